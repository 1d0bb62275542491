//! How long diagnoses of histories take: of a whole fleet, and of one gyro with many records.

use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde::Serialize;

use super::draw::{DrawnFleet, FleetDraw, HiddenCause};
use crate::core::changes::{GyroHistory, diagnose_history};

/// Records of the one gyro, and its peers, as many as the service asks for.
const RECORDS: usize = 1000;
const PEERS: usize = 40;
const OF_A_PEER: usize = 100;
/// The one gyro is asked for so often.
const ROUNDS: usize = 21;

/// What was measured.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Speed {
    pub gyros: usize,
    /// Of all their gyros.
    pub records: usize,
    pub threads: usize,
    pub fleet_s: f64,
    pub of_one: usize,
    /// Median of one gyro with so many records, and the slowest.
    pub one_ms: f64,
    pub slowest_ms: f64,
}

/// Diagnoses fleets of every kind, `gyros` at the least, on all threads; then one gyro again and again.
pub fn measure(seed: u64, gyros: usize) -> Speed {
    let mut fleets: Vec<DrawnFleet> = Vec::new();
    let count = |fleets: &[DrawnFleet]| fleets.iter().map(|fleet| fleet.gyros.len()).sum::<usize>();
    while count(&fleets) < gyros {
        let number = fleets.len();
        fleets.push(FleetDraw::of(seed, number as u64).fleet(HiddenCause::ALL[number % HiddenCause::ALL.len()]));
    }
    let begun = Instant::now();
    fleets.par_iter().flat_map(|fleet| (0..fleet.gyros.len()).into_par_iter().map(move |g| (fleet, g))).for_each(
        |(fleet, g)| {
            let others = fleet.gyros.iter().enumerate().filter(|(other, _)| *other != g);
            let others: Vec<&GyroHistory> = others.map(|(_, gyro)| gyro).collect();
            drop(diagnose_history(&fleet.gyros[g], &others, [None; 3]));
        },
    );
    let fleet_s = begun.elapsed().as_secs_f64();
    let all = FleetDraw::of(seed, u64::MAX).weekly(1, RECORDS);
    let peers = FleetDraw::of(seed, u64::MAX - 1).weekly(PEERS, OF_A_PEER);
    let others: Vec<&GyroHistory> = peers.iter().collect();
    let mut took: Vec<Duration> = (0..ROUNDS)
        .map(|_| {
            let begun = Instant::now();
            drop(diagnose_history(&all[0], &others, [None; 3]));
            begun.elapsed()
        })
        .collect();
    took.sort();
    let ms = |took: Duration| 1e3 * took.as_secs_f64();
    Speed {
        gyros: count(&fleets),
        records: fleets.iter().flat_map(|fleet| &fleet.gyros).map(|gyro| gyro.entries.len()).sum(),
        threads: rayon::current_num_threads(),
        fleet_s,
        of_one: RECORDS,
        one_ms: ms(took[ROUNDS / 2]),
        slowest_ms: ms(took[ROUNDS - 1]),
    }
}
