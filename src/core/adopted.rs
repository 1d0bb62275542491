//! An effect of the catalogue as a model holds it.

use super::effects::{Effect, Shape};
use super::mounting::Slot;

/// What a model says of one coefficient of an effect in one gyro.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownCoefficient {
    pub slot: Slot,
    pub effect: Effect,
    pub name: &'static str,
    pub value: f64,
    pub sd: f64,
}

/// An effect that has entered the model: its regressors are fitted with model (6), its shape is held.
#[derive(Debug, Clone, PartialEq)]
pub struct Adopted {
    pub effect: Effect,
    pub shape: Shape,
    /// Gyros that have it; all of them for effects of the station.
    pub slots: Vec<Slot>,
}
