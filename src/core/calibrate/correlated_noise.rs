//! Noise that dwells have in common: what a bias does between them, beside what scatters within each.
//!
//! Per gyro `V = diag(d^2) + phi s^2 K`, d the standard deviation of each dwell, s their median, and K one of two
//! kernels of the dwells' times ([`CorrelatedNoise`]). K is constant in pulse/s: a bias wanders however long a dwell
//! was. phi is common to the gyros, each wanders for itself. Every pair (K, phi) has its restricted likelihood
//!
//! ```text
//! ln L = -1/2 ln det V - 1/2 ln det X'V^-1 X - 1/2 (n - q + k) ln(k + RSS)
//! ```
//!
//! with k the degrees of freedom in favour of what is stated, none without standard errors; and so has every
//! [`Law`] by which the noise may go beside what is stated. The estimates stay those of the stated weights; their
//! covariance is the mean over all of these and over white noise as stated, each with its weight.
//!
//! Both kernels are states of a linear system, so `L^-1 X` with `V = L L'` is what a Kalman filter makes of X: its
//! work grows with the dwells, not with their cube.

use std::ops::AddAssign;

use nalgebra::{DMatrix, DVector, Matrix4, Vector4};

use super::law::{AS_STATED, DwellConditions, Law};
use super::noise::{PRIOR_DOF, overstated};
use crate::core::named::named;
use crate::core::numerics::least_squares::Factor;
use crate::core::numerics::log_sum::LogSum;
use crate::core::numerics::median::median_of;

/// Powers of each kernel, over the square of the median standard deviation.
pub const POWERS: [f64; 5] = [0.15, 0.5, 1.5, 5.0, 20.0];

/// A random walk needs more for as much, because its kernel is one at the middle of the campaign.
pub const OF_WALK: f64 = 3.0;

/// Correlation times of flicker, in spacings of dwells.
pub const TIMES: [f64; 4] = [1.5, 5.0, 16.0, 50.0];

/// Prior probability that there is no memory; the pairs of kernel and power share the rest.
pub const WITHOUT_MEMORY: f64 = 0.995;

/// ln of a weight below which a kind of noise is left out.
const NOTHING: f64 = -9.0;

named! {
/// What dwells have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CorrelatedNoise {
    /// Mean over [`TIMES`] of exp(-|dt|/tau): about as flat over the decades as flicker is.
    Flicker = "flicker",
    /// min(t, t')/mean t.
    Walk = "random_walk",
}
}

impl CorrelatedNoise {
    /// By how much more power a pair of this kernel has.
    pub fn size(self) -> f64 {
        if self == Self::Walk { OF_WALK } else { 1.0 }
    }

    /// K for dwells at these times, n x n.
    pub fn kernel(self, times: &[f64]) -> DMatrix<f64> {
        let n = times.len();
        self.times(times, DMatrix::identity(n, n))
    }

    /// K X without K (n x n): two passes over the dwells.
    fn times(self, times: &[f64], x: DMatrix<f64>) -> DMatrix<f64> {
        let n = times.len();
        let mut product = DMatrix::zeros(n, x.ncols());
        let clock = DwellTimes::of(times);
        match self {
            Self::Flicker => {
                for tau in TIMES {
                    let keep = |k: usize| (-clock.steps[k] / tau / clock.spacing).exp();
                    let (mut before, mut after) = (x.clone(), x.clone());
                    for k in 1..n {
                        let last = before.row(k - 1) * keep(k);
                        before.row_mut(k).add_assign(&last);
                    }
                    for k in (1..n).rev() {
                        let next = after.row(k) * keep(k);
                        after.row_mut(k - 1).add_assign(&next);
                    }
                    product += (before + after - &x) / TIMES.len() as f64;
                }
            }
            Self::Walk => {
                let mut after = x;
                for k in (1..n).rev() {
                    let next = after.row(k).into_owned();
                    after.row_mut(k - 1).add_assign(&next);
                }
                for k in 1..n {
                    let step = product.row(k - 1) + after.row(k) * (clock.steps[k] / clock.mean);
                    product.set_row(k, &step);
                }
            }
        }
        product
    }

