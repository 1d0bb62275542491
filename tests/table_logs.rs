//! Logs of a hundred rows a second on a table, made by equations of their own: positions and turns, white noise and
//! flicker, jitter, lost samples. What `dwells` makes of their text is held against what was done.
//!
//! `GYROWATCH_LOGS=100 cargo test --test all table_logs:: -- --nocapture` prints the figures.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::fs;
use std::process::Output;

use assert_cmd::Command;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::prelude::*;

type V = [f64; 3];

const HZ: f64 = 100.0;
const SLEW_S: f64 = 15.0;
const DWELL_S: f64 = 90.0;
const POSITIONS: usize = 42;
const TURNS: usize = 36;
const LATITUDE_DEG: f64 = 34.25;
const GRAVITY_G0: f64 = 0.998_985_755;
const EARTH_ARCSEC_S: f64 = 15.041_067_178_669;
/// Rates at which a dwell holds a whole turn or more, deg/s.
const WHOLE_TURNS: [f64; 6] = [5.0, -5.0, 10.0, -10.0, 20.0, -20.0];
/// Flicker over white noise in the Allan variance of a dwell, from which a log's slow noise counts as flicker.
const FLICKER: f64 = 0.1;
/// A table keeps its rate to so much of it.
const RATE_ERROR: f64 = 5e-4;

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn axis(name: &str) -> V {
    let sign = if name.starts_with('-') { -1.0 } else { 1.0 };
    ["X", "Y", "Z"].map(|letter| if name.ends_with(letter) { sign } else { 0.0 })
}

const NAMES: [&str; 6] = ["+X", "-X", "+Y", "-Y", "+Z", "-Z"];

/// What the log tells of the table besides the outputs.
#[derive(Debug, Clone, Copy)]
enum Told {
    /// Accelerometers, and a programme.
    Force,
    /// A programme with the station's times.
    Clock,
    /// The rate that the table was told, and a programme.
    Rate,
}

const ALL: [Told; 3] = [Told::Force, Told::Clock, Told::Rate];

/// What the gyros' columns are: rates, or whole pulses since the row before.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Logged {
    Rates,
    Pulses,
}

/// A position or a turn, and what is true of it.
struct Done {
    up: &'static str,
    north: &'static str,
    /// As the table was told, deg/s.
    told: f64,
    /// As it turned, arcsec/s.
    turn: f64,
    start_s: f64,
    /// Mean inertial rate over whole turns, arcsec/s, and mean outputs, pulse/s.
    rate: V,
    output: V,
}

/// Flicker of power density h/f: Gauss-Markov processes whose times are an octave apart, each of variance h ln 2,
/// stepped a twentieth of their time at once.
struct Flicker(Vec<(f64, f64, f64, usize)>);

impl Flicker {
    fn new(h: f64, log_s: f64) -> Self {
        let times = std::iter::successors(Some(log_s / TAU), |time| Some(time / 2.0)).take_while(|t| *t > 2.0 / HZ);
        let process = |time: f64| {
            let every = ((time * HZ / 20.0) as usize).max(1);
            let keep = (-(every as f64) / HZ / time).exp();
            (0.0, keep, (h * std::f64::consts::LN_2 * (1.0 - keep * keep)).sqrt(), every)
        };
        Self(times.map(process).collect())
    }

    fn at(&mut self, row: usize, rng: &mut ChaCha8Rng) -> f64 {
        let step = |(state, keep, kick, every): &mut (f64, f64, f64, usize)| {
            if row.is_multiple_of(*every) {
                *state = *state * *keep + *kick * rng.sample::<f64, _>(StandardNormal);
            }
            *state
        };
        self.0.iter_mut().map(step).sum()
    }
}

