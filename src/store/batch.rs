//! What one transaction writes: statements, each with many rows.
//!
//! SQLite is in the process: a statement is run once a row, whose cells are bound one by one. PostgreSQL is asked
//! once a statement: there the rows travel as one JSON array of arrays (numbers) and one run of bytes (everything
//! else) that the numbers point into.

use std::fmt::Write as _;
use std::ops::Range;

use rusqlite::CachedStatement;
use rusqlite::types::{ToSqlOutput, ValueRef};
use sqlx::PgConnection;

use super::db::Sql;
use super::error::StoreError;
use crate::store::sqlite::checksum::Summing;

/// A transaction under construction.
#[derive(Debug, Default)]
pub(crate) struct Batch(Vec<Statement>);

/// A statement with its rows.
#[derive(Debug)]
struct Statement {
    sql: Sql,
    rows: Rows,
    /// It is to find what each of its rows is about: where it does not, somebody else has changed that.
    finds_all: bool,
}

/// SQLite's page size.
const PAGE: usize = 4096;

impl Batch {
    /// Appends `sql` unless there are no rows. `$1` and `$2` stand in PostgreSQL's words for the JSON array and the
    /// bytes, `$C0`, `$C1` and so on in SQLite's for the cells of one row, by their places.
    pub fn add(&mut self, sql: Sql, rows: Rows) {
        if !rows.ends.is_empty() {
            self.0.push(Statement { sql, rows, finds_all: false });
        }
    }

    /// As [`Batch::add`], where nothing may be committed unless the statement changes something for each row.
    pub fn add_to_all(&mut self, sql: Sql, rows: Rows) {
        if !rows.ends.is_empty() {
            self.0.push(Statement { sql, rows, finds_all: true });
        }
    }

    /// Roughly how many pages of SQLite's log it takes.
    pub fn pages(&self) -> u32 {
        self.0.iter().map(|Statement { rows, .. }| (rows.ends.len() + rows.bytes.len() / PAGE) as u32).sum()
    }

    /// Runs everything and commits; after an error nothing of it remains. Waits for the disk.
    pub fn commit(&self, connection: &Summing) -> Result<(), StoreError> {
        let committed = self.run_and_commit(connection);
        if committed.is_err() {
            // Some errors have rolled back by themselves; then this one has nothing to do and says so.
            let _nothing_left = connection.execute_batch("ROLLBACK");
        }
        Ok(committed?)
    }

    fn run_and_commit(&self, connection: &Summing) -> rusqlite::Result<()> {
        connection.begin();
        connection.prepare_cached("BEGIN IMMEDIATE")?.execute(())?;
        for Statement { sql, rows, .. } in &self.0 {
            rows.run(&mut connection.prepare_cached(sql.sqlite)?)?;
        }
        connection.write()?;
        connection.prepare_cached("COMMIT")?.execute(())?;
        Ok(())
    }

    /// Runs everything within the transaction that is open.
    pub async fn run(self, connection: &mut PgConnection) -> Result<(), StoreError> {
        for Statement { sql, rows, finds_all } in self.0 {
            let wanted = rows.ends.len() as u64;
            let query = sqlx::query(sql.postgres).bind(rows.json());
            let query = if sql.postgres.contains("$2") { query.bind(rows.bytes) } else { query };
            let found = query.execute(&mut *connection).await?.rows_affected();
            if finds_all && found != wanted {
                return Err(StoreError::Overtaken(format!("{found} of {wanted} rows are as they were read")));
            }
        }
        Ok(())
    }
}

/// The rows of one statement.
#[derive(Debug, Default)]
pub(crate) struct Rows {
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
    /// Of the rows' bytes. In JSON it takes two places: where it begins (counting from 1), and its length.
    Bytes(Option<Range<usize>>),
}

impl Cell {
    fn places(&self) -> usize {
        if matches!(self, Self::Bytes(_)) { 2 } else { 1 }
    }
}

impl Rows {
    /// A row of one whole number each.
    pub fn of(numbers: impl IntoIterator<Item = i64>) -> Self {
        let mut rows = Self::default();
        for number in numbers {
            rows.row().integer(number);
        }
        rows
    }

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
                    Cell::Bytes(Some(at)) => write!(json, "{},{}", at.start + 1, at.len()).expect(cannot_fail),
                    Cell::Bytes(None) => json.push_str("1,null"),
                }
            }
            json.push(']');
        }
        json.push(']');
        json
    }

    fn value<'a>(&'a self, cell: &'a Cell) -> ToSqlOutput<'a> {
        ToSqlOutput::Borrowed(match cell {
            Cell::Null | Cell::Bytes(None) => ValueRef::Null,
            Cell::Integer(value) => ValueRef::Integer(*value),
            Cell::Real(value) => ValueRef::Real(*value),
            Cell::Text(value) => ValueRef::Text(value.as_bytes()),
            Cell::Bytes(Some(at)) => ValueRef::Blob(&self.bytes[at.clone()]),
        })
    }

    /// Runs a statement of SQLite's for each row.
    fn run(&self, statement: &mut CachedStatement<'_>) -> rusqlite::Result<()> {
        let Some(first) = self.rows().next() else { return Ok(()) };
        let mut parameters = Vec::with_capacity(first.len());
        let mut place = 0;
        for cell in first {
            parameters.push(statement.parameter_index(&format!("$C{place}"))?);
            place += cell.places();
        }
        let bound = parameters.iter().flatten().count();
        if bound != statement.parameter_count() {
            return Err(rusqlite::Error::InvalidParameterCount(bound, statement.parameter_count()));
        }
        for row in self.rows() {
            debug_assert_eq!(row.len(), first.len(), "rows of a statement are alike");
            for (cell, parameter) in row.iter().zip(&parameters) {
                if let Some(parameter) = parameter {
                    statement.raw_bind_parameter(*parameter, self.value(cell))?;
                }
            }
            statement.raw_execute()?;
        }
        Ok(())
    }
}

/// A row under construction; dropping it ends it.
pub(crate) struct Row<'a> {
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

    /// One place, for short texts.
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

    /// Takes two places.
    pub fn bytes(&mut self, value: &[u8]) -> &mut Self {
        self.written(|out| out.extend_from_slice(value))
    }

    /// As [`Row::bytes`], written by `write` into the bytes directly.
    pub fn written(&mut self, write: impl FnOnce(&mut Vec<u8>)) -> &mut Self {
        let start = self.rows.bytes.len();
        write(&mut self.rows.bytes);
        let end = self.rows.bytes.len();
        self.cell(Cell::Bytes(Some(start..end)))
    }

    /// As [`Row::bytes`]; nothing at all is null.
    pub fn optional(&mut self, value: Option<impl AsRef<[u8]>>) -> &mut Self {
        match value {
            Some(value) => self.bytes(value.as_ref()),
            None => self.cell(Cell::Bytes(None)),
        }
    }
}

impl Drop for Row<'_> {
    fn drop(&mut self) {
        self.rows.ends.push(self.rows.cells.len());
    }
}
