//! Why an entry that was tried was not named, in the order in which the search decides.

use crate::core::diagnose::diagnosis::Candidate;
use crate::core::diagnose::report::closure::UNSEEN;
use crate::core::diagnose::report::named::{Named, slots};
use crate::core::diagnose::report::{held_out, identifiability};
use crate::core::diagnose::search::bayes_factor::Score;
use crate::core::diagnose::search::hypotheses::INVISIBLE;
use crate::core::diagnose::search::noise_rounds::{FALSE_ALARM, Settled};
use crate::core::diagnose::search::stepwise::{Choice, MOST, Search};
use crate::core::effects::Effect;

pub(crate) struct WhyNot<'a> {
    pub settled: &'a Settled,
    pub search: &'a Search<'a>,
    pub named: &'a [Named],
}

impl WhyNot<'_> {
    /// `alone` is what the entry is held against the threshold with where nothing else is in the model.
    pub fn of(&self, effect: Effect, alone: f64, visible: bool) -> String {
        if !visible {
            return "the design does not show it".to_owned();
        }
        if let Some(twin) = self.named.iter().find(|n| n.class.contains(&effect)) {
            return format!("this campaign cannot tell it from {}, which stands for both", twin.part.effect.id());
        }
        if self.search.is_ruled_out(&[], effect) {
            return "its size would be beyond what is plausible".to_owned();
        }
        if alone <= self.search.needed(0) {
            let p = digits(self.search.p_value(alone));
            return format!(
                "noise alone shows as much somewhere in {p} of campaigns; a name asks for less than {FALSE_ALARM}"
            );
        }
        let found = &self.settled.found;
        if found.iter().any(|choice| choice.kind == effect) && !effect.entry().is_one_dwell() {
            return "it closes nothing of dwells that were held out".to_owned();
        }
        if found.iter().any(|choice| choice.kind == effect) {
            return "several dwells stand out, each by itself: that is not one bad dwell".to_owned();
        }
        let Some(first) = self.takes_most_from(effect) else {
            return if self.settled.frame.noise.law.is_some() {
                "it did not hold with the growth of the noise with rate left open".to_owned()
            } else {
                "it did not hold with everything fitted together".to_owned()
            };
        };
        let left = self.search.evidence(found, effect);
        match first.kind {
            _ if left > self.search.needed(found.len()) && found.len() >= MOST => {
                format!("{MOST} causes are in the model already: what needs more has not been understood")
            }
            _ if left > self.search.needed(found.len()) => {
                format!("beside {} it did not hold with everything fitted together", told(first.kind))
            }
            first if first.is_nameable() => {
                format!("it explains the same dwells as {} less well, and nothing beside it", told(first))
            }
            _ => {
                format!("{}, outside the catalogue, explains the same dwells better", told(first.kind))
            }
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
pub(crate) fn candidates(settled: &Settled, search: &Search, named: &[Named], variances: &[f64]) -> Vec<Candidate> {
    let (frame, known) = (&settled.frame, search.scores(&[]));
    let why_not = WhyNot { settled, search, named };
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
            held_out::errors(frame, &[], &[&part], variances).held_out(1.0, coefficients, UNSEEN)
        });
        Some(Candidate {
            effect,
            closure: held_out.map(|h| h.closure),
            interval: held_out.map(|h| h.interval),
            p_value_adjusted: search.p_value(earned),
            within_noise: earned <= search.needed(0) && !search.is_ruled_out(&[], score.kind),
            gyros: slots(frame, &choice.members),
            why_not: why_not.of(effect, earned, visible),
        })
    });
    judged.collect()
}

fn told(kind: Effect) -> &'static str {
    if kind.is_nameable() { kind.id() } else { kind.entry().looks_like }
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
