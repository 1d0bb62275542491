use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::averages::{later, noise, settled, standard_error, without_edges};
use super::blocks::{Blocks, Series};
use super::intervals::{Found, Interval, Search, find};
use super::noise::{Noise, octaves};
use super::programme::{
    LoggedInterval, Position, Table, align, attitude, clock_factor, clock_offset, exchanged, twenty_four,
};
use crate::core::campaign::Site;

/// White noise of standard deviation `white` a sample, and flicker h/f made of Gauss-Markov processes, two an octave,
/// from a few samples to much more than the log: each has variance h ln(sqrt 2) of an octave's half.
struct Source {
    rng: ChaCha8Rng,
    white: f64,
    states: Vec<(f64, f64, f64)>,
}

impl Source {
    fn new(seed: u64, step_s: f64, log_s: f64, white: f64, h: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let slowest = log_s / TAU;
        let sd = (h * 0.5 * std::f64::consts::LN_2).sqrt();
        let times = std::iter::successors(Some(slowest), |t| Some(t / 2f64.sqrt())).take_while(|t| *t > 2.0 * step_s);
        let states = times
            .map(|time| {
                let keep = (-step_s / time).exp();
                (sd * rng.sample::<f64, _>(StandardNormal), keep, sd * (1.0 - keep * keep).sqrt())
            })
            .collect();
        Self { rng, white, states }
    }

    fn next(&mut self) -> f64 {
        let mut value = self.white * self.rng.sample::<f64, _>(StandardNormal);
        for (state, keep, kick) in &mut self.states {
            *state = *state * *keep + *kick * self.rng.sample::<f64, _>(StandardNormal);
            value += *state;
        }
        value
    }
}

const DWELL_S: f64 = 180.0;
const PAUSE_S: f64 = 60.0;
const SLEW_S: f64 = 15.0;
const DWELLS: usize = 78;

/// A log of three gyros: dwells of a level each, slews between them, jitter, lost samples and spikes.
fn log(seed: u64, hz: f64) -> (Series, Vec<[f64; 3]>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    let log_s = DWELLS as f64 * (DWELL_S + PAUSE_S);
    let step = hz.recip();
    let mut sources: Vec<Source> =
        (0..3).map(|k| Source::new(3 * seed + k, step, log_s, 0.02 * hz.sqrt(), 1e-6)).collect();
    let mut levels: Vec<[f64; 3]> = (0..DWELLS).map(|_| [0; 3].map(|_| rng.random_range(-30.0..30.0))).collect();
    // Now and then a position is taken twice in a row, and nothing moves between.
    for k in 1..DWELLS {
        if rng.random_range(0.0..1.0) < 0.02 {
            levels[k] = levels[k - 1];
        }
    }
    let mut blocks = Blocks::new(3, step);
    let samples = (log_s * hz) as usize;
    for k in 0..samples {
        let time = k as f64 * step;
        let noise: Vec<f64> = sources.iter_mut().map(Source::next).collect();
        if rng.random_range(0.0..1.0) < 1e-3 {
            continue;
        }
        let dwell = (time / (DWELL_S + PAUSE_S)) as usize;
        let into = time - dwell as f64 * (DWELL_S + PAUSE_S) - DWELL_S;
        let next = levels[(dwell + 1).min(DWELLS - 1)];
        let share = (into / SLEW_S).clamp(0.0, 1.0);
        let share = share * share * (3.0 - 2.0 * share);
        // What turns fast is noisier: a third of the dwells by up to three times.
        let louder = 0.02 * hz.sqrt() * (levels[dwell][0] - 10.0).max(0.0) / 10.0;
        let extra: Vec<f64> = (0..3).map(|_| louder * rng.sample::<f64, _>(StandardNormal)).collect();
        let value = |c: usize| levels[dwell][c] * (1.0 - share) + next[c] * share + noise[c] + extra[c];
        let spike = if rng.random_range(0.0..1.0) < 2e-6 { 500.0 } else { 0.0 };
        let jitter = 0.1 * step * rng.random_range(-1.0..1.0);
        blocks.push(time + jitter, &[value(0) + spike, value(1), value(2)]);
    }
    (Series::join(vec![blocks]), levels)
}

fn found(series: &mut Series) -> Found {
    find(series, &[0, 1, 2], &Search { min_s: None, breaks: Vec::new(), keep_short: false, room: Vec::new() })
}

