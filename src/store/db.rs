//! One query on either database: SQLite or PostgreSQL.
//!
//! Most texts are understood by both; where they are not, the two stand side by side as a [`Sql`]. What is asked
//! about is bound, never part of a text, and each database is spoken to in its own words.

use std::future::ready;

use futures::{Stream, TryStreamExt};
use sqlx::encode::IsNull;
use sqlx::error::BoxDynError;
use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::postgres::PgArgumentBuffer;
use sqlx::sqlite::SqliteArgumentsBuffer;
use sqlx::{Database, Decode, Encode, Postgres, SqlSafeStr, Sqlite, SqlitePool, Type};

use super::error::Result;
pub(super) use super::postgres::PgReaders;
use crate::core::id::Id;

/// Connections that read.
#[derive(Debug, Clone)]
pub(crate) enum Readers {
    Sqlite(SqlitePool),
    Postgres(PgReaders),
}

/// The same in the words of each database.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sql {
    pub sqlite: &'static str,
    pub postgres: &'static str,
}

impl Readers {
    pub fn words(&self, sql: Sql) -> &'static str {
        match self {
            Self::Sqlite(_) => sql.sqlite,
            Self::Postgres(_) => sql.postgres,
        }
    }

    /// The whole numbers of a list in JSON, in `parameter`: `"$1"`.
    pub fn list(&self, parameter: &str) -> String {
        match self {
            Self::Sqlite(_) => format!("(SELECT value FROM json_each({parameter}))"),
            Self::Postgres(_) => format!(
                "(SELECT CAST(j.value AS BIGINT) FROM jsonb_array_elements_text(CAST({parameter} AS JSONB)) AS j(value))"
            ),
        }
    }

    /// Of several questions on one connection: they end together within the limit of one.
    pub async fn within_limit<T>(&self, work: impl Future<Output = Result<T>>) -> Result<T> {
        match self {
            Self::Sqlite(_) => work.await,
            Self::Postgres(readers) => readers.within_limit(work).await,
        }
    }

    pub async fn close(&self) {
        match self {
            Self::Sqlite(pool) => pool.close().await,
            Self::Postgres(pool) => pool.close().await,
        }
    }
}

/// What `read` makes of each row as it comes. Rows in wait take many times the memory of what is made of them.
pub(crate) async fn each<R, T>(
    rows: impl Stream<Item = Result<R, sqlx::Error>>,
    read: impl Fn(&R) -> Result<T>,
) -> Result<Vec<T>> {
    rows.err_into().and_then(|row| ready(read(&row))).try_collect().await
}

/// Runs `$query` on whichever database `$readers` are of; in it `$db` is the pool.
macro_rules! on {
    ($readers:expr, $db:ident => $query:expr) => {
        match &$readers {
            $crate::store::db::Readers::Sqlite($db) => $query,
            $crate::store::db::Readers::Postgres($db) => $query,
        }
    };
}

/// `read!(store, query_as.fetch_all, sql, a, b)`: what a query with these parameters finds. With `all` and `first` each
/// row is read by the list of its type's columns, see [`super::columns`].
macro_rules! read {
    ($store:expr, all, $sql:expr $(, $bound:expr)* $(,)?) => {
        $crate::store::db::on!($store.readers, db => {
            let rows = sqlx::query($sql)$(.bind($bound))*.fetch(db);
            $crate::store::db::each(rows, $crate::store::rows::Columns::get_all).await
        })
    };
    ($store:expr, first, $sql:expr $(, $bound:expr)* $(,)?) => {
        $crate::store::db::on!($store.readers, db => {
            let row = sqlx::query($sql)$(.bind($bound))*.fetch_optional(db).await?;
            row.as_ref().map($crate::store::rows::Columns::get_all).transpose()
        })
    };
    ($store:expr, $query:ident.$fetch:ident, $sql:expr $(, $bound:expr)* $(,)?) => {
        $crate::store::db::on!($store.readers, db => sqlx::$query($sql)$(.bind($bound))*.$fetch(db).await?)
    };
}

pub(super) use {on, read};

/// Numbers of gyros, IMUs or stations as they were read.
pub(crate) fn numbers(rows: Vec<Whole<u32>>) -> Vec<u32> {
    rows.into_iter().map(|Whole(number)| number).collect()
}

/// What brings a schema up to date, of migrations by number and name.
pub(super) fn migrator(migrations: &[(i64, &'static str, &'static str)]) -> Migrator {
    let migration = |(version, name, sql): &(i64, &'static str, &'static str)| {
        Migration::new(*version, (*name).into(), MigrationType::Simple, sql.into_sql_str(), false)
    };
    Migrator::with_migrations(migrations.iter().map(migration).collect())
}

/// Conditions with a parameter each, from `$first` on: each by itself, so that it finds its index; one that is not asked
/// for is no condition.
pub(crate) fn asked<const N: usize>(first: usize, conditions: [(bool, &str); N]) -> String {
    let one = |(parameter, (is_asked, words)): (usize, (bool, &str))| match is_asked {
        true => words.to_owned(),
        false => format!("${parameter} IS NULL"),
    };
    (first..).zip(conditions).map(one).collect::<Vec<_>>().join(" AND ")
}

/// A list for [`Readers::list`].
pub(crate) fn list_of<'a>(ids: impl IntoIterator<Item = &'a Id>) -> String {
    serde_json::Value::from_iter(ids.into_iter().map(|id| id.0)).to_string()
}

/// What `count(*)` finds.
pub(crate) fn counted(count: i64) -> usize {
    count.unsigned_abs() as usize
}

/// For `LIMIT` and `OFFSET`.
pub(crate) fn at_most(rows: usize) -> i64 {
    i64::try_from(rows).unwrap_or(i64::MAX)
}

/// A whole number that is narrower here than in the database, where all are 64 bits wide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Whole<T>(pub T);

macro_rules! whole {
    ($database:ty, $buffer:ty) => {
        impl<T> Type<$database> for Whole<T> {
            fn type_info() -> <$database as Database>::TypeInfo {
                <i64 as Type<$database>>::type_info()
            }

            fn compatible(found: &<$database as Database>::TypeInfo) -> bool {
                <i64 as Type<$database>>::compatible(found)
            }
        }

        impl<'r, T: TryFrom<i64, Error: std::error::Error + Send + Sync + 'static>> Decode<'r, $database> for Whole<T> {
            fn decode(value: <$database as Database>::ValueRef<'r>) -> Result<Self, BoxDynError> {
                Ok(Self(T::try_from(<i64 as Decode<$database>>::decode(value)?)?))
            }
        }

        impl<'q, T: Copy + Into<i64>> Encode<'q, $database> for Whole<T> {
            fn encode_by_ref(&self, buffer: &mut $buffer) -> Result<IsNull, BoxDynError> {
                <i64 as Encode<'q, $database>>::encode(self.0.into(), buffer)
            }
        }
    };
}

whole!(Sqlite, SqliteArgumentsBuffer);
whole!(Postgres, PgArgumentBuffer);
