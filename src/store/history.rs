//! The history of one gyro: a row a record, in order of time.

use sqlx::SqlitePool;

use super::batch::{Batch, Rows};
use super::error::StoreError;
use super::figures::{Figures, PACKED_LEN};
use super::id::Id;
use super::open::Store;
use crate::core::time::UtcMicros;

#[derive(Debug, Clone, PartialEq)]
pub struct HistoryRow {
    pub gyro: u32,
    pub figures: Figures,
}

/// A stretch of time, its ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    pub from: UtcMicros,
    pub to: UtcMicros,
}

impl Span {
    pub const EVER: Span = Span { from: UtcMicros(i64::MIN), to: UtcMicros(i64::MAX) };
}

pub(super) fn insert(history: &[HistoryRow], batch: &mut Batch) {
    // In the order of the key: neighbours share their page, and each page is touched once.
    let mut ordered: Vec<&HistoryRow> = history.iter().collect();
    ordered.sort_unstable_by_key(|row| (row.gyro, row.figures.at));
    batch.add(
        "INSERT INTO history (gyro, calibrated_at, record, figures)
         SELECT value->>0, value->>1, value->>2, substr($BYTES, value->>3, value->>4) FROM json_each($ROWS)",
        rows(ordered.into_iter()),
    );
}

pub(super) fn update(history: &[HistoryRow], batch: &mut Batch) {
    batch.add(
        "UPDATE history SET record = j.value->>2, figures = substr($BYTES, j.value->>3, j.value->>4)
         FROM json_each($ROWS) AS j WHERE history.gyro = j.value->>0 AND history.calibrated_at = j.value->>1",
        rows(history.iter()),
    );
}

fn rows<'a>(history: impl Iterator<Item = &'a HistoryRow>) -> Rows {
    let mut rows = Rows::default();
    for HistoryRow { gyro, figures } in history {
        rows.row()
            .integer(i64::from(*gyro))
            .integer(figures.at.0)
            .integer(figures.record.0)
            .written(|out| figures.pack(*gyro, out));
    }
    rows
}

/// Rows of `gyro` within `span`: the oldest `limit` of them, oldest first; or the newest, newest first.
async fn read(
    readers: &SqlitePool,
    gyro: u32,
    span: Span,
    limit: usize,
    newest_first: bool,
) -> Result<Vec<Figures>, StoreError> {
    let sql = if newest_first {
        "SELECT CAST(group_concat(figures, '') AS BLOB) FROM (SELECT figures FROM history
         WHERE gyro = $1 AND calibrated_at BETWEEN $2 AND $3 ORDER BY calibrated_at DESC LIMIT $4)"
    } else {
        "SELECT CAST(group_concat(figures, '') AS BLOB) FROM (SELECT figures FROM history
         WHERE gyro = $1 AND calibrated_at BETWEEN $2 AND $3 ORDER BY calibrated_at LIMIT $4)"
    };
    let packed: Option<Vec<u8>> = sqlx::query_scalar(sql)
        .bind(gyro)
        .bind(span.from.0)
        .bind(span.to.0)
        .bind(i64::try_from(limit).unwrap_or(i64::MAX))
        .fetch_one(readers)
        .await?;
    unpack(gyro, &packed.unwrap_or_default())
}

/// SQLite joins blobs byte for byte, and in the order of the subquery; a row out of place would show here.
fn unpack(gyro: u32, packed: &[u8]) -> Result<Vec<Figures>, StoreError> {
    let (rows, rest) = packed.as_chunks::<PACKED_LEN>();
    if !rest.is_empty() {
        return Err(StoreError::Damaged(format!("history rows of gyro number {gyro} have a wrong length")));
    }
    rows.iter().map(|row| Figures::unpack(gyro, row)).collect()
}

impl Store {
    /// The oldest `limit` rows of a gyro within `span`, oldest first.
    pub async fn history(&self, gyro: u32, span: Span, limit: usize) -> Result<Vec<Figures>, StoreError> {
        read(&self.readers, gyro, span, limit, false).await
    }

    /// The newest `limit` rows of a gyro within `span`, oldest first.
    pub async fn newest_history(&self, gyro: u32, span: Span, limit: usize) -> Result<Vec<Figures>, StoreError> {
        let mut rows = read(&self.readers, gyro, span, limit, true).await?;
        rows.reverse();
        Ok(rows)
    }

    /// How many rows a gyro has.
    pub async fn count_history(&self, gyro: u32) -> Result<i64, StoreError> {
        let sql = "SELECT count(*) FROM history WHERE gyro = $1";
        Ok(sqlx::query_scalar(sql).bind(gyro).fetch_one(&self.readers).await?)
    }

    /// The temperature of each of a gyro's records that states one; of a campaign that does not, the mean of its dwells.
    pub async fn temperatures(&self, gyro: u32) -> Result<Vec<(Id, f64)>, StoreError> {
        let sql = "SELECT record.id, CAST(coalesce(json_extract(body, '$.temperature_c'),
                          (SELECT avg(value->>'temperature_c') FROM json_each(body, '$.dwells'))) AS REAL)
                   FROM history JOIN record ON record.id = history.record WHERE gyro = $1 AND json_valid(body)";
        let rows: Vec<(i64, Option<f64>)> = sqlx::query_as(sql).bind(gyro).fetch_all(&self.readers).await?;
        Ok(rows.into_iter().filter_map(|(id, temperature)| Some((Id(id), temperature?))).collect())
    }
}