/// Logs in which dwells are missed or invented, and errors of means in standard errors.
fn measure(seeds: std::ops::Range<u64>, hz: f64) -> (usize, Vec<f64>) {
    let (mut wrong, mut errors) = (0, Vec::new());
    for seed in seeds {
        let (mut series, levels) = log(seed, hz);
        let found = found(&mut series);
        // The next position is held before its dwell begins.
        let starts: Vec<f64> = found.intervals.iter().map(|i| series.start_s(i.from)).collect();
        let at = |k: usize| (starts[k] / (DWELL_S + PAUSE_S)).round() as usize;
        if found.intervals.len() != DWELLS || (0..DWELLS).any(|k| at(k) != k) {
            wrong += 1;
            continue;
        }
        let cut: Vec<Interval> = found.intervals.iter().filter_map(|i| without_edges(&series, *i, None)).collect();
        let of = noise(&series, &series.tracks.iter().collect::<Vec<_>>(), &cut, &[]);
        for (c, (track, [of, _])) in series.tracks.iter().zip(of).enumerate() {
            for (k, interval) in cut.iter().enumerate() {
                let interval = settled(&series, &[(track, of)], *interval);
                let sem = standard_error(&series, track, (&of, true), interval, hz.recip());
                errors.push((track.mean_of(interval.from, interval.to) - levels[k][c]) / sem);
            }
        }
    }
    (wrong, errors)
}

/// `GYROWATCH_LOGS=100 cargo test --lib dwells_are -- --nocapture` prints the figures of as many logs.
#[test]
fn dwells_are_found_unbiased_and_as_well_known_as_they_say() {
    let logs: u64 = std::env::var("GYROWATCH_LOGS").ok().and_then(|n| n.parse().ok()).unwrap_or(12);
    let (wrong, errors) = measure(1..1 + logs, 5.0);
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
    println!("logs {logs}, with a dwell missed or invented {wrong}; error/sd: mean {mean:+.3}, rms {rms:.3}");
    assert_eq!(wrong, 0);
    assert!(mean.abs() < 0.25, "{mean}");
    assert!((0.9..1.1).contains(&rms), "{rms}");
}

#[test]
fn blocks_that_are_halved_hold_the_same_sums() {
    let (mut fine, mut coarse) = (Blocks::with_room(1, 0.01, 1 << 16), Blocks::with_room(1, 0.01, 64));
    for k in 0..10_000 {
        let value = [1e6 + f64::from(k % 7)];
        fine.push(f64::from(k) * 0.01, &value);
        coarse.push(f64::from(k) * 0.01, &value);
    }
    let [fine, coarse] = [fine, coarse].map(|blocks| Series::join(vec![blocks]));
    assert!(coarse.number.len() <= 64 && coarse.block_s > 1.0);
    let whole = |s: &Series| s.tracks[0].mean_of(0, s.number.len());
    assert!((whole(&fine) - whole(&coarse)).abs() < 1e-9);
    let expected = 1e6 + (0..10_000).map(|k| f64::from(k % 7)).sum::<f64>() / 1e4;
    assert!((whole(&coarse) - expected).abs() < 1e-9);
    assert!((coarse.tracks[0].spread[3] - 2.0).abs() < 0.1, "sd of 0..6 is 2");
    assert_eq!(coarse.tracks[0].step, 1.0);
}

/// Dwells of 60 s, half a minute of slew between: how many are found, s in all, and the shortest that was looked for.
#[test]
fn a_clock_that_is_a_little_slow_changes_little() {
    let found = |step_s: f64| {
        let mut rng = ChaCha8Rng::seed_from_u64(14);
        let mut blocks = Blocks::new(1, step_s);
        for k in 0..(1800.0 / step_s) as u32 {
            let time = f64::from(k) * step_s;
            let (dwell, into) = ((time / 90.0) as u32, time % 90.0);
            let level = |dwell: u32| f64::from(7 * dwell % 11);
            let share = ((into - 60.0) / 30.0).clamp(0.0, 1.0);
            let noise = 0.01 * rng.sample::<f64, _>(StandardNormal);
            blocks.push(time, &[level(dwell) * (1.0 - share) + level(dwell + 1) * share + noise]);
        }
        let mut series = Series::join(vec![blocks]);
        let search = Search { min_s: None, breaks: Vec::new(), keep_short: false, room: Vec::new() };
        let found = find(&mut series, &[0], &search);
        let seconds: f64 = found.intervals.iter().map(|i| series.end_s(i.to) - series.start_s(i.from)).sum();
        (found.intervals.len(), seconds, found.min_s)
    };
    let (count, whole, least) = found(1.0);
    assert_eq!((count, least), (20, 24.0));
    for step_s in [1.000_000_1, 1.000_01, 1.005, 1.02] {
        let (count, seconds, least) = found(step_s);
        assert_eq!(count, 20, "{step_s}");
        assert!((seconds / whole - 1.0).abs() < 0.05 && (24.0..24.6).contains(&least), "{step_s}: {seconds} {whole}");
    }
    let (count, seconds, least) = found(1.28);
    assert!(count == 20 && seconds > 0.75 * whole && least < 31.0, "{count} {seconds} {whole} {least}");
}

