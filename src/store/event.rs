//! What was done to gyros.

use super::batch::{Batch, Rows};
use super::error::StoreError;
use super::id::Id;
use super::open::Store;
use crate::core::judge::{Event, FixedLevels, Measured};
use crate::core::time::UtcMicros;

#[derive(Debug, Clone, PartialEq)]
pub struct EventRow {
    pub id: Id,
    pub gyro: u32,
    pub at: UtcMicros,
    pub event: Event,
    /// Levels that a baseline mark states.
    pub fixed: FixedLevels,
    pub reason: String,
    pub author: Option<String>,
    pub received_at: UtcMicros,
}

pub(super) fn insert(events: &[EventRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for event in events {
        let mut row = rows.row();
        row.integer(event.id.0)
            .integer(i64::from(event.gyro))
            .integer(event.at.0)
            .bytes(event.event.name().as_bytes())
            .bytes(event.reason.as_bytes())
            .optional(event.author.as_deref())
            .integer(event.received_at.0);
        for level in &event.fixed {
            row.real(level.map(|level| level.value)).real(level.and_then(|level| level.sd));
        }
    }
    batch.add(
        "INSERT INTO event (id, gyro, at, kind, reason, author, received_at, d_i, d_i_sd, d_s, d_s_sd)
         SELECT value->>0, value->>1, value->>2, CAST(substr($BYTES, value->>3, value->>4) AS TEXT),
                CAST(substr($BYTES, value->>5, value->>6) AS TEXT), CAST(substr($BYTES, value->>7, value->>8) AS TEXT),
                value->>9, value->>10, value->>11, value->>12, value->>13
         FROM json_each($ROWS)",
        rows,
    );
}

type Row = (i64, u32, i64, String, String, Option<String>, i64, Option<f64>, Option<f64>, Option<f64>, Option<f64>);

fn row(row: Row) -> Result<EventRow, StoreError> {
    let (id, gyro, at, kind, reason, author, received_at, d_i, d_i_sd, d_s, d_s_sd) = row;
    let fixed = [(d_i, d_i_sd), (d_s, d_s_sd)].map(|(value, sd)| value.map(|value| Measured { value, sd }));
    let event =
        Event::from_name(&kind).ok_or_else(|| StoreError::Damaged(format!("event {}: unknown kind", Id(id))))?;
    let (id, at, received_at) = (Id(id), UtcMicros(at), UtcMicros(received_at));
    Ok(EventRow { id, gyro, at, event, fixed, reason, author, received_at })
}

impl Store {
    /// Every event of a gyro, oldest first.
    pub async fn events(&self, gyro: u32) -> Result<Vec<EventRow>, StoreError> {
        let sql = "SELECT id, gyro, at, kind, reason, author, received_at, d_i, d_i_sd, d_s, d_s_sd
                   FROM event WHERE gyro = $1 ORDER BY at, id";
        let rows: Vec<Row> = sqlx::query_as(sql).bind(gyro).fetch_all(&self.readers).await?;
        rows.into_iter().map(row).collect()
    }

    /// Every event of several gyros, by gyro and oldest first.
    pub async fn events_of(&self, gyros: &[u32]) -> Result<Vec<EventRow>, StoreError> {
        let sql = "SELECT id, gyro, at, kind, reason, author, received_at, d_i, d_i_sd, d_s, d_s_sd
                   FROM event WHERE gyro IN (SELECT value FROM json_each($1)) ORDER BY gyro, at, id";
        let gyros = serde_json::json!(gyros).to_string();
        let rows: Vec<Row> = sqlx::query_as(sql).bind(gyros).fetch_all(&self.readers).await?;
        rows.into_iter().map(row).collect()
    }
}
