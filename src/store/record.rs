//! Records as stations sent them, and what was decided about them.

use std::sync::Arc;

use super::batch::{Batch, Rows};
use super::error::StoreError;
use super::id::Id;
use super::open::Store;
use super::verdicts::VerdictSheet;
use crate::core::time::UtcMicros;

/// What a station sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Parameters that the station fitted.
    Record,
    /// Raw dwells, fitted here.
    Campaign,
}

impl Kind {
    fn code(self) -> i64 {
        match self {
            Kind::Record => 0,
            Kind::Campaign => 1,
        }
    }

    fn from_code(code: i64) -> Option<Self> {
        [Kind::Record, Kind::Campaign].into_iter().find(|kind| kind.code() == code)
    }
}

/// One record with its verdicts.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordRow {
    pub id: Id,
    pub kind: Kind,
    pub imu: u32,
    pub station: u32,
    pub calibrated_at: UtcMicros,
    pub received_at: UtcMicros,
    /// Word for word.
    pub body: Arc<str>,
    pub body_sha256: [u8; 32],
    pub verdicts: VerdictSheet,
}

/// Which record it is, without what it says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordHead {
    pub id: Id,
    pub kind: Kind,
    pub station: u32,
    pub calibrated_at: UtcMicros,
}

/// An item at an instant that was asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordAt {
    pub id: Id,
    /// SHA-256 of its text.
    pub hash: Vec<u8>,
    /// It does not count any more.
    pub voided: bool,
}

