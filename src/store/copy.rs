//! A database in a file copied into an empty one on a server: block by block, so that an interrupted copy goes on
//! where it stopped, and compared row by row at the end.

use futures::TryStreamExt;
use sqlx::sqlite::{SqliteConnectOptions, SqliteRow};
use sqlx::{AssertSqlSafe, ConnectOptions, Connection, PgConnection, Row, SqliteConnection};

use super::db::Sql;
use super::error::StoreError;
use super::open::Options;
use super::postgres;
use crate::store::packed::history_row::PACKED_LEN;
use crate::store::sqlite::lock;
use crate::store::sqlite::lock::Lock;
use crate::store::sqlite::write_behind::history_log::Tail;
use crate::system::sha256;

/// Rows of a block, and about how many bytes of them.
const BLOCK_ROWS: usize = 5_000;
const BLOCK_BYTES: usize = 8 << 20;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Whole,
    Real,
    Text,
    Bytes,
}

/// A table: its name, in what order it is read, its columns.
struct Table {
    name: &'static str,
    order: &'static str,
    columns: &'static [(&'static str, Kind)],
}

macro_rules! tables {
    ($($name:literal by $order:literal: $($kind:ident $($column:ident)+),+;)+) => {
        &[$(Table {
            name: $name,
            order: $order,
            columns: &[$($((stringify!($column), Kind::$kind)),+),+],
        }),+]
    };
}

/// Those that are referred to before those that refer to them.
const TABLES: &[Table] = tables! {
    "imu" by "id": Whole id, Text name;
    "station" by "id": Whole id, Text name;
    "gyro" by "id": Whole id, Text serial;
    "gyro_attribute" by "gyro": Whole gyro, Text batch type unit;
    "record" by "id": Whole id kind imu station calibrated_at received_at, Text body, Bytes body_sha256 verdicts, Whole voided, Text notes,
        Whole sent_by, Real temperature_c, Bytes packed;
    "history" by "gyro, calibrated_at": Whole gyro calibrated_at record, Bytes figures;
    "voided_history" by "gyro, calibrated_at, record": Whole gyro calibrated_at record, Bytes figures;
    "bench_result" by "id": Whole id gyro station measured_at, Text method, Real d_i d_s d_i_sd d_s_sd, Whole received_at,
        Text body, Bytes body_sha256, Whole voided sent_by;
    "event" by "id": Whole id gyro at, Text kind reason author, Whole received_at, Real d_i d_i_sd d_s d_s_sd, Whole until, Text test;
    "idempotency_key" by "key": Text key, Whole item, Bytes body_sha256;
    "correction" by "item, replaced_by": Whole item replaced_by at, Text author reason;
    "confirmation" by "record": Whole record at, Text author reason;
    "alert" by "id": Whole id gyro, Text coefficient rule status severity, Whole fired_at resolved_at record_at within told_at,
        Text told_severity acknowledged_by acknowledged_reason, Whole acknowledged_at, Text silenced_by silenced_reason,
        Whole silenced_at silenced_until, Text finding, Whole since hushed_at digest muted_by muted_until
        station inhibited_by;
    "silence" by "id": Whole id, Text serial imu station rule, Whole until, Text author reason, Whole at ended_at,
        Text ended_by ended_reason;
    "alert_step" by "id": Whole id alert at, Text action, Whole told, Text author reason body;
    "hook" by "id": Whole id, Text name kind url authorization secret old_secret, Whole old_secret_until, Text filter,
        Whole enabled, Text disabled_because, Whole created_at changed_at deleted_at batch, Text expect;
    "hook_heard" by "hook, alert": Whole hook alert, Text severity;
    "delivery" by "id": Whole id hook step alert queued_at, Text state, Whole due_at attempts first_attempt_at finished_at,
        Text action digest;
    "delivery_part" by "delivery, place": Whole delivery place hook alert, Text action, Whole step, Text body;
    "delivery_attempt" by "delivery, id": Whole delivery id at status, Text detail, Whole took_us, Text answer;
    "imu_model" by "id": Whole id imu adopted_at, Text author reason body;
    "campaign_model" by "record": Whole record model;
    "hypothesis" by "id": Whole id, Text body author reason, Whole added_at ended_at;
    "diagnosis" by "record": Whole record model, Text program, Whole refused, Text body, Bytes packed;
    "diagnosis_job" by "id": Whole id asked_at, Text asked_by asked, Whole canceled begun_at ended_at;
    "diagnosis_task" by "job, record": Whole job record, Text state reason;
    "diagnosis_gist" by "record": Whole record imu station measured_at, Text program gist;
    "token" by "id": Whole id, Text name role station, Bytes secret_sha256, Whole created_at expires_at revoked_at;
    "session" by "id": Whole id token, Bytes secret_sha256, Whole began_at expires_at;
    "audit" by "id": Whole id at, Text who, Whole token, Text source action subject before after agent;
};

