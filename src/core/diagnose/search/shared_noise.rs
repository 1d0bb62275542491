//! Noise that gyros share: one supply, one table, one room.
//!
//! Residuals r_j of each gyro, whitened by its own noise and off its own design, S_ij = r_i'r_j, nu degrees of freedom
//! each. Their covariance is free with a prior of k observations of independent unit noise (inverse Wishart), so that
//! an entry whose fits are f_j in all gyros has, with D_ij = (f_i'r_j + r_i'f_j)/2,
//!
//! ```text
//! ln B(all)    = -(nu+k)/2 ln[det(k + S - D)/det(k + S)] - 1/2 sum ln det(1 + g U_j'U_j)
//! ln B(subset) = the same with the members' determinants alone, less 1/2 sum over N of (R_NN)^-1_ij D_ij
//! ```
//!
//! R = (k + S - D)/(k + nu), N the gyros outside the subset (Bayesian multivariate regression, Box and Tiao 1973, 8.2;
//! N's part of the fit counts at the noise that is left).

use std::ops::Range;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use statrs::function::gamma::ln_gamma;

use super::bayes_factor::Score;
use super::hypotheses::{Bank, Block, Hypothesis, SMALL};
use super::projections::{GyroStatistics, MAX_GYROS, Products, State};
use crate::core::diagnose::residuals::pooled_noise::{Scatter, pool};
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::effects::Effect;
use crate::core::numerics::log_sum::LogSum;

/// Observations of independent unit noise that the prior is worth.
const K: f64 = 10.0;

/// Mean square of a gyro's residuals from which on they are no noise: what is common to gyros is then an effect that is
/// not in the model yet.
const NO_NOISE: f64 = 2.5;

/// How often R is found anew for coefficients that all gyros share.
const ROUNDS: usize = 3;

/// Noise that gyros share, under one set of adopted columns.
#[derive(Debug, Clone)]
pub(crate) struct Shared {
    gyros: usize,
    /// S; zero beyond the gyros.
    products: Matrix3<f64>,
    nu: f64,
    /// ln of the odds by which the residuals are likelier under a free covariance than under independent noise.
    pub log_gain: f64,
    /// Residuals of all gyros side by side, over `unit`.
    residuals: DMatrix<f64>,
    /// Their root mean square where no errors are stated.
    unit: f64,
}

impl Shared {
    /// Of the residuals under `state`, n x gyros. Where no errors are stated they are first brought to a mean square of
    /// one.
    pub fn of(frame: &Frame, state: &State) -> Self {
        let columns: Vec<DVector<f64>> = state.iter().map(|g| DVector::from_column_slice(&g.residual)).collect();
        let mut residuals = DMatrix::from_columns(&columns);
        let gyros = state.len();
        let dof = |j: usize| frame.gyros[j].dof().saturating_sub(state[j].extra.basis.rank()).max(1) as f64;
        let nu = (0..gyros).map(dof).sum::<f64>() / gyros as f64;
        let mut unit = 1.0;
        if !frame.noise.stated {
            let mean_square: f64 = residuals.norm_squared() / (nu * gyros as f64);
            unit = mean_square.sqrt().max(f64::MIN_POSITIVE);
            residuals.unscale_mut(unit);
        }
        let mut products = Matrix3::zeros();
        products.view_mut((0, 0), (gyros, gyros)).copy_from(&residuals.tr_mul(&residuals));
        let mut shared = Self { gyros, products, nu, log_gain: 0.0, residuals, unit };
        shared.log_gain = shared.gain();
        shared
    }

    fn gain(&self) -> f64 {
        let (p, nu) = (self.gyros, self.nu);
        let (a, b) = (0.5 * (nu + K), 0.5 * K);
        // What k adds beyond the gyros is one to both.
        let beyond = (MAX_GYROS - p) as f64 * K.ln();
        let free = ln_gamma_of_matrix(p, a) - ln_gamma_of_matrix(p, b) + b * p as f64 * K.ln()
            - a * (ln_det(&self.left(&Matrix3::zeros())) - beyond);
        let of_scale =
            |rss: f64, nu: f64| ln_gamma(0.5 * (nu + K)) - ln_gamma(b) + b * K.ln() - 0.5 * (nu + K) * (K + rss).ln();
        let own = self.products.diagonal();
        let mut scatter: Vec<Scatter> = own.iter().take(p).map(|rss| Scatter { rss: *rss, nu }).collect();
        let independent: f64 = match pool(&mut scatter) {
            true => of_scale(own.sum(), nu * p as f64),
            false => own.iter().take(p).map(|rss| of_scale(*rss, nu)).sum(),
        };
        free - independent
    }

