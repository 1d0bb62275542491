//! The effects of a model file in a simulated campaign, as large as the file says.
//!
//! A cause of [`super::cause`] acts as physics; an effect of a model file is what that model says it is: its regressors
//! times its coefficients, in the outputs that the station would have written.

use super::detectability::{Sight, norm};
use super::inject::is_visible;
use super::run::Simulated;
use crate::core::augmented::{AugmentedModel, KnownEffect};
use crate::core::campaign::TestKind;
use crate::core::effects::{MissingInput, Refusal, Scope, Setting, axes};
use crate::core::message::Message;
use crate::message;

/// Why a model's effects cannot be put into a campaign.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}", self.message())]
pub enum NotPossible {
    /// Effects of an IMU are put into campaigns of an IMU alone.
    BenchTest,
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The campaign lacks what the effect acts by.
    Missing { effect: &'static str, missing: MissingInput },
    /// The model does not say how large the effect is in this gyro.
    NoEstimate { effect: &'static str, coefficient: &'static str, slot: &'static str },
    /// A hypothesis of which this campaign shows nothing.
    Unseen { effect: &'static str },
    /// Of the gyros that have effects the campaign holds none.
    NoGyro,
}

impl NotPossible {
    /// The reason as a code with parameters.
    pub fn message(&self) -> Message {
        match *self {
            Self::BenchTest => message!("model_effects_of_imu"),
            Self::Refused(ref why) => why.message(),
            Self::Missing { effect, missing } => message!("effect_cannot_act", effect, missing = missing.message()),
            Self::NoEstimate { effect, coefficient, slot } => {
                message!("effect_without_estimate", effect, coefficient, slot)
            }
            Self::Unseen { effect } => message!("hypothesis_unseen", effect),
            Self::NoGyro => message!("none_of_these_gyros"),
        }
    }
}

/// Adds every effect of `model` to the outputs, and its name to the truth.
///
/// # Errors
/// [`NotPossible`]; then nothing was added.
pub fn augment(simulated: &mut Simulated, model: &AugmentedModel) -> Result<(), NotPossible> {
    if model.effects.is_empty() {
        return Ok(());
    }
    if simulated.campaign.test != TestKind::Imu {
        return Err(NotPossible::BenchTest);
    }
    let (setting, _) = axes::setting(&simulated.campaign)?;
    let reference_c = model.identified.as_ref().and_then(|identified| identified.reference_c);
    let setting = setting.referred_to(&simulated.campaign, reference_c);
    // Counted from the model's temperature, an effect of temperature adds nothing where that holds throughout.
    let idle = |known: &&KnownEffect| {
        reference_c.is_some()
            && (known.adopted.effect.entry().missing)(&setting) == Some(MissingInput::TemperatureChange)
    };
    let acting: Vec<&KnownEffect> = model.effects.iter().filter(|known| !idle(known)).collect();
    let responses: Vec<EffectResponse> =
        acting.iter().map(|known| EffectResponse::of(known, &setting)).collect::<Result<_, _>>()?;
    for (known, response) in acting.iter().zip(&responses) {
        for (k, dwell) in simulated.campaign.dwells.iter_mut().enumerate() {
            dwell.output_pulse_s.iter_mut().zip(&response.pulses).for_each(|(output, pulses)| *output += pulses[k]);
        }
        simulated.reveal(known.adopted.effect.id(), response);
    }
    simulated.reveal_detectability(&responses);
    Ok(())
}

/// d of an effect over all gyros; none where the design does not see it, or without noise.
pub fn detectability(simulated: &Simulated, known: &KnownEffect) -> Result<Option<f64>, NotPossible> {
    let (setting, _) = axes::setting(&simulated.campaign)?;
    let response = EffectResponse::of(known, &setting)?;
    let Some(sights) = simulated.sights() else { return Ok(None) };
    let each = |of: fn(&Sight, &[f64]) -> f64| {
        norm(&sights.iter().zip(&response.pulses).map(|(sight, pulses)| of(sight, pulses)).collect::<Vec<_>>())
    };
    let (seen, power) = (each(Sight::detectability), each(Sight::power));
    Ok(is_visible(seen, power).then_some(seen))
}

/// What one effect adds.
struct EffectResponse {
    /// pulse/s, by gyro and dwell.
    pulses: Vec<Vec<f64>>,
    /// The coefficient of the greatest magnitude.
    largest: f64,
}

impl EffectResponse {
    fn of(known: &KnownEffect, setting: &Setting) -> Result<Self, NotPossible> {
        let (entry, shape) = (known.adopted.effect.entry(), known.adopted.shape);
        if let Some(missing) = (entry.missing)(setting) {
            return Err(NotPossible::Missing { effect: entry.id, missing });
        }
        let mut response = Self { pulses: vec![vec![0.0; setting.dwells()]; setting.gyros.len()], largest: 0.0 };
        for (j, axes) in setting.gyros.iter().enumerate().filter(|(_, axes)| known.adopted.slots.contains(&axes.slot)) {
            let own = if entry.scope == Scope::Common { None } else { Some(axes.slot) };
            let columns = entry.regressors(setting, j, shape);
            for (coefficient, column) in entry.coefficients(shape).iter().zip(columns) {
                let estimate = known.estimates.iter().find(|e| e.slot == own && e.name == coefficient.name);
                let value = estimate.map(|e| e.value).ok_or(NotPossible::NoEstimate {
                    effect: entry.id,
                    coefficient: coefficient.name,
                    slot: axes.slot.name(),
                })?;
                response.pulses[j].iter_mut().zip(&column).for_each(|(sum, x)| *sum += value * axes.scale * x);
                if value.abs() > response.largest.abs() {
                    response.largest = value;
                }
            }
        }
        Ok(response)
    }
}

impl Simulated {
    fn reveal(&mut self, id: &str, response: &EffectResponse) {
        let sights = self.sights();
        let truth = &mut self.truth;
        truth.effects.push(id.to_owned());
        truth.sizes.push(response.largest);
        let slots: Vec<&str> = self.world.slots().map(|slot| slot.name()).collect();
        if let Some(sights) = sights {
            let each = sights.iter().zip(&response.pulses).zip(&slots);
            let seen: Vec<_> =
                each.map(|((sight, pulses), slot)| (*slot, sight.detectability(pulses), sight.power(pulses))).collect();
            truth
                .gyros
                .extend(seen.iter().filter(|(_, d, power)| is_visible(*d, *power)).map(|(s, ..)| (*s).to_owned()));
            truth.seen_by.push(seen.iter().map(|(slot, d, _)| ((*slot).to_owned(), *d)).collect());
        }
        truth.gyros.sort();
        truth.gyros.dedup();
    }

    /// Everything that was put in, together.
    fn reveal_detectability(&mut self, responses: &[EffectResponse]) {
        let Some(sights) = self.sights() else { return };
        let (with, without) = (self.world.outputs(&self.causes), self.world.outputs(&[]));
        let each: Vec<f64> = (0..sights.len())
            .map(|j| {
                let all = |k: usize| with[j][k] - without[j][k] + responses.iter().map(|r| r.pulses[j][k]).sum::<f64>();
                sights[j].detectability(&(0..with[j].len()).map(all).collect::<Vec<_>>())
            })
            .collect();
        self.truth.seen = norm(&each);
    }

    /// None without noise: then nothing has a detectability.
    fn sights(&self) -> Option<Vec<Sight>> {
        let world = &self.world;
        let noisy = world.sd.iter().flatten().all(|sd| *sd > 0.0);
        noisy.then(|| world.sd.iter().map(|sd| Sight::new(world.terms, &world.commanded, sd)).collect())
    }
}
