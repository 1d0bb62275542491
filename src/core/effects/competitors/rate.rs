//! Competing hypotheses that follow the rate, this one or those before.

use super::common::picked;
use crate::core::campaign::Phase;
use crate::core::effects::entry::{COMPETING, Effect, Entry, Prior, Shape};
use crate::core::effects::setting::Setting;

pub(super) const ENTRIES: &[&Entry] = &[
    &RATE_EVEN,
    &RATE_ODD,
    &RATE_CURVE,
    &RATE_AND_FORCE,
    &STATIC_TO_RATE,
    &TORQUER_HEATING,
    &RATE_BEFORE,
    &RATE_PRODUCT,
    &SETTLING_AFTER_RATE,
];

pub const RATE_EVEN: Entry = Entry {
    effect: Effect::RateEven,
    id: "rate_even",
    cause: "torquer and electronics rectify: drift that both senses share, about any axis",
    equation: "k_x w_x^2 + k_y w_y^2 + k_z w_z^2, or with |w|",
    unit: "deg/h per (arcsec/s)^n",
    typical: [1e-12, 1e-9], // rectification of rebalance loops
    confused_with: &[Effect::ScaleAsymmetry, Effect::ScaleQuadratic, Effect::Anisoinertia],
    shapes: &|_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[1]), 1.0), (Shape::Only(&[2]), 0.5)],
    columns: &|s, _, shape| match picked(shape) {
        [0] => s.by_axis(|k, i| s.rate[k][i].powi(2)),
        [1] => s.by_axis(|k, i| s.rate[k][i].abs()),
        _ => s.by_axis(|k, i| f64::from(u8::from(turns_about(s, k, i)))),
    },
    ..COMPETING
};

pub const RATE_ODD: Entry = Entry {
    effect: Effect::RateOdd,
    id: "rate_odd",
    cause: "saturation of the torquer's magnet, about any axis",
    equation: "k_x w_x^3 + k_y w_y^3 + k_z w_z^3, or with w |w|",
    unit: "deg/h per (arcsec/s)^n",
    typical: [1e-16, 1e-9], // linearity of torquers, 10 to 100 ppm of full rate
    confused_with: &[Effect::ScaleCubic],
    shapes: &|_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[1]), 1.0), (Shape::Only(&[2]), 0.5)],
    columns: &|s, _, shape| match picked(shape) {
        [0] => s.by_axis(|k, i| s.rate[k][i].powi(3)),
        [1] => s.by_axis(|k, i| s.rate[k][i] * s.rate[k][i].abs()),
        _ => s.by_axis(|k, i| if turns_about(s, k, i) { s.rate[k][i].signum() } else { 0.0 }),
    },
    ..COMPETING
};

pub const RATE_CURVE: Entry = Entry {
    effect: Effect::RateCurve,
    id: "rate_curve",
    cause: "linearity of the rebalance loop by no single power",
    equation: "sum_n c_n (w_I/top)^n/n, n = 2 .. 7",
    unit: "deg/h",
    typical: [0.001, 1.0], // linearity of rebalance loops, 1 to 100 ppm of full rate
    confused_with: &[Effect::ScaleCubic, Effect::ScaleQuadratic, Effect::ScaleAsymmetry],
    prior: Prior::Smooth,
    columns: &rate_curve,
    ..COMPETING
};

pub const RATE_AND_FORCE: Entry = Entry {
    effect: Effect::RateAndForce,
    id: "rate_and_force",
    cause: "the torquer's gap changes under load: scale factor depends on orientation",
    equation: "w_I (k_S a_S + k_O a_O), or k . a times w",
    unit: "1/g0",
    typical: [1e-7, 0.0001], // scale factor against orientation, 0.1 to 100 ppm
    confused_with: &[Effect::GRateCoupling, Effect::Anisoinertia],
    shapes: &|_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[1]), 1.0)],
    columns: &|s, j, shape| match picked(shape) {
        [0] => s.by_axis(|k, i| s.force[k][i] * s.rate[k][i]),
        _ => {
            let gyro = &s.gyros[j];
            [gyro.spin, gyro.output]
                .iter()
                .map(|axis| s.column(|k| s.force[k].dot(axis) * s.rate[k].dot(&gyro.input)))
                .collect()
        }
    },
    ..COMPETING
};

pub const STATIC_TO_RATE: Entry = Entry {
    effect: Effect::StaticToRate,
    id: "static_to_rate",
    cause: "the unit was mounted anew, or slip rings and fans run, for the rate dwells",
    equation: "k, or k . a, in rate dwells alone",
    unit: "deg/h, deg/(h g0)",
    typical: [0.0001, 0.05], // repeatability of remounting
    confused_with: &[Effect::BiasStep, Effect::ScaleAsymmetry],
    shapes: &|_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[1]), 1.0)],
    columns: &|s, _, shape| match picked(shape) {
        [0] => vec![s.column(|k| turning(s, k))],
        _ => s.by_axis(|k, i| turning(s, k) * s.force[k][i]),
    },
    ..COMPETING
};

