//! Noise of a history: white, as the stations state it, with a process beside it that remembers.
//!
//! Covariance sigma^2 (diag(s_k^2) + rho R): s_k the stated standard deviations relative to their mean square, R one
//! of the processes below with mean variance 1, rho its power beside the white noise. sigma is profiled out, so ln L =
//! -n/2 ln(r'V^-1 r / n) - 1/2 ln |V| (Harville 1977). Every cause has to be better than these by itself.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::core::named::named;

named! {
/// A process with a memory, R_ij.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Process {
    White = "white",
    /// min(t_i, t_j): variance grows with time.
    RandomWalk = "random_walk",
    /// min(i, j): variance grows with every occasion.
    WalkByRecord = "walk_by_record",
    /// 1/f over the span: sum of exponential memories, their times a factor of four apart.
    Flicker = "flicker",
}
}

impl Process {
    fn covariance(self, t: &[f64], i: usize, j: usize) -> f64 {
        let n = t.len();
        let span = (t[n - 1] - t[0]).max(f64::MIN_POSITIVE);
        match self {
            Self::White => 0.0,
            Self::RandomWalk => (t[i.min(j)] - t[0]) / span,
            Self::WalkByRecord => i.min(j) as f64 / (n - 1) as f64,
            Self::Flicker => {
                let lag = (t[i] - t[j]).abs() / span;
                [1.0, 4.0, 16.0, 64.0].iter().map(|rate| (-lag * rate).exp()).sum::<f64>() / 4.0
            }
        }
    }
}

/// Powers of a process beside the white noise.
const POWERS: [f64; 7] = [0.5, 2.0, 8.0, 32.0, 128.0, 512.0, 8192.0];

/// One covariance, by its Cholesky factor.
#[derive(Debug, Clone)]
pub(super) struct NoiseCovariance {
    pub process: Process,
    pub power: f64,
    factor: Cholesky<f64, Dyn>,
    pub half_log_det: f64,
}

impl NoiseCovariance {
    /// None where it is not positive definite.
    fn of(process: Process, power: f64, covariance: DMatrix<f64>) -> Option<Self> {
        let factor = Cholesky::new(covariance)?;
        let half_log_det = 0.5 * factor.ln_determinant();
        Some(Self { process, power, factor, half_log_det })
    }

    /// L^-1 v.
    pub fn whiten(&self, v: &[f64]) -> Vec<f64> {
        let mut out = DVector::from_column_slice(v);
        self.factor.l_dirty().solve_lower_triangular_unchecked_mut(&mut out);
        out.data.into()
    }
}

/// White noise first, then every process at every power. `variance` is that of each record, `known` are columns whose
/// coefficient is known with a variance.
pub(super) fn models(t: &[f64], variance: &[f64], known: &[(Vec<f64>, f64)]) -> Vec<NoiseCovariance> {
    let n = t.len();
    let base = DMatrix::from_fn(n, n, |i, j| {
        let shared: f64 = known.iter().map(|(column, v)| v * column[i] * column[j]).sum();
        shared + if i == j { variance[i] } else { 0.0 }
    });
    let mut all: Vec<NoiseCovariance> = NoiseCovariance::of(Process::White, 0.0, base.clone()).into_iter().collect();
    for process in [Process::RandomWalk, Process::WalkByRecord, Process::Flicker] {
        let shape = DMatrix::from_fn(n, n, |i, j| process.covariance(t, i, j));
        let of = |power: &f64| NoiseCovariance::of(process, *power, &base + &shape * *power);
        all.extend(POWERS.iter().filter_map(of));
    }
    all
}
