//! The writing side: one connection, one transaction a group.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::runtime::{Handle, RuntimeFlavor};
use tokio::sync::Mutex;
use tokio::task::JoinHandle;

use super::batch::{Batch, Rows};
use super::cells::Cells;
use super::db::{Sql, cell, insert};
use super::error::StoreError;
use super::id::IdSource;
use super::postgres::{CellWriter, Missed};
use crate::core::correction::CorrectionItem;
use crate::core::id::Id;
use crate::core::time::UtcMicros;
use crate::store::packed::verdicts::StoredVerdict;
use crate::store::sqlite::writer::FileWriter;
use crate::store::tables::access;
use crate::store::tables::access::AccessChanges;
use crate::store::tables::alerts;
use crate::store::tables::alerts::{AlertRow, StepRow};
use crate::store::tables::bench;
use crate::store::tables::bench::BenchRow;
use crate::store::tables::correction;
use crate::store::tables::correction::Withdrawn;
use crate::store::tables::delivery;
use crate::store::tables::delivery::OutboxChanges;
use crate::store::tables::diagnosis;
use crate::store::tables::diagnosis::NewDiagnosis;
use crate::store::tables::diagnosis_digest;
use crate::store::tables::diagnosis_job;
use crate::store::tables::diagnosis_job::JobChanges;
use crate::store::tables::event;
use crate::store::tables::event::EventRow;
use crate::store::tables::gyro_attribute;
use crate::store::tables::gyro_attribute::GyroAttributeRow;
use crate::store::tables::head;
use crate::store::tables::head::HeadChanges;
use crate::store::tables::history::HistoryRow;
use crate::store::tables::hook;
use crate::store::tables::hook::HookRow;
use crate::store::tables::hypothesis;
use crate::store::tables::hypothesis::HypothesisRow;
use crate::store::tables::keys;
use crate::store::tables::keys::KeyRow;
use crate::store::tables::model;
use crate::store::tables::model::ModelRow;
use crate::store::tables::names::{NamesOf, NewName};
use crate::store::tables::record;
use crate::store::tables::record::{RecordRow, RejudgedSheet};
use crate::store::tables::set_aside;
use crate::store::tables::set_aside::{ConfirmationRow, SetAside};
use crate::store::tables::silence;
use crate::store::tables::silence::SilenceRow;

/// Everything that one transaction writes. Rows may refer to names of the same group.
#[derive(Debug, Default)]
pub struct Changes {
    pub imus: Vec<NewName>,
    pub stations: Vec<NewName>,
    pub gyros: Vec<NewName>,
    pub records: Vec<RecordRow>,
    pub history: Vec<HistoryRow>,
    /// Stored rows that are judged anew.
    pub rejudged: Rejudged,
    /// What does not count any more.
    pub withdrawn: Withdrawn,
    pub corrections: Vec<CorrectionItem>,
    /// What is not to count before its time is confirmed.
    pub set_aside: SetAside,
    /// What was set aside and counts from now on; its rows are among those of `history`.
    pub confirmed: Vec<ConfirmationRow>,
    pub benches: Vec<BenchRow>,
    pub events: Vec<EventRow>,
    pub attributes: Vec<GyroAttributeRow>,
    pub keys: Vec<KeyRow>,
    pub alerts: Vec<AlertRow>,
    pub alert_steps: Vec<StepRow>,
    pub silences: Vec<SilenceRow>,
    pub hooks: Vec<HookRow>,
    pub models: Vec<ModelRow>,
    pub hypotheses: Vec<HypothesisRow>,
    /// Campaigns that were fitted with an adopted model, and which.
    pub models_used: Vec<(Id, Id)>,
    /// Diagnoses that have been made of stored campaigns.
    pub diagnoses: Vec<NewDiagnosis>,
    pub diagnosis_jobs: JobChanges,
    pub outbox: OutboxChanges,
    pub access: AccessChanges,
    /// How the gyros stand that all of that touches.
    pub heads: HeadChanges,
}

/// What changes on stored records when they are judged again.
#[derive(Debug, Default)]
pub struct Rejudged {
    pub history: Vec<HistoryRow>,
    pub sheets: Vec<(Id, RejudgedSheet)>,
    /// What is noted about them.
    pub notes: Vec<(Id, String)>,
    /// Rows that another model makes of stored campaigns. Judging enters them into `history`.
    pub restated: Vec<RestatedRow>,
}

impl Rejudged {
    /// The gyros of which something is stated anew, in order.
    pub fn gyros_restated(&self) -> std::collections::BTreeSet<u32> {
        self.restated.iter().map(|restated| restated.row.gyro).collect()
    }
}

