//! Files that their owner alone may read, whatever the umask says: the database, what SQLite puts beside it, and
//! copies.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::Path;

use crate::store::error::{Result, StoreError};

const OWNER_ALONE: u32 = 0o600;
/// Of the smallest write, bytes: the first page of many a table and index, in the log and in the database.
const LEAST_ROOM: u64 = 1 << 19;

fn options() -> OpenOptions {
    let mut options = File::options();
    options.write(true).mode(OWNER_ALONE);
    options
}

/// A file that is not there yet.
pub(crate) fn create(path: &Path) -> io::Result<File> {
    options().create_new(true).open(path)
}

pub(crate) fn open(path: &Path) -> io::Result<File> {
    options().create(true).truncate(false).open(path)
}

/// Makes an empty file for SQLite, which makes its log and what else belongs to it with the same permissions. One
/// that is there stays as it is; where others may read it, the log says so.
pub(crate) fn make(database: &Path) {
    if is_in_memory(database) {
        return;
    }
    // Whatever else is wrong SQLite says in its own words.
    let there = create(database).is_err_and(|error| error.kind() == io::ErrorKind::AlreadyExists);
    if there && fs::metadata(database).is_ok_and(|found| found.permissions().mode() & 0o077 != 0) {
        tracing::warn!(database = %database.display(), "others on this machine may read the database: chmod 600");
    }
}

/// Makes sure that the disk of a database has room for a write, as far as the file system says.
pub(crate) fn make_sure_of_room(database: &Path) -> Result<()> {
    match rustix::fs::statvfs(database) {
        Ok(disk) if disk.f_bavail.saturating_mul(disk.f_frsize) < LEAST_ROOM => Err(StoreError::Full),
        _ => Ok(()),
    }
}

/// Whether it is no file, but the name that sqlx gives to a database in memory.
pub(crate) fn is_in_memory(file: &Path) -> bool {
    file.to_string_lossy().starts_with("file:sqlx-in-memory")
}
