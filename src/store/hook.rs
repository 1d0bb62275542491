//! Hooks: whom to tell.

use sqlx::{Row as _, sqlite::SqliteRow};

use super::batch::{Batch, Rows};
use super::error::StoreError;
use super::id::Id;
use super::open::Store;
use crate::core::time::UtcMicros;

/// A hook. Its secrets are for signing and sending only; what shows hooks leaves them out, and so does `Debug`.
#[derive(Clone, PartialEq, Eq)]
pub struct HookRow {
    pub id: Id,
    pub name: String,
    pub kind: String,
    pub url: String,
    pub authorization: Option<String>,
    pub secret: Option<String>,
    /// The secret before, and until when it signs as well.
    pub old_secret: Option<(String, UtcMicros)>,
    /// JSON.
    pub filter: String,
    pub enabled: bool,
    pub disabled_because: Option<String>,
    pub created_at: UtcMicros,
    pub changed_at: UtcMicros,
    pub deleted_at: Option<UtcMicros>,
}

impl std::fmt::Debug for HookRow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // The address too may hold a token.
        f.debug_struct("HookRow").field("id", &self.id).field("kind", &self.kind).finish_non_exhaustive()
    }
}

pub(super) fn upsert(hooks: &[HookRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for hook in hooks {
        let old = hook.old_secret.as_ref();
        rows.row()
            .integer(hook.id.0)
            .text(&hook.name)
            .text(&hook.kind)
            .text(&hook.url)
            .optional_text(hook.authorization.as_deref())
            .optional_text(hook.secret.as_deref())
            .optional_text(old.map(|(secret, _)| secret.as_str()))
            .optional_integer(old.map(|(_, until)| until.0))
            .text(&hook.filter)
            .integer(i64::from(hook.enabled))
            .optional_text(hook.disabled_because.as_deref())
            .integer(hook.created_at.0)
            .integer(hook.changed_at.0)
            .optional_integer(hook.deleted_at.map(|at| at.0));
    }
    batch.add(
        "INSERT INTO hook (id, name, kind, url, authorization, secret, old_secret, old_secret_until, filter, enabled,
             disabled_because, created_at, changed_at, deleted_at)
         SELECT value->>0, value->>1, value->>2, value->>3, value->>4, value->>5, value->>6, value->>7, value->>8,
             value->>9, value->>10, value->>11, value->>12, value->>13
         FROM json_each($ROWS) WHERE true
         ON CONFLICT (id) DO UPDATE SET (name, kind, url, authorization, secret, old_secret, old_secret_until, filter,
             enabled, disabled_because, changed_at, deleted_at) =
            (excluded.name, excluded.kind, excluded.url, excluded.authorization, excluded.secret, excluded.old_secret,
             excluded.old_secret_until, excluded.filter, excluded.enabled, excluded.disabled_because,
             excluded.changed_at, excluded.deleted_at)",
        rows,
    );
}

const COLUMNS: &str = "SELECT id, name, kind, url, authorization, secret, old_secret, old_secret_until, filter, enabled, \
                       disabled_because, created_at, changed_at, deleted_at FROM hook";

fn hook(row: &SqliteRow) -> Result<HookRow, StoreError> {
    let instant = |column: &str| Ok::<_, sqlx::Error>(row.try_get::<Option<i64>, _>(column)?.map(UtcMicros));
    let old_secret: Option<String> = row.try_get("old_secret")?;
    Ok(HookRow {
        id: Id(row.try_get("id")?),
        name: row.try_get("name")?,
        kind: row.try_get("kind")?,
        url: row.try_get("url")?,
        authorization: row.try_get("authorization")?,
        secret: row.try_get("secret")?,
        old_secret: old_secret.zip(instant("old_secret_until")?),
        filter: row.try_get("filter")?,
        enabled: row.try_get("enabled")?,
        disabled_because: row.try_get("disabled_because")?,
        created_at: UtcMicros(row.try_get("created_at")?),
        changed_at: UtcMicros(row.try_get("changed_at")?),
        deleted_at: instant("deleted_at")?,
    })
}

impl Store {
    /// Every hook that was not deleted, oldest first.
    pub async fn hooks(&self) -> Result<Vec<HookRow>, StoreError> {
        let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE deleted_at IS NULL ORDER BY id"));
        let rows = sqlx::query(sql).fetch_all(&self.readers).await?;
        rows.iter().map(hook).collect()
    }

    /// A hook, unless it was deleted.
    pub async fn hook(&self, id: Id) -> Result<Option<HookRow>, StoreError> {
        let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE id = $1 AND deleted_at IS NULL"));
        let row = sqlx::query(sql).bind(id.0).fetch_optional(&self.readers).await?;
        row.as_ref().map(hook).transpose()
    }
}
