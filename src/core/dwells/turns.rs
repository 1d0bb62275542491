//! While the table turns, the horizontal part of the Earth's rate goes round in the body, and so does what is level of
//! gravity: the outputs swing by more than their noise, and nothing moves. The swing is taken out before steady
//! intervals are looked for.
//!
//! In a turn by the angle theta(t) each output is
//!
//! ```text
//! y = a + b t + c1 cos theta + s1 sin theta + c2 cos 2 theta + s2 sin 2 theta + noise
//! ```
//!
//! first harmonic: E of the Earth's horizontal rate (12 arcsec/s and more, against noise of far less), and D terms of an
//! axis that is not quite vertical; second: their squares. Only the harmonics are subtracted, so that a mean over whole
//! turns stays what it was. The fit is by least absolute values, so that starts, stops and knocks do not bend it.

use nalgebra::{DVector, Vector3};

use super::blocks::{Series, Track};
use super::intervals::{Interval, quantile};
use super::programme::REST_ARCSEC_S;
use crate::core::numerics::normal::SD_OF_MEDIAN;
use crate::core::numerics::normal_equations::NormalEquations;
use crate::core::units::EARTH_RATE_DEG_H;

/// Seconds over which the rate of the table is averaged before it is compared with the next.
const CELL_S: f64 = 1.0;
/// Relative change of the rate from cell to cell that begins another turn, and its change in standard deviations.
const OTHER_RATE: f64 = 0.005;
const CHANGE: f64 = 7.0;
/// Parts of a turn over which the outputs are averaged before its swing is fitted.
const PARTS_OF_TURN: f64 = 64.0;
/// Cells of a turn, and blocks without samples in it, at least and at most.
const FEWEST: usize = 8;
const GAP: i64 = 24;
/// Turns from which the harmonics are parted from the mean: one, but for its edges; from which the second is fitted.
pub const WHOLE: f64 = 0.9;
const TWO: f64 = 2.0;
/// Part of a turn by whose swing a rate is known, and the whole of it, arcsec.
const PART: f64 = 0.3;
pub const TURN_ARCSEC: f64 = 1_296_000.0;
/// Rounds of the fit by least absolute values, and residuals, in their median, that are then left out of it.
const ROUNDS: usize = 20;
const OUTLIER: f64 = 9.0;
/// What is left of a swing over its changes from part to part, which noise makes as large as itself.
const UNEXPLAINED: f64 = 5.0;
/// Power of a harmonic over that of noise from which the angle's own scale is fitted, and how far it may be off.
const PLAIN: f64 = 100.0;
const SCALE: f64 = 0.03;
/// Rounds in which it is found. Each leaves a part, as a slow drift explains nearly the same: of noise that is well so,
/// and a scale from [`PLAINLY_OFF`] on is found in full.
const FEW_ROUNDS: usize = 3;
const MANY_ROUNDS: usize = 12;
const PLAINLY_OFF: f64 = 5e-3;

/// Intervals in which the table turns, faster than one at rest may seem to, at a rate that does not change: `rates` by block, arcsec/s, in any three axes.
pub fn steady_turns(series: &Series, rates: &[Vector3<f64>]) -> Vec<Interval> {
    let width = (CELL_S / series.block_s).ceil().max(1.0) as usize;
    let cells: Vec<Vector3<f64>> = rates.chunks(width).map(mean).collect();
    let turning = |c: &Vector3<f64>| c.norm() >= REST_ARCSEC_S;
    let both = cells.windows(2).filter(|p| turning(&p[0]) && turning(&p[1]));
    // Relative: stamps that jitter make a rate of differences as uncertain as it is fast.
    let noise = quantile(both.map(|p| (p[1] - p[0]).norm() / p[0].norm()).collect(), 0.5);
    let mut found: Vec<(usize, usize)> = Vec::new();
    for (k, cell) in cells.iter().enumerate().filter(|(_, cell)| turning(cell)) {
        let room = REST_ARCSEC_S.max(OTHER_RATE.max(CHANGE * noise) * cell.norm());
        let near = |j: usize| {
            let gap = series.number[k * width] - series.number[j * width];
            (cell - cells[j]).norm() <= room && gap <= width as i64 + GAP
        };
        match found.last_mut() {
            Some((_, to)) if *to == k && near(k - 1) => *to = k + 1,
            _ => found.push((k, k + 1)),
        }
    }
    found.retain(|(from, to)| to - from >= FEWEST);
    found.iter().map(|&(from, to)| Interval { from: from * width, to: (to * width).min(rates.len()) }).collect()
}

