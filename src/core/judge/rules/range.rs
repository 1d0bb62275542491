//! `range`: max - min over the records of the last days against the budget.

use super::Case;
use crate::core::judge::decide::range_beyond;
use crate::core::judge::{Finding, Rule, Verdict};

/// The value is max - min over the records of `range_days` up to the judged one, at least `range_min_records`.
///
/// `confirmed` when no single record is to blame: leave out the highest or the lowest, and what remains still exceeds.
pub(crate) fn range(case: &Case<'_>, limit: f64) -> Verdict {
    let (samples, now) = (case.since_reset(Rule::Range), case.now().at);
    let window = &samples[samples.partition_point(|sample| now.days_since(sample.at) > case.limits.range_days)..];
    let need = case.limits.range_min_records.max(2);
    if window.len() < need {
        return case.too_few(Rule::Range, limit, window.len(), need);
    }
    let extremes = Extremes::of(window.iter().map(|sample| case.value(sample).value));
    let (lowest, highest) = (&window[extremes.lowest], &window[extremes.highest]);
    let difference = case.value(highest).minus(case.value(lowest));
    let outcome = range_beyond(difference, window.len(), limit, case.limits.confidence);
    let finding = Finding::Range {
        records: window.len(),
        days: case.limits.range_days,
        lowest: (lowest.at, case.value(lowest).value),
        highest: (highest.at, case.value(highest).value),
    };
    case.verdict(Rule::Range, limit, difference, outcome, finding).confirmed_if(extremes.range_without_one > limit)
}

/// Indices of the extremes, and the smaller of the two ranges that remain when one of them is left out.
pub(super) struct Extremes {
    pub lowest: usize,
    pub highest: usize,
    pub range_without_one: f64,
}

impl Extremes {
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let ([mut min, mut second_min], [mut max, mut second_max]) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let (mut lowest, mut highest) = (0, 0);
        for (i, x) in values.enumerate() {
            if x < min {
                (min, second_min, lowest) = (x, min, i);
            } else {
                second_min = second_min.min(x);
            }
            if x > max {
                (max, second_max, highest) = (x, max, i);
            } else {
                second_max = second_max.max(x);
            }
        }
        Self { lowest, highest, range_without_one: (max - second_min).min(second_max - min) }
    }
}
