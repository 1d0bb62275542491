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
