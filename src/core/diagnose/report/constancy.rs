//! Whether a name is true all the time.
//!
//! The drift d that was fitted for a named effect is tried with another size after an instant: the column d H(t - t_0),
//! off everything that is fitted, against the rest of the residual (F). Instants are the quarters of the effect's own
//! information, half time, and pauses; a warm-up may come again at any time, in any size. Sizes on either side then say
//! in which part it acts.

use super::named::Named;
use super::remaining::FittedResiduals;
use crate::core::diagnose::residuals::augmented_fit::Fit;
use crate::core::effects::Shape;
use crate::core::numerics::basis::dot;

/// Probability below which a name is not constant, over all that is tried; and for effects so strong that what their
/// shape misses would show.
const LEVEL: f64 = 0.02;
const LEVEL_OF_STRONG: f64 = 0.005;
const STRONG: f64 = 50.0;

/// Share of the tests that count as independent: neighbouring instants tell nearly the same.
const INDEPENDENT: f64 = 0.6;

/// Standard deviations within which a size is none, and beyond which the other is one.
const NONE: f64 = 2.0;
const SOME: f64 = 4.0;

/// Instants at which a warm-up is tried to come again.
const RESTARTS: usize = 12;

/// A change of a named effect.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Change {
    /// Among the names.
    pub named: usize,
    pub gyro: usize,
    /// Over all that was tried.
    pub p_value: f64,
    /// From when to when it acts, s after the first dwell, where the sizes on either side say so.
    pub acts_in: Option<[f64; 2]>,
}

/// Names that are not constant, the least probable change of each.
pub(crate) fn changes(left: &FittedResiduals, named: &[Named], fit: &Fit, detectability: f64) -> Vec<Change> {
    let mut all: Vec<Change> = Vec::new();
    for (p, name) in named.iter().enumerate().filter(|(_, n)| n.part.dwell().is_none()) {
        for j in (0..name.part.members.len()).filter(|&j| name.part.members[j]) {
            let drift = fit.drift_of((p, &name.part), &left.frame.setting, j);
            let tried = of_gyro(left, j, drift, name.part.shape);
            all.extend(tried.map(|(p_value, acts_in)| Change { named: p, gyro: j, p_value, acts_in }));
        }
    }
    let count = (all.len() as f64 * INDEPENDENT).max(1.0);
    let level = if detectability > STRONG { LEVEL_OF_STRONG } else { LEVEL };
    let mut changes: Vec<Change> = Vec::new();
    all.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    for one in all {
        let p_value = (one.p_value * count).min(1.0);
        if p_value < level && !changes.iter().any(|change| change.named == one.named) {
            changes.push(Change { p_value, ..one });
        }
    }
    changes
}

/// Every change of a drift of gyro `j` that is tried: its probability, and the part in which it would act.
fn of_gyro(
    left: &FittedResiduals,
    j: usize,
    drift: Vec<f64>,
    shape: Shape,
) -> impl Iterator<Item = (f64, Option<[f64; 2]>)> {
    let s = &left.frame.setting;
    let n = s.dwells();
    // Off the model alone: what the other names leave of it is the effect's own.
    let mut own = left.frame.gyros[j].whiten(drift.clone());
    left.frame.gyros[j].basis.project_out(&mut own);
    let total = dot(&own, &own);
    let mut firsts: Vec<usize> = Vec::new();
    let mut sum = 0.0;
    for (k, x) in own.iter().enumerate() {
        let before = sum;
        sum += x * x;
        let quarters = [0.25, 0.5, 0.75].map(|share| share * total);
        firsts.extend(quarters.iter().filter(|q| before < **q && **q <= sum).map(|_| k + 1));
    }
    firsts.extend((1..n).find(|&k| s.elapsed(k) > 0.5 * s.span()));
    firsts.extend(s.pauses());
    firsts.sort_unstable();
    firsts.dedup();
    let onset = match shape {
        Shape::Instant(instant) => (0..n).find(|&k| s.time[k] > instant),
        _ => None,
    };
    let after = |first: usize, of: &dyn Fn(usize) -> f64| s.column(|k| if k < first { 0.0 } else { of(k) });
    let decay = |first: usize, tau: f64| move |k: usize| (-(s.time[k] - s.time[first]) / tau).exp();
    // A step that settles: more or less at first.
    let settling = onset.into_iter().flat_map(|first| {
        [0.04, 0.1].map(|share| {
            let decay = decay(first, share * s.span());
            after(first, &|k| drift[k] * decay(k))
        })
    });
    // A warm-up that comes again.
    let again = (1..=RESTARTS).filter_map(|i| match shape {
        Shape::Tau(tau) => {
            let first = (i * n / (RESTARTS + 1)).max(1);
            Some(after(first, &decay(first, tau)))
        }
        _ => None,
    });
    let switched = firsts.into_iter().filter(|&first| first < n && onset.is_none_or(|onset| first > onset + 1));
    let mut tried = Vec::new();
    for first in switched {
        let column = left.frame.gyros[j].whiten(after(first, &|k| drift[k]));
        let acts_in = part(left, j, &drift, first);
        if let Some(tested) = left.of_form("not_constant", j, vec![column]) {
            tried.push((tested.p_value, acts_in));
        }
    }
    for column in settling.chain(again) {
        let column = left.frame.gyros[j].whiten(column);
        tried.extend(left.of_form("not_constant", j, vec![column]).map(|tested| (tested.p_value, None)));
    }
    tried.into_iter()
}

/// From when to when a drift acts where its size changes with dwell `first`: sizes before and after by least squares,
/// in units of what was fitted.
fn part(left: &FittedResiduals, j: usize, drift: &[f64], first: usize) -> Option<[f64; 2]> {
    let (gyro, s) = (&left.frame.gyros[j], &left.frame.setting);
    let n = drift.len();
    let off_model = |from: usize, to: usize| {
        let mut column: Vec<f64> = (0..n).map(|k| if (from..to).contains(&k) { drift[k] } else { 0.0 }).collect();
        column = gyro.whiten(column);
        gyro.basis.project_out(&mut column);
        column
    };
    let (before, after) = (off_model(0, first), off_model(first, n));
    let (bb, ba, aa) = (dot(&before, &before), dot(&before, &after), dot(&after, &after));
    let det = bb * aa - ba * ba;
    let (br, ar) = (dot(&before, &left.residuals[j]), dot(&after, &left.residuals[j]));
    let sizes = [1.0 + (br * aa - ar * ba) / det, 1.0 + (ar * bb - br * ba) / det];
    let sds = [(aa / det).sqrt(), (bb / det).sqrt()];
    let over = |i: usize| (sizes[i] / sds[i]).abs();
    let at = 0.5 * (s.elapsed(first - 1) + s.elapsed(first));
    match (over(0), over(1)) {
        (before, after) if before < NONE && after > SOME => Some([at, s.span()]),
        (before, after) if after < NONE && before > SOME => Some([0.0, at]),
        _ => None,
    }
}