    /// `L^-1 X` and ln det L, with `L L' = diag(d^2) + power K`.
    fn whitened(self, times: &[f64], d: &DVector<f64>, power: f64, mut x: DMatrix<f64>) -> (DMatrix<f64>, f64) {
        let clock = DwellTimes::of(times);
        let m = x.ncols();
        // What the states are expected to be, column by column of X, and their covariance.
        let mut expected = DMatrix::<f64>::zeros(4, m);
        let each = power / TIMES.len() as f64;
        let (mut covariance, mut log_det) = (Matrix4::from_diagonal_element(each), 0.0);
        if self == Self::Walk {
            covariance.fill(0.0);
        }
        let seen = Vector4::repeat(1.0);
        for k in 0..times.len() {
            if k > 0 && self == Self::Flicker {
                let keep = Vector4::from(TIMES.map(|tau| (-clock.steps[k] / tau / clock.spacing).exp()));
                covariance = Matrix4::from_fn(|a, b| {
                    keep[a] * keep[b] * covariance[(a, b)] + if a == b { each * (1.0 - keep[a] * keep[a]) } else { 0.0 }
                });
                expected.row_iter_mut().zip(&keep).for_each(|(mut row, keep)| row *= *keep);
            } else if k > 0 {
                covariance[(0, 0)] += power * clock.steps[k] / clock.mean;
            }
            let gain = covariance * seen;
            let variance = gain.sum() + d[k] * d[k];
            for c in 0..m {
                let surprise = x[(k, c)] - expected.column(c).sum();
                for a in 0..4 {
                    expected[(a, c)] += gain[a] * surprise / variance;
                }
                x[(k, c)] = surprise / variance.sqrt();
            }
            covariance -= gain * gain.transpose() / variance;
            log_det += 0.5 * variance.ln();
        }
        (x, log_det)
    }
}

/// Times of dwells as the kernels need them.
struct DwellTimes {
    /// Since the dwell before, s.
    steps: Vec<f64>,
    /// Usual one.
    spacing: f64,
    /// Mean time since the first dwell.
    mean: f64,
}

impl DwellTimes {
    fn of(times: &[f64]) -> Self {
        let steps: Vec<f64> = (0..times.len()).map(|k| if k > 0 { times[k] - times[k - 1] } else { 0.0 }).collect();
        let spacing = median_of(steps.iter().skip(1).copied()).map_or(1.0, |step| step.max(f64::MIN_POSITIVE));
        let since = times.iter().map(|t| t - times[0]).sum::<f64>() / times.len() as f64;
        Self { steps, spacing, mean: since.max(f64::MIN_POSITIVE) }
    }
}

/// One gyro as its fit leaves it.
pub(super) struct FittedGyro<'a> {
    /// Orthonormal basis of the design over `weights`, n x q.
    pub basis: &'a DMatrix<f64>,
    pub weights: &'a DVector<f64>,
    /// Variances over those of the weights; and the same without a growth with rate.
    pub variances: &'a DVector<f64>,
    pub even: &'a DVector<f64>,
    /// y - X b.
    pub residuals: &'a DVector<f64>,
    /// Degrees of freedom left over.
    pub dof: usize,
}

/// Noise other than white and as stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoiseDeparture {
    Law(Law),
    /// A kernel with its power phi.
    CorrelatedNoise(CorrelatedNoise, f64),
}

impl NoiseDeparture {
    /// Whether dwells near in time err alike.
    pub fn has_memory(&self) -> bool {
        matches!(self, Self::CorrelatedNoise(..))
    }

    /// All that dwells can tell, each with ln of its prior probability.
    fn all(course: &DwellConditions, stated: bool) -> Vec<(Self, f64)> {
        // Without standard errors the duration is in the variances, and the rate along the input axis.
        let is_open = |law: &Law| stated || !matches!(law, Law::Duration(_));
        let laws: Vec<Law> = Law::all(course).into_iter().filter(is_open).collect();
        let of_law = ((1.0 - AS_STATED) / laws.len() as f64).ln();
        let of_pair = ((1.0 - WITHOUT_MEMORY) / (CorrelatedNoise::ALL.len() * POWERS.len()) as f64).ln();
        let mut all: Vec<(Self, f64)> = laws.into_iter().map(|law| (Self::Law(law), of_law)).collect();
        for memory in CorrelatedNoise::ALL {
            all.extend(POWERS.map(|power| (Self::CorrelatedNoise(memory, power * memory.size()), of_pair)));
        }
        all
    }
}

/// What the noise is: kinds with their probabilities; white noise as stated has the rest.
pub type DepartureWeights = Vec<(NoiseDeparture, f64)>;

/// What [`weigh`] found.
pub(super) struct Weighed {
    pub kinds: DepartureWeights,
    /// The part that white noise as stated has in the covariance of each gyro.
    pub white: Vec<f64>,
    /// None where a memory is unlikely.
    pub wander: Option<Wander>,
}

