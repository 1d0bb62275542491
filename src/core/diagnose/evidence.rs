//! How strongly the residuals speak for each hypothesis: Bayes factors against the model in use.
//!
//! For one gyro with `nu` degrees of freedom, residual sum of squares `R`, projected columns `U` (m of them) and a
//! prior of power `g` per coefficient and noise variance (Zellner's g-prior; scale of the noise unknown), averaged over two or three values of `g`,
//!
//! ```text
//! ln B = -1/2 ln det(1 + g U'U) - nu/2 ln(1 - b'(U'U + 1/g)^-1 b / R),   b = U'r
//! ```
//!
//! A gyro has the effect with probability one half before the data speak, so gyros multiply as (1 + B_j)/2; values of
//! a non-linear parameter average with their weights. The penalty for flexible entries is thus no choice of ours.

use nalgebra::{Cholesky, DMatrix, DVector, DVectorView, Dyn};

use super::bank::{Bank, Block, Hypothesis, Kind, basis_matrix};
use super::basis::{Basis, dot};
use super::floor::STATED_DOF;
use super::frame::Frame;

/// Residuals of one gyro under the model and what has been adopted so far.
#[derive(Debug, Clone)]
pub(super) struct GyroState {
    /// Adopted columns, orthonormal and orthogonal to the model's.
    pub extra: Basis,
    pub residual: Vec<f64>,
    /// Sum of squares and degrees of freedom, stated errors counted in.
    pub rss: f64,
    pub nu: f64,
}

/// An IMU's gyros.
pub(super) const MAX_GYROS: usize = 3;

pub(super) type State = Vec<GyroState>;

/// One kind's evidence given a state.
#[derive(Debug, Clone)]
pub(super) struct Score {
    pub kind: Kind,
    pub log_evidence: f64,
    /// Index of the hypothesis that weighs most.
    pub best: usize,
    /// ln B of each gyro for the best hypothesis (of all gyros together, at every place, for a common one).
    pub gyro_log: [f64; MAX_GYROS],
}

/// The model in use with further columns adopted.
pub(super) fn state(frame: &Frame, extras: Vec<Basis>) -> State {
    let prior = if frame.noise.stated { STATED_DOF } else { 0.0 };
    frame
        .gyros
        .iter()
        .zip(extras)
        .map(|(gyro, extra)| {
            let mut residual = gyro.residual.clone();
            extra.project_out(&mut residual);
            let dof = (gyro.dof() - extra.rank().min(gyro.dof())) as f64;
            GyroState { rss: prior + dot(&residual, &residual), nu: prior + dof, residual, extra }
        })
        .collect()
}

/// Products of every column of the bank with residuals and adopted columns.
pub(super) struct Products {
    with_extra: Vec<DMatrix<f64>>,
    with_residual: Vec<DVector<f64>>,
}

impl Products {
    pub fn of(bank: &Bank, state: &State) -> Self {
        let extra = |gyro: &GyroState| basis_matrix(gyro.extra.vectors(), gyro.residual.len());
        Self {
            with_extra: state.iter().zip(&bank.columns).map(|(gyro, c)| c.tr_mul(&extra(gyro))).collect(),
            with_residual: (state.iter().zip(&bank.columns))
                .map(|(gyro, c)| c.tr_mul(&DVector::from_column_slice(&gyro.residual)))
                .collect(),
        }
    }

    pub fn seen<'a>(&'a self, bank: &'a Bank, state: &State) -> Vec<Seen<'a>> {
        (0..state.len())
            .map(|j| Seen {
                columns: &bank.columns[j],
                with_residual: self.with_residual[j].as_slice(),
                with_extra: &self.with_extra[j],
                rss: state[j].rss,
                nu: state[j].nu,
            })
            .collect()
    }
}

/// Scores every kind of the bank.
pub(super) fn scores(bank: &Bank, state: &State) -> Vec<Score> {
    let products = Products::of(bank, state);
    let seen = products.seen(bank, state);
    bank.kinds.iter().map(|(kind, range)| score(bank, *kind, range.clone(), &seen)).collect()
}

/// Scores one kind of hypothesis.
pub(super) fn score(bank: &Bank, kind: Kind, range: std::ops::Range<usize>, seen: &[Seen]) -> Score {
    let mut score = Score { kind, log_evidence: f64::NEG_INFINITY, best: range.start, gyro_log: [0.0; MAX_GYROS] };
    let mut total = LogSum::default();
    for i in range {
        let (log, gyro_log) = log_bayes(&bank.hypotheses[i], seen);
        if log > total.top {
            (score.best, score.gyro_log) = (i, gyro_log);
        }
        total.add(log);
    }
    score.log_evidence = total.log();
    score
}

