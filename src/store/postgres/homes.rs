//! Where names of earlier versions, and those that were copied from a file, are at home.

use sqlx::PgConnection;

use crate::store::cells::cell_of;
use crate::store::error::StoreError;

/// Names of one transaction.
const AT_ONCE: i64 = 10_000;

/// Of IMUs and stations by their names.
const NAMED: [(&str, &str); 2] = [
    (
        "SELECT id, name FROM imu WHERE cell IS NULL ORDER BY id LIMIT $1",
        "UPDATE imu SET cell = given.cell FROM unnest(CAST($1 AS BIGINT[]), CAST($2 AS BIGINT[])) AS given(id, cell) WHERE imu.id = given.id",
    ),
    (
        "SELECT id, name FROM station WHERE cell IS NULL ORDER BY id LIMIT $1",
        "UPDATE station SET cell = given.cell FROM unnest(CAST($1 AS BIGINT[]), CAST($2 AS BIGINT[])) AS given(id, cell) WHERE station.id = given.id",
    ),
];
/// Of gyros by the IMU in which each was first seen; one that only a bench has seen has none.
const GYROS: (&str, &str) = (
    "SELECT gyro.id, gyro.serial, (SELECT imu.cell FROM history JOIN record ON record.id = history.record
         JOIN imu ON imu.id = record.imu WHERE history.gyro = gyro.id ORDER BY history.calibrated_at LIMIT 1)
     FROM gyro WHERE cell IS NULL ORDER BY id LIMIT $1",
    "UPDATE gyro SET cell = given.cell FROM unnest(CAST($1 AS BIGINT[]), CAST($2 AS BIGINT[])) AS given(id, cell) WHERE gyro.id = given.id",
);

/// Gives a cell to every name that has none. Broken off, it goes on where it stopped.
///
/// # Errors
/// [`StoreError`].
pub(super) async fn give(connection: &mut PgConnection) -> Result<(), StoreError> {
    for (ask, set) in NAMED {
        loop {
            let found: Vec<(i64, String)> = sqlx::query_as(ask).bind(AT_ONCE).fetch_all(&mut *connection).await?;
            if found.is_empty() {
                break;
            }
            let (ids, cells): (Vec<i64>, Vec<i64>) =
                found.into_iter().map(|(id, name)| (id, i64::from(cell_of(&name)))).unzip();
            sqlx::query(set).bind(ids).bind(cells).execute(&mut *connection).await?;
        }
    }
    let mut given = 0;
    loop {
        let (ask, set) = GYROS;
        let found: Vec<(i64, String, Option<i64>)> =
            sqlx::query_as(ask).bind(AT_ONCE).fetch_all(&mut *connection).await?;
        if found.is_empty() {
            return Ok(());
        }
        let cell = |serial: &str, cell: Option<i64>| cell.unwrap_or_else(|| i64::from(cell_of(serial)));
        let (ids, cells): (Vec<i64>, Vec<i64>) =
            found.into_iter().map(|(id, serial, found)| (id, cell(&serial, found))).unzip();
        given += ids.len();
        sqlx::query(set).bind(ids).bind(cells).execute(&mut *connection).await?;
        tracing::info!(gyros = given, "gyros are given the cells in which they are at home");
    }
}
