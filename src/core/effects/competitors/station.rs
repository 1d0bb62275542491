//! Competing hypotheses of the station that all gyros share.

use nalgebra::Vector3;

use super::common::{mid, picked};
use crate::core::campaign::Phase;
use crate::core::effects::entry::{COMPETING, Effect, Entry, Scope, Shape};
use crate::core::effects::setting::Setting;
use crate::core::effects::station::{AZIMUTH, LEVELLING, afterwards, instants, tilted};
use crate::core::units::STANDARD_GRAVITY_M_S2;

pub(super) const ENTRIES: &[&Entry] = &[&TABLE_RATE, &LEVER_ARM, &DRIFTING_TABLE, &MISALIGNMENT];

pub const TABLE_RATE: Entry = Entry {
    effect: Effect::TableRate,
    id: "table_rate",
    cause: "the table turns faster or slower than it says, in one sense or at one rate",
    equation: "k E.u |w_u|/|E|, or k E.u w_u/|E| at one rate, w_u the table's rate about the vertical u",
    unit: "1",
    typical: [1e-7, 1e-4], // rate accuracy of tables, 0.1 to 100 ppm
    confused_with: &[Effect::ScaleAsymmetry, Effect::ScaleCubic, Effect::Relevelling],
    scope: Scope::Common,
    shapes: &|s| {
        let levels = LEVELS.iter().take(levels(s).len()).map(|level| (Shape::Only(level), 0.5));
        [(Shape::Only(&[]), 1.0)].into_iter().chain(levels).collect()
    },
    columns: &|s, j, shape| {
        let levels = levels(s);
        let along = |k: usize| s.gyros[j].input.dot(&s.force[k]) / s.force[k].norm();
        let wrong_by = |k: usize| match picked(shape) {
            [] => table_rate(s, k).abs(),
            [level] if is_at(levels[*level], table_rate(s, k)) => table_rate(s, k),
            _ => 0.0,
        };
        vec![s.column(|k| along(k) * wrong_by(k))]
    },
    only_closer: true,
    ..COMPETING
};

pub const LEVER_ARM: Entry = Entry {
    effect: Effect::LeverArm,
    id: "lever_arm",
    cause: "the IMU sits off the table's axis: it is thrown outwards, and G sees it",
    equation: "G.(w x (w x r))/|E|, r in body axes",
    unit: "m",
    typical: [0.01, 0.5], // fixtures
    confused_with: &[Effect::Anisoinertia, Effect::ScaleQuadratic, Effect::ScaleAsymmetry],
    scope: Scope::Common,
    columns: &|s, j, _| {
        let outwards = |k: usize, axis: Vector3<f64>| {
            let w = s.rate[k] * ARCSEC;
            s.gyros[j].g.dot(&w.cross(&w.cross(&axis))) / STANDARD_GRAVITY_M_S2
        };
        [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| s.column(|k| outwards(k, axis))).to_vec()
    },
    only_closer: true,
    ..COMPETING
};

/// One rotation to all gyros, of which each takes its part in `levelling` and `azimuth` for one of its own.
pub const MISALIGNMENT: Entry = Entry {
    effect: Effect::Misalignment,
    id: "misalignment",
    cause: "the table is neither level nor turned to the north: one small rotation, the same to all gyros",
    equation: "G.C(d x f)/|E| + E.C(d x w)/|E|, d = (d_E, d_N, d_U)",
    unit: "rad",
    typical: [5e-6, 3e-3], // levelling and north alignment of tables
    confused_with: &[Effect::Levelling, Effect::Azimuth, Effect::Magnetic],
    parts: &[Effect::Levelling, Effect::Azimuth],
    scope: Scope::Common,
    missing: LEVELLING.missing,
    shapes: LEVELLING.shapes,
    columns: &|s, j, shape| [(LEVELLING.columns)(s, j, shape), (AZIMUTH.columns)(s, j, shape)].concat(),
    ..COMPETING
};

pub const DRIFTING_TABLE: Entry = Entry {
    effect: Effect::DriftingTable,
    id: "drifting_table",
    cause: "the pier settles, the north reference drifts or is set anew: tilt or azimuth change in the campaign",
    equation: "t (G.C(d x f)/|E| + E.C(d x w)/|E|), d = (d_E, d_N, 0) or (0, 0, d_U), or H(t - t_0) with d_U",
    unit: "rad per campaign",
    typical: [1e-6, 1e-3], // stability of piers within a day
    confused_with: &[Effect::Relevelling, Effect::Levelling, Effect::Azimuth, Effect::TemperatureG],
    scope: Scope::Common,
    shapes: &|s| {
        let instants: Vec<f64> = instants(s).collect();
        let weight = 1.0 / instants.len().max(1) as f64;
        let anew = instants.into_iter().map(|instant| (Shape::Instant(instant), weight));
        [(Shape::Only(&[0]), 1.0), (Shape::Only(&[1]), 1.0)].into_iter().chain(anew).collect()
    },
    columns: &|s, j, shape| {
        let turned = |axis: Vector3<f64>| tilted(s, j, axis, false);
        let drifting = |axis: Vector3<f64>| {
            turned(axis).into_iter().enumerate().map(|(k, x)| 0.5 * (1.0 + mid(s, k)) * x).collect()
        };
        match (shape, picked(shape)) {
            (Shape::Instant(_), _) => vec![afterwards(s, turned(Vector3::z()), shape)],
            (_, [0]) => vec![drifting(Vector3::x()), drifting(Vector3::y())],
            _ => vec![turned(Vector3::z()), drifting(Vector3::z())],
        }
    },
    only_closer: true,
    ..COMPETING
};

/// Radians.
const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;

/// Rates of a table that are told from one another: more are those of a sweep.
const LEVELS: [&[usize]; 8] = [&[0], &[1], &[2], &[3], &[4], &[5], &[6], &[7]];

/// The table's rate about the vertical, arcsec/s.
fn table_rate(s: &Setting, k: usize) -> f64 {
    match s.phase[k] {
        Phase::Rate => s.rate[k].dot(&s.force[k]) / s.force[k].norm() - s.earth_nav.z,
        Phase::Static => 0.0,
    }
}

/// Sizes of the table's rates.
fn levels(s: &Setting) -> Vec<f64> {
    let mut all: Vec<f64> = (0..s.dwells()).map(|k| table_rate(s, k).abs()).filter(|rate| *rate > 1.0).collect();
    all.sort_unstable_by(f64::total_cmp);
    all.dedup_by(|a, b| is_at(*b, *a));
    all
}

fn is_at(level: f64, rate: f64) -> bool {
    (rate.abs() / level - 1.0).abs() < 0.01
}
