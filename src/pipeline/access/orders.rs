//! What changes who may use the service, carried out by the one writer.

use serde::Serialize;

use super::secret::Secret;
use crate::core::access::{AuditEntry, Role, Token};
use crate::pipeline::Guard;
use crate::pipeline::prelude::*;
use crate::store::{AccessChanges, SessionRow, TokenDatabase, Writer};
use crate::wire::body::bodies;

/// A token to be made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewToken {
    pub name: String,
    pub role: Role,
    pub station: Option<String>,
    pub expires_at: Option<UtcMicros>,
}

impl NewToken {
    /// A station that would limit nothing looks like a limit: it is refused. `pointer` is where it was said.
    pub fn check_station(role: Role, station: Option<&str>, pointer: &str, faults: &mut Faults) {
        if station.is_some() && !role.may_be_of_one_station() {
            faults.push(pointer, message!("station_of_role", of = Role::Station.name(), role = role.name()));
        }
    }
}

#[derive(Debug)]
pub enum AccessOrder {
    Create(NewToken),
    Revoke(Id),
    /// A browser may go on as the token that it has shown.
    SignIn {
        token: Id,
    },
    SignOut {
        session: Id,
    },
}

/// A browser has signed in.
#[derive(Debug, Clone)]
pub struct SignedIn {
    /// What the browser is to send along.
    pub cookie: Secret,
    pub seconds: i64,
}

/// A token as the audit trail has it.
#[derive(Serialize)]
struct AuditedToken {
    id: String,
    name: String,
    role: &'static str,
    station: Option<String>,
    expires_at: Option<String>,
    revoked_at: Option<String>,
}

bodies! {
    AuditedToken of Token: id, name, role, station, expires_at, revoked_at;
}

/// Carries out one order; on disk, and known to the guard, when this returns. A secret that was drawn comes back.
pub(in crate::pipeline) async fn order_access(
    guard: &Guard,
    writer: &mut Writer,
    now: UtcMicros,
    order: &AccessOrder,
    by: &Actor,
    known: &[Token],
) -> Result<Option<Secret>, Refused> {
    let mut access = AccessChanges::default();
    let line = writer.next_id(now);
    let mut drawn = None;
    match order {
        // Of two that came at once, the second.
        AccessOrder::Create(_) if by.is_setup() && !known.is_empty() => {
            return Err(Problem::new(401, "title_token_not_valid", message!("setup_over")).into());
        }
        AccessOrder::Create(new) => {
            let secret = draw(writer.next_id(now))?;
            let row = token_row(new, &secret, now);
            access.audit.push(created(by, line, &row));
            access.tokens.push(row);
            drawn = Some(secret);
        }
        AccessOrder::Revoke(id) => {
            let row = known.iter().find(|row| row.id == *id).ok_or_else(|| Problem::no_such_token(id))?;
            let Some((row, audit)) = revoked(by, line, row, now) else { return Ok(None) };
            access.tokens.push(row);
            access.audit.push(audit);
        }
        AccessOrder::SignIn { token } => {
            let secret = draw(writer.next_id(now))?;
            let expires_at = UtcMicros(now.0.saturating_add(guard.session_us()));
            let id = secret.id;
            access.sessions.push(SessionRow {
                id,
                token: *token,
                secret_sha256: secret.sha256(),
                began_at: now,
                expires_at,
            });
            access.ended = guard.ended_sessions(now);
            access.audit.push(by.line(line, now, ("sign in", format!("sessions/{id}")), NOTHING, NOTHING));
            drawn = Some(secret);
        }
        AccessOrder::SignOut { session } => {
            access.ended.push(*session);
            access.audit.push(by.line(line, now, ("sign out", format!("sessions/{session}")), NOTHING, NOTHING));
        }
    }
    writer.commit(&Changes { access, ..Changes::default() }).await?;
    guard.read_again().await?;
    Ok(drawn)
}

const NOTHING: Option<&()> = None;

fn draw(id: Id) -> Result<Secret, Refused> {
    Secret::draw(id).map_err(|error| {
        tracing::error!(%error, "the operating system gives no random numbers");
        Problem::new(503, "title_try_again", message!("no_random_numbers")).into()
    })
}

fn token_row(new: &NewToken, secret: &Secret, now: UtcMicros) -> Token {
    let NewToken { name, role, station, expires_at } = new.clone();
    let secret_sha256 = secret.sha256();
    Token { id: secret.id, name, role, station, secret_sha256, created_at: now, expires_at, revoked_at: None }
}

fn created(by: &Actor, line: Id, row: &Token) -> AuditEntry {
    let what = ("create token", format!("tokens/{}", row.id));
    by.line(line, row.created_at, what, NOTHING, Some(&AuditedToken::from(row)))
}

/// None where it was revoked before.
fn revoked(by: &Actor, line: Id, row: &Token, now: UtcMicros) -> Option<(Token, AuditEntry)> {
    if row.revoked_at.is_some() {
        return None;
    }
    let after = Token { revoked_at: Some(now), ..row.clone() };
    let what = ("revoke token", format!("tokens/{}", row.id));
    let audit = by.line(line, now, what, Some(&AuditedToken::from(row)), Some(&AuditedToken::from(&after)));
    Some((after, audit))
}

/// Makes a token in a database that a service may be serving.
///
/// # Errors
/// [`Refused`]; then there is no new token that anybody could use.
pub async fn create_beside(database: &mut TokenDatabase, new: &NewToken, now: UtcMicros) -> Result<Secret, Refused> {
    let secret = draw(database.next_id(now))?;
    let row = token_row(new, &secret, now);
    let audit = vec![created(&Actor::by_command_line(), database.next_id(now), &row)];
    database.commit(AccessChanges { tokens: vec![row], audit, ..AccessChanges::default() }).await?;
    Ok(secret)
}

/// Revokes a token in a database that a service may be serving; false where it was revoked before.
///
/// # Errors
/// [`Refused`]: there is no such token, or the database fails.
pub async fn revoke_beside(database: &mut TokenDatabase, id: Id, now: UtcMicros) -> Result<bool, Refused> {
    let known = database.tokens().await?;
    let row = known.iter().find(|row| row.id == id).ok_or_else(|| Problem::no_such_token(id))?;
    let Some((row, audit)) = revoked(&Actor::by_command_line(), database.next_id(now), row, now) else {
        return Ok(false);
    };
    let access = AccessChanges { tokens: vec![row], audit: vec![audit], ..AccessChanges::default() };
    database.commit(access).await?;
    Ok(true)
}
