//! Evidence for a hypothesis whose coefficients all gyros share: a tilt of the table is one tilt to all of them.
//!
//! Each gyro weighs with its own noise, so the gyros do not multiply; the coefficients are found from all of them at
//! once.

use nalgebra::{Matrix3, Vector3};

use crate::core::diagnose::search::hypotheses::{Hypothesis, SMALL};
use crate::core::diagnose::search::projections::GyroStatistics;
use crate::core::diagnose::search::projections::MAX_GYROS;
use crate::core::numerics::log_sum::LogSum;

/// A hypothesis whose coefficients all gyros share.
pub(crate) struct Common<'a> {
    pub size: usize,
    /// Gyros that show it, in front: Gram matrix and products with the residual.
    parts: [Option<(&'a GyroStatistics<'a>, Matrix3<f64>, Vector3<f64>)>; MAX_GYROS],
}

impl<'a> Common<'a> {
    /// None where no gyro shows it.
    pub fn of(hypothesis: &Hypothesis, seen: &'a [GyroStatistics<'a>]) -> Option<Self> {
        let size = hypothesis.blocks.iter().map(|block| block.len).max().filter(|len| *len > 0)?;
        let mut parts = [None; MAX_GYROS];
        let show = hypothesis.blocks.iter().zip(seen).filter(|(block, _)| block.len == size);
        for (part, (block, seen)) in parts.iter_mut().zip(show) {
            *part = Some((seen, seen.gram(block), seen.side(block)));
        }
        Some(Self { size, parts })
    }

    /// Gain in log-likelihood.
    pub fn gain(&self, power: f64) -> f64 {
        self.fitted(power).gain
    }

    /// Each gyro weighs with its own noise, found anew from what the fit leaves it: twice, and until it stays where a
    /// strong effect was noise at first.
    fn fitted(&self, power: f64) -> Fitted {
        let mut left = self.parts.map(|part| part.map_or(0.0, |(seen, ..)| seen.rss));
        let mut fitted = Fitted::default();
        for round in 1..=MOST_ROUNDS {
            let (mut system, mut side) = (Matrix3::identity() / power, Vector3::zeros());
            for ((seen, gram, own), left) in self.parts.iter().flatten().zip(&left) {
                let weight = seen.nu / left;
                system += gram * weight;
                side += own * weight;
            }
            let Some(factor) = system.cholesky() else { return Fitted::default() };
            let estimate = factor.solve(&side);
            // What is not among the coefficients adds nothing to the determinant of power x system.
            let log_det = factor.ln_determinant() + SMALL as f64 * power.ln();
            let before = fitted.gain;
            fitted = Fitted { gain: 0.0, log_det, size: estimate.norm_squared() };
            for ((seen, gram, own), left) in self.parts.iter().flatten().zip(&mut left) {
                *left = (seen.rss - 2.0 * estimate.dot(own) + estimate.dot(&(gram * estimate))).max(1e-12 * seen.rss);
                fitted.gain += 0.5 * seen.nu * (seen.rss / *left).ln();
            }
            if round > 1 && fitted.gain - before < STRONG {
                break;
            }
        }
        fitted
    }

    /// ln of the Bayes factor, averaged over the prior's powers, the widest last. What is too strong for that has a
    /// wider one, at odds that only a strong effect pays.
    pub fn log_bayes(&self, powers: &[f64]) -> f64 {
        let (mut sum, mut widest, mut size) = (LogSum::default(), 0.0, 0.0);
        for &power in powers {
            let fitted = self.fitted(power);
            sum.add(fitted.gain - fitted.penalty(power));
            (widest, size) = (power, fitted.size);
        }
        if size > STRONG * widest {
            let power = size.powi(2) / widest;
            let fitted = self.fitted(power);
            sum.add(fitted.gain - fitted.penalty(power) - STRONG);
        }
        sum.log_mean(powers.len())
    }
}

/// What the coefficients take from the residuals: gain in log-likelihood, ln det of the system, and the square of
/// their length.
#[derive(Default)]
struct Fitted {
    gain: f64,
    log_det: f64,
    size: f64,
}

impl Fitted {
    fn penalty(&self, power: f64) -> f64 {
        0.5 * self.log_det + 0.5 * self.size / power
    }
}

/// Rounds in which the gyros' noise is found anew.
const MOST_ROUNDS: usize = 10;

/// ln of evidence from which on an effect is strong.
const STRONG: f64 = 10.0;
