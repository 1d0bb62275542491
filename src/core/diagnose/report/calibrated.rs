//! The campaign as it is calibrated, with the model in use and with the named effects in it: what a diagnosis says of
//! coefficients, chi-square and stated standard errors is what the fit says.

use crate::core::augmented::Adopted;
use crate::core::calibrate::{Calibration, calibrate_augmented};
use crate::core::campaign::Campaign;
use crate::core::diagnose::residuals::augmented_fit::Part;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::model::{Term, Terms};

pub(crate) struct Calibrated {
    pub plain: Calibration,
    /// None where nothing is named.
    pub named: Option<Calibration>,
}

impl Calibrated {
    /// A term of model (6) among the named effects joins the terms of all gyros, as it does once the diagnosis is
    /// adopted.
    pub fn of(campaign: &Campaign, frame: &Frame, parts: &[Part]) -> Self {
        let plain = calibrate_augmented(campaign, frame.terms, &frame.adopted);
        let terms: Vec<Term> = frame.terms.iter().chain(parts.iter().filter_map(|part| part.effect.term())).collect();
        let named = parts.iter().filter(|part| part.effect.term().is_none()).map(|part| part.adopted(frame));
        let adopted: Vec<Adopted> = frame.adopted.iter().cloned().chain(named).collect();
        let named = (!parts.is_empty()).then(|| calibrate_augmented(campaign, Terms::of(&terms), &adopted));
        Self { plain, named }
    }

    /// With the named effects in the model, if there are any.
    pub fn augmented(&self) -> &Calibration {
        self.named.as_ref().unwrap_or(&self.plain)
    }
}
