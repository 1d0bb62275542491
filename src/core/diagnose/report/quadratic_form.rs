//! Whether residuals are alike that should be independent: a quadratic form of them, and its distribution under noise.
//!
//! Residuals `r = P e` of white noise `e` with the projector `P = 1 - Q Q'` of the model (`Q` an orthonormal basis of
//! its whitened design, `d` degrees of freedom) give `T = r'Wr / (r'r/d)`. With `A = PWP`, `m = tr(A)/d` and the
//! traces `a2 = tr(A^2)`, `a3 = tr(A^3)`:
//!
//! ```text
//! mean      tr(A)
//! variance  2 (a2 - m^2 d)                  d/(d + 2)
//! third     8 (a3 - 3 m a2 + 2 m^3 d)       d^2/((d + 2)(d + 4))      third central moment
//! ```
//!
//! exactly: the scale is estimated from the same residuals, so that T depends on their direction alone, which is
//! uniform on the sphere in d dimensions. A form with a few large eigenvalues is far from normal: beyond 0.1 % of the
//! normal distribution lie 0.7 % of it. The tail is that of the gamma distribution with the same three moments
//! (Pearson type III). That distribution ends above where the skewness is negative, before the form does: there the
//! tail is that of the normal distribution, corrected for the skewness (Cornish and Fisher's first term), which is
//! never too light.

use nalgebra::{DMatrix, DVector};
use statrs::function::gamma::checked_gamma_ur;

use crate::core::numerics::basis::dot;
use crate::core::numerics::normal::normal_cdf;

/// Skewness below which the gamma distribution is the normal one for all purposes.
const STRAIGHT: f64 = 1e-3;

/// More dwells than this have the trace of their cubed weights estimated: it takes a product of matrices otherwise.
const MOST_EXACT: usize = 300;

/// Vectors of random signs for that: where a single eigenvalue rules, the trace has a relative standard deviation of
/// 18 %, and less where many share it.
const PROBES: usize = 64;

/// Which dwells should be independent: symmetric, n x n, nothing on the diagonal.
pub(super) struct Weights {
    matrix: DMatrix<f64>,
    /// tr(W^3).
    cubed: f64,
}

impl Weights {
    /// From W, n x n. tr(W^3) is exact up to 300 dwells and estimated with random signs beyond.
    pub fn new(matrix: DMatrix<f64>) -> Self {
        let n = matrix.nrows();
        let cubed = if n <= MOST_EXACT {
            (&matrix * &matrix).dot(&matrix)
        } else {
            let signs = DMatrix::from_fn(n, PROBES, |k, c| sign(k * PROBES + c));
            let once = &matrix * signs;
            once.dot(&(&matrix * &once)) / PROBES as f64
        };
        Self { matrix, cubed }
    }

    /// The form and its moments for residuals with `dof` degrees of freedom of a model with the orthonormal `basis`
    /// (n x p); none where too little is left to say.
    pub fn test(&self, basis: &DMatrix<f64>, dof: f64) -> Option<QuadraticFormTest<'_>> {
        if dof < 4.0 {
            return None;
        }
        let across = &self.matrix * basis;
        let inner = basis.tr_mul(&across);
        let twice = &inner * &inner;
        // tr W = 0 by construction; with B = Q'WQ: tr(A^2) = tr WW - 2 tr(Q'WWQ) + tr(BB), and
        // tr(A^3) = tr WWW - 3 tr(Q'WWWQ) + 3 tr(B Q'WWQ) - tr(BBB).
        let mean = -inner.trace();
        let square = self.matrix.norm_squared() - 2.0 * across.norm_squared() + twice.trace();
        let cube = self.cubed - 3.0 * across.dot(&(&self.matrix * &across)) + 3.0 * inner.dot(&across.tr_mul(&across))
            - inner.dot(&twice);
        let m = mean / dof;
        let variance = 2.0 * (square - m * mean) * dof / (dof + 2.0);
        if variance.is_nan() || variance <= 1e-9 * self.matrix.norm_squared() {
            return None;
        }
        let central = cube - 3.0 * m * square + 2.0 * m * m * mean;
        let third = 8.0 * central * dof * dof / ((dof + 2.0) * (dof + 4.0));
        Some(QuadraticFormTest {
            weights: &self.matrix,
            dof,
            mean,
            sd: variance.sqrt(),
            skewness: third / variance.powf(1.5),
        })
    }
}

