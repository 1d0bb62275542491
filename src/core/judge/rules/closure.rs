//! `closure`: the closure moved from its baseline: D_O, in which neither D_I nor D_S has a part.

use super::Case;
use super::baseline::{BaselineLevel, LEVEL_RECORDS};
use crate::core::judge::{Coefficient, Finding, Limit, Rule, Verdict};

/// The value is |c_k - median of the first three closures since the last baseline mark, and since the gyro was
/// mounted in its IMU and slot|: the closure is the mounting's, so a move begins a new level by itself.
///
/// A turn of the spin axis about the input axis by psi moves D_O by D_S psi and leaves D_I as it is, so the finding
/// carries D_S: the reason then tells the turn. `confirmed` as for the baseline.
pub(crate) fn closure(case: &Case<'_>, limit: Limit) -> Verdict {
    let first = case.history.seat_baseline;
    let moved = first.first().zip(case.history.baseline.first()).is_some_and(|(here, ever)| here.at != ever.at);
    let level = match BaselineLevel::of(case, None, first) {
        Ok(level) => level,
        Err(have) if moved => {
            let since = first.first().map_or(case.now().at, |first| first.at);
            return case.nothing(Rule::Closure, limit, Finding::Moved { since, have, need: LEVEL_RECORDS });
        }
        Err(have) => return case.too_few(Rule::Closure, limit, have, LEVEL_RECORDS),
    };
    let (deviation, _) = level.deviation(case, case.now());
    let d_s = case.now().get(Coefficient::DS).map_or(0.0, |d_s| d_s.value);
    let finding = Finding::Closure {
        level: level.level.value,
        since: level.since,
        moved,
        now: case.value(case.now()).value,
        d_s: case.limits.closure_is_d_o.then_some(d_s),
    };
    case.verdict(Rule::Closure, limit, deviation, case.beyond(deviation, limit.value), finding)
        .confirmed_if(level.confirmed(case, Rule::Closure, limit.value))
}
