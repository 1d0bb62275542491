//! Weighted least squares that returns its own evidence.
//!
//! The design is whitened (each row divided by its standard deviation), its columns are scaled to unit length, and
//! the result is taken apart as Q R by Householder reflections. Normal equations are never formed: they square the
//! condition number. Where R is far from singular, its inverse gives the estimate; otherwise R = U S V^T, and the
//! singular values say what the design determines: what it does not comes back as null directions, and the estimate
//! is then the shortest of the equally good ones.

use nalgebra::{DMatrix, DVector};

/// Singular values below this share of the largest count as zero.
///
/// Not machine precision: the design is commanded, and a station knows its own positions to some 20 arcsec
/// (1e-4 rad) at best. A direction that the design excites less than that is fed by the station's errors.
pub const RANK_TOLERANCE: f64 = 1e-4;

/// A whitened column shorter than this is nothing: the variance of its coefficient would be beyond all numbers.
const SHORTEST: f64 = 1e-100;

/// Of the singular values, a few a column; for numbers that are not finite they would never end.
const MOST_ITERATIONS: usize = 10_000;

/// A design matrix taken apart, ready to fit any number of measurements that share it and its weights.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    design: DMatrix<f64>,
    /// 1/sd of each row.
    weights: DVector<f64>,
    /// Orthonormal columns that span what the whitened design can produce, n x rank.
    basis: DMatrix<f64>,
    /// Turns coordinates on `basis` into parameters, p x rank.
    back: DMatrix<f64>,
    covariance: DMatrix<f64>,
    null: DMatrix<f64>,
    scaled_null: DMatrix<f64>,
    column_scale: DVector<f64>,
    leverage: DVector<f64>,
}

/// The estimate and all that speaks for or against it.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Parameters, p.
    pub estimate: DVector<f64>,
    /// Covariance for the standard deviations as given, p x p. Meaningless along `null_directions`.
    pub covariance: DMatrix<f64>,
    pub rank: usize,
    /// Directions of parameter space (columns, unit length, p x (p - rank)) along which nothing changes.
    pub null_directions: DMatrix<f64>,
    /// y - X b, in the unit of y, n.
    pub residuals: DVector<f64>,
    /// Share of its own measurement in each fitted value, 0 to 1, n; their sum is the rank.
    pub leverage: DVector<f64>,
    /// Sum of squared whitened residuals.
    pub chi2: f64,
    /// n - rank.
    pub dof: usize,
}

impl Factor {
    /// Takes the design (n x p) apart for rows with standard deviations `sd` (n, positive).
    ///
    /// # Panics
    /// Where `sd` has another length than the design has rows, the design has no rows or no columns, or a number is
    /// not finite.
    pub fn new(design: DMatrix<f64>, sd: &[f64]) -> Self {
        let (n, p) = design.shape();
        assert!(n > 0 && p > 0, "a design has rows and columns");
        assert_eq!(sd.len(), n, "one standard deviation a row");
        let weights = DVector::from_iterator(n, sd.iter().map(|s| 1.0 / s));
        // Rows of zeros make the matrix tall, so that all p right singular vectors come out; they change nothing.
        let mut whitened = design.clone().resize_vertically(n.max(p), 0.0);
        for (mut row, w) in whitened.row_iter_mut().zip(weights.iter()) {
            row *= *w;
        }
        let mut column_scale = DVector::from_element(p, 1.0);
        for (mut column, scale) in whitened.column_iter_mut().zip(column_scale.iter_mut()) {
            let length = column.norm();
            if length < SHORTEST {
                column.fill(0.0);
            } else {
                *scale = length;
                column /= length;
            }
        }
        let qr = whitened.qr();
        let (q, r) = (qr.q(), qr.r());
        let Solved { basis, mut back, scaled_null } = match by_inverse(&r) {
            Some(back) => Solved { basis: q, back, scaled_null: DMatrix::zeros(p, 0) },
            None => by_singular_values(&q, r),
        };
        let basis = basis.resize_vertically(n, 0.0);
        let mut null = scaled_null.clone();
        for (i, scale) in column_scale.iter().enumerate() {
            back.row_mut(i).unscale_mut(*scale);
            null.row_mut(i).unscale_mut(*scale);
        }
        for mut direction in null.column_iter_mut() {
            let length = positive(direction.norm());
            direction.unscale_mut(length);
        }
        let covariance = &back * back.transpose();
        let leverage = DVector::from_iterator(n, basis.row_iter().map(|row| row.norm_squared()));
        Self { design, weights, basis, back, covariance, null, scaled_null, column_scale, leverage }
    }

    /// Number of independent columns of the whitened design.
    pub fn rank(&self) -> usize {
        self.basis.ncols()
    }

