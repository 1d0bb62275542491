//! How strongly the residuals speak for each hypothesis: Bayes factors against the model in use.
//!
//! For one gyro with `nu` degrees of freedom, residual sum of squares `R`, projected columns `U` (m of them) and a
//! prior of power `g` per coefficient and noise variance (Zellner's g-prior; scale of the noise unknown), averaged
//! over two or three values of `g`,
//!
//! ```text
//! ln B = -1/2 ln det(1 + g U'U) - nu/2 ln(1 - b'(U'U + 1/g)^-1 b / R),   b = U'r
//! ```
//!
//! A gyro has the effect with probability one half before the data speak, so gyros multiply as (1 + B_j)/2; values of
//! a non-linear parameter average with their weights. The penalty for flexible entries is thus no choice of ours.
//!
//! Coefficients that all gyros share have a form of their own ([`crate::core::diagnose::search::shared_coefficients`]).

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::core::diagnose::search::hypotheses::{Bank, Block, Hypothesis, SMALL};
use crate::core::diagnose::search::projections::{GyroStatistics, MAX_GYROS, Products, State};
use crate::core::diagnose::search::shared_coefficients::Common;
use crate::core::effects::Effect;
use crate::core::numerics::log_sum::LogSum;

/// One kind's evidence given a state.
#[derive(Debug, Clone)]
pub(crate) struct Score {
    pub kind: Effect,
    pub log_evidence: f64,
    /// Index of the hypothesis that weighs most.
    pub best: usize,
    /// ln B of each gyro for the best hypothesis (of all gyros together, at every place, for a common one).
    pub gyro_log: [f64; MAX_GYROS],
}

/// Scores every kind of the bank.
pub(crate) fn scores(bank: &Bank, state: &State) -> Vec<Score> {
    scores_of(bank, &Products::of(bank, state).seen())
}

/// The same of products with all columns of the bank.
pub(crate) fn scores_of(bank: &Bank, seen: &[GyroStatistics]) -> Vec<Score> {
    bank.kinds.iter().map(|(kind, range)| score(bank, *kind, range.clone(), seen)).collect()
}

/// ln of as many entries as may share their evidence.
const SHARED: f64 = 1.1;

/// Evidence that speaks for the strongest of several entries or for one like it: of alternatives that exclude one
/// another the Bayes factors add. A campaign may tell that one of them is there before it tells which.
pub(crate) fn together(logs: impl Iterator<Item = f64>) -> f64 {
    let mut sum = LogSum::default();
    logs.for_each(|log| sum.add(log));
    sum.log().min(sum.top + SHARED)
}

/// Scores one kind of hypothesis.
pub(crate) fn score(bank: &Bank, kind: Effect, range: std::ops::Range<usize>, seen: &[GyroStatistics]) -> Score {
    let mut score = Score { kind, log_evidence: f64::NEG_INFINITY, best: range.start, gyro_log: [0.0; MAX_GYROS] };
    let mut total = LogSum::default();
    for i in range {
        let (log, factors) = log_bayes(&bank.hypotheses[i], seen);
        if log > total.top {
            (score.best, score.gyro_log) = (i, factors.map(|factor| factor.log()));
        }
        total.add(log);
    }
    score.log_evidence = total.log();
    score
}

/// ln(weight x Bayes factor) of one hypothesis, and the factor of each gyro.
fn log_bayes(hypothesis: &Hypothesis, seen: &[GyroStatistics]) -> (f64, [LogSum; MAX_GYROS]) {
    if hypothesis.common {
        let log = Common::of(hypothesis, seen).map_or(0.0, |common| common.log_bayes(hypothesis.powers));
        return (hypothesis.log_weight + log, [LogSum::of_one(log); MAX_GYROS]);
    }
    let mut factors = [LogSum::of_one(0.0); MAX_GYROS];
    for ((factor, block), seen) in factors.iter_mut().zip(&hypothesis.blocks).zip(seen) {
        *factor = bayes_factor(hypothesis.powers, block, seen);
    }
    (hypothesis.log_weight + log_membership(&factors[..seen.len()]), factors)
}

/// As [`log_bayes`], with the effect in exactly the gyros `members`: one of the equally likely sets.
pub(crate) fn log_bayes_in(hypothesis: &Hypothesis, members: &[bool], seen: &[GyroStatistics]) -> f64 {
    if hypothesis.common {
        return log_bayes(hypothesis, seen).0;
    }
    let own = hypothesis.blocks.iter().zip(seen).zip(members).filter(|(_, member)| **member);
    let factors: f64 = own.map(|((block, seen), _)| bayes_factor(hypothesis.powers, block, seen).log()).sum();
    hypothesis.log_weight + factors - (2.0_f64.powi(seen.len() as i32) - 1.0).ln()
}

