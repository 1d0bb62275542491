//! What the noise may be beside white, independent and as stated: every name must hold whatever it is.
//!
//! Each alternative m has a restricted likelihood L(m), its coefficients and scale integrated out, and Bayes factors
//! B_m of its own. The evidence of a hypothesis is that of all together,
//!
//! ```text
//! ln sum_m w_m L(m) B_m - ln sum_m w_m L(m)
//! ```
//!
//! so that a name owes nothing to a noise that is not there. Alternatives only ever take names away: they are asked
//! where something would be named, and those that neither with nor without the names weigh anything are left out.

use super::choice::{Choice, designs, without};
use super::hypotheses::{Bank, Candidates};
use super::projections::{State, each_by_itself};
use super::shared_noise::Shared;
use super::temperature_odds::odds_of_temperature;
use crate::core::calibrate::correlated_noise::{CorrelatedNoise, NoiseDeparture, POWERS, WITHOUT_MEMORY};
use crate::core::calibrate::law::{AS_STATED, DwellConditions, Law};
use crate::core::calibrate::noise_found::{CorrelatedNoiseFound, LawFound, NoiseFound};
use crate::core::diagnose::residuals::noise_growth::spanned;
use crate::core::diagnose::residuals::pooled_noise::{Scatter, pool};
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::effects::Setting;
use crate::core::numerics::basis::dot;
use crate::core::numerics::log_sum::LogSum;
use crate::core::numerics::median::median_of;

/// Prior probability that gyros share their noise.
const BETWEEN_GYROS: f64 = 0.1;

/// How many times as likely a memory is held beforehand where there is one gyro.
const OF_ONE_GYRO: f64 = 2.0;

/// ln of odds below which an alternative is left out, by its weight with and without the names.
const NOTHING: f64 = -6.9;

/// Weight from which on the noise is said to have a memory, and names of time and temperature need more.
const CERTAIN: f64 = 0.98;

/// Weight from which on a law of rate asks more of names.
const MAY_BE: f64 = 0.1;

/// What the laws take of a campaign.
fn course(s: &Setting) -> DwellConditions {
    DwellConditions {
        times: s.time.clone(),
        durations: s.duration.clone(),
        rates: s.rate.clone(),
        forces: s.force.clone(),
    }
}

struct Model {
    kind: NoiseDeparture,
    frame: Frame,
    bank: Bank,
    /// ln of its prior odds against noise as it is stated.
    log_odds: f64,
}

/// Alternatives to noise as it is stated.
#[derive(Default)]
pub(crate) struct NoiseModels {
    models: Vec<Model>,
    /// ln of the prior odds of noise that gyros share, where they may.
    shared: Option<f64>,
}

/// What is found of the noise beyond white and independent.
#[derive(Debug, Clone, Default)]
pub(crate) struct Found {
    /// Correlation between gyros, and the variances of their whitened residuals.
    pub between_gyros: Option<Shared>,
    /// Power of each kind of memory over the square of the median standard deviation, and the probability that there
    /// is none.
    pub memory: Option<(CorrelatedNoise, f64, f64)>,
    /// Whether there may be one: it weighs something beside the names.
    pub may_have_memory: bool,
    /// Whether it may go with rate where that is not stated.
    pub may_go_with_rate: bool,
}

