//! What a fit answers, and what speaks for and against it.

use nalgebra::{DMatrix, DVector, Vector3};

use super::design;
use super::noise::{self, NoiseScale};
use super::noise_found::{LawFound, NoiseFound};
use super::uncertainty::Uncertainty;
use crate::core::campaign::repeats::PureError;
use crate::core::campaign::{Campaign, CampaignNote, GyroNoise, coarse_steps};
use crate::core::effects::{Coefficient, Effect};
use crate::core::model::{Term, Terms};
use crate::core::mounting::Slot;
use crate::core::named::named;
use crate::core::numerics::tails::chi2_tail;
use crate::core::record::Name;

named! {
/// Where a gyro's E comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScaleSource {
    /// Fitted: the model has the scale term.
    Fitted = "fitted",
    /// Held at `known_e_pulse_per_arcsec`.
    Held = "held",
    /// Neither. The outputs stay in pulse/s.
    Missing = "missing",
}
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
    /// Covariance of the parameters, p x p, with the noise scale and its t inflation, and with the station's part where
    /// one is stated; none without a noise scale.
    pub covariance: Option<DMatrix<f64>>,
    /// What that is made of.
    pub uncertainty: Option<Uncertainty>,
    /// Of the parameters.
    pub rank: usize,
    pub null_directions: Vec<NullDirection>,
    /// Sum of squared residuals over the standard errors that weigh (over 1 pulse/s without any).
    pub chi2: f64,
    pub dof: usize,
    /// Chance of residuals as large as these if the model and the noise scale are right.
    pub p_value: Option<f64>,
    pub noise: NoiseScale,
    /// Standard deviation of each output as the noise scale has it, pulse/s; none without a noise scale.
    pub sigma: Option<DVector<f64>>,
    /// Measured less fitted, pulse/s, by dwell.
    pub residuals: DVector<f64>,
    /// The same without what the station's stated uncertainty most likely left in them, and their degrees of freedom.
    pub left: (DVector<f64>, usize),
    /// The same over its own standard deviation, sigma sqrt(1 - leverage); none without a noise scale. Zero where
    /// the dwell is fitted exactly because nothing else speaks of it (leverage 1).
    pub standardised: Option<DVector<f64>>,
    /// By dwell, 0 to 1.
    pub leverage: DVector<f64>,
    /// Whether E and G hold the part of a field that these dwells do not tell from them.
    pub holds_untold_field: bool,
    pub(super) known_e: Option<Vector3<f64>>,
}

/// What a drift in time of one pulse/s an hour makes of one gyro's fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftResponse {
    /// Of E (pulse/arcsec) and G (pulse/(s g0)), body axes.
    pub e: Vector3<f64>,
    pub g: Vector3<f64>,
    /// Sums of squares over the standard errors that weigh: of the drift, and of what residuals show of it.
    pub squares: f64,
    pub left: f64,
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
    /// Chance of so much growth in residuals whose noise does not grow.
    pub growth_chance: f64,
    pub gyros: Vec<GyroCalibration>,
    /// Effects of the model that this campaign could not be fitted with, and why; what its figures look like.
    pub notes: Vec<CampaignNote>,
    /// Effects that these dwells tell less well than the model and yet contradict: fitted anew, with what that leaves of
    /// D_I and D_S.
    pub contradicted: Vec<(Slot, Effect)>,
    /// What the noise is beyond white, independent and as stated; its memory is in the covariances.
    pub noise_found: NoiseFound,
    /// By gyro.
    pub by_drift: Vec<DriftResponse>,
    /// The law of the noise, where residuals that exceed the noise as stated do not exceed it where it goes by that.
    pub law_that_explains: Option<LawFound>,
}

/// Whether residuals are so large that chance does not explain them: `p_value` is their chance.
pub fn exceeds_noise(p_value: Option<f64>) -> bool {
    p_value.is_some_and(|p| p < 1e-3)
}

/// What is noted of a memory of the noise.
pub(super) fn remembers(found: &NoiseFound) -> Option<CampaignNote> {
    let memory = found.memory.as_ref()?;
    Some(CampaignNote::NoiseRemembers { probability: memory.probability, deg_per_h: memory.largest() })
}

/// Whether repeats scatter more than three times as much as the stated standard errors.
pub(super) fn by_far(PureError { chi2, dof }: PureError) -> bool {
    const TIMES: f64 = 3.0;
    chi2 > TIMES * TIMES * dof as f64 && chi2_tail(chi2, dof).is_some_and(|p| p < 1e-6)
}

/// Standard deviations used as weights for gyro `j`: its standard errors, or ones.
pub fn weights_sd(campaign: &Campaign, j: usize) -> Vec<f64> {
    campaign.errors_of(j).unwrap_or_else(|| vec![1.0; campaign.dwells.len()])
}

/// Chance of the growth below which noise is said to grow with rate.
const GROWTH_CHANCE: f64 = 0.01;

