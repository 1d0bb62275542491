//! `step`: |x_k - x_(k-1)| against the budget.

use super::Case;
use crate::core::judge::{Finding, Rule, Verdict};

/// The value is |x_k - x_(k-1)|, over records since the last repair.
///
/// A step is one campaign's word. `confirmed` is set on the *next* record, when that still lies beyond the limit, on
/// the same side, from the record before the step: whatever its own state, it says that the gyro has moved.
pub(crate) fn step(case: &Case<'_>, limit: f64) -> Verdict {
    let samples = case.since_reset(Rule::Step);
    let [.., previous, now] = samples else {
        return case.too_few(Rule::Step, limit, samples.len(), 2);
    };
    let (now, before) = (case.value(now), case.value(previous));
    let difference = now.minus(before);
    let level_before = samples.iter().rev().nth(2).filter(|level| {
        let level = case.value(level);
        case.both_exceed(before.minus(level), now.minus(level), limit)
    });
    let finding = Finding::Step {
        since: previous.at,
        before: before.value,
        now: now.value,
        confirms: level_before.map(|level| (level.at, case.value(level).value)),
    };
    case.verdict(Rule::Step, limit, difference, case.beyond(difference, limit), finding)
        .confirmed_if(level_before.is_some())
}
