//! The history of one gyro: a row a record, in order of time.

use crate::core::figures::Figures;
use crate::core::id::Id;
use crate::core::time::{Span, UtcMicros};
use crate::store::db::{Readers, Sql, Whole, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;
use crate::store::packed::history_row::PACKED_LEN;

/// Folded rows of `gyro` within `span`, whether they count or not: the oldest `limit` of them, oldest first; or the
/// newest, newest first.
async fn read_folded(
    readers: &Readers,
    gyro: u32,
    span: Span,
    limit: usize,
    newest_first: bool,
) -> Result<Vec<Figures>, StoreError> {
    let sql = readers.words(if newest_first {
        Sql {
            sqlite: "SELECT CAST(group_concat(figures, '') AS BLOB) FROM (SELECT figures FROM history
         WHERE gyro = $1 AND calibrated_at BETWEEN $2 AND $3 ORDER BY calibrated_at DESC LIMIT $4)",
            postgres: "SELECT string_agg(figures, CAST('' AS BYTEA) ORDER BY calibrated_at DESC)
         FROM (SELECT figures, calibrated_at FROM history
         WHERE gyro = $1 AND calibrated_at BETWEEN $2 AND $3 ORDER BY calibrated_at DESC LIMIT $4) AS chosen",
        }
    } else {
        Sql {
            sqlite: "SELECT CAST(group_concat(figures, '') AS BLOB) FROM (SELECT figures FROM history
         WHERE gyro = $1 AND calibrated_at BETWEEN $2 AND $3 ORDER BY calibrated_at LIMIT $4)",
            postgres: "SELECT string_agg(figures, CAST('' AS BYTEA) ORDER BY calibrated_at)
         FROM (SELECT figures, calibrated_at FROM history
         WHERE gyro = $1 AND calibrated_at BETWEEN $2 AND $3 ORDER BY calibrated_at LIMIT $4) AS chosen",
        }
    });
    let limit = i64::try_from(limit).unwrap_or(i64::MAX);
    let packed: Option<Vec<u8>> = on!(*readers, db => {
        sqlx::query_scalar(sql).bind(Whole(gyro)).bind(span.from.0).bind(span.to.0).bind(limit).fetch_one(db).await?
    });
    unpack(gyro, &packed.unwrap_or_default())
}

/// SQLite joins blobs byte for byte, and in the order of the subquery; a row out of place would show here.
pub(crate) fn unpack(gyro: u32, packed: &[u8]) -> Result<Vec<Figures>, StoreError> {
    let (rows, rest) = packed.as_chunks::<PACKED_LEN>();
    if !rest.is_empty() {
        return Err(StoreError::Damaged(format!("history rows of gyro number {gyro} have a wrong length")));
    }
    rows.iter().map(|row| Figures::unpack(gyro, row)).collect()
}

/// Rows of one order in one: those that wait hold where both have the instant.
pub(crate) fn merged(folded: Vec<Figures>, waiting: Vec<Figures>, newest_first: bool, limit: usize) -> Vec<Figures> {
    if waiting.is_empty() {
        return folded;
    }
    let before = |a: &Figures, b: &Figures| if newest_first { a.at > b.at } else { a.at < b.at };
    let mut all = Vec::with_capacity(limit.min(folded.len() + waiting.len()));
    let (mut folded, mut waiting) = (folded.into_iter().peekable(), waiting.into_iter().peekable());
    while all.len() < limit {
        let next = match (folded.peek(), waiting.peek()) {
            (Some(there), Some(waits)) if there.at == waits.at => {
                folded.next();
                waiting.next()
            }
            (Some(there), Some(waits)) if before(there, waits) => folded.next(),
            (Some(_), None) => folded.next(),
            _ => waiting.next(),
        };
        let Some(next) = next else { break };
        all.push(next);
    }
    all
}

/// The oldest `limit` rows of a gyro within `span` that count, oldest first.
pub async fn oldest(store: &Store, gyro: u32, span: Span, limit: usize) -> Result<Vec<Figures>, StoreError> {
    counting(store, gyro, span, limit, false).await
}

