//! Stretches in which the table turned, and what the Earth's rate does in them: known from the log's rate, angles or
//! attitude, else found in the outputs by the rates of the programme.

use nalgebra::{Rotation3, Vector3};

use super::gather::{LogSeries, Role};
use super::units::Quantity;
use crate::core::dwells::intervals::{Interval, Search, find};
use crate::core::dwells::programme::{Position, REST_ARCSEC_S};
use crate::core::dwells::turns;
use crate::core::frames::{Body, Nav, Rotation};
use crate::core::message::{Message, figure, list};
use crate::core::numerics::median::median_of;
use crate::message;

/// A stretch by the log's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurningInterval {
    pub from_s: f64,
    pub to_s: f64,
    /// Turns in it, where their swing was taken out; zero where it was not.
    pub turns: f64,
    /// Rate at which the outputs swing, by the log's clock, arcsec/s.
    pub swings_arcsec_s: f64,
}

/// All stretches, and whether the log itself says that they are turns.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TurningIntervals {
    pub stretches: Vec<TurningInterval>,
    pub known: bool,
    /// Whether the Earth's rate in the outputs shows that rates and times are in their units.
    pub proved: bool,
    /// That they are in another.
    pub other_unit: Option<Message>,
}

/// Part by which rates may be off those in another unit.
const OTHER_UNIT: f64 = 0.05;
/// Rates that no table is told, arcsec/s: a turn would take two hours. Part of a log in which a table stands.
const SLOWEST: f64 = 180.0;
const AT_REST: f64 = 0.2;
/// Blocks of a stretch, at least.
const FEWEST: usize = 8;
/// Turns by whose swing units are known, parts of a turn that are sampled, and how far a swing by another unit turns: at
/// least. A part of a turn, or one, fits whatever drifts.
const TURNS: usize = 3;
const PARTS: f64 = 8.0;
const ROUNDS: f64 = 2.0;

/// Takes the swing of all turns out of the outputs and the force. What was there is kept as [`Role::Raw`].
pub fn take_out(log: &mut LogSeries, min_s: Option<f64>, programme: Option<&[Position]>) -> TurningIntervals {
    spin_of_attitude(log);
    let is_output = |role: &Role| matches!(role, Role::Output(_));
    let outputs: Vec<usize> = (0..log.roles.len()).filter(|&k| is_output(&log.roles[k])).collect();
    let channels: Vec<usize> =
        (0..log.roles.len()).filter(|&k| is_output(&log.roles[k]) || matches!(log.roles[k], Role::Force(_))).collect();
    let (turns, known): (Vec<(Interval, Vec<f64>)>, bool) = match rates(log) {
        Some(rates) => {
            let found = turns::steady_turns(&log.series, &rates);
            (found.into_iter().map(|turn| (turn, turns::angles(&log.series, &rates, turn))).collect(), true)
        }
        None => (by_outputs(log, &outputs, min_s, programme), false),
    };
    for &output in &outputs {
        let Role::Output(k) = log.roles[output] else { continue };
        log.roles.push(Role::Raw(k));
        log.series.tracks.push(log.series.tracks[output].clone());
    }
    let found: Vec<Interval> = turns.iter().map(|(turn, _)| *turn).collect();
    let series = &mut log.series;
    let mut stretches = Vec::new();
    for (turn, angles) in turns {
        let (from_s, to_s) = (series.start_s(turn.from), series.end_s(turn.to));
        let turns = if angles.is_empty() { 0.0 } else { turns::take_out(series, &channels, turn, angles) };
        let swings_arcsec_s = turns * turns::TURN_ARCSEC / (series.time_s[turn.to - 1] - series.time_s[turn.from]);
        stretches.push(TurningInterval { from_s, to_s, turns, swings_arcsec_s });
    }
    let (proved, other_unit) = by_swing(log, &found, programme);
    TurningIntervals { stretches, known, proved, other_unit }
}

