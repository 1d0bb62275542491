//! The standard normal distribution, and the range of several normal figures.

use std::f64::consts::SQRT_2;

use statrs::function::erf::{erfc, erfc_inv};

/// Standard deviation over the median of absolute departures of normal figures.
pub(crate) const SD_OF_MEDIAN: f64 = 1.482_602_218_505_602;
/// Standard error of the median of normal figures over that of their mean, sqrt(pi/2).
pub(crate) const MEDIAN_ERROR: f64 = 1.253_314_137_315_500_3;

/// The standard normal distribution function.
pub(crate) fn normal_cdf(z: f64) -> f64 {
    0.5 * erfc(-z / SQRT_2)
}

/// Its inverse.
pub(crate) fn normal_quantile(p: f64) -> f64 {
    -SQRT_2 * erfc_inv(2.0 * p)
}

/// P(range of n standard normal figures <= q) = n integral phi(z) [Phi(z) - Phi(z - q)]^(n-1) dz, by Simpson's rule.
pub(crate) fn range_cdf(q: f64, n: usize) -> f64 {
    const INTERVALS: usize = 96;
    const END: f64 = 8.0;
    let step = 2.0 * END / INTERVALS as f64;
    let power = i32::try_from(n.saturating_sub(1)).unwrap_or(i32::MAX);
    let density = |z: f64| (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let sum: f64 = (0..=INTERVALS)
        .map(|i| {
            let z = -END + step * i as f64;
            let weight = if i == 0 || i == INTERVALS { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
            weight * density(z) * (normal_cdf(z) - normal_cdf(z - q)).max(0.0).powi(power)
        })
        .sum();
    (n as f64 * sum * step / 3.0).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_range_of_normal_figures_is_tukeys() {
        // Upper 5 % points of the studentised range for infinite degrees of freedom (Harter's table).
        for (n, q) in [(2, 2.772), (3, 3.314), (5, 3.858), (10, 4.474), (20, 5.012), (60, 5.764)] {
            assert!((range_cdf(q, n) - 0.95).abs() < 3e-4, "n = {n}: {}", range_cdf(q, n));
        }
    }

    #[test]
    fn quantiles_undo_the_distribution() {
        assert!((normal_quantile(0.975) - 1.959_963_985).abs() < 1e-8);
        assert!((normal_cdf(1.644_853_627) - 0.95).abs() < 1e-9);
    }
}
