//! Silences of every alert that matches.

use super::*;
use crate::core::alert_filter::Matchers;
use crate::store::Remark;

/// Nobody is told of the alerts that match, before a time or until somebody ends it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SilenceRow {
    pub id: Id,
    pub matchers: Matchers,
    pub until: UtcMicros,
    pub said: Remark,
    pub ended: Option<Remark>,
}

columns! {
    SilenceRow in "silence" {
        id, matchers: ["serial", "imu", "station", "rule"], until, said: ["author", "reason", "at"],
        ended: ["ended_by", "ended_reason", "ended_at"],
    }
}

part! {
    Matchers { serial, imu, station, rule }
}

/// Silences in force at `now`, or all that there ever were; the newest first.
pub async fn list(store: &Store, in_force_at: Option<UtcMicros>, limit: u32) -> Result<Vec<SilenceRow>> {
    let sql = SilenceRow::select("WHERE ($1 IS NULL OR (until > $1 AND ended_at IS NULL)) ORDER BY id DESC LIMIT $2");
    read!(store, all, sql, in_force_at, limit)
}

pub async fn get(store: &Store, id: Id) -> Result<Option<SilenceRow>> {
    read!(store, first, SilenceRow::select("WHERE id = $1"), id)
}
