//! Windows of time in which what a station measured is suspect, mark by mark.

use super::*;
use crate::core::suspect_window::{Mark, SuspectWindow};

/// How somebody marked a window of a station.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WindowMarkRow {
    pub id: Id,
    pub station: u32,
    pub mark: Mark,
}

columns! {
    WindowMarkRow in "suspect_window" { id, station, mark: ["first_at", "last_at", "author", "reason", "trusted"] }
}

part! {
    Mark { window, trusted }
}
part! {
    SuspectWindow { span, author, reason }
}
part! {
    Span { from, to }
}

/// Every mark of these stations, oldest first.
pub async fn of_stations(store: &Store, stations: &[u32]) -> Result<Vec<WindowMarkRow>> {
    if stations.is_empty() {
        return Ok(Vec::new());
    }
    let sql = WindowMarkRow::select(&format!("WHERE station IN {} ORDER BY id", store.readers.list("$1")));
    read!(store, all, sql, stations)
}
