//! What a station that is not quite level, north or seated does to a fit: sensitivities, and the covariance that
//! follows (GUM 2008, 5.1.2 and 5.2.2).
//!
//! A rotation d (rad) that all dwells share changes what gyro j sees in dwell k by
//!
//! ```text
//! x_jk = G.dA + E.dw     dA = C(d x f), dw = C(d x w)  of the table, d along east, north or up
//!                        dA = d x A,    dw = d x w     of the IMU in its fixture, d along a body axis
//! ```
//!
//! per radian: the columns that the catalogue has for `levelling`, `azimuth` and `reseating` (a tilted table turns
//! about its own vertical: over whole turns only what lies along it stays). The weighted fit that makes the estimates
//! makes S = A+ x of them. The covariance is S diag(u^2) S'. P is left out of x: 2 P A dA is usually below a hundredth
//! of G.dA.

use nalgebra::{DMatrix, DVector};

use super::gyro_fit::GyroFit;
use super::shared_coefficients::{self, CommonFit, OwnFit};
use super::uncertainty::StationResponse;
use crate::core::campaign::{Campaign, CampaignNote, StationPart, StationUncertainty, StationUndetermined};
use crate::core::effects::{Effect, GyroAxes, Setting, Shape};
use crate::core::numerics::least_squares::{Factor, Fit};
use crate::core::numerics::normal_equations::{NormalEquations, Solution};
use crate::core::numerics::tails::chi2_tail;
use crate::core::units::arcsec;

/// A rotation of its standard uncertainty: what it makes of each gyro's outputs, pulse/s.
pub struct StationRotation {
    part: StationPart,
    /// By gyro of the setting.
    pub columns: Vec<DVector<f64>>,
}

/// The rotations that a station states: x u of the equation above, for the gyros of the setting. Those of the table
/// need attitudes.
pub fn rotations(setting: &Setting, stated: &StationUncertainty) -> Vec<StationRotation> {
    let mut rotations = Vec::new();
    for part in StationPart::ALL {
        let (effect, shape) = match part {
            StationPart::Levelling => (Effect::Levelling, Shape::Tilt { with_rate: false }),
            StationPart::Azimuth => (Effect::Azimuth, Shape::Linear),
            // From before the first dwell on: in all of them.
            StationPart::Fixture => (Effect::Reseating, Shape::Instant(f64::NEG_INFINITY)),
        };
        let Some(sd) = stated.of(part).filter(|_| part == StationPart::Fixture || setting.nav_to_body.is_some()) else {
            continue;
        };
        let scaled = |j: usize| {
            let columns = (effect.entry().columns)(setting, j, shape).into_iter();
            columns.map(move |column| setting.gyros[j].scale * sd * DVector::from_vec(column)).collect::<Vec<_>>()
        };
        let of_gyros: Vec<Vec<DVector<f64>>> = (0..setting.gyros.len()).map(scaled).collect();
        for c in 0..of_gyros.first().map_or(0, Vec::len) {
            rotations
                .push(StationRotation { part, columns: of_gyros.iter().map(|of_gyro| of_gyro[c].clone()).collect() });
        }
    }
    rotations
}

/// Hands each fit its responses, and what the station may have left in its residuals is no noise. Answers what cannot
/// be told.
pub(super) fn spread(
    campaign: &Campaign,
    stated: &StationUncertainty,
    fits: &mut [GyroFit],
    common: Option<&CommonFit>,
    has_sem: bool,
) -> Vec<CampaignNote> {
    let axes = campaign.gyros.iter().zip(fits.iter()).map(|(gyro, fit)| {
        let nominal = campaign.geometry.triad(gyro.slot)?.mat_gyro_body();
        let (e, g) = fit.e_and_g()?;
        Some(GyroAxes::carried(gyro.slot, nominal, e, g))
    });
    let (rotations, places, notes) = of_gyros(campaign, stated, axes.collect());
    for rotation in &rotations {
        let nothing = DVector::zeros(campaign.dwells.len());
        let of_gyro = |(fit, column): (&GyroFit, &Option<&DVector<f64>>)| fit.factor().fit(column.unwrap_or(&nothing));
        let columns: Vec<_> = places.iter().map(|place| place.map(|place| &rotation.columns[place])).collect();
        let mut seen: Vec<_> = fits.iter().zip(&columns).map(of_gyro).collect();
        if let Some(common) = common {
            let own = |(j, seen): (usize, _)| {
                let seen: &Fit = seen;
                let (factor, variance) = (fits[j].factor(), common.variances[j]);
                OwnFit { factor, residuals: &seen.residuals, variance }
            };
            let owns: Vec<OwnFit> = seen.iter().enumerate().map(own).collect();
            let taken = shared_coefficients::fit(common.kept.clone(), &owns).estimate;
            for (j, seen) in seen.iter_mut().enumerate() {
                for (regressor, k) in common.kept.iter().zip(taken.iter()) {
                    let Some(regressor) = &regressor[j] else { continue };
                    let absorbed = fits[j].factor().fit(&regressor.column);
                    seen.estimate.axpy(-k, &absorbed.estimate, 1.0);
                    seen.residuals.axpy(-k, &absorbed.residuals, 1.0);
                }
            }
        }
        for ((fit, seen), column) in fits.iter_mut().zip(seen).zip(&columns) {
            fit.station.extend(column.map(|_| response(rotation.part, seen)));
        }
    }
    let seen: Vec<InResiduals> =
        fits.iter().map(|fit| InResiduals { factor: fit.factor(), fit: &fit.fit, responses: &fit.station }).collect();
    let Some(TakenOut { net, times }) = take_out(&seen, has_sem) else { return notes };
    for (fit, (net, taken)) in fits.iter_mut().zip(net) {
        fit.leave(net, taken);
        fit.station.iter_mut().zip(&times).for_each(|(response, times)| response.times = *times);
    }
    notes.into_iter().chain(contradictions(stated, &rotations, &times)).collect()
}

