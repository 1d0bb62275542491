//! Whether values differ by more than their standard deviations say (Cochran 1954), and by how much (DerSimonian and
//! Laird, Controlled Clinical Trials 7, 1986).

use super::tails::chi2_tail;

/// Chance below which values differ by more than their standard deviations.
const BEYOND_NOISE: f64 = 0.05;

/// Sums over values of one or several quantities, each with a mean of its own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Scatter {
    /// Q, the sum of ((x - mean)/sd)^2 about the weighted mean.
    pub chi2: f64,
    pub dof: usize,
    /// sum w - sum w^2/sum w, w = 1/sd^2.
    weight: f64,
}

impl Scatter {
    /// Of one quantity: values with their standard deviations, two at least.
    pub fn of(values: &[(f64, f64)]) -> Option<Self> {
        let sum = |f: &dyn Fn(f64, f64) -> f64| values.iter().map(|(x, sd)| f(*x, sd.powi(-2))).sum::<f64>();
        let (s1, s2) = (sum(&|_, w| w), sum(&|_, w| w * w));
        let mean = sum(&|x, w| x * w) / s1;
        (values.len() > 1).then(|| Self {
            chi2: sum(&|x, w| w * (x - mean).powi(2)),
            dof: values.len() - 1,
            weight: s1 - s2 / s1,
        })
    }

    /// Both together: Q, degrees of freedom and weights add.
    pub fn plus(self, other: Self) -> Self {
        Self { chi2: self.chi2 + other.chi2, dof: self.dof + other.dof, weight: self.weight + other.weight }
    }

    /// P(chi-square >= Q) if the standard deviations hold.
    pub fn p_value(&self) -> Option<f64> {
        chi2_tail(self.chi2, self.dof)
    }

    /// tau, the standard deviation beside those that are stated: zero where Q is within chance.
    pub fn beyond(&self) -> f64 {
        let is_beyond = self.p_value().is_some_and(|p| p < BEYOND_NOISE);
        if is_beyond { ((self.chi2 - self.dof as f64) / self.weight).max(0.0).sqrt() } else { 0.0 }
    }
}
