//! Records whose time is in doubt: kept as those that were voided are, until somebody confirms it.

use super::*;
use crate::store::HistoryRow;
use crate::store::packed::history_row;

#[derive(Debug, Default, PartialEq)]
pub struct SetAside {
    /// Rows of new records, which never come into the history.
    pub history: Vec<HistoryRow>,
    /// Stored records, which are withdrawn with the same transaction.
    pub stored: Vec<SetAsideRecord>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SetAsideRecord {
    pub record: Id,
    pub author: String,
    pub reason: String,
}

/// Somebody has confirmed the time of a record that was set aside.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConfirmationRow {
    pub record: Id,
    pub at: UtcMicros,
    pub author: String,
    pub reason: String,
}

columns! {
    ConfirmationRow in "confirmation" { record, at, author, reason }
}

/// After the records themselves have been written.
pub(crate) fn insert(set_aside: &SetAside, batch: &mut Batch) {
    history_row::void(&set_aside.history, batch);
    // It may have been confirmed before.
    let stored = Rows::of(set_aside.stored.iter().map(|stored| stored.record));
    batch.change("DELETE FROM confirmation", "record = $C0", stored);
}

/// `rows` are those of the confirmed records, which count from now on.
pub(crate) fn confirm<'a>(
    confirmed: &[ConfirmationRow],
    rows: impl Iterator<Item = &'a HistoryRow>,
    batch: &mut Batch,
) {
    let records = Rows::of(confirmed.iter().map(|confirmed| confirmed.record));
    batch.change("UPDATE record SET voided = 0", "id = $C0", records);
    let is_confirmed = |row: &&HistoryRow| confirmed.iter().any(|it| it.record == row.figures.record);
    let keys = rows.filter(is_confirmed).map(|row| (row.gyro, row.figures.at, row.figures.record));
    batch.change("DELETE FROM voided_history", "gyro = $C0 AND calibrated_at = $C1 AND record = $C2", Rows::of(keys));
    batch.enter(confirmed, OnConflict::Fail);
}

/// Enters what is noted about stored records in the place of what was noted before.
pub(crate) fn note(noted: &[(Id, String)], batch: &mut Batch) {
    let rows = Rows::each(noted, |(record, notes), row| _ = row.put(record).words(notes));
    batch.change("UPDATE record SET notes = $C1", "id = $C0", rows);
}

pub async fn confirmation(store: &Store, record: Id) -> Result<Option<ConfirmationRow>> {
    read!(store, first, ConfirmationRow::select("WHERE record = $1"), record)
}

/// Whether a record is set aside until somebody confirms its time.
pub async fn is_set_aside(store: &Store, record: Id) -> Result<bool> {
    let sql = "SELECT count(*) FROM record WHERE id = $1 AND voided <> 0
               AND NOT EXISTS (SELECT 1 FROM correction WHERE item = record.id)";
    read!(store, one, sql, record)
}

/// The records of a gyro that are set aside, oldest first.
pub async fn of_gyro(store: &Store, gyro: u32) -> Result<Vec<(Id, UtcMicros)>> {
    let sql = "SELECT record, calibrated_at FROM voided_history WHERE gyro = $1
               AND NOT EXISTS (SELECT 1 FROM correction WHERE item = voided_history.record)
               ORDER BY calibrated_at, record";
    read!(store, all, sql, gyro)
}
