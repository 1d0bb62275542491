//! What was done to gyros.

use super::*;
use crate::core::gyro_event::GyroEvent;
use crate::core::judge::Event;

#[derive(Debug, Clone, PartialEq)]
pub struct EventRow {
    pub id: Id,
    pub gyro: u32,
    pub told: GyroEvent,
    pub received_at: UtcMicros,
}

columns! {
    EventRow in "event" {
        id, gyro,
        told: ["at", "kind", "until", "test", "d_i", "d_i_sd", "d_s", "d_s_sd", "reason", "author"],
        received_at,
    }
}

part! {
    GyroEvent { at, event, until, test, fixed, reason, author }
}

/// Every event of a gyro, oldest first.
pub async fn of_gyro(store: &Store, gyro: u32) -> Result<Vec<EventRow>> {
    read!(store, all, EventRow::select("WHERE gyro = $1 ORDER BY at, id"), gyro)
}

/// Those of some gyros that were retired or put into storage: when last, and which.
pub async fn out_of_use_of(store: &Store, gyros: &[u32]) -> Result<HashMap<u32, (UtcMicros, Event)>> {
    let ended = of_gyros(store, gyros).await?.into_iter().filter(|event| event.told.event.ends_calibrations());
    Ok(ended.map(|event| (event.gyro, (event.told.at, event.told.event))).collect())
}

/// Every event of several gyros, by gyro and oldest first.
pub async fn of_gyros(store: &Store, gyros: &[u32]) -> Result<Vec<EventRow>> {
    if gyros.is_empty() {
        return Ok(Vec::new());
    }
    let sql = EventRow::select(&format!("WHERE gyro IN {} ORDER BY gyro, at, id", store.readers.list("$1")));
    read!(store, all, sql, gyros)
}
