//! What only SQLite has: the one writer of its file, the lock, checkpoints, backups, checksums and the log written
//! behind.

pub(super) mod backup;
pub(super) mod checkpoint;
pub(super) mod checksum;
pub(super) mod flush_failure;
pub(super) mod lock;
pub(super) mod private;
pub(super) mod write_behind;
pub(super) mod writer;
