//! As `folder.rs`, on Windows: nothing is opened, written or moved by way of a symbolic link or a junction.
//!
//! The directory is held open so that nobody can rename or replace it meanwhile; what is in it is asked for by its
//! path. A file that another program has open for writing is not read: the program is not done with it.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::os::windows::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::cli::errors::said;
use crate::message;

/// Size and time of change: while they stand still, so does the file.
pub type FileStamp = (u64, Option<SystemTime>);

// Names and numbers of `CreateFileW`.
const FILE_SHARE_READ: u32 = 1;
const FILE_SHARE_WRITE: u32 = 2;
const FILE_SHARE_DELETE: u32 = 4;
const FILE_FLAG_BACKUP_SEMANTICS: u32 = 0x0200_0000;
const FILE_FLAG_OPEN_REPARSE_POINT: u32 = 0x0020_0000;

pub struct Dir {
    path: PathBuf,
    /// Not shared for deletion: while it is open the path leads here.
    _held: File,
}

impl Dir {
    /// The directory that somebody named: the way there may lead over links.
    pub fn open(path: &Path) -> io::Result<Self> {
        Self::hold(fs::canonicalize(path)?)
    }

    fn hold(path: PathBuf) -> io::Result<Self> {
        let held = OpenOptions::new()
            .read(true)
            .share_mode(FILE_SHARE_READ | FILE_SHARE_WRITE)
            .custom_flags(FILE_FLAG_BACKUP_SEMANTICS | FILE_FLAG_OPEN_REPARSE_POINT)
            .open(&path)?;
        if held.metadata()?.is_dir() {
            return Ok(Self { path, _held: held });
        }
        let folder = path.file_name().unwrap_or_default().display().to_string();
        Err(io::Error::other(said(message!("terminal_no_folder", folder))))
    }

    /// The directory `name` in it, made where there is none.
    pub fn within(&self, name: &str) -> io::Result<Self> {
        let path = self.path.join(name);
        match fs::create_dir(&path) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
        Self::hold(path)
    }

    pub fn names(&self) -> io::Result<Vec<OsString>> {
        fs::read_dir(&self.path)?.map(|entry| Ok(entry?.file_name())).collect()
    }

    fn metadata(&self, name: &OsStr) -> Option<Metadata> {
        fs::symlink_metadata(self.path.join(name)).ok()
    }

    /// Whether anything has the name.
    pub fn has(&self, name: &OsStr) -> bool {
        self.metadata(name).is_some()
    }

    pub fn is_link(&self, name: &OsStr) -> bool {
        self.metadata(name).is_some_and(|found| found.is_symlink())
    }

    /// None for what is not a plain file, or is gone.
    pub fn stamp(&self, name: &OsStr) -> Option<FileStamp> {
        let found = self.metadata(name).filter(Metadata::is_file)?;
        Some((found.len(), found.modified().ok()))
    }

    /// A plain file; none where the name is a link or anything else by now. While another program has it open for
    /// writing it is refused.
    pub fn file(&self, name: &OsStr) -> io::Result<Option<File>> {
        let opened = OpenOptions::new()
            .read(true)
            .share_mode(FILE_SHARE_READ | FILE_SHARE_DELETE)
            .custom_flags(FILE_FLAG_OPEN_REPARSE_POINT)
            .open(self.path.join(name));
        match opened {
            Ok(file) if file.metadata()?.is_file() => Ok(Some(file)),
            Ok(_) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Writes a file in place of what has the name. Who may read it is what the folder says.
    pub fn write(&self, name: &OsStr, text: &[u8]) -> io::Result<()> {
        let path = self.path.join(name);
        match fs::remove_file(&path) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
        let created =
            OpenOptions::new().write(true).create_new(true).custom_flags(FILE_FLAG_OPEN_REPARSE_POINT).open(path);
        created?.write_all(text)
    }

    /// Moves what has the name into `to`, where nothing has `new_name`.
    pub fn move_to(&self, name: &OsStr, to: &Dir, new_name: &OsStr) -> io::Result<()> {
        if to.has(new_name) {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        fs::rename(self.path.join(name), to.path.join(new_name))
    }
}
