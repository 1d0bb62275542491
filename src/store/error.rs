//! What can go wrong with the database, sorted by what a caller can do about it.

use std::fmt::Display;
use std::io::ErrorKind;
use std::sync::Arc;

use sqlx::postgres::PgDatabaseError;

use crate::core::message::{Message, sent, text};
use crate::message;

/// What the store hands back, unless it says otherwise.
pub type Result<T, E = StoreError> = std::result::Result<T, E>;

/// A failure of the store. `Display` is for the log; clients are told only what concerns them.
#[derive(Debug, Clone, thiserror::Error)]
pub enum StoreError {
    /// No room left on the device. Reading goes on; writing works again once there is room.
    #[error("the disk is full")]
    Full,
    /// The file, its file system or the disk under it refuses reading or writing.
    #[error("the database cannot be read or written: {0}")]
    ReadOnly(String),
    /// Another process holds the database.
    #[error("the database is locked by another process")]
    Busy,
    /// Another service has the database open.
    #[error("another gyrowatch serves the database {0}; stop it first, or use a file of your own")]
    InUse(String),
    /// A file or an address is not what it would have to be, or cannot be read or written.
    #[error("{0}")]
    File(Message),
    /// A write did not reach the disk and cannot be known to; nothing may be written until a restart.
    #[error("a write could not be made durable: {0}; restart after checking the disk")]
    NotDurable(String),
    /// The content contradicts its checksums or its structure.
    #[error("the database is damaged: {0}")]
    Damaged(Message),
    /// A file is no database at all, or one whose first page is not readable as one.
    #[error("no database: {0}")]
    NoDatabase(String),
    /// A database server does not answer, or broke off what was under way; nothing was stored.
    #[error("the database cannot be reached: {0}")]
    Unreachable(Message),
    /// A database server broke off in the middle of a commit and cannot be asked what became of it.
    #[error("a commit was not answered, and the database cannot be asked what became of it: {0}")]
    Unanswered(String),
    /// Another writer has just written what this one was about to, such as the same new name; nothing was stored.
    #[error("overtaken by another writer: {0}")]
    Overtaken(String),
    /// A rule of the schema was broken: what was to be written contradicts what is stored.
    #[error("refused by the database: {0}")]
    Refused(String),
    /// What is encrypted cannot be read.
    #[error("{0}")]
    Key(Message),
    #[error("database: {0}")]
    Other(#[source] Arc<dyn std::error::Error + Send + Sync>),
}

impl StoreError {
    /// Damage of a kind that has no message of its own.
    pub fn damaged(what: impl Display) -> Self {
        Self::Damaged(Message::verbatim(what))
    }

    /// A failure that has no kind of its own.
    pub fn other(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Self::Other(error.into().into())
    }

    /// What is wrong with a file or an address.
    pub(super) fn at(place: &str, fault: Message) -> Self {
        Self::File(message!("at_file", file = sent(place), fault))
    }

    /// With the table, where it says what is damaged there.
    pub(super) fn of(self, table: &str) -> Self {
        if let Self::Damaged(what) = self { Self::damaged(format_args!("{table}: {what}")) } else { self }
    }