/// The likelier kernel where its power is free, and its standard deviation in each gyro, pulse/s.
pub(super) struct Wander {
    pub memory: CorrelatedNoise,
    pub pulse_s: Vec<f64>,
}

impl Weighed {
    /// Of gyros whose noise is white as stated.
    pub fn white(gyros: usize) -> Self {
        Self { kinds: Vec::new(), white: vec![1.0; gyros], wander: None }
    }
}

/// Powers of what the dwell before leaves, over those of a memory.
const OF_LOAD: f64 = 10.0;

/// ln of odds by which that must be likelier in a gyro than any kind of noise.
const CLEARLY_OF_LOAD: f64 = 7.0;

/// Specific force of the dwell before, n x 3.
fn load_before(course: &DwellConditions) -> DMatrix<f64> {
    DMatrix::from_fn(course.times.len(), 3, |k, axis| if k > 0 { course.forces[k - 1][axis] } else { 0.0 })
}

impl<'a> FittedGyro<'a> {
    /// Of a fit whose weights are as its noise: `even` are ones; residuals with their degrees of freedom.
    pub fn of_even(factor: &'a Factor, even: &'a DVector<f64>, (residuals, dof): (&'a DVector<f64>, usize)) -> Self {
        Self { basis: factor.basis(), weights: factor.weights(), variances: even, even, residuals, dof }
    }

    /// ln L and RSS; `whitened` are the basis, as wide as the outputs, and the residuals over `L`.
    fn restricted(&self, (whitened, log_det): (DMatrix<f64>, f64), stated: bool) -> Option<(f64, f64)> {
        let q = self.basis.ncols();
        let (x, z) = (whitened.columns(0, q), whitened.column(q));
        let factor = x.tr_mul(&x).cholesky()?;
        let side = x.tr_mul(&z);
        let rss = z.norm_squared() - side.dot(&factor.solve(&side));
        let k = if stated { PRIOR_DOF } else { 0.0 };
        let log = -log_det - 0.5 * factor.ln_determinant() - 0.5 * (self.dof as f64 + k) * (k + rss).ln();
        log.is_finite().then_some((log, rss))
    }

    /// The basis in pulse/s and beside it the residuals.
    fn columns(&self) -> DMatrix<f64> {
        let q = self.basis.ncols();
        let mut columns = self.basis.clone().resize_horizontally(q + 1, 0.0);
        for (mut row, w) in columns.row_iter_mut().zip(self.weights.iter()) {
            row /= *w;
        }
        columns.set_column(q, self.residuals);
        columns
    }

    /// Standard deviations for `variances` over those of the weights.
    fn deviations(&self, variances: &DVector<f64>) -> DVector<f64> {
        variances.zip_map(self.weights, |v, w| v.sqrt() / w)
    }

    /// Variances where the noise goes by a law, over those of the weights.
    fn under(&self, law: Law, course: &DwellConditions) -> DVector<f64> {
        let factors = DVector::from_vec(law.factors(course));
        self.even.component_mul(&factors.component_mul(&factors))
    }

    /// The same where the dwell before leaves something, V = diag(d^2) + power B B', `load` being B.
    fn under_load(&self, d: &DVector<f64>, load: &DMatrix<f64>, power: f64, stated: bool) -> Option<(f64, f64)> {
        let (mut columns, mut load) = (self.columns(), load * power.sqrt());
        for (k, d) in d.iter().enumerate() {
            columns.row_mut(k).scale_mut(1.0 / d);
            load.row_mut(k).scale_mut(1.0 / d);
        }
        let split = load.svd(true, false);
        let (axes, sizes) = (split.u?, split.singular_values.map(|size| (1.0 + size * size).sqrt()));
        // (1 + U U')^-1/2 takes of the axes of U what is above one.
        let along = DMatrix::from_diagonal(&sizes.map(|size| 1.0 / size - 1.0)) * axes.tr_mul(&columns);
        columns += axes * along;
        let log_det = d.iter().chain(sizes.iter()).map(|size| size.ln()).sum();
        self.restricted((columns, log_det), stated)
    }

    /// ln of the mean restricted likelihood of correlated noise beside white noise over powers, evenly many in each
    /// decade, and by those likelihoods the mean of its standard deviation, pulse/s. The size of all noise is free.
    fn wander(&self, memory: CorrelatedNoise, times: &[f64], d: &DVector<f64>, stated: bool) -> Option<(f64, f64)> {
        const EACH_DECADE: f64 = 4.0;
        let usual = median_of(d.iter().copied())?;
        let k = if stated { PRIOR_DOF } else { 0.0 };
        let of_power = |step: i32| {
            let power = 10_f64.powf(f64::from(step) / EACH_DECADE) * usual * usual;
            let (log, rss) = self.restricted(memory.whitened(times, d, power, self.columns()), stated)?;
            Some((log, (power * (k + rss) / (k + self.dof as f64)).sqrt()))
        };
        let found: Vec<(f64, f64)> = (-8..=24).filter_map(of_power).collect();
        let all = LogSum::of(&found.iter().map(|(log, _)| *log).collect::<Vec<f64>>()).log();
        let mean = found.iter().map(|(log, size)| (log - all).exp() * size).sum::<f64>();
        (!found.is_empty()).then_some((all, mean))
    }

    /// Sum of squared residuals where the noise goes by a law, and its variances over those of the weights.
    pub fn squares_under(&self, law: Law, course: &DwellConditions, stated: bool) -> Option<(f64, DVector<f64>)> {
        let variances = self.under(law, course);
        let (_, rss) = self.independent(&self.deviations(&variances), stated)?;
        Some((rss, variances))
    }

    /// Restricted likelihood (ln L) of independent noise of these standard deviations, and RSS.
    pub fn independent(&self, d: &DVector<f64>, stated: bool) -> Option<(f64, f64)> {
        let mut columns = self.columns();
        for (mut row, d) in columns.row_iter_mut().zip(d.iter()) {
            row /= *d;
        }
        self.restricted((columns, d.iter().map(|d| d.ln()).sum()), stated)
    }
}

/// Weighs what the noise may be by what the residuals of all gyros say. Each gyro's covariance of the coordinates on
/// its basis (q x q), given for white noise as stated, becomes the mean over all kinds.
pub(super) fn weigh(
    course: &DwellConditions,
    gyros: &[FittedGyro],
    plain: &mut [Option<DMatrix<f64>>],
    stated: bool,
) -> Weighed {
    // Errors that are far too large for the residuals say nothing of which kind it is.
    let chi2 = gyros.iter().map(|gyro| gyro.residuals.component_mul(gyro.weights).norm_squared()).sum();
    let is_told = stated && overstated(chi2, gyros.iter().map(|gyro| gyro.dof).sum()).is_none();
    let d: Vec<DVector<f64>> = gyros.iter().map(|gyro| gyro.deviations(gyro.variances)).collect();
    let white = gyros.iter().zip(&d).map(|(gyro, d)| gyro.independent(d, is_told)).collect::<Option<Vec<_>>>();
    let Some(white) = white.filter(|_| gyros.iter().all(|gyro| gyro.dof > LEAST_DOF && gyro.residuals.norm() > 0.0))
    else {
        return Weighed::white(gyros.len());
    };
    let usual: Vec<f64> = d.iter().map(|d| median_of(d.iter().copied()).unwrap_or(1.0)).collect();
    let under = |kind: NoiseDeparture, j: usize| match kind {
        NoiseDeparture::Law(law) => gyros[j].independent(&gyros[j].deviations(&gyros[j].under(law, course)), is_told),
        NoiseDeparture::CorrelatedNoise(memory, power) => {
            let whitened = memory.whitened(&course.times, &d[j], power * usual[j].powi(2), gyros[j].columns());
            gyros[j].restricted(whitened, is_told)
        }
    };
    let as_stated = (AS_STATED - (1.0 - WITHOUT_MEMORY)).ln();
    let mut all = LogSum::of(&[as_stated]);
    let mut likely: Vec<(NoiseDeparture, f64, Vec<f64>)> = Vec::new();
    let mut likeliest: Vec<f64> = white.iter().map(|(log, _)| *log).collect();
    for (kind, prior) in NoiseDeparture::all(course, stated) {
        let Some(found) = (0..gyros.len()).map(|j| under(kind, j)).collect::<Option<Vec<_>>>() else { continue };
        likeliest.iter_mut().zip(&found).for_each(|(most, (log, _))| *most = most.max(*log));
        let gain: f64 = found.iter().zip(&white).map(|((log, _), (white, _))| log - white).sum();
        if prior + gain > NOTHING {
            all.add(prior + gain);
            likely.push((kind, prior + gain, found.into_iter().map(|(_, rss)| rss).collect()));
        }
    }
    let weight = |log: f64| (log - all.log()).exp();
    let k = if stated { PRIOR_DOF } else { 0.0 };
    let (load, mut white) = (load_before(course), vec![weight(as_stated); gyros.len()]);
    for (j, (plain, gyro)) in plain.iter_mut().zip(gyros).enumerate() {
        let Some(covariance) = plain else { continue };
        let nu = gyro.dof as f64 + k;
        let x = DMatrix::from_fn(gyro.basis.nrows(), gyro.basis.ncols(), |k, c| gyro.basis[(k, c)] * gyro.weights[k]);
        let shared = CorrelatedNoise::ALL.map(|memory| {
            let is_likely =
                likely.iter().any(|(kind, ..)| matches!(kind, NoiseDeparture::CorrelatedNoise(of, _) if *of == memory));
            is_likely.then(|| x.tr_mul(&memory.times(&course.times, x.clone())))
        });
        *covariance *= weight(as_stated);
        for (kind, log, rss) in &likely {
            let own = match *kind {
                NoiseDeparture::Law(law) => scaled(gyro.basis, &gyro.under(law, course)),
                NoiseDeparture::CorrelatedNoise(memory, power) => {
                    let shared = shared[usize::from(memory == CorrelatedNoise::Walk)].iter();
                    let within = scaled(gyro.basis, gyro.variances);
                    shared.fold(within, |sum, shared| sum + shared * (power * usual[j].powi(2)))
                }
            };
            *covariance += own * (weight(*log) * (k + rss[j]) / (nu - 2.0));
        }
        let left: Vec<(f64, f64, f64)> = (POWERS.iter())
            .map(|power| power * OF_LOAD * usual[j].powi(2))
            .filter_map(|power| gyro.under_load(&d[j], &load, power, is_told).map(|(log, rss)| (power, log, rss)))
            .collect();
        let mut of_load = LogSum::default();
        left.iter().for_each(|(_, log, _)| of_load.add(*log));
        if of_load.log_mean(POWERS.len()) > likeliest[j] + CLEARLY_OF_LOAD {
            let (within, into) = (scaled(gyro.basis, gyro.variances), x.tr_mul(&load));
            let one = |(power, log, rss): (f64, f64, f64)| {
                (&within + &into * into.transpose() * power) * ((log - of_load.log()).exp() * (k + rss) / (nu - 2.0))
            };
            *covariance = left.into_iter().map(one).sum();
            white[j] = 0.0;
        }
    }
    let kinds: DepartureWeights = likely.into_iter().map(|(kind, log, _)| (kind, weight(log))).collect();
    let of_memory: f64 = kinds.iter().filter(|(kind, _)| kind.has_memory()).map(|(_, weight)| weight).sum();
    let wander = |memory: CorrelatedNoise| {
        let found = gyros.iter().zip(&d).map(|(gyro, d)| gyro.wander(memory, &course.times, d, is_told));
        let (logs, pulse_s): (Vec<f64>, Vec<f64>) = found.collect::<Option<Vec<_>>>()?.into_iter().unzip();
        Some((logs.iter().sum::<f64>(), Wander { memory, pulse_s }))
    };
    let is_likely = |_: &CorrelatedNoise| of_memory > 0.5;
    let wanders = CorrelatedNoise::ALL.into_iter().filter(is_likely).filter_map(wander);
    let wander = wanders.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, wander)| wander);
    Weighed { kinds, white, wander }
}

