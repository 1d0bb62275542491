//! Campaign to model (6): the parameters of each gyro, their full covariance, and what speaks for and against them.
//!
//! Reading order: [`design`] (what is fitted, in which gauge), [`crate::core::numerics::least_squares`] (least
//! squares), `repeats` and [`noise`] with [`growth`] (how far outputs can be trusted), [`effect_columns`] (effects
//! beyond model (6)) and `common` (those that all gyros share), [`drift`] (from there to D_I, D_S, D_O),
//! [`mod@bench`] (one gyro on a fixture). [`outcome`] puts them together: what a campaign comes to.

pub mod bench;
mod bench_form;
mod calibration;
pub mod correlated_noise;
pub mod design;
pub mod drift;
pub mod effect_columns;
pub mod growth;
mod gyro_fit;
pub mod law;
pub mod noise;
pub mod noise_found;
mod noise_report;
pub mod outcome;
mod regressor;
pub mod repeats_between;
pub mod reseated;
mod shared_coefficients;
mod shrunken_errors;
pub mod station;
pub mod uncertainty;

pub use calibration::{
    Calibration, EffectParameter, GyroCalibration, NullDirection, Parameter, ScaleSource, exceeds_noise, weights_sd,
};

use nalgebra::{DMatrix, DVector};

use super::augmented::{Adopted, KnownCoefficient, Options};
use super::campaign::{Campaign, CampaignNote, Dwell, EffectNotFitted, Phase, StationUncertainty, rounded_vertical};
use super::effects::Effect;
use super::model::Terms;
use crate::core::calibrate::effect_columns::{Regressors, Retold};
use crate::core::calibrate::regressor::Regressor;
use crate::core::calibrate::shared_coefficients::{CommonFit, OwnFit, SharedRegressors};
use crate::core::campaign::repeats::PureError;
use correlated_noise::{FittedGyro, Weighed};
use growth::{Exposure, NoiseGrowth};
use gyro_fit::{GyroFit, SharedDesigns, fit_gyro, retold};
use law::{DwellConditions, Law};
use noise::{Evidence, NoiseScale};
use noise_found::NoiseFound;

/// Fits `terms` to every gyro of a campaign that passed [`Campaign::check`].
///
/// y_k = D0 + G.A_k + P.A_k^2 + E.w_k + noise, weights 1/sem^2 (equal without standard errors; those of a law where
/// standard errors are estimates of few values). A gyro with a known E has E.w_k taken off first and no scale term
/// fitted.
///
/// ```
/// use gyrowatch::core::{calibrate::calibrate, model::Terms};
///
/// let text = std::fs::read("tests/data/practice/campaign-00.json")?;
/// let campaign = gyrowatch::wire::document::parse(&text)?;
/// let fit = calibrate(&campaign, Terms::MODEL_6);
/// // On a table D0 and P are one rank short: the null direction comes back, and G and E do not touch it.
/// let g1 = &fit.gyros[0];
/// assert_eq!((g1.parameters.len(), g1.rank, g1.null_directions.len()), (10, 9, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn calibrate(campaign: &Campaign, terms: Terms) -> Calibration {
    calibrate_augmented(campaign, terms, &[])
}

/// As [`calibrate`], with the noise as standard errors, repeats and residuals give it: white, independent, and without
/// the laws and memories that [`correlated_noise`] weighs. Where the commanded vectors may be wrong, what they
/// leave must not pass for noise that wanders.
pub fn calibrate_in_white_noise(campaign: &Campaign, terms: Terms) -> Calibration {
    calibrate_in(Kinds::White, campaign, terms, (&[], &[]), None, &StationUncertainty::default())
}

/// As [`calibrate`], with the effects of an augmented model fitted beside the terms: each gyro for itself, and those
/// of the station once for all gyros together.
///
/// An effect that model (6) absorbs in this campaign, or that lacks a column, is left out and noted.
pub fn calibrate_augmented(campaign: &Campaign, terms: Terms, adopted: &[Adopted]) -> Calibration {
    calibrate_in(Kinds::All, campaign, terms, (adopted, &[]), None, &StationUncertainty::default())
}

/// As [`calibrate_augmented`], with what the campaign states of its station in the covariances: [`station`]. An effect
/// that the model knows clearly better than these dwells tell it is held at the model's value, with its uncertainty,
/// unless they contradict it: then it is fitted, and D_I and D_S are as uncertain as that leaves them.
/// Effects of temperature count from `reference_c` (deg C; the campaign's mean where there is none): D0, G and E are
/// then those at that temperature.
pub fn calibrate_at_station(
    campaign: &Campaign,
    terms: Terms,
    model: &Options,
    reference_c: Option<f64>,
) -> Calibration {
    let effects = (&*model.adopted, &*model.known);
    calibrate_in(Kinds::All, campaign, terms, effects, reference_c, &campaign.station_uncertainty)
}

