//! The statements of one transaction, in the order in which rows may refer to one another.

use super::batch::{Batch, OnConflict};
use super::rows::Rows;
use super::tables::{
    access, alerts, correction, delivery, diagnosis, diagnosis_digest, diagnosis_job, gyro_attribute, head, model,
    record, set_aside,
};
use crate::store::{Changes, NewName};

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
        batch.add(&sqlite, &postgres, rows);
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
