//! Where nothing changes: the intervals of a log over which a mean has a meaning.

use std::ops::RangeInclusive;

use super::blocks::{Series, Track};
use crate::core::numerics::normal::SD_OF_MEDIAN;

/// What is looked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// Shortest interval, s; from the log itself where none is given.
    pub min_s: Option<f64>,
    /// Times at which another log begins: no interval goes across.
    pub breaks: Vec<f64>,
    /// Short intervals are kept: a programme says what they are.
    pub keep_short: bool,
    /// By block, a change that is no motion though it is more than noise; empty where there is none.
    pub room: Vec<f64>,
}

/// Blocks `from..to` of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interval {
    pub from: usize,
    pub to: usize,
}

/// What was found, and what was left out and why.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found {
    pub intervals: Vec<Interval>,
    /// Steady, but much shorter than the others: pauses of the table.
    pub short: Vec<Interval>,
    /// Long intervals that are several dwells of one position by the clock of the others.
    pub split: usize,
    /// Shortest interval that was looked for, s.
    pub min_s: f64,
    /// How long those were that are shorter, s: dwells perhaps, no moments.
    pub too_short_s: Vec<f64>,
}

/// Without a stated shortest interval: so many samples' time, and at least this.
const LEAST_S: f64 = 2.0;
const LEAST_BLOCKS: f64 = 24.0;
/// Part of the shortest interval from which a shorter one may be a dwell.
const PART_OF_DWELL: f64 = 0.3;
/// Change between neighbouring means, in standard deviations of such changes, that is no noise. 10^7 normal values
/// pass 7 once in 10^5 logs.
const CHANGE: f64 = 7.0;
/// Growth of noise from one window to one of twice the length: white noise falls, flicker stays, motion doubles.
const GROWTH: f64 = 1.2;
/// Windows in a usual interval, over which slow motion is looked for.
const LONGEST_WINDOW: f64 = 12.0;
/// Change over an interval against the noise of short means that is a slow motion.
const DRIFT: f64 = 15.0;
/// Disturbances up to this share of an interval, and so long, are cut out of it: a table that goes to another position
/// and stops there takes longer.
const DISTURBANCE: f64 = 0.05;
const DISTURBANCE_S: f64 = 10.0;
/// Intervals so many times shorter than the next longer one may be pauses of the table: where they are between most
/// others, few in a row, and take little of the time, or where they are hardly any.
const SHORTER: f64 = 2.5;
const PAUSES: f64 = 0.2;
const PAUSES_IN_A_ROW: usize = 3;
const BETWEEN_MOST: f64 = 0.6;
const HARDLY_ANY: f64 = 0.1;
const HARDLY_ANY_TIME: f64 = 0.03;
/// Levels that a command takes at most, and the share of samples in which it changes.
const FEW_LEVELS: f64 = 20.0;
const SELDOM: f64 = 0.01;
/// Blocks over which a channel's noise may be another than elsewhere.
const LOCAL: usize = 48;
/// Growth of changes from single blocks to means over four, which double twice in a motion.
const SMOOTH: f64 = 2.4;
/// Quantile of |change| for the first guess of the noise, and what it is for a normal distribution.
const QUANTILE: f64 = 0.3;
const NORMAL_QUANTILE: f64 = 0.385_320_5;
/// Room for regular dwells: durations and pauses that agree so well are a programme's.
const REGULAR: f64 = 0.03;
/// What the first or last dwell may last, in regular ones.
const AT_AN_END: std::ops::Range<f64> = 0.7..1.4;