    /// Whether no gyro's whitened residuals have a square sum beyond `NO_NOISE` times what noise would give them.
    pub fn is_of_noise(&self) -> bool {
        self.products.diagonal().max() < NO_NOISE * self.nu
    }

    /// k + S - D.
    fn left(&self, taken: &Matrix3<f64>) -> Matrix3<f64> {
        Matrix3::from_diagonal_element(K) + self.products - taken
    }

    /// Correlation of the residuals of two gyros.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        self.products[(i, j)] / (self.products[(i, i)] * self.products[(j, j)]).sqrt()
    }

    /// Residuals without what they share: turned by the inverse root of their correlation.
    pub fn apart(&self, residuals: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let p = residuals.len();
        let length = |j: usize| self.products[(j, j)].sqrt().max(f64::MIN_POSITIVE);
        let mut axes = DMatrix::from_fn(p, p, |i, j| self.correlation(i, j)).symmetric_eigen();
        axes.eigenvalues.apply(|x| *x = 1.0 / x.max(1e-6).sqrt());
        let root = axes.recompose();
        let turned = |i: usize| {
            let mut sum = vec![0.0; residuals[i].len()];
            for j in 0..p {
                let share = root[(i, j)] * length(i) / length(j);
                sum.iter_mut().zip(&residuals[j]).for_each(|(sum, r)| *sum += share * r);
            }
            sum
        };
        (0..p).map(turned).collect()
    }

    /// Evidence of every kind of the bank, from the products of all its columns under the same `state`.
    pub fn scores(&self, bank: &Bank, state: &State, products: &Products) -> Vec<Score> {
        let all = self.side_by_side(bank, state, products);
        bank.kinds.iter().map(|(kind, range)| self.score(bank, *kind, range.clone(), &all)).collect()
    }

    fn side_by_side<'a>(&self, bank: &Bank, state: &'a State, products: &'a Products) -> JointStatistics<'a> {
        let mut across = products.across(bank, state);
        across.iter_mut().for_each(|across| across.unscale_mut(self.unit));
        JointStatistics { state, seen: products.seen(), across }
    }

    fn score(&self, bank: &Bank, kind: Effect, range: Range<usize>, all: &JointStatistics) -> Score {
        let mut score = Score { kind, log_evidence: f64::NEG_INFINITY, best: range.start, gyro_log: [0.0; MAX_GYROS] };
        let mut total = LogSum::default();
        let mut best = f64::NEG_INFINITY;
        for i in range {
            let hypothesis = &bank.hypotheses[i];
            let log = hypothesis.log_weight
                + match hypothesis.common {
                    true => self.common(bank, hypothesis, all.state),
                    false => self.of_sets(hypothesis, all, |_| true),
                };
            if log > best {
                (best, score.best) = (log, i);
            }
            total.add(log);
        }
        let hypothesis = &bank.hypotheses[score.best];
        for (j, log) in score.gyro_log.iter_mut().enumerate().take(self.gyros) {
            *log = match hypothesis.common {
                true => best - hypothesis.log_weight,
                false => self.membership(hypothesis, all, j),
            };
        }
        score.log_evidence = total.log();
        score
    }

    /// Evidence of hypotheses in exactly the gyros `members`, one of the equally likely sets, from the products of their
    /// columns.
    pub fn in_members(
        &self,
        bank: &Bank,
        hypotheses: &[Hypothesis],
        members: &[bool],
        state: &State,
        products: &Products,
    ) -> f64 {
        let all = self.side_by_side(bank, state, products);
        let wanted: usize = (0..self.gyros).filter(|&j| members[j]).map(|j| 1 << j).sum();
        let sets = (1 << self.gyros) - 1;
        let mut total = LogSum::default();
        for hypothesis in hypotheses {
            let log = match hypothesis.common {
                true => self.common(bank, hypothesis, state),
                false => self.of_sets(hypothesis, &all, |set| set == wanted) - f64::from(sets).ln(),
            };
            total.add(hypothesis.log_weight + log);
        }
        total.log()
    }

    /// ln of the mean of B over those sets of gyros that count, and over the powers.
    fn of_sets(&self, hypothesis: &Hypothesis, all: &JointStatistics, counts: impl Fn(usize) -> bool) -> f64 {
        let mut total = LogSum::default();
        let mut count = 0;
        for power in 0..hypothesis.powers.len() {
            let fitted = self.fitted(hypothesis, power, all);
            for set in (1..1 << self.gyros).filter(|set| counts(*set)) {
                total.add(fitted.in_set(self, set));
                count += 1;
            }
        }
        total.log_mean(count)
    }

    /// ln of the odds that gyro `j` has it: of the sets that hold it against those that do not.
    fn membership(&self, hypothesis: &Hypothesis, all: &JointStatistics, j: usize) -> f64 {
        let (mut with, mut without) = (LogSum::default(), LogSum::default());
        for power in 0..hypothesis.powers.len() {
            let fitted = self.fitted(hypothesis, power, all);
            without.add(0.0);
            for set in 1..1 << self.gyros {
                let log = fitted.in_set(self, set);
                if set >> j & 1 == 1 { with.add(log) } else { without.add(log) }
            }
        }
        with.log() - without.log()
    }

    fn fitted(&self, hypothesis: &Hypothesis, power: usize, all: &JointStatistics) -> Fitted {
        let g = hypothesis.powers[power];
        let mut taken = Matrix3::zeros();
        let mut penalties = [0.0; MAX_GYROS];
        for (i, (block, seen)) in hypothesis.blocks.iter().zip(&all.seen).enumerate() {
            if block.len == 0 {
                continue;
            }
            let across = &all.across[i];
            let (coefficients, penalty) = coefficients(block, seen, g, across, i);
            penalties[i] = penalty;
            for j in 0..self.gyros {
                let along: f64 = coefficients.iter().enumerate().map(|(c, x)| x * across[(j, block.start + c)]).sum();
                taken[(i, j)] += 0.5 * along;
                taken[(j, i)] += 0.5 * along;
            }
        }
        let left = self.left(&taken);
        let all = -0.5 * (self.nu + K) * (ln_det(&left) - ln_det(&self.left(&Matrix3::zeros())));
        Fitted { all, taken, noise: left / (self.nu + K), penalties }
    }

    /// ln B of coefficients that all gyros share: generalised least squares with the covariance that they leave.
    fn common(&self, bank: &Bank, hypothesis: &Hypothesis, state: &State) -> f64 {
        let p = self.gyros;
        let n = self.residuals.nrows();
        let Some(size) = hypothesis.blocks.iter().map(|block| block.len).max().filter(|len| *len > 0) else {
            return 0.0;
        };
        let off = |i: usize| {
            let block = &hypothesis.blocks[i];
            if block.len < size {
                return DMatrix::zeros(n, size);
            }
            let columns = bank.columns[i].columns(block.start, size);
            let adopted = state[i].extra.basis.matrix(n);
            columns - &adopted * adopted.tr_mul(&columns)
        };
        let columns: Vec<DMatrix<f64>> = (0..p).map(off).collect();
        let gram = |i: usize, j: usize| columns[i].tr_mul(&columns[j]);
        let side = |i: usize, j: usize| columns[i].tr_mul(&self.residuals.column(j));
        let grams: Vec<Vec<DMatrix<f64>>> = (0..p).map(|i| (0..p).map(|j| gram(i, j)).collect()).collect();
        let sides: Vec<Vec<DVector<f64>>> = (0..p).map(|i| (0..p).map(|j| side(i, j)).collect()).collect();
        let none = ln_det(&self.left(&Matrix3::zeros()));
        let mut sum = LogSum::default();
        for &power in hypothesis.powers {
            let (mut taken, mut penalty) = (Matrix3::zeros(), 0.0);
            for _ in 0..ROUNDS {
                let Some(weights) = (self.left(&taken) / (self.nu + K)).cholesky().map(|factor| factor.inverse())
                else {
                    break;
                };
                let mut system = DMatrix::identity(size, size) / power;
                let mut along = DVector::zeros(size);
                for i in 0..p {
                    for j in 0..p {
                        system += &grams[i][j] * weights[(i, j)];
                        along += &sides[i][j] * weights[(i, j)];
                    }
                }
                let Some(factor) = system.cholesky() else { break };
                let estimate = factor.solve(&along);
                penalty =
                    0.5 * (factor.ln_determinant() + size as f64 * power.ln()) + 0.5 * estimate.norm_squared() / power;
                for i in 0..p {
                    for j in 0..p {
                        taken[(i, j)] = sides[i][j].dot(&estimate) + sides[j][i].dot(&estimate)
                            - estimate.dot(&(&grams[i][j] * &estimate));
                    }
                }
            }
            sum.add(-0.5 * (self.nu + K) * (ln_det(&self.left(&taken)) - none) - penalty);
        }
        sum.log_mean(hypothesis.powers.len())
    }
}

