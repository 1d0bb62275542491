//! The writing side: one connection, one transaction a group, and checkpoints from a second connection.

use sqlx::{Connection, SqliteConnection};

use super::access::{self, AccessChanges};
use super::alerts::{self, AlertRow, StepRow};
use super::batch::{Batch, Rows};
use super::bench::{self, BenchRow};
use super::checkpoint::{self, Checkpoints};
use super::correction::{self, CorrectionRow, Withdrawn};
use super::delivery::{self, OutboxChanges};
use super::diagnosis::{self, NewDiagnosis};
use super::diagnosis_job::{self, JobChanges};
use super::error::StoreError;
use super::event::{self, EventRow};
use super::gist;
use super::halt::Halt;
use super::history::HistoryRow;
use super::hook::{self, HookRow};
use super::id::{Id, IdSource};
use super::keys::{self, KeyRow};
use super::lock::Lock;
use super::model::{self, ModelRow};
use super::names::Names;
use super::record::{self, RecordRow};
use super::tail::SharedTail;
use super::verdicts::VerdictSheet;
use crate::core::time::UtcMicros;

/// Everything that one transaction writes. Rows may refer to names of the same group.
#[derive(Debug, Default)]
pub struct Changes {
    pub imus: Vec<(u32, String)>,
    pub stations: Vec<(u32, String)>,
    pub gyros: Vec<(u32, String)>,
    pub records: Vec<RecordRow>,
    pub history: Vec<HistoryRow>,
    /// Stored rows that are judged anew.
    pub rejudged: Rejudged,
    /// What does not count any more.
    pub withdrawn: Withdrawn,
    pub corrections: Vec<CorrectionRow>,
    pub benches: Vec<BenchRow>,
    pub events: Vec<EventRow>,
    pub keys: Vec<KeyRow>,
    pub alerts: Vec<AlertRow>,
    pub alert_steps: Vec<StepRow>,
    pub hooks: Vec<HookRow>,
    pub models: Vec<ModelRow>,
    /// Campaigns of `records` that were fitted with an adopted model, and which.
    pub models_used: Vec<(Id, Id)>,
    /// Diagnoses that have been made of stored campaigns.
    pub diagnoses: Vec<NewDiagnosis>,
    pub diagnosis_jobs: JobChanges,
    pub outbox: OutboxChanges,
    pub access: AccessChanges,
}

/// What changes on stored records when they are judged again.
#[derive(Debug, Default)]
pub struct Rejudged {
    pub history: Vec<HistoryRow>,
    pub sheets: Vec<(Id, VerdictSheet)>,
}

impl Changes {
    /// Rows of the history in the order in which they hold: the last of a gyro and instant.
    fn history_rows(&self) -> impl Iterator<Item = &HistoryRow> {
        self.history.iter().chain(&self.rejudged.history)
    }

    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
            && self.corrections.is_empty()
            && self.benches.is_empty()
            && self.events.is_empty()
            && self.keys.is_empty()
            && self.rejudged.history.is_empty()
            && self.alerts.is_empty()
            && self.alert_steps.is_empty()
            && self.hooks.is_empty()
            && self.models.is_empty()
            && self.diagnoses.is_empty()
            && self.diagnosis_jobs.is_empty()
            && self.outbox.is_empty()
            && self.access.is_empty()
    }
}

/// The only one who writes.
#[derive(Debug)]
pub struct Writer {
    connection: SqliteConnection,
    names: Names,
    tail: SharedTail,
    ids: IdSource,
    checkpoints: Checkpoints,
    halt: Halt,
    /// The last write failed: whether writing works again, only writing can tell.
    in_doubt: bool,
    _lock: Lock,
}

impl Writer {
    pub(super) fn new(
        connection: SqliteConnection,
        names: Names,
        tail: SharedTail,
        ids: IdSource,
        checkpoints: Checkpoints,
        halt: Halt,
        lock: Lock,
    ) -> Self {
        Self { connection, names, tail, ids, checkpoints, halt, in_doubt: false, _lock: lock }
    }

    pub fn names(&self) -> &Names {
        &self.names
    }

    pub fn next_id(&mut self, now: UtcMicros) -> Id {
        self.ids.next(now)
    }

