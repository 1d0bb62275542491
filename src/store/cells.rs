//! What a transaction holds among other servers: the cells of the IMUs and gyros that it is about.

use std::collections::BTreeSet;

use crate::system::sha256;

/// How many there are, for ever.
pub(crate) const CELLS: usize = 256;

/// Whoever changes tokens or sessions, or what is known of diagnoses, holds this one.
pub(crate) const ACCESS_CELL: u8 = 0;

/// Cells, in the order in which they are locked. A database in a file has one writer, who holds everything.
pub type Cells = BTreeSet<u8>;

pub fn all_cells() -> Cells {
    (0..=u8::MAX).collect()
}

/// The cell of whatever is first seen under a name: the first byte of the name's SHA-256.
pub fn cell_of(name: &str) -> u8 {
    sha256(name.as_bytes())[0]
}
