//! The columns that may explain a history, each tied to something that was recorded of it.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::core::judge::{Coefficient, Event, Mark};
use crate::core::time::UtcMicros;

use super::answer::{Attribution, ChangeCause, StationForm, YEAR_DAYS};
use super::series::{Observation, RecordSeries};
use super::station::{CoursePart, StationCourse, beside_level};
use super::unlike_window::Unlike;

/// A candidate is only tried where so many records stand on either side of its change.
const FEWEST_ON_A_SIDE: usize = 2;

/// A slope that begins is only tried where so many records come after its beginning.
const FEWEST_OF_A_SLOPE: usize = 4;

/// Other IMUs that were at a station before an instant and after it, from which on they say whether it stepped.
const TELL_A_STEP: usize = 2;

/// Temperatures that vary less than this (standard deviation, K) explain nothing.
const LEAST_TEMPERATURE_SD: f64 = 0.05;

/// Fewest records whose temperature is known.
const FEWEST_TEMPERATURES: usize = 5;

/// One column of regressors and what it stands for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CandidateCause {
    pub cause: ChangeCause,
    pub tie: Attribution,
    pub parameter: &'static str,
    pub unit: &'static str,
    pub column: Vec<f64>,
    /// How many columns of this kind were tried to find the best.
    pub tried: usize,
    /// What the station would have done, where the candidate is its doing.
    pub part: Option<CoursePart>,
    /// Rows of which the regressor is not known, and the variance that it has among the others.
    pub missing: Vec<usize>,
    pub spread: f64,
}

/// Every candidate that the records can tell from a constant. Offsets count from station `reference`; a station steps at
/// instants at which `course` does not say whether it does. `unlike`: when gyros of its stations were off with this one,
/// each in its own direction. They come first: of equals it is the station that many gyros speak against.
pub(super) fn all(
    series: &RecordSeries,
    marks: &[Mark],
    coefficient: Coefficient,
    reference: usize,
    course: &StationCourse,
    unlike: &[(Arc<str>, Unlike)],
) -> Vec<CandidateCause> {
    let mut found: Vec<CandidateCause> =
        unlike.iter().filter_map(|(name, seen)| off_with_others(series, name, seen)).collect();
    found.extend(ageing(series, marks));
    found.extend(steps_at_events(series, marks));
    found.extend(re_mountings(series));
    found.extend(temperature(series));
    found.extend(stations(series, reference, course));
    if coefficient == Coefficient::DO {
        found.extend(clocking(series));
    }
    found.extend(onsets_of_ageing(series));
    found.extend(free_steps(series));
    found.retain(|candidate| {
        let first = candidate.column[0];
        candidate.column.iter().any(|value| *value != first)
    });
    found
}

fn candidate(cause: ChangeCause, tie: Attribution, unit: &'static str, column: Vec<f64>) -> CandidateCause {
    CandidateCause { cause, tie, parameter: "k", unit, column, tried: 1, part: None, missing: Vec::new(), spread: 0.0 }
}

/// One slope, or one before and one after the last repair.
fn ageing(series: &RecordSeries, marks: &[Mark]) -> Vec<CandidateCause> {
    let slope = |tie, column| candidate(ChangeCause::Ageing, tie, "deg/(h*g0)/year", column);
    let is_within = |at| series.rows[0].at < at && series.rows.last().is_some_and(|newest| at <= newest.at);
    let repair = marks.iter().rev().find(|mark| mark.event == Event::Repair && is_within(mark.at));
    let Some(Mark { at, .. }) = repair else { return vec![slope(Attribution::Slope, series.column(|row| row.years))] };
    let years = |row: &Observation| row.at.days_since(*at) / YEAR_DAYS;
    vec![
        slope(Attribution::SlopeUntil(*at), series.column(|row| years(row).min(0.0))),
        slope(Attribution::SlopeAfter(*at), series.column(|row| years(row).max(0.0))),
    ]
}

