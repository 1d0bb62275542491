//! What a station does to every gyro that it measures: its offset, drift and steps, from gyros of other IMUs.
//!
//! Records of peer p: y = mu_p + sum of b c(t, station) + noise, with c of a part: 1 at the station (offset), t there
//! (drift), t there from an instant on, 1 there from an instant on (step) or between two (window). Each peer gives an
//! estimate b_p of its own, its level projected out; the station's is their robust mean (Huber from the weighted
//! median), its standard deviation the larger of what the records' noise gives and the sandwich over IMUs, whose gyros
//! are calibrated together and move together. So no gyro that ages or steps by itself makes its station do so. Parts are taken one by one, the most
//! significant first, and estimated again beside one another.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use super::answer::{GyroHistory, HistoryEntry, StationForm, YEAR_DAYS};
use super::series::{RecordScatter, RecordSeries, scatter_of};
use crate::core::numerics::basis::{Basis, dot};
use crate::core::numerics::median::{median_of, upper_median_of};
use crate::core::numerics::normal::SD_OF_MEDIAN;
use crate::core::numerics::normal_equations::{NormalEquations, Solution, gram};
use crate::core::time::UtcMicros;

/// |b|/sd from which a part is taken: of an offset or a drift, and of a step or a window, which are searched for.
pub(super) const TAKEN: f64 = 4.5;
const TAKEN_SEARCHED: f64 = 5.0;
/// Instants that are tried at a station, and to either side of the best, before that is refined.
const INSTANTS: usize = 24;
const ABOUT: usize = 12;
/// Lengths of windows that are looked through, days: a fault of hours to one of two months.
const WINDOWS: [f64; 5] = [4.0, 8.0, 16.0, 32.0, 64.0];
/// A record counts as so many of its standard deviations there, at most.
const CLIPPED: f64 = 4.0;
/// What the best of many instants, or of all windows, gains by chance.
const SEARCHED: f64 = 12.0;
const SEARCHED_WINDOWS: f64 = 18.0;
/// Relative standard deviation of a robust scale, times the root of the number of figures: 0.6745^-1 sqrt(pi/8)/phi.
pub(super) const OF_SCALE: f64 = 1.167;
/// Huber's constant.
pub(super) const HUBER: f64 = 1.5;
/// A gyro's own records agree with one or two IMUs within so many standard deviations, and show something themselves
/// from as many on; of more IMUs they are only denied so far apart from them.
const AGREES: f64 = 3.5;
const DENIES: f64 = 6.0;
/// What is within so many standard deviations of nothing, and farther from what the gyros show, is not the station's.
const NOTHING: f64 = 3.0;
/// Gyros that share a change differ in it by less than its size over this; those that age each by itself do not.
const ALIKE: f64 = 8.0;
const MOST_PARTS: usize = 6;
/// Parts are estimated again beside one another until none changes by so many of its standard deviations, so many times at
/// the most: an offset and a drift of one station give way to one another slowly.
const SETTLED: f64 = 0.05;
const ROUNDS: usize = 40;
/// Steps that are told from a gyro's slope at one station, and the |b|/sd from which: one too many only widens the slope.
const MOST_STEPS: usize = 3;
const STEPS: f64 = 3.5;
/// Fewest records that show how a gyro scatters.
const SCATTERS: usize = 3;

/// A part of a station's course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CoursePart {
    pub station: usize,
    pub form: StationForm,
}

impl CoursePart {
    /// Its column; `at` and `years` of one record.
    pub fn at(&self, station: usize, at: UtcMicros, years: f64) -> f64 {
        if station == self.station { self.form.at(at, years) } else { 0.0 }
    }
}

/// What gyros share of a part, deg/(h g0), and a year for a drift.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shared {
    pub value: f64,
    pub sd: f64,
    pub gyros: usize,
    pub imus: usize,
    /// How the gyros differ beyond their noise at the least (95 %), standard deviation.
    pub between: f64,
    /// By how much the sum of squares falls.
    pub gain: f64,
}

impl Shared {
    /// Whether a drift of this size would be taken for more than chance.
    pub fn is_beyond_chance(&self) -> bool {
        self.value.abs() > TAKEN * self.sd
    }

    /// |value|/sd; zero where the standard deviation is unknown.
    pub fn significance(&self) -> f64 {
        if self.sd > 0.0 { self.value.abs() / self.sd } else { 0.0 }
    }
}

/// What the gyros that were there read on the whole, about their own levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoursePoint {
    pub at: UtcMicros,
    pub value: f64,
    pub sd: f64,
    pub records: usize,
}

/// The records of one gyro at one station.
#[derive(Debug, Clone, Copy)]
pub(super) struct StationCell {
    pub gyro: usize,
    pub imu: usize,
    pub station: usize,
    pub mean: f64,
    pub weight: f64,
}