/// A stored campaign's row of one gyro, as another model has it.
#[derive(Debug, Clone)]
pub struct RestatedRow {
    pub row: HistoryRow,
    /// Verdicts that need no history.
    pub requirements: Vec<StoredVerdict>,
}

impl Changes {
    /// New names.
    pub fn names_mut(&mut self, of: NamesOf) -> &mut Vec<NewName> {
        match of {
            NamesOf::Imus => &mut self.imus,
            NamesOf::Stations => &mut self.stations,
            NamesOf::Gyros => &mut self.gyros,
        }
    }

    /// Rows of the history in the order in which they hold: the last of a gyro and instant.
    pub(super) fn history_rows(&self) -> impl Iterator<Item = &HistoryRow> {
        self.history.iter().chain(&self.rejudged.history)
    }

    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
            && self.corrections.is_empty()
            && self.confirmed.is_empty()
            && self.benches.is_empty()
            && self.events.is_empty()
            && self.attributes.is_empty()
            && self.keys.is_empty()
            && self.rejudged.history.is_empty()
            && self.alerts.is_empty()
            && self.alert_steps.is_empty()
            && self.silences.is_empty()
            && self.hooks.is_empty()
            && self.models.is_empty()
            && self.hypotheses.is_empty()
            && self.diagnoses.is_empty()
            && self.diagnosis_jobs.is_empty()
            && self.outbox.is_empty()
            && self.access.is_empty()
    }
}

/// Who writes: of a file the only one, of a database server one of many.
#[derive(Debug)]
pub struct Writer {
    ids: IdSource,
    engine: Engine,
}

#[derive(Debug)]
enum Engine {
    File(Arc<Mutex<FileWriter>>),
    Server(Box<CellWriter>),
}

impl Writer {
    /// Of a database in a file, which no other process writes.
    pub(super) fn of_file(ids: IdSource, writer: FileWriter) -> Self {
        Self { ids, engine: Engine::File(Arc::new(Mutex::new(writer))) }
    }

    /// Of a database that other processes may write as well.
    pub(super) fn of_server(writer: CellWriter) -> Self {
        Self { ids: IdSource::after(0), engine: Engine::Server(Box::new(writer)) }
    }

    /// Another writer on the same database; none where there can be but one.
    pub fn another(&self) -> Option<Self> {
        match &self.engine {
            Engine::File(_) => None,
            Engine::Server(writer) => Some(Self::of_server(writer.another())),
        }
    }

    /// Whether others may write too, so that what is written has to be held.
    pub fn is_one_of_many(&self) -> bool {
        matches!(self.engine, Engine::Server(_))
    }

    /// An identifier greater than every one before in what is held. To be asked during a turn.
    pub fn next_id(&mut self, now: UtcMicros) -> Id {
        self.ids.next(now)
    }

    /// Where identifiers come from, for who needs nothing else of the writer. To be asked during a turn.
    pub fn ids(&mut self) -> &mut IdSource {
        &mut self.ids
    }

    /// From here to [`Writer::commit`] or [`Writer::give_back`] nobody else writes what is at home in `cells`: what is
    /// read of it is what holds when this is committed. Says what others have written since these cells were held
    /// last; names that are at home in them are known.
    ///
    /// # Errors
    /// [`StoreError`].
    pub async fn take_turn(&mut self, cells: &Cells) -> Result<Missed, StoreError> {
        match &mut self.engine {
            Engine::File(_) => Ok(Missed::default()),
            Engine::Server(writer) => {
                let (missed, ids) = writer.take_turn(cells).await?;
                self.ids = ids;
                Ok(missed)
            }
        }
    }

    /// Ends a turn in which nothing was committed; otherwise does nothing.
    pub async fn give_back(&mut self) {
        if let Engine::Server(writer) = &mut self.engine {
            writer.give_back().await;
        }
    }

    /// Writes all changes in one transaction, and ends the turn; they are on disk when this returns. After an error
    /// nothing is stored; only after [`StoreError::Unanswered`] that is not known.
    ///
    /// # Errors
    /// [`StoreError`]; after [`StoreError::NotDurable`] every later commit fails alike.
    pub async fn commit(&mut self, changes: &Changes) -> Result<(), StoreError> {
        match &mut self.engine {
            Engine::File(writer) => {
                let mut writer = writer.lock().await;
                waiting_for_disk(|| writer.commit(changes))
            }
            Engine::Server(writer) => writer.commit(changes, self.ids.last()).await,
        }
    }

    /// A way to commit as [`Writer::commit`] does, on a thread of its own; none where servers take turns, and each
    /// transaction needs its own.
    pub fn committer(&self) -> Option<Committer> {
        match &self.engine {
            Engine::File(writer) => Some(Committer(Arc::clone(writer))),
            Engine::Server(_) => None,
        }
    }

