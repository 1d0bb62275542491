//! What a campaign comes to: fits and drift coefficients of an IMU, or a bench result.

use super::bench::{BenchCalibration, calibrate_bench};
use super::drift::NotSeparated;
use super::{Calibration, GyroCalibration, Kinds, calibrate_at_station, calibrate_in};
use crate::core::augmented::{AugmentedModel, Options};
use crate::core::campaign::commanded::{force_off_gravity, latitude_of_rates};
use crate::core::campaign::{
    Campaign, CampaignGyro, CampaignNote, CoarseStep, DriftOfGyro, StationPart, StationUncertainty, Stepped,
    Temperatures, TestKind,
};
use crate::core::fault::Faults;
use crate::core::model::Terms;
use crate::core::record::Plausibility;
use crate::core::separate::{Separation, separate};
use crate::core::units::radians_from_arcsec;

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
        let mut bench = calibrate_bench(campaign).map_err(|why| {
            faults.push("/dwells", why.message());
            faults
        })?;
        bench.notes.extend(latitude_sign_on_bench(campaign, &bench));
        bench.notes.extend(held_on_bench(campaign, &bench));
        return Ok(Outcome::Bench(Box::new(bench)));
    }
    let terms = model.terms.unwrap_or_else(|| campaign.terms());
    let mut calibration = calibrate_at_station(campaign, terms, model, model.reference_c);
    let separations = calibration.separate(&campaign.geometry, limits);
    calibration.notes.extend(latitude_sign(campaign, &separations));
    calibration.notes.extend(gravity_off(campaign, &calibration, &separations));
    calibration.notes.extend(latitude_off(campaign, &separations));
    calibration.notes.extend(drift_aliased(campaign, &calibration, &separations));
    calibration.notes.extend(held_scale(campaign, (terms, model), &calibration, limits));
    let as_measured = as_measured(campaign, terms, model, limits);
    for (i, separation) in separations.iter().enumerate() {
        if let Err(why @ (NotSeparated::Implausible(_) | NotSeparated::Unseparable(_))) = separation {
            faults.push(format!("/gyros/{i}"), why.message());
        }
    }
    faults.or(Outcome::Imu { calibration: Box::new(calibration), separations, as_measured })
}

/// Whether each E, held or fitted, is one that the gyro in its slot can have. Every way in asks it with the limits in
/// force.
///
/// # Errors
/// As [`Campaign::check_known_scales`] and [`evaluate`].
pub fn check_scales(campaign: &Campaign, limits: &Plausibility) -> Result<(), Faults> {
    campaign.check_known_scales(limits)?;
    if campaign.test == TestKind::Imu { evaluate(campaign, limits).map(|_| ()) } else { Ok(()) }
}

/// Shift of D_I from which a wrong sign of the latitude is looked for, deg/(h g0), and how near to it the D_I of every
/// gyro must be.
const LARGE_SHIFT: f64 = 8.0;
const NEAR_SHIFT: f64 = 0.5;

/// What a wrong sign of the latitude adds to D_I, deg/(h g0).
fn shift_of_latitude_sign(campaign: &Campaign) -> Option<f64> {
    let site = campaign.site?;
    Some(-2.0 * site.earth_rate().0.z / site.gravity_g0)
}

/// Whether all gyros have the D_I that a wrong sign of the latitude makes: rates whose vertical part is Omega sin L
/// with the wrong sign add -2 Omega sin L/g to it, along the specific force in every dwell. Nothing else in a campaign
/// shows it.
fn latitude_sign(campaign: &Campaign, separations: &[Result<Separation, NotSeparated>]) -> Option<CampaignNote> {
    let shift = shift_of_latitude_sign(campaign)?;
    let is_near = |separation: &Result<Separation, NotSeparated>| {
        separation.as_ref().is_ok_and(|own| (own.rigid.d_i / shift - 1.0).abs() < NEAR_SHIFT)
    };
    let all = separations.len() >= 2 && separations.iter().all(is_near);
    (all && shift.abs() > LARGE_SHIFT).then_some(CampaignNote::LatitudeSign { shift })
}

/// The same of one gyro by itself, where the shift is larger and D_I nearer to it.
const LARGE_SHIFT_ALONE: f64 = 12.0;
const NEAR_SHIFT_ALONE: f64 = 0.25;

