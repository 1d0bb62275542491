//! Bench results.

use std::sync::Arc;

use super::record::RecordAt;
use crate::core::bench::BenchMethod;
use crate::core::id::Id;
use crate::core::time::{Span, UtcMicros};
use crate::store::batch::{Batch, Rows};
use crate::store::db::{AnyRow, Whole, cell, insert, listed, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;

#[derive(Debug, Clone, PartialEq)]
pub struct BenchRow {
    pub id: Id,
    pub gyro: u32,
    pub station: u32,
    pub measured_at: UtcMicros,
    pub method: BenchMethod,
    /// D_I and D_S, deg/(h g0).
    pub d: [f64; 2],
    pub sd: [Option<f64>; 2],
    /// It does not count any more.
    pub voided: bool,
    pub received_at: UtcMicros,
    pub body: Arc<str>,
    pub body_sha256: [u8; 32],
    /// As of [`crate::store::RecordRow`].
    pub sent_by: Option<Id>,
}

pub(crate) fn insert(benches: &[BenchRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for bench in benches {
        rows.row()
            .integer(bench.id.0)
            .integer(i64::from(bench.gyro))
            .integer(i64::from(bench.station))
            .integer(bench.measured_at.0)
            .bytes(bench.method.name().as_bytes())
            .real(Some(bench.d[0]))
            .real(Some(bench.d[1]))
            .real(bench.sd[0])
            .real(bench.sd[1])
            .integer(bench.received_at.0)
            .bytes(bench.body.as_bytes())
            .bytes(&bench.body_sha256)
            .optional_integer(bench.sent_by.map(|line| line.0));
    }
    batch.add(
        insert!(
            "bench_result
             (id, gyro, station, measured_at, method, d_i, d_s, d_i_sd, d_s_sd, received_at, body, body_sha256,
              sent_by)",
            [int 0, int 1, int 2, int 3, words 4 5, real 6, real 7, real 8, real 9, int 10, words 11 12, blob 13 14, int 15]
        ),
        rows,
    );
}

fn row(row: &impl AnyRow) -> Result<BenchRow, StoreError> {
    let id = Id(row.cell("id")?);
    let damaged = |what: &str| StoreError::Damaged(format!("bench result {id}: {what}"));
    let (method, body, hash): (String, String, Vec<u8>) =
        (row.cell("method")?, row.cell("body")?, row.cell("body_sha256")?);
    Ok(BenchRow {
        id,
        gyro: row.cell::<Whole<u32>>("gyro")?.0,
        station: row.cell::<Whole<u32>>("station")?.0,
        measured_at: UtcMicros(row.cell("measured_at")?),
        method: BenchMethod::from_name(&method).ok_or_else(|| damaged("unknown method"))?,
        d: [row.cell("d_i")?, row.cell("d_s")?],
        sd: [row.cell("d_i_sd")?, row.cell("d_s_sd")?],
        voided: row.cell::<i64>("voided")? != 0,
        received_at: UtcMicros(row.cell("received_at")?),
        body: body.into(),
        body_sha256: hash.try_into().map_err(|_| damaged("its hash has not 32 bytes"))?,
        sent_by: row.cell::<Option<i64>>("sent_by")?.map(Id),
    })
}

pub async fn get(store: &Store, id: Id) -> Result<Option<BenchRow>, StoreError> {
    let sql = "SELECT id, gyro, station, measured_at, method, d_i, d_s, d_i_sd, d_s_sd, voided, received_at, body,
                      body_sha256, sent_by
               FROM bench_result WHERE id = $1";
    on!(store.readers, db => sqlx::query(sql).bind(id.0).fetch_optional(db).await?.as_ref().map(row).transpose())
}

/// Those of `gyros` that have bench results.
pub async fn on_benches(store: &Store, gyros: &[u32]) -> Result<Vec<u32>, StoreError> {
    let sql = store.readers.words(listed!("SELECT DISTINCT gyro FROM bench_result WHERE gyro"));
    let gyros = serde_json::json!(gyros).to_string();
    let found: Vec<Whole<u32>> = on!(store.readers, db => sqlx::query_scalar(sql).bind(gyros).fetch_all(db).await?);
    Ok(found.into_iter().map(|gyro| gyro.0).collect())
}

/// Bench results of a gyro within `span` that count, oldest first.
pub async fn of_gyro(store: &Store, gyro: u32, span: Span) -> Result<Vec<BenchRow>, StoreError> {
    let mut rows = all_of_gyro(store, gyro, span).await?;
    rows.retain(|row| !row.voided);
    Ok(rows)
}

/// Bench results of a gyro within `span`, those that do not count any more included, oldest first.
pub async fn all_of_gyro(store: &Store, gyro: u32, span: Span) -> Result<Vec<BenchRow>, StoreError> {
    let sql = "SELECT id, gyro, station, measured_at, method, d_i, d_s, d_i_sd, d_s_sd, voided, received_at, body,
                      body_sha256, sent_by
               FROM bench_result WHERE gyro = $1 AND measured_at BETWEEN $2 AND $3 ORDER BY measured_at, method, id";
    on!(store.readers, db => sqlx::query(sql).bind(Whole(gyro)).bind(span.from.0).bind(span.to.0).fetch_all(db).await?.iter().map(row).collect())
}

/// The results of a gyro by one method at an instant: the one that counts first, then those that do not.
pub async fn at(store: &Store, gyro: u32, at: UtcMicros, method: BenchMethod) -> Result<Vec<RecordAt>, StoreError> {
    let sql = "SELECT id, body_sha256, voided <> 0 FROM bench_result
               WHERE gyro = $1 AND measured_at = $2 AND method = $3 ORDER BY voided";
    let found: Vec<(i64, Vec<u8>, bool)> = on!(store.readers, db => sqlx::query_as(sql).bind(Whole(gyro)).bind(at.0).bind(method.name()).fetch_all(db).await?);
    Ok(found.into_iter().map(|(id, hash, voided)| RecordAt { id: Id(id), hash, voided }).collect())
}
