//! What one transaction writes: statements, each with many rows.
//!
//! SQLite is in the process: a statement is run once a row, whose cells are bound one by one. PostgreSQL is asked
//! once a statement: there the rows travel as one JSON array of arrays (numbers) and one run of bytes (everything
//! else) that the numbers point into.

use sqlx::{AssertSqlSafe, PgConnection};

use super::error::{Result, StoreError};
use super::rows::{Columns, Rows};
use crate::store::sqlite::checksum::Summing;

/// A transaction under construction.
#[derive(Debug, Default)]
pub(crate) struct Batch(Vec<Statement>);

/// A statement with its rows, in the words of each database: `$C0`, `$C1` and so on stand for the cells of one row, by
/// their places, and `$ROWS` in PostgreSQL's for all rows.
#[derive(Debug)]
struct Statement {
    sqlite: String,
    postgres: String,
    rows: Rows,
    /// It is to find what each of its rows is about: where it does not, somebody else has changed that.
    finds_all: bool,
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
    pub fn change(&mut self, does: &str, which: &str, rows: Rows) {
        let beside = match does.split(' ').next() {
            Some("UPDATE") => "FROM",
            Some("DELETE") => "USING",
            _ => "CROSS JOIN",
        };
        self.add(&format!("{does} WHERE {which}"), &format!("{does} {beside} $ROWS WHERE {which}"), rows);
    }

    /// As [`Batch::change`], where the two databases are to be asked in words of their own.
    pub fn add(&mut self, sqlite: &str, postgres: &str, rows: Rows) {
        if !rows.ends.is_empty() {
            let (sqlite, postgres) = (rows.of_sqlite(sqlite), rows.of_postgres(postgres));
            self.0.push(Statement { sqlite, postgres, rows, finds_all: false });
        }
    }

    /// As [`Batch::add`], where nothing may be committed to a server unless the statement changes something for each row.
    pub fn add_to_all(&mut self, sqlite: &str, postgres: &str, rows: Rows) {
        let there = self.0.len();
        self.add(sqlite, postgres, rows);
        self.0[there..].iter_mut().for_each(|statement| statement.finds_all = true);
    }

    /// Appends the rows to `table`, each a cell a column: `"id, name"`.
    pub fn insert(&mut self, table: &str, columns: &str, on_conflict: OnConflict, rows: Rows) {
        let (into, then) = (format!("INSERT INTO {table} ({columns})"), on_conflict.words(columns));
        let cells = rows.places().map(|place| format!("$C{place}")).collect::<Vec<_>>().join(", ");
        let sqlite = format!("{into} VALUES ({cells}) {then}");
        self.add(&sqlite, &format!("{into} SELECT {cells} FROM $ROWS WHERE true {then}"), rows);
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
        for Statement { sqlite, rows, .. } in &self.0 {
            rows.run(&mut connection.prepare_cached(sqlite)?)?;
        }
        connection.write()?;
        connection.prepare_cached("COMMIT")?.execute(())?;
        Ok(())
    }

    /// Runs everything within the transaction that is open.
    pub async fn run(self, connection: &mut PgConnection) -> Result<()> {
        for Statement { postgres, rows, finds_all, .. } in self.0 {
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
