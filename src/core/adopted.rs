//! An effect of the catalogue as a model holds it.

use super::effects::{Effect, Parameter, Shape};
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

impl Adopted {
    /// Whether it is a field whose direction was not told. At rest its part along north is one with E and G: where
    /// dwells do not show that part, E and G, hence D_I and D_S, are not told either.
    pub fn is_of_any_direction(&self) -> bool {
        self.effect.entry().parameter == Parameter::FieldAzimuth && self.shape == Shape::Linear
    }
}
