//! Names that other servers have given numbers to.

use sqlx::PgPool;

use crate::store::db::{Readers, Whole};
use crate::store::error::StoreError;
use crate::store::names::{Names, Table};
use crate::store::open::Store;
use crate::store::record::RecordRow;

/// Learns the names that came after those that are known.
///
/// # Errors
/// [`StoreError`]; then what was known before is known.
pub(super) async fn learn_new(readers: &PgPool, names: &Names) -> Result<(), StoreError> {
    let known = {
        let tables = names.read();
        [&tables.imus, &tables.stations, &tables.gyros].map(Table::len)
    };
    let sql = "SELECT 0 AS kind, id, name FROM imu WHERE id > $1
               UNION ALL SELECT 1, id, name FROM station WHERE id > $2
               UNION ALL SELECT 2, id, serial FROM gyro WHERE id > $3 ORDER BY kind, id";
    let mut query = sqlx::query_as(sql);
    for len in known {
        query = query.bind(len as i64);
    }
    let rows: Vec<(i32, Whole<u32>, String)> = query.fetch_all(readers).await?;
    let mut fresh: [Vec<(u32, String)>; 3] = Default::default();
    for (kind, Whole(number), name) in rows {
        let place = fresh.get_mut(kind.unsigned_abs() as usize);
        place.into_iter().for_each(|kind| kind.push((number, name.clone())));
    }
    let mut whole = true;
    names.change(|tables| {
        for (table, fresh) in [&mut tables.imus, &mut tables.stations, &mut tables.gyros].into_iter().zip(&fresh) {
            whole &= fresh.iter().all(|(number, name)| table.learn(*number, name));
        }
    });
    if whole { Ok(()) } else { Err(StoreError::Damaged("the numbers of names are out of sequence".to_owned())) }
}

impl Store {
    /// A row of another server's may be read before the names that came with it were heard of.
    ///
    /// # Errors
    /// As [`learn_new`].
    pub(in crate::store) async fn know_names_of(&self, row: &RecordRow) -> Result<(), StoreError> {
        let Readers::Postgres(readers) = &self.readers else { return Ok(()) };
        let are_known = {
            let tables = self.names.read();
            tables.imus.name(row.imu).is_some()
                && tables.stations.name(row.station).is_some()
                && row.verdicts.0.iter().all(|(gyro, _)| tables.gyros.name(*gyro).is_some())
        };
        if are_known { Ok(()) } else { learn_new(readers, &self.names).await }
    }
}