    /// What the database said, for its administrator; clients are told less.
    pub fn message(&self) -> Message {
        match self {
            Self::Full => message!("store_full"),
            Self::ReadOnly(why) => message!("store_unusable", why = text(why)),
            Self::Busy => message!("store_locked"),
            Self::InUse(database) => message!("store_in_use", database = text(database)),
            Self::File(why) | Self::Key(why) => why.clone(),
            Self::NotDurable(why) => message!("store_not_durable", why = text(why)),
            Self::Damaged(what) => message!("database_damaged", what = what.clone()),
            Self::NoDatabase(why) => message!("store_no_database", why = text(why)),
            Self::Unreachable(why) => message!("store_unreachable", why = why.clone()),
            Self::Unanswered(why) => message!("store_unanswered", why = text(why)),
            Self::Overtaken(why) => message!("store_overtaken", why = text(why)),
            Self::Refused(why) => message!("store_refused", why = text(why)),
            // Its cause says what.
            Self::Other(_) => message!("store_other"),
        }
    }
}

/// SQLite's extended result codes that need telling apart (sqlite.org/rescode.html).
const FSYNC_FAILED: [i32; 2] = [1034, 1290];

impl From<sqlx::Error> for StoreError {
    fn from(error: sqlx::Error) -> Self {
        use sqlx::Error::{Io, PoolTimedOut, Protocol, Tls};
        match &error {
            Io(why) if why.kind() == ErrorKind::ConnectionRefused => {
                return Self::Unreachable(message!("server_absent", why = text(why)));
            }
            Io(why) => return Self::Unreachable(Message::verbatim(why)),
            Tls(why) => return Self::Unreachable(message!("tls_failed", why = text(why))),
            Protocol(why) => return Self::Unreachable(message!("server_foreign", why = text(why))),
            PoolTimedOut => return Self::Unreachable(message!("server_busy")),
            _ => {}
        }
        let Some(said) = error.as_database_error() else { return Self::other(error) };
        let known = match said.try_downcast_ref::<PgDatabaseError>() {
            Some(said) => of_server(said.code(), said.message()),
            None => said.code().and_then(|code| of_file(code.parse().ok()?, said.message())),
        };
        known.unwrap_or_else(|| Self::other(error))
    }
}

impl From<rusqlite::Error> for StoreError {
    fn from(error: rusqlite::Error) -> Self {
        let known = match &error {
            rusqlite::Error::SqliteFailure(failure, said) => {
                of_file(failure.extended_code, said.as_deref().unwrap_or("no reason is given"))
            }
            _ => None,
        };
        known.unwrap_or_else(|| Self::other(error))
    }
}

/// What PostgreSQL says, by its class of error (postgresql.org/docs/current/errcodes-appendix.html).
fn of_server(code: &str, message: &str) -> Option<StoreError> {
    let message = format!("{message} ({code})");
    Some(match (code, code.get(..2)?) {
        ("53100", _) => StoreError::Full,
        // Files of the server's that it cannot read or write.
        ("25006", _) | (_, "58") => StoreError::ReadOnly(message),
        // A key that is there by now, or one that was lost with the commit that brought it.
        ("23503" | "23505", _) => StoreError::Overtaken(message),
        (_, "21" | "22" | "23") => StoreError::Refused(message),
        // Connections; transactions that were broken off; resources; locks not had in time; a server on its way up or
        // down.
        (_, "08" | "25" | "40" | "53" | "55" | "57") => StoreError::Unreachable(Message::verbatim(message)),
        (_, "XX") => StoreError::damaged(message),
        _ => return None,
    })
}

/// What SQLite says, by its extended result code.
fn of_file(code: i32, message: &str) -> Option<StoreError> {
    if FSYNC_FAILED.contains(&code) {
        return Some(StoreError::NotDurable(message.to_owned()));
    }
    Some(match code & 0xff {
        5 | 6 => StoreError::Busy,
        8 | 10 | 14 => StoreError::ReadOnly(message.to_owned()),
        11 => StoreError::damaged(message),
        13 => StoreError::Full,
        26 => StoreError::NoDatabase(message.to_owned()),
        19 => StoreError::Refused(message.to_owned()),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    #[test]
    fn what_is_no_database_is_not_called_a_damaged_one() {
        assert!(matches!(of_file(11, ""), Some(StoreError::Damaged(_))));
        let said = of_file(26, "file is not a database").unwrap().message();
        assert_eq!(Language::English.words(&said), "the file is no SQLite database (file is not a database)");
    }

    #[test]
    fn a_code_of_the_server_is_not_read_as_one_of_a_file() {
        // 42501 (no right to the table) ends in the byte by which SQLite says that it is busy.
        assert!(of_server("42501", "").is_none() && matches!(of_file(42501, ""), Some(StoreError::Busy)));
        assert!(matches!(of_server("58030", "could not fsync file"), Some(StoreError::ReadOnly(_))));
        assert!(matches!(of_server("53100", "could not extend file"), Some(StoreError::Full)));
        assert!(matches!(of_server("57P03", "the database system is starting up"), Some(StoreError::Unreachable(_))));
    }
}
