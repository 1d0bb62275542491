//! Evidence for a hypothesis whose coefficients all gyros share: a tilt of the table is one tilt to all of them.
//!
//! Each gyro weighs with its own noise, so the gyros do not multiply; the coefficients are found from all of them at once.

use crate::core::diagnose::search::hypotheses::Hypothesis;
use crate::core::diagnose::search::projections::MAX_GYROS;
use crate::core::diagnose::search::projections::Seen;
use crate::core::numerics::log_sum::LogSum;
use crate::core::numerics::small_systems;

/// A hypothesis whose coefficients all gyros share.
pub(crate) struct Common<'a> {
    pub size: usize,
    /// Gyros that show it, in front: Gram matrix and products with the residual.
    parts: [Option<(&'a Seen<'a>, small_systems::Matrix, small_systems::Vector)>; MAX_GYROS],
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
        let size = self.size;
        let mut left = self.parts.map(|part| part.map_or(0.0, |(seen, ..)| seen.rss));
        let (mut gain, mut penalty) = (0.0, 0.0);
        for _ in 0..2 {
            let (mut system, mut side) =
                ([[0.0; small_systems::MOST]; small_systems::MOST], [0.0; small_systems::MOST]);
            (0..size).for_each(|i| system[i][i] = 1.0 / power);
            for ((seen, gram, own), left) in self.parts.iter().flatten().zip(&left) {
                let weight = seen.nu / left;
                for i in 0..size {
                    side[i] += own[i] * weight;
                    (0..size).for_each(|j| system[i][j] += gram[i][j] * weight);
                }
            }
            let Some(factor) = small_systems::Factor::of(size, &system) else { return (0.0, 0.0) };
            let estimate = factor.solve(&side);
            let length: f64 = estimate.iter().map(|x| x * x).sum();
            penalty = 0.5 * (factor.log_det() + size as f64 * power.ln()) + 0.5 * length / power;
            gain = 0.0;
            for ((seen, gram, own), left) in self.parts.iter().flatten().zip(&mut left) {
                let along: f64 = estimate.iter().zip(own).map(|(x, b)| x * b).sum();
                let square: f64 =
                    (0..size).map(|i| estimate[i] * (0..size).map(|j| gram[i][j] * estimate[j]).sum::<f64>()).sum();
                *left = (seen.rss - 2.0 * along + square).max(1e-12 * seen.rss);
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
