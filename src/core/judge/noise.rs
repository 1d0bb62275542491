//! One model of how figures of an unmoved gyro scatter, for every rule: a level, scatter s that is correlated from
//! one figure to the next (AR(1) with phi), and a random walk of the level by q a root year.
//!
//! Every figure that a control rule compares is a weighted sum of cells, so its variance follows from s, phi and q in
//! one pass. s is the gyro's own, learned from its records; phi and q are the fleet's, as one gyro's records do not
//! tell them for years (the standard deviation of phi is 0.20 after 26 records).

mod fleet;

pub use fleet::{FleetNoise, Spacing, fit_fleet};

use crate::core::numerics::median::median;

/// What is known of the noise of a whole fleet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseParameters {
    /// Correlation of the scatter from one cell to the next.
    pub phi: f64,
    /// Random walk of the level, deg/(h g0) a root year.
    pub walk: f64,
    /// Whether they were fitted to the fleet; if not, a standard deviation of the trend may be half or twice what it
    /// should be.
    pub of_fleet: bool,
}

impl Default for NoiseParameters {
    /// Before there is a fleet: the middle of what gyros show.
    fn default() -> Self {
        Self { phi: 0.4, walk: 5e-4, of_fleet: false }
    }
}

impl NoiseParameters {
    /// sum_ij u_i w_j phi^|i-j|: covariance of two weighted sums for scatter of variance one. O(n).
    pub(super) fn of_scatter(&self, u: &[f64], w: &[f64]) -> f64 {
        let (mut before_u, mut before_w, mut sum) = (0.0, 0.0, 0.0);
        for (u, w) in u.iter().zip(w) {
            sum += u * w + u * before_w + w * before_u;
            before_u = self.phi * (before_u + u);
            before_w = self.phi * (before_w + w);
        }
        sum
    }

    /// Covariance of two weighted sums by the walk, each of weights that add up to zero; `t` in years. O(n).
    pub(super) fn of_walk(&self, t: impl Fn(usize) -> f64, u: &[f64], w: &[f64]) -> f64 {
        let (mut after_u, mut after_w, mut sum) = (0.0, 0.0, 0.0);
        for i in (1..u.len()).rev() {
            after_u += u[i];
            after_w += w[i];
            sum += (t(i) - t(i - 1)) * after_u * after_w;
        }
        self.walk * self.walk * sum
    }

    /// n Var(mean of n) for scatter of variance one: 1 where it is independent.
    pub(super) fn inflation(&self, n: usize) -> f64 {
        let rest: f64 = (1..n).map(|lag| (n - lag) as f64 * self.phi.powi(lag as i32)).sum();
        1.0 + 2.0 * rest / n as f64
    }

    /// By how much the variance of the median of three is larger than that of their mean: 0.449 - 0.333 where they
    /// are independent.
    pub(super) fn median_excess(&self) -> f64 {
        0.115 * (1.0 - self.phi)
    }
}

/// A gyro's own scatter: what its cells show, drawn towards what a gyro is expected to have.
#[derive(Debug, Clone, Copy)]
pub(super) struct ScatterPrior {
    /// Expected scatter, deg/(h g0).
    pub scatter: f64,
    /// Scatter is taken no smaller.
    pub least: f64,
}

/// Cells that the expectation counts for.
const WEIGHT: f64 = 5.0;

impl ScatterPrior {
    /// For a budget, and cells with these stated standard deviations.
    ///
    /// No smaller than a twentieth of the budget: less does not matter. No smaller than what the stations state of
    /// their own, the median over all cells or over the newest three.
    pub fn of(budget: f64, stated: impl DoubleEndedIterator<Item = Option<f64>> + Clone) -> Self {
        let (newest, all) = (middle(stated.clone().rev().take(3)), middle(stated));
        Self { scatter: budget / 10.0, least: (budget / 20.0).max(all).max(newest) }
    }

    /// s^2 from squares of residuals that stand for so many independent ones.
    pub fn variance(&self, squares: f64, degrees_of_freedom: f64) -> f64 {
        let expected = WEIGHT * self.scatter * self.scatter;
        ((expected + squares) / (WEIGHT + degrees_of_freedom.max(1.0))).max(self.least * self.least)
    }
}

/// Median of the standard deviations that are stated.
fn middle(stated: impl Iterator<Item = Option<f64>>) -> f64 {
    let mut known = [0.0; super::cells::CELLS];
    let mut n = 0;
    for sd in stated.flatten() {
        known[n] = sd;
        n += 1;
    }
    median(&mut known[..n]).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covariances_are_those_of_the_full_matrix() {
        let noise = NoiseParameters { phi: 0.6, walk: 2e-3, of_fleet: true };
        let t: [f64; 5] = [-2.0, -1.4, -1.1, -0.2, 0.0];
        let (u, w) = ([0.3, -0.5, 0.1, 0.6, -0.5], [-0.2, 0.4, 0.3, -0.9, 0.4]);
        let (mut scatter, mut walk) = (0.0, 0.0);
        for i in 0..t.len() {
            for j in 0..t.len() {
                scatter += u[i] * w[j] * 0.6_f64.powi((i as i32 - j as i32).abs());
                // A walk from the first cell on: covariance of two levels is the time that they share.
                walk += u[i] * w[j] * 4e-6 * (t[i].min(t[j]) - t[0]);
            }
        }
        assert!((noise.of_scatter(&u, &w) - scatter).abs() < 1e-12);
        assert!((noise.of_walk(|i| t[i], &u, &w) - walk).abs() < 1e-15);
        let mean = [1.0 / 7.0; 7];
        assert!((noise.inflation(7) - 7.0 * noise.of_scatter(&mean, &mean)).abs() < 1e-12);
    }

    #[test]
    fn scatter_is_drawn_towards_what_is_expected_and_never_below_what_is_stated() {
        let prior = ScatterPrior::of(0.01, [Some(1e-4), None, Some(3e-4), Some(2e-4)].into_iter());
        assert_eq!((prior.scatter, prior.least), (1e-3, 5e-4));
        assert!((prior.variance(0.0, 5.0) - 0.5e-6).abs() < 1e-18, "half of the expected variance");
        assert!((prior.variance(9e-6 * 45.0, 45.0) - (5e-6 + 405e-6) / 50.0).abs() < 1e-15);
        let noisy = ScatterPrior::of(0.01, [Some(1e-4), Some(1e-4), Some(1e-4), Some(0.2), Some(0.3)].into_iter());
        assert_eq!(noisy.least, 0.2, "the newest three decide too");
    }
}
