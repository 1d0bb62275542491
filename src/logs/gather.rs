//! Logs read from first to last, once: every sample brought to the campaign's units and gathered into blocks.

use super::error::LogError;
use super::map::{Columns, Found, Map, Reading};
use super::source::Source;
use super::units::{Counts, Quantity};
use crate::core::dwells::blocks::{Blocks, Series};
use crate::core::message::{Message, figure, list, text};
use crate::message;

/// What a track of the series is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    Output(usize),
    Force(usize),
    /// Rate of the table, arcsec/s: about the vertical (0 alone), or in body axes.
    Rate(usize),
    /// Rate of the table's axis, arcsec/s; cosine and sine of its angle.
    Turn(usize),
    Cosine(usize),
    Sine(usize),
    Attitude(usize),
    Temperature,
    /// Rate of turn of the stated attitude, East North Up, arcsec/s.
    Spin(usize),
    /// An output before the swing of the turns was taken out of it.
    Raw(usize),
    /// Time since the sample before, s: what increments are divided by.
    Interval,
}

/// All logs as one series, and what was seen while they were read.
pub struct Gathered {
    pub series: Series,
    pub roles: Vec<Role>,
    pub counts: Counts,
    /// Times at which another log begins.
    pub breaks: Vec<f64>,
    /// Usual time from sample to sample, s.
    pub sample_s: f64,
    /// First time of the log, where its clock counts from 1970, s.
    pub unix_s: Option<f64>,
    pub rows: u64,
    pub remarks: Vec<Message>,
}

/// What is made of a row.
struct Channel {
    role: Role,
    reading: Reading,
}

/// Rows from which the time between samples is taken before blocks are begun.
const FIRST_ROWS: usize = 256;
/// A pause between logs that follow one another, s.
const BETWEEN_LOGS_S: f64 = 1.0;
/// Longest run of equal rows that is no frozen logger, where rows differ otherwise.
const FROZEN: u64 = 50;

/// Reads all logs: those that run beside one another, or, where the map knows one, those that follow one another.
///
/// # Errors
/// Columns that are not there, times that jump back, rows that cannot be read.
pub fn gather(map: &Map, mut sources: Vec<(String, Source)>) -> Result<Gathered, LogError> {
    let beside = map.logs();
    if beside > 1 && sources.len() != beside {
        return Err(LogError::new("map", message!("map_logs", logs = beside, have = sources.len())));
    }
    let (channels, counts, remarks) = channels(map, &sources)?;
    let of_log = |log: usize| channels.iter().filter(move |c| c.reading.log == log).collect::<Vec<_>>();
    let mut reader = Reader::new(map, counts, remarks);
    let mut logs = Vec::new();
    let mut roles = Vec::new();
    for k in 0..sources.len() {
        let own = of_log(if beside > 1 { k } else { 0 });
        if own.is_empty() {
            return Err(LogError::new(&sources[k].0, message!("log_unused", log = k + 1)));
        }
        if k == 0 || beside > 1 {
            let own_roles = tracks(&own, counts);
            logs.push(Room::new(own_roles.len()));
            roles.extend(own_roles);
            reader.restart();
        } else {
            // The first decides which columns are what: others of another layout are named.
            same_layout(&sources[0], &sources[k])?;
            reader.follow();
        }
        let (place, source) = &mut sources[k];
        let room = logs.last_mut().expect("a room was made for the first log");
        reader.read(map, place, source, &own, room)?;
    }
    let blocks: Vec<Blocks> = logs.into_iter().map(Room::into_blocks).collect();
    let series = Series::join(blocks);
    reader.into_gathered(series, roles)
}

pub fn same_layout(first: &(String, Source), other: &(String, Source)) -> Result<(), LogError> {
    if first.1.columns() == other.1.columns() {
        return Ok(());
    }
    Err(LogError::new(&other.0, message!("log_other_layout", first = first.0.clone())))
}

/// That a key has as many columns as it may.
pub fn counted(key: &'static str, have: usize, allowed: &[usize]) -> Result<(), LogError> {
    if allowed.contains(&have) {
        return Ok(());
    }
    let fault = message!("map_column_count", need = list(allowed.iter().map(text)), have = have);
    Err(LogError::new("map", message!("at_map_key", key = key, fault = fault)))
}