    /// Writes all changes in one transaction; they are on disk when this returns. After an error nothing is stored.
    ///
    /// # Errors
    /// [`StoreError`]; after [`StoreError::NotDurable`] every later commit fails alike.
    pub async fn commit(&mut self, changes: &Changes) -> Result<(), StoreError> {
        self.halt.check()?;
        let finished = self.checkpoints.finish(&mut self.connection).await;
        self.in_doubt |= finished.is_err();
        self.halt.heed(finished)?;
        let mut batch = batch_of(changes);
        let fold = {
            let tail = self.tail.read();
            let fold = tail.due(changes.history_rows().count());
            tail.write(changes.history_rows(), &fold, &mut batch);
            fold
        };
        let pages = batch.pages();
        let committed = batch.commit(&mut self.connection).await;
        self.in_doubt = matches!(&committed, Err(error) if !matches!(error, StoreError::Refused(_)));
        self.halt.heed(committed)?;
        self.names.change(|tables| {
            tables.imus.extend(&changes.imus);
            tables.stations.extend(&changes.stations);
            tables.gyros.extend(&changes.gyros);
        });
        self.tail.change(|tail| tail.committed(changes.history_rows(), &fold));
        self.checkpoints.written(pages);
        Ok(())
    }

    /// Whether writing works: the database can be locked for it, and after a failure it takes a write.
    ///
    /// # Errors
    /// As [`Writer::commit`].
    pub async fn probe(&mut self) -> Result<(), StoreError> {
        self.halt.check()?;
        self.halt.heed(self.checkpoints.begin(&mut self.connection).await)?;
        // The number is of no use to anyone else; setting it writes the first page.
        let sql = if self.in_doubt {
            "BEGIN IMMEDIATE; PRAGMA user_version = 0; COMMIT"
        } else {
            "BEGIN IMMEDIATE; ROLLBACK"
        };
        if let Err(error) = sqlx::query(sql).execute(&mut self.connection).await {
            let _nothing_left = sqlx::query("ROLLBACK").execute(&mut self.connection).await;
            return self.halt.heed(Err(error.into()));
        }
        self.in_doubt = false;
        Ok(())
    }

    /// Copies the whole log into the database and closes it.
    pub async fn close(mut self) -> Result<(), StoreError> {
        let copied = match self.halt.check() {
            Ok(()) => self.halt.heed(checkpoint::copy_all(&mut self.connection).await),
            halted => halted,
        };
        if matches!(copied, Err(StoreError::NotDurable(_))) {
            std::mem::forget(self.connection);
            return copied;
        }
        self.connection.close().await?;
        copied
    }
}

pub(super) fn batch_of(changes: &Changes) -> Batch {
    let mut batch = Batch::new();
    for (sql, names) in [
        (
            "INSERT INTO imu SELECT value->>0, CAST(substr($BYTES, value->>1, value->>2) AS TEXT) FROM json_each($ROWS)",
            &changes.imus,
        ),
        (
            "INSERT INTO station SELECT value->>0, CAST(substr($BYTES, value->>1, value->>2) AS TEXT) FROM json_each($ROWS)",
            &changes.stations,
        ),
        (
            "INSERT INTO gyro SELECT value->>0, CAST(substr($BYTES, value->>1, value->>2) AS TEXT) FROM json_each($ROWS)",
            &changes.gyros,
        ),
    ] {
        let mut rows = Rows::default();
        for (number, name) in names {
            rows.row().integer(i64::from(*number)).bytes(name.as_bytes());
        }
        batch.add(sql, rows);
    }
    correction::withdraw(&changes.withdrawn, &mut batch);
    record::insert(&changes.records, &mut batch);
    correction::insert(&changes.corrections, &mut batch);
    record::update_verdicts(&changes.rejudged.sheets, &mut batch);
    bench::insert(&changes.benches, &mut batch);
    event::insert(&changes.events, &mut batch);
    keys::insert(&changes.keys, &mut batch);
    alerts::upsert(&changes.alerts, &mut batch);
    alerts::insert_steps(&changes.alert_steps, &mut batch);
    hook::upsert(&changes.hooks, &mut batch);
    model::insert(&changes.models, &mut batch);
    model::insert_uses(&changes.models_used, &mut batch);
    diagnosis::expect(&changes.records, &mut batch);
    diagnosis::make_due(&changes.models, &mut batch);
    diagnosis::update(&changes.diagnoses, &mut batch);
    gist::upsert(&changes.diagnoses, &mut batch);
    diagnosis_job::apply(&changes.diagnosis_jobs, &mut batch);
    delivery::apply(&changes.outbox, &mut batch);
    access::apply(&changes.access, &mut batch);
    batch
}