/// A gyro's offset at a station against its others, one over the variance of its noise, and the sum of squares of the
/// others' shares in what it is held against.
#[derive(Debug, Clone, Copy)]
pub(super) struct OffsetOfGyro {
    pub value: f64,
    pub information: f64,
    pub shares: f64,
}

#[derive(Debug, Clone, Copy)]
struct PeerRecord {
    at: UtcMicros,
    years: f64,
    station: usize,
    y: f64,
    weight: f64,
}

#[derive(Debug, Clone)]
struct Peer {
    imu: usize,
    rows: Vec<PeerRecord>,
    /// As they were measured, of each station that it has been to.
    measured: Vec<Vec<PeerRecord>>,
}

/// Courses of the stations that one gyro has been to, for one coefficient.
#[derive(Debug, Clone)]
pub(super) struct StationCourse {
    peers: Vec<Peer>,
    /// Median scatter of the peers.
    pub scatter: Option<RecordScatter>,
    stations: usize,
    pub taken: Vec<(CoursePart, Shared)>,
}

impl StationCourse {
    /// Of `peers` at `stations`; years count from `origin`. Nothing is taken yet.
    pub fn of(peers: &[&GyroHistory], stations: &[&str], origin: UtcMicros, column: usize) -> Self {
        let mut imus: Vec<&str> = Vec::new();
        let mut out = Vec::new();
        let mut scatters = Vec::new();
        let blunders = blunders(peers, column);
        for (number, peer) in peers.iter().enumerate() {
            let Some(newest) = peer.entries.last() else { continue };
            let imu = imus.iter().position(|imu| **imu == *newest.imu).unwrap_or_else(|| {
                imus.push(&newest.imu);
                imus.len() - 1
            });
            let scatter = scatter_of(&peer.entries, column);
            let place = |name: &str| stations.iter().position(|known| *known == name);
            let mut there: BTreeMap<&str, Vec<PeerRecord>> = BTreeMap::new();
            for entry in peer.entries.iter().filter(|entry| !blunders.contains(&(number, entry.at))) {
                let sd = entry.d[column].sd.filter(|sd| *sd > 0.0);
                let weight = sd.map_or(scatter.absolute, |sd| sd * scatter.of_stated).powi(-2);
                let (station, years) = (place(&entry.station), entry.at.days_since(origin) / YEAR_DAYS);
                if weight.is_finite() && weight > 0.0 {
                    let station = station.unwrap_or(stations.len());
                    let row = PeerRecord { at: entry.at, years, station, y: entry.d[column].value, weight };
                    there.entry(&entry.station).or_default().push(row);
                }
            }
            let measured: Vec<Vec<PeerRecord>> = there.into_values().collect();
            let mut rows: Vec<PeerRecord> =
                measured.iter().flatten().filter(|row| row.station < stations.len()).copied().collect();
            rows.sort_by_key(|row| row.at);
            if rows.len() >= SCATTERS {
                scatters.push(scatter);
            }
            if rows.len() >= 2 {
                out.push(Peer { imu, rows: about_their_mean(rows), measured });
            }
        }
        let of = |of: fn(&RecordScatter) -> f64| median_of(scatters.iter().map(of));
        let scatter = of(|one| one.absolute).zip(of(|one| one.of_stated));
        let scatter = scatter.map(|(absolute, of_stated)| RecordScatter { absolute, of_stated });
        Self { peers: out, scatter, stations: stations.len(), taken: Vec::new() }
    }

    /// Gyros whose records show how they scatter.
    pub fn gyros(&self) -> usize {
        self.that_scatter().count()
    }

    /// Their records.
    pub fn records(&self) -> usize {
        self.that_scatter().map(|peer| peer.rows.len()).sum()
    }

    fn that_scatter(&self) -> impl Iterator<Item = &Peer> {
        self.peers.iter().filter(|peer| peer.rows.len() >= SCATTERS)
    }

    /// What the peers that show a station's drift and the gyro itself do in a year at other stations while it drifts,
    /// beside what is taken of those from an instant on.
    pub fn slope_elsewhere(&self, drift: &CoursePart, series: &RecordSeries) -> Option<Shared> {
        let mut each: Vec<(usize, f64, f64)> = Vec::new();
        let is_since = |row: &&PeerRecord| !matches!(drift.form, StationForm::DriftSince(from) if row.at < from);
        let mut add = |imu: usize, rows: &[PeerRecord]| {
            let rows: Vec<PeerRecord> = rows.iter().filter(is_since).copied().collect();
            let slope = slope_beside_steps(&rows).filter(|_| rows[0].station != drift.station);
            each.extend(slope.map(|(value, information)| (imu, value, information)));
        };
        for peer in self.peers.iter().filter(|peer| own(drift, &peer.rows).is_some()) {
            for rows in &peer.measured {
                let beside =
                    |row: &PeerRecord| PeerRecord { y: row.y - self.made(row, |part| part.form.is_searched()), ..*row };
                add(peer.imu, &rows.iter().map(beside).collect::<Vec<_>>());
            }
        }
        // All that is taken is out of the gyro's own rows: what is no step is put back.
        let sd = series.unit * series.scatter.of_stated;
        let row = |row: &super::series::Observation| {
            let weight = 1.0 / (row.variance * sd * sd);
            let row = PeerRecord { at: row.at, years: row.years, station: row.station, y: row.y, weight };
            PeerRecord { y: row.y + self.made(&row, |part| !part.form.is_searched()), ..row }
        };
        for other in 0..self.stations {
            let here = series.rows.iter().filter(|row| row.station == other);
            add(usize::MAX, &here.map(row).collect::<Vec<_>>());
        }
        combined(&each)
    }

