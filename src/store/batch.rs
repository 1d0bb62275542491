//! What one transaction writes: many rows a statement.
//!
//! A driver's call costs more than a database's work for a row, so the rows of a statement travel as one JSON array of
//! arrays (numbers) and one run of bytes (everything else) that the numbers point into. For SQLite's busiest statements the
//! numbers stand in the bytes too, in columns of [`FLAT_CELL`], and the JSON says only where each row begins: reading an array
//! of twelve numbers out of JSON takes SQLite longer than storing the row.

use std::fmt::Write as _;
use std::io::Write as _;

use sqlx::sqlite::SqliteArguments;
use sqlx::{Arguments, AssertSqlSafe, PgConnection, SqliteConnection};

use super::db::{FlatSql, Sql};
use super::error::StoreError;

/// A transaction under construction.
#[derive(Debug, Default)]
pub(super) struct Batch(Vec<Statement>);

#[derive(Debug)]
struct Statement {
    sql: Sql,
    rows: Rows,
    /// For SQLite the rows' numbers stand in the bytes.
    flat: bool,
}

/// SQLite's page size.
const PAGE: usize = 4096;

impl Batch {
    /// Appends `sql` unless there are no rows. For SQLite `$ROWS` stands in it for the JSON array and `$BYTES` for the bytes, for
    /// PostgreSQL `$1` and `$2`.
    pub fn add(&mut self, sql: Sql, rows: Rows) {
        self.push(Statement { sql, rows, flat: false });
    }

    /// As [`Batch::add`], for rows of whole numbers and bytes.
    pub fn add_flat(&mut self, FlatSql(sql): FlatSql, rows: Rows) {
        self.push(Statement { sql, rows, flat: true });
    }

    fn push(&mut self, statement: Statement) {
        if !statement.rows.ends.is_empty() {
            self.0.push(statement);
        }
    }

    /// Roughly how many pages of SQLite's log it takes.
    pub fn pages(&self) -> u32 {
        self.0.iter().map(|Statement { rows, .. }| (rows.ends.len() + rows.bytes.len() / PAGE) as u32).sum()
    }

    /// Runs everything in one round trip and commits; after an error nothing of it remains.
    pub async fn commit(self, connection: &mut SqliteConnection) -> Result<(), StoreError> {
        let (mut all, mut arguments) = ("BEGIN IMMEDIATE".to_owned(), SqliteArguments::default());
        let cannot_fail = "text and bytes can always be encoded";
        for Statement { sql, rows, flat } in self.0 {
            let (first, second) = (arguments.len() + 1, arguments.len() + 2);
            all.push_str("; ");
            numbered(sql.sqlite, [("ROWS", first), ("BYTES", second)], &mut all);
            let (json, bytes) = if flat { rows.flat() } else { (rows.json(), rows.bytes) };
            arguments.add(json).expect(cannot_fail);
            arguments.add(bytes).expect(cannot_fail);
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
        for Statement { sql, rows, .. } in self.0 {
            let query = sqlx::query(sql.postgres).bind(rows.json());
            let query = if sql.postgres.contains("$2") { query.bind(rows.bytes) } else { query };
            query.execute(&mut *connection).await?;
        }
        Ok(())
    }
}

/// Appends `sql` with numbers for the names of its parameters.
fn numbered(sql: &str, numbers: [(&str, usize); 2], out: &mut String) {
    let mut pieces = sql.split('$');
    out.push_str(pieces.next().unwrap_or_default());
    for piece in pieces {
        let named = numbers.iter().find_map(|(name, number)| Some((number, piece.strip_prefix(name)?)));
        let (number, rest) = named.expect("every `$` of a statement begins one of the two names");
        write!(out, "${number}{rest}").expect("writing to a string cannot fail");
    }
}

/// Bytes of a number in a flat row: enough for any of 64 bits, padded with spaces.
pub(super) const FLAT_CELL: usize = 20;

const _: () = assert!(FLAT_CELL == 20, "as `cell!(flat …)` of `super::db` has it");

/// The rows of one statement.
#[derive(Debug, Default)]
pub(super) struct Rows {
    cells: Vec<Cell>,
    /// How many cells there are at the end of each row.
    ends: Vec<usize>,
    bytes: Vec<u8>,
}

#[derive(Debug)]
enum Cell {
    Null,
    Integer(i64),
    Real(f64),
    Text(String),
}

impl Rows {
    /// Begins a row; its cells follow.
    pub fn row(&mut self) -> Row<'_> {
        Row { rows: self }
    }

