//! The records of a history under every model of their noise, beside what is named.

use crate::core::numerics::basis::{Basis, dot};
use crate::core::numerics::log_sum::LogSum;
use crate::core::numerics::tails::{f_tail, squares_tail};

use super::answer::ExcessScatter;
use super::candidates::CandidateCause;
use super::noise::NoiseCovariance;

/// What is left is more than scatter where it is so many times as large as expected,
const EXCESSIVE: f64 = 3.0;
/// at this significance.
const EXCESS_REMAINS: f64 = 1e-4;

/// The rows under every noise model, with what is named projected out.
pub(super) struct FittedRows {
    pub models: Vec<NoiseCovariance>,
    bases: Vec<Basis>,
    pub left: Vec<Vec<f64>>,
    pub squares: Vec<f64>,
    pub n: usize,
    prior: NoisePrior,
}

/// What is known of the scale of the noise beforehand: as though so many degrees of freedom had given this variance.
#[derive(Debug, Clone, Copy)]
pub(super) struct NoisePrior {
    pub freedom: f64,
    pub variance: f64,
}

impl FittedRows {
    /// Rows `y` beside a level and `columns`, n each, under each model.
    pub fn of(models: Vec<NoiseCovariance>, y: &[f64], columns: &[&[f64]], prior: NoisePrior) -> Self {
        let n = y.len();
        let (mut bases, mut left, mut squares) = (Vec::new(), Vec::new(), Vec::new());
        for model in &models {
            let mut basis = Basis::of([model.whiten(&vec![1.0; n])]);
            for column in columns {
                basis.push(model.whiten(column));
            }
            let mut r = model.whiten(y);
            basis.project_out(&mut r);
            squares.push(dot(&r, &r));
            bases.push(basis);
            left.push(r);
        }
        Self { models, bases, left, squares, n, prior }
    }

    /// A column, whitened by a model, off the level and what is named.
    pub fn projected(&self, model: usize, white: &[f64]) -> Vec<f64> {
        let mut column = white.to_vec();
        self.bases[model].project_out(&mut column);
        column
    }

    /// ln L of a model that leaves so many whitened `squares`: -n/2 ln(squares/n) - 1/2 ln det V, with the prior's.
    pub fn ln_likelihood(&self, model: usize, squares: f64) -> f64 {
        let n = self.n as f64 + self.prior.freedom;
        -0.5 * n * ((squares + self.prior.freedom * self.prior.variance) / n).ln() - self.models[model].half_log_det
    }

    /// The model of the largest ln L.
    pub fn best(&self) -> (f64, usize) {
        let all = (0..self.models.len()).map(|m| (self.ln_likelihood(m, self.squares[m]), m));
        all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::NEG_INFINITY, 0))
    }

    /// ln of the likelihoods' mean over the models, white noise being as likely beforehand as all others together.
    pub fn mean(&self, of: impl Fn(usize) -> f64) -> f64 {
        let others = (self.models.len() - 1) as f64;
        let each = (0..self.models.len()).map(|m| of(m) - if m == 0 { 0.0 } else { others.ln() });
        LogSum::of(&each.collect::<Vec<f64>>()).log() - std::f64::consts::LN_2
    }

    /// ln L with what is named, as a mean over the models.
    pub fn evidence(&self) -> f64 {
        self.mean(|m| self.ln_likelihood(m, self.squares[m]))
    }

    /// Of a row of unit weight, where so many whitened `squares` are left.
    pub fn variance(&self, squares: f64) -> f64 {
        (squares + self.prior.freedom * self.prior.variance) / self.freedom()
    }

    /// White noise against what is known of its scale beforehand: F of the two variances.
    pub fn excess(&self) -> Option<ExcessScatter> {
        let freedom = self.n.checked_sub(self.parameters()).filter(|freedom| *freedom > 0)?;
        let (sd, expected) = ((self.squares[0] / freedom as f64).sqrt(), self.prior.variance.sqrt());
        let p_value = squares_tail(self.squares[0] / self.prior.variance, freedom, self.prior.freedom);
        (sd > EXCESSIVE * expected && p_value < EXCESS_REMAINS).then_some(ExcessScatter { sd, expected, p_value })
    }

    /// ln L under white noise.
    pub fn white(&self) -> f64 {
        self.ln_likelihood(0, self.squares[0])
    }

    /// The level and what is named.
    pub fn parameters(&self) -> usize {
        self.bases[0].rank()
    }

    /// Significance of `more` coefficients by which ln L rises by `gain`: F of that.
    pub fn significance(&self, gain: f64, more: f64) -> f64 {
        let (n, freedom) = (self.n as f64 + self.prior.freedom, self.freedom() - more);
        if gain > 0.0 { f_tail((2.0 * gain / n).exp_m1() * freedom / more, more, freedom) } else { 1.0 }
    }

    /// Degrees of freedom, the prior's included.
    pub fn freedom(&self) -> f64 {
        (self.n - self.parameters()).max(1) as f64 + self.prior.freedom
    }
}

/// The estimate of a whitened column beside what is named, and its information; none where nothing of it is left.
pub(super) fn along(fitted: &FittedRows, m: usize, white: &[f64]) -> Option<(f64, f64)> {
    let column = fitted.projected(m, white);
    let information = dot(&column, &column);
    (information > 1e-9 * dot(white, white)).then(|| (dot(&column, &fitted.left[m]) / information, information))
}

pub(super) fn whitened(fitted: &FittedRows, pool: &[CandidateCause]) -> Vec<Vec<Vec<f64>>> {
    pool.iter().map(|c| fitted.models.iter().map(|model| model.whiten(&c.column)).collect()).collect()
}
