//! The writing side: one connection, one transaction a group.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::Mutex;
use tokio::task::JoinHandle;

use super::postgres::CellWriter;
use super::sqlite::writer::{FileWriter, waiting_for_disk};
use crate::core::id::Id;
use crate::core::time::UtcMicros;
use crate::store::{Cells, Changes, IdSource, RemoteChanges, Result};

/// Who writes: of a file the only one, of a database server one of many.
#[derive(Debug)]
pub struct Writer {
    ids: IdSource,
    engine: Engine,
}

#[derive(Debug)]
enum Engine {
    File(Arc<Mutex<FileWriter>>),
    Server(Box<CellWriter>),
}

impl Writer {
    /// Of a database in a file, which no other process writes.
    pub(super) fn of_file(ids: IdSource, writer: FileWriter) -> Self {
        Self { ids, engine: Engine::File(Arc::new(Mutex::new(writer))) }
    }

    /// Of a database that other processes may write as well.
    pub(super) fn of_server(writer: CellWriter) -> Self {
        Self { ids: IdSource::after(0), engine: Engine::Server(Box::new(writer)) }
    }

    /// Another writer on the same database; none where there can be but one.
    pub fn another(&self) -> Option<Self> {
        match &self.engine {
            Engine::File(_) => None,
            Engine::Server(writer) => Some(Self::of_server(writer.another())),
        }
    }

    /// Whether others may write too, so that what is written has to be held.
    pub fn is_one_of_many(&self) -> bool {
        matches!(self.engine, Engine::Server(_))
    }

    /// An identifier greater than every one before in what is held. To be asked during a turn.
    pub fn next_id(&mut self, now: UtcMicros) -> Id {
        self.ids.next(now)
    }

    /// Where identifiers come from, for who needs nothing else of the writer. To be asked during a turn.
    pub fn ids(&mut self) -> &mut IdSource {
        &mut self.ids
    }

    /// From here to [`Writer::commit`] or [`Writer::give_back`] nobody else writes what is at home in `cells`: what is
    /// read of it is what holds when this is committed. Says what others have written since these cells were held
    /// last; names that are at home in them are known.
    pub async fn lock_cells(&mut self, cells: &Cells) -> Result<RemoteChanges> {
        match &mut self.engine {
            Engine::File(_) => Ok(RemoteChanges::default()),
            Engine::Server(writer) => {
                let (remote_changes, ids) = writer.lock_cells(cells).await?;
                self.ids = ids;
                Ok(remote_changes)
            }
        }
    }

    /// Ends a turn in which nothing was committed; otherwise does nothing.
    pub async fn give_back(&mut self) {
        if let Engine::Server(writer) = &mut self.engine {
            writer.give_back().await;
        }
    }

    /// Writes all changes in one transaction, and ends the turn; they are on disk when this returns. After an error
    /// nothing is stored; only after [`crate::store::StoreError::Unanswered`] that is not known.
    ///
    /// # Errors
    /// After [`crate::store::StoreError::NotDurable`] every later commit fails alike.
    pub async fn commit(&mut self, changes: &Changes) -> Result<()> {
        match &mut self.engine {
            Engine::File(writer) => {
                let mut writer = writer.lock().await;
                waiting_for_disk(|| writer.commit(changes))
            }
            Engine::Server(writer) => writer.commit(changes, self.ids.last()).await,
        }
    }

    /// A way to commit as [`Writer::commit`] does, on a thread of its own; none where servers take turns, and each
    /// transaction needs its own.
    pub fn committer(&self) -> Option<Committer> {
        match &self.engine {
            Engine::File(writer) => Some(Committer(Arc::clone(writer))),
            Engine::Server(_) => None,
        }
    }

    /// Whether writing works.
    pub async fn probe(&mut self) -> Result<()> {
        match &mut self.engine {
            Engine::File(writer) => {
                let mut writer = writer.lock().await;
                waiting_for_disk(|| writer.probe())
            }
            Engine::Server(writer) => writer.probe().await,
        }
    }

    /// Ends writing in order; nothing is being written beside any more.
    ///
    /// # Errors
    /// Where the end is not in order; what was committed is stored all the same.
    pub async fn close(self) -> Result<()> {
        match self.engine {
            Engine::File(writer) => {
                let writer = Arc::into_inner(writer).expect("commits beside have been waited for");
                waiting_for_disk(|| writer.into_inner().close())
            }
            Engine::Server(writer) => writer.close().await,
        }
    }
}

/// A way to commit while the writer makes ready what comes next.
#[derive(Debug)]
pub struct Committer(Arc<Mutex<FileWriter>>);

/// What has become of changes that were written beside.
#[derive(Debug)]
pub struct Written {
    pub changes: Changes,
    /// As of [`Writer::commit`].
    pub outcome: Result<()>,
    pub took: Duration,
}

impl Committer {
    /// Begins to write `changes`. Nothing else may be under way; what is asked of the writer meanwhile waits.
    pub fn commit(self, changes: Changes) -> JoinHandle<Written> {
        let mut writer = self.0.try_lock_owned().expect("what was under way before has been waited for");
        tokio::task::spawn_blocking(move || {
            let begun = Instant::now();
            let outcome = writer.commit(&changes);
            Written { changes, outcome, took: begun.elapsed() }
        })
    }
}