/// Angle of the table through a turn, rad, from the rates along their mean; zero in the middle.
pub fn angles(series: &Series, rates: &[Vector3<f64>], turn: Interval) -> Vec<f64> {
    let along = mean(&rates[turn.from..turn.to]);
    let length = along.norm().max(f64::MIN_POSITIVE);
    let rate = |k: usize| rates[k].dot(&along) / length;
    let mut angles = vec![0.0];
    for k in turn.from + 1..turn.to {
        // A rate that is the difference of angles is that since the block before.
        let step = rate(k) * (series.time_s[k] - series.time_s[k - 1]);
        angles.push(angles[angles.len() - 1] + (step / 3600.0).to_radians());
    }
    let middle = 0.5 * angles[angles.len() - 1];
    angles.iter_mut().for_each(|angle| *angle -= middle);
    angles
}

/// Takes the swing of a turn out of the channels; how many turns it has, zero where the angles do not explain how the
/// outputs swing: nothing is taken out then.
///
/// Of less than one turn the harmonics are not parted from the mean, so what is taken out has the mean zero.
pub fn take_out(series: &mut Series, channels: &[usize], turn: Interval, mut angles: Vec<f64>) -> f64 {
    let width = width(turn, turned(&angles));
    let fits = fitted(series, channels, turn, &mut angles, width);
    if fits.iter().any(|fit| fit.rest > UNEXPLAINED) {
        return 0.0;
    }
    let turns = turned(&angles) / std::f64::consts::TAU;
    for (&channel, fit) in channels.iter().zip(&fits) {
        let swing: Vec<f64> = angles.iter().map(|&angle| fit.swing(angle)).collect();
        let level = if turns < WHOLE { swing.iter().sum::<f64>() / swing.len() as f64 } else { 0.0 };
        let own = &mut series.tracks[channel].mean[turn.from..turn.to];
        own.iter_mut().zip(swing).for_each(|(value, swing)| *value -= swing - level);
    }
    turns
}

/// Of rates that a turn may have, arcsec/s, the one whose swing explains the channels best, and its angles; none where
/// none explains more than noise would, or by a swing larger than the Earth's rate makes at such a rate.
pub fn likeliest(series: &Series, channels: &[usize], turn: Interval, rates: &[f64]) -> Option<Vec<f64>> {
    let scatter = |fits: &[Fit]| fits.iter().map(|fit| fit.scatter.max(f64::MIN_POSITIVE).ln()).sum::<f64>();
    let duration_s = series.time_s[turn.to - 1] - series.time_s[turn.from];
    let fastest = rates.iter().copied().fold(0.0, f64::max);
    let width = width(turn, (fastest * duration_s / 3600.0).to_radians());
    let middle = |c: &usize| quantile(series.tracks[*c].mean[turn.from..turn.to].to_vec(), 0.5);
    let level = channels.iter().map(|c| middle(c).powi(2)).sum::<f64>().sqrt();
    let tried = rates.iter().filter_map(|&rate| {
        // A small part of a turn looks like any slow motion.
        if rate * duration_s < PART * TURN_ARCSEC {
            return None;
        }
        let mut own = angles(series, &vec![Vector3::new(rate, 0.0, 0.0); series.number.len()], turn);
        let fits = fitted(series, channels, turn, &mut own, width);
        let is_earths = fits.iter().all(|fit| fit.amplitude() <= earths_swing(rate, level));
        // At half the rate the second harmonic would explain the swing as well.
        (is_earths && fits.iter().any(|fit| fit.power > PLAIN)).then(|| (scatter(&fits), own))
    });
    tried.min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
}

/// By block, what the Earth's rate (deg/h are arcsec/s) may change the outputs by while the table turns at `slowest` arcsec/s or faster.
pub fn room(series: &Series, outputs: &[usize], slowest: f64) -> Vec<f64> {
    let level = |k: usize| outputs.iter().map(|&c| series.tracks[c].mean[k].powi(2)).sum::<f64>().sqrt();
    (0..series.number.len()).map(|k| earths_swing(slowest, level(k))).collect()
}

