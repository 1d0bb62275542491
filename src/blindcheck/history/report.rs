//! The table of a blind check of histories.

use std::collections::BTreeMap;

use serde::Serialize;

use super::draw::HiddenCause;
use super::score::FleetScore;
use crate::blindcheck::tally::Tally;

/// What is counted, and what is to be reached.
#[derive(Debug, Clone, Serialize)]
pub struct HistoryRate {
    pub what: String,
    pub tally: Tally,
    pub at_least: Option<f64>,
    pub at_most: Option<f64>,
    pub reached: Option<bool>,
}

#[derive(Debug, Clone, Serialize)]
pub struct HistoryReport {
    pub fleets: usize,
    pub seed: u64,
    pub rows: Vec<HistoryRate>,
    /// Of each kind, what was named instead, and how often.
    pub confusion: BTreeMap<&'static str, BTreeMap<String, usize>>,
}

impl HistoryReport {
    /// Counts hits of each row, with what is to be reached.
    pub fn of(seed: u64, scores: &[FleetScore]) -> Self {
        let mut rows = Vec::new();
        let mut row = |what: String, tally: Tally, at_least: Option<f64>, at_most: Option<f64>| {
            let reached = tally
                .rate()
                .map(|rate| at_least.is_none_or(|least| rate >= least) && at_most.is_none_or(|most| rate <= most));
            let goal = at_least.is_some() || at_most.is_some();
            if tally.trials > 0 {
                rows.push(HistoryRate { what, tally, at_least, at_most, reached: reached.filter(|_| goal) });
            }
        };
        for kind in HiddenCause::ALL {
            let right = Tally::of(scores.iter().filter(|score| score.kind == kind).map(|score| score.right));
            let to_reach = if kind == HiddenCause::Wanders { None } else { Some(0.95) };
            row(format!("right: {}", kind.name()), right, to_reach, None);
        }
        let all = |of: &dyn Fn(&FleetScore) -> Option<bool>| Tally::of(scores.iter().filter_map(of));
        row("class holds the cause".into(), all(&|score| score.class.filter(|_| score.right)), Some(1.0), None);
        let lone = |score: &FleetScore| score.class.filter(|_| score.kind == HiddenCause::LoneImuMoved);
        row("a lone IMU's class holds station and step".into(), all(&lone), Some(1.0), None);
        let hits = scores.iter().map(|score| score.false_names.0).sum();
        let trials = scores.iter().map(|score| score.false_names.1).sum();
        row("false names".into(), Tally { hits, trials }, None, Some(0.01));
        row("the station's doing blamed on the gyro".into(), all(&|score| score.gyro_blamed), None, Some(0.05));
        row("wandering explained".into(), all(&|score| score.explained), None, Some(0.02));
        let named = |score: &FleetScore| score.explained.map(|_| !score.named.is_empty());
        row("wandering given a name".into(), all(&named), None, None);
        row("closure covered".into(), all(&|score| score.closure_covered), Some(0.9), None);
        row("date within 80 %".into(), all(&|score| score.date_covered.map(|c| c[0])), Some(0.75), None);
        row("date within 95 %".into(), all(&|score| score.date_covered.map(|c| c[1])), Some(0.92), None);
        row("calibrated in time".into(), all(&|score| score.in_time), Some(0.92), None);
        let mut confusion: BTreeMap<&'static str, BTreeMap<String, usize>> = BTreeMap::new();
        for score in scores.iter().filter(|score| !score.right) {
            let named: Vec<&str> = score.named.iter().map(|cause| cause.name()).collect();
            let named = if named.is_empty() { "-".to_owned() } else { named.join("+") };
            *confusion.entry(score.kind.name()).or_default().entry(named).or_default() += 1;
        }
        Self { fleets: scores.len(), seed, rows, confusion }
    }

    /// Whether no row misses what it is to reach.
    pub fn reached(&self) -> bool {
        self.rows.iter().all(|row| row.reached != Some(false))
    }
}