    /// All parts that are taken but the `k`th.
    pub fn taken_beside(&self, k: usize) -> Vec<(CoursePart, Shared)> {
        let mut others = self.taken.clone();
        others.remove(k);
        others
    }

    /// What some of the parts that are taken have made of a row.
    fn made(&self, row: &PeerRecord, of: impl Fn(&CoursePart) -> bool) -> f64 {
        let taken = self.taken.iter().filter(|(part, _)| of(part));
        taken.map(|(part, common)| common.value * part.at(row.station, row.at, row.years)).sum()
    }

    /// Those that have been at a station.
    fn at(&self, station: usize) -> impl Iterator<Item = &Peer> {
        self.peers.iter().filter(move |peer| peer.measured.iter().any(|rows| rows[0].station == station))
    }

    /// How many IMUs have been at a station.
    pub fn imus_at(&self, station: usize) -> usize {
        self.at(station).map(|peer| peer.imu).collect::<BTreeSet<usize>>().len()
    }

    /// Means of the records of every gyro at every station.
    pub fn cells(&self) -> Vec<StationCell> {
        let mut cells: Vec<StationCell> = Vec::new();
        for (gyro, peer) in self.peers.iter().enumerate() {
            for station in 0..self.stations {
                let here = peer.rows.iter().filter(|row| row.station == station);
                let (weight, sum) = here.fold((0.0, 0.0), |(w, sum), row| (w + row.weight, sum + row.weight * row.y));
                if weight > 0.0 {
                    cells.push(StationCell { gyro, imu: peer.imu, station, mean: sum / weight, weight });
                }
            }
        }
        cells
    }

    /// First and last instant of every IMU at a station.
    pub fn stays_at(&self, station: usize) -> Vec<[UtcMicros; 2]> {
        let mut stays: BTreeMap<usize, [UtcMicros; 2]> = BTreeMap::new();
        for peer in &self.peers {
            for row in peer.rows.iter().filter(|row| row.station == station) {
                let stay = stays.entry(peer.imu).or_insert([row.at; 2]);
                *stay = [stay[0].min(row.at), stay[1].max(row.at)];
            }
        }
        stays.into_values().collect()
    }

    /// What each gyro says of a station's offset against its others.
    pub fn offsets_of_gyros(&self, station: usize) -> Vec<OffsetOfGyro> {
        let part = CoursePart { station, form: StationForm::Offset };
        let of = |peer: &Peer| {
            let (value, information) = own(&part, &peer.rows)?;
            let mut others = vec![0.0; self.stations];
            let elsewhere = peer.rows.iter().filter(|row| row.station != station);
            elsewhere.for_each(|row| others[row.station] += row.weight);
            let whole: f64 = others.iter().sum();
            let shares = others.iter().map(|weight| (weight / whole).powi(2)).sum();
            Some(OffsetOfGyro { value, information, shares })
        };
        self.at(station).filter_map(of).collect()
    }

    /// What the peers read at a station about their levels, in so many bins of records.
    pub fn course_of(&self, station: usize, bins: usize) -> Vec<CoursePoint> {
        let rows = self.rows_at(station);
        let size = rows.len().div_ceil(bins).max(1);
        let point = |some: &[(usize, &PeerRecord)]| {
            let each: Vec<(usize, f64, f64)> = some.iter().map(|(imu, row)| (*imu, row.y, row.weight)).collect();
            let common = combined(&each)?;
            let middle = some[some.len() / 2].1.at;
            Some(CoursePoint { at: middle, value: common.value, sd: common.sd, records: some.len() })
        };
        rows.chunks(size).filter_map(point).collect()
    }

    /// What the peers say of a part beside what is taken; none where no peer can tell.
    pub fn estimate(&self, part: &CoursePart) -> Option<Shared> {
        let each: Vec<(usize, f64, f64)> = self
            .at(part.station)
            .filter_map(|peer| own(part, &peer.rows).map(|(b, info)| (peer.imu, b, info)))
            .collect();
        combined(&each)
    }

    /// Takes the parts that the peers show and `is_borne_out` does not object to, which is also told what is taken, and
    /// of whom.
    /// `reference` is the station that offsets count from. Where several stations drift, a step of one may come first,
    /// which follows the drift of another: the drifts together are another beginning, and what explains more is kept.
    pub fn take(
        &mut self,
        reference: usize,
        is_borne_out: impl Fn(&CoursePart, &Shared, &[(CoursePart, Shared)], &Self) -> bool,
    ) {
        self.take_what_explains_most(reference, is_borne_out);
        self.widen();
    }

