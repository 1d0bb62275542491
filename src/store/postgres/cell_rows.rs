//! How far the cells have been written, and what is new since they were looked at.

use sqlx::postgres::PgRow;

use super::PgReaders;
use crate::core::named::named;
use crate::store::cells::CELLS;
use crate::store::error::{Result, StoreError};
use crate::store::rows::AnyRow;

named! {
/// What a commit may bring that others want to hear of, each with a column of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChangeTopic {
    Names = "names",
    /// Hooks, silences and alerts of stations.
    Settings = "settings",
    Outbox = "outbox",
    Models = "models",
    Diagnoses = "diagnoses",
    Access = "access",
}
}

/// A cell's row: stamps are random, and differ where anything has been written in between, or lost.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct CellRow {
    pub cell: u8,
    pub stamp: i64,
    /// The greatest identifier that was given out under its lock.
    pub last_id: i64,
    pub(super) topics: [i64; ChangeTopic::ALL.len()],
}

pub(super) const COLUMNS: &str =
    "SELECT cell, stamp, last_id, names, settings, outbox, models, diagnoses, access FROM cell";

impl CellRow {
    pub fn of(row: &PgRow) -> Result<Self> {
        let (cell, stamp, last_id, topics): (i64, _, _, _) = row.whole()?;
        let cell = u8::try_from(cell).map_err(|_| StoreError::damaged(format_args!("there is a cell {cell}")))?;
        Ok(Self { cell, stamp, last_id, topics })
    }

    pub fn stamp_of(&self, topic: ChangeTopic) -> i64 {
        self.topics[topic as usize]
    }
}

/// Every cell's row as it was seen last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct AllCells(pub [CellRow; CELLS]);

impl Default for AllCells {
    fn default() -> Self {
        Self([CellRow::default(); CELLS])
    }
}

impl AllCells {
    /// Without locking any.
    pub async fn look(readers: &PgReaders) -> Result<Self> {
        let mut all = Self::default();
        for row in sqlx::query(COLUMNS).fetch_all(readers).await? {
            let row = CellRow::of(&row)?;
            all.0[usize::from(row.cell)] = row;
        }
        Ok(all)
    }

    /// Takes over what was found; says what is new.
    pub fn learn(&mut self, found: &[CellRow]) -> RemoteChanges {
        let mut remote_changes = RemoteChanges::default();
        for row in found {
            let seen = std::mem::replace(&mut self.0[usize::from(row.cell)], *row);
            if row.stamp != seen.stamp {
                remote_changes.cells.push(row.cell);
            }
            remote_changes
                .topics
                .extend(ChangeTopic::ALL.into_iter().filter(|topic| row.stamp_of(*topic) != seen.stamp_of(*topic)));
        }
        remote_changes
    }
}

/// What others have written.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RemoteChanges {
    /// Cells in which something was written: nothing that is remembered of their gyros is known to hold.
    pub cells: Vec<u8>,
    pub topics: Vec<ChangeTopic>,
}

impl RemoteChanges {
    pub fn brings(&self, topic: ChangeTopic) -> bool {
        self.topics.contains(&topic)
    }
}