fn steps_at_events(series: &RecordSeries, marks: &[Mark]) -> Vec<CandidateCause> {
    let mut gaps: BTreeMap<usize, Vec<(Event, UtcMicros)>> = BTreeMap::new();
    for mark in marks.iter().filter(|mark| mark.event.may_move_a_gyro()) {
        gaps.entry(series.rows.partition_point(|row| row.at < mark.at)).or_default().push((mark.event, mark.at));
    }
    let step = |(cut, events): (usize, Vec<(Event, UtcMicros)>)| {
        let column = step_column(series, cut)?;
        Some(candidate(ChangeCause::StepAtEvent, Attribution::Events(events), "deg/(h*g0)", column))
    };
    gaps.into_iter().filter_map(step).collect()
}

fn re_mountings(series: &RecordSeries) -> Vec<CandidateCause> {
    let name = |row: &Observation| format!("{}/{}", row.seat.0, row.seat.1.name());
    (1..series.len())
        .filter(|&k| series.rows[k].seat != series.rows[k - 1].seat)
        .filter_map(|cut| {
            let (from, to) = (name(&series.rows[cut - 1]), name(&series.rows[cut]));
            let tie = Attribution::Moved { from, to, at: series.rows[cut].at };
            step_column(series, cut).map(|column| candidate(ChangeCause::ReMounting, tie, "deg/(h*g0)", column))
        })
        .collect()
}

/// k (T - mean T). Where T is not known the column is zero, and the row's variance grows by k^2 var T.
fn temperature(series: &RecordSeries) -> Option<CandidateCause> {
    let known: Vec<f64> = series.rows.iter().filter_map(|row| row.temperature_c).collect();
    if known.len() < FEWEST_TEMPERATURES {
        return None;
    }
    let mean = known.iter().sum::<f64>() / known.len() as f64;
    let variance = known.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / known.len() as f64;
    let missing: Vec<usize> = (0..series.len()).filter(|k| series.rows[*k].temperature_c.is_none()).collect();
    (variance.sqrt() > LEAST_TEMPERATURE_SD).then(|| {
        let tie = Attribution::Temperature { mean_c: mean, missing: missing.len() };
        let column = series.column(|row| row.temperature_c.map_or(0.0, |t| t - mean));
        CandidateCause { missing, spread: variance, ..candidate(ChangeCause::Temperature, tie, "deg/(h*g0)/K", column) }
    })
}

fn stations(series: &RecordSeries, reference: usize, course: &StationCourse) -> Vec<CandidateCause> {
    let mut found = Vec::new();
    for station in 0..series.stations.len() {
        let there = series.rows.iter().filter(|row| row.station == station).count();
        let elsewhere = series.len() - there;
        if station != reference && there >= FEWEST_ON_A_SIDE && elsewhere >= FEWEST_ON_A_SIDE {
            found.extend(of_station(series, reference, station, StationForm::Offset));
        }
        if there >= 2 * FEWEST_ON_A_SIDE {
            found.extend(of_station(series, reference, station, StationForm::Drift));
        }
        let stays = course.stays_at(station);
        let is_told =
            |at: UtcMicros| stays.iter().filter(|[first, last]| *first < at && at <= *last).count() >= TELL_A_STEP;
        let cuts = (FEWEST_ON_A_SIDE..series.len().saturating_sub(FEWEST_ON_A_SIDE - 1)).map(|k| series.rows[k].at);
        let steps = cuts
            .filter(|at| !is_told(*at))
            .flat_map(|at| of_station(series, reference, station, StationForm::Step(at)));
        found.extend(steps.filter(|step| {
            let after = step.column.iter().filter(|value| **value > 0.0).count();
            (FEWEST_ON_A_SIDE..=there.saturating_sub(FEWEST_ON_A_SIDE)).contains(&after)
        }));
    }
    found
}

fn of_station(series: &RecordSeries, reference: usize, station: usize, form: StationForm) -> Option<CandidateCause> {
    let part = CoursePart { station, form };
    let column = series.column(|row| part.at(row.station, row.at, row.years));
    let tried = if form.is_searched() { series.len() } else { 1 };
    let tie = attribution(series, reference, &part);
    Some(CandidateCause { part: Some(part), tried, ..candidate(ChangeCause::Station, tie, form.unit(), column) })
}

