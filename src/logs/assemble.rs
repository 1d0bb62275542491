//! Intervals of a log become dwells of a campaign: what was commanded in each, and what the gyros said.

use nalgebra::Vector3;

use super::error::LogError;
use super::gather::{LogSeries, Role};
use super::map::Map;
use super::programme::{axis, earth_axis};
use super::turning::{self, TurningInterval, TurningIntervals};
use super::units::Counts;
use crate::core::campaign::{Phase, Site};
use crate::core::dwells::averages::{later, noise, settled, standard_error, without_edges};
use crate::core::dwells::blocks::Track;
use crate::core::dwells::explained::{Outputs, Undecided, align_by_outputs, is_another};
use crate::core::dwells::intervals::{Found, Interval, Search, find, is_motion};
use crate::core::dwells::noise::Noise;
use crate::core::dwells::programme::{
    Clock, LoggedInterval, Position, REST_ARCSEC_S, Table, attitude, clock_factor, clock_offset, exchanged,
};
use crate::core::dwells::turns::{TURN_ARCSEC, WHOLE};
use crate::core::frames::{Body, Nav, Rotation, Vector};
use crate::core::message::{Message, Parameter, figure, list, signed, significant, text};
use crate::core::numerics::median::{median_of, upper_median_of};
use crate::core::units::EARTH_RATE_DEG_H;
use crate::message;

/// A dwell with everything that is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Dwell {
    pub commanded: Commanded,
    pub start_s: f64,
    pub duration_s: f64,
    pub temperature_c: Option<f64>,
    pub output: Vec<f64>,
    pub output_sem: Vec<f64>,
}

/// The dwells of a log, and all that was left out.
pub struct Assembled {
    pub dwells: Vec<Dwell>,
    pub remarks: Vec<Message>,
}

/// Share of an interval's blocks at the end of a channel's range above which its mean is worth nothing.
const CLIPPED: f64 = 0.02;
/// Length of the specific force that is gravity in the unit stated.
const GRAVITY: std::ops::Range<f64> = 0.9..1.1;
/// Angle between measured and commanded vertical that is another position, radians (8 deg).
const OFF_COMMANDED: f64 = 0.14;
/// Part of a commanded rate by which the log's own may differ from it.
const OFF_RATE: f64 = 0.2;
/// The same, by how the outputs swing in the turn.
const OTHER_SWING: f64 = 0.1;
/// The same of all turns, so many at the least, and how alike they are then: a clock, or all rates.
const OTHER_FACTOR: f64 = 1e-3;
const FEWEST_TURNS: usize = 6;
const ONE_FACTOR: f64 = 0.5;
/// Turning of gyros that measure rates themselves, where nothing else says that the table turns: arcsec/s (1 deg/s).
pub const TURNING: f64 = 3600.0;
/// Part of a usual dwell from which a turn without dwell is said, and part of it that dwells must cover.
const SHORT_TURN: f64 = 0.3;
const COVERED: f64 = 0.3;
/// Time from sample to sample, length of a log, and of a usual dwell, s, that a campaign has.
const SAMPLE_S: std::ops::Range<f64> = 2e-5..600.0;
const LOG_S: f64 = 28.0 * 86_400.0;
const USUAL_S: f64 = 86_400.0;
/// Time from sample to sample, and length of a usual dwell, s, from which the unit of time is asked about.
const SELDOM_S: f64 = 5.0;
const LONG_S: f64 = 3600.0;
/// Difference of outputs, in standard deviations of white noise, that is none; part of a usual dwell, beyond a usual
/// pause, that hides a dwell.
const ALIKE: f64 = 10.0;
const HIDES: f64 = 0.5;
/// Part of a turn that may be about what is level.
const LEVEL_TURN: f64 = 0.05;
/// Cosine below which two verticals are different orientations (10 deg).
const SAME_UP: f64 = 0.985;

/// One interval on its way to a dwell.
struct Candidate {
    interval: Interval,
    force: Option<Vector3<f64>>,
    seen: LoggedInterval,
    attitude: Option<Rotation<Nav, Body>>,
    position: Option<Position>,
    /// When it began, before anything was cut: what its attitude is of.
    began_s: f64,
    /// Rate of turn about what is level, arcsec/s.
    level_turn: f64,
}

struct Work<'a> {
    map: &'a Map,
    log: &'a LogSeries,
    site: Option<Site>,
    table: Option<Table>,
    turns: TurningIntervals,
    /// Whether noise may be another in each dwell. Of counts whose time is known it is not.
    differs: bool,
    remarks: Vec<Message>,
}

/// Finds the dwells of what was gathered.
pub fn assemble(
    map: &Map,
    log: &mut LogSeries,
    site: Option<Site>,
    programme: Option<&[Position]>,
) -> Result<Assembled, LogError> {
    let is_watched = |role: &Role| matches!(role, Role::Output(_) | Role::Force(_) | Role::Rate(_) | Role::Turn(_));
    let watched: Vec<usize> = (0..log.roles.len()).filter(|&k| is_watched(&log.roles[k])).collect();
    let by_stamps = log.stamps_are_the_counts();
    if by_stamps {
        log.by_own_time();
    }
    let turns = turning::take_out(log, map.min_s, programme);
    let of_unit = turning::of_other_unit(log, programme).or_else(|| turns.other_unit.clone());
    let other_unit = of_unit.or_else(|| turning::rate_at_rest(log, programme));
    let (breaks, keep_short) = (log.breaks.clone(), programme.is_some());
    let search = Search { min_s: map.min_s, breaks, keep_short, room: Vec::new() };
    let found = find(&mut log.series, &watched, &search);
    if !log.is_regular {
        log.by_own_time();
    }
    let differs = !by_stamps && !log.is_regular;
    let mut work = Work { map, log, site, table: table(map)?, turns, differs, remarks: log.remarks.clone() };
    work.assemble(found, programme, other_unit).map_err(|fault| LogError::new("log", fault))
}

