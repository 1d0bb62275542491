//! What else physics and table work produce, beyond the contract: competitors and signs, never names.
//!
//! A contract entry that merely resembles one of these must not get its name, so they take part in the search. Where
//! one of them wins, the answer says what kind of structure is there and that the catalogue does not explain it.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::{Setting, Shape};
use crate::core::campaign::Phase;

/// How the coefficients of a suspect's columns are distributed before the data speak.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Prior {
    /// Any direction in the span of the columns alike.
    Flat,
    /// In proportion to the columns' own lengths: a smooth curve as a sum of ever smaller waves.
    Smooth,
}

/// A kind of structure outside the contract.
#[derive(Debug, Clone, Copy)]
pub struct Suspect {
    pub id: &'static str,
    /// What it looks like, for people.
    pub looks_like: &'static str,
    pub prior: Prior,
    pub shapes: fn(&Setting) -> Vec<(Shape, f64)>,
    pub columns: fn(&Setting, usize, Shape) -> Vec<Vec<f64>>,
}

/// The suspects that follow any course of the bias in time, from smooth to a random walk.
pub const WANDERING: [&str; 3] = ["curve_in_time", "wander_in_time", "correlated_in_time"];

pub const SUSPECTS: &[Suspect] = &[
    Suspect {
        id: "curve_in_time",
        looks_like: "a smooth course in time",
        prior: Prior::Smooth,
        shapes: one,
        columns: |s, _, _| waves(s, 9, 2.0),
    },
    Suspect {
        id: "wander_in_time",
        looks_like: "a random walk in time",
        prior: Prior::Smooth,
        shapes: one,
        columns: |s, _, _| waves(s, 16, 1.0),
    },
    Suspect {
        id: "correlated_in_time",
        looks_like: "noise that neighbouring dwells share",
        prior: Prior::Smooth,
        shapes: one,
        columns: |s, _, _| waves(s, 26, 0.35),
    },
    Suspect {
        id: "bend_in_time",
        looks_like: "a bend in time",
        prior: Prior::Flat,
        shapes: |_| vec![(Shape::Only(&[2]), 1.0), (Shape::Only(&[1, 2]), 1.0), (Shape::Only(&[1, 2, 3]), 1.0)],
        columns: |s, _, shape| picked(shape).iter().map(|&degree| legendre_in_time(s, degree)).collect(),
    },
    Suspect {
        id: "burst",
        looks_like: "a passing disturbance of several dwells",
        prior: Prior::Flat,
        shapes: windows,
        columns: |s, _, shape| match shape {
            Shape::Window(from, to) => vec![s.column(|k| f64::from(u8::from((from..to).contains(&k))))],
            _ => Vec::new(),
        },
    },
    Suspect {
        id: "drifting_mass_unbalance",
        looks_like: "g-sensitivity that changes with time",
        prior: Prior::Flat,
        shapes: one,
        columns: |s, _, _| (0..3).map(|i| s.column(|k| mid(s, k) * s.force[k][i])).collect(),
    },
    Suspect {
        id: "drifting_scale",
        looks_like: "a scale factor that changes with time",
        prior: Prior::Flat,
        shapes: one,
        columns: |s, j, _| vec![s.column(|k| mid(s, k) * s.rate[k].dot(&s.gyros[j].input))],
    },
    Suspect {
        id: "bent_temperature",
        looks_like: "a bend in temperature",
        prior: Prior::Flat,
        shapes: |_| vec![(Shape::Only(&[2]), 1.0), (Shape::Only(&[1, 2]), 1.0), (Shape::Only(&[1, 2, 3]), 1.0)],
        columns: |s, _, shape| picked(shape).iter().map(|&degree| temperature_power(s, degree as i32)).collect(),
    },
    Suspect {
        id: "temperature_rate",
        looks_like: "a response to the rate of change of temperature",
        prior: Prior::Flat,
        shapes: |_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[0, 1]), 0.5)],
        columns: |s, _, shape| {
            let all = [temperature_slope(s), temperature_power(s, 1)];
            picked(shape).iter().map(|&i| all[i].clone()).collect()
        },
    },
    Suspect {
        id: "temperature_lag",
        looks_like: "a late response to temperature",
        prior: Prior::Flat,
        shapes: |s| [2.0, 4.0, 8.0, 16.0].into_iter().map(|x| (Shape::Tau(x * s.interval()), 1.0)).collect(),
        columns: |s, _, shape| match shape {
            Shape::Tau(tau) => vec![temperature_lagged(s, tau)],
            _ => Vec::new(),
        },
    },
    Suspect {
        id: "temperature_and_time",
        looks_like: "a response to temperature that changes with time",
        prior: Prior::Flat,
        shapes: one,
        columns: |s, _, _| vec![s.column(|k| mid(s, k) * temperature(s, k))],
    },
    Suspect {
        id: "temperature_g_squared",
        looks_like: "compliance that follows temperature",
        prior: Prior::Flat,
        shapes: one,
        columns: |s, _, _| (0..3).map(|i| s.column(|k| temperature(s, k) * s.force[k][i].powi(2))).collect(),
    },
    Suspect {
        id: "orientation_harmonics",
        looks_like: "a function of orientation beyond second degree",
        prior: Prior::Flat,
        shapes: |_| vec![(Shape::Only(&[3]), 1.0), (Shape::Only(&[3, 4]), 1.0)],
        columns: |s, _, shape| picked(shape).iter().flat_map(|&degree| monomials(s, degree)).collect(),
    },
    Suspect {
        id: "friction",
        looks_like: "a dependence on the sense of specific force",
        prior: Prior::Flat,
        shapes: |_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[0, 1, 2]), 1.0)],
        columns: |s, j, shape| {
            let gyro = &s.gyros[j];
            let axes = [gyro.input, gyro.spin, gyro.output];
            picked(shape).iter().map(|&i| s.column(|k| s.force[k].dot(&axes[i]).abs())).collect()
        },
    },
    Suspect {
        id: "heading",
        looks_like: "a dependence on the table's heading",
        prior: Prior::Flat,
        shapes: |_| vec![(Shape::Only(&[0, 1]), 1.0), (Shape::Only(&[2]), 1.0), (Shape::Only(&[0, 1, 2]), 0.5)],
        columns: |s, _, shape| picked(shape).iter().flat_map(|&part| heading(s, part)).collect(),
    },
    Suspect {
        id: "rate_even",
        looks_like: "an even function of rate",
        prior: Prior::Flat,
        shapes: |_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[1]), 1.0), (Shape::Only(&[2]), 0.5)],
        columns: |s, _, shape| match picked(shape) {
            [0] => (0..3).map(|i| s.column(|k| s.rate[k][i].powi(2))).collect(),
            [1] => (0..3).map(|i| s.column(|k| s.rate[k][i].abs())).collect(),
            _ => (0..3).map(|i| s.column(|k| f64::from(u8::from(turns_about(s, k, i))))).collect(),
        },
    },
    Suspect {
        id: "rate_odd",
        looks_like: "an odd function of rate",
        prior: Prior::Flat,
        shapes: |_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[1]), 1.0), (Shape::Only(&[2]), 0.5)],
        columns: |s, _, shape| match picked(shape) {
            [0] => (0..3).map(|i| s.column(|k| s.rate[k][i].powi(3))).collect(),
            [1] => (0..3).map(|i| s.column(|k| s.rate[k][i] * s.rate[k][i].abs())).collect(),
            _ => (0..3).map(|i| s.column(|k| if turns_about(s, k, i) { s.rate[k][i].signum() } else { 0.0 })).collect(),
        },
    },
    Suspect {
        id: "rate_curve",
        looks_like: "a smooth function of the rate along the input axis",
        prior: Prior::Smooth,
        shapes: one,
        columns: rate_curve,
    },
    Suspect {
        id: "rate_and_force",
        looks_like: "a scale factor that depends on orientation",
        prior: Prior::Flat,
        shapes: |_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[1]), 1.0)],
        columns: |s, j, shape| match picked(shape) {
            [0] => (0..3).map(|i| s.column(|k| s.force[k][i] * s.rate[k][i])).collect(),
            _ => {
                let gyro = &s.gyros[j];
                [gyro.spin, gyro.output]
                    .iter()
                    .map(|axis| s.column(|k| s.force[k].dot(axis) * s.rate[k].dot(&gyro.input)))
                    .collect()
            }
        },
    },
    Suspect {
        id: "static_to_rate",
        looks_like: "a difference between standing and turning",
        prior: Prior::Flat,
        shapes: |_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[1]), 1.0)],
        columns: |s, _, shape| match picked(shape) {
            [0] => vec![s.column(|k| turning(s, k))],
            _ => (0..3).map(|i| s.column(|k| turning(s, k) * s.force[k][i])).collect(),
        },
    },
    Suspect {
        id: "orientation_before",
        looks_like: "a memory of the orientation before",
        prior: Prior::Flat,
        shapes: one,
        columns: |s, _, _| (0..3).map(|i| s.column(|k| if k == 0 { 0.0 } else { s.force[k - 1][i] })).collect(),
    },
    Suspect {
        id: "torquer_heating",
        looks_like: "a memory of the rates before",
        prior: Prior::Flat,
        shapes: |s| [0.4, 1.5, 4.0, 12.0].into_iter().map(|x| (Shape::Tau(x * s.interval()), 1.0)).collect(),
        columns: |s, j, shape| match shape {
            Shape::Tau(tau) => vec![heating(s, j, tau)],
            _ => Vec::new(),
        },
    },
    Suspect {
        id: "rate_before",
        looks_like: "a memory of the rate before",
        prior: Prior::Flat,
        shapes: one,
        columns: |s, _, _| (0..3).map(|i| s.column(|k| if k == 0 { 0.0 } else { s.rate[k - 1][i] })).collect(),
    },
];

