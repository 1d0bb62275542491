//! How the noise of a dwell's mean goes with rate and duration, where no standard errors say so.
//!
//! A torquer's current is noisier the harder it works, so the mean of a fast dwell scatters more than that of a still
//! one; and a mean over a longer time scatters less, if the noise is white. Without standard errors all dwells weigh
//! the same; their variances are then taken as s^2 (1 + rho x) duration^-p, x = (w_I/W)^2, with w_I the rate along
//! the gyro's input axis and W the largest in the campaign. s belongs to the gyro, rho and p (0 or 1) are common. The
//! estimate stays that of equal weights; only its covariance follows the variances.

use nalgebra::{DVector, Vector3};

use crate::core::numerics::tails::chi2_tail;

/// Rates up to this are the Earth's and the table's creep, arcsec/s.
pub(super) const SLOW_ARCSEC_S: f64 = 20.0;

/// Share by which durations must differ to say anything of p.
const OTHER_DURATION: f64 = 0.2;

/// Variance of a dwell's mean up to a factor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NoiseGrowth {
    /// rho: by how much the variance at the fastest rate exceeds that at rest.
    pub growth: f64,
    /// p: power with which it falls with duration.
    pub fall: f64,
}

impl NoiseGrowth {
    /// That of each dwell, over that of the first one's duration at rest.
    pub fn variances(&self, dwells: &Exposure) -> DVector<f64> {
        dwells.rate.zip_map(&dwells.duration, |x, duration| (1.0 + self.growth * x) * duration.powf(-self.fall))
    }
}

/// What the law takes of one gyro's dwells.
#[derive(Debug, Clone, PartialEq)]
pub struct Exposure {
    /// x of each dwell, 0 to 1; zeros where the table never turned.
    pub rate: DVector<f64>,
    /// Over that of the first dwell.
    pub duration: DVector<f64>,
}

impl Exposure {
    /// Of dwells with these rates (arcsec/s) and durations, for a gyro with this input axis; the whole rate counts
    /// where that is unknown.
    pub fn of(rates: &[Vector3<f64>], durations: &[f64], input: Option<&Vector3<f64>>) -> Self {
        let largest = rates.iter().map(|w| w.norm()).fold(0.0, f64::max);
        let share = |w: &Vector3<f64>| (input.map_or(w.norm(), |input| input.dot(w)) / largest).powi(2);
        let turns = largest > SLOW_ARCSEC_S;
        Self {
            rate: DVector::from_iterator(rates.len(), rates.iter().map(|w| if turns { share(w) } else { 0.0 })),
            duration: DVector::from_iterator(durations.len(), durations.iter().map(|d| d / durations[0])),
        }
    }

    /// Values of p that these durations let tell apart.
    pub fn falls(&self) -> &'static [f64] {
        let differ = self.duration.iter().any(|d| (d - 1.0).abs() > OTHER_DURATION);
        if differ { &[0.0, 1.0] } else { &[0.0] }
    }
}

/// Rounds of the fixed-point iteration. Where most dwells are at rest the answer is within 0.5 % then; with rates
/// spread evenly it was 3 % short (0.389 of 0.4).
const ROUNDS: usize = 12;

/// Residuals of one gyro's unweighted fit.
pub struct Unweighted<'a> {
    pub residuals: &'a DVector<f64>,
    pub leverage: &'a DVector<f64>,
    pub dwells: &'a Exposure,
}

impl Unweighted<'_> {
    /// s^2: E(r^2) = s^2 sum v_k (1 - h_k), the trace of M V.
    pub fn variance(&self, law: NoiseGrowth) -> f64 {
        self.residuals.norm_squared() / self.shares(law).sum()
    }

    /// Degrees of freedom of that variance (Satterthwaite).
    pub fn dof(&self, law: NoiseGrowth) -> f64 {
        let shares = self.shares(law);
        let second: f64 = shares.zip_map(self.leverage, |share, h| share * share / (1.0 - h).max(1e-9)).sum();
        shares.sum().powi(2) / second
    }

    fn shares(&self, law: NoiseGrowth) -> DVector<f64> {
        law.variances(self.dwells).zip_map(self.leverage, |v, h| v * (1.0 - h))
    }

    /// Log-likelihood of the residuals, their scale at its best.
    fn log_likelihood(&self, law: NoiseGrowth) -> f64 {
        let seen = law.variances(self.dwells).zip_map(self.leverage, |v, h| (v, 1.0 - h));
        let (mut squares, mut logs, mut count) = (0.0, 0.0, 0.0);
        for (r, (v, left)) in self.residuals.iter().zip(&seen).filter(|(_, (_, left))| *left > 1e-6) {
            squares += r * r / (v * left);
            logs += v.ln();
            count += 1.0;
        }
        if squares > 0.0 { -0.5 * (count * (squares / count).ln() + logs) } else { 0.0 }
    }
}