    fn take_what_explains_most(
        &mut self,
        reference: usize,
        is_borne_out: impl Fn(&CoursePart, &Shared, &[(CoursePart, Shared)], &Self) -> bool,
    ) {
        let mut drifting = self.clone();
        self.take_one_by_one(reference, &is_borne_out);
        if self.taken.iter().all(|(part, _)| part.form == StationForm::Offset) {
            return;
        }
        drifting.take_drifts();
        let is_told = |(k, (part, common)): (usize, &(CoursePart, Shared))| {
            drifting.is_shared(part, common) && is_borne_out(part, common, &drifting.taken_beside(k), &drifting)
        };
        if drifting.taken.len() < 2 || !drifting.taken.iter().enumerate().all(is_told) {
            return;
        }
        drifting.take_one_by_one(reference, &is_borne_out);
        if drifting.cost() < self.cost() {
            *self = drifting;
        }
    }

    /// The drifts of all stations that are significant beside one another.
    fn take_drifts(&mut self) {
        for station in 0..self.stations {
            let part = CoursePart { station, form: StationForm::Drift };
            if let Some(common) = self.estimate(&part) {
                self.subtract(&part, common.value);
                self.taken.push((part, common));
            }
        }
        while self.taken.len() > 1 {
            self.settle();
            let least = (0..self.taken.len())
                .min_by(|a, b| self.taken[*a].1.significance().total_cmp(&self.taken[*b].1.significance()));
            let Some(least) = least.filter(|k| self.taken.len() > MOST_PARTS || !is_taken(&self.taken[*k])) else {
                break;
            };
            let (part, common) = self.taken.remove(least);
            self.subtract(&part, -common.value);
        }
    }

    /// What is left of the records about the gyros' levels, in squares of their standard deviations, and what the parts
    /// would gain by chance.
    fn cost(&self) -> f64 {
        let of_peer = |peer: &Peer| -> f64 {
            let rows = about_their_mean(peer.rows.clone());
            rows.iter().map(|row| (row.y * row.y * row.weight).min(CLIPPED * CLIPPED)).sum()
        };
        let left: f64 = self.peers.iter().map(of_peer).sum();
        left + self.taken.iter().map(|(part, _)| by_chance(part.form) + TAKEN).sum::<f64>()
    }

    fn take_one_by_one(
        &mut self,
        reference: usize,
        is_borne_out: &impl Fn(&CoursePart, &Shared, &[(CoursePart, Shared)], &Self) -> bool,
    ) {
        let mut refused: Vec<CoursePart> = Vec::new();
        // Where a drift or a step is refused, instants are found that follow it for a while.
        let mut not_searched: Vec<usize> = Vec::new();
        for _ in 0..2 * MOST_PARTS {
            let known = |part: &CoursePart| {
                let is_not = part.form.is_searched() && not_searched.contains(&part.station);
                is_not || self.taken.iter().any(|(taken, _)| taken == part) || refused.contains(part)
            };
            let candidates: Vec<CoursePart> =
                self.candidates(reference).into_iter().filter(|part| !known(part)).collect();
            let best = candidates
                .into_iter()
                .filter_map(|part| Some((part, self.estimate(&part)?)))
                .filter(is_taken)
                .max_by(|a, b| rated(a).total_cmp(&rated(b)));
            let Some((part, common)) = best.filter(|_| self.taken.len() < MOST_PARTS) else { break };
            let (part, common) = self.refined(part, common);
            if !self.is_shared(&part, &common) || !is_borne_out(&part, &common, &self.taken, self) {
                refused.push(part);
                if !matches!(part.form, StationForm::Offset | StationForm::Between(..)) {
                    not_searched.push(part.station);
                }
                continue;
            }
            self.subtract(&part, common.value);
            self.taken.push((part, common));
            refused.extend(self.estimate_again());
        }
    }

    /// Whether it is what the gyros share: they do not differ in it as those that age each by itself do, and it is not
    /// what they do at other stations as well. They may differ in an offset: gyro x station.
    fn is_shared(&self, part: &CoursePart, common: &Shared) -> bool {
        part.form == StationForm::Offset
            || common.value.abs() > ALIKE * common.between && !self.is_everywhere(part, common)
    }

