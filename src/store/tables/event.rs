//! What was done to gyros.

use std::collections::HashMap;

use crate::core::id::Id;
use crate::core::judge::{Event, FixedLevels, Measured};
use crate::core::time::UtcMicros;
use crate::store::batch::{Batch, Rows};
use crate::store::db::{AnyRow, Whole, cell, insert, listed, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;

#[derive(Debug, Clone, PartialEq)]
pub struct EventRow {
    pub id: Id,
    pub gyro: u32,
    pub at: UtcMicros,
    pub event: Event,
    /// When it was over, of what took time.
    pub until: Option<UtcMicros>,
    /// Which environmental test it was.
    pub test: Option<String>,
    /// Levels that a baseline mark states.
    pub fixed: FixedLevels,
    pub reason: String,
    pub author: Option<String>,
    pub received_at: UtcMicros,
}

pub(crate) fn insert(events: &[EventRow], batch: &mut Batch) {
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
        row.optional_integer(event.until.map(|until| until.0)).optional(event.test.as_deref());
    }
    batch.add(
        insert!(
            "event (id, gyro, at, kind, reason, author, received_at, d_i, d_i_sd, d_s, d_s_sd, until, test)",
            [int 0, int 1, int 2, words 3 4, words 5 6, words 7 8, int 9, real 10, real 11, real 12, real 13, int 14, words 15 16]
        ),
        rows,
    );
}

fn event_of(row: &impl AnyRow) -> Result<EventRow, StoreError> {
    let id = Id(row.cell("id")?);
    let kind: String = row.cell("kind")?;
    let level = |value: &str, sd: &str| -> Result<Option<Measured>, StoreError> {
        let (value, sd): (Option<f64>, Option<f64>) = (row.cell(value)?, row.cell(sd)?);
        Ok(value.map(|value| Measured { value, sd }))
    };
    Ok(EventRow {
        id,
        gyro: row.cell::<Whole<u32>>("gyro")?.0,
        at: UtcMicros(row.cell("at")?),
        event: Event::from_name(&kind).ok_or_else(|| StoreError::Damaged(format!("event {id}: unknown kind")))?,
        until: row.cell::<Option<i64>>("until")?.map(UtcMicros),
        test: row.cell("test")?,
        fixed: [level("d_i", "d_i_sd")?, level("d_s", "d_s_sd")?],
        reason: row.cell("reason")?,
        author: row.cell("author")?,
        received_at: UtcMicros(row.cell("received_at")?),
    })
}

/// Every event of a gyro, oldest first.
pub async fn of_gyro(store: &Store, gyro: u32) -> Result<Vec<EventRow>, StoreError> {
    let sql = "SELECT id, gyro, at, kind, reason, author, received_at, d_i, d_i_sd, d_s, d_s_sd, until, test
               FROM event WHERE gyro = $1 ORDER BY at, id";
    on!(store.readers, db => sqlx::query(sql).bind(Whole(gyro)).fetch_all(db).await?.iter().map(event_of).collect())
}

/// Those of some gyros that were retired or put into storage: when last, and which.
pub async fn out_of_use_of(store: &Store, gyros: &[u32]) -> Result<HashMap<u32, (UtcMicros, Event)>, StoreError> {
    let ended = of_gyros(store, gyros).await?.into_iter().filter(|event| event.event.ends_calibrations());
    Ok(ended.map(|event| (event.gyro, (event.at, event.event))).collect())
}

/// Every event of several gyros, by gyro and oldest first.
pub async fn of_gyros(store: &Store, gyros: &[u32]) -> Result<Vec<EventRow>, StoreError> {
    let sql = store.readers.words(listed!(
        "SELECT id, gyro, at, kind, reason, author, received_at, d_i, d_i_sd, d_s, d_s_sd, until, test
         FROM event WHERE gyro",
        " ORDER BY gyro, at, id"
    ));
    let gyros = serde_json::json!(gyros).to_string();
    on!(store.readers, db => sqlx::query(sql).bind(gyros).fetch_all(db).await?.iter().map(event_of).collect())
}
