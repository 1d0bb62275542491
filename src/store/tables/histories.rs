//! Histories of many gyros in one query: asked for one by one, each takes its own way to the database and back.

use super::*;
use crate::store::packed::history_row::PACKED_LEN;

/// Gyros of one query, so that what it hands over stays within a few megabytes.
const AT_ONCE: usize = 256;

/// A gyro, and from when to when.
pub type Stretch = (u32, Span);

/// Of each stretch the newest `limit` rows that count, oldest first: as [`super::history::newest`].
pub async fn newest(store: &Store, of: &[Stretch], limit: usize) -> Result<Vec<Vec<Figures>>> {
    let mut all = counting_of_many(store, of, limit, true).await?;
    all.iter_mut().for_each(|rows| rows.reverse());
    Ok(all)
}

/// As [`newest`], of the whole histories of these gyros.
pub async fn newest_ever(store: &Store, gyros: &[u32], limit: usize) -> Result<Vec<Vec<Figures>>> {
    let ever: Vec<Stretch> = gyros.iter().map(|gyro| (*gyro, Span::EVER)).collect();
    newest(store, &ever, limit).await
}

/// Of each of these gyros the newest row that counts.
pub async fn last(store: &Store, gyros: &[u32]) -> Result<Vec<(u32, Option<Figures>)>> {
    let rows = newest_ever(store, gyros, 1).await?;
    Ok(gyros.iter().zip(rows).map(|(gyro, mut rows)| (*gyro, rows.pop())).collect())
}

/// Of each stretch the oldest `limit` rows that count, oldest first: as [`super::history::oldest`].
pub async fn oldest(store: &Store, of: &[Stretch], limit: usize) -> Result<Vec<Vec<Figures>>> {
    counting_of_many(store, of, limit, false).await
}

async fn counting_of_many(
    store: &Store,
    of: &[Stretch],
    limit: usize,
    newest_first: bool,
) -> Result<Vec<Vec<Figures>>> {
    let mut all = Vec::with_capacity(of.len());
    for some in of.chunks(AT_ONCE) {
        let read = marked_of_many(store, some, limit, newest_first).await?;
        for (&(gyro, span), mut rows) in some.iter().zip(read) {
            let full = rows.len() == limit;
            rows.retain(|figures| !figures.voided);
            if full && rows.len() < limit {
                // Some of them count no more, and others may stand behind them.
                rows = counting(store, gyro, span, limit, newest_first).await?;
            }
            all.push(rows);
        }
    }
    Ok(all)
}

/// Rows of one gyro that count: the oldest, oldest first; or the newest, newest first.
pub(crate) async fn counting(
    store: &Store,
    gyro: u32,
    mut span: Span,
    limit: usize,
    newest_first: bool,
) -> Result<Vec<Figures>> {
    let mut counting = Vec::new();
    loop {
        let wanted = limit - counting.len();
        let rows = marked_of_many(store, &[(gyro, span)], wanted, newest_first).await?.pop().unwrap_or_default();
        let (full, last) = (rows.len() == wanted, rows.last().map(|figures| figures.at));
        counting.extend(rows.into_iter().filter(|figures| !figures.voided));
        match last {
            Some(last) if full && counting.len() < limit && newest_first => span.to = UtcMicros(last.0 - 1),
            Some(last) if full && counting.len() < limit => span.from = UtcMicros(last.0 + 1),
            _ => return Ok(counting),
        }
    }
}

/// With the rows that count no more.
async fn marked_of_many(store: &Store, of: &[Stretch], limit: usize, newest_first: bool) -> Result<Vec<Vec<Figures>>> {
    let waiting: Vec<Vec<Figures>> = {
        let pending = store.write_behind.history.read();
        of.iter().map(|&(gyro, span)| pending.first_of(gyro, span, limit, newest_first)).collect()
    };
    let newest = if newest_first { "DESC" } else { "" };
    let sql = AssertSqlSafe(match &store.readers {
        Readers::Sqlite(..) => format!(
            "SELECT (SELECT CAST(group_concat(figures, '') AS BLOB) FROM (SELECT figures FROM history
             WHERE gyro = j.value->>0 AND calibrated_at BETWEEN j.value->>1 AND j.value->>2
             ORDER BY calibrated_at {newest} LIMIT $2)) FROM json_each($1) AS j ORDER BY j.key"
        ),
        Readers::Postgres(..) => format!(
            "SELECT (SELECT string_agg(figures, CAST('' AS BYTEA) ORDER BY calibrated_at {newest})
                 FROM (SELECT figures, calibrated_at FROM history WHERE gyro = CAST(j.value->>0 AS BIGINT)
                 AND calibrated_at BETWEEN CAST(j.value->>1 AS BIGINT) AND CAST(j.value->>2 AS BIGINT)
                 ORDER BY calibrated_at {newest} LIMIT $2) AS chosen)
             FROM jsonb_array_elements(CAST($1 AS JSONB)) WITH ORDINALITY AS j(value, key) ORDER BY j.key"
        ),
    });
    let stretches: Vec<[i64; 3]> = of.iter().map(|(gyro, span)| [i64::from(*gyro), span.from.0, span.to.0]).collect();
    let packed: Vec<Option<Vec<u8>>> = read!(store, all, sql, serde_json::json!(stretches).to_string(), limit)?;
    let rows = of.iter().zip(packed).zip(waiting).map(|((&(gyro, _), packed), waiting)| {
        Ok(merged(unpack(gyro, &packed.unwrap_or_default())?, waiting, newest_first, limit))
    });
    rows.collect()
}

/// SQLite joins blobs byte for byte, and in the order of the subquery; a row out of place would show here.
pub(crate) fn unpack(gyro: u32, packed: &[u8]) -> Result<Vec<Figures>> {
    let (rows, rest) = packed.as_chunks::<PACKED_LEN>();
    if !rest.is_empty() {
        return Err(StoreError::damaged(format_args!("history rows of gyro number {gyro} have a wrong length")));
    }
    rows.iter().map(|row| Figures::unpack(gyro, row)).collect()
}

/// Rows of one order in one: those that wait hold where both have the instant.
fn merged(folded: Vec<Figures>, waiting: Vec<Figures>, newest_first: bool, limit: usize) -> Vec<Figures> {
    if waiting.is_empty() {
        return folded;
    }
    let mut by_time: BTreeMap<UtcMicros, Figures> = folded.into_iter().map(|row| (row.at, row)).collect();
    by_time.extend(waiting.into_iter().map(|row| (row.at, row)));
    let rows = by_time.into_values();
    if newest_first { rows.rev().take(limit).collect() } else { rows.take(limit).collect() }
}