#[test]
fn logs_beside_one_another_share_their_blocks() {
    let (mut fast, mut slow) = (Blocks::new(1, 0.01), Blocks::new(1, 0.1));
    for k in 0..1000 {
        fast.push(f64::from(k) * 0.01, &[1.0]);
    }
    for k in 0..50 {
        slow.push(5.0 + f64::from(k) * 0.1, &[2.0]);
    }
    let series = Series::join(vec![fast, slow]);
    assert_eq!((series.tracks[0].mean[0], series.tracks[1].mean[0]), (1.0, 2.0));
    assert!((series.start_s(0) - 5.0).abs() <= series.block_s);
    let mut slow = Blocks::new(1, 1.28);
    let mut fast = Blocks::beside(1, 0.01, slow.unit_s());
    (0..10).for_each(|k| slow.push(f64::from(k) * 1.28, &[1.0]));
    (0..1000).for_each(|k| fast.push(f64::from(k) * 0.01, &[2.0]));
    let series = Series::join(vec![slow, fast]);
    assert_eq!((series.block_s, &*series.number), (1.28, &[0, 1, 2, 3, 4, 5, 6, 7][..]));
    assert_eq!(series.tracks[1].weight[1], 128.0);
}

#[test]
fn the_noise_of_known_parts_is_found_again() {
    // White of 1 at 1 s: A(tau) = 1/tau. The Allan variance of flicker h/f is 2 ln 2 h at every tau.
    let step = 0.1;
    let pooled = |h: f64| {
        let mut all = Vec::new();
        for seed in 0..60 {
            let mut source = Source::new(100 + seed, step, 7200.0, (1.0 / step).sqrt(), h);
            let values: Vec<f64> = (0..2000).map(|_| source.next()).collect();
            all.extend(octaves(&values, &vec![1.0; values.len()], step));
        }
        Noise::fit(&all, 0.0)
    };
    let white = pooled(0.0);
    assert!((white.white() - 1.0).abs() < 0.03, "{}", white.white());
    assert!((white.standard_error(200.0, 200.0, 200.0) * 200f64.sqrt() - 1.0).abs() < 0.25);
    let both = pooled(0.05);
    let floor = (2.0 * std::f64::consts::LN_2 * 0.05_f64).sqrt();
    assert!((both.flicker() / floor - 1.0).abs() < 0.15, "{} for {floor}", both.flicker());
}

#[test]
fn a_log_that_moves_all_the_time_has_no_interval() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut blocks = Blocks::new(3, 0.01);
    for k in 0..6000 {
        let t = f64::from(k) * 0.01;
        let wave = |f: f64, p: f64| 30.0 * (TAU * f * t + p).sin() + 12.0 * (TAU * 2.3 * f * t).sin();
        let noise = 0.1 * rng.sample::<f64, _>(StandardNormal);
        blocks.push(t, &[wave(0.21, 0.0) + noise, wave(0.34, 1.0), wave(0.17, 2.0)]);
    }
    assert!(found(&mut Series::join(vec![blocks])).intervals.is_empty());
}

#[test]
fn the_last_bit_of_a_converter_is_no_motion() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut blocks = Blocks::new(2, 0.01);
    // Two levels of a converter, held for ten samples each; and a command that never changes.
    let mut level = 0.0;
    for k in 0..1000 {
        if k % 10 == 0 {
            level = f64::from(u8::from(rng.random_range(0.0..1.0) < 0.4)) * 0.02;
        }
        blocks.push(f64::from(k) * 0.01, &[level, 90.0]);
    }
    let mut series = Series::join(vec![blocks]);
    let found =
        find(&mut series, &[0, 1], &Search { min_s: None, breaks: Vec::new(), keep_short: false, room: Vec::new() });
    assert_eq!(found.intervals.len(), 1, "{found:?}");
}

