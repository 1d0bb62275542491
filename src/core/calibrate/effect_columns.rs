//! Effects that the model holds beyond model (6), as columns of the fit.

use nalgebra::{DMatrix, DVector};

use super::design::{Design, WeightedDesign};
use super::regressor::{Regressor, adding, told_apart};
use crate::core::augmented::{Adopted, KnownCoefficient};
use crate::core::calibrate::shared_coefficients::SharedRegressors;
use crate::core::campaign::{Campaign, CampaignNote, EffectNotFitted, Temperatures, any_kelvin};
use crate::core::effects::{Effect, Entry, MissingInput, OwnHypothesis, Scope, Setting, Shape, axes};
use crate::core::mounting::Slot;
use crate::core::numerics::basis::Basis;
use crate::core::numerics::least_squares::{Factor, Fit};
use crate::core::numerics::normal_equations::inverse_of_covariance;
use crate::core::numerics::tails::squares_tail;

/// A coefficient is held where the campaign's standard deviation of it is so many times the model's,
const KNOWN_BETTER: f64 = 1.5;
/// unless chance is as small as this that the gyro's are so far from the model's, or those of all gyros together
const CONTRADICTED: f64 = 1e-3;
/// and the gyro's own are not near.
const DOUBTED: f64 = 0.2;

pub(super) struct Regressors {
    /// Of each gyro for itself.
    pub own: Vec<Vec<Regressor>>,
    /// Of coefficients that all gyros share.
    pub shared: Vec<SharedRegressors>,
    /// What the model says of them.
    pub known: Vec<KnownCoefficient>,
    /// Effects of temperature where nobody states one. Their regressors are root mean squares over any temperature, to
    /// be held at zero with the size of the coefficient as the standard deviation.
    pub any_temperature: Vec<Effect>,
    /// Why some cannot be formed.
    pub notes: Vec<CampaignNote>,
}

pub(super) fn regressors(
    campaign: &Campaign,
    (adopted, known): (&[Adopted], &[KnownCoefficient]),
    reference_c: Option<f64>,
) -> Regressors {
    let none = |notes| Regressors {
        own: vec![Vec::new(); campaign.gyros.len()],
        shared: Vec::new(),
        known: known.to_vec(),
        any_temperature: Vec::new(),
        notes,
    };
    if adopted.is_empty() {
        return none(Vec::new());
    }
    let (setting, notes) = match axes::setting(campaign) {
        Ok((setting, notes)) => (setting.referred_to(campaign, reference_c), notes),
        Err(why) => return none(vec![CampaignNote::EffectsLeftOut { why }]),
    };
    let mut all = none(notes);
    let unknown = reference_c.filter(|_| Temperatures::stated(campaign).is_none()).map(|reference_c| {
        any_kelvin(reference_c).map(|(kelvin, weight)| (setting.at_kelvin(kelvin), weight)).collect::<Vec<_>>()
    });
    for adopted in adopted {
        let entry = adopted.effect.entry();
        let is_known = |slot: Slot| known.iter().any(|one| (one.effect, one.slot) == (adopted.effect, slot));
        let is_restated = entry.of_temperature && adopted.slots.iter().any(|slot| is_known(*slot));
        let has_a_value = |(setting, _): &&(Setting, f64)| (entry.missing)(setting).is_none();
        let of_any = unknown.as_ref().filter(|_| is_restated);
        let of_any: Option<Vec<_>> = of_any.map(|settings| settings.iter().filter(has_a_value).collect());
        let missing = match &of_any {
            Some(settings) => settings.is_empty().then_some(MissingInput::Temperature),
            None => (entry.missing)(&setting),
        };
        if let Some(missing) = missing {
            let (effect, why) = (adopted.effect, EffectNotFitted::Lacks(missing));
            all.notes.push(CampaignNote::EffectLeftOut { slot: None, effect, why });
            continue;
        }
        if of_any.is_some() {
            let of_others = adopted.slots.iter().filter(|slot| !is_known(**slot));
            all.notes.extend(of_others.map(|slot| {
                let (slot, why) = (Some(*slot), EffectNotFitted::Lacks(MissingInput::Temperature));
                CampaignNote::EffectLeftOut { slot, effect: adopted.effect, why }
            }));
            all.any_temperature.push(adopted.effect);
            for one in all.known.iter_mut().filter(|one| one.effect == adopted.effect) {
                (one.value, one.sd) = (0.0, one.value.hypot(one.sd));
            }
        }
        if adopted.effect.hypothesis().is_some_and(OwnHypothesis::is_left_out_at_reference) {
            all.notes.push(CampaignNote::EffectAtReference { effect: adopted.effect });
        }
        let coefficients = entry.coefficients(adopted.shape);
        let first = all.shared.len();
        if entry.scope == Scope::Common {
            all.shared.resize_with(first + coefficients.len(), || vec![None; campaign.gyros.len()]);
        }
        let acts_in = |slot: Slot| adopted.slots.contains(&slot) && (of_any.is_none() || is_known(slot));
        for (j, axes) in setting.gyros.iter().enumerate().filter(|(_, axes)| acts_in(axes.slot)) {
            let columns = match &of_any {
                Some(settings) => over_any_temperature(entry, settings, j, adopted.shape),
                None => entry.regressors(&setting, j, adopted.shape),
            };
            for (c, (column, coefficient)) in columns.into_iter().zip(&coefficients).enumerate() {
                let column = axes.scale * DVector::from_vec(column);
                let regressor = Regressor { effect: adopted.effect, coefficient: *coefficient, column };
                match entry.scope {
                    Scope::Gyro => all.own[j].push(regressor),
                    Scope::Common => all.shared[first + c][j] = Some(regressor),
                }
            }
        }
    }
    all
}

