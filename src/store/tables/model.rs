//! Error models that were adopted for an IMU, and which campaigns were fitted with them.

use crate::core::id::Id;
use crate::core::time::UtcMicros;
use crate::store::batch::{Batch, Rows};
use crate::store::db::{AnyRow, Whole, cell, insert, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;

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

pub(crate) fn insert(models: &[ModelRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for model in models {
        rows.row()
            .integer(model.id.0)
            .integer(i64::from(model.imu))
            .integer(model.adopted_at.0)
            .text(&model.author)
            .text(&model.reason)
            .text(&model.body);
    }
    batch.add(
        insert!("imu_model (id, imu, adopted_at, author, reason, body)", [int 0, int 1, int 2, text 3, text 4, text 5]),
        rows,
    );
}

/// Which campaigns were fitted with an adopted model; the last holds.
pub(crate) fn insert_uses(uses: &[(Id, Id)], batch: &mut Batch) {
    let mut rows = Rows::default();
    for (record, model) in uses {
        rows.row().integer(record.0).integer(model.0);
    }
    batch.add(
        insert!(
            "campaign_model (record, model)",
            [int 0, int 1],
            "ON CONFLICT (record) DO UPDATE SET model = excluded.model"
        ),
        rows,
    );
}

fn row(row: &impl AnyRow) -> Result<ModelRow, StoreError> {
    Ok(ModelRow {
        id: Id(row.cell("id")?),
        imu: row.cell::<Whole<u32>>("imu")?.0,
        adopted_at: UtcMicros(row.cell("adopted_at")?),
        author: row.cell("author")?,
        reason: row.cell("reason")?,
        body: row.cell("body")?,
    })
}

/// Every model that was adopted for an IMU, newest first.
pub async fn of_imu(store: &Store, imu: u32) -> Result<Vec<ModelRow>, StoreError> {
    let sql = "SELECT id, imu, adopted_at, author, reason, body FROM imu_model WHERE imu = $1 ORDER BY id DESC";
    on!(store.readers, db => sqlx::query(sql).bind(Whole(imu)).fetch_all(db).await?.iter().map(row).collect())
}

/// How many campaigns were fitted with each model of an IMU that any was.
pub async fn uses(store: &Store, imu: u32) -> Result<Vec<(Id, u64)>, StoreError> {
    let sql = "SELECT model, count(*) FROM campaign_model WHERE model IN (SELECT id FROM imu_model WHERE imu = $1)
               GROUP BY model";
    let rows: Vec<(i64, i64)> = on!(store.readers, db => sqlx::query_as(sql).bind(Whole(imu)).fetch_all(db).await?);
    Ok(rows.into_iter().map(|(model, count)| (Id(model), count.unsigned_abs())).collect())
}

/// The newest model of each IMU that has one.
pub async fn in_force(store: &Store) -> Result<Vec<ModelRow>, StoreError> {
    let sql = "SELECT id, imu, adopted_at, author, reason, body FROM imu_model
               WHERE id IN (SELECT max(id) FROM imu_model GROUP BY imu)";
    on!(store.readers, db => sqlx::query(sql).fetch_all(db).await?.iter().map(row).collect())
}

/// The adopted model that a stored campaign was fitted with, if it was one.
pub async fn of_campaign(store: &Store, record: Id) -> Result<Option<ModelRow>, StoreError> {
    let sql = "SELECT id, imu, adopted_at, author, reason, body FROM imu_model
               WHERE id = (SELECT model FROM campaign_model WHERE record = $1)";
    on!(store.readers, db => sqlx::query(sql).bind(record.0).fetch_optional(db).await?.as_ref().map(row).transpose())
}
