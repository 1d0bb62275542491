//! A checksum of every table of a database in a file, kept with each change: what is read later is what was written.
//!
//! SQLite's own check finds a broken tree and not a changed letter. Of each row the CRC-32 of its values is taken (as
//! SQL sees them, whatever way they are stored), and of each table their sum: it does not depend on the order of
//! rows, and a change takes the row's old CRC away and adds its new one. Triggers that only the writing connection
//! has (`TEMP`) tell of each change, so that no statement can forget to. A later version that stores something
//! otherwise comes with a migration, after which all are computed anew ([`settle`]).

use std::ops::Deref;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rusqlite::functions::FunctionFlags;
use rusqlite::types::{Null, ValueRef};
use rusqlite::{Connection, OpenFlags, params};

use crate::core::message::{Message, text};
use crate::message;
use crate::store::error::Result;

/// Sums stay below this: so do not overflow where SQLite adds two.
const MODULUS: i64 = 1 << 62;
/// Tables that have a checksum: all but itself, SQLite's own, and those of other programs, which write without it
/// (`_litestream_seq`).
const TABLES: &str = "SELECT name FROM sqlite_schema WHERE type = 'table' AND name <> 'checksum'
    AND name NOT GLOB 'sqlite_*' AND (name NOT GLOB '_*' OR name = '_sqlx_migrations')";
/// The migration that made the table of checksums.
const SINCE: i64 = 16;
/// What of the schema is a checksum's: of tables that have one, of their own, and views.
const SCHEMA: &str = "sqlite_schema";

/// Rows and sum of a table, or what a transaction adds to them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Sum {
    rows: i64,
    sum: i64,
}

impl Sum {
    fn add(&mut self, row: i64, sign: i64) {
        self.rows += sign;
        self.sum = (self.sum + sign * row).rem_euclid(MODULUS);
    }
}

/// CRC-32 of a row's values, each with its kind and length. A whole number is the same in a column of reals, where
/// SQLite stores it as one.
fn row_sum<'v>(values: impl Iterator<Item = ValueRef<'v>>) -> i64 {
    let mut hasher = crc32fast::Hasher::new();
    for value in values {
        let (kind, bytes): (u8, &[u8]) = match value {
            ValueRef::Null => (0, &[]),
            ValueRef::Integer(whole) => (1, &whole.to_le_bytes()),
            ValueRef::Real(real) if real == real.trunc() && real.abs() < 9e15 => (1, &(real as i64).to_le_bytes()),
            ValueRef::Real(real) => (2, &real.to_le_bytes()),
            ValueRef::Text(text) => (3, text),
            ValueRef::Blob(blob) => (4, blob),
        };
        hasher.update(&[kind]);
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    }
    i64::from(hasher.finalize())
}

/// Every row of a table, or of the schema, read.
fn table_sum(connection: &Connection, name: &str) -> rusqlite::Result<Sum> {
    let sql = if name == SCHEMA {
        // Where a table begins in the file is another place in every copy.
        format!(
            "SELECT type, name, tbl_name, sql FROM {SCHEMA}
             WHERE type = 'view' OR tbl_name = 'checksum' OR tbl_name IN ({TABLES})"
        )
    } else {
        format!("SELECT * FROM \"{name}\"")
    };
    let mut statement = connection.prepare(&sql)?;
    let columns = statement.column_count();
    let (mut rows, mut sum) = (statement.query(())?, Sum::default());
    while let Some(row) = rows.next()? {
        let values: Vec<ValueRef<'_>> = (0..columns).map(|column| row.get_ref(column)).collect::<Result<_, _>>()?;
        sum.add(row_sum(values.into_iter()), 1);
    }
    Ok(sum)
}

fn tables(connection: &Connection) -> rusqlite::Result<Vec<String>> {
    connection.prepare(TABLES)?.query_map((), |row| row.get(0))?.collect()
}

fn newest_migration(connection: &Connection) -> rusqlite::Result<i64> {
    connection.query_row("SELECT max(version) FROM _sqlx_migrations", (), |row| row.get(0))
}

fn is_kept(connection: &Connection) -> rusqlite::Result<bool> {
    connection.query_row("SELECT count(*) FROM sqlite_schema WHERE name = 'checksum'", (), |row| row.get(0))
}

/// Computes the checksums of a database that has none of its version: once after an upgrade, reading everything.
pub(crate) fn settle(connection: &Connection) -> Result<()> {
    let version = newest_migration(connection)?;
    let known = "SELECT count(*) > 0 AND min(version) = $1 AND max(version) = $1 FROM checksum";
    if connection.query_row(known, [version], |row| row.get(0))? {
        return Ok(());
    }
    connection.execute_batch("BEGIN IMMEDIATE; DELETE FROM checksum")?;
    let computed = (|| {
        for name in tables(connection)?.iter().map(String::as_str).chain([SCHEMA]) {
            let Sum { rows, sum } = table_sum(connection, name)?;
            connection.execute("INSERT INTO checksum VALUES ($1, $2, $3, $4)", params![name, version, rows, sum])?;
        }
        connection.execute_batch("COMMIT")
    })();
    if computed.is_err() {
        let _nothing_left = connection.execute_batch("ROLLBACK");
    }
    Ok(computed?)
}

