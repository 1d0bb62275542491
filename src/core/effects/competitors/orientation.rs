//! Competing hypotheses that follow the orientation, this one or the one before.

use nalgebra::Vector3;

use super::common::picked;
use crate::core::campaign::Phase;
use crate::core::effects::entry::{COMPETING, Effect, Entry, Shape};
use crate::core::effects::setting::Setting;

pub(super) const ENTRIES: &[&Entry] = &[&ORIENTATION_HARMONICS, &FRICTION, &HEADING, &EARTH_RATE, &ORIENTATION_BEFORE];

pub const ORIENTATION_HARMONICS: Entry = Entry {
    effect: Effect::OrientationHarmonics,
    id: "orientation_harmonics",
    cause: "flexure of case and mount under their own weight beyond second degree",
    equation: "sum of c a_x^l a_y^m a_z^n, l + m + n = 3 and 4",
    unit: "deg/(h g0^n)",
    typical: [0.0001, 0.01], // residuals of multi-position tests
    confused_with: &[Effect::CrossCompliance, Effect::CubicG],
    shapes: &|_| vec![(Shape::Only(&[3]), 1.0), (Shape::Only(&[3, 4]), 1.0)],
    columns: &|s, _, shape| picked(shape).iter().flat_map(|&degree| monomials(s, degree)).collect(),
    ..COMPETING
};

pub const FRICTION: Entry = Entry {
    effect: Effect::Friction,
    id: "friction",
    cause: "pivots and flex leads hold by friction: the sense of the load counts",
    equation: "k_I |a_I| + k_S |a_S| + k_O |a_O|",
    unit: "deg/(h g0)",
    typical: [0.0001, 0.01], // pivot friction of floats without full flotation
    confused_with: &[Effect::Hysteresis, Effect::GSquared],
    shapes: &|_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[0, 1, 2]), 1.0)],
    columns: &|s, j, shape| {
        let gyro = &s.gyros[j];
        let axes = [gyro.input, gyro.spin, gyro.output];
        picked(shape).iter().map(|&i| s.column(|k| s.force[k].dot(&axes[i]).abs())).collect()
    },
    ..COMPETING
};

pub const HEADING: Entry = Entry {
    effect: Effect::Heading,
    id: "heading",
    cause: "cables, air flow and gradients in the room follow the table's heading",
    equation: "k . C e_E + k . C e_N, and products of them",
    unit: "deg/h",
    typical: [0.0001, 0.01], // repeatability between headings of one face
    confused_with: &[Effect::Azimuth, Effect::Magnetic, Effect::Levelling],
    shapes: &|_| vec![(Shape::Only(&[0, 1]), 1.0), (Shape::Only(&[2]), 1.0), (Shape::Only(&[0, 1, 2]), 0.5)],
    columns: &|s, _, shape| picked(shape).iter().flat_map(|&part| heading(s, part)).collect(),
    ..COMPETING
};

/// Its part along the vertical lies inside G.
pub const EARTH_RATE: Entry = Entry {
    effect: Effect::EarthRate,
    id: "earth_rate",
    cause: "the latitude, or the Earth's rate, that the dwells' rates were made with is wrong",
    equation: "k . I C e_N in static dwells, k the error of the rate along north",
    unit: "deg/h",
    typical: [0.0001, 1.0], // a latitude wrong by arc minutes to degrees: 15.04 deg/h sin(latitude)
    confused_with: &[Effect::Magnetic, Effect::Azimuth, Effect::Levelling],
    columns: &|s, j, _| {
        let Some(c) = &s.nav_to_body else { return Vec::new() };
        let along = |k: usize| s.gyros[j].input.dot(&(c[k] * Vector3::y()));
        vec![s.column(|k| if s.phase[k] == Phase::Static { along(k) } else { 0.0 })]
    },
    ..COMPETING
};

pub const ORIENTATION_BEFORE: Entry = Entry {
    effect: Effect::OrientationBefore,
    id: "orientation_before",
    cause: "the float and the fluid remember how they stood before",
    equation: "k . a of the dwell before",
    unit: "deg/(h g0)",
    typical: [0.0001, 0.05], // settling after a change of position
    confused_with: &[Effect::Hysteresis],
    columns: &|s, _, _| s.by_axis(|k, i| if k == 0 { 0.0 } else { s.force[k - 1][i] }),
    ..COMPETING
};

/// All products of body components of specific force of one degree.
fn monomials(s: &Setting, degree: usize) -> Vec<Vec<f64>> {
    let mut found = Vec::new();
    for x in 0..=degree {
        for y in 0..=degree - x {
            let z = degree - x - y;
            found.push(s.column(|k| {
                let a = &s.force[k];
                a.x.powi(x as i32) * a.y.powi(y as i32) * a.z.powi(z as i32)
            }));
        }
    }
    found
}

/// East (0) and north (1) in body axes, and their products (2): what turns with the table's heading.
fn heading(s: &Setting, part: usize) -> Vec<Vec<f64>> {
    let Some(c) = &s.nav_to_body else { return Vec::new() };
    let still = |k: usize| f64::from(u8::from(s.phase[k] == Phase::Static));
    let axis = |k: usize, nav: Vector3<f64>| still(k) * (c[k] * nav);
    match part {
        0 => s.by_axis(|k, i| axis(k, Vector3::x())[i]),
        1 => s.by_axis(|k, i| axis(k, Vector3::y())[i]),
        _ => (0..3)
            .flat_map(|i| (0..=i).map(move |l| (i, l)))
            .map(|(i, l)| s.column(|k| axis(k, Vector3::x())[i] * axis(k, Vector3::x())[l]))
            .collect(),
    }
}
