//! Error models that were adopted for an IMU, and which campaigns were fitted with them.

use super::*;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelRow {
    pub id: Id,
    pub imu: u32,
    pub adopted_at: UtcMicros,
    pub author: String,
    pub reason: String,
    /// The model file, JSON.
    pub body: String,
}

columns! {
    ModelRow in "imu_model" { id, imu, adopted_at, author, reason, body }
}

/// Which campaigns were fitted with an adopted model; the last holds.
pub(crate) fn insert_uses(uses: &[(Id, Id)], batch: &mut Batch) {
    let rows = Rows::of(uses.iter().copied());
    batch.insert("campaign_model", "record, model", OnConflict::Set("record", &["model"]), rows);
}

/// Every model that was adopted for an IMU, newest first.
pub async fn of_imu(store: &Store, imu: u32) -> Result<Vec<ModelRow>> {
    read!(store, all, ModelRow::select("WHERE imu = $1 ORDER BY id DESC"), imu)
}

/// How many campaigns were fitted with each model of an IMU that any was.
pub async fn uses(store: &Store, imu: u32) -> Result<Vec<(Id, u64)>> {
    let sql = "SELECT model, count(*) FROM campaign_model WHERE model IN (SELECT id FROM imu_model WHERE imu = $1)
               GROUP BY model";
    read!(store, all, sql, imu)
}

/// The newest model of each IMU that has one.
pub async fn in_force(store: &Store) -> Result<Vec<ModelRow>> {
    read!(store, all, ModelRow::select("WHERE id IN (SELECT max(id) FROM imu_model GROUP BY imu)"))
}

/// The adopted model that a stored campaign was fitted with, if it was one.
pub async fn of_campaign(store: &Store, record: Id) -> Result<Option<ModelRow>> {
    let sql = ModelRow::select("WHERE id = (SELECT model FROM campaign_model WHERE record = $1)");
    read!(store, first, sql, record)
}
