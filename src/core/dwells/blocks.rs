//! Samples gathered into blocks of time, in memory that does not grow with the log.

use std::ops::AddAssign;

/// Most blocks that are kept. Where a log has more, two and two become one.
pub const MOST_BLOCKS: usize = 1 << 18;

/// Blocks at the end of a range that are no chance; of whole numbers, the part of an interval that is none.
const IN_A_ROW: usize = 8;
const PART_IN_A_ROW: usize = 8;
/// Samples of an interval at the end of a fine scale that are no chance.
const BY_CHANCE: f64 = 3.5;
/// Steps in the range of a scale on which no two samples fall on the end by chance.
const FINE: f64 = 1000.0;

/// Part of an interval by which blocks may be shorter: a clock that is slow by so much leaves few of them empty.
const SLOW: f64 = 0.01;
/// Part of a block that rounding makes of nothing.
const ROUNDED: f64 = 1e-9;

/// Sums over blocks of 2^level units, which begin at whole multiples of their length.
#[derive(Debug, Clone)]
pub struct Blocks {
    /// A second; of slower samples the time between them, s.
    unit_s: f64,
    level: i32,
    most: usize,
    number: Vec<i64>,
    count: Vec<u32>,
    time: Vec<f64>,
    channels: Vec<Sums>,
}

#[derive(Debug, Clone)]
struct Sums {
    /// The first value: sums are of what differs from it, so that squares keep their digits.
    origin: f64,
    sum: Vec<f64>,
    square: Vec<f64>,
    least: Limit,
    most: Limit,
    last: f64,
    step: f64,
    samples: u64,
    changes: u64,
    whole: bool,
}

/// An end of a channel's range, and how many samples of which block stand there.
#[derive(Debug, Clone)]
struct Limit {
    value: f64,
    at: Vec<(usize, u32)>,
}

/// One channel over the blocks of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    pub mean: Vec<f64>,
    /// Standard deviation of the samples within a block; zero where there is one.
    pub spread: Vec<f64>,
    /// What a block counts for in a mean: its samples, or of counts the time in which they were counted.
    pub weight: Vec<f64>,
    /// Share of a block's samples at the ends of the channel's range.
    pub at_end: Vec<f64>,
    pub least: f64,
    pub most: f64,
    /// Smallest difference between samples one after the other: one count of a converter.
    pub step: f64,
    /// Share of the samples that differ from the one before.
    pub changes: f64,
    /// Whether all samples are whole numbers.
    pub whole: bool,
    /// One pulse of a counter, unit times s: sums over any time are right to a pulse. Zero where nothing is counted.
    pub pulse: f64,
}

/// All channels over the same blocks. Block k covers `number[k] * block_s` to `(number[k] + 1) * block_s`.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub block_s: f64,
    pub number: Vec<i64>,
    /// Mean time of the samples of each block, s; of the first log where several run beside one another.
    pub time_s: Vec<f64>,
    pub tracks: Vec<Track>,
}

impl Blocks {
    /// For samples that come every `interval_s` seconds.
    pub fn new(channels: usize, interval_s: f64) -> Self {
        Self::with_room(channels, interval_s, MOST_BLOCKS)
    }

    /// Keeps at most `most` blocks: they double in length when more would be needed. The first are as long as
    /// `interval_s` above a second, else at least that but for a hundredth, a power of two.
    pub fn with_room(channels: usize, interval_s: f64, most: usize) -> Self {
        let unit_s = if interval_s > 1.0 + SLOW { interval_s } else { 1.0 };
        Self::in_units(channels, interval_s, most, unit_s)
    }

    /// As [`Self::new`], for a log beside another, whose blocks are of `unit_s`.
    pub fn beside(channels: usize, interval_s: f64, unit_s: f64) -> Self {
        Self::in_units(channels, interval_s, MOST_BLOCKS, unit_s)
    }

    /// What the length of a block is a power of two of, s.
    pub fn unit_s(&self) -> f64 {
        self.unit_s
    }

