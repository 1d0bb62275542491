//! A hypothesis of one's own in a simulated campaign: as large, or as visible, as asked.
//!
//! It is what its equation says, in the outputs that the station would have written.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::augment::{NotPossible, augment, detectability};
use super::run::Simulated;
use crate::core::augmented::{Adopted, AugmentedModel, KnownEffect};
use crate::core::effects::{Effect, Estimate, Scope, Shape};
use crate::core::mounting::Slot;

/// How much of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Amount {
    /// Every coefficient, in its unit.
    Size(f64),
    /// d over all gyros; proportions and signs of the coefficients are drawn.
    Detectability(f64),
}

/// Puts `effect` into the outputs of the gyros `slots`, all where none are given, its parameter drawn from its range.
///
/// # Errors
/// [`NotPossible`]; then nothing was added.
pub fn hide(
    simulated: &mut Simulated,
    effect: Effect,
    amount: Amount,
    slots: &[Slot],
    rng: &mut ChaCha8Rng,
) -> Result<KnownEffect, NotPossible> {
    let entry = effect.entry();
    let common = entry.scope == Scope::Common;
    let chosen = |slot: &Slot| common || slots.is_empty() || slots.contains(slot);
    let slots: Vec<Slot> = simulated.campaign.gyros.iter().map(|gyro| gyro.slot).filter(chosen).collect();
    if slots.is_empty() {
        return Err(NotPossible::NoGyro);
    }
    let range = effect.hypothesis().and_then(|own| own.written.range.as_ref());
    let between = |from: f64, to: f64, share: f64| match from > 0.0 {
        true => from * (to / from).powf(share),
        false => from + (to - from) * share,
    };
    let shape = range.map_or(Shape::Linear, |r| Shape::Own(between(r.from, r.to, rng.random_range(0.1..0.9))));
    let mut estimate = |slot: Option<Slot>, name: &'static str| {
        let own = rng.random_range(0.7..1.4) * if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let value = if let Amount::Size(size) = amount { size } else { own };
        Estimate { slot, name, value, sd: 0.0, unit: entry.unit }
    };
    let gyros: Vec<Option<Slot>> = if common { vec![None] } else { slots.iter().copied().map(Some).collect() };
    let names = (entry.names)(shape);
    let estimates = gyros.iter().flat_map(|slot| names.iter().map(|name| (*slot, *name)));
    let estimates: Vec<Estimate> = estimates.map(|(slot, name)| estimate(slot, name)).collect();
    let mut known = KnownEffect { adopted: Adopted { effect, shape, slots }, estimates };
    if let Amount::Detectability(wanted) = amount {
        let seen = detectability(simulated, &known)?.ok_or(NotPossible::Unseen { effect: entry.id })?;
        known.estimates.iter_mut().for_each(|estimate| estimate.value *= wanted / seen);
    }
    augment(simulated, &AugmentedModel { effects: vec![known.clone()], ..AugmentedModel::default() })?;
    Ok(known)
}
