//! Noise that grows with the rate, where no standard errors say so.
//!
//! A torquer's current is noisier the harder it works, so the mean of a fast dwell scatters more than that of a still
//! one. Without standard errors all dwells weigh the same; their variances are then taken as s^2 (1 + rho x),
//! x = (w_I/W)^2, with w_I the rate along the gyro's input axis and W the largest in the campaign. s belongs to the
//! gyro, rho is common. The estimate stays that of equal weights; only its covariance follows the variances.

use nalgebra::DVector;

/// Rounds of the fixed-point iteration. Where most dwells are at rest the answer is within 0.5 % then; with rates spread evenly it was 3 %
/// short (0.389 of 0.4).
const ROUNDS: usize = 12;

/// Residuals of one gyro's unweighted fit.
pub struct Unweighted<'a> {
    pub residuals: &'a DVector<f64>,
    pub leverage: &'a DVector<f64>,
    /// x of each dwell, 0 to 1.
    pub x: &'a DVector<f64>,
}

impl Unweighted<'_> {
    /// s^2: E(r^2) = s^2 sum v_k (1 - h_k), the trace of M V.
    pub fn variance(&self, rho: f64) -> f64 {
        let expected: f64 = self.x.iter().zip(self.leverage).map(|(x, h)| (1.0 + rho * x) * (1.0 - h)).sum();
        self.residuals.norm_squared() / expected
    }

    /// Degrees of freedom of that variance (Satterthwaite).
    pub fn dof(&self, rho: f64) -> f64 {
        let share = |(x, h): (&f64, &f64)| (1.0 + rho * x) * (1.0 - h);
        let first: f64 = self.x.iter().zip(self.leverage).map(share).sum();
        let second: f64 =
            self.x.iter().zip(self.leverage).map(|pair| share(pair).powi(2) / (1.0 - pair.1).max(1e-9)).sum();
        first * first / second
    }
}

/// rho >= 0, by least squares on the squared residuals with weights 1/v^2 (as their own scatter asks), all gyros
/// together. Zero where there is nothing to see it by.
pub fn growth(gyros: &[Unweighted]) -> f64 {
    let mut rho = 0.0;
    for _ in 0..ROUNDS {
        let (mut slope, mut curvature) = (0.0, 0.0);
        for gyro in gyros {
            let s2 = gyro.variance(rho);
            if s2 <= 0.0 || !s2.is_finite() {
                continue;
            }
            for ((r, h), x) in gyro.residuals.iter().zip(gyro.leverage).zip(gyro.x) {
                let left = 1.0 - h;
                if left > 1e-6 {
                    let weight = left / (1.0 + rho * x).powi(2);
                    slope += weight * x * (r * r / (s2 * left) - 1.0);
                    curvature += weight * x * x;
                }
            }
        }
        if curvature <= 0.0 {
            return 0.0;
        }
        rho = (slope / curvature).max(0.0);
    }
    rho
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    fn vector(n: usize, of: impl Fn(usize) -> f64) -> DVector<f64> {
        DVector::from_fn(n, |k, _| of(k))
    }

    /// Residuals whose squares are what s^2 (1 + rho x)(1 - h) expects.
    fn expected(s: f64, rho: f64, x: &DVector<f64>, h: &DVector<f64>) -> DVector<f64> {
        let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        vector(x.len(), |k| sign(k) * s * ((1.0 + rho * x[k]) * (1.0 - h[k])).sqrt())
    }

    #[test]
    fn the_growth_that_residuals_have_is_found_over_all_gyros() {
        // Most dwells are still, as in a campaign.
        let x = vector(30, |k| (k as f64 - 19.0).max(0.0) / 10.0);
        let other = vector(20, |k| ((k as f64 - 14.0).max(0.0) / 5.0).powi(2));
        let (h, more) = (vector(30, |k| 0.05 + 0.01 * k as f64), vector(20, |k| if k == 17 { 1.0 } else { 0.3 }));
        let zero = vector(20, |_| 0.0);
        for rho in [0.4, 6.0] {
            let (first, second) = (expected(0.02, rho, &x, &h), expected(7.0, rho, &other, &more));
            let gyros = [
                Unweighted { residuals: &first, leverage: &h, x: &x },
                Unweighted { residuals: &second, leverage: &more, x: &other },
                Unweighted { residuals: &zero, leverage: &more, x: &other },
            ];
            let found = growth(&gyros);
            assert!((found / rho - 1.0).abs() < 5e-3, "{found} is not {rho}");
            for (gyro, s) in gyros.iter().zip([0.02_f64, 7.0]) {
                assert!((gyro.variance(rho) / (s * s) - 1.0).abs() < 1e-12);
            }
        }
        let quieter = expected(0.02, -0.5, &x, &h);
        assert_eq!(growth(&[Unweighted { residuals: &quieter, leverage: &h, x: &x }]), 0.0, "noise does not shrink");
        let still = vector(30, |_| 0.0);
        assert_eq!(growth(&[Unweighted { residuals: &quieter, leverage: &h, x: &still }]), 0.0, "nothing turned");
    }

    #[test]
    fn the_degrees_of_freedom_weigh_each_residual_by_what_it_is_expected_to_be() {
        // Shares 1 x 0.5 and 2 x 0.75; (0.5 + 1.5)^2 / (0.5^2/0.5 + 1.5^2/0.75) = 4/3.5.
        let (residuals, x) = (vector(2, |_| 1.0), vector(2, |k| k as f64));
        let gyro = Unweighted { residuals: &residuals, leverage: &vector(2, |k| [0.5, 0.25][k]), x: &x };
        assert!((gyro.dof(1.0) - 4.0 / 3.5).abs() < 1e-12, "{}", gyro.dof(1.0));
    }

    #[test]
    fn variance_and_degrees_of_freedom_are_those_of_the_full_matrices() {
        // A mean of n: M = 1 - 1/n, s^2 = r'r/tr(MV), and with equal variances tr(M) = n - 1 degrees of freedom.
        let n = 12;
        let (rho, x) = (3.0, vector(12, |k| (k as f64 / 11.0).powi(2)));
        let m = DMatrix::identity(n, n) - DMatrix::from_element(n, n, 1.0 / n as f64);
        let v = DMatrix::from_diagonal(&x.map(|x| 1.0 + rho * x));
        let residuals = &m * vector(12, |k| (7.3 * k as f64).sin());
        let leverage = vector(12, |_| 1.0 / 12.0);
        let gyro = Unweighted { residuals: &residuals, leverage: &leverage, x: &x };
        let trace = (&m * &v).trace();
        assert!((gyro.variance(rho) - residuals.norm_squared() / trace).abs() < 1e-12);
        assert!((gyro.dof(0.0) - 11.0).abs() < 1e-12);
        // Satterthwaite has tr(MV)^2/tr(MVMV); the sum over the dwells is that but for terms of the order of 1/n.
        let exact = trace * trace / (&m * &v * &m * &v).trace();
        assert!((gyro.dof(rho) / exact - 1.0).abs() < 0.5 / n as f64, "{} {exact}", gyro.dof(rho));
    }
}
