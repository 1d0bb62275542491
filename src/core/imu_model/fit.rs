//! From campaigns of one IMU to its model: one weighted fit of all gyros and campaigns together.
//!
//! ```text
//! y_cjk = x_cjk.(theta + delta_c) + s_cjk.d_c + noise,     delta_c ~ N(0, tau^2),  d_c ~ N(0, u_c^2)
//! ```
//!
//! with `theta` the coefficients, gyros `j`, campaigns `c`, dwells `k`. `delta` is what D0, G and E do from campaign to
//! campaign beyond their noise (power-ups, seats, ageing). `tau` of each of the three families comes from the
//! campaigns' own fits (DerSimonian and Laird 1986) and is zero where their scatter is within their noise. The weights
//! are the noise that each campaign's own calibration finds. `d` are the rotations of the station, as uncertain as it
//! states ([`crate::core::calibrate::station`]) and others in each campaign: what no campaign is to be held against
//! another for.

use std::borrow::Cow;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Vector3};

use super::columns::columns;
use super::identified::{FittedCampaign, Identified, ModelCoefficient, ModelGyro, NoiseLaw, Of, Validity};
use super::programme::station_columns;
use crate::core::augmented::{Adopted, AugmentedModel, KnownEffect, Options, Provenance};
use crate::core::calibrate::design::Design;
use crate::core::calibrate::noise::NoiseSource;
use crate::core::calibrate::{Calibration, calibrate_at_station};
use crate::core::campaign::{Campaign, CampaignGyro, Dwell, Temperatures, TestKind};
use crate::core::effects::{Estimate, GyroAxes, Refusal, Scope, Setting, axes};
use crate::core::message::{Message, text};
use crate::core::model::{Term, Terms};
use crate::core::mounting::Slot;
use crate::core::numerics::between::{Observation, Scatter};
use crate::core::numerics::least_squares::{Factor, RANK_TOLERANCE};
use crate::core::record::Name;
use crate::message;

#[derive(Debug, Clone)]
pub struct CampaignSample<'a> {
    pub campaign: &'a Campaign,
    /// Its identifier or the hash of its document.
    pub source: Option<String>,
    /// Effects of this campaign and of no other.
    pub occasions: Vec<Adopted>,
}