pub(super) fn insert(records: &[RecordRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for record in records {
        rows.row()
            .integer(record.id.0)
            .integer(record.kind.code())
            .integer(i64::from(record.imu))
            .integer(i64::from(record.station))
            .integer(record.calibrated_at.0)
            .integer(record.received_at.0)
            .bytes(record.body.as_bytes())
            .bytes(&record.body_sha256)
            .written(|out| record.verdicts.pack(record.id, out));
    }
    batch.add(
        "INSERT INTO record (id, kind, imu, station, calibrated_at, received_at, body, body_sha256, verdicts)
         SELECT value->>0, value->>1, value->>2, value->>3, value->>4, value->>5,
                CAST(substr($BYTES, value->>6, value->>7) AS TEXT),
                substr($BYTES, value->>8, value->>9), substr($BYTES, value->>10, value->>11)
         FROM json_each($ROWS)",
        rows,
    );
}

pub(super) fn update_verdicts(sheets: &[(Id, VerdictSheet)], batch: &mut Batch) {
    let mut rows = Rows::default();
    for (id, sheet) in sheets {
        rows.row().integer(id.0).written(|out| sheet.pack(*id, out));
    }
    batch.add(
        "UPDATE record SET verdicts = substr($BYTES, j.value->>1, j.value->>2)
         FROM json_each($ROWS) AS j WHERE record.id = j.value->>0",
        rows,
    );
}

type Row = (i64, i64, u32, u32, i64, i64, String, Vec<u8>, Vec<u8>);

fn row(row: Row) -> Result<RecordRow, StoreError> {
    let (id, kind, imu, station, calibrated_at, received_at, body, body_sha256, verdicts) = row;
    let id = Id(id);
    let damaged = |what: &str| StoreError::Damaged(format!("record {id}: {what}"));
    Ok(RecordRow {
        id,
        kind: Kind::from_code(kind).ok_or_else(|| damaged("unknown kind"))?,
        imu,
        station,
        calibrated_at: UtcMicros(calibrated_at),
        received_at: UtcMicros(received_at),
        body: body.into(),
        body_sha256: body_sha256.try_into().map_err(|_| damaged("its hash has not 32 bytes"))?,
        verdicts: VerdictSheet::unpack(id, &verdicts)?,
    })
}

impl Store {
    pub async fn record(&self, id: Id) -> Result<Option<RecordRow>, StoreError> {
        let sql = "SELECT id, kind, imu, station, calibrated_at, received_at, body, body_sha256, verdicts
                   FROM record WHERE id = $1";
        let found: Option<Row> = sqlx::query_as(sql).bind(id.0).fetch_optional(&self.readers).await?;
        found.map(row).transpose()
    }

    /// Every record, in order of arrival.
    pub async fn record_ids(&self) -> Result<Vec<Id>, StoreError> {
        let ids: Vec<i64> = sqlx::query_scalar("SELECT id FROM record ORDER BY id").fetch_all(&self.readers).await?;
        Ok(ids.into_iter().map(Id).collect())
    }

    /// The records of an IMU at an instant: the one that counts first (there is one at the most), then those that do not.
    pub async fn records_at(&self, imu: u32, at: UtcMicros) -> Result<Vec<RecordAt>, StoreError> {
        let sql =
            "SELECT id, body_sha256, voided <> 0 FROM record WHERE imu = $1 AND calibrated_at = $2 ORDER BY voided";
        let found: Vec<(i64, Vec<u8>, bool)> =
            sqlx::query_as(sql).bind(imu).bind(at.0).fetch_all(&self.readers).await?;
        Ok(found.into_iter().map(|(id, hash, voided)| RecordAt { id: Id(id), hash, voided }).collect())
    }

    /// The newest record's instant of each IMU.
    pub async fn newest_of_imus(&self) -> Result<Vec<(u32, UtcMicros)>, StoreError> {
        let sql = "SELECT id, (SELECT max(calibrated_at) FROM record WHERE record.imu = imu.id) FROM imu";
        let rows: Vec<(u32, Option<i64>)> = sqlx::query_as(sql).fetch_all(&self.readers).await?;
        Ok(rows.into_iter().filter_map(|(imu, at)| Some((imu, UtcMicros(at?)))).collect())
    }

    pub async fn verdict_sheet(&self, id: Id) -> Result<Option<VerdictSheet>, StoreError> {
        let sql = "SELECT verdicts FROM record WHERE id = $1";
        let found: Option<Vec<u8>> = sqlx::query_scalar(sql).bind(id.0).fetch_optional(&self.readers).await?;
        found.map(|bytes| VerdictSheet::unpack(id, &bytes)).transpose()
    }

    /// The verdict sheets of several records.
    pub async fn verdict_sheets(
        &self,
        records: impl Iterator<Item = Id>,
    ) -> Result<Vec<(Id, VerdictSheet)>, StoreError> {
        let ids: Vec<String> = records.map(|id| id.0.to_string()).collect();
        let sql = "SELECT id, verdicts FROM record WHERE id IN (SELECT value FROM json_each($1))";
        let rows: Vec<(i64, Vec<u8>)> =
            sqlx::query_as(sql).bind(format!("[{}]", ids.join(","))).fetch_all(&self.readers).await?;
        rows.into_iter().map(|(id, bytes)| Ok((Id(id), VerdictSheet::unpack(Id(id), &bytes)?))).collect()
    }

    /// The newest `limit` records of an IMU that count, newest first, without their bodies.
    pub async fn records_of_imu(&self, imu: u32, limit: u32) -> Result<Vec<RecordHead>, StoreError> {
        let sql = "SELECT id, kind, station, calibrated_at FROM record WHERE imu = $1 AND voided = 0
                   ORDER BY calibrated_at DESC LIMIT $2";
        let rows: Vec<(i64, i64, u32, i64)> =
            sqlx::query_as(sql).bind(imu).bind(limit).fetch_all(&self.readers).await?;
        let head = |(id, kind, station, at)| {
            let kind =
                Kind::from_code(kind).ok_or_else(|| StoreError::Damaged(format!("record {}: unknown kind", Id(id))))?;
            Ok(RecordHead { id: Id(id), kind, station, calibrated_at: UtcMicros(at) })
        };
        rows.into_iter().map(head).collect()
    }
}
