//! How far a database has been written, and what is new since it was looked at.

use std::collections::BTreeSet;

use sqlx::{AssertSqlSafe, Row as _};

use super::PgReaders;
use crate::core::id::Id;
use crate::store::commit::Changes;
use crate::store::db::Readers;
use crate::store::error::StoreError;
use crate::store::open::Store;
use crate::store::tables::history::HistoryRow;
use crate::store::tables::names::Commit;

/// The turn's row.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Standing {
    /// The newest.
    pub commit: Commit,
    pub last_id: i64,
    /// The version at which something of each kind was last written: see [`KINDS`].
    pub kinds: [i64; KINDS],
}

const KINDS: usize = 7;
pub(super) const RECORDS: usize = 0;
/// What counts no more, marks, bench results: what alters judging beyond new records.
pub(super) const MARKS: usize = 1;
pub(super) const ALERTS: usize = 2;
pub(super) const OUTBOX: usize = 3;
pub(super) const MODELS: usize = 4;
pub(super) const DIAGNOSES: usize = 5;
pub(super) const ACCESS: usize = 6;

/// The turn's row, and the stamp that the commit had which this server has seen: none where the database has lost it.
pub(super) fn look(seen: Commit) -> String {
    format!(
        "SELECT version, stamp, last_id, records, marks, alerts, outbox, models, diagnoses, access,
             (SELECT stamp FROM turn_commit WHERE turn_commit.version = {})
         FROM turn WHERE id = 1",
        seen.version
    )
}

/// The turn's row, and whether what was seen of the database before is still part of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Found {
    pub standing: Standing,
    pub is_continued: bool,
}

impl Found {
    pub fn of(row: &sqlx::postgres::PgRow, seen: Commit) -> Result<Self, sqlx::Error> {
        let mut kinds = [0; KINDS];
        for (kind, place) in kinds.iter_mut().zip(3..) {
            *kind = row.try_get(place)?;
        }
        let commit = Commit { version: row.try_get(0)?, stamp: row.try_get(1)? };
        let stamp: Option<i64> = row.try_get(3 + KINDS)?;
        Ok(Self {
            standing: Standing { commit, last_id: row.try_get(2)?, kinds },
            is_continued: stamp == Some(seen.stamp) || seen == Commit::default(),
        })
    }

    /// Without taking the turn.
    pub async fn look(readers: &PgReaders, seen: Commit) -> Result<Self, StoreError> {
        let row = sqlx::query(AssertSqlSafe(look(seen))).fetch_one(readers).await?;
        Ok(Self::of(&row, seen)?)
    }

    /// What others have written since `seen`.
    pub fn missed(&self, seen: &Standing) -> Missed {
        if self.is_continued { Missed::between(seen, &self.standing) } else { Missed::EVERYTHING }
    }
}

impl Standing {
    /// As it is after `changes`, of which the greatest identifier is `last_id`.
    pub fn after(&self, changes: &Changes, last_id: i64) -> Self {
        let commit = Commit { version: self.commit.version + 1, stamp: rand::random_range(1..i64::MAX) };
        let mut next = Self { commit, last_id: last_id.max(self.last_id), kinds: self.kinds };
        let withdrawn = &changes.withdrawn;
        let outbox = &changes.outbox;
        let is_new = [
            !changes.records.is_empty(),
            [changes.events.len(), changes.benches.len(), withdrawn.records.len(), withdrawn.benches.len()] != [0; 4]
                || !changes.confirmed.is_empty(),
            !(changes.alerts.is_empty() && changes.alert_steps.is_empty() && changes.silences.is_empty()),
            [changes.hooks.len(), outbox.queued.len(), outbox.replayed.len()] != [0; 3]
                || [outbox.dropped.len(), outbox.hastened.len(), outbox.heard.len(), outbox.forgotten.len()] != [0; 4],
            !changes.models.is_empty(),
            !(changes.models.is_empty() && changes.diagnosis_jobs.started.is_empty())
                || changes.records.iter().any(|record| record.kind == crate::core::kind::Kind::Campaign),
            !changes.access.tokens.is_empty()
                || !changes.access.sessions.is_empty()
                || !changes.access.ended.is_empty(),
        ];
        for (kind, is_new) in next.kinds.iter_mut().zip(is_new) {
            if is_new {
                *kind = next.commit.version;
            }
        }
        next
    }

    /// Whether something of a kind was written since `seen`.
    pub fn has_moved(&self, kind: usize, seen: &Self) -> bool {
        self.kinds[kind] > seen.kinds[kind]
    }
}

/// What others have written since this server's last turn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Missed {
    /// Commits have been lost: nothing of what was seen is known to hold.
    pub everything: bool,
    /// Records with greater identifiers than this.
    pub records_after: Option<Id>,
    /// Something counts no more, was done to a gyro, or was measured on a bench, or an alert has changed: in commits
    /// after this.
    pub touched_after: Option<i64>,
    pub outbox: bool,
    pub models: bool,
    pub diagnoses: bool,
    pub access: bool,
}

impl Missed {
    /// Nothing of what was seen before is known to hold.
    pub const EVERYTHING: Self = Self {
        everything: true,
        records_after: None,
        touched_after: None,
        outbox: true,
        models: true,
        diagnoses: true,
        access: true,
    };

    pub(super) fn between(seen: &Standing, now: &Standing) -> Self {
        let moved = |kind| now.has_moved(kind, seen);
        Self {
            everything: false,
            records_after: moved(RECORDS).then_some(Id(seen.last_id)),
            touched_after: (moved(MARKS) || moved(ALERTS)).then_some(seen.commit.version),
            outbox: moved(OUTBOX),
            models: moved(MODELS),
            diagnoses: moved(DIAGNOSES),
            access: moved(ACCESS),
        }
    }
}

/// The gyros to which something is done besides a new record.
pub(super) fn touched(changes: &Changes) -> Option<String> {
    let withdrawn = &changes.withdrawn;
    let is_confirmed = |row: &&HistoryRow| changes.confirmed.iter().any(|it| it.record == row.figures.record);
    let confirmed = changes.history.iter().filter(is_confirmed).map(|row| row.gyro);
    let marked = changes.events.iter().map(|event| event.gyro).chain(changes.benches.iter().map(|bench| bench.gyro));
    let gone = withdrawn.history.iter().map(|row| row.gyro).chain(withdrawn.benches.iter().map(|(_, gyro)| *gyro));
    let alerted = changes.alerts.iter().map(|row| row.gyro);
    let gyros: BTreeSet<u32> = marked.chain(gone).chain(confirmed).chain(alerted).collect();
    (!gyros.is_empty()).then(|| serde_json::json!(gyros).to_string())
}

/// The gyros to which something was done in commits after `version`, besides new records.
///
/// # Errors
/// [`StoreError`].
pub async fn touched_since(store: &Store, version: i64) -> Result<Vec<u32>, StoreError> {
    let Readers::Postgres(readers) = &store.readers else { return Ok(Vec::new()) };
    let sql = "SELECT gyros FROM turn_commit WHERE version > $1 AND gyros IS NOT NULL";
    let lists: Vec<String> = sqlx::query_scalar(sql).bind(version).fetch_all(readers).await?;
    let mut gyros = BTreeSet::new();
    for list in lists {
        let list: Vec<u32> = serde_json::from_str(&list).map_err(|error| StoreError::Damaged(error.to_string()))?;
        gyros.extend(list);
    }
    Ok(gyros.into_iter().collect())
}
