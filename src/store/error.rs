//! What can go wrong with the database, sorted by what a caller can do about it.

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

fn sqlite_code(error: &sqlx::Error) -> Option<(i32, String)> {
    let database = error.as_database_error()?;
    let code = database.code()?.parse().ok()?;
    Some((code, database.message().to_owned()))
}
