//! What can go wrong with the database, sorted by what a caller can do about it.

use sqlx::postgres::PgDatabaseError;

/// A failure of the store. `Display` is for the log; clients are told only what concerns them.
#[derive(Debug, thiserror::Error)]
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
    /// A file beside the database, such as a backup, cannot be read or written.
    #[error("{0}")]
    File(String),
    /// A write did not reach the disk and cannot be known to; nothing may be written until a restart.
    #[error("a write could not be made durable: {0}; restart after checking the disk")]
    NotDurable(String),
    /// The content contradicts its checksums or its structure.
    #[error("the database is damaged: {0}")]
    Damaged(String),
    /// A database server does not answer, or broke off what was under way; nothing was stored.
    #[error("the database cannot be reached: {0}")]
    Unreachable(String),
    /// A rule of the schema was broken: what was to be written contradicts what is stored.
    #[error("refused by the database: {0}")]
    Refused(String),
    #[error("database: {0}")]
    Other(#[source] sqlx::Error),
}

/// SQLite's extended result codes that need telling apart (sqlite.org/rescode.html).
const FSYNC_FAILED: [i32; 2] = [1034, 1290];

impl From<sqlx::Error> for StoreError {
    fn from(error: sqlx::Error) -> Self {
        if let Some(error) = of_server(&error) {
            return error;
        }
        let Some((code, message)) = sqlite_code(&error) else { return Self::Other(error) };
        if FSYNC_FAILED.contains(&code) {
            return Self::NotDurable(message);
        }
        match code & 0xff {
            5 | 6 => Self::Busy,
            8 | 10 | 14 => Self::ReadOnly(message),
            11 | 26 => Self::Damaged(message),
            13 => Self::Full,
            19 => Self::Refused(message),
            _ => Self::Other(error),
        }
    }
}

/// What PostgreSQL says, by its class of error (postgresql.org/docs/current/errcodes-appendix.html), or why it says nothing.
fn of_server(error: &sqlx::Error) -> Option<StoreError> {
    let said = match error {
        sqlx::Error::Io(_) | sqlx::Error::Tls(_) | sqlx::Error::Protocol(_) | sqlx::Error::PoolTimedOut => {
            return Some(StoreError::Unreachable(error.to_string()));
        }
        other => other.as_database_error()?.try_downcast_ref::<PgDatabaseError>()?,
    };
    let message = format!("{} ({})", said.message(), said.code());
    Some(match (said.code(), said.code().get(..2)?) {
        ("53100", _) => StoreError::Full,
        ("25006", _) => StoreError::ReadOnly(message),
        (_, "21" | "22" | "23") => StoreError::Refused(message),
        // Connections; transactions that were broken off; resources; locks not had in time; a server on its way up or down.
        (_, "08" | "25" | "40" | "53" | "55" | "57") => StoreError::Unreachable(message),
        (_, "XX") => StoreError::Damaged(message),
        _ => return None,
    })
}

fn sqlite_code(error: &sqlx::Error) -> Option<(i32, String)> {
    let database = error.as_database_error()?;
    let code = database.code()?.parse().ok()?;
    Some((code, database.message().to_owned()))
}
