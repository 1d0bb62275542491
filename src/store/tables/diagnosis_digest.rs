//! What a summary of many diagnoses says of each: a few hundred bytes beside the tens of thousands of the whole.

use super::*;
use crate::store::{CampaignFilter, NewDiagnosis};
use futures::TryStreamExt;

/// The gist of one campaign's diagnosis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DigestRow {
    pub record: Id,
    pub imu: u32,
    pub station: u32,
    pub measured_at: UtcMicros,
    pub program: String,
    /// JSON.
    pub gist: String,
}

columns! {
    DigestRow in "diagnosis_gist" { record, imu, station, measured_at, program, gist }
}

pub(crate) fn upsert(diagnoses: &[NewDiagnosis], batch: &mut Batch) {
    let rows = Rows::each(diagnoses, |NewDiagnosis { row: made, gist }, row| {
        row.put(&made.record).put(&made.program).words(gist);
    });
    batch.change(
        "INSERT INTO diagnosis_gist (record, imu, station, measured_at, program, gist)
         SELECT id, imu, station, calibrated_at, $C1, $C2 FROM record",
        "id = $C0 ON CONFLICT (record) DO UPDATE SET program = excluded.program, gist = excluded.gist",
        rows,
    );
}

/// Hands the gist of every campaign that counts to `each`, the earliest measured first.
pub async fn each(store: &Store, of: &CampaignFilter, mut each: impl FnMut(DigestRow) -> Result<()>) -> Result<()> {
    let sql = DigestRow::select(
        "WHERE measured_at BETWEEN $1 AND $2 AND ($3 IS NULL OR imu = $3) AND ($4 IS NULL OR station = $4)
             AND record NOT IN (SELECT item FROM correction)
         ORDER BY measured_at, record",
    );
    let &CampaignFilter { imu, station, measured: Span { from, to } } = of;
    on!(store.readers, db => {
        let mut rows = sqlx::query(sql).bind(from.0).bind(to.0).bind(imu.bound()).bind(station.bound()).fetch(db);
        while let Some(row) = rows.try_next().await? {
            each(row.whole()?)?;
        }
    });
    Ok(())
}

/// The newest `limit` campaigns that count, were measured at or after `since`, and whose gist holds `words`, the newest
/// first; and how many there are.
pub async fn holding(store: &Store, words: &str, since: UtcMicros, limit: usize) -> Result<(Vec<DigestRow>, usize)> {
    let sql = AssertSqlSafe(format!(
        "SELECT {}, count(*) OVER () AS many FROM diagnosis_gist
         WHERE measured_at >= $1 AND gist LIKE $2 AND record NOT IN (SELECT item FROM correction)
         ORDER BY measured_at DESC, record DESC LIMIT $3",
        DigestRow::COLUMNS
    ));
    let found: Vec<(DigestRow, usize)> = read!(store, all, sql, since, format!("%{words}%"), limit)?;
    let many = found.first().map_or(0, |(_, many)| *many);
    Ok((found.into_iter().map(|(row, _)| row).collect(), many))
}

/// Campaigns that count and have no diagnosis yet.
pub async fn not_diagnosed(store: &Store, of: &CampaignFilter) -> Result<u64> {
    let sql = "SELECT count(*) FROM diagnosis JOIN record ON record.id = diagnosis.record
               WHERE diagnosis.body IS NULL AND record.calibrated_at BETWEEN $1 AND $2
                   AND ($3 IS NULL OR record.imu = $3) AND ($4 IS NULL OR record.station = $4)
                   AND record.id NOT IN (SELECT item FROM correction)";
    let &CampaignFilter { imu, station, measured: Span { from, to } } = of;
    read!(store, one, sql, from, to, imu, station)
}