impl Calibration {
    /// The notes of the fit, and what its noise is found to be: nothing that is said of it anywhere else is missing.
    pub fn all_notes(&self) -> Vec<CampaignNote> {
        let mut notes = self.notes.clone();
        notes.extend(self.contradicted.iter().map(|(slot, effect)| {
            let (slot, effect) = (*slot, *effect);
            CampaignNote::EffectContradicted { slot, effect }
        }));
        notes.extend((!self.has_sem).then_some(CampaignNote::NoStandardErrors));
        let grows = self.growth_chance < GROWTH_CHANCE;
        notes.extend(grows.then(|| CampaignNote::NoiseGrows { times: (1.0 + self.growth).sqrt() }));
        let found = &self.noise_found;
        notes.extend(found.largest_correlation().map(|correlation| CampaignNote::NoiseShared { correlation }));
        notes.extend(remembers(found));
        notes.extend(self.repeats.is_empty().then_some(CampaignNote::NoRepeats));
        let gyros = self.overstated();
        notes.extend((!gyros.is_empty()).then_some(CampaignNote::ErrorsOverstated { gyros }));
        notes.extend(self.understated());
        let scattering = |g: &&GyroCalibration| exceeds_noise(g.p_value);
        let gyros: Vec<Slot> = self.gyros.iter().filter(scattering).map(|g| g.slot).collect();
        notes.extend(
            (!gyros.is_empty()).then_some(CampaignNote::ResidualsExceedNoise { gyros, law: self.law_that_explains }),
        );
        notes
    }

    /// Steps of what was commanded or counted that are not small against the noise as fitted.
    pub fn coarse_steps(&self, campaign: &Campaign) -> impl Iterator<Item = CampaignNote> {
        // Repeats that fall on one count show no noise; f64 and ten digits end there.
        const ROUNDING: f64 = 1e-9;
        let of_gyro = |(j, gyro): (usize, &GyroCalibration)| {
            let largest = campaign.dwells.iter().fold(0.0_f64, |most, d| most.max(d.output_pulse_s[j].abs()));
            Some(GyroNoise {
                slot: gyro.slot,
                g: gyro.g().map_or(0.0, |g| g.norm()),
                e: gyro.e().map_or(0.0, |e| e.norm()),
                sd: gyro.sigma.as_ref()?.iter().map(|sd| sd.max(ROUNDING * largest)).collect(),
            })
        };
        let gyros: Vec<Option<GyroNoise>> = self.gyros.iter().enumerate().map(of_gyro).collect();
        coarse_steps(campaign, &gyros).into_iter().map(CampaignNote::Coarse)
    }

    /// Gyros whose stated standard errors are too large for the scatter of the dwells, and how many times.
    pub fn overstated(&self) -> Vec<(Slot, f64)> {
        let overstated = |g: &GyroCalibration| Some((g.slot, noise::overstated(g.chi2, g.dof)?));
        self.gyros.iter().filter(|_| self.has_sem).filter_map(overstated).collect()
    }

    /// Gyros whose repeats scatter more than three times as much as the stated standard errors, and not with time: those
    /// are in another unit, and repeats alone do not make `residuals_exceed_noise` of it.
    fn understated(&self) -> Option<CampaignNote> {
        let is_asked = self.has_sem && self.noise_found.memory.is_none();
        let gyros: Vec<&GyroCalibration> =
            self.gyros.iter().filter(|g| is_asked && by_far(g.noise.pure_error)).collect();
        let all = gyros.iter().map(|g| g.noise.pure_error).reduce(PureError::plus)?;
        let times = (all.chi2 / all.dof as f64).sqrt();
        Some(CampaignNote::ErrorsUnderstated { gyros: gyros.into_iter().map(|g| g.slot).collect(), times })
    }

    /// Reduced chi-square of all gyros together: against the standard errors as stated or, where none are, against
    /// the noise that is found. None where nothing is left over, or nothing gives the noise.
    pub fn reduced_chi2(&self) -> Option<f64> {
        let over_noise = |g: &GyroCalibration| match &g.sigma {
            _ if self.has_sem => Some(g.chi2),
            sigma => Some(g.residuals.component_div(sigma.as_ref()?).norm_squared()).filter(|chi2| chi2.is_finite()),
        };
        let chi2: f64 = self.gyros.iter().map(over_noise).sum::<Option<f64>>()?;
        let dof: usize = self.gyros.iter().map(|g| g.dof).sum();
        (dof > 0).then(|| chi2 / dof as f64)
    }

    /// Ratio of real to stated noise, root mean square over the gyros; none where no standard errors are stated.
    pub fn sem_factor(&self) -> Option<f64> {
        let squares: f64 = self.gyros.iter().map(|g| Some(g.noise.factor?.powi(2))).sum::<Option<f64>>()?;
        self.has_sem.then(|| (squares / self.gyros.len() as f64).sqrt())
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

    /// Reduced chi-square against the standard errors that weigh; none where nothing is left over.
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
