//! Errors of prediction on dwells that were not fitted, and the fraction of the gap that an effect closes on them.
//!
//! With `Q` an orthonormal basis of the fitted columns and `r` the residuals, the errors on a fold that was left out
//! are exactly `(1 - Q_f Q_f')^-1 r_f`: no fold is ever fitted again. Of a fold with more dwells than the basis has
//! columns this is `r_f + Q_f (1 - Q_f'Q_f)^-1 Q_f'r_f` (Woodbury), and the trace of that inverse the trace of this
//! one and the difference of the two sizes. Folds keep repeats of one orientation together; for effects that follow
//! time they are blocks of time. What a cause that is not named leaves counts there by how far the fold is from the
//! others; the interval is therefore that of the share of the dwells as they were fitted.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::core::diagnose::diagnosis::HeldOut;
use crate::core::diagnose::residuals::augmented_fit::{Part, with_parts};
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::numerics::basis::{Basis, axpy, dot};

/// Folds, where there are enough groups.
const FOLDS: usize = 8;

/// Smallest eigenvalue of 1 - Q_f Q_f' with which a fold counts as predictable from the others.
const PREDICTABLE: f64 = 0.02;

/// Sums of squared errors in units of the noise variance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Errors {
    pub without: f64,
    pub with: f64,
    /// What noise alone leaves, errors of the model's own coefficients included.
    pub floor: f64,
    /// Number of dwells predicted.
    pub count: usize,
    /// What the effects take of the dwells as they are fitted, beyond what their coefficients take of noise.
    pub taken: f64,
    /// What they leave of those beyond noise, and its degrees of freedom.
    pub left: f64,
    pub dof: f64,
    /// Whether something is said to remain beside the names.
    pub remains: bool,
}

/// Errors of all gyros without and with the effects in question, `kept` in the model both times. A gyro that they leave
/// alone counts too: what other causes leave in it is part of the gap that is not closed. Where something `remains`,
/// repeats may scatter by that too, and what is left is held against no more noise than is stated.
pub(crate) fn errors(frame: &Frame, kept: &[&Part], asked: &[&Part], variances: &[f64], remains: bool) -> Errors {
    let by_time = asked.iter().any(|part| part.effect.entry().follows_time);
    let mut errors = Errors { remains, ..Errors::default() };
    for (j, &variance) in variances.iter().enumerate() {
        let without = with_parts(frame, j, frame.gyros[j].basis.clone(), kept);
        let with = with_parts(frame, j, without.clone(), asked);
        let (plain, augmented) = (residual(frame, j, &without), residual(frame, j, &with));
        let noise = if remains && frame.noise.stated { variance.min(1.0) } else { variance };
        let (before, after) = (dot(&plain, &plain) / noise, dot(&augmented, &augmented) / noise);
        let dof = frame.dwells().saturating_sub(with.rank()) as f64;
        errors.taken += before - after - with.rank().saturating_sub(without.rank()) as f64;
        errors.left += after - dof;
        errors.dof += dof;
        let lost: Vec<usize> = asked.iter().filter(|part| part.members[j]).filter_map(|part| part.dwell()).collect();
        for fold in folds(frame.dwells(), &frame.noise.repeats, by_time) {
            for fold in predictable(&with, fold, &lost) {
                let (e, f) = (left_out(&without, &plain, &fold), left_out(&with, &augmented, &fold));
                let (Some((e, noise)), Some((f, _))) = (e, f) else { continue };
                errors.without += dot(&e, &e) / variance;
                errors.with += dot(&f, &f) / variance;
                errors.floor += noise;
                errors.count += fold.len();
            }
        }
        // A dwell that the effect itself sets aside is not predicted by anything; without the effect it stays in.
        for k in lost {
            if let Some((e, noise)) = left_out(&without, &plain, &[k]) {
                errors.without += dot(&e, &e) / variance;
                errors.with += noise;
                errors.floor += noise;
                errors.count += 1;
            }
        }
    }
    errors
}

impl Errors {
    /// Closure with a 95 % interval, and errors in units that `floor_deg_per_h` sets.
    ///
    /// `coefficients` is the number of fitted coefficients of the effects, `unseen` the power (in noise variances) that
    /// the tests of what remains could have missed.
    pub fn held_out(&self, floor_deg_per_h: f64, coefficients: f64, unseen: f64) -> HeldOut {
        let n = (self.count as f64).max(1.0);
        let gain = (self.without - self.with).max(0.0);
        let over = self.with - self.floor;
        let left = if is_significant(over, n) { over } else { coefficients };
        let closure = if gain > 0.0 { gain / (gain + left) } else { 0.0 };
        let [low, high] = self.interval(coefficients, unseen);
        let rms = |structure: f64| floor_deg_per_h * (1.0 + structure / n).sqrt();
        HeldOut {
            before_deg_per_h: rms(gain + left),
            after_deg_per_h: rms(left),
            closure,
            interval: [low.min(closure), high.max(closure)],
        }
    }

