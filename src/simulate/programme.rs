//! What the table does: positions, turns, repeats, order and clock.

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::core::campaign::Phase;
use crate::core::fault::Faults;

use super::fault_at::fault;
use crate::core::message::text;
use crate::core::named::named;
use crate::message;

/// Whole revolution, arcsec.
const TURN_ARCSEC: f64 = 360.0 * 3600.0;

/// Positions and turns of the table, in their order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Programme {
    pub positions: Positions,
    /// Static positions that are taken a second time (drawn at random, more than the list wraps round).
    pub repeats: usize,
    /// The whole programme is run so many times.
    pub cycles: usize,
    /// Table rates about the vertical; empty has no rate dwells.
    pub rates_arcsec_s: Vec<f64>,
    /// Each rate in both senses, or in the positive one only.
    pub both_senses: bool,
    /// Each body axis up and down, or up only.
    pub both_ups: bool,
    pub order: DwellOrder,
    pub dwell_s: f64,
    /// Dwells last from `dwell_s` to this, each as it comes (evenly in the logarithm); left out, all alike.
    pub longest_dwell_s: Option<f64>,
    pub settle_s: f64,
    /// Rate dwells last at least one turn (a slow rate makes them long); else they last as long as the others and
    /// the means are still those over a whole turn.
    pub whole_turns: bool,
    /// The programme is cut into as many parts, with the power off in between.
    pub power_ups: usize,
    pub power_off_s: f64,
}

named! {
/// Sets of static positions: a list of body directions that point up, with headings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Positions {
    /// Six faces, one heading.
    #[serde(rename = "6")]
    Faces = "6",
    /// Six faces in four headings each.
    #[serde(rename = "24")]
    TwentyFour = "24",
    /// And the twelve edges, 45 degrees.
    #[serde(rename = "36")]
    WithEdges = "36",
    /// And the twenty-four tilts of 30 and 60 degrees.
    #[serde(rename = "60")]
    WithTilts = "60",
    /// One gyro on the polar axis: body Z (the output axis of a fixture) along the Earth's axis, twelve positions
    /// about it, then Z against it and twelve more.
    #[serde(rename = "polar_tumble")]
    PolarTumble = "polar_tumble",
}
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DwellOrder {
    /// As listed: face by face, heading by heading, statics before rates.
    Fixed,
    /// Statics shuffled, then rates shuffled.
    Random,
    /// Statics and rates shuffled together.
    Mixed,
}

impl Default for Programme {
    fn default() -> Self {
        Self {
            positions: Positions::TwentyFour,
            repeats: 6,
            cycles: 1,
            rates_arcsec_s: vec![360.0, 1800.0, 3600.0, 7200.0],
            both_senses: true,
            both_ups: true,
            order: DwellOrder::Random,
            dwell_s: 180.0,
            longest_dwell_s: None,
            settle_s: 60.0,
            whole_turns: false,
            power_ups: 1,
            power_off_s: 7200.0,
        }
    }
}

/// One dwell that the table is told to do.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    pub phase: Phase,
    pub start_s: f64,
    pub duration_s: f64,
    /// C at the start: v_body = C v_table, and the table commands East, North, Up.
    pub attitude: Rotation3<f64>,
    /// Rate of the table about its vertical with respect to the Earth, arcsec/s.
    pub turn_arcsec_s: f64,
    /// Seconds since the last power-up, at mid-dwell.
    pub since_power_up_s: f64,
    pub power_up: usize,
}

/// A position or a turn before it has its place in time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Station {
    attitude: Rotation3<f64>,
    turn_arcsec_s: f64,
}

/// Dwells of `programme` in time order. `pole_elevation` is the latitude in radians (for positions about the pole).
pub fn plan(programme: &Programme, pole_elevation: f64, rng: &mut ChaCha8Rng) -> Result<Vec<Planned>, Faults> {
    check(programme)?;
    let mut order = Vec::new();
    for _ in 0..programme.cycles {
        order.extend(one_cycle(programme, pole_elevation, rng));
    }
    if order.is_empty() {
        return Err(fault("/programme", message!("no_positions_or_rates")));
    }
    Ok(clocked(programme, &order, rng))
}

fn check(programme: &Programme) -> Result<(), Faults> {
    let mut faults = Faults::default();
    let mut positive = |name: &str, value: f64, zero_too: bool| {
        if !(value.is_finite() && (value > 0.0 || zero_too && value == 0.0)) {
            faults.push(format!("/programme/{name}"), message!("not_positive_seconds", value = text(value)));
        }
    };
    positive("dwell_s", programme.dwell_s, false);
    positive("longest_dwell_s", programme.longest_dwell_s.unwrap_or(programme.dwell_s), false);
    positive("settle_s", programme.settle_s, true);
    positive("power_off_s", programme.power_off_s, true);
    for (i, rate) in programme.rates_arcsec_s.iter().enumerate() {
        if !(rate.is_finite() && *rate != 0.0) {
            faults.push(format!("/programme/rates_arcsec_s/{i}"), message!("not_a_rate", value = text(rate)));
        }
    }
    for (name, count) in [("cycles", programme.cycles), ("power_ups", programme.power_ups)] {
        if count == 0 {
            faults.push(format!("/programme/{name}"), message!("at_least_1"));
        }
    }
    faults.or(())
}

fn one_cycle(programme: &Programme, pole_elevation: f64, rng: &mut ChaCha8Rng) -> Vec<Station> {
    let mut statics = static_positions(programme.positions, pole_elevation);
    let listed = statics.len();
    let mut again: Vec<usize> = (0..listed).collect();
    again.shuffle(rng);
    for k in 0..programme.repeats {
        statics.push(statics[again[k % listed]]);
    }
    let mut turns = turns(programme);
    match programme.order {
        DwellOrder::Fixed => statics.append(&mut turns),
        DwellOrder::Random => {
            statics.shuffle(rng);
            turns.shuffle(rng);
            statics.append(&mut turns);
        }
        DwellOrder::Mixed => {
            statics.append(&mut turns);
            statics.shuffle(rng);
        }
    }
    statics
}