/// Why campaigns make no model of one IMU.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}", self.message())]
pub enum NotIdentified {
    NoCampaign,
    BenchTest,
    OtherImu {
        first: Name,
        other: Name,
    },
    OtherGeometry,
    GyroExchanged {
        slot: Slot,
        first: Name,
        other: Name,
    },
    OtherGyros,
    OtherHeld(Slot),
    SameInstant,
    NoNoise(Slot),
    #[error(transparent)]
    Refused(#[from] Refusal),
}

impl NotIdentified {
    /// The refusal as a code with parameters.
    pub fn message(&self) -> Message {
        match self {
            Self::NoCampaign => message!("no_campaign_to_fit"),
            Self::BenchTest => message!("bench_test_has_no_model"),
            Self::OtherImu { first, other } => {
                message!("campaigns_of_other_imu", first = text(first), other = text(other))
            }
            Self::OtherGeometry => message!("campaigns_of_other_geometry"),
            Self::GyroExchanged { slot, first, other } => {
                message!("campaigns_of_other_gyro", slot = slot.name(), first = text(first), other = text(other))
            }
            Self::OtherGyros => message!("campaigns_of_other_gyros"),
            Self::OtherHeld(slot) => message!("campaigns_of_other_held", slot = slot.name()),
            Self::SameInstant => message!("campaigns_of_one_instant"),
            Self::NoNoise(slot) => message!("model_without_noise", slot = slot.name()),
            Self::Refused(why) => why.message(),
        }
    }
}

/// Directions of specific force nearer than this are one, cosine of 10 degrees.
const SAME_DIRECTION: f64 = 0.985;
/// Standard deviation along what no campaign shows, in the units of model (6) and above: beyond anything possible.
const UNKNOWN: f64 = 100.0;
/// Families of coefficients that may differ from campaign to campaign.
const FAMILIES: [Term; 3] = [Term::Bias, Term::GLinear, Term::Scale];

/// Fits `model`'s terms and effects to campaigns of one IMU, at their mean temperature.
///
/// # Errors
/// [`NotIdentified`], naming what does not fit together.
pub fn identify(samples: &[CampaignSample], model: &AugmentedModel) -> Result<Identified, NotIdentified> {
    identify_at(samples, model, mean_temperature(samples))
}

/// As [`identify`], at a temperature that is given.
///
/// # Errors
/// As [`identify`].
pub fn identify_at(
    samples: &[CampaignSample],
    model: &AugmentedModel,
    reference_c: Option<f64>,
) -> Result<Identified, NotIdentified> {
    let slots: Vec<Slot> =
        samples.iter().take(1).flat_map(|sample| &sample.campaign.gyros).map(|gyro| gyro.slot).collect();
    let ordered: Vec<Cow<Campaign>> = samples.iter().map(|sample| sample.campaign.in_order_of(&slots)).collect();
    let with_gyros = |(sample, campaign)| CampaignSample { campaign, ..CampaignSample::clone(sample) };
    let mut samples: Vec<CampaignSample> =
        samples.iter().zip(ordered.iter().map(Cow::as_ref)).map(with_gyros).collect();
    samples.sort_by_key(|sample| sample.campaign.measured_at);
    of_one_imu(&samples.iter().map(|sample| sample.campaign).collect::<Vec<_>>())?;
    let newest = samples.last().ok_or(NotIdentified::NoCampaign)?.campaign;
    let adopted = || model.effects.iter().map(|known| &known.adopted);
    let of_model_6 = adopted().filter_map(|a| a.effect.term());
    let terms: Vec<Term> = model.terms.unwrap_or_else(|| newest.terms()).iter().chain(of_model_6).collect();
    let terms = Terms::of(&terms);
    let lasts = |a: &&Adopted| {
        let entry = a.effect.entry();
        a.effect.term().is_none() && !entry.one_occasion && !entry.closure_only
    };
    let mut effects: Vec<Adopted> = adopted().filter(lasts).cloned().collect();
    let axes = axes_of(&samples)?;
    loop {
        let problem = ModelProblem::new(&samples, terms, &effects, reference_c, &axes)?;
        match problem.undetermined(&effects) {
            Some(effect) => _ = effects.remove(effect),
            None => return Ok(problem.solved(&effects)),
        }
    }
}

/// Whether campaigns, in the order of time, are of one IMU with the same gyros.
///
/// # Errors
/// [`NotIdentified`], naming what does not fit together.
pub fn of_one_imu(campaigns: &[&Campaign]) -> Result<(), NotIdentified> {
    let first = *campaigns.first().ok_or(NotIdentified::NoCampaign)?;
    for c in campaigns {
        if c.test != TestKind::Imu {
            return Err(NotIdentified::BenchTest);
        }
        if c.imu != first.imu {
            return Err(NotIdentified::OtherImu { first: first.imu.clone(), other: c.imu.clone() });
        }
        if !c.geometry.is_same(&first.geometry) {
            return Err(NotIdentified::OtherGeometry);
        }
        for gyro in &c.gyros {
            let other = first.gyros.iter().find(|g| g.slot == gyro.slot).ok_or(NotIdentified::OtherGyros)?;
            if other.serial != gyro.serial {
                let (first, other) = (other.serial.clone(), gyro.serial.clone());
                return Err(NotIdentified::GyroExchanged { slot: gyro.slot, first, other });
            }
            if other.known_e != gyro.known_e {
                return Err(NotIdentified::OtherHeld(gyro.slot));
            }
        }
        if c.gyros.len() != first.gyros.len() {
            return Err(NotIdentified::OtherGyros);
        }
    }
    let at_once = campaigns.windows(2).any(|pair| pair[0].measured_at == pair[1].measured_at);
    if at_once { Err(NotIdentified::SameInstant) } else { Ok(()) }
}

fn mean_temperature(samples: &[CampaignSample]) -> Option<f64> {
    let known: Vec<f64> = samples.iter().filter_map(|s| Temperatures::stated(s.campaign)).flatten().collect();
    (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
}

/// Axes as the campaign with the fastest rate shows them.
fn axes_of(samples: &[CampaignSample]) -> Result<Vec<GyroAxes>, Refusal> {
    let fastest = samples.iter().max_by(|a, b| fastest(a.campaign).total_cmp(&fastest(b.campaign)));
    Ok(fastest.map(|s| axes::setting(s.campaign)).transpose()?.map(|(s, _)| s.gyros).unwrap_or_default())
}

fn fastest(campaign: &Campaign) -> f64 {
    campaign.dwells.iter().map(|d| d.rate_arcsec_s.norm()).fold(0.0, f64::max)
}

struct CampaignPart<'a> {
    sample: &'a CampaignSample<'a>,
    calibration: Calibration,
    setting: Setting,
    /// Of the noise, gyro by gyro.
    sd: Vec<Vec<f64>>,
    scales: Vec<ScatterScale>,
}

/// How far outputs of one gyro scatter about the model.
#[derive(Debug, Clone, Copy)]
struct ScatterScale {
    /// Over the standard deviations that the calibration finds, for the covariance of what is fitted.
    of_sigma: f64,
    /// Over the standard errors as stated, or 1 pulse/s, for an output to come.
    of_weights: f64,
    dof: f64,
}

impl ScatterScale {
    /// As the calibration's covariance has it. Where repeats scatter less than the residuals do, the residuals count:
    /// what the model leaves out is in the next campaign, too.
    fn of(calibration: &Calibration, j: usize) -> Option<Self> {
        let gyro = &calibration.gyros[j];
        let factor = gyro.noise.factor.filter(|f| *f > 0.0)?;
        let [found, output] = [gyro.noise.covariance_scale()?.sqrt(), gyro.noise.output_scale()?.sqrt()];
        let by_repeats = matches!(gyro.noise.source, NoiseSource::SemAndRepeats | NoiseSource::Repeats);
        let gyros = if calibration.has_sem { &calibration.gyros[..] } else { std::slice::from_ref(gyro) };
        let squares: f64 =
            gyros.iter().filter_map(|g| Some(g.left.0.component_div(g.sigma.as_ref()?).norm_squared())).sum();
        let dof = gyros.iter().map(|g| g.left.1).sum::<usize>() as f64;
        let of_residuals = (squares / (dof - 2.0)).sqrt();
        if by_repeats && dof > 2.0 && of_residuals * factor > output {
            return Some(Self { of_sigma: of_residuals, of_weights: of_residuals * factor, dof });
        }
        Some(Self { of_sigma: found / factor, of_weights: output, dof: gyro.noise.dof })
    }
}

struct ModelProblem<'a> {
    parts: Vec<CampaignPart<'a>>,
    terms: Terms,
    reference_c: Option<f64>,
    coefficients: Vec<ModelCoefficient>,
    /// From what is fitted to the coefficients: the gauge of P at constant |a|.
    expand: DMatrix<f64>,
    factor: Factor,
    side: DVector<f64>,
}