/// The newest `limit` rows of a gyro within `span` that count, oldest first.
pub async fn newest(store: &Store, gyro: u32, span: Span, limit: usize) -> Result<Vec<Figures>, StoreError> {
    let mut rows = counting(store, gyro, span, limit, true).await?;
    rows.reverse();
    Ok(rows)
}

pub(crate) async fn counting(
    store: &Store,
    gyro: u32,
    mut span: Span,
    limit: usize,
    newest_first: bool,
) -> Result<Vec<Figures>, StoreError> {
    let mut counting = Vec::new();
    loop {
        let wanted = limit - counting.len();
        let rows = marked(store, gyro, span, wanted, newest_first).await?;
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
async fn marked(
    store: &Store,
    gyro: u32,
    span: Span,
    limit: usize,
    newest_first: bool,
) -> Result<Vec<Figures>, StoreError> {
    let waiting = store.unplaced.tail.read().first_of(gyro, span, limit, newest_first);
    let folded = read_folded(&store.readers, gyro, span, limit, newest_first).await?;
    Ok(merged(folded, waiting, newest_first, limit))
}

/// The rows of a gyro within `span` that do not count any more, oldest first.
pub async fn voided(store: &Store, gyro: u32, span: Span) -> Result<Vec<Figures>, StoreError> {
    let sql = store.readers.words(Sql {
        sqlite: "SELECT CAST(group_concat(figures, '') AS BLOB) FROM (SELECT figures FROM voided_history
                 WHERE gyro = $1 AND calibrated_at BETWEEN $2 AND $3 ORDER BY calibrated_at, record)",
        postgres: "SELECT string_agg(figures, CAST('' AS BYTEA) ORDER BY calibrated_at, record) FROM voided_history
                   WHERE gyro = $1 AND calibrated_at BETWEEN $2 AND $3",
    });
    let packed: Option<Vec<u8>> = on!(store.readers, db => sqlx::query_scalar(sql).bind(Whole(gyro)).bind(span.from.0).bind(span.to.0).fetch_one(db).await?);
    unpack(gyro, &packed.unwrap_or_default())
}

/// How many rows a gyro has that count.
pub async fn count(store: &Store, gyro: u32) -> Result<usize, StoreError> {
    Ok(oldest(store, gyro, Span::EVER, usize::MAX).await?.len())
}

/// The temperature of each of these records that has one; of what an earlier version stored, as its body says it.
pub async fn temperatures(store: &Store, records: impl Iterator<Item = Id>) -> Result<Vec<(Id, f64)>, StoreError> {
    let records: Vec<i64> = records.map(|record| record.0).collect();
    let sql = store.readers.words(Sql {
        sqlite: "SELECT record.id, coalesce(temperature_c, CAST(coalesce(json_extract(body, '$.temperature_c'),
                        (SELECT avg(value->>'temperature_c') FROM json_each(body, '$.dwells'))) AS REAL))
                 FROM json_each($1) AS j JOIN record ON record.id = j.value
                 WHERE temperature_c IS NOT NULL OR json_valid(body)",
        // What begins with a brace was read as JSON before it was stored; other campaigns came as CSV.
        postgres: "SELECT sent.id, coalesce(sent.temperature_c, CAST(sent.body->>'temperature_c' AS DOUBLE PRECISION),
                       (SELECT avg(CAST(dwell.value->>'temperature_c' AS DOUBLE PRECISION))
                        FROM jsonb_array_elements(CASE WHEN jsonb_typeof(sent.body->'dwells') = 'array'
                                                  THEN sent.body->'dwells' ELSE '[]' END) AS dwell(value)))
                   FROM (SELECT record.id, record.temperature_c,
                                CASE WHEN record.temperature_c IS NULL AND ltrim(record.body, E' \\t\\r\\n') LIKE '{%'
                                     THEN CAST(record.body AS JSONB) END AS body
                         FROM jsonb_array_elements_text(CAST($1 AS JSONB)) AS j(value)
                         JOIN record ON record.id = CAST(j.value AS BIGINT)) AS sent",
    });
    let records = serde_json::Value::from(records).to_string();
    let rows: Vec<(i64, Option<f64>)> =
        on!(store.readers, db => sqlx::query_as(sql).bind(records).fetch_all(db).await?);
    Ok(rows.into_iter().filter_map(|(id, temperature)| Some((Id(id), temperature?))).collect())
}
