//! One coefficient of one gyro over time, ready to be searched.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::core::judge::Mark;
use crate::core::mounting::Slot;
use crate::core::numerics::median::median_of;
use crate::core::numerics::normal::SD_OF_MEDIAN;
use crate::core::time::UtcMicros;

use super::answer::{HistoryEntry, Outlier, YEAR_DAYS};

/// Of more records than this, neighbours of one station and seat are averaged.
const MOST_ROWS: usize = 72;
/// Distance, in standard deviations, from which a record between others is an outlier.
const OUTLYING: f64 = 6.0;
/// Standard deviations of the best step among neighbours from which on they are averaged before it and after it.
const STEPS: f64 = 5.0;
/// The same figures within so many days are one measurement, sent again.
const REPEATED_WITHIN_DAYS: f64 = 1.0;

/// How records scatter about their neighbours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RecordScatter {
    /// Standard deviation of one record, deg/(h g0).
    pub absolute: f64,
    /// The same in units of the stated standard deviations; drawn towards 1 where there are few differences.
    pub of_stated: f64,
}

/// From differences of successive records of one station: median |d|/(0.6745 sqrt 2), which a step or a slow drift
/// hardly moves.
pub(super) fn scatter_of(entries: &[HistoryEntry], column: usize) -> RecordScatter {
    let mut last: BTreeMap<&str, &HistoryEntry> = BTreeMap::new();
    let mut plain = Vec::new();
    let mut stated = Vec::new();
    for entry in entries {
        if let Some(before) = last.insert(&entry.station, entry) {
            let (old, new) = (before.d[column], entry.d[column]);
            let difference = (new.value - old.value).abs() / std::f64::consts::SQRT_2;
            plain.push(difference);
            if let Some((a, b)) = old.sd.zip(new.sd) {
                stated.push(difference / (0.5 * (a * a + b * b)).sqrt());
            }
        }
    }
    stated.retain(|one: &f64| one.is_finite());
    let count = stated.len() as f64;
    let seen = robust(stated).unwrap_or(1.0);
    let of_stated = ((count * seen * seen + 4.0) / (count + 4.0)).sqrt();
    RecordScatter { absolute: robust(plain).unwrap_or(0.0), of_stated }
}

/// Standard deviation of normal figures from the median of their absolute values.
pub(super) fn robust(absolute: impl IntoIterator<Item = f64>) -> Option<f64> {
    Some(SD_OF_MEDIAN * median_of(absolute)?)
}

#[derive(Debug, Clone)]
pub(super) struct Observation {
    pub at: UtcMicros,
    /// Since the gyro's first record.
    pub years: f64,
    pub station: usize,
    pub seat: (Arc<str>, Slot),
    pub temperature_c: Option<f64>,
    /// About the mean of all, deg/(h g0).
    pub y: f64,
    /// Variance in units of `unit^2`.
    pub variance: f64,
    pub d_s: f64,
}

/// The rows, oldest first.
#[derive(Debug, Clone)]
pub(super) struct RecordSeries {
    pub rows: Vec<Observation>,
    pub stations: Vec<Arc<str>>,
    pub origin: UtcMicros,
    pub mean: f64,
    /// Standard deviation of a record of variance 1, as stated (or, where nothing is, as they scatter).
    pub unit: f64,
    pub scatter: RecordScatter,
    /// Largest stated standard deviation of D_S; where none is stated, that of its scatter.
    pub d_s_sd: f64,
}

