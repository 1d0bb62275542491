//! Adopted coefficients that are others in a campaign than the model says, and what that does to D_I and D_S.

use nalgebra::DVector;

use super::fit::{CampaignSample, identify_at};
use super::identified::Identified;
use super::programme::{CoefficientEstimate, StackedDesign};
use crate::core::augmented::{Adopted, AugmentedModel, KnownEffect, Options};
use crate::core::calibrate::noise::t_variance;
use crate::core::campaign::Campaign;
use crate::core::diagnose::{Verdict, diagnose};
use crate::core::effects::{Coefficient, Effect, Parameter};
use crate::core::mounting::Slot;
use crate::core::numerics::normal_equations::inverse_of_covariance;
use crate::core::numerics::tails::squares_tail;
use crate::core::separate::Rigid;

/// Chance, over all effects of the model, below which one has changed.
const CHANGED: f64 = 0.001;

/// The model's effects held against a campaign's own.
#[derive(Debug, Clone, PartialEq)]
pub struct Changed {
    pub effects: Vec<ChangedEffect>,
    /// What D_I and D_S of this campaign are with the effects that have changed as it shows them, less what they
    /// are with the model's.
    pub shifts: Vec<DriftShift>,
}

/// One effect then and now, one gyro or all gyros together.
#[derive(Debug, Clone, PartialEq)]
pub struct ChangedEffect {
    pub effect: Effect,
    /// None for one that all gyros share.
    pub slot: Option<Slot>,
    /// Each with its value and standard deviation then and now.
    pub coefficients: Vec<(Coefficient, [f64; 2], [f64; 2])>,
    /// Of noise alone, over all that is compared (Sidak).
    pub p_value: f64,
    pub changed: bool,
    /// Noise alone would not have it, but with the model's effects fitted anew the gyro shows at least as much that
    /// the model does not hold: that may be what has changed.
    pub undecided: bool,
    /// Undecided because the campaign lies beyond the temperatures that the model has seen: the effect may be bent there.
    pub beyond_seen: bool,
}

/// How far D_I or D_S of a gyro moves with the effects that changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftShift {
    pub slot: Slot,
    pub coefficient: &'static str,
    /// deg/(h g0).
    pub shift: f64,
    pub sd: f64,
}

/// Fits the model's effects to the campaign anew, at the model's temperature, and holds them against the model:
///
/// ```text
/// (k - k_model)' S^-1 (k - k_model)/m ~ F(m, nu),     S = C + C_model
/// 1/nu = w^2/dof + w_model^2/dof_model,               w = tr(S^-1 C)/m
/// ```
///
/// with `C` as the scales of the noise are estimated, m coefficients, and nu after Welch (1947): either campaign may
/// know its noise by a few repeats only. Beyond the temperatures seen it may be a bend, and is undecided. None
/// where nothing can be compared.
pub fn changed(model: &Identified, campaign: &Campaign) -> Option<Changed> {
    let programme = StackedDesign::of_another(model, campaign).ok()?;
    // The phase of a cycle is another each time: nothing to compare.
    let lasting = model.effects.iter().filter(|adopted| adopted.effect.entry().parameter != Parameter::Period);
    let effects = lasting.map(|adopted| KnownEffect { adopted: adopted.clone(), estimates: Vec::new() }).collect();
    let as_model = AugmentedModel { terms: Some(model.terms), effects, ..AugmentedModel::default() };
    let sample = CampaignSample { campaign, source: None, occasions: Vec::new() };
    let now = identify_at(&[sample], &as_model, model.reference_c).ok()?;
    let mut groups: Vec<(usize, Option<Slot>)> = Vec::new();
    for coefficient in &now.coefficients {
        if let Some((effect, _)) = coefficient.of.effect()
            && !groups.contains(&(effect, coefficient.slot))
        {
            groups.push((effect, coefficient.slot));
        }
    }
    let count = groups.len();
    let held = groups.into_iter().filter_map(|(effect, slot)| held_against(model, &now, effect, slot, count));
    let mut held: Vec<_> = held.collect();
    if held.iter().any(|(one, ..)| one.changed) {
        let estimate = CoefficientEstimate::of(model, campaign, &programme, model.effects.len());
        let errors = programme.measured(campaign) - &programme.columns * &estimate.values;
        for (one, own, _) in held.iter_mut().filter(|(one, ..)| one.changed) {
            let (effect, _) = now.coefficients[own[0].0].of.effect()?;
            one.beyond_seen = may_be_bent(&programme, &errors, (&now.effects[effect], one));
            (one.changed, one.undecided) = (!one.beyond_seen, one.beyond_seen);
        }
    }
    if held.iter().any(|(one, ..)| one.changed) {
        let (gyros, power) = lacking(&now, campaign);
        for (one, _, statistic) in held.iter_mut().filter(|(one, ..)| one.changed) {
            let lacks = power >= *statistic && gyros.iter().any(|gyro| one.slot.is_none_or(|slot| slot == *gyro));
            (one.changed, one.undecided) = (!lacks, lacks);
        }
    }
    let mut places = Vec::new();
    let mut found = Vec::new();
    for (one, own, _) in held {
        places.extend(own.into_iter().filter(|_| one.changed));
        found.push(one);
    }
    let shifts = if places.is_empty() { Vec::new() } else { shifts(&now, &places) };
    Some(Changed { effects: found, shifts })
}