pub(super) fn attribution(series: &RecordSeries, reference: usize, part: &CoursePart) -> Attribution {
    let name = |station: usize| -> Arc<str> { series.stations[station].clone() };
    Attribution::Station { name: name(part.station), against: name(reference), form: part.form }
}

/// Where a station's gyros were off, each in its own direction: from the record on, and up to the one, that fit this
/// gyro best.
fn off_with_others(series: &RecordSeries, name: &Arc<str>, seen: &Unlike) -> Option<CandidateCause> {
    let station = series.stations.binary_search(name).ok()?;
    let here: Vec<UtcMicros> = series.rows.iter().filter(|row| row.station == station).map(|row| row.at).collect();
    let column = |(from, until): (UtcMicros, Option<UtcMicros>)| {
        let is_off = move |row: &Observation| {
            row.station == station && from <= row.at && until.is_none_or(|until| row.at < until)
        };
        series.column(|row| f64::from(is_off(row)))
    };
    let edges = seen.edges(&here);
    let gain = |column: &[f64]| {
        let rows = series.rows.iter().zip(column).map(|(row, c)| (1.0 / row.variance, *c, row.y));
        beside_level(rows).map_or(0.0, |(value, information)| value * value * information)
    };
    let tried = edges.len();
    let all = edges.into_iter().map(|edges| (column(edges), edges));
    let (column, (from, until)) = all.max_by(|a, b| gain(&a.0).total_cmp(&gain(&b.0)))?;
    let tie = Attribution::Unlike { name: name.clone(), seen: *seen, from, until };
    Some(CandidateCause { tried, ..candidate(ChangeCause::Station, tie, "deg/(h*g0)", column) })
}

/// D_O = delta D_S: told from a constant only where D_S moved by clearly more than it is known.
fn clocking(series: &RecordSeries) -> Option<CandidateCause> {
    let n = series.len() as f64;
    let mean = series.rows.iter().map(|row| row.d_s).sum::<f64>() / n;
    let spread = (series.rows.iter().map(|row| (row.d_s - mean).powi(2)).sum::<f64>() / n).sqrt();
    (spread > 5.0 * series.d_s_sd && spread > 1e-9 * mean.abs()).then(|| CandidateCause {
        parameter: "delta",
        ..candidate(ChangeCause::Clocking, Attribution::Proportion, "rad", series.column(|row| row.d_s - mean))
    })
}

/// A slope that begins at a record.
fn onsets_of_ageing(series: &RecordSeries) -> Vec<CandidateCause> {
    let end = series.len().saturating_sub(FEWEST_OF_A_SLOPE);
    let cuts = FEWEST_ON_A_SIDE - 1..end;
    let tried = cuts.len();
    cuts.map(|cut| {
        let began = series.rows[cut].years;
        let column = series.column(|row| (row.years - began).max(0.0));
        CandidateCause {
            tried,
            ..candidate(ChangeCause::Ageing, Attribution::SlopeSince(series.rows[cut].at), "deg/(h*g0)/year", column)
        }
    })
    .collect()
}

fn free_steps(series: &RecordSeries) -> Vec<CandidateCause> {
    let cuts: Vec<(usize, Vec<f64>)> =
        (1..series.len()).filter_map(|cut| Some((cut, step_column(series, cut)?))).collect();
    let tried = cuts.len();
    cuts.into_iter()
        .map(|(cut, column)| {
            let tie = Attribution::Instant { after: series.rows[cut - 1].at, before: series.rows[cut].at };
            CandidateCause { tried, ..candidate(ChangeCause::Step, tie, "deg/(h*g0)", column) }
        })
        .collect()
}

/// 0 before row `cut`, 1 from there on; none where too few rows stand on a side, or where nothing lies between.
fn step_column(series: &RecordSeries, cut: usize) -> Option<Vec<f64>> {
    let n = series.len();
    (cut >= FEWEST_ON_A_SIDE && n - cut.min(n) >= FEWEST_ON_A_SIDE && series.rows[cut].at > series.rows[cut - 1].at)
        .then(|| (0..n).map(|k| f64::from(k >= cut)).collect())
}