    fn rows(&self) -> impl Iterator<Item = &[Cell]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| &self.cells[start..*end])
    }

    /// An array of a row's cells for each row.
    fn json(&self) -> String {
        let cannot_fail = "writing to a string cannot fail";
        let mut json = String::with_capacity(2 + 12 * self.cells.len());
        for row in self.rows() {
            json.push_str(if json.is_empty() { "[[" } else { ",[" });
            for (k, cell) in row.iter().enumerate() {
                json.push_str(if k == 0 { "" } else { "," });
                match cell {
                    Cell::Null => json.push_str("null"),
                    Cell::Integer(value) => write!(json, "{value}").expect(cannot_fail),
                    Cell::Real(value) => write!(json, "{value:e}").expect(cannot_fail),
                    Cell::Text(value) => {
                        write!(json, "{}", serde_json::Value::from(value.as_str())).expect(cannot_fail)
                    }
                }
            }
            json.push(']');
        }
        json.push(']');
        json
    }

    /// Where each row begins (counting from 1) in the bytes, and the bytes with the rows' numbers after them.
    fn flat(mut self) -> (String, Vec<u8>) {
        let mut bytes = std::mem::take(&mut self.bytes);
        bytes.reserve(FLAT_CELL * self.cells.len());
        let mut starts = String::with_capacity(2 + 9 * self.ends.len());
        for row in self.rows() {
            let comma = if starts.is_empty() { "[" } else { "," };
            write!(starts, "{comma}{}", bytes.len() + 1).expect("writing to a string cannot fail");
            for cell in row {
                let Cell::Integer(value) = cell else { unreachable!("a flat row has whole numbers alone") };
                write!(bytes, "{value:<FLAT_CELL$}").expect("writing to memory cannot fail");
            }
        }
        starts.push(']');
        (starts, bytes)
    }
}

/// A row under construction; dropping it ends it.
pub(super) struct Row<'a> {
    rows: &'a mut Rows,
}

impl Row<'_> {
    fn cell(&mut self, cell: Cell) -> &mut Self {
        self.rows.cells.push(cell);
        self
    }

    pub fn integer(&mut self, value: i64) -> &mut Self {
        self.cell(Cell::Integer(value))
    }

    pub fn optional_integer(&mut self, value: Option<i64>) -> &mut Self {
        self.cell(value.map_or(Cell::Null, Cell::Integer))
    }

    /// One cell, for short texts: as a JSON string, without a detour through `$BYTES`.
    pub fn text(&mut self, value: &str) -> &mut Self {
        self.cell(Cell::Text(value.to_owned()))
    }

    pub fn optional_text(&mut self, value: Option<&str>) -> &mut Self {
        self.cell(value.map_or(Cell::Null, |value| Cell::Text(value.to_owned())))
    }

    /// Written with every digit it takes to read the same number back.
    pub fn real(&mut self, value: Option<f64>) -> &mut Self {
        self.cell(value.filter(|v| v.is_finite()).map_or(Cell::Null, Cell::Real))
    }

    /// Two cells: where in `$BYTES` it begins (counting from 1) and how long it is.
    pub fn bytes(&mut self, value: &[u8]) -> &mut Self {
        self.written(|out| out.extend_from_slice(value))
    }

    /// As [`Row::bytes`], written by `write` into the bytes directly.
    pub fn written(&mut self, write: impl FnOnce(&mut Vec<u8>)) -> &mut Self {
        let start = self.rows.bytes.len();
        write(&mut self.rows.bytes);
        let len = self.rows.bytes.len() - start;
        self.integer(start as i64 + 1).integer(len as i64)
    }

    /// As [`Row::bytes`]; nothing at all has length null, and `substr` then gives null.
    pub fn optional(&mut self, value: Option<&str>) -> &mut Self {
        match value {
            Some(value) => self.bytes(value.as_bytes()),
            None => self.integer(1).cell(Cell::Null),
        }
    }
}

impl Drop for Row<'_> {
    fn drop(&mut self) {
        self.rows.ends.push(self.rows.cells.len());
    }
}
