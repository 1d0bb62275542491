//! Whole logs on a table, from samples to dwells: positions and turns, in which the Earth's rate goes round.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::assemble::assemble;
use super::gather::{LogSeries, Role};
use super::map::Map;
use super::units::{Counts, Unit};
use crate::core::campaign::{Phase, Site};
use crate::core::dwells::blocks::{Blocks, Series};
use crate::core::dwells::programme::{Position, twenty_four};
use crate::core::frames::{Body, Nav, Rotation, Vector};

const DWELLS: usize = 78;
const TURNS: usize = 36;
const RATES_DEG_S: [f64; 6] = [2.0, -2.0, 5.0, -5.0, 10.0, -10.0];

/// What the log says of the table besides the outputs.
#[derive(Debug, Clone, Copy, PartialEq)]
enum CommandSource {
    /// A programme, and accelerometers.
    Force,
    /// A programme with times.
    Clock,
    /// A programme, and the rate of the table.
    Rate,
    /// The attitude at every sample, no programme.
    Attitude,
}

const ALL: [CommandSource; 4] =
    [CommandSource::Force, CommandSource::Clock, CommandSource::Rate, CommandSource::Attitude];

fn normal(rng: &mut ChaCha8Rng, sd: f64) -> f64 {
    sd * rng.sample::<f64, _>(StandardNormal)
}

struct Truth {
    start_s: f64,
    length_s: f64,
    output: [f64; 3],
    rate: Vector3<f64>,
    phase: Phase,
}

fn site() -> Site {
    Site { latitude: 34.25_f64.to_radians(), gravity_g0: 0.998_985_755, magnetic_field_nav: None }
}

/// Flicker h/f as a sum of Gauss-Markov processes, two an octave.
struct Flicker(Vec<(f64, f64, f64)>);

impl Flicker {
    fn next(&mut self, rng: &mut ChaCha8Rng) -> f64 {
        let step = |(state, keep, kick): &mut (f64, f64, f64)| {
            *state = *state * *keep + *kick * rng.sample::<f64, _>(StandardNormal);
            *state
        };
        self.0.iter_mut().map(step).sum()
    }
}