/// Degrees of freedom from which on a memory is looked for.
const LEAST_DOF: usize = 10;

/// Q'diag(v)Q.
pub(super) fn scaled(basis: &DMatrix<f64>, variances: &DVector<f64>) -> DMatrix<f64> {
    let mut scaled = basis.clone();
    for (mut row, v) in scaled.row_iter_mut().zip(variances.iter()) {
        row *= *v;
    }
    basis.tr_mul(&scaled)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// Dwells of unequal spacing and noise.
    fn dwells() -> (Vec<f64>, DVector<f64>, DMatrix<f64>) {
        let times: Vec<f64> = (0..20).map(|k| 90.0 + 240.0 * k as f64 + if k > 11 { 3000.0 } else { 0.0 }).collect();
        let d = DVector::from_fn(20, |k, _| 1.0 + 0.3 * (1.7 * k as f64).sin());
        (times, d, DMatrix::from_fn(20, 3, |k, c| (7.3 * k as f64 + 2.1 * c as f64 * c as f64).sin()))
    }

    #[test]
    fn kernels_are_as_defined_and_the_filter_is_their_cholesky_factor() {
        let (times, d, x) = dwells();
        let since = |k: usize| times[k] - times[0];
        let mean = (0..20).map(since).sum::<f64>() / 20.0;
        for memory in CorrelatedNoise::ALL {
            let kernel = DMatrix::from_fn(20, 20, |a, b| match memory {
                CorrelatedNoise::Flicker => {
                    TIMES.map(|tau| (-(times[a] - times[b]).abs() / 240.0 / tau).exp()).iter().sum::<f64>() / 4.0
                }
                CorrelatedNoise::Walk => since(a).min(since(b)) / mean,
            });
            assert!((memory.kernel(&times) - &kernel).amax() < 1e-12, "{memory:?}");
            let covariance = DMatrix::from_diagonal(&d.component_mul(&d)) + 2.5 * &kernel;
            let lower = covariance.cholesky().expect("positive").unpack();
            let by_matrix = lower.solve_lower_triangular(&x).expect("it is regular");
            let (whitened, log_det) = memory.whitened(&times, &d, 2.5, x.clone());
            assert!((whitened - by_matrix).amax() < 1e-10, "{memory:?}");
            assert!((log_det - lower.diagonal().map(f64::ln).sum()).abs() < 1e-10, "{memory:?}");
        }
    }

    #[test]
    fn the_size_of_a_wander_is_its_own_beside_any_white_noise() {
        let n = 60;
        let times: Vec<f64> = (0..n).map(|k| 240.0 * k as f64).collect();
        let d = DVector::from_element(n, 0.2);
        let basis = DMatrix::from_fn(n, 3, |k, c| (7.3 * k as f64 + 2.1 * c as f64 * c as f64).sin()).qr().q();
        let (weights, ones) = (d.map(|d| 1.0 / d), DVector::from_element(n, 1.0));
        let mut rng = ChaCha8Rng::seed_from_u64(20);
        for (memory, size, white) in [
            (CorrelatedNoise::Flicker, 3.0, 1.0),
            (CorrelatedNoise::Flicker, 6.0, 1.0),
            (CorrelatedNoise::Flicker, 3.0, 2.0),
            (CorrelatedNoise::Walk, 30.0, 1.0),
        ] {
            let root = memory.kernel(&times).cholesky().map_or_else(
                || DMatrix::from_fn(n, n, |a, b| if b < a { (1.0 / (n as f64 - 1.0) * 2.0_f64).sqrt() } else { 0.0 }),
                |factor| factor.unpack(),
            );
            let mut ratios = Vec::new();
            for _ in 0..40 {
                let mut normal = || DVector::from_fn(n, |_, _| rng.sample::<f64, _>(StandardNormal));
                let noise = (normal() * white + &root * normal() * size) * 0.2;
                let whitened = noise.component_mul(&weights);
                let left = &whitened - &basis * basis.tr_mul(&whitened);
                let residuals = left.component_div(&weights);
                let (basis, weights, variances, even) = (&basis, &weights, &ones, &ones);
                let fitted = FittedGyro { basis, weights, variances, even, residuals: &residuals, dof: n - 3 };
                ratios.push(fitted.wander(memory, &times, &d, true).expect("it is regular").1 / (0.2 * size));
            }
            let usual = median_of(ratios.iter().copied()).expect("there are forty");
            assert!((0.8..1.25).contains(&usual), "{memory:?} of {size} beside {white}: {usual}");
        }
    }

    #[test]
    fn what_the_dwell_before_leaves_is_weighed_as_its_matrix_has_it() {
        let (times, d, x) = dwells();
        let force = |k: usize| nalgebra::Vector3::new((k % 3) as f64 - 1.0, (k % 5) as f64 - 2.0, 0.3);
        let forces = (0..20).map(force).collect();
        let nothing = vec![nalgebra::Vector3::zeros(); 20];
        let load = load_before(&DwellConditions { times, durations: vec![180.0; 20], rates: nothing, forces });
        assert!(load.row(0).norm() == 0.0 && load.row(5) == force(4).transpose());
        let (ones, residuals) = (DVector::from_element(20, 1.0), x.column(2).into_owned());
        let basis = x.columns(0, 2).into_owned().qr().q();
        let (weights, variances, even) = (&ones, &ones, &ones);
        let fitted = FittedGyro { basis: &basis, weights, variances, even, residuals: &residuals, dof: 18 };
        let (log, rss) = fitted.under_load(&d, &load, 2.5, true).expect("it is regular");
        let v = DMatrix::from_diagonal(&d.component_mul(&d)) + &load * load.transpose() * 2.5;
        let factor = v.clone().cholesky().expect("positive");
        let normal = basis.tr_mul(&factor.solve(&basis));
        let side = basis.tr_mul(&factor.solve(&residuals));
        let seen = normal.clone().cholesky().expect("positive").solve(&side).dot(&side);
        let by_matrix = residuals.dot(&factor.solve(&residuals)) - seen;
        assert!((rss - by_matrix).abs() < 1e-9, "{rss} is not {by_matrix}");
        let expected =
            -0.5 * v.determinant().ln() - 0.5 * normal.determinant().ln() - 11.0 * (PRIOR_DOF + by_matrix).ln();
        assert!((log - expected).abs() < 1e-9, "{log} is not {expected}");
    }

    #[test]
    fn a_few_dwells_or_none_that_scatter_say_nothing() {
        let (times, d, x) = dwells();
        let basis = x.qr().q();
        let (weights, variances) = (d.map(|d| 1.0 / d), DVector::from_element(20, 1.0));
        let course = DwellConditions {
            times,
            durations: vec![180.0; 20],
            rates: vec![nalgebra::Vector3::zeros(); 20],
            forces: vec![nalgebra::Vector3::zeros(); 20],
        };
        for (residuals, dof) in [(d.clone(), LEAST_DOF), (DVector::zeros(20), 17)] {
            let fitted = FittedGyro {
                basis: &basis,
                weights: &weights,
                variances: &variances,
                even: &variances,
                residuals: &residuals,
                dof,
            };
            let mut covariance = [Some(DMatrix::identity(3, 3))];
            assert_eq!(weigh(&course, &[fitted], &mut covariance, true).kinds, []);
            assert_eq!(covariance, [Some(DMatrix::identity(3, 3))]);
        }
    }

    /// What [`weigh`] is defined to give, by matrices: kinds with their weights, and the covariance of each gyro.
    fn by_matrices(
        course: &DwellConditions,
        gyros: &[FittedGyro],
        plain: &[DMatrix<f64>],
        stated: bool,
    ) -> (Vec<(NoiseDeparture, f64)>, Vec<DMatrix<f64>>) {
        let k = if stated { 4.0 } else { 0.0 };
        let over = |v: &DVector<f64>, w: &DVector<f64>| DMatrix::from_diagonal(&v.zip_map(w, |v, w| v / (w * w)));
        let covariance = |kind: Option<NoiseDeparture>, gyro: &FittedGyro| match kind {
            None => over(gyro.variances, gyro.weights),
            Some(NoiseDeparture::Law(law)) => {
                let factors = DVector::from_vec(law.factors(course)).map(|f| f * f);
                over(&gyro.even.component_mul(&factors), gyro.weights)
            }
            Some(NoiseDeparture::CorrelatedNoise(memory, power)) => {
                let white = over(gyro.variances, gyro.weights);
                let usual = median_of(white.diagonal().iter().map(|v| v.sqrt())).unwrap_or(1.0);
                white + power * usual * usual * memory.kernel(&course.times)
            }
        };
        let restricted = |v: &DMatrix<f64>, gyro: &FittedGyro| {
            let design = DMatrix::from_fn(20, 3, |n, c| gyro.basis[(n, c)] / gyro.weights[n]);
            let inverse = v.clone().cholesky().expect("it is positive").inverse();
            let normal = design.transpose() * &inverse * &design;
            let side = design.transpose() * &inverse * gyro.residuals;
            let solved = normal.clone().cholesky().expect("it is positive").inverse() * &side;
            let rss = (gyro.residuals.transpose() * &inverse * gyro.residuals)[(0, 0)] - side.dot(&solved);
            let log = -0.5 * v.determinant().ln() - 0.5 * normal.determinant().ln();
            (log - 0.5 * (gyro.dof as f64 + k) * (k + rss).ln(), rss)
        };
        let laws: Vec<NoiseDeparture> = Law::all(course).into_iter().map(NoiseDeparture::Law).collect();
        let laws = laws.into_iter().filter(|kind| stated || !matches!(kind, NoiseDeparture::Law(Law::Duration(_))));
        let laws: Vec<(NoiseDeparture, f64)> = laws.map(|kind| (kind, 0.2)).collect();
        let of_law = 0.2 / laws.len() as f64;
        let flicker = [0.15, 0.5, 1.5, 5.0, 20.0]
            .map(|power| (NoiseDeparture::CorrelatedNoise(CorrelatedNoise::Flicker, power), 0.0005));
        let walks = [0.15, 0.5, 1.5, 5.0, 20.0]
            .map(|power| (NoiseDeparture::CorrelatedNoise(CorrelatedNoise::Walk, power * 3.0), 0.0005));
        let kinds = laws.into_iter().map(|(kind, _)| (kind, of_law)).chain(flicker).chain(walks);
        let white: f64 = gyros.iter().map(|gyro| restricted(&covariance(None, gyro), gyro).0).sum();
        let weight = |kind: NoiseDeparture, prior: f64| {
            let log: f64 = gyros.iter().map(|gyro| restricted(&covariance(Some(kind), gyro), gyro).0).sum();
            prior * (log - white).exp()
        };
        let likely =
            kinds.map(|(kind, prior)| (kind, weight(kind, prior))).filter(|(_, weight)| *weight > NOTHING.exp());
        let likely: Vec<(NoiseDeparture, f64)> = likely.collect();
        let all = 0.795 + likely.iter().map(|(_, weight)| weight).sum::<f64>();
        let likely: Vec<(NoiseDeparture, f64)> =
            likely.into_iter().map(|(kind, weight)| (kind, weight / all)).collect();
        let mixed = gyros.iter().zip(plain).map(|(gyro, plain)| {
            let mut mixed = plain * (0.795 / all);
            for (kind, weight) in &likely {
                let v = covariance(Some(*kind), gyro);
                let scale = (k + restricted(&v, gyro).1) / (gyro.dof as f64 + k - 2.0);
                let w = DMatrix::from_diagonal(gyro.weights);
                mixed += gyro.basis.transpose() * &w * v * &w * gyro.basis * (weight * scale);
            }
            mixed
        });
        (likely.clone(), mixed.collect())
    }

    #[test]
    fn kinds_of_noise_have_the_weights_and_covariances_of_their_matrices() {
        let (times, d, x) = dwells();
        let durations: Vec<f64> = (0..20).map(|k| if k % 3 == 0 { 60.0 } else { 240.0 }).collect();
        let rates: Vec<_> = (0..20).map(|k| nalgebra::Vector3::new(0.0, 30.0 * f64::from(k % 5), 10.0)).collect();
        let forces = vec![nalgebra::Vector3::zeros(); 20];
        let course = DwellConditions { times, durations, rates, forces };
        let variances = DVector::from_fn(20, |k, _| 1.0 + 0.2 * (3.1 * k as f64).cos());
        let even = DVector::from_fn(20, |k, _| 1.0 + 0.1 * (2.3 * k as f64).sin());
        for (stated, walk) in [(true, 0.0), (true, 0.6), (false, 0.3), (false, 0.0)] {
            let fits: Vec<_> = [1.0, 7.0]
                .map(|size: f64| {
                    let weights = d.map(|d| 1.0 / (d * size));
                    let over = DMatrix::from_fn(20, 3, |n, c| x[(n, c)] * weights[n]);
                    let basis = over.qr().q();
                    let mut wander = 0.0;
                    let noise = DVector::from_fn(20, |n, _| {
                        wander += walk * (5.9 * n as f64 + size).sin();
                        size * (d[n] * 1.4 * (11.7 * n as f64 * size).sin() + wander)
                    });
                    let whitened = noise.component_mul(&weights);
                    let left = &whitened - &basis * (basis.transpose() * &whitened);
                    (basis, weights.clone(), left.component_div(&weights))
                })
                .into();
            let gyros: Vec<FittedGyro> = fits
                .iter()
                .map(|(basis, weights, residuals)| FittedGyro {
                    basis,
                    weights,
                    variances: &variances,
                    even: &even,
                    residuals,
                    dof: 17,
                })
                .collect();
            let plain = vec![DMatrix::from_diagonal_element(3, 3, 0.7), DMatrix::from_diagonal_element(3, 3, 1.3)];
            let mut mixed: Vec<_> = plain.iter().cloned().map(Some).collect();
            let found = weigh(&course, &gyros, &mut mixed, stated).kinds;
            let (kinds, covariances) = by_matrices(&course, &gyros, &plain, stated);
            assert_eq!(found.len(), kinds.len());
            for ((kind, weight), (expected, of_matrices)) in found.iter().zip(&kinds) {
                assert_eq!(kind, expected);
                assert!((weight / of_matrices - 1.0).abs() < 1e-7, "{kind:?}: {weight} is not {of_matrices}");
            }
            for (mixed, expected) in mixed.iter().flatten().zip(&covariances) {
                assert!((mixed - expected).amax() < 1e-7 * expected.amax(), "{mixed} is not {expected}");
            }
        }
    }
}
