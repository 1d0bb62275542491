//! Where names of earlier versions, and those that were copied from a file, are at home.

use sqlx::{AssertSqlSafe, PgConnection};

use crate::store::cells::cell_of;
use crate::store::error::Result;

/// Names of one transaction.
const AT_ONCE: i64 = 10_000;

/// Which names have none, each with its cell where that is not by its name: of a gyro that of the IMU in which it was
/// first seen; one that only a bench has seen has none.
const WITHOUT: [(&str, &str); 3] = [
    ("imu", "SELECT id, name, CAST(NULL AS BIGINT) FROM imu WHERE cell IS NULL ORDER BY id LIMIT $1"),
    ("station", "SELECT id, name, CAST(NULL AS BIGINT) FROM station WHERE cell IS NULL ORDER BY id LIMIT $1"),
    (
        "gyro",
        "SELECT gyro.id, gyro.serial, (SELECT imu.cell FROM history JOIN record ON record.id = history.record
             JOIN imu ON imu.id = record.imu WHERE history.gyro = gyro.id ORDER BY history.calibrated_at LIMIT 1)
         FROM gyro WHERE cell IS NULL ORDER BY id LIMIT $1",
    ),
];

/// Gives a cell to every name that has none. Broken off, it goes on where it stopped.
pub(super) async fn give(connection: &mut PgConnection) -> Result<()> {
    for (table, without) in WITHOUT {
        let set = format!(
            "UPDATE {table} SET cell = given.cell
             FROM unnest(CAST($1 AS BIGINT[]), CAST($2 AS BIGINT[])) AS given(id, cell) WHERE {table}.id = given.id"
        );
        let mut given = 0;
        loop {
            let found: Vec<(i64, String, Option<i64>)> =
                sqlx::query_as(without).bind(AT_ONCE).fetch_all(&mut *connection).await?;
            if found.is_empty() {
                break;
            }
            let cell = |name: &str, cell: Option<i64>| cell.unwrap_or_else(|| i64::from(cell_of(name)));
            let (ids, cells): (Vec<i64>, Vec<i64>) =
                found.into_iter().map(|(id, name, found)| (id, cell(&name, found))).unzip();
            given += ids.len();
            sqlx::query(AssertSqlSafe(set.clone())).bind(ids).bind(cells).execute(&mut *connection).await?;
            tracing::info!(table, given, "names are given the cells in which they are at home");
        }
    }
    Ok(())
}