impl Found {
    /// As it is answered.
    pub fn report(&self, frame: &Frame, laws: &[Law]) -> NoiseFound {
        let gyros = &frame.setting.gyros;
        let pairs = (0..gyros.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
        let correlated = |shared: &Shared| {
            pairs.map(|(j, i)| (gyros[j].slot, gyros[i].slot, shared.correlation(i, j))).collect::<Vec<_>>()
        };
        NoiseFound {
            between_gyros: self.between_gyros.as_ref().map(correlated).unwrap_or_default(),
            memory: self.memory.map(|(memory, power, without)| CorrelatedNoiseFound {
                kind: memory.name(),
                deg_per_h: (frame.gyros.iter().zip(gyros))
                    .map(|(gyro, axes)| (axes.slot, power.sqrt() * median_of(gyro.sd.iter().copied()).unwrap_or(1.0)))
                    .collect(),
                probability: 1.0 - without,
            }),
            laws: LawFound::together(laws.iter().map(|law| law.found())),
        }
    }
}

/// One of the models that are averaged over.
pub(crate) struct WeightedModel<'a> {
    pub log_weight: f64,
    pub has_memory: bool,
    pub frame: &'a Frame,
    pub bank: &'a Bank,
    /// The residuals beside what was adopted, each gyro's noise from its own alone.
    pub state: State,
    /// The same where gyros share the noise, and the weight of that.
    pub shared: Option<(f64, Shared)>,
}

/// The law by which the noise goes, where it is likelier than what is stated, with `columns` in the model: ln of its
/// odds, and the campaign with it.
pub(crate) fn likelier_law(frame: &Frame, columns: &[Vec<Vec<f64>>]) -> Option<(f64, Law, Frame)> {
    if !frame.noise.stated {
        return None;
    }
    let laws = Law::all(&course(&frame.setting));
    let odds = (1.0 - AS_STATED) / AS_STATED / laws.len().max(1) as f64;
    let pooled = is_pooled(frame, columns);
    let as_stated = log_likelihood(frame, columns, pooled);
    let tried = laws.into_iter().filter_map(|law| {
        let changed = frame.with_factors(&law.factors(&course(&frame.setting))).ok()?;
        Some((odds.ln() + log_likelihood(&changed, columns, pooled) - as_stated, law, changed))
    });
    let (gain, law, changed) = tried.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (gain > 0.0).then_some((gain, law, changed))
}

impl NoiseModels {
    /// Those of which one weighs something beside the likeliest and the noise of `frame`: with all of `found` in the
    /// model, with all but one, or with nothing.
    pub fn of(frame: &Frame, bank: &Bank, found: &[Choice], candidates: &Candidates) -> Self {
        let s = &frame.setting;
        let mut in_model = vec![found.to_vec(), Vec::new()];
        if found.len() > 1 {
            in_model.extend((0..found.len()).map(|i| without(found, i)));
        }
        let designs: Vec<_> = in_model.iter().map(|choices| designs(frame, bank, choices)).collect();
        let mut tried: Vec<(NoiseDeparture, f64, Frame)> = Vec::new();
        if frame.noise.stated {
            let laws = Law::all(&course(s));
            let odds = ((1.0 - AS_STATED) / AS_STATED / laws.len().max(1) as f64).ln();
            let framed =
                |law: Law| Some((NoiseDeparture::Law(law), odds, frame.with_factors(&law.factors(&course(s))).ok()?));
            tried.extend(laws.into_iter().filter_map(framed));
        }
        // One gyro has no peers that wander otherwise, or that have the temperature's course as well.
        let prior = match frame.gyros.len() {
            1 => OF_ONE_GYRO.ln(),
            _ => -odds_of_temperature(s),
        };
        let odds = ((1.0 - WITHOUT_MEMORY) / WITHOUT_MEMORY / (2 * POWERS.len()) as f64).ln() + prior;
        for memory in CorrelatedNoise::ALL {
            let kernel = memory.kernel(&s.time);
            for power in POWERS.map(|power| memory.size() * power) {
                let framed = frame
                    .with_memory(&kernel, power)
                    .map(|framed| (NoiseDeparture::CorrelatedNoise(memory, power), odds, framed));
                tried.extend(framed);
            }
        }
        let mut weighs = vec![false; tried.len()];
        for columns in &designs {
            let pooled = is_pooled(frame, columns);
            let plain = log_likelihood(frame, columns, pooled);
            let weigh = |(_, odds, framed): &(NoiseDeparture, f64, Frame)| {
                odds + log_likelihood(framed, columns, pooled) - plain
            };
            let weights: Vec<f64> = tried.iter().map(weigh).collect();
            let likeliest = weights.iter().copied().fold(0.0, f64::max);
            weighs.iter_mut().zip(weights).for_each(|(weighs, weight)| *weighs |= weight - likeliest > NOTHING);
        }
        let models = tried.into_iter().zip(weighs).filter(|(_, weighs)| *weighs).map(|((kind, log_odds, frame), _)| {
            let bank = Bank::of(&frame, candidates);
            Model { kind, frame, bank, log_odds }
        });
        let mut all = Self { models: models.collect(), shared: None };
        if frame.gyros.len() > 1 {
            let log_odds = (BETWEEN_GYROS / (1.0 - BETWEEN_GYROS)).ln();
            let weighs = designs.iter().any(|columns| log_odds + shared_gain(frame, columns) > NOTHING);
            all.shared = weighs.then_some(log_odds);
        }
        all
    }

