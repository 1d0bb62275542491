//! What a verdict is about.

/// What a verdict is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Coefficient {
    DI,
    DS,
    /// The closure, in which neither D_I nor D_S has a part: mounting, or a true output-axis term.
    DO,
    /// The scale-factor row (Table 3).
    E,
    /// The row of g-sensitive terms (Table 4).
    G,
    /// The gyro as a whole.
    All,
}

impl Coefficient {
    pub const ALL: [Coefficient; 6] =
        [Coefficient::DI, Coefficient::DS, Coefficient::DO, Coefficient::E, Coefficient::G, Coefficient::All];

    pub fn name(self) -> &'static str {
        match self {
            Coefficient::DI => "D_I",
            Coefficient::DS => "D_S",
            Coefficient::DO => "D_O",
            Coefficient::E => "E",
            Coefficient::G => "G",
            Coefficient::All => "all",
        }
    }

    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|coefficient| coefficient.name() == name)
    }

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
