//! `Idempotency-Key` headers and what came of the requests that bore them.

use super::*;

#[derive(Debug, Clone, PartialEq)]
pub struct KeyRow {
    pub key: String,
    pub item: Id,
    pub body_sha256: [u8; 32],
}

columns! {
    KeyRow in "idempotency_key" { key, item, body_sha256 }
}

/// What these keys were used for before: the item's id and the hash of the body; those that were never used are left out.
pub async fn get_many(store: &Store, keys: &[&str]) -> Result<Vec<(String, (Id, Vec<u8>))>> {
    let sql = store.readers.words(Sql {
        sqlite: "SELECT key, item, body_sha256 FROM idempotency_key WHERE key IN (SELECT value FROM json_each($1))",
        postgres: "SELECT key, item, body_sha256 FROM idempotency_key
                   WHERE key IN (SELECT j.value FROM jsonb_array_elements_text(CAST($1 AS JSONB)) AS j(value))",
    });
    let keys = serde_json::json!(keys).to_string();
    read!(store, all, sql, keys)
}

/// As [`get_many`], of one.
pub async fn get(store: &Store, key: &str) -> Result<Option<(Id, Vec<u8>)>> {
    Ok(get_many(store, &[key]).await?.pop().map(|(_, used)| used))
}
