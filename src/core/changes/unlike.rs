//! What a station does to each gyro in a direction of its own, as a table that is wrongly levelled does: the median of
//! the gyros stays, and many of them are off.
//!
//! At an instant gyro g jumps by z_g = (a - b)/(s sqrt(1/n_a + 1/n_b)), with a the mean of its next records at the
//! station, b that of its last ones there, and s its scatter. Where many of its gyros, six and of three IMUs at the
//! least, jump at once, and not to one side, and at other stations few do, it is the station.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::core::time::UtcMicros;

use super::answer::{GyroHistory, HistoryEntry};
use super::series::scatter_of;
use super::unlike_window::Unlike;

/// Records of a gyro on either side of an instant, at most, and the days within which they lie.
const RECORDS: usize = 2;
const NEAR_DAYS: f64 = 45.0;
/// Instants of a station that are looked at, at the most.
const INSTANTS: usize = 1000;
/// |z| from which a gyro has jumped: of normal ones, of two coefficients, one in 4,000.
const JUMPED: f64 = 4.0;
/// |z| of one gyro from which it is asked whether others have jumped with it.
const SUSPECTED: f64 = 3.0;
/// Gyros and IMUs that tell, at the least.
const GYROS: usize = 6;
const IMUS: usize = 3;
/// Share of a station's gyros that jump, at the least, and of those elsewhere, at the most.
const MANY: f64 = 0.4;
const FEW: f64 = 0.25;
/// Share of those that jump to one side of one coefficient from which on they share it: a step.
const ALIKE: f64 = 0.85;

/// How far a gyro's D_I, D_S and D_O jump at an instant, in standard deviations.
struct Jump<'a> {
    imu: &'a str,
    z: [f64; 3],
}

impl Jump<'_> {
    /// In what is the gyro's own: D_O moves with its mounting too.
    fn has_jumped(&self) -> bool {
        self.z[..2].iter().any(|z| z.abs() > JUMPED)
    }
}

/// What the gyros of a station do at an instant: how many jump, of how many.
struct SeenJump<'a> {
    at: UtcMicros,
    gyros: usize,
    of: usize,
    /// In the order of the fleet.
    each: Vec<Option<Jump<'a>>>,
}

impl SeenJump<'_> {
    /// Whether the gyros jump to the same sides on the whole.
    fn is_alike(&self, other: &Self) -> bool {
        let both = self.each.iter().zip(&other.each).filter_map(|(a, b)| a.as_ref().zip(b.as_ref()));
        both.map(|(a, b)| a.z[0] * b.z[0] + a.z[1] * b.z[1]).sum::<f64>() > 0.0
    }
}

/// How D_I, D_S and D_O of each gyro scatter from record to record, or as is stated where that is more, deg/(h g0).
pub(super) fn scatters(fleet: &[&GyroHistory]) -> Vec<[f64; 3]> {
    let of_gyro = |gyro: &&GyroHistory| {
        [0, 1, 2].map(|column| {
            let stated = gyro.entries.iter().filter_map(|entry| entry.d[column].sd).fold(0.0, f64::max);
            scatter_of(&gyro.entries, column).absolute.max(stated)
        })
    };
    fleet.iter().map(of_gyro).collect()
}

/// When many gyros of the stations of `gyro` were off, itself among them, each in its own direction; oldest first of each
/// station. `others` are those of the fleet.
pub(super) fn beside(gyro: &GyroHistory, others: &[&GyroHistory]) -> Vec<(Arc<str>, Unlike)> {
    let sd = scatters(&[gyro])[0];
    let has_jumped_at = |station: &&Arc<str>| {
        let entries: Vec<&HistoryEntry> = gyro.entries.iter().filter(|entry| entry.station == **station).collect();
        // One record by itself may be off too.
        let differ = |pair: &[&HistoryEntry], k: usize| (pair[1].d[k].value - pair[0].d[k].value).abs();
        let most = JUMPED * std::f64::consts::SQRT_2;
        let is_far = entries.windows(2).any(|pair| (0..3).any(|k| differ(pair, k) > most * sd[k]));
        let seen = Seen { entries, sd };
        let mut jumps = seen.entries.iter().filter_map(|entry| seen.jump(entry.at));
        is_far || jumps.any(|jump| jump.z.iter().any(|z| z.abs() > SUSPECTED))
    };
    let stations: BTreeSet<&Arc<str>> = gyro.entries.iter().map(|entry| &entry.station).collect();
    let stations: Vec<&Arc<str>> = stations.into_iter().filter(has_jumped_at).collect();
    if stations.is_empty() {
        return Vec::new();
    }
    let fleet: Vec<&GyroHistory> = std::iter::once(gyro).chain(others.iter().copied()).collect();
    let scatters: Vec<[f64; 3]> = std::iter::once(sd).chain(scatters(others)).collect();
    let of = |station: &Arc<str>| unlike(&fleet, &scatters, station);
    stations.into_iter().flat_map(|station| of(station).into_iter().map(|one| (station.clone(), one))).collect()
}