/// Standard errors by gyro and dwell, pulse/s, as a fit weighs by them: as stated, or shrunk to the law that they scatter
/// about where residuals follow that. None where no dwell states any.
pub fn errors_as_weighed(campaign: &Campaign) -> Option<Vec<Vec<f64>>> {
    let gyros = 0..campaign.gyros.len();
    let stated = gyros.clone().map(|j| campaign.errors_of(j)).collect::<Option<Vec<_>>>()?;
    if !shrunken_errors::may_scatter(&stated) {
        return Some(stated);
    }
    let mut shared = SharedDesigns::default();
    let fit = |j: usize| fit_gyro(campaign, j, campaign.terms(), (vec![], &[]), (stated[j].clone(), &[]), &mut shared);
    let fits: Vec<GyroFit> = gyros.map(fit).collect();
    Some(shrunken_errors::shrunken(campaign, &fits).map_or(stated, |shrunken| shrunken.sd))
}

/// Which kinds of noise are weighed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kinds {
    White,
    All,
}

fn calibrate_in(
    kinds: Kinds,
    campaign: &Campaign,
    terms: Terms,
    (adopted, known): (&[Adopted], &[KnownCoefficient]),
    reference_c: Option<f64>,
    stated: &StationUncertainty,
) -> Calibration {
    let Regressors { own, shared: of_all, known, any_temperature, mut notes } =
        effect_columns::regressors(campaign, (adopted, known), reference_c);
    let dwells = &campaign.dwells;
    let has_sem = campaign.states_errors();
    let repeats = crate::core::campaign::repeats::repeats(dwells);
    let mut shared = SharedDesigns::default();
    let mut fit_each = |sd: &dyn Fn(usize) -> Vec<f64>| {
        let of_gyro = |(j, r): (usize, &Vec<Regressor>)| retold(campaign, j, terms, (r, &known), sd(j), &mut shared);
        let retold: Vec<Retold> = own.iter().enumerate().flat_map(of_gyro).collect();
        let (held, contradicted) = effect_columns::to_hold(&retold, &known);
        let one = |(j, r): (usize, &Vec<Regressor>)| {
            fit_gyro(campaign, j, terms, (r.clone(), &held), (sd(j), &repeats), &mut shared)
        };
        (own.iter().enumerate().map(one).collect::<Vec<GyroFit>>(), contradicted)
    };
    let (mut fits, mut contradicted) = fit_each(&|j| weights_sd(campaign, j));
    let shrunken = shrunken_errors::shrunken(campaign, &fits);
    if let Some(shrunken) = &shrunken {
        (fits, contradicted) = fit_each(&|j| shrunken.sd[j].clone());
    }
    let of_any_direction = |effect: &Effect| adopted.iter().any(|a| a.effect == *effect && a.is_of_any_direction());
    // A field acts on all gyros, also on those that show nothing of its part along east.
    let is_untold = fits.iter().any(|fit| fit.hidden.iter().any(of_any_direction));
    for (fit, gyro) in fits.iter().zip(&campaign.gyros) {
        let note = |effect: &Effect, why| CampaignNote::EffectLeftOut { slot: Some(gyro.slot), effect: *effect, why };
        let hidden = |effect| {
            if of_any_direction(effect) { EffectNotFitted::NorthPart } else { EffectNotFitted::NotDistinguished }
        };
        notes.extend(fit.hidden.iter().map(|effect| note(effect, hidden(effect))));
        let held = |effect| {
            if any_temperature.contains(effect) { EffectNotFitted::AnyTemperature } else { EffectNotFitted::Held }
        };
        notes.extend(fit.held_effects().iter().map(|effect| note(effect, held(effect))));
    }
    let common = (!of_all.is_empty()).then(|| fit_common(of_all, &mut fits, has_sem, &repeats));
    let told = |effect: &Effect| CampaignNote::EffectLeftOut {
        slot: None,
        effect: *effect,
        why: EffectNotFitted::NotDistinguished,
    };
    notes.extend(common.iter().flat_map(|common| &common.hidden).map(told));
    if stated.is_stated() {
        notes.extend(station::spread(campaign, stated, &mut fits, common.as_ref(), has_sem));
    }
    let (growth, growth_chance) = if has_sem { (0.0, 1.0) } else { unequal_variances(campaign, &repeats, &mut fits) };
    let evidence: Vec<Evidence> = fits.iter().map(|f| f.evidence).collect();
    let scatter = |(j, noise): (usize, NoiseScale)| match shrunken {
        Some(_) => noise,
        None => noise.with_scatter(sem_scatter(dwells, j)),
    };
    let noises: Vec<NoiseScale> = noise::noise(&evidence, has_sem).into_iter().enumerate().map(scatter).collect();
    let mut coordinates: Vec<_> = fits.iter().zip(&noises).map(|(fit, noise)| fit.coordinates(noise)).collect();
    let found = (kinds == Kinds::All).then(|| weigh(dwells, has_sem, &fits, &mut coordinates));
    notes.extend(shrunken.and_then(|shrunken| shrunken.scatter).map(|scatter| CampaignNote::ErrorsScatter { scatter }));
    let found = found.unwrap_or_else(|| Weighed::white(fits.len()));
    let is_other_noise = noise_report::is_other(&found.kinds);
    let hours = DVector::from_iterator(dwells.len(), dwells.iter().map(|dwell| dwell.mid_s() / 3600.0));
    let hours = hours.add_scalar(-hours.mean());
    let by_drift = fits.iter().map(|fit| fit.by_drift(&hours)).collect();
    let course = DwellConditions::of(dwells);
    // What is not stated cannot state too little.
    let law = noise_report::law(&found.kinds).filter(|_| has_sem);
    let chances = law.and_then(|law| chances_under(law, &course, (has_sem, &repeats), &fits));
    let explains = |chances: &Vec<Option<f64>>| !chances.iter().any(|chance| exceeds_noise(*chance));
    let law_that_explains = law.filter(|_| chances.as_ref().is_some_and(explains)).map(Law::found);
    let vertical = rounded_vertical(campaign);
    let mut gyros: Vec<GyroCalibration> = fits
        .into_iter()
        .zip(noises)
        .zip(coordinates.into_iter().zip(found.white.iter().copied()))
        .zip(&campaign.gyros)
        .map(|(((fit, noise), coordinates), gyro)| fit.finish((gyro, vertical), noise, coordinates, is_other_noise))
        .collect();
    for gyro in &mut gyros {
        gyro.holds_untold_field = is_untold && gyro.scale_source == ScaleSource::Fitted;
        gyro.effects.retain(|one| !any_temperature.contains(&one.effect));
    }
    let noise_found = match kinds {
        Kinds::White => NoiseFound::default(),
        Kinds::All => noise_report::report(&found, &gyros),
    };
    Calibration {
        terms,
        has_sem,
        repeats,
        growth,
        growth_chance,
        gyros,
        notes,
        contradicted,
        noise_found,
        by_drift,
        law_that_explains,
    }
}

