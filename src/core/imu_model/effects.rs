//! Which effects a model is fitted with: those that the diagnoses of its campaigns name, or those that are asked for.

use crate::core::augmented::{Adopted, AugmentedModel, KnownEffect};
use crate::core::calibrate::calibrate_augmented;
use crate::core::campaign::Campaign;
use crate::core::diagnose::{NamedEffect, Verdict, diagnose};
use crate::core::effects::{Effect, Refusal, Shape, axes};
use crate::core::model::Terms;

/// Effects chosen for several campaigns of an IMU.
#[derive(Debug, Clone, PartialEq)]
pub struct Chosen {
    /// Terms, and effects that act in every campaign; without estimates.
    pub model: AugmentedModel,
    /// By campaign, effects of it alone.
    pub occasions: Vec<Vec<Adopted>>,
    /// By campaign, what its diagnosis with the effects of those before it came to.
    pub verdicts: Vec<Verdict>,
}

/// Diagnoses the campaigns one after the other, each against what the ones before named.
///
/// # Errors
/// [`Refusal`], where one cannot be diagnosed.
pub fn named(campaigns: &[&Campaign], terms: Option<Terms>) -> Result<Chosen, Refusal> {
    let model = AugmentedModel { terms, ..AugmentedModel::default() };
    let mut chosen = Chosen { model, occasions: Vec::new(), verdicts: Vec::new() };
    for campaign in campaigns {
        let found = diagnose(campaign, &chosen.model.options(campaign))?;
        chosen.verdicts.push(found.verdict);
        let mut occasions = Vec::new();
        for effect in &found.effects {
            let entry = effect.effect.entry();
            match (entry.closure_only, entry.one_occasion) {
                (true, _) => {}
                (false, true) => occasions.push(adopted(effect)),
                // What one gyro has the others may have less of: their coefficients are as well known as the campaigns
                // tell, and not zero.
                (false, false) => {
                    let slots = campaign.gyros.iter().map(|gyro| gyro.slot).collect();
                    join(&mut chosen.model, Adopted { slots, ..adopted(effect) });
                }
            }
        }
        chosen.occasions.push(occasions);
    }
    Ok(chosen)
}

fn adopted(named: &NamedEffect) -> Adopted {
    Adopted { effect: named.effect, shape: named.shape, slots: named.gyros.clone() }
}

/// The same effect in further gyros is one effect.
fn join(model: &mut AugmentedModel, new: Adopted) {
    match model.effects.iter_mut().find(|known| known.adopted.effect == new.effect) {
        Some(known) => {
            let further = new.slots.into_iter().filter(|slot| !known.adopted.slots.contains(slot));
            known.adopted.slots.extend(further.collect::<Vec<_>>());
        }
        None => model.effects.push(KnownEffect { adopted: new, estimates: Vec::new() }),
    }
}

/// The effects that are asked for, in all gyros, each with the shape that fits the campaign best.
///
/// # Errors
/// [`Refusal`], where the campaign has no axes.
pub fn asked_for(effects: &[Effect], campaign: &Campaign, terms: Option<Terms>) -> Result<AugmentedModel, Refusal> {
    let (setting, _) = axes::setting(campaign)?;
    let slots: Vec<_> = campaign.gyros.iter().map(|gyro| gyro.slot).collect();
    let mut model = AugmentedModel { terms, ..AugmentedModel::default() };
    for effect in effects {
        let known = model.options(campaign);
        let fitted_with = |adopted: &Adopted| -> f64 {
            let all: Vec<Adopted> = known.adopted.iter().chain([adopted]).cloned().collect();
            let fit = calibrate_augmented(campaign, known.terms.unwrap_or_default(), &all);
            fit.gyros.iter().map(|gyro| gyro.chi2).sum()
        };
        let with = |shape| Adopted { effect: *effect, shape, slots: slots.clone() };
        let shapes = (effect.entry().shapes)(&setting).into_iter().map(|(shape, _)| with(shape));
        let scored = shapes.map(|adopted| (fitted_with(&adopted), adopted));
        let any = Some(with(Shape::Linear)).filter(Adopted::is_of_any_direction);
        let untold = any.filter(|any| {
            let all: Vec<Adopted> = known.adopted.iter().chain([any]).cloned().collect();
            let fit = calibrate_augmented(campaign, known.terms.unwrap_or_default(), &all);
            fit.gyros.iter().any(|gyro| gyro.holds_untold_field)
        });
        let best = || scored.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, best)| best);
        if let Some(best) = untold.or_else(best) {
            join(&mut model, best);
        }
    }
    Ok(model)
}
