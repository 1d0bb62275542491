//! `shift`: a lasting change of level too small for `step`: the newest three weeks with records against those before.

use super::Case;
use crate::core::judge::cells::CELLS;
use crate::core::judge::decide::Conformity;
use crate::core::judge::noise::ScatterPrior;
use crate::core::judge::{Finding, Limit, Measured, Rule, ShiftLimits, State, Verdict};
use crate::core::numerics::median::median;
use crate::core::numerics::normal::SD_OF_MEDIAN;

/// Cells (weekly means) that there must be before the rule says anything.
pub const SHIFT_MIN_CELLS: usize = 8;
/// Newest cells whose median is the level now.
const NEWEST: usize = 3;
/// Standard deviations that a departure must have: once in some 300 records of an unmoved coefficient, whatever phi is.
const STANDARD_DEVIATIONS: f64 = 3.0;
/// Deviations from the median count for no more than so many scatters.
const CLIPPED_AT: f64 = 3.0;

/// The value is |median of the newest three cells - level of up to 37 cells before|, a cell being the mean of one
/// week's records. The limit is `limits.least`, or three standard deviations of the value where those are more: what
/// does not matter raises no alarm.
///
/// Scatter comes from the cells before (clipped at three robust scatters, so that single outliers have no part),
/// drawn towards a tenth of the budget with the weight of five cells, and no smaller than a twentieth of it;
/// correlation and walk are the fleet's ([`crate::core::judge::NoiseParameters`]), and so is what stations differ by,
/// where the cells are of several. `confirmed` is never set: three campaigns have spoken already.
pub(crate) fn shift(case: &Case<'_>, limits: &ShiftLimits) -> Verdict {
    let points = case.points();
    if points.len() < SHIFT_MIN_CELLS {
        return case.too_few(Rule::Shift, limits.least, points.len(), SHIFT_MIN_CELLS);
    }
    let (noise, budget, n) = (&case.limits.noise, limits.budget, points.len());
    let prior = ScatterPrior::of(budget, points.iter().map(|point| point.sd));
    let k = n - NEWEST;
    let mut x = [0.0; CELLS];
    x.iter_mut().zip(points).for_each(|(x, point)| *x = point.x);
    let (before, newest) = x[..n].split_at(k);
    let mut sorted = [0.0; CELLS];
    let mut middle = |values: &[f64]| {
        sorted[..values.len()].copy_from_slice(values);
        median(&mut sorted[..values.len()]).unwrap_or(0.0)
    };
    let (center, now) = (middle(before), middle(newest));
    let mut off = [0.0; CELLS];
    off.iter_mut().zip(before).for_each(|(off, x)| *off = (x - center).abs());
    let clip = CLIPPED_AT * (SD_OF_MEDIAN * middle(&off[..k])).max(prior.least);
    let clipped = |x: &f64| (x - center).clamp(-clip, clip);
    let mean = before.iter().map(clipped).sum::<f64>() / k as f64;
    let squares = before.iter().map(|x| (clipped(x) - mean).powi(2)).sum::<f64>();
    let variance = prior.variance(squares, k as f64 - noise.inflation(k));
    let mut weights = [0.0; CELLS];
    weights[..k].fill(-1.0 / k as f64);
    weights[k..n].fill(1.0 / NEWEST as f64);
    let weights = &weights[..n];
    let scatter = noise.of_scatter(weights, weights) + noise.median_excess();
    let between = case.of_stations(points.iter().map(|point| point.station).zip(weights.iter().copied()));
    let sd =
        (variance * scatter + noise.of_walk(|i| points[i].t, weights, weights)).sqrt().hypot(between.unwrap_or(0.0));
    let level = center + mean;
    let departure = Measured { value: now - level, sd: Some(sd) };
    let limit = Limit { value: limits.least.value.max(STANDARD_DEVIATIONS * sd), ..limits.least };
    let mut outcome = Conformity::certain(departure.value.abs() > limit.value);
    if outcome.state == State::Within && limit.value > budget {
        // Noise so large that not even a change by the whole budget would show.
        outcome.state = State::Indeterminate;
    }
    let finding = Finding::Shift {
        level,
        before: k,
        since: points[k].first,
        now,
        scatter: variance.sqrt(),
        least: limits.least.value,
    };
    case.verdict(Rule::Shift, limit, departure, outcome, finding).between_stations(between)
}
