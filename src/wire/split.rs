//! The gap of a campaign against a reference: parameters, structure, noise.

use crate::core::diagnose::{Moved, Parts, Split};
use crate::wire::prelude::*;
use crate::wire::unit;

/// What parts a campaign from a reference of the same IMU.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SplitBody {
    /// The reference.
    pub imu: String,
    pub station: String,
    pub measured_at: String,
    pub all: PartsBody,
    pub gyros: Vec<GyroPartsBody>,
    /// Coefficients then and now.
    pub moved: Vec<MovedBody>,
    pub notes: Vec<String>,
    /// The notes for programs.
    #[serde(default)]
    pub note_codes: Vec<MessageBody>,
}

impl SplitBody {
    pub(super) fn say(&mut self, language: Language) {
        self.notes = self.note_codes.iter_mut().map(|note| note.say(language)).collect();
    }
}

/// Root mean squares over dwells, weighted by 1/sd^2; the squares of the three parts add up to that of the whole.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PartsBody {
    /// Measured less what the reference's parameters predict.
    pub whole_deg_per_h: f64,
    /// What a new fit of the same model closes, above noise.
    pub parameters_deg_per_h: f64,
    /// What it leaves, above noise.
    pub structure_deg_per_h: f64,
    pub noise_deg_per_h: f64,
    /// Probability that noise alone moves the parameters as far.
    pub p_value: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GyroPartsBody {
    pub slot: String,
    #[serde(flatten)]
    pub parts: PartsBody,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MovedBody {
    pub slot: String,
    /// D0, D_I, D_S, D_O or |E|.
    pub coefficient: String,
    pub reference: f64,
    pub now: f64,
    pub shift: f64,
    /// Of the shift; null where neither states its noise.
    #[schema(required)]
    pub sd: Option<f64>,
    pub unit: String,
}

bodies! {
    PartsBody of Parts: whole_deg_per_h = whole, parameters_deg_per_h = parameters, structure_deg_per_h = structure,
        noise_deg_per_h = noise, p_value;
    MovedBody of Moved: slot, coefficient, reference, now, shift: |moved| moved.now - moved.reference, sd,
        unit: |moved| unit::of_machines(moved.unit);
    GyroPartsBody of (Slot, Parts): slot = 0, parts = 1;
    SplitBody of Split: imu, station, measured_at, all, gyros, moved, notes, note_codes = notes;
}