/// When many gyros of `station` were off in different directions, oldest first; `scatters` are those of the fleet.
pub(super) fn unlike(fleet: &[&GyroHistory], scatters: &[[f64; 3]], station: &str) -> Vec<Unlike> {
    let seen = |is_here: bool| -> Vec<Seen<'_>> {
        let is_one = |entry: &&HistoryEntry| (*entry.station == *station) == is_here;
        let gyros = fleet.iter().zip(scatters);
        gyros.map(|(gyro, sd)| Seen { entries: gyro.entries.iter().filter(is_one).collect(), sd: *sd }).collect()
    };
    let (here, elsewhere) = (seen(true), seen(false));
    let mut instants: Vec<UtcMicros> = here.iter().flat_map(|seen| seen.entries.iter().map(|entry| entry.at)).collect();
    instants.sort_unstable();
    instants.dedup();
    let counted = |at: UtcMicros| -> Option<SeenJump<'_>> {
        let each: Vec<Option<Jump<'_>>> = here.iter().map(|seen| seen.jump(at)).collect();
        let jumps: Vec<&Jump<'_>> = each.iter().flatten().collect();
        let jumped: Vec<&Jump<'_>> = jumps.iter().filter(|jump| jump.has_jumped()).copied().collect();
        let imus: BTreeSet<&str> = jumped.iter().map(|jump| jump.imu).collect();
        let is_many = jumped.len() >= GYROS && imus.len() >= IMUS && jumped.len() as f64 >= MANY * jumps.len() as f64;
        let to_one_side = |column: usize| {
            let big = jumped.iter().filter(|jump| jump.z[column].abs() > JUMPED);
            let above = big.clone().filter(|jump| jump.z[column] > 0.0).count();
            above.max(big.count() - above) as f64 >= ALIKE * jumped.len() as f64
        };
        let is_its = || {
            let others: Vec<Jump<'_>> = elsewhere.iter().filter_map(|seen| seen.jump(at)).collect();
            others.iter().filter(|jump| jump.has_jumped()).count() as f64 <= FEW * others.len() as f64
        };
        let is_found = is_many && !to_one_side(0) && !to_one_side(1) && is_its();
        let (gyros, of) = (jumped.len(), jumps.len());
        is_found.then_some(SeenJump { at, gyros, of, each })
    };
    // Neighbouring instants see the same jump, and the way back is another: the one that most gyros show is it.
    let mut found: Vec<SeenJump<'_>> = Vec::new();
    let every = instants.len().div_ceil(INSTANTS).max(1);
    for one in instants.iter().step_by(every).filter_map(|at| counted(*at)) {
        match found.last_mut() {
            Some(last) if one.at.days_since(last.at) < NEAR_DAYS && one.is_alike(last) => {
                if one.gyros > last.gyros {
                    *last = one;
                }
            }
            _ => found.push(one),
        }
    }
    // There, and back.
    let window = |pair: &[SeenJump<'_>]| {
        let SeenJump { at: from, gyros, of, .. } = pair[0];
        Unlike { from, until: pair.get(1).map(|back| back.at), gyros, of }
    };
    found.chunks(2).map(window).collect()
}

/// The records of a gyro that are looked at, and how they scatter.
struct Seen<'a> {
    entries: Vec<&'a HistoryEntry>,
    sd: [f64; 3],
}

impl<'a> Seen<'a> {
    fn jump(&self, at: UtcMicros) -> Option<Jump<'a>> {
        let cut = self.entries.partition_point(|entry| entry.at < at);
        let is_near = |entry: &&&HistoryEntry| entry.at.days_since(at).abs() <= NEAR_DAYS;
        let before: Vec<&&HistoryEntry> = self.entries[..cut].iter().rev().take(RECORDS).filter(is_near).collect();
        let after: Vec<&&HistoryEntry> = self.entries[cut..].iter().take(RECORDS).filter(is_near).collect();
        let imu = &*before.first()?.imu;
        let mean = |some: &[&&HistoryEntry], column: usize| {
            some.iter().map(|entry| entry.d[column].value).sum::<f64>() / some.len() as f64
        };
        let many = (1.0 / before.len() as f64 + 1.0 / after.len() as f64).sqrt();
        let is_known = !after.is_empty() && self.sd[..2].iter().all(|sd| *sd > 0.0);
        let z = [0, 1, 2].map(|k| (mean(&after, k) - mean(&before, k)) / (self.sd[k] * many));
        is_known.then_some(Jump { imu, z })
    }
}
