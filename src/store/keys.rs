//! `Idempotency-Key` headers and what came of the requests that bore them.

use super::batch::{Batch, Rows};
use super::db::{cell, insert, on};
use super::error::StoreError;
use super::id::Id;
use super::open::Store;

#[derive(Debug, Clone, PartialEq)]
pub struct KeyRow {
    pub key: String,
    pub item: Id,
    pub body_sha256: [u8; 32],
}

pub(super) fn insert(keys: &[KeyRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for key in keys {
        rows.row().bytes(key.key.as_bytes()).integer(key.item.0).bytes(&key.body_sha256);
    }
    batch.add(insert!("idempotency_key (key, item, body_sha256)", [words 0 1, int 2, blob 3 4]), rows);
}

impl Store {
    /// What a key was used for before: the item's id and the hash of the body.
    pub async fn key(&self, key: &str) -> Result<Option<(Id, Vec<u8>)>, StoreError> {
        let sql = "SELECT item, body_sha256 FROM idempotency_key WHERE key = $1";
        let found: Option<(i64, Vec<u8>)> =
            on!(self.readers, db => sqlx::query_as(sql).bind(key).fetch_optional(db).await?);
        Ok(found.map(|(id, hash)| (Id(id), hash)))
    }
}