    /// The share that the effects close of the dwells as they are fitted, from its lowest to its highest.
    fn interval(&self, coefficients: f64, unseen: f64) -> [f64; 2] {
        // Selected because it was large: the lower end takes off what selection adds.
        let taken = [-2.0, 2.0].map(|sd| (self.taken.max(0.0).sqrt() + sd).max(0.0).powi(2));
        // Of squares of noise with a structure in them (non-central chi-square).
        let structure = self.left.max(0.0);
        let scatter = (2.0 * self.dof).sqrt();
        let left = match (is_significant(self.left, self.dof), self.remains) {
            (true, _) => {
                let twice = 2.0 * (2.0 * self.dof + 4.0 * structure).sqrt();
                [(structure - twice).max(0.0), structure + twice]
            }
            (false, true) => [0.0, coefficients + unseen + structure + 2.0 * scatter],
            (false, false) => [0.0, coefficients + unseen + structure.min(scatter)],
        };
        let share = |taken: f64, left: f64| if taken > 0.0 { taken / (taken + left) } else { 0.0 };
        [share(taken[0], left[1]), share(taken[1], left[0])]
    }
}

/// Whether squares of `count` errors exceed those of noise by more than chance.
fn is_significant(over: f64, count: f64) -> bool {
    over > 2.5 * (2.0 * count).sqrt()
}

fn residual(frame: &Frame, j: usize, basis: &Basis) -> Vec<f64> {
    let mut residual = frame.gyros[j].residual.clone();
    basis.project_out(&mut residual);
    residual
}

/// Errors on a fold, and what noise alone makes of their squares; none where the rest does not predict it.
fn left_out(basis: &Basis, residual: &[f64], fold: &[usize]) -> Option<(Vec<f64>, f64)> {
    let (size, rank) = (fold.len(), basis.rank());
    let left: Vec<f64> = fold.iter().map(|&k| residual[k]).collect();
    if size <= rank {
        let factor = unexplained(&rows(basis, fold), 0.0).cholesky()?;
        let errors = factor.solve(&DVector::from_vec(left));
        return Some((errors.data.into(), inverse_trace(&factor)));
    }
    let columns = columns(basis, fold);
    let factor = unexplained(&columns, 0.0).cholesky()?;
    let along = factor.solve(&DVector::from_iterator(rank, columns.iter().map(|column| dot(column, &left))));
    let mut errors = left;
    columns.iter().zip(&along).for_each(|(column, along)| axpy(*along, column, &mut errors));
    Some((errors, inverse_trace(&factor) + (size - rank) as f64))
}

fn inverse_trace(factor: &Cholesky<f64, Dyn>) -> f64 {
    let size = factor.l_dirty().nrows();
    let inverse = factor.l_dirty().solve_lower_triangular(&DMatrix::identity(size, size));
    inverse.map_or(f64::INFINITY, |inverse| inverse.norm_squared())
}

/// Whether every eigenvalue of `1 - Q_f Q_f'` exceeds [`PREDICTABLE`]: less that, it still is positive definite.
fn determined(basis: &Basis, fold: &[usize]) -> bool {
    let narrow = if fold.len() <= basis.rank() { rows(basis, fold) } else { columns(basis, fold) };
    unexplained(&narrow, PREDICTABLE).cholesky().is_some()
}

/// Of `Q_f`: a vector for each dwell of the fold.
fn rows(basis: &Basis, fold: &[usize]) -> Vec<Vec<f64>> {
    fold.iter().map(|&k| basis.vectors().iter().map(|q| q[k]).collect()).collect()
}

/// Of `Q_f`: a vector for each column of the basis.
fn columns(basis: &Basis, fold: &[usize]) -> Vec<Vec<f64>> {
    basis.vectors().iter().map(|q| fold.iter().map(|&k| q[k]).collect()).collect()
}

/// `1 - X X' - least` of the rows `X`; of it only the lower triangle, which is all that its factor reads.
fn unexplained(rows: &[Vec<f64>], least: f64) -> DMatrix<f64> {
    let size = rows.len();
    let mut matrix = DMatrix::zeros(size, size);
    for (a, row) in rows.iter().enumerate() {
        for (b, other) in rows[..=a].iter().enumerate() {
            matrix[(a, b)] = -dot(row, other);
        }
        matrix[(a, a)] += 1.0 - least;
    }
    matrix
}

