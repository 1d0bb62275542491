//! Effects that the model holds beyond model (6), as columns of the fit.

use nalgebra::{DMatrix, DVector};

use super::design::Design;
use super::regressor::{Regressor, adding, told_apart};
use crate::core::augmented::{Adopted, Known};
use crate::core::calibrate::shared_coefficients::Shared;
use crate::core::campaign::{Campaign, CampaignNote, LeftOut, Temperatures, unknown_kelvin};
use crate::core::effects::{Effect, Scope, Setting, axes};
use crate::core::mounting::Slot;
use crate::core::numerics::basis::Basis;
use crate::core::numerics::least_squares::{Factor, Fit};

/// A coefficient is held where the campaign's standard deviation of it is so many times the model's,
const KNOWN_BETTER: f64 = 1.5;
/// unless the two are so many standard deviations apart.
const CONTRADICTED: f64 = 3.5;

/// The regressors of the adopted effects.
pub(super) struct Regressors {
    /// Of each gyro for itself.
    pub own: Vec<Vec<Regressor>>,
    /// Of coefficients that all gyros share.
    pub shared: Vec<Shared>,
    /// What the model says of them.
    pub known: Vec<Known>,
    /// Effects of temperature where nobody states one. Their regressors are those of one kelvin in all dwells, to be
    /// held at zero with what any temperature would do as the standard deviation.
    pub any_temperature: Vec<Effect>,
    /// Why some cannot be formed.
    pub notes: Vec<CampaignNote>,
}

pub(super) fn regressors(
    campaign: &Campaign,
    (adopted, known): (&[Adopted], &[Known]),
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
        let at_one_kelvin = Setting { temperature: Some(vec![1.0; setting.dwells()]), ..setting.clone() };
        (unknown_kelvin(reference_c), at_one_kelvin)
    });
    for adopted in adopted {
        let entry = adopted.effect.entry();
        let is_known = |slot: Slot| known.iter().any(|one| (one.effect, one.slot) == (adopted.effect, slot));
        let of_any =
            unknown.as_ref().filter(|_| entry.of_temperature && adopted.slots.iter().any(|slot| is_known(*slot)));
        let setting = of_any.map_or(&setting, |(_, at_one_kelvin)| at_one_kelvin);
        if let Some(missing) = (entry.missing)(setting) {
            let (effect, why) = (adopted.effect, LeftOut::Lacks(missing));
            all.notes.push(CampaignNote::EffectLeftOut { slot: None, effect, why });
            continue;
        }
        if let Some((kelvin, _)) = of_any {
            all.any_temperature.push(adopted.effect);
            for one in all.known.iter_mut().filter(|one| one.effect == adopted.effect) {
                (one.value, one.sd) = (0.0, kelvin * one.value.hypot(one.sd));
            }
        }
        let coefficients = entry.coefficients(adopted.shape);
        let first = all.shared.len();
        if entry.scope == Scope::Common {
            all.shared.resize_with(first + coefficients.len(), || vec![None; campaign.gyros.len()]);
        }
        let acts_in = |slot: Slot| adopted.slots.contains(&slot) && (of_any.is_none() || is_known(slot));
        for (j, axes) in setting.gyros.iter().enumerate().filter(|(_, axes)| acts_in(axes.slot)) {
            let mut columns = (entry.columns)(setting, j, adopted.shape);
            if let Some(beyond) = entry.beyond.filter(|_| entry.beyond_is_linear) {
                // A torquer's scale factor multiplies drift as it does rate: held at the reference, G/|E| stays.
                let of_drift = beyond(setting, j, adopted.shape, &[1.0]);
                columns[0].iter_mut().zip(of_drift).for_each(|(column, more)| *column += more);
            }
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

/// The regressors that leave something over beside model (6) and those before them, and the effects that do not.
pub(super) fn visible(base: &Factor, regressors: Vec<Regressor>) -> (Vec<Regressor>, Vec<Effect>) {
    let whitened = regressors.iter().map(|regressor| regressor.column.component_mul(base.weights()));
    let (adds, _) = adding(Basis::of_orthonormal(base.basis()), whitened.map(|column| (column.norm_squared(), column)));
    told_apart(regressors, &adds, |regressor| Some(regressor.effect))
}

/// Those regressors that are fitted, and those that are held with what is known of them: of an effect that the model
/// knows so much better than these dwells tell it, or that they do not tell, and that they do not contradict.
pub(super) fn to_hold<'a>(
    (design, sd, base): &(Design, Vec<f64>, Factor),
    y: &DVector<f64>,
    regressors: Vec<Regressor>,
    known: &[&'a Known],
    variance: impl Fn(&Fit) -> f64,
) -> (Vec<Regressor>, Vec<(Regressor, &'a Known)>) {
    let known_of = |one: &Regressor| {
        known.iter().copied().find(|known| known.effect == one.effect && known.name == one.coefficient.name)
    };
    let (kept, hidden) = visible(base, regressors.clone());
    let fit = Factor::new(extended(design, &kept).reduced, sd).fit(y);
    let first = fit.estimate.len() - kept.len();
    let variance = variance(&fit);
    let (mut worse, mut denied) = (hidden, Vec::new());
    for (m, one) in kept.iter().enumerate() {
        let Some(known) = known_of(one) else { continue };
        let place = first + m;
        let sd = (fit.covariance[(place, place)] * variance).sqrt();
        if sd > KNOWN_BETTER * known.sd {
            worse.push(one.effect);
        }
        if (fit.estimate[place] - known.value).abs() > CONTRADICTED * sd.hypot(known.sd) {
            denied.push(one.effect);
        }
    }
    let is_held = |one: &Regressor| worse.contains(&one.effect) && !denied.contains(&one.effect);
    let (mut fitted, mut held) = (Vec::new(), Vec::new());
    for one in regressors {
        match known_of(&one).filter(|_| is_held(&one)) {
            Some(known) => held.push((one, known)),
            None => fitted.push(one),
        }
    }
    (fitted, held)
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
