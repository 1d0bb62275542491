//! What is found of the noise beyond white, independent and as stated, by a fit or a diagnosis.

use nalgebra::DMatrix;

use super::GyroCalibration;
use super::memory::{self, Kind};
use crate::core::message::{Message, figure, signed};
use crate::core::mounting::Slot;
use crate::core::numerics::tails::chi2_tail;
use crate::message;

/// What is found of the noise; empty where it is white, independent and as stated, or where nothing asked.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NoiseFound {
    /// Correlations of gyros.
    pub between_gyros: Vec<(Slot, Slot, f64)>,
    pub memory: Option<MemoryFound>,
    pub laws: Vec<LawFound>,
}

/// A bias that wanders from dwell to dwell.
#[derive(Debug, Clone, PartialEq)]
pub struct MemoryFound {
    /// `flicker` or `random_walk`, whichever is likelier.
    pub kind: &'static str,
    /// Its standard deviation in each gyro, of a random walk at mid-campaign.
    pub deg_per_h: Vec<(Slot, f64)>,
    /// That there is any.
    pub probability: f64,
}

/// How the noise goes where the standard errors do not say so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LawFound {
    /// It falls with duration to this power.
    Duration { power: f64 },
    /// So many times as large at the fastest rate as at rest.
    Rate { times: f64 },
    /// So many times as large at the end as at the beginning.
    Time { times: f64 },
}

/// Weight from which on the noise is said to have a memory.
const CERTAIN: f64 = 0.98;

/// Chance below which gyros are said to share their noise.
const SHARED: f64 = 1e-3;

impl NoiseFound {
    /// What the residuals of a fit say.
    pub(super) fn of(found: &memory::Found, gyros: &[GyroCalibration]) -> Self {
        let certain = |of_kind: &dyn Fn(&Kind) -> bool| {
            let those = found.kinds.iter().filter(|(kind, _)| of_kind(kind));
            let probability: f64 = those.clone().map(|(_, weight)| weight).sum();
            let likeliest = those.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(kind, _)| *kind);
            likeliest.filter(|_| probability > CERTAIN).map(|kind| (kind, probability))
        };
        let memory = match certain(&|kind| matches!(kind, Kind::Memory(..))) {
            Some((Kind::Memory(memory, power), probability)) => Some(MemoryFound {
                kind: memory.name(),
                deg_per_h: gyros.iter().filter_map(|gyro| Some((gyro.slot, gyro.wander(power)?))).collect(),
                probability,
            }),
            _ => None,
        };
        let laws = match certain(&|kind| matches!(kind, Kind::Law(_))) {
            Some((Kind::Law(law), _)) => vec![law.found()],
            _ => Vec::new(),
        };
        // Gyros that wander each for itself seem to go together, too.
        let between_gyros = if memory.is_some() { Vec::new() } else { between(gyros) };
        Self { between_gyros, memory, laws }
    }

    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// In words.
    pub(crate) fn notes(&self) -> Vec<Message> {
        let mut notes = Vec::new();
        let largest = self.between_gyros.iter().map(|(.., r)| *r).max_by(|a, b| a.abs().total_cmp(&b.abs()));
        notes.extend(largest.map(|r| message!("noise_shared", correlation = signed(r, 2))));
        notes.extend(self.memory.as_ref().map(|memory| {
            let size = memory.deg_per_h.iter().map(|(_, size)| *size).fold(0.0, f64::max);
            let probability = figure(memory.probability.min(0.999), 3);
            message!("noise_memory", probability = probability, size = crate::core::record::short(size))
        }));
        notes.extend(self.laws.iter().map(|law| match *law {
            LawFound::Duration { power } => message!("noise_of_duration", power = figure(power, 2)),
            LawFound::Rate { times } => message!("noise_of_rate", times = figure(times, 1)),
            LawFound::Time { times } => message!("noise_of_time", times = figure(times, 1)),
        }));
        notes
    }
}

/// Correlations of the standardised residuals of every two gyros, where Bartlett's test of none (Biometrika 41, 1954)
/// has less than [`SHARED`]: -(nu - (2 p + 5)/6) ln det R is chi-square of p (p - 1)/2.
fn between(gyros: &[GyroCalibration]) -> Vec<(Slot, Slot, f64)> {
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
