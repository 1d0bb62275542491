//! Tokens, the browsers that signed in with them, and the audit trail.

use sqlx::SqliteConnection;

use crate::core::access::{AuditEntry, AuditFilter, Role};
use crate::core::id::Id;
use crate::core::time::UtcMicros;
use crate::store::batch::{Batch, Rows};
use crate::store::db::{AnyRow, Whole, among, cell, insert, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;

/// A token, without its secret.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TokenRow {
    pub id: Id,
    pub name: String,
    pub role: Role,
    /// The only station that it may send for.
    pub station: Option<String>,
    pub secret_sha256: [u8; 32],
    pub created_at: UtcMicros,
    pub expires_at: Option<UtcMicros>,
    pub revoked_at: Option<UtcMicros>,
}

impl TokenRow {
    pub fn is_valid(&self, now: UtcMicros) -> bool {
        self.revoked_at.is_none() && self.expires_at.is_none_or(|until| now < until)
    }
}

/// A browser that signed in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SessionRow {
    pub id: Id,
    pub token: Id,
    pub secret_sha256: [u8; 32],
    pub began_at: UtcMicros,
    pub expires_at: UtcMicros,
}

/// What changes about access; see [`crate::store::Changes`].
#[derive(Debug, Default)]
pub struct AccessChanges {
    /// New ones, and those that were revoked.
    pub tokens: Vec<TokenRow>,
    pub sessions: Vec<SessionRow>,
    pub ended: Vec<Id>,
    pub audit: Vec<AuditEntry>,
}

impl AccessChanges {
    pub fn is_empty(&self) -> bool {
        self.tokens.is_empty() && self.sessions.is_empty() && self.ended.is_empty() && self.audit.is_empty()
    }
}

pub(crate) fn apply(changes: &AccessChanges, batch: &mut Batch) {
    let mut rows = Rows::default();
    for token in &changes.tokens {
        rows.row()
            .integer(token.id.0)
            .text(&token.name)
            .text(token.role.name())
            .optional_text(token.station.as_deref())
            .bytes(&token.secret_sha256)
            .integer(token.created_at.0)
            .optional_integer(token.expires_at.map(|at| at.0))
            .optional_integer(token.revoked_at.map(|at| at.0));
    }
    batch.add(
        insert!(
            "token (id, name, role, station, secret_sha256, created_at, expires_at, revoked_at)",
            [int 0, text 1, text 2, text 3, blob 4 5, int 6, int 7, int 8],
            "ON CONFLICT (id) DO UPDATE SET revoked_at = excluded.revoked_at"
        ),
        rows,
    );
    let mut rows = Rows::default();
    for session in &changes.sessions {
        rows.row()
            .integer(session.id.0)
            .integer(session.token.0)
            .bytes(&session.secret_sha256)
            .integer(session.began_at.0)
            .integer(session.expires_at.0);
    }
    batch.add(
        insert!(
            "session (id, token, secret_sha256, began_at, expires_at)",
            [int 0, int 1, blob 2 3, int 4, int 5]
        ),
        rows,
    );
    batch.add(among!("DELETE FROM session WHERE id"), Rows::of(changes.ended.iter().map(|id| id.0)));
    let mut rows = Rows::default();
    for line in &changes.audit {
        rows.row()
            .integer(line.id.0)
            .integer(line.at.0)
            .text(&line.who)
            .optional_integer(line.token.map(|token| token.0))
            .text(&line.source)
            .text(&line.action)
            .text(&line.subject)
            .optional_text(line.before.as_deref())
            .optional_text(line.after.as_deref())
            .optional_text(line.agent.as_deref());
    }
    batch.add(
        insert!(
            "audit (id, at, who, token, source, action, subject, before, after, agent)",
            [int 0, int 1, text 2, int 3, text 4, text 5, text 6, text 7, text 8, text 9]
        ),
        rows,
    );
}

fn hash(row: &impl AnyRow) -> Result<[u8; 32], StoreError> {
    let bytes: Vec<u8> = row.cell("secret_sha256")?;
    bytes.try_into().map_err(|_| StoreError::Damaged("the hash of a token has another length".to_owned()))
}