fn channels(map: &Map, sources: &[(String, Source)]) -> Result<(Vec<Channel>, Counts, Vec<Message>), LogError> {
    let mut channels = Vec::new();
    let mut remarks = Vec::new();
    let mut add = |key: &'static str, found: &Found, role: fn(usize) -> Role| {
        let taken = (found.unit_name.clone(), found.of_header);
        remarks.push(match taken {
            (unit, true) => message!("unit_of_header", key = key, unit = unit),
            (unit, false) => message!("unit_of_map", key = key, unit = unit),
        });
        let own = found.readings.iter().enumerate();
        channels.extend(own.map(|(k, reading)| Channel { role: role(k), reading: *reading }));
    };
    let output = map.output.find("output", Quantity::Output, sources)?;
    add("output", &output, Role::Output);
    counted("output", output.readings.len(), &[1, 2, 3])?;
    if !map.gyros.is_empty() && map.gyros.len() != output.readings.len() {
        let fault = message!("map_gyros", gyros = map.gyros.len(), outputs = output.readings.len());
        return Err(LogError::new("map", fault));
    }
    if let Some(force) = &map.force {
        let found = force.find("force", Quantity::Force, sources)?;
        counted("force", found.readings.len(), &[3])?;
        add("force", &found, Role::Force);
    }
    let of_averages = [("duration", map.duration.is_some()), ("standard_error", map.standard_error.is_some())];
    let inertial = ("rate.inertial", map.rate.as_ref().is_some_and(|rate| rate.inertial.is_some()));
    if let Some((key, _)) = of_averages.into_iter().chain([inertial]).find(|(_, is_there)| *is_there) {
        return Err(LogError::new("map", message!("map_of_averages", key = key)));
    }
    if let Some(rate) = &map.rate {
        let found = rate.find("rate", Quantity::Rate, sources)?;
        counted("rate", found.readings.len(), &[1, 3])?;
        add("rate", &found, Role::Rate);
    }
    if let Some(table) = &map.table {
        add("table", &table.as_columns().find("table", Quantity::Angle, sources)?, Role::Turn);
    }
    if let Some(temperature) = &map.temperature {
        let found = temperature.find("temperature", Quantity::Temperature, sources)?;
        counted("temperature", found.readings.len(), &[1])?;
        add("temperature", &found, |_| Role::Temperature);
    }
    if let Some(attitude) = &map.attitude {
        let found = attitude.plain("attitude", sources)?;
        counted("attitude", found.len(), &[4])?;
        channels.extend(found.into_iter().enumerate().map(|(k, reading)| Channel { role: Role::Attitude(k), reading }));
    }
    Ok((channels, output.unit.counts, remarks))
}

/// The tracks that a log's channels become.
fn tracks(channels: &[&Channel], counts: Counts) -> Vec<Role> {
    let mut roles: Vec<Role> = channels.iter().map(|c| c.role).collect();
    for channel in channels {
        if let Role::Turn(k) = channel.role {
            roles.extend([Role::Cosine(k), Role::Sine(k)]);
        }
    }
    let has_output = channels.iter().any(|c| matches!(c.role, Role::Output(_)));
    if has_output && matches!(counts, Counts::Increment | Counts::Total) {
        roles.push(Role::Interval);
    }
    roles
}

/// Blocks of a log, begun once the time between its samples is known.
struct Room {
    width: usize,
    first: Vec<(f64, Vec<f64>)>,
    blocks: Option<Blocks>,
}

impl Room {
    fn new(width: usize) -> Self {
        Self { width, first: Vec::new(), blocks: None }
    }

    fn push(&mut self, time: f64, values: &[f64]) {
        match &mut self.blocks {
            Some(blocks) => blocks.push(time, values),
            None => {
                self.first.push((time, values.to_vec()));
                if self.first.len() == FIRST_ROWS {
                    self.begin();
                }
            }
        }
    }

