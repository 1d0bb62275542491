//! Histories of many gyros in one query: asked for one by one, each takes its own way to the database and back.

use super::history::{merged, unpack};
use crate::core::figures::Figures;
use crate::core::time::Span;
use crate::store;
use crate::store::db::{Sql, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;

/// Gyros of one query, so that what it hands over stays within a few megabytes.
const AT_ONCE: usize = 256;

/// A gyro, and from when to when.
pub type Stretch = (u32, Span);

/// Of each stretch the newest `limit` rows that count, oldest first: as `newest_history`.
pub async fn newest(store: &Store, of: &[Stretch], limit: usize) -> Result<Vec<Vec<Figures>>, StoreError> {
    let mut all = counting_of_many(store, of, limit, true).await?;
    all.iter_mut().for_each(|rows| rows.reverse());
    Ok(all)
}

/// Of each stretch the oldest `limit` rows that count, oldest first: as `history`.
pub async fn oldest(store: &Store, of: &[Stretch], limit: usize) -> Result<Vec<Vec<Figures>>, StoreError> {
    counting_of_many(store, of, limit, false).await
}

async fn counting_of_many(
    store: &Store,
    of: &[Stretch],
    limit: usize,
    newest_first: bool,
) -> Result<Vec<Vec<Figures>>, StoreError> {
    let mut all = Vec::with_capacity(of.len());
    for some in of.chunks(AT_ONCE) {
        let read = marked_of_many(store, some, limit, newest_first).await?;
        for (&(gyro, span), mut rows) in some.iter().zip(read) {
            let full = rows.len() == limit;
            rows.retain(|figures| !figures.voided);
            if full && rows.len() < limit {
                // Some of them count no more, and others may stand behind them.
                rows = store::history::counting(store, gyro, span, limit, newest_first).await?;
            }
            all.push(rows);
        }
    }
    Ok(all)
}

/// With the rows that count no more.
async fn marked_of_many(
    store: &Store,
    of: &[Stretch],
    limit: usize,
    newest_first: bool,
) -> Result<Vec<Vec<Figures>>, StoreError> {
    let waiting: Vec<Vec<Figures>> = {
        let tail = store.unplaced.tail.read();
        of.iter().map(|&(gyro, span)| tail.first_of(gyro, span, limit, newest_first)).collect()
    };
    let sql = store.readers.words(if newest_first {
        Sql {
            sqlite: "SELECT (SELECT CAST(group_concat(figures, '') AS BLOB) FROM (SELECT figures FROM history
         WHERE gyro = j.value->>0 AND calibrated_at BETWEEN j.value->>1 AND j.value->>2
         ORDER BY calibrated_at DESC LIMIT $2)) FROM json_each($1) AS j ORDER BY j.key",
            postgres: "SELECT (SELECT string_agg(figures, CAST('' AS BYTEA) ORDER BY calibrated_at DESC)
             FROM (SELECT figures, calibrated_at FROM history WHERE gyro = CAST(j.value->>0 AS BIGINT)
             AND calibrated_at BETWEEN CAST(j.value->>1 AS BIGINT) AND CAST(j.value->>2 AS BIGINT)
             ORDER BY calibrated_at DESC LIMIT $2) AS chosen)
         FROM jsonb_array_elements(CAST($1 AS JSONB)) WITH ORDINALITY AS j(value, key) ORDER BY j.key",
        }
    } else {
        Sql {
            sqlite: "SELECT (SELECT CAST(group_concat(figures, '') AS BLOB) FROM (SELECT figures FROM history
         WHERE gyro = j.value->>0 AND calibrated_at BETWEEN j.value->>1 AND j.value->>2
         ORDER BY calibrated_at LIMIT $2)) FROM json_each($1) AS j ORDER BY j.key",
            postgres: "SELECT (SELECT string_agg(figures, CAST('' AS BYTEA) ORDER BY calibrated_at)
             FROM (SELECT figures, calibrated_at FROM history WHERE gyro = CAST(j.value->>0 AS BIGINT)
             AND calibrated_at BETWEEN CAST(j.value->>1 AS BIGINT) AND CAST(j.value->>2 AS BIGINT)
             ORDER BY calibrated_at LIMIT $2) AS chosen)
         FROM jsonb_array_elements(CAST($1 AS JSONB)) WITH ORDINALITY AS j(value, key) ORDER BY j.key",
        }
    });
    let stretches: Vec<[i64; 3]> = of.iter().map(|(gyro, span)| [i64::from(*gyro), span.from.0, span.to.0]).collect();
    let packed: Vec<Option<Vec<u8>>> = on!(store.readers, db => sqlx::query_scalar(sql)
        .bind(serde_json::json!(stretches).to_string())
        .bind(i64::try_from(limit).unwrap_or(i64::MAX))
        .fetch_all(db)
        .await?);
    let rows = of.iter().zip(packed).zip(waiting).map(|((&(gyro, _), packed), waiting)| {
        Ok(merged(unpack(gyro, &packed.unwrap_or_default())?, waiting, newest_first, limit))
    });
    rows.collect()
}
