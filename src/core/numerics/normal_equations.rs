//! Normal equations of few unknowns, N b = r: where the design itself is at hand and matters to the last digit,
//! [`least_squares`](super::least_squares) takes that apart instead.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::basis::dot;

/// Share of an unknown's own information that the others must leave it. N carries the design's rounding squared.
const SINGULAR: f64 = 1e-13;

/// N and r, sums over weighted rows.
#[derive(Debug, Clone)]
pub(crate) struct NormalEquations {
    pub matrix: DMatrix<f64>,
    pub right: DVector<f64>,
}

/// What they determine, all of it: b, and N^-1, its covariance for rows weighted by their inverse variance.
#[derive(Debug, Clone)]
pub(crate) struct Solution {
    pub estimate: DVector<f64>,
    pub covariance: DMatrix<f64>,
}

impl NormalEquations {
    /// Without any row.
    pub fn new(unknowns: usize) -> Self {
        Self { matrix: DMatrix::zeros(unknowns, unknowns), right: DVector::zeros(unknowns) }
    }

    /// Of the columns of a whitened design and what is measured, whitened.
    pub fn of_columns(columns: &[Vec<f64>], y: &[f64]) -> Self {
        Self { matrix: gram(columns), right: DVector::from_fn(columns.len(), |i, _| dot(&columns[i], y)) }
    }

    /// Adds a row that measures `y`.
    pub fn add(&mut self, row: &DVector<f64>, y: f64, weight: f64) {
        self.matrix.ger(weight, row, row, 1.0);
        self.right.axpy(weight * y, row, 1.0);
    }

    /// None where an unknown is not told from the others: then nothing is known of its uncertainty.
    pub fn solve(&self) -> Option<Solution> {
        self.solve_beyond(&self.matrix.diagonal(), SINGULAR)
    }

    /// As [`Self::solve`], where the others have to leave each unknown more than a share `least` of `whole`.
    pub fn solve_beyond(&self, whole: &DVector<f64>, least: f64) -> Option<Solution> {
        let covariance = scaled_inverse(&self.matrix, whole, least)?;
        Some(Solution { estimate: &covariance * &self.right, covariance })
    }
}

/// Products of columns with one another.
pub(crate) fn gram(columns: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(columns.len(), columns.len(), |i, j| dot(&columns[i], &columns[j]))
}

/// Inverse of a covariance, whose units may be far apart; none where it is singular.
pub(crate) fn inverse_of_covariance(covariance: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    scaled_inverse(covariance, &covariance.diagonal(), 0.0)
}

fn scaled_inverse(matrix: &DMatrix<f64>, whole: &DVector<f64>, least: f64) -> Option<DMatrix<f64>> {
    let scale = whole.map(|whole| whole.max(f64::MIN_POSITIVE).sqrt());
    let scaled = |of: &DMatrix<f64>| of.map_with_location(|i, j, value| value / (scale[i] * scale[j]));
    let factor = Cholesky::new(scaled(matrix))?;
    let is_told = |pivot: &f64| pivot * pivot > least;
    factor.l_dirty().diagonal().iter().all(is_told).then(|| scaled(&factor.inverse()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(rows: &[([f64; 2], f64)]) -> NormalEquations {
        let mut normal = NormalEquations::new(2);
        rows.iter().for_each(|(row, y)| normal.add(&DVector::from_column_slice(row), *y, 4.0));
        normal
    }

    #[test]
    fn a_line_and_its_covariance_are_those_of_the_books() {
        // y = 1 + 2 t at t = -1, 0, 1, each of sd 1/2: variances 1/12 and 1/8.
        let found = of(&[([1.0, -1.0], -1.0), ([1.0, 0.0], 1.0), ([1.0, 1.0], 3.0)]).solve().unwrap();
        let expected = [(found.estimate[0], 1.0), (found.estimate[1], 2.0)];
        let variances = [(found.covariance[(0, 0)], 1.0 / 12.0), (found.covariance[(1, 1)], 0.125)];
        assert!(expected.iter().chain(&variances).all(|(got, right)| (got - right).abs() < 1e-14), "{found:?}");
    }

    #[test]
    fn a_singular_system_states_no_uncertainty() {
        // Nothing, a column of zeros, and columns alike but for rounding, in units that are far apart.
        let alike = |unit: f64, off: f64| [0.1, 0.7, 1.3].map(|t| ([t, unit * (t + off * (t - 0.7) * t)], t));
        let mut rows = vec![Vec::new(), vec![([1.0, 0.0], 1.0), ([2.0, 0.0], 2.0)]];
        for unit in [1.0, 1e12, 3e-9] {
            rows.extend([0.0, 1e-9, 1e-8, 1e-7].map(|off| alike(unit, off).to_vec()));
        }
        for rows in rows {
            assert!(of(&rows).solve().is_none(), "{rows:?}");
        }
        // As far apart in unit, but told apart.
        let told = of(&[([1.0, 1e12], 1.0), ([2.0, 1e12], 2.0), ([3.0, 1e12], 2.0)]).solve().unwrap();
        assert!(told.covariance.diagonal().iter().all(|variance| *variance > 0.0), "{told:?}");
    }
}
