//! Why an entry that was tried was not named, in the order in which the search decides.

use crate::core::diagnose::report::named::Named;
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