    /// Whether white noise, independent between gyros, is all that need be asked.
    pub fn is_empty(&self) -> bool {
        self.models.is_empty() && self.shared.is_none()
    }

    /// The models with the logarithm of the weight of each, the one as stated first; `columns` are the raw columns of
    /// everything in the model, `state` the residuals that they leave. None is dropped here: what weighs nothing without
    /// a name may be what the name holds under.
    pub fn under<'a>(
        &'a self,
        frame: &'a Frame,
        bank: &'a Bank,
        columns: impl FnOnce() -> Vec<Vec<Vec<f64>>>,
        state: impl Fn(&Frame, &Bank) -> State,
    ) -> Vec<WeightedModel<'a>> {
        // What gyros share may be white or have a memory; a law is each gyro's own.
        let weighed = |log_weight: f64, model: Option<&'a Model>| {
            let (frame, bank) = model.map_or((frame, bank), |model| (&model.frame, &model.bank));
            let state = state(frame, bank);
            let has_memory = model.is_some_and(|model| model.kind.has_memory());
            let may_be_shared = self.shared.filter(|_| has_memory || model.is_none());
            let shared = may_be_shared.map(|log_odds| (log_odds, Shared::of(frame, &state)));
            let shared = shared.filter(|(_, shared)| shared.is_of_noise());
            let shared = shared.map(|(log_odds, shared)| (log_weight + log_odds + shared.log_gain, shared));
            WeightedModel { log_weight, has_memory, frame, bank, state, shared }
        };
        let mut all = vec![weighed(0.0, None)];
        if !self.models.is_empty() {
            let columns = columns();
            let pooled = is_pooled(frame, &columns);
            let plain = log_likelihood(frame, &columns, pooled);
            all.extend(self.models.iter().map(|model| {
                let log_weight = model.log_odds + log_likelihood(&model.frame, &columns, pooled) - plain;
                weighed(log_weight, Some(model))
            }));
        }
        all
    }

    /// What of it is there, with `columns` in the model.
    pub fn found(&self, frame: &Frame, columns: &[Vec<Vec<f64>>], state: impl FnOnce() -> State) -> Found {
        let pooled = is_pooled(frame, columns);
        let plain = log_likelihood(frame, columns, pooled);
        let weigh = |model: &Model| model.log_odds + log_likelihood(&model.frame, columns, pooled) - plain;
        let weights: Vec<f64> = self.models.iter().map(weigh).collect();
        let shared = self.shared.map(|log_odds| (log_odds, Shared::of(frame, &state())));
        let memories: Vec<(f64, &Model)> =
            weights.iter().copied().zip(&self.models).filter(|(_, model)| model.kind.has_memory()).collect();
        let mut without = LogSum::of(&[0.0]);
        (weights.iter().zip(&self.models))
            .filter(|(_, model)| !model.kind.has_memory())
            .for_each(|(w, _)| without.add(*w));
        let mut of_all = LogSum::of(&weights);
        of_all.add(0.0);
        let without = (without.log() - of_all.log()).exp().min(1.0);
        let may_have_memory = 1.0 - without > NOTHING.exp();
        let mut with_rate = LogSum::default();
        let of_rate = |model: &Model| matches!(model.kind, NoiseDeparture::Law(Law::Rate(_)));
        (weights.iter().zip(&self.models)).filter(|(_, model)| of_rate(model)).for_each(|(w, _)| with_rate.add(*w));
        let may_go_with_rate = with_rate.log() - of_all.log() > MAY_BE.ln();
        let likeliest = memories.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        let memory = likeliest.filter(|_| 1.0 - without > CERTAIN).and_then(|(_, model)| match model.kind {
            NoiseDeparture::CorrelatedNoise(memory, power) => Some((memory, power, without)),
            NoiseDeparture::Law(_) => None,
        });
        let between_gyros = shared
            .filter(|(log_odds, shared)| shared.is_of_noise() && log_odds + shared.log_gain > 0.0)
            .map(|(_, shared)| shared);
        Found { between_gyros, memory, may_have_memory, may_go_with_rate }
    }
}

