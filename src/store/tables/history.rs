//! The history of one gyro: a row a record, in order of time.

use super::histories::{counting, unpack};
use super::*;

/// The oldest `limit` rows of a gyro within `span` that count, oldest first.
pub async fn oldest(store: &Store, gyro: u32, span: Span, limit: usize) -> Result<Vec<Figures>> {
    counting(store, gyro, span, limit, false).await
}

/// The newest `limit` rows of a gyro within `span` that count, oldest first.
pub async fn newest(store: &Store, gyro: u32, span: Span, limit: usize) -> Result<Vec<Figures>> {
    let mut rows = counting(store, gyro, span, limit, true).await?;
    rows.reverse();
    Ok(rows)
}

/// The rows of a gyro within `span` that do not count any more, oldest first.
pub async fn voided(store: &Store, gyro: u32, span: Span) -> Result<Vec<Figures>> {
    let sql = store.readers.words(Sql {
        sqlite: "SELECT CAST(group_concat(figures, '') AS BLOB) FROM (SELECT figures FROM voided_history
                 WHERE gyro = $1 AND calibrated_at BETWEEN $2 AND $3 ORDER BY calibrated_at, record)",
        postgres: "SELECT string_agg(figures, CAST('' AS BYTEA) ORDER BY calibrated_at, record) FROM voided_history
                   WHERE gyro = $1 AND calibrated_at BETWEEN $2 AND $3",
    });
    let packed: Option<Vec<u8>> = read!(store, one, sql, gyro, span.from, span.to)?;
    unpack(gyro, &packed.unwrap_or_default())
}

/// How many rows a gyro has that count.
pub async fn count(store: &Store, gyro: u32) -> Result<usize> {
    Ok(oldest(store, gyro, Span::EVER, usize::MAX).await?.len())
}

/// The temperature of each of these records that has one; of what an earlier version stored, as its body says it.
pub async fn temperatures(store: &Store, records: impl Iterator<Item = Id>) -> Result<HashMap<Id, f64>> {
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
    let records: Vec<Id> = records.collect();
    let rows: Vec<(Id, Option<f64>)> = read!(store, all, sql, &records)?;
    Ok(rows.into_iter().filter_map(|(id, temperature)| Some((id, temperature?))).collect())
}