fn log(seed: u64, hz: f64, told: CommandSource) -> (LogSeries, Vec<Position>, Vec<Truth>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // Input axes of 1.47 pulse/arcsec in a skewed triad, and what gravity does.
    let e = [Vector3::new(0.85, -0.6, 1.04), Vector3::new(0.85, -0.6, -1.04), Vector3::new(0.85, 1.2, 0.0)];
    let e = e.map(|axis| axis + Vector3::from_fn(|_, _| normal(&mut rng, 0.01)));
    let d = [0; 3].map(|_| (normal(&mut rng, 2.0), Vector3::from_fn(|_, _| normal(&mut rng, 4.0))));
    // Quiet and loud gyros: 0.02 to 5 pulse/s in a second.
    let white = 0.02 * 250_f64.powf(rng.random_range(0.0..1.0));
    let flicker = 1e-6 * 10_f64.powf(rng.random_range(0.0..2.0));
    let (dwell_s, slew_s) = if hz > 50.0 { (90.0, 20.0) } else { (290.0, 40.0) };
    let mut programme: Vec<Position> = (0..DWELLS).map(|k| twenty_four()[k * 7 % 24]).collect();
    for (k, position) in programme.iter_mut().skip(DWELLS - TURNS).enumerate() {
        // Shorter dwells still hold a whole turn.
        let rates = if hz > 50.0 { &RATES_DEG_S[2..] } else { &RATES_DEG_S[..] };
        position.turn_arcsec_s = 3600.0 * rates[k % rates.len()];
    }
    if seed.is_multiple_of(3) {
        for k in (1..DWELLS).rev() {
            programme.swap(k, rng.random_range(0.0..k as f64 + 1.0) as usize);
        }
    }
    let step = hz.recip();
    let log_s = DWELLS as f64 * (dwell_s + slew_s);
    let sd = (flicker * 0.5 * std::f64::consts::LN_2).sqrt();
    let process = |time: f64| {
        let keep = (-step / time).exp();
        (0.0, keep, sd * (1.0 - keep * keep).sqrt())
    };
    let times = || std::iter::successors(Some(log_s / TAU), |t| Some(t / 2f64.sqrt())).take_while(|t| *t > 2.0 * step);
    let mut flickers = [0; 3].map(|_| Flicker(times().map(process).collect()));
    let mut roles: Vec<Role> = (0..3).map(Role::Output).collect();
    match told {
        CommandSource::Force => roles.extend((0..3).map(Role::Force)),
        CommandSource::Clock => {}
        CommandSource::Rate => roles.push(Role::Rate(0)),
        CommandSource::Attitude => roles.extend((0..4).map(Role::Attitude)),
    }
    let mut blocks = Blocks::new(roles.len(), step);
    let (earth, site) = (site().earth_rate().0, site());
    let (mut truth, mut quaternion): (Vec<Truth>, [f64; 4]) = (Vec::new(), [0.0; 4]);
    for (k, position) in programme.iter_mut().enumerate() {
        let begin = k as f64 * (dwell_s + slew_s) + slew_s;
        (position.start_s, position.duration_s) = match told {
            CommandSource::Clock => (Some(begin - 37.0), Some(dwell_s)),
            _ => (None, None),
        };
        // A table keeps its rate to 3e-4 of it.
        let turn = position.turn_arcsec_s * (1.0 + 3e-4 * rng.random_range(-1.7..1.7));
        let up = position.up();
        let attitude = |into: f64| {
            let turned = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), (turn * into / 3600.0).to_radians());
            let matrix = position.attitude.matrix() * turned.inverse().matrix();
            Rotation::<Nav, Body>::stated_as(nalgebra::Rotation3::from_matrix_unchecked(matrix))
        };
        let output = |rate: Vector3<f64>| {
            let of = |c: usize| d[c].0 + d[c].1.dot(&(site.gravity_g0 * up)) + e[c].dot(&rate);
            [0, 1, 2].map(of)
        };
        let rate = position.commanded(&site).1 + (turn - position.turn_arcsec_s) * up;
        let peaks = [0; 3].map(|_| rng.random_range(-20_000.0..20_000.0));
        let before = truth.last().map_or([0.0; 3], |t| t.output);
        for row in 0..((dwell_s + slew_s) * hz).round() as usize {
            let time = begin - slew_s + row as f64 * step;
            let into = time - begin;
            let share = (into / slew_s + 1.0 + 0.5 * step / slew_s).clamp(0.0, 1.0);
            let slewing = into < -1e-9;
            let own = attitude(into.max(0.0));
            let felt = if slewing {
                let level = output(rate);
                let wave = (std::f64::consts::PI * share).sin();
                [0, 1, 2].map(|c| before[c] * (1.0 - share) + level[c] * share + peaks[c] * wave)
            } else {
                output((own * Vector::new(earth)).0 + turn * up)
            };
            let noise = [0, 1, 2]
                .map(|c| white * hz.sqrt() * rng.sample::<f64, _>(StandardNormal) + flickers[c].next(&mut rng));
            let lost = rng.random_range(0.0..1.0) < 1e-3;
            let jitter = 0.1 * step * rng.random_range(-1.0..1.0);
            let mut values: Vec<f64> = (0..3).map(|c| felt[c] + noise[c]).collect();
            match told {
                CommandSource::Force => {
                    let force = (if slewing { share } else { 1.0 }) * site.gravity_g0 * up;
                    values.extend(force.iter().map(|f| f + 2e-4 * rng.sample::<f64, _>(StandardNormal)));
                }
                CommandSource::Clock => {}
                CommandSource::Rate => values.push(if slewing { 0.0 } else { position.turn_arcsec_s }),
                CommandSource::Attitude => {
                    let stated = own.to_attitude();
                    let along: f64 = stated.iter().zip(&quaternion).map(|(now, old)| now * old).sum();
                    quaternion = stated.map(|q| if along < 0.0 { -q } else { q });
                    values.extend(quaternion);
                }
            }
            if !lost {
                blocks.push(time + jitter, &values);
            }
        }
        truth.push(Truth { start_s: begin, length_s: dwell_s, output: output(rate), rate, phase: position.phase() });
    }
    let gathered = LogSeries {
        series: Series::join(vec![blocks]),
        roles,
        unit: Unit { factor: 1.0, offset: 0.0, counts: Counts::Rate },
        rate_factor: 0.0,
        time_unit_s: 1.0,
        breaks: Vec::new(),
        sample_s: step,
        is_regular: true,
        began: None,
        remarks: Vec::new(),
    };
    (gathered, programme, truth)
}

