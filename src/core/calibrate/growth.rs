//! Noise that grows with the rate, where no standard errors say so.
//!
//! A torquer's current is noisier the harder it works, so the mean of a fast dwell scatters more than that of a still
//! one. Without standard errors all dwells weigh the same; their variances are then taken as s^2 (1 + rho x),
//! x = (w_I/W)^2, with w_I the rate along the gyro's input axis and W the largest in the campaign. s belongs to the
//! gyro, rho is common. The estimate stays that of equal weights; only its covariance follows the variances.

use nalgebra::DVector;

/// Rounds of the fixed-point iteration; the change is below a per mille after five.
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
