//! Records and bench results that do not count any more: who said so, when, why, and what stands in their place.

use crate::core::correction::{CorrectedResult, CorrectionItem};
use crate::core::id::Id;
use crate::core::time::UtcMicros;
use crate::store::batch::{Batch, Rows};
use crate::store::db::{Whole, among, cell, insert, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;
use crate::store::packed::history_row::{self, HistoryRow};

/// What a transaction takes out of what counts.
#[derive(Debug, Default)]
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
    let (records, benches) = (withdrawn.records.iter().map(|id| id.0), withdrawn.benches.iter().map(|(id, _)| id.0));
    batch.add(among!("UPDATE record SET voided = id WHERE id"), Rows::of(records));
    batch.add(among!("UPDATE bench_result SET voided = id WHERE id"), Rows::of(benches));
    batch.add(
        insert!("voided_history (gyro, calibrated_at, record, figures)", [int 0, int 1, int 2, blob 3 4]),
        history_row::rows(withdrawn.history.iter()),
    );
}

pub(crate) fn insert(corrections: &[CorrectionItem], batch: &mut Batch) {
    let mut rows = Rows::default();
    for correction in corrections {
        rows.row()
            .integer(correction.item.0)
            .optional_integer(correction.replaced_by.map(|id| id.0))
            .integer(correction.at.0)
            .text(&correction.author)
            .text(&correction.reason);
    }
    batch.add(
        insert!("correction (item, replaced_by, at, author, reason)", [int 0, int 1, int 2, text 3, text 4]),
        rows,
    );
}

type Row = (i64, Option<i64>, i64, String, String);

fn row((item, replaced_by, at, author, reason): Row) -> CorrectionItem {
    CorrectionItem { item: Id(item), replaced_by: replaced_by.map(Id), at: UtcMicros(at), author, reason }
}

/// What was said of an item, oldest first: that it does not count, that another stands in its place, that it stands in
/// another's place.
pub async fn of_item(store: &Store, item: Id) -> Result<Vec<CorrectionItem>, StoreError> {
    let sql = "SELECT item, replaced_by, at, author, reason FROM correction
               WHERE item = $1 OR replaced_by = $1 ORDER BY at, replaced_by NULLS FIRST";
    let rows: Vec<Row> = on!(store.readers, db => sqlx::query_as(sql).bind(item.0).fetch_all(db).await?);
    Ok(rows.into_iter().map(row).collect())
}

/// What was said of a gyro's calibrations and bench results that do not count any more, oldest first.
pub async fn of_gyro(store: &Store, gyro: u32) -> Result<Vec<CorrectedResult>, StoreError> {
    let sql = "SELECT item, replaced_by, at, author, reason, withdrawn.measured_at, withdrawn.bench <> 0
               FROM (SELECT record AS id, calibrated_at AS measured_at, 0 AS bench FROM voided_history WHERE gyro = $1
                     UNION ALL
                     SELECT id, measured_at, 1 FROM bench_result WHERE gyro = $1 AND voided <> 0) AS withdrawn
               JOIN correction ON item = withdrawn.id ORDER BY at, item, replaced_by NULLS FIRST";
    let rows: Vec<(i64, Option<i64>, i64, String, String, i64, bool)> =
        on!(store.readers, db => sqlx::query_as(sql).bind(Whole(gyro)).fetch_all(db).await?);
    let of_gyro = |(item, replaced_by, at, author, reason, measured_at, is_bench)| CorrectedResult {
        correction: row((item, replaced_by, at, author, reason)),
        measured_at: UtcMicros(measured_at),
        is_bench,
    };
    Ok(rows.into_iter().map(of_gyro).collect())
}
