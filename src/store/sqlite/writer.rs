//! Writing a database in a file: one connection that commits, and checkpoints from a second one.
//!
//! Whoever calls waits for the disk. The connection is SQLite's own and not a driver's with a thread of its own:
//! handing a group over to that thread and back would take as long as a commit's flush.

use std::path::Path;

use tokio::runtime::{Handle, RuntimeFlavor};

use super::checkpoint::{self, Checkpoints};
use super::checksum::Summing;
use super::flush_failure::FlushFailure;
use super::lock::Lock;
use super::private;
use crate::store::changes::batch_of;
use crate::store::name_tables::Names;
use crate::store::sqlite::write_behind::WriteBehind;
use crate::store::sqlite::write_behind::record_index::{IndexChanges, NewRecord};
use crate::store::tables::diagnosis;
use crate::store::{ChangeTopic, Changes, RecordRow, Result, StoreError};

#[derive(Debug)]
pub(crate) struct FileWriter {
    connection: Summing,
    names: Names,
    write_behind: WriteBehind,
    checkpoints: Checkpoints,
    flush_failure: FlushFailure,
    /// The last write failed: whether writing works again, only writing can tell.
    in_doubt: bool,
    _lock: Lock,
}

impl FileWriter {
    pub fn new(
        connection: Summing,
        names: Names,
        write_behind: WriteBehind,
        checkpoints: Checkpoints,
        flush_failure: FlushFailure,
        lock: Lock,
    ) -> Self {
        Self { connection, names, write_behind, checkpoints, flush_failure, in_doubt: false, _lock: lock }
    }

    /// See [`crate::store::Writer::commit`].
    pub fn commit(&mut self, changes: &Changes) -> Result<()> {
        self.flush_failure.check()?;
        let finished = self.checkpoints.finish(&self.connection);
        self.in_doubt |= finished.is_err();
        self.flush_failure.record(finished)?;
        let mut batch = batch_of(changes);
        let fold = {
            let history = self.write_behind.history.read();
            let fold = history.due(changes.history_rows().count());
            history.write(changes.history_rows(), &fold, &mut batch);
            fold
        };
        let indexed = indexed(changes);
        let entering = {
            let index = self.write_behind.index.read();
            let entering = index.due(&indexed);
            index.write(&entering, &indexed, &mut batch);
            diagnosis::make_due(&changes.models, &mut batch);
            entering
        };
        let pages = batch.pages();
        let committed = batch.commit(&self.connection);
        match &committed {
            // It says nothing of the disk.
            Err(StoreError::Refused(_)) => {}
            result => self.in_doubt = result.is_err(),
        }
        self.flush_failure.record(committed)?;
        // First, so that whoever finds a row knows its names.
        if changes.brings(ChangeTopic::Names) {
            self.names.change(|tables| tables.enter(changes.new_names()));
        }
        self.write_behind.history.change(|history| history.committed(changes.history_rows(), &fold));
        self.write_behind.index.change(|index| index.committed(&entering, &indexed));
        self.checkpoints.written(pages);
        Ok(())
    }

    /// Whether writing works: the database can be locked for it, and after a failure it takes a write.
    pub fn probe(&mut self) -> Result<()> {
        self.flush_failure.check()?;
        self.flush_failure.record(self.checkpoints.begin(&self.connection))?;
        let sql = if self.in_doubt {
            // What the failed write has left of the log would take one page of another.
            let database = self.connection.path().filter(|path| !path.is_empty()).map(Path::new);
            database.map_or(Ok(()), private::make_sure_of_room)?;
            // The number is of no use to anyone else; setting it writes the first page.
            "BEGIN IMMEDIATE; PRAGMA user_version = 0; COMMIT"
        } else {
            "BEGIN IMMEDIATE; ROLLBACK"
        };
        if let Err(error) = self.connection.execute_batch(sql) {
            let _nothing_left = self.connection.execute_batch("ROLLBACK");
            return self.flush_failure.record(Err(error.into()));
        }
        self.in_doubt = false;
        Ok(())
    }

    /// Copies the whole log into the database and closes it.
    pub fn close(self) -> Result<()> {
        self.checkpoints.stop();
        let copied = match self.flush_failure.check() {
            Ok(()) => self.flush_failure.record(checkpoint::copy_all(&self.connection)),
            halted => halted,
        };
        if matches!(copied, Err(StoreError::NotDurable(_))) {
            std::mem::forget(self.connection);
            return copied;
        }
        self.connection.into_inner().close().map_err(|(_, error)| error)?;
        copied
    }
}

fn indexed(changes: &Changes) -> IndexChanges<'_> {
    let new = |record: &RecordRow| NewRecord {
        record: record.id,
        imu: record.imu,
        at: record.calibrated_at,
        voided: record.voided,
    };
    IndexChanges {
        records: changes.records.iter().map(new).collect(),
        withdrawn: &changes.withdrawn.records,
        confirmed: changes.confirmed.iter().map(|confirmed| confirmed.record).collect(),
        asked_for: changes.models.iter().map(|model| model.imu).collect(),
    }
}

/// Does `work` on this thread. Where it is one of those that run a runtime's tasks, its others are handed over to the
/// next.
pub(in crate::store) fn waiting_for_disk<T>(work: impl FnOnce() -> T) -> T {
    match Handle::current().runtime_flavor() {
        RuntimeFlavor::CurrentThread => work(),
        _ => tokio::task::block_in_place(work),
    }
}
