//! A database in a file copied into an empty one on a server: block by block, so that an interrupted copy goes on
//! where it stopped, and compared row by row at the end.

use futures::TryStreamExt;
use sqlx::sqlite::{SqliteConnectOptions, SqliteRow};
use sqlx::{AssertSqlSafe, ConnectOptions, Connection, PgConnection, Row, SqliteConnection};

use super::postgres;
use super::rows::{AnyRow, Stored};
use crate::message;
use crate::store::packed::history_row::PACKED_LEN;
use crate::store::sqlite::lock::{self, Lock};
use crate::store::sqlite::write_behind::history_log::PendingHistory;
use crate::store::{Options, Result, StoreError};
use crate::system::sha256;

/// Rows of a block, and about how many bytes of them.
const BLOCK_ROWS: usize = 5_000;
const BLOCK_BYTES: usize = 8 << 20;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ColumnType {
    Whole,
    Real,
    Text,
    Bytes,
}

impl ColumnType {
    /// Of a column of a STRICT table.
    fn of(declared: &str) -> Result<Self> {
        match declared {
            "INTEGER" => Ok(Self::Whole),
            "REAL" => Ok(Self::Real),
            "TEXT" => Ok(Self::Text),
            "BLOB" => Ok(Self::Bytes),
            other => Err(StoreError::damaged(format_args!("a column of type {other}"))),
        }
    }
}

/// A table as the schema of the file has it: its name, its columns, in what order it is read.
struct CopiedTable {
    name: &'static str,
    columns: Vec<(String, ColumnType)>,
    order: String,
}

/// Those that are referred to before those that refer to them.
const TABLES: &str = "imu station gyro gyro_attribute record history voided_history bench_result event suspect_window \
    idempotency_key correction confirmation alert silence alert_step hook hook_heard delivery \
    delivery_part delivery_attempt imu_model campaign_model hypothesis diagnosis diagnosis_job \
    diagnosis_task diagnosis_gist token session audit";

impl CopiedTable {
    async fn of(name: &'static str, source: &mut SqliteConnection) -> Result<Self> {
        let sql = "SELECT name, type, pk FROM pragma_table_info($1) ORDER BY cid";
        let found: Vec<(String, String, i64)> = sqlx::query_as(sql).bind(name).fetch_all(source).await?;
        let mut key: Vec<(i64, &str)> = found.iter().map(|(column, _, pk)| (*pk, column.as_str())).collect();
        key.retain(|(place, _)| *place > 0);
        key.sort_unstable();
        let key: Vec<&str> = key.into_iter().map(|(_, column)| column).collect();
        let order = if key.is_empty() { "rowid".to_owned() } else { quoted(&key) };
        let kinds = found.iter().map(|(column, declared, _)| Ok((column.clone(), ColumnType::of(declared)?)));
        Ok(Self { name, columns: kinds.collect::<Result<_>>()?, order })
    }

    /// Every column, in quotation marks: some are words of SQL.
    fn columns(&self) -> String {
        quoted(&self.columns.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>())
    }

    /// Reads the table in the file; the history is that of the table and of what waits before it.
    fn select(&self) -> String {
        let (columns, order) = (self.columns(), &self.order);
        let source = if self.name == "history" { HISTORY } else { self.name };
        format!("SELECT {columns} FROM {source} ORDER BY {order}")
    }

    fn insert(&self) -> String {
        let arrays = self.columns.iter().zip(1..).map(|((_, kind), place)| match kind {
            ColumnType::Whole => format!("CAST(${place} AS BIGINT[])"),
            ColumnType::Real => format!("CAST(${place} AS DOUBLE PRECISION[])"),
            ColumnType::Text => format!("CAST(${place} AS TEXT[])"),
            ColumnType::Bytes => format!("CAST(${place} AS BYTEA[])"),
        });
        let arrays: Vec<String> = arrays.collect();
        format!("INSERT INTO {} ({}) SELECT * FROM unnest({})", self.name, self.columns(), arrays.join(", "))
    }
}

