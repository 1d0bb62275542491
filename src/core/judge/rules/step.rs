//! `step`: the record against the level of the three before it.

use super::Case;
use crate::core::judge::{Finding, Limit, Measured, Rule, Sample, Verdict};

/// Records whose median is the level before.
const BEFORE: usize = 3;

/// The value is |x_k - median(x_(k-1), x_(k-2), x_(k-3))|, over records since the last repair; of two records before,
/// the earlier one is the level.
///
/// `confirmed` when the record before exceeded too, on the same side: two campaigns in a row then differ from the
/// level before both. A single outlier moves no median, so the return from it exceeds nothing.
pub(crate) fn step(case: &Case<'_>, limit: Limit) -> Verdict {
    let samples = case.since_reset(Rule::Step);
    let Some((level, difference, between)) = from_level(case, samples) else {
        return case.too_few(Rule::Step, limit, samples.len(), 2);
    };
    let before = from_level(case, &samples[..samples.len() - 1]);
    let confirmed = before.is_some_and(|(_, before, _)| case.both_exceed(before, difference, limit.value));
    let finding = Finding::Step { level, now: case.value(case.now()).value };
    case.verdict(Rule::Step, limit, difference, case.beyond(difference, limit.value), finding)
        .between_stations(between)
        .confirmed_if(confirmed)
}

/// The level before the last of some records, how far that one is from it, and what stations bring into that.
fn from_level(case: &Case<'_>, samples: &[Sample]) -> Option<(f64, Measured, Option<f64>)> {
    let (now, before) = samples.split_last()?;
    let mut newest = [Measured::exact(0.0); BEFORE];
    let count = before.len().min(BEFORE);
    let before = &before[before.len() - count..];
    for (to, from) in newest.iter_mut().zip(before) {
        *to = case.value(from);
    }
    let level = Measured::median(&newest[..count])?;
    let of_level = if count == BEFORE { before } else { &before[..1] };
    let (difference, between) = case.apart(case.value(now).minus(level), now, of_level);
    Some((level.value, difference, between))
}
