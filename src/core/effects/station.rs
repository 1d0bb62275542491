//! Effects of the station: its table's vertical and north, and its magnetic field.
//!
//! A small rotation `d` (East, North, Up; radians) of the commanded attitudes against the true ones changes what the
//! gyros see by `C(d x f)` and `C(d x w)`. In a rate dwell over whole turns two cases part. Where the *table* is tilted
//! it turns about its own tilted vertical: horizontal parts of Earth rate and gravity average away, and of `d x w`
//! only the vertical part stays. Where the *IMU on the table* is tilted, the table's rate itself is seen turned by `d`.

use nalgebra::{Rotation3, Vector3};

use super::entry::{Effect, Entry, PLAIN, Parameter, Scope, Shape, no_attitude};
use super::setting::Setting;
use crate::core::campaign::Phase;

pub(super) const ENTRIES: &[&Entry] = &[&LEVELLING, &AZIMUTH, &MAGNETIC, &RELEVELLING, &RESEATING];

pub const LEVELLING: Entry = Entry {
    effect: Effect::Levelling,
    id: "levelling",
    cause: "the table's vertical is tilted about east and north; all gyros see the same tilt",
    equation: "G.C(d x f)/|E| + E.C(d x w)/|E|, d = (d_E, d_N, 0)",
    unit: "rad",
    typical: [5e-6, 1e-3], // levelling of two-axis tables, 1 to 200 arcsec
    plausible: 0.2,
    confused_with: &[Effect::Azimuth, Effect::Magnetic],
    scope: Scope::Common,
    names: &|_| vec!["east", "north"],
    missing: &no_attitude,
    shapes: &|s| {
        // The table's rate shows three numbers a gyro beside E: of fewer gyros anything that the faces do passes for a tilt.
        let of_imu = (s.gyros.len() >= 3).then_some((Shape::Tilt { with_rate: true }, 1.0));
        [(Shape::Tilt { with_rate: false }, 1.0)].into_iter().chain(of_imu).collect()
    },
    columns: &|s, j, shape| {
        let with_rate = shape == Shape::Tilt { with_rate: true };
        vec![tilted(s, j, Vector3::x(), with_rate), tilted(s, j, Vector3::y(), with_rate)]
    },
    beyond: Some(|s, j, shape, d| {
        tilted_beyond(s, j, Vector3::new(d[0], d[1], 0.0), shape == Shape::Tilt { with_rate: true })
    }),
    parameter: Parameter::Tilt,
    ..PLAIN
};

pub const AZIMUTH: Entry = Entry {
    effect: Effect::Azimuth,
    id: "azimuth",
    cause: "the table's north is misaligned; all gyros see the same angle",
    equation: "E.C(d x w)/|E|, d = (0, 0, d_U)",
    unit: "rad",
    typical: [5e-6, 3e-3], // north alignment of tables, 1 to 600 arcsec
    plausible: 0.5,
    confused_with: &[Effect::Levelling, Effect::Magnetic],
    scope: Scope::Common,
    names: &|_| vec!["up"],
    missing: &no_attitude,
    columns: &|s, j, _| vec![tilted(s, j, Vector3::z(), false)],
    beyond: Some(|s, j, _, d| tilted_beyond(s, j, Vector3::z() * d[0], false)),
    ..PLAIN
};

pub const MAGNETIC: Entry = Entry {
    effect: Effect::Magnetic,
    id: "magnetic",
    cause: "the ambient field acts on the motor and torquer: drift fixed to a direction in nav",
    equation: "k . C b, b = (sin phi, cos phi, 0)",
    unit: "deg/h",
    typical: [1e-3, 0.1], // IEEE 517, magnetic sensitivity, per 0.5 gauss
    plausible: 1e3,
    confused_with: &[Effect::Azimuth, Effect::Levelling, Effect::Scale],
    names: &|shape| match shape {
        Shape::Azimuth(_) => vec!["k_x", "k_y", "k_z"],
        _ => vec!["east_x", "east_y", "east_z", "north_x", "north_y", "north_z"],
    },
    missing: &no_attitude,
    shapes: &field_directions,
    columns: &|s, _, shape| {
        let along = |field: Vector3<f64>| {
            let body = in_body(s, field);
            (0..3).map(|i| body.iter().map(|b| b[i]).collect()).collect::<Vec<Vec<f64>>>()
        };
        match shape {
            Shape::Azimuth(angle) => along(Vector3::new(angle.sin(), angle.cos(), 0.0)),
            // Of any direction: what goes with east and what goes with north.
            _ => [along(Vector3::x()), along(Vector3::y())].concat(),
        }
    },
    parameter: Parameter::FieldAzimuth,
    ..PLAIN
};

