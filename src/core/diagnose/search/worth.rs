//! What several choices are worth together, and how few do.

use crate::core::diagnose::search::bayes_factor::{each_by_itself, log_bayes_in};
use crate::core::diagnose::search::hypotheses::Kind;
use crate::core::diagnose::search::projections::Products;
use crate::core::diagnose::search::stepwise::{Choice, PER_CAUSE, SUSPECT_ODDS, Search, without};
use crate::core::numerics::log_sum::LogSum;

impl Search<'_> {
    /// Drops names that the others, chosen anew without them, make superfluous, the least missed first: a cause that two entries
    /// explain alike may have been given to one of them in some gyros and to the other in the rest.
    pub(crate) fn fewest(&self, mut choices: Vec<Choice>) -> Vec<Choice> {
        while choices.len() > 1 {
            let all = self.together(&choices);
            let fewer = (0..choices.len()).filter(|&i| !choices[i].is_competitor()).map(|i| {
                let mut fewer = without(&choices, i);
                self.polish_contract(&mut fewer);
                (all - self.together(&fewer), fewer)
            });
            match fewer.min_by(|(a, _), (b, _)| a.total_cmp(b)) {
                Some((missed, mut fewer)) if missed <= self.needed(fewer.len()) => {
                    self.polish(&mut fewer);
                    choices = self.prune(fewer);
                }
                _ => break,
            }
        }
        choices
    }

    /// Evidence of all choices together less what each further cause costs beforehand.
    pub(crate) fn worth(&self, choices: &[Choice]) -> f64 {
        self.together(choices) - PER_CAUSE * choices.len() as f64
    }

    /// Evidence of all choices: each given those before it, in its own gyros.
    fn together(&self, choices: &[Choice]) -> f64 {
        (0..choices.len()).map(|i| self.in_members(&choices[..i], &choices[i])).sum()
    }

    /// Evidence of a choice in its own gyros and no others, given `before`. [`Search::scores`] average over all sets of gyros: were
    /// that added up, two names that share the gyros between them would each be credited with the other's. For the same reason each
    /// gyro's noise is its own here: what is taken out of one must not make another's evidence stronger.
    fn in_members(&self, before: &[Choice], choice: &Choice) -> f64 {
        let Some((_, range)) = self.bank.kinds.iter().find(|(kind, _)| *kind == choice.kind) else { return 0.0 };
        let hypotheses = &self.bank.hypotheses[range.clone()];
        let state = each_by_itself(self.frame, self.extras(before));
        let products = Products::of_some(self.bank, hypotheses, &state);
        let seen = products.seen(&state);
        let mut total = LogSum::default();
        for hypothesis in hypotheses {
            total.add(log_bayes_in(hypothesis, &choice.members, &seen));
        }
        total.log() + if matches!(choice.kind, Kind::Competitor(_)) { SUSPECT_ODDS } else { 0.0 }
    }
}