    /// Whether the gyros that a station's part was seen in do the same wherever they are: then it is theirs. What the
    /// station does beside that shows in those that were elsewhere too, beside each one's own level, slope and part and
    /// an offset of the station, and is nothing.
    fn is_everywhere(&self, part: &CoursePart, common: &Shared) -> bool {
        let parts = [StationForm::Offset, part.form].map(|form| CoursePart { form, ..*part });
        let mut whole = NormalEquations::new(2);
        let mut of_imus: BTreeMap<usize, NormalEquations> = BTreeMap::new();
        let (mut squares, mut freedom) = (0.0, -2.0);
        for peer in &self.peers {
            let rows: Vec<&PeerRecord> = peer.measured.iter().flatten().collect();
            let white = |of: &dyn Fn(&PeerRecord) -> f64| -> Vec<f64> {
                rows.iter().map(|row| of(row) * row.weight.sqrt()).collect()
            };
            let slopes = [white(&|row| row.years), white(&|row| part.form.at(row.at, row.years))];
            let own = Basis::of([white(&|_| 1.0)].into_iter().chain(slopes));
            let beside = |of: &dyn Fn(&PeerRecord) -> f64| {
                let mut column = white(of);
                own.project_out(&mut column);
                column
            };
            let columns = parts.map(|one| beside(&|row| one.at(row.station, row.at, row.years)));
            let left = beside(&|row| row.y - self.made(row, |other| other != part));
            let told = NormalEquations::of_columns(&columns, &left);
            squares += dot(&left, &left);
            freedom += (rows.len() - own.rank()) as f64;
            whole.matrix += &told.matrix;
            whole.right += &told.right;
            let of_imu = of_imus.entry(peer.imu).or_insert_with(|| NormalEquations::new(2));
            of_imu.matrix += told.matrix;
            of_imu.right += told.right;
        }
        let Some(Solution { estimate, covariance }) = whole.solve() else { return false };
        let excess = ((squares - estimate.dot(&whole.right)) / freedom.max(1.0)).max(1.0);
        let pull = |of_imu: &NormalEquations| (&covariance * (&of_imu.right - &of_imu.matrix * &estimate))[1].powi(2);
        let sandwich: f64 = of_imus.values().map(pull).sum();
        let (value, sd) = (estimate[1], (excess * covariance[(1, 1)]).max(sandwich).sqrt());
        value.abs() < NOTHING * sd && (value - common.value).abs() > NOTHING * sd.hypot(common.sd)
    }

    /// The last record of a peer at a station before an instant.
    pub fn before(&self, station: usize, at: UtcMicros) -> Option<UtcMicros> {
        self.instants(station).into_iter().rfind(|instant| *instant < at)
    }

    fn candidates(&self, reference: usize) -> Vec<CoursePart> {
        let mut all = Vec::new();
        for station in 0..self.stations {
            if station != reference {
                all.push(CoursePart { station, form: StationForm::Offset });
            }
            all.push(CoursePart { station, form: StationForm::Drift });
            let instants = self.instants(station);
            let every = instants.len().div_ceil(INSTANTS).max(1);
            // Near the ends of its records a step is an offset.
            let edge = instants.len() / 16 + 1;
            let inner = instants.iter().skip(edge).take(instants.len().saturating_sub(2 * edge));
            let since = inner.step_by(every).flat_map(|at| [StationForm::Step(*at), StationForm::DriftSince(*at)]);
            all.extend(since.chain(self.windows(station)).map(|form| CoursePart { station, form }));
        }
        all
    }

    fn instants(&self, station: usize) -> Vec<UtcMicros> {
        let mut instants: Vec<UtcMicros> = self.rows_at(station).into_iter().map(|(_, row)| row.at).collect();
        instants.dedup();
        instants
    }

    /// The records at a station in the order of time, each with its IMU.
    fn rows_at(&self, station: usize) -> Vec<(usize, &PeerRecord)> {
        let rows = self.at(station).flat_map(|peer| peer.rows.iter().map(move |row| (peer.imu, row)));
        let mut rows: Vec<(usize, &PeerRecord)> = rows.filter(|(_, row)| row.station == station).collect();
        rows.sort_by_key(|(_, row)| row.at);
        rows
    }

    /// Of each length the window in which the records at a station are furthest off together; none that begins with the
    /// first record or ends with the last, which are steps.
    fn windows(&self, station: usize) -> impl Iterator<Item = StationForm> {
        let rows: Vec<&PeerRecord> = self.rows_at(station).into_iter().map(|(_, row)| row).collect();
        // Each record's estimate times its weight, and the weight.
        let terms: Vec<[f64; 2]> = (rows.iter())
            .map(|row| [(row.y * row.weight.sqrt()).clamp(-CLIPPED, CLIPPED) * row.weight.sqrt(), row.weight])
            .collect();
        WINDOWS.into_iter().filter_map(move |days| {
            let (mut end, mut sums) = (0, [0.0; 2]);
            let mut best: Option<(f64, StationForm)> = None;
            for start in 0..rows.len() {
                while end < rows.len() && rows[end].at.days_since(rows[start].at) < days {
                    (sums[0], sums[1]) = (sums[0] + terms[end][0], sums[1] + terms[end][1]);
                    end += 1;
                }
                let is_inner = start > 0 && end < rows.len() && rows[start - 1].at < rows[start].at;
                let rated = sums[0] * sums[0] / sums[1];
                if is_inner && best.as_ref().is_none_or(|(most, _)| rated > *most) {
                    best = Some((rated, StationForm::Between(rows[start].at, rows[end].at)));
                }
                (sums[0], sums[1]) = (sums[0] - terms[start][0], sums[1] - terms[start][1]);
            }
            best.map(|(_, form)| form)
        })
    }

