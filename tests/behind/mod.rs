//! What is done to a database in a file behind the service's back, so that only the database knows.

use std::path::Path;

use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions, Connection, SqliteConnection};

/// Has the database refuse records that have the word in them.
pub const POISON: &str =
    "CREATE TRIGGER poison BEFORE INSERT ON record WHEN instr(CAST(NEW.body AS TEXT), 'POISON') > 0
     BEGIN SELECT raise(ABORT, 'poisoned'); END";

pub async fn open(database: &Path) -> SqliteConnection {
    SqliteConnectOptions::new().filename(database).connect().await.unwrap()
}

/// To look only.
pub async fn read(database: &Path) -> SqliteConnection {
    SqliteConnectOptions::new().filename(database).read_only(true).connect().await.unwrap()
}

pub async fn execute(database: &Path, sql: &'static str) {
    let mut database = open(database).await;
    sqlx::raw_sql(sql).execute(&mut database).await.unwrap();
    database.close().await.unwrap();
}
