//! `range`: max - min over the records of the last days against the budget.

use super::{Case, Sample};
use crate::core::judge::decide::range_beyond;
use crate::core::judge::{Finding, Rule, Verdict};

/// The value is max - min over the records of `range_days` up to the judged one, at least `range_min_records`.
///
/// `confirmed` when no single record is to blame: leave out the highest or the lowest, and what remains still exceeds.
pub(crate) fn range(case: &Case<'_>, limit: f64) -> Verdict {
    let (samples, now) = (&case.history.samples[..=case.k], case.now().at);
    let first = case.history.first_since_reset(case.k, Rule::Range);
    let too_old = |sample: &Sample| now.days_since(sample.at) > case.limits.range_days;
    let start = first + samples[first..].partition_point(too_old);
    let window = &samples[start..];
    let need = case.limits.range_min_records.max(2);
    if window.len() < need {
        return case.too_few(Rule::Range, limit, window.len(), need);
    }
    let extremes = case.history.samples.extremes(case.column, start..case.k + 1);
    let (lowest, highest) = (&samples[extremes.lowest], &samples[extremes.highest]);
    let difference = case.value(highest).minus(case.value(lowest));
    let outcome = range_beyond(difference, window.len(), limit, case.limits.confidence);
    let finding = Finding::Range {
        records: window.len(),
        days: case.limits.range_days,
        lowest: (lowest.at, case.value(lowest).value),
        highest: (highest.at, case.value(highest).value),
    };
    case.verdict(Rule::Range, limit, difference, outcome, finding).confirmed_if(extremes.range_without_one() > limit)
}