/// One comparison, the places of its coefficients in the campaign's own fit with the model's values, and the sum of
/// squares of the difference.
type Held = (ChangedEffect, Vec<(usize, f64)>, f64);

/// Share of (k - k_model) T that an effect of other coefficients adds to the outputs at the least: one that is bent, and
/// there as steep, adds half.
const STRAIGHT: f64 = 0.75;

/// Whether most dwells are beyond the temperatures seen, and their `errors`, measured less forecast, are less than other
/// coefficients of an effect of temperature would have it.
fn may_be_bent(programme: &StackedDesign, errors: &DVector<f64>, (adopted, one): (&Adopted, &ChangedEffect)) -> bool {
    let (entry, n) = (adopted.effect.entry(), programme.dwells);
    let beyond = programme.seen.iter().filter(|seen| !seen.temperature).count();
    let Some(kelvin) = programme.setting.temperature.as_ref().filter(|_| entry.of_temperature && 2 * beyond > n) else {
        return false;
    };
    let of_one_kelvin = programme.setting.at_kelvin(1.0);
    let (mut along, mut expected) = (0.0, 0.0);
    for (j, gyro) in programme.gyros.iter().enumerate().filter(|(_, g)| one.slot.is_none_or(|slot| slot == g.slot)) {
        let columns = entry.regressors(&of_one_kelvin, j, adopted.shape);
        for k in 0..n {
            let more =
                one.coefficients.iter().zip(&columns).map(|((_, then, now), column)| (now[0] - then[0]) * column[k]);
            let more = gyro.scale * more.sum::<f64>() / programme.noise[j * n + k];
            along += more * errors[j * n + k] / programme.noise[j * n + k];
            expected += more * more * kelvin[k];
        }
    }
    expected > 0.0 && along < STRAIGHT * expected
}

/// Gyros in which the campaign shows more than the model with the effects that are fitted to it anew, and how much in
/// all: the sum of d^2. What is less than a change cannot have made it: with a coefficient that is three times as
/// large, a shape not quite right (a time constant, a direction) leaves something, too.
fn lacking(now: &Identified, campaign: &Campaign) -> (Vec<Slot>, f64) {
    let (terms, adopted) = (Some(now.terms), now.effects.clone());
    let options = Options { terms, adopted, reference_c: now.reference_c, ..Options::default() };
    let all = || campaign.gyros.iter().map(|gyro| gyro.slot).collect();
    let Ok(found) = diagnose(campaign, &options) else { return (all(), f64::INFINITY) };
    let named: f64 = found.effects.iter().map(|effect| effect.detectability.powi(2)).sum();
    let outputs = (campaign.dwells.len() * campaign.gyros.len()) as f64;
    match found.verdict {
        Verdict::NoGap => (Vec::new(), 0.0),
        Verdict::Explained => (found.effects.iter().flat_map(|effect| effect.gyros.iter().copied()).collect(), named),
        Verdict::PartlyExplained | Verdict::Unexplained => {
            (all(), named + outputs * (found.remaining.reduced_chi2 - 1.0).max(0.0))
        }
    }
}

