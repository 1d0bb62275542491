//! Where a campaign and the error model part, which unmodelled effect parts them, and how far the gap shrinks.
//!
//! Reading order: [`answer`] (what comes out), `frame` (model (6) taken out of everything), `bank` and `evidence` (how
//! a candidate scores), `null` (what noise alone scores), `search`, `sharpen` and `settle` (which are adopted), `fit` (the augmented
//! model), `heldout` (closure), `remaining` (tests without a catalogue), `identify`, `impact`, `next`, `report` (the answer).

mod diagnosis;
mod record_closure;
mod report;
mod residuals;
mod search;

pub use crate::core::diagnose::diagnosis::*;
pub use crate::core::diagnose::record_closure::{CLOSURE_CLASS, ClosureDiagnosis, GyroClosure, closures};

pub use crate::core::diagnose::report::against_reference::{Moved, NoReference, Parts, Reference, Split, split};
pub use crate::core::diagnose::search::noise_rounds::FALSE_ALARM;

use crate::core::diagnose::residuals::whitened::Frame;
pub(crate) use crate::core::diagnose::residuals::whitened::setting;
use crate::core::diagnose::search::noise_rounds::Settled;

use super::campaign::Campaign;
use super::effects::{Effect, Shape};
use super::model::Terms;
use super::mounting::Slot;

/// Raised by whoever changes what a diagnosis finds: one that was kept is then made again.
pub const METHOD: u32 = 7;

/// An effect that has entered the model: its regressors are fitted with model (6), its shape is held.
#[derive(Debug, Clone, PartialEq)]
pub struct Adopted {
    pub effect: Effect,
    pub shape: Shape,
    /// Gyros that have it; all of them for effects of the station.
    pub slots: Vec<Slot>,
}

/// What is compared with the campaign.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Terms of model (6) in use; the campaign's own where none are given.
    pub terms: Option<Terms>,
    /// Effects that the model in use holds already.
    pub adopted: Vec<Adopted>,
}

/// Why a campaign cannot be diagnosed at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    #[error(
        "{dwells} dwells leave nothing over the {parameters} parameters of the model: nothing can be held against it"
    )]
    TooFewDwells { dwells: usize, parameters: usize },
    #[error("the output of {0} is the same in every dwell")]
    NoOutput(&'static str),
    #[error("the geometry names no axes for {0}")]
    NoAxes(&'static str),
    #[error("the model holds no terms")]
    NoTerms,
}

/// Diagnoses one campaign against the terms and effects in use.
///
/// Errors: [`Refusal`] where no residual can be formed at all. What merely cannot be tested (no temperature, no
/// attitude, no repeats) is said in `notes` and `not_identifiable`.
pub fn diagnose(campaign: &Campaign, options: &Options) -> Result<Diagnosis, Refusal> {
    Ok(crate::core::diagnose::report::assemble::report(&Settled::of(Frame::of(campaign, options)?)?))
}
