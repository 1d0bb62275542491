//! What a campaign comes to: fits and drift coefficients of an IMU, or a bench result.

use super::bench::{BenchCalibration, calibrate_bench};
use super::drift::NotSeparated;
use super::{Calibration, calibrate_at_station};
use crate::core::augmented::{AugmentedModel, Options};
use crate::core::campaign::{Campaign, CampaignNote, Temperatures, TestKind};
use crate::core::fault::Faults;
use crate::core::model::Terms;
use crate::core::record::Plausibility;
use crate::core::separate::Separation;

/// What a campaign came to: the calibration of an IMU, or the bench test of one gyro.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// Separations in the order of the gyros, each or the reason why there is none.
    Imu {
        calibration: Box<Calibration>,
        separations: Vec<Result<Separation, NotSeparated>>,
        /// Where those are stated at the temperature of the IMU's model: the same at the campaign's own.
        as_measured: Option<AsMeasured>,
    },
    Bench(Box<BenchCalibration>),
}

/// Separations at the mean temperature of the campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct AsMeasured {
    pub temperature_c: f64,
    pub separations: Vec<Result<Separation, NotSeparated>>,
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
    let mut calibration = calibrate_at_station(campaign, terms, model, model.reference_c);
    let separations = calibration.separate(&campaign.geometry, limits);
    calibration.notes.extend(latitude_sign(campaign, &separations));
    let as_measured = as_measured(campaign, terms, model, limits);
    for (i, separation) in separations.iter().enumerate() {
        if let Err(why @ (NotSeparated::Implausible(_) | NotSeparated::Unseparable(_))) = separation {
            faults.push(format!("/gyros/{i}"), why.message());
        }
    }
    faults.or(Outcome::Imu { calibration: Box::new(calibration), separations, as_measured })
}

/// Shift of D_I from which a wrong sign of the latitude is looked for, deg/(h g0), and how near to it the D_I of every
/// gyro must be.
const LARGE_SHIFT: f64 = 8.0;
const NEAR_SHIFT: f64 = 0.5;

/// Whether all gyros have the D_I that a wrong sign of the latitude makes: rates whose vertical part is Omega sin L
/// with the wrong sign add -2 Omega sin L/g to it, along the specific force in every dwell. Nothing else in a campaign
/// shows it.
fn latitude_sign(campaign: &Campaign, separations: &[Result<Separation, NotSeparated>]) -> Option<CampaignNote> {
    let site = campaign.site?;
    let shift = -2.0 * site.earth_rate().0.z / site.gravity_g0;
    let is_near = |separation: &Result<Separation, NotSeparated>| {
        separation.as_ref().is_ok_and(|own| (own.rigid.d_i / shift - 1.0).abs() < NEAR_SHIFT)
    };
    let all = separations.len() >= 2 && separations.iter().all(is_near);
    (all && shift.abs() > LARGE_SHIFT).then_some(CampaignNote::LatitudeSign { shift })
}

/// None where no effect of temperature moves anything.
fn as_measured(campaign: &Campaign, terms: Terms, model: &Options, limits: &Plausibility) -> Option<AsMeasured> {
    model.reference_c?;
    model.adopted.iter().find(|adopted| adopted.effect.entry().of_temperature)?;
    let stated = Temperatures::stated(campaign)?;
    let own = calibrate_at_station(campaign, terms, model, None);
    Some(AsMeasured {
        temperature_c: stated.iter().sum::<f64>() / stated.len() as f64,
        separations: own.separate(&campaign.geometry, limits),
    })
}
