//! What one transaction writes: statements, each with many rows.
//!
//! SQLite is in the process: a statement is run once a row, whose cells are bound one by one. PostgreSQL is asked
//! once a statement: there the rows travel as one JSON array of arrays (numbers) and one run of bytes (everything
//! else) that the numbers point into.

use std::borrow::Cow;

use sqlx::{AssertSqlSafe, PgConnection};

use super::db::Sql;
use super::error::{Result, StoreError};
use super::rows::{ALL_ROWS, Columns, Rows};
use crate::store::sqlite::checksum::Summing;

/// A transaction under construction.
#[derive(Debug, Default)]
pub(crate) struct Batch(Vec<Statement>);

/// A statement with its rows.
#[derive(Debug)]
struct Statement {
    does: Words,
    rows: Rows,
    /// It is to find what each of its rows is about: where it does not, somebody else has changed that.
    finds_all: bool,
}

/// What a statement does: `$C0`, `$C1` and so on stand for the cells of one row, by their places, and `$ROWS` in
/// PostgreSQL's words for all rows.
#[derive(Debug)]
enum Words {
    Change { does: Cow<'static, str>, which: Cow<'static, str> },
    Insert { table: &'static str, columns: &'static str, on_conflict: OnConflict },
    OfEach(Sql<Cow<'static, str>>),
}

impl Statement {
    fn of_sqlite(&self) -> String {
        match &self.does {
            Words::Change { does, which } => self.rows.of_sqlite(&format!("{does} WHERE {which}")),
            Words::Insert { table, columns, on_conflict } => {
                let (cells, then) = (self.rows.cells_of_sqlite(), on_conflict.words(columns));
                format!("INSERT INTO {table} ({columns}) VALUES ({cells}) {then}")
            }
            Words::OfEach(words) => self.rows.of_sqlite(&words.sqlite),
        }
    }

    fn of_postgres(&self) -> String {
        match &self.does {
            Words::Change { does, which } => {
                let beside = match does.split(' ').next() {
                    Some("UPDATE") => "FROM",
                    Some("DELETE") => "USING",
                    _ => "CROSS JOIN",
                };
                self.rows.of_postgres(&format!("{does} {beside} $ROWS WHERE {which}"))
            }
            Words::Insert { table, columns, on_conflict } => {
                let (cells, then) = (self.rows.cells_of_postgres(), on_conflict.words(columns));
                format!("INSERT INTO {table} ({columns}) SELECT {cells} FROM {ALL_ROWS} WHERE true {then}")
            }
            Words::OfEach(words) => self.rows.of_postgres(&words.postgres),
        }
    }
}

/// What becomes of a row whose key is there already.
#[derive(Debug, Clone, Copy)]
pub(crate) enum OnConflict {
    /// Nothing is written at all.
    Fail,
    /// What is there stays.
    Keep,
    /// These columns take the new values.
    Set(&'static str, &'static [&'static str]),
    /// All columns take the new values, but for the key and these.
    SetAllBut(&'static str, &'static [&'static str]),
}

impl OnConflict {
    /// As SQL, where rows come into `columns`.
    fn words(self, columns: &str) -> String {
        let set = |key: &str, columns: &mut dyn Iterator<Item = &str>| {
            let new: Vec<String> = columns.map(|column| format!("{column} = excluded.{column}")).collect();
            format!("ON CONFLICT ({key}) DO UPDATE SET {}", new.join(", "))
        };
        match self {
            Self::Fail => String::new(),
            Self::Keep => "ON CONFLICT DO NOTHING".to_owned(),
            Self::Set(key, columns) => set(key, &mut columns.iter().copied()),
            Self::SetAllBut(key, kept) => {
                let of_key = |column: &str| key.split(", ").any(|part| part == column);
                set(key, &mut columns.split(", ").filter(|one| !of_key(one) && !kept.contains(one)))
            }
        }
    }
}

/// SQLite's page size.
const PAGE: usize = 4096;

impl Batch {
    /// Appends a statement for each row, unless there are none: what it does, `"UPDATE alert SET rule = $C1"`, and
    /// `which` rows of the table are meant, `"id = $C0"`. An insert names the tables that it selects from.
    pub fn change(&mut self, does: impl Into<Cow<'static, str>>, which: impl Into<Cow<'static, str>>, rows: Rows) {
        self.push(Words::Change { does: does.into(), which: which.into() }, rows);
    }

    /// As [`Batch::change`], where the two databases are to be asked in words of their own.
    pub fn add(&mut self, words: Sql<impl Into<Cow<'static, str>>>, rows: Rows) {
        self.push(Words::OfEach(Sql { sqlite: words.sqlite.into(), postgres: words.postgres.into() }), rows);
    }

    /// As [`Batch::add`], where nothing may be committed to a server unless the statement changes something for each row.
    pub fn add_to_all(&mut self, words: Sql<impl Into<Cow<'static, str>>>, rows: Rows) {
        let there = self.0.len();
        self.add(words, rows);
        self.0[there..].iter_mut().for_each(|statement| statement.finds_all = true);
    }

    /// Appends the rows to `table`, each a cell a column: `"id, name"`.
    pub fn insert(&mut self, table: &'static str, columns: &'static str, on_conflict: OnConflict, rows: Rows) {
        self.push(Words::Insert { table, columns, on_conflict }, rows);
    }

    fn push(&mut self, does: Words, rows: Rows) {
        if !rows.ends.is_empty() {
            self.0.push(Statement { does, rows, finds_all: false });
        }
    }

    /// As [`Batch::insert`], where the type of a row says which columns it has.
    pub fn enter<'a, T: Columns + 'a>(&mut self, all: impl IntoIterator<Item = &'a T>, on_conflict: OnConflict) {
        self.insert(T::TABLE, T::COLUMNS, on_conflict, Rows::each(all, T::put));
    }

    /// Roughly how many pages of SQLite's log it takes.
    pub fn pages(&self) -> u32 {
        self.0.iter().map(|Statement { rows, .. }| (rows.ends.len() + rows.bytes.len() / PAGE) as u32).sum()
    }

    /// Runs everything and commits; after an error nothing of it remains. Waits for the disk.
    pub fn commit(&self, connection: &Summing) -> Result<()> {
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
        for statement in &self.0 {
            statement.rows.run(&mut connection.prepare_cached(&statement.of_sqlite())?)?;
        }
        connection.write()?;
        connection.prepare_cached("COMMIT")?.execute(())?;
        Ok(())
    }

    /// Runs everything within the transaction that is open.
    pub async fn run(self, connection: &mut PgConnection) -> Result<()> {
        for statement in self.0 {
            let postgres = statement.of_postgres();
            let Statement { rows, finds_all, .. } = statement;
            let wanted = rows.ends.len() as u64;
            let has_bytes = postgres.contains("$2");
            let query = sqlx::query(AssertSqlSafe(postgres)).bind(rows.json());
            let query = if has_bytes { query.bind(rows.bytes) } else { query };
            let found = query.execute(&mut *connection).await?.rows_affected();
            if finds_all && found != wanted {
                return Err(StoreError::Overtaken(format!("{found} of {wanted} rows are as they were read")));
            }
        }
        Ok(())
    }
}