fn shared_gain(frame: &Frame, columns: &[Vec<Vec<f64>>]) -> f64 {
    let extras = columns.iter().enumerate().map(|(j, columns)| {
        let gyro = &frame.gyros[j];
        let mut basis = gyro.basis.clone();
        let model = basis.rank();
        columns.iter().skip(frame.designs[j].len()).for_each(|column| {
            basis.push(gyro.whiten(column.clone()));
        });
        basis.split_off(model).into()
    });
    Shared::of(frame, &each_by_itself(frame, extras.collect())).log_gain
}

/// Sums of squares and degrees of freedom of each gyro with `columns` in the model, and ln det X'V^-1 X.
fn scatters(frame: &Frame, columns: &[Vec<Vec<f64>>]) -> Vec<(Scatter, f64)> {
    let of_gyro = |(j, columns): (usize, &Vec<Vec<f64>>)| {
        let gyro = &frame.gyros[j];
        let (basis, log_det) = spanned(columns, |column| gyro.whiten(column.to_vec()));
        let mut residual = gyro.whiten(frame.outputs[j].clone());
        basis.project_out(&mut residual);
        let dof = residual.len() - basis.rank().min(residual.len());
        let rss = dot(&residual, &residual).max(frame.noise.rounding[j] * dof as f64).max(f64::MIN_POSITIVE);
        (frame.noise.with_stated(rss, dof as f64), log_det)
    };
    columns.iter().enumerate().map(of_gyro).collect()
}

/// Whether gyros know their noise from one another.
fn is_pooled(frame: &Frame, columns: &[Vec<Vec<f64>>]) -> bool {
    let mut all: Vec<Scatter> = scatters(frame, columns).into_iter().map(|(scatter, _)| scatter).collect();
    frame.noise.stated && pool(&mut all)
}

/// ln of the probability of the outputs, coefficients of `columns` and scale integrated out, up to a constant that
/// all kinds of noise have in common: -sum ln diag chol V - 1/2 ln det X'V^-1 X - nu/2 ln RSS.
fn log_likelihood(frame: &Frame, columns: &[Vec<Vec<f64>>], pooled: bool) -> f64 {
    let all = scatters(frame, columns);
    let scale: f64 = frame.gyros.iter().map(|gyro| gyro.log_scale).sum();
    let log_det: f64 = all.iter().map(|(_, log_det)| log_det).sum();
    let of_scale = |scatter: Scatter| 0.5 * scatter.nu * scatter.rss.ln();
    let sum = |a: Scatter, b: Scatter| Scatter { rss: a.rss + b.rss, nu: a.nu + b.nu };
    let squares = match pooled {
        true => of_scale(all.iter().map(|(scatter, _)| *scatter).fold(Scatter { rss: 0.0, nu: 0.0 }, sum)),
        false => all.iter().map(|(scatter, _)| of_scale(*scatter)).sum(),
    };
    -scale - 0.5 * log_det - squares
}
