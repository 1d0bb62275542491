//! `Idempotency-Key` headers and what came of the requests that bore them.

use crate::core::id::Id;
use crate::store::batch::{Batch, Rows};
use crate::store::db::{Sql, cell, insert, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;

#[derive(Debug, Clone, PartialEq)]
pub struct KeyRow {
    pub key: String,
    pub item: Id,
    pub body_sha256: [u8; 32],
}

pub(crate) fn insert(keys: &[KeyRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for key in keys {
        rows.row().bytes(key.key.as_bytes()).integer(key.item.0).bytes(&key.body_sha256);
    }
    batch.add(insert!("idempotency_key (key, item, body_sha256)", [words 0 1, int 2, blob 3 4]), rows);
}

/// As `key`, of many; those that were never used are left out.
pub async fn get_many(store: &Store, keys: &[&str]) -> Result<Vec<(String, (Id, Vec<u8>))>, StoreError> {
    let sql = store.readers.words(Sql {
        sqlite: "SELECT key, item, body_sha256 FROM idempotency_key WHERE key IN (SELECT value FROM json_each($1))",
        postgres: "SELECT key, item, body_sha256 FROM idempotency_key
                   WHERE key IN (SELECT j.value FROM jsonb_array_elements_text(CAST($1 AS JSONB)) AS j(value))",
    });
    let keys = serde_json::json!(keys).to_string();
    let found: Vec<(String, i64, Vec<u8>)> =
        on!(store.readers, db => sqlx::query_as(sql).bind(keys).fetch_all(db).await?);
    Ok(found.into_iter().map(|(key, id, hash)| (key, (Id(id), hash))).collect())
}

/// What a key was used for before: the item's id and the hash of the body.
pub async fn get(store: &Store, key: &str) -> Result<Option<(Id, Vec<u8>)>, StoreError> {
    let sql = "SELECT item, body_sha256 FROM idempotency_key WHERE key = $1";
    let found: Option<(i64, Vec<u8>)> =
        on!(store.readers, db => sqlx::query_as(sql).bind(key).fetch_optional(db).await?);
    Ok(found.map(|(id, hash)| (Id(id), hash)))
}
