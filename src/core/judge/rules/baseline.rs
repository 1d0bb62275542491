//! `baseline`: |x_k - baseline| against the budget.

use super::Case;
use crate::core::judge::{BASELINE_RECORDS, Finding, Limit, Measured, Rule, Sample, Verdict, stated_level};
use crate::core::time::UtcMicros;

/// Records since the last mark that it takes until one is judged: those that make the level, and the judged one.
pub(super) const LEVEL_RECORDS: usize = BASELINE_RECORDS + 1;

/// The level that a record is measured from.
pub(super) struct BaselineLevel {
    pub level: Measured,
    /// First of the records that make it; none where it is fixed.
    pub since: Option<UtcMicros>,
    /// The records that make it; none where it is fixed.
    pub records: Option<[Sample; BASELINE_RECORDS]>,
}

impl BaselineLevel {
    /// The level that the last baseline mark states, or else the configured one, or the median of `first`, the first
    /// [`BASELINE_RECORDS`] records that count; an error with the number of records since then, the judged one among
    /// them, where those are not complete before it.
    pub fn of(case: &Case<'_>, fixed: Option<Measured>, first: &[Sample]) -> Result<Self, usize> {
        let now = case.now().at;
        let stated = stated_level(case.history.marks(), now, case.column);
        if let Some(level) = stated.or(fixed) {
            return Ok(Self { level, since: None, records: None });
        }
        let before = &first[..first.partition_point(|sample| sample.at < now)];
        let values: Vec<Measured> = before.iter().map(|sample| case.value(sample)).collect();
        match (<[Sample; BASELINE_RECORDS]>::try_from(before), Measured::median(&values)) {
            (Ok(records), Some(level)) => Ok(Self { level, since: Some(records[0].at), records: Some(records) }),
            _ => Err(before.len() + 1),
        }
    }

    /// And what stations bring into its standard deviation.
    pub fn deviation(&self, case: &Case<'_>, sample: &Sample) -> (Measured, Option<f64>) {
        case.apart(case.value(sample).minus(self.level), sample, self.records.as_ref().map_or(&[][..], |all| all))
    }

    /// Whether the record before the judged one lay beyond the limit on the same side too, and is none of the
    /// baseline's own.
    pub fn confirmed(&self, case: &Case<'_>, rule: Rule, limit: f64) -> bool {
        let [.., previous, _] = case.since_reset(rule) else { return false };
        let is_own = self.records.is_some_and(|records| records.iter().any(|own| own.at == previous.at));
        !is_own && case.both_exceed(self.deviation(case, previous).0, self.deviation(case, case.now()).0, limit)
    }
}

/// The value is |x_k - b|, b the median of the first [`BASELINE_RECORDS`] records since the last baseline mark, or a
/// fixed one. The baseline's own records are not judged by it.
///
/// `confirmed` when the record before (since the mark) lay beyond the limit on the same side.
pub(crate) fn baseline(case: &Case<'_>, limit: Limit, fixed: Option<Measured>) -> Verdict {
    let level = match BaselineLevel::of(case, fixed, case.history.baseline) {
        Ok(level) => level,
        Err(have) => return case.too_few(Rule::Baseline, limit, have, LEVEL_RECORDS),
    };
    let (deviation, between) = level.deviation(case, case.now());
    let finding = Finding::Baseline { level: level.level.value, since: level.since, now: case.value(case.now()).value };
    case.verdict(Rule::Baseline, limit, deviation, case.beyond(deviation, limit.value), finding)
        .between_stations(between)
        .confirmed_if(level.confirmed(case, Rule::Baseline, limit.value))
}