/// Chances of residuals as large as each gyro's where the noise goes by a law.
fn chances_under(
    law: Law,
    course: &DwellConditions,
    (has_sem, repeats): (bool, &[Vec<usize>]),
    fits: &[GyroFit],
) -> Option<Vec<Option<f64>>> {
    let evidence = fits.iter().map(|fit| fit.evidence_under(law, course, (has_sem, repeats)));
    let evidence = evidence.collect::<Option<Vec<Evidence>>>()?;
    Some(noise::noise(&evidence, has_sem).iter().zip(&evidence).map(|(noise, own)| noise.p_value(own)).collect())
}

/// Averages the covariance of each gyro's coordinates over the kinds of noise.
fn weigh(dwells: &[Dwell], has_sem: bool, fits: &[GyroFit], coordinates: &mut [Option<DMatrix<f64>>]) -> Weighed {
    let fitted: Vec<FittedGyro> = fits.iter().map(GyroFit::fitted).collect();
    correlated_noise::weigh(&DwellConditions::of(dwells), &fitted, coordinates, has_sem)
}

/// Fits what all gyros share and takes it out of each gyro's fit.
fn fit_common(of_all: Vec<SharedRegressors>, fits: &mut [GyroFit], has_sem: bool, repeats: &[Vec<usize>]) -> CommonFit {
    let own: Vec<OwnFit> = fits.iter().map(|fit| fit.own(has_sem)).collect();
    let common = shared_coefficients::fit(of_all, &own);
    let taken = shared_coefficients::in_whole_numbers(common.leverage.iter().map(|share| share.sum()));
    for (j, (fit, taken)) in fits.iter_mut().zip(taken).enumerate() {
        fit.take_out(&common, j, taken, repeats);
    }
    common
}

/// Lets the residuals say how the noise goes with rate and duration, and what follows for each fit's evidence.
fn unequal_variances(campaign: &Campaign, repeats: &[Vec<usize>], fits: &mut [GyroFit]) -> (f64, f64) {
    let exposures: Vec<Exposure> = fits.iter().map(|fit| fit.exposure(campaign)).collect();
    let unweighted: Vec<_> = fits.iter().zip(&exposures).map(|(fit, dwells)| fit.unweighted(dwells)).collect();
    let law = growth::law(&unweighted);
    let chance = growth::chance(&unweighted, law);
    for (fit, dwells) in fits.iter_mut().zip(&exposures) {
        fit.variances = law.variances(dwells);
        fit.even = NoiseGrowth { growth: 0.0, ..law }.variances(dwells);
        let (left, dof) = fit.left();
        let scaled = left.zip_map(&fit.variances, |r, v| r * r / v);
        let pure_error = PureError::of(repeats, |k| fit.of_position[k], |k| fit.variances[k].sqrt());
        let evidence = Evidence::of(scaled.sum(), dof, pure_error);
        let gyro = fit.unweighted(dwells);
        let residual = evidence.residual.map(|_| (gyro.variance(law), gyro.dof(law)));
        fit.evidence = Evidence { residual, ..evidence };
    }
    (law.growth, chance)
}

fn sem_scatter(dwells: &[Dwell], j: usize) -> f64 {
    let still = dwells.iter().filter(|d| d.phase == Phase::Static);
    noise::sem_scatter(still.filter_map(|d| Some((d.output_sem_pulse_s.as_ref()?[j], d.duration_s))))
}

#[cfg(test)]
mod tests;