/// Root mean squares of the regressors of gyro `j`, dwell by dwell, with the signs where they are largest: they need not
/// be linear in temperature.
fn over_any_temperature(entry: &Entry, settings: &[&(Setting, f64)], j: usize, shape: Shape) -> Vec<Vec<f64>> {
    let all: Vec<_> = settings.iter().map(|(setting, weight)| (entry.regressors(setting, j, shape), *weight)).collect();
    let length = |column: &[f64]| column.iter().map(|x| x * x).sum::<f64>();
    let of_coefficient = |c: usize| {
        let columns = || all.iter().map(|(columns, weight)| (columns[c].as_slice(), *weight));
        let (largest, _) = columns().max_by(|(a, _), (b, _)| length(a).total_cmp(&length(b)))?;
        let rms = |k: usize| columns().map(|(column, weight)| weight * column[k] * column[k]).sum::<f64>().sqrt();
        Some(largest.iter().enumerate().map(|(k, x)| rms(k).copysign(*x)).collect())
    };
    (0..entry.coefficients(shape).len()).filter_map(of_coefficient).collect()
}

/// The regressors that leave something over beside model (6) and those before them, and the effects that do not.
pub(super) fn visible(base: &Factor, regressors: Vec<Regressor>) -> (Vec<Regressor>, Vec<Effect>) {
    let whitened = regressors.iter().map(|regressor| regressor.column.component_mul(base.weights()));
    let (adds, _) = adding(Basis::of_orthonormal(base.basis()), whitened.map(|column| (column.norm_squared(), column)));
    told_apart(regressors, &adds, |regressor| Some(regressor.effect))
}

/// What a gyro's dwells say of an effect that the model knows, each of its coefficients fitted freely.
pub(super) struct Retold {
    slot: Slot,
    effect: Effect,
    /// Whether they tell it clearly less well than the model, or not at all.
    worse: bool,
    /// Sum of squares of how far its coefficients are from the model's, over their standard deviations.
    squares: f64,
    count: usize,
    /// Degrees of freedom of the noise.
    dof: f64,
}