/// Reads every table of the database in `file` and says which are not as they were written. Nothing where there are
/// no checksums yet: a file of an earlier version.
pub(crate) fn check(file: &Path) -> Result<Vec<Message>> {
    let connection = Connection::open_with_flags(file, OpenFlags::SQLITE_OPEN_READ_ONLY)?;
    // All as of one moment.
    connection.execute_batch("BEGIN")?;
    if !is_kept(&connection)? {
        let lost = newest_migration(&connection)? >= SINCE;
        return Ok(if lost { vec![message!("checksums_missing")] } else { Vec::new() });
    }
    let mut statement = connection.prepare("SELECT name, version, rows, sum FROM checksum")?;
    let kept = statement.query_map((), |row| {
        Ok((row.get::<_, String>(0)?, row.get::<_, i64>(1)?, Sum { rows: row.get(2)?, sum: row.get(3)? }))
    })?;
    let kept: Vec<(String, i64, Sum)> = kept.collect::<Result<_, _>>()?;
    let version = newest_migration(&connection)?;
    // A start that was cut off between a migration and the checksums; the next one computes them.
    if kept.iter().all(|(_, of, _)| *of < version) {
        return Ok(Vec::new());
    }
    let mut faults = Vec::new();
    let tables = tables(&connection)?;
    for name in tables.iter().map(String::as_str).chain([SCHEMA]) {
        let found = table_sum(&connection, name)?;
        let entry = kept.iter().find(|(kept, of, _)| kept == name && *of == version);
        match entry {
            None => faults.push(message!("table_unsummed", table = name.to_owned())),
            Some((_, _, sum)) if *sum == found => {}
            Some((_, _, Sum { rows, .. })) if *rows != found.rows => {
                let (have, written) = (text(found.rows), text(rows));
                faults.push(message!("table_of_other_length", table = name.to_owned(), have, written));
            }
            Some(_) => faults.push(message!("table_changed", table = name.to_owned())),
        }
    }
    if kept.len() != tables.len() + 1 {
        faults.push(message!("summed_table_missing"));
    }
    Ok(faults)
}

/// A connection that writes, and keeps the checksums with every change.
#[derive(Debug)]
pub(crate) struct Summing {
    connection: Connection,
    names: Vec<String>,
    /// What the transaction under way adds to each.
    changed: Changed,
}

#[derive(Debug, Clone)]
struct Changed(Arc<Mutex<Vec<Sum>>>);

impl Changed {
    fn lock(&self) -> MutexGuard<'_, Vec<Sum>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Deref for Summing {
    type Target = Connection;

    fn deref(&self) -> &Connection {
        &self.connection
    }
}

impl Summing {
    /// Over a database whose checksums are settled, or one of an earlier version, which has none.
    pub fn over(connection: Connection) -> Result<Self> {
        let names = if is_kept(&connection)? { tables(&connection)? } else { Vec::new() };
        let changed = Changed(Arc::new(Mutex::new(vec![Sum::default(); names.len()])));
        let told = changed.clone();
        connection.create_scalar_function("row_changed", -1, FunctionFlags::SQLITE_UTF8, move |row| {
            let (table, sign) = (row.get::<u32>(0)? as usize, row.get::<i64>(1)?);
            let sum = row_sum((2..row.len()).map(|place| row.get_raw(place)));
            told.lock()[table].add(sum, sign);
            Ok(Null)
        })?;
        for (number, name) in names.iter().enumerate() {
            let columns: Vec<String> = {
                let mut statement = connection.prepare("SELECT name FROM pragma_table_info($1) ORDER BY cid")?;
                statement.query_map([name], |row| row.get(0))?.collect::<Result<_, _>>()?
            };
            let call = |which: &str, sign: i64| {
                let values: String = columns.iter().map(|column| format!(", {which}.\"{column}\"")).collect();
                format!("SELECT row_changed({number}, {sign}{values});")
            };
            let (gone, come) = (call("OLD", -1), call("NEW", 1));
            for (event, calls) in
                [("INSERT", come.clone()), ("DELETE", gone.clone()), ("UPDATE", format!("{gone} {come}"))]
            {
                connection.execute_batch(&format!(
                    "CREATE TEMP TRIGGER \"{name}_{event}\" AFTER {event} ON main.\"{name}\" BEGIN {calls} END"
                ))?;
            }
        }
        Ok(Self { connection, names, changed })
    }

    /// A transaction begins: what one before has told and not committed is forgotten.
    pub fn begin(&self) {
        self.changed.lock().fill(Sum::default());
    }

    /// Writes what the transaction under way has changed, as the last thing before it is committed.
    pub fn write(&self) -> rusqlite::Result<()> {
        for (name, Sum { rows, sum }) in self.names.iter().zip(self.changed.lock().iter()) {
            if (*rows, *sum) != (0, 0) {
                let sql = "UPDATE checksum SET rows = rows + $1, sum = (sum + $2) % $3 WHERE name = $4";
                self.connection.prepare_cached(sql)?.execute(params![rows, sum, MODULUS, name])?;
            }
        }
        Ok(())
    }

    /// Ends writing.
    pub fn into_inner(self) -> Connection {
        self.connection
    }
}
