//! `step`: |x_k - x_(k-1)| against the budget.

use super::too_few;
use crate::core::judge::decide::beyond;
use crate::core::judge::history::{History, Measured};
use crate::core::judge::{Coefficient, Finding, Limits, Rule, State, Verdict};

/// The value is |x_k - x_(k-1)|, over records since the last repair.
///
/// A step is one campaign's word. `confirmed` is set on the *next* record, when that still lies beyond the limit, on
/// the same side, from the record before the step: whatever its own state, it says that the gyro has moved.
pub(crate) fn step(history: &History<'_>, k: usize, coefficient: Coefficient, limit: f64, limits: &Limits) -> Verdict {
    let samples = history.since_reset(k, Rule::Step);
    let at =
        |back: usize| samples.len().checked_sub(back + 1).map(|i| (samples[i].at, samples[i].d[column(coefficient)]));
    let (Some((_, now)), Some((since, before))) = (at(0), at(1)) else {
        return too_few(Rule::Step, coefficient, limit, samples.len(), 2);
    };
    let difference = now.minus(before);
    let (state, probability) = beyond(difference, limit, limits.confidence);
    let level_before = at(2).filter(|(_, level)| {
        let earlier_step = before.minus(*level);
        exceeds(earlier_step, limit, limits) && same_side(earlier_step, now.minus(*level), limit, limits)
    });
    Verdict {
        coefficient,
        rule: Rule::Step,
        state,
        value: Some(difference.value.abs()),
        limit,
        sd: difference.sd,
        probability,
        confirmed: level_before.is_some(),
        finding: Finding::Step {
            since,
            before: before.value,
            now: now.value,
            confirms: level_before.map(|(at, level)| (at, level.value)),
        },
    }
}

fn column(coefficient: Coefficient) -> usize {
    coefficient.column().expect("steps are judged on coefficients that have a history")
}

fn exceeds(difference: Measured, limit: f64, limits: &Limits) -> bool {
    beyond(difference, limit, limits.confidence).0 == State::Exceeded
}

fn same_side(earlier: Measured, now: Measured, limit: f64, limits: &Limits) -> bool {
    exceeds(now, limit, limits) && earlier.value.is_sign_positive() == now.value.is_sign_positive()
}