pub fn table(map: &Map) -> Result<Option<Table>, LogError> {
    let Some(of) = &map.table else { return Ok(None) };
    let fail = |fault: Message| LogError::new("map", message!("at_map_key", key = "table", fault));
    let (up, north) = (axis(&of.zero_up).map_err(fail)?, axis(&of.zero_north).map_err(fail)?);
    let parallel = || fail(message!("programme_parallel", up = of.zero_up.clone(), north = of.zero_north.clone()));
    let zero = attitude(up, north).ok_or_else(parallel)?;
    Ok(Some(Table { outer: earth_axis(&of.outer).map_err(fail)?, inner: axis(&of.inner).map_err(fail)?, zero }))
}

impl Work<'_> {
    fn track(&self, role: Role) -> Option<&Track> {
        let place = self.log.roles.iter().position(|own| *own == role)?;
        Some(&self.log.series.tracks[place])
    }

    fn mean(&self, role: Role, i: Interval) -> Option<f64> {
        Some(self.track(role)?.mean_of(i.from, i.to))
    }

    fn vector(&self, role: fn(usize) -> Role, i: Interval) -> Option<Vector3<f64>> {
        Some(Vector3::new(self.mean(role(0), i)?, self.mean(role(1), i)?, self.mean(role(2), i)?))
    }

    fn outputs(&self) -> usize {
        self.log.roles.iter().filter(|role| matches!(role, Role::Output(_))).count()
    }

    fn assemble(
        &mut self,
        found: Found,
        programme: Option<&[Position]>,
        other_unit: Option<Message>,
    ) -> Result<Assembled, Message> {
        let span = self.log.series.end_s(self.log.series.number.len()) - self.log.series.start_s(0);
        let (too_short, least) = (found.too_short_s.clone(), figure(found.min_s, 1));
        let lengths = found.intervals.iter().map(|i| self.log.series.end_s(i.to) - self.log.series.start_s(i.from));
        let usual = median_of(lengths).unwrap_or(0.0);
        // Of several logs, without the time between them.
        let logged = self.log.series.number.len() as f64 * self.log.series.block_s;
        if !SAMPLE_S.contains(&self.log.sample_s) || logged > LOG_S || usual > USUAL_S {
            let [step, days, usual] = [self.log.sample_s, logged / 86_400.0, usual].map(|value| significant(value, 3));
            return Err(message!("time_unlikely", step, days, usual));
        }
        if let Some(fault) = other_unit {
            return Err(fault);
        }
        let below_min = |fault: Message| match too_short.last() {
            Some(&longest) => {
                let (count, least, longest) = (too_short.len(), figure(found.min_s, 1), figure(longest, 1));
                message!("intervals_below_min", fault, count, least, longest)
            }
            None => fault,
        };
        if found.intervals.is_empty() {
            return Err(below_min(message!("no_interval", seconds = figure(span, 1), least)));
        }
        self.note(&found, usual);
        let is_proved = self.log.began.is_some() || self.turns.proved;
        if !is_proved && (self.log.sample_s >= SELDOM_S || usual >= LONG_S) {
            let [step, usual] = [self.log.sample_s, usual].map(|value| significant(value, 3));
            self.remarks.push(message!("time_unproved", step, usual));
        }
        let span = |i: &Interval| (self.log.series.start_s(i.from), self.log.series.end_s(i.to));
        let seen: Vec<(f64, f64)> = found.intervals.iter().chain(&found.short).map(span).collect();
        if let [only] = found.intervals[..] {
            let mut outputs = (0..self.outputs()).filter_map(|k| self.track(Role::Output(k)));
            if outputs.any(|track| is_motion(track, only)) {
                return Err(message!("moves", seconds = figure(self.log.series.end_s(only.to), 1)));
            }
        }
        let intervals = self.not_clipped(found.intervals)?;
        let mut candidates: Vec<Candidate> = intervals.into_iter().map(|i| self.candidate(i)).collect();
        self.check_force(&candidates)?;
        let explains = |remark: &&Message| ["intervals_clipped", "counter_reset"].contains(&&*remark.code);
        let clipped = self.remarks.iter().find(explains).cloned();
        let after_clipping = |fault: Message| match clipped {
            Some(clipped) => message!("after_clipping", fault, clipped),
            None => fault,
        };
        self.command(&mut candidates, programme).map_err(|fault| below_min(after_clipping(fault)))?;
        if candidates.len() == 1 {
            return Err(below_min(self.one_interval(&candidates[0])));
        }
        let mut made = self.dwells(candidates)?;
        made.remarks.extend(self.without_dwell(&made.dwells, &seen));
        Ok(made)
    }

    fn note(&mut self, found: &Found, usual: f64) {
        let start = |i: &Interval| text(format_args!("{:.1}", self.log.series.start_s(i.from)));
        if !found.short.is_empty() {
            let starts = list(found.short.iter().take(5).map(start));
            self.remarks.push(message!("intervals_short", count = found.short.len(), starts));
        }
        if let Some(longest) = found.too_short_s.last().filter(|longest| **longest > SHORT_TURN * usual) {
            let (count, least, longest) = (found.too_short_s.len(), figure(found.min_s, 1), figure(*longest, 1));
            self.remarks.push(message!("intervals_too_short", count, least, longest));
        }
        if found.split > 0 {
            self.remarks.push(message!("intervals_split", count = found.split));
        }
    }

    /// Turns that became no dwell: in which nothing was steady, and which were left out.
    fn without_dwell(&self, dwells: &[Dwell], seen: &[(f64, f64)]) -> Vec<Message> {
        let usual = upper_median_of(dwells.iter().map(|d| d.duration_s)).unwrap_or(0.0);
        let made: Vec<(f64, f64)> = dwells.iter().map(|d| (d.start_s, d.start_s + d.duration_s)).collect();
        let shared = |turn: &TurningInterval, of: &[(f64, f64)]| {
            let part = |&(from, to): &(f64, f64)| (to.min(turn.to_s) - from.max(turn.from_s)).max(0.0);
            of.iter().map(part).sum::<f64>() / (turn.to_s - turn.from_s)
        };
        let lost =
            |turn: &&TurningInterval| turn.to_s - turn.from_s >= SHORT_TURN * usual && shared(turn, &made) < COVERED;
        let lost: Vec<&TurningInterval> = self.turns.stretches.iter().filter(lost).collect();
        let (left, unsteady): (Vec<&TurningInterval>, Vec<&TurningInterval>) =
            lost.iter().partition(|turn| shared(turn, seen) >= COVERED);
        let code = if self.turns.known { "turns_unsteady" } else { "swings_unsteady" };
        let say = |(code, turns): (&'static str, Vec<&TurningInterval>)| {
            let spans = turns.iter().map(|turn| text(format_args!("{:.0}–{:.0}", turn.from_s, turn.to_s)));
            let seconds = turns.iter().map(|turn| turn.to_s - turn.from_s).sum::<f64>();
            let mut said =
                message!("turns_left", count = turns.len(), seconds = figure(seconds, 0), spans = list(spans));
            said.code = code.into();
            (!turns.is_empty()).then_some(said)
        };
        [("turns_left", left), (code, unsteady)].into_iter().filter_map(say).collect()
    }

    fn not_clipped(&mut self, intervals: Vec<Interval>) -> Result<Vec<Interval>, Message> {
        let measured = |role: &&Role| matches!(role, Role::Force(_) | Role::Raw(_));
        let roles: Vec<Role> = self.log.roles.iter().filter(measured).copied().collect();
        let clips =
            |i: &Interval| roles.iter().any(|r| self.track(*r).is_some_and(|t| t.clipped(i.from, i.to) > CLIPPED));
        let (clipped, kept): (Vec<_>, Vec<_>) = intervals.into_iter().partition(clips);
        if !clipped.is_empty() {
            let starts = clipped.iter().take(5).map(|i| text(format_args!("{:.1}", self.log.series.start_s(i.from))));
            let clipped = message!("intervals_clipped", count = clipped.len(), starts = list(starts));
            if kept.is_empty() {
                return Err(clipped);
            }
            self.remarks.push(clipped);
        }
        Ok(kept)
    }

    /// What the log says of an interval.
    fn candidate(&self, interval: Interval) -> Candidate {
        let force = self.vector(Role::Force, interval);
        let up = force.and_then(|f| f.try_normalize(0.0));
        let spin = self.spin(interval);
        let mut level_turn = spin.map_or(0.0, |spin| spin.xy().norm());
        let mut turn = match self.vector(Role::Rate, interval) {
            Some(rate) => Some(self.up(up, interval).map_or(rate.norm(), |up| rate.dot(&up))),
            None => self.mean(Role::Rate(0), interval).or(spin.map(|spin| spin.z)),
        };
        let part = self.first_if_turning(interval, turn);
        let mut attitude = match [0, 1, 2, 3].map(|k| self.mean(Role::Attitude(k), part)) {
            [Some(w), Some(x), Some(y), Some(z)] => Some(Rotation::from_attitude([w, x, y, z])),
            _ => None,
        };
        if let (Some(table), Some(angles), Some(rates)) = (self.table, self.angles(interval), self.rates(interval)) {
            attitude = Some(table.attitude(angles.0, angles.1));
            let vertical = table.turn(angles, rates);
            let both = rates.0 * table.outer.normalize() + rates.1 * table.inner_in_nav(angles);
            level_turn = both.xy().norm();
            turn = Some(vertical);
        }
        let began_s = self.log.series.time_s[interval.from];
        let seen = LoggedInterval { up, turn_arcsec_s: turn };
        Candidate { interval, force, seen, attitude, position: None, began_s, level_turn }
    }

    /// What points up in the body: by the accelerometers, else by the stated attitude.
    fn up(&self, force: Option<Vector3<f64>>, interval: Interval) -> Option<Vector3<f64>> {
        let first = Interval { to: interval.from + 1, ..interval };
        let stated = || {
            let [w, x, y, z] = [0, 1, 2, 3].map(|k| self.mean(Role::Attitude(k), first));
            let attitude: Rotation<Nav, Body> = Rotation::from_attitude([w?, x?, y?, z?]);
            Some((attitude * Vector::new(Vector3::z())).0)
        };
        force.or_else(stated)
    }

    /// The first block of an interval in which the table turns; all of one in which it stands.
    fn first_if_turning(&self, interval: Interval, turn: Option<f64>) -> Interval {
        let turns = turn.is_some_and(|turn| turn.abs() >= REST_ARCSEC_S);
        Interval { to: if turns { interval.from + 1 } else { interval.to }, ..interval }
    }

    /// Angles of the table at the start of an interval, where it turns; over all of it, where it stands.
    fn angles(&self, interval: Interval) -> Option<(f64, f64)> {
        let rates = self.rates(interval)?;
        let stands = rates.0.abs().max(rates.1.abs()) < REST_ARCSEC_S;
        let part = Interval { to: if stands { interval.to } else { interval.from + 1 }, ..interval };
        let angle = |k: usize| {
            let (cosine, sine) = (self.mean(Role::Cosine(k), part)?, self.mean(Role::Sine(k), part)?);
            Some(sine.atan2(cosine))
        };
        Some((angle(0)?, angle(1)?))
    }

    /// Rates of the table's axes, arcsec/s: what their angles change by over the interval. The mean of rates from
    /// sample to sample would be too large where stamps jitter.
    fn rates(&self, interval: Interval) -> Option<(f64, f64)> {
        let (first, last) = (interval.from, interval.to - 1);
        let seconds = self.log.series.time_s[last] - self.log.series.time_s[first];
        let rate = |k: usize| {
            let (cosine, sine) = (self.track(Role::Cosine(k))?, self.track(Role::Sine(k))?);
            let angle = |block: usize| sine.mean[block].atan2(cosine.mean[block]);
            let turned = |block: usize| {
                let turned = angle(block) - angle(block - 1);
                turned - std::f64::consts::TAU * (turned / std::f64::consts::TAU).round()
            };
            Some((first + 1..=last).map(turned).sum::<f64>().to_degrees() * 3600.0 / seconds)
        };
        if seconds > 0.0 { Some((rate(0)?, rate(1)?)) } else { None }
    }

    /// Rate of turn of the stated attitude over an interval, East North Up, arcsec/s.
    fn spin(&self, interval: Interval) -> Option<Vector3<f64>> {
        let time = &self.log.series.time_s;
        let tracks = [self.track(Role::Spin(0))?, self.track(Role::Spin(1))?, self.track(Role::Spin(2))?];
        let turned = |track: &Track| {
            (interval.from + 1..interval.to).map(|k| track.mean[k] * (time[k] - time[k - 1])).sum::<f64>()
        };
        let seconds = time[interval.to - 1] - time[interval.from];
        (seconds > 0.0).then(|| Vector3::from(tracks.map(turned)) / seconds)
    }

    /// The specific force must be gravity in the unit that the map states.
    fn check_force(&self, candidates: &[Candidate]) -> Result<(), Message> {
        let mut lengths: Vec<f64> = candidates.iter().filter_map(|c| Some(c.force?.norm())).collect();
        lengths.sort_by(f64::total_cmp);
        let Some(&usual) = lengths.get(lengths.len() / 2) else { return Ok(()) };
        let direction_only = self.map.force.as_ref().is_some_and(|f| f.direction_only);
        if GRAVITY.contains(&usual) {
            let off = lengths.iter().filter(|l| !GRAVITY.contains(l)).count();
            return if off * 4 > lengths.len() && !direction_only {
                Err(message!(
                    "force_varies",
                    least = figure(lengths[0], 3),
                    most = figure(lengths[lengths.len() - 1], 3)
                ))
            } else {
                Ok(())
            };
        }
        let units = [("m/s^2", 9.806_65), ("mg", 1e3), ("g0", 1.0 / 9.806_65), ("cm/s^2", 980.665), ("g0", 1e-3)];
        let likely = units.iter().find(|(_, factor)| GRAVITY.contains(&(usual / factor)));
        Err(match likely {
            Some((unit, _)) => message!("force_other_unit", length = figure(usual, 4), unit = *unit),
            None => message!("force_no_unit", length = figure(usual, 4)),
        })
    }

    /// What the table did in each candidate. Those that nothing is known of are taken out.
    fn command(&mut self, candidates: &mut Vec<Candidate>, programme: Option<&[Position]>) -> Result<(), Message> {
        match programme {
            Some(programme) => self.by_programme(candidates, programme),
            None => self.by_itself(candidates),
        }
    }

    /// What the log itself says that the table did.
    fn by_itself(&mut self, candidates: &mut Vec<Candidate>) -> Result<(), Message> {
        let mut turning = 0;
        let level = |c: &Candidate| {
            let vertical = c.seen.turn_arcsec_s.unwrap_or(0.0);
            c.level_turn >= REST_ARCSEC_S.max(LEVEL_TURN * vertical.abs())
        };
        let before = candidates.len();
        candidates.retain(|c| !level(c));
        if candidates.len() < before {
            self.remarks.push(message!("intervals_tumbling", count = before - candidates.len()));
        }
        candidates.retain(|c| {
            let keeps = c.seen.turn_arcsec_s.is_some() || !self.turns_by_itself(c.interval);
            turning += usize::from(!keeps);
            keeps
        });
        if turning > 0 {
            self.remarks.push(message!("intervals_turning", count = turning));
        }
        for candidate in candidates.iter_mut() {
            let turn = candidate.seen.turn_arcsec_s.filter(|turn| turn.abs() >= REST_ARCSEC_S);
            candidate.position = candidate.attitude.map(|attitude| Position {
                attitude,
                turn_arcsec_s: turn.unwrap_or(0.0),
                start_s: None,
                duration_s: None,
            });
        }
        if candidates.is_empty() {
            return Err(message!("all_turning"));
        }
        let of_output = |remark: &Message| {
            let is_output = |key: &Parameter| matches!(key, Parameter::Text(key) if key == "output");
            ["unit_of_map", "unit_of_map_alone"].contains(&&*remark.code)
                && remark.parameter("key").is_some_and(is_output)
        };
        let by_map = self.remarks.iter().any(of_output);
        let by_itself = candidates.iter().all(|c| c.attitude.is_none());
        if by_map && by_itself && self.log.unit.counts == Counts::Angular {
            self.remarks.push(message!("scale_unproved"));
        }
        Ok(())
    }

    /// Whether gyros that measure rates say that the IMU turns.
    fn turns_by_itself(&self, interval: Interval) -> bool {
        let rates = (0..self.outputs()).filter_map(|k| self.mean(Role::Output(k), interval));
        self.log.unit.counts == Counts::Angular && rates.map(|r| r * r).sum::<f64>().sqrt() > TURNING
    }

    fn by_programme(&mut self, candidates: &mut Vec<Candidate>, programme: &[Position]) -> Result<(), Message> {
        let series = &self.log.series;
        let spans: Vec<(f64, f64)> =
            candidates.iter().map(|c| (series.start_s(c.interval.from), series.end_s(c.interval.to))).collect();
        let seen: Vec<LoggedInterval> = candidates.iter().map(|c| c.seen).collect();
        let clock = clock_offset(&spans, &seen, programme);
        self.remarks.extend(one_clock(clock, &spans, &seen, programme)?);
        if let Some(Clock { offset_s: offset, .. }) = clock {
            let found = self.by_the_clock(&spans, candidates, programme, offset);
            let taken: Vec<usize> = found.iter().map(|(row, _)| *row).collect();
            *candidates = found.into_iter().map(|(_, candidate)| candidate).collect();
            self.remarks.extend(missing(&taken, programme));
            self.remarks.push(message!("programme_clock", seconds = figure(offset, 2)));
        } else {
            let blind = seen.iter().all(|s| s.up.is_none() && s.turn_arcsec_s.is_none());
            if blind && seen.len() != programme.len() {
                return Err(self.miscounted(candidates, programme.len()));
            }
            let others = exchanged(&seen, programme);
            if !others.is_empty() {
                let rows = list(others.iter().map(|row| text(row + 1)));
                return Err(message!("programme_exchanged", count = seen.len(), rows));
            }
            let means = |c: &Candidate| -> Vec<f64> {
                (0..self.outputs()).filter_map(|k| self.mean(Role::Output(k), c.interval)).collect()
            };
            let means = candidates.iter().map(means).collect();
            let matched = align_programme((self.map, self.log.unit.counts, self.site), &seen, spans, means, programme)?;
            let taken = matched.iter().flatten().count();
            if is_another(taken, seen.len()) {
                let (intervals, rows) = (seen.len(), programme.len());
                return Err(message!("programme_other", matched = taken, intervals, rows));
            }
            let mut places = matched.iter();
            candidates.retain_mut(|c| {
                c.position = places.next().copied().flatten().map(|j| programme[j]);
                c.position.is_some()
            });
            let left = seen.len() - taken;
            if left > 0 {
                self.remarks.push(message!("programme_left", count = left));
            }
            self.remarks.extend(missing(&matched.iter().flatten().copied().collect::<Vec<_>>(), programme));
        }
        self.remarks.extend(self.at_another_rate(candidates));
        self.check_commanded(candidates)
    }

    /// Turns in which the outputs swing, with the Earth's rate, as at another rate than the programme tells: some, or
    /// all of them by one factor.
    fn at_another_rate(&self, candidates: &[Candidate]) -> Option<Message> {
        let series = &self.log.series;
        let of = |c: &Candidate| {
            let told = c.position?.turn_arcsec_s.abs();
            let (from, to) = (series.start_s(c.interval.from), series.end_s(c.interval.to));
            let holds =
                |turn: &&TurningInterval| turn.from_s <= from + series.block_s && to - series.block_s <= turn.to_s;
            let turn = self.turns.stretches.iter().filter(|turn| turn.turns >= WHOLE).find(holds)?;
            (told > 0.0).then_some((from, turn.swings_arcsec_s, told))
        };
        let turns: Vec<(f64, f64, f64)> = candidates.iter().filter_map(of).collect();
        let is_other = |(_, swings, told): &&(f64, f64, f64)| (swings / told - 1.0).abs() > OTHER_SWING;
        let place = |(from, swings, told): &(f64, f64, f64)| {
            let [swings_at, told_at] = [swings, told].map(|rate| rate / 3600.0);
            text(format_args!("{from:.0} s: {swings_at:.2} / {told_at:.2} deg/s"))
        };
        let others: Vec<Parameter> = turns.iter().filter(is_other).map(place).collect();
        if !others.is_empty() {
            return Some(message!("turns_at_another_rate", count = others.len(), turns = list(others)));
        }
        let off = median_of(turns.iter().map(|(_, swings, told)| swings / told - 1.0))?;
        let near = |(_, swings, told): &(f64, f64, f64)| (swings / told - 1.0 - off).abs() < ONE_FACTOR * off.abs();
        let is_one = turns.len() >= FEWEST_TURNS && off.abs() > OTHER_FACTOR && turns.iter().all(near);
        is_one.then(|| message!("turns_by_one_factor", count = turns.len(), percent = signed(100.0 * off, 1)))
    }

    /// That intervals and rows are not as many, and where it shows: neighbours with the same outputs may be one position,
    /// a long pause may hide one.
    fn miscounted(&self, candidates: &[Candidate], rows: usize) -> Message {
        const SAID: usize = 5;
        let (series, intervals) = (&self.log.series, candidates.len());
        let fault = message!("programme_count", intervals, rows);
        let pauses: Vec<(f64, f64)> = candidates
            .windows(2)
            .map(|p| (series.end_s(p[0].interval.to), series.start_s(p[1].interval.from)))
            .collect();
        let lengths = candidates.iter().map(|c| series.end_s(c.interval.to) - series.start_s(c.interval.from));
        let usual = median_of(pauses.iter().map(|(from, to)| to - from)).unwrap_or(0.0);
        let long = usual + HIDES * median_of(lengths).unwrap_or(0.0);
        let is_told = |k: &usize| match intervals > rows {
            true => self.are_alike(candidates[*k].interval, candidates[k + 1].interval),
            false => pauses[*k].1 - pauses[*k].0 > long,
        };
        let told: Vec<usize> = (0..pauses.len()).filter(is_told).collect();
        let said = told.iter().take(SAID).map(|&k| {
            let (from, to) = pauses[k];
            text(format_args!("{}/{} ({from:.0}–{to:.0} s)", k + 1, k + 2))
        });
        let places = list(said.chain((told.len() > SAID).then(|| text("…"))));
        match intervals > rows {
            _ if told.is_empty() => fault,
            true => message!("intervals_alike", fault, places),
            false => message!("pauses_long", fault, places),
        }
    }

    /// Whether the outputs of two intervals differ by no more than noise makes of them.
    fn are_alike(&self, one: Interval, other: Interval) -> bool {
        let mut outputs = (0..self.outputs()).filter_map(|k| self.track(Role::Output(k)));
        outputs.all(|track| {
            let mean = |i: Interval| track.mean_of(i.from, i.to);
            let variance = |i: Interval| {
                let mean = mean(i);
                let squares = track.mean[i.from..i.to].iter().map(|value| (value - mean).powi(2)).sum::<f64>();
                squares / ((i.to - i.from) as f64).powi(2)
            };
            (mean(one) - mean(other)).abs() <= ALIKE * (variance(one) + variance(other)).sqrt()
        })
    }

    /// Each position's own time, as far as the log was steady in it.
    fn by_the_clock(
        &self,
        spans: &[(f64, f64)],
        candidates: &[Candidate],
        programme: &[Position],
        offset: f64,
    ) -> Vec<(usize, Candidate)> {
        let series = &self.log.series;
        let block = |time: f64| series.number.partition_point(|&n| (n as f64 + 0.5) * series.block_s < time);
        let mut found = Vec::new();
        for (row, position) in programme.iter().enumerate() {
            let (Some(start), Some(duration)) = (position.start_s, position.duration_s) else { continue };
            let (from, to) = (start + offset, start + offset + duration);
            let shared = spans.iter().enumerate().map(|(k, &(a, b))| (k, a.max(from), b.min(to)));
            let Some((k, from, to)) = shared.max_by(|a, b| (a.2 - a.1).total_cmp(&(b.2 - b.1))) else { continue };
            let interval = Interval { from: block(from), to: block(to) };
            if to - from < 0.5 * duration || interval.to <= interval.from {
                continue;
            }
            let interval = Interval { from: interval.from.max(candidates[k].interval.from), ..interval };
            found.push((row, Candidate { position: Some(*position), ..self.candidate(interval) }));
        }
        found
    }

    /// Accelerometers and rates, where there are any, must agree with the programme.
    fn check_commanded(&self, candidates: &[Candidate]) -> Result<(), Message> {
        let turns_otherwise = |c: &&Candidate| {
            let told = c.position.map_or(0.0, |p| p.turn_arcsec_s);
            let off = c.seen.turn_arcsec_s.map_or(0.0, |seen| (seen - told).abs());
            off > REST_ARCSEC_S.max(OFF_RATE * told.abs())
        };
        if let Some(first) = candidates.iter().find(turns_otherwise) {
            let count = candidates.iter().filter(turns_otherwise).count();
            let start = figure(self.log.series.start_s(first.interval.from), 1);
            return Err(message!("programme_rates", count, of = candidates.len(), start));
        }
        let angle = |c: &Candidate| Some(c.seen.up?.dot(&c.position?.up()).clamp(-1.0, 1.0).acos());
        let start = |c: &Candidate| self.log.series.start_s(c.interval.from);
        let off: Vec<(f64, f64)> = candidates.iter().filter_map(|c| Some((start(c), angle(c)?))).collect();
        agree(&off)
    }

    fn one_interval(&self, candidate: &Candidate) -> Message {
        let i = candidate.interval;
        let outputs = (0..self.outputs()).filter_map(|k| self.mean(Role::Output(k), i));
        let means = list(outputs.map(|mean| text(format_args!("{mean:.4}"))));
        let seconds = figure(self.log.series.end_s(i.to) - self.log.series.start_s(i.from), 1);
        message!("one_interval", seconds, means)
    }

    fn dwells(&mut self, candidates: Vec<Candidate>) -> Result<Assembled, Message> {
        let series = &self.log.series;
        let cut = |c: Candidate| {
            let interval = without_edges(series, c.interval, self.map.cut_s)?;
            Some(Candidate { interval, ..c })
        };
        let before = candidates.len();
        let mut candidates: Vec<Candidate> = candidates.into_iter().filter_map(cut).collect();
        let gone = before - candidates.len();
        let phase = |c: &Candidate| c.position.map_or(Phase::Static, |p| p.phase());
        let outputs: Vec<&Track> = (0..self.outputs()).filter_map(|k| self.track(Role::Output(k))).collect();
        // By output, at rest and in turns.
        let noise_of = |candidates: &[Candidate], part: fn(Interval) -> Interval| -> Vec<[Noise; 2]> {
            let of_phase = |wanted: Phase| -> Vec<Interval> {
                candidates.iter().filter(|c| phase(c) == wanted).map(|c| part(c.interval)).collect()
            };
            noise(series, &outputs, &of_phase(Phase::Static), &of_phase(Phase::Rate))
        };
        let of = |noise: &[[Noise; 2]], c: &Candidate| -> Vec<Noise> {
            noise.iter().map(|both| both[usize::from(phase(c) == Phase::Rate)]).collect()
        };
        let rough = noise_of(&candidates, later);
        for candidate in &mut candidates {
            let channels: Vec<(&Track, Noise)> = outputs.iter().copied().zip(of(&rough, candidate)).collect();
            candidate.interval = settled(series, &channels, candidate.interval);
            self.whole_turns(candidate);
        }
        let fine = noise_of(&candidates, |settled| settled);
        let dwells = candidates.iter().map(|c| self.dwell(c, &of(&fine, c))).collect::<Result<Vec<_>, _>>()?;
        if gone > 0 {
            self.remarks.push(message!("intervals_all_edge", count = gone));
        }
        let dwells = self.without_parts_of_turns(&candidates, dwells)?;
        Ok(Assembled { dwells, remarks: std::mem::take(&mut self.remarks) })
    }

    /// Leaves out parts of a turn of which nothing says at which heading they began: an unknown part of the Earth's
    /// horizontal rate is in their means. Those that it moves by less than noise stay.
    fn without_parts_of_turns(&mut self, candidates: &[Candidate], dwells: Vec<Dwell>) -> Result<Vec<Dwell>, Message> {
        let (mut kept, mut below, mut left, mut most) = (Vec::new(), 0_usize, 0_usize, 0.0_f64);
        for (candidate, dwell) in candidates.iter().zip(dwells) {
            let Some((unknown, turn)) = self.unknown_rate(candidate) else {
                kept.push(dwell);
                continue;
            };
            // The gyro that sees most of the turn has the scale factor.
            let scale = dwell.output.iter().map(|output| output.abs()).fold(0.0, f64::max) / turn.abs();
            if dwell.output_sem.iter().all(|sem| unknown * scale <= *sem) {
                below += 1;
                kept.push(dwell);
            } else {
                left += 1;
                most = most.max(unknown);
            }
        }
        if below > 0 {
            self.remarks.push(message!("turns_not_whole", count = below));
        }
        let too_short = message!("turns_too_short", count = left, most = figure(most, 1));
        if kept.is_empty() {
            return Err(too_short);
        }
        if left > 0 {
            self.remarks.push(too_short);
        }
        Ok(kept)
    }

    /// Of a part of a turn from an unknown heading, what the Earth's horizontal rate may be in its mean, and the turn,
    /// arcsec/s: Omega cos L |sin(theta/2) / (theta/2)|.
    fn unknown_rate(&self, candidate: &Candidate) -> Option<(f64, f64)> {
        let position = candidate.position?;
        let unknown = self.is_part_of_turn(candidate, &position) && self.part_of_turn(candidate, &position).is_none();
        let half = 0.5 * self.turned(candidate, &position);
        unknown.then_some((self.site?.earth_rate().0.y * (half.sin() / half).abs(), position.turn_arcsec_s))
    }

    /// Cuts a turning interval to whole turns, where there is one.
    fn whole_turns(&self, candidate: &mut Candidate) {
        let turn = candidate.position.map_or(0.0, |p| p.turn_arcsec_s);
        if turn == 0.0 {
            return;
        }
        let series = &self.log.series;
        let i = candidate.interval;
        let turns = (series.end_s(i.to) - series.start_s(i.from)) * turn.abs() / TURN_ARCSEC;
        if turns < 1.0 {
            return;
        }
        let end = series.start_s(i.from) + turns.floor() * TURN_ARCSEC / turn.abs();
        candidate.interval.to = series.number.partition_point(|&n| (n as f64 + 0.5) * series.block_s < end).min(i.to);
    }

    fn dwell(&self, candidate: &Candidate, noise: &[Noise]) -> Result<Dwell, Message> {
        let i = candidate.interval;
        let series = &self.log.series;
        let is_part = candidate.position.is_some_and(|p| self.is_part_of_turn(candidate, &p));
        let (mut output, mut output_sem) = (Vec::new(), Vec::new());
        for (k, noise) in noise.iter().enumerate() {
            let Some(track) = self.track(Role::Output(k)) else { continue };
            // Of less than a turn the swing is in the mean.
            let averaged = self.track(Role::Raw(k)).filter(|_| is_part).unwrap_or(track);
            output.push(averaged.mean_of(i.from, i.to));
            output_sem.push(standard_error(series, track, (noise, self.differs), i, self.log.sample_s));
        }
        let (start, end) = (series.start_s(i.from), series.end_s(i.to));
        Ok(Dwell {
            commanded: self.commanded(candidate)?,
            start_s: start.max(0.0),
            duration_s: end - start.max(0.0),
            temperature_c: self.mean(Role::Temperature, i),
            output,
            output_sem,
        })
    }

    /// Angles from and to of a turn that is no whole one, rad after the attitude that the log states.
    fn part_of_turn(&self, candidate: &Candidate, position: &Position) -> Option<(f64, f64)> {
        candidate.attitude.filter(|stated| *stated == position.attitude)?;
        let begun = self.log.series.start_s(candidate.interval.from) - candidate.began_s;
        let from = (position.turn_arcsec_s * begun / 3600.0).to_radians();
        let turned = self.turned(candidate, position);
        self.is_part_of_turn(candidate, position).then_some((from, from + turned))
    }

    /// Whether what the Earth's horizontal rate does in a dwell is left in its mean: it has less than one turn, and
    /// nor had the stretch that it is of, from which the swing was taken out.
    fn is_part_of_turn(&self, candidate: &Candidate, position: &Position) -> bool {
        let (series, i) = (&self.log.series, candidate.interval);
        let turned = self.turned(candidate, position).abs();
        let is_of = |turn: &&TurningInterval| {
            turn.from_s < series.start_s(i.from) + series.block_s && series.end_s(i.to) - series.block_s < turn.to_s
        };
        let is_out = self.turns.stretches.iter().filter(is_of).any(|turn| turn.turns >= WHOLE);
        // A whole one is cut to its blocks.
        let two_blocks = (position.turn_arcsec_s.abs() * 2.0 * series.block_s / 3600.0).to_radians();
        0.0 < turned && turned < std::f64::consts::TAU - two_blocks && !is_out
    }

    /// Angle of a turn, rad; zero in a position.
    fn turned(&self, candidate: &Candidate, position: &Position) -> f64 {
        let (series, i) = (&self.log.series, candidate.interval);
        (position.turn_arcsec_s * (series.end_s(i.to) - series.start_s(i.from)) / 3600.0).to_radians()
    }

    fn commanded(&self, candidate: &Candidate) -> Result<Commanded, Message> {
        if let Some(position) = &candidate.position {
            let site = self.site.ok_or_else(|| message!("map_site_missing"))?;
            let (force_g0, rate_arcsec_s) = match self.part_of_turn(candidate, position) {
                Some(part) => position.commanded_over(&site, part),
                None => position.commanded(&site),
            };
            return Ok(Commanded {
                phase: position.phase(),
                attitude: Some(position.attitude),
                force_g0,
                rate_arcsec_s,
            });
        }
        let direction_only = self.map.force.as_ref().is_some_and(|f| f.direction_only);
        by_accelerometers(
            candidate.force,
            candidate.seen.turn_arcsec_s,
            self.site,
            self.log.unit.counts,
            direction_only,
        )
    }
}

