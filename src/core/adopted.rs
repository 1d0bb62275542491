//! An effect of the catalogue as a model holds it.

use super::effects::{Effect, Shape};
use super::mounting::Slot;

/// An effect that has entered the model: its regressors are fitted with model (6), its shape is held.
#[derive(Debug, Clone, PartialEq)]
pub struct Adopted {
    pub effect: Effect,
    pub shape: Shape,
    /// Gyros that have it; all of them for effects of the station.
    pub slots: Vec<Slot>,
}
