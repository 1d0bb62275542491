//! `before_after`: the last record before an environmental test against those after it.

use super::Case;
use crate::core::judge::limits::{AFTER, BEFORE_AFTER_RECORDS, Limit};
use crate::core::judge::{Event, Finding, Mark, Rule, Sample, Verdict};

/// The value is |x_k - last record before the test|, for the first record after the last environmental test. Where
/// that one is beyond the limit, the next ones are judged too, until one is within it: `confirmed` when the record
/// before exceeded too, on the same side. None where there is no test to judge, no record before it, or a reset
/// between.
///
/// A record made during the test has no part in it.
pub(crate) fn before_after(case: &Case<'_>, limit: Limit) -> Option<Verdict> {
    let samples = case.since_reset(Rule::BeforeAfter);
    let now = case.now().at;
    let end = |mark: &Mark| mark.until.map_or(mark.at, |until| until.max(mark.at));
    let over = |mark: &&Mark| mark.event == Event::EnvironmentalTest && end(mark) <= now;
    let test = case.history.marks().iter().filter(over).max_by_key(|mark| end(mark))?;
    let samples = &samples[samples.len().saturating_sub(BEFORE_AFTER_RECORDS)..];
    let before = samples[..samples.partition_point(|sample| sample.at < test.at)].last()?;
    let after = &samples[samples.partition_point(|sample| sample.at < end(test))..];
    let (_, earlier) = after.split_last()?;
    let difference = |sample: &Sample| {
        case.apart(case.value(sample).minus(case.value(before)), sample, std::slice::from_ref(before))
    };
    if after.len() > AFTER || !earlier.iter().all(|sample| case.exceeds(difference(sample).0, limit.value)) {
        return None;
    }
    let (own, between) = difference(case.now());
    let confirmed = earlier.last().is_some_and(|last| case.both_exceed(difference(last).0, own, limit.value));
    let finding = Finding::BeforeAfter {
        before: (before.at, case.value(before).value),
        from: test.at,
        until: end(test),
        now: case.value(case.now()).value,
    };
    let outcome = case.beyond(own, limit.value);
    let verdict = case.verdict(Rule::BeforeAfter, limit, own, outcome, finding);
    Some(verdict.between_stations(between).confirmed_if(confirmed))
}
