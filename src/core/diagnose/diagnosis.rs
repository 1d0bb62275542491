//! What a diagnosis answers. Plain data, every number finite; the wire form is `wire::diagnosis`.

use nalgebra::{Matrix3, Vector3};

use crate::core::augmented::Adopted;
use crate::core::calibrate::noise_found::NoiseFound;
use crate::core::campaign::Phase;
use crate::core::effects::{Effect, Estimate, Shape};
use crate::core::message::Message;
use crate::core::model::Terms;
use crate::core::mounting::Slot;
use crate::core::named::named;
use crate::core::note::Note;

named! {
/// How far the catalogue explains the gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Structure is not above the noise floor.
    NoGap = "no_gap",
    /// Something was adopted and nothing significant remains.
    Explained = "explained",
    /// Something was adopted and something significant remains.
    PartlyExplained = "partly_explained",
    /// There is a gap, and nothing of the catalogue earns adoption.
    Unexplained = "unexplained",
}
}

/// The answer for one campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// What the campaign was compared with: terms of model (6), and effects that the model holds already.
    pub terms: Terms,
    pub adopted: Vec<Adopted>,
    /// Hypotheses of one's own that competed with the catalogue.
    pub hypotheses: Vec<Effect>,
    pub verdict: Verdict,
    pub noise_floor: NoiseFloor,
    /// What model (6), or the terms and effects in use, leaves above the floor.
    pub gap: Gap,
    pub located: Located,
    /// In the order of adoption.
    pub effects: Vec<NamedEffect>,
    /// Closure by all adopted effects together; none where nothing was adopted.
    pub closure: Option<HeldOut>,
    /// What is left after adoption, tested without the catalogue as well.
    pub remaining: Remaining,
    /// Everything tried and not adopted, best first.
    pub candidates: Vec<Candidate>,
    pub not_identifiable: Vec<NotIdentifiable>,
    pub impact: Vec<Impact>,
    pub next_dwells: Vec<NextDwell>,
    /// Residual of each gyro in each dwell before and after adoption.
    pub residuals: Vec<Residual>,
    /// What is to be known of the campaign itself.
    pub of_campaign: Vec<Note>,
    /// What could not be done with this campaign, and why.
    pub notes: Vec<Message>,
    /// What the noise is beyond white, independent and as stated.
    pub noise: NoiseFound,
    /// What is left goes with, the strongest first, where something is left: no cause.
    pub description: Vec<Described>,
}

named! {
/// What a dwell has that others may have too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Variable("variable_") {
    Time = "time",
    Temperature = "temperature",
    TemperatureRate = "rate_of_temperature",
    UpDirection = "up_direction",
    Heading = "heading",
    RateLevel = "rate_level",
    RateAxis = "rate_axis",
    RateHistory = "rate_history",
    OrientationBefore = "previous_orientation",
    OrientationAge = "orientation_age",
    Phase = "phase",
    TimeAndForce = "time_and_force",
    TimeAndRate = "time_and_rate",
    TimeAndHeading = "time_and_heading",
    TemperatureAndForce = "temperature_and_force",
    TemperatureAndRate = "temperature_and_rate",
    TemperatureAndHeading = "temperature_and_heading",
    TemperatureAndTime = "temperature_and_time",
    SingleDwells = "single_dwells",
}
}

/// One thing that what is left goes with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Described {
    pub by: Variable,
    /// ln of the odds against noise.
    pub evidence: f64,
}

/// Standard uncertainty of one dwell, deg/h, and what it was taken from.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseFloor {
    /// Root mean square over gyros and dwells of the standard uncertainty of one dwell.
    pub deg_per_h: f64,
    /// "repeats+residuals+sem", "repeats+sem", "residuals+sem", "sem", "repeats+residual", "repeats", "residual".
    pub source: &'static str,
    /// Real over stated standard errors; 1 where none are stated.
    pub sem_factor: f64,
    pub gyros: Vec<GyroFloor>,
}

/// The noise floor of one gyro, deg/h.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroFloor {
    pub slot: Slot,
    pub deg_per_h: f64,
    /// Degrees of freedom of repeated dwells (pure error).
    pub repeat_dof: usize,
}

/// Difference between measurement and model over the dwells, deg/h.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// Root mean square of the residuals.
    pub rms_deg_per_h: f64,
    /// What that would be by noise alone: less than the noise floor, because the fit takes up part of the noise.
    pub noise_alone_deg_per_h: f64,
    /// Residual sum of squares over the floor's variance and degrees of freedom.
    pub reduced_chi2: f64,
    /// That noise alone shows as much structure, over everything that was looked at.
    pub p_value: f64,
}

/// Where squared residuals exceed what noise alone leaves: shares by gyro, phase and dwell. Those of gyros and of
/// phases add up to 1.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Located {
    pub gyros: Vec<(Slot, f64)>,
    pub phases: Vec<(Phase, f64)>,
    /// Largest shares first.
    pub dwells: Vec<DwellShare>,
}

/// One gyro in one dwell: its residual and share.
#[derive(Debug, Clone, PartialEq)]
pub struct DwellShare {
    pub index: usize,
    pub slot: Slot,
    pub residual_deg_per_h: f64,
    pub share: f64,
}