fn static_positions(positions: Positions, pole_elevation: f64) -> Vec<Station> {
    if positions == Positions::PolarTumble {
        return polar_tumble(pole_elevation);
    }
    let headings = if positions == Positions::Faces { 1 } else { 4 };
    let mut ups: Vec<(Vector3<f64>, usize)> = faces().into_iter().map(|up| (up, headings)).collect();
    if matches!(positions, Positions::WithEdges | Positions::WithTilts) {
        ups.extend(tilted(45.0).into_iter().map(|up| (up, 1)));
    }
    if positions == Positions::WithTilts {
        ups.extend(tilted(30.0).into_iter().chain(tilted(60.0)).map(|up| (up, 1)));
    }
    let mut stations = Vec::new();
    for (up, headings) in ups {
        for quarter in 0..headings {
            let heading = quarter as f64 * std::f64::consts::FRAC_PI_2;
            stations.push(Station { attitude: attitude(up, heading), turn_arcsec_s: 0.0 });
        }
    }
    stations
}

fn faces() -> Vec<Vector3<f64>> {
    [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().flat_map(|axis| [axis, -axis]).collect()
}

/// Ups between two body axes, `degrees` away from the first: four signs in each of the three planes.
fn tilted(degrees: f64) -> Vec<Vector3<f64>> {
    let (s, c) = degrees.to_radians().sin_cos();
    let mut ups = Vec::new();
    for first in 0..3 {
        for (along, across) in [(c, s), (c, -s), (-c, s), (-c, -s)] {
            let mut up = Vector3::zeros();
            up[first] = along;
            up[(first + 1) % 3] = across;
            ups.push(up);
        }
    }
    ups
}

/// The attitude in which body direction `up` points up, turned by `heading` (radians) about the vertical.
pub fn attitude(up: Vector3<f64>, heading: f64) -> Rotation3<f64> {
    let up = up.normalize();
    let least = up.iamin();
    let reference = Vector3::ith(least, 1.0);
    let north = (reference - up * up.dot(&reference)).normalize();
    let north = Rotation3::new(up * heading) * north;
    let east = north.cross(&up);
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[east, north, up]))
}

/// Polar-axis tumble: the body turned about its Z in steps of 30 degrees, Z along the pole, then against it.
fn polar_tumble(pole_elevation: f64) -> Vec<Station> {
    let pole = Vector3::new(0.0, pole_elevation.cos(), pole_elevation.sin());
    let east = Vector3::x();
    let meridian = pole.cross(&east);
    let mut stations = Vec::new();
    for sense in [1.0, -1.0] {
        let rows = [east, meridian * sense, pole * sense].map(|v| v.transpose());
        let onto_pole = Rotation3::from_matrix_unchecked(Matrix3::from_rows(&rows));
        for step in 0..12 {
            let about_pole =
                Rotation3::from_axis_angle(&Vector3::z_axis(), f64::from(step) * std::f64::consts::PI / 6.0);
            stations.push(Station { attitude: about_pole * onto_pole, turn_arcsec_s: 0.0 });
        }
    }
    stations
}

fn turns(programme: &Programme) -> Vec<Station> {
    let ups = if programme.both_ups { faces() } else { vec![Vector3::x(), Vector3::y(), Vector3::z()] };
    let senses: &[f64] = if programme.both_senses { &[1.0, -1.0] } else { &[1.0] };
    let mut stations = Vec::new();
    for up in ups {
        for rate in &programme.rates_arcsec_s {
            stations.extend(senses.iter().map(|s| Station { attitude: attitude(up, 0.0), turn_arcsec_s: s * rate }));
        }
    }
    stations
}

fn clocked(programme: &Programme, order: &[Station], rng: &mut ChaCha8Rng) -> Vec<Planned> {
    let per_power_up = order.len().div_ceil(programme.power_ups);
    let mut clock = 0.0;
    let mut switched_on = 0.0;
    let mut dwells = Vec::with_capacity(order.len());
    for (k, station) in order.iter().enumerate() {
        let power_up = k / per_power_up;
        if k > 0 && k % per_power_up == 0 {
            clock += programme.power_off_s;
            switched_on = clock;
        }
        let times_longer = |longest: f64| (longest / programme.dwell_s).powf(rng.random_range(0.0..1.0));
        let duration_s =
            duration(programme, station.turn_arcsec_s) * programme.longest_dwell_s.map_or(1.0, times_longer);
        dwells.push(Planned {
            phase: if station.turn_arcsec_s == 0.0 { Phase::Static } else { Phase::Rate },
            start_s: clock,
            duration_s,
            attitude: station.attitude,
            turn_arcsec_s: station.turn_arcsec_s,
            since_power_up_s: clock - switched_on + 0.5 * duration_s,
            power_up,
        });
        clock += duration_s + programme.settle_s;
    }
    dwells
}

fn duration(programme: &Programme, turn_arcsec_s: f64) -> f64 {
    if turn_arcsec_s == 0.0 || !programme.whole_turns {
        return programme.dwell_s;
    }
    let turn_s = TURN_ARCSEC / turn_arcsec_s.abs();
    turn_s * (programme.dwell_s / turn_s).ceil().max(1.0)
}

/// A random unit vector.
pub fn any_direction(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    loop {
        let v = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        if (0.01..=1.0).contains(&v.norm_squared()) {
            return v.normalize();
        }
    }
}