    /// The best instants of a step or a window among those about its own.
    fn refined(&self, part: CoursePart, common: Shared) -> (CoursePart, Shared) {
        let instants = self.instants(part.station);
        let reach = instants.len().div_ceil(INSTANTS).max(1);
        match part.form {
            StationForm::Offset | StationForm::Drift => (part, common),
            StationForm::Step(at) => self.best_about(&instants, at, reach, (part, common), StationForm::Step),
            StationForm::DriftSince(at) => {
                self.best_about(&instants, at, reach, (part, common), StationForm::DriftSince)
            }
            StationForm::Between(from, until) => {
                let found =
                    self.best_about(&instants, from, reach, (part, common), |at| StationForm::Between(at, until));
                let StationForm::Between(from, _) = found.0.form else { return found };
                let found = self.best_about(&instants, until, reach, found, |at| StationForm::Between(from, at));
                // A window up to the newest records may be a step that has not ended: the gyro's own may be newer.
                let StationForm::Between(from, _) = found.0.form else { return found };
                let lasting = CoursePart { form: StationForm::Step(from), ..found.0 };
                self.estimate(&lasting).filter(|step| step.gain >= found.1.gain).map_or(found, |step| (lasting, step))
            }
        }
    }

    /// The best of a part's forms, one for each instant, from `reach` instants before one to as many after it: in strides,
    /// then about the best in shorter ones.
    fn best_about(
        &self,
        instants: &[UtcMicros],
        at: UtcMicros,
        reach: usize,
        found: (CoursePart, Shared),
        form: impl Fn(UtcMicros) -> StationForm,
    ) -> (CoursePart, Shared) {
        let (mut best, mut k) = (found, instants.partition_point(|instant| *instant < at));
        let mut stride = reach.div_ceil(ABOUT);
        loop {
            let first = k.saturating_sub(ABOUT * stride).max(1);
            let about = (first..instants.len().min(k + ABOUT * stride + 1)).step_by(stride);
            for place in about {
                let part = CoursePart { form: form(instants[place]), ..best.0 };
                let Some(common) = self.estimate(&part) else { continue };
                if common.gain > best.1.gain {
                    (best, k) = ((part, common), place);
                }
            }
            if stride == 1 {
                return best;
            }
            stride = stride.div_ceil(ABOUT);
        }
    }

    /// Takes `value` times a station's part off every peer's records.
    pub fn subtract(&mut self, part: &CoursePart, value: f64) {
        for row in self.peers.iter_mut().flat_map(|peer| &mut peer.rows) {
            row.y -= value * part.at(row.station, row.at, row.years);
        }
    }

    /// Each part was estimated as though the others were known: their uncertainty widens its own, sqrt(N_kk (N^-1)_kk), N
    /// the normal matrix of all beside the peers' levels.
    fn widen(&mut self) {
        let parts: Vec<CoursePart> = self.taken.iter().map(|(part, _)| *part).collect();
        if parts.len() < 2 {
            return;
        }
        let mut normal = NormalEquations::new(parts.len());
        for peer in &self.peers {
            let level = Basis::of([peer.rows.iter().map(|row| row.weight.sqrt()).collect::<Vec<_>>()]);
            let column = |part: &CoursePart| {
                let of = |row: &PeerRecord| row.weight.sqrt() * part.at(row.station, row.at, row.years);
                let mut column: Vec<f64> = peer.rows.iter().map(of).collect();
                level.project_out(&mut column);
                column
            };
            let columns: Vec<Vec<f64>> = parts.iter().map(column).collect();
            normal.matrix += gram(&columns);
        }
        let Some(beside) = normal.solve_beyond(&normal.matrix.diagonal(), 0.0) else { return };
        for (k, (_, common)) in self.taken.iter_mut().enumerate() {
            common.sd *= (normal.matrix[(k, k)] * beside.covariance[(k, k)]).max(1.0).sqrt();
        }
    }

    fn settle(&mut self) {
        for _ in 0..ROUNDS {
            if self.estimate_once() < SETTLED {
                break;
            }
        }
    }

    /// The largest change of a part, in its standard deviations.
    fn estimate_once(&mut self) -> f64 {
        let mut largest = 0.0_f64;
        for k in 0..self.taken.len() {
            let (part, old) = self.taken[k];
            self.subtract(&part, -old.value);
            let new = self.estimate(&part).unwrap_or(old);
            let (part, new) = self.refined(part, new);
            self.subtract(&part, new.value);
            largest = largest.max((new.value - old.value).abs() / new.sd.max(f64::MIN_POSITIVE));
            self.taken[k] = (part, new);
        }
        largest
    }

