//! `baseline`: |x_k - baseline| against the budget.

use super::too_few;
use crate::core::judge::decide::beyond;
use crate::core::judge::history::{BASELINE_RECORDS, History, Measured, Sample};
use crate::core::judge::{Coefficient, Finding, Limits, Rule, State, Verdict};

/// The value is |x_k - b|, b the mean of the first [`BASELINE_RECORDS`] records since the last baseline mark, or a
/// fixed one. The baseline's own records are not judged by it.
///
/// `confirmed` when the record before (since the mark) lay beyond the limit on the same side.
pub(crate) fn baseline(
    history: &History<'_>,
    k: usize,
    coefficient: Coefficient,
    limit: f64,
    fixed: Option<Measured>,
    limits: &Limits,
) -> Verdict {
    let column = coefficient.column().expect("baselines are judged on coefficients that have a history");
    let first = history.baseline_before(k);
    if fixed.is_none() && first.len() < BASELINE_RECORDS {
        return too_few(Rule::Baseline, coefficient, limit, first.len(), BASELINE_RECORDS);
    }
    let level = fixed.unwrap_or_else(|| Measured::mean(first.iter().map(|sample| sample.d[column])));
    let deviation = |sample: &Sample| sample.d[column].minus(level);
    let now = deviation(&history.samples[k]);
    let (state, probability) = beyond(now, limit, limits.confidence);
    let before = history.since_reset(k, Rule::Baseline).iter().rev().nth(1);
    let confirmed = state == State::Exceeded
        && before.filter(|sample| fixed.is_some() || first.iter().all(|b| b.at != sample.at)).is_some_and(|sample| {
            let before = deviation(sample);
            before.value.is_sign_positive() == now.value.is_sign_positive()
                && beyond(before, limit, limits.confidence).0 == State::Exceeded
        });
    Verdict {
        coefficient,
        rule: Rule::Baseline,
        state,
        value: Some(now.value.abs()),
        limit,
        sd: now.sd,
        probability,
        confirmed,
        finding: Finding::Baseline {
            level: level.value,
            since: fixed.is_none().then(|| first[0].at),
            now: history.samples[k].d[column].value,
        },
    }
}
