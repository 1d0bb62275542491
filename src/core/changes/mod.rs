//! Why a coefficient changed over months: the question of the diagnosis, asked of a gyro's history instead of a
//! campaign.
//!
//! A history y_k (deg/(h g0)) of one coefficient is a constant, plus what its stations did, plus causes, plus noise.
//! What a history can name:
//!
//! | id | form | what parts it from the others |
//! |---|---|---|
//! | `station` | offset, drift or step of one station | **shared by the gyros of other IMUs that it measured** |
//! | `station` | k between two instants | many of its gyros were off between them, each its own way ([`unlike`]) |
//! | `ageing` | k t, k (t - t0) from an instant t0 on, or a slope of its own after a repair | a slope that goes on across events, stations and temperatures |
//! | `step_at_event` | k after one recorded event | the instant is known beforehand |
//! | `re_mounting` | k after the gyro changed IMU or slot | as above; in D_O it is the clocking of S about I |
//! | `temperature` | k (T - mean T) | follows the recorded temperature |
//! | `clocking` | D_O = delta D_S | D_O moves in proportion to D_S; parts from D_O proper only where D_S changes |
//! | `step` | k after an instant that no event explains | none of the above |
//!
//! First the stations: what the gyros of other IMUs share there ([`station`]) is taken out with its uncertainty, and
//! the gyro is judged by what is left. Where nobody else was at a station its doing cannot be told from the gyro's, and
//! the answer is a class. Each candidate then competes with those that are named and with noise that remembers
//! ([`noise`]): a coefficient that wanders ages and steps by chance. The significance is corrected for all that was
//! tried (Bonferroni over candidates and instants), the gain is measured on blocks of time that were left out.

mod answer;
mod candidates;
mod closure;
mod due;
mod fitted_rows;
mod noise;
mod offsets;
mod pairs;
mod reproducibility;
mod search;
mod series;
mod station;
mod station_scatter;
mod unlike;
mod unlike_window;

use crate::core::numerics::median::median_of;
use std::collections::HashSet;
use std::sync::Arc;

use super::judge::{BASELINE_RECORDS, Coefficient};
use super::time::UtcMicros;
use series::RecordSeries;
use station::{CoursePart, StationCourse};

pub use answer::{
    AsOf, CauseEstimate, ChangeCause, DrawnRecord, Due, ExcessScatter, FEWEST_RECORDS, GyroHistory, HistoryDiagnosis,
    HistoryEntry, HistoryHeldOut, HistoryVerdict, NamedCause, Outlier, RandomVariation, Rejected, StationForm,
};
pub use due::DriftBudget;
pub use noise::Process;
pub use reproducibility::{FleetStations, Spread, StationColumn, StationFigures, stations};
pub use station::{CoursePoint, Shared};
pub use unlike_window::Unlike;

/// Stated standard deviations of a gyro without peers count for nothing where successive records scatter by so many.
const DISBELIEVED: f64 = 3.0;
/// Days below which records are of one occasion, and tell nothing of time.
const SHORTEST_DAYS: f64 = 1.0;

/// Diagnoses D_I, D_S and D_O of `gyro`. `others` are gyros of the fleet: those of other IMUs tell what a station does
/// to all, those of the same IMU share its record. With `budgets` it is said when a coefficient that ages leaves them.
pub fn diagnose_history(
    gyro: &GyroHistory,
    others: &[&GyroHistory],
    budgets: [Option<DriftBudget>; 3],
) -> Vec<HistoryDiagnosis> {
    let all: Vec<&GyroHistory> = std::iter::once(gyro).chain(others.iter().copied()).collect();
    let uneven = [0, 1, 2].map(|column| station_scatter::of_stations(&all, column));
    if uneven.iter().all(|factors| factors.is_empty()) {
        return of_weighed(gyro, others, budgets);
    }
    let weighed: Vec<GyroHistory> = all.iter().map(|history| station_scatter::weighed(history, &uneven)).collect();
    of_weighed(&weighed[0], &weighed[1..].iter().collect::<Vec<_>>(), budgets)
}

fn of_weighed(gyro: &GyroHistory, others: &[&GyroHistory], budgets: [Option<DriftBudget>; 3]) -> Vec<HistoryDiagnosis> {
    let is_mate = is_mate_of(gyro);
    let (mates, peers): (Vec<&GyroHistory>, Vec<&GyroHistory>) = others.iter().partition(|other| is_mate(other));
    let entries = series::distinct(&gyro.entries);
    let unlike = unlike::beside(gyro, others);
    let of = |(column, coefficient)| {
        diagnose(gyro, &entries, [&mates, &peers], &unlike, coefficient, column, budgets[column])
    };
    [Coefficient::DI, Coefficient::DS, Coefficient::DO].into_iter().enumerate().map(of).collect()
}

/// Whether another gyro was in the same IMU at the same time: it shares the record and tells nothing of the station.
pub fn is_mate_of(gyro: &GyroHistory) -> impl Fn(&GyroHistory) -> bool + use<'_> {
    let seats: HashSet<(UtcMicros, &str)> = gyro.entries.iter().map(|entry| (entry.at, &*entry.imu)).collect();
    move |other| other.entries.iter().any(|entry| seats.contains(&(entry.at, &*entry.imu)))
}

