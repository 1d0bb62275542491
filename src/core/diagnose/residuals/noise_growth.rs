//! How noise grows with rate where no standard errors are stated.
//!
//! `v_k = sigma_j^2 (1 + c^2 (w_I/top)^2) duration^-p`, with `c` shared by the gyros and unknown. A large `c` and an
//! effect of rate can pass for one another, so evidence is averaged over `c` before an effect is believed.

use crate::core::effects::Setting;
use crate::core::numerics::basis::{Basis, dot};

/// Values of `c` that are weighed, equally likely beforehand.
pub(crate) const GROWTHS: [f64; 9] = [0.0, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0];

/// Standard deviation of each dwell of gyro `j` up to a factor.
pub(crate) fn shape(s: &Setting, j: usize, c: f64, p: f64) -> Vec<f64> {
    let input = s.column(|k| s.rate[k].dot(&s.gyros[j].input).abs());
    let top = input.iter().fold(f64::MIN_POSITIVE, |m: f64, x| m.max(*x));
    s.column(|k| (1.0 + (c * input[k] / top).powi(2)).sqrt() * (s.duration[0] / s.duration[k]).powf(0.5 * p))
}

/// Logarithm of the probability of one gyro's output for noise of a given shape, coefficients of `design` and scale
/// integrated out (restricted likelihood, up to a constant that `c` does not change).
pub(crate) fn restricted(output: &[f64], design: &[Vec<f64>], shape: &[f64]) -> f64 {
    let whiten = |column: &[f64]| -> Vec<f64> { column.iter().zip(shape).map(|(x, sd)| x / sd).collect() };
    let mut basis = Basis::default();
    let mut log_det = 0.0;
    for column in design {
        let whitened = whiten(column);
        let before = dot(&whitened, &whitened);
        let left = basis.push(whitened);
        if left > 0.0 {
            log_det += (left * before / dot(column, column)).ln();
        }
    }
    let mut residual = whiten(output);
    basis.project_out(&mut residual);
    let dof = residual.len() as f64 - basis.rank() as f64;
    let rss = dot(&residual, &residual).max(f64::MIN_POSITIVE);
    -shape.iter().map(|sd| sd.ln()).sum::<f64>() - 0.5 * log_det - 0.5 * dof * rss.ln()
}

/// Restricted likelihood of all gyros at each of [`GROWTHS`].
pub(crate) fn profile(s: &Setting, outputs: &[Vec<f64>], designs: &[Vec<Vec<f64>>], p: f64) -> [f64; GROWTHS.len()] {
    GROWTHS.map(|c| (0..outputs.len()).map(|j| restricted(&outputs[j], &designs[j], &shape(s, j, c, p))).sum())
}
