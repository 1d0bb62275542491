//! What is to be said of the standard errors that a station states.

use crate::core::calibrate::noise;
use crate::core::diagnose::residuals::augmented_fit::Fit;
use crate::core::diagnose::residuals::noise_floor;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::numerics::tails::chi2_tail;

/// What is to be known of standard errors that are stated too large.
pub(crate) fn too_large(frame: &Frame) -> Option<String> {
    let gyros = frame.gyros.iter().zip(&frame.setting.gyros).filter(|_| frame.noise.stated);
    noise::overstated_note(
        gyros.filter_map(|(gyro, setting)| Some((setting.slot.name(), noise::overstated(gyro.rss(), gyro.dof())?))),
    )
}

/// What is to be known of standard errors that the repeats of all gyros show to be too small.
pub(crate) fn too_small(frame: &Frame, fit: &Fit) -> Option<String> {
    let of_gyros = frame.gyros.iter().zip(&fit.residuals).filter(|_| frame.noise.stated);
    let repeats = of_gyros.map(|(gyro, residual)| noise_floor::pure_error(frame, gyro, residual));
    let (sum, dof) = repeats.fold((0.0, 0), |(sum, dof), pure| (sum + pure.chi2, dof + pure.dof));
    let beyond_chance = chi2_tail(sum, dof).is_some_and(|p| p < 1e-3);
    beyond_chance.then(|| {
        let times = (sum / dof as f64).sqrt();
        format!(
            "repeated dwells scatter {times:.1} times as much as the stated standard errors say: those are too small, or what \
             changes from one time to the next is no noise"
        )
    })
}
