//! In what order a list of gyros is read, where not by status.

use crate::core::named::named;

named! {
    /// By what a list of the fleet is sorted.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum FleetOrder {
        /// The larger load of D_I and D_S first, whatever its sign.
        Load = "load",
        /// What its trend carries to the budget first; then the others.
        Reach = "eta",
        /// What was calibrated the longest ago first.
        Age = "age",
        Serial = "serial",
    }
}