    /// Each part again, beside the others, which were not there when its instants were found. What is significant no
    /// more is given up, and answered.
    fn estimate_again(&mut self) -> Vec<CoursePart> {
        self.settle();
        let mut given_up = Vec::new();
        while let Some(k) = self.taken.iter().position(|(part, common)| common.significance() < 0.8 * threshold(part)) {
            let (part, common) = self.taken.remove(k);
            self.subtract(&part, -common.value);
            given_up.push(part);
        }
        given_up
    }
}

/// Records of peers that stand apart from those before and after them at their station, where the records of other IMUs
/// that are next to them there do not: they are no doing of the station.
fn blunders(peers: &[&GyroHistory], column: usize) -> HashSet<(usize, UtcMicros)> {
    // Of each station when which IMU was there, and of which gyro a record stands apart.
    let mut there: BTreeMap<&str, BTreeMap<(UtcMicros, &str), Vec<usize>>> = BTreeMap::new();
    for (number, peer) in peers.iter().enumerate() {
        let mut of_station: BTreeMap<&str, Vec<HistoryEntry>> = BTreeMap::new();
        for entry in &peer.entries {
            of_station.entry(&entry.station).or_default().push(entry.clone());
            there.entry(&entry.station).or_default().entry((entry.at, &entry.imu)).or_default();
        }
        for (station, entries) in of_station {
            let apart: HashSet<UtcMicros> = RecordSeries::of(&entries, column)
                .take_outliers(|_| false)
                .into_iter()
                .map(|outlier| outlier.at)
                .collect();
            let visits = there.entry(station).or_default();
            for entry in peer.entries.iter().filter(|entry| *entry.station == *station && apart.contains(&entry.at)) {
                visits.entry((entry.at, &entry.imu)).or_default().push(number);
            }
        }
    }
    let mut found = HashSet::new();
    for visits in there.values() {
        let is_alone = |(at, imu): (UtcMicros, &str)| {
            let before = visits.range(..(at, imu)).rfind(|((_, other), _)| *other != imu);
            let after = visits.range((at, imu)..).find(|((_, other), _)| *other != imu);
            let mut beside = before.into_iter().chain(after).peekable();
            beside.peek().is_some() && beside.all(|(_, apart)| apart.is_empty())
        };
        for ((at, _), gyros) in visits.iter().filter(|(visit, gyros)| !gyros.is_empty() && is_alone(**visit)) {
            found.extend(gyros.iter().map(|gyro| (*gyro, *at)));
        }
    }
    found
}

/// Whether the gyro's own estimate lets the part be taken out of its records: beside one IMU it must agree, and beside
/// more it must not be nothing where they show something.
pub(super) fn is_borne_out(common: &Shared, own: Option<(f64, f64)>) -> bool {
    let Some((value, sd)) = own else { return common.imus > 1 };
    let apart = (value - common.value).abs() / sd.hypot(common.sd);
    let is_nothing = value.abs() < AGREES * sd;
    match common.imus {
        0 | 1 => !is_nothing && apart < AGREES,
        2 => !is_nothing || apart < AGREES,
        _ => !is_nothing || apart < DENIES,
    }
}

/// The gain of a part, less what the best of many gains by chance.
fn rated((part, common): &(CoursePart, Shared)) -> f64 {
    common.gain - by_chance(part.form)
}

fn by_chance(form: StationForm) -> f64 {
    match form {
        StationForm::Offset | StationForm::Drift => 0.0,
        StationForm::DriftSince(_) | StationForm::Step(_) => SEARCHED,
        StationForm::Between(..) => SEARCHED_WINDOWS,
    }
}

fn is_taken((part, common): &(CoursePart, Shared)) -> bool {
    common.significance() > threshold(part)
}

fn threshold(part: &CoursePart) -> f64 {
    if part.form.is_searched() { TAKEN_SEARCHED } else { TAKEN }
}

fn about_their_mean(mut rows: Vec<PeerRecord>) -> Vec<PeerRecord> {
    let weight: f64 = rows.iter().map(|row| row.weight).sum();
    let mean = rows.iter().map(|row| row.weight * row.y).sum::<f64>() / weight;
    rows.iter_mut().for_each(|row| row.y -= mean);
    rows
}

/// One peer's estimate beside its own level, and 1/variance.
fn own(part: &CoursePart, rows: &[PeerRecord]) -> Option<(f64, f64)> {
    let (mut with, mut without) = (0, 0);
    let is_searched = part.form.is_searched();
    let found = beside_level(rows.iter().map(|row| {
        let c = part.at(row.station, row.at, row.years);
        with += usize::from(c != 0.0);
        // A step shows at the station itself; against others it is an offset.
        without += usize::from(c == 0.0 && (!is_searched || row.station == part.station));
        (row.weight, c, row.y)
    }));
    let few = match part.form {
        StationForm::Drift => with < 3,
        StationForm::DriftSince(_) => with < 3 || without < 1,
        _ => with < 1 || without < 1,
    };
    found.filter(|_| !few)
}

