//! In what order a list of gyros is read, where not by status.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FleetOrder {
    /// The larger load of D_I and D_S first, whatever its sign.
    Load,
    /// What its trend carries to the budget first; then the others.
    Reach,
    /// What was calibrated the longest ago first.
    Age,
    Serial,
}

impl FleetOrder {
    pub const ALL: [Self; 4] = [Self::Load, Self::Reach, Self::Age, Self::Serial];

    /// As queries name it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Load => "load",
            Self::Reach => "eta",
            Self::Age => "age",
            Self::Serial => "serial",
        }
    }

    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|order| order.name() == name)
    }
}
