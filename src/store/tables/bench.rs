//! Bench results.

use super::*;
use crate::core::bench::{BenchItem, BenchMethod};
use crate::store::RecordAt;

columns! {
    BenchItem in "bench_result" {
        id, gyro, station, measured_at, method, d: ["d_i", "d_s"], sd: ["d_i_sd", "d_s_sd"], voided, received_at, body,
        body_sha256, sent_by,
    }
}

pub async fn get(store: &Store, id: Id) -> Result<Option<BenchItem>> {
    read!(store, first, BenchItem::select("WHERE id = $1"), id)
}

pub async fn on_benches(store: &Store, gyros: &[u32]) -> Result<Vec<u32>> {
    let those = store.readers.list("$1");
    let sql = AssertSqlSafe(format!("SELECT DISTINCT gyro FROM bench_result WHERE gyro IN {those}"));
    read!(store, all, sql, gyros)
}

/// Bench results of a gyro within `span` that count, oldest first.
pub async fn of_gyro(store: &Store, gyro: u32, span: Span) -> Result<Vec<BenchItem>> {
    let mut rows = all_of_gyro(store, gyro, span).await?;
    rows.retain(|row| !row.voided);
    Ok(rows)
}

/// Bench results of a gyro within `span`, those that do not count any more included, oldest first.
pub async fn all_of_gyro(store: &Store, gyro: u32, span: Span) -> Result<Vec<BenchItem>> {
    let sql = BenchItem::select("WHERE gyro = $1 AND measured_at BETWEEN $2 AND $3 ORDER BY measured_at, method, id");
    read!(store, all, sql, gyro, span.from, span.to)
}

/// The results of a gyro by one method at an instant: the one that counts first, then those that do not.
pub async fn at(store: &Store, gyro: u32, at: UtcMicros, method: BenchMethod) -> Result<Vec<RecordAt>> {
    let sql = "SELECT id, body_sha256, voided FROM bench_result
               WHERE gyro = $1 AND measured_at = $2 AND method = $3 ORDER BY voided";
    read!(store, all, sql, gyro, at, method)
}
