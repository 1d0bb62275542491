//! Coefficients that all gyros of an IMU share: a tilt of the table is one tilt to all of them.
//!
//! With `B_j` an orthonormal basis of gyro j's own whitened columns (model (6) and its own effects), `X_j` the
//! regressors of the shared coefficients `k`, `W_j` its weights and `s_j` its noise over them,
//!
//! ```text
//! k = (sum_j Z_j'Z_j / s_j^2)^-1 sum_j Z_j' W_j y_j / s_j^2,   Z_j = (1 - B_j B_j') W_j X_j
//! ```
//!
//! is what one fit of all gyros together gives (Frisch and Waugh 1933, Lovell 1963). Each gyro's own parameters are
//! those of `y_j - X_j k`, and their covariance that of its own fit plus `T_j cov(k) T_j'`, `T_j` what its own
//! columns make of `X_j`.

use nalgebra::{DMatrix, DVector};

use crate::core::calibrate::regressor::{Regressor, adding, told_apart};
use crate::core::effects::Effect;
use crate::core::numerics::basis::Basis;
use crate::core::numerics::least_squares::Factor;

/// One shared coefficient: its regressor in each gyro, pulse/s per unit; none where the gyro is not one of those that
/// have it.
pub(super) type SharedRegressors = Vec<Option<Regressor>>;

/// Degrees of freedom that gyros share, in whole numbers of the same sum.
pub(super) fn in_whole_numbers(shares: impl Iterator<Item = f64>) -> impl Iterator<Item = usize> {
    shares.scan(0.0, |taken: &mut f64, share| {
        let before = taken.round();
        *taken += share;
        Some((taken.round() - before) as usize)
    })
}

/// One gyro as its own columns leave it.
pub(super) struct OwnFit<'a> {
    pub factor: &'a Factor,
    /// Residuals of its own fit, pulse/s.
    pub residuals: &'a DVector<f64>,
    /// s_j^2.
    pub variance: f64,
}

/// The shared coefficients, and how much of each gyro they take.
pub(super) struct CommonFit {
    /// By coefficient, and in each gyro that has it the regressor.
    pub kept: Vec<SharedRegressors>,
    pub hidden: Vec<Effect>,
    pub estimate: DVector<f64>,
    pub covariance: DMatrix<f64>,
    /// s_j^2 of each gyro: the covariance is in these units.
    pub variances: Vec<f64>,
    /// By gyro: share of each measurement in its own fitted value that the shared coefficients add.
    pub leverage: Vec<DVector<f64>>,
}

/// Fits what all gyros share beside what each has for itself.
pub(super) fn fit(shared: Vec<SharedRegressors>, gyros: &[OwnFit]) -> CommonFit {
    let columns: Vec<DVector<f64>> = shared.iter().map(|regressor| stacked(regressor, gyros)).collect();
    let raw = |regressor: &SharedRegressors| -> f64 {
        let power = |(r, own): (&Option<Regressor>, &OwnFit)| {
            r.as_ref().map_or(0.0, |r| r.column.component_mul(own.factor.weights()).norm_squared() / own.variance)
        };
        regressor.iter().zip(gyros).map(power).sum()
    };
    let n = gyros.first().map_or(0, |own| own.residuals.len());
    let powers = shared.iter().map(raw);
    let (adds, basis) = adding(Basis::default(), powers.zip(columns.iter().cloned()));
    let basis = basis.matrix(gyros.len() * n);
    let fitted: Vec<&DVector<f64>> = columns.iter().zip(&adds).filter(|(_, adds)| **adds).map(|(c, _)| c).collect();
    let (kept, hidden) = told_apart(shared, &adds, |regressor| regressor.iter().flatten().map(|r| r.effect).next());
    let m = kept.len();
    let whitened = |own: &OwnFit| own.residuals.component_mul(own.factor.weights()).unscale(own.variance.sqrt());
    let side: Vec<f64> = gyros.iter().flat_map(|own| whitened(own).data.as_vec().clone()).collect();
    let along = basis.tr_mul(&DVector::from_vec(side));
    // The kept columns are R on the basis, upper triangular, as Gram and Schmidt leave them.
    let r = DMatrix::from_fn(m, m, |i, j| if i <= j { basis.column(i).dot(fitted[j]) } else { 0.0 });
    let back = r.solve_upper_triangular(&DMatrix::identity(m, m)).unwrap_or_else(|| DMatrix::zeros(m, m));
    let leverage = (0..gyros.len()).map(|j| DVector::from_fn(n, |k, _| basis.row(j * n + k).norm_squared())).collect();
    let variances = gyros.iter().map(|own| own.variance).collect();
    CommonFit { kept, hidden, estimate: &back * along, covariance: &back * back.transpose(), variances, leverage }
}

