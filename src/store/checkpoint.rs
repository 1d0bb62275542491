//! Copying the write-ahead log into the database, off the committing path.
//!
//! SQLite's automatic checkpoint runs inside a commit and stalls everyone behind it for tens of milliseconds. Here a
//! second connection copies while the first goes on committing. A log that is never *wholly* copied is never begun
//! anew and would grow for ever under load, so when the copy has nearly caught up, the committing connection copies
//! the last pages itself, between two commits.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use sqlx::SqliteConnection;
use tokio::sync::mpsc;

use super::error::StoreError;
use super::halt::Halt;

/// Pages that the committing connection may copy by itself: a few milliseconds.
const FEW: i64 = 500;
/// Copies in a row before the rest is left to the committing connection anyway.
const PASSES: usize = 8;

#[derive(Debug)]
pub(super) struct Checkpoints {
    wanted: mpsc::Sender<()>,
    nearly_done: Arc<AtomicBool>,
    /// An earlier run's log has been copied.
    begun: bool,
    written: u32,
    every: u32,
}

impl Checkpoints {
    /// Copies on `connection`, as a task, each time about `every` pages have been written. The task ends with `self`.
    pub fn start(connection: SqliteConnection, every: u32, halt: Halt) -> Self {
        let (wanted, requests) = mpsc::channel(1);
        let nearly_done = Arc::new(AtomicBool::new(false));
        tokio::spawn(serve(connection, requests, nearly_done.clone(), halt));
        Self { wanted, nearly_done, begun: false, written: 0, every }
    }

    /// Copies what an earlier run has left in the log, before anything is added to it: where that run ended with a failed flush,
    /// the log may stand in memory only, and what is appended to it would be lost with it.
    pub async fn begin(&mut self, connection: &mut SqliteConnection) -> Result<(), StoreError> {
        if !self.begun {
            copy_all(connection).await?;
            self.begun = true;
        }
        Ok(())
    }

    /// Counts what a commit has written.
    pub fn written(&mut self, pages: u32) {
        self.written = self.written.saturating_add(pages);
        // A full channel means that one is already waiting to run.
        if self.written >= self.every && self.wanted.try_send(()).is_ok() {
            self.written = 0;
        }
    }

    /// Copies the last pages, where the task has left only few.
    pub async fn finish(&mut self, connection: &mut SqliteConnection) -> Result<(), StoreError> {
        self.begin(connection).await?;
        if self.nearly_done.swap(false, Ordering::Relaxed) {
            copy(connection).await?;
        }
        Ok(())
    }
}

async fn serve(
    mut connection: SqliteConnection,
    mut requests: mpsc::Receiver<()>,
    nearly_done: Arc<AtomicBool>,
    halt: Halt,
) {
    while requests.recv().await.is_some() && halt.check().is_ok() {
        match halt.heed(catch_up(&mut connection).await) {
            Ok(()) => nearly_done.store(true, Ordering::Relaxed),
            Err(error) => tracing::warn!(%error, "the write-ahead log could not be copied into the database"),
        }
    }
    if halt.check().is_err() {
        std::mem::forget(connection);
    }
}

/// Copies everything and empties the log, unless another process reads from it: then as much as may be.
pub(super) async fn copy_all(connection: &mut SqliteConnection) -> Result<(), StoreError> {
    let copied = sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").execute(connection).await;
    match copied.map_err(StoreError::from) {
        Err(StoreError::Busy) | Ok(_) => Ok(()),
        Err(error) => Err(error),
    }
}

/// Copies until only few pages have come in during a copy.
async fn catch_up(connection: &mut SqliteConnection) -> Result<(), StoreError> {
    let mut copied = copy(connection).await?;
    for _ in 1..PASSES {
        let now_copied = copy(connection).await?;
        if now_copied - copied <= FEW {
            break;
        }
        copied = now_copied;
    }
    Ok(())
}

/// One passive checkpoint: how many pages of the log, as it stood at the beginning, are copied now.
async fn copy(connection: &mut SqliteConnection) -> Result<i64, StoreError> {
    let (_busy, _in_log, copied): (i64, i64, i64) =
        sqlx::query_as("PRAGMA wal_checkpoint(PASSIVE)").fetch_one(connection).await?;
    Ok(copied)
}
