//! Stations that scatter more, or less, than the others by more than is stated.
//!
//! A station may be noisy without saying so, or state every station's standard deviation alike. Successive differences of
//! a gyro at a station, in units of that gyro's own scatter, are compared among the stations of all gyros that were at
//! more than one. Where a station is beyond chance, its records weigh as they scatter.

use std::collections::BTreeMap;

use super::answer::{GyroHistory, HistoryEntry};
use super::reproducibility::OF_SUCCESSIVE;
use super::series::robust;

/// A station scatters otherwise where the logarithm of its scatter is so many standard deviations off,
const BEYOND_CHANCE: f64 = 4.0;
/// and its scatter differs by this factor.
const WORTH_WEIGHING: f64 = 1.5;
/// Fewest differences at a station.
const FEWEST: usize = 4;

/// How many times as much as the others the stations scatter that are beyond chance, by name.
pub(super) fn of_stations<'a>(histories: &[&'a GyroHistory], column: usize) -> BTreeMap<&'a str, f64> {
    let mut at: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for history in histories {
        let mut own = differences(&history.entries, column);
        if own.len() > 1 {
            let scatter = robust(own.values().flatten().copied()).unwrap_or(0.0);
            for (station, some) in own.iter_mut().filter(|_| scatter > 0.0) {
                at.entry(station).or_default().extend(some.iter().map(|one| one / scatter));
            }
        }
    }
    let mut factors = BTreeMap::new();
    let mut left: Vec<&str> = at.iter().filter(|(_, some)| some.len() >= FEWEST).map(|(name, _)| *name).collect();
    while left.len() > 1 {
        let apart = left.iter().enumerate().filter_map(|(k, station)| {
            let others = left.iter().filter(|one| *one != station).flat_map(|one| &at[one]).copied();
            let here = &at[station];
            let sd = OF_SUCCESSIVE * (1.0 / here.len() as f64 + 1.0 / others.clone().count() as f64).sqrt();
            let ratio = robust(here.iter().copied())? / robust(others)?;
            let significance = ratio.ln().abs() / sd;
            (ratio.is_finite() && significance > BEYOND_CHANCE).then_some((significance, k, ratio))
        });
        let Some((_, k, ratio)) = apart.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        let station = left.swap_remove(k);
        if ratio.max(1.0 / ratio) > WORTH_WEIGHING {
            factors.insert(station, ratio);
        }
    }
    factors
}

/// Differences of a gyro's successive records at each station, in stated standard deviations where there are any.
fn differences(entries: &[HistoryEntry], column: usize) -> BTreeMap<&str, Vec<f64>> {
    let mut last: BTreeMap<&str, &HistoryEntry> = BTreeMap::new();
    let mut all: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    let is_stated = entries.iter().all(|entry| entry.d[column].sd.is_some_and(|sd| sd > 0.0));
    for entry in entries {
        if let Some(before) = last.insert(&entry.station, entry) {
            let sd = |entry: &HistoryEntry| entry.d[column].sd.filter(|_| is_stated).unwrap_or(1.0);
            let difference = (entry.d[column].value - before.d[column].value).abs();
            all.entry(&entry.station).or_default().push(difference / sd(entry).hypot(sd(before)));
        }
    }
    all
}

/// The history with every standard deviation times its station's factor; where none is stated, with those that it shows.
pub(super) fn weighed(history: &GyroHistory, factors: &[BTreeMap<&str, f64>; 3]) -> GyroHistory {
    let mut weighed = history.clone();
    for (column, factors) in factors.iter().enumerate().filter(|(_, factors)| !factors.is_empty()) {
        let factor = |station: &str| factors.get(station).copied().unwrap_or(1.0);
        let all = differences(&history.entries, column);
        let even = all.iter().flat_map(|(station, some)| some.iter().map(|one| one / factor(station)));
        let scatter = robust(even);
        for entry in &mut weighed.entries {
            let sd = entry.d[column].sd.filter(|sd| *sd > 0.0).or(scatter);
            entry.d[column].sd = sd.map(|sd| sd * factor(&entry.station));
        }
    }
    weighed
}
