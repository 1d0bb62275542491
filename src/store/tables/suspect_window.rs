//! Windows of time in which what a station measured is suspect, mark by mark.

use super::{AnyRow, Columns, Id, Part, Result, Row, Span, Store, columns, read};
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

impl Part for Mark {
    fn put(&self, row: &mut Row<'_>) {
        let Self { window: SuspectWindow { span, author, reason }, trusted } = self;
        row.put(&span.from).put(&span.to).put(author).put(reason).put(trusted);
    }

    fn get(row: &impl AnyRow, columns: &[&'static str]) -> Result<Self> {
        let (from, to, author, reason, trusted) = row.part(columns)?;
        Ok(Self { window: SuspectWindow { span: Span { from, to }, author, reason }, trusted })
    }
}

/// Every mark of these stations, oldest first.
pub async fn of_stations(store: &Store, stations: &[u32]) -> Result<Vec<WindowMarkRow>> {
    if stations.is_empty() {
        return Ok(Vec::new());
    }
    let sql = WindowMarkRow::select(&format!("WHERE station IN {} ORDER BY id", store.readers.list("$1")));
    read!(store, all, sql, serde_json::json!(stations).to_string())
}