#[test]
fn one_position_taken_twice_is_cut_by_the_clock_of_the_others() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut blocks = Blocks::new(1, 0.1);
    // Dwells of 60 s every 80 s; the fifth and sixth in one position.
    let levels = [0.0, 5.0, 1.0, 6.0, 3.0, 3.0, 8.0, 2.0, 9.0, 4.0, 7.0, 1.5];
    for k in 0..9600 {
        let t = f64::from(k) * 0.1;
        let (dwell, into) = ((t / 80.0) as usize, t % 80.0);
        let next = levels[(dwell + 1).min(11)];
        let share = if into < 60.0 { 0.0 } else { (into - 60.0) / 20.0 };
        let level = levels[dwell] * (1.0 - share) + next * share;
        blocks.push(t, &[level + 0.01 * rng.sample::<f64, _>(StandardNormal)]);
    }
    let mut series = Series::join(vec![blocks]);
    let found =
        find(&mut series, &[0], &Search { min_s: None, breaks: Vec::new(), keep_short: false, room: Vec::new() });
    assert_eq!((found.intervals.len(), found.split), (12, 1));
    let starts: Vec<f64> = found.intervals.iter().map(|i| (series.start_s(i.from) / 80.0).fract()).collect();
    assert!(starts.iter().all(|s| *s < 0.04 || *s > 0.97), "{starts:?}");
}

#[test]
fn what_has_not_settled_is_cut_off() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut blocks = Blocks::new(1, 0.1);
    for k in 0..2000 {
        let t = f64::from(k) * 0.1;
        let settling = 0.3 * (-t / 8.0).exp();
        blocks.push(t, &[10.0 + settling + 0.05 * rng.sample::<f64, _>(StandardNormal)]);
    }
    let series = Series::join(vec![blocks]);
    let whole = Interval { from: 0, to: series.number.len() };
    let track = &series.tracks[0];
    let kept = settled(&series, &[(track, noise(&series, &[track], &[later(whole)], &[])[0][0])], whole);
    assert!(series.start_s(kept.from) > 12.0 && kept.to == whole.to, "{kept:?}");
    assert!((track.mean_of(kept.from, kept.to) - 10.0).abs() < 0.008);
}

#[test]
fn twenty_four_positions_are_all_rotations_and_all_different() {
    let all = twenty_four();
    assert_eq!(all.len(), 24);
    for (k, one) in all.iter().enumerate() {
        let matrix = one.attitude.matrix();
        assert!((matrix.determinant() - 1.0).abs() < 1e-12);
        assert!(all[..k].iter().all(|other| (other.attitude.matrix() - matrix).norm() > 1.0));
    }
}

#[test]
fn a_table_turns_the_body_as_its_axes_say() {
    // Outer axis north, inner axis body Z, zero: body X east, Y north, Z up.
    let zero = attitude(Vector3::z(), Vector3::y()).unwrap();
    let table = Table { outer: Vector3::y(), inner: Vector3::z(), zero };
    let up = |outer: f64, inner: f64| {
        let up = table.attitude(outer.to_radians(), inner.to_radians()).up();
        [up.x, up.y, up.z].map(|c| c.round() as i32)
    };
    assert_eq!(up(0.0, 0.0), [0, 0, 1]);
    // Turned by +90 deg about north, body Z points east, and -X points up.
    assert_eq!(up(90.0, 0.0), [-1, 0, 0]);
    assert_eq!(up(90.0, 90.0), [0, 1, 0]);
    assert!((table.turn((0.0, 0.3), (0.0, 360.0)) - 360.0).abs() < 1e-9);
    assert!(table.turn((TAU / 4.0, 0.0), (0.0, 360.0)).abs() < 1e-9, "the inner axis is level");
    let site = Site { latitude: 0.6, gravity_g0: 0.999, magnetic_field_nav: None };
    let turning = Position { attitude: zero, turn_arcsec_s: 360.0, start_s: None, duration_s: None };
    let (force, rate) = turning.commanded(&site);
    assert!((force - Vector3::new(0.0, 0.0, 0.999)).norm() < 1e-12);
    assert!((rate - Vector3::new(0.0, 0.0, 360.0 + 15.041_067_178_669 * 0.6_f64.sin())).norm() < 1e-9);
}