/// Finds the steady intervals of the channels `watched`.
///
/// A block is in motion where the means before and after it, over 1, 2, 4 ... blocks up to half of the shortest
/// interval, differ by more than seven standard deviations of such differences in any channel. The noise is a quantile
/// of these differences, then the median of those that are no motion. Gyros that turn are noisier than those at rest:
/// what exceeds the log's noise must also exceed that of the blocks around, averaged down as white noise is. Noise
/// averages, motion adds up: what is taken for noise must not grow with the window. What is left are intervals; short
/// disturbances between equal means are cut out, slow
/// motion is left out. The blocks of disturbances are taken out of the series, so that no mean has them.
pub fn find(series: &mut Series, watched: &[usize], search: &Search) -> Found {
    let min_s = search.min_s.unwrap_or_else(|| LEAST_S.max(LEAST_BLOCKS * series.block_s));
    let top = ((0.5 * min_s / series.block_s).log2().floor().max(0.0)) as u32;
    let whole = stretches(series, search, min_s);
    let mut moving = vec![false; series.number.len()];
    let mut noise = Vec::new();
    for &c in watched {
        noise.push(mark(&series.tracks[c], &whole, 0..=top, &search.room, &mut moving));
    }
    let channels: Vec<(&Track, f64)> = watched.iter().map(|&c| &series.tracks[c]).zip(noise.iter().copied()).collect();
    let mut quiet: Vec<Interval> =
        whole.iter().flat_map(|&(from, to)| merged(series, &channels, runs(&moving, from, to))).collect();
    take_out(series, &moving, &mut quiet);
    let channels: Vec<(&Track, f64)> = watched.iter().map(|&c| &series.tracks[c]).zip(noise).collect();
    let duration = |i: &Interval| series.end_s(i.to) - series.start_s(i.from);
    let is_dwell = |i: &&Interval| duration(i) < min_s && duration(i) >= PART_OF_DWELL * min_s;
    let mut too_short_s: Vec<f64> = quiet.iter().filter(is_dwell).map(duration).collect();
    too_short_s.sort_by(f64::total_cmp);
    quiet.retain(|i| duration(i) >= min_s);
    // A small step that is made slowly shows over longer times alone.
    let usual = quantile(quiet.iter().map(duration).collect(), 0.5);
    let longest = (usual / LONGEST_WINDOW / series.block_s).log2().floor().max(0.0) as u32;
    if longest > top && quiet.iter().any(|i| drifts(&channels, &search.room, i)) {
        let mut moving = vec![false; series.number.len()];
        let whole = stretches(series, search, min_s);
        for (track, _) in &channels {
            mark(track, &whole, top + 1..=longest, &search.room, &mut moving);
        }
        let again =
            |i: Interval| if drifts(&channels, &search.room, &i) { runs(&moving, i.from, i.to) } else { vec![i] };
        quiet = quiet.into_iter().flat_map(again).collect();
    }
    quiet.retain(|i| duration(i) >= min_s && !drifts(&channels, &search.room, i));
    let keep = search.keep_short || search.min_s.is_some();
    let (intervals, short) = if keep { (quiet, Vec::new()) } else { without_pauses(series, quiet) };
    let (intervals, split) = split_by_the_clock(series, intervals);
    Found { intervals, short, split, min_s, too_short_s }
}

/// Blocks one after the other, without a new log and without a gap that is longer than a dwell's disturbance.
fn stretches(series: &Series, search: &Search, min_s: f64) -> Vec<(usize, usize)> {
    let room = (2.0 * min_s / series.block_s).max(LEAST_BLOCKS) as i64;
    let mut found = Vec::new();
    let mut from = 0;
    for k in 1..=series.number.len() {
        let ends = k == series.number.len() || series.number[k] - series.number[k - 1] > room || {
            let (before, after) = (series.start_s(k - 1), series.start_s(k));
            search.breaks.iter().any(|&at| before < at && at <= after + 0.5 * series.block_s)
        };
        if ends && from < k {
            found.push((from, k));
            from = k;
        }
    }
    found
}

/// Marks the motion in one channel; the noise of differences between means of the longest kind.
fn mark(
    track: &Track,
    stretches: &[(usize, usize)],
    levels: RangeInclusive<u32>,
    room: &[f64],
    moving: &mut [bool],
) -> f64 {
    let mut noise = 0.0;
    let shortest: Vec<(usize, f64)> = stretches.iter().flat_map(|&s| changes(track, s, 1)).collect();
    let around = local(&shortest, track.mean.len());
    let mut most = f64::INFINITY;
    for level in levels {
        let half = 1_usize << level;
        let changes: Vec<(usize, f64)> = stretches.iter().flat_map(|&s| changes(track, s, half)).collect();
        if changes.is_empty() {
            continue;
        }
        let least = resolution(track) / (half as f64).sqrt();
        let of = |share: f64, normal: f64, of: Vec<f64>| (quantile(of, share) / normal).max(least);
        // What is clipped has no noise.
        let noisy = |c: &&(usize, f64)| track.whole || track.at_end[c.0] < 1.0;
        let sizes: Vec<f64> = changes.iter().filter(noisy).map(|c| c.1.abs()).collect();
        let rough = of(QUANTILE, NORMAL_QUANTILE, sizes.clone());
        let still: Vec<f64> = sizes.into_iter().filter(|c| *c <= CHANGE * rough).collect();
        let sigma = of(0.5, 1.0 / SD_OF_MEDIAN, still).min(rough.max(least)).min(most).max(least);
        most = GROWTH * sigma;
        let reach = half.div_ceil(2);
        let beyond = |c: &&(usize, f64)| {
            c.1.abs() > CHANGE * sigma
                && c.1.abs() > CHANGE * around[c.0 / LOCAL] / (half as f64).sqrt()
                && c.1.abs() > room.get(c.0).copied().unwrap_or(0.0)
        };
        for (at, _) in changes.iter().filter(beyond) {
            moving[at.saturating_sub(reach)..(at + reach).min(track.mean.len())].fill(true);
        }
        noise = sigma;
    }
    noise
}

