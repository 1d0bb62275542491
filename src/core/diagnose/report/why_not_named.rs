//! Why an entry that was tried was not named, in the order in which the search decides.

use crate::core::diagnose::diagnosis::Candidate;
use crate::core::diagnose::report::closure::UNSEEN;
use crate::core::diagnose::report::named::{Named, slots};
use crate::core::diagnose::report::{held_out, identifiability};
use crate::core::diagnose::search::bayes_factor::Score;
use crate::core::diagnose::search::choice::Choice;
use crate::core::diagnose::search::hypotheses::INVISIBLE;
use crate::core::diagnose::search::noise_rounds::{FALSE_ALARM, SearchOutcome};
use crate::core::diagnose::search::stepwise::{MOST, Search};
use crate::core::effects::Effect;
use crate::core::message::{Message, text};
use crate::message;

pub(crate) struct RejectionReasons<'a> {
    pub settled: &'a SearchOutcome,
    pub search: &'a Search<'a>,
    pub named: &'a [Named],
}

impl RejectionReasons<'_> {
    /// `alone` is what the entry is held against the threshold with where nothing else is in the model.
    pub fn of(&self, effect: Effect, alone: f64, visible: bool) -> Message {
        if !visible {
            return message!("design_does_not_show_it");
        }
        if let Some(twin) = self.named.iter().find(|n| n.class.contains(&effect)) {
            return message!("one_class_with", effect = twin.part.effect.word());
        }
        if self.search.is_ruled_out(&[], effect) {
            return message!("beyond_plausible_size");
        }
        if alone <= self.search.needed(&[]) {
            return message!("not_significant", p = digits(self.search.p_value(alone)), level = text(FALSE_ALARM));
        }
        let found = &self.settled.found;
        if found.iter().any(|choice| choice.kind == effect) {
            return match effect.entry().is_one_dwell() {
                true => message!("several_outlier_dwells"),
                false => message!("closes_nothing_held_out"),
            };
        }
        let Some(first) = self.takes_most_from(effect) else {
            return match self.settled.frame.noise.law {
                Some(_) => message!("not_with_noise_growth_open"),
                None => message!("not_in_joint_fit"),
            };
        };
        let first = first.kind;
        if self.search.evidence(found, effect) > self.search.needed(found) {
            return match found.len() >= MOST {
                true => message!("too_many_causes", count = MOST),
                false => message!("not_in_joint_fit_beside", effect = first.word()),
            };
        }
        if self.search.evidence(found, effect) > self.search.threshold.beside {
            return message!("too_small_beside", effect = first.word());
        }
        match first.is_nameable() {
            true => message!("explains_less_than", effect = first.word()),
            false => message!("explained_outside_catalogue", effect = first.word()),
        }
    }

    /// What was adopted and leaves least of `kind`.
    fn takes_most_from(&self, kind: Effect) -> Option<&Choice> {
        let found = &self.settled.found;
        let beside = |choice: &Choice| self.search.evidence(std::slice::from_ref(choice), kind);
        match found.as_slice() {
            [] => None,
            [one] => Some(one),
            more => more.iter().min_by(|a, b| beside(a).total_cmp(&beside(b))),
        }
    }
}

/// Every other entry that was tried, best first, with why it was not taken.
pub(crate) fn candidates(
    settled: &SearchOutcome,
    search: &Search,
    named: &[Named],
    variances: &[f64],
    remains: bool,
) -> Vec<Candidate> {
    let (frame, known) = (&settled.frame, search.scores(&[]));
    let why_not = RejectionReasons { settled, search, named };
    let open = |score: &&Score| score.kind.is_nameable() && !named.iter().any(|n| n.part.effect == score.kind);
    let mut alone: Vec<&Score> = known.iter().filter(open).collect();
    alone.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    let judged = alone.iter().filter_map(|score| {
        let choice = search.choice(score);
        let part = search.part(&choice)?;
        let (effect, earned) = (part.effect, search.earned(&[], score.kind));
        let visible = identifiability::visible(&settled.bank, effect) > INVISIBLE;
        let held_out = visible.then(|| {
            let coefficients = part.columns(frame, 0).len() as f64;
            held_out::errors(frame, &[], &[&part], variances, remains).held_out(1.0, coefficients, UNSEEN)
        });
        Some(Candidate {
            effect,
            closure: held_out.map(|h| h.closure),
            interval: held_out.map(|h| h.interval),
            p_value_adjusted: search.p_value(earned),
            within_noise: earned <= search.needed(&[]) && !search.is_ruled_out(&[], score.kind),
            gyros: slots(frame, &choice.members),
            why_not: why_not.of(effect, earned, visible),
        })
    });
    judged.collect()
}

/// A probability with two digits that count.
fn digits(p: f64) -> String {
    let decimals = if p > 0.0 { (1.0 - p.log10().floor()).clamp(2.0, 9.0) as usize } else { 2 };
    format!("{p:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probability_shows_which_side_of_the_level_it_is_on() {
        assert_eq!([0.96, 0.2, 0.0214, 0.008_12, 1.0].map(digits), ["0.96", "0.20", "0.021", "0.0081", "1.00"]);
    }
}
