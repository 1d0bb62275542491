//! Tokens beside a service that may be running: for the subcommand that lists and makes them.

use sqlx::{ConnectOptions, SqliteConnection};

use super::cells::ACCESS_CELL;
use super::changes::batch_of;
use super::open::{connect_options, last_id, migrate, open_to_write};
use super::postgres;
use super::sqlite::checksum::{Summing, settle};
use super::sqlite::writer::waiting_for_disk;
use super::sqlite::{lock, private};
use super::tables::access;
use crate::core::access::Token;
use crate::core::id::Id;
use crate::core::time::UtcMicros;
use crate::store::{AccessChanges, Cells, Changes, IdSource, Options, Result, Store, StoreError, Writer};

/// A database beside the service that may be serving it: for commands that read tokens or write one row.
#[derive(Debug)]
pub struct TokenDatabase(TokenBackend);

#[derive(Debug)]
enum TokenBackend {
    File { reading: Box<SqliteConnection>, writing: Box<Summing>, ids: IdSource },
    Server { store: Store, writer: Box<Writer> },
}

impl TokenDatabase {
    /// Opens the database; where no service holds it, creates it and brings its schema up to date first.
    pub async fn open(options: &Options) -> Result<Self> {
        if options.is_server() {
            let (store, mut writer) = postgres::open::open_beside(options).await?;
            writer.lock_cells(&Cells::from([ACCESS_CELL])).await?;
            return Ok(Self(TokenBackend::Server { store, writer: Box::new(writer) }));
        }
        let connect = connect_options(options)?;
        let file = connect.get_filename().to_owned();
        let lock = match lock::take(&file) {
            Err(StoreError::InUse(_)) => None,
            taken => Some(taken?),
        };
        private::make(&file);
        let mut reading = connect.connect().await?;
        if lock.is_some() {
            migrate(&mut reading).await?;
        }
        let ids = IdSource::after(last_id(&mut reading).await?);
        let writing = open_to_write(&file, options)?;
        if lock.is_some() {
            settle(&writing)?;
        }
        let writing = Summing::over(writing)?;
        Ok(Self(TokenBackend::File { reading: Box::new(reading), writing: Box::new(writing), ids }))
    }

    pub async fn tokens(&mut self) -> Result<Vec<Token>> {
        match &mut self.0 {
            TokenBackend::File { reading, .. } => access::tokens_of(reading).await,
            TokenBackend::Server { store, .. } => access::tokens(store).await,
        }
    }

    pub fn next_id(&mut self, now: UtcMicros) -> Id {
        match &mut self.0 {
            TokenBackend::File { ids, .. } => ids.next(now),
            TokenBackend::Server { writer, .. } => writer.next_id(now),
        }
    }

    /// Writes in one transaction; on disk when this returns.
    ///
    /// # Errors
    /// [`StoreError`]; then nothing is written, but see [`crate::store::Writer::commit`].
    pub async fn commit(&mut self, access: AccessChanges) -> Result<()> {
        let changes = Changes { access, ..Changes::default() };
        match &mut self.0 {
            TokenBackend::File { writing, .. } => waiting_for_disk(|| batch_of(&changes).commit(writing)),
            TokenBackend::Server { writer, .. } => writer.commit(&changes).await,
        }
    }
}