/// (U'U + 1/g)^-1 U'r of one gyro's block, and ln det(1 + g U'U).
fn coefficients(block: &Block, seen: &GyroStatistics, g: f64, across: &DMatrix<f64>, own: usize) -> (Vec<f64>, f64) {
    let side = |c: usize| across[(own, block.start + c)];
    if seen.adopted == 0 {
        let of = |c: usize| g * side(c) / (1.0 + g * block.length(c));
        let penalty = (0..block.len).map(|c| (g * block.length(c)).ln_1p()).sum();
        return ((0..block.len).map(of).collect(), penalty);
    }
    if block.len <= SMALL {
        let sides = Vector3::from_fn(|c, _| if c < block.len { side(c) } else { 0.0 });
        let Some(factor) = (Matrix3::identity() + g * seen.gram(block)).cholesky() else { return (Vec::new(), 0.0) };
        let solved = factor.solve(&sides) * g;
        return (solved.iter().take(block.len).copied().collect(), factor.ln_determinant());
    }
    let system = DMatrix::from_fn(block.len, block.len, |a, b| {
        let taken: f64 = seen.taken(block.start + a).iter().zip(seen.taken(block.start + b)).map(|(x, y)| x * y).sum();
        let own = if a == b { 1.0 + g * block.length(a) } else { 0.0 };
        own - g * taken
    });
    let Some(factor) = system.cholesky() else { return (Vec::new(), 0.0) };
    let solved = factor.solve(&DVector::from_fn(block.len, |c, _| side(c))) * g;
    (solved.iter().copied().collect(), factor.ln_determinant())
}