impl Table {
    /// Every column, in quotation marks: some are words of SQL.
    fn columns(&self) -> String {
        let quoted: Vec<String> = self.columns.iter().map(|(name, _)| format!("\"{name}\"")).collect();
        quoted.join(", ")
    }

    /// Reads the table on either side; on SQLite the history is that of the table and of what waits before it.
    fn select(&self, from: Sql) -> String {
        let (columns, order) = (self.columns(), self.order);
        let source = if self.name == "history" { from.sqlite } else { self.name };
        format!("SELECT {columns} FROM {source} ORDER BY {order}")
    }

    fn insert(&self) -> String {
        let arrays = self.columns.iter().zip(1..).map(|((_, kind), place)| match kind {
            Kind::Whole => format!("CAST(${place} AS BIGINT[])"),
            Kind::Real => format!("CAST(${place} AS DOUBLE PRECISION[])"),
            Kind::Text => format!("CAST(${place} AS TEXT[])"),
            Kind::Bytes => format!("CAST(${place} AS BYTEA[])"),
        });
        let arrays: Vec<String> = arrays.collect();
        format!("INSERT INTO {} ({}) SELECT * FROM unnest({})", self.name, self.columns(), arrays.join(", "))
    }
}

/// How a table compares on the two sides.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Copied {
    pub table: &'static str,
    /// Rows in the file, and on the server.
    pub rows: [u64; 2],
    /// Of all rows together, whatever their order.
    pub checksums: [u128; 2],
}

impl Copied {
    pub fn is_whole(&self) -> bool {
        self.rows[0] == self.rows[1] && self.checksums[0] == self.checksums[1]
    }
}

/// Copies the database in a file into an empty one on a server, or goes on with that, and compares both. `each` hears
/// of every block: the table, and how many of its rows are there.
///
/// # Errors
/// [`StoreError`]: a file that is served, a server that holds other data. What was copied before stays, and the next
/// call goes on.
pub async fn copy(
    from: &Options,
    to: &Options,
    mut each: impl FnMut(&'static str, u64),
) -> Result<Vec<Copied>, StoreError> {
    if from.is_server() || !to.is_server() {
        return Err(StoreError::File("a copy goes from sqlite:// to postgres://".to_owned()));
    }
    let (mut source, _lock) = open_source(from).await?;
    let mut target = postgres::open_to_copy(to).await?;
    claim(&mut target, &from.file()?.display().to_string()).await?;
    for table in TABLES {
        copy_table(table, &mut source, &mut target, &mut each).await?;
    }
    let mut compared = Vec::with_capacity(TABLES.len());
    for table in TABLES {
        let (rows, checksum) = source_sum(table, &mut source).await?;
        let (found, of_found) = target_sum(table, &mut target).await?;
        compared.push(Copied { table: table.name, rows: [rows, found], checksums: [checksum, of_found] });
    }
    if compared.iter().all(Copied::is_whole) {
        release(&mut target).await?;
    }
    Ok(compared)
}

/// The file, which nobody serves meanwhile, with what waits before its history at hand.
async fn open_source(from: &Options) -> Result<(SqliteConnection, Lock), StoreError> {
    let file = from.file()?;
    let lock = lock::take(&file)?;
    let connect = SqliteConnectOptions::new().filename(&file).read_only(true).disable_statement_logging();
    let mut source = connect.connect().await?;
    crate::store::sqlite::backup::check_schema(&mut source, &file).await?;
    let tail = Tail::load(&mut source).await?;
    let create =
        "CREATE TEMP TABLE waiting (gyro INTEGER NOT NULL, calibrated_at INTEGER NOT NULL, record INTEGER NOT NULL,
                      figures BLOB NOT NULL, PRIMARY KEY (gyro, calibrated_at)) STRICT, WITHOUT ROWID";
    sqlx::query(create).execute(&mut source).await?;
    for (gyro, figures) in tail.rows() {
        let mut packed = Vec::with_capacity(PACKED_LEN);
        figures.pack(gyro, &mut packed);
        sqlx::query("INSERT INTO waiting VALUES ($1, $2, $3, $4)")
            .bind(i64::from(gyro))
            .bind(figures.at.0)
            .bind(figures.record.0)
            .bind(packed)
            .execute(&mut source)
            .await?;
    }
    Ok((source, lock))
}