impl<'a> ModelProblem<'a> {
    fn new(
        samples: &'a [CampaignSample<'a>],
        terms: Terms,
        effects: &[Adopted],
        reference_c: Option<f64>,
        axes: &[GyroAxes],
    ) -> Result<Self, NotIdentified> {
        let part = |sample: &'a CampaignSample<'a>| -> Result<CampaignPart<'a>, NotIdentified> {
            let c = sample.campaign;
            let all: Vec<Adopted> = effects.iter().chain(&sample.occasions).cloned().collect();
            let options = Options { adopted: all, ..Options::default() };
            let calibration = calibrate_at_station(c, terms, &options, reference_c);
            let scales = (0..c.gyros.len())
                .map(|j| ScatterScale::of(&calibration, j).ok_or(NotIdentified::NoNoise(c.gyros[j].slot)));
            let scales = scales.collect::<Result<Vec<ScatterScale>, _>>()?;
            let sd = calibration.gyros.iter().zip(&scales).map(|(gyro, scale)| {
                gyro.sigma.iter().flat_map(|sigma| sigma.iter()).map(|s| s * scale.of_sigma).collect()
            });
            let sd = sd.collect();
            let setting = Setting::of(c, axes.to_vec()).referred_to(c, reference_c);
            Ok(CampaignPart { sample, calibration, setting, sd, scales })
        };
        let parts = samples.iter().map(part).collect::<Result<Vec<_>, _>>()?;
        let between = between(&parts);
        let coefficients = coefficients(&samples[0].campaign.gyros, terms, effects, axes, &between);
        let dwells: Vec<Dwell> = samples.iter().flat_map(|s| s.campaign.dwells.iter().cloned()).collect();
        let expand = expand(&coefficients, Design::new(&dwells, terms).gauge.is_some());
        let (factor, side) = stacked(&parts, &coefficients, effects, &expand);
        Ok(Self { parts, terms, reference_c, coefficients, expand, factor, side })
    }

    /// An effect that the campaigns do not tell from the rest.
    fn undetermined(&self, effects: &[Adopted]) -> Option<usize> {
        let width = self.factor.covariance().nrows();
        let told = |place: usize| {
            let (effect, _) = self.coefficients[place].of.effect()?;
            let direction = self.expand.row(place).transpose().resize_vertically(width, 0.0);
            Some((effect, self.factor.determines(&direction)))
        };
        let told: Vec<(usize, bool)> = (0..self.coefficients.len()).filter_map(told).collect();
        // What the campaigns tell of a field of any direction they tell beside its part along north.
        let is_told_in_part = |effect: usize| effects[effect].is_of_any_direction() && told.contains(&(effect, true));
        told.iter().find(|(effect, is_told)| !is_told && !is_told_in_part(*effect)).map(|(effect, _)| *effect)
    }

    /// Moves `values` along what no campaign shows to where the untold parts of fields are zero: E is then the sum of
    /// both, as the plain model has it.
    fn without_untold_fields(&self, effects: &[Adopted], unseen: &DMatrix<f64>, values: &mut DVector<f64>) {
        let of_field = |place: &usize| {
            let of = self.coefficients[*place].of.effect();
            of.is_some_and(|(effect, _)| effects[effect].is_of_any_direction())
        };
        let places: Vec<usize> = (0..self.coefficients.len()).filter(of_field).collect();
        if places.is_empty() || unseen.ncols() == 0 {
            return;
        }
        let of_fields = unseen.select_rows(&places);
        if let Ok(along) = of_fields.svd(true, true).solve(&values.select_rows(&places), RANK_TOLERANCE) {
            *values -= unseen * along;
        }
    }

    fn solved(self, effects: &[Adopted]) -> Identified {
        let q = self.expand.ncols();
        let fit = self.factor.fit(&self.side);
        let mut values = &self.expand * fit.estimate.rows(0, q);
        let unseen = &self.expand * fit.null_directions.rows(0, q);
        self.without_untold_fields(effects, &unseen, &mut values);
        let mut covariance = &self.expand * fit.covariance.view((0, 0), (q, q)) * self.expand.transpose();
        covariance += &unseen * unseen.transpose() * (UNKNOWN * UNKNOWN);
        covariance = 0.5 * (&covariance + covariance.transpose());
        let mut coefficients = self.coefficients;
        coefficients.iter_mut().zip(values.iter()).for_each(|(c, value)| c.value = *value);
        let newest = self.parts[self.parts.len() - 1].sample.campaign;
        let gyros = newest.gyros.iter().enumerate().map(|(j, gyro)| {
            let axes = &self.parts[0].setting.gyros[j];
            ModelGyro {
                slot: gyro.slot,
                serial: gyro.serial.clone(),
                e_held: gyro.known_e.is_some(),
                e: gyro.known_e.unwrap_or(axes.scale * axes.input),
                g: axes.scale * axes.g,
                noise: noise(&self.parts, j),
            }
        });
        Identified {
            imu: newest.imu.clone(),
            geometry: newest.geometry.clone(),
            terms: self.terms,
            reference_c: self.reference_c,
            measured_at: newest.measured_at,
            gyros: gyros.collect(),
            effects: effects.to_vec(),
            coefficients,
            covariance,
            campaigns: self.parts.iter().map(|part| fitted(part.sample)).collect(),
            validity: validity(&self.parts),
        }
    }
}

