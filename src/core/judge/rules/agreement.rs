//! `agreement`: the range over the methods that measured a gyro (the paper's Table 5) against its limit.

use crate::core::bench::BenchMethod;
use crate::core::judge::decide::range_beyond;
use crate::core::judge::extremes::Extremes;
use crate::core::judge::history::Measured;
use crate::core::judge::{Coefficient, Finding, Rule, State, Verdict};
use crate::core::time::UtcMicros;

/// Where a figure comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Source {
    /// Separated from a calibration of the IMU.
    Separation,
    Bench(BenchMethod),
}

impl Source {
    pub fn name(self) -> &'static str {
        match self {
            Source::Separation => "separation",
            Source::Bench(method) => method.name(),
        }
    }
}

/// One figure of one gyro by one method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SourcedResult {
    pub source: Source,
    pub at: UtcMicros,
    pub measured: Measured,
}

/// The value is max - min over `results`: those that are to agree, which the caller chooses (of one coefficient, since
/// the last repair, no farther apart in time than the gyro is expected to hold still: `within_days`, where it was so many).
///
/// `confirmed` when no single result is to blame: leave out the highest or the lowest, and the rest still disagree.
pub fn agreement(
    coefficient: Coefficient,
    results: &[SourcedResult],
    within_days: Option<f64>,
    limit: f64,
    confidence: f64,
) -> Verdict {
    let extremes = Extremes::of(results.iter().map(|result| (result, result.measured.value)));
    let (value, sd, state, probability, confirmed, finding) = if let [_, _, ..] = results
        && let Some((lowest, highest)) = extremes.lowest.zip(extremes.highest)
    {
        let range = highest.measured.minus(lowest.measured);
        let outcome = range_beyond(range, results.len(), limit, confidence);
        let of = |result: &SourcedResult| (result.source, result.at, result.measured.value);
        let finding = Finding::Agreement { results: results.len(), lowest: of(lowest), highest: of(highest) };
        let confirmed = extremes.range_without_one() > limit;
        (Some(range.value), range.sd, outcome.state, outcome.probability, confirmed, finding)
    } else {
        let (have, need) = (results.len(), 2);
        let finding = match within_days {
            Some(days) => Finding::FewWithin { have, need, days },
            None => Finding::TooFew { have, need },
        };
        (None, None, State::Indeterminate, None, false, finding)
    };
    Verdict { coefficient, rule: Rule::Agreement, state, value, limit, sd, probability, confirmed, finding }
}