/// What the Earth's rate may change outputs of such a level by, in a turn at `rate`.
fn earths_swing(rate: f64, level: f64) -> f64 {
    2.0 * EARTH_RATE_DEG_H / rate * level
}

/// The angle that the table goes through, rad.
fn turned(angles: &[f64]) -> f64 {
    (angles[angles.len() - 1] - angles[0]).abs()
}

/// Blocks in a part of a turn by the angle `turned`, rad.
fn width(turn: Interval, turned: f64) -> usize {
    let blocks = (turn.to - turn.from) as f64;
    (blocks / PARTS_OF_TURN * std::f64::consts::TAU / turned).clamp(1.0, (blocks / FEWEST as f64).max(1.0)) as usize
}

/// A channel's fit: the harmonics, the median of what is left, that over its changes from part to part, and the power of
/// the first over that of noise; by part of the turn, what is left and whether it was kept.
struct Fit {
    harmonics: Vec<f64>,
    scatter: f64,
    rest: f64,
    power: f64,
    kept: Vec<bool>,
    left: Vec<f64>,
}

/// A part of a turn: its angle and mean, and the means of what is fitted.
struct Part {
    angle: f64,
    row: [f64; 6],
    value: f64,
}

impl Fit {
    fn swing(&self, angle: f64) -> f64 {
        let part = |(k, of): (usize, &[f64])| {
            let (sine, cosine) = ((k + 1) as f64 * angle).sin_cos();
            of[0] * cosine + of[1] * sine
        };
        self.harmonics.chunks(2).enumerate().map(part).sum()
    }

    /// Of the first harmonic.
    fn amplitude(&self) -> f64 {
        self.harmonics[0].hypot(self.harmonics[1])
    }

    /// Derivative of the swing by a scale of the angle.
    fn slope(&self, angle: f64) -> f64 {
        let (sine, cosine) = angle.sin_cos();
        angle * (self.harmonics[1] * cosine - self.harmonics[0] * sine)
    }
}

/// Fits every channel. The angle's scale is fitted too where the swing is plain: a table told 10 deg/s may turn at 10.01.
fn fitted(series: &Series, channels: &[usize], turn: Interval, angles: &mut [f64], width: usize) -> Vec<Fit> {
    let fit = |angles: &[f64]| -> Vec<Fit> {
        channels.iter().map(|&c| harmonics(&series.tracks[c], turn, angles, width)).collect()
    };
    let mut fits = fit(angles);
    let mut scaled = 1.0;
    for round in 0..MANY_ROUNDS {
        if round >= FEW_ROUNDS && (scaled - 1.0_f64).abs() < PLAINLY_OFF {
            break;
        }
        let (mut up, mut down) = (0.0, 0.0);
        for own in fits.iter().filter(|fit| fit.power > PLAIN) {
            let weight = own.scatter.max(f64::MIN_POSITIVE).powi(-2);
            for (k, part) in angles.chunks_exact(width).enumerate().filter(|(k, _)| own.kept[*k]) {
                let slope = own.slope(part.iter().sum::<f64>() / width as f64);
                up += weight * slope * own.left[k];
                down += weight * slope * slope;
            }
        }
        let turns = turned(angles) / std::f64::consts::TAU;
        let off = up / down;
        if turns < WHOLE || !off.is_finite() || (scaled * (1.0 + off) - 1.0).abs() > SCALE {
            break;
        }
        scaled *= 1.0 + off;
        angles.iter_mut().for_each(|angle| *angle *= 1.0 + off);
        fits = fit(angles);
    }
    fits
}

