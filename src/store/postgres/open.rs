//! Opening a database on a server: migrations, homes of names, the names in memory.

use std::time::{Duration, Instant};

use sqlx::migrate::MigrateError;
use sqlx::postgres::PgPoolOptions;
use sqlx::{AssertSqlSafe, PgConnection, Row as _};

use super::bounded::{BREATH, COMES_UP, PgReaders};
use super::cell_writer::CellWriter;
use super::hosts::Hosts;
use super::names;
use super::other_servers::OtherServers;
use crate::message;
use crate::store::cells::cell_of;
use crate::store::db::{MigrationFile, Readers, migrations, migrator, newest_of};
use crate::store::name_tables::Names;
use crate::store::sqlite::write_behind::WriteBehind;
use crate::store::{Options, Result, Store, StoreError, Writer};

/// Every migration ever shipped, oldest first; a shipped one is never edited.
const MIGRATIONS: [MigrationFile; 23] = migrations! {
    "postgres":
    "0001_schema" "0002_claims" "0003_shared_limits" "0004_alerts_found_late" "0005_notes"
    "0006_environmental_tests" "0007_senders" "0008_commit_stamps" "0009_head" "0010_cells" "0011_outlook"
    "0012_gyro_attributes" "0013_record_temperature" "0014_station_alerts" "0015_hypotheses"
    "0016_packed_texts" "0017_imu_alerts" "0018_gyro_history" "0019_scale" "0020_suspect_windows"
    "0021_bounded_lists" "0022_imu_order" "0023_long_texts"
};

/// How long who reads everything waits for the next row.
const TO_READ_ALL: Duration = Duration::from_secs(600);

/// Opens the database and brings its schema up to date.
///
/// # Errors
/// [`StoreError`] where it cannot be reached within seconds, or holds a schema newer than this program.
pub(in crate::store) async fn open(options: &Options) -> Result<(Store, Writer)> {
    let (readers, names, writer) = ready(options).await?;
    let (hosts, number) = (Hosts::of(&options.url)?, rand::random_range(1..i64::MAX));
    let other_servers = OtherServers::watch(readers.clone(), hosts, names.clone(), number, options.lease);
    Ok((store_of(readers, names, other_servers), Writer::of_server(writer)))
}

/// As [`open`], to write a row beside the servers: nothing in the background becomes this process's.
pub(in crate::store) async fn open_beside(options: &Options) -> Result<(Store, Writer)> {
    let (readers, names, writer) = ready(options).await?;
    Ok((store_of(readers, names, OtherServers::none()), Writer::of_server(writer)))
}

fn store_of(readers: PgReaders, names: Names, other_servers: OtherServers) -> Store {
    Store::new(Readers::Postgres(readers, other_servers), names, WriteBehind::default())
}

async fn ready(options: &Options) -> Result<(PgReaders, Names, CellWriter)> {
    let hosts = Hosts::of(&options.url)?;
    patiently(async || {
        let mut connection = hosts.reach(options.busy_timeout).await?;
        refuse_shared(&mut connection, &hosts, options.busy_timeout).await?;
        migrate(&mut connection).await?;
        give_homes(&mut connection).await
    })
    .await?;
    let readers = pool(&hosts, options, options.readers, options.lease).await?;
    check_copied(&readers).await?;
    let names = Names::default();
    names::learn_all(&readers, &names).await?;
    let writer = CellWriter::new(hosts, options, readers.clone(), names.clone()).await?;
    Ok((readers, names, writer))
}

/// A pooler between that hands its connections out by the transaction mixes up what is prepared on them.
async fn refuse_shared(one: &mut PgConnection, hosts: &Hosts, patience: Duration) -> Result<()> {
    // Not prepared: a pooler that mixes up what is would answer that.
    let process = async |connection: &mut PgConnection| -> Result<i32> {
        let row = sqlx::raw_sql("SELECT pg_backend_pid()").fetch_one(connection).await?;
        Ok(row.try_get(0)?)
    };
    let mut other = hosts.reach(patience).await?;
    for _ in 0..3 {
        let of_one = process(one).await?;
        sqlx::raw_sql("BEGIN").execute(&mut other).await?;
        let of_other = process(&mut other).await?;
        sqlx::raw_sql("ROLLBACK").execute(&mut other).await?;
        if of_one == of_other {
            return Err(StoreError::File(message!("server_pooled")));
        }
    }
    Ok(())
}

/// Opens the database for reading alone, as it stands now: what is written meanwhile is not seen.
///
/// # Errors
/// [`StoreError::File`] where its schema is not of this version of the program.
pub(in crate::store) async fn open_to_read(options: &Options) -> Result<Store> {
    let readers = pool(&Hosts::of(&options.url)?, options, 1, TO_READ_ALL).await?;
    let names = Names::default();
    {
        let mut connection = readers.pool().acquire().await?;
        // One connection, inside one transaction for as long as it lives.
        sqlx::query("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY").execute(&mut *connection).await?;
        check_schema(&mut connection, options).await?;
    }
    check_copied(&readers).await?;
    names::learn_all(&readers, &names).await?;
    Ok(store_of(readers, names, OtherServers::none()))
}

/// Opens the database to be copied into: its schema as of this program, no service made ready on it.
pub(in crate::store) async fn open_to_copy(options: &Options) -> Result<PgConnection> {
    let mut connection = Hosts::of(&options.url)?.reach(options.busy_timeout).await?;
    migrate(&mut connection).await?;
    Ok(connection)
}