/// Noise of neighbouring blocks, by pieces of the log.
fn local(changes: &[(usize, f64)], blocks: usize) -> Vec<f64> {
    let mut pieces: Vec<Vec<f64>> = vec![Vec::new(); blocks / LOCAL + 1];
    for (at, change) in changes {
        pieces[at / LOCAL].push(change.abs());
    }
    pieces.into_iter().map(|piece| SD_OF_MEDIAN * quantile(piece, 0.5)).collect()
}

/// Half a count of the converter. A channel of few levels that changes hardly ever is a command: it has no noise.
fn resolution(track: &Track) -> f64 {
    let range = track.most - track.least;
    let is_command = range <= FEW_LEVELS * track.step && track.changes < SELDOM;
    let counts = if is_command { 0.0 } else { 0.5 * track.step };
    counts.max(1e-9 * range)
}

/// Difference of the means of `half` blocks before and after each block, with the block.
fn changes(track: &Track, (from, to): (usize, usize), half: usize) -> Vec<(usize, f64)> {
    let origin = track.mean[from];
    let (mut sums, mut counts) = (vec![0.0], vec![0.0]);
    for k in from..to {
        let n = track.weight[k];
        sums.push(sums[k - from] + n * (track.mean[k] - origin));
        counts.push(counts[k - from] + n);
    }
    let mean = |a: usize, b: usize| (sums[b] - sums[a]) / (counts[b] - counts[a]);
    let last = (to - from).saturating_sub(half);
    (half..=last).map(|k| (from + k, mean(k, k + half) - mean(k - half, k))).collect()
}

pub(super) fn quantile(mut of: Vec<f64>, share: f64) -> f64 {
    if of.is_empty() {
        return 0.0;
    }
    let k = ((of.len() - 1) as f64 * share).round() as usize;
    *of.select_nth_unstable_by(k, f64::total_cmp).1
}

fn runs(moving: &[bool], from: usize, to: usize) -> Vec<Interval> {
    let mut found: Vec<Interval> = Vec::new();
    for k in (from..to).filter(|&k| !moving[k]) {
        match found.last_mut() {
            Some(run) if run.to == k => run.to = k + 1,
            _ => found.push(Interval { from: k, to: k + 1 }),
        }
    }
    found
}

/// Joins runs of equal means between which there is no more than a disturbance: a spike, a knock, a few lost samples.
fn merged(series: &Series, channels: &[(&Track, f64)], runs: Vec<Interval>) -> Vec<Interval> {
    let mut found: Vec<Interval> = Vec::new();
    for run in runs {
        if let Some(before) = found.last_mut() {
            let whole = series.end_s(run.to) - series.start_s(before.from);
            let between = series.start_s(run.from) - series.end_s(before.to);
            let alike = |&(track, noise): &(&Track, f64)| {
                let difference = track.mean_of(before.from, before.to) - track.mean_of(run.from, run.to);
                difference.abs() <= CHANGE * noise
            };
            if between <= DISTURBANCE_S.min(DISTURBANCE * whole) && channels.iter().all(alike) {
                before.to = run.to;
                continue;
            }
        }
        found.push(run);
    }
    found
}

/// Takes the blocks in motion within intervals out of the series, and out of the intervals.
fn take_out(series: &mut Series, moving: &[bool], intervals: &mut [Interval]) {
    let mut kept = vec![true; series.number.len()];
    for interval in intervals.iter() {
        for k in interval.from..interval.to {
            kept[k] = !moving[k];
        }
    }
    let before: Vec<usize> = std::iter::once(0)
        .chain(kept.iter().scan(0, |sum, &kept| {
            *sum += usize::from(kept);
            Some(*sum)
        }))
        .collect();
    for interval in intervals {
        *interval = Interval { from: before[interval.from], to: before[interval.to] };
    }
    series.keep(&kept);
}

/// Whether a channel changes from the first to the last quarter as only motion does.
fn drifts(channels: &[(&Track, f64)], room: &[f64], run: &Interval) -> bool {
    let room = room.get((run.from + run.to) / 2).copied().unwrap_or(0.0);
    let quarter = (run.to - run.from).div_ceil(4);
    channels.iter().any(|(track, noise)| {
        let change = track.mean_of(run.to - quarter, run.to) - track.mean_of(run.from, run.from + quarter);
        change.abs() > DRIFT * noise && change.abs() > room
    })
}

