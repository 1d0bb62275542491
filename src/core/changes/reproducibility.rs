//! Stations compared over the fleet: gauge repeatability and reproducibility, with what each does over time.
//!
//! Of a record of gyro g at station s, y = mu_g + b_s(t) + c_gs + e: e is repeatability, the spread of the offsets b_s
//! among stations is their reproducibility, that of c_gs gyro x station (AIAG, Measurement Systems Analysis, 4th ed.,
//! chapter III). Gyros age and step by themselves, so all of it is robust: e from the median of successive differences,
//! c from the median of the gyros' pulls about the common offset, b from [`station`](super::station).

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::sync::Arc;

use crate::core::numerics::median::median_of;
use crate::core::numerics::tails;
use crate::core::time::UtcMicros;

use super::answer::{GyroHistory, HistoryEntry, StationForm};
use super::offsets::{Offsets, offsets};
use super::series::robust;
use super::station::{CoursePart, CoursePoint, OF_SCALE, Shared, StationCourse};
use super::unlike::{scatters, unlike};
use super::unlike_window::Unlike;

/// Points of a station's course, at most.
const POINTS: usize = 60;
/// As [`OF_SCALE`]; successive differences share a record each.
pub(super) const OF_SUCCESSIVE: f64 = 1.43;

/// A standard deviation with its 95 % interval, deg/(h g0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    pub sd: f64,
    pub interval: [f64; 2],
}

/// One coefficient at one station.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StationColumn {
    pub repeatability: Option<Spread>,
    /// Against the station that offsets count from; none of itself, and where no gyro was at both.
    pub offset: Option<Shared>,
    /// A year.
    pub drift: Option<Shared>,
    /// Whether the drift is beyond chance, and the gyros of several IMUs share it.
    pub drifts: bool,
    /// Where it began within the records.
    pub drift_since: Option<UtcMicros>,
    /// In order of time.
    pub steps: Vec<(UtcMicros, Shared)>,
    /// From the first instant on and before the second it was off; in order of time.
    pub windows: Vec<([UtcMicros; 2], Shared)>,
    pub by_gyro: Option<Spread>,
    pub course: Vec<CoursePoint>,
}

/// What a station does to results (gauge repeatability and reproducibility), as its gyros share it.
#[derive(Debug, Clone, PartialEq)]
pub struct StationFigures {
    pub name: Arc<str>,
    pub records: usize,
    pub gyros: usize,
    pub imus: usize,
    pub first: UtcMicros,
    pub last: UtcMicros,
    /// The station that its offsets count from; none of itself, and where no gyros lead to another.
    pub against: Option<Arc<str>>,
    /// When many of its gyros were off in different directions, oldest first.
    pub unlike: Vec<Unlike>,
    /// D_I and D_S.
    pub columns: [StationColumn; 2],
}

/// All stations of a fleet.
#[derive(Debug, Clone, PartialEq)]
pub struct FleetStations {
    /// By name.
    pub stations: Vec<StationFigures>,
    /// The station that most offsets count from.
    pub against: Arc<str>,
    /// Spread of the offsets of those, D_I and D_S.
    pub reproducibility: [Option<Spread>; 2],
}

impl FleetStations {
    /// How D_I and D_S differ from station to station: the spread of the stations' offsets, and beside it what single
    /// gyros show beyond those (the median over the stations that tell it). 0 where the fleet does not tell it: where
    /// the 95 % interval of the spread begins at 0.
    pub fn between(&self) -> [f64; 2] {
        let known = |spread: Option<Spread>| spread.filter(|spread| spread.interval[0] > 0.0).map(|spread| spread.sd);
        [0, 1].map(|column| {
            let by_gyro = self.stations.iter().filter_map(|station| known(station.columns[column].by_gyro));
            let by_gyro = median_of(by_gyro).unwrap_or(0.0);
            known(self.reproducibility[column]).map_or(0.0, |sd| sd.hypot(by_gyro))
        })
    }
}