    fn begin(&mut self) {
        let mut steps: Vec<f64> = self.first.windows(2).map(|p| p[1].0 - p[0].0).filter(|d| *d > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        let usual = steps.get(steps.len() / 2).copied().unwrap_or(1.0);
        let mut blocks = Blocks::new(self.width, usual);
        for (time, values) in self.first.drain(..) {
            blocks.push(time, &values);
        }
        self.blocks = Some(blocks);
    }

    fn into_blocks(mut self) -> Blocks {
        if self.blocks.is_none() {
            self.begin();
        }
        self.blocks.take().expect("blocks were begun above")
    }
}

/// The clock of a log: seconds since the first sample, through whatever the counter does.
#[derive(Debug, Default)]
struct Clock {
    /// Raw time of the first sample of all logs, in s.
    origin: Option<f64>,
    /// Added to what the counter says: it began anew, or another log follows.
    carried: f64,
    raw: f64,
    last: Option<f64>,
    interval: f64,
    steps: Vec<f64>,
    repeated: u64,
    disordered: u64,
    lost: u64,
    gaps: u64,
    wrapped: u64,
}

impl Clock {
    /// Time of a sample; none where it repeats the time of the one before.
    fn at(&mut self, number: f64, factor: f64) -> Result<Option<f64>, Message> {
        let seconds = number * factor;
        let origin = *self.origin.get_or_insert(seconds);
        let Some(last) = self.last else {
            self.raw = number;
            let time = seconds - origin + self.carried;
            self.last = Some(time);
            return Ok(Some(time));
        };
        let mut time = seconds - origin + self.carried;
        if time == last {
            self.repeated += 1;
            return Ok(None);
        }
        if time < last {
            let back = last - time;
            if let Some(period) = period(self.raw, number, factor, back, self.interval) {
                self.carried += period;
                self.wrapped += 1;
                time += period;
            } else if self.interval > 0.0 && back <= 2.0 * self.interval {
                self.disordered += 1;
                return Ok(Some(last));
            } else {
                return Err(message!("time_back", from = text(self.raw), to = text(number), seconds = figure(back, 3)));
            }
        }
        let step = time - last;
        if self.steps.len() < FIRST_ROWS {
            self.steps.push(step);
            let mut steps = self.steps.clone();
            steps.sort_by(f64::total_cmp);
            self.interval = steps[steps.len() / 2];
        } else if step > 1.5 * self.interval {
            self.lost += (step / self.interval).round() as u64 - 1;
            self.gaps += 1;
        }
        self.raw = number;
        self.last = Some(time);
        Ok(Some(time))
    }
}

/// What a counter that falls to its begin has to be carried by: 2^16, 2^24, 2^32 counts, a day, a week.
fn period(before: f64, now: f64, factor: f64, back: f64, interval: f64) -> Option<f64> {
    let counts = [16, 24, 32].map(|bits| 2f64.powi(bits) * factor);
    let whole = before.fract() == 0.0 && now.fract() == 0.0;
    let counts = counts.into_iter().filter(|_| whole);
    let room = (5.0 * interval).max(1e-6);
    counts
        .chain([86_400.0, 604_800.0])
        .find(|period| (period - back).abs() <= room && now.abs() * factor <= 0.01 * period)
}

struct Reader {
    clock: Clock,
    counts: Counts,
    hz: Option<f64>,
    absolute: bool,
    time_factor: f64,
    breaks: Vec<f64>,
    rows: u64,
    missing: u64,
    bad: usize,
    equal: u64,
    run: u64,
    longest_run: (u64, f64),
    remarks: Vec<Message>,
}

impl Reader {
    fn new(map: &Map, counts: Counts, remarks: Vec<Message>) -> Self {
        Self {
            clock: Clock::default(),
            counts,
            hz: map.rate_hz,
            absolute: false,
            time_factor: 1.0,
            breaks: Vec::new(),
            rows: 0,
            missing: 0,
            bad: 0,
            equal: 0,
            run: 0,
            longest_run: (0, 0.0),
            remarks,
        }
    }

    /// A log beside the one before: the same clock, from its begin.
    fn restart(&mut self) {
        self.clock = Clock { origin: self.clock.origin, ..Clock::default() };
    }

    /// A log after the one before. Where its own clock does not go on, it begins a second later.
    fn follow(&mut self) {
        if let Some(last) = self.clock.last {
            self.breaks.push(last);
        }
    }