/// Bayes factor of one gyro, averaged over the powers.
fn bayes_factor(powers: &[f64], block: &Block, seen: &GyroStatistics) -> LogSum {
    if block.len == 0 {
        return LogSum::of_one(0.0);
    }
    let mut sum = LogSum::default();
    let projected = Projected::of(block, seen);
    for (p, &power) in powers.iter().enumerate() {
        let (explained, log_det) = projected.explained(power, block.log_dets[p]);
        sum.add(seen.gain(explained) - 0.5 * log_det);
    }
    sum.mean(powers.len())
}

/// ln of the mean over non-empty subsets of gyros of the product of their Bayes factors.
fn log_membership(factors: &[LogSum]) -> f64 {
    // Large factors are added as logarithms, the rest multiplied: one logarithm instead of one a gyro.
    const LARGE: f64 = 30.0;
    let (mut product, mut log) = (1.0, 0.0);
    for factor in factors {
        if factor.top > LARGE {
            log += factor.log() - std::f64::consts::LN_2;
        } else {
            product *= 0.5 + 0.5 * factor.top.exp() * factor.sum;
        }
    }
    // Of the 2^J equally likely subsets the empty one, with Bayes factor 1, is left out.
    let none = 0.5_f64.powi(factors.len() as i32);
    let without = if log > 0.0 { product } else { (product - none).max(f64::MIN_POSITIVE) };
    log + (without / (1.0 - none)).ln()
}

/// A block in one gyro with what has been adopted taken out of it.
enum Projected<'a> {
    /// Of at most [`SMALL`] columns: Gram matrix `U'U` and `U'r`, zero beyond them.
    Small {
        gram: Matrix3<f64>,
        side: Vector3<f64>,
    },
    /// Orthogonal columns with nothing adopted: squared lengths, and `U'r`.
    Orthogonal {
        block: &'a Block,
        side: &'a [f64],
    },
    Large {
        block: &'a Block,
        seen: &'a GyroStatistics<'a>,
    },
}

impl<'a> Projected<'a> {
    fn of(block: &'a Block, seen: &'a GyroStatistics<'a>) -> Self {
        if seen.adopted == 0 {
            Self::Orthogonal { block, side: &seen.with_residual[block.start..][..block.len] }
        } else if block.len <= SMALL {
            Self::Small { gram: seen.gram(block), side: seen.side(block) }
        } else {
            Self::Large { block, seen }
        }
    }

    /// Sum of squares that the block takes from the residual, and ln det(1 + g U'U); `log_det` is that determinant with
    /// nothing adopted.
    fn explained(&self, power: f64, log_det: f64) -> (f64, f64) {
        match self {
            Self::Orthogonal { block, side } => {
                let own = side.iter().enumerate().map(|(i, b)| b * b / (1.0 + power * block.length(i))).sum::<f64>();
                (power * own, log_det)
            }
            Self::Small { gram, side } => explained_by_few(gram, side, power).unwrap_or((0.0, log_det)),
            Self::Large { block, seen } => {
                let (explained, change) = explained_by_many(block, power, seen);
                (explained, log_det + change)
            }
        }
    }
}

/// As [`Projected::explained`] for a block of at most [`SMALL`] columns: with `1 + g U'U = L D L'` and `y = L^-1 U'r`
/// it takes `g sum y_i^2/d_i`, and the determinant is the product of the `d_i`. None where rounding leaves no positive
/// determinant.
fn explained_by_few(gram: &Matrix3<f64>, side: &Vector3<f64>, power: f64) -> Option<(f64, f64)> {
    let a = |i: usize, j: usize| power * gram[(i, j)];
    let d0 = 1.0 + a(0, 0);
    let (l10, l20) = (a(1, 0) / d0, a(2, 0) / d0);
    let d1 = 1.0 + a(1, 1) - l10 * a(1, 0);
    let l21 = (a(2, 1) - l20 * a(1, 0)) / d1;
    let d2 = 1.0 + a(2, 2) - l20 * a(2, 0) - l21 * l21 * d1;
    let y1 = side[1] - l10 * side[0];
    let y2 = side[2] - l20 * side[0] - l21 * y1;
    let taken = power * (side[0] * side[0] / d0 + y1 * y1 / d1 + y2 * y2 / d2);
    (d0 > 0.0 && d1 > 0.0 && d2 > 0.0).then(|| (taken, (d0 * d1 * d2).ln()))
}

