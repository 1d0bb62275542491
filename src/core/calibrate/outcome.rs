//! What a campaign comes to: fits and drift coefficients of an IMU, or a bench result.

use super::bench::{BenchCalibration, calibrate_bench};
use super::drift::NotSeparated;
use super::{Calibration, calibrate_augmented};
use crate::core::augmented::AugmentedModel;
use crate::core::augmented::Options;
use crate::core::campaign::{Campaign, TestKind};
use crate::core::fault::Faults;
use crate::core::record::Plausibility;
use crate::core::separate::Separation;

#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// Separations in the order of the gyros, each or the reason why there is none.
    Imu {
        calibration: Calibration,
        separations: Vec<Result<Separation, NotSeparated>>,
    },
    Bench(Box<BenchCalibration>),
}

/// Fits a campaign that passed [`Campaign::check`] with the terms that it asks for, and separates its gyros.
///
/// # Errors
/// As [`evaluate_with`].
pub fn evaluate(campaign: &Campaign, limits: &Plausibility) -> Result<Outcome, Faults> {
    evaluate_with(campaign, &AugmentedModel::default().options(campaign), limits)
}

/// Fits terms and effects to a campaign, and separates its gyros. Of a bench test the coefficients are those of eq.
/// (5).
///
/// # Errors
/// Faults where the outputs contradict what the campaign says of itself: a fitted E that no gyro in its slot can have
/// (outputs or slots exchanged, polarity reversed), a bench test that determines no D_I and D_S.
pub fn evaluate_with(campaign: &Campaign, model: &Options, limits: &Plausibility) -> Result<Outcome, Faults> {
    let mut faults = Faults::default();
    if campaign.test != TestKind::Imu {
        return calibrate_bench(campaign).map(Box::new).map(Outcome::Bench).map_err(|why| {
            faults.push("/dwells", why.message());
            faults
        });
    }
    let terms = model.terms.unwrap_or_else(|| campaign.terms());
    let calibration = calibrate_augmented(campaign, terms, &model.adopted);
    let separations = calibration.separate(&campaign.geometry, limits);
    for (i, separation) in separations.iter().enumerate() {
        if let Err(why @ (NotSeparated::Implausible(_) | NotSeparated::Unseparable(_))) = separation {
            faults.push(format!("/gyros/{i}"), why.message());
        }
    }
    faults.or(Outcome::Imu { calibration, separations })
}