/// The likelier law, all gyros together.
pub fn law(gyros: &[Unweighted]) -> NoiseGrowth {
    let falls = gyros.first().map_or(&[0.0][..], |gyro| gyro.dwells.falls());
    let laws = falls.iter().map(|&fall| NoiseGrowth { growth: growth(gyros, fall), fall });
    let likelihood = |law: &NoiseGrowth| gyros.iter().map(|gyro| gyro.log_likelihood(*law)).sum::<f64>();
    laws.max_by(|a, b| likelihood(a).total_cmp(&likelihood(b))).unwrap_or_default()
}

/// Chance of residuals that speak so much for the growth of `law` where there is none: of the likelihood ratio, half
/// of a chi-square of one degree of freedom (Self and Liang, J. Am. Stat. Assoc. 82, 1987), as rho is never below 0.
pub fn chance(gyros: &[Unweighted], law: NoiseGrowth) -> f64 {
    let even = NoiseGrowth { growth: 0.0, ..law };
    let gain: f64 = gyros.iter().map(|gyro| gyro.log_likelihood(law) - gyro.log_likelihood(even)).sum();
    chi2_tail(2.0 * gain.max(0.0), 1).map_or(1.0, |tail| 0.5 * tail)
}

/// rho >= 0, by least squares on the squared residuals with weights 1/v^2 (as their own scatter asks), all gyros
/// together. Zero where there is nothing to see it by.
fn growth(gyros: &[Unweighted], fall: f64) -> f64 {
    let mut law = NoiseGrowth { growth: 0.0, fall };
    for _ in 0..ROUNDS {
        let (mut slope, mut curvature) = (0.0, 0.0);
        for gyro in gyros {
            let s2 = gyro.variance(law);
            if s2 <= 0.0 || !s2.is_finite() {
                continue;
            }
            let still = NoiseGrowth { growth: 0.0, fall }.variances(gyro.dwells);
            for (k, r) in gyro.residuals.iter().enumerate() {
                let (left, x) = (1.0 - gyro.leverage[k], gyro.dwells.rate[k]);
                if left > 1e-6 {
                    let weight = left / (1.0 + law.growth * x).powi(2);
                    slope += weight * x * (r * r / (s2 * left * still[k]) - 1.0);
                    curvature += weight * x * x;
                }
            }
        }
        if curvature <= 0.0 {
            return 0.0;
        }
        law.growth = (slope / curvature).max(0.0);
    }
    law.growth
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    fn vector(n: usize, of: impl Fn(usize) -> f64) -> DVector<f64> {
        DVector::from_fn(n, |k, _| of(k))
    }

    /// Dwells of these shares of the largest rate, the last `long` of them four times as long as the others.
    fn dwells(rate: DVector<f64>, long: usize) -> Exposure {
        let n = rate.len();
        Exposure { rate, duration: vector(n, |k| if k + long < n { 1.0 } else { 4.0 }) }
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
            let (x, other) = (dwells(x.clone(), 0), dwells(other.clone(), 0));
            let gyros = [
                Unweighted { residuals: &first, leverage: &h, dwells: &x },
                Unweighted { residuals: &second, leverage: &more, dwells: &other },
                Unweighted { residuals: &zero, leverage: &more, dwells: &other },
            ];
            let found = law(&gyros);
            assert!((found.growth / rho - 1.0).abs() < 5e-3 && found.fall == 0.0, "{found:?} is not {rho}");
            for (gyro, s) in gyros.iter().zip([0.02_f64, 7.0]) {
                let s2 = gyro.variance(NoiseGrowth { growth: rho, fall: 0.0 });
                assert!((s2 / (s * s) - 1.0).abs() < 1e-12);
            }
        }
        let quieter = expected(0.02, -0.5, &x, &h);
        let alone = |dwells: &Exposure| law(&[Unweighted { residuals: &quieter, leverage: &h, dwells }]).growth;
        assert_eq!(alone(&dwells(x, 0)), 0.0, "noise does not shrink");
        assert_eq!(alone(&dwells(vector(30, |_| 0.0), 0)), 0.0, "nothing turned");
    }

    #[test]
    fn residuals_that_scatter_are_weighed_by_the_variance_that_they_are_expected_to_have() {
        // As in a campaign, but every other dwell is louder by half than the law has it, and those between quieter.
        let (x, h) = (vector(30, |k| (k as f64 - 19.0).max(0.0) / 10.0), vector(30, |k| 0.05 + 0.01 * k as f64));
        let scattered = |k: usize| if k.is_multiple_of(2) { 1.5 } else { 0.6 } + if k == 29 { 1.5 } else { 0.0 };
        let residuals = expected(0.02, 3.0, &x, &h).component_mul(&vector(30, scattered));
        let dwells = dwells(x.clone(), 0);
        let gyro = Unweighted { residuals: &residuals, leverage: &h, dwells: &dwells };
        let found = law(std::slice::from_ref(&gyro));
        // Least squares on r^2/(1 - h) = s^2 (1 + rho x), whose variance is as v^2/(1 - h): a fixed point of it.
        let s2 = gyro.variance(found);
        let weights = vector(30, |k| (1.0 - h[k]) / (1.0 + found.growth * x[k]).powi(2));
        let above = vector(30, |k| residuals[k].powi(2) / (s2 * (1.0 - h[k])) - 1.0);
        let again = weights.component_mul(&x).dot(&above) / weights.dot(&x.component_mul(&x));
        assert!((found.growth / again - 1.0).abs() < 0.02, "{} is not {again}", found.growth);
    }

    #[test]
    fn noise_that_falls_with_duration_is_told_from_noise_that_grows_with_rate() {
        // The fast dwells are the long ones: by rate alone their noise would seem not to grow.
        let (x, h) = (vector(30, |k| (k as f64 - 19.0).max(0.0) / 10.0), vector(30, |_| 0.1));
        let even = expected(0.02, 3.0, &x, &h);
        for (fall, long) in [(0.0, 14), (1.0, 14), (0.0, 0)] {
            let dwells = dwells(x.clone(), long);
            let residuals = even.zip_map(&dwells.duration, |r, d| r * d.powf(-0.5 * fall));
            let found = law(&[Unweighted { residuals: &residuals, leverage: &h, dwells: &dwells }]);
            assert!((found.growth / 3.0 - 1.0).abs() < 5e-3 && found.fall == fall, "{found:?}");
            let v = found.variances(&dwells);
            assert!((v[29] / v[0] - (1.0 + found.growth) * dwells.duration[29].powf(-fall)).abs() < 1e-12);
        }
    }

    #[test]
    fn the_rate_that_counts_is_along_the_input_axis_over_the_largest_of_all() {
        let rates = [Vector3::new(0.0, 0.0, 40.0), Vector3::new(30.0, 0.0, 0.0), Vector3::new(0.0, 10.0, 0.0)];
        let found = Exposure::of(&rates, &[100.0, 150.0, 119.0], Some(&Vector3::x()));
        assert_eq!(
            (found.rate, found.duration),
            (vector(3, |k| [0.0, 0.5625, 0.0][k]), vector(3, |k| [1.0, 1.5, 1.19][k]))
        );
        let whole = Exposure::of(&rates, &[100.0, 81.0, 119.0], None);
        assert_eq!((whole.rate[2], whole.falls()), (0.0625, &[0.0][..]));
        let slow = Exposure::of(&rates.map(|w| 0.5 * w), &[100.0, 79.0, 100.0], None);
        assert_eq!((slow.falls(), slow.rate), (&[0.0, 1.0][..], vector(3, |_| 0.0)), "the table crept");
    }

    #[test]
    fn the_degrees_of_freedom_weigh_each_residual_by_what_it_is_expected_to_be() {
        // Shares 1 x 0.5 and 2 x 0.75; (0.5 + 1.5)^2 / (0.5^2/0.5 + 1.5^2/0.75) = 4/3.5.
        let (residuals, x) = (vector(2, |_| 1.0), vector(2, |k| k as f64));
        let dwells = dwells(x, 0);
        let gyro = Unweighted { residuals: &residuals, leverage: &vector(2, |k| [0.5, 0.25][k]), dwells: &dwells };
        let dof = gyro.dof(NoiseGrowth { growth: 1.0, fall: 0.0 });
        assert!((dof - 4.0 / 3.5).abs() < 1e-12, "{dof}");
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
        let dwells = dwells(x, 5);
        let law = NoiseGrowth { growth: rho, fall: 1.0 };
        let v = v * DMatrix::from_diagonal(&dwells.duration.map(|d| 1.0 / d));
        let gyro = Unweighted { residuals: &residuals, leverage: &leverage, dwells: &dwells };
        let trace = (&m * &v).trace();
        assert!((gyro.variance(law) - residuals.norm_squared() / trace).abs() < 1e-12);
        assert!((gyro.dof(NoiseGrowth::default()) - 11.0).abs() < 1e-12);
        // Satterthwaite has tr(MV)^2/tr(MVMV); the sum over the dwells is that but for terms of the order of 1/n.
        let exact = trace * trace / (&m * &v * &m * &v).trace();
        assert!((gyro.dof(law) / exact - 1.0).abs() < 0.5 / n as f64, "{} {exact}", gyro.dof(law));
    }
}
