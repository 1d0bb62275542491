//! What is to be said of the standard errors that a station states.

use crate::core::calibrate::noise;
use crate::core::campaign::repeats::PureError;
use crate::core::diagnose::report::calibrated::Calibrated;
use crate::core::numerics::tails::chi2_tail;

/// What is to be known of standard errors that are stated too large.
pub(crate) fn too_large(fits: &Calibrated) -> Option<String> {
    noise::overstated_note(fits.plain.overstated().into_iter().map(|(slot, times)| (slot.name(), times)))
}

/// What is to be known of standard errors that the repeats of all gyros show to be too small.
pub(crate) fn too_small(fits: &Calibrated) -> Option<String> {
    let fit = fits.augmented();
    let of_gyros = fit.gyros.iter().filter(|_| fit.has_sem).map(|gyro| gyro.noise.pure_error);
    let PureError { chi2, dof } = of_gyros.fold(PureError::default(), PureError::plus);
    let beyond_chance = chi2_tail(chi2, dof).is_some_and(|p| p < 1e-3);
    beyond_chance.then(|| {
        let times = (chi2 / dof as f64).sqrt();
        format!(
            "repeated dwells scatter {times:.1} times as much as the stated standard errors say: those are too small, or what \
             changes from one time to the next is no noise"
        )
    })
}