#[test]
fn a_programme_is_laid_over_what_was_seen() {
    let programme = twenty_four();
    let seen = |k: usize| LoggedInterval {
        up: Some(programme[k].up() + Vector3::new(0.01, -0.01, 0.02)),
        turn_arcsec_s: None,
    };
    // The first position is missing, something else happened after the tenth, and the last was not reached.
    let mut all: Vec<LoggedInterval> = (1..23).map(seen).collect();
    all.insert(10, LoggedInterval { up: Some(Vector3::new(1.0, 1.0, 1.0)), turn_arcsec_s: None });
    let found = align(&all, &programme);
    assert_eq!(found[10], None);
    let places: Vec<usize> = found.iter().flatten().copied().collect();
    assert_eq!(places.len(), 22);
    assert!(places.windows(2).all(|p| p[0] < p[1]));
    assert!(
        places
            .iter()
            .zip(all.iter().enumerate().filter(|(k, _)| *k != 10))
            .all(|(&j, (_, s))| { s.up.unwrap().normalize().dot(&programme[j].up()) > 0.99 })
    );
}

#[test]
fn the_programmes_clock_is_found_in_the_log() {
    let timed = |k: usize| Position { start_s: Some(240.0 * k as f64), duration_s: Some(180.0), ..twenty_four()[k] };
    let programme: Vec<Position> = (0..24).map(timed).collect();
    let spans: Vec<(f64, f64)> = (0..24).map(|k| (37.0 + 240.0 * k as f64, 37.0 + 240.0 * k as f64 + 180.0)).collect();
    let blind = [LoggedInterval { up: None, turn_arcsec_s: None }; 24];
    let found = clock_offset(&spans, &blind, &programme).unwrap();
    assert!((found.offset_s - 37.0).abs() < 1e-9 && found.rival_s.is_none(), "{found:?}");
    assert_eq!(clock_offset(&spans, &blind, &twenty_four()), None);
    // Without the first two, nothing says which they are: but what points up does, or a clock that both share.
    let late = clock_offset(&spans[2..], &blind[2..], &programme).unwrap();
    assert!(late.rival_s.is_some_and(|rival| (rival - late.offset_s).abs() >= 239.0), "{late:?}");
    let seen: Vec<LoggedInterval> =
        programme.iter().map(|p| LoggedInterval { up: Some(p.up()), turn_arcsec_s: None }).collect();
    let late = clock_offset(&spans[2..], &seen[2..], &programme).unwrap();
    assert!((late.offset_s - 37.0).abs() < 1e-9 && late.rival_s.is_none(), "{late:?}");
    let shared: Vec<(f64, f64)> = spans[2..].iter().map(|(from, to)| (from - 37.0, to - 37.0)).collect();
    let one = clock_offset(&shared, &blind[2..], &programme).unwrap();
    assert!(one.offset_s.abs() < 1e-9 && one.rival_s.is_none(), "{one:?}");
}

#[test]
fn times_in_another_unit_are_known_by_the_length_of_their_dwells() {
    let timed = |k: usize, unit: f64| {
        let (start_s, duration_s) = (Some(unit * 240.0 * k as f64), Some(unit * 180.0));
        Position { start_s, duration_s, ..twenty_four()[k] }
    };
    let programme = |unit: f64| -> Vec<Position> { (0..24).map(|k| timed(k, unit)).collect() };
    let spans: Vec<(f64, f64)> = (0..24).map(|k| (240.0 * k as f64 + 4.0, 240.0 * k as f64 + 170.0)).collect();
    let blind = [LoggedInterval { up: None, turn_arcsec_s: None }; 24];
    assert_eq!(clock_factor(&spans, &blind, &programme(1e3)), Some(1e-3));
    assert_eq!(clock_factor(&spans, &blind, &programme(1.0 / 60.0)), Some(60.0));
    // Few intervals of the programme were found: a thousandth of it lies in any one.
    let few: Vec<(f64, f64)> = spans.iter().step_by(5).copied().collect();
    assert_eq!(clock_factor(&few, &blind[..few.len()], &programme(1.0)), None);
}

#[test]
fn a_converter_that_reads_the_same_all_the_while_is_known_to_its_rounding() {
    let mut blocks = Blocks::new(1, 1.0);
    (0..200).for_each(|k| blocks.push(f64::from(k), &[if k < 100 { 3.0 } else { 7.0 }]));
    let series = Series::join(vec![blocks]);
    let track = &series.tracks[0];
    let first = Interval { from: 2, to: 90 };
    let of = noise(&series, &[track], &[first, Interval { from: 110, to: 190 }], &[]);
    // The smallest difference that was seen is four.
    assert!((standard_error(&series, track, (&of[0][0], true), first, 1.0) - 4.0 / 12f64.sqrt()).abs() < 1e-12);
    let both = Interval { from: 2, to: 190 };
    assert!(standard_error(&series, track, (&of[0][0], true), both, 1.0) < 1e-6, "it does not read the same");
}