fn quoted(columns: &[&str]) -> String {
    let quoted: Vec<String> = columns.iter().map(|name| format!("\"{name}\"")).collect();
    quoted.join(", ")
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
pub async fn copy(from: &Options, to: &Options, mut each: impl FnMut(&'static str, u64)) -> Result<Vec<Copied>> {
    if from.is_server() || !to.is_server() {
        return Err(StoreError::File(message!("copy_direction")));
    }
    let (mut source, _lock) = open_source(from).await?;
    let mut target = postgres::open::open_to_copy(to).await?;
    claim(&mut target, &from.file()?.display().to_string()).await?;
    let mut tables = Vec::new();
    for name in TABLES.split(' ') {
        tables.push(CopiedTable::of(name, &mut source).await?);
    }
    for table in &tables {
        copy_table(table, &mut source, &mut target, &mut each).await?;
    }
    let mut compared = Vec::with_capacity(tables.len());
    for table in &tables {
        let there = AssertSqlSafe(format!("SELECT {} FROM {}", table.columns(), table.name));
        let (rows, checksum) = sum(table, sqlx::query(AssertSqlSafe(table.select())).fetch(&mut source)).await?;
        let (found, of_found) = sum(table, sqlx::query(there).fetch(&mut target)).await?;
        compared.push(Copied { table: table.name, rows: [rows, found], checksums: [checksum, of_found] });
    }
    if compared.iter().all(Copied::is_whole) {
        postgres::open::give_homes(&mut target).await?;
        release(&tables, &mut target).await?;
    }
    Ok(compared)
}

/// The file, which nobody serves meanwhile, with what waits before its history at hand.
async fn open_source(from: &Options) -> Result<(SqliteConnection, Lock)> {
    let file = from.file()?;
    let lock = lock::take(&file)?;
    let connect = SqliteConnectOptions::new().filename(&file).read_only(true).disable_statement_logging();
    let mut source = connect.connect().await?;
    crate::store::sqlite::backup::check_schema(&mut source, &file).await?;
    let pending = PendingHistory::load(&mut source).await?;
    let create =
        "CREATE TEMP TABLE waiting (gyro INTEGER NOT NULL, calibrated_at INTEGER NOT NULL, record INTEGER NOT NULL,
                      figures BLOB NOT NULL, PRIMARY KEY (gyro, calibrated_at)) STRICT, WITHOUT ROWID";
    sqlx::query(create).execute(&mut source).await?;
    for (gyro, figures) in pending.rows() {
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
const HISTORY: &str = "(SELECT * FROM history WHERE NOT EXISTS (SELECT 1 FROM waiting
          WHERE waiting.gyro = history.gyro AND waiting.calibrated_at = history.calibrated_at)
      UNION ALL SELECT * FROM waiting)";

/// Takes an empty database, or one into which the same file was being copied.
async fn claim(target: &mut PgConnection, source: &str) -> Result<()> {
    sqlx::query(
        "CREATE TABLE IF NOT EXISTS copying (name TEXT PRIMARY KEY, rows BIGINT NOT NULL, source TEXT NOT NULL)",
    )
    .execute(&mut *target)
    .await?;
    let begun: Option<String> =
        sqlx::query_scalar("SELECT source FROM copying WHERE name = ''").fetch_optional(&mut *target).await?;
    match begun {
        Some(begun) if begun == source => return Ok(()),
        Some(other) => return Err(StoreError::File(message!("copy_of_other", file = other))),
        None => {}
    }
    for table in TABLES.split(' ') {
        let any = AssertSqlSafe(format!("SELECT count(*) FROM (SELECT 1 FROM {table} LIMIT 1) AS chosen"));
        if sqlx::query_scalar::<_, i64>(any).fetch_one(&mut *target).await? > 0 {
            release_mark(target).await?;
            return Err(StoreError::File(message!("copy_not_empty", table)));
        }
    }
    sqlx::query("INSERT INTO copying VALUES ('', 0, $1)").bind(source).execute(target).await?;
    Ok(())
}

async fn release_mark(target: &mut PgConnection) -> Result<()> {
    sqlx::query("DROP TABLE copying").execute(target).await?;
    Ok(())
}

/// What a server keeps besides what is copied, as in a database that none has opened yet: one that had opened this one
/// made it of nothing. The next start makes it of what was copied.
const NOTHING_MADE: &str = "DELETE FROM head; DELETE FROM gyro_station; UPDATE head_made SET limits = '', through = '';
     DELETE FROM diagnosis_claim; DELETE FROM cell_commit; UPDATE lease SET holder = 0, until = now()";

/// Opens the copy to servers: identifiers go on after the greatest.
async fn release(tables: &[CopiedTable], target: &mut PgConnection) -> Result<()> {
    let newest = tables.iter().filter(|table| table.columns[0].0 == "id" && !NAMES.contains(&table.name));
    let newest: Vec<String> =
        newest.map(|table| format!("coalesce((SELECT max(id) FROM {}), 0)", table.name)).collect();
    let sql = format!(
        "UPDATE cell SET stamp = $1, names = $1, settings = $1, outbox = $1, models = $1, diagnoses = $1, access = $1,
             last_id = greatest({})",
        newest.join(", ")
    );
    let mut whole = target.begin().await?;
    sqlx::raw_sql(NOTHING_MADE).execute(&mut *whole).await?;
    let stamp = rand::random_range(1..i64::MAX);
    sqlx::query(AssertSqlSafe(sql)).bind(stamp).execute(&mut *whole).await?;
    release_mark(&mut whole).await?;
    Ok(whole.commit().await?)
}

/// Their numbers are not among the identifiers.
const NAMES: [&str; 3] = ["imu", "station", "gyro"];

async fn copy_table(
    table: &CopiedTable,
    source: &mut SqliteConnection,
    target: &mut PgConnection,
    each: &mut impl FnMut(&'static str, u64),
) -> Result<()> {
    let done: Option<i64> = sqlx::query_scalar("SELECT rows FROM copying WHERE name = $1")
        .bind(table.name)
        .fetch_optional(&mut *target)
        .await?;
    let mut done = done.unwrap_or(0);
    let sql = AssertSqlSafe(format!("{} LIMIT -1 OFFSET $1", table.select()));
    let mut rows = sqlx::query(sql).bind(done).fetch(source);
    let (mut block, mut bytes, mut packed) = (Vec::new(), 0, Vec::new());
    loop {
        let row = rows.try_next().await?;
        let ended = row.is_none();
        if let Some(row) = row {
            pack(table, &row, &mut packed)?;
            bytes += packed.len();
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

/// One transaction: the rows, and how many there are now.
async fn put(table: &CopiedTable, rows: &[SqliteRow], done: i64, target: &mut PgConnection) -> Result<()> {
    let mut insert = sqlx::query(AssertSqlSafe(table.insert()));
    for (place, (_, kind)) in table.columns.iter().enumerate() {
        insert = match kind {
            ColumnType::Whole => insert.bind(column::<i64>(rows, place)?),
            ColumnType::Real => insert.bind(column::<f64>(rows, place)?),
            ColumnType::Text => insert.bind(column::<String>(rows, place)?),
            ColumnType::Bytes => insert.bind(column::<Vec<u8>>(rows, place)?),
        };
    }
    let mut block = target.begin().await?;
    insert.execute(&mut *block).await?;
    let note = "INSERT INTO copying VALUES ($1, $2, '') ON CONFLICT (name) DO UPDATE SET rows = excluded.rows";
    sqlx::query(note).bind(table.name).bind(done).execute(&mut *block).await?;
    Ok(block.commit().await?)
}

fn column<T: Stored>(rows: &[SqliteRow], place: usize) -> Result<Vec<Option<T>>, sqlx::Error> {
    rows.iter().map(|row| row.try_get(place)).collect()
}

/// How many rows, and the sum of half the SHA-256 of each: the same in whatever order they come.
async fn sum<R: AnyRow>(
    table: &CopiedTable,
    mut rows: impl futures::Stream<Item = Result<R, sqlx::Error>> + Unpin,
) -> Result<(u64, u128)> {
    let (mut count, mut sum, mut bytes) = (0, 0_u128, Vec::new());
    while let Some(row) = rows.try_next().await? {
        pack(table, &row, &mut bytes)?;
        let hash = sha256(&bytes);
        let half = hash.first_chunk().expect("SHA-256 has 32 bytes");
        sum = sum.wrapping_add(u128::from_le_bytes(*half));
        count += 1;
    }
    Ok((count, sum))
}

/// What a row holds, cell by cell.
fn pack(table: &CopiedTable, row: &impl AnyRow, bytes: &mut Vec<u8>) -> Result<()> {
    bytes.clear();
    for (place, (_, kind)) in table.columns.iter().enumerate() {
        match kind {
            ColumnType::Whole => add(bytes, row.cell::<Option<i64>>(place)?.map(i64::to_le_bytes)),
            ColumnType::Real => add(bytes, row.cell::<Option<f64>>(place)?.map(f64::to_le_bytes)),
            ColumnType::Text => add(bytes, row.cell::<Option<String>>(place)?),
            ColumnType::Bytes => add(bytes, row.cell::<Option<Vec<u8>>>(place)?),
        }
    }
    Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tests::opened;

    /// Made anew from the others at the first start, or of a file alone.
    const NOT_COPIED: &str =
        "calendar calendar_begun checksum gyro_station head head_made history_log _sqlx_migrations";

    #[tokio::test]
    async fn every_table_is_copied_or_made_anew() {
        let dir = tempfile::tempdir().unwrap();
        let (store, writer) = opened(&dir).await;
        drop((store, writer));
        let file = SqliteConnectOptions::new().filename(dir.path().join("test.db"));
        let mut source = file.connect().await.unwrap();
        let sql = "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite%' ORDER BY name";
        let there: Vec<String> = sqlx::query_scalar(sql).fetch_all(&mut source).await.unwrap();
        let mut known: Vec<&str> = TABLES.split(' ').chain(NOT_COPIED.split(' ')).collect();
        known.sort_unstable();
        assert_eq!(there, known);
        let alert = CopiedTable::of("alert", &mut source).await.unwrap();
        assert!(alert.columns.contains(&("imu".to_owned(), ColumnType::Whole)), "{}", alert.columns());
        assert_eq!(alert.order, "\"id\"");
    }
}