/// Z of all gyros end to end, each over its noise.
fn stacked(regressor: &SharedRegressors, gyros: &[OwnFit]) -> DVector<f64> {
    let of_gyro = |(regressor, own): (&Option<Regressor>, &OwnFit)| -> Vec<f64> {
        let Some(regressor) = regressor else { return vec![0.0; own.residuals.len()] };
        let whitened = regressor.column.component_mul(own.factor.weights()).unscale(own.variance.sqrt());
        let mut left: Vec<f64> = whitened.data.into();
        Basis::of_orthonormal(own.factor.basis()).project_out(&mut left);
        left
    };
    DVector::from_vec(regressor.iter().zip(gyros).flat_map(of_gyro).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::effects::Effect;

    /// A fixed sequence without any pattern that the columns have.
    fn number(i: usize) -> f64 {
        (7.3 * i as f64).sin() + 0.4 * (3.1 * i as f64 * i as f64).cos()
    }

    const N: usize = 9;

    fn column(from: usize) -> DVector<f64> {
        DVector::from_fn(N, |k, _| number(from + k))
    }

    fn regressor(column: DVector<f64>) -> Option<Regressor> {
        let coefficient = Effect::Levelling.entry().coefficients(crate::core::effects::Shape::Linear)[0];
        Some(Regressor { effect: Effect::Levelling, coefficient, column })
    }

    #[test]
    fn shared_coefficients_are_those_of_one_fit_of_all_gyros_together() {
        let sd = [vec![0.5; N], (0..N).map(|k| 1.0 + 0.1 * k as f64).collect::<Vec<f64>>()];
        let variances = [1.7, 0.6];
        let designs = [10, 400].map(|from| DMatrix::from_fn(N, 2, |k, c| number(from + 50 * c + k)));
        let outputs = [column(800), column(900)];
        let x = [[column(1000), column(1100)], [column(1200), column(1300)]];
        let factors: Vec<Factor> = (0..2).map(|j| Factor::new(designs[j].clone(), &sd[j])).collect();
        let residuals: Vec<DVector<f64>> = (0..2).map(|j| factors[j].fit(&outputs[j]).residuals).collect();
        let own: Vec<OwnFit> =
            (0..2).map(|j| OwnFit { factor: &factors[j], residuals: &residuals[j], variance: variances[j] }).collect();
        let shared = x.iter().map(|gyros| gyros.iter().map(|c| regressor(c.clone())).collect()).collect();
        let found = fit(shared, &own);

        // All at once: two columns of each gyro of its own, then the two shared ones, rows over their deviations.
        let mut all = DMatrix::zeros(2 * N, 6);
        let mut side = DVector::zeros(2 * N);
        for j in 0..2 {
            for k in 0..N {
                let weight = 1.0 / (sd[j][k] * f64::sqrt(variances[j]));
                side[j * N + k] = weight * outputs[j][k];
                for c in 0..2 {
                    all[(j * N + k, 2 * j + c)] = weight * designs[j][(k, c)];
                    all[(j * N + k, 4 + c)] = weight * x[c][j][k];
                }
            }
        }
        let back = all.clone().svd(true, true).solve(&DMatrix::identity(2 * N, 2 * N), 1e-12).unwrap();
        let (together, normal) = (&back * side, &back * back.transpose());
        for c in 0..2 {
            assert!((found.estimate[c] - together[4 + c]).abs() < 1e-9, "{} {}", found.estimate, together);
            for d in 0..2 {
                assert!((found.covariance[(c, d)] - normal[(4 + c, 4 + d)]).abs() < 1e-9);
            }
        }
        let hat = &all * &normal * all.transpose();
        for j in 0..2 {
            for k in 0..N {
                let leverage = factors[j].leverage()[k] + found.leverage[j][k];
                assert!((leverage - hat[(j * N + k, j * N + k)]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn what_the_gyros_own_columns_span_is_not_fitted() {
        let factor = Factor::new(DMatrix::from_fn(N, 2, |k, c| number(10 + 50 * c + k)), &[1.0; N]);
        let residuals = factor.fit(&column(800)).residuals;
        let own = [OwnFit { factor: &factor, residuals: &residuals, variance: 1.0 }];
        let hidden = DVector::from_fn(N, |k, _| number(10 + k) - 2.0 * number(60 + k));
        let found = fit(vec![vec![regressor(hidden)], vec![regressor(column(1000))]], &own);
        assert_eq!((found.kept.len(), found.hidden), (1, vec![Effect::Levelling]));
    }
}