    fn read(
        &mut self,
        map: &Map,
        place: &str,
        source: &mut Source,
        channels: &[&Channel],
        room: &mut Room,
    ) -> Result<(), LogError> {
        let time = self.time_column(map, place, source)?;
        let mut wanted: Vec<usize> = channels.iter().map(|c| c.reading.column).collect();
        wanted.extend(time);
        let has_output = channels.iter().any(|c| matches!(c.role, Role::Output(_)));
        let per_interval = has_output && matches!(self.counts, Counts::Increment | Counts::Total);
        let needs_before = per_interval || channels.iter().any(|c| matches!(c.role, Role::Turn(_)));
        let is_attitude = |k: &usize| matches!(channels[*k].role, Role::Attitude(_));
        let attitude: Vec<usize> = (0..channels.len()).filter(is_attitude).collect();
        let mut quaternion = Vec::new();
        let mut row = Vec::new();
        let mut before: Option<(f64, Vec<f64>)> = None;
        let mut numbers = Vec::new();
        let mut index = 0_u64;
        let mut follows = self.clock.last.is_some();
        let bad = source.rows(place, &wanted, &mut |sample| {
            index += 1;
            let values = sample.values;
            if values.iter().any(|v| v.is_nan()) {
                self.missing += 1;
                return Ok(());
            }
            let stamp = match time {
                Some(_) => values[values.len() - 1],
                None => (index - 1) as f64,
            };
            if std::mem::take(&mut follows) {
                self.begin_after(stamp);
            }
            let Some(at) = self.clock.at(stamp, self.time_factor)? else { return Ok(()) };
            self.rows += 1;
            numbers.clear();
            numbers.extend(channels.iter().zip(values).map(|(c, v)| c.reading.factor * v + c.reading.offset));
            align(&attitude, &mut numbers, &mut quaternion);
            self.note_equal(has_output, &numbers, before.as_ref().map(|b| b.1.as_slice()), at);
            if needs_before {
                let now = (at, numbers.clone());
                if let Some((earlier, old)) = before.replace(now)
                    && at - earlier <= 1.5 * self.clock.interval
                {
                    derive(channels, self.counts, per_interval, (&numbers, &old), at - earlier, &mut row);
                    room.push(at, &row);
                }
            } else {
                if has_output {
                    before = Some((at, numbers.clone()));
                }
                room.push(at, &numbers);
            }
            Ok(())
        })?;
        self.bad += bad;
        if self.clock.repeated > 100 && self.clock.repeated * 5 > self.rows {
            let fault = message!("time_coarse", repeated = self.clock.repeated, rows = self.rows);
            return Err(LogError::new(place, fault));
        }
        if self.rows == 0 {
            return Err(LogError::new(place, message!("no_rows", count = self.missing as usize)));
        }
        Ok(())
    }

    /// The clock of a log that follows another: its own where that goes on, else a second after the other's end.
    fn begin_after(&mut self, stamp: f64) {
        let (Some(last), Some(origin)) = (self.clock.last, self.clock.origin) else { return };
        let own = stamp * self.time_factor - origin + self.clock.carried;
        if own <= last {
            self.clock.carried += last + BETWEEN_LOGS_S - own;
        }
        self.clock.last = None;
    }

    fn note_equal(&mut self, has_output: bool, now: &[f64], before: Option<&[f64]>, at: f64) {
        if !has_output {
            return;
        }
        if before == Some(now) {
            self.equal += 1;
            self.run += 1;
            if self.run > self.longest_run.0 {
                self.longest_run = (self.run, at);
            }
        } else {
            self.run = 0;
        }
    }

