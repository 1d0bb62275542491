//! Windows of time in which what a station measured is suspect, mark by mark.

use crate::core::id::Id;
use crate::core::suspect_window::{Mark, SuspectWindow};
use crate::core::time::{Span, UtcMicros};
use crate::store::batch::{Batch, Rows};
use crate::store::db::{AnyRow, Whole, cell, insert, listed, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;

/// How somebody marked a window of a station.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WindowMarkRow {
    pub id: Id,
    pub station: u32,
    pub mark: Mark,
}

pub(crate) fn insert(marks: &[WindowMarkRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for WindowMarkRow { id, station, mark: Mark { window, trusted } } in marks {
        rows.row()
            .integer(id.0)
            .integer(i64::from(*station))
            .integer(window.span.from.0)
            .integer(window.span.to.0)
            .integer(i64::from(*trusted))
            .text(&window.author)
            .text(&window.reason);
    }
    batch.add(
        insert!(
            "suspect_window (id, station, first_at, last_at, trusted, author, reason)",
            [int 0, int 1, int 2, int 3, int 4, text 5, text 6]
        ),
        rows,
    );
}

/// Every mark of these stations, oldest first.
pub async fn of_stations(store: &Store, stations: &[u32]) -> Result<Vec<WindowMarkRow>, StoreError> {
    if stations.is_empty() {
        return Ok(Vec::new());
    }
    let sql = store.readers.words(listed!(
        "SELECT id, station, first_at, last_at, trusted, author, reason FROM suspect_window WHERE station",
        " ORDER BY id"
    ));
    let stations = serde_json::json!(stations).to_string();
    on!(store.readers, db => sqlx::query(sql).bind(stations).fetch_all(db).await?.iter().map(row_of).collect())
}

fn row_of(row: &impl AnyRow) -> Result<WindowMarkRow, StoreError> {
    let span = Span { from: UtcMicros(row.cell("first_at")?), to: UtcMicros(row.cell("last_at")?) };
    Ok(WindowMarkRow {
        id: Id(row.cell("id")?),
        station: row.cell::<Whole<u32>>("station")?.0,
        mark: Mark {
            window: SuspectWindow { span, author: row.cell("author")?, reason: row.cell("reason")? },
            trusted: row.cell::<i64>("trusted")? != 0,
        },
    })
}
