//! Campaign to model (6): the parameters of each gyro, their full covariance, and what speaks for and against them.
//!
//! Reading order: [`design`] (what is fitted, in which gauge), [`crate::core::numerics::least_squares`] (least squares), [`repeats`] and
//! [`noise`] with [`growth`] (how far outputs can be trusted), [`further`] (effects beyond model (6)) and `common`
//! (those that all gyros share), [`drift`] (from there to D_I, D_S, D_O), [`mod@bench`] (one gyro on a
//! fixture). [`outcome`] puts them together: what a campaign comes to.

pub mod bench;
mod bench_form;
pub mod design;
pub mod drift;
pub mod effect_columns;
pub mod growth;
mod gyro_fit;
pub mod noise;
pub mod outcome;
mod shared_coefficients;

use nalgebra::{DMatrix, DVector, Vector3};

use super::campaign::{Campaign, CampaignNote, Dwell, LeftOut, Phase};
use super::diagnose::Adopted;
use super::effects::{Coefficient, Effect};
use super::model::{Term, Terms};
use super::mounting::Slot;
use super::record::Name;
use crate::core::calibrate::effect_columns::Regressors;
use crate::core::calibrate::shared_coefficients::{Own, Shared};
use crate::core::campaign::repeats::PureError;
use gyro_fit::{GyroFit, SharedFactors, fit_gyro};
use noise::{Evidence, Noise};

/// Where a gyro's E comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScaleSource {
    /// Fitted: the model has the scale term.
    Fitted,
    /// Held at `known_e_pulse_per_arcsec`.
    Held,
    /// Neither. The outputs stay in pulse/s.
    Missing,
}

/// One fitted number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// D0, G_x .. G_z, P_x .. P_z, E_x .. E_z.
    pub name: &'static str,
    pub term: Term,
    pub value: f64,
    /// None where the campaign does not determine the parameter, or nothing gives the noise.
    pub sd: Option<f64>,
    /// Whether the dwells (with the gauge) leave one value.
    pub determined: bool,
}

/// One fitted coefficient of an effect beyond model (6).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectParameter {
    pub effect: Effect,
    pub coefficient: Coefficient,
    pub value: f64,
    /// None where nothing gives the noise.
    pub sd: Option<f64>,
}

/// A direction of the parameters along which no dwell changes.
#[derive(Debug, Clone, PartialEq)]
pub struct NullDirection {
    /// Unit vector in the order of the parameters.
    pub direction: DVector<f64>,
    /// The condition that fixes it; none where it is merely cut off at the shortest solution.
    pub gauge: Option<&'static str>,
}

/// Rates up to this are the Earth's and the table's creep, arcsec/s.
const SLOW_ARCSEC_S: f64 = 20.0;

/// The condition that makes D0 and P unique at constant |a|.
pub const GAUGE: &str = "P_x + P_y + P_z = 0";

/// One gyro's fit.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroCalibration {
    pub slot: Slot,
    pub serial: Name,
    /// The terms that were fitted (without `scale` where E is held).
    pub terms: Terms,
    pub scale_source: ScaleSource,
    pub parameters: Vec<Parameter>,
    /// Fitted beside them: the effects of an augmented model.
    pub effects: Vec<EffectParameter>,
    /// Covariance of the parameters, p x p, with the noise scale and its t inflation; none without a noise scale.
    pub covariance: Option<DMatrix<f64>>,
    pub rank: usize,
    pub null_directions: Vec<NullDirection>,
    /// Sum of squared residuals over the standard errors as given (over 1 pulse/s without any).
    pub chi2: f64,
    pub dof: usize,
    /// Chance of residuals as large as these if the model and the noise scale are right.
    pub p_value: Option<f64>,
    pub noise: Noise,
    /// Standard deviation of each output as the noise scale has it, pulse/s; none without a noise scale.
    pub sigma: Option<DVector<f64>>,
    /// Measured less fitted, pulse/s, by dwell.
    pub residuals: DVector<f64>,
    /// The same over its own standard deviation, sigma sqrt(1 - leverage); none without a noise scale. Zero where
    /// the dwell is fitted exactly because nothing else speaks of it (leverage 1).
    pub standardised: Option<DVector<f64>>,
    /// By dwell, 0 to 1.
    pub leverage: DVector<f64>,
    known_e: Option<Vector3<f64>>,
}

