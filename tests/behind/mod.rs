//! What is done to a database in a file behind the service's back, so that only the database knows.

use std::path::Path;

use sqlx::ConnectOptions;
use sqlx::sqlite::SqliteConnectOptions;

/// Has the database refuse records that have the word in them.
pub const POISON: &str =
    "CREATE TRIGGER poison BEFORE INSERT ON record WHEN instr(CAST(NEW.body AS TEXT), 'POISON') > 0
     BEGIN SELECT raise(ABORT, 'poisoned'); END";

pub async fn execute(database: &Path, sql: &'static str) {
    let mut database = SqliteConnectOptions::new().filename(database).connect().await.unwrap();
    sqlx::raw_sql(sql).execute(&mut database).await.unwrap();
}
