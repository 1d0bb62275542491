//! Diagnoses of stored campaigns, and which are still to be made.

use super::*;
use crate::core::kind::Kind;
use crate::store::packed::text;
use crate::store::{ModelRow, RecordRow};

/// A diagnosis that was made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DiagnosisRow {
    pub record: Id,
    /// The adopted model that it was made against.
    pub model: Option<Id>,
    /// Which program made it.
    pub program: String,
    /// Whether there is none, and `body` says why.
    pub refused: bool,
    pub body: String,
}

/// One that is to be kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewDiagnosis {
    pub row: DiagnosisRow,
    /// What a summary of many says of it (JSON).
    pub gist: String,
}

/// Every stored campaign is to be diagnosed.
pub(crate) fn expect(records: &[RecordRow], batch: &mut Batch) {
    let campaigns = records.iter().filter(|record| record.kind == Kind::Campaign);
    batch.insert("diagnosis", "record", OnConflict::Fail, Rows::of(campaigns.map(|record| record.id)));
}

/// A newly adopted model makes the diagnoses of its IMU due again. In a file its records have all been entered into
/// the calendar before.
pub(crate) fn make_due(models: &[ModelRow], batch: &mut Batch) {
    let imus = || Rows::of(models.iter().map(|model| model.imu));
    batch.change("DELETE FROM diagnosis_gist", "imu = $C0", imus());
    let made_due = "UPDATE diagnosis SET body = NULL, packed = NULL, model = NULL, program = NULL, refused = NULL";
    let sql = Sql {
        sqlite: format!("{made_due} WHERE record IN (SELECT record FROM calendar WHERE imu = $C0)"),
        postgres: format!("{made_due} WHERE record IN (SELECT id FROM record WHERE imu IN (SELECT $C0 FROM $ROWS))"),
    };
    batch.add(sql, imus());
}

pub(crate) fn update(diagnoses: &[NewDiagnosis], batch: &mut Batch) {
    let rows = Rows::each(diagnoses, |NewDiagnosis { row: made, .. }, row| {
        let (body, packed) = text::pack(&made.body);
        row.put(&made.record).put(&made.model).put(&made.program).put(&made.refused);
        row.words(body).optional_bytes(packed.as_deref());
    });
    let kept = "UPDATE diagnosis SET model = $C1, program = $C2, refused = $C3, body = $C4, packed = $C6";
    batch.change(kept, "record = $C0", rows);
}

/// The diagnosis of a campaign as it was made last; none where it is due.
pub async fn get(store: &Store, record: Id) -> Result<Option<DiagnosisRow>> {
    let sql = "SELECT model, program, refused, body, packed FROM diagnosis WHERE record = $1 AND body IS NOT NULL";
    let found: Option<((_, _, _), String, Option<Vec<u8>>)> = read!(store, first, sql, record)?;
    let row = |((model, program, refused), body, packed)| {
        let body = text::unpack(body, packed, || format!("the diagnosis of campaign {record}"))?;
        Ok(DiagnosisRow { record, model, program, refused, body })
    };
    found.map(row).transpose()
}

/// Campaigns whose diagnosis is due, newest first, from before `before` on.
pub async fn due(store: &Store, before: Id, limit: u32) -> Result<Vec<Id>> {
    let sql = "SELECT record FROM diagnosis WHERE body IS NULL AND record < $1 ORDER BY record DESC LIMIT $2";
    read!(store, all, sql, before, limit)
}
