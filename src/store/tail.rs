//! The newest history rows, before they are folded into the clustered history.
//!
//! In `history` every gyro's rows have pages of their own, so a commit that put its rows there would write a page a gyro. A
//! commit appends them to `history_log` instead, in one run of bytes, and they are held in memory, where readers find them.
//! Later all waiting rows of a gyro are folded into `history` together, those of the gyro that has waited longest first, a
//! few gyros a commit so that none is held up; the log is then cut off before the oldest row that still waits.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

use sqlx::SqliteConnection;

use super::batch::{Batch, Rows};
use super::db::{Sql, cell, insert};
use super::error::StoreError;
use super::figures::{Figures, PACKED_LEN};
use super::history::{HistoryRow, Span};

/// Rows that may wait: enough that a page of a gyro takes several of them at a time, in a fleet of thousands too.
const CAPACITY: usize = 16_384;
/// Rows of one gyro that are folded though there is room: more would take a commit longer than a millisecond or two.
const MANY: usize = 512;
const GYRO_LEN: usize = 4;

/// Rows that wait, by gyro.
#[derive(Debug, Default)]
pub(super) struct Tail {
    waiting: HashMap<u32, Waiting>,
    /// First entry of the log that a gyro's waiting rows stand in, and the gyro.
    by_age: BTreeSet<(i64, u32)>,
    /// Gyros with [`MANY`] rows.
    with_many: BTreeSet<u32>,
    len: usize,
    last_entry: i64,
}

#[derive(Debug)]
struct Waiting {
    since: i64,
    /// In order of time, one an instant.
    rows: Vec<Figures>,
}

/// What a commit moves from the tail into the history.
#[derive(Debug, Default)]
pub(super) struct Fold {
    rows: Vec<HistoryRow>,
}

impl Tail {
    /// Reads the log, as it was left.
    pub async fn load(connection: &mut SqliteConnection) -> Result<Self, StoreError> {
        let entries: Vec<(i64, Vec<u8>)> =
            sqlx::query_as("SELECT id, rows FROM history_log ORDER BY id").fetch_all(connection).await?;
        let mut tail = Self::default();
        for (entry, packed) in entries {
            let (rows, rest) = packed.as_chunks::<{ GYRO_LEN + PACKED_LEN }>();
            if !rest.is_empty() {
                return Err(StoreError::Damaged(format!("entry {entry} of the history's log has a wrong length")));
            }
            for row in rows {
                let (gyro, figures) = row.split_first_chunk().expect("a row is longer than a number");
                let figures = figures.try_into().expect("the rest of a row is as long as its figures");
                let gyro = u32::from_le_bytes(*gyro);
                tail.insert(entry, gyro, Figures::unpack(gyro, figures)?);
            }
            tail.last_entry = entry;
        }
        Ok(tail)
    }

    /// Every waiting row, with its gyro.
    pub fn rows(&self) -> impl Iterator<Item = (u32, &Figures)> {
        self.waiting.iter().flat_map(|(gyro, waiting)| waiting.rows.iter().map(|row| (*gyro, row)))
    }

    /// A gyro's waiting rows within `span`, in order of time.
    pub fn of(&self, gyro: u32, span: Span) -> &[Figures] {
        let Some(Waiting { rows, .. }) = self.waiting.get(&gyro) else { return &[] };
        let from = rows.partition_point(|row| row.at < span.from);
        let to = rows.partition_point(|row| row.at <= span.to);
        rows.get(from..to).unwrap_or_default()
    }

    /// The oldest `limit` of them, oldest first; or the newest, newest first.
    pub fn first_of(&self, gyro: u32, span: Span, limit: usize, newest_first: bool) -> Vec<Figures> {
        let rows = self.of(gyro, span).iter();
        if newest_first { rows.rev().take(limit).copied().collect() } else { rows.take(limit).copied().collect() }
    }

    /// The newest waiting row of each gyro that has any.
    pub fn newest(&self) -> impl Iterator<Item = (u32, &Figures)> {
        self.waiting.iter().filter_map(|(gyro, waiting)| Some((*gyro, waiting.rows.last()?)))
    }

