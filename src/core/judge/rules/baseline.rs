//! `baseline`: |x_k - baseline| against the budget.

use super::Case;
use crate::core::judge::history::{BASELINE_RECORDS, Measured, Sample, stated_level};
use crate::core::judge::{Finding, Rule, Verdict};
use crate::core::time::UtcMicros;

/// Records since the last mark that it takes until one is judged: those that make the level, and the judged one.
pub(super) const LEVEL_RECORDS: usize = BASELINE_RECORDS + 1;

/// The level that a record is measured from.
pub(super) struct Level {
    pub level: Measured,
    /// First of the records that make it; none where it is fixed.
    pub since: Option<UtcMicros>,
    /// Last of the records that make it.
    until: Option<UtcMicros>,
}

impl Level {
    /// The level that the last baseline mark states, or else the configured one, or the mean of the first [`BASELINE_RECORDS`] records since the last baseline mark; an error
    /// with the number of records since then, the judged one among them, where those are not complete before it.
    pub fn of(case: &Case<'_>, fixed: Option<Measured>) -> Result<Self, usize> {
        let stated = stated_level(case.history.marks, case.now().at, case.column);
        if let Some(level) = stated.or(fixed) {
            return Ok(Self { level, since: None, until: None });
        }
        let first = case.history.baseline_before(case.k);
        let [begin, .., end] = first else { return Err(first.len() + 1) };
        if first.len() < BASELINE_RECORDS {
            return Err(first.len() + 1);
        }
        let level = Measured::mean(first.iter().map(|sample| case.value(sample)));
        Ok(Self { level, since: Some(begin.at), until: Some(end.at) })
    }

    pub fn deviation(&self, case: &Case<'_>, sample: &Sample) -> Measured {
        case.value(sample).minus(self.level)
    }

    /// Whether the record before the judged one lay beyond the limit on the same side too.
    pub fn confirmed(&self, case: &Case<'_>, rule: Rule, limit: f64) -> bool {
        let previous = case.since_reset(rule).iter().rev().nth(1);
        previous.filter(|sample| self.until.is_none_or(|until| sample.at > until)).is_some_and(|sample| {
            case.both_exceed(self.deviation(case, sample), self.deviation(case, case.now()), limit)
        })
    }
}

/// The value is |x_k - b|, b the mean of the first [`BASELINE_RECORDS`] records since the last baseline mark, or a
/// fixed one. The baseline's own records are not judged by it.
///
/// `confirmed` when the record before (since the mark) lay beyond the limit on the same side.
pub(crate) fn baseline(case: &Case<'_>, limit: f64, fixed: Option<Measured>) -> Verdict {
    let level = match Level::of(case, fixed) {
        Ok(level) => level,
        Err(have) => return case.too_few(Rule::Baseline, limit, have, LEVEL_RECORDS),
    };
    let deviation = level.deviation(case, case.now());
    let finding = Finding::Baseline { level: level.level.value, since: level.since, now: case.value(case.now()).value };
    case.verdict(Rule::Baseline, limit, deviation, case.beyond(deviation, limit), finding)
        .confirmed_if(level.confirmed(case, Rule::Baseline, limit))
}