fn latitude_sign_on_bench(campaign: &Campaign, bench: &BenchCalibration) -> Option<CampaignNote> {
    let shift = shift_of_latitude_sign(campaign)?;
    let d_i = bench.coefficient("D_I")?;
    let off = |value: f64| (value / shift).abs() < NEAR_SHIFT_ALONE;
    let is_near = shift.abs() > LARGE_SHIFT_ALONE && off(d_i.value - shift) && d_i.sd.is_none_or(off);
    is_near.then_some(CampaignNote::LatitudeSign { shift })
}

/// What specific forces that are longer or shorter than the site's gravity make of D_I and D_S, deg/(h g0): both are
/// smaller by that share. The coefficient that it moves most, where it shows. Where rounding explains it, that may be
/// told already.
fn gravity_off(
    campaign: &Campaign,
    calibration: &Calibration,
    separations: &[Result<Separation, NotSeparated>],
) -> Option<CampaignNote> {
    let (share, may_be_rounded) = force_off_gravity(campaign)?;
    let is_of_force = |note| matches!(note, CampaignNote::Coarse(CoarseStep { of: Stepped::Force, .. }));
    if may_be_rounded && calibration.coarse_steps(campaign).any(is_of_force) {
        return None;
    }
    let moved = |(gyro, separation): (&CampaignGyro, &Result<Separation, NotSeparated>)| {
        let rigid = &separation.as_ref().ok()?.rigid;
        let sd = rigid.sd()?;
        let shows = |(value, sd): &(f64, f64)| (share * value).abs() > TOLD_FROM * sd;
        let most = [(rigid.d_i, sd[0]), (rigid.d_s, sd[1])].into_iter().filter(shows);
        Some((gyro.slot, most.map(|(value, _)| (share * value).abs()).reduce(f64::max)?))
    };
    let moved = campaign.gyros.iter().zip(separations).filter_map(moved);
    let (slot, moves) = moved.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(CampaignNote::GravityOff { share, slot, moves })
}

/// Rates that are those of another latitude than the site's, where it shows in D_I.
fn latitude_off(campaign: &Campaign, separations: &[Result<Separation, NotSeparated>]) -> Option<CampaignNote> {
    let (degrees, moves) = latitude_of_rates(campaign)?;
    let sds = separations.iter().filter_map(|separation| Some(separation.as_ref().ok()?.rigid.sd()?[0]));
    let least = sds.reduce(f64::min)?;
    (moves > TOLD_FROM * least).then_some(CampaignNote::LatitudeOff { degrees, moves })
}

/// Detectability (root of the sum of squares that something leaves in the residuals, over their noise) below which it is
/// more often missed than seen.
pub(crate) const JUST_MISSED: f64 = 4.5;

/// The least share of a drift's squares that is reckoned to be left.
const LEAST_LEFT: f64 = 0.01;

/// Standard deviations of D_I or D_S from which on what a hidden drift moves is told: by chance orders have up to two.
const TOLD_OF_DRIFT: f64 = 3.0;

/// The gyro whose D_I or D_S moves most, over its standard deviation, by a drift in time that residuals do not show.
fn drift_aliased(
    campaign: &Campaign,
    calibration: &Calibration,
    separations: &[Result<Separation, NotSeparated>],
) -> Option<CampaignNote> {
    let times = campaign.dwells.iter().map(|dwell| dwell.mid_s() / 3600.0);
    let hours = times.clone().fold(f64::NEG_INFINITY, f64::max) - times.fold(f64::INFINITY, f64::min);
    let of_gyro = |(j, separation): (usize, &Result<Separation, NotSeparated>)| {
        let (gyro, by) = (&calibration.gyros[j], calibration.by_drift[j]);
        let rigid = &separation.as_ref().ok()?.rigid;
        let (sd, e, g) = (rigid.sd()?, gyro.e()?, gyro.g()?);
        // One deg/h is |E| pulse/s.
        let seen = e.norm() * by.left.max(LEAST_LEFT * by.squares).sqrt() / gyro.noise.factor?;
        let drift = rounded(JUST_MISSED / seen)?;
        let pulses = drift * e.norm();
        let moved = separate(&campaign.geometry, gyro.slot, &(e + by.e * pulses), &(g + by.g * pulses), None).ok()?;
        let [d_i, d_s] = [moved.rigid.d_i - rigid.d_i, moved.rigid.d_s - rigid.d_s].map(f64::abs);
        let times = (d_i / sd[0]).max(d_s / sd[1]);
        let of = DriftOfGyro { slot: gyro.slot, whole: drift * hours };
        let note = CampaignNote::DriftAliased { of: Some(of), drift, d_i, d_s };
        (times > TOLD_OF_DRIFT).then_some((times, note))
    };
    let told = separations.iter().enumerate().filter_map(of_gyro);
    told.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, note)| note)
}

