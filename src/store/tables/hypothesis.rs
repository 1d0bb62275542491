//! Hypotheses of one's own that compete in every diagnosis.

use crate::core::id::Id;
use crate::core::time::UtcMicros;
use crate::store::batch::{Batch, Rows};
use crate::store::db::{cell, insert, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HypothesisRow {
    pub id: Id,
    /// JSON.
    pub body: String,
    pub author: String,
    pub reason: String,
    pub added_at: UtcMicros,
    /// When it was taken out; it competes until then.
    pub ended_at: Option<UtcMicros>,
}

pub(crate) fn upsert(hypotheses: &[HypothesisRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for HypothesisRow { id, body, author, reason, added_at, ended_at } in hypotheses {
        rows.row()
            .integer(id.0)
            .text(body)
            .text(author)
            .text(reason)
            .integer(added_at.0)
            .optional_integer(ended_at.map(|at| at.0));
    }
    batch.add(
        insert!(
            "hypothesis (id, body, author, reason, added_at, ended_at)",
            [int 0, text 1, text 2, text 3, int 4, int 5],
            "ON CONFLICT (id) DO UPDATE SET ended_at = excluded.ended_at"
        ),
        rows,
    );
}

/// Those that compete, in the order in which they were added.
pub async fn in_force(store: &Store) -> Result<Vec<HypothesisRow>, StoreError> {
    let sql = "SELECT id, body, author, reason, added_at FROM hypothesis WHERE ended_at IS NULL ORDER BY id";
    let rows: Vec<(i64, String, String, String, i64)> =
        on!(store.readers, db => sqlx::query_as(sql).fetch_all(db).await?);
    let row = |(id, body, author, reason, added_at)| HypothesisRow {
        id: Id(id),
        body,
        author,
        reason,
        added_at: UtcMicros(added_at),
        ended_at: None,
    };
    Ok(rows.into_iter().map(row).collect())
}