/// What was commanded in a dwell, or stands for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Commanded {
    pub phase: Phase,
    pub attitude: Option<Rotation<Nav, Body>>,
    pub force_g0: Vector3<f64>,
    pub rate_arcsec_s: Vector3<f64>,
}

/// Measured specific force in place of the commanded one. It leaves the heading open, so that of the Earth's rate at
/// rest only the vertical part is known: enough for gyros that measure rates of turn and do not see the rest.
///
/// # Errors
/// No accelerometers, or gyros that see the Earth's rate.
pub fn by_accelerometers(
    force: Option<Vector3<f64>>,
    turn_arcsec_s: Option<f64>,
    site: Option<Site>,
    counts: Counts,
    direction_only: bool,
) -> Result<Commanded, Message> {
    let Some(force) = force else { return Err(message!("commanded_unknown")) };
    if counts != Counts::Angular {
        return Err(message!("commanded_heading"));
    }
    let turn = turn_arcsec_s.filter(|turn| turn.abs() >= REST_ARCSEC_S);
    let up = force.try_normalize(0.0).ok_or_else(|| message!("force_no_unit", length = figure(0.0, 1)))?;
    let vertical = site.map_or(0.0, |site| EARTH_RATE_DEG_H * site.latitude.sin());
    let gravity = site.map_or(1.0, |site| site.gravity_g0);
    Ok(Commanded {
        phase: if turn.is_some() { Phase::Rate } else { Phase::Static },
        attitude: None,
        force_g0: if direction_only { gravity * up } else { force },
        rate_arcsec_s: (turn.unwrap_or(0.0) + vertical) * up,
    })
}

