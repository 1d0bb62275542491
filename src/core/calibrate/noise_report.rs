//! What the residuals of all gyros say of the noise, as it is answered.

use nalgebra::DMatrix;

use super::GyroCalibration;
use super::correlated_noise::{DepartureWeights, NoiseDeparture, Weighed};
use super::law::Law;
use super::noise_found::{CorrelatedNoiseFound, NoiseFound};
use crate::core::mounting::Slot;
use crate::core::numerics::tails::chi2_tail;

/// Weight from which on the noise is said to have a memory.
const CERTAIN: f64 = 0.98;

/// Chance below which gyros are said to share their noise.
const SHARED: f64 = 1e-3;

/// Whether the noise is said to be other than white, independent and as stated.
pub(super) fn is_other(found: &DepartureWeights) -> bool {
    [true, false].into_iter().any(|memory| certain(found, memory).is_some())
}

/// The law by which the noise is said to go.
pub(super) fn law(found: &DepartureWeights) -> Option<Law> {
    match certain(found, false) {
        Some((NoiseDeparture::Law(law), _)) => Some(law),
        _ => None,
    }
}

/// The likeliest kind with a memory or without, and the probability of all those, where it is certain.
fn certain(found: &DepartureWeights, memory: bool) -> Option<(NoiseDeparture, f64)> {
    let those = found.iter().filter(|(kind, _)| kind.has_memory() == memory);
    let probability: f64 = those.clone().map(|(_, weight)| weight).sum();
    let (likeliest, _) = those.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (probability > CERTAIN).then_some((*likeliest, probability))
}

/// What the residuals of a fit say.
pub(super) fn report(found: &Weighed, gyros: &[GyroCalibration]) -> NoiseFound {
    let scales: Vec<_> = gyros.iter().map(|gyro| (gyro.slot, gyro.scale_factor())).collect();
    let of_kinds = of_kinds(found, &scales);
    // Gyros that wander each for itself seem to go together, too.
    let between_gyros = if of_kinds.memory.is_some() { Vec::new() } else { between(gyros) };
    NoiseFound { between_gyros, ..of_kinds }
}

/// What is certain of each gyro by itself; `scales` are their |E|, pulse/arcsec, where they are known.
pub(super) fn of_kinds(found: &Weighed, scales: &[(Slot, Option<f64>)]) -> NoiseFound {
    let memory = certain(&found.kinds, true).zip(found.wander.as_ref()).map(|((_, probability), wander)| {
        let in_gyros = scales.iter().zip(&wander.pulse_s);
        let deg_per_h = in_gyros.filter_map(|((slot, scale), pulse_s)| Some((*slot, pulse_s / (*scale)?))).collect();
        CorrelatedNoiseFound { kind: wander.memory.name(), deg_per_h, probability }
    });
    let laws = law(&found.kinds).map(Law::found).into_iter().collect();
    NoiseFound { between_gyros: Vec::new(), memory, laws }
}

/// Correlations of the standardised residuals of every two gyros, where Bartlett's test of none (Biometrika 41, 1954)
/// has less than [`SHARED`]: -(nu - (2 p + 5)/6) ln det R is chi-square of p (p - 1)/2.
pub(super) fn between(gyros: &[GyroCalibration]) -> Vec<(Slot, Slot, f64)> {
    let p = gyros.len();
    let Some(residuals) = gyros.iter().map(|gyro| gyro.standardised.as_ref()).collect::<Option<Vec<_>>>() else {
        return Vec::new();
    };
    let correlation = |i: usize, j: usize| {
        residuals[i].dot(residuals[j]) / (residuals[i].norm() * residuals[j].norm()).max(f64::MIN_POSITIVE)
    };
    let matrix = DMatrix::from_fn(p, p, |i, j| if i == j { 1.0 } else { correlation(i, j) });
    let nu = gyros.iter().map(|gyro| gyro.dof).min().unwrap_or(0) as f64;
    let statistic = -(nu - (2 * p + 5) as f64 / 6.0) * matrix.determinant().max(f64::MIN_POSITIVE).ln();
    if !chi2_tail(statistic.max(0.0), p * (p - 1) / 2).is_some_and(|chance| chance < SHARED) {
        return Vec::new();
    }
    let pairs = (0..p).flat_map(|i| (0..i).map(move |j| (j, i)));
    pairs.map(|(j, i)| (gyros[j].slot, gyros[i].slot, correlation(i, j))).collect()
}