fn one(_: &Setting) -> Vec<(Shape, f64)> {
    vec![(Shape::Linear, 1.0)]
}

fn picked(shape: Shape) -> &'static [usize] {
    match shape {
        Shape::Only(picked) => picked,
        _ => &[],
    }
}

/// Time from -1 at the first dwell to +1 at the last.
fn mid(s: &Setting, k: usize) -> f64 {
    let span = s.span();
    if span > 0.0 { 2.0 * s.elapsed(k) / span - 1.0 } else { 0.0 }
}

fn temperature(s: &Setting, k: usize) -> f64 {
    s.temperature.as_ref().map_or(0.0, |t| t[k])
}

/// Half cosines over the campaign, the m-th in proportion to m^-roughness.
fn waves(s: &Setting, count: usize, roughness: f64) -> Vec<Vec<f64>> {
    (1..=count.min(s.dwells() / 2))
        .map(|m| {
            let size = (m as f64).powf(-roughness);
            s.column(|k| size * (PI * m as f64 * 0.5 * (mid(s, k) + 1.0)).cos())
        })
        .collect()
}

fn legendre_in_time(s: &Setting, degree: usize) -> Vec<f64> {
    s.column(|k| {
        let x = mid(s, k);
        match degree {
            1 => x,
            2 => 1.5 * x * x - 0.5,
            _ => 2.5 * x.powi(3) - 1.5 * x,
        }
    })
}

