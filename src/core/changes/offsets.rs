//! Offsets of all stations against one, estimated together.
//!
//! Of gyro g at station s, mean of records y_gs = mu_g + b_s + e, weighted by its records. The b_s of all stations come
//! from one fit with every gyro's level projected out, so that none is biased by another that is too small to be taken
//! by itself. Weights are Huber's; standard deviations are the larger of what the scatter of the y_gs gives and the
//! sandwich over IMUs, as for the parts of a [`station`](super::station).

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, DVector};

use super::series::robust;
use super::station::{HUBER, Shared, StationCell};
use crate::core::numerics::normal_equations::{NormalEquations, Solution};

/// The fit with one set of weights.
struct FittedOffsets {
    offsets: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Of each cell.
    residuals: Vec<f64>,
}

/// Of one group of stations.
#[derive(Debug, Clone, Default)]
pub(super) struct Offsets {
    /// By station, against `reference`.
    pub by_station: BTreeMap<usize, Shared>,
    /// What their own uncertainty adds to their variance about their mean, that of the reference included.
    pub of_spread: f64,
}

/// Of those that `compared` holds, against `reference`.
pub(super) fn offsets(cells: &[StationCell], reference: usize, compared: &[bool]) -> Offsets {
    let places: BTreeMap<usize, usize> =
        (0..compared.len()).filter(|station| compared[*station]).enumerate().map(|(k, station)| (station, k)).collect();
    let counts = |cell: &&StationCell| cell.station == reference || places.contains_key(&cell.station);
    let cells: Vec<StationCell> = cells.iter().filter(counts).copied().collect();
    let mut found = Offsets::default();
    if places.is_empty() {
        return found;
    }
    let gyros: BTreeSet<usize> = cells.iter().map(|cell| cell.gyro).collect();
    let freedom = cells.len().saturating_sub(gyros.len() + places.len());
    let mut weights: Vec<f64> = cells.iter().map(|cell| cell.weight).collect();
    let mut excess = 1.0;
    for _ in 0..8 {
        let Some(fitted) = fit(&cells, &weights, &places) else { return found };
        let pulls = fitted.residuals.iter().zip(&cells).map(|(r, cell)| r.abs() * cell.weight.sqrt());
        let of_fit = (cells.len() as f64 / freedom.max(1) as f64).sqrt();
        excess = if freedom < 2 { 1.0 } else { (of_fit * robust(pulls.clone()).unwrap_or(1.0)).max(1.0) };
        for ((weight, pull), cell) in weights.iter_mut().zip(pulls).zip(&cells) {
            *weight = cell.weight * (HUBER * excess / pull.max(f64::MIN_POSITIVE)).min(1.0);
        }
    }
    let Some(fitted) = fit(&cells, &weights, &places) else { return found };
    let mut scores: BTreeMap<usize, DVector<f64>> = BTreeMap::new();
    for ((cell, weight), residual) in cells.iter().zip(&weights).zip(&fitted.residuals) {
        let score = scores.entry(cell.imu).or_insert_with(|| DVector::zeros(places.len()));
        if let Some(place) = places.get(&cell.station) {
            score[*place] += weight * residual;
        }
    }
    let imus = scores.len() as f64;
    let outer =
        scores.values().fold(DMatrix::zeros(places.len(), places.len()), |sum, one| sum + one * one.transpose());
    let few = if imus > 2.0 { imus / (imus - 1.0) } else { 2.0 };
    let sandwich = &fitted.covariance * outer * &fitted.covariance * few;
    for (station, place) in &places {
        let here: Vec<&StationCell> = cells.iter().filter(|cell| cell.station == *station).collect();
        let noise = excess * excess * fitted.covariance[(*place, *place)];
        let common = Shared {
            value: fitted.offsets[*place],
            sd: noise.max(sandwich[(*place, *place)]).sqrt(),
            gyros: here.len(),
            imus: here.iter().map(|cell| cell.imu).collect::<BTreeSet<_>>().len(),
            between: 0.0,
            gain: 0.0,
        };
        found.by_station.insert(*station, common);
    }
    // Of offsets x with covariance V and a zero among them: E[sum (x - mean)^2] = tr V - 1'V 1/(m + 1).
    let sd = DVector::from_iterator(places.len(), found.by_station.values().map(|offset| offset.sd));
    let scale = DVector::from_fn(places.len(), |k, _| sd[k] / fitted.covariance[(k, k)].sqrt());
    let covariance =
        DMatrix::from_fn(places.len(), places.len(), |i, j| scale[i] * fitted.covariance[(i, j)] * scale[j]);
    let m = places.len() as f64;
    found.of_spread = (covariance.trace() - covariance.sum() / (m + 1.0)) / m;
    found
}

fn fit(cells: &[StationCell], weights: &[f64], places: &BTreeMap<usize, usize>) -> Option<FittedOffsets> {
    let mut by_gyro: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
    for (k, (cell, weight)) in cells.iter().zip(weights).enumerate() {
        by_gyro.entry(cell.gyro).or_default().push((k, *weight));
    }
    let m = places.len();
    let mut normal = NormalEquations::new(m);
    let level = |own: &[(usize, f64)], of: &dyn Fn(usize) -> f64| {
        own.iter().map(|(k, weight)| weight * of(*k)).sum::<f64>() / own.iter().map(|(_, weight)| weight).sum::<f64>()
    };
    for own in by_gyro.values() {
        let whole: f64 = own.iter().map(|(_, weight)| weight).sum();
        let mean = level(own, &|k| cells[k].mean);
        for (a, of_a) in own {
            let Some(i) = places.get(&cells[*a].station) else { continue };
            normal.matrix[(*i, *i)] += of_a;
            normal.right[*i] += of_a * (cells[*a].mean - mean);
            for (b, of_b) in own {
                if let Some(j) = places.get(&cells[*b].station) {
                    normal.matrix[(*i, *j)] -= of_a * of_b / whole;
                }
            }
        }
    }
    let Solution { estimate: offsets, covariance } = normal.solve()?;
    let offset = |k: usize| places.get(&cells[k].station).map_or(0.0, |place| offsets[*place]);
    let mut residuals = vec![0.0; cells.len()];
    for own in by_gyro.values() {
        let mean = level(own, &|k| cells[k].mean - offset(k));
        own.iter().for_each(|(k, _)| residuals[*k] = cells[*k].mean - offset(*k) - mean);
    }
    Some(FittedOffsets { offsets, covariance, residuals })
}