fn diagnose(
    gyro: &GyroHistory,
    entries: &[HistoryEntry],
    [mates, peers]: [&[&GyroHistory]; 2],
    unlike: &[(Arc<str>, Unlike)],
    coefficient: Coefficient,
    column: usize,
    budget: Option<DriftBudget>,
) -> HistoryDiagnosis {
    let mut series = RecordSeries::of(entries, column);
    let mut answer = HistoryDiagnosis {
        coefficient,
        verdict: HistoryVerdict::TooFew,
        records: gyro.entries.len(),
        scatter: series.scatter.absolute,
        spread: series.spread(),
        causes: Vec::new(),
        rejected: Vec::new(),
        outliers: Vec::new(),
        is_of_a_day: false,
        wander: None,
        excess: None,
        remaining_p_value: 1.0,
        due: None,
        course: Vec::new(),
    };
    let span = entries.first().zip(entries.last()).map_or(0.0, |(first, last)| last.at.days_since(first.at));
    answer.is_of_a_day = series.len() >= FEWEST_RECORDS && span < SHORTEST_DAYS;
    if series.len() < FEWEST_RECORDS || answer.is_of_a_day {
        return answer;
    }
    answer.verdict = HistoryVerdict::NoChange;
    if answer.spread <= 1e-12 * series.mean.abs().max(1e-12) {
        return answer;
    }
    let names: Vec<&str> = series.stations.iter().map(|name| &**name).collect();
    let reference = series.reference();
    let mut course = StationCourse::of(peers, &names, series.origin, column);
    course.take(reference, |part, common, taken, course| {
        let part = placed(&series, course, (*part, *common), taken);
        station::is_borne_out(common, own_estimate(&series, &part, taken))
    });
    for k in 0..course.taken.len() {
        course.taken[k].0 = placed(&series, &course, course.taken[k], &course.taken_beside(k));
    }
    let mates = StationCourse::of(mates, &names, series.origin, column);
    for (part, common) in &course.taken {
        for row in &mut series.rows {
            row.y -= common.value * part.at(row.station, row.at, row.years);
        }
    }
    let stations = series.stations.clone();
    let is_told = |row: &series::Observation| {
        unlike.iter().any(|(station, seen)| stations[row.station] == *station && seen.may_hold(row.at))
    };
    answer.outliers = series.take_outliers(is_told);
    series.condense(&gyro.marks);
    let question = search::CauseSearch {
        series: &series,
        marks: &gyro.marks,
        coefficient,
        reference,
        course: &course,
        mates: &mates,
        prior: prior(&series, [&course, &mates], entries, column),
        unlike,
    };
    let Some(found) = question.answer() else { return answer };
    let may_wander = found.named.iter().any(|cause| cause.class.contains(&ChangeCause::Wandering));
    let remains = found.wander.is_some() || may_wander || found.excess.is_some();
    answer.verdict = match (found.named.is_empty(), remains) {
        (true, false) => HistoryVerdict::NoChange,
        (true, true) => HistoryVerdict::Unexplained,
        (false, false) => HistoryVerdict::Explained,
        (false, true) => HistoryVerdict::PartlyExplained,
    };
    let of_station = |budget: &DriftBudget| {
        budget.measured_since.map_or(0.0, |since| baseline_part(&series, &course, entries, since))
    };
    answer.due = budget.and_then(|budget| {
        let since = entries.last()?.at.days_since(series.rows.last()?.at);
        due::due(&found.levels, since, DriftBudget { baseline: budget.baseline - of_station(&budget), ..budget })
    });
    answer.causes = found.named;
    answer.rejected = found.rejected;
    answer.wander = found.wander;
    answer.excess = found.excess;
    answer.remaining_p_value = found.remaining_p_value;
    answer.course = drawn(entries, &answer, column, series.origin);
    answer
}

/// What the stations did to the records that made the baseline: the median, as the baseline is.
fn baseline_part(series: &RecordSeries, course: &StationCourse, entries: &[HistoryEntry], since: UtcMicros) -> f64 {
    let first = entries.iter().filter(|entry| entry.at >= since).take(BASELINE_RECORDS);
    let part = |entry: &HistoryEntry| -> f64 {
        let station = series.stations.binary_search(&entry.station).unwrap_or(0);
        let years = entry.at.days_since(series.origin) / answer::YEAR_DAYS;
        course.taken.iter().map(|(part, common)| common.value * part.at(station, entry.at, years)).sum()
    };
    median_of(first.map(part)).unwrap_or(0.0)
}

