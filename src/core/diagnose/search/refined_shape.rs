//! Shapes between those of the grid, for effects of which the grid misses what would show.
//!
//! Time constants, periods and directions of a field are tried on a grid. What the nearest of them leaves of an
//! effect is a tenth of it, or half where the design hides a part of the field: nothing at the limit of detection, but
//! from twice that on it passes for an effect of its own, or two neighbours of the grid for a pair.

use std::f64::consts::FRAC_PI_2;

use crate::core::diagnose::residuals::augmented_fit;
use crate::core::diagnose::residuals::augmented_fit::{Fit, Part, with_parts};
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::choice::Choice;
use crate::core::diagnose::search::stepwise::Search;
use crate::core::effects::{Effect, Shape};
use crate::core::numerics::basis::dot;

/// ln of evidence from which on shapes between those of the grid are tried, and ln of likelihood that one must gain.
const CLEAR: f64 = 10.0;
const LEAST_GAIN: f64 = 2.0;

/// The same for instants, of which the grid holds every tenth dwell or so.
const STRONG_INSTANT: f64 = 8.0;

/// ln of likelihood that another instant must gain where the grid shows nothing: among the rates a few dwells may carry
/// all of a change.
const UNSEEN_BY_THE_GRID: f64 = 20.0;

/// Steps of the golden section: the bracket shrinks to a ten-thousandth.
const STEPS: usize = 20;

/// The shapes at which strong entries explain most, each by itself and beside what was found, where they lie off the
/// grid.
pub(crate) fn sharpened(search: &Search, found: &[Choice]) -> Vec<(Effect, Shape)> {
    let mut shapes = Vec::new();
    for score in search.scores(&[]).iter().filter(|score| score.log_evidence > CLEAR) {
        shapes.extend(search.part(&search.choice(score)).and_then(|alone| best(search, &[alone], 0)));
    }
    for score in search.scores(&[]).iter() {
        let least = match score.log_evidence {
            evidence if evidence > STRONG_INSTANT => 0.0,
            _ if found.is_empty() => continue,
            _ => UNSEEN_BY_THE_GRID,
        };
        let alone = search.part(&search.choice(score));
        shapes.extend(alone.and_then(|alone| best_instant(search.frame, &[alone], 0, least)));
    }
    let named: Vec<&Choice> = found.iter().filter(|choice| !choice.is_competitor()).collect();
    let parts: Vec<Part> = named.iter().filter_map(|choice| search.part(choice)).collect();
    // A dwell set aside may be what the nearest instant of the grid leaves of a change.
    let lasting: Vec<Part> = parts.iter().filter(|part| part.dwell().is_none()).cloned().collect();
    shapes.extend((0..lasting.len()).filter_map(|i| best_instant(search.frame, &lasting, i, 0.0)));
    for (i, _) in named.iter().enumerate().filter(|(_, choice)| choice.evidence > CLEAR) {
        shapes.extend(best(search, &parts, i));
    }
    shapes
}