/// What every station of `fleet` does; none without records.
pub fn stations(fleet: &[GyroHistory]) -> Option<FleetStations> {
    let mut found: BTreeMap<Arc<str>, StationFigures> = BTreeMap::new();
    let mut records: HashSet<(&str, &str, UtcMicros)> = HashSet::new();
    for gyro in fleet {
        let mut here: Vec<&Arc<str>> = Vec::new();
        for entry in &gyro.entries {
            let figures = found.entry(entry.station.clone()).or_insert_with(|| StationFigures {
                name: entry.station.clone(),
                records: 0,
                gyros: 0,
                imus: 0,
                first: entry.at,
                last: entry.at,
                against: None,
                unlike: Vec::new(),
                columns: Default::default(),
            });
            figures.records += usize::from(records.insert((&entry.station, &entry.imu, entry.at)));
            figures.first = figures.first.min(entry.at);
            figures.last = figures.last.max(entry.at);
            if !here.contains(&&entry.station) {
                here.push(&entry.station);
                figures.gyros += 1;
            }
        }
    }
    let names: Vec<&str> = found.keys().map(|name| &**name).collect();
    let records: Vec<usize> = found.values().map(|figures| figures.records).collect();
    let groups = groups(fleet, &names, &records);
    let reference = groups.first()?.0;
    let against = names[reference].into();
    let origin = found.values().map(|figures| figures.first).min()?;
    let gyros: Vec<&GyroHistory> = fleet.iter().collect();
    let mut reproducibility = [None; 2];
    let mut stations: Vec<StationFigures> = found.values().cloned().collect();
    let scatters = scatters(&gyros);
    stations.iter_mut().for_each(|figures| figures.unlike = unlike(&gyros, &scatters, &figures.name));
    for (reference, compared) in &groups {
        let of_group = stations.iter_mut().zip(compared).filter(|(_, compared)| **compared);
        of_group.for_each(|(figures, _)| figures.against = Some(names[*reference].into()));
    }
    for (column, reproducibility) in reproducibility.iter_mut().enumerate() {
        let raw = StationCourse::of(&gyros, &names, origin, column);
        let (mut course, cells) = (raw.clone(), raw.cells());
        for (reference, compared) in &groups {
            for (station, offset) in offsets(&cells, *reference, compared).by_station {
                course.subtract(&CoursePart { station, form: StationForm::Offset }, offset.value);
            }
        }
        course.take(reference, |_, common, _, _| common.imus >= 2);
        let mut levels = raw.clone();
        for (part, common) in course.taken.iter().filter(|(part, _)| part.form != StationForm::Offset) {
            levels.subtract(part, common.value);
        }
        let cells = levels.cells();
        let mut known = BTreeMap::new();
        for (reference, compared) in groups.iter().rev() {
            let mut of_group = offsets(&cells, *reference, compared);
            // That of the largest group is left.
            *reproducibility = among(&of_group);
            known.append(&mut of_group.by_station);
        }
        for (station, figures) in stations.iter_mut().enumerate() {
            figures.imus = raw.imus_at(station);
            let offset = known.get(&station).copied();
            figures.columns[column] =
                of_station([&raw, &course], station, offset, repeatability(fleet, &figures.name, column));
        }
    }
    Some(FleetStations { stations, against, reproducibility })
}

/// Stations that gyros compare, the most first: of each group the busiest, which offsets count from, and which others are
/// compared with it.
fn groups(fleet: &[GyroHistory], names: &[&str], records: &[usize]) -> Vec<(usize, Vec<bool>)> {
    let mut busiest: Vec<usize> = (0..names.len()).collect();
    busiest.sort_by_key(|station| records[*station]);
    let mut groups: Vec<(usize, Vec<bool>)> = Vec::new();
    for station in busiest.into_iter().rev() {
        if !groups.iter().any(|(_, compared): &(usize, Vec<bool>)| compared[station]) {
            groups.push((station, compared(fleet, names, station)));
        }
    }
    groups.sort_by_key(|(_, compared)| std::cmp::Reverse(compared.iter().filter(|reached| **reached).count()));
    groups
}

/// Stations other than `reference` that gyros compare with it: those of one gyro, and through its stations those of others.
fn compared(fleet: &[GyroHistory], names: &[&str], reference: usize) -> Vec<bool> {
    let mut reached = vec![false; names.len()];
    reached[reference] = true;
    let number = |entry: &HistoryEntry| names.binary_search(&&*entry.station).ok();
    let of_gyros: Vec<BTreeSet<usize>> =
        fleet.iter().map(|gyro| gyro.entries.iter().filter_map(number).collect()).collect();
    loop {
        let meets = |of: &&BTreeSet<usize>| of.iter().any(|k| reached[*k]) && !of.iter().all(|k| reached[*k]);
        let Some(more) = of_gyros.iter().find(meets) else { break };
        more.iter().for_each(|k| reached[*k] = true);
    }
    reached[reference] = false;
    reached
}