/// That the programme's times are those of one clock alone; what is said where they are of none.
///
/// # Errors
/// Two offsets, a dwell apart, that fit as well; times in another unit.
pub fn one_clock(
    clock: Option<Clock>,
    spans: &[(f64, f64)],
    seen: &[LoggedInterval],
    programme: &[Position],
) -> Result<Option<Message>, Message> {
    match clock {
        None if programme.iter().any(|position| position.start_s.is_some()) => {
            match clock_factor(spans, seen, programme) {
                Some(factor) => Err(message!("programme_clock_unit", factor = text(factor))),
                None => Ok(Some(message!("programme_clock_unused"))),
            }
        }
        Some(Clock { offset_s, rival_s: Some(rival) }) => {
            Err(message!("programme_ambiguous", one = figure(offset_s, 1), other = figure(rival, 1)))
        }
        _ => Ok(None),
    }
}

/// Which interval is which row of a programme, by what was seen in it and by the outputs.
///
/// # Errors
/// No site; several ways that explain the outputs as well.
pub fn align_programme(
    (map, counts, site): (&Map, Counts, Option<Site>),
    seen: &[LoggedInterval],
    spans: Vec<(f64, f64)>,
    means: Vec<Vec<f64>>,
    programme: &[Position],
) -> Result<Vec<Option<usize>>, Message> {
    let site = site.ok_or_else(|| message!("map_site_missing"))?;
    let (axes, are_rates) = (map.input_axes().unwrap_or_default(), counts == Counts::Angular);
    let outputs = Outputs { spans, means, axes, are_rates, site };
    let undecided = |Undecided| message!("programme_undecided", intervals = seen.len(), rows = programme.len());
    align_by_outputs(seen, &outputs, programme).map_err(undecided)
}

