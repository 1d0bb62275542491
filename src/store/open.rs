//! Opening the database: connect options, migrations, the names in memory.

use std::path::Path;
use std::str::FromStr;

use rusqlite::OpenFlags;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions};
use sqlx::{AssertSqlSafe, ConnectOptions, Connection, SqliteConnection};

use super::db::{MigrationFile, Readers, migrations, migrator};
use super::name_tables::Names;
use super::postgres;
use crate::message;
use crate::store::sqlite::checkpoint::Checkpoints;
use crate::store::sqlite::checksum::{Summing, settle};
use crate::store::sqlite::flush_failure::FlushFailure;
use crate::store::sqlite::write_behind::WriteBehind;
use crate::store::sqlite::writer::{FileWriter, waiting_for_disk};
use crate::store::sqlite::{lock, private};
use crate::store::tables::hook;
use crate::store::{Changes, IdSource, Options, Result, Store, StoreError, Table, Tables, Writer, all_cells};

/// Every migration ever shipped, oldest first; a shipped one is never edited.
pub(super) const MIGRATIONS: [MigrationFile; 30] = migrations! {
    "sqlite":
    "0001_history" "0002_alerts" "0003_models" "0004_corrections" "0005_access" "0006_history_log"
    "0007_diagnoses" "0008_fixed_baselines" "0009_diagnosis_jobs" "0010_shared_limits" "0011_calendar"
    "0012_alerts_found_late" "0013_notes" "0014_environmental_tests" "0015_senders" "0016_checksums"
    "0017_head" "0018_outlook" "0019_gyro_attributes" "0020_record_temperature" "0021_station_alerts"
    "0022_hypotheses" "0023_packed_texts" "0024_imu_alerts" "0025_gyro_history" "0026_scale"
    "0027_suspect_windows" "0028_bounded_lists" "0029_imu_order" "0030_long_texts"
};

/// Opens the database, creates it if there is none, and brings its schema up to date.
///
/// # Errors
/// [`StoreError`] where the file cannot be opened, is served by another process, is no database, or holds a schema
/// newer than this program.
pub async fn open(options: &Options) -> Result<(Store, Writer)> {
    if options.is_server() { postgres::open::open(options).await } else { open_file(options).await }
}

/// Encrypts secrets of hooks that were stored before there was a key; says of how many hooks.
///
/// # Errors
/// [`StoreError::Key`] where something is encrypted, and not with this key.
pub async fn hide_stored_secrets(store: &Store, writer: &mut Writer) -> Result<usize> {
    writer.lock_cells(&all_cells()).await?;
    let hidden = hide_in_turn(store, writer).await;
    writer.give_back().await;
    hidden
}

async fn hide_in_turn(store: &Store, writer: &mut Writer) -> Result<usize> {
    let mut hooks = Vec::new();
    for mut hook in hook::stored(store).await? {
        hook.clone().show(&store.secrets)?;
        if hook.hide(&store.secrets)? {
            hooks.push(hook);
        }
    }
    let count = hooks.len();
    if count > 0 {
        writer.commit(&Changes { hooks, ..Changes::default() }).await?;
    }
    Ok(count)
}

async fn open_file(options: &Options) -> Result<(Store, Writer)> {
    let connect = connect_options(options)?;
    let file = connect.get_filename().to_owned();
    let lock = lock::take(&file)?;
    private::make(&file);
    let mut connection = connect.clone().connect().await?;
    check_structure(&mut connection).await?;
    migrate(&mut connection).await?;
    let names = Names::new(load_names(&mut connection).await?);
    let write_behind = WriteBehind::load(&mut connection).await?;
    let last_id = last_id(&mut connection).await?;
    let (writing, checkpointing) = (open_to_write(&file, options)?, open_to_write(&file, options)?);
    settle(&writing)?;
    let writing = Summing::over(writing)?;
    // Not sooner: where the last connection is closed, SQLite copies the log by itself.
    connection.close().await?;
    // Never idle-closed: a reader's warm page cache is what makes reading fast.
    let readers = SqlitePoolOptions::new()
        .min_connections(1)
        .max_connections(options.readers.max(1))
        .idle_timeout(None)
        .max_lifetime(None)
        .connect_with(connect.read_only(true).create_if_missing(false))
        .await?;
    let store = Store::new(Readers::Sqlite(readers, file), names.clone(), write_behind.clone());
    let flush_failure = FlushFailure::default();
    let mut checkpoints = Checkpoints::start(checkpointing, options.checkpoint_pages, flush_failure.clone())?;
    match flush_failure.record(waiting_for_disk(|| checkpoints.begin(&writing))) {
        // Reading goes on; a write tries it again.
        Err(StoreError::Full) => tracing::warn!("the disk is full: the write-ahead log stays as it was left"),
        copied => copied?,
    }
    let writer = FileWriter::new(writing, names, write_behind, checkpoints, flush_failure, lock);
    Ok((store, Writer::of_file(IdSource::after(last_id), writer)))
}

/// Up to this size a file is looked through at the start, at some hundred MiB a second; `gyrowatch verify` looks
/// through any.
const LOOKED_THROUGH: i64 = 256 << 20;

