//! `range`: max - min over the records of the last days against the budget.

use super::{Case, Sample};
use crate::core::judge::decide::range_beyond;
use crate::core::judge::{Finding, Older, Rule, Verdict};

/// The value is max - min over the records of `range_days` up to the judged one, at least `range_min_records`.
///
/// `confirmed` when no single record is to blame: leave out the highest or the lowest, and what remains still exceeds.
pub(crate) fn range(case: &Case<'_>, limit: f64) -> Verdict {
    let (samples, now) = (&case.history.samples[..=case.k], case.now().at);
    let first = case.history.first_since_reset(case.k, Rule::Range);
    let too_old = |sample: &Sample| now.days_since(sample.at) > case.limits.range_days;
    let start = first + samples[first..].partition_point(too_old);
    let older = if start == 0 { case.history.older } else { Older::NONE };
    let records = older.records + samples.len() - start;
    let need = case.limits.range_min_records.max(2);
    let here = case.history.samples.extremes(case.column, start..case.k + 1);
    let extremes = older.extremes[case.column].and(here.at(|place| (samples[place].at, case.value(&samples[place]))));
    let (true, Some(lowest), Some(highest)) = (records >= need, extremes.lowest, extremes.highest) else {
        return case.too_few(Rule::Range, limit, records, need);
    };
    let difference = highest.1.minus(lowest.1);
    let outcome = range_beyond(difference, records, limit, case.limits.confidence);
    let finding = Finding::Range {
        records,
        days: case.limits.range_days,
        lowest: (lowest.0, lowest.1.value),
        highest: (highest.0, highest.1.value),
    };
    case.verdict(Rule::Range, limit, difference, outcome, finding).confirmed_if(extremes.range_without_one() > limit)
}