impl RecordSeries {
    /// One coefficient of a history, oldest first: its mean taken off, its variances in units of a typical one.
    /// `column` is the place in `Entry::d`.
    pub fn of(entries: &[HistoryEntry], column: usize) -> Self {
        let mut stations: Vec<Arc<str>> = entries.iter().map(|entry| entry.station.clone()).collect();
        stations.sort_unstable();
        stations.dedup();
        let scatter = scatter_of(entries, column);
        let n = entries.len().max(1) as f64;
        let mean = entries.iter().map(|entry| entry.d[column].value).sum::<f64>() / n;
        let stated: Vec<f64> = entries.iter().filter_map(|e| e.d[column].sd).filter(|sd| *sd > 0.0).collect();
        let squares = stated.iter().map(|sd| sd * sd).sum::<f64>() / stated.len().max(1) as f64;
        let unit = if stated.is_empty() { scatter.absolute } else { squares.sqrt() };
        let unit = if unit > 0.0 { unit } else { 1e-9 * mean.abs().max(1e-3) };
        let origin = entries.first().map_or(UtcMicros(0), |entry| entry.at);
        let row = |entry: &HistoryEntry| Observation {
            at: entry.at,
            years: entry.at.days_since(origin) / YEAR_DAYS,
            station: stations.binary_search(&entry.station).unwrap_or(0),
            seat: (entry.imu.clone(), entry.slot),
            temperature_c: entry.temperature_c.filter(|t| t.is_finite()),
            y: entry.d[column].value - mean,
            variance: entry.d[column].sd.filter(|sd| *sd > 0.0).map_or(1.0, |sd| (sd / unit).powi(2).max(1e-6)),
            d_s: entry.d[1].value,
        };
        let rows = entries.iter().map(row).collect();
        let stated_of_d_s = entries.iter().filter_map(|entry| entry.d[1].sd).reduce(f64::max);
        let d_s_sd = stated_of_d_s.unwrap_or_else(|| scatter_of(entries, 1).absolute);
        Self { rows, stations, origin, mean, unit, scatter, d_s_sd }
    }

    /// Number of records.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// One figure of every record, in order of time.
    pub fn column(&self, of: impl Fn(&Observation) -> f64) -> Vec<f64> {
        self.rows.iter().map(of).collect()
    }

    /// Root mean square about the mean.
    pub fn spread(&self) -> f64 {
        (self.rows.iter().map(|row| row.y * row.y).sum::<f64>() / self.len().max(1) as f64).sqrt()
    }

    /// The station that most records are of.
    pub fn reference(&self) -> usize {
        let count = |station: usize| self.rows.iter().filter(|row| row.station == station).count();
        (0..self.stations.len()).max_by_key(|station| count(*station)).unwrap_or(0)
    }

