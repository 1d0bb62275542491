//! `closure`: the closure moved from its baseline: D_O, in which neither D_I nor D_S has a part.

use super::Case;
use super::baseline::{LEVEL_RECORDS, Level};
use crate::core::judge::{Coefficient, Finding, Rule, Verdict};

/// The value is |c_k - mean of the first three closures since the last baseline mark|.
///
/// A turn of the spin axis about the input axis by psi moves D_O by D_S psi and leaves D_I as it is, so the finding
/// carries D_S: the reason then tells the turn. `confirmed` as for the baseline.
pub(crate) fn closure(case: &Case<'_>, limit: f64) -> Verdict {
    let level = match Level::of(case, None) {
        Ok(level) => level,
        Err(have) => return case.too_few(Rule::Closure, limit, have, LEVEL_RECORDS),
    };
    let deviation = level.deviation(case, case.now());
    let d_s = case.now().get(Coefficient::DS).map_or(0.0, |d_s| d_s.value);
    let finding = Finding::Closure {
        level: level.level.value,
        since: level.since,
        now: case.value(case.now()).value,
        d_s: case.limits.closure_is_d_o.then_some(d_s),
    };
    case.verdict(Rule::Closure, limit, deviation, case.beyond(deviation, limit), finding).confirmed_if(level.confirmed(
        case,
        Rule::Closure,
        limit,
    ))
}
