//! `range`: max - min over the records of the last days against the budget.

use super::too_few;
use crate::core::judge::decide::beyond;
use crate::core::judge::history::{History, Sample};
use crate::core::judge::{Coefficient, Finding, Limits, Rule, Verdict};

/// The value is max - min over the records of `limits.range_days` up to the judged one, at least
/// `limits.range_min_records` of them.
///
/// `confirmed` when no single record is to blame: leave out the highest or the lowest, and what remains still exceeds.
pub(crate) fn range(history: &History<'_>, k: usize, coefficient: Coefficient, limit: f64, limits: &Limits) -> Verdict {
    let samples = history.since_reset(k, Rule::Range);
    let now = history.samples[k].at;
    let window = &samples[samples.partition_point(|sample| now.days_since(sample.at) > limits.range_days)..];
    if window.len() < limits.range_min_records.max(2) {
        return too_few(Rule::Range, coefficient, limit, window.len(), limits.range_min_records.max(2));
    }
    let column = coefficient.column().expect("ranges are judged on coefficients that have a history");
    let extremes = Extremes::of(window, column);
    let (lowest, highest) = (&window[extremes.lowest], &window[extremes.highest]);
    let difference = highest.d[column].minus(lowest.d[column]);
    let (state, probability) = beyond(difference, limit, limits.confidence);
    Verdict {
        coefficient,
        rule: Rule::Range,
        state,
        value: Some(difference.value),
        limit,
        sd: difference.sd,
        probability,
        confirmed: extremes.range_without_one > limit,
        finding: Finding::Range {
            records: window.len(),
            days: limits.range_days,
            lowest: (lowest.at, lowest.d[column].value),
            highest: (highest.at, highest.d[column].value),
        },
    }
}

/// Indices of the extremes, and the smaller of the two ranges that remain when one of them is left out.
struct Extremes {
    lowest: usize,
    highest: usize,
    range_without_one: f64,
}

impl Extremes {
    fn of(window: &[Sample], column: usize) -> Self {
        let value = |i: usize| window[i].d[column].value;
        let (mut lowest, mut highest) = (0, 0);
        let (mut second_lowest, mut second_highest) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 1..window.len() {
            if value(i) < value(lowest) {
                second_lowest = value(lowest);
                lowest = i;
            } else {
                second_lowest = second_lowest.min(value(i));
            }
            if value(i) > value(highest) {
                second_highest = value(highest);
                highest = i;
            } else {
                second_highest = second_highest.max(value(i));
            }
        }
        let range_without_one = (value(highest) - second_lowest).min(second_highest - value(lowest));
        Self { lowest, highest, range_without_one }
    }
}
