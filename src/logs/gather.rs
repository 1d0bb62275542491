//! Logs read from first to last, once: every sample brought to the campaign's units and gathered into blocks.

use super::clock::Epoch;
use super::error::LogError;
use super::map::{Columns, Found, Header, Map, Reading};
use super::repeats::Rows;
use super::sampling::Sampling;
use super::source::Source;
use super::text::SkippedLines;
use super::units::{Counts, Quantity, Unit};
use crate::core::dwells::blocks::{Blocks, Series, Track};
use crate::core::message::{Message, figure, list, sent, text};
use crate::core::numerics::median::upper_median_of;
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
pub struct LogSeries {
    pub series: Series,
    pub roles: Vec<Role>,
    pub unit: Unit,
    /// What a rate of one is in arcsec/s; zero where the log has none.
    pub rate_factor: f64,
    /// Unit of the column of time, s; zero where there is none.
    pub time_unit_s: f64,
    /// Times at which another log begins.
    pub breaks: Vec<f64>,
    /// Usual time from sample to sample, s.
    pub sample_s: f64,
    /// Counts are of that time each, whatever their stamps say.
    pub is_regular: bool,
    /// From when the log's clock counts, and its first time by it, s.
    pub began: Option<(Epoch, f64)>,
    pub remarks: Vec<Message>,
}

impl LogSeries {
    /// Counts as rates by the time in which they were counted: so that a mean over many blocks is their sum by its time.
    pub fn by_own_time(&mut self) {
        let Some(times) = self.own_times() else { return };
        for (role, track) in self.roles.iter().zip(&mut self.series.tracks) {
            if *role == Role::Interval {
                track.mean.fill(self.sample_s);
            }
            if !is_output(role) {
                continue;
            }
            for ((mean, weight), times) in track.mean.iter_mut().zip(&mut track.weight).zip(&times) {
                *mean /= times;
                *weight *= times;
            }
        }
    }

    /// Whether counts scatter less by their own time than by row: stamps say when a row was counted, and not when it
    /// was written.
    pub fn stamps_are_the_counts(&self) -> bool {
        let Some(times) = self.own_times() else { return false };
        let outputs = self.roles.iter().zip(&self.series.tracks).filter(|(role, _)| is_output(role));
        let gain = |(_, track): (&Role, &Track)| -> f64 {
            let by_row = track.mean.windows(2);
            let by_time: Vec<f64> = track.mean.iter().zip(&times).map(|(mean, times)| mean / times).collect();
            by_row.zip(by_time.windows(2)).map(|(row, time)| (row[1] - row[0]).abs() - (time[1] - time[0]).abs()).sum()
        };
        outputs.map(gain).sum::<f64>() > 0.0
    }

    /// By block, the time in which a row was counted, in the usual ones.
    fn own_times(&self) -> Option<Vec<f64>> {
        let place = self.roles.iter().position(|role| *role == Role::Interval)?;
        Some(self.series.tracks[place].mean.iter().map(|own| own / self.sample_s).collect())
    }
}