/// As [`changed`], where the model in use is one of the very IMU, holds effects, and can be compared.
pub fn changed_since(model: &AugmentedModel, campaign: &Campaign) -> Option<Changed> {
    let identified = model.identified.as_ref().filter(|identified| !identified.effects.is_empty())?;
    changed(identified, campaign)
}

fn held_against(model: &Identified, now: &Identified, effect: usize, slot: Option<Slot>, count: usize) -> Option<Held> {
    let adopted = &now.effects[effect];
    let of = |identified: &Identified, effect: usize| -> Vec<usize> {
        let places = identified.of_effect(effect).into_iter();
        places.filter(|place| identified.coefficients[*place].slot == slot).collect()
    };
    let then = of(model, model.effects.iter().position(|known| known == adopted)?);
    let own = of(now, effect);
    if then.len() != own.len() || then.is_empty() {
        return None;
    }
    let values = |identified: &Identified, places: &[usize]| identified.values().select_rows(places);
    let block =
        |identified: &Identified, places: &[usize]| identified.covariance.select_rows(places).select_columns(places);
    let difference = values(now, &own) - values(model, &then);
    // Covariances are those of errors that follow a t distribution.
    let scales = [now, model].map(|identified| identified.dof(slot));
    let [of_now, of_model] = [(now, &own, scales[0]), (model, &then, scales[1])]
        .map(|(identified, places, dof)| block(identified, places) / t_variance(dof));
    let inverse = inverse_of_covariance(&(&of_now + &of_model))?;
    let count_of = own.len();
    let shares = [of_now, of_model].map(|of| (&inverse * of).trace() / count_of as f64);
    let dofs = [scales[0], scales[1] * model.campaigns.len() as f64];
    let dof = shares.iter().zip(dofs).map(|(share, dof)| share * share / dof).sum::<f64>().recip();
    let statistic = difference.dot(&(inverse * &difference));
    let alone = squares_tail(statistic, count_of, dof);
    // 1 - (1 - p)^n without losing small p.
    let p_value = -f64::exp_m1(count as f64 * f64::ln_1p(-alone.min(1.0 - 1e-16)));
    let names = adopted.effect.entry().coefficients(adopted.shape);
    let coefficients = names.into_iter().enumerate().map(|(m, coefficient)| {
        let pair = |identified: &Identified, place: usize| [identified.coefficients[place].value, identified.sd(place)];
        (coefficient, pair(model, then[m]), pair(now, own[m]))
    });
    let one = ChangedEffect {
        effect: adopted.effect,
        slot,
        coefficients: coefficients.collect(),
        p_value,
        changed: p_value < CHANGED,
        undecided: false,
        beyond_seen: false,
    };
    Some((one, own.into_iter().zip(values(model, &then).iter().copied()).collect(), statistic))
}

/// D_I and D_S with the effects as the campaign has them, less those with the model's.
fn shifts(now: &Identified, changed: &[(usize, f64)]) -> Vec<DriftShift> {
    let free = CoefficientEstimate { values: now.values(), covariance: now.covariance.clone() };
    let mut held = free.clone();
    let places: Vec<usize> = changed.iter().map(|(place, _)| *place).collect();
    held.condition(&places, &DVector::from_iterator(changed.len(), changed.iter().map(|(_, value)| *value)));
    let mut all = Vec::new();
    for gyro in &now.gyros {
        let of = |k: &CoefficientEstimate| Some(now.separation(gyro.slot, &k.values, &k.covariance)?.rigid);
        let (Some(free), Some(held)) = (of(&free), of(&held)) else { continue };
        // The variance of a fit less that of the same fit with something known is the variance of their difference.
        let variance = |rigid: &Rigid, i: usize| rigid.covariance.map_or(0.0, |c| c[(i, i)]);
        for (i, (coefficient, shift)) in
            [("D_I", free.d_i - held.d_i), ("D_S", free.d_s - held.d_s)].into_iter().enumerate()
        {
            let sd = (variance(&free, i) - variance(&held, i)).max(0.0).sqrt();
            all.push(DriftShift { slot: gyro.slot, coefficient, shift, sd });
        }
    }
    all
}
