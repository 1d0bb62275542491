//! Samples gathered into blocks of time, in memory that does not grow with the log.

/// Most blocks that are kept. Where a log has more, two and two become one.
pub const MOST_BLOCKS: usize = 1 << 18;

/// Blocks at the end of a range that are no chance.
const IN_A_ROW: usize = 8;

/// Sums over blocks of 2^level seconds, which begin at whole multiples of their length.
#[derive(Debug, Clone)]
pub struct Blocks {
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
    least: f64,
    most: f64,
    last: f64,
    step: f64,
    samples: u64,
    changes: u64,
}

/// One channel over the blocks of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    pub mean: Vec<f64>,
    /// Standard deviation of the samples within a block; zero where there is one.
    pub spread: Vec<f64>,
    pub count: Vec<u32>,
    pub least: f64,
    pub most: f64,
    /// Smallest difference between samples one after the other: one count of a converter.
    pub step: f64,
    /// Share of the samples that differ from the one before.
    pub changes: f64,
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

    pub fn with_room(channels: usize, interval_s: f64, most: usize) -> Self {
        let sums = Sums {
            origin: f64::NAN,
            sum: Vec::new(),
            square: Vec::new(),
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
            last: f64::NAN,
            step: f64::INFINITY,
            samples: 0,
            changes: 0,
        };
        let level = interval_s.log2().ceil().clamp(-40.0, 40.0) as i32;
        Self { level, most, number: Vec::new(), count: Vec::new(), time: Vec::new(), channels: vec![sums; channels] }
    }

    /// One sample of every channel. Times do not decrease.
    pub fn push(&mut self, time_s: f64, values: &[f64]) {
        let number = self.number_of(time_s);
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
            channel.least = channel.least.min(value);
            channel.most = channel.most.max(value);
            let step = (value - channel.last).abs();
            channel.samples += 1;
            if step > 0.0 {
                channel.step = channel.step.min(step);
                channel.changes += 1;
            }
            channel.last = value;
        }
    }

    fn number_of(&self, time_s: f64) -> i64 {
        (time_s * 2f64.powi(-self.level)).floor() as i64
    }

    /// Blocks of twice the length.
    fn halve(&mut self) {
        self.level += 1;
        let mut kept = 0;
        for k in 0..self.number.len() {
            let number = self.number[k].div_euclid(2);
            if kept > 0 && self.number[kept - 1] == number {
                self.count[kept - 1] += self.count[k];
                self.time[kept - 1] += self.time[k];
                for channel in &mut self.channels {
                    channel.sum[kept - 1] += channel.sum[k];
                    channel.square[kept - 1] += channel.square[k];
                }
                continue;
            }
            self.number[kept] = number;
            self.count[kept] = self.count[k];
            self.time[kept] = self.time[k];
            for channel in &mut self.channels {
                channel.sum[kept] = channel.sum[k];
                channel.square[kept] = channel.square[k];
            }
            kept += 1;
        }
        self.number.truncate(kept);
        self.count.truncate(kept);
        self.time.truncate(kept);
        for channel in &mut self.channels {
            channel.sum.truncate(kept);
            channel.square.truncate(kept);
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
        let count = kept.iter().map(|&k| self.count[k]).collect();
        let step = if channel.step.is_finite() { channel.step } else { 0.0 };
        let changes = channel.changes as f64 / channel.samples.max(1) as f64;
        Track { mean, spread, count, least: channel.least, most: channel.most, step, changes }
    }
}

impl Series {
    /// Logs that ran beside one another, over the blocks in which all of them have samples.
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
        Self { block_s: 2f64.powi(level), number, time_s, tracks }
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
            only(&mut track.count, marked);
        }
    }

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
        let (mut sum, mut count) = (0.0, 0.0);
        for k in from..to {
            let n = f64::from(self.count[k]);
            sum += n * (self.mean[k] - first);
            count += n;
        }
        first + sum / count
    }

    /// Share of the blocks `from..to` that stand at the end of the channel's range, several in a row.
    pub fn clipped(&self, from: usize, to: usize) -> f64 {
        if self.most <= self.least {
            return 0.0;
        }
        let room = 1e-12 * (self.most - self.least);
        let at_end = |mean: &f64| mean - self.least <= room || self.most - mean <= room;
        let runs = self.mean[from..to].chunk_by(|a, b| at_end(a) == at_end(b));
        let clipped: usize = runs.filter(|run| at_end(&run[0]) && run.len() >= IN_A_ROW).map(<[f64]>::len).sum();
        clipped as f64 / (to - from) as f64
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