fn coefficients(
    gyros: &[CampaignGyro],
    terms: Terms,
    effects: &[Adopted],
    axes: &[GyroAxes],
    between: &[f64; 3],
) -> Vec<ModelCoefficient> {
    let mut all = Vec::new();
    for (gyro, axes) in gyros.iter().zip(axes) {
        let slot = Some(gyro.slot);
        for term in terms.iter().filter(|term| *term != Term::Scale || gyro.known_e.is_none()) {
            let family = FAMILIES.iter().position(|family| *family == term);
            let between = family.map_or(0.0, |family| between[family] * axes.scale);
            let one = |part| ModelCoefficient { slot, of: Of::Term(term, part), value: 0.0, between };
            all.extend((0..term.columns()).map(one));
        }
        for (e, adopted) in effects.iter().enumerate().filter(|(_, a)| a.slots.contains(&gyro.slot)) {
            let entry = adopted.effect.entry();
            let count = if entry.scope == Scope::Gyro { entry.coefficients(adopted.shape).len() } else { 0 };
            all.extend((0..count).map(|m| ModelCoefficient { slot, of: Of::Effect(e, m), value: 0.0, between: 0.0 }));
        }
    }
    for (e, adopted) in effects.iter().enumerate().filter(|(_, a)| a.effect.entry().scope == Scope::Common) {
        let count = adopted.effect.entry().coefficients(adopted.shape).len();
        all.extend((0..count).map(|m| ModelCoefficient { slot: None, of: Of::Effect(e, m), value: 0.0, between: 0.0 }));
    }
    all
}