/// b of y = level + b c by weighted least squares, and 1/variance, from (weight, c, y); none where c is all but constant.
pub(super) fn beside_level(rows: impl Iterator<Item = (f64, f64, f64)>) -> Option<(f64, f64)> {
    let [mut w, mut wc, mut wcc, mut wy, mut wcy] = [0.0; 5];
    for (weight, c, y) in rows {
        w += weight;
        wc += weight * c;
        wcc += weight * c * c;
        wy += weight * y;
        wcy += weight * c * y;
    }
    let information = wcc - wc * wc / w;
    (information > 1e-9 * wcc).then(|| ((wcy - wc * wy / w) / information, information))
}

/// The slope of rows of one station, a year, and one over its variance: beside the level, and beside steps that are
/// significant beside level and slope.
fn slope_beside_steps(rows: &[PeerRecord]) -> Option<(f64, f64)> {
    if rows.len() < 3 {
        return None;
    }
    let white =
        |of: &dyn Fn(&PeerRecord) -> f64| -> Vec<f64> { rows.iter().map(|row| of(row) * row.weight.sqrt()).collect() };
    let (years, y) = (white(&|row| row.years), white(&|row| row.y));
    let step = |k: usize| white(&|row| f64::from(row.at >= rows[k].at));
    let mut named = Basis::of([white(&|_| 1.0)]);
    for _ in 0..MOST_STEPS {
        let (mut with_slope, mut left) = (named.clone(), y.clone());
        with_slope.push(years.clone());
        with_slope.project_out(&mut left);
        let gain = |k: usize| {
            let (mut column, whole) = (step(k), rows[k..].iter().map(|row| row.weight).sum::<f64>());
            with_slope.project_out(&mut column);
            let information = dot(&column, &column);
            if information > 1e-9 * whole { dot(&column, &left).powi(2) / information } else { 0.0 }
        };
        // One record by itself is no step.
        let best = (2..rows.len() - 1).map(|k| (gain(k), k)).max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, k)) = best.filter(|(gain, _)| *gain > STEPS * STEPS) else { break };
        named.push(step(k));
    }
    let (mut column, mut left) = (years, y);
    let before = dot(&column, &column);
    named.project_out(&mut column);
    named.project_out(&mut left);
    let information = dot(&column, &column);
    (information > 1e-9 * before).then(|| (dot(&column, &left) / information, information))
}

/// The robust mean of estimates (IMU, estimate, 1/variance).
fn combined(each: &[(usize, f64, f64)]) -> Option<Shared> {
    if each.is_empty() {
        return None;
    }
    let mut sorted: Vec<(f64, f64)> = each.iter().map(|&(_, b, info)| (b, info)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * sorted.iter().map(|one| one.1).sum::<f64>();
    let mut below = 0.0;
    let mut value = sorted[0].0;
    for (b, info) in &sorted {
        value = *b;
        below += info;
        if below >= half {
            break;
        }
    }
    let pull = upper_median_of(each.iter().map(|(_, b, info)| (b - value).abs() * info.sqrt()))?;
    let excess = if each.len() < 3 { 1.0 } else { (SD_OF_MEDIAN * pull).max(1.0) };
    let count = each.len() as f64;
    let least = excess / (1.645 * OF_SCALE / count.sqrt()).exp();
    let weigh = |value: f64, b: f64, info: f64| {
        let pull = (b - value).abs() * info.sqrt() / excess;
        info * if pull > HUBER { HUBER / pull } else { 1.0 }
    };
    for _ in 0..8 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for &(_, b, info) in each {
            let w = weigh(value, b, info);
            sum += w * b;
            weights += w;
        }
        value = sum / weights;
    }
    let mut by_imu: Vec<(usize, f64)> = Vec::new();
    let mut weights = 0.0;
    for &(imu, b, info) in each {
        let w = weigh(value, b, info);
        weights += w;
        match by_imu.iter_mut().find(|(known, _)| *known == imu) {
            Some((_, sum)) => *sum += w * (b - value),
            None => by_imu.push((imu, w * (b - value))),
        }
    }
    let imus = by_imu.len();
    let noise = excess * excess / weights;
    let sandwich = by_imu.iter().map(|(_, sum)| sum * sum).sum::<f64>() / (weights * weights);
    let sandwich = if imus > 2 { sandwich * imus as f64 / (imus - 1) as f64 } else { 2.0 * sandwich };
    Some(Shared {
        value,
        sd: noise.max(sandwich).sqrt(),
        gyros: each.len(),
        imus,
        between: ((least * least - 1.0).max(0.0) / (2.0 * half) * count).sqrt(),
        gain: each.iter().map(|&(_, b, info)| weigh(value, b, info) * (b * b - (b - value).powi(2))).sum(),
    })
}
