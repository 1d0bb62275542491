//! Rows on their way into the database and out of it, cell by cell.

use std::fmt::Write as _;
use std::ops::Range;

use rusqlite::CachedStatement;
use rusqlite::types::{ToSqlOutput, ValueRef};
use sqlx::postgres::PgRow;
use sqlx::sqlite::SqliteRow;
use sqlx::{AssertSqlSafe, Column as _, Decode, Postgres, Row as _, Sqlite, Type};

use super::error::{Result, StoreError};

/// A row of a table, made by [`columns`](super::columns).
pub(crate) trait Columns: Part {
    const TABLE: &'static str;
    /// As SQL lists them.
    const COLUMNS: &'static str;

    /// All columns, of which rows and in what order `then` says.
    fn select(then: &str) -> AssertSqlSafe<String> {
        AssertSqlSafe(format!("SELECT {} FROM {} {then}", Self::COLUMNS, Self::TABLE))
    }
}

/// What one column holds.
pub(crate) trait Column: Sized {
    /// As the database has it.
    type Stored: Stored;
    const KIND: CellKind;

    fn put_one(&self, row: &mut Row<'_>);

    /// None of what the database should not hold.
    fn of(stored: Self::Stored) -> Option<Self>;
}

/// What some columns beside one another hold together, often but one.
pub(crate) trait Part: Sized {
    fn put(&self, row: &mut Row<'_>);

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self>;
}

/// All rows of a statement, in PostgreSQL's words.
pub(super) const ALL_ROWS: &str = "jsonb_array_elements(CAST($1 AS JSONB)) AS j(value)";

/// The rows of one statement.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    cells: Vec<Cell>,
    /// How many cells there are at the end of each row.
    pub(super) ends: Vec<usize>,
    pub(super) bytes: Vec<u8>,
}

#[derive(Debug)]
enum Cell {
    Null(CellKind),
    Integer(i64),
    Real(f64),
    Text(String),
    /// Of the rows' bytes, or text there. In JSON it takes two places: where it begins (counting from 1), and its length.
    Bytes(Range<usize>),
    Words(Range<usize>),
}

/// What a cell is, or would be if it were not null.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CellKind {
    Integer,
    Real,
    Text,
    Bytes,
    Words,
}

impl Cell {
    fn kind(&self) -> CellKind {
        match self {
            Self::Null(kind) => *kind,
            Self::Integer(_) => CellKind::Integer,
            Self::Real(_) => CellKind::Real,
            Self::Text(_) => CellKind::Text,
            Self::Bytes(_) => CellKind::Bytes,
            Self::Words(_) => CellKind::Words,
        }
    }

    fn places(&self) -> usize {
        if matches!(self.kind(), CellKind::Bytes | CellKind::Words) { 2 } else { 1 }
    }

    /// The cell at a place of its row, in SQLite's words: a parameter has the number of its place, counted from 1.
    fn of_sqlite(&self, place: usize) -> String {
        match self.kind() {
            CellKind::Words => format!("CAST(?{} AS TEXT)", place + 1),
            _ => format!("?{}", place + 1),
        }
    }

    fn of_postgres(&self, place: usize) -> String {
        let bytes = || format!("substr($2, CAST(value->>{place} AS INT), CAST(value->>{} AS INT))", place + 1);
        match self.kind() {
            CellKind::Integer => format!("CAST(value->>{place} AS BIGINT)"),
            CellKind::Real => format!("CAST(value->>{place} AS DOUBLE PRECISION)"),
            CellKind::Text => format!("value->>{place}"),
            CellKind::Bytes => bytes(),
            CellKind::Words => format!("convert_from({}, 'UTF8')", bytes()),
        }
    }
}

impl Rows {
    pub fn of<P: Part>(parts: impl IntoIterator<Item = P>) -> Self {
        Self::each(parts, |part, row| part.put(row))
    }