/// The programme in an order of its own, with the truth.
fn programme(rng: &mut ChaCha8Rng, rates: [f64; 6], e: &[V; 3], g: &[V; 3], bias: V) -> Vec<Done> {
    let faces: Vec<(&str, &str)> = NAMES
        .iter()
        .flat_map(|up| NAMES.iter().map(move |north| (*up, *north)))
        .filter(|(up, north)| dot(axis(up), axis(north)) == 0.0)
        .collect();
    let shift = rng.random_range(0..24);
    let face = |k: usize| faces[(k * 7 + shift) % faces.len()];
    let mut all: Vec<((&str, &str), f64)> = (0..POSITIONS).map(|k| (face(k), 0.0)).collect();
    all.extend((0..TURNS).map(|k| (face(k), rates[k % rates.len()])));
    if rng.random_range(0.0..1.0) < 0.5 {
        for k in (1..all.len()).rev() {
            all.swap(k, rng.random_range(0..k + 1));
        }
    }
    let done = |(k, ((up, north), told)): (usize, ((&'static str, &'static str), f64))| {
        let turn = 3600.0 * told * (1.0 + RATE_ERROR * rng.random_range(-1.0..1.0));
        let vertical = EARTH_ARCSEC_S * LATITUDE_DEG.to_radians().sin() + turn;
        let level = if told == 0.0 { EARTH_ARCSEC_S * LATITUDE_DEG.to_radians().cos() } else { 0.0 };
        let rate = [0, 1, 2].map(|c| vertical * axis(up)[c] + level * axis(north)[c]);
        let force = axis(up).map(|c| GRAVITY_G0 * c);
        let output = [0, 1, 2].map(|c| bias[c] + dot(g[c], force) + dot(e[c], rate));
        let start_s = SLEW_S + k as f64 * (SLEW_S + DWELL_S);
        Done { up, north, told, turn, start_s, rate, output }
    };
    all.into_iter().enumerate().map(done).collect()
}