/// Rates counted in whole pulses: a mean over T is off by a pulse at both ends, pulse/(T sqrt 6), whether the counts
/// scatter or not.
#[test]
fn a_mean_of_counts_is_known_to_a_pulse_at_both_ends() {
    const HZ: f64 = 100.0;
    const SAMPLES: usize = 6000;
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    // At rest, turning, and a rate that is counted without any scatter.
    let mut rates: Vec<f64> = (0..20).map(|_| rng.random_range(-40.0..40.0)).collect();
    rates.extend((0..20).map(|_| rng.random_range(-20_000.0..20_000.0)));
    rates.push(10_800.0);
    let (mut blocks, mut total) = (Blocks::new(1, 1.0 / HZ), rng.random_range(0.0..1.0));
    for k in 0..rates.len() * SAMPLES {
        let before = f64::floor(total);
        total += rates[k / SAMPLES] / HZ + 1e-4 * rng.sample::<f64, _>(StandardNormal);
        blocks.push(k as f64 / HZ, &[total.floor() - before]);
    }
    let mut series = Series::join(vec![blocks]);
    let track = &mut series.tracks[0];
    assert!(track.whole && track.step == 1.0, "{}", track.step);
    track.pulse = track.step;
    track.scale(HZ);
    let block = |time: f64| series.number.partition_point(|&n| (n as f64) * series.block_s < time);
    let dwell = |k: usize| Interval { from: block(60.0 * k as f64 + 1.0), to: block(60.0 * k as f64 + 59.0) };
    let (still, turning): (Vec<Interval>, Vec<Interval>) =
        ((0..20).map(dwell).collect(), (20..41).map(dwell).collect());
    let track = &series.tracks[0];
    let of = noise(&series, &[track], &still, &turning)[0];
    let pulse = 1.0 / 58.0 / 6_f64.sqrt();
    let mut squares = Vec::new();
    for (k, interval) in still.iter().chain(&turning).enumerate() {
        let sem = standard_error(&series, track, (&of[usize::from(k >= 20)], true), *interval, 1.0 / HZ);
        // Of one gyro, flicker of such a size would not be seen.
        assert!((0.95..3.0).contains(&(sem / pulse)), "{}: {sem} {pulse}", rates[k]);
        squares.push(((track.mean_of(interval.from, interval.to) - rates[k]) / sem).powi(2));
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!((0.3..1.2).contains(&rms), "{rms}");
}

#[test]
fn samples_at_the_end_of_the_range_are_clipped_unless_counts_stand_there_by_nature() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let mut clipped = |limit: f64, whole: bool| {
        let mut blocks = Blocks::new(1, 0.01);
        for k in 0..4000 {
            let value = 100.4 + 0.3 * rng.sample::<f64, _>(StandardNormal) - if k < 2000 { 50.0 } else { 0.0 };
            let value = value.min(limit);
            blocks.push(f64::from(k) * 0.01, &[if whole { value.floor() } else { value }]);
        }
        let series = Series::join(vec![blocks]);
        let middle = series.number.len() / 2;
        (series.tracks[0].clipped(2, middle - 2), series.tracks[0].clipped(middle + 2, 2 * middle - 2))
    };
    for (limit, whole) in [(1e9, false), (1e9, true)] {
        let (low, high) = clipped(limit, whole);
        assert!(low < 0.01 && high < 0.01, "{limit} {whole}: {low} {high}");
    }
    assert!(clipped(100.4, false).1 > 0.4, "half of the noise");
    let (low, high) = clipped(90.0, true);
    assert!(low < 0.01 && high > 0.99, "{low} {high}");
}

#[test]
fn rows_that_are_exchanged_are_named() {
    let mut programme = twenty_four();
    let seen: Vec<LoggedInterval> =
        programme.iter().map(|p| LoggedInterval { up: Some(p.up()), turn_arcsec_s: None }).collect();
    assert!(exchanged(&seen, &programme).is_empty());
    programme.swap(0, 4);
    assert_eq!(exchanged(&seen, &programme), [0, 4]);
    assert!(exchanged(&seen[1..], &programme).is_empty(), "fewer intervals than rows");
}
