//! What one transaction writes, as rows of every table.

use std::collections::BTreeSet;

use crate::core::bench::BenchItem;
use crate::core::correction::CorrectionItem;
use crate::core::id::Id;
use crate::core::kind::Kind;
use crate::store::batch::{Batch, OnConflict};
use crate::store::db::Sql;
use crate::store::rows::Rows;
use crate::store::tables::correction::Withdrawn;
use crate::store::tables::set_aside::SetAside;
use crate::store::tables::{
    access, alerts, correction, delivery, diagnosis, diagnosis_digest, diagnosis_job, gyro_attribute, head, model,
    record, set_aside,
};
use crate::store::{
    AccessChanges, AlertRow, ChangeTopic, ConfirmationRow, EventRow, GyroAttributeRow, HeadChanges, HistoryRow,
    HookRow, HypothesisRow, JobChanges, KeyRow, ModelRow, NamesOf, NewDiagnosis, NewName, OutboxChanges, PackedText,
    RecordRow, RejudgedVerdicts, SilenceRow, StepRow, StoredVerdict, WindowMarkRow,
};

/// Everything that one transaction writes. Rows may refer to names of the same group.
#[derive(Debug, Default, PartialEq)]
pub struct Changes {
    pub imus: Vec<NewName>,
    pub stations: Vec<NewName>,
    pub gyros: Vec<NewName>,
    pub records: Vec<RecordRow>,
    /// Texts of stored records, deflated from now on.
    pub packed: Vec<PackedText>,
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
    pub benches: Vec<BenchItem>,
    pub events: Vec<EventRow>,
    pub attributes: Vec<GyroAttributeRow>,
    pub window_marks: Vec<WindowMarkRow>,
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
#[derive(Debug, Default, PartialEq)]
pub struct Rejudged {
    pub history: Vec<HistoryRow>,
    pub sheets: Vec<(Id, RejudgedVerdicts)>,
    /// What is noted about them.
    pub notes: Vec<(Id, String)>,
    /// Rows that another model makes of stored campaigns. Judging enters them into `history`.
    pub restated: Vec<RestatedRow>,
}

impl Rejudged {
    /// Verdicts that need no history, where a calibration of a gyro is stated anew.
    pub fn requirements_of(&self, gyro: u32, record: Id) -> Option<&[StoredVerdict]> {
        let of_it = |restated: &&RestatedRow| (restated.row.gyro, restated.row.figures.record) == (gyro, record);
        self.restated.iter().find(of_it).map(|restated| restated.requirements.as_slice())
    }

    /// The gyros of which something is stated anew, in order.
    pub fn gyros_restated(&self) -> BTreeSet<u32> {
        self.restated.iter().map(|restated| restated.row.gyro).collect()
    }
}

/// A stored campaign's row of one gyro, as another model has it.
#[derive(Debug, Clone, PartialEq)]
pub struct RestatedRow {
    pub row: HistoryRow,
    /// Verdicts that need no history.
    pub requirements: Vec<StoredVerdict>,
}

impl Changes {
    pub fn names_mut(&mut self, of: NamesOf) -> &mut Vec<NewName> {
        match of {
            NamesOf::Imus => &mut self.imus,
            NamesOf::Stations => &mut self.stations,
            NamesOf::Gyros => &mut self.gyros,
        }
    }

    /// New names of IMUs, stations and gyros.
    pub(super) fn new_names(&self) -> [&[NewName]; 3] {
        [&self.imus, &self.stations, &self.gyros]
    }

    /// Rows of the history in the order in which they hold: the last of a gyro and instant.
    pub(super) fn history_rows(&self) -> impl Iterator<Item = &HistoryRow> {
        self.history.iter().chain(&self.rejudged.history)
    }

    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether others want to hear of it.
    pub(super) fn brings(&self, topic: ChangeTopic) -> bool {
        let (outbox, access) = (&self.outbox, &self.access);
        match topic {
            ChangeTopic::Names => self.new_names().iter().any(|names| !names.is_empty()),
            ChangeTopic::Settings => {
                let of_no_gyro = self.alerts.iter().any(|alert| alert.of.gyro().is_none());
                of_no_gyro || !self.hooks.is_empty() || !self.silences.is_empty()
            }
            ChangeTopic::Outbox => {
                let moved = [outbox.queued.len(), outbox.replayed.len(), outbox.dropped.len(), outbox.hastened.len()];
                moved != [0; 4] || !self.hooks.is_empty()
            }
            ChangeTopic::Models => !self.models.is_empty() || !self.hypotheses.is_empty(),
            ChangeTopic::Diagnoses => {
                !(self.models.is_empty() && self.diagnosis_jobs.started.is_empty())
                    || self.records.iter().any(|record| record.kind == Kind::Campaign)
            }
            ChangeTopic::Access => [access.tokens.len(), access.sessions.len(), access.ended.len()] != [0; 3],
        }
    }
}

/// The statements of one transaction, in the order in which rows may refer to one another.
pub(super) fn batch_of(changes: &Changes) -> Batch {
    let mut batch = Batch::default();
    for (table, column, names) in
        [("imu", "name", &changes.imus), ("station", "name", &changes.stations), ("gyro", "serial", &changes.gyros)]
    {
        let rows = Rows::each(names, |NewName { number, cell, name }, row| {
            row.put(number).integer(i64::from(*cell)).text(name);
        });
        // A file knows of no cells.
        let sqlite = format!("INSERT INTO {table} (id, {column}) VALUES ($C0, $C2)");
        let postgres = format!("INSERT INTO {table} (id, cell, {column}) SELECT $C0, $C1, $C2 FROM $ROWS");
        batch.add(Sql { sqlite, postgres }, rows);
    }
    correction::withdraw(&changes.withdrawn, &mut batch);
    batch.enter(&changes.records, OnConflict::Fail);
    record::pack(&changes.packed, &mut batch);
    set_aside::insert(&changes.set_aside, &mut batch);
    set_aside::confirm(&changes.confirmed, changes.history.iter(), &mut batch);
    set_aside::note(&changes.rejudged.notes, &mut batch);
    batch.enter(&changes.corrections, OnConflict::Fail);
    record::update_verdicts(&changes.rejudged.sheets, &mut batch);
    batch.enter(&changes.benches, OnConflict::Fail);
    batch.enter(&changes.events, OnConflict::Fail);
    gyro_attribute::upsert(&changes.attributes, &mut batch);
    batch.enter(&changes.window_marks, OnConflict::Fail);
    batch.enter(&changes.keys, OnConflict::Fail);
    batch.enter(&changes.silences, OnConflict::Set("id", &["ended_at", "ended_by", "ended_reason"]));
    alerts::upsert(&changes.alerts, &mut batch);
    batch.enter(&changes.alert_steps, OnConflict::Fail);
    batch.enter(&changes.hooks, OnConflict::SetAllBut("id", &["created_at"]));
    batch.enter(&changes.models, OnConflict::Fail);
    batch.enter(&changes.hypotheses, OnConflict::Set("id", &["ended_at"]));
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