    /// What is to be folded so that `incoming` more rows find room.
    pub fn due(&self, incoming: usize) -> Fold {
        let excess = (self.len + incoming).saturating_sub(CAPACITY);
        let mut gyros = self.with_many.clone();
        let mut taken: usize = gyros.iter().map(|gyro| self.waiting[gyro].rows.len()).sum();
        for (_, gyro) in &self.by_age {
            if taken >= excess {
                break;
            }
            if gyros.insert(*gyro) {
                taken += self.waiting[gyro].rows.len();
            }
        }
        // In the order of the key, so that each page is touched once.
        let rows_of = |gyro: &u32| {
            let gyro = *gyro;
            self.waiting[&gyro].rows.iter().map(move |figures| HistoryRow { gyro, figures: *figures })
        };
        Fold { rows: gyros.iter().flat_map(rows_of).collect() }
    }

    /// Enters new rows into the log, and those of `fold` into the history.
    pub fn write<'a>(&self, new: impl Iterator<Item = &'a HistoryRow>, fold: &Fold, batch: &mut Batch) {
        let mut new = new.peekable();
        if new.peek().is_some() {
            let mut entry = Rows::default();
            entry.row().integer(self.last_entry + 1).written(|out| {
                for HistoryRow { gyro, figures } in new {
                    out.extend(gyro.to_le_bytes());
                    figures.pack(*gyro, out);
                }
            });
            batch.add(insert!("history_log (id, rows)", [int 0, blob 1 2]), entry);
        }
        if !fold.rows.is_empty() {
            super::history::upsert(fold.rows.iter(), batch);
            let mut cut = Rows::default();
            cut.row().integer(self.oldest_after(fold));
            batch.add(Sql::of_sqlite("DELETE FROM history_log WHERE id < $C0"), cut);
        }
    }

    /// The first entry of the log that is still needed when `fold` is in the history.
    fn oldest_after(&self, fold: &Fold) -> i64 {
        let folded: HashSet<u32> = fold.rows.iter().map(|row| row.gyro).collect();
        let first = self.by_age.iter().find(|(_, gyro)| !folded.contains(gyro));
        first.map_or(self.last_entry + 1, |(since, _)| *since)
    }

    /// Follows a commit.
    pub fn committed<'a>(&mut self, new: impl Iterator<Item = &'a HistoryRow>, fold: &Fold) {
        for of_gyro in fold.rows.chunk_by(|a, b| a.gyro == b.gyro) {
            self.remove(of_gyro[0].gyro);
        }
        let mut new = new.peekable();
        if new.peek().is_some() {
            self.last_entry += 1;
        }
        for row in new {
            self.insert(self.last_entry, row.gyro, row.figures);
        }
    }

    fn remove(&mut self, gyro: u32) {
        if let Some(waiting) = self.waiting.remove(&gyro) {
            self.by_age.remove(&(waiting.since, gyro));
            self.with_many.remove(&gyro);
            self.len -= waiting.rows.len();
        }
    }

    fn insert(&mut self, entry: i64, gyro: u32, figures: Figures) {
        let waiting = self.waiting.entry(gyro).or_insert_with(|| {
            self.by_age.insert((entry, gyro));
            Waiting { since: entry, rows: Vec::new() }
        });
        match waiting.rows.binary_search_by_key(&figures.at, |row| row.at) {
            Ok(there) => waiting.rows[there] = figures,
            Err(place) => {
                waiting.rows.insert(place, figures);
                self.len += 1;
                if waiting.rows.len() == MANY {
                    self.with_many.insert(gyro);
                }
            }
        }
    }
}

/// The tail, as readers and the writer share it.
#[derive(Debug, Clone, Default)]
pub(super) struct SharedTail(Arc<RwLock<Tail>>);

impl SharedTail {
    pub fn new(tail: Tail) -> Self {
        Self(Arc::new(RwLock::new(tail)))
    }

    /// To be asked before the database: what is folded in between is then seen in both rather than in neither.
    pub fn read(&self) -> RwLockReadGuard<'_, Tail> {
        // Every change leaves the tail whole, even one that panics.
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn change(&self, change: impl FnOnce(&mut Tail)) {
        change(&mut self.0.write().unwrap_or_else(PoisonError::into_inner));
    }
}