/// A row out of the order of its key is not found, and neither may be those beside it: no checksum tells, for they are
/// not read.
async fn check_structure(connection: &mut SqliteConnection) -> Result<()> {
    let size = "SELECT page_count * page_size FROM pragma_page_count, pragma_page_size";
    if sqlx::query_scalar::<_, i64>(size).fetch_one(&mut *connection).await? > LOOKED_THROUGH {
        return Ok(());
    }
    finds_nothing(connection, "PRAGMA quick_check(3)").await
}

/// What a check of SQLite's own finds wrong with the file is said as it says it.
pub(super) async fn finds_nothing(connection: &mut SqliteConnection, check: &'static str) -> Result<()> {
    let found: Vec<String> = sqlx::query_scalar(check).fetch_all(connection).await?;
    if found == ["ok"] { Ok(()) } else { Err(StoreError::damaged(found.join("; "))) }
}

/// WAL with `synchronous = FULL`: the log is on disk before a commit returns. Checkpoints are made by
/// [`Writer`]'s second connection, off the committing path, so the automatic ones are switched off.
pub(super) fn connect_options(options: &Options) -> Result<SqliteConnectOptions> {
    refuse_parameters(&options.url)?;
    let connect = SqliteConnectOptions::from_str(&options.url)?
        .create_if_missing(true)
        .journal_mode(SqliteJournalMode::Wal)
        .busy_timeout(options.busy_timeout)
        .statement_cache_capacity(STATEMENTS)
        .row_buffer_size(1024)
        .disable_statement_logging();
    Ok(pragmas(options).into_iter().fold(connect, |connect, (name, value)| connect.pragma(name, value)))
}

/// Prepared statements that a connection keeps.
const STATEMENTS: usize = 256;

/// How every connection works, besides the journal's mode, which stands in the file.
fn pragmas(options: &Options) -> [(&'static str, String); 5] {
    [
        ("synchronous", "FULL".to_owned()),
        ("foreign_keys", "ON".to_owned()),
        ("cache_size", format!("-{}", options.cache_kib)),
        ("wal_autocheckpoint", "0".to_owned()),
        ("temp_store", "MEMORY".to_owned()),
    ]
}

/// Those who write open the file by its name: a parameter that only those who read would heed is refused.
fn refuse_parameters(url: &str) -> Result<()> {
    let (_, parameters) = url.split_once('?').unwrap_or_default();
    let other = parameters.split('&').find(|parameter| !matches!(*parameter, "" | "mode=rw" | "mode=rwc"));
    other.map_or(Ok(()), |other| Err(StoreError::File(message!("address_parameter", parameter = other.to_owned()))))
}

/// As [`connect_options`], of a connection that the calling thread itself works on.
pub(super) fn open_to_write(file: &Path, options: &Options) -> Result<rusqlite::Connection> {
    let mut flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX | OpenFlags::SQLITE_OPEN_URI;
    if private::is_in_memory(file) {
        flags |= OpenFlags::SQLITE_OPEN_MEMORY | OpenFlags::SQLITE_OPEN_SHARED_CACHE;
    }
    let connection = rusqlite::Connection::open_with_flags(file, flags)?;
    connection.busy_timeout(options.busy_timeout)?;
    connection.set_prepared_statement_cache_capacity(STATEMENTS);
    for (name, value) in pragmas(options) {
        connection.execute_batch(&format!("PRAGMA {name} = {value}"))?;
    }
    Ok(connection)
}

/// Brings the schema up to date.
pub(super) async fn migrate(connection: &mut SqliteConnection) -> Result<()> {
    migrator(&MIGRATIONS).run(connection).await.map_err(|error| match error {
        sqlx::migrate::MigrateError::Execute(error) => error.into(),
        other => StoreError::other(other),
    })
}

pub(super) async fn load_names(connection: &mut SqliteConnection) -> Result<Tables> {
    Ok(Tables {
        imus: load_table(connection, "imu", "name").await?,
        stations: load_table(connection, "station", "name").await?,
        gyros: load_table(connection, "gyro", "serial").await?,
        ..Tables::default()
    })
}

/// Thousands in one row: of 10^5 names a row each would take most of a start.
async fn load_table(connection: &mut SqliteConnection, from: &str, column: &str) -> Result<Table> {
    let sql = format!(
        "SELECT json_group_array(json_array(id, {column}))
         FROM (SELECT id, {column} FROM {from} WHERE id > $1 ORDER BY id LIMIT 10000)"
    );
    let (mut table, mut last) = (Table::default(), -1);
    loop {
        let names = sqlx::query_scalar(AssertSqlSafe(sql.clone())).bind(last).fetch_one(&mut *connection).await?;
        let names: String = names;
        let names: Vec<(u32, String)> =
            serde_json::from_str(&names).map_err(|error| StoreError::damaged(format_args!("names: {error}")))?;
        let Some((number, _)) = names.last() else { return Ok(table) };
        last = i64::from(*number);
        for (number, name) in names {
            if !table.add(number, 0, &name) {
                return Err(StoreError::damaged(format_args!("`{name}` has more than one number")));
            }
        }
    }
}

pub(super) async fn last_id(connection: &mut SqliteConnection) -> Result<i64> {
    let tables = "record bench_result event alert alert_step hook delivery imu_model token session audit diagnosis_job";
    let newest = tables.split(' ').map(|table| format!("coalesce((SELECT max(id) FROM {table}), 0)"));
    let sql = AssertSqlSafe(format!("SELECT max({})", newest.collect::<Vec<_>>().join(", ")));
    Ok(sqlx::query_scalar(sql).fetch_one(connection).await?)
}