/// Of the table: its vertical tilts by d = (d_E, d_N, 0), rad, at the instant t_0.
pub const RELEVELLING: Entry = Entry {
    effect: Effect::Relevelling,
    id: "relevelling",
    cause: "the table was levelled anew or settled: its tilt changes once, for all gyros alike",
    equation: "H(t - t_0) (G.C(d x f)/|E| + E.C(d x w)/|E|), d = (d_E, d_N, 0)",
    unit: "rad",
    typical: [5e-6, 1e-3], // levelling of two-axis tables, 1 to 200 arcsec
    plausible: 0.2,
    confused_with: &[Effect::Levelling, Effect::Magnetic, Effect::Reseating],
    throughout: Some(Effect::Levelling),
    scope: Scope::Common,
    names: &|_| vec!["east", "north"],
    missing: &no_attitude,
    shapes: &|s| instants(s).map(|instant| (Shape::Instant(instant), 1.0)).collect(),
    columns: &|s, j, shape| {
        let columns = [Vector3::x(), Vector3::y()].map(|axis| tilted(s, j, axis, false));
        columns.into_iter().map(|column| afterwards(s, column, shape)).collect()
    },
    beyond: Some(|s, j, shape, d| afterwards(s, tilted_beyond(s, j, Vector3::new(d[0], d[1], 0.0), false), shape)),
    parameter: Parameter::Instant,
    one_occasion: true,
    ..PLAIN
};

/// A campaign that was fitted to another seat has E and G of turned axes; what rates and Earth then differ by is all
/// that a field along north may leave, too.
pub const RESEATING: Entry = Entry {
    effect: Effect::Reseating,
    id: "reseating",
    cause: "the IMU sits otherwise in its fixture while the table turns, or from a time on; all gyros turn alike",
    equation: "S (G.(d x A)/|E| + E.(d x w)/|E|), d in body axes, S = 1 in turning dwells or after t_0",
    unit: "rad",
    typical: [2e-5, 2e-3], // repeatability of fixtures and dowels, 5 to 300 arcsec
    plausible: 0.2,
    confused_with: &[Effect::Magnetic, Effect::Azimuth, Effect::Levelling],
    never_told_from: &[Effect::Magnetic],
    scope: Scope::Common,
    names: &|_| vec!["d_x", "d_y", "d_z"],
    shapes: &|s| {
        let between_phases = s.phase.contains(&Phase::Rate) && s.phase.contains(&Phase::Static);
        let while_turning = between_phases.then_some((Shape::Linear, 4.0));
        while_turning.into_iter().chain(instants(s).map(|instant| (Shape::Instant(instant), 1.0))).collect()
    },
    columns: &|s, j, shape| {
        let gyro = &s.gyros[j];
        let about = |axis: Vector3<f64>| {
            s.column(|k| gyro.g.dot(&axis.cross(&s.force[k])) + gyro.input.dot(&axis.cross(&s.rate[k])))
        };
        let columns = [Vector3::x(), Vector3::y(), Vector3::z()].map(about);
        columns.into_iter().map(|column| afterwards(s, column, shape)).collect()
    },
    beyond: Some(|s, j, shape, d| {
        let d = Vector3::new(d[0], d[1], d[2]);
        let of_rate = |k: usize| s.gyros[j].input.dot(&beyond(d, s.rate[k]));
        afterwards(s, s.column(|k| of_rate(k) + of_force(s, j, k, d.cross(&s.force[k]), beyond(d, s.force[k]))), shape)
    }),
    parameter: Parameter::Seating,
    one_occasion: true,
    ..PLAIN
};

/// Instants within a campaign at which its station may have changed: evenly spaced ones, and pauses.
pub(super) fn instants(s: &Setting) -> impl Iterator<Item = f64> {
    const COUNT: usize = 8;
    let n = s.dwells();
    let mut first: Vec<usize> = (1..=COUNT).map(|i| (i * n / (COUNT + 1)).max(1)).collect();
    first.extend(s.pauses());
    first.sort_unstable();
    first.dedup();
    first.into_iter().filter(move |&k| k < n).map(|k| 0.5 * (s.time[k - 1] + s.time[k]))
}

/// A column where the shape has the effect: after its instant, or without one in turning dwells.
pub(super) fn afterwards(s: &Setting, mut column: Vec<f64>, shape: Shape) -> Vec<f64> {
    for (k, x) in column.iter_mut().enumerate() {
        let acts = match shape {
            Shape::Instant(instant) => s.time[k] > instant,
            _ => s.phase[k] == Phase::Rate,
        };
        if !acts {
            *x = 0.0;
        }
    }
    column
}

