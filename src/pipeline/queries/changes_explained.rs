//! A gyro's history as the diagnosis of change needs it, with the fleet beside it.

use super::entries::{PEER_RECORDS, entries};
use super::fleet::{level, stated};
use crate::core::changes::{AsOf, DriftBudget, GyroHistory, HistoryDiagnosis, diagnose_history, is_mate_of};
use crate::core::judge::history::{baseline_of, seat_baseline_of};
use crate::core::judge::{Mark, baseline_since};
use crate::pipeline::ingest::judge::gyro_window::{distinct, load_marks, sample_of};
use crate::pipeline::prelude::*;
use crate::pipeline::queries::gyro_history::Histories;
use crate::store::Stretch;

/// Records of the gyro itself that are looked at, at most.
const OWN_RECORDS: usize = 1000;
/// Records of a peer are taken from so many parts of the gyro's time.
const PARTS: usize = 20;
/// Most peers that count, and most gyros that are asked whether they are one: of every station as many, those with the
/// nearest numbers, which came to the service at the same time.
const PEERS: usize = 40;
const ASKED: usize = 200;

/// Why a gyro's coefficients changed.
#[derive(Debug, Clone, PartialEq)]
pub struct ExplainedHistory {
    /// Gyros of other IMUs that met the same stations.
    pub peers: usize,
    /// Of many records some are looked at, spread over their time.
    pub as_of: AsOf,
    /// D_I, D_S, D_O.
    pub coefficients: Vec<HistoryDiagnosis>,
    /// Of each; none without a baseline.
    pub budgets: [Option<DriftBudget>; 3],
}

impl Histories {
    /// Diagnoses the history of a gyro. Computes for some milliseconds, on a thread for that.
    pub async fn explain(&self, gyro: u32, serial: &str) -> Result<ExplainedHistory, StoreError> {
        let all = store::history::oldest(&self.store, gyro, Span::EVER, usize::MAX).await?;
        let marks = load_marks(&self.store, gyro).await?;
        let method = self.config.judging.method;
        let budgets = self.budgets(serial, &all, &marks);
        let as_of = AsOf { records: all.len(), newest: all.last().map(|figures| figures.at), now: self.clock.now() };
        let own = spread(&all, OWN_RECORDS);
        let of_own = own.iter().map(|figures| figures.record);
        let temperatures = store::history::temperatures(&self.store, of_own).await?;
        let history = GyroHistory { entries: entries(&self.store, method, &own, &temperatures), marks };
        let rows = self.peers(gyro, &own).await?;
        let peers = rows.iter().map(|rows| entries(&self.store, method, rows, &HashMap::new()));
        let peers: Vec<GyroHistory> = peers.map(|entries| GyroHistory { entries, marks: Vec::new() }).collect();
        let failed = format!("the history of gyro number {gyro} could not be diagnosed");
        let explained = computed(failed, move || {
            let peers: Vec<&GyroHistory> = peers.iter().collect();
            let coefficients = diagnose_history(&history, &peers, budgets);
            let is_mate = is_mate_of(&history);
            let peers = peers.iter().filter(|peer| !is_mate(peer)).count();
            ExplainedHistory { peers, as_of, coefficients, budgets }
        });
        explained.await
    }

    /// Records of gyros that met one of these stations: the newest, or where there are more within the time of `own`,
    /// some from each part of it.
    async fn peers(&self, gyro: u32, own: &[Figures]) -> Result<Vec<Vec<Figures>>, StoreError> {
        let Some([first, last]) = own.first().zip(own.last()).map(|(first, last)| [first.at, last.at]) else {
            return Ok(Vec::new());
        };
        let mut peers = self.neighbours(gyro, own).await?;
        let is_more = |rows: &[Figures]| rows.len() == PEER_RECORDS && rows[0].at > first;
        let more: Vec<usize> = (0..peers.len()).filter(|k| is_more(&peers[*k].1)).collect();
        let days = last.days_since(first) / PARTS as f64;
        let part = |part: usize| {
            let to = if part + 1 == PARTS { last } else { UtcMicros(first.plus_days(days * (part + 1) as f64).0 - 1) };
            Span { from: first.plus_days(days * part as f64), to }
        };
        let parts: Vec<Stretch> =
            more.iter().flat_map(|k| (0..PARTS).map(|number| (peers[*k].0, part(number)))).collect();
        let found = store::histories::newest(&self.store, &parts, PEER_RECORDS / PARTS).await?;
        for (k, parts) in more.iter().zip(found.chunks(PARTS)) {
            peers[*k].1 = parts.concat();
        }
        Ok(peers.into_iter().map(|(_, rows)| rows).collect())
    }

    /// Gyros that met a station of `own`, and their newest records: of each station as many, first of the one that the
    /// fewest have met. None of a station is crowded out by those of another.
    async fn neighbours(&self, gyro: u32, own: &[Figures]) -> Result<Vec<(u32, Vec<Figures>)>, StoreError> {
        let stations: BTreeSet<u32> = own.iter().map(|figures| figures.station).collect();
        let each = (ASKED / stations.len().max(1)).max(1);
        let mut near: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for station in stations {
            near.insert(station, store::head::near(&self.store, station, gyro, each).await?);
        }
        let asked: BTreeSet<u32> = near.values().flatten().copied().collect();
        let asked: Vec<u32> = asked.into_iter().collect();
        let rows = store::histories::newest_ever(&self.store, &asked, PEER_RECORDS).await?;
        let mut rows: HashMap<u32, Vec<Figures>> = asked.into_iter().zip(rows).collect();
        for (station, gyros) in &mut near {
            gyros.retain(|other| rows[other].iter().any(|figures| figures.station == *station));
        }
        let mut near: Vec<Vec<u32>> = near.into_values().collect();
        near.sort_by_key(Vec::len);
        let mut peers: Vec<u32> = Vec::new();
        let longest = near.last().map_or(0, Vec::len);
        for other in (0..longest).flat_map(|k| near.iter().filter_map(move |gyros| gyros.get(k))) {
            if peers.len() < PEERS && !peers.contains(other) {
                peers.push(*other);
            }
        }
        Ok(peers.into_iter().filter_map(|other| Some((other, rows.remove(&other)?))).collect())
    }

    /// How far D_I, D_S and D_O may be from their baselines, where these are known.
    fn budgets(&self, serial: &str, own: &[Figures], marks: &[Mark]) -> [Option<DriftBudget>; 3] {
        let Some(newest) = own.last() else { return [None; 3] };
        let limits = self.limits(serial, own);
        let samples = distinct(own.iter().map(|figures| sample_of(figures, self.config.judging.method)));
        let drift = baseline_of(&samples, marks, newest.at);
        let baselines = [drift, drift, seat_baseline_of(&samples, marks, newest.at)];
        [0, 1, 2].map(|column| {
            let limit = limits.budgets()[column]?;
            let stated = stated(marks, newest.at, &limits, column);
            let began = || baseline_since(marks, newest.at).unwrap_or(UtcMicros(i64::MIN));
            let measured_since = stated.is_none().then(began);
            Some(DriftBudget { baseline: level(baselines[column], column, stated)?, limit, measured_since })
        })
    }
}

/// One of every so many, the newest among them, so that no more than `most` are left. Which one of its neighbours is
/// taken changes, so that what alternates is not seen from one side.
fn spread(all: &[Figures], most: usize) -> Vec<Figures> {
    let every = all.len().div_ceil(most).max(1);
    let mut some: Vec<Figures> =
        all.rchunks(every).enumerate().map(|(k, some)| some[some.len() - 1 - k % some.len()]).collect();
    some.reverse();
    some
}
