//! How noise grows with rate where no standard errors are stated, while effects of rate are still being looked for.
//!
//! The law is that of [`crate::core::calibrate::growth`]. A large growth and an effect of rate can pass for one
//! another, so evidence is averaged over the growth before an effect is believed.

use crate::core::calibrate::growth::{Exposure, NoiseGrowth};
use crate::core::effects::Setting;
use crate::core::numerics::basis::{Basis, dot};

/// Growths that are weighed, equally likely beforehand.
pub(crate) const GROWTHS: [f64; 9] = [0.0, 0.1225, 0.25, 0.49, 1.0, 1.96, 4.0, 7.84, 16.0];

pub(crate) fn exposure(s: &Setting, j: usize) -> Exposure {
    Exposure::of(&s.rate, &s.duration, Some(&s.gyros[j].input))
}

/// Standard deviation of each dwell of gyro `j` up to a factor.
pub(crate) fn shape(s: &Setting, j: usize, law: NoiseGrowth) -> Vec<f64> {
    law.variances(&exposure(s, j)).map(f64::sqrt).data.into()
}

/// Logarithm of the probability of one gyro's output for noise of a given shape, coefficients of `design` and scale
/// integrated out (restricted likelihood, up to a constant that the growth does not change).
pub(crate) fn restricted(output: &[f64], design: &[Vec<f64>], shape: &[f64]) -> f64 {
    let whiten = |column: &[f64]| -> Vec<f64> { column.iter().zip(shape).map(|(x, sd)| x / sd).collect() };
    let (basis, log_det) = spanned(design, whiten);
    let mut residual = whiten(output);
    basis.project_out(&mut residual);
    let dof = residual.len() as f64 - basis.rank() as f64;
    let rss = dot(&residual, &residual).max(f64::MIN_POSITIVE);
    -shape.iter().map(|sd| sd.ln()).sum::<f64>() - 0.5 * log_det - 0.5 * dof * rss.ln()
}

/// Basis of whitened columns, and ln det X'V^-1 X over what it is without whitening them, up to a constant.
pub(crate) fn spanned(columns: &[Vec<f64>], whiten: impl Fn(&[f64]) -> Vec<f64>) -> (Basis, f64) {
    let (mut basis, mut log_det) = (Basis::default(), 0.0);
    for column in columns {
        let whitened = whiten(column);
        let before = dot(&whitened, &whitened);
        let left = basis.push(whitened);
        if left > 0.0 {
            log_det += (left * before / dot(column, column)).ln();
        }
    }
    (basis, log_det)
}

/// Restricted likelihood of all gyros at each of [`GROWTHS`].
pub(crate) fn profile(s: &Setting, outputs: &[Vec<f64>], designs: &[Vec<Vec<f64>>], fall: f64) -> [f64; GROWTHS.len()] {
    let of = |j: usize, law: NoiseGrowth| restricted(&outputs[j], &designs[j], &shape(s, j, law));
    GROWTHS.map(|growth| (0..outputs.len()).map(|j| of(j, NoiseGrowth { growth, fall })).sum())
}
