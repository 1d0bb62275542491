//! Every gyro's newest row, for lists.

use std::collections::HashMap;

use crate::core::figures::Figures;
use crate::core::time::Span;
use crate::store;
use crate::store::db::{Whole, on};
use crate::store::error::StoreError;
use crate::store::open::Store;
use crate::store::packed::history_row::PACKED_LEN;

/// The newest row that counts of each gyro whose serial comes after that of gyro number `after` (0: all), by serial,
/// at most `limit`; none for a gyro that only a bench has seen. By number would be in no order at all: a database
/// server's numbers are random.
pub async fn newest_of_gyros(store: &Store, after: u32, limit: u32) -> Result<Vec<(u32, Option<Figures>)>, StoreError> {
    // Before the database is asked: see `SharedTail::read`.
    let waiting: HashMap<u32, Figures> = store.unplaced.tail.read().newest().map(|(gyro, row)| (gyro, *row)).collect();
    let sql =
        "SELECT id, (SELECT figures FROM history WHERE history.gyro = gyro.id ORDER BY calibrated_at DESC LIMIT 1)
               FROM gyro WHERE serial > coalesce((SELECT serial FROM gyro WHERE id = $1), '') ORDER BY serial LIMIT $2";
    let rows: Vec<(Whole<u32>, Option<Vec<u8>>)> =
        on!(store.readers, db => sqlx::query_as(sql).bind(Whole(after)).bind(Whole(limit)).fetch_all(db).await?);
    let mut newest = Vec::with_capacity(rows.len());
    for (Whole(gyro), packed) in rows {
        let folded = packed.map(|bytes| one(gyro, &bytes)).transpose()?;
        let waiting = waiting.get(&gyro).copied();
        // Of two with one instant the last is taken: the one that waits.
        let mut figures = folded.into_iter().chain(waiting).max_by_key(|figures| figures.at);
        if figures.is_some_and(|figures| figures.voided) {
            figures = store::history::newest(store, gyro, Span::EVER, 1).await?.pop();
        }
        newest.push((gyro, figures));
    }
    Ok(newest)
}

fn one(gyro: u32, bytes: &[u8]) -> Result<Figures, StoreError> {
    let packed: &[u8; PACKED_LEN] = bytes
        .try_into()
        .map_err(|_| StoreError::Damaged(format!("a history row of gyro number {gyro} has a wrong length")))?;
    Figures::unpack(gyro, packed)
}