/// Windows of three to a third of the dwells, clear of both ends (one that reaches an end is a step).
fn windows(s: &Setting) -> Vec<(Shape, f64)> {
    let n = s.dwells();
    let mut found = Vec::new();
    for width in [2, 3, 4, 6, 8, 11, 15, 20, 27] {
        let stride = (width / 4).max(1);
        for from in (1..n.saturating_sub(width)).step_by(stride) {
            if 3 * width <= n {
                found.push((Shape::Window(from, from + width), stride as f64 / width as f64));
            }
        }
    }
    if found.is_empty() { vec![(Shape::Window(0, 0), 1.0)] } else { found }
}

fn temperature_power(s: &Setting, degree: i32) -> Vec<f64> {
    s.column(|k| temperature(s, k).powi(degree))
}

/// Temperature now less temperature one dwell before, over the time between.
fn temperature_slope(s: &Setting) -> Vec<f64> {
    s.column(|k| {
        let k = k.max(1).min(s.dwells() - 1);
        if s.dwells() < 2 { 0.0 } else { (temperature(s, k) - temperature(s, k - 1)) / (s.time[k] - s.time[k - 1]) }
    })
}

fn temperature_lagged(s: &Setting, tau: f64) -> Vec<f64> {
    let mut state = temperature(s, 0);
    (0..s.dwells())
        .map(|k| {
            if k > 0 {
                let keep = (-(s.time[k] - s.time[k - 1]) / tau).exp();
                state = keep * state + (1.0 - keep) * temperature(s, k);
            }
            state
        })
        .collect()
}

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
        0 => (0..3).map(|i| s.column(|k| axis(k, Vector3::x())[i])).collect(),
        1 => (0..3).map(|i| s.column(|k| axis(k, Vector3::y())[i])).collect(),
        _ => (0..3)
            .flat_map(|i| (0..=i).map(move |l| (i, l)))
            .map(|(i, l)| s.column(|k| axis(k, Vector3::x())[i] * axis(k, Vector3::x())[l]))
            .collect(),
    }
}

fn turning(s: &Setting, k: usize) -> f64 {
    f64::from(u8::from(s.phase[k] == Phase::Rate))
}

fn turns_about(s: &Setting, k: usize, axis: usize) -> bool {
    s.phase[k] == Phase::Rate && s.rate[k].iamax() == axis
}

/// Legendre polynomials of degree two to seven in w_I over its largest value, falling off with degree.
fn rate_curve(s: &Setting, j: usize, _: Shape) -> Vec<Vec<f64>> {
    let rate = s.column(|k| s.rate[k].dot(&s.gyros[j].input));
    let top = rate.iter().fold(0.0_f64, |m, w| m.max(w.abs()));
    if top == 0.0 {
        return Vec::new();
    }
    (2..=7_i32).map(|degree| rate.iter().map(|w| (w / top).powi(degree) / f64::from(degree)).collect()).collect()
}

/// Heat of the torquer: w_I^2 of all dwells before, forgotten with `tau`.
fn heating(s: &Setting, j: usize, tau: f64) -> Vec<f64> {
    let mut heat = 0.0;
    (0..s.dwells())
        .map(|k| {
            if k > 0 {
                let keep = (-(s.time[k] - s.time[k - 1]) / tau).exp();
                heat = keep * (heat + s.rate[k - 1].dot(&s.gyros[j].input).powi(2));
            }
            heat
        })
        .collect()
}
