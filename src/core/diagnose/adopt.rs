//! A diagnosis into the model in use.

use crate::core::augmented::{Adopted, AugmentedModel, KnownEffect, Provenance};
use crate::core::campaign::Campaign;
use crate::core::diagnose::diagnosis::Diagnosis;

impl AugmentedModel {
    /// The model in use with what a diagnosis adopted: the next campaigns are compared with it.
    pub fn adopting(&self, campaign: &Campaign, diagnosis: &Diagnosis) -> Self {
        let new = diagnosis.effects.iter().map(|named| KnownEffect {
            adopted: Adopted { effect: named.effect, shape: named.shape, slots: named.gyros.clone() },
            estimates: named.estimates.clone(),
        });
        Self {
            terms: Some(self.terms.unwrap_or_else(|| campaign.terms())),
            effects: self.effects.iter().cloned().chain(new).collect(),
            found_in: Some(Provenance {
                imu: campaign.imu.clone(),
                station: campaign.station.clone(),
                measured_at: campaign.measured_at,
            }),
            // Coefficients that were fitted without the new effects are not those with them.
            identified: None,
            plausible_sizes: self.plausible_sizes.clone(),
        }
    }
}