/// The scale of the noise as the fleet shows it, or one or two other gyros do; without any, as it is stated.
fn prior(
    series: &RecordSeries,
    [peers, mates]: [&StationCourse; 2],
    entries: &[HistoryEntry],
    column: usize,
) -> fitted_rows::NoisePrior {
    let stated = entries.iter().any(|entry| entry.d[column].sd.is_some_and(|sd| sd > 0.0));
    let of_stated = series.scatter.of_stated;
    let fleet = peers.scatter.filter(|_| peers.gyros() >= 3);
    let few = if peers.gyros() > 0 { peers } else { mates };
    let of_few = 8_f64.min(few.records() as f64 / 4.0);
    let (freedom, sd): (f64, f64) = match fleet {
        Some(fleet) if stated => (40.0, series.unit * fleet.of_stated),
        Some(fleet) => (20.0, fleet.absolute),
        None if few.scatter.is_some() => {
            let scatter = few.scatter.unwrap_or(series.scatter);
            (of_few, if stated { series.unit * scatter.of_stated } else { scatter.absolute })
        }
        None if stated => (4.0, series.unit * if of_stated > DISBELIEVED { of_stated } else { 1.0 }),
        None => (0.0, 0.0),
    };
    // Figures without any noise have that of their rounding.
    let rounding = 1e-9 * (series.mean.abs() + series.spread());
    fitted_rows::NoisePrior { freedom: freedom.max(0.1), variance: sd.max(rounding).powi(2) }
}

/// The records with what is named of them. What stations did stands about its mean, what is explained about the level of
/// the records.
fn drawn(entries: &[HistoryEntry], answer: &HistoryDiagnosis, column: usize, origin: UtcMicros) -> Vec<DrawnRecord> {
    let of = |entry: &HistoryEntry, station: bool| -> f64 {
        let causes = answer.causes.iter().filter(|cause| !station || cause.cause == ChangeCause::Station);
        causes.map(|cause| cause.estimate.value * cause.tie.regressor(entry, origin)).sum()
    };
    let n = entries.len() as f64;
    let station = entries.iter().map(|entry| of(entry, true)).sum::<f64>() / n;
    // An outlier moves the median of what is left by nothing.
    let level = median_of(entries.iter().map(|entry| entry.d[column].value - of(entry, false))).unwrap_or(0.0);
    let one = |entry: &HistoryEntry| DrawnRecord {
        at: entry.at,
        measured: entry.d[column],
        station: of(entry, true) - station,
        explained: level + of(entry, false),
    };
    entries.iter().map(one).collect()
}

/// Where a station's step or window begins and ends is somewhere between two records of peers, and a step may have
/// ended since their newest. Of the gyro's own records there those within it are told by how well they fit.
fn placed(
    series: &RecordSeries,
    course: &StationCourse,
    (mut part, common): (CoursePart, Shared),
    taken: &[(CoursePart, Shared)],
) -> CoursePart {
    use StationForm::{Between, Step};
    let station = part.station;
    // Since the record of a peer before it.
    let up_to = |at: UtcMicros| {
        let before = course.before(station, at);
        let is_there = move |row: &&series::Observation| row.station == station && before < Some(row.at) && row.at < at;
        series.rows.iter().filter(is_there).map(|row| row.at)
    };
    for is_end in [false, true] {
        let others: Vec<StationForm> = match part.form {
            Step(at) if !is_end => up_to(at).map(Step).collect(),
            Step(from) => up_to(UtcMicros(i64::MAX)).map(|at| Between(from, at)).collect(),
            Between(from, until) if !is_end => up_to(from).map(|at| Between(at, until)).collect(),
            Between(from, until) => up_to(until).map(|at| Between(from, at)).collect(),
            _ => continue,
        };
        let misfit = |form: StationForm| misfit(series, (CoursePart { station, form }, common), taken);
        let all = std::iter::once(part.form).chain(others).map(|form| (misfit(form), form));
        if let Some((_, form)) = all.min_by(|a, b| a.0.total_cmp(&b.0)) {
            part.form = form;
        }
    }
    part
}

/// Weighted squares of how what is left of a gyro's records differs from one to the next, beside one part of what the
/// stations do and those that are taken. A gyro that ages or steps by itself hardly alters them.
fn misfit(series: &RecordSeries, one: (CoursePart, Shared), taken: &[(CoursePart, Shared)]) -> f64 {
    let left = |row: &series::Observation| {
        let parts = taken.iter().chain([&one]);
        row.y - parts.map(|(part, common)| common.value * part.at(row.station, row.at, row.years)).sum::<f64>()
    };
    let pairs = series.rows.windows(2);
    pairs.map(|pair| (left(&pair[1]) - left(&pair[0])).powi(2) / (pair[0].variance + pair[1].variance)).sum()
}

/// What the gyro's own records say of a part, beside a level: estimate and standard deviation.
fn own_estimate(series: &RecordSeries, part: &CoursePart, taken: &[(CoursePart, Shared)]) -> Option<(f64, f64)> {
    let rows = series.rows.iter().map(|row| {
        let of = |part: &CoursePart| part.at(row.station, row.at, row.years);
        let known: f64 = taken.iter().map(|(part, common)| common.value * of(part)).sum();
        (1.0 / row.variance, of(part), row.y - known)
    });
    let sd = series.unit * series.scatter.of_stated;
    station::beside_level(rows).map(|(value, information)| (value, sd / information.sqrt()))
}

#[cfg(test)]
mod tests;
