//! What a transaction holds among other servers: the cells of the IMUs and gyros that it is about.

use std::collections::BTreeSet;

use crate::system::sha256;

/// How many there are, for ever.
pub(crate) const CELLS: usize = 256;

/// Whoever changes tokens or sessions, or what is known of diagnoses, holds this one.
pub(crate) const ACCESS_CELL: u8 = 0;

/// Cells, in the order in which they are locked. A database in a file has one writer, who holds everything.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cells(BTreeSet<u8>);

impl Cells {
    pub fn one(cell: u8) -> Self {
        Self(BTreeSet::from([cell]))
    }

    pub fn all() -> Self {
        Self((0..=u8::MAX).collect())
    }

    pub fn contains(&self, other: &Self) -> bool {
        self.0.is_superset(&other.0)
    }

    pub fn insert(&mut self, cell: u8) {
        self.0.insert(cell);
    }

    pub fn iter(&self) -> impl Iterator<Item = u8> {
        self.0.iter().copied()
    }
}

impl FromIterator<u8> for Cells {
    fn from_iter<T: IntoIterator<Item = u8>>(cells: T) -> Self {
        Self(cells.into_iter().collect())
    }
}

impl Extend<u8> for Cells {
    fn extend<T: IntoIterator<Item = u8>>(&mut self, cells: T) {
        self.0.extend(cells);
    }
}

/// The cell of whatever is first seen under a name: the first byte of the name's SHA-256.
pub fn cell_of(name: &str) -> u8 {
    sha256(name.as_bytes())[0]
}
