//! Which part of an interval is averaged, and how far its means are known.

use super::blocks::{Series, Track};
use super::intervals::Interval;
use super::noise::{Noise, Shown, octaves};

/// Share of an interval that is cut off each end where nothing else is said.
const EDGE: f64 = 0.01;
/// Part of an interval in which it may still be settling.
const SETTLING: usize = 5;
/// Part of an interval that is compared with the rest, and how many such parts an end may lose.
const PART: usize = 16;
const MOST_PARTS: usize = 6;
/// Difference of a part from the rest, in standard deviations, that is settling.
const UNSETTLED: f64 = 4.5;
/// Pairs that say something of a dwell's own noise, and how far it must be from that of the others.
const OWN_PAIRS: f64 = 30.0;
const OWN_NOISE: f64 = 4.0;

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
        let of = |i: &Interval| octaves(&track.mean[i.from..i.to], &track.weight[i.from..i.to], series.block_s);
        let pooled = |intervals: &[Interval]| intervals.iter().flat_map(of).collect();
        Shown { still: pooled(still), turning: pooled(turning), pulse: track.pulse }
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

/// Standard error of a channel's mean over an interval. Where white noise is plainly other in this dwell than in those
/// that the noise is of, it is its own. Of a converter that reads the same all the while it is that of one reading,
/// count/sqrt(12): no noise rounds it sometimes up and sometimes down.
pub fn standard_error(series: &Series, track: &Track, noise: &Noise, interval: Interval, sample_s: f64) -> f64 {
    let dwell_s = series.end_s(interval.to) - series.start_s(interval.from);
    let samples: f64 = track.weight[interval.from..interval.to].iter().sum();
    let log_s = series.end_s(series.number.len()) - series.start_s(0);
    let own = own_noise(series, track, noise, interval).unwrap_or(*noise);
    let of_noise = own.standard_error(dwell_s, (samples * sample_s).min(dwell_s), log_s);
    let first = track.mean[interval.from];
    let reads_the_same = (interval.from..interval.to).all(|k| track.spread[k] == 0.0 && track.mean[k] == first);
    let of_rounding = if reads_the_same && track.pulse == 0.0 { track.step / 12_f64.sqrt() } else { 0.0 };
    of_noise.max(of_rounding)
}

fn own_noise(series: &Series, track: &Track, noise: &Noise, interval: Interval) -> Option<Noise> {
    let blocks = interval.from..interval.to;
    let own = octaves(&track.mean[blocks.clone()], &track.weight[blocks], series.block_s);
    let longest = own.last()?.tau_s;
    let told = own.iter().filter(|o| o.tau_s > longest / 128.0 && o.pairs >= 4.0 && noise.is_white(o.tau_s));
    let (mut ratio, mut pairs) = (0.0, 0.0);
    for octave in told {
        ratio += octave.pairs * octave.variance / noise.allan(octave.tau_s).max(1e-300);
        pairs += octave.pairs;
    }
    let ratio = ratio / pairs;
    (pairs >= OWN_PAIRS && (ratio.ln()).abs() > OWN_NOISE * (2.0 / pairs).sqrt()).then(|| noise.with_white(ratio))
}