/// The fit of a whole campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// What was asked for.
    pub terms: Terms,
    pub has_sem: bool,
    /// Groups of repeated dwells.
    pub repeats: Vec<Vec<usize>>,
    /// Without standard errors: rho, by how much the variance at the fastest rate exceeds that at rest.
    pub growth: f64,
    pub gyros: Vec<GyroCalibration>,
    /// Effects of the model that this campaign could not be fitted with, and why.
    pub notes: Vec<CampaignNote>,
}

/// Fits `terms` to every gyro of a campaign that passed [`Campaign::check`].
///
/// y_k = D0 + G.A_k + P.A_k^2 + E.w_k + noise, weights 1/sem^2 (equal without standard errors). A gyro with a known
/// E has E.w_k taken off first and no scale term fitted.
pub fn calibrate(campaign: &Campaign, terms: Terms) -> Calibration {
    calibrate_augmented(campaign, terms, &[])
}

/// As [`calibrate`], with the effects of an augmented model fitted beside the terms: each gyro for itself, and those of the
/// station once for all gyros together.
///
/// An effect that model (6) absorbs in this campaign, or that lacks a column, is left out and noted.
pub fn calibrate_augmented(campaign: &Campaign, terms: Terms, adopted: &[Adopted]) -> Calibration {
    let Regressors { own, shared: of_all, mut notes } = effect_columns::regressors(campaign, adopted);
    let dwells = &campaign.dwells;
    let has_sem = campaign.states_errors();
    let repeats = crate::core::campaign::repeats::repeats(dwells);
    let mut shared = SharedFactors::default();
    let mut fits: Vec<GyroFit> =
        own.into_iter().enumerate().map(|(j, r)| fit_gyro(campaign, j, terms, r, &repeats, &mut shared)).collect();
    for (fit, gyro) in fits.iter().zip(&campaign.gyros) {
        notes.extend(fit.hidden.iter().map(|effect| CampaignNote::EffectLeftOut {
            slot: Some(gyro.slot),
            effect: *effect,
            why: LeftOut::NotTold,
        }));
    }
    if !of_all.is_empty() {
        notes.extend(fit_common(of_all, &mut fits, has_sem, &repeats, &shared));
    }
    let growth = if has_sem { 0.0 } else { unequal_variances(campaign, &repeats, &mut fits) };
    let evidence: Vec<Evidence> = fits.iter().map(|f| f.evidence).collect();
    let gyros = fits
        .into_iter()
        .zip(noise::noise(&evidence, has_sem))
        .zip(&campaign.gyros)
        .enumerate()
        .map(|(j, ((fit, noise), gyro))| fit.finish(gyro, noise.with_scatter(sem_scatter(dwells, j)), &shared))
        .collect();
    Calibration { terms, has_sem, repeats, growth, gyros, notes }
}

/// Fits what all gyros share and takes it out of each gyro's fit; answers what these dwells cannot tell.
fn fit_common(
    of_all: Vec<Shared>,
    fits: &mut [GyroFit],
    has_sem: bool,
    repeats: &[Vec<usize>],
    shared: &SharedFactors,
) -> Vec<CampaignNote> {
    let own: Vec<Own> = fits.iter().map(|fit| fit.own(has_sem, shared)).collect();
    let common = shared_coefficients::fit(of_all, &own);
    let mut taken = 0.0;
    for (j, fit) in fits.iter_mut().enumerate() {
        let before = f64::round(taken);
        taken += common.leverage[j].sum();
        fit.take_out(&common, j, (taken.round() - before) as usize, repeats, shared);
    }
    let told = |effect: &Effect| CampaignNote::EffectLeftOut { slot: None, effect: *effect, why: LeftOut::NotTold };
    common.hidden.iter().map(told).collect()
}

/// Lets the residuals say how the noise grows with the rate, and what follows for each fit's evidence.
fn unequal_variances(campaign: &Campaign, repeats: &[Vec<usize>], fits: &mut [GyroFit]) -> f64 {
    let shares: Vec<DVector<f64>> = fits.iter().map(|fit| fit.rate_shares(campaign)).collect();
    let unweighted: Vec<_> = fits.iter().zip(&shares).map(|(fit, x)| fit.unweighted(x)).collect();
    let rho = growth::growth(&unweighted);
    for (fit, x) in fits.iter_mut().zip(&shares) {
        fit.variances = x.map(|x| 1.0 + rho * x);
        let scaled = fit.fit.residuals.zip_map(&fit.variances, |r, v| r * r / v);
        let pure_error = PureError::of(repeats, |k| fit.of_position[k], |k| fit.variances[k].sqrt());
        let evidence = Evidence::of(scaled.sum(), fit.fit.dof, pure_error);
        let gyro = fit.unweighted(x);
        let residual = evidence.residual.map(|_| (gyro.variance(rho), gyro.dof(rho)));
        fit.evidence = Evidence { residual, ..evidence };
    }
    rho
}

