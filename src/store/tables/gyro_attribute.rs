//! What a laboratory says of its gyros.

use super::*;
use crate::core::gyro_attributes::GyroAttributes;

/// A gyro, and what is said of it from now on.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroAttributeRow {
    pub gyro: u32,
    pub attributes: GyroAttributes,
}

part! {
    GyroAttributes { batch, r#type, unit }
}

/// The last row of a gyro holds.
pub(crate) fn upsert(changed: &[GyroAttributeRow], batch: &mut Batch) {
    let last: HashMap<u32, &GyroAttributes> = changed.iter().map(|row| (row.gyro, &row.attributes)).collect();
    let rows = Rows::each(last, |(gyro, attributes), row| _ = row.put(&gyro).put(attributes));
    batch.insert("gyro_attribute", "gyro, batch, type, unit", OnConflict::SetAllBut("gyro", &[]), rows);
}

/// Of these gyros, those of which something is said.
pub async fn of(store: &Store, gyros: &[u32]) -> Result<HashMap<u32, GyroAttributes>> {
    let those = store.readers.list("$1");
    let sql = AssertSqlSafe(format!("SELECT gyro, batch, type, unit FROM gyro_attribute WHERE gyro IN {those}"));
    let rows: Vec<(u32, GyroAttributes)> = read!(store, all, sql, gyros)?;
    Ok(rows.into_iter().collect())
}

/// Gyros of the batches that these are of, each with the one of these.
pub async fn mates(store: &Store, gyros: &[u32]) -> Result<BTreeMap<u32, u32>> {
    if gyros.is_empty() {
        return Ok(BTreeMap::new());
    }
    let sql = AssertSqlSafe(format!(
        "SELECT mate.gyro, known.gyro FROM gyro_attribute AS known
         JOIN gyro_attribute AS mate ON mate.batch = known.batch WHERE known.gyro IN {}",
        store.readers.list("$1")
    ));
    let rows: Vec<(u32, u32)> = read!(store, all, sql, gyros)?;
    Ok(rows.into_iter().collect())
}