/// What the evidence of one gyro is made of.
pub(super) struct Seen<'a> {
    /// The gyro's columns.
    pub columns: &'a DMatrix<f64>,
    /// Products of the gyro's columns with its residual.
    pub with_residual: &'a [f64],
    /// Products of the gyro's columns with what has been adopted: columns x adopted.
    pub with_extra: &'a DMatrix<f64>,
    pub rss: f64,
    pub nu: f64,
}

impl Seen<'_> {
    /// Gram matrix of a common block's columns, adopted columns projected out.
    fn gram(&self, block: &Block) -> DMatrix<f64> {
        let own = self.columns.columns(block.start, block.len);
        let gram = own.tr_mul(&own);
        if self.with_extra.ncols() == 0 {
            return gram;
        }
        let part = self.with_extra.rows(block.start, block.len);
        gram - part * part.transpose()
    }

    fn side(&self, block: &Block) -> DVectorView<'_, f64> {
        DVectorView::from_slice(&self.with_residual[block.start..], block.len)
    }

    /// -nu/2 ln(1 - explained/R), safe where rounding explains a little more than there is.
    fn gain(&self, explained: f64) -> f64 {
        -0.5 * self.nu * (1.0 - (explained / self.rss).clamp(0.0, 1.0 - 1e-12)).ln()
    }
}

/// ln(weight x Bayes factor) of one hypothesis, and of each gyro.
fn log_bayes(hypothesis: &Hypothesis, seen: &[Seen]) -> (f64, [f64; MAX_GYROS]) {
    let mut gyro_log = [0.0; MAX_GYROS];
    if hypothesis.common {
        let log = log_bayes_common(hypothesis, seen);
        gyro_log.fill(log);
        return (hypothesis.log_weight + log, gyro_log);
    }
    for (j, seen) in seen.iter().enumerate() {
        let mut sum = LogSum::default();
        for (p, &power) in hypothesis.powers.iter().enumerate() {
            sum.add(log_bayes_gyro(&hypothesis.blocks[j], power, p, seen));
        }
        gyro_log[j] = sum.log_mean(hypothesis.powers.len());
    }
    (hypothesis.log_weight + log_membership(&gyro_log[..seen.len()]), gyro_log)
}

/// ln of the mean over non-empty subsets of gyros of the product of their Bayes factors.
pub(super) fn log_membership(logs: &[f64]) -> f64 {
    // Large factors are added as logarithms, the rest multiplied: one logarithm instead of one a gyro.
    const LARGE: f64 = 30.0;
    let (mut product, mut log) = (1.0, 0.0);
    for &x in logs {
        if x > LARGE {
            log += x - std::f64::consts::LN_2;
        } else {
            product *= 0.5 + 0.5 * x.exp();
        }
    }
    // Of the 2^J equally likely subsets the empty one, with Bayes factor 1, is left out.
    let none = 0.5_f64.powi(logs.len() as i32);
    let without = if log > 0.0 { product } else { (product - none).max(f64::MIN_POSITIVE) };
    log + (without / (1.0 - none)).ln()
}

/// ln B of one gyro.
fn log_bayes_gyro(block: &Block, power: f64, p: usize, seen: &Seen) -> f64 {
    if block.len == 0 {
        return 0.0;
    }
    let (explained, log_det) = explained(block, power, seen);
    seen.gain(explained) - 0.5 * (block.log_dets[p] + log_det)
}

/// Sum of squares that a block takes from a gyro's residual, and what the adopted columns change in ln det.
///
/// With the block's columns orthogonal, `A = 1 + g U'U` is diagonal, and what has been adopted takes `W W'` out of it
/// (W: block x adopted), so that determinant and inverse need only a matrix of the size of the adopted columns:
/// `det(A - g W W') = det A det S`, `S = 1 - g W' A^-1 W`.
fn explained(block: &Block, power: f64, seen: &Seen) -> (f64, f64) {
    let b = &seen.with_residual[block.start..block.start + block.len];
    let inverse = |i: usize| 1.0 / (1.0 + power * block.lengths.get(i).copied().unwrap_or(1.0));
    let own: f64 = b.iter().enumerate().map(|(i, b)| b * b * inverse(i)).sum();
    let adopted = seen.with_extra.ncols();
    if adopted == 0 {
        return (power * own, 0.0);
    }
    let mut small = DMatrix::identity(adopted, adopted);
    let mut side = DVector::zeros(adopted);
    for (i, b) in b.iter().enumerate() {
        let w = seen.with_extra.row(block.start + i);
        let a = inverse(i);
        for c in 0..adopted {
            side[c] += w[c] * a * b;
            for d in 0..adopted {
                small[(c, d)] -= power * w[c] * a * w[d];
            }
        }
    }
    match small.cholesky() {
        Some(cholesky) => (power * (own + power * side.dot(&cholesky.solve(&side))), log_det(&cholesky)),
        None => (0.0, 0.0),
    }
}

