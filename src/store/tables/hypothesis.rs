//! Hypotheses of one's own that compete in every diagnosis.

use super::*;

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

columns! {
    HypothesisRow in "hypothesis" { id, body, author, reason, added_at, ended_at }
}

/// Those that compete, in the order in which they were added.
pub async fn in_force(store: &Store) -> Result<Vec<HypothesisRow>> {
    read!(store, all, HypothesisRow::select("WHERE ended_at IS NULL ORDER BY id"))
}
