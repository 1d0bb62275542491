//! What share of a change a cause closes, on blocks of time that were left out of the fit.
//!
//! Errors are in units of the noise variance; what noise alone gives, the fit's own error included, is taken off both.

use nalgebra::DVector;

use super::answer::HistoryHeldOut;
use crate::core::numerics::normal_equations::NormalEquations;

const BLOCKS: usize = 8;
/// Remaining power, in standard deviations of what noise alone leaves, from which something is left.
const LEFT: f64 = 2.5;
/// Share of what all records tell of a coefficient that those outside of a block must tell of it beside the others.
const TOLD_ELSEWHERE: f64 = 0.05 * 0.05;

/// Of column `k` among `columns`, the others in the model both times. So much of its course as `open` may be another's,
/// which the residuals of the blocks need not show.
pub(super) fn held_out(y: &[f64], variance: &[f64], columns: &[&[f64]], k: usize, open: f64) -> Option<HistoryHeldOut> {
    let others: Vec<&[f64]> = columns.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, column)| *column).collect();
    summed(y, y, variance, &others, columns, open)
}

/// Of a column whose coefficient is known without this gyro; it is taken out of `y` already.
pub(super) fn held_out_known(
    y: &[f64],
    variance: &[f64],
    columns: &[&[f64]],
    column: &[f64],
    value: f64,
) -> Option<HistoryHeldOut> {
    let whole: Vec<f64> = y.iter().zip(column).map(|(y, c)| y + value * c).collect();
    summed(&whole, y, variance, columns, columns, 0.0)
}

fn summed(
    y_without: &[f64],
    y_with: &[f64],
    variance: &[f64],
    without: &[&[f64]],
    with: &[&[f64]],
    open: f64,
) -> Option<HistoryHeldOut> {
    let n = y_with.len();
    let blocks = BLOCKS.min(n / 2).max(1);
    let mut waiting: Vec<std::ops::Range<usize>> = (0..blocks).map(|b| b * n / blocks..(b + 1) * n / blocks).collect();
    let (mut before, mut after, mut floor, mut count, mut noise) = (0.0, 0.0, 0.0, 0.0, 0.0);
    while let Some(block) = waiting.pop() {
        if block.is_empty() {
            continue;
        }
        let predicted = errors(y_without, variance, without, &block).zip(errors(y_with, variance, with, &block));
        let Some(((e, e_noise), (f, f_noise))) = predicted else {
            // A block that the rest cannot predict, in halves.
            if block.len() > 1 {
                let middle = usize::midpoint(block.start, block.end);
                waiting.extend([block.start..middle, middle..block.end]);
            }
            continue;
        };
        // The noise of the smaller model is smaller: both are brought to that of the larger one.
        before += e - e_noise + f_noise;
        after += f;
        floor += f_noise;
        count += block.len() as f64;
        noise += variance[block].iter().sum::<f64>();
    }
    if count < 4.0 {
        return None;
    }
    let gain = (before - after).max(0.0);
    if gain == 0.0 {
        return None;
    }
    let scatter = (2.0 * count).sqrt();
    let over = after - floor;
    let significant = over > LEFT * scatter;
    // What is left is known to one degree of freedom at best.
    let left = over.max(1.0);
    let over_scatter = (2.0 * count + 4.0 * over.max(0.0)).sqrt();
    let low_gain = (gain.sqrt() - 2.0).max(0.0).powi(2);
    let high_left = if significant { over + 2.0 * over_scatter } else { left + 0.5 * scatter };
    let high_left = high_left.max(gain * open);
    let high_gain = (gain.sqrt() + 2.0).powi(2);
    let low_left = if significant { (over - 2.0 * over_scatter).max(0.0) } else { 0.0 };
    let share = |gain: f64, left: f64| if gain > 0.0 { gain / (gain + left) } else { 0.0 };
    let closure = share(gain, left);
    let sd = (noise / count).sqrt();
    Some(HistoryHeldOut {
        before: sd * (1.0 + (gain + left) / count).sqrt(),
        after: sd * (1.0 + left / count).sqrt(),
        closure,
        interval: [share(low_gain, high_left).min(closure), share(high_gain, low_left).max(closure)],
    })
}

/// Sum of squared errors on a block, and what noise alone makes of it; none where the rest does not predict it.
fn errors(y: &[f64], variance: &[f64], columns: &[&[f64]], block: &std::ops::Range<usize>) -> Option<(f64, f64)> {
    let p = columns.len() + 1;
    let row = |k: usize| -> DVector<f64> { DVector::from_fn(p, |c, _| if c == 0 { 1.0 } else { columns[c - 1][k] }) };
    let mut normal = NormalEquations::new(p);
    let mut whole: DVector<f64> = DVector::zeros(p);
    for k in 0..y.len() {
        let x = row(k);
        whole += x.component_mul(&x) / variance[k];
        if !block.contains(&k) {
            normal.add(&x, y[k], 1.0 / variance[k]);
        }
    }
    let elsewhere = normal.solve_beyond(&whole, TOLD_ELSEWHERE)?;
    let (mut sum, mut noise) = (0.0, 0.0);
    for k in block.clone() {
        let x = row(k);
        sum += (y[k] - x.dot(&elsewhere.estimate)).powi(2) / variance[k];
        noise += 1.0 + x.dot(&(&elsewhere.covariance * &x)) / variance[k];
    }
    Some((sum, noise))
}
