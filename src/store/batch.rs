//! What one transaction writes: many rows a statement.
//!
//! A driver's call costs more than a database's work for a row, so the rows of a statement travel as one JSON array of
//! arrays (numbers) and one run of bytes (everything else) that the numbers point into.

use std::fmt::Write as _;

use sqlx::sqlite::SqliteArguments;
use sqlx::{Arguments, AssertSqlSafe, PgConnection, SqliteConnection};

use super::db::Sql;
use super::error::StoreError;

/// A transaction under construction.
#[derive(Debug, Default)]
pub(super) struct Batch(Vec<(Sql, Rows)>);

/// SQLite's page size.
const PAGE: usize = 4096;

impl Batch {
    /// Appends `sql` unless there are no rows. For SQLite `$ROWS` stands in it for the JSON array and `$BYTES` for the bytes, for
    /// PostgreSQL `$1` and `$2`.
    pub fn add(&mut self, sql: Sql, rows: Rows) {
        if !rows.json.is_empty() {
            self.0.push((sql, rows));
        }
    }

    /// Roughly how many pages of SQLite's log it takes.
    pub fn pages(&self) -> u32 {
        self.0.iter().map(|(_, rows)| rows.count + (rows.bytes.len() / PAGE) as u32).sum()
    }

    /// Runs everything in one round trip and commits; after an error nothing of it remains.
    pub async fn commit(self, connection: &mut SqliteConnection) -> Result<(), StoreError> {
        let (mut all, mut arguments) = ("BEGIN IMMEDIATE".to_owned(), SqliteArguments::default());
        let cannot_fail = "text and bytes can always be encoded";
        for (sql, rows) in self.0 {
            let (first, second) = (arguments.len() + 1, arguments.len() + 2);
            let sql = sql.sqlite.replace("$ROWS", &format!("${first}")).replace("$BYTES", &format!("${second}"));
            all.push_str("; ");
            all.push_str(&sql);
            arguments.add(rows.json + "]").expect(cannot_fail);
            arguments.add(rows.bytes).expect(cannot_fail);
        }
        all.push_str("; COMMIT");
        let run = sqlx::query_with(AssertSqlSafe(all), arguments).execute(&mut *connection).await;
        if let Err(error) = run {
            // Some errors have rolled back by themselves; then this one has nothing to do and says so.
            let _nothing_left = sqlx::query("ROLLBACK").execute(connection).await;
            return Err(error.into());
        }
        Ok(())
    }

    /// Runs everything within the transaction that is open.
    pub async fn run(self, connection: &mut PgConnection) -> Result<(), StoreError> {
        for (sql, rows) in self.0 {
            let query = sqlx::query(sql.postgres).bind(rows.json + "]");
            let query = if sql.postgres.contains("$2") { query.bind(rows.bytes) } else { query };
            query.execute(&mut *connection).await?;
        }
        Ok(())
    }
}

/// The rows of one statement.
#[derive(Debug, Default)]
pub(super) struct Rows {
    json: String,
    bytes: Vec<u8>,
    count: u32,
}

impl Rows {
    /// Begins a row; its cells follow.
    pub fn row(&mut self) -> Row<'_> {
        self.count += 1;
        self.json.push_str(if self.json.is_empty() { "[[" } else { ",[" });
        Row { rows: self, first: true }
    }
}

/// A row under construction; dropping it ends it.
pub(super) struct Row<'a> {
    rows: &'a mut Rows,
    first: bool,
}

impl Row<'_> {
    fn cell(&mut self, value: impl std::fmt::Display) -> &mut Self {
        let comma = if std::mem::take(&mut self.first) { "" } else { "," };
        write!(self.rows.json, "{comma}{value}").expect("writing to a string cannot fail");
        self
    }

    pub fn integer(&mut self, value: i64) -> &mut Self {
        self.cell(value)
    }

    pub fn optional_integer(&mut self, value: Option<i64>) -> &mut Self {
        match value {
            Some(value) => self.cell(value),
            None => self.cell("null"),
        }
    }

    /// One cell, for short texts: as a JSON string, without a detour through `$BYTES`.
    pub fn text(&mut self, value: &str) -> &mut Self {
        self.cell(serde_json::Value::from(value))
    }

    pub fn optional_text(&mut self, value: Option<&str>) -> &mut Self {
        self.cell(serde_json::Value::from(value))
    }

    /// Written with every digit it takes to read the same number back.
    pub fn real(&mut self, value: Option<f64>) -> &mut Self {
        match value.filter(|v| v.is_finite()) {
            Some(value) => self.cell(format_args!("{value:e}")),
            None => self.cell("null"),
        }
    }

    /// Two cells: where in `$BYTES` it begins (counting from 1) and how long it is.
    pub fn bytes(&mut self, value: &[u8]) -> &mut Self {
        let start = self.rows.bytes.len() + 1;
        self.rows.bytes.extend_from_slice(value);
        self.cell(start).cell(value.len())
    }

    /// As [`Row::bytes`], written by `write` into the bytes directly.
    pub fn written(&mut self, write: impl FnOnce(&mut Vec<u8>)) -> &mut Self {
        let start = self.rows.bytes.len();
        write(&mut self.rows.bytes);
        let len = self.rows.bytes.len() - start;
        self.cell(start + 1).cell(len)
    }

    /// As [`Row::bytes`]; nothing at all has length null, and `substr` then gives null.
    pub fn optional(&mut self, value: Option<&str>) -> &mut Self {
        match value {
            Some(value) => self.bytes(value.as_bytes()),
            None => self.cell(1).cell("null"),
        }
    }
}

impl Drop for Row<'_> {
    fn drop(&mut self) {
        self.rows.json.push(']');
    }
}
