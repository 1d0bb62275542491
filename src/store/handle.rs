//! The reading side of a database.

use std::path::Path;
use std::time::Duration;

use super::db::{Readers, on, read};
use super::name_tables::Names;
use super::postgres::hosts::without_password;
use super::sqlite::lock;
use super::sqlite::write_behind::WriteBehind;
use crate::store::{ChangeFeed, LeasedTask, Result, Secrets};

/// Where the database is, and how it is held open.
#[derive(Debug, Clone)]
pub struct Options {
    /// `sqlite://path` or `postgres://user@host/database`.
    pub url: String,
    /// Connections that read at the same time.
    pub readers: u32,
    /// How long a statement waits for a lock of another process.
    pub busy_timeout: Duration,
    /// Page cache of each connection, KiB.
    pub cache_kib: u32,
    /// Pages in the write-ahead log from which on they are copied into the database.
    pub checkpoint_pages: u32,
    /// How long work in the background is a server's own before others may take it over.
    pub lease: Duration,
}

/// The reading side. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Store {
    pub(in crate::store) readers: Readers,
    pub(in crate::store) names: Names,
    pub(in crate::store) write_behind: WriteBehind,
    pub(in crate::store) secrets: Secrets,
}

impl Options {
    /// Whether the address is of a database server.
    pub fn is_server(&self) -> bool {
        self.url.starts_with("postgres://") || self.url.starts_with("postgresql://")
    }

    /// The address without the password, for people to read.
    pub fn shown(&self) -> String {
        without_password(&self.url)
    }
}

impl Store {
    /// Without a key of the hooks' secrets.
    pub(super) fn new(readers: Readers, names: Names, write_behind: WriteBehind) -> Self {
        Self { readers, names, write_behind, secrets: Secrets::default() }
    }

    pub fn names(&self) -> &Names {
        &self.names
    }

    /// Whether the database answers.
    pub async fn ping(&self) -> Result<()> {
        on!(self.readers, db => _ = sqlx::query("SELECT 1").fetch_one(db).await?);
        Ok(())
    }

    /// Bytes on disk: the database, and the write-ahead log beside it where that is a file of its own.
    pub async fn sizes(&self) -> Result<(u64, u64)> {
        match &self.readers {
            Readers::Sqlite(_, file) => {
                let size = |path: &Path| std::fs::metadata(path).map_or(0, |found| found.len());
                Ok((size(file), size(&lock::beside(file, "-wal"))))
            }
            Readers::Postgres(..) => Ok((read!(self, one, "SELECT pg_database_size(current_database())")?, 0)),
        }
    }

    /// Whether something that one server does for all is this one's to do now. Alone on a file, everything is.
    pub fn holds_lease(&self, duty: LeasedTask) -> bool {
        match &self.readers {
            Readers::Sqlite(..) => true,
            Readers::Postgres(_, other_servers) => other_servers.holds_lease(duty),
        }
    }

    /// What is written by any server from now on; none where there can be no other.
    pub fn change_feed(&self) -> Option<ChangeFeed> {
        match &self.readers {
            Readers::Sqlite(..) => None,
            Readers::Postgres(_, other_servers) => Some(other_servers.change_feed()),
        }
    }

    /// With the key of the hooks' secrets.
    #[must_use]
    pub fn with(self, secrets: Secrets) -> Self {
        Self { secrets, ..self }
    }

    /// Waits for reads under way and closes the readers.
    pub async fn close(&self) {
        if let Readers::Postgres(readers, other_servers) = &self.readers {
            other_servers.part(readers).await;
        }
        self.readers.close().await;
    }
}
