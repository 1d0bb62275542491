//! What a verdict is about.

use crate::core::named::named;

named! {
/// What a verdict is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Coefficient {
    DI = "D_I",
    DS = "D_S",
    /// The closure, in which neither D_I nor D_S has a part: mounting, or a true output-axis term.
    DO = "D_O",
    /// The scale-factor row (Table 3).
    E = "E",
    /// The row of g-sensitive terms (Table 4).
    G = "G",
    /// The gyro as a whole.
    All = "all",
}
}

impl Coefficient {
    /// Its place in [`Sample::d`](super::Sample::d); none for what has no history there.
    pub fn column(self) -> Option<usize> {
        match self {
            Coefficient::DI => Some(0),
            Coefficient::DS => Some(1),
            Coefficient::DO => Some(2),
            _ => None,
        }
    }
}