fn token(row: &impl AnyRow) -> Result<TokenRow, StoreError> {
    let id = Id(row.cell("id")?);
    let role: String = row.cell("role")?;
    let damaged = || StoreError::Damaged(format!("token {id} has the role {role:?}, which is none"));
    Ok(TokenRow {
        id,
        name: row.cell("name")?,
        role: Role::from_name(&role).ok_or_else(damaged)?,
        station: row.cell("station")?,
        secret_sha256: hash(row)?,
        created_at: UtcMicros(row.cell("created_at")?),
        expires_at: row.cell::<Option<i64>>("expires_at")?.map(UtcMicros),
        revoked_at: row.cell::<Option<i64>>("revoked_at")?.map(UtcMicros),
    })
}

const TOKENS: &str =
    "SELECT id, name, role, station, secret_sha256, created_at, expires_at, revoked_at FROM token ORDER BY id";

/// Every token there ever was, oldest first.
pub async fn tokens(store: &Store) -> Result<Vec<TokenRow>, StoreError> {
    on!(store.readers, db => sqlx::query(TOKENS).fetch_all(db).await?.iter().map(token).collect())
}

/// As [`tokens`], by a connection of one's own.
pub(in crate::store) async fn tokens_of(reading: &mut SqliteConnection) -> Result<Vec<TokenRow>, StoreError> {
    sqlx::query(TOKENS).fetch_all(reading).await?.iter().map(token).collect()
}

pub async fn sessions(store: &Store) -> Result<Vec<SessionRow>, StoreError> {
    let sql = "SELECT id, token, secret_sha256, began_at, expires_at FROM session ORDER BY id";
    on!(store.readers, db => sqlx::query(sql).fetch_all(db).await?.iter().map(session).collect())
}

/// One line of the audit trail.
pub async fn audit_line(store: &Store, id: Id) -> Result<Option<AuditEntry>, StoreError> {
    let sql = "SELECT id, at, who, token, source, action, subject, before, after, agent FROM audit WHERE id = $1";
    on!(store.readers, db => sqlx::query(sql).bind(id.0).fetch_optional(db).await?.as_ref().map(line).transpose())
}

/// Lines of the audit trail, newest first, those before `before`.
pub async fn audit(
    store: &Store,
    filter: &AuditFilter,
    before: Option<Id>,
    limit: u32,
) -> Result<Vec<AuditEntry>, StoreError> {
    let sql = "SELECT id, at, who, token, source, action, subject, before, after, agent FROM audit
               WHERE id < $1 AND at >= $2 AND at <= $3 AND ($4 IS NULL OR who = $4) AND ($5 IS NULL OR action = $5)
                   AND ($6 IS NULL OR subject = $6)
               ORDER BY id DESC LIMIT $7";
    on!(store.readers, db => {
        let query = sqlx::query(sql)
            .bind(before.map_or(i64::MAX, |id| id.0))
            .bind(filter.from.map_or(i64::MIN, |at| at.0))
            .bind(filter.to.map_or(i64::MAX, |at| at.0))
            .bind(&filter.who)
            .bind(&filter.action)
            .bind(&filter.subject)
            .bind(Whole(limit));
        query.fetch_all(db).await?.iter().map(line).collect()
    })
}

fn session(row: &impl AnyRow) -> Result<SessionRow, StoreError> {
    Ok(SessionRow {
        id: Id(row.cell("id")?),
        token: Id(row.cell("token")?),
        secret_sha256: hash(row)?,
        began_at: UtcMicros(row.cell("began_at")?),
        expires_at: UtcMicros(row.cell("expires_at")?),
    })
}

fn line(row: &impl AnyRow) -> Result<AuditEntry, StoreError> {
    Ok(AuditEntry {
        id: Id(row.cell("id")?),
        at: UtcMicros(row.cell("at")?),
        who: row.cell("who")?,
        token: row.cell::<Option<i64>>("token")?.map(Id),
        source: row.cell("source")?,
        agent: row.cell("agent")?,
        action: row.cell("action")?,
        subject: row.cell("subject")?,
        before: row.cell("before")?,
        after: row.cell("after")?,
    })
}
