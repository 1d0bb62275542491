//! What is known of causes before the outputs speak: how large each may be, and that temperature is suspected first
//! where it moved; and what is asked of a name once they have spoken.

use crate::core::diagnose::report::held_out;
use crate::core::diagnose::residuals::augmented_fit;
use crate::core::diagnose::residuals::augmented_fit::Part;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::bayes_factor::Score;
use crate::core::diagnose::search::choice::Choice;
use crate::core::diagnose::search::stepwise::Search;
use crate::core::diagnose::search::temperature_odds::odds_of_temperature;
use crate::core::effects::Effect;

/// ln of evidence from which on an effect is asked whether its size is plausible.
const LEAST_ASKED: f64 = 1.0;

impl Search<'_> {
    /// Rules out what is implausibly large, and gives temperature its odds. Sizes are those of white noise, and so is
    /// the evidence `white` from which on they are asked for.
    pub(crate) fn weigh(&self, choices: &[Choice], scores: &mut [Score], white: &[f64]) {
        let odds = odds_of_temperature(&self.frame.setting);
        for (score, white) in scores.iter_mut().zip(white) {
            // Odds among causes, not against noise.
            if score.log_evidence > self.threshold.alone && score.kind.entry().of_temperature {
                score.log_evidence += odds;
            }
            if score.log_evidence.max(*white) > LEAST_ASKED && self.is_implausible(choices, score) {
                score.log_evidence = f64::NEG_INFINITY;
            }
        }
    }

    /// The choices: dwells set aside, for what they close is no other's; those of temperature where it has odds; the
    /// others.
    pub(crate) fn most_plausible_first(&self, mut choices: Vec<Choice>) -> Vec<Choice> {
        let odds = odds_of_temperature(&self.frame.setting);
        choices.sort_by_key(|choice| {
            let entry = choice.kind.entry();
            (!entry.is_one_dwell(), !(odds > 0.0 && entry.of_temperature))
        });
        choices
    }

    /// Evidence without the odds that temperature has among causes.
    pub(crate) fn against_noise(&self, kind: Effect, evidence: f64) -> f64 {
        let odds = if kind.entry().of_temperature { odds_of_temperature(&self.frame.setting) } else { 0.0 };
        if evidence > self.threshold.alone + odds { evidence - odds } else { evidence }
    }

    /// Whether what the outputs ask of an effect is more than a gyro of this kind has, beyond its own uncertainty.
    fn is_implausible(&self, choices: &[Choice], score: &Score) -> bool {
        let Some(part) = self.part(&self.choice(score)) else { return false };
        let most = self.frame.plausible_sizes.of(part.effect);
        let mut parts: Vec<Part> = choices.iter().filter_map(|choice| self.part(choice)).collect();
        parts.push(part);
        let fit = augmented_fit::fit(self.frame, &parts);
        let own = fit.fitted.iter().filter(|f| f.part == parts.len() - 1);
        own.into_iter().any(|f| f.value.abs() - 2.0 * f.sd > most)
    }
}

/// Which parts, in their order, shrink the gap on dwells that were held out. One dwell set aside is not asked: it
/// says nothing of others.
pub(crate) fn closing(frame: &Frame, parts: &[Part]) -> Vec<bool> {
    let variances = augmented_fit::fit(frame, parts).variances;
    let closes = |p: usize| {
        let earlier: Vec<&Part> = parts[..p].iter().collect();
        let errors = held_out::errors(frame, &earlier, &[&parts[p]], &variances, false);
        parts[p].dwell().is_some() || errors.with < errors.without
    };
    (0..parts.len()).map(closes).collect()
}
