//! Files that their owner alone may read, whatever the umask says: the database, what SQLite puts beside it, and
//! copies.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::Path;

use crate::store::error::{Result, StoreError};

const OWNER_ALONE: u32 = 0o600;
/// Of the smallest write: the first page of many a table and index.
const LEAST_PAGES: u32 = 64;

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

/// Makes sure that there is room for a write of about so many pages: they are written to a file, which is then removed.
pub(crate) fn make_sure_of_room(path: &Path, pages: u32) -> Result<()> {
    let written = open(path).and_then(|mut file| {
        let pages = pages.saturating_mul(2).saturating_add(LEAST_PAGES);
        (0..pages).try_for_each(|_| file.write_all(&[0x5a; 4096]))
    });
    let _made_or_not = fs::remove_file(path);
    written.map_err(|error| match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => StoreError::Full,
        _ => StoreError::ReadOnly(error.to_string()),
    })
}

/// Whether it is no file, but the name that sqlx gives to a database in memory.
pub(crate) fn is_in_memory(file: &Path) -> bool {
    file.to_string_lossy().starts_with("file:sqlx-in-memory")
}