/// The history with what waits before it.
const HISTORY: Sql = Sql::of_sqlite(
    "(SELECT * FROM history WHERE NOT EXISTS (SELECT 1 FROM waiting
          WHERE waiting.gyro = history.gyro AND waiting.calibrated_at = history.calibrated_at)
      UNION ALL SELECT * FROM waiting)",
);

/// Takes an empty database, or one into which the same file was being copied.
async fn claim(target: &mut PgConnection, source: &str) -> Result<(), StoreError> {
    sqlx::query(
        "CREATE TABLE IF NOT EXISTS copying (name TEXT PRIMARY KEY, rows BIGINT NOT NULL, source TEXT NOT NULL)",
    )
    .execute(&mut *target)
    .await?;
    let begun: Option<String> =
        sqlx::query_scalar("SELECT source FROM copying WHERE name = ''").fetch_optional(&mut *target).await?;
    match begun {
        Some(begun) if begun == source => return Ok(()),
        Some(other) => {
            let why = format!("the database holds a part of {other}: go on with that, or begin with an empty one");
            return Err(StoreError::File(why));
        }
        None => {}
    }
    for table in TABLES {
        let any = AssertSqlSafe(format!("SELECT count(*) FROM (SELECT 1 FROM {} LIMIT 1) AS chosen", table.name));
        if sqlx::query_scalar::<_, i64>(any).fetch_one(&mut *target).await? > 0 {
            release_mark(target).await?;
            return Err(StoreError::File(format!("the database is not empty: there are rows in {}", table.name)));
        }
    }
    sqlx::query("INSERT INTO copying VALUES ('', 0, $1)").bind(source).execute(target).await?;
    Ok(())
}

async fn release_mark(target: &mut PgConnection) -> Result<(), StoreError> {
    sqlx::query("DROP TABLE copying").execute(target).await?;
    Ok(())
}

/// Opens the copy to servers: identifiers go on after the greatest.
async fn release(target: &mut PgConnection) -> Result<(), StoreError> {
    let newest = TABLES.iter().filter(|table| table.columns[0].0 == "id" && !NAMES.contains(&table.name));
    let newest: Vec<String> =
        newest.map(|table| format!("coalesce((SELECT max(id) FROM {}), 0)", table.name)).collect();
    let sql = format!(
        "UPDATE cell SET stamp = $1, names = $1, settings = $1, outbox = $1, models = $1, diagnoses = $1, access = $1,
             last_id = greatest({})",
        newest.join(", ")
    );
    let mut whole = target.begin().await?;
    let stamp = rand::random_range(1..i64::MAX);
    sqlx::query(AssertSqlSafe(sql)).bind(stamp).execute(&mut *whole).await?;
    release_mark(&mut whole).await?;
    Ok(whole.commit().await?)
}

/// Their numbers are not among the identifiers.
const NAMES: [&str; 3] = ["imu", "station", "gyro"];

