//! The newest history rows, before they are folded into the clustered history.
//!
//! In `history` every gyro's rows have pages of their own, so a commit that put its rows there would write a page a
//! gyro. A commit appends them to `history_log` instead, in one run of bytes, and they are held in memory, where
//! readers find them. Later all waiting rows of a gyro are folded into `history` together, those of the gyro that has
//! waited longest first, a few gyros a commit so that none is held up; the log is then cut off before the oldest row
//! that still waits.

use std::collections::BTreeSet;

use sqlx::SqliteConnection;

use crate::core::figures::Figures;
use crate::core::time::Span;
use crate::store::batch::{Batch, OnConflict};
use crate::store::packed::history_row::{self, PACKED_LEN};
use crate::store::rows::Rows;
use crate::store::sqlite::write_behind::queues::PendingRows;
use crate::store::{HistoryRow, Result, StoreError};

const GYRO_LEN: usize = 4;

/// Rows that wait, by gyro; those of a gyro in order of time, one an instant.
#[derive(Debug, Default)]
pub(crate) struct PendingHistory {
    waiting: PendingRows<Figures>,
    last_entry: i64,
}

/// The gyros whose waiting rows a commit moves into the history.
#[derive(Debug, Default)]
pub(crate) struct Fold(BTreeSet<u32>);

impl PendingHistory {
    /// Reads the log, as it was left.
    pub async fn load(connection: &mut SqliteConnection) -> Result<Self> {
        let entries: Vec<(i64, Vec<u8>)> =
            sqlx::query_as("SELECT id, rows FROM history_log ORDER BY id").fetch_all(connection).await?;
        let mut pending = Self::default();
        for (entry, packed) in entries {
            let (rows, rest) = packed.as_chunks::<{ GYRO_LEN + PACKED_LEN }>();
            if !rest.is_empty() {
                return Err(StoreError::damaged(format_args!("entry {entry} of the history's log has a wrong length")));
            }
            for row in rows {
                let (gyro, figures) = row.split_first_chunk().expect("a row is longer than a number");
                let figures = figures.try_into().expect("the rest of a row is as long as its figures");
                let gyro = u32::from_le_bytes(*gyro);
                pending.insert(entry, gyro, Figures::unpack(gyro, figures)?);
            }
            pending.last_entry = entry;
        }
        Ok(pending)
    }

    /// Every waiting row, with its gyro.
    pub fn rows(&self) -> impl Iterator<Item = (u32, &Figures)> {
        self.waiting.iter().flat_map(|(gyro, rows)| rows.iter().map(move |row| (gyro, row)))
    }

    /// A gyro's waiting rows within `span`, in order of time.
    pub fn of(&self, gyro: u32, span: Span) -> &[Figures] {
        let rows = self.waiting.of(gyro);
        let from = rows.partition_point(|row| row.at < span.from);
        let to = rows.partition_point(|row| row.at <= span.to);
        rows.get(from..to).unwrap_or_default()
    }

    /// The oldest `limit` of them, oldest first; or the newest, newest first.
    pub fn first_of(&self, gyro: u32, span: Span, limit: usize, newest_first: bool) -> Vec<Figures> {
        let rows = self.of(gyro, span).iter();
        if newest_first { rows.rev().take(limit).copied().collect() } else { rows.take(limit).copied().collect() }
    }

    /// What is to be folded so that `incoming` more rows find room.
    pub fn due(&self, incoming: usize) -> Fold {
        Fold(self.waiting.due(incoming))
    }

    /// In the order of the key, so that each page is touched once.
    fn rows_of(&self, fold: &Fold) -> Vec<HistoryRow> {
        let of_gyro =
            |gyro: u32| self.waiting.of(gyro).iter().map(move |figures| HistoryRow { gyro, figures: *figures });
        fold.0.iter().flat_map(|gyro| of_gyro(*gyro)).collect()
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
            batch.insert("history_log", "id, rows", OnConflict::Fail, entry);
        }
        if !fold.0.is_empty() {
            history_row::upsert(self.rows_of(fold).iter(), batch);
            let first = self.waiting.first_without(&fold.0).unwrap_or(self.last_entry + 1);
            batch.change("DELETE FROM history_log", "id < $C0", Rows::of([first]));
        }
    }

    /// Follows a commit.
    pub fn committed<'a>(&mut self, new: impl Iterator<Item = &'a HistoryRow>, fold: &Fold) {
        for gyro in &fold.0 {
            self.waiting.remove(*gyro);
        }
        let mut new = new.peekable();
        if new.peek().is_some() {
            self.last_entry += 1;
        }
        for row in new {
            self.insert(self.last_entry, row.gyro, row.figures);
        }
    }

    fn insert(&mut self, entry: i64, gyro: u32, figures: Figures) {
        self.waiting.enter(entry, gyro, |rows| match rows.binary_search_by_key(&figures.at, |row| row.at) {
            Ok(there) => rows[there] = figures,
            Err(place) => rows.insert(place, figures),
        });
    }
}
