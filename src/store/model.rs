//! Error models that were adopted for an IMU, and which campaigns were fitted with them.

use sqlx::{Row as _, sqlite::SqliteRow};

use super::batch::{Batch, Rows};
use super::error::StoreError;
use super::id::Id;
use super::open::Store;
use crate::core::time::UtcMicros;

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

pub(super) fn insert(models: &[ModelRow], batch: &mut Batch) {
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
        "INSERT INTO imu_model (id, imu, adopted_at, author, reason, body)
         SELECT value->>0, value->>1, value->>2, value->>3, value->>4, value->>5 FROM json_each($ROWS)",
        rows,
    );
}

/// Which of the group's campaigns were fitted with an adopted model.
pub(super) fn insert_uses(uses: &[(Id, Id)], batch: &mut Batch) {
    let mut rows = Rows::default();
    for (record, model) in uses {
        rows.row().integer(record.0).integer(model.0);
    }
    batch.add("INSERT INTO campaign_model (record, model) SELECT value->>0, value->>1 FROM json_each($ROWS)", rows);
}

fn row(row: &SqliteRow) -> Result<ModelRow, StoreError> {
    Ok(ModelRow {
        id: Id(row.try_get("id")?),
        imu: row.try_get("imu")?,
        adopted_at: UtcMicros(row.try_get("adopted_at")?),
        author: row.try_get("author")?,
        reason: row.try_get("reason")?,
        body: row.try_get("body")?,
    })
}

impl Store {
    /// Every model that was adopted for an IMU, newest first.
    pub async fn models(&self, imu: u32) -> Result<Vec<ModelRow>, StoreError> {
        let sql = "SELECT id, imu, adopted_at, author, reason, body FROM imu_model WHERE imu = $1 ORDER BY id DESC";
        let rows = sqlx::query(sql).bind(imu).fetch_all(&self.readers).await?;
        rows.iter().map(row).collect()
    }

    /// The newest model of each IMU that has one.
    pub async fn models_in_force(&self) -> Result<Vec<ModelRow>, StoreError> {
        let sql = "SELECT id, imu, adopted_at, author, reason, body FROM imu_model
                   WHERE id IN (SELECT max(id) FROM imu_model GROUP BY imu)";
        let rows = sqlx::query(sql).fetch_all(&self.readers).await?;
        rows.iter().map(row).collect()
    }

    /// The adopted model that a stored campaign was fitted with, if it was one.
    pub async fn model_of_campaign(&self, record: Id) -> Result<Option<ModelRow>, StoreError> {
        let sql = "SELECT id, imu, adopted_at, author, reason, body FROM imu_model
                   WHERE id = (SELECT model FROM campaign_model WHERE record = $1)";
        let found = sqlx::query(sql).bind(record.0).fetch_optional(&self.readers).await?;
        found.as_ref().map(row).transpose()
    }
}