/// Declinations rarely exceed 20 degrees; iron in the building can turn the field anywhere.
fn field_directions(s: &Setting) -> Vec<(Shape, f64)> {
    let stated = s.field_nav.filter(|b| b.xy().norm() > 1e-6 * b.norm()).map(|b| b.x.atan2(b.y));
    match stated {
        Some(angle) => vec![(Shape::Azimuth(angle), 1.0)],
        None => {
            let weight = |degrees: f64| {
                if degrees == 0.0 {
                    8.0
                } else if degrees.abs() <= 20.0 {
                    1.0
                } else {
                    0.25
                }
            };
            [-60.0, -40.0, -20.0, -10.0, 0.0, 10.0, 20.0, 40.0, 60.0, 90.0_f64]
                .into_iter()
                .map(|d| (Shape::Azimuth(d.to_radians()), weight(d)))
                .collect()
        }
    }
}

/// A horizontal nav vector in body axes; nothing of it stays in a rate dwell.
fn in_body(s: &Setting, horizontal: Vector3<f64>) -> Vec<Vector3<f64>> {
    let Some(c) = &s.nav_to_body else { return vec![Vector3::zeros(); s.dwells()] };
    (0..s.dwells()).map(|k| if s.phase[k] == Phase::Static { c[k] * horizontal } else { Vector3::zeros() }).collect()
}

/// Drift of gyro `j` for a unit rotation about `axis` (nav); `with_rate` when the table's rate is seen turned too.
pub(super) fn tilted(s: &Setting, j: usize, axis: Vector3<f64>, with_rate: bool) -> Vec<f64> {
    let Some(c) = &s.nav_to_body else { return vec![0.0; s.dwells()] };
    let gyro = &s.gyros[j];
    let force = axis.cross(&Vector3::new(0.0, 0.0, s.gravity));
    let earth = axis.cross(&s.earth_nav);
    s.column(|k| match s.phase[k] {
        Phase::Static => gyro.input.dot(&(c[k] * earth)) + gyro.g.dot(&(c[k] * force)),
        Phase::Rate if with_rate => gyro.input.dot(&(c[k] * axis.cross(&(c[k].transpose() * s.rate[k])))),
        Phase::Rate => gyro.input.dot(&(c[k] * Vector3::new(0.0, 0.0, earth.z))),
    })
}

/// As [`tilted`], for a rotation `d` that is not small: what it adds beyond its first order.
fn tilted_beyond(s: &Setting, j: usize, d: Vector3<f64>, with_rate: bool) -> Vec<f64> {
    let Some(c) = &s.nav_to_body else { return vec![0.0; s.dwells()] };
    let (input, f, w) = (s.gyros[j].input, Vector3::new(0.0, 0.0, s.gravity), s.earth_nav);
    let up = |v: Vector3<f64>| Vector3::new(0.0, 0.0, v.z);
    s.column(|k| match s.phase[k] {
        Phase::Static => input.dot(&(c[k] * beyond(d, w))) + of_force(s, j, k, c[k] * d.cross(&f), c[k] * beyond(d, f)),
        Phase::Rate if with_rate => input.dot(&(c[k] * beyond(d, c[k].transpose() * s.rate[k]))),
        Phase::Rate => {
            input.dot(&(c[k] * up(beyond(d, w)))) + of_force(s, j, k, Vector3::zeros(), c[k] * up(beyond(d, f)))
        }
    })
}

/// What specific force that is `first` off, to first order, and `beyond` more makes beside `G.first`.
fn of_force(s: &Setting, j: usize, k: usize, first: Vector3<f64>, beyond: Vector3<f64>) -> f64 {
    let (gyro, a) = (&s.gyros[j], s.force[k]);
    let turned = a + first + beyond;
    gyro.g.dot(&beyond) + gyro.p.dot(&(turned.component_mul(&turned) - a.component_mul(&a)))
}

/// exp(d x) v - v - d x v.
fn beyond(d: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {
    Rotation3::new(d) * v - v - d.cross(&v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_quarter_turn_is_more_than_its_first_order() {
        // About the vertical it takes east to north; to first order it adds pi/2 of north and keeps east.
        let more = beyond(Vector3::z() * FRAC_PI_2, Vector3::x());
        assert!((more - Vector3::new(-1.0, 1.0 - FRAC_PI_2, 0.0)).norm() < 1e-12, "{more}");
        assert!(beyond(Vector3::z() * 1e-4, Vector3::x()).norm() < 1e-8);
    }
}
