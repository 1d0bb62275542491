//! The columns that may explain a history, each tied to something that was recorded of it.

use crate::core::judge::{Coefficient, Event};

use super::answer::GyroHistory;

/// Days of a Julian year; ageing is stated per year.
const YEAR_DAYS: f64 = 365.25;

/// A candidate is only tried where so many records stand on either side of its change.
const FEWEST_ON_A_SIDE: usize = 2;

/// Temperatures that vary less than this (standard deviation, K) explain nothing.
const LEAST_TEMPERATURE_SD: f64 = 0.05;

/// One column of regressors and what it stands for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidate {
    pub cause: &'static str,
    pub detail: String,
    pub parameter: &'static str,
    pub unit: &'static str,
    pub column: Vec<f64>,
    /// How many columns of this kind were tried to find the best.
    pub tried: usize,
    /// The station, where the candidate is one.
    pub station: Option<String>,
}

/// Every candidate that `gyro`'s records can tell from a constant. `reference` is the station that offsets count from.
pub(super) fn all(gyro: &GyroHistory, coefficient: Coefficient, reference: &str) -> Vec<Candidate> {
    let mut found = vec![ageing(gyro)];
    found.extend(steps_at_events(gyro));
    found.extend(re_mountings(gyro));
    found.extend(temperature(gyro));
    found.extend(stations(gyro, reference));
    if coefficient == Coefficient::DO {
        found.extend(clocking(gyro));
    }
    found.extend(free_steps(gyro));
    found
}

fn candidate(cause: &'static str, detail: String, unit: &'static str, column: Vec<f64>) -> Candidate {
    Candidate { cause, detail, parameter: "k", unit, column, tried: 1, station: None }
}

fn ageing(gyro: &GyroHistory) -> Candidate {
    let first = gyro.entries[0].at;
    let years = gyro.entries.iter().map(|e| e.at.days_since(first) / YEAR_DAYS).collect();
    candidate("ageing", "a steady slope".into(), "deg/(h*g0)/year", years)
}

fn steps_at_events(gyro: &GyroHistory) -> Vec<Candidate> {
    let counts = |event| !matches!(event, Event::Note | Event::Baseline);
    let marks = gyro.marks.iter().filter(|mark| counts(mark.event));
    marks
        .filter_map(|mark| {
            let cut = gyro.entries.partition_point(|e| e.at < mark.at);
            step_column(gyro, cut).map(|c| candidate("step_at_event", mark.event.name().into(), "deg/(h*g0)", c))
        })
        .collect()
}

fn re_mountings(gyro: &GyroHistory) -> Vec<Candidate> {
    (1..gyro.entries.len())
        .filter(|&k| gyro.entries[k].seat != gyro.entries[k - 1].seat)
        .filter_map(|cut| {
            let detail = format!("from {} to {}", gyro.entries[cut - 1].seat, gyro.entries[cut].seat);
            step_column(gyro, cut).map(|c| candidate("re_mounting", detail, "deg/(h*g0)", c))
        })
        .collect()
}

fn temperature(gyro: &GyroHistory) -> Option<Candidate> {
    let t: Option<Vec<f64>> = gyro.entries.iter().map(|e| e.temperature_c).collect();
    let t = t?;
    let mean = t.iter().sum::<f64>() / t.len() as f64;
    let variance = t.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / t.len() as f64;
    (variance.sqrt() > LEAST_TEMPERATURE_SD).then(|| {
        let detail = format!("about {mean:.2} degrees Celsius");
        candidate("temperature", detail, "deg/(h*g0)/K", t.iter().map(|x| x - mean).collect())
    })
}

fn stations(gyro: &GyroHistory, reference: &str) -> Vec<Candidate> {
    let mut names: Vec<&str> = gyro.entries.iter().map(|e| e.station.as_str()).filter(|&s| s != reference).collect();
    names.sort_unstable();
    names.dedup();
    names
        .into_iter()
        .filter_map(|name| {
            let column: Vec<f64> = gyro.entries.iter().map(|e| f64::from(e.station == name)).collect();
            let there = column.iter().sum::<f64>() as usize;
            (there >= FEWEST_ON_A_SIDE && column.len() - there >= FEWEST_ON_A_SIDE).then(|| Candidate {
                station: Some(name.to_owned()),
                ..candidate("station", format!("{name} against {reference}"), "deg/(h*g0)", column)
            })
        })
        .collect()
}

/// D_O = delta D_S: told from a constant only where D_S moved by clearly more than it is known.
fn clocking(gyro: &GyroHistory) -> Option<Candidate> {
    let ds: Vec<f64> = gyro.entries.iter().map(|e| e.d[1].value).collect();
    let mean = ds.iter().sum::<f64>() / ds.len() as f64;
    let spread = (ds.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / ds.len() as f64).sqrt();
    let sd = gyro.entries.iter().filter_map(|e| e.d[1].sd).fold(0.0, f64::max);
    (spread > 5.0 * sd && spread > 1e-9 * mean.abs()).then(|| Candidate {
        parameter: "delta",
        ..candidate("clocking", "D_O in proportion to D_S".into(), "rad", ds.iter().map(|x| x - mean).collect())
    })
}

fn free_steps(gyro: &GyroHistory) -> Vec<Candidate> {
    let cuts: Vec<(usize, Vec<f64>)> =
        (1..gyro.entries.len()).filter_map(|cut| Some((cut, step_column(gyro, cut)?))).collect();
    let tried = cuts.len();
    cuts.into_iter()
        .map(|(cut, column)| Candidate {
            tried,
            ..candidate("step", format!("before record {} of {}", cut + 1, gyro.entries.len()), "deg/(h*g0)", column)
        })
        .collect()
}

/// 0 before record `cut`, 1 from there on; none where too few records stand on a side.
fn step_column(gyro: &GyroHistory, cut: usize) -> Option<Vec<f64>> {
    let n = gyro.entries.len();
    (cut >= FEWEST_ON_A_SIDE && n - cut.min(n) >= FEWEST_ON_A_SIDE)
        .then(|| (0..n).map(|k| f64::from(k >= cut)).collect())
}
