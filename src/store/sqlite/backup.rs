//! Copies of the database: made while it is served, and checked before they count.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use sqlx::sqlite::{SqliteConnectOptions, SqlitePoolOptions};
use sqlx::{ConnectOptions, Connection, SqliteConnection, SqlitePool};

use super::lock::beside;
use super::{checksum, private};
use crate::core::id::Id;
use crate::core::message::{Message, list, text};
use crate::core::time::Span;
use crate::message;
use crate::store::db::{Readers, newest_of};
use crate::store::name_tables::Names;
use crate::store::open::{MIGRATIONS, connect_options, finds_nothing, load_names, migrate};
use crate::store::sqlite::write_behind::WriteBehind;
use crate::store::{self, postgres};
use crate::store::{Options, Result, Store, StoreError};
use crate::system::{fill_random, sha256};

impl Options {
    /// The file that the address names.
    pub fn file(&self) -> Result<PathBuf> {
        if self.is_server() {
            return Err(StoreError::File(message!("file_of_server", database = self.shown())));
        }
        Ok(connect_options(self)?.get_filename().to_owned())
    }
}

/// What a checked file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BackupContents {
    pub gyros: usize,
    pub records: usize,
    /// Rows of the gyros' histories.
    pub figures: usize,
    pub bench_results: usize,
}

/// Copies the database as it stands at one instant into `target`, served or not, and checks the copy.
///
/// # Errors
/// [`StoreError`] where `target` exists, a file cannot be read or written, or the copy does not pass [`check`]; then
/// there is no `target`.
pub async fn backup(options: &Options, target: &Path) -> Result<BackupContents> {
    let source = options.file()?;
    let mut source = reading(&source).busy_timeout(options.busy_timeout).connect().await?;
    placed(target, async |part: &Path| {
        let into = part.to_str().ok_or_else(|| wrong(part, message!("file_name_not_utf8")))?;
        sqlx::query("VACUUM INTO $1").bind(into).execute(&mut source).await?;
        Ok(())
    })
    .await
}

/// Copies a backup to where the configured database is to be, and checks the copy.
pub async fn restore(file: &Path, options: &Options) -> Result<BackupContents> {
    let target = options.file()?;
    placed(&target, async |part: &Path| copy(file, part).map_err(|error| failed(file, &error))).await
}

/// Copies the bytes alone, and not who may read them.
fn copy(file: &Path, to: &Path) -> io::Result<()> {
    io::copy(&mut File::open(file)?, &mut File::options().write(true).open(to)?)?;
    Ok(())
}

/// Lets `write` fill an empty file beside `target`, checks it, and gives it its name once it is on disk.
async fn placed(target: &Path, write: impl AsyncFnOnce(&Path) -> Result<()>) -> Result<BackupContents> {
    // Takes the name, so that nothing that comes up meanwhile is overwritten.
    private::create(target).map_err(|error| failed(target, &error))?;
    let part = beside(target, ".part");
    let finished = async {
        private::create(&part).map_err(|error| failed(&part, &error))?;
        write(&part).await?;
        let contents = check(&part).await?;
        File::open(&part).and_then(|file| file.sync_all()).map_err(|error| failed(&part, &error))?;
        fs::rename(&part, target).map_err(|error| failed(target, &error))?;
        let directory = target.parent().filter(|dir| !dir.as_os_str().is_empty()).unwrap_or(Path::new("."));
        File::open(directory).and_then(|dir| dir.sync_all()).map_err(|error| failed(directory, &error))?;
        Ok(contents)
    }
    .await;
    if finished.is_err() {
        for leftover in [&part, target] {
            let _may_not_be_there = fs::remove_file(leftover);
        }
    }
    finished
}

/// Reads everything: SQLite's structure and references, each IMU's calendar, every record's and bench result's hash,
/// every stored figure's and verdict's checksum, the checksum of every table.
///
/// # Errors
/// [`StoreError::Damaged`] naming the first thing that is not as it was written; [`StoreError::File`] where it is no
/// database of this program.
pub async fn check(file: &Path) -> Result<BackupContents> {
    let contents = read_through(file, true).await?;
    match checksum::check(file)? {
        faults if faults.is_empty() => Ok(contents),
        faults => Err(StoreError::Damaged(message!("damages", faults = list(faults)))),
    }
}

