//! Puts causes into a campaign: draws their hidden particulars and finds the size that makes them as visible as asked.

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::core::fault::Faults;

use super::cause::{ALWAYS, CATALOGUE, COMMON, Cause, CauseKind, Mechanism, Particulars, known};
use super::detectability::norm;
use super::fault_at::fault;
use super::outside::UncataloguedCause;
use super::scenario::{EffectChoice, slot_named};
use super::world::World;
use crate::core::message::{sent, text};
use crate::message;

/// A response of which less than this share is left over by the model cannot be seen.
const UNSEEN: f64 = 1e-5;
/// Whether anything of a response is left over by the model, beyond rounding.
pub fn is_visible(detectability: f64, power: f64) -> bool {
    detectability > UNSEEN * power
}

/// The cause that a person or the blind check chose, its particulars drawn and its size found.
pub fn injected(world: &World, choice: &EffectChoice, pointer: &str, rng: &mut ChaCha8Rng) -> Result<Cause, Faults> {
    let mid_h = world.mid_h();
    let fixed =
        Particulars { time_h: choice.time_h, dwell: choice.dwell, direction: choice.direction.map(Vector3::from) };
    check_particulars(world, choice, pointer)?;
    let unknown = || {
        let unknown = message!("unknown_effect", effect = sent(&choice.effect), effects = known());
        fault(&format!("{pointer}/effect"), unknown)
    };
    let (kind, typical) = match choice.effect.strip_prefix("outside:") {
        Some(family) => {
            (CauseKind::Uncatalogued(UncataloguedCause::draw(family, &mid_h, rng).ok_or_else(unknown)?), 1e-6)
        }
        None => {
            let typical = CATALOGUE.iter().find(|known| known.id == choice.effect).ok_or_else(unknown)?.typical;
            let effect = Mechanism::draw(&choice.effect, &fixed, &mid_h, rng).ok_or_else(unknown)?;
            (CauseKind::Catalogue(effect), typical)
        }
    };
    let weights = weights(world, choice, pointer, rng)?;
    let last_h = mid_h.last().copied().unwrap_or(1.0);
    let acts_in_h = choice.acts_in.map_or(ALWAYS, |shares| shares.map(|share| share * last_h));
    let cause = Cause { label: choice.effect.clone(), size: typical, weights, kind, acts_in_h };
    match (choice.size, choice.detectability) {
        (Some(size), None) if size.is_finite() => Ok(Cause { size, ..cause }),
        (None, Some(d)) if d.is_finite() && d > 0.0 => sized(world, cause, d, pointer),
        (None, None) => Ok(cause),
        _ => Err(fault(pointer, message!("size_or_detectability"))),
    }
}

fn check_particulars(world: &World, choice: &EffectChoice, pointer: &str) -> Result<(), Faults> {
    let mut faults = Faults::default();
    if let Some(time_h) = choice.time_h.filter(|t| !(t.is_finite() && *t > 0.0)) {
        faults.push(format!("{pointer}/time_h"), message!("not_positive_time", value = text(time_h)));
    }
    if let Some(dwell) = choice.dwell.filter(|&k| k >= world.plan.len()) {
        faults.push(format!("{pointer}/dwell"), message!("beyond_last_dwell", dwell, dwells = world.plan.len()));
    }
    if let Some([from, to]) = choice.acts_in.filter(|[from, to]| from.partial_cmp(to) != Some(std::cmp::Ordering::Less))
    {
        let value = format!("{from} .. {to}");
        faults.push(format!("{pointer}/acts_in"), message!("acts_never", value = text(value)));
    }
    faults.or(())
}

/// One for gyros that have the effect alike; where the choice is by detectability each has a share of its own.
fn weights(world: &World, choice: &EffectChoice, pointer: &str, rng: &mut ChaCha8Rng) -> Result<[f64; 3], Faults> {
    let mut chosen = [true; 3];
    if let (Some(names), false) = (&choice.gyros, COMMON.contains(&choice.effect.as_str())) {
        chosen = [false; 3];
        for (i, name) in names.iter().enumerate() {
            chosen[slot_named(name, &format!("{pointer}/gyros/{i}"))?.index()] = true;
        }
    }
    let mut weights = [0.0; 3];
    for gyro in &world.gyros {
        let own = rng.random_range(0.7..1.4) * if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let alike = choice.size.is_some() || COMMON.contains(&choice.effect.as_str());
        if chosen[gyro.slot.index()] {
            weights[gyro.slot.index()] = if alike { 1.0 } else { own };
        }
    }
    if weights == [0.0; 3] {
        return Err(fault(&format!("{pointer}/gyros"), message!("names_no_gyro")));
    }
    Ok(weights)
}

/// `cause` with the size that makes it as visible as `d`. Finite rotations are not quite linear: three rounds.
fn sized(world: &World, mut cause: Cause, d: f64, pointer: &str) -> Result<Cause, Faults> {
    for _ in 0..3 {
        let (seen, power) = world.detectability(std::slice::from_ref(&cause));
        let (seen, power) = (norm(&seen), norm(&power));
        if !is_visible(seen, power) {
            let unseen = message!("effect_not_seen", effect = cause.label.clone());
            return Err(fault(&format!("{pointer}/detectability"), unseen));
        }
        cause.size *= d / seen;
    }
    Ok(cause)
}