/// Writes log, programme and map into a folder; what was done, and whether the noise is white.
fn write(dir: &Path, seed: u64, (told, logged): (Told, Logged), rates: [f64; 6]) -> (Vec<Done>, bool) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let normal = |rng: &mut ChaCha8Rng, sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let mut e = [[0.85, -0.6, 1.04], [0.85, -0.6, -1.04], [0.85, 1.2, 0.0]];
    e.iter_mut().flatten().for_each(|part| *part += normal(&mut rng, 0.01));
    let mut g = [[0.0; 3]; 3];
    g.iter_mut().flatten().for_each(|part| *part = normal(&mut rng, 4.0));
    let bias = [0; 3].map(|_| normal(&mut rng, 2.0));
    let done = programme(&mut rng, rates, &e, &g, bias);
    // Quiet and loud gyros: 0.02 to 2 pulse/s in a second.
    let white = 0.02 * 100_f64.powf(rng.random_range(0.0..1.0)) * HZ.sqrt();
    let h = 1e-6 * 100_f64.powf(rng.random_range(0.0..1.0));
    let log_s = done.len() as f64 * (SLEW_S + DWELL_S);
    let mut flickers = [0; 3].map(|_| Flicker::new(h, log_s));
    let mut text = String::from("t,g1,g2,g3");
    text.push_str(match told {
        Told::Force => ",ax,ay,az\n",
        Told::Clock => "\n",
        Told::Rate => ",table\n",
    });
    let mut before = done[0].output;
    let (mut counted, mut shown) = ([0.0_f64; 3], [0.0_f64; 3]);
    let peaks: Vec<V> = done.iter().map(|_| [0; 3].map(|_| rng.random_range(-2e4..2e4))).collect();
    for row in 0..(log_s * HZ) as usize {
        let time = (row as f64 + 0.5) / HZ;
        let k = (time / (SLEW_S + DWELL_S)) as usize;
        let (one, into) = (&done[k], time - done[k].start_s);
        let (up, north) = (axis(one.up), axis(one.north));
        let level = |seconds: f64| {
            // Heading of the table, positive about the vertical: body axes that pointed north turn to the west.
            let angle = (one.turn * seconds / 3600.0).to_radians();
            let east = cross(north, up);
            let horizontal = [0, 1, 2].map(|c| angle.cos() * north[c] + angle.sin() * east[c]);
            let flat = EARTH_ARCSEC_S * LATITUDE_DEG.to_radians().cos();
            let vertical = EARTH_ARCSEC_S * LATITUDE_DEG.to_radians().sin() + one.turn;
            let rate = [0, 1, 2].map(|c| vertical * up[c] + flat * horizontal[c]);
            [0, 1, 2].map(|c| bias[c] + GRAVITY_G0 * dot(g[c], up) + dot(e[c], rate))
        };
        let share = (1.0 + into / SLEW_S).clamp(0.0, 1.0);
        let felt = if into < 0.0 {
            let (next, wave) = (level(0.0), (std::f64::consts::PI * share).sin());
            [0, 1, 2].map(|c| before[c] * (1.0 - share) + next[c] * share + peaks[k][c] * wave)
        } else {
            before = level(into);
            before
        };
        let output = [0, 1, 2].map(|c| felt[c] + normal(&mut rng, white) + flickers[c].at(row, &mut rng));
        let force = up.map(|c| GRAVITY_G0 * c * share + normal(&mut rng, 2e-4));
        let jitter = 0.1 * rng.random_range(-1.0..1.0) / HZ;
        let stamp = time + jitter;
        // A counter is read when the row is stamped, or by a clock of its own.
        let read_after = if seed.is_multiple_of(2) { jitter } else { 0.0 };
        let counts = [0, 1, 2].map(|c| {
            counted[c] += output[c] / HZ;
            let now = (counted[c] + output[c] * read_after).floor();
            now - std::mem::replace(&mut shown[c], now)
        });
        if rng.random_range(0.0..1.0) < 1e-3 {
            continue;
        }
        match logged {
            Logged::Rates => write!(text, "{stamp:.6},{:.4},{:.4},{:.4}", output[0], output[1], output[2]),
            Logged::Pulses => write!(text, "{stamp:.6},{},{},{}", counts[0], counts[1], counts[2]),
        }
        .unwrap();
        match told {
            Told::Force => writeln!(text, ",{:.5},{:.5},{:.5}", force[0], force[1], force[2]),
            Told::Clock => writeln!(text),
            Told::Rate => writeln!(text, ",{}", if into < 0.0 { 0.0 } else { one.told }),
        }
        .unwrap();
    }
    fs::write(dir.join("log.csv"), text).unwrap();
    let timed = matches!(told, Told::Clock);
    let mut rows =
        String::from(if timed { "up,north,rate_deg_s,start_s,duration_s\n" } else { "up,north,rate_deg_s\n" });
    for one in &done {
        let times = if timed { format!(",{},{DWELL_S}", one.start_s - 12.5) } else { String::new() };
        writeln!(rows, "{},{},{}{times}", one.up, one.north, one.told).unwrap();
    }
    fs::write(dir.join("programme.csv"), rows).unwrap();
    let map = format!(
        "imu = \"IMU-1\"\nstation = \"ST-1\"\nmeasured_at = \"2026-03-01T08:00:00Z\"\ngeometry = \"skewed\"\n\
        site = {{ latitude_deg = {LATITUDE_DEG}, gravity_g0 = {GRAVITY_G0} }}\n\
        gyros = [\"G1 A-1\", \"G2 A-2\", \"G3 A-3\"]\ntime = {{ column = \"t\", unit = \"s\" }}\n\
        output = {{ columns = [\"g1\", \"g2\", \"g3\"], unit = \"{}\" }}\n{}",
        if logged == Logged::Pulses { "pulse" } else { "pulse/s" },
        match told {
            Told::Force => "force = { columns = [\"ax\", \"ay\", \"az\"], unit = \"g0\" }\n",
            Told::Clock => "",
            Told::Rate => "rate = { columns = [\"table\"], unit = \"deg/s\" }\n",
        }
    );
    fs::write(dir.join("map.toml"), map).unwrap();
    (done, 2.0 * std::f64::consts::LN_2 * h * DWELL_S * HZ < FLICKER * white * white)
}

/// Why the dwells are not those that were done; otherwise their errors in standard errors, at rest and in turns.
fn judged(output: &Output, done: &[Done]) -> Result<[Vec<f64>; 2], String> {
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or_default().to_owned());
    }
    let made: Value = serde_json::from_slice(&output.stdout).unwrap();
    let dwells = made["dwells"].as_array().unwrap();
    if dwells.len() != done.len() {
        return Err(format!("{} dwells", dwells.len()));
    }
    let mut errors = [Vec::new(), Vec::new()];
    for (k, (dwell, one)) in dwells.iter().zip(done).enumerate() {
        let number = |name: &str| dwell[name].as_f64().unwrap();
        let of = |name: &str, c: usize| dwell[name][c].as_f64().unwrap();
        let (start, length) = (number("start_s"), number("duration_s"));
        // Within what was held, to a block; of turns, whole ones.
        if start < one.start_s - 1.0 || start + length > one.start_s + DWELL_S + 1.0 {
            return Err(format!("dwell {}: {start:.1} s and {length:.1} s for {:.1} s", k + 1, one.start_s));
        }
        let turns = length * one.told.abs() / 360.0;
        let least = if one.told == 0.0 { 0.55 * DWELL_S } else { 0.95 * 360.0 / one.told.abs() };
        if length < least || (turns - turns.round()).abs() > 0.05 {
            return Err(format!("dwell {}: {length:.1} s, {turns:.2} turns", k + 1));
        }
        if (dwell["phase"] == "rate") != (one.told != 0.0) {
            return Err(format!("dwell {}: {}", k + 1, dwell["phase"]));
        }
        let off = (0..3).map(|c| (of("rate_arcsec_s", c) - one.rate[c]).powi(2)).sum::<f64>().sqrt();
        if off > 1.01 * RATE_ERROR * one.turn.abs() + 1e-3 {
            return Err(format!("dwell {}: the rate is off by {off:.3} arcsec/s", k + 1));
        }
        let errors = &mut errors[usize::from(one.told != 0.0)];
        errors.extend((0..3).map(|c| (of("output_pulse_s", c) - one.output[c]) / of("output_sem_pulse_s", c)));
    }
    Ok(errors)
}

