//! Which part of an interval is averaged, and how far its means are known.

use super::blocks::{Series, Track};
use super::intervals::Interval;
use super::noise::{Noise, NoiseOctaves, Octave, octaves};

/// Share of an interval that is cut off each end where nothing else is said.
const EDGE: f64 = 0.01;
/// Part of an interval in which it may still be settling.
const SETTLING: usize = 5;
/// Part of an interval that is compared with the rest, and how many such parts an end may lose.
const PART: usize = 16;
const MOST_PARTS: usize = 6;
/// Difference of a part from the rest, in standard deviations, that is settling.
const UNSETTLED: f64 = 4.5;
/// Part of the longest time from which rounding to whole pulses is the noise of phase that the model says: in shorter
/// ones none or one is counted.
const OF_PULSES: f64 = 32.0;

/// The interval without its edges: `cut_s` at each end, or a hundredth and a block.
pub fn without_edges(series: &Series, interval: Interval, cut_s: Option<f64>) -> Option<Interval> {
    let blocks = interval.to - interval.from;
    let cut = match cut_s {
        Some(cut) => (cut / series.block_s).ceil() as usize,
        None => 1 + (EDGE * blocks as f64) as usize,
    };
    (blocks > 2 * cut + 1).then(|| Interval { from: interval.from + cut, to: interval.to - cut })
}

/// The interval without its first fifth, in which it may still be settling.
pub fn later(interval: Interval) -> Interval {
    Interval { from: interval.from + (interval.to - interval.from) / SETTLING, ..interval }
}

/// Noise of the outputs at rest and in turns.
pub fn noise(series: &Series, outputs: &[&Track], still: &[Interval], turning: &[Interval]) -> Vec<[Noise; 2]> {
    let shown = |track: &&Track| {
        let of = |i: &Interval| octaves_of(series, track, *i);
        let pooled = |intervals: &[Interval]| intervals.iter().flat_map(of).collect();
        NoiseOctaves { still: pooled(still), turning: pooled(turning), pulse: track.pulse }
    };
    Noise::fit_all(&outputs.iter().map(shown).collect::<Vec<_>>())
}

/// The interval without what has not settled: ends whose mean differs from that of the rest by more than noise does.
pub fn settled(series: &Series, channels: &[(&Track, Noise)], interval: Interval) -> Interval {
    let part = ((interval.to - interval.from) / PART).max(1);
    let mut kept = interval;
    let unsettled = |end: Interval, rest: Interval| {
        let tau = part as f64 * series.block_s;
        channels.iter().any(|(track, noise)| {
            let off = track.mean_of(end.from, end.to) - track.mean_of(rest.from, rest.to);
            let allowed = (2.0 * noise.allan(tau)).sqrt();
            allowed > 0.0 && off.abs() > UNSETTLED * allowed
        })
    };
    for _ in 0..MOST_PARTS {
        let cut = kept.from + part;
        if !unsettled(Interval { to: cut, ..kept }, Interval { from: cut, ..kept }) {
            break;
        }
        kept.from = cut;
    }
    for _ in 0..MOST_PARTS {
        let cut = kept.to - part;
        if !unsettled(Interval { from: cut, ..kept }, Interval { to: cut, ..kept }) {
            break;
        }
        kept.to = cut;
    }
    kept
}

/// Octaves of a channel over an interval; of whole pulses the longest alone.
fn octaves_of(series: &Series, track: &Track, i: Interval) -> Vec<Octave> {
    let mut found = octaves(&track.mean[i.from..i.to], &track.weight[i.from..i.to], series.block_s);
    let longest = found.last().map_or(0.0, |o| o.tau_s);
    found.retain(|o| track.pulse == 0.0 || o.tau_s > longest / OF_PULSES);
    found
}

/// Standard error of a channel's mean over an interval. Where the noise `differs` from dwell to dwell, and rounding or
/// white noise is plainly other in this one than in those that the noise is of, it is its own: where stamps jitter, it
/// goes with the rate of turn. Of a converter that reads the same all the while it is that of one reading,
/// count/sqrt(12): no noise rounds it sometimes up and sometimes down.
pub fn standard_error(
    series: &Series,
    track: &Track,
    (noise, differs): (&Noise, bool),
    interval: Interval,
    sample_s: f64,
) -> f64 {
    let dwell_s = series.end_s(interval.to) - series.start_s(interval.from);
    let samples: f64 = track.weight[interval.from..interval.to].iter().sum();
    let log_s = series.end_s(series.number.len()) - series.start_s(0);
    let own = if differs { noise.with_own(&octaves_of(series, track, interval), track.pulse) } else { *noise };
    let of_noise = own.standard_error(dwell_s, (samples * sample_s).min(dwell_s), log_s);
    let first = track.mean[interval.from];
    let reads_the_same = (interval.from..interval.to).all(|k| track.spread[k] == 0.0 && track.mean[k] == first);
    let of_rounding = if reads_the_same && track.pulse == 0.0 { track.step / 12_f64.sqrt() } else { 0.0 };
    of_noise.max(of_rounding)
}