    /// Whether writing works.
    ///
    /// # Errors
    /// As [`Writer::commit`].
    pub async fn probe(&mut self) -> Result<(), StoreError> {
        match &mut self.engine {
            Engine::File(writer) => {
                let mut writer = writer.lock().await;
                waiting_for_disk(|| writer.probe())
            }
            Engine::Server(writer) => writer.probe().await,
        }
    }

    /// Ends writing in order; nothing is being written beside any more.
    ///
    /// # Errors
    /// [`StoreError`], where the end is not in order; what was committed is stored all the same.
    pub async fn close(self) -> Result<(), StoreError> {
        match self.engine {
            Engine::File(writer) => {
                let writer = Arc::into_inner(writer).expect("whoever commits beside has been waited for");
                waiting_for_disk(|| writer.into_inner().close())
            }
            Engine::Server(writer) => writer.close().await,
        }
    }
}

/// Does `work` on this thread. Where it is one of those that run a runtime's tasks, its others are handed over to the
/// next.
pub(super) fn waiting_for_disk<T>(work: impl FnOnce() -> T) -> T {
    match Handle::current().runtime_flavor() {
        RuntimeFlavor::CurrentThread => work(),
        _ => tokio::task::block_in_place(work),
    }
}

/// A way to commit while the writer makes ready what comes next.
#[derive(Debug)]
pub struct Committer(Arc<Mutex<FileWriter>>);

/// What has become of changes that were written beside.
#[derive(Debug)]
pub struct Written {
    pub changes: Changes,
    /// As of [`Writer::commit`].
    pub outcome: Result<(), StoreError>,
    pub took: Duration,
}

impl Committer {
    /// Begins to write `changes`. Nothing else may be under way; what is asked of the writer meanwhile waits.
    pub fn commit(self, changes: Changes) -> JoinHandle<Written> {
        let mut writer = self.0.try_lock_owned().expect("what was under way before has been waited for");
        tokio::task::spawn_blocking(move || {
            let begun = Instant::now();
            let outcome = writer.commit(&changes);
            Written { changes, outcome, took: begun.elapsed() }
        })
    }
}

pub(super) fn batch_of(changes: &Changes) -> Batch {
    let mut batch = Batch::default();
    // A file knows of no cells.
    for (file, server, names) in [
        (
            insert!("imu (id, name)", [int 0, words 2 3]),
            insert!("imu (id, cell, name)", [int 0, int 1, words 2 3]),
            &changes.imus,
        ),
        (
            insert!("station (id, name)", [int 0, words 2 3]),
            insert!("station (id, cell, name)", [int 0, int 1, words 2 3]),
            &changes.stations,
        ),
        (
            insert!("gyro (id, serial)", [int 0, words 2 3]),
            insert!("gyro (id, cell, serial)", [int 0, int 1, words 2 3]),
            &changes.gyros,
        ),
    ] {
        let mut rows = Rows::default();
        for NewName { number, cell, name } in names {
            rows.row().integer(i64::from(*number)).integer(i64::from(*cell)).bytes(name.as_bytes());
        }
        batch.add(Sql { sqlite: file.sqlite, postgres: server.postgres }, rows);
    }
    correction::withdraw(&changes.withdrawn, &mut batch);
    record::insert(&changes.records, &mut batch);
    set_aside::insert(&changes.set_aside, &mut batch);
    set_aside::confirm(&changes.confirmed, changes.history.iter(), &mut batch);
    set_aside::note(&changes.rejudged.notes, &mut batch);
    correction::insert(&changes.corrections, &mut batch);
    record::update_verdicts(&changes.rejudged.sheets, &mut batch);
    bench::insert(&changes.benches, &mut batch);
    event::insert(&changes.events, &mut batch);
    gyro_attribute::upsert(&changes.attributes, &mut batch);
    keys::insert(&changes.keys, &mut batch);
    silence::upsert(&changes.silences, &mut batch);
    alerts::upsert(&changes.alerts, &mut batch);
    alerts::insert_steps(&changes.alert_steps, &mut batch);
    hook::upsert(&changes.hooks, &mut batch);
    model::insert(&changes.models, &mut batch);
    hypothesis::upsert(&changes.hypotheses, &mut batch);
    model::insert_uses(&changes.models_used, &mut batch);
    diagnosis::expect(&changes.records, &mut batch);
    diagnosis::update(&changes.diagnoses, &mut batch);
    diagnosis_digest::upsert(&changes.diagnoses, &mut batch);
    diagnosis_job::apply(&changes.diagnosis_jobs, &mut batch);
    delivery::apply(&changes.outbox, &mut batch);
    access::apply(&changes.access, &mut batch);
    head::upsert(&changes.heads, &mut batch);
    batch
}
