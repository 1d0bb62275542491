//! Which record an IMU has at which instant.
//!
//! In the table `calendar` every IMU's entries have pages of their own, so a commit that made its entries there would
//! write a page an IMU. A record that is newer than every other of its IMU waits in memory instead, where readers
//! find it, and is entered later with the others of that IMU; a start finds those that wait among the newest records.
//! What comes late or takes another's place is entered at once, after what waits of its IMU. So what waits of an IMU
//! counts, is in order of time and is newer than all that the table has of it, and the table's key refuses a second
//! record of an IMU and instant.

use std::collections::{BTreeSet, HashMap};

use sqlx::SqliteConnection;

use crate::core::id::Id;
use crate::core::time::UtcMicros;
use crate::store::batch::{Batch, OnConflict};
use crate::store::db::each;
use crate::store::error::{Result, StoreError};
use crate::store::rows::Rows;
use crate::store::sqlite::write_behind::queues::PendingRows;

/// A record that waits.
#[derive(Debug, Clone, Copy)]
struct Entry {
    at: UtcMicros,
    record: Id,
}

/// What is not in the table yet.
#[derive(Debug, Default)]
pub(crate) struct PendingIndex {
    waiting: PendingRows<Entry>,
    /// The newest instant of each IMU, whether what was calibrated then counts or not.
    newest: HashMap<u32, UtcMicros>,
}

/// A record that a commit stores.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NewRecord {
    pub record: Id,
    pub imu: u32,
    pub at: UtcMicros,
    pub voided: bool,
}

/// What a commit does to records, as far as the index is concerned.
#[derive(Debug)]
pub(crate) struct IndexChanges<'a> {
    pub records: Vec<NewRecord>,
    pub withdrawn: &'a [Id],
    pub confirmed: Vec<Id>,
    /// IMUs of which the table alone is asked in the same commit: whose diagnoses become due.
    pub asked_for: Vec<u32>,
}

/// What a commit enters into the table.
#[derive(Debug, Default)]
pub(crate) struct IndexUpdate {
    /// IMUs whose records that wait are entered.
    imus: BTreeSet<u32>,
    /// Those whose new records are entered too.
    at_once: BTreeSet<u32>,
}

