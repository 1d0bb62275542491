//! Roles: what somebody who holds a token may do.

use crate::core::id::Id;
use crate::core::named::named;
use crate::core::time::UtcMicros;

named! {
/// Each may do what those before it may.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// Reads.
    Viewer = "viewer",
    /// Sends calibrations.
    Station = "station",
    /// Says what is to be made of them: acknowledges, silences, marks events, adopts models.
    Engineer = "engineer",
    /// Decides who is told and who may do what.
    Admin = "admin",
}
}

/// A token, without its secret.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Token {
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

impl Role {
    /// Whether a token of it can be limited to one station: those above do more than send, for any.
    pub fn may_be_of_one_station(self) -> bool {
        self == Self::Station
    }
}

impl Token {
    /// Neither revoked nor expired.
    pub fn is_valid(&self, now: UtcMicros) -> bool {
        self.revoked_at.is_none() && self.expires_at.is_none_or(|until| now < until)
    }
}

/// One line of the audit trail. `before` and `after` are JSON.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AuditEntry {
    pub id: Id,
    pub at: UtcMicros,
    pub who: String,
    pub token: Option<Id>,
    pub source: String,
    /// The program that was used, by its own word.
    pub agent: Option<String>,
    pub action: String,
    pub subject: String,
    pub before: Option<String>,
    pub after: Option<String>,
}

/// Which lines of the audit trail.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AuditFilter {
    pub from: Option<UtcMicros>,
    pub to: Option<UtcMicros>,
    pub who: Option<String>,
    pub action: Option<String>,
    pub subject: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_ascend_and_are_known_by_their_names() {
        assert!(Role::ALL.is_sorted());
        assert_eq!(Role::ALL.map(|role| Role::from_name(role.name())), Role::ALL.map(Some));
        assert_eq!(Role::from_name("Admin"), None);
    }
}