/// Logs with a dwell missed, invented or of another command, and errors of means in standard errors.
fn measure(seeds: std::ops::Range<u64>, hz: f64) -> (usize, Vec<f64>) {
    let map = Map::parse("output = { columns = [1, 2, 3], unit = \"pulse/s\" }").unwrap();
    let (mut wrong, mut errors) = (0, Vec::new());
    for seed in seeds {
        let told = ALL[seed as usize % ALL.len()];
        let (mut log, programme, truth) = log(seed, hz, told);
        let programme = (told != CommandSource::Attitude).then_some(&programme[..]);
        let made = assemble(&map, &mut log, Some(site()), programme);
        let dwells = made.as_ref().map(|made| &made.dwells[..]).unwrap_or_default();
        let is_of = |d: &super::assemble::Dwell, t: &Truth| {
            // Inside what was held, to a block or two, and not less than a half of it; of turns, whole ones.
            let (early, late) = (t.start_s - d.start_s, d.start_s + d.duration_s - t.start_s - t.length_s);
            let is_inside = early.max(late) < 1.0 + 1.5 / hz && d.duration_s > 0.5 * t.length_s;
            // As far as the table keeps its rate; from attitudes, as far as the clock, off by a tenth of a step at both
            // ends, tells it.
            let clock = if told == CommandSource::Attitude { 0.2 / hz / d.duration_s } else { 0.0 };
            let off = (d.commanded.rate_arcsec_s - t.rate).norm();
            is_inside && d.commanded.phase == t.phase && off < (5.2e-4 + clock) * t.rate.norm() + 0.02
        };
        if dwells.len() != DWELLS || !dwells.iter().zip(&truth).all(|(d, t)| is_of(d, t)) {
            let why = made.as_ref().err().map(|e| e.fault.code.to_string());
            println!("seed {seed}, {hz} Hz, {told:?}: {} dwells {why:?}", dwells.len());
            if std::env::var("GYROWATCH_SHOW").is_ok() {
                for d in dwells {
                    let (phase, rate) = (d.commanded.phase, d.commanded.rate_arcsec_s.norm());
                    println!("  {phase:?} {:.0} {:.0} {rate:.2}", d.start_s, d.duration_s);
                }
            }
            wrong += 1;
            continue;
        }
        let of = |(d, t): (&super::assemble::Dwell, &Truth)| {
            [0, 1, 2].map(|c| (d.output[c] - t.output[c]) / d.output_sem[c])
        };
        errors.extend(dwells.iter().zip(&truth).flat_map(of));
    }
    (wrong, errors)
}

/// `GYROWATCH_LOGS=100 cargo test --lib turns_are -- --nocapture` prints the figures of as many logs of each rate.
#[test]
fn turns_are_found_and_positions_too_of_quiet_and_of_loud_gyros() {
    let logs: u64 = std::env::var("GYROWATCH_LOGS").ok().and_then(|n| n.parse().ok()).unwrap_or(4);
    let first: u64 = std::env::var("GYROWATCH_FIRST").ok().and_then(|n| n.parse().ok()).unwrap_or(0);
    for hz in [1.0, 100.0] {
        let (wrong, errors) = measure(first..first + logs, hz);
        let n = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / n;
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
        println!(
            "{hz} Hz: logs {logs}, with a dwell missed or invented {wrong}; error/sd: mean {mean:+.3}, rms {rms:.3}"
        );
        assert!(100 * wrong <= logs as usize);
        assert!(mean.abs() < 0.25, "{mean}");
        assert!((0.8..1.2).contains(&rms), "{rms}");
    }
}