/// Of a positive definite matrix; what rounding makes less than nothing is nothing.
fn ln_det(matrix: &Matrix3<f64>) -> f64 {
    matrix.determinant().max(1e-9).ln()
}

/// ln of the multivariate gamma function of dimension `p`.
fn ln_gamma_of_matrix(p: usize, a: f64) -> f64 {
    let dimension = p as f64;
    let of_each: f64 = (0..p).map(|i| ln_gamma(a - 0.5 * i as f64)).sum();
    0.25 * dimension * (dimension - 1.0) * std::f64::consts::PI.ln() + of_each
}

/// What the evidence of gyros that share noise is made of.
struct JointStatistics<'a> {
    state: &'a State,
    seen: Vec<GyroStatistics<'a>>,
    /// [`Products::across`] over the unit of the residuals.
    across: Vec<DMatrix<f64>>,
}

/// A hypothesis fitted in every gyro.
struct Fitted {
    all: f64,
    taken: Matrix3<f64>,
    /// R.
    noise: Matrix3<f64>,
    /// ln det(1 + g U'U) of each gyro.
    penalties: [f64; MAX_GYROS],
}

impl Fitted {
    /// ln B with the gyros of a set, bit by bit.
    fn in_set(&self, shared: &Shared, set: usize) -> f64 {
        let is_member = |j: &usize| set >> j & 1 == 1;
        let penalty: f64 = (0..shared.gyros).filter(is_member).map(|j| self.penalties[j]).sum();
        let outside: Vec<usize> = (0..shared.gyros).filter(|j| !is_member(j)).collect();
        let (d, r) = (&self.taken, &self.noise);
        let lost = match outside[..] {
            [i] => d[(i, i)] / r[(i, i)],
            [i, j] => {
                let det = r[(i, i)] * r[(j, j)] - r[(i, j)] * r[(j, i)];
                (d[(i, i)] * r[(j, j)] + d[(j, j)] * r[(i, i)] - 2.0 * d[(i, j)] * r[(i, j)]) / det
            }
            _ => 0.0,
        };
        self.all - 0.5 * penalty - 0.5 * lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gamma_function_of_a_matrix_is_the_published_product() {
        assert!((ln_gamma_of_matrix(1, 4.5) - ln_gamma(4.5)).abs() < 1e-12);
        // Gamma_2(a) = sqrt(pi) Gamma(a) Gamma(a - 1/2) (Muirhead 1982, theorem 2.1.12).
        let two = 0.5 * std::f64::consts::PI.ln() + ln_gamma(5.0) + ln_gamma(4.5);
        assert!((ln_gamma_of_matrix(2, 5.0) - two).abs() < 1e-12);
    }
}