/// Standard deviations used as weights for gyro `j`: its standard errors, or ones.
pub fn weights_sd(campaign: &Campaign, j: usize) -> Vec<f64> {
    campaign.errors_of(j).unwrap_or_else(|| vec![1.0; campaign.dwells.len()])
}

fn sem_scatter(dwells: &[Dwell], j: usize) -> f64 {
    let still = dwells.iter().filter(|d| d.phase == Phase::Static);
    noise::sem_scatter(still.filter_map(|d| Some((d.output_sem_pulse_s.as_ref()?[j], d.duration_s))))
}

impl Calibration {
    /// How the figures came about.
    pub fn all_notes(&self) -> Vec<CampaignNote> {
        let mut notes = self.notes.clone();
        notes.extend((!self.has_sem).then_some(CampaignNote::NoStandardErrors));
        notes.extend((self.growth > 0.1).then(|| CampaignNote::NoiseGrows { times: (1.0 + self.growth).sqrt() }));
        notes.extend(self.repeats.is_empty().then_some(CampaignNote::NoRepeats));
        let overstated = |g: &GyroCalibration| Some((g.slot, noise::overstated(g.chi2, g.dof)?));
        let gyros: Vec<(Slot, f64)> = self.gyros.iter().filter(|_| self.has_sem).filter_map(overstated).collect();
        notes.extend((!gyros.is_empty()).then_some(CampaignNote::ErrorsOverstated { gyros }));
        let scattering = |g: &&GyroCalibration| g.p_value.is_some_and(|p| p < 1e-3);
        let gyros: Vec<Slot> = self.gyros.iter().filter(scattering).map(|g| g.slot).collect();
        notes.extend((!gyros.is_empty()).then_some(CampaignNote::ResidualsExceedNoise { gyros }));
        notes
    }
}

impl GyroCalibration {
    /// D0, pulse/s, where it was fitted.
    pub fn bias(&self) -> Option<f64> {
        self.of(Term::Bias).map(|p| p[0].value)
    }

    /// G, pulse/(s g0), body axes, where it was fitted.
    pub fn g(&self) -> Option<Vector3<f64>> {
        self.of(Term::GLinear).map(vector)
    }

    /// P, pulse/(s g0^2), body axes, where it was fitted.
    pub fn p(&self) -> Option<Vector3<f64>> {
        self.of(Term::GSquared).map(vector)
    }

    /// E, pulse/arcsec, body axes: fitted or held.
    pub fn e(&self) -> Option<Vector3<f64>> {
        self.known_e.or_else(|| self.of(Term::Scale).map(vector))
    }

    /// The parameters of one term, where it was fitted.
    pub fn of(&self, term: Term) -> Option<&[Parameter]> {
        let first = design::first_column(self.terms, term);
        self.terms.contains(term).then(|| &self.parameters[first..first + term.columns()])
    }

    /// Names of the parameters that the dwells do not determine.
    pub fn undetermined(&self) -> impl Iterator<Item = &'static str> {
        self.parameters.iter().filter(|p| !p.determined).map(|p| p.name)
    }

    /// Reduced chi-square against the standard errors as given; none where nothing is left over.
    pub fn reduced_chi2(&self) -> Option<f64> {
        (self.dof > 0).then(|| self.chi2 / self.dof as f64)
    }

    /// |E|, pulse/arcsec, where E is held or determined.
    pub fn scale_factor(&self) -> Option<f64> {
        let known = self.known_e.is_some() || self.of(Term::Scale).is_some_and(|e| e.iter().all(|p| p.determined));
        self.e().filter(|_| known).map(|e| e.norm()).filter(|&norm| norm > 0.0)
    }
}

fn vector(parameters: &[Parameter]) -> Vector3<f64> {
    Vector3::new(parameters[0].value, parameters[1].value, parameters[2].value)
}

#[cfg(test)]
mod tests;