/// P_x = -P_y - P_z of every gyro where the gauge holds.
fn expand(coefficients: &[ModelCoefficient], gauged: bool) -> DMatrix<f64> {
    let p = coefficients.len();
    let held = |c: &ModelCoefficient| gauged && c.of == Of::Term(Term::GSquared, 0);
    let free: Vec<usize> = (0..p).filter(|place| !held(&coefficients[*place])).collect();
    let mut expand = DMatrix::zeros(p, free.len());
    for (column, place) in free.iter().enumerate() {
        expand[(*place, column)] = 1.0;
        if gauged && matches!(coefficients[*place].of, Of::Term(Term::GSquared, _)) {
            let of_same = |c: &ModelCoefficient| c.slot == coefficients[*place].slot && held(c);
            if let Some(first) = coefficients.iter().position(of_same) {
                expand[(first, column)] = -1.0;
            }
        }
    }
    expand
}

/// The design of all campaigns, their own coefficients after the common ones, and the outputs.
fn stacked(
    parts: &[CampaignPart],
    coefficients: &[ModelCoefficient],
    effects: &[Adopted],
    expand: &DMatrix<f64>,
) -> (Factor, DVector<f64>) {
    let q = expand.ncols();
    let varying: Vec<usize> = (0..coefficients.len()).filter(|c| coefficients[*c].between > 0.0).collect();
    let own = |part: &CampaignPart| {
        let (gyros, occasions) = (&part.sample.campaign.gyros, &part.sample.occasions);
        self::coefficients(gyros, Terms::of(&[]), occasions, &part.setting.gyros, &[0.0; 3])
    };
    let owns: Vec<Vec<ModelCoefficient>> = parts.iter().map(own).collect();
    let station = |part: &CampaignPart| station_columns(&part.setting, &part.sample.campaign.station_uncertainty);
    let stations: Vec<DMatrix<f64>> = parts.iter().map(station).collect();
    let turns = stations.iter().map(DMatrix::ncols).sum::<usize>();
    let width = q + turns + owns.iter().map(|own| own.len() + varying.len()).sum::<usize>();
    let rows: usize =
        turns + parts.iter().map(|part| part.sd.len() * part.setting.dwells() + varying.len()).sum::<usize>();
    let (mut design, mut side, mut sd) = (DMatrix::zeros(rows, width), DVector::zeros(rows), Vec::with_capacity(rows));
    let (mut row, mut column) = (0, q);
    for ((part, own), station) in parts.iter().zip(&owns).zip(&stations) {
        let n = part.setting.dwells();
        let height = part.sd.len() * n;
        let of_all = columns(&part.setting, coefficients, effects).matrix;
        design.view_mut((row, 0), (height, q)).copy_from(&(&of_all * expand));
        let of_own = columns(&part.setting, own, &part.sample.occasions).matrix;
        design.view_mut((row, column), (height, own.len())).copy_from(&of_own);
        column += own.len();
        for (v, place) in varying.iter().enumerate() {
            design.view_mut((row, column + v), (height, 1)).copy_from(&of_all.column(*place));
        }
        for (j, of_gyro) in part.sd.iter().enumerate() {
            for (k, output) in part.sample.campaign.free_outputs(j).enumerate() {
                side[row + j * n + k] = output;
            }
            sd.extend(of_gyro);
        }
        row += height;
        for (v, place) in varying.iter().enumerate() {
            design[(row, column + v)] = 1.0;
            sd.push(coefficients[*place].between);
            row += 1;
        }
        column += varying.len();
        design.view_mut((row - varying.len() - height, column), (height, station.ncols())).copy_from(station);
        let turned = station.ncols();
        design.view_mut((row, column), (turned, turned)).fill_with_identity();
        sd.extend(std::iter::repeat_n(1.0, turned));
        (row, column) = (row + turned, column + turned);
    }
    (Factor::new(design, &sd), side)
}

