//! Evidence for a hypothesis whose coefficients all gyros share: a tilt of the table is one tilt to all of them.
//!
//! Each gyro weighs with its own noise, so the gyros do not multiply; the coefficients are found from all of them at
//! once.

use nalgebra::{Matrix3, Vector3};

use crate::core::diagnose::search::hypotheses::{Hypothesis, SMALL};
use crate::core::diagnose::search::projections::MAX_GYROS;
use crate::core::diagnose::search::projections::Seen;
use crate::core::numerics::log_sum::LogSum;

/// A hypothesis whose coefficients all gyros share.
pub(crate) struct Common<'a> {
    pub size: usize,
    /// Gyros that show it, in front: Gram matrix and products with the residual.
    parts: [Option<(&'a Seen<'a>, Matrix3<f64>, Vector3<f64>)>; MAX_GYROS],
}

impl<'a> Common<'a> {
    /// None where no gyro shows it.
    pub fn of(hypothesis: &Hypothesis, seen: &'a [Seen<'a>]) -> Option<Self> {
        let size = hypothesis.blocks.iter().map(|block| block.len).max().filter(|len| *len > 0)?;
        let mut parts = [None; MAX_GYROS];
        let show = hypothesis.blocks.iter().zip(seen).filter(|(block, _)| block.len == size);
        for (part, (block, seen)) in parts.iter_mut().zip(show) {
            *part = Some((seen, seen.gram(block), seen.side(block)));
        }
        Some(Self { size, parts })
    }

    /// Log-likelihood gain, and half of ln det plus the prior's own term. Each gyro weighs with its own noise, found
    /// anew from what the fit leaves it.
    pub fn fit(&self, power: f64) -> (f64, f64) {
        let mut left = self.parts.map(|part| part.map_or(0.0, |(seen, ..)| seen.rss));
        let (mut gain, mut penalty) = (0.0, 0.0);
        for _ in 0..2 {
            let (mut system, mut side) = (Matrix3::identity() / power, Vector3::zeros());
            for ((seen, gram, own), left) in self.parts.iter().flatten().zip(&left) {
                let weight = seen.nu / left;
                system += gram * weight;
                side += own * weight;
            }
            let Some(factor) = system.cholesky() else { return (0.0, 0.0) };
            let estimate = factor.solve(&side);
            // What is not among the coefficients adds nothing to the determinant of power x system.
            let log_det = factor.ln_determinant() + SMALL as f64 * power.ln();
            penalty = 0.5 * log_det + 0.5 * estimate.norm_squared() / power;
            gain = 0.0;
            for ((seen, gram, own), left) in self.parts.iter().flatten().zip(&mut left) {
                *left = (seen.rss - 2.0 * estimate.dot(own) + estimate.dot(&(gram * estimate))).max(1e-12 * seen.rss);
                gain += 0.5 * seen.nu * (seen.rss / *left).ln();
            }
        }
        (gain, penalty)
    }

    /// ln of the Bayes factor, averaged over the prior's powers.
    pub fn log_bayes(&self, powers: &[f64]) -> f64 {
        let mut sum = LogSum::default();
        for &power in powers {
            let (gain, penalty) = self.fit(power);
            sum.add(gain - penalty);
        }
        sum.log_mean(powers.len())
    }
}