    fn time_column(&mut self, map: &Map, place: &str, source: &Source) -> Result<Option<usize>, LogError> {
        let fail = |fault: Message| LogError::new(place, message!("at_map_key", key = "time", fault = fault));
        let Some(time) = &map.time else {
            let Some(hz) = map.rate_hz.filter(|hz| *hz > 0.0) else {
                return Err(LogError::new("map", message!("map_no_time")));
            };
            self.time_factor = hz.recip();
            return Ok(None);
        };
        let own = Columns { log: None, ..time.clone() };
        let name = own.columns.first().ok_or_else(|| fail(message!("map_no_columns")))?;
        let (column, _) = name.find(source).map_err(fail)?;
        let heading = source.columns()[column].unit.clone();
        let unit = own.unit.clone().or(heading);
        let known = || list(Quantity::Time.units().iter().copied());
        let Some(unit) = unit else { return Err(fail(message!("map_unit_missing", known = known()))) };
        let Some(found) = Quantity::Time.unit(&unit) else {
            return Err(fail(message!("map_unit_unknown", unit = unit, known = known())));
        };
        self.time_factor = found.factor * own.scale.first().unwrap_or(&1.0);
        self.absolute = unit.trim().to_lowercase().starts_with("unix_");
        Ok(Some(column))
    }

    fn into_gathered(mut self, mut series: Series, roles: Vec<Role>) -> Result<Gathered, LogError> {
        let clock = &self.clock;
        let mut say = |count: u64, message: Message| {
            if count > 0 {
                self.remarks.push(message);
            }
        };
        let interval = if clock.interval > 0.0 { clock.interval } else { self.hz.map_or(1.0, f64::recip) };
        say(clock.lost, message!("samples_lost", lost = clock.lost, gaps = clock.gaps, rows = self.rows));
        say(clock.repeated, message!("samples_repeated", count = clock.repeated));
        say(clock.disordered, message!("samples_disordered", count = clock.disordered));
        say(clock.wrapped, message!("time_wrapped", count = clock.wrapped));
        say(self.missing, message!("rows_incomplete", count = self.missing));
        say(self.bad as u64, message!("rows_left_out", count = self.bad));
        let counted = matches!(self.counts, Counts::Increment | Counts::Total);
        // Counts of a second are equal by nature.
        let frozen = !counted && self.longest_run.0 >= FROZEN && self.equal * 50 < self.rows;
        let (length, end) = self.longest_run;
        say(u64::from(frozen), message!("samples_frozen", count = length, end = figure(end, 2)));
        if series.number.is_empty() {
            return Err(LogError::new("map", message!("logs_apart")));
        }
        if counted {
            // By the usual time between samples; a dwell's mean is brought to its own time afterwards.
            let outputs = roles.iter().zip(&mut series.tracks).filter(|(role, _)| matches!(role, Role::Output(_)));
            outputs.for_each(|(_, track)| track.scale(interval.recip()));
        }
        let unix_s = self.clock.origin.filter(|_| self.absolute);
        Ok(Gathered {
            series,
            roles,
            counts: self.counts,
            breaks: self.breaks,
            sample_s: interval,
            unix_s,
            rows: self.rows,
            remarks: self.remarks,
        })
    }
}

/// A quaternion and its negative are one attitude: the sign nearer to the one before, so that means have a meaning.
fn align(places: &[usize], numbers: &mut [f64], before: &mut Vec<f64>) {
    let along: f64 = places.iter().zip(&*before).map(|(&place, old)| numbers[place] * old).sum();
    if along < 0.0 {
        places.iter().for_each(|&place| numbers[place] = -numbers[place]);
    }
    before.clear();
    before.extend(places.iter().map(|&place| numbers[place]));
}

/// A row of tracks from two samples one after the other: increments and angles need the one before.
fn derive(
    channels: &[&Channel],
    counts: Counts,
    per_interval: bool,
    (now, before): (&[f64], &[f64]),
    step: f64,
    row: &mut Vec<f64>,
) {
    row.clear();
    let turned = |k: usize| {
        let turned = now[k] - before[k];
        turned - std::f64::consts::TAU * (turned / std::f64::consts::TAU).round()
    };
    for (k, channel) in channels.iter().enumerate() {
        row.push(match channel.role {
            Role::Output(_) if counts == Counts::Total => now[k] - before[k],
            Role::Turn(_) => turned(k).to_degrees() * 3600.0 / step,
            _ => now[k],
        });
    }
    for (k, channel) in channels.iter().enumerate() {
        if matches!(channel.role, Role::Turn(_)) {
            row.extend([now[k].cos(), now[k].sin()]);
        }
    }
    if per_interval {
        row.push(step);
    }
}