fn is_output(role: &Role) -> bool {
    matches!(role, Role::Output(_) | Role::Raw(_))
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
/// Values in a row that are the same by no chance, where no more than such a share of the others is so: a sensor or a
/// logger that hangs. Where more of the log is so, its readings stand still by nature.
const FROZEN: u64 = 25;
const SAME: f64 = 0.2;
const MOST_FROZEN: f64 = 0.1;
/// Samples that alternate between two levels: how much nearer each is to the last but one than to the last, counts
/// that are no rounding, and the share of the samples that are so by no chance.
const BACK: f64 = 0.25;
const COUNTS: f64 = 3.0;
const ALTERNATE: f64 = 0.8;
/// Runs that are kept, and said.
const RUNS: usize = 1000;
const RUNS_SAID: usize = 5;

/// Reads all logs: those that run beside one another, or, where the map knows one, those that follow one another.
///
/// # Errors
/// Columns that are not there, times that jump back, rows that cannot be read.
pub fn gather(map: &Map, mut sources: Vec<(String, Source)>) -> Result<LogSeries, LogError> {
    let beside = map.logs();
    if beside > 1 && sources.len() != beside {
        return Err(LogError::new("map", message!("map_logs", logs = beside, have = sources.len())));
    }
    let (channels, unit, mut remarks) = channels(map, &sources)?;
    let is_row = beside == 1 && sources.len() > 1;
    if is_row {
        // The first decides which columns are what: others of another layout are named.
        sources[1..].iter().try_for_each(|other| same_layout(&sources[0], other))?;
        remarks.extend(in_order_of_time(map, &mut sources)?);
    }
    let counts = unit.counts;
    let of_log = |log: usize| channels.iter().filter(move |c| c.reading.log == log).collect::<Vec<_>>();
    let rate = channels.iter().find(|channel| matches!(channel.role, Role::Rate(_)));
    let mut reader = Reader::new(map, unit, remarks);
    reader.rate_factor = rate.map_or(0.0, |channel| channel.reading.factor.abs());
    let mut logs: Vec<BlockBuffer> = Vec::new();
    let mut roles = Vec::new();
    for (k, (place, source)) in sources.iter_mut().enumerate() {
        let own = of_log(if beside > 1 { k } else { 0 });
        if own.is_empty() {
            return Err(LogError::new(place.as_str(), message!("log_unused", log = k + 1)));
        }
        if k == 0 || beside > 1 {
            let own_roles = tracks(&own, counts);
            let unit_s = logs.first_mut().map(|first| first.begun().unit_s());
            logs.push(BlockBuffer::new(own_roles.len(), unit_s));
            roles.extend(own_roles);
            reader.restart();
        } else {
            reader.follow();
        }
        reader.seen.extend(is_row.then(|| Rows::new(place)));
        let room = logs.last_mut().expect("a room was made for the first log");
        reader.read(map, place, source, &own, room)?;
    }
    let blocks: Vec<Blocks> = logs.into_iter().map(BlockBuffer::into_blocks).collect();
    let series = Series::join(blocks);
    reader.into_gathered(&sources[0].0, series, roles)
}

/// Puts logs that follow one another in order of time, where their clocks have one epoch; that it was another order.
fn in_order_of_time(map: &Map, sources: &mut Vec<(String, Source)>) -> Result<Option<Message>, LogError> {
    let began = |(place, source): &mut (String, Source)| Ok(Stamps::of(map, place, source)?.began);
    let began = sources.iter_mut().map(began).collect::<Result<Vec<_>, LogError>>()?;
    let Some(began) = began.into_iter().collect::<Option<Vec<(Epoch, f64)>>>() else { return Ok(None) };
    let of_one_epoch = began.iter().all(|(epoch, _)| *epoch == began[0].0);
    if !of_one_epoch || began.is_sorted_by(|a, b| a.1 <= b.1) {
        return Ok(None);
    }
    let mut of_time: Vec<(f64, (String, Source))> = began.iter().map(|(_, s)| *s).zip(sources.drain(..)).collect();
    of_time.sort_by(|a, b| a.0.total_cmp(&b.0));
    sources.extend(of_time.into_iter().map(|(_, source)| source));
    Ok(Some(message!("logs_in_order", logs = list(sources.iter().map(|(place, _)| sent(place))))))
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
    let fault = message!("map_column_count", need = list(allowed.iter().map(text)), have);
    Err(LogError::new("map", message!("at_map_key", key, fault)))
}

fn channels(map: &Map, sources: &[(String, Source)]) -> Result<(Vec<Channel>, Unit, Vec<Message>), LogError> {
    let mut channels = Vec::new();
    let mut remarks = Vec::new();
    let mut add = |key: &'static str, found: &Found, role: fn(usize) -> Role| {
        let unit = found.unit_name.clone();
        remarks.push(match &found.header {
            Header::Says => message!("unit_of_header", key, unit),
            Header::Silent => message!("unit_of_map", key, unit),
            Header::Unknown(header) => {
                message!("unit_of_map_alone", key, unit, header = sent(header))
            }
        });
        let own = found.readings.iter().enumerate();
        channels.extend(own.map(|(k, reading)| Channel { role: role(k), reading: *reading }));
    };
    let found = |key, columns: &Columns, of: Quantity, allowed: &[usize]| {
        let found = columns.find(key, of, sources)?;
        counted(key, found.readings.len(), allowed).map(|()| found)
    };
    let output = found("output", &map.output, Quantity::Output, &[1, 2, 3])?;
    add("output", &output, Role::Output);
    if !map.gyros.is_empty() && map.gyros.len() != output.readings.len() {
        let fault = message!("map_gyros", gyros = map.gyros.len(), outputs = output.readings.len());
        return Err(LogError::new("map", fault));
    }
    if let Some(force) = &map.force {
        add("force", &found("force", force, Quantity::Force, &[3])?, Role::Force);
    }
    let of_averages = [("duration", map.duration.is_some()), ("standard_error", map.standard_error.is_some())];
    let inertial = ("rate.inertial", map.rate.as_ref().is_some_and(|rate| rate.inertial.is_some()));
    if let Some((key, _)) = of_averages.into_iter().chain([inertial]).find(|(_, is_there)| *is_there) {
        return Err(LogError::new("map", message!("map_of_averages", key)));
    }
    if let Some(rate) = &map.rate {
        add("rate", &found("rate", rate, Quantity::Rate, &[1, 3])?, Role::Rate);
    }
    if let Some(table) = &map.table {
        add("table", &table.as_columns().find("table", Quantity::Angle, sources)?, Role::Turn);
    }
    if let Some(temperature) = &map.temperature {
        add("temperature", &found("temperature", temperature, Quantity::Temperature, &[1])?, |_| Role::Temperature);
    }
    if let Some(attitude) = &map.attitude {
        let found = attitude.plain("attitude", sources)?;
        counted("attitude", found.len(), &[4])?;
        channels.extend(found.into_iter().enumerate().map(|(k, reading)| Channel { role: Role::Attitude(k), reading }));
    }
    Ok((channels, output.unit, remarks))
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
    if has_output && counts.need_time() {
        roles.push(Role::Interval);
    }
    roles
}