/// Reads every table and says of which the rows are not those that were written. On a server nothing: see [`checksum`].
pub fn check_checksums(options: &Options) -> Result<Vec<Message>> {
    if options.is_server() { Ok(Vec::new()) } else { checksum::check(&options.file()?) }
}

/// As [`check`], without the records: for those who read each of them anyway.
pub async fn check_all_but_records(options: &Options) -> Result<()> {
    if options.is_server() {
        let store = postgres::open::open_to_read(options).await?;
        contents(&store, false).await?;
        store.close().await;
        return Ok(());
    }
    read_through(&options.file()?, false).await.map(|_| ())
}

async fn read_through(file: &Path, records: bool) -> Result<BackupContents> {
    // SQLite says of what is not there only that it cannot be opened.
    if !fs::exists(file).map_err(|error| failed(file, &error))? {
        return Err(StoreError::File(message!("file_absent")));
    }
    let version = {
        let mut connection = reading(file).connect().await?;
        structure(&mut connection).await?;
        let version = schema(&mut connection, file).await?;
        connection.close().await?;
        version
    };
    if version == newest_version() {
        return read_tables(file, records).await;
    }
    // As it will be once a service is started on it.
    let mut drawn = [0; 8];
    fill_random(&mut drawn).map_err(StoreError::other)?;
    let migrated = std::env::temp_dir().join(format!("gyrowatch-check-{}.db", hex::encode(drawn)));
    let checked = async {
        private::create(&migrated).and_then(|_| copy(file, &migrated)).map_err(|error| failed(&migrated, &error))?;
        let mut connection =
            SqliteConnectOptions::new().filename(&migrated).disable_statement_logging().connect().await?;
        migrate(&mut connection).await?;
        connection.close().await?;
        read_tables(&migrated, records).await
    }
    .await;
    let _may_not_be_there = fs::remove_file(&migrated);
    checked
}

async fn read_tables(file: &Path, records: bool) -> Result<BackupContents> {
    let readers = SqlitePoolOptions::new().max_connections(1).connect_with(reading(file)).await?;
    check_calendar(&readers).await?;
    let store = store_of(readers, file).await?;
    let contents = contents(&store, records).await;
    store.close().await;
    contents
}

/// Opens a database, served or not, for reading alone, as it stands now: what is written meanwhile is not seen.
///
/// # Errors
/// [`StoreError::File`] where its schema is not of this version of the program.
pub async fn open_to_read(options: &Options) -> Result<Store> {
    if options.is_server() {
        return postgres::open::open_to_read(options).await;
    }
    let file = options.file()?;
    let connect = reading(&file).busy_timeout(options.busy_timeout);
    // One connection, inside one transaction for as long as it lives.
    let one = SqlitePoolOptions::new().max_connections(1).idle_timeout(None).max_lifetime(None);
    let readers = one.connect_with(connect).await?;
    {
        let mut connection = readers.acquire().await?;
        sqlx::query("BEGIN").execute(&mut *connection).await?;
        check_schema(&mut connection, &file).await?;
    }
    store_of(readers, &file).await
}

/// What `readers`, of which there is one, see.
async fn store_of(readers: SqlitePool, file: &Path) -> Result<Store> {
    let mut connection = readers.acquire().await?;
    let names = Names::new(load_names(&mut connection).await?);
    let write_behind = WriteBehind::load(&mut connection).await?;
    drop(connection);
    Ok(Store::new(Readers::Sqlite(readers, file.to_owned()), names, write_behind))
}