/// One adopted effect.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedEffect {
    pub effect: Effect,
    /// Its non-linear parameter, at the value adopted.
    pub shape: Shape,
    /// Every entry that this campaign cannot tell from it, itself first.
    pub class: Vec<Effect>,
    /// Gyros in which more would do as well, as far as that gyro alone can say, with all that would.
    pub wider_in: Vec<(Slot, Vec<Effect>)>,
    /// The gyros that have it.
    pub gyros: Vec<Slot>,
    /// From when to when it acts, s after the first dwell, where that is not the whole campaign.
    pub acts_in: Option<[f64; 2]>,
    pub estimates: Vec<Estimate>,
    pub held_out: HeldOut,
    pub p_value_adjusted: f64,
    /// Square root of the whitened power that the effect takes from the residual.
    pub detectability: f64,
    /// What it adds in each dwell of the gyros that have it, at the estimates: sum_m k_m x_m, deg/h.
    pub drift: Vec<(Slot, Vec<f64>)>,
}

/// Errors of prediction on dwells that were not fitted, and the fraction of the gap that closes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldOut {
    pub before_deg_per_h: f64,
    pub after_deg_per_h: f64,
    /// 1 - (MSE after - floor) / (MSE before - floor), limited to 1.
    pub closure: f64,
    /// 95 % interval; it knows that the effect was selected on the same campaign.
    pub interval: [f64; 2],
}

/// What is left once the named effects are in the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Remaining {
    pub rms_deg_per_h: f64,
    pub reduced_chi2: f64,
    pub p_value: f64,
    /// What the tests that know no catalogue see, strongest first; empty where nothing is significant.
    pub signs: Vec<Sign>,
}

/// A kind of structure that a test independent of the catalogue found.
#[derive(Debug, Clone, PartialEq)]
pub struct Sign {
    pub kind: &'static str,
    pub slots: Vec<Slot>,
    /// The dwells that stand out, where it is of single ones.
    pub dwells: Vec<usize>,
    pub p_value: f64,
}

impl Sign {
    pub(crate) fn of_no_dwell(kind: &'static str, slots: Vec<Slot>, p_value: f64) -> Self {
        Self { kind, slots, dwells: Vec::new(), p_value }
    }
}

/// An effect that was tried and not named.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    pub effect: Effect,
    /// Fraction of the reducible gap that it closes alone; none where it could not be tried.
    pub closure: Option<f64>,
    /// 95 % interval of that.
    pub interval: Option<[f64; 2]>,
    pub p_value_adjusted: f64,
    /// Whether it stands out from noise no more than a first name must. Its closure is then that of a gap which is
    /// not there: the share of a chance pattern that an entry takes when its gyros and shape are chosen to take most,
    /// and no finding.
    pub within_noise: bool,
    pub gyros: Vec<Slot>,
    pub why_not: Message,
}

/// An effect that this campaign hides, wholly or in part.
#[derive(Debug, Clone, PartialEq)]
pub struct NotIdentifiable {
    pub effect: Effect,
    /// Share of the effect's whitened power that the model in use cannot absorb, best gyro.
    pub visible_fraction: f64,
    /// What it is hard to tell from; empty where the campaign shows nothing of it at all.
    pub confounded_with: Vec<Effect>,
    pub reason: Message,
}

/// Shift of a coefficient when the adopted effects enter the model: augmented minus plain.
#[derive(Debug, Clone, PartialEq)]
pub struct Impact {
    pub slot: Slot,
    pub coefficient: &'static str,
    pub plain: f64,
    /// None where G was not in the model.
    pub plain_sd: Option<f64>,
    pub augmented: f64,
    pub augmented_sd: f64,
    pub shift: f64,
    /// |shift| over the budget, [`BUDGET_DEG_PER_H_G0`].
    pub of_budget: f64,
}

/// A shift counts beyond so many of the augmented model's standard deviations.
const MATERIAL: f64 = 4.0;

impl Impact {
    /// Whether the effect moves the coefficient beyond its noise. Where it does not, plain and augmented values
    /// differ by less than either is known to, and which of them is nearer to the truth is chance.
    pub fn is_material(&self) -> bool {
        self.shift.abs() > MATERIAL * self.augmented_sd
    }
}

/// The short-term stability that the paper asks of D_I and D_S (section 4.3), deg/(h g0).
pub const BUDGET_DEG_PER_H_G0: f64 = 1e-2;

/// A dwell worth measuring next.
#[derive(Debug, Clone, PartialEq)]
pub struct NextDwell {
    pub phase: Phase,
    pub specific_force_g0: Vector3<f64>,
    pub rate_arcsec_s: Vector3<f64>,
    /// Columns: east, north and up in body axes.
    pub attitude: Matrix3<f64>,
    /// Of the table about the vertical, arcsec/s.
    pub table_rate_arcsec_s: f64,
    pub separates: Vec<Effect>,
}

/// Residuals of one gyro in one dwell, deg/h.
#[derive(Debug, Clone, PartialEq)]
pub struct Residual {
    pub index: usize,
    pub slot: Slot,
    pub before_deg_per_h: f64,
    pub after_deg_per_h: f64,
    pub sd_deg_per_h: f64,
}