/// Blocks of a log, begun once the time between its samples is known.
struct BlockBuffer {
    width: usize,
    /// Unit of the blocks of the log beside it.
    unit_s: Option<f64>,
    first: Vec<(f64, Vec<f64>)>,
    blocks: Option<Blocks>,
}

impl BlockBuffer {
    fn new(width: usize, unit_s: Option<f64>) -> Self {
        Self { width, unit_s, first: Vec::new(), blocks: None }
    }

    fn push(&mut self, time: f64, values: &[f64]) {
        match &mut self.blocks {
            Some(blocks) => blocks.push(time, values),
            None => {
                self.first.push((time, values.to_vec()));
                if self.first.len() == FIRST_ROWS {
                    self.begun();
                }
            }
        }
    }

    fn begun(&mut self) -> &mut Blocks {
        self.blocks.get_or_insert_with(|| {
            let steps = self.first.windows(2).map(|p| p[1].0 - p[0].0).filter(|d| *d > 0.0);
            let usual = upper_median_of(steps).unwrap_or(1.0);
            let mut blocks = match self.unit_s {
                Some(unit_s) => Blocks::beside(self.width, usual, unit_s),
                None => Blocks::new(self.width, usual),
            };
            for (time, values) in self.first.drain(..) {
                blocks.push(time, &values);
            }
            blocks
        })
    }

    fn into_blocks(mut self) -> Blocks {
        self.begun();
        self.blocks.expect("blocks were begun above")
    }
}

/// The stamps of a log: their column, what makes seconds of them, and the unit of that column, s.
struct Stamps {
    column: Option<usize>,
    factor: f64,
    unit_s: f64,
    /// From when they count, and the first of them, s.
    began: Option<(Epoch, f64)>,
}