    fn in_units(channels: usize, interval_s: f64, most: usize, unit_s: f64) -> Self {
        let sums = Sums {
            origin: f64::NAN,
            sum: Vec::new(),
            square: Vec::new(),
            least: Limit { value: f64::INFINITY, at: Vec::new() },
            most: Limit { value: f64::NEG_INFINITY, at: Vec::new() },
            last: f64::NAN,
            step: f64::INFINITY,
            samples: 0,
            changes: 0,
            whole: true,
        };
        let units = interval_s / unit_s / (1.0 + SLOW);
        let level = units.log2().ceil().clamp(-40.0, 40.0) as i32;
        Self {
            unit_s,
            level,
            most,
            number: Vec::new(),
            count: Vec::new(),
            time: Vec::new(),
            channels: vec![sums; channels],
        }
    }

    /// One sample of every channel. Times do not decrease.
    pub fn push(&mut self, time_s: f64, values: &[f64]) {
        let number = (time_s / self.unit_s * 2f64.powi(-self.level) + ROUNDED).floor() as i64;
        if self.number.last() != Some(&number) {
            if self.number.len() == self.most {
                self.halve();
                return self.push(time_s, values);
            }
            self.number.push(number);
            self.count.push(0);
            self.time.push(0.0);
            for channel in &mut self.channels {
                channel.sum.push(0.0);
                channel.square.push(0.0);
            }
        }
        let last = self.number.len() - 1;
        self.count[last] += 1;
        self.time[last] += time_s;
        for (channel, &value) in self.channels.iter_mut().zip(values) {
            if channel.origin.is_nan() {
                channel.origin = value;
            }
            let off = value - channel.origin;
            channel.sum[last] += off;
            channel.square[last] += off * off;
            channel.least.see(value, last, value < channel.least.value);
            channel.most.see(value, last, value > channel.most.value);
            channel.whole &= value.fract() == 0.0;
            let step = (value - channel.last).abs();
            channel.samples += 1;
            if step > 0.0 {
                channel.step = channel.step.min(step);
                channel.changes += 1;
            }
            channel.last = value;
        }
    }

    /// Blocks of twice the length.
    fn halve(&mut self) {
        self.level += 1;
        let mut number: Vec<i64> = Vec::new();
        let mut places = Vec::with_capacity(self.number.len());
        for of_half in &self.number {
            let whole = of_half.div_euclid(2);
            if number.last() != Some(&whole) {
                number.push(whole);
            }
            places.push(number.len() - 1);
        }
        self.number = number;
        add_up(&mut self.count, &places);
        add_up(&mut self.time, &places);
        for channel in &mut self.channels {
            add_up(&mut channel.sum, &places);
            add_up(&mut channel.square, &places);
            for (block, _) in channel.least.at.iter_mut().chain(&mut channel.most.at) {
                *block = places[*block];
            }
        }
    }

    fn track(&self, channel: &Sums, kept: &[usize]) -> Track {
        let moments = kept.iter().map(|&k| {
            let n = f64::from(self.count[k]);
            let mean = channel.sum[k] / n;
            let variance = if n > 1.0 { (channel.square[k] - n * mean * mean).max(0.0) / (n - 1.0) } else { 0.0 };
            (channel.origin + mean, variance.sqrt())
        });
        let (mean, spread) = moments.unzip();
        let weight: Vec<f64> = kept.iter().map(|&k| f64::from(self.count[k])).collect();
        let mut ends = vec![0.0; self.number.len()];
        for &(block, count) in channel.least.at.iter().chain(&channel.most.at) {
            ends[block] += f64::from(count) / f64::from(self.count[block]);
        }
        let at_end = kept.iter().map(|&k| ends[k]).collect();
        let step = if channel.step.is_finite() { channel.step } else { 0.0 };
        let changes = channel.changes as f64 / channel.samples.max(1) as f64;
        let (least, most, whole) = (channel.least.value, channel.most.value, channel.whole);
        Track { mean, spread, weight, at_end, least, most, step, changes, whole, pulse: 0.0 }
    }
}

/// Sums of the values that have the same of the ascending `places`.
fn add_up<T: Copy + Default + AddAssign>(values: &mut Vec<T>, places: &[usize]) {
    let mut sums = vec![T::default(); places.last().map_or(0, |last| last + 1)];
    for (value, place) in values.iter().zip(places) {
        sums[*place] += *value;
    }
    *values = sums;
}

impl Limit {
    fn see(&mut self, value: f64, block: usize, is_beyond: bool) {
        if is_beyond {
            *self = Self { value, at: Vec::new() };
        }
        if value != self.value {
            return;
        }
        match self.at.last_mut() {
            Some((last, count)) if *last == block => *count += 1,
            _ => self.at.push((block, 1)),
        }
    }
}