/// tau of each family, over |E|, from all gyros and components together.
fn between(parts: &[CampaignPart]) -> [f64; 3] {
    FAMILIES.map(|term| {
        let of_component = |(j, i): (usize, usize)| {
            let of_part = |part: &CampaignPart| {
                let parameter = part.calibration.gyros[j].of(term)?[i];
                let scale = part.setting.gyros[j].scale;
                let sd = parameter.sd.filter(|sd| *sd > 0.0)?;
                Some(Observation::independent(parameter.value / scale, sd / scale))
            };
            Scatter::of(&parts.iter().filter_map(of_part).collect::<Vec<_>>())
        };
        let gyros = 0..parts[0].sample.campaign.gyros.len();
        let components = gyros.flat_map(|j| (0..term.columns()).map(move |i| (j, i)));
        components.filter_map(of_component).fold(Scatter::default(), Scatter::plus).beyond()
    })
}

/// The law that the noise of gyro `j` follows over all campaigns: least squares of sd^2 in shares of itself.
fn noise(parts: &[CampaignPart], j: usize) -> NoiseLaw {
    let (mut uu, mut uv, mut vv, mut u1, mut v1) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut factors, mut dof) = (Vec::new(), 0.0);
    for part in parts {
        let axes = &part.setting.gyros[j];
        for (k, sd) in part.sd[j].iter().enumerate() {
            let variance = (sd / axes.scale).powi(2);
            let (u, v) = (3600.0 / part.setting.duration[k], part.setting.rate[k].dot(&axes.input).powi(2) * 1e-12);
            let (u, v) = (u / variance, v / variance);
            uu += u * u;
            uv += u * v;
            vv += v * v;
            u1 += u;
            v1 += v;
        }
        dof += part.scales[j].dof;
        factors.extend(part.calibration.has_sem.then(|| part.scales[j].of_weights.powi(2)));
    }
    let determinant = uu * vv - uv * uv;
    let both = ((u1 * vv - v1 * uv) / determinant, (v1 * uu - u1 * uv) / determinant);
    let (a, b) = match both {
        (a, b) if determinant > 1e-9 * uu * vv && a > 0.0 && b >= 0.0 => (a, b),
        (a, _) if determinant > 1e-9 * uu * vv && a <= 0.0 && vv > 0.0 => (0.0, v1 / vv),
        _ => (u1 / uu, 0.0),
    };
    let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
    NoiseLaw {
        sem_factor: (!factors.is_empty()).then(|| mean(&factors).sqrt()),
        random_walk: a.sqrt(),
        rate_ppm: b.sqrt(),
        dof,
    }
}