/// The harmonics of one channel, fitted to its means over `width` blocks each.
fn harmonics(track: &Track, turn: Interval, angles: &[f64], width: usize) -> Fit {
    let turns = turned(angles) / std::f64::consts::TAU;
    let unknowns = if turns >= TWO { 6 } else { 4 };
    let parts = parts(track, turn, angles, width);
    let count = parts.len();
    let origin = quantile(parts.iter().map(|part| part.value).collect(), 0.5);
    let mut weights = vec![1.0; count];
    let (mut left, mut scatter, mut found) = (vec![0.0; count], 0.0, vec![0.0; unknowns]);
    for round in 0..ROUNDS + 2 {
        let rows = parts.iter().zip(&weights).filter(|(_, weight)| **weight > 0.0);
        let rows = rows.map(|(part, weight)| (part.row, part.value - origin, *weight));
        let Some(solution) = least_squares(rows, unknowns) else {
            break;
        };
        found = solution;
        let model = |part: &Part| part.row.iter().zip(&found).map(|(r, f)| r * f).sum::<f64>();
        left = parts.iter().map(|part| part.value - origin - model(part)).collect();
        scatter = quantile(left.iter().map(|r: &f64| r.abs()).collect(), 0.5);
        let least = (1e-3 * scatter).max(f64::MIN_POSITIVE);
        let weight = |r: &f64| match round {
            ..ROUNDS => r.abs().max(least).recip(),
            _ => f64::from(u8::from(r.abs() <= OUTLIER * scatter.max(f64::MIN_POSITIVE))),
        };
        weights = left.iter().map(weight).collect();
    }
    // A steady rate may be counted without any scatter, and no better for that: a pulse at both ends of each part.
    let samples = track.weight[turn.from..turn.to].iter().sum::<f64>() / count as f64;
    let step = if track.pulse > 0.0 { track.step } else { 0.0 };
    let least = (step / samples / 6_f64.sqrt() / SD_OF_MEDIAN).max(f64::MIN_POSITIVE);
    let change = quantile(left.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect(), 0.5);
    let rest = scatter / change.max(least);
    let scatter = scatter.max(least);
    let noise = (SD_OF_MEDIAN * scatter).powi(2).max(f64::MIN_POSITIVE);
    let first: Vec<f64> = parts.iter().map(|p| found[2] * p.angle.cos() + found[3] * p.angle.sin()).collect();
    let level = first.iter().sum::<f64>() / count as f64;
    let power = first.iter().map(|swing| (swing - level).powi(2)).sum::<f64>() / noise;
    let kept = weights.iter().map(|w| *w > 0.0).collect();
    Fit { harmonics: found[2..].to_vec(), scatter, rest, power, kept, left }
}

/// Means over `width` blocks each of a channel and of what is fitted to it.
fn parts(track: &Track, turn: Interval, angles: &[f64], width: usize) -> Vec<Part> {
    let turns = turned(angles) / std::f64::consts::TAU;
    let row = |k: usize| {
        let (sine, cosine) = angles[k].sin_cos();
        // Of a small part of a turn cos and sin are all but 1 and theta, which is time.
        let (level, time) = match turns {
            ..WHOLE => (angles[0].cos(), 0.0),
            _ => (0.0, 2.0 * k as f64 / angles.len() as f64 - 1.0),
        };
        [1.0, time, cosine - level, sine, cosine * cosine - sine * sine, 2.0 * sine * cosine]
    };
    let part = |from: usize| {
        let mut mean = [0.0; 6];
        let blocks = from..from + width;
        let weight: f64 = blocks.clone().map(|k| track.weight[turn.from + k]).sum();
        for k in blocks.clone() {
            let share = track.weight[turn.from + k] / weight;
            mean.iter_mut().zip(row(k)).for_each(|(mean, value)| *mean += share * value);
        }
        let angle = angles[blocks].iter().sum::<f64>() / width as f64;
        Part { angle, row: mean, value: track.mean_of(turn.from + from, turn.from + from + width) }
    };
    (0..angles.len() / width).map(|k| part(k * width)).collect()
}

/// Weighted least squares of `width` unknowns; none where they are not told apart.
fn least_squares(rows: impl Iterator<Item = ([f64; 6], f64, f64)>, width: usize) -> Option<Vec<f64>> {
    let mut normal = NormalEquations::new(width);
    rows.for_each(|(row, value, weight)| normal.add(&DVector::from_column_slice(&row[..width]), value, weight));
    // A whisper of a ridge: what is not told apart stays small, and what is not there is zero.
    for k in 0..width {
        let own = &mut normal.matrix[(k, k)];
        *own = if *own == 0.0 { 1.0 } else { *own * (1.0 + 1e-12) };
    }
    let found = normal.solve()?.estimate;
    found.iter().all(|f| f.is_finite()).then(|| found.iter().copied().collect())
}

fn mean(of: &[Vector3<f64>]) -> Vector3<f64> {
    of.iter().sum::<Vector3<f64>>() / of.len() as f64
}
