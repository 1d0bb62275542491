//! One query on either database: SQLite or PostgreSQL.
//!
//! Most texts are understood by both; where they are not, the two stand side by side as a [`Sql`]. What is asked
//! about is bound, never part of a text, and each database is spoken to in its own words.

use std::future::ready;
use std::path::PathBuf;

use futures::{Stream, TryStreamExt};
use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::{SqlSafeStr, SqlitePool};

use super::error::Result;
use super::postgres::OtherServers;
pub(super) use super::postgres::PgReaders;
use super::rows::{AnyRow, Part};
use crate::core::id::Id;
use crate::core::named::Named;
use crate::core::time::UtcMicros;

/// Connections that read, and where the database is that they are of.
#[derive(Debug, Clone)]
pub(crate) enum Readers {
    Sqlite(SqlitePool, PathBuf),
    /// Other servers may use it too.
    Postgres(PgReaders, OtherServers),
}

/// The same in the words of each database.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sql<T = &'static str> {
    pub sqlite: T,
    pub postgres: T,
}

impl Readers {
    pub fn words(&self, sql: Sql) -> &'static str {
        match self {
            Self::Sqlite(..) => sql.sqlite,
            Self::Postgres(..) => sql.postgres,
        }
    }

    /// The whole numbers of a list in JSON, in `parameter`: `"$1"`.
    pub fn list(&self, parameter: &str) -> String {
        match self {
            Self::Sqlite(..) => format!("(SELECT value FROM json_each({parameter}))"),
            Self::Postgres(..) => format!(
                "(SELECT CAST(j.value AS BIGINT) FROM jsonb_array_elements_text(CAST({parameter} AS JSONB)) AS j(value))"
            ),
        }
    }

    pub async fn close(&self) {
        match self {
            Self::Sqlite(pool, _) => pool.close().await,
            Self::Postgres(pool, _) => pool.close().await,
        }
    }
}

/// What each row holds, read as it comes: rows in wait take many times the memory of what is made of them.
pub(crate) async fn each<R: AnyRow, P: Part>(rows: impl Stream<Item = Result<R, sqlx::Error>>) -> Result<Vec<P>> {
    rows.err_into().and_then(|row| ready(row.whole())).try_collect().await
}

/// Runs `$query` on whichever database `$readers` are of; in it `$db` is the pool.
macro_rules! on {
    ($readers:expr, $db:ident => $query:expr) => {
        match &$readers {
            $crate::store::db::Readers::Sqlite($db, _) => $query,
            $crate::store::db::Readers::Postgres($db, _) => $query,
        }
    };
}

/// `read!(store, all, sql, a, b)`: what a query with these parameters finds, each row read as a [`Part`]; the `first`
/// row if there is any, or the `one` that there is.
macro_rules! read {
    ($store:expr, all, $sql:expr $(, $bound:expr)* $(,)?) => {
        $crate::store::db::on!($store.readers, db => {
            $crate::store::db::each(sqlx::query($sql)$(.bind($crate::store::db::Bound::bound($bound)))*.fetch(db)).await
        })
    };
    ($store:expr, first, $sql:expr $(, $bound:expr)* $(,)?) => {
        $crate::store::db::on!($store.readers, db => {
            let row = sqlx::query($sql)$(.bind($crate::store::db::Bound::bound($bound)))*.fetch_optional(db).await?;
            row.as_ref().map($crate::store::rows::AnyRow::whole).transpose()
        })
    };
    ($store:expr, one, $sql:expr $(, $bound:expr)* $(,)?) => {
        $crate::store::db::on!($store.readers, db => {
            let row = sqlx::query($sql)$(.bind($crate::store::db::Bound::bound($bound)))*.fetch_one(db).await?;
            $crate::store::rows::AnyRow::whole(&row)
        })
    };
}

pub(super) use {on, read};

/// A migration by its file's name, and what it does.
pub(super) type MigrationFile = (&'static str, &'static str);

/// `migrations! { "sqlite": "0001_history" "0002_alerts" }`: those of a directory, oldest first.
macro_rules! migrations {
    ($of:literal: $($file:literal)+) => {
        [$(($file, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/migrations/", $of, "/", $file, ".sql")))),+]
    };
}

pub(super) use migrations;

/// `0001_history` is number 1, `history`.
fn numbered(file: &'static str) -> (i64, &'static str) {
    let (number, name) = file.split_once('_').expect("a migration has a number and a name");
    (number.parse().expect("its number is one"), name)
}

/// The number of the newest.
pub(super) fn newest_of(migrations: &[MigrationFile]) -> Option<i64> {
    migrations.last().map(|(file, _)| numbered(file).0)
}

/// What brings a schema up to date.
pub(super) fn migrator(migrations: &[MigrationFile]) -> Migrator {
    let migration = |(file, sql): &MigrationFile| {
        let (version, name) = numbered(file);
        Migration::new(version, name.into(), MigrationType::Simple, sql.into_sql_str(), false)
    };
    Migrator::with_migrations(migrations.iter().map(migration).collect())
}

/// Conditions with a parameter each, from `$first` on: each by itself, so that it finds its index; one that is not asked
/// for is no condition.
pub(crate) fn where_conditions<const N: usize>(first: usize, conditions: [(bool, &str); N]) -> String {
    let one = |(parameter, (is_asked, words)): (usize, (bool, &str))| match is_asked {
        true => words.to_owned(),
        false => format!("${parameter} IS NULL"),
    };
    (first..).zip(conditions).map(one).collect::<Vec<_>>().join(" AND ")
}

/// What a parameter is bound as: whole numbers are 64 bits wide in the database.
pub(crate) trait Bound {
    type SqlType;

    fn bound(self) -> Self::SqlType;
}

macro_rules! bound {
    ($of:ty as $bound:ty: $as:expr) => {
        impl Bound for $of {
            type SqlType = $bound;

            fn bound(self) -> $bound {
                let bound: fn($of) -> $bound = $as;
                bound(self)
            }
        }
    };
}

bound!(bool as bool: |value| value);
bound!(i64 as i64: |value| value);
bound!(f64 as f64: |value| value);
bound!(String as String: |value| value);
bound!(u32 as i64: i64::from);
bound!(usize as i64: |value| value.try_into().unwrap_or(i64::MAX));
bound!(Id as i64: |id| id.0);
bound!(UtcMicros as i64: |at| at.0);

impl<'a> Bound for &'a str {
    type SqlType = &'a str;

    fn bound(self) -> &'a str {
        self
    }
}

impl<N: Named> Bound for N {
    type SqlType = &'static str;

    fn bound(self) -> &'static str {
        self.name()
    }
}

impl<B: Bound> Bound for Option<B> {
    type SqlType = Option<B::SqlType>;

    fn bound(self) -> Option<B::SqlType> {
        self.map(B::bound)
    }
}

/// A list for [`Readers::list`].
impl<B: Bound<SqlType = i64> + Copy> Bound for &[B] {
    type SqlType = String;

    fn bound(self) -> String {
        serde_json::Value::from_iter(self.iter().map(|one| one.bound())).to_string()
    }
}

impl<B: Bound<SqlType = i64> + Copy> Bound for &Vec<B> {
    type SqlType = String;

    fn bound(self) -> String {
        self.as_slice().bound()
    }
}