impl Stamps {
    fn of(map: &Map, place: &str, source: &mut Source) -> Result<Self, LogError> {
        let fail = |fault: Message| LogError::new(place, message!("at_map_key", key = "time", fault));
        let Some(time) = &map.time else {
            let Some(hz) = map.rate_hz.filter(|hz| *hz > 0.0) else {
                return Err(LogError::new("map", message!("map_no_time")));
            };
            return Ok(Self { column: None, factor: hz.recip(), unit_s: 0.0, began: None });
        };
        let mut own = Columns { log: None, ..time.clone() };
        let name = own.columns.first().ok_or_else(|| fail(message!("map_no_columns")))?;
        let (column, _) = name.find(source).map_err(fail)?;
        let first = source.first(column);
        // Dates and times of day are read as seconds.
        if first.is_some_and(|(_, is_clock)| is_clock) && source.columns()[column].unit.is_none() {
            own = own.or_unit("s");
        }
        let (found, unit, _) = own.unit(Quantity::Time, source).map_err(fail)?;
        let factor = found.factor * own.scale.first().unwrap_or(&1.0);
        let is_unix = unit.trim().to_lowercase().starts_with("unix_");
        let began = first.and_then(|(first, is_clock)| {
            let of_cells = if is_clock { Epoch::of(first) } else { None };
            Some((if is_unix { Epoch::Unix } else { of_cells? }, first * factor))
        });
        Ok(Self { column: Some(column), factor, unit_s: found.factor, began })
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
    seen: u64,
    repeated: u64,
    disordered: u64,
    lost: u64,
    gaps: u64,
    wrapped: u64,
}

impl Clock {
    /// Time of a sample; none where it repeats the time of the one before.
    fn at(&mut self, number: f64, factor: f64) -> Result<Option<f64>, Message> {
        self.seen += 1;
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
            self.interval = upper_median_of(self.steps.iter().copied()).unwrap_or(step);
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

/// How often a channel reads what it read before.
struct StuckDetector {
    role: Role,
    last: f64,
    before: f64,
    /// Samples that are the last but one again, and far from the last.
    alternating: u64,
    began_s: f64,
    least: f64,
    most: f64,
    whole: bool,
    same: u64,
    run: u64,
    /// Runs of [`FROZEN`] and more: the value, from and to, s, and the samples.
    runs: Vec<(f64, f64, f64, u64)>,
}

impl StuckDetector {
    fn new(role: Role) -> Self {
        let (least, most) = (f64::INFINITY, f64::NEG_INFINITY);
        Self {
            role,
            last: f64::NAN,
            before: f64::NAN,
            alternating: 0,
            began_s: 0.0,
            least,
            most,
            whole: true,
            same: 0,
            run: 0,
            runs: Vec::new(),
        }
    }

    fn see(&mut self, value: f64, at: f64) {
        self.whole &= value.fract() == 0.0;
        (self.least, self.most) = (self.least.min(value), self.most.max(value));
        let step = (value - self.last).abs();
        let is_back = (value - self.before).abs() < BACK * step && (step >= COUNTS || !self.whole);
        self.alternating += u64::from(is_back);
        self.before = self.last;
        if value != self.last {
            (self.last, self.began_s, self.run) = (value, at, 0);
            return;
        }
        self.same += 1;
        self.run += 1;
        if self.run == FROZEN && self.runs.len() < RUNS {
            self.runs.push((value, self.began_s, at, self.run));
        } else if self.run > FROZEN
            && let Some(run) = self.runs.last_mut().filter(|run| run.1 == self.began_s)
        {
            (run.2, run.3) = (at, self.run);
        }
    }

    /// Runs in which the channel hung. Whole numbers, counts above all, are the same by nature; at an end of its range
    /// a channel is clipped.
    fn frozen(&self, rows: u64) -> Vec<(f64, f64, u64)> {
        let is_clipped = |run: &&(f64, f64, f64, u64)| run.0 == self.least || run.0 == self.most;
        let frozen: Vec<_> = self.runs.iter().filter(|run| !is_clipped(run)).collect();
        let in_runs: u64 = self.runs.iter().map(|run| run.3).sum();
        let others = rows.saturating_sub(in_runs) as f64;
        let by_nature = self.whole
            || self.runs.len() == RUNS
            || self.same.saturating_sub(in_runs) as f64 > SAME * others
            || frozen.iter().map(|run| run.3).sum::<u64>() as f64 > MOST_FROZEN * rows as f64;
        if by_nature { Vec::new() } else { frozen.iter().map(|run| (run.1, run.2, run.3)).collect() }
    }
}

/// A counter of so many bits that begins anew when it is full.
#[derive(Debug, Clone)]
struct Counter {
    last: f64,
    carried: f64,
    least: f64,
    most: f64,
    whole: bool,
    began_anew: u64,
    /// Steps of about half of its range: up or down, nobody knows.
    unclear: u64,
    period: f64,
    /// The last step that was no fall to zero, whether the counter has just fallen there, and how often it went on from
    /// there as before.
    step: Option<f64>,
    fell: bool,
    resets: u64,
}

/// Part of a counter's range from which a step is not plain, and from which it is the step back over its end.
const UNCLEAR_STEP: std::ops::Range<f64> = 0.4..0.6;
/// Part of its range that a counter went through, which began anew.
const RANGE_SEEN: f64 = 0.9;
/// Steps, and a count, within which a counter that was reset is of zero and goes on, and from which on it has fallen.
const AT_ZERO: f64 = 3.0;
const FALLEN: f64 = 8.0;

impl Default for Counter {
    fn default() -> Self {
        let (least, most) = (f64::INFINITY, f64::NEG_INFINITY);
        let (carried, began_anew, unclear, period) = (0.0, 0, 0, 0.0);
        let (step, fell, resets) = (None, false, 0);
        Self { last: 0.0, carried, least, most, whole: true, began_anew, unclear, period, step, fell, resets }
    }
}

impl Counter {
    /// The count, carried on where the counter began anew since the one before.
    fn see(&mut self, value: f64, is_next: bool) -> f64 {
        (self.least, self.most) = (self.least.min(value), self.most.max(value));
        self.whole &= value.fract() == 0.0;
        let step = value - std::mem::replace(&mut self.last, value);
        let half = step.abs() >= UNCLEAR_STEP.start * 65_536.0;
        if let Some(period) = self.bits().filter(|_| is_next && half) {
            let share = step.abs() / period;
            self.period = period;
            self.unclear += u64::from(UNCLEAR_STEP.contains(&share));
            if share >= UNCLEAR_STEP.end {
                self.began_anew += 1;
                self.carried -= step.signum() * period;
                return value + self.carried;
            }
        }
        if is_next {
            self.see_reset(value, step.abs());
        }
        value + self.carried
    }

    /// Whether the counter fell to zero and went on from there.
    fn see_reset(&mut self, value: f64, step: f64) {
        let usual = self.step.map(|usual| usual + 1.0);
        let is_near = |length: f64| usual.is_some_and(|usual| length <= AT_ZERO * usual);
        if std::mem::take(&mut self.fell) {
            self.resets += u64::from(is_near(step));
        } else if is_near(value.abs()) && usual.is_some_and(|usual| step > FALLEN * usual) {
            self.fell = true;
            return;
        }
        self.step = Some(step);
    }

    /// The range of the least counter that can have counted all that was seen.
    fn bits(&self) -> Option<f64> {
        let fits = |period: &f64| {
            self.least >= 0.0 && self.most < *period || self.least >= -0.5 * period && self.most < 0.5 * period
        };
        [16, 24, 32].map(|bits| 2f64.powi(bits)).into_iter().find(|period| self.whole && fits(period))
    }

    /// Whether it cannot be said how often the counter began anew.
    fn is_unclear(&self) -> bool {
        let seen = self.most - self.least >= RANGE_SEEN * self.period;
        let other = self.began_anew > 0 && self.bits() != Some(self.period);
        other || self.unclear > 0 && seen && self.bits() == Some(self.period)
    }
}

/// Temperatures without the values that a sensor shows where it has none (999, -127, 85).
#[derive(Debug, Default)]
struct Temperature {
    good: Option<f64>,
    run: u64,
    left_out: u64,
}

impl Temperature {
    /// What may be a temperature where nothing was seen before, deg C.
    const LIKELY: std::ops::Range<f64> = -100.0..200.0;
    /// Change from one sample to the next that is none of a temperature, and samples from which it is one.
    const JUMP: f64 = 20.0;
    const LASTS: u64 = 50;

    /// The temperature, or the last one before; none where there was none.
    fn good(&mut self, value: f64) -> Option<f64> {
        let is_good = match self.good {
            Some(last) => (value - last).abs() <= Self::JUMP,
            None => Self::LIKELY.contains(&value),
        };
        self.run = if is_good { 0 } else { self.run + 1 };
        if is_good || self.run > Self::LASTS {
            self.good = Some(value);
        } else {
            self.left_out += 1;
        }
        self.good
    }
}

struct Reader {
    clock: Clock,
    unit: Unit,
    hz: Option<f64>,
    epoch: Option<Epoch>,
    time_factor: f64,
    time_unit_s: f64,
    /// Of the log with the outputs.
    sampling: Sampling,
    rate_factor: f64,
    breaks: Vec<f64>,
    rows: u64,
    missing: u64,
    bad: SkippedLines,
    counters: Vec<Counter>,
    temperature: Temperature,
    held: Vec<StuckDetector>,
    /// The rows of logs that follow one another.
    seen: Vec<Rows>,
    remarks: Vec<Message>,
}

impl Reader {
    fn new(map: &Map, unit: Unit, remarks: Vec<Message>) -> Self {
        Self {
            clock: Clock::default(),
            unit,
            hz: map.rate_hz,
            epoch: None,
            time_factor: 1.0,
            time_unit_s: 0.0,
            sampling: Sampling::default(),
            rate_factor: 0.0,
            breaks: Vec::new(),
            rows: 0,
            missing: 0,
            bad: SkippedLines::default(),
            counters: Vec::new(),
            temperature: Temperature::default(),
            held: Vec::new(),
            seen: Vec::new(),
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
            self.sampling.pause();
        }
    }

    fn read(
        &mut self,
        map: &Map,
        place: &str,
        source: &mut Source,
        channels: &[&Channel],
        room: &mut BlockBuffer,
    ) -> Result<(), LogError> {
        let Stamps { column: time, factor, unit_s, began } = Stamps::of(map, place, source)?;
        (self.time_factor, self.time_unit_s, self.epoch) = (factor, unit_s, began.map(|(epoch, _)| epoch));
        let mut wanted: Vec<usize> = channels.iter().map(|c| c.reading.column).collect();
        wanted.extend(time);
        let has_output = channels.iter().any(|c| matches!(c.role, Role::Output(_)));
        let per_interval = has_output && self.unit.counts.need_time();
        let needs_before = per_interval || channels.iter().any(|c| matches!(c.role, Role::Turn(_)));
        let is_attitude = |k: &usize| matches!(channels[*k].role, Role::Attitude(_));
        let attitude: Vec<usize> = (0..channels.len()).filter(is_attitude).collect();
        let temperature = channels.iter().position(|c| c.role == Role::Temperature);
        let mut quaternion = Vec::new();
        let mut row = Vec::new();
        let mut before: Option<(f64, Vec<f64>)> = None;
        let mut numbers = Vec::new();
        let mut index = 0_u64;
        let mut follows = self.clock.last.is_some();
        let bad = source.rows(place, &wanted, &mut |values| {
            index += 1;
            if values.iter().any(|v| v.is_nan()) {
                self.missing += 1;
                return Ok(());
            }
            let stamp = match time {
                Some(_) => values[values.len() - 1],
                None => (index - 1) as f64,
            };
            if std::mem::take(&mut follows) {
                self.begin_after(stamp)?;
            }
            if let Some(seen) = self.seen.last_mut() {
                seen.see(values, time.map(|_| stamp * factor));
            }
            let Some(at) = self.clock.at(stamp, self.time_factor)? else { return Ok(()) };
            self.rows += 1;
            if per_interval {
                self.sampling.see(at, self.clock.interval);
            }
            let is_next = before.as_ref().is_some_and(|(earlier, _)| at - earlier <= 1.5 * self.clock.interval);
            self.convert(channels, values, is_next, &mut numbers);
            if let Some(place) = temperature {
                let Some(held) = self.temperature.good(numbers[place]) else {
                    self.missing += 1;
                    return Ok(());
                };
                numbers[place] = held;
            }
            align(&attitude, &mut numbers, &mut quaternion);
            channels.iter().zip(&numbers).for_each(|(channel, value)| self.note_held(channel.role, *value, at));
            if needs_before {
                let now = (at, numbers.clone());
                if let Some((earlier, old)) = before.replace(now)
                    && is_next
                {
                    derive(channels, self.unit.counts, per_interval, (&numbers, &old), at - earlier, &mut row);
                    room.push(at, &row);
                }
            } else {
                room.push(at, &numbers);
            }
            Ok(())
        })?;
        self.bad.add(bad);
        match source.several(&wanted).or_else(|| self.unusable()).or_else(|| self.repeated()) {
            Some(fault) => Err(LogError::new(place, fault)),
            None => Ok(()),
        }
    }

    /// What is wrong with the rows of a log as a whole.
    fn unusable(&self) -> Option<Message> {
        let Clock { repeated, seen, .. } = self.clock;
        if repeated > 100 && repeated * 6 > seen {
            return Some(message!("time_coarse", repeated, rows = seen));
        }
        (self.rows == 0).then(|| message!("no_rows", count = self.missing))
    }

    /// That the last log has rows of one before it.
    fn repeated(&self) -> Option<Message> {
        let (last, before) = self.seen.split_last()?;
        before.iter().find_map(|earlier| last.again(earlier))
    }

    /// The clock of a log that follows another: its own where that goes on, else a second after the other's end.
    ///
    /// # Errors
    /// It began before the other's end, by a clock that both have.
    fn begin_after(&mut self, stamp: f64) -> Result<(), Message> {
        let (Some(last), Some(origin)) = (self.clock.last, self.clock.origin) else { return Ok(()) };
        let begin = stamp * self.time_factor;
        let back = last - (begin - origin + self.clock.carried);
        if let (Some(epoch), [.., other, _]) = (self.epoch, &self.seen[..])
            && back > 2.0 * self.clock.interval
        {
            let (from, to) = (text(epoch.written(begin)), text(epoch.written(begin + back)));
            let other = sent(&other.place);
            return Err(message!("log_overlaps", other, seconds = figure(back + self.clock.interval, 1), from, to));
        }
        if back >= 0.0 {
            self.clock.carried += back + BETWEEN_LOGS_S;
        }
        self.clock.last = None;
        Ok(())
    }

    /// The values of a row in the campaign's units, counts as if their counters had no end.
    fn convert(&mut self, channels: &[&Channel], values: &[f64], is_next: bool, numbers: &mut Vec<f64>) {
        self.counters.resize(channels.len().max(self.counters.len()), Counter::default());
        let of_total = self.unit.counts == Counts::Total;
        numbers.clear();
        for ((channel, &value), counter) in channels.iter().zip(values).zip(&mut self.counters) {
            let is_count = of_total && matches!(channel.role, Role::Output(_));
            let value = if is_count { counter.see(value, is_next) } else { value };
            numbers.push(channel.reading.factor * value + channel.reading.offset);
        }
    }

    fn note_held(&mut self, role: Role, value: f64, at: f64) {
        if !matches!(role, Role::Output(_) | Role::Force(_)) {
            return;
        }
        match self.held.iter_mut().find(|held| held.role == role) {
            Some(held) => held.see(value, at),
            None => {
                let mut held = StuckDetector::new(role);
                held.see(value, at);
                self.held.push(held);
            }
        }
    }

    /// Takes out what was read while a channel hung.
    fn without_frozen(&mut self, series: &mut Series) {
        let frozen: Vec<(f64, f64, u64)> = self.held.iter().flat_map(|held| held.frozen(self.rows)).collect();
        let Some(count) = frozen.iter().map(|run| run.2).max() else { return };
        let mut spans: Vec<(f64, f64)> = frozen.iter().map(|run| (run.0, run.1)).collect();
        spans.sort_by(|a, b| a.0.total_cmp(&b.0));
        spans.dedup_by(|next, run| {
            let overlap = next.0 <= run.1;
            if overlap {
                run.1 = run.1.max(next.1);
            }
            overlap
        });
        let hung = |k: usize| spans.iter().any(|&(from, to)| series.end_s(k + 1) > from && series.start_s(k) <= to);
        let marked: Vec<bool> = (0..series.number.len()).map(|k| !hung(k)).collect();
        series.keep(&marked);
        let said = spans.iter().take(RUNS_SAID).map(|(from, to)| text(format_args!("{from:.1}–{to:.1}")));
        self.remarks.push(message!("samples_frozen", runs = spans.len(), count, spans = list(said)));
    }

    fn into_gathered(mut self, place: &str, mut series: Series, roles: Vec<Role>) -> Result<LogSeries, LogError> {
        self.without_frozen(&mut series);
        if let Some(dead) = self.held.iter().find(|held| held.least == held.most && self.rows > FROZEN)
            && let Role::Output(gyro) = dead.role
        {
            return Err(LogError::new(place, message!("output_dead", output = gyro + 1, value = text(dead.least))));
        }
        let alternates =
            |held: &&StuckDetector| self.rows > FROZEN && held.alternating as f64 > ALTERNATE * self.rows as f64;
        if let Some(held) = self.held.iter().find(alternates) {
            let (key, column) = match held.role {
                Role::Force(k) => ("force", k + 1),
                Role::Output(k) => ("output", k + 1),
                _ => ("output", 1),
            };
            let (one, other) = (figure(held.before, 4), figure(held.last, 4));
            let fault = message!("samples_alternate", key, column, one, other);
            return Err(LogError::new(place, fault));
        }
        if let Some(counter) = self.counters.iter().find(|counter| counter.is_unclear()) {
            let fault = message!("counter_unclear", bits = counter.period.log2() as usize, count = counter.unclear);
            return Err(LogError::new(place, fault));
        }
        let clock = &self.clock;
        let mut say = |count: u64, message: Message| {
            if count > 0 {
                self.remarks.push(message);
            }
        };
        let usual = if clock.interval > 0.0 { clock.interval } else { self.hz.map_or(1.0, f64::recip) };
        let regular = self.sampling.regular_s();
        let interval = regular.unwrap_or(usual);
        say(clock.lost, message!("samples_lost", lost = clock.lost, gaps = clock.gaps, rows = self.rows));
        say(clock.repeated, message!("samples_repeated", count = clock.repeated));
        say(clock.disordered, message!("samples_disordered", count = clock.disordered));
        say(clock.wrapped, message!("time_wrapped", count = clock.wrapped));
        say(self.missing, message!("rows_incomplete", count = self.missing));
        say(self.temperature.left_out, message!("temperatures_left_out", count = self.temperature.left_out));
        let began = self.counters.iter().map(|counter| counter.began_anew).sum::<u64>();
        say(began, message!("counter_wrapped", count = began));
        let resets = self.counters.iter().map(|counter| counter.resets).max().unwrap_or(0);
        say(resets, message!("counter_reset", count = resets));
        self.remarks.extend(self.bad.remark());
        let counted = self.unit.counts.need_time();
        if series.number.is_empty() {
            return Err(LogError::new("map", message!("logs_apart")));
        }
        if counted {
            // By the usual time between samples; a dwell's mean is brought to its own time afterwards.
            let outputs = roles.iter().zip(&mut series.tracks).filter(|(role, _)| matches!(role, Role::Output(_)));
            outputs.for_each(|(_, track)| {
                track.pulse = if track.whole { track.step } else { 0.0 };
                track.scale(interval.recip());
            });
        }
        let began = self.epoch.zip(self.clock.origin);
        Ok(LogSeries {
            series,
            roles,
            unit: self.unit,
            rate_factor: self.rate_factor,
            time_unit_s: self.time_unit_s,
            breaks: self.breaks,
            sample_s: interval,
            is_regular: regular.is_some(),
            began,
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

#[cfg(test)]
mod tests {
    use super::*;

    /// What a counter of `period` shows of these pulses a sample, and what is made of it.
    fn counted(pulses: &[f64], period: f64, least: f64) -> (Counter, Vec<f64>) {
        let (mut counter, mut total, mut steps, mut before) = (Counter::default(), least, Vec::new(), None);
        for pulse in pulses {
            total += pulse;
            let shown = (total - least).rem_euclid(period) + least;
            let carried = counter.see(shown, before.is_some());
            steps.extend(before.replace(carried).map(|before: f64| carried - before));
        }
        (counter, steps)
    }

    #[test]
    fn counters_that_begin_anew_are_carried_on() {
        let slow: Vec<f64> = (0..4000).map(|k| if k < 2000 { 5400.0 } else { -5400.0 + f64::from(k % 3) }).collect();
        for (period, least) in [(65_536.0, 0.0), (65_536.0, -32_768.0), (4_294_967_296.0, 0.0)] {
            let (counter, steps) = counted(&slow, period, least);
            assert!(!counter.is_unclear(), "{period} {least}");
            assert_eq!(steps, slow[1..], "{period} {least}");
        }
        let fast: Vec<f64> = (0..4000).map(|k| (f64::from(k) * 20.0).min(54_000.0)).collect();
        assert!(counted(&fast, 65_536.0, 0.0).0.is_unclear(), "up by 54000 is down by 11536");
        let (wide, steps) = counted(&fast, 4_294_967_296.0, 0.0);
        assert!(!wide.is_unclear());
        assert_eq!(steps, fast[1..]);
    }

    #[test]
    fn a_counter_that_falls_to_zero_and_goes_on_was_reset() {
        let shown = |turn: f64, fall: &dyn Fn(u32, f64) -> f64| {
            let (mut counter, mut total) = (Counter::default(), 1e6);
            for k in 0..1000 {
                total += if (300..400).contains(&k) { turn } else { 24.0 + f64::from(k % 3) };
                counter.see(fall(k, total), k > 0);
            }
            counter.resets
        };
        let at_200 = 1e6 + 200.0 * 25.0;
        assert_eq!(shown(7000.0, &|_, total| total), 0);
        assert_eq!(shown(7000.0, &|_, total| total - at_200), 0, "it passes zero");
        assert_eq!(shown(7000.0, &|_, total| total - 1.35e6), 0, "it passes zero in a turn");
        assert_eq!(shown(7000.0, &|k, total| if k < 200 { total } else { total - at_200 }), 1);
        assert_eq!(shown(25.0, &|_, total| total.rem_euclid(1e4)), 2, "full at 10000");
        assert_eq!(shown(7000.0, &|k, total| if k % 50 == 49 { 0.0 } else { total }), 0, "single zeros");
    }

    #[test]
    fn fault_values_are_no_temperatures() {
        let mut sensor = Temperature::default();
        let shown = [999.0, 30.0, 30.1, 999.0, -127.0, 30.2];
        let good: Vec<Option<f64>> = shown.iter().map(|value| sensor.good(*value)).collect();
        assert_eq!(good, [None, Some(30.0), Some(30.1), Some(30.1), Some(30.1), Some(30.2)]);
        assert_eq!(sensor.left_out, 3);
        let warm: Vec<Option<f64>> = (0..100).map(|_| sensor.good(80.0)).collect();
        assert_eq!((warm[0], warm[99]), (Some(30.2), Some(80.0)), "it stays so");
    }

    #[test]
    fn samples_of_two_imus_alternate_and_noise_and_counts_do_not() {
        let share = |of: &dyn Fn(u32) -> f64| {
            let mut held = StuckDetector::new(Role::Output(0));
            (0..3000).for_each(|k| held.see(of(k), f64::from(k)));
            held.alternating as f64 / 3000.0
        };
        let noise = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24) - 0.5;
        assert!(share(&|k| noise(k) + if k % 2 == 0 { 30.0 } else { 0.0 }) > ALTERNATE);
        assert!(share(&noise) < 0.5, "{}", share(&noise));
        assert!(share(&|k| f64::from(k % 2)) < 0.01, "half a pulse a sample");
    }
}
