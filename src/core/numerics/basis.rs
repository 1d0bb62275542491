//! An orthonormal basis that grows column by column: what has been projected out of a gyro's whitened dwells.
//!
//! Gram-Schmidt done twice keeps the vectors orthogonal to rounding ("twice is enough", Giraud, Langou and
//! Rozloznik 2005), like Householder's QR, and lets later columns join at the cost of one projection each.

use nalgebra::DMatrix;

/// Squared length, relative to what it was, below which a projected column counts as lying in the basis.
const DEPENDENT: f64 = 1e-14;

#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Basis {
    vectors: Vec<Vec<f64>>,
}

impl Basis {
    /// Of any columns of one length; those that depend on the ones before add nothing.
    pub fn of(columns: impl IntoIterator<Item = Vec<f64>>) -> Self {
        let mut basis = Self::default();
        for column in columns {
            basis.push(column);
        }
        basis
    }

    /// Of columns that are orthonormal already.
    pub fn of_orthonormal(columns: &DMatrix<f64>) -> Self {
        Self { vectors: columns.column_iter().map(|column| column.iter().copied().collect()).collect() }
    }

    /// Number of vectors.
    pub fn rank(&self) -> usize {
        self.vectors.len()
    }

    /// Orthonormal vectors, each as long as a column.
    pub fn vectors(&self) -> &[Vec<f64>] {
        &self.vectors
    }

    /// Takes out of `v` what the basis spans.
    pub fn project_out(&self, v: &mut [f64]) {
        for _ in 0..2 {
            for q in &self.vectors {
                let along = dot(q, v);
                axpy(-along, q, v);
            }
        }
    }

    /// Adds a column; answers the share of its squared length that the basis did not span before (0: nothing new).
    pub fn push(&mut self, column: Vec<f64>) -> f64 {
        let before = dot(&column, &column);
        self.push_beyond(column, DEPENDENT * before).map_or(0.0, |after| after / before)
    }

    /// Adds a column of which more than a squared length of `least` lies outside the basis; answers how much.
    pub fn push_beyond(&mut self, mut column: Vec<f64>, least: f64) -> Option<f64> {
        self.project_out(&mut column);
        let left = dot(&column, &column);
        (left > least).then(|| {
            scale(1.0 / left.sqrt(), &mut column);
            self.vectors.push(column);
            left
        })
    }

    /// The vectors as columns of `n` numbers.
    pub fn matrix(&self, n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, self.rank(), |k, c| self.vectors[c][k])
    }

    /// The vectors from number `rank` on, as a basis of their own.
    pub fn split_off(mut self, rank: usize) -> Self {
        Self { vectors: self.vectors.split_off(rank) }
    }

    /// Its vectors and those of `other`, which are orthogonal to them.
    pub fn with(&self, other: &Self) -> Self {
        Self { vectors: self.vectors.iter().chain(&other.vectors).cloned().collect() }
    }

    /// Sum of squares of row `k`: the leverage of dwell `k`.
    pub fn leverage(&self, k: usize) -> f64 {
        self.vectors.iter().map(|q| q[k] * q[k]).sum()
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four running sums let the compiler use vector instructions without changing the order of operations.
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let tail: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a4.zip(b4) {
        for i in 0..4 {
            sums[i] += x[i] * y[i];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + tail
}

/// y += a x.
pub(crate) fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

pub(crate) fn scale(a: f64, x: &mut [f64]) {
    x.iter_mut().for_each(|x| *x *= a);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_columns_add_nothing_and_the_rest_is_orthonormal() {
        let mut basis = Basis::of([vec![1.0; 5], vec![1.0, 2.0, 3.0, 4.0, 5.0]]);
        assert_eq!(basis.push(vec![3.0, 5.0, 7.0, 9.0, 11.0]), 0.0);
        assert!(basis.push(vec![1.0, 4.0, 9.0, 16.0, 25.0]) > 0.0);
        assert_eq!(basis.rank(), 3);
        for (i, p) in basis.vectors().iter().enumerate() {
            for (j, q) in basis.vectors().iter().enumerate() {
                assert!((dot(p, q) - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        assert!(((0..5).map(|k| basis.leverage(k)).sum::<f64>() - 3.0).abs() < 1e-14);
        assert_eq!(Basis::of_orthonormal(&basis.matrix(5)), basis);
    }

    #[test]
    fn a_column_joins_where_it_leaves_more_than_is_asked() {
        // Beside (1, 0): (3, t) leaves t^2.
        let mut basis = Basis::of([vec![1.0, 0.0]]);
        assert_eq!(basis.push_beyond(vec![3.0, 0.5], 0.25), None);
        assert_eq!(basis.push_beyond(vec![3.0, f64::NAN], 0.25), None);
        assert_eq!(basis.push_beyond(vec![3.0, 0.5], 0.2), Some(0.25));
        assert_eq!(basis.vectors()[1], [0.0, 1.0]);
    }
}
