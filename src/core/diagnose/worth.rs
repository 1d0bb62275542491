//! What several choices are worth together.

use super::bank::Kind;
use super::evidence::log_bayes_in;
use super::logsum::LogSum;
use super::products::Products;
use super::search::{Choice, PER_CAUSE, SUSPECT_ODDS, Search, without};

impl Search<'_> {
    /// Drops names that the others, chosen anew without them, make superfluous: a cause that two entries explain alike may have been
    /// given to one of them in some gyros and to the other in the rest.
    pub(super) fn fewest(&self, mut choices: Vec<Choice>) -> Vec<Choice> {
        let mut i = 0;
        while choices.len() > 1 && i < choices.len() && !choices.iter().any(Choice::is_suspect) {
            let mut fewer = without(&choices, i);
            self.polish_contract(&mut fewer);
            if self.worth(&choices) - self.worth(&fewer) > self.needed(fewer.len()) {
                i += 1;
            } else {
                (choices, i) = (self.prune(fewer), 0);
            }
        }
        choices
    }

    /// Evidence of all choices together less what each further cause costs beforehand.
    pub(super) fn worth(&self, choices: &[Choice]) -> f64 {
        let together: f64 = (0..choices.len()).map(|i| self.in_members(&choices[..i], &choices[i])).sum();
        together - PER_CAUSE * choices.len() as f64
    }

    /// Evidence of a choice in its own gyros and no others, given `before`. [`Search::scores`] average over all sets of gyros: were
    /// that added up, two names that share the gyros between them would each be credited with the other's.
    fn in_members(&self, before: &[Choice], choice: &Choice) -> f64 {
        let Some((_, range)) = self.bank.kinds.iter().find(|(kind, _)| *kind == choice.kind) else { return 0.0 };
        let hypotheses = &self.bank.hypotheses[range.clone()];
        let state = self.state(before);
        let products = Products::of_some(self.bank, hypotheses, &state);
        let seen = products.seen(&state);
        let mut total = LogSum::default();
        for hypothesis in hypotheses {
            total.add(log_bayes_in(hypothesis, &choice.members, &seen));
        }
        total.log() + if matches!(choice.kind, Kind::Suspect(_)) { SUSPECT_ODDS } else { 0.0 }
    }
}