/// A database that is being copied into is nobody's yet.
async fn check_copied(readers: &PgReaders) -> Result<()> {
    let sql = "SELECT count(*) FROM information_schema.tables
               WHERE table_schema = current_schema() AND table_name = 'copying'";
    if sqlx::query_scalar::<_, i64>(sql).fetch_one(readers).await? > 0 {
        return Err(StoreError::File(message!("copy_unfinished")));
    }
    Ok(())
}

async fn check_schema(connection: &mut PgConnection, options: &Options) -> Result<()> {
    let wrong = |why| Err(StoreError::at(&options.shown(), why));
    let ours = "SELECT count(*) FROM information_schema.tables WHERE table_schema = current_schema()
                AND table_name IN ('_sqlx_migrations', 'record', 'cell')";
    if sqlx::query_scalar::<_, i64>(ours).fetch_one(&mut *connection).await? != 3 {
        return wrong(message!("file_foreign"));
    }
    let found: Option<i64> =
        sqlx::query_scalar("SELECT max(version) FROM _sqlx_migrations").fetch_one(connection).await?;
    match found.cmp(&newest_of(&MIGRATIONS)) {
        std::cmp::Ordering::Greater => wrong(message!("file_newer")),
        std::cmp::Ordering::Less => wrong(message!("file_older")),
        std::cmp::Ordering::Equal => Ok(()),
    }
}

async fn pool(hosts: &Hosts, options: &Options, connections: u32, limit: Duration) -> Result<PgReaders> {
    let pool = PgPoolOptions::new()
        .max_connections(connections.max(1))
        .acquire_timeout(options.busy_timeout)
        .idle_timeout(None)
        .max_lifetime(None);
    // Which of them answers is known since the schema was looked at.
    hosts.reach(options.busy_timeout).await?;
    Ok(PgReaders::connect(pool, hosts.last().clone(), limit, hosts.silence.clone()).await?)
}

/// Tries again while the database is coming up, or another server is at the same.
async fn patiently<T>(work: impl AsyncFn() -> Result<T>) -> Result<T> {
    let end = Instant::now() + COMES_UP;
    loop {
        match work().await {
            Err(error @ (StoreError::Unreachable(_) | StoreError::Overtaken(_))) if Instant::now() < end => {
                tracing::info!(%error, "the database does not answer yet; trying again");
                tokio::time::sleep(BREATH).await;
            }
            done => return done,
        }
    }
}

/// Brings the schema up to date. Two servers at it at once hinder each other, and the second tries again.
async fn migrate(connection: &mut PgConnection) -> Result<()> {
    let mut migrator = migrator(&MIGRATIONS);
    // A lock of PostgreSQL's own, which others that speak as it does have not.
    migrator.set_locking(false);
    // What is to be made is there already, or what is to be changed is not any more (class 42): another server's work.
    let is_made = |error: &sqlx::Error| {
        error.as_database_error().and_then(|said| said.code()).is_some_and(|code| code.starts_with("42"))
    };
    migrator.run(connection).await.map_err(|error| match error {
        MigrateError::ExecuteMigration(error, _) if is_made(&error) => StoreError::Overtaken(error.to_string()),
        MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _) => error.into(),
        other => StoreError::other(other),
    })
}

/// Names of one transaction.
const NAMES_AT_ONCE: i64 = 10_000;

/// Which names have none, each with its cell where that is not by its name: of a gyro that of the IMU in which it was
/// first seen; one that only a bench has seen has none.
const WITHOUT_HOME: [(&str, &str); 3] = [
    ("imu", "SELECT id, name, CAST(NULL AS BIGINT) FROM imu WHERE cell IS NULL ORDER BY id LIMIT $1"),
    ("station", "SELECT id, name, CAST(NULL AS BIGINT) FROM station WHERE cell IS NULL ORDER BY id LIMIT $1"),
    (
        "gyro",
        "SELECT gyro.id, gyro.serial, (SELECT imu.cell FROM history JOIN record ON record.id = history.record
             JOIN imu ON imu.id = record.imu WHERE history.gyro = gyro.id ORDER BY history.calibrated_at LIMIT 1)
         FROM gyro WHERE cell IS NULL ORDER BY id LIMIT $1",
    ),
];

/// Gives a cell to every name that has none. Broken off, it goes on where it stopped.
pub(in crate::store) async fn give_homes(connection: &mut PgConnection) -> Result<()> {
    for (table, without) in WITHOUT_HOME {
        let set = format!(
            "UPDATE {table} SET cell = given.cell
             FROM unnest(CAST($1 AS BIGINT[]), CAST($2 AS BIGINT[])) AS given(id, cell) WHERE {table}.id = given.id"
        );
        let mut given = 0;
        loop {
            let found: Vec<(i64, String, Option<i64>)> =
                sqlx::query_as(without).bind(NAMES_AT_ONCE).fetch_all(&mut *connection).await?;
            if found.is_empty() {
                break;
            }
            let cell = |name: &str, cell: Option<i64>| cell.unwrap_or_else(|| i64::from(cell_of(name)));
            let (ids, cells): (Vec<i64>, Vec<i64>) =
                found.into_iter().map(|(id, name, found)| (id, cell(&name, found))).unzip();
            given += ids.len();
            sqlx::query(AssertSqlSafe(set.clone())).bind(ids).bind(cells).execute(&mut *connection).await?;
            tracing::info!(table, given, "names are given the cells in which they are at home");
        }
    }
    Ok(())
}