fn response(part: StationPart, seen: Fit) -> StationResponse {
    StationResponse { part, estimate: seen.estimate, residuals: seen.residuals, times: 1.0 }
}

/// A note of each part of which the residuals hold more than is stated.
fn contradictions<'a>(
    stated: &'a StationUncertainty,
    rotations: &'a [StationRotation],
    times: &'a [f64],
) -> impl Iterator<Item = CampaignNote> + 'a {
    StationPart::ALL.into_iter().filter_map(move |part| {
        let times = rotations.iter().zip(times).find(|(of, times)| of.part == part && **times > 1.0)?.1;
        Some(CampaignNote::StationContradicted { part, times: *times, arcsec: arcsec(stated.of(part)?) })
    })
}

/// What a station makes of the fit of one gyro by itself.
#[derive(Default)]
pub(super) struct OfOne {
    pub responses: Vec<StationResponse>,
    /// Whitened residuals without what the station most likely left in them, and the degrees of freedom that this costs.
    pub net: Option<(DVector<f64>, usize)>,
    pub notes: Vec<CampaignNote>,
}

/// As [`spread`], of the only gyro of a campaign.
pub(super) fn of_one(campaign: &Campaign, axes: GyroAxes, (factor, fit): (&Factor, &Fit), has_sem: bool) -> OfOne {
    let (rotations, _, notes) = of_gyros(campaign, &campaign.station_uncertainty, vec![Some(axes)]);
    let of = |rotation: &StationRotation| response(rotation.part, factor.fit(&rotation.columns[0]));
    let mut responses: Vec<StationResponse> = rotations.iter().map(of).collect();
    let taken = match responses.as_slice() {
        [] => None,
        responses => take_out(&[InResiduals { factor, fit, responses }], has_sem),
    };
    let Some(TakenOut { mut net, times }) = taken else { return OfOne { responses, net: None, notes } };
    responses.iter_mut().zip(&times).for_each(|(response, times)| response.times = *times);
    let notes = notes.into_iter().chain(contradictions(&campaign.station_uncertainty, &rotations, &times)).collect();
    OfOne { net: Some(net.swap_remove(0)), responses, notes }
}

/// The rotations of the gyros whose axes are known, the place of each gyro among them, and what cannot be told.
fn of_gyros(
    campaign: &Campaign,
    stated: &StationUncertainty,
    axes: Vec<Option<GyroAxes>>,
) -> (Vec<StationRotation>, Vec<Option<usize>>, Vec<CampaignNote>) {
    let parts = || StationPart::ALL.into_iter().filter(|part| stated.of(*part).is_some());
    let left_out = |parts: Vec<StationPart>, why| CampaignNote::StationLeftOut { parts, why };
    let (mut notes, mut known, mut places) = (Vec::new(), Vec::new(), Vec::new());
    for (gyro, axes) in campaign.gyros.iter().zip(axes) {
        if axes.is_none() {
            notes.push(left_out(parts().collect(), StationUndetermined::Scale(gyro.slot)));
        }
        places.push(axes.is_some().then_some(known.len()));
        known.extend(axes);
    }
    let setting = Setting::of(campaign, known);
    let of_table: Vec<StationPart> = parts().filter(|part| *part != StationPart::Fixture).collect();
    if setting.nav_to_body.is_none() && !of_table.is_empty() && !setting.gyros.is_empty() {
        notes.push(left_out(of_table, StationUndetermined::Attitude));
    }
    (rotations(&setting, stated), places, notes)
}

/// Rounds in which the noise, where nothing states it, and what the station leaves in the residuals are told apart.
const ROUNDS: usize = 4;

/// Chance of rotations as large as those found, below which they contradict what is stated.
const CONTRADICTED: f64 = 1e-3;

/// Share of its stated variance that the residuals must tell of a rotation to speak of its size.
const TOLD: f64 = 0.05;

/// What [`take_out`] answers.
struct TakenOut {
    /// By gyro: whitened residuals, and the degrees of freedom that were taken out.
    net: Vec<(DVector<f64>, usize)>,
    /// By rotation: how many times what is stated the residuals say that it is, 1 where they do not contradict that.
    times: Vec<f64>,
}

/// A fit in whose residuals the rotations may have left something.
struct InResiduals<'a> {
    factor: &'a Factor,
    fit: &'a Fit,
    responses: &'a [StationResponse],
}

