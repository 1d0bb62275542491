//! What is to be said of the standard errors that a station states.

use crate::core::calibrate::noise;
use crate::core::campaign::CampaignNote;
use crate::core::diagnose::residuals::augmented_fit::Fit;
use crate::core::diagnose::residuals::noise_floor;
use crate::core::diagnose::residuals::whitened::{Frame, GyroFrame};
use crate::core::effects::GyroAxes;
use crate::core::message::{Message, figure};
use crate::core::numerics::tails::chi2_tail;
use crate::message;

/// Gyros whose standard errors are stated too large, and how many times.
pub(crate) fn too_large(frame: &Frame) -> Option<CampaignNote> {
    let gyros = frame.gyros.iter().zip(&frame.setting.gyros).filter(|_| frame.noise.stated);
    let overstated =
        |(gyro, setting): (&GyroFrame, &GyroAxes)| Some((setting.slot, noise::overstated(gyro.rss(), gyro.dof())?));
    let gyros: Vec<_> = gyros.filter_map(overstated).collect();
    (!gyros.is_empty()).then_some(CampaignNote::ErrorsOverstated { gyros })
}

/// What is to be known of standard errors that the repeats of all gyros show to be too small.
pub(crate) fn too_small(frame: &Frame, fit: &Fit) -> Option<Message> {
    let of_gyros = frame.gyros.iter().zip(&fit.residuals).filter(|_| frame.noise.stated);
    let repeats = of_gyros.map(|(gyro, residual)| noise_floor::pure_error(frame, gyro, residual));
    let (sum, dof) = repeats.fold((0.0, 0), |(sum, dof), pure| (sum + pure.chi2, dof + pure.dof));
    let beyond_chance = chi2_tail(sum, dof).is_some_and(|p| p < 1e-3);
    beyond_chance.then(|| message!("standard_errors_understated", times = figure((sum / dof as f64).sqrt(), 1)))
}