pub const TORQUER_HEATING: Entry = Entry {
    effect: Effect::TorquerHeating,
    id: "torquer_heating",
    cause: "the torquer's own heat after a fast dwell",
    equation: "k sum of earlier w_I^2, forgotten with tau",
    unit: "deg/h per (arcsec/s)^2",
    typical: [1e-12, 1e-9], // a watt in the torquer warms it by a kelvin
    confused_with: &[Effect::ScaleQuadratic, Effect::Warmup],
    shapes: &|s| [0.4, 1.5, 4.0, 12.0].into_iter().map(|x| (Shape::Tau(x * s.interval()), 1.0)).collect(),
    columns: &|s, j, shape| match shape {
        Shape::Tau(tau) => vec![heating(s, j, tau)],
        _ => Vec::new(),
    },
    ..COMPETING
};

pub const RATE_BEFORE: Entry = Entry {
    effect: Effect::RateBefore,
    id: "rate_before",
    cause: "fluid and suspension remember the rate before",
    equation: "k . w of the dwell before",
    unit: "1",
    typical: [1e-9, 1e-6], // settling after a change of rate
    confused_with: &[Effect::Hysteresis, Effect::ScaleAsymmetry],
    columns: &|s, _, _| s.by_axis(|k, i| if k == 0 { 0.0 } else { s.rate[k - 1][i] }),
    ..COMPETING
};

/// Two entries together follow it closely where the design has few directions of rate.
pub const RATE_PRODUCT: Entry = Entry {
    effect: Effect::RateProduct,
    id: "rate_product",
    cause: "lever arms and the inertia of float and wheel: products of rates that no entry has, also with temperature",
    equation: "k w_S^2, k w_O^2, k w_I w_O or k w_S w_O, or T w_I^2, T w_S or T w_O",
    unit: "deg/h per (arcsec/s)^n",
    typical: [1e-12, 1e-9], // rigid-body terms of floated gyros
    confused_with: &[Effect::Anisoinertia, Effect::ScaleQuadratic, Effect::TemperatureScale, Effect::Reseating],
    shapes: &|s| {
        let products = 0..if s.temperature.is_some() { PRODUCTS.len() } else { 4 };
        products.map(|i| (Shape::Only(&PRODUCTS[i]), 1.0)).collect()
    },
    columns: &|s, j, shape| {
        let gyro = &s.gyros[j];
        let product = |k: usize| {
            let [i, sp, o] = [gyro.input, gyro.spin, gyro.output].map(|axis| s.rate[k].dot(&axis));
            let t = s.kelvin(k);
            match picked(shape) {
                [0] => sp * sp,
                [1] => o * o,
                [2] => i * o,
                [3] => sp * o,
                [4] => t * i * i,
                [5] => t * sp,
                _ => t * o,
            }
        };
        vec![s.column(product)]
    },
    only_closer: true,
    ..COMPETING
};

pub const SETTLING_AFTER_RATE: Entry = Entry {
    effect: Effect::SettlingAfterRate,
    id: "settling_after_rate",
    cause: "fluid, case and slip rings settle after the table has turned, however fast",
    equation: "k exp(-t/tau), t since the table last turned",
    unit: "deg/h",
    typical: [0.0001, 0.05], // thermal settling after a change of rate
    confused_with: &[Effect::BiasStep, Effect::Warmup, Effect::Periodic],
    shapes: &|s| [0.5, 1.5, 4.0, 12.0].into_iter().map(|x| (Shape::Tau(x * s.interval()), 1.0)).collect(),
    columns: &|s, _, shape| match shape {
        Shape::Tau(tau) => vec![settling(s, tau)],
        _ => Vec::new(),
    },
    only_closer: true,
    ..COMPETING
};

const PRODUCTS: [[usize; 1]; 7] = [[0], [1], [2], [3], [4], [5], [6]];

/// What is left, of one, of the last turn.
fn settling(s: &Setting, tau: f64) -> Vec<f64> {
    let mut ended = None;
    (0..s.dwells())
        .map(|k| {
            let left = ended.map_or(0.0, |ended: f64| ((ended - s.time[k]) / tau).exp());
            if s.phase[k] == Phase::Rate {
                ended = Some(s.time[k] + 0.5 * s.duration[k]);
            }
            left
        })
        .collect()
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