/// The fold, or its dwells one by one where the others do not determine all of it; without those that are `lost`.
fn predictable(basis: &Basis, mut fold: Vec<usize>, lost: &[usize]) -> Vec<Vec<usize>> {
    fold.retain(|k| !lost.contains(k));
    if fold.is_empty() {
        Vec::new()
    } else if determined(basis, &fold) {
        vec![fold]
    } else {
        fold.into_iter().map(|k| vec![k]).filter(|single| determined(basis, single)).collect()
    }
}

/// Blocks of time, or groups of dwells with one orientation and rate spread over the folds.
fn folds(n: usize, repeats: &[Vec<usize>], by_time: bool) -> Vec<Vec<usize>> {
    let mut folds = vec![Vec::new(); FOLDS.min(n)];
    let count = folds.len();
    if by_time {
        for k in 0..n {
            folds[k * count / n].push(k);
        }
        return folds;
    }
    let mut grouped = vec![false; n];
    let mut next = 0;
    for k in 0..n {
        if grouped[k] {
            continue;
        }
        let alone = vec![k];
        let group = repeats.iter().find(|group| group[0] == k).unwrap_or(&alone);
        for &member in group {
            grouped[member] = true;
            folds[next % count].push(member);
        }
        next += 1;
    }
    folds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_of_one_orientation_share_a_fold_and_every_dwell_has_one() {
        let repeats = vec![vec![0, 9, 17], vec![3, 4]];
        let folds = folds(20, &repeats, false);
        assert_eq!(folds.len(), FOLDS);
        let mut all: Vec<usize> = folds.concat();
        all.sort_unstable();
        assert_eq!(all, (0..20).collect::<Vec<_>>());
        for group in &repeats {
            assert!(folds.iter().any(|fold| group.iter().all(|k| fold.contains(k))), "{group:?} in {folds:?}");
        }
    }

    #[test]
    fn effects_of_time_are_held_out_in_blocks_of_time() {
        let folds = folds(78, &[vec![0, 40]], true);
        assert!(folds.iter().all(|fold| fold.windows(2).all(|pair| pair[1] == pair[0] + 1)), "{folds:?}");
        assert_eq!(folds.concat(), (0..78).collect::<Vec<_>>());
    }

    #[test]
    fn an_error_of_prediction_is_that_of_a_fit_without_the_dwell() {
        // A mean of four: leaving the last out, its error is 8 - (1 + 2 + 4)/3.
        let values = [1.0, 2.0, 4.0, 8.0];
        let basis = Basis::of([vec![1.0; 4]]);
        let mut residual = values.to_vec();
        basis.project_out(&mut residual);
        let (error, noise) = left_out(&basis, &residual, &[3]).unwrap();
        assert!((error[0] - (8.0 - 7.0 / 3.0)).abs() < 1e-12);
        assert!((noise - (1.0 + 1.0 / 3.0)).abs() < 1e-12);
        // The last two out: the mean is 3/2, known to half of a value's variance.
        let (errors, noise) = left_out(&basis, &residual, &[2, 3]).unwrap();
        assert!((errors[0] - 2.5).abs() < 1e-12 && (errors[1] - 6.5).abs() < 1e-12, "{errors:?}");
        assert!((noise - 2.0 * (1.0 + 0.5)).abs() < 1e-12);
    }

    #[test]
    fn a_fold_that_holds_all_of_a_column_is_not_predicted_by_the_rest() {
        let basis = Basis::of([vec![1.0; 5], vec![0.0, 0.0, 0.0, 1.0, 2.0]]);
        assert!(determined(&basis, &[0, 1]) && determined(&basis, &[3]));
        assert!(!determined(&basis, &[3, 4]) && !determined(&basis, &[2, 3, 4]));
    }

    #[test]
    fn the_interval_is_that_of_the_fitted_share_and_says_what_may_remain() {
        let of = |left: f64, remains: bool| Errors { taken: 144.0, left, dof: 200.0, remains, ..Errors::default() };
        let near = |a: [f64; 2], b: [f64; 2]| (0..2).all(|i| (a[i] - b[i]).abs() < 1e-3);
        // sqrt(2 200 + 4 288) = 39.4: between 10^2 over 100 + 288 + 78.8 and 14^2 over 196 + 288 - 78.8.
        assert!(near(of(288.0, true).interval(3.0, 10.0), [0.2142, 0.4837]));
        // No more than 2.5 deviations of 20: at most 40 and two deviations where something remains, else one.
        assert!(near(of(40.0, true).interval(3.0, 10.0), [100.0 / 193.0, 1.0]));
        assert!(near(of(40.0, false).interval(3.0, 10.0), [100.0 / 133.0, 1.0]));
    }
}
