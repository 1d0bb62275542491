//! What is to be said of the standard errors that a station states.

use crate::core::campaign::CampaignNote;
use crate::core::campaign::repeats::PureError;
use crate::core::diagnose::report::calibrated::Calibrated;
use crate::core::message::{Message, figure};
use crate::core::numerics::tails::chi2_tail;
use crate::message;

/// Gyros whose standard errors are stated too large, and how many times.
pub(crate) fn too_large(fits: &Calibrated) -> Option<CampaignNote> {
    let gyros = fits.plain.overstated();
    (!gyros.is_empty()).then_some(CampaignNote::ErrorsOverstated { gyros })
}

/// What is to be known of standard errors that the repeats of all gyros show to be too small.
pub(crate) fn too_small(fits: &Calibrated) -> Option<Message> {
    let fit = fits.augmented();
    let of_gyros = fit.gyros.iter().filter(|_| fit.has_sem).map(|gyro| gyro.noise.pure_error);
    let PureError { chi2, dof } = of_gyros.fold(PureError::default(), PureError::plus);
    let beyond_chance = chi2_tail(chi2, dof).is_some_and(|p| p < 1e-3);
    beyond_chance.then(|| message!("standard_errors_understated", times = figure((chi2 / dof as f64).sqrt(), 1)))
}
