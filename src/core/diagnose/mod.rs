//! Where a campaign and the error model part, which unmodelled effect parts them, and how far the gap shrinks.
//!
//! Reading order: [`answer`] (what comes out), `frame` (model (6) taken out of everything), `bank` and `evidence` (how
//! a candidate scores), `null` (what noise alone scores), `search`, `sharpen` and `settle` (which are adopted), `fit` (the augmented
//! model), `heldout` (closure), `remaining` (tests without a catalogue), `identify`, `impact`, `next`, `report` (the answer).

mod adopt;
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
use crate::core::diagnose::search::noise_rounds::Settled;

use super::augmented::Options;
use super::campaign::Campaign;
use super::effects::{CATALOGUE, COMPETITORS, Refusal};

/// Raised by whoever changes what a diagnosis finds: one that was kept is then made again. A new entry of the catalogue raises it by itself:
/// there were 48 when it was 7.
pub const METHOD: u32 = 7 + 100 * (CATALOGUE.len() + COMPETITORS.len() - 48) as u32;

/// Diagnoses one campaign against the terms and effects in use.
///
/// Errors: [`Refusal`] where no residual can be formed at all. What merely cannot be tested (no temperature, no
/// attitude, no repeats) is said in `notes` and `not_identifiable`.
pub fn diagnose(campaign: &Campaign, options: &Options) -> Result<Diagnosis, Refusal> {
    Ok(crate::core::diagnose::report::assemble::report(&Settled::of(Frame::of(campaign, options)?)?))
}