/// Prior power so wide that only the fit counts.
const NO_PRIOR: f64 = 1e5;

/// Gain in log-likelihood of one hypothesis in each gyro, coefficients free, and the number of coefficients.
pub(super) fn gains(hypothesis: &Hypothesis, seen: &[Seen]) -> Vec<(f64, usize)> {
    hypothesis
        .blocks
        .iter()
        .zip(seen)
        .map(|(block, seen)| match block.len {
            0 => (0.0, 0),
            len => (seen.gain(explained(block, NO_PRIOR, seen).0), len),
        })
        .collect()
}

/// Log-likelihood gain less number of coefficients (half of Akaike's criterion) of a kind at its best: gyros that do
/// not pay for their coefficients stay out, an unknown shape counts as one more.
pub(super) fn criterion(bank: &Bank, range: std::ops::Range<usize>, seen: &[Seen]) -> f64 {
    let shape = if range.len() > 1 { 1.0 } else { 0.0 };
    let best = range
        .map(|i| {
            let hypothesis = &bank.hypotheses[i];
            if hypothesis.common {
                let size = hypothesis.blocks.iter().map(|block| block.len).max().unwrap_or(0);
                return common_fit(hypothesis, seen, NO_PRIOR).0 - size as f64;
            }
            gains(hypothesis, seen).iter().map(|&(gain, len)| (gain - len as f64).max(0.0)).sum()
        })
        .fold(0.0, f64::max);
    best - shape
}

fn log_bayes_common(hypothesis: &Hypothesis, seen: &[Seen]) -> f64 {
    let mut sum = LogSum::default();
    for &power in hypothesis.powers {
        let (gain, penalty) = common_fit(hypothesis, seen, power);
        sum.add(gain - penalty);
    }
    sum.log_mean(hypothesis.powers.len())
}

/// Common coefficients: log-likelihood gain, and half of ln det plus the prior's own term. Each gyro weighs with its
/// own noise, found anew from what the fit leaves it.
fn common_fit(hypothesis: &Hypothesis, seen: &[Seen], power: f64) -> (f64, f64) {
    let Some(size) = hypothesis.blocks.iter().map(|block| block.len).max().filter(|len| *len > 0) else {
        return (0.0, 0.0);
    };
    let parts: Vec<(&Seen, &Block, DMatrix<f64>)> = seen
        .iter()
        .zip(&hypothesis.blocks)
        .filter(|(_, block)| block.len == size)
        .map(|(seen, block)| (seen, block, seen.gram(block)))
        .collect();
    let mut left: Vec<f64> = parts.iter().map(|(seen, ..)| seen.rss).collect();
    let (mut gain, mut penalty) = (0.0, 0.0);
    for _ in 0..2 {
        let mut system = DMatrix::identity(size, size) / power;
        let mut side = DVector::zeros(size);
        for ((seen, block, gram), left) in parts.iter().zip(&left) {
            system += gram * (seen.nu / left);
            side += seen.side(block) * (seen.nu / left);
        }
        let Some(cholesky) = system.cholesky() else { return (0.0, 0.0) };
        let estimate = cholesky.solve(&side);
        penalty = 0.5 * (log_det(&cholesky) + size as f64 * power.ln()) + 0.5 * estimate.norm_squared() / power;
        gain = 0.0;
        for ((seen, block, gram), left) in parts.iter().zip(&mut left) {
            let now = seen.rss - 2.0 * estimate.dot(&seen.side(block)) + estimate.dot(&(gram * &estimate));
            *left = now.max(1e-12 * seen.rss);
            gain += 0.5 * seen.nu * (seen.rss / *left).ln();
        }
    }
    (gain, penalty)
}

fn log_det(cholesky: &Cholesky<f64, Dyn>) -> f64 {
    cholesky.l_dirty().diagonal().iter().map(|x| 2.0 * x.ln()).sum()
}

/// ln of a sum of exponentials, kept in units of its largest term: one exponential a term, one logarithm in the end.
struct LogSum {
    top: f64,
    sum: f64,
}

impl Default for LogSum {
    fn default() -> Self {
        Self { top: f64::NEG_INFINITY, sum: 0.0 }
    }
}

impl LogSum {
    /// Terms below this, in logarithms, do not change a sum of 1.
    const NOTHING: f64 = -37.0;

    fn add(&mut self, log: f64) {
        if log > self.top {
            self.sum = 1.0 + self.sum * (self.top - log).exp();
            self.top = log;
        } else if log - self.top > Self::NOTHING {
            self.sum += (log - self.top).exp();
        }
    }

    fn log(&self) -> f64 {
        self.top + self.sum.ln()
    }

    fn log_mean(&self, count: usize) -> f64 {
        self.top + (self.sum / count as f64).ln()
    }
}
