//! Noise of a history: white, as the stations state it, with a process beside it that remembers.
//!
//! Covariance sigma^2 (diag(s_k^2) + rho R): s_k the stated standard deviations relative to their mean square, R one
//! of the processes below with mean variance 1, rho its power beside the white noise. sigma is profiled out, so ln L =
//! -n/2 ln(r'V^-1 r / n) - 1/2 ln |V| (Harville 1977). Every cause has to be better than these by itself.

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

/// One covariance, as its lower Cholesky factor, row by row.
#[derive(Debug, Clone)]
pub(super) struct NoiseCovariance {
    pub process: Process,
    pub power: f64,
    n: usize,
    factor: Vec<f64>,
    pub half_log_det: f64,
}

impl NoiseCovariance {
    /// Row-packed lower triangle of a covariance; none where it is not positive definite.
    fn of(process: Process, power: f64, n: usize, mut a: Vec<f64>) -> Option<Self> {
        let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
        let mut half_log_det = 0.0;
        for i in 0..n {
            for j in 0..=i {
                let mut sum = a[at(i, j)];
                for k in 0..j {
                    sum -= a[at(i, k)] * a[at(j, k)];
                }
                if i == j {
                    if sum.is_nan() || sum <= 0.0 {
                        return None;
                    }
                    a[at(i, i)] = sum.sqrt();
                    half_log_det += a[at(i, i)].ln();
                } else {
                    a[at(i, j)] = sum / a[at(j, j)];
                }
            }
        }
        Some(Self { process, power, n, factor: a, half_log_det })
    }

    /// L^-1 v.
    pub fn whiten(&self, v: &[f64]) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.n);
        let mut start = 0;
        for (i, value) in v.iter().enumerate() {
            let row = &self.factor[start..=start + i];
            let done: f64 = row[..i].iter().zip(&out).map(|(l, x)| l * x).sum();
            out.push((value - done) / row[i]);
            start += i + 1;
        }
        out
    }
}

/// White noise first, then every process at every power. `variance` is that of each record, `known` are columns whose
/// coefficient is known with a variance.
pub(super) fn models(t: &[f64], variance: &[f64], known: &[(Vec<f64>, f64)]) -> Vec<NoiseCovariance> {
    let n = t.len();
    let mut base = Vec::with_capacity(n * (n + 1) / 2);
    for i in 0..n {
        for j in 0..=i {
            let shared: f64 = known.iter().map(|(column, v)| v * column[i] * column[j]).sum();
            base.push(shared + if i == j { variance[i] } else { 0.0 });
        }
    }
    let mut all: Vec<NoiseCovariance> = NoiseCovariance::of(Process::White, 0.0, n, base.clone()).into_iter().collect();
    for process in [Process::RandomWalk, Process::WalkByRecord, Process::Flicker] {
        let mut shape = Vec::with_capacity(base.len());
        for i in 0..n {
            shape.extend((0..=i).map(|j| process.covariance(t, i, j)));
        }
        all.extend(POWERS.iter().filter_map(|power| {
            let sum = base.iter().zip(&shape).map(|(a, b)| a + power * b).collect();
            NoiseCovariance::of(process, *power, n, sum)
        }));
    }
    all
}