fn dwells(dir: &Path) -> Output {
    let mut command = Command::cargo_bin("gyrowatch").unwrap();
    command.current_dir(dir).args(["dwells", "log.csv", "--map", "map.toml", "--programme", "programme.csv"]);
    command.output().unwrap()
}

/// Half a turn in a dwell: nothing says where it began, so the Earth's horizontal rate in it is not known.
#[test]
fn parts_of_a_turn_are_left_out_where_they_would_move_the_fit() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), 5, (Told::Rate, Logged::Rates), [2.0, -2.0, 10.0, -10.0, 20.0, -20.0]);
    let output = dwells(dir.path());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("12 turning intervals are left out. They are shorter than one turn"), "{said}");
    let made: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {said}"));
    let phases = |name: &str| made["dwells"].as_array().unwrap().iter().filter(|d| d["phase"] == name).count();
    assert_eq!((phases("static"), phases("rate")), (POSITIONS, TURNS - 12));
}

#[test]
fn a_hundred_rows_a_second_on_a_table_become_the_dwells_that_were_done() {
    judge(Logged::Rates);
}

/// A count of a hundredth of a second is a hundred pulses a second coarse, a mean over the dwell right to a pulse.
#[test]
fn whole_pulses_a_hundred_times_a_second_are_as_well_known_as_they_say() {
    judge(Logged::Pulses);
}

fn judge(logged: Logged) {
    let number = |name: &str, default: u64| std::env::var(name).ok().and_then(|n| n.parse().ok()).unwrap_or(default);
    let (logs, first) = (number("GYROWATCH_LOGS", 3), number("GYROWATCH_FIRST", 0));
    let dir = tempfile::tempdir().unwrap();
    let (mut wrong, mut errors) = (0, BTreeMap::<_, Vec<f64>>::new());
    for seed in first..first + logs {
        let told = ALL[seed as usize % ALL.len()];
        let (done, is_white) = write(dir.path(), seed, (told, logged), WHOLE_TURNS);
        match judged(&dwells(dir.path()), &done) {
            Ok(own) => {
                for (phase, own) in ["at rest", "in turns"].into_iter().zip(own) {
                    let kind = (format!("{told:?}"), if is_white { "white" } else { "flicker" }, phase);
                    errors.entry(kind).or_default().extend(own);
                }
            }
            Err(why) => {
                println!("seed {seed}, {told:?}, {logged:?}: {why}");
                wrong += 1;
            }
        }
    }
    let rms = |errors: &[f64]| (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
    for ((told, noise, phase), own) in &errors {
        println!("{logged:?}, {told}, {noise}, {phase}: {} means, rms {:.3}", own.len(), rms(own));
    }
    let errors = errors.into_values().flatten().collect::<Vec<_>>();
    let (mean, rms) = (errors.iter().sum::<f64>() / errors.len() as f64, rms(&errors));
    println!(
        "{logged:?}: logs {logs}, with a dwell missed or invented {wrong}; error/sd: mean {mean:+.3}, rms {rms:.3}"
    );
    assert!(100 * wrong <= logs);
    assert!(mean.abs() < 0.25, "{mean}");
    // How much flicker there is, few dwells say poorly: of few logs there is room for chance.
    let room = if logs < 30 { 0.15 } else { 0.1 };
    assert!((rms - 1.0).abs() < room, "{rms}");
}
