//! Copying the write-ahead log into the database, off the committing path.
//!
//! SQLite's automatic checkpoint runs inside a commit and stalls everyone behind it for tens of milliseconds. Here a
//! second connection copies while the first goes on committing. A log that is never *wholly* copied is never begun
//! anew and would grow for ever under load, so when the copy has nearly caught up, the committing connection copies
//! the last pages itself, between two commits.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::thread::{self, JoinHandle};

use rusqlite::Connection;

use super::flush_failure::FlushFailure;
use crate::store::error::{Result, StoreError};

/// Pages that the committing connection may copy by itself: a few milliseconds.
const FEW: i64 = 500;
/// Copies in a row before the rest is left to the committing connection anyway.
const PASSES: usize = 8;

#[derive(Debug)]
pub(crate) struct Checkpoints {
    wanted: mpsc::SyncSender<()>,
    thread: JoinHandle<()>,
    nearly_done: Arc<AtomicBool>,
    /// An earlier run's log has been copied.
    begun: bool,
    written: u32,
    every: u32,
}

impl Checkpoints {
    /// Copies on `connection`, on a thread, each time about `every` pages have been written. The thread ends when
    /// `self` is gone, which only [`Checkpoints::stop`] waits for.
    pub fn start(connection: Connection, every: u32, flush_failure: FlushFailure) -> Result<Self> {
        let (wanted, requests) = mpsc::sync_channel(1);
        let nearly_done = Arc::new(AtomicBool::new(false));
        let beside = nearly_done.clone();
        let thread = thread::Builder::new().name("checkpoints".into());
        let thread = thread.spawn(move || serve(connection, &requests, &beside, &flush_failure));
        let thread = thread.map_err(StoreError::other)?;
        Ok(Self { wanted, thread, nearly_done, begun: false, written: 0, every })
    }

    /// Copies what an earlier run has left in the log, before anything is added to it: where that run ended with a
    /// failed flush, the log may stand in memory only, and what is appended to it would be lost with it.
    pub fn begin(&mut self, connection: &Connection) -> Result<()> {
        if !self.begun {
            copy_all(connection)?;
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

    /// Copies the last pages, where the thread has left only few.
    pub fn finish(&mut self, connection: &Connection) -> Result<()> {
        self.begin(connection)?;
        if self.nearly_done.swap(false, Ordering::Relaxed) {
            copy(connection)?;
        }
        Ok(())
    }

    /// Waits for a copy that is under way, and closes its connection.
    pub fn stop(self) {
        let Self { wanted, thread, .. } = self;
        drop(wanted);
        if thread.join().is_err() {
            tracing::error!("the thread that copies the write-ahead log has panicked");
        }
    }
}

fn serve(
    connection: Connection,
    requests: &mpsc::Receiver<()>,
    nearly_done: &AtomicBool,
    flush_failure: &FlushFailure,
) {
    while requests.recv().is_ok() && flush_failure.check().is_ok() {
        match flush_failure.record(catch_up(&connection)) {
            Ok(()) => nearly_done.store(true, Ordering::Relaxed),
            Err(error) => tracing::warn!(%error, "the write-ahead log could not be copied into the database"),
        }
    }
    if flush_failure.check().is_err() {
        std::mem::forget(connection);
    }
}

/// Copies everything and empties the log, unless another process reads from it: then as much as may be.
pub(crate) fn copy_all(connection: &Connection) -> Result<()> {
    let copied = connection.query_row("PRAGMA wal_checkpoint(TRUNCATE)", (), |_| Ok(()));
    match copied.map_err(StoreError::from) {
        Err(StoreError::Busy) | Ok(_) => Ok(()),
        Err(error) => Err(error),
    }
}

/// Copies until only few pages have come in during a copy.
fn catch_up(connection: &Connection) -> Result<()> {
    let mut copied = copy(connection)?;
    for _ in 1..PASSES {
        let now_copied = copy(connection)?;
        if now_copied - copied <= FEW {
            break;
        }
        copied = now_copied;
    }
    Ok(())
}

/// One passive checkpoint: how many pages of the log, as it stood at the beginning, are copied now.
fn copy(connection: &Connection) -> Result<i64> {
    // Whether it was hindered, pages in the log, pages copied.
    Ok(connection.query_row("PRAGMA wal_checkpoint(PASSIVE)", (), |row| row.get(2))?)
}