fn of_station(
    [raw, course]: [&StationCourse; 2],
    station: usize,
    offset: Option<Shared>,
    repeatability: Option<Spread>,
) -> StationColumn {
    let drifts = course.taken.iter().filter(|(part, _)| part.station == station && part.form.is_drift());
    let taken = drifts.max_by(|(_, a), (_, b)| a.significance().total_cmp(&b.significance()));
    let drift = match taken {
        Some((_, common)) => Some(*common),
        None => course.estimate(&CoursePart { station, form: StationForm::Drift }),
    };
    let drift_since =
        taken.and_then(|(part, _)| if let StationForm::DriftSince(at) = part.form { Some(at) } else { None });
    let (mut steps, mut windows) = (Vec::new(), Vec::new());
    for (part, common) in course.taken.iter().filter(|(part, _)| part.station == station) {
        match part.form {
            StationForm::Step(at) => steps.push((at, *common)),
            StationForm::Between(from, until) => windows.push(([from, until], *common)),
            StationForm::Offset | StationForm::Drift | StationForm::DriftSince(_) => {}
        }
    }
    steps.sort_by_key(|(at, _)| *at);
    windows.sort_by_key(|(between, _)| *between);
    StationColumn {
        repeatability,
        offset,
        drift,
        drifts: taken.is_some(),
        drift_since,
        steps,
        windows,
        by_gyro: by_gyro(course, station),
        course: raw.course_of(station, POINTS),
    }
}

/// Spread of what single gyros show beyond the common offset, their records' noise taken off. A gyro's offset is against
/// the mean of its other stations, which share it too: of k alike its variance is that of noise and (1 + 1/k) times that
/// of gyro x station.
fn by_gyro(course: &StationCourse, station: usize) -> Option<Spread> {
    let common = course.estimate(&CoursePart { station, form: StationForm::Offset })?.value;
    let each = course.offsets_of_gyros(station);
    let count = each.len();
    if count < 3 {
        return None;
    }
    let scale = robust(each.iter().map(|one| (one.value - common).abs() * one.information.sqrt()))?;
    let power = each.iter().map(|one| one.information * (1.0 + one.shares)).sum::<f64>() / count as f64;
    let beyond = |scale: f64| ((scale * scale - 1.0).max(0.0) / power).sqrt();
    let factor = (1.96 * OF_SCALE / (count as f64).sqrt()).exp();
    Some(Spread { sd: beyond(scale), interval: [beyond(scale / factor), beyond(scale * factor)] })
}

/// Of one record, from successive records of one gyro there.
fn repeatability(fleet: &[GyroHistory], station: &str, column: usize) -> Option<Spread> {
    let mut differences = Vec::new();
    for gyro in fleet {
        let here: Vec<f64> =
            gyro.entries.iter().filter(|entry| *entry.station == *station).map(|entry| entry.d[column].value).collect();
        differences.extend(here.windows(2).map(|pair| (pair[1] - pair[0]).abs() / std::f64::consts::SQRT_2));
    }
    let count = differences.len();
    let sd = robust(differences).filter(|_| count > 2)?;
    let factor = (1.96 * OF_SUCCESSIVE / (count as f64).sqrt()).exp();
    Some(Spread { sd, interval: [sd / factor, sd * factor] })
}

/// Spread of the offsets of all stations, that of reference included (zero), their own uncertainty taken off; the
/// interval is that of a variance with one degree of freedom fewer than stations.
fn among(offsets: &Offsets) -> Option<Spread> {
    let values: Vec<f64> = offsets.by_station.values().map(|offset| offset.value).collect();
    if values.is_empty() {
        return None;
    }
    let count = values.len() + 1;
    let mean = values.iter().sum::<f64>() / count as f64;
    let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() + mean * mean;
    let dof = (count - 1) as f64;
    let [low, high] = [0.975, 0.025].map(|p| squares / tails::chi2_quantile(p, dof));
    let sd = |variance: f64| (variance - offsets.of_spread).max(0.0).sqrt();
    Some(Spread { sd: sd(squares / dof), interval: [sd(low), sd(high)] })
}
