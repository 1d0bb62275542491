//! What the database knows of names: their numbers and cells, of those too that other servers have given out.

use std::collections::HashSet;
use std::hash::Hash;

use crate::store::cells::cell_of;
use crate::store::db::Readers;
use crate::store::error::StoreError;
use crate::store::handle::Store;
use crate::store::name_tables::{NamesOf, Table};
use crate::store::postgres::names::{read, select};

/// A number for a new name, beside the `new` ones of the same group: of a file the next, of a database server one at
/// random. A commit that a failover has lost may have been answered, so that its numbers are in use somewhere and
/// must not become another name's.
pub fn new_number(store: &Store, known: &Table, new: &Table) -> u32 {
    match store.readers {
        Readers::Sqlite(..) => known.last_number() + new.len() as u32 + 1,
        Readers::Postgres(..) => std::iter::repeat_with(|| rand::random_range(1..=i32::MAX.unsigned_abs()))
            .find(|number| [known, new].iter().all(|names| names.name(*number).is_none()))
            .expect("there are more numbers than names"),
    }
}

/// Has names that only other servers may know looked up: of IMUs, stations and gyros.
pub async fn look_up(store: &Store, names: [Vec<&str>; 3]) -> Result<(), StoreError> {
    let Readers::Postgres(readers, _) = &store.readers else { return Ok(()) };
    let Some([imus, stations, gyros]) = unknown(store, names, |table, name| table.number(name).is_some()) else {
        return Ok(());
    };
    let sql = select(["WHERE name = ANY($1)", "WHERE name = ANY($2)", "WHERE serial = ANY($3)"]);
    let found = sqlx::query_as(sql).bind(imus).bind(stations).bind(gyros).fetch_all(readers).await?;
    learn(store, read(found)?)
}

/// Those that are not known, each once; none where there are none.
fn unknown<T: Copy + Eq + Hash>(
    store: &Store,
    asked: [Vec<T>; 3],
    is_known: impl Fn(&Table, T) -> bool,
) -> Option<[Vec<T>; 3]> {
    let tables = store.names.read();
    let [imus, stations, gyros] = asked;
    let unknown = [(&tables.imus, imus), (&tables.stations, stations), (&tables.gyros, gyros)]
        .map(|(table, asked)| asked.into_iter().filter(|one| !is_known(table, *one)).collect::<HashSet<T>>());
    unknown.iter().any(|some| !some.is_empty()).then(|| unknown.map(|some| some.into_iter().collect()))
}

/// As [`look_up`], of numbers of gyros.
pub async fn look_up_gyros(store: &Store, gyros: Vec<u32>) -> Result<(), StoreError> {
    look_up_numbers(store, [Vec::new(), Vec::new(), gyros]).await
}

/// Where an IMU is at home, known or not.
pub fn cell_of_imu(store: &Store, imu: &str) -> u8 {
    let tables = store.names.read();
    tables.imus.number(imu).and_then(|number| tables.imus.cell(number)).unwrap_or_else(|| cell_of(imu))
}

/// Where a gyro is at home, known or not; an IMU that brings a new one takes it into its own cell.
pub fn cell_of_gyro(store: &Store, serial: &str) -> u8 {
    let tables = store.names.read();
    tables.gyros.number(serial).and_then(|number| tables.gyros.cell(number)).unwrap_or_else(|| cell_of(serial))
}

fn learn(store: &Store, found: Vec<(NamesOf, u32, u8, String)>) -> Result<(), StoreError> {
    store.names.change(|tables| {
        found.iter().try_for_each(|(kind, number, cell, name)| tables.learn(*kind, *number, *cell, name))
    })
}

/// As [`look_up`], by numbers: a row of another server's may be read before the names that came with it were heard of.
pub(super) async fn look_up_numbers(store: &Store, numbers: [Vec<u32>; 3]) -> Result<(), StoreError> {
    let Readers::Postgres(readers, _) = &store.readers else { return Ok(()) };
    let Some(unknown) = unknown(store, numbers, |table, number| table.name(number).is_some()) else { return Ok(()) };
    let [imus, stations, gyros] = unknown.map(|some| some.into_iter().map(i64::from).collect::<Vec<_>>());
    let sql = select(["WHERE id = ANY($1)", "WHERE id = ANY($2)", "WHERE id = ANY($3)"]);
    let found = sqlx::query_as(sql).bind(imus).bind(stations).bind(gyros).fetch_all(readers).await?;
    learn(store, read(found)?)
}