    /// A row of each of these, as `put` writes it.
    pub fn each<T>(all: impl IntoIterator<Item = T>, put: impl Fn(T, &mut Row<'_>)) -> Self {
        let mut rows = Self::default();
        all.into_iter().for_each(|one| put(one, &mut rows.row()));
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

    /// The cells of a row, each with its place. Rows of a statement are alike.
    fn first(&self) -> impl Iterator<Item = (usize, &Cell)> {
        let cells = self.rows().next().unwrap_or_default();
        let starts = cells.iter().scan(0, |next, cell| Some(std::mem::replace(next, *next + cell.places())));
        starts.zip(cells)
    }

    /// The cells of a row, as SQLite lists them.
    pub(super) fn cells_of_sqlite(&self) -> String {
        self.listed(Cell::of_sqlite)
    }

    /// Those of all rows, as PostgreSQL lists them.
    pub(super) fn cells_of_postgres(&self) -> String {
        self.listed(Cell::of_postgres)
    }

    fn listed(&self, words: fn(&Cell, usize) -> String) -> String {
        self.first().map(|(place, cell)| words(cell, place)).collect::<Vec<_>>().join(", ")
    }

    /// A statement with a row's cells in SQLite's words.
    pub(super) fn of_sqlite(&self, statement: &str) -> String {
        self.with_cells(statement, Cell::of_sqlite)
    }

    /// In PostgreSQL's, which stand for those of all rows.
    pub(super) fn of_postgres(&self, statement: &str) -> String {
        self.with_cells(&statement.replace("$ROWS", ALL_ROWS), Cell::of_postgres)
    }

    fn with_cells(&self, statement: &str, words: fn(&Cell, usize) -> String) -> String {
        let mut parts = statement.split("$C");
        let mut all = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let (digits, rest) = part.split_at(part.find(|c: char| !c.is_ascii_digit()).unwrap_or(part.len()));
            let place: usize = digits.parse().expect("the place of a cell follows");
            let (_, cell) = self.first().find(|(at, _)| *at == place).expect("a row has a cell there");
            all.push_str(&words(cell, place));
            all.push_str(rest);
        }
        all
    }

    /// An array of a row's cells for each row.
    pub(super) fn json(&self) -> String {
        let cannot_fail = "writing to a string cannot fail";
        let mut json = String::with_capacity(2 + 12 * self.cells.len());
        for row in self.rows() {
            json.push_str(if json.is_empty() { "[[" } else { ",[" });
            for (k, cell) in row.iter().enumerate() {
                json.push_str(if k == 0 { "" } else { "," });
                match cell {
                    Cell::Null(CellKind::Bytes | CellKind::Words) => json.push_str("1,null"),
                    Cell::Null(_) => json.push_str("null"),
                    Cell::Integer(value) => write!(json, "{value}").expect(cannot_fail),
                    Cell::Real(value) => write!(json, "{value:e}").expect(cannot_fail),
                    Cell::Text(value) => {
                        write!(json, "{}", serde_json::Value::from(value.as_str())).expect(cannot_fail)
                    }
                    Cell::Bytes(at) | Cell::Words(at) => {
                        write!(json, "{},{}", at.start + 1, at.len()).expect(cannot_fail);
                    }
                }
            }
            json.push(']');
        }
        json.push(']');
        json
    }

    fn value<'a>(&'a self, cell: &'a Cell) -> ToSqlOutput<'a> {
        ToSqlOutput::Borrowed(match cell {
            Cell::Null(_) => ValueRef::Null,
            Cell::Integer(value) => ValueRef::Integer(*value),
            Cell::Real(value) => ValueRef::Real(*value),
            Cell::Text(value) => ValueRef::Text(value.as_bytes()),
            Cell::Bytes(at) | Cell::Words(at) => ValueRef::Blob(&self.bytes[at.clone()]),
        })
    }

    /// Runs a statement of SQLite's for each row.
    pub(super) fn run(&self, statement: &mut CachedStatement<'_>) -> rusqlite::Result<()> {
        let places: Vec<usize> = self.first().map(|(place, _)| place).collect();
        let parameters = statement.parameter_count();
        for row in self.rows() {
            debug_assert_eq!(row.len(), places.len(), "rows of a statement are alike");
            for (cell, place) in row.iter().zip(&places).take_while(|(_, place)| **place < parameters) {
                statement.raw_bind_parameter(place + 1, self.value(cell))?;
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

    /// The cells of what may be one or several.
    pub fn put(&mut self, value: &impl Part) -> &mut Self {
        value.put(self);
        self
    }

    pub fn null(&mut self, kind: CellKind) -> &mut Self {
        self.cell(Cell::Null(kind))
    }

    pub fn integer(&mut self, value: i64) -> &mut Self {
        self.cell(Cell::Integer(value))
    }

    /// One place, for short texts.
    pub fn text(&mut self, value: &str) -> &mut Self {
        self.cell(Cell::Text(value.to_owned()))
    }

    /// Written with every digit it takes to read the same number back.
    pub fn real(&mut self, value: f64) -> &mut Self {
        self.cell(if value.is_finite() { Cell::Real(value) } else { Cell::Null(CellKind::Real) })
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
        self.cell(Cell::Bytes(start..end))
    }

    /// As [`Row::bytes`], where they are a long text.
    pub fn words(&mut self, value: &str) -> &mut Self {
        let start = self.rows.bytes.len();
        self.rows.bytes.extend_from_slice(value.as_bytes());
        self.cell(Cell::Words(start..start + value.len()))
    }

    pub fn optional_words(&mut self, value: Option<&str>) -> &mut Self {
        if let Some(value) = value { self.words(value) } else { self.null(CellKind::Words) }
    }

    pub fn optional_bytes(&mut self, value: Option<&[u8]>) -> &mut Self {
        if let Some(value) = value { self.bytes(value) } else { self.null(CellKind::Bytes) }
    }
}

impl Drop for Row<'_> {
    fn drop(&mut self) {
        self.rows.ends.push(self.rows.cells.len());
    }
}

/// What both databases can hold in a cell.
pub(crate) trait Stored:
    Type<Sqlite> + for<'r> Decode<'r, Sqlite> + Type<Postgres> + for<'r> Decode<'r, Postgres>
{
}

impl<T> Stored for T where T: Type<Sqlite> + for<'r> Decode<'r, Sqlite> + Type<Postgres> + for<'r> Decode<'r, Postgres> {}

/// A row of either database.
pub(crate) trait AnyRow {
    fn cell<T: Stored>(&self, place: usize) -> Result<T, sqlx::Error>;

    /// Of a column.
    fn name(&self, place: usize) -> &str;

    /// What its columns hold, in their order.
    fn whole<P: Part>(&self) -> Result<P>
    where
        Self: Sized,
    {
        P::get(&mut Found { row: self, next: 0 })
    }
}

macro_rules! any_row {
    ($row:ty) => {
        impl AnyRow for $row {
            fn cell<T: Stored>(&self, place: usize) -> Result<T, sqlx::Error> {
                self.try_get(place)
            }

            fn name(&self, place: usize) -> &str {
                self.column(place).name()
            }
        }
    };
}

any_row!(SqliteRow);
any_row!(PgRow);

/// A row that is read, column after column.
pub(crate) struct Found<'r, R> {
    row: &'r R,
    next: usize,
}

impl<R: AnyRow> Found<'_, R> {
    /// What the next columns hold.
    pub fn part<P: Part>(&mut self) -> Result<P> {
        P::get(self)
    }

    /// What the next column holds.
    pub fn cell<T: Stored>(&mut self) -> Result<T, sqlx::Error> {
        let cell = self.row.cell(self.next).map_err(|error| match error {
            sqlx::Error::ColumnDecode { source, .. } => {
                sqlx::Error::ColumnDecode { index: format!("{:?}", self.row.name(self.next)), source }
            }
            other => other,
        });
        self.next += 1;
        cell
    }

    /// That the last column holds what it should not.
    pub fn unknown(&self) -> StoreError {
        StoreError::damaged(format_args!("unknown {}", self.row.name(self.next - 1)))
    }
}
