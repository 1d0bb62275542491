//! `agreement`: the range over the methods that measured a gyro (the paper's Table 5) against its limit.

use crate::core::judge::decide::widest;
use crate::core::judge::{Coefficient, FigureSource, Finding, Limit, Measured, Rule, Verdict};
use crate::core::time::UtcMicros;

/// One figure of one gyro by one method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SourcedResult {
    pub source: FigureSource,
    pub at: UtcMicros,
    pub measured: Measured,
}

/// The value is max - min over `results`: those that are to agree, which the caller chooses (of one coefficient,
/// since the last repair, no farther apart in time than the gyro is expected to hold still: `within_days`, where it
/// was so many). Of several pairs, that one which exceeds with the largest probability.
///
/// `confirmed` when no single result is to blame: leave out the highest or the lowest, and the rest still disagree.
pub fn agreement(
    coefficient: Coefficient,
    results: &[SourcedResult],
    within_days: Option<f64>,
    limit: Limit,
    confidence: f64,
) -> Verdict {
    let figures: Vec<(&SourcedResult, Measured)> = results.iter().map(|result| (result, result.measured)).collect();
    let verdict = |finding| Verdict::undecided(coefficient, Rule::Agreement, limit, finding);
    let too_few = match within_days {
        Some(days) => Finding::FewWithin { have: results.len(), need: 2, days },
        None => Finding::TooFew { have: results.len(), need: 2 },
    };
    let Some((pair, without_one)) = widest(&figures, |_, _| 0.0, limit.value) else { return verdict(too_few) };
    let outcome = pair.outcome(results.len(), limit.value, confidence);
    let of = |(result, measured): (&SourcedResult, Measured)| (result.source, result.at, measured.value);
    let finding = Finding::Agreement { results: results.len(), lowest: of(pair.low), highest: of(pair.high) };
    outcome.of(pair.difference(), verdict(finding)).confirmed_if(without_one > limit.value)
}
