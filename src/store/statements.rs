//! The statements of one transaction, in the order in which rows may refer to one another.

use super::batch::{Batch, Rows};
use super::changes::Changes;
use super::db::{Sql, cell, insert};
use super::name_tables::NewName;
use super::tables::{
    access, alerts, bench, correction, delivery, diagnosis, diagnosis_digest, diagnosis_job, event, gyro_attribute,
    head, hook, hypothesis, keys, model, record, set_aside, silence, suspect_window,
};

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
    suspect_window::insert(&changes.window_marks, &mut batch);
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