/// To two digits; none of what is no number.
fn rounded(value: f64) -> Option<f64> {
    let unit = 10_f64.powf(value.log10().floor() - 1.0);
    Some((value / unit).round() * unit).filter(|rounded| rounded.is_normal())
}

/// What an error of the direction of E that is held does, with its size where nothing is stated, arcsec; and from which
/// part of the standard deviation of D_I or D_S on it is told.
const HELD_TO_ARCSEC: f64 = 20.0;
const TOLD_FROM: f64 = 0.3;

/// The gyro whose D_I or D_S moves most by an error of E that is held, where the station states no uncertainty of the
/// fixture: to the dwells, E that is turned in the IMU is the IMU that is turned in its fixture.
fn held_scale(
    campaign: &Campaign,
    (terms, model): (Terms, &Options),
    calibration: &Calibration,
    limits: &Plausibility,
) -> Option<CampaignNote> {
    let is_held = |gyro: &CampaignGyro| gyro.known_e.is_some();
    if campaign.station_uncertainty.fixture.is_some() || !campaign.gyros.iter().any(is_held) {
        return None;
    }
    let fixture = Some(radians_from_arcsec(HELD_TO_ARCSEC));
    let stated = StationUncertainty { fixture, ..StationUncertainty::default() };
    // What a rotation does is the same in any noise.
    let turned =
        calibrate_in(Kinds::White, campaign, terms, (&model.adopted, &model.known), model.reference_c, &stated);
    let moved = |((gyro, turned), own): ((&CampaignGyro, &GyroCalibration), &GyroCalibration)| {
        own.separate(&campaign.geometry, limits).ok().filter(|_| is_held(gyro))?;
        let budgets = own.budgets(&campaign.geometry, false)?.into_iter();
        let moved =
            turned.budgets(&campaign.geometry, false)?.into_iter().zip(budgets).take(2).filter_map(|(turned, own)| {
                let by = turned.of_station[StationPart::Fixture as usize]?;
                (by > TOLD_FROM * own.combined).then_some(by)
            });
        Some((gyro.slot, moved.reduce(f64::max)?))
    };
    let gyros = campaign.gyros.iter().zip(&turned.gyros).zip(&calibration.gyros);
    let (slot, moves) = gyros.filter_map(moved).max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(CampaignNote::HeldScale { slot, arcsec: HELD_TO_ARCSEC, moves })
}

/// What an error of the size of E that is held does on a bench: it is taken for one of this share.
const HELD_TO_SHARE: f64 = 1e-3;

/// What errors of the direction and of the size of E that is held would do to D_I or D_S of a bench test. The table's
/// rate is an answer in its own unit.
fn held_on_bench(campaign: &Campaign, bench: &BenchCalibration) -> Vec<CampaignNote> {
    let gyro = &campaign.gyros[0];
    let most = |moves: &dyn Fn(&str) -> Option<f64>| {
        let told = |name: &str| {
            let by = moves(name)?.abs();
            bench.coefficient(name)?.sd.filter(|sd| by > TOLD_FROM * sd).map(|_| by)
        };
        ["D_I", "D_S"].into_iter().filter_map(told).reduce(f64::max)
    };
    let direction = || {
        let fixture = Some(radians_from_arcsec(HELD_TO_ARCSEC));
        let station_uncertainty = StationUncertainty { fixture, ..StationUncertainty::default() };
        let turned = calibrate_bench(&Campaign { station_uncertainty, ..campaign.clone() }).ok()?;
        let by = |name: &str| turned.coefficient(name)?.uncertainty?.of_station[StationPart::Fixture as usize];
        Some(CampaignNote::HeldScale { slot: gyro.slot, arcsec: HELD_TO_ARCSEC, moves: most(&by)? })
    };
    let size = || {
        let gyros = vec![CampaignGyro { known_e: Some(gyro.known_e? * (1.0 + HELD_TO_SHARE)), ..gyro.clone() }];
        let longer = calibrate_bench(&Campaign { gyros, ..campaign.clone() }).ok()?;
        let by = |name: &str| Some(longer.coefficient(name)?.value - bench.coefficient(name)?.value);
        Some(CampaignNote::HeldSize { slot: gyro.slot, share: HELD_TO_SHARE, moves: most(&by)? })
    };
    let is_held = bench.holds_direction && campaign.station_uncertainty.fixture.is_none();
    let direction = is_held.then(direction).flatten();
    let size = (campaign.test == TestKind::TorqueFeedback).then(size).flatten();
    direction.into_iter().chain(size).collect()
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
