//! A directory that others may write to: nothing in it is opened, written or moved by way of a symbolic link.
//!
//! Everything is asked of the open directory by the bare name, so that what is swapped for a link meanwhile is not
//! followed either.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{self, Write};
use std::os::fd::OwnedFd;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::time::{Duration, SystemTime};

use rustix::fs::{self, AtFlags, CWD, FileType, Mode, OFlags, RenameFlags, Stat};
use rustix::io::Errno;

use crate::cli::errors::said;
use crate::message;

/// Size and time of change: while they stand still, so does the file.
pub type FileStamp = (u64, Option<SystemTime>);

/// What others may read of what is written here: nothing.
const PRIVATE: Mode = Mode::from_raw_mode(0o600);

pub struct Dir(OwnedFd);

impl Dir {
    /// The directory that somebody named: the way there may lead over links.
    pub fn open(path: &Path) -> io::Result<Self> {
        Ok(Self(fs::openat(CWD, path, OFlags::DIRECTORY | OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())?))
    }

    /// The directory `name` in it, made where there is none.
    pub fn within(&self, name: &str) -> io::Result<Self> {
        match fs::mkdirat(&self.0, name, Mode::from_raw_mode(0o777)) {
            Ok(()) | Err(Errno::EXIST) => {}
            Err(error) => return Err(error.into()),
        }
        let flags = OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::RDONLY | OFlags::CLOEXEC;
        match fs::openat(&self.0, name, flags, Mode::empty()) {
            Ok(dir) => Ok(Self(dir)),
            Err(Errno::LOOP | Errno::NOTDIR) => {
                Err(io::Error::other(said(message!("terminal_no_folder", folder = name.to_owned()))))
            }
            Err(error) => Err(error.into()),
        }
    }

    pub fn names(&self) -> io::Result<Vec<OsString>> {
        let entries = fs::Dir::read_from(&self.0)?;
        let name =
            |entry: rustix::io::Result<fs::DirEntry>| Ok(OsStr::from_bytes(entry?.file_name().to_bytes()).to_owned());
        entries.map(name).filter(|name| !matches!(name, Ok(name) if name == "." || name == "..")).collect()
    }

    fn stat(&self, name: &OsStr) -> Option<Stat> {
        fs::statat(&self.0, name, AtFlags::SYMLINK_NOFOLLOW).ok()
    }

    /// Whether anything has the name.
    pub fn has(&self, name: &OsStr) -> bool {
        self.stat(name).is_some()
    }

    pub fn is_link(&self, name: &OsStr) -> bool {
        self.stat(name).is_some_and(|stat| FileType::from_raw_mode(stat.st_mode) == FileType::Symlink)
    }

    /// None for what is not a plain file, or is gone.
    pub fn stamp(&self, name: &OsStr) -> Option<FileStamp> {
        let stat = self.stat(name).filter(is_plain)?;
        let since = Duration::new(u64::try_from(stat.st_mtime).ok()?, u32::try_from(stat.st_mtime_nsec).ok()?);
        Some((stat.st_size.unsigned_abs(), SystemTime::UNIX_EPOCH.checked_add(since)))
    }

    /// A plain file; none where the name is a link, a pipe, a device or anything else by now. Waits for nobody.
    pub fn file(&self, name: &OsStr) -> io::Result<Option<File>> {
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
        match fs::openat(&self.0, name, flags, Mode::empty()) {
            Ok(file) if is_plain(&fs::fstat(&file)?) => Ok(Some(file.into())),
            // A socket cannot be opened.
            Ok(_) | Err(Errno::LOOP | Errno::NXIO) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Writes a file for its owner alone, in place of what has the name.
    pub fn write(&self, name: &OsStr, text: &[u8]) -> io::Result<()> {
        match fs::unlinkat(&self.0, name, AtFlags::empty()) {
            Ok(()) | Err(Errno::NOENT) => {}
            Err(error) => return Err(error.into()),
        }
        let flags = OFlags::WRONLY | OFlags::CREATE | OFlags::EXCL | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let mut file = File::from(fs::openat(&self.0, name, flags, PRIVATE)?);
        file.write_all(text)
    }

    /// Moves what has the name into `to`, where nothing has `new_name`.
    pub fn move_to(&self, name: &OsStr, to: &Dir, new_name: &OsStr) -> io::Result<()> {
        match fs::renameat_with(&self.0, name, &to.0, new_name, RenameFlags::NOREPLACE) {
            // Not every file system can.
            Err(Errno::INVAL | Errno::NOSYS) => Ok(fs::renameat(&self.0, name, &to.0, new_name)?),
            moved => Ok(moved?),
        }
    }
}

fn is_plain(stat: &Stat) -> bool {
    FileType::from_raw_mode(stat.st_mode) == FileType::RegularFile
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    #[test]
    fn only_plain_files_are_opened_and_nothing_waits() {
        let dir = tempfile::tempdir().unwrap();
        let path = |name: &str| dir.path().join(name);
        std::fs::write(path("plain"), "text").unwrap();
        symlink("plain", path("link")).unwrap();
        symlink("nowhere", path("dangling")).unwrap();
        std::fs::create_dir(path("directory")).unwrap();
        fs::mkfifoat(CWD, path("pipe"), PRIVATE).unwrap();
        let _socket = std::os::unix::net::UnixListener::bind(path("socket")).unwrap();
        let folder = Dir::open(dir.path()).unwrap();
        assert_eq!(folder.names().unwrap().len(), 6);
        for name in folder.names().unwrap() {
            let plain = name == "plain";
            assert_eq!(folder.file(&name).unwrap().is_some(), plain, "{}", name.display());
            assert_eq!(folder.stamp(&name).is_some(), plain, "{}", name.display());
        }
        assert_eq!(folder.file(OsStr::new("gone")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn what_is_written_is_its_owners_alone_and_follows_no_link() {
        let dir = tempfile::tempdir().unwrap();
        let other = dir.path().join("other");
        std::fs::write(&other, "as it was").unwrap();
        symlink("other", dir.path().join("note")).unwrap();
        let folder = Dir::open(dir.path()).unwrap();
        folder.write(OsStr::new("note"), b"why").unwrap();
        assert_eq!(std::fs::read_to_string(&other).unwrap(), "as it was");
        let note = dir.path().join("note");
        assert_eq!(std::fs::symlink_metadata(&note).unwrap().permissions().mode() & 0o7777, 0o600);
        assert_eq!(std::fs::read_to_string(note).unwrap(), "why");
    }

    #[test]
    fn a_directory_that_is_a_link_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        symlink(elsewhere.path(), dir.path().join("refused")).unwrap();
        let folder = Dir::open(dir.path()).unwrap();
        assert!(folder.within("refused").is_err_and(|error| error.to_string().contains("symbolic link")));
        assert!(folder.within("sent").is_ok());
    }
}
