//! Records and bench results that do not count any more: who said so, when, why, and what stands in their place.

use super::*;
use crate::core::correction::{CorrectedResult, CorrectionItem};
use crate::store::HistoryRow;
use crate::store::packed::history_row;

/// What a transaction takes out of what counts.
#[derive(Debug, Default, PartialEq)]
pub struct Withdrawn {
    pub records: Vec<Id>,
    /// The records' rows of the history, as they stood.
    pub history: Vec<HistoryRow>,
    /// Bench results, each with its gyro.
    pub benches: Vec<(Id, u32)>,
}

impl Withdrawn {
    /// The gyros whose history shrinks, in order.
    pub fn gyros(&self) -> std::collections::BTreeSet<u32> {
        self.history.iter().map(|row| row.gyro).collect()
    }
}

/// Makes room for what the same transaction inserts.
pub(crate) fn withdraw(withdrawn: &Withdrawn, batch: &mut Batch) {
    let (records, benches) = (withdrawn.records.iter().copied(), withdrawn.benches.iter().map(|(id, _)| *id));
    batch.change("UPDATE record SET voided = id", "id = $C0", Rows::of(records));
    batch.change("UPDATE bench_result SET voided = id", "id = $C0", Rows::of(benches));
    history_row::void(&withdrawn.history, batch);
}

columns! {
    CorrectionItem in "correction" { item, replaced_by, at, author, reason }
}

/// What was said of an item, oldest first: that it does not count, that another stands in its place, that it stands in
/// another's place.
pub async fn of_item(store: &Store, item: Id) -> Result<Vec<CorrectionItem>> {
    let sql = CorrectionItem::select("WHERE item = $1 OR replaced_by = $1 ORDER BY at, replaced_by NULLS FIRST");
    read!(store, all, sql, item)
}

/// What was said of a gyro's calibrations and bench results that do not count any more, oldest first.
pub async fn of_gyro(store: &Store, gyro: u32) -> Result<Vec<CorrectedResult>> {
    let sql = AssertSqlSafe(format!(
        "SELECT {}, withdrawn.measured_at, withdrawn.bench
         FROM (SELECT record AS id, calibrated_at AS measured_at, CAST(0 AS BIGINT) AS bench FROM voided_history WHERE gyro = $1
               UNION ALL
               SELECT id, measured_at, 1 FROM bench_result WHERE gyro = $1 AND voided <> 0) AS withdrawn
         JOIN correction ON item = withdrawn.id ORDER BY at, item, replaced_by NULLS FIRST",
        CorrectionItem::COLUMNS
    ));
    read!(store, all, sql, gyro)
}

part! {
    CorrectedResult { correction, measured_at, is_bench }
}