/// As [`Projected::explained`] for a block of many columns beside few adopted ones.
///
/// With the block's columns orthogonal, `A = 1 + g U'U` is diagonal, and what has been adopted takes `W W'` out of it
/// (W: block x adopted), so that determinant and inverse need only a matrix of the size of the adopted columns:
/// `det(A - g W W') = det A det S`, `S = 1 - g W' A^-1 W`.
fn explained_by_many(block: &Block, power: f64, seen: &GyroStatistics) -> (f64, f64) {
    let b = &seen.with_residual[block.start..block.start + block.len];
    let mut own = 0.0;
    let mut small = DMatrix::<f64>::identity(seen.adopted, seen.adopted);
    let mut side = DVector::zeros(seen.adopted);
    for (i, b) in b.iter().enumerate() {
        let w = seen.taken(block.start + i);
        let a = 1.0 / (1.0 + power * block.length(i));
        own += b * b * a;
        for c in 0..seen.adopted {
            side[c] += w[c] * a * b;
            for d in 0..seen.adopted {
                small[(c, d)] -= power * w[c] * a * w[d];
            }
        }
    }
    match small.cholesky() {
        Some(cholesky) => (power * (own + power * side.dot(&cholesky.solve(&side))), cholesky.ln_determinant()),
        None => (0.0, 0.0),
    }
}

/// Prior power so wide that only the fit counts.
const NO_PRIOR: f64 = 1e5;

/// Gain in log-likelihood of one hypothesis in each gyro, coefficients free, and the number of coefficients.
pub(crate) fn gains(hypothesis: &Hypothesis, seen: &[GyroStatistics]) -> Vec<(f64, usize)> {
    hypothesis
        .blocks
        .iter()
        .zip(seen)
        .map(|(block, seen)| match block.len {
            0 => (0.0, 0),
            len => (seen.gain(Projected::of(block, seen).explained(NO_PRIOR, 0.0).0), len),
        })
        .collect()
}

/// Log-likelihood gain less number of coefficients (half of Akaike's criterion) of a kind at its best: gyros that do
/// not pay for their coefficients stay out, an unknown shape counts as one more.
pub(crate) fn criterion(bank: &Bank, range: std::ops::Range<usize>, seen: &[GyroStatistics]) -> f64 {
    let shape = if range.len() > 1 { 1.0 } else { 0.0 };
    let best = range
        .map(|i| {
            let hypothesis = &bank.hypotheses[i];
            if hypothesis.common {
                return Common::of(hypothesis, seen).map_or(0.0, |common| common.gain(NO_PRIOR) - common.size as f64);
            }
            gains(hypothesis, seen).iter().map(|&(gain, len)| (gain - len as f64).max(0.0)).sum()
        })
        .fold(0.0, f64::max);
    best - shape
}

/// Evidence of a kind from gyro `j` alone, and its [`criterion`] there; none for coefficients that all gyros share.
pub(crate) fn of_gyro(
    bank: &Bank,
    range: std::ops::Range<usize>,
    j: usize,
    seen: &GyroStatistics,
) -> Option<(f64, f64)> {
    let shape = if range.len() > 1 { 1.0 } else { 0.0 };
    let (mut total, mut best) = (LogSum::default(), f64::NEG_INFINITY);
    for hypothesis in bank.hypotheses[range].iter().filter(|hypothesis| !hypothesis.common) {
        let block = &hypothesis.blocks[j];
        total.add(hypothesis.log_weight + bayes_factor(hypothesis.powers, block, seen).log());
        if block.len > 0 {
            best =
                best.max(seen.gain(Projected::of(block, seen).explained(NO_PRIOR, 0.0).0) - block.len as f64 - shape);
        }
    }
    (best > f64::NEG_INFINITY).then(|| (total.log(), best))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_columns_explain_what_a_factor_of_their_system_says() {
        let (gram, power) = (Matrix3::new(2.0, 0.3, -0.4, 0.3, 1.5, 0.2, -0.4, 0.2, 0.9), 7.0);
        let side = Vector3::new(1.0, -2.0, 0.5);
        let system: Matrix3<f64> = Matrix3::identity() + power * gram;
        let expected = (power * side.dot(&system.qr().solve(&side).unwrap()), system.determinant().ln());
        let found = explained_by_few(&gram, &side, power).unwrap();
        assert!((found.0 - expected.0).abs() < 1e-12 && (found.1 - expected.1).abs() < 1e-12, "{found:?}");
        assert!(explained_by_few(&(-gram), &side, power).is_none(), "not positive definite");
    }
}