/// The residuals without what the rotations, each N(0, u^2) and one for all gyros, most likely left in them (ridge
/// regression): what the station's own uncertainty explains is neither noise nor lack of fit, and not counted twice.
/// By gyro, whitened, with the degrees of freedom that it costs.
///
/// What is found, d = P X'r with P = (1 + X'X)^-1 for the stated prior, has the variance (1 - P)(1 - P + s^2 P) in noise
/// of a scale s^2. A part whose d are too large for that (chi-square, p < 0.001) contradicts what is stated: its prior
/// is then as wide as what is found, d/(1 - P), and it stays in the residuals as lack of fit.
fn take_out(fits: &[InResiduals], has_sem: bool) -> Option<TakenOut> {
    let m = fits.iter().map(|fit| fit.responses.len()).max().unwrap_or(0);
    let whitened = |fit: &InResiduals, v: &DVector<f64>| v.component_mul(fit.factor.weights());
    let left: Vec<DMatrix<f64>> = fits
        .iter()
        .map(|fit| {
            let columns: Vec<_> = fit.responses.iter().map(|response| whitened(fit, &response.residuals)).collect();
            if columns.len() == m && m > 0 {
                DMatrix::from_columns(&columns)
            } else {
                DMatrix::zeros(fit.fit.residuals.len(), m)
            }
        })
        .collect();
    let residuals: Vec<DVector<f64>> = fits.iter().map(|fit| whitened(fit, &fit.fit.residuals)).collect();
    let scatter = |j: usize, net: &DVector<f64>, taken: f64| {
        let dof = fits[j].fit.dof as f64 - taken;
        if dof > 0.0 { (net.norm_squared() / dof).max(f64::MIN_POSITIVE) } else { 1.0 }
    };
    let mut variances: Vec<f64> =
        (0..fits.len()).map(|j| if has_sem { 1.0 } else { scatter(j, &residuals[j], 0.0) }).collect();
    let parts: Vec<StationPart> =
        fits.iter().map(|fit| fit.responses).max_by_key(|of| of.len())?.iter().map(|one| one.part).collect();
    let mut times = vec![1.0; m];
    let mut round = 0;
    let (net, taken): (Vec<_>, Vec<f64>) = loop {
        let prior = DMatrix::from_diagonal(&DVector::from_iterator(m, times.iter().map(|times| 1.0 / (times * times))));
        let mut normal = NormalEquations { matrix: prior, right: DVector::zeros(m) };
        for j in 0..fits.len() {
            normal.matrix += left[j].tr_mul(&left[j]) / variances[j];
            normal.right += left[j].tr_mul(&residuals[j]) / variances[j];
        }
        let Solution { estimate: likely, covariance } = normal.solve_beyond(&normal.matrix.diagonal(), 0.0)?;
        let without = |kept: &dyn Fn(usize) -> bool, j: usize| {
            let own = DMatrix::from_fn(left[j].nrows(), m, |k, i| if kept(i) { 0.0 } else { left[j][(k, i)] });
            let taken = (&covariance * left[j].tr_mul(&own)).trace() / variances[j];
            (&residuals[j] - own * &likely, taken)
        };
        let all: Vec<(DVector<f64>, f64)> = (0..fits.len()).map(|j| without(&|_| false, j)).collect();
        round += 1;
        if !has_sem && round % ROUNDS != 0 {
            variances = all.iter().enumerate().map(|(j, (net, taken))| scatter(j, net, *taken)).collect();
            continue;
        }
        let squares: f64 = all.iter().zip(&variances).map(|((net, _), variance)| net.norm_squared() / variance).sum();
        let dof = fits.iter().zip(&all).map(|(fit, (_, taken))| fit.fit.dof as f64 - taken).sum::<f64>();
        let noise = (squares / dof.max(1.0)).max(1.0);
        let told = |i: usize| 1.0 - covariance[(i, i)] / (times[i] * times[i]);
        let found = |part: StationPart| {
            let own: Vec<usize> = (0..m).filter(|i| parts[*i] == part && times[*i] == 1.0 && told(*i) > TOLD).collect();
            let over = |i: &usize| likely[*i].powi(2) / (told(*i) * (told(*i) + noise * (1.0 - told(*i))));
            let chance = chi2_tail(own.iter().map(over).sum(), own.len()).filter(|chance| *chance < CONTRADICTED)?;
            let size = own.iter().map(|i| (likely[*i] / told(*i)).powi(2)).sum::<f64>() / own.len() as f64;
            Some((part, chance, size.sqrt().max(1.0)))
        };
        match StationPart::ALL.into_iter().filter_map(found).min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((part, _, size)) => {
                times.iter_mut().zip(&parts).filter(|(_, of)| **of == part).for_each(|(times, _)| *times = size);
            }
            None => {
                break (0..fits.len()).map(|j| without(&|i| times[i] > 1.0, j)).unzip();
            }
        }
    };
    let net = net.into_iter().zip(shared_coefficients::in_whole_numbers(taken.into_iter())).collect();
    Some(TakenOut { net, times })
}