async fn copy_table(
    table: &Table,
    source: &mut SqliteConnection,
    target: &mut PgConnection,
    each: &mut impl FnMut(&'static str, u64),
) -> Result<(), StoreError> {
    let done: Option<i64> = sqlx::query_scalar("SELECT rows FROM copying WHERE name = $1")
        .bind(table.name)
        .fetch_optional(&mut *target)
        .await?;
    let mut done = done.unwrap_or(0);
    let sql = AssertSqlSafe(format!("{} LIMIT -1 OFFSET $1", table.select(HISTORY)));
    let mut rows = sqlx::query(sql).bind(done).fetch(source);
    let (mut block, mut bytes) = (Vec::new(), 0);
    loop {
        let row = rows.try_next().await?;
        let ended = row.is_none();
        if let Some(row) = row {
            bytes += size(table, &row)?;
            block.push(row);
        }
        if !block.is_empty() && (ended || block.len() == BLOCK_ROWS || bytes >= BLOCK_BYTES) {
            done += block.len() as i64;
            put(table, &block, done, target).await?;
            each(table.name, done.unsigned_abs());
            block.clear();
            bytes = 0;
        }
        if ended {
            return Ok(());
        }
    }
}

fn size(table: &Table, row: &SqliteRow) -> Result<usize, sqlx::Error> {
    let mut size = 0;
    for (place, (_, kind)) in table.columns.iter().enumerate() {
        size += match kind {
            Kind::Text => row.try_get::<Option<&str>, _>(place)?.map_or(0, str::len),
            Kind::Bytes => row.try_get::<Option<&[u8]>, _>(place)?.map_or(0, <[u8]>::len),
            Kind::Whole | Kind::Real => 8,
        };
    }
    Ok(size)
}

/// One transaction: the rows, and how many there are now.
async fn put(table: &Table, rows: &[SqliteRow], done: i64, target: &mut PgConnection) -> Result<(), StoreError> {
    let mut insert = sqlx::query(AssertSqlSafe(table.insert()));
    for (place, (_, kind)) in table.columns.iter().enumerate() {
        insert = match kind {
            Kind::Whole => insert.bind(column::<i64>(rows, place)?),
            Kind::Real => insert.bind(column::<f64>(rows, place)?),
            Kind::Text => insert.bind(column::<String>(rows, place)?),
            Kind::Bytes => insert.bind(column::<Vec<u8>>(rows, place)?),
        };
    }
    let mut block = target.begin().await?;
    insert.execute(&mut *block).await?;
    let note = "INSERT INTO copying VALUES ($1, $2, '') ON CONFLICT (name) DO UPDATE SET rows = excluded.rows";
    sqlx::query(note).bind(table.name).bind(done).execute(&mut *block).await?;
    Ok(block.commit().await?)
}

fn column<T>(rows: &[SqliteRow], place: usize) -> Result<Vec<Option<T>>, sqlx::Error>
where
    T: for<'r> sqlx::Decode<'r, sqlx::Sqlite> + sqlx::Type<sqlx::Sqlite>,
{
    rows.iter().map(|row| row.try_get(place)).collect()
}

async fn source_sum(table: &Table, source: &mut SqliteConnection) -> Result<(u64, u128), StoreError> {
    sum(table, sqlx::query(AssertSqlSafe(table.select(HISTORY))).fetch(source)).await
}

async fn target_sum(table: &Table, target: &mut PgConnection) -> Result<(u64, u128), StoreError> {
    let sql = AssertSqlSafe(format!("SELECT {} FROM {}", table.columns(), table.name));
    sum(table, sqlx::query(sql).fetch(target)).await
}

/// How many rows, and the sum of half the SHA-256 of each: the same in whatever order they come.
async fn sum<R: Row>(
    table: &Table,
    mut rows: impl futures::Stream<Item = Result<R, sqlx::Error>> + Unpin,
) -> Result<(u64, u128), StoreError>
where
    usize: sqlx::ColumnIndex<R>,
    Option<i64>: for<'r> sqlx::Decode<'r, R::Database> + sqlx::Type<R::Database>,
    Option<f64>: for<'r> sqlx::Decode<'r, R::Database> + sqlx::Type<R::Database>,
    Option<String>: for<'r> sqlx::Decode<'r, R::Database> + sqlx::Type<R::Database>,
    Option<Vec<u8>>: for<'r> sqlx::Decode<'r, R::Database> + sqlx::Type<R::Database>,
{
    let (mut count, mut sum, mut bytes) = (0, 0_u128, Vec::new());
    while let Some(row) = rows.try_next().await? {
        bytes.clear();
        for (place, (_, kind)) in table.columns.iter().enumerate() {
            match kind {
                Kind::Whole => add(&mut bytes, row.try_get::<Option<i64>, _>(place)?.map(i64::to_le_bytes)),
                Kind::Real => add(&mut bytes, row.try_get::<Option<f64>, _>(place)?.map(f64::to_le_bytes)),
                Kind::Text => add(&mut bytes, row.try_get::<Option<String>, _>(place)?),
                Kind::Bytes => add(&mut bytes, row.try_get::<Option<Vec<u8>>, _>(place)?),
            }
        }
        let hash = sha256(&bytes);
        let half = hash.first_chunk().expect("SHA-256 has 32 bytes");
        sum = sum.wrapping_add(u128::from_le_bytes(*half));
        count += 1;
    }
    Ok((count, sum))
}

/// Nothing is told from an empty value by its length.
fn add(bytes: &mut Vec<u8>, value: Option<impl AsRef<[u8]>>) {
    match value {
        Some(value) => {
            let value = value.as_ref();
            bytes.extend((value.len() as u64 + 1).to_le_bytes());
            bytes.extend(value);
        }
        None => bytes.extend(0_u64.to_le_bytes()),
    }
}
