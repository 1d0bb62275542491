//! Tokens, the browsers that signed in with them, and the audit trail.

use sqlx::SqliteConnection;

use super::*;
use crate::core::access::{AuditEntry, AuditFilter, Token};

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
#[derive(Debug, Default, PartialEq)]
pub struct AccessChanges {
    /// New ones, and those that were revoked.
    pub tokens: Vec<Token>,
    pub sessions: Vec<SessionRow>,
    pub ended: Vec<Id>,
    pub audit: Vec<AuditEntry>,
}

columns! {
    Token in "token" { id, name, role, station, secret_sha256, created_at, expires_at, revoked_at }
}
columns! {
    SessionRow in "session" { id, token, secret_sha256, began_at, expires_at }
}
columns! {
    AuditEntry in "audit" { id, at, who, token, source, action, subject, before, after, agent }
}

pub(crate) fn apply(changes: &AccessChanges, batch: &mut Batch) {
    batch.enter(&changes.tokens, OnConflict::Set("id", &["revoked_at"]));
    batch.enter(&changes.sessions, OnConflict::Fail);
    batch.change("DELETE FROM session", "id = $C0", Rows::of(changes.ended.iter().copied()));
    batch.enter(&changes.audit, OnConflict::Fail);
}

/// Every token there ever was, oldest first.
pub async fn tokens(store: &Store) -> Result<Vec<Token>> {
    read!(store, all, Token::select("ORDER BY id"))
}

/// As [`tokens`], by a connection of one's own.
pub(in crate::store) async fn tokens_of(reading: &mut SqliteConnection) -> Result<Vec<Token>> {
    sqlx::query(Token::select("ORDER BY id")).fetch_all(reading).await?.iter().map(AnyRow::whole).collect()
}

pub async fn sessions(store: &Store) -> Result<Vec<SessionRow>> {
    read!(store, all, SessionRow::select("ORDER BY id"))
}

pub async fn audit_line(store: &Store, id: Id) -> Result<Option<AuditEntry>> {
    read!(store, first, AuditEntry::select("WHERE id = $1"), id)
}

/// Lines of the audit trail, newest first, those before `before`.
pub async fn audit(store: &Store, filter: &AuditFilter, before: Option<Id>, limit: u32) -> Result<Vec<AuditEntry>> {
    let sql = AuditEntry::select(
        "WHERE id < $1 AND at >= $2 AND at <= $3 AND ($4 IS NULL OR who = $4) AND ($5 IS NULL OR action = $5)
             AND ($6 IS NULL OR subject = $6)
         ORDER BY id DESC LIMIT $7",
    );
    let AuditFilter { from, to, who, action, subject } = filter;
    let (from, to) = (from.unwrap_or(Span::EVER.from), to.unwrap_or(Span::EVER.to));
    let (who, action, subject) = (who.as_deref(), action.as_deref(), subject.as_deref());
    read!(store, all, sql, before.map_or(i64::MAX, |id| id.0), from, to, who, action, subject, limit)
}