fn fitted(sample: &CampaignSample) -> FittedCampaign {
    let c = sample.campaign;
    FittedCampaign {
        station: c.station.clone(),
        measured_at: c.measured_at,
        dwells: c.dwells.len(),
        source: sample.source.clone(),
    }
}

fn validity(parts: &[CampaignPart]) -> Validity {
    let temperatures = || parts.iter().filter_map(|p| Temperatures::stated(p.sample.campaign)).flatten();
    let (low, high) = (temperatures().fold(f64::INFINITY, f64::min), temperatures().fold(f64::NEG_INFINITY, f64::max));
    let mut directions: Vec<Vector3<f64>> = Vec::new();
    for force in parts.iter().flat_map(|part| &part.setting.force).filter(|force| force.norm() > 0.0) {
        let direction = force.normalize();
        if directions.iter().all(|known| known.dot(&direction) < SAME_DIRECTION) {
            directions.push(direction);
        }
    }
    Validity {
        temperature_c: (low <= high).then_some([low, high]),
        rate_arcsec_s: parts.iter().map(|p| fastest(p.sample.campaign)).fold(0.0, f64::max),
        directions,
    }
}

impl Identified {
    /// The model file of this IMU: the effects of `model` with the values that were fitted.
    pub fn into_model(self, model: &AugmentedModel) -> AugmentedModel {
        let estimates = |adopted: &Adopted| -> Vec<Estimate> {
            let names = adopted.effect.entry().coefficients(adopted.shape);
            let place = self.effects.iter().position(|own| own == adopted);
            let places = place.map(|place| self.of_effect(place)).unwrap_or_default().into_iter();
            let estimate = |place: usize| {
                let own = self.coefficients[place];
                let (_, number) = own.of.effect()?;
                let coefficient = names[number];
                let (name, unit) = (coefficient.name, coefficient.unit);
                Some(Estimate { slot: own.slot, name, value: own.value, sd: self.sd(place), unit })
            };
            places.filter_map(estimate).collect()
        };
        // What the campaigns cannot tell is left out of the model; terms have become terms.
        let kept = model.effects.iter().filter(|known| self.effects.contains(&known.adopted));
        let effects = kept.map(|k| KnownEffect { adopted: k.adopted.clone(), estimates: estimates(&k.adopted) });
        let newest = self.campaigns.iter().max_by_key(|fitted| fitted.measured_at);
        let found_in = newest.map(|newest| Provenance {
            imu: self.imu.clone(),
            station: newest.station.clone(),
            measured_at: newest.measured_at,
        });
        let effects = effects.collect();
        AugmentedModel {
            terms: Some(self.terms),
            effects,
            found_in,
            plausible_sizes: model.plausible_sizes.clone(),
            identified: Some(Arc::new(self)),
        }
    }
}
