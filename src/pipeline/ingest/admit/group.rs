//! A group under construction.

use serde_json::json;

use crate::core::bench::BenchMethod;
use crate::core::history_note::HistoryNote;
use crate::pipeline::prelude::*;
use crate::store::{KeyRow, Tables};
use crate::wire::history_note;

/// A group under construction: what is to be written, and what it already holds besides what is stored.
#[derive(Debug, Default)]
pub(crate) struct Group {
    pub changes: Changes,
    /// The new ones.
    pub(super) names: Tables,
    /// Those that count, by IMU and instant.
    pub(super) records: HashMap<(u32, UtcMicros), (Id, [u8; 32])>,
    /// Those that are set aside: of one instant there may be several.
    pub(super) aside: HashMap<(u32, UtcMicros), Vec<(Id, [u8; 32])>>,
    pub(super) rows: HashMap<(u32, UtcMicros), Id>,
    pub(super) benches: HashMap<(u32, UtcMicros, BenchMethod), (Id, [u8; 32])>,
    pub(super) keys: HashMap<String, (Id, [u8; 32])>,
    sendings: Vec<Sending>,
}

/// What one sender has in a group.
#[derive(Debug)]
struct Sending {
    by: Actor,
    line: Id,
    /// The first of it, as the audit trail names it.
    subject: String,
    first: Id,
    last: Id,
    count: usize,
}

impl Group {
    pub(super) fn take_key(&mut self, key: &str, item: Id, body_sha256: [u8; 32]) {
        self.keys.insert(key.to_owned(), (item, body_sha256));
        self.changes.keys.push(KeyRow { key: key.to_owned(), item, body_sha256 });
    }

    pub(super) fn withdraws(&self, record: Id) -> bool {
        self.changes.withdrawn.records.contains(&record)
    }

    /// Takes down that an item under `place` is `by`'s; gives the line of the audit trail that will say so, one for all
    /// that one sender has in a group.
    pub(super) fn note_sending(&mut self, by: &Actor, place: &str, id: Id, new_line: impl FnOnce() -> Id) -> Id {
        if let Some(known) = self.sendings.iter_mut().find(|sending| sending.by == *by) {
            (known.last, known.count) = (id, known.count + 1);
            return known.line;
        }
        let (by, line, subject) = (by.clone(), new_line(), format!("{place}/{id}"));
        self.sendings.push(Sending { by, line, subject, first: id, last: id, count: 1 });
        line
    }

    /// As for a stored record, of one of this group.
    pub(super) fn set_new_aside(&mut self, id: Id, of: &[u32], note: &HistoryNote) -> bool {
        let Some(record) = self.changes.records.iter_mut().find(|record| record.id == id) else { return false };
        if record.verdicts.0.iter().any(|(gyro, _)| !of.contains(gyro)) {
            return false;
        }
        record.voided = true;
        let at = (record.imu, record.calibrated_at);
        self.records.remove(&at);
        self.aside.entry(at).or_default().push((id, record.body_sha256));
        record.notes = Some(history_note::with(record.notes.as_deref(), note).into());
        for row in self.changes.history.extract_if(.., |row| row.figures.record == id) {
            self.rows.remove(&(row.gyro, row.figures.at));
            self.changes.set_aside.history.push(row);
        }
        true
    }

    /// The lines about what was sent join what is to be written.
    pub fn audit_sendings(&mut self, now: UtcMicros) {
        for Sending { by, line, subject, first, last, count } in self.sendings.drain(..) {
            let subject = if count == 1 { subject } else { "records".to_owned() };
            let after = json!({ "stored": count, "first": first.to_string(), "last": last.to_string() });
            self.changes.access.audit.push(by.line(line, now, ("store", subject), None::<&()>, Some(&after)));
        }
    }
}