/// Whether the outputs swing in turns as the Earth's rate makes them, and the unit of rate or time in which they would.
/// Angles turn as far whatever the unit of time: they tell neither.
fn by_swing(log: &LogSeries, found: &[Interval], programme: Option<&[Position]>) -> (bool, Option<Message>) {
    let series = &log.series;
    let of_angles = [Role::Turn, Role::Spin].into_iter().any(|kind| by_blocks(log, kind).is_some());
    if of_angles && by_blocks(log, Role::Rate).is_none() {
        return (false, None);
    }
    let is_raw = |k: &usize| matches!(log.roles[*k], Role::Raw(_));
    let raw: Vec<usize> = (0..log.roles.len()).filter(is_raw).collect();
    let rates = rates(log);
    let told = |turn: &Interval| match &rates {
        Some(rates) => vec![mean(rates, *turn).norm()],
        None => told(programme.unwrap_or_default()),
    };
    // Turns have the largest outputs.
    let level =
        |turn: &Interval| raw.iter().map(|&k| series.tracks[k].mean_of(turn.from, turn.to).powi(2)).sum::<f64>();
    let mut turns: Vec<Interval> = found.to_vec();
    turns.sort_by(|a, b| level(b).total_cmp(&level(a)));
    let fastest = turns::TURN_ARCSEC / PARTS / series.block_s;
    let at = |turn: &Interval, times: f64| {
        let rates = told(turn).into_iter().map(|rate| rate * times);
        rates.filter(|rate| *rate < fastest).collect::<Vec<f64>>()
    };
    let explains = |times: f64| {
        let sampled = turns.iter().map(|turn| (turn, at(turn, times))).filter(|(_, rates)| !rates.is_empty());
        let asked: Vec<(&Interval, Vec<f64>)> = sampled.take(TURNS).collect();
        let is_explained = |(turn, rates): &(&Interval, Vec<f64>)| {
            let duration_s = series.time_s[turn.to - 1] - series.time_s[turn.from];
            let is_told = (times - 1.0).abs() < OTHER_UNIT;
            let far = |rate: &&f64| is_told || **rate * duration_s >= ROUNDS * turns::TURN_ARCSEC;
            let rates: Vec<f64> = rates.iter().filter(far).copied().collect();
            turns::likeliest(series, &raw, **turn, &rates).is_some()
        };
        asked.len() == TURNS && asked.iter().all(is_explained)
    };
    if explains(1.0) {
        return (true, None);
    }
    let other = |of: Quantity, own: f64| {
        of.units().iter().find(|name| {
            let times = of.unit(name).map_or(0.0, |unit| unit.factor) / own;
            own > 0.0 && (times - 1.0).abs() > OTHER_UNIT && explains(times)
        })
    };
    // The unit of the rate is known by the programme, where there is one.
    let of_rate = if programme.is_some() { None } else { other(Quantity::Rate, log.rate_factor) };
    let rate = of_rate.map(|unit| message!("rate_other_unit", unit = *unit));
    let time = || other(Quantity::Time, log.time_unit_s).map(|unit| message!("time_other_unit", unit = *unit));
    (false, rate.or_else(time))
}

/// Rates of turn of a programme, arcsec/s, each once.
fn told(programme: &[Position]) -> Vec<f64> {
    let mut told: Vec<f64> = programme.iter().map(|p| p.turn_arcsec_s.abs()).filter(|rate| *rate > 0.0).collect();
    told.sort_by(f64::total_cmp);
    told.dedup();
    told
}

fn mean(rates: &[Vector3<f64>], of: Interval) -> Vector3<f64> {
    rates[of.from..of.to].iter().sum::<Vector3<f64>>() / (of.to - of.from) as f64
}

/// That the log's rate is that of the programme, of the table's angles or of the attitude in another unit: all its
/// turns are faster, or slower, by one factor.
pub fn of_other_unit(log: &LogSeries, programme: Option<&[Position]>) -> Option<Message> {
    let rates = by_blocks(log, Role::Rate)?;
    let turns = turns::steady_turns(&log.series, &rates);
    let seen: Vec<f64> = turns.iter().map(|turn| rates[(turn.from + turn.to) / 2].norm()).collect();
    let of_log = || {
        let rates = by_blocks(log, Role::Turn).or_else(|| by_blocks(log, Role::Spin)).unwrap_or_default();
        turns.iter().filter(|turn| turn.to <= rates.len()).map(|turn| mean(&rates, *turn).norm()).collect()
    };
    let told: Vec<f64> = programme.map_or_else(of_log, told);
    let all_at = |times: f64| {
        let is_at = |seen: &f64| told.iter().any(|told| (seen / times / told - 1.0).abs() < OTHER_UNIT);
        !seen.is_empty() && seen.iter().all(is_at)
    };
    let fastest = |rates: &[f64]| rates.iter().copied().fold(0.0, f64::max);
    let times = fastest(&seen) / fastest(&told);
    // Few turns are off by one factor whatever the cause.
    let is_few = programme.is_none() && turns.len() < TURNS;
    if is_few || all_at(1.0) || !all_at(times) {
        return None;
    }
    let is_unit = |name: &&&str| {
        let factor = Quantity::Rate.unit(name).map_or(0.0, |unit| unit.factor);
        factor != log.rate_factor && (factor * times / log.rate_factor - 1.0).abs() < OTHER_UNIT
    };
    let unit = Quantity::Rate.units().iter().find(is_unit)?;
    Some(message!("rate_other_unit", unit = *unit))
}