/// That measured verticals are those that were commanded; `off`: begin of each dwell, s, and the angle between, rad.
pub fn agree(off: &[(f64, f64)]) -> Result<(), Message> {
    let wrong: Vec<&(f64, f64)> = off.iter().filter(|(_, angle)| *angle > OFF_COMMANDED).collect();
    let Some(&&(start, angle)) = wrong.first() else { return Ok(()) };
    let (start, degrees) = (figure(start, 1), figure(angle.to_degrees(), 1));
    Err(message!("programme_contradicted", count = wrong.len(), of = off.len(), start, degrees))
}

/// Rows of a programme that no interval is of.
pub fn missing(taken: &[usize], programme: &[Position]) -> Option<Message> {
    const SAID: usize = 12;
    let rows: Vec<usize> = (0..programme.len()).filter(|row| !taken.contains(row)).collect();
    let turning = rows.iter().filter(|&&row| programme[row].phase() == Phase::Rate).count();
    let which = rows.iter().take(SAID).map(|row| text(row + 1)).chain((rows.len() > SAID).then(|| text("…")));
    (!rows.is_empty()).then(|| {
        let (count, rows, which) = (rows.len(), programme.len(), list(which));
        message!("programme_missing", count, rows, which, turning)
    })
}

/// Whether all dwells have one vertical.
pub fn one_orientation(dwells: &[Dwell]) -> bool {
    let ups: Vec<Vector3<f64>> = dwells.iter().filter_map(|d| d.commanded.force_g0.try_normalize(0.0)).collect();
    ups.iter().all(|up| up.dot(&ups[0]) > SAME_UP)
}