/// 1 or -1, as good as random (the finalizer of MurmurHash3).
fn sign(number: usize) -> f64 {
    let mut bits = number as u64 ^ 0x9e37_79b9_7f4a_7c15;
    bits = (bits ^ (bits >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    bits = (bits ^ (bits >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    if (bits ^ (bits >> 33)) & 1 == 0 { 1.0 } else { -1.0 }
}

pub(super) struct QuadraticFormTest<'w> {
    weights: &'w DMatrix<f64>,
    dof: f64,
    mean: f64,
    sd: f64,
    skewness: f64,
}

impl QuadraticFormTest<'_> {
    /// Of whitened residuals, n.
    pub fn score(&self, residual: &[f64]) -> Score {
        let scale = dot(residual, residual) / self.dof;
        if scale.is_nan() || scale <= 0.0 {
            return Score::NONE;
        }
        let r = DVector::from_column_slice(residual);
        let form = r.dot(&(self.weights * &r));
        Score { z: (form / scale - self.mean) / self.sd, skewness: self.skewness }
    }
}

/// A figure with mean 0, variance 1 and a skewness under noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Score {
    z: f64,
    skewness: f64,
}

impl Score {
    /// Of a test that says nothing.
    pub const NONE: Self = Self { z: 0.0, skewness: 0.0 };

    /// Of independent scores together.
    pub fn together(scores: &[Self]) -> Self {
        let n = scores.len() as f64;
        let (z, third) = scores.iter().fold((0.0, 0.0), |(z, third), score| (z + score.z, third + score.skewness));
        Self { z: z / n.sqrt(), skewness: third / n.powf(1.5) }
    }

    /// Probability of a larger one.
    pub fn p_value(self) -> f64 {
        let Self { z, skewness } = self;
        if skewness < STRAIGHT {
            let beyond = z.max(1.0);
            return normal_cdf(skewness / 6.0 * (beyond * beyond - 1.0) - z);
        }
        let shape = 4.0 / (skewness * skewness);
        let at = shape + z * shape.sqrt();
        // Below its beginning; what cannot be computed is no evidence either.
        if at > 0.0 { checked_gamma_ur(shape, at).unwrap_or(1.0) } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;

    /// Dwells and columns of the model: as many as a campaign has, and a bare one.
    const DESIGNS: [(usize, usize); 2] = [(60, 14), (24, 12)];

    fn pairs(n: usize, like: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |a, b| if a == b { 0.0 } else { like(a.min(b), a.max(b)) })
    }

    /// Runs in time, neighbours, groups of repeats, and values of a slow wave.
    fn weights(n: usize) -> [DMatrix<f64>; 4] {
        [
            pairs(n, |a, b| (-((b - a) as f64 / 5.0)).exp()),
            pairs(n, |a, b| f64::from(u8::from(b - a == 1))),
            pairs(n, |a, b| f64::from(u8::from(3 * a % n == 3 * b % n))),
            pairs(n, |a, b| (-(((a as f64 / 12.0).sin() - (b as f64 / 12.0).sin()) / 0.1).powi(2)).exp()),
        ]
    }

    /// An orthonormal basis: powers and waves over the dwells.
    fn basis((n, columns): (usize, usize)) -> DMatrix<f64> {
        let raw = DMatrix::from_fn(n, columns, |k, c| {
            let t = k as f64 / n as f64;
            if c < 4 { t.powi(c as i32) } else { (t * 3.0 * c as f64 + c as f64).sin() }
        });
        raw.qr().q()
    }

    fn noise(random: &mut ChaCha8Rng, basis: &DMatrix<f64>) -> DVector<f64> {
        let e = DVector::from_fn(basis.nrows(), |_, _| StandardNormal.sample(random));
        &e - basis * basis.tr_mul(&e)
    }

    #[test]
    fn noise_has_the_moments_and_each_probability_as_often_as_it_says() {
        let mut random = ChaCha8Rng::seed_from_u64(20_261_122);
        for design in DESIGNS {
            let (basis, dof) = (basis(design), (design.0 - design.1) as f64);
            for (i, matrix) in weights(design.0).into_iter().enumerate() {
                let weights = Weights::new(matrix);
                let test = weights.test(&basis, dof).expect("enough is left");
                const DRAWS: usize = 20_000;
                let scores: Vec<Score> =
                    (0..DRAWS).map(|_| test.score(noise(&mut random, &basis).as_slice())).collect();
                let moment = |n: i32| scores.iter().map(|score| score.z.powi(n)).sum::<f64>() / DRAWS as f64;
                assert!(moment(1).abs() < 0.03, "form {i} of {dof}: mean {}", moment(1));
                assert!((moment(2) - 1.0).abs() < 0.08, "form {i} of {dof}: variance {}", moment(2));
                assert!((moment(3) - test.skewness).abs() < 0.25, "form {i} of {dof}: third moment {}", moment(3));
                let mut p_values: Vec<f64> = scores.iter().map(|score| score.p_value()).collect();
                p_values.sort_by(f64::total_cmp);
                // Binomial scatter is 2 %, 7 % and 22 % of these; the approximation takes the rest. With few degrees
                // of freedom the form has an end that the gamma distribution does not know: there it says too much,
                // never too little.
                let least = if dof < 20.0 { 0.0 } else { 0.3 };
                for (level, low, high) in [(0.1, 0.85, 1.15), (0.01, 0.75, 1.3), (0.001, least, 1.9)] {
                    let share = p_values.partition_point(|p| *p < level) as f64 / DRAWS as f64 / level;
                    assert!((low..high).contains(&share), "form {i} of {dof}: {share} of what {level} promises");
                }
            }
        }
    }

    #[test]
    fn a_form_that_ends_soon_above_never_says_more_than_noise_does() {
        let mut random = ChaCha8Rng::seed_from_u64(20_261_130);
        for design in DESIGNS {
            let (basis, dof) = (basis(design), (design.0 - design.1) as f64);
            for matrix in weights(design.0) {
                let weights = Weights::new(-matrix);
                let test = weights.test(&basis, dof).expect("enough is left");
                assert!(test.skewness < 0.0);
                const DRAWS: usize = 10_000;
                let p_values = || test.score(noise(&mut random, &basis).as_slice()).p_value();
                let p_values: Vec<f64> = std::iter::repeat_with(p_values).take(DRAWS).collect();
                for level in [0.1, 0.01, 0.001] {
                    let share = p_values.iter().filter(|p| **p < level).count() as f64 / DRAWS as f64 / level;
                    assert!(share < 1.0 + 3.0 / (DRAWS as f64 * level).sqrt(), "{share} of what {level} promises");
                }
            }
        }
        // Residuals that are less alike than noise say nothing, however far.
        let p_values = [-8.0, -3.0, -1.0, 0.0, 1.0, 2.0].map(|z| Score { z, skewness: -1.767 }.p_value());
        assert!(p_values[0] > 0.99 && p_values.is_sorted_by(|a, b| a >= b), "{p_values:?}");
        // Two thirds of the way to its end is nothing.
        assert!(Score { z: 1.391, skewness: -1.767 }.p_value() > 0.04);
        assert!(Score { z: 9.0, skewness: -0.2 }.p_value() < 1e-20);
    }

    #[test]
    fn the_traces_are_those_of_the_projected_form() {
        for design in DESIGNS {
            let (n, basis, dof) = (design.0, basis(design), (design.0 - design.1) as f64);
            let projector = DMatrix::identity(n, n) - &basis * basis.transpose();
            for matrix in weights(n) {
                let a = &projector * &matrix * &projector;
                // What a constant takes off, taken off the form itself.
                let centred = &a - &projector * (a.trace() / dof);
                let (square, cube) = ((&centred * &centred).trace(), (&centred * &centred * &centred).trace());
                let variance = 2.0 * square * dof / (dof + 2.0);
                let third = 8.0 * cube * dof * dof / ((dof + 2.0) * (dof + 4.0));
                let weights = Weights::new(matrix);
                let found = weights.test(&basis, dof).expect("enough is left");
                assert!((found.mean - a.trace()).abs() < 1e-9);
                assert!((found.sd.powi(2) / variance - 1.0).abs() < 1e-9);
                let skewness = third / variance.powf(1.5);
                assert!((found.skewness - skewness).abs() < 1e-6, "{} {skewness}", found.skewness);
            }
        }
    }

    #[test]
    fn many_dwells_have_their_trace_estimated_closely() {
        let n = MOST_EXACT + 60;
        let matrix = DMatrix::from_fn(n, n, |a, b| if a == b { 0.0 } else { (-(a.abs_diff(b) as f64 / 5.0)).exp() });
        let exact = (&matrix * &matrix).dot(&matrix);
        assert!((Weights::new(matrix).cubed / exact - 1.0).abs() < 0.1);
    }
}