impl PendingIndex {
    /// Reads what is not in the table.
    pub async fn load(connection: &mut SqliteConnection) -> Result<Self> {
        let newest = "SELECT id, (SELECT max(calibrated_at) FROM calendar WHERE imu = imu.id) FROM imu";
        let newest: Vec<(u32, Option<UtcMicros>)> = each(sqlx::query(newest).fetch(&mut *connection)).await?;
        let newest = newest.into_iter().filter_map(|(imu, at)| Some((imu, at?))).collect();
        let mut pending = Self { waiting: PendingRows::default(), newest };
        let since = "SELECT id, imu, calibrated_at, voided, EXISTS (SELECT 1 FROM calendar WHERE record = since.id
                         AND (imu, calibrated_at, voided) = (since.imu, since.calibrated_at, since.voided))
                     FROM record AS since WHERE id >= coalesce((SELECT record FROM calendar_begun), 0) ORDER BY id";
        let since: Vec<(Id, u32, UtcMicros, bool, bool)> = each(sqlx::query(since).fetch(connection)).await?;
        for (record, imu, at, voided, entered) in since {
            if entered {
                pending.waiting.pass(1);
            } else if voided || !pending.is_newest(imu, at) {
                let why = "does not count or is not the newest of its IMU, and is not in the calendar";
                return Err(StoreError::damaged(format_args!("record {record} {why}")));
            } else {
                pending.enter(imu, Entry { at, record });
            }
        }
        Ok(pending)
    }

    fn is_newest(&self, imu: u32, at: UtcMicros) -> bool {
        self.newest.get(&imu).is_none_or(|newest| *newest < at)
    }

    fn enter(&mut self, imu: u32, entry: Entry) {
        self.newest.insert(imu, entry.at);
        self.waiting.enter(entry.record.0, imu, |entries| entries.push(entry));
    }

    /// The newest `limit` records of an IMU before `before` that wait, newest first.
    pub fn last_of(&self, imu: u32, before: UtcMicros, limit: usize) -> impl Iterator<Item = Id> {
        let entries = self.waiting.of(imu);
        let until = entries.partition_point(|entry| entry.at < before);
        entries[..until].iter().rev().take(limit).map(|entry| entry.record)
    }

    /// The record of an IMU at an instant, if it waits.
    pub fn at(&self, imu: u32, at: UtcMicros) -> Option<Id> {
        let entries = self.waiting.of(imu);
        entries.binary_search_by_key(&at, |entry| entry.at).ok().map(|place| entries[place].record)
    }

    /// The newest instant of an IMU, whether what was calibrated then counts or not.
    pub fn newest_of(&self, imu: u32) -> Option<UtcMicros> {
        self.newest.get(&imu).copied()
    }

    pub fn due(&self, changes: &IndexChanges<'_>) -> IndexUpdate {
        let mut at_once = self.imus_of(changes.withdrawn);
        at_once.extend(&changes.asked_for);
        let mut newest: HashMap<u32, UtcMicros> = HashMap::new();
        for record in &changes.records {
            let (imu, at) = (record.imu, record.at);
            if record.voided || newest.get(&imu).is_some_and(|newest| at <= *newest) || !self.is_newest(imu, at) {
                at_once.insert(imu);
            } else {
                newest.insert(imu, at);
            }
        }
        let mut imus = self.waiting.due(changes.records.len());
        imus.extend(&at_once);
        IndexUpdate { imus, at_once }
    }

    /// The IMUs of those records that wait.
    fn imus_of(&self, records: &[Id]) -> BTreeSet<u32> {
        if records.is_empty() {
            return BTreeSet::new();
        }
        let among = |entries: &[Entry]| entries.iter().any(|entry| records.contains(&entry.record));
        self.waiting.iter().filter(|(_, entries)| among(entries)).map(|(imu, _)| imu).collect()
    }

    /// After the records themselves have been written.
    pub fn write(&self, entering: &IndexUpdate, changes: &IndexChanges<'_>, batch: &mut Batch) {
        let waiting =
            entering.imus.iter().flat_map(|imu| self.waiting.of(*imu).iter().map(move |entry| (*imu, *entry, 0)));
        enter(waiting, batch);
        // Makes room for what takes its place.
        let withdrawn = Rows::of(changes.withdrawn.iter().copied());
        batch.change("UPDATE calendar SET voided = record", of_record("0"), withdrawn);
        let (at_once, later): (Vec<_>, Vec<_>) =
            changes.records.iter().partition(|record| entering.at_once.contains(&record.imu));
        let entry = |record: &&NewRecord| {
            let voided = if record.voided { record.record.0 } else { 0 };
            (record.imu, Entry { at: record.at, record: record.record }, voided)
        };
        enter(at_once.iter().map(entry), batch);
        // What was set aside takes its place.
        let confirmed = Rows::of(changes.confirmed.iter().copied());
        batch.change("UPDATE calendar SET voided = 0", of_record("id"), confirmed);
        let first = self.waiting.first_without(&entering.imus);
        let first = first.or_else(|| later.first().map(|record| record.record.0));
        // Where nothing waits any more.
        let first = first.or_else(|| at_once.last().map(|record| record.record.0 + 1));
        if let (Some(first), false) = (first, entering.imus.is_empty()) {
            batch.insert(
                "calendar_begun",
                "id, record",
                OnConflict::Set("id", &["record"]),
                Rows::of([(1_i64, first)]),
            );
        }
    }

    /// Follows a commit.
    pub fn committed(&mut self, entering: &IndexUpdate, changes: &IndexChanges<'_>) {
        for imu in &entering.imus {
            self.waiting.remove(*imu);
        }
        for record in &changes.records {
            let NewRecord { record, imu, at, .. } = *record;
            if entering.at_once.contains(&imu) {
                let newest = self.newest.entry(imu).or_insert(at);
                *newest = at.max(*newest);
                self.waiting.pass(1);
            } else {
                self.enter(imu, Entry { at, record });
            }
        }
    }
}

/// The entry of a record that stands where its IMU has it, `voided` or not.
fn of_record(voided: &str) -> String {
    format!(
        "record = $C0
             AND (imu, calibrated_at, voided) = (SELECT imu, calibrated_at, {voided} FROM record WHERE id = $C0)"
    )
}

fn enter(entries: impl Iterator<Item = (u32, Entry, i64)>, batch: &mut Batch) {
    let rows = entries.map(|(imu, Entry { at, record }, voided)| (imu, at, voided, record));
    batch.insert("calendar", "imu, calibrated_at, voided, record", OnConflict::Fail, Rows::of(rows));
}