/// The instant between any two dwells at which part `i`, which all gyros share, explains most beside the others, where
/// that gains more than `least` of ln likelihood: its grid holds a few.
fn best_instant(frame: &Frame, parts: &[Part], i: usize, least: f64) -> Option<(Effect, Shape)> {
    let Part { effect, shape, .. } = parts[i];
    if !parts[i].common() || !effect.entry().parameter.takes(Shape::Instant(0.0)) {
        return None;
    }
    let left = |shape: Shape| chi2(frame, parts, i, shape, &vec![1.0; frame.gyros.len()]);
    let time = &frame.setting.time;
    let between = (2..frame.dwells().saturating_sub(1)).map(|k| Shape::Instant(0.5 * (time[k - 1] + time[k])));
    let best = between.map(|shape| (left(shape), shape)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    (gain(frame, left(shape), best.0) > least).then_some((effect, best.1))
}

/// ln of likelihood by which a fit that leaves the sum of squares `after` is better than one that leaves `before`.
fn gain(frame: &Frame, before: f64, after: f64) -> f64 {
    0.5 * (frame.gyros.len() * frame.dwells()) as f64 * (before / after).ln()
}

/// The best shape of part `i` between its neighbours on the grid, with all parts fitted, where it gains enough.
fn best(search: &Search, parts: &[Part], i: usize) -> Option<(Effect, Shape)> {
    let Part { effect, shape, .. } = parts[i];
    let at = value(shape)?;
    let (low, high) = neighbours(search, effect, at)?;
    let left = |x: f64| chi2(search.frame, parts, i, with_value(shape, x), &vec![1.0; search.frame.gyros.len()]);
    let x = golden_section(low, high, left);
    (gain(search.frame, left(at), left(x)) > LEAST_GAIN).then(|| (effect, with_value(shape, x)))
}

/// Standard deviation of the value that the shape of part `i` hangs on, from the curvature of the sum of squares
/// about it: `chi^2(x + h) + chi^2(x - h) - 2 chi^2(x) = 2 (h/sd)^2`. At most `grid`, what the spacing of the grid is
/// worth.
pub(crate) fn shape_sd(frame: &Frame, parts: &[Part], i: usize, variances: &[f64], grid: f64) -> f64 {
    let Some(at) = value(parts[i].shape) else { return grid };
    let left = |x: f64| chi2(frame, parts, i, with_value(parts[i].shape, x), variances);
    let h = 0.05 * grid;
    let curvature = (left(at + h) + left(at - h) - 2.0 * left(at)) / (h * h);
    if curvature > 0.0 { (2.0 / curvature).sqrt().min(grid) } else { grid }
}

/// Detectability of one radian of a field's direction below which the direction is not told: its standard deviation is
/// half a radian there.
const TOLD_DIRECTION: f64 = 2.0;

/// The parts, which `fit` fits, as a model is to hold them: a field whose direction the dwells do not tell has any. At
/// rest all directions but north fit alike, and each moves E and G otherwise.
pub(crate) fn as_told(frame: &Frame, parts: &[Part], fit: &Fit) -> Vec<Part> {
    let of_part = |(p, part): (usize, &Part)| match part.shape {
        Shape::Azimuth(angle) if !is_told(frame, parts, (p, angle), fit) => {
            Part { shape: Shape::Linear, ..part.clone() }
        }
        _ => part.clone(),
    };
    parts.iter().enumerate().map(of_part).collect()
}

/// Whether the direction of the field that part `p` is was stated, or residuals would show another.
fn is_told(frame: &Frame, parts: &[Part], (p, angle): (usize, f64), fit: &Fit) -> bool {
    if (parts[p].effect.entry().shapes)(&frame.setting).len() < 2 {
        return true;
    }
    let all: Vec<&Part> = parts.iter().collect();
    // The derivative by the angle is the field a quarter turn on.
    let turned = Part { shape: Shape::Azimuth(angle + FRAC_PI_2), ..parts[p].clone() };
    let of_gyro = |j: usize| {
        let gyro = &frame.gyros[j];
        let mut column = gyro.whiten(fit.drift_of((p, &turned), &frame.setting, j));
        with_parts(frame, j, gyro.basis.clone(), &all).project_out(&mut column);
        dot(&column, &column) / fit.variances[j]
    };
    let members = (0..turned.members.len()).filter(|j| turned.members[*j]);
    members.map(of_gyro).sum::<f64>().sqrt() > TOLD_DIRECTION
}

/// How likely a change is where the phases meet, over everywhere else together: there fixtures are changed.
const WHERE_PHASES_MEET: f64 = 0.5;

/// When part `i` sets in, and the standard deviation of that: a change between two dwells is as likely beforehand as
/// they are apart, more so where one phase follows the other, and then as exp(-chi^2/2) of the fit with it there.
pub(crate) fn instant(frame: &Frame, parts: &[Part], i: usize, variances: &[f64]) -> (f64, f64) {
    let (time, phase) = (&frame.setting.time, &frame.setting.phase);
    let meets = |k: &usize| phase[k - 1] != phase[*k];
    let where_phases_meet = (1..time.len()).find(meets).filter(|first| !(first + 1..time.len()).any(|k| meets(&k)));
    let between = (1..time.len()).map(|k| {
        let (middle, apart) = (0.5 * (time[k - 1] + time[k]), time[k] - time[k - 1]);
        let more = if Some(k) == where_phases_meet { WHERE_PHASES_MEET * frame.setting.span() } else { 0.0 };
        (middle, apart, (apart + more).ln() - 0.5 * chi2(frame, parts, i, Shape::Instant(middle), variances))
    });
    let between: Vec<(f64, f64, f64)> = between.collect();
    let most = between.iter().map(|gap| gap.2).fold(f64::NEG_INFINITY, f64::max);
    let weight = |gap: &(f64, f64, f64)| (gap.2 - most).exp();
    let all: f64 = between.iter().map(weight).sum();
    let mean = between.iter().map(|gap| weight(gap) * gap.0).sum::<f64>() / all;
    let squares = |gap: &(f64, f64, f64)| weight(gap) * ((gap.0 - mean).powi(2) + gap.1 * gap.1 / 12.0);
    (mean, (between.iter().map(squares).sum::<f64>() / all).sqrt())
}

/// Sum of squares that the fit of all parts leaves with another shape of part `i`, over the noise `variances` of each
/// gyro.
fn chi2(frame: &Frame, parts: &[Part], i: usize, shape: Shape, variances: &[f64]) -> f64 {
    let mut parts = parts.to_vec();
    parts[i].shape = shape;
    augmented_fit::fit(frame, &parts).residuals.iter().zip(variances).map(|(r, v)| dot(r, r) / v).sum()
}

/// Where a function with one minimum between `low` and `high` has it.
fn golden_section(mut low: f64, mut high: f64, of: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let inner = |low: f64, high: f64| [high - ratio * (high - low), low + ratio * (high - low)];
    let [mut a, mut b] = inner(low, high);
    let (mut of_a, mut of_b) = (of(a), of(b));
    for _ in 0..STEPS {
        if of_a < of_b {
            (high, b, of_b) = (b, a, of_a);
            a = inner(low, high)[0];
            of_a = of(a);
        } else {
            (low, a, of_a) = (a, b, of_b);
            b = inner(low, high)[1];
            of_b = of(b);
        }
    }
    0.5 * (low + high)
}

/// The shapes of the grid on either side of `at`; at its ends as far beyond as the neighbour on the other side lies.
/// None for an entry with a single shape: then it is known.
fn neighbours(search: &Search, effect: Effect, at: f64) -> Option<(f64, f64)> {
    let grid = search.bank.hypotheses.iter().filter(|hypothesis| hypothesis.kind == effect);
    let (mut below, mut above) = (f64::NEG_INFINITY, f64::INFINITY);
    for x in grid.filter_map(|hypothesis| value(hypothesis.shape)) {
        if x < at {
            below = below.max(x);
        } else if x > at {
            above = above.min(x);
        }
    }
    let held = effect.hypothesis().is_some();
    match (below.is_finite(), above.is_finite()) {
        (true, true) => Some((below, above)),
        // The range of a hypothesis of one's own ends where it says.
        (true, false) if held => Some((below, at)),
        (false, true) if held => Some((at, above)),
        (true, false) => Some((below, at + (at - below))),
        (false, true) => Some((at - 0.5 * (above - at).min(at.abs()), above)),
        (false, false) => None,
    }
}

/// The number that a shape hangs on without a step.
fn value(shape: Shape) -> Option<f64> {
    match shape {
        Shape::Tau(x) | Shape::Period(x) | Shape::Azimuth(x) | Shape::Own(x) => Some(x),
        _ => None,
    }
}

fn with_value(shape: Shape, x: f64) -> Shape {
    match shape {
        Shape::Tau(_) => Shape::Tau(x),
        Shape::Period(_) => Shape::Period(x),
        Shape::Azimuth(_) => Shape::Azimuth(x),
        Shape::Own(_) => Shape::Own(x),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_of_a_valley_is_found() {
        for least in [0.013, 0.5, 0.997] {
            let x = golden_section(0.0, 1.0, |x| (x - least).abs().powf(1.5));
            assert!((x - least).abs() < 1e-3, "{x} for {least}");
        }
    }
}