/// Fits the effects that the model knows to one gyro anew: (k - k_model)' (C + C_model)^-1 (k - k_model), effect by
/// effect. `of_noise` gives the variance over that of the weights and its degrees of freedom.
pub(super) fn retold(
    WeightedDesign { design, sd, factor: base }: &WeightedDesign,
    y: &DVector<f64>,
    regressors: &[Regressor],
    (slot, known): (Slot, &[KnownCoefficient]),
    of_noise: impl Fn(&Fit) -> (f64, f64),
) -> Vec<Retold> {
    let known_of = |one: &Regressor| known.iter().find(|known| is_of(known, slot, one));
    let mut effects: Vec<Effect> = regressors.iter().filter_map(|one| known_of(one).map(|_| one.effect)).collect();
    effects.dedup();
    if effects.is_empty() {
        return Vec::new();
    }
    let (kept, hidden) = visible(base, regressors.to_vec());
    let fit = Factor::new(extended(design, &kept).reduced, sd).fit(y);
    let first = fit.estimate.len() - kept.len();
    let (variance, dof) = of_noise(&fit);
    let of = |effect: Effect| {
        let told = kept.iter().enumerate().filter(|(_, one)| one.effect == effect);
        let told: Vec<_> = told.filter_map(|(m, one)| Some((first + m, known_of(one)?))).collect();
        let covariance = |a: usize, b: usize| fit.covariance[(told[a].0, told[b].0)] * variance;
        let own = DMatrix::from_fn(told.len(), told.len(), covariance);
        let worse = told.iter().enumerate().any(|(i, (_, known))| own[(i, i)].sqrt() > KNOWN_BETTER * known.sd);
        let off = told.iter().map(|(place, known)| fit.estimate[*place] - known.value);
        let off = DVector::from_iterator(told.len(), off);
        let of_model = DVector::from_iterator(told.len(), told.iter().map(|(_, known)| known.sd * known.sd));
        let squares = inverse_of_covariance(&(own + DMatrix::from_diagonal(&of_model)))
            .map_or(0.0, |inverse| off.dot(&(inverse * &off)));
        let worse = worse || hidden.contains(&effect);
        Retold { slot, effect, worse, squares, count: told.len(), dof }
    };
    effects.into_iter().map(of).collect()
}

/// Of what is known that which is held: of effects that the model knows so much better than these dwells tell them, and
/// that they do not contradict; and where those that are contradicted are.
pub(super) fn to_hold(retold: &[Retold], known: &[KnownCoefficient]) -> (Vec<KnownCoefficient>, Vec<(Slot, Effect)>) {
    let chance = |effect: Effect, slot: Option<Slot>| {
        let those = retold.iter().filter(|one| one.effect == effect && slot.is_none_or(|slot| one.slot == slot));
        let (squares, count, dof) =
            those.fold((0.0, 0, 0.0), |sum, one| (sum.0 + one.squares, sum.1 + one.count, sum.2 + one.dof));
        squares_tail(squares, count, dof)
    };
    let is_denied = |one: &Retold| {
        let own = chance(one.effect, Some(one.slot));
        own < CONTRADICTED || own < DOUBTED && chance(one.effect, None) < CONTRADICTED
    };
    let (denied, rest): (Vec<&Retold>, Vec<&Retold>) =
        retold.iter().filter(|one| one.worse).partition(|o| is_denied(o));
    let is_held =
        |known: &&KnownCoefficient| rest.iter().any(|one| (one.slot, one.effect) == (known.slot, known.effect));
    let held = known.iter().filter(is_held).cloned().collect();
    (held, denied.into_iter().map(|one| (one.slot, one.effect)).collect())
}

/// Whether it is of the coefficient that a regressor of the gyro in `slot` is of.
pub(super) fn is_of(known: &KnownCoefficient, slot: Slot, one: &Regressor) -> bool {
    (known.slot, known.effect, known.name) == (slot, one.effect, one.coefficient.name)
}

/// The design with the regressors after model (6)'s columns.
pub(super) fn extended(design: &Design, regressors: &[Regressor]) -> Design {
    let (n, q) = design.reduced.shape();
    let (p, m) = (design.expand.nrows(), regressors.len());
    let mut reduced = design.reduced.clone().resize(n, q + m, 0.0);
    for (c, regressor) in regressors.iter().enumerate() {
        reduced.set_column(q + c, &regressor.column);
    }
    let mut expand = design.expand.clone().resize(p + m, q + m, 0.0);
    expand.view_mut((p, q), (m, m)).copy_from(&DMatrix::identity(m, m));
    let gauge = design.gauge.as_ref().map(|direction| direction.clone().resize_vertically(p + m, 0.0));
    Design { terms: design.terms, reduced, expand, gauge }
}

#[cfg(test)]
mod tests;