/// That the column of the rate shows one and the same slow turn wherever the table stands.
pub fn rate_at_rest(log: &LogSeries, programme: Option<&[Position]>) -> Option<Message> {
    let rates = by_blocks(log, Role::Rate)?;
    let is_told = told(programme.unwrap_or_default()).first().is_some_and(|slowest| *slowest < SLOWEST);
    let slow: Vec<&Vector3<f64>> = rates.iter().filter(|rate| rate.norm() < SLOWEST).collect();
    if is_told || (slow.len() as f64) < AT_REST * rates.len() as f64 {
        return None;
    }
    let usual = Vector3::from_fn(|c, _| median_of(slow.iter().map(|rate| rate[c])).unwrap_or(0.0));
    let columns = log.roles.iter().filter(|role| matches!(role, Role::Rate(_))).count();
    let in_degrees = |arcsec: f64| figure(arcsec / 3600.0, 4);
    let shown = list(usual.iter().take(columns).map(|rate| in_degrees(*rate)));
    (usual.norm() >= REST_ARCSEC_S).then(|| message!("rate_at_rest", rates = shown, least = in_degrees(REST_ARCSEC_S)))
}

/// Rate of turn of a stated attitude, East North Up, arcsec/s, as three tracks more.
fn spin_of_attitude(log: &mut LogSeries) {
    let place = |k: usize| log.roles.iter().position(|role| *role == Role::Attitude(k));
    let [Some(w), Some(x), Some(y), Some(z)] = [0, 1, 2, 3].map(place) else { return };
    let series = &log.series;
    let attitude =
        |k: usize| *Rotation::<Nav, Body>::from_attitude([w, x, y, z].map(|c| series.tracks[c].mean[k])).matrix();
    let mut spin = vec![[0.0; 3]];
    for k in 1..series.number.len() {
        let turned = Rotation3::from_matrix_unchecked(attitude(k).transpose() * attitude(k - 1));
        let rate = turned.scaled_axis() / (series.time_s[k] - series.time_s[k - 1]);
        spin.push(rate.map(|c| c.to_degrees() * 3600.0).into());
    }
    let like = series.tracks[w].clone();
    for c in 0..3 {
        log.roles.push(Role::Spin(c));
        let mut track = like.clone();
        track.mean = spin.iter().map(|rate| rate[c]).collect();
        log.series.tracks.push(track);
    }
}

/// Rate of turn by block, in any axes.
fn rates(log: &LogSeries) -> Option<Vec<Vector3<f64>>> {
    let kinds: [fn(usize) -> Role; 3] = [Role::Rate, Role::Turn, Role::Spin];
    kinds.into_iter().find_map(|kind| by_blocks(log, kind))
}

/// The same by one kind of columns.
fn by_blocks(log: &LogSeries, kind: fn(usize) -> Role) -> Option<Vec<Vector3<f64>>> {
    let own: Vec<usize> = (0..3).filter_map(|k| log.roles.iter().position(|role| *role == kind(k))).collect();
    let rate = |k: usize| Vector3::from_fn(|c, _| own.get(c).map_or(0.0, |&place| log.series.tracks[place].mean[k]));
    (!own.is_empty()).then(|| (0..log.series.number.len()).map(rate).collect())
}

/// Stretches in which the outputs change by no more than the Earth's rate can change them, with the angles of the rate
/// that explains how they swing; without angles where they swing by no rate that the table was told.
fn by_outputs(
    log: &LogSeries,
    outputs: &[usize],
    min_s: Option<f64>,
    programme: Option<&[Position]>,
) -> Vec<(Interval, Vec<f64>)> {
    let series = &log.series;
    let told = told(programme.unwrap_or_default());
    let Some(&slowest) = told.first() else { return Vec::new() };
    let search = |room: Vec<f64>| Search { min_s, breaks: log.breaks.clone(), keep_short: true, room };
    let mut own = series.clone();
    let rough = find(&mut own, outputs, &search(turns::room(series, outputs, slowest)));
    let block = |time: f64| series.number.partition_point(|&n| (n as f64 + 0.5) * series.block_s < time);
    let whole = |(from_s, to_s): (f64, f64)| Interval { from: block(from_s), to: block(to_s) };
    let turn = |turn: Interval| (turn, turns::likeliest(series, outputs, turn, &told).unwrap_or_default());
    let spans = rough.intervals.iter().map(|i| whole((own.start_s(i.from), own.end_s(i.to))));
    spans.filter(|i| i.to > i.from + FEWEST).map(turn).collect()
}
