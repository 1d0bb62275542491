//! What a campaign comes to: fits and drift coefficients of an IMU, or a bench result.

use super::bench::{BenchCalibration, calibrate_bench};
use super::drift::NotSeparated;
use super::{Calibration, calibrate};
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

/// Fits a campaign that passed [`Campaign::check`], and separates its gyros.
///
/// # Errors
/// Faults where the outputs contradict what the campaign says of itself: a fitted E that no gyro in its slot can have
/// (outputs or slots exchanged, polarity reversed), a bench test that determines no D_I and D_S.
pub fn evaluate(campaign: &Campaign, limits: &Plausibility) -> Result<Outcome, Faults> {
    let mut faults = Faults::default();
    if campaign.test != TestKind::Imu {
        return calibrate_bench(campaign).map(Box::new).map(Outcome::Bench).map_err(|why| {
            faults.push("/dwells", why.to_string());
            faults
        });
    }
    let calibration = calibrate(campaign, campaign.terms());
    let separations = calibration.separate(&campaign.geometry, limits);
    for (i, separation) in separations.iter().enumerate() {
        if let Err(why @ (NotSeparated::Implausible(_) | NotSeparated::Unseparable(_))) = separation {
            faults.push(format!("/gyros/{i}"), why.to_string());
        }
    }
    faults.or(Outcome::Imu { calibration, separations })
}