/// Whether what a channel does in an interval is a smooth motion: means over four blocks change more from one to the
/// next than single blocks do, by more than those of a random walk (1.7 times), and means over sixteen no less.
pub fn is_motion(track: &Track, run: Interval) -> bool {
    let change = |blocks: usize| {
        let changes = changes(track, (run.from, run.to), blocks);
        quantile(changes.into_iter().map(|(_, change)| change.abs()).collect(), 0.5)
    };
    change(4) > SMOOTH * change(1).max(resolution(track)) && change(16) > change(4)
}

/// Takes out what is much shorter than everything else and stands between most of it, or is hardly there.
fn without_pauses(series: &Series, found: Vec<Interval>) -> (Vec<Interval>, Vec<Interval>) {
    let duration = |i: &Interval| series.end_s(i.to) - series.start_s(i.from);
    let mut lengths: Vec<f64> = found.iter().map(duration).collect();
    lengths.sort_by(f64::total_cmp);
    let steps = lengths.windows(2).filter(|pair| pair[1] > SHORTER * pair[0]);
    let least = steps.map(|pair| pair[1]).filter(|&least| are_pauses(&found, least, duration)).fold(0.0, f64::max);
    found.into_iter().partition(|i| duration(i) >= least)
}

fn are_pauses(found: &[Interval], least: f64, duration: impl Fn(&Interval) -> f64) -> bool {
    let sum = |short: bool| found.iter().map(&duration).filter(|d| (*d < least) == short).sum::<f64>();
    let share = sum(true) / (sum(true) + sum(false));
    let runs: Vec<usize> = found
        .chunk_by(|a, b| (duration(a) < least) == (duration(b) < least))
        .filter(|run| duration(&run[0]) < least)
        .map(<[Interval]>::len)
        .collect();
    let short: usize = runs.iter().sum();
    let between = (found.len() - short).saturating_sub(1) as f64;
    let everywhere = runs.iter().all(|run| *run <= PAUSES_IN_A_ROW) && runs.len() as f64 >= BETWEEN_MOST * between;
    let hardly = short as f64 <= HARDLY_ANY * found.len() as f64 && share <= HARDLY_ANY_TIME;
    share <= PAUSES && everywhere || hardly
}

/// Splits an interval that lasts as long as k regular dwells and the pauses between them: one position twice, between
/// which nothing moved. The first and the last dwell may begin earlier or end later than by the clock, and are split in
/// two at most: a station may stand still for long before and after its programme.
fn split_by_the_clock(series: &Series, found: Vec<Interval>) -> (Vec<Interval>, usize) {
    let Some((dwell, period)) = clock(series, &found) else { return (found, 0) };
    let mut split = 0;
    let mut parts = Vec::new();
    let last = found.len() - 1;
    for (place, interval) in found.into_iter().enumerate() {
        let (start, end) = (series.start_s(interval.from), series.end_s(interval.to));
        let more = ((end - start - dwell) / period).round();
        let is_regular = (end - start - dwell - more * period).abs() <= REGULAR * dwell;
        let at_end = (place == 0 || place == last) && AT_AN_END.contains(&((end - start - period) / dwell));
        let times = if at_end { 1.0 } else { more };
        if times < 1.0 || !(is_regular || at_end) {
            parts.push(interval);
            continue;
        }
        split += times as usize;
        let anchor = if place == 0 { end - dwell - times * period } else { start };
        let block = |time: f64| {
            let before = series.number[interval.from..interval.to].iter();
            interval.from + before.take_while(|&&n| (n as f64 + 0.5) * series.block_s < time).count()
        };
        for k in 0..=(times as usize) {
            let begin = anchor + k as f64 * period;
            let stop = if k == times as usize { end } else { begin + dwell };
            let (from, to) = (block(begin), block(stop));
            parts.push(Interval { from, to: to.max(from + 1) });
        }
    }
    (parts, split)
}

/// Duration of a dwell and time from one to the next, where nine of ten keep both.
fn clock(series: &Series, found: &[Interval]) -> Option<(f64, f64)> {
    const FEW: usize = 8;
    if found.len() < FEW {
        return None;
    }
    let durations: Vec<f64> = found.iter().map(|i| series.end_s(i.to) - series.start_s(i.from)).collect();
    let dwell = quantile(durations.clone(), 0.5);
    let pauses: Vec<f64> = found.windows(2).map(|p| series.start_s(p[1].from) - series.end_s(p[0].to)).collect();
    let pause = quantile(pauses.clone(), 0.5);
    let keeps = |of: &[f64], usual: f64| {
        let kept = of.iter().filter(|d| (*d - usual).abs() <= REGULAR * dwell).count();
        10 * kept >= 8 * of.len()
    };
    (keeps(&durations, dwell) && keeps(&pauses, pause)).then_some((dwell, dwell + pause))
}