impl Series {
    /// Logs that ran beside one another, in blocks of one unit, over those in which all of them have samples.
    pub fn join(mut logs: Vec<Blocks>) -> Self {
        let level = logs.iter().map(|log| log.level).max().unwrap_or(0);
        for log in &mut logs {
            while log.level < level {
                log.halve();
            }
        }
        let mut kept: Vec<Vec<usize>> = vec![Vec::new(); logs.len()];
        let mut number = Vec::new();
        if let Some((first, others)) = logs.split_first() {
            for (k, &at) in first.number.iter().enumerate() {
                let places: Option<Vec<usize>> = others.iter().map(|log| log.number.binary_search(&at).ok()).collect();
                let Some(places) = places else { continue };
                number.push(at);
                for (kept, place) in kept.iter_mut().zip(std::iter::once(k).chain(places)) {
                    kept.push(place);
                }
            }
        }
        let of_log = |(log, kept): (&Blocks, &Vec<usize>)| {
            log.channels.iter().map(|channel| log.track(channel, kept)).collect::<Vec<_>>()
        };
        let tracks = logs.iter().zip(&kept).flat_map(of_log).collect();
        let mean_time = |log: &Blocks| kept[0].iter().map(|&k| log.time[k] / f64::from(log.count[k])).collect();
        let time_s = logs.first().map(mean_time).unwrap_or_default();
        let unit_s = logs.first().map_or(1.0, |log| log.unit_s);
        Self { block_s: unit_s * 2f64.powi(level), number, time_s, tracks }
    }

    /// Leaves the blocks that are marked.
    pub fn keep(&mut self, marked: &[bool]) {
        fn only<T: Copy>(of: &mut Vec<T>, marked: &[bool]) {
            let mut place = marked.iter();
            of.retain(|_| *place.next().unwrap_or(&true));
        }
        only(&mut self.number, marked);
        only(&mut self.time_s, marked);
        for track in &mut self.tracks {
            only(&mut track.mean, marked);
            only(&mut track.spread, marked);
            only(&mut track.weight, marked);
            only(&mut track.at_end, marked);
        }
    }

    /// When a block begins, s after the time that block 0 begins at.
    pub fn start_s(&self, block: usize) -> f64 {
        self.number[block] as f64 * self.block_s
    }

    /// Begin of the block after the last of `from..to`.
    pub fn end_s(&self, to: usize) -> f64 {
        (self.number[to - 1] + 1) as f64 * self.block_s
    }
}

impl Track {
    /// Mean of all samples of the blocks `from..to`.
    pub fn mean_of(&self, from: usize, to: usize) -> f64 {
        let first = self.mean[from];
        let (mut sum, mut weight) = (0.0, 0.0);
        for k in from..to {
            sum += self.weight[k] * (self.mean[k] - first);
            weight += self.weight[k];
        }
        first + sum / weight
    }

    /// Share of the samples in the blocks `from..to` that stand at the ends of the channel's range by more than chance.
    ///
    /// Of a fine scale one sample reaches the end, and another by rounding. Of a coarse one blocks in a row are no chance; of counts, which are
    /// equal by nature where nothing but the rate is in them, a good part of the interval in a row.
    pub fn clipped(&self, from: usize, to: usize) -> f64 {
        if self.most <= self.least {
            return 0.0;
        }
        let at_end = &self.at_end[from..to];
        let is_fine = !self.whole && FINE * self.step < self.most - self.least;
        let in_a_row = if self.whole { IN_A_ROW.max((to - from) / PART_IN_A_ROW) } else { IN_A_ROW };
        let runs = at_end.chunk_by(|a, b| (*a == 1.0) == (*b == 1.0));
        let counted: f64 = if is_fine {
            let samples: f64 = at_end.iter().zip(&self.weight[from..to]).map(|(share, weight)| share * weight).sum();
            if samples < BY_CHANCE { 0.0 } else { at_end.iter().sum() }
        } else {
            runs.filter(|run| run[0] == 1.0 && run.len() >= in_a_row).map(|run| run.len() as f64).sum()
        };
        counted / (to - from) as f64
    }

    /// The same channel in another unit.
    pub fn scale(&mut self, factor: f64) {
        for value in self.mean.iter_mut().chain(&mut self.spread) {
            *value *= factor;
        }
        for value in [&mut self.least, &mut self.most, &mut self.step] {
            *value *= factor;
        }
    }
}
