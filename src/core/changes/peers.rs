//! What a station does to every gyro that it measures.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use crate::core::numerics::least_squares::Factor;

use super::answer::GyroHistory;

/// Offset of one station against the reference station, as the other gyros of the fleet show it, deg/(h g0).
#[derive(Debug, Clone, PartialEq)]
pub struct StationOffset {
    pub value: f64,
    pub sd: f64,
    /// Gyros that were measured both there and elsewhere.
    pub gyros: usize,
}

/// Offsets of all stations but `reference`, from gyros that met at least two stations.
///
/// Least squares of y_gk = mu_g + beta_station(gk) + nu over the peers: each gyro keeps a level of its own, so only
/// what moves *within* gyros when the station changes counts. Component `column` of `d`.
pub(super) fn station_offsets(
    peers: &[GyroHistory],
    reference: &str,
    column: usize,
) -> BTreeMap<String, StationOffset> {
    let movers: Vec<&GyroHistory> = peers.iter().filter(|peer| stations(peer) > 1).collect();
    let mut names: Vec<&str> = movers.iter().flat_map(|p| p.entries.iter().map(|e| e.station.as_str())).collect();
    names.sort_unstable();
    names.dedup();
    if !names.contains(&reference) {
        return BTreeMap::new();
    }
    names.retain(|&name| name != reference);
    let rows: usize = movers.iter().map(|peer| peer.entries.len()).sum();
    let columns = names.len() + movers.len();
    if names.is_empty() || rows <= columns {
        return BTreeMap::new();
    }
    let mut design = DMatrix::zeros(rows, columns);
    let mut y = DVector::zeros(rows);
    let mut row = 0;
    for (g, peer) in movers.iter().enumerate() {
        // About the gyro's own mean: levels of tens of deg/(h g0) would drown offsets of thousandths.
        let mean = peer.entries.iter().map(|e| e.d[column].value).sum::<f64>() / peer.entries.len() as f64;
        for entry in &peer.entries {
            y[row] = entry.d[column].value - mean;
            design[(row, names.len() + g)] = 1.0;
            if let Some(s) = names.iter().position(|&name| name == entry.station) {
                design[(row, s)] = 1.0;
            }
            row += 1;
        }
    }
    let factor = Factor::new(design, &vec![1.0; rows]);
    let fit = factor.fit(&y);
    if fit.dof == 0 {
        return BTreeMap::new();
    }
    let variance = fit.chi2 / fit.dof as f64;
    names
        .iter()
        .enumerate()
        .filter(|&(s, _)| {
            let mut one = DVector::zeros(columns);
            one[s] = 1.0;
            factor.determines(&one)
        })
        .map(|(s, &name)| {
            let gyros = movers.iter().filter(|p| p.entries.iter().any(|e| e.station == name)).count();
            let sd = (fit.covariance[(s, s)] * variance).sqrt();
            (name.to_owned(), StationOffset { value: fit.estimate[s], sd, gyros })
        })
        .collect()
}

fn stations(gyro: &GyroHistory) -> usize {
    let mut names: Vec<&str> = gyro.entries.iter().map(|e| e.station.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    names.len()
}