    /// Orthonormal columns that span what the whitened design can produce, n x rank. A candidate regressor r
    /// that the design cannot absorb has (I - B B^T) W r left over.
    pub fn basis(&self) -> &DMatrix<f64> {
        &self.basis
    }

    /// Root mean square, weighted by 1/sd^2, of what is left of a column beside the others: 1/sqrt(C_ii sum 1/sd^2), in
    /// the unit of the column. Meaningless where the parameter is not determined.
    pub fn excitation(&self, i: usize) -> f64 {
        (self.covariance[(i, i)] * self.weights.norm_squared()).sqrt().recip()
    }

    /// 1/sd of each row.
    pub fn weights(&self) -> &DVector<f64> {
        &self.weights
    }

    /// Covariance of the parameters, p x p, for rows of the stated standard deviations. Null directions have no part in
    /// it.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// Covariance of the parameters (p x p) from that of the coordinates on the basis (rank x rank).
    pub fn covariance_of(&self, coordinates: &DMatrix<f64>) -> DMatrix<f64> {
        &self.back * coordinates * self.back.transpose()
    }

    /// Diagonal of the hat matrix, n; its sum is the rank.
    pub fn leverage(&self) -> &DVector<f64> {
        &self.leverage
    }

    /// Whether `functional . parameters` (p coefficients) is the same for all equally good parameters.
    ///
    /// Judged in the units of the scaled columns, with the tolerance of the rank.
    pub fn determines(&self, functional: &DVector<f64>) -> bool {
        if self.scaled_null.ncols() == 0 {
            return true;
        }
        let scaled = functional.component_div(&self.column_scale);
        (self.scaled_null.transpose() * &scaled).norm() <= RANK_TOLERANCE * scaled.norm()
    }

    /// Whether parameter `place` of the p is the same for all equally good ones.
    pub fn determines_parameter(&self, place: usize) -> bool {
        let mut unit = DVector::zeros(self.column_scale.len());
        unit[place] = 1.0;
        self.determines(&unit)
    }

    /// Fits the measurements y (n).
    ///
    /// # Panics
    /// Where `y` has another length than the design has rows.
    pub fn fit(&self, y: &DVector<f64>) -> Fit {
        assert_eq!(y.len(), self.design.nrows(), "one measurement a row");
        let whitened = y.component_mul(&self.weights);
        let coordinates = self.basis.tr_mul(&whitened);
        let estimate = &self.back * &coordinates;
        // From the basis, not from y - X b: exact to rounding also where X b cancels large terms.
        let left = whitened - &self.basis * coordinates;
        Fit {
            estimate,
            covariance: self.covariance.clone(),
            rank: self.rank(),
            null_directions: self.null.clone(),
            residuals: left.component_div(&self.weights),
            leverage: self.leverage.clone(),
            chi2: left.norm_squared(),
            dof: y.len() - self.rank(),
        }
    }
}

/// What solves a design with columns of unit length.
struct Solved {
    /// Orthonormal columns that span what the design can produce.
    basis: DMatrix<f64>,
    /// Turns coordinates on `basis` into parameters.
    back: DMatrix<f64>,
    /// Orthonormal columns that the design does not see.
    scaled_null: DMatrix<f64>,
}

/// The inverse of R, where its condition is certainly better than the tolerance: the product of the Frobenius norms
/// of a matrix and its inverse is never less than the largest singular value over the smallest. No loss of rank can
/// hide in it, and of its digits no more than four are lost.
fn by_inverse(r: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let inverse = r.solve_upper_triangular(&DMatrix::identity(r.nrows(), r.ncols()))?;
    (r.norm() * inverse.norm() * RANK_TOLERANCE < 1.0).then_some(inverse)
}

fn by_singular_values(q: &DMatrix<f64>, r: DMatrix<f64>) -> Solved {
    let p = r.ncols();
    let svd = r.try_svd(true, true, 5.0 * f64::EPSILON, MOST_ITERATIONS).expect("finite numbers converge");
    let (u, v_t) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"));
    let threshold = RANK_TOLERANCE * svd.singular_values.max();
    let (kept, dropped): (Vec<usize>, Vec<usize>) = (0..p).partition(|&i| svd.singular_values[i] > threshold);
    let mut back = v_t.select_rows(&kept).transpose();
    for (k, &i) in kept.iter().enumerate() {
        back.column_mut(k).unscale_mut(svd.singular_values[i]);
    }
    Solved { basis: q * u.select_columns(&kept), back, scaled_null: v_t.select_rows(&dropped).transpose() }
}

/// A length to divide by: that of a vector of zeros counts as one.
fn positive(length: f64) -> f64 {
    if length > 0.0 { length } else { 1.0 }
}

#[cfg(test)]
mod tests;