    /// Takes out the records that stand apart from both neighbours and from the medians of three on either side; at an
    /// end, from those of the one side. None that `is_told` says something of.
    pub fn take_outliers(&mut self, is_told: impl Fn(&Observation) -> bool) -> Vec<Outlier> {
        let n = self.len();
        if n < 8 {
            return Vec::new();
        }
        let sides = |k: usize| -> Vec<f64> {
            let before = &self.rows[k.saturating_sub(3)..k];
            let after = &self.rows[k + 1..(k + 4).min(n)];
            let middle = |rows: &[Observation]| median_of(rows.iter().map(|row| row.y));
            let nearest = [before.last(), after.first()].into_iter().flatten().map(|row| row.y);
            [middle(before), middle(after)].into_iter().flatten().chain(nearest).collect()
        };
        let apart = |k: usize| -> f64 {
            let differences: Vec<f64> = sides(k).iter().map(|side| self.rows[k].y - side).collect();
            let same = differences.iter().all(|d| *d > 0.0) || differences.iter().all(|d| *d < 0.0);
            if same { differences.into_iter().min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0) } else { 0.0 }
        };
        let pull = |pair: &[Observation]| (pair[1].y - pair[0].y).abs() / (pair[0].variance + pair[1].variance).sqrt();
        let to_left = self.rows.windows(2).map(pull);
        let sd = robust(to_left).unwrap_or(0.0).max(1e-12);
        let found: Vec<(usize, f64, f64)> = (0..n)
            .map(|k| (k, apart(k), sd * (1.5 * self.rows[k].variance).sqrt()))
            .filter(|(k, deviation, sd)| deviation.abs() > OUTLYING * sd && !is_told(&self.rows[*k]))
            .collect();
        if found.len() > n / 6 {
            return Vec::new();
        }
        let outliers = found.iter().map(|&(k, deviation, sd)| Outlier { at: self.rows[k].at, deviation, sd }).collect();
        let mut k = 0;
        self.rows.retain(|_| {
            k += 1;
            !found.iter().any(|(outlier, ..)| *outlier == k - 1)
        });
        outliers
    }

    /// Averages neighbours of one station and seat between two events that may move a gyro, where there are too many
    /// rows; of very many events, between the newest.
    pub fn condense(&mut self, marks: &[Mark]) {
        let marks: Vec<UtcMicros> =
            marks.iter().filter(|mark| mark.event.may_move_a_gyro()).map(|mark| mark.at).collect();
        let marks = &marks[marks.len().saturating_sub(MOST_ROWS / 4)..];
        let mut bins = MOST_ROWS;
        while self.len() > MOST_ROWS && bins >= 4 {
            let mut groups: BTreeMap<_, Vec<usize>> = BTreeMap::new();
            for (k, row) in self.rows.iter().enumerate() {
                let since = marks.iter().filter(|at| **at <= row.at).count();
                let bin = k * bins / self.len();
                groups.entry((bin, since, row.station, row.seat.clone())).or_default().push(k);
            }
            if groups.len() <= MOST_ROWS || bins < 8 {
                let apart = groups.values().flat_map(|group| self.apart(group));
                let mut rows: Vec<Observation> = apart.map(|group| self.average(group)).collect();
                rows.sort_by_key(|row| row.at);
                self.rows = rows;
                break;
            }
            bins /= 2;
        }
    }

    /// A group in two, where it steps within: an average over a step would be two steps.
    fn apart<'a>(&self, group: &'a [usize]) -> impl Iterator<Item = &'a [usize]> {
        let sum = |some: &[usize]| {
            some.iter().fold((0.0, 0.0), |(weight, weighted), k| {
                let one = 1.0 / self.rows[*k].variance;
                (weight + one, weighted + one * self.rows[*k].y)
            })
        };
        let whole = sum(group);
        let (mut before, mut best) = ((0.0, 0.0), (0.0, 0));
        for (cut, k) in group.iter().enumerate() {
            let after = (whole.0 - before.0, whole.1 - before.1);
            let step = (after.1 / after.0 - before.1 / before.0) / (1.0 / after.0 + 1.0 / before.0).sqrt();
            if cut > 0 && step.abs() > best.0 {
                best = (step.abs(), cut);
            }
            let one = sum(std::slice::from_ref(k));
            before = (before.0 + one.0, before.1 + one.1);
        }
        let cut = if best.0 > STEPS * self.unit * self.scatter.of_stated { best.1 } else { 0 };
        let (before, after) = group.split_at(cut);
        [before, after].into_iter().filter(|some| !some.is_empty())
    }

    fn average(&self, group: &[usize]) -> Observation {
        let weight = |k: &usize| 1.0 / self.rows[*k].variance;
        let total: f64 = group.iter().map(weight).sum();
        let mean = |of: &dyn Fn(&Observation) -> f64| {
            group.iter().map(|k| weight(k) * of(&self.rows[*k])).sum::<f64>() / total
        };
        let first = &self.rows[group[0]];
        let temperatures: Vec<f64> = group.iter().filter_map(|k| self.rows[*k].temperature_c).collect();
        let known = 2 * temperatures.len() > group.len();
        let years = mean(&|row| row.years);
        Observation {
            at: self.origin.plus_days(years * YEAR_DAYS),
            years,
            temperature_c: known.then(|| temperatures.iter().sum::<f64>() / temperatures.len() as f64),
            y: mean(&|row| row.y),
            variance: 1.0 / total,
            d_s: mean(&|row| row.d_s),
            ..first.clone()
        }
    }
}

/// The entries without those that are another measurement sent again.
pub(super) fn distinct(entries: &[HistoryEntry]) -> Vec<HistoryEntry> {
    let mut kept: Vec<HistoryEntry> = Vec::with_capacity(entries.len());
    for entry in entries {
        let repeats = |before: &HistoryEntry| {
            entry.at.days_since(before.at).abs() < REPEATED_WITHIN_DAYS
                && entry.d.iter().zip(&before.d).all(|(a, b)| a.value.to_bits() == b.value.to_bits())
        };
        if !kept.last().is_some_and(repeats) {
            kept.push(entry.clone());
        }
    }
    kept
}