/// Every record that is said to have been entered stands where its IMU has it, and nothing else does.
async fn check_calendar(readers: &SqlitePool) -> Result<()> {
    let sql = "SELECT (SELECT count(*) FROM calendar), count(*) FILTER (WHERE entered), min(id) FILTER (WHERE NOT entered AND due)
               FROM (SELECT id, id < coalesce((SELECT record FROM calendar_begun), 0) AS due, EXISTS (SELECT 1 FROM calendar
                   WHERE record = held.id AND (imu, calibrated_at, voided) = (held.imu, held.calibrated_at, held.voided)) AS entered
                   FROM record AS held)";
    let (entries, entered, missing): (i64, i64, Option<i64>) = sqlx::query_as(sql).fetch_one(readers).await?;
    if let Some(record) = missing {
        return Err(of_record(Id(record), message!("record_elsewhere")));
    }
    if entries != entered {
        return Err(StoreError::Damaged(message!("calendar_entries", count = text(entries - entered))));
    }
    Ok(())
}

async fn structure(connection: &mut SqliteConnection) -> Result<()> {
    finds_nothing(connection, "PRAGMA integrity_check(3)").await?;
    let dangling: Option<String> =
        sqlx::query_scalar("SELECT \"table\" FROM pragma_foreign_key_check").fetch_optional(connection).await?;
    match dangling {
        None => Ok(()),
        Some(table) => Err(StoreError::Damaged(message!("row_refers_to_none", table))),
    }
}

/// Refuses a file whose schema is not of this version of the program.
pub(crate) async fn check_schema(connection: &mut SqliteConnection, file: &Path) -> Result<()> {
    if schema(connection, file).await? < newest_version() {
        return Err(wrong(file, message!("file_older")));
    }
    Ok(())
}

/// The newest migration that was made.
async fn schema(connection: &mut SqliteConnection, file: &Path) -> Result<Option<i64>> {
    let ours = "SELECT count(*) FROM sqlite_schema WHERE name IN ('_sqlx_migrations', 'record', 'history')";
    if sqlx::query_scalar::<_, i64>(ours).fetch_one(&mut *connection).await? != 3 {
        return Err(wrong(file, message!("file_foreign")));
    }
    let version: Option<i64> =
        sqlx::query_scalar("SELECT max(version) FROM _sqlx_migrations").fetch_one(connection).await?;
    if version > newest_version() {
        return Err(wrong(file, message!("file_newer")));
    }
    Ok(version)
}

fn newest_version() -> Option<i64> {
    newest_of(&MIGRATIONS)
}

async fn contents(store: &Store, records: bool) -> Result<BackupContents> {
    let mut contents = BackupContents::default();
    let records = if records { store::record::ids(store).await? } else { Vec::new() };
    for id in records {
        let missing = || of_record(id, message!("in_index_only"));
        let row = store::record::get(store, id).await?.ok_or_else(missing)?;
        if !is_unchanged(&row.body, row.body_sha256) {
            return Err(of_record(id, message!("text_not_as_stored")));
        }
        contents.records += 1;
    }
    let gyros = store.names().read().gyros.numbers();
    for gyro in gyros {
        contents.gyros += 1;
        contents.figures += store::history::oldest(store, gyro, Span::EVER, usize::MAX).await?.len();
        store::history::voided(store, gyro, Span::EVER).await?;
        store::event::of_gyro(store, gyro).await?;
        for row in store::bench::all_of_gyro(store, gyro, Span::EVER).await? {
            if !is_unchanged(&row.body, row.body_sha256) {
                let fault = message!("text_not_as_stored");
                return Err(StoreError::Damaged(message!("fault_of_bench_result", id = text(row.id), fault)));
            }
            contents.bench_results += 1;
        }
    }
    Ok(contents)
}

fn is_unchanged(body: &str, hash: [u8; 32]) -> bool {
    sha256(body.as_bytes()) == hash
}

fn of_record(id: Id, fault: Message) -> StoreError {
    StoreError::Damaged(message!("fault_of_record", id = text(id), fault))
}

/// Reads only, and leaves the journal mode as it is.
fn reading(file: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new().filename(file).read_only(true).disable_statement_logging()
}

fn wrong(file: &Path, why: Message) -> StoreError {
    StoreError::at(&file.display().to_string(), why)
}

fn failed(file: &Path, error: &io::Error) -> StoreError {
    wrong(
        file,
        match error.kind() {
            io::ErrorKind::AlreadyExists => message!("file_there"),
            _ => Message::verbatim(error),
        },
    )
}
