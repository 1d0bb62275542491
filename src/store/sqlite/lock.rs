//! One service a database: two would each number gyros and identifiers by themselves.
//!
//! SQLite's own locks cannot tell: they are held for a transaction only. The operating system gives this one up when
//! the process ends, however it ends. Programs that only read, or write a row by themselves, do not take it.

use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::private;
use crate::core::message::text;
use crate::message;
use crate::store::error::{Result, StoreError};

/// Held as long as it lives; none for a database in memory.
pub(crate) type Lock = Option<File>;

/// Takes the lock of the database in `file`.
///
/// # Errors
/// [`StoreError::InUse`] where another process holds it, [`StoreError::ReadOnly`] where it cannot be taken at all.
pub(crate) fn take(file: &Path) -> Result<Lock> {
    if private::is_in_memory(file) {
        return Ok(None);
    }
    let path = beside(file, ".lock");
    let failed = |error: std::io::Error| match (error.kind(), path.parent()) {
        (ErrorKind::NotFound, Some(directory)) => {
            StoreError::File(message!("no_directory", directory = text(directory.display())))
        }
        (ErrorKind::PermissionDenied, Some(directory)) => {
            StoreError::File(message!("directory_closed", directory = text(directory.display())))
        }
        _ => StoreError::ReadOnly(format!("{}: {error}", path.display())),
    };
    let lock = private::open(&path).map_err(failed)?;
    match lock.try_lock() {
        Ok(()) => Ok(Some(lock)),
        Err(TryLockError::WouldBlock) => Err(StoreError::InUse(file.display().to_string())),
        Err(TryLockError::Error(error)) => Err(failed(error)),
    }
}

/// The file's name with `suffix` appended.
pub(crate) fn beside(file: &Path, suffix: &str) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}
