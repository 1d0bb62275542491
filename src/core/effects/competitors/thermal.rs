//! Competing hypotheses that follow temperature.

use super::common::{mid, picked};
use crate::core::effects::entry::{COMPETING, Effect, Entry, Shape};
use crate::core::effects::setting::Setting;

pub(super) const ENTRIES: &[&Entry] = &[
    &BENT_TEMPERATURE,
    &TEMPERATURE_RATE,
    &TEMPERATURE_LAG,
    &TEMPERATURE_AND_TIME,
    &TEMPERATURE_G_SQUARED,
    &LAGGING_SENSITIVITY,
];

pub const BENT_TEMPERATURE: Entry = Entry {
    effect: Effect::BentTemperature,
    id: "bent_temperature",
    cause: "viscosity and buoyancy of the flotation fluid are no straight line in temperature",
    equation: "k_1 T + k_2 T^2 + k_3 T^3",
    unit: "deg/h/K^n",
    typical: [0.0001, 0.05], // IEEE 517, temperature sensitivity beyond first degree
    confused_with: &[Effect::TemperatureBias, Effect::Warmup, Effect::Periodic],
    shapes: &|_| vec![(Shape::Only(&[2]), 1.0), (Shape::Only(&[1, 2]), 1.0), (Shape::Only(&[1, 2, 3]), 1.0)],
    columns: &|s, _, shape| picked(shape).iter().map(|&degree| temperature_power(s, degree as i32)).collect(),
    of_temperature: true,
    ..COMPETING
};

pub const TEMPERATURE_RATE: Entry = Entry {
    effect: Effect::TemperatureRate,
    id: "temperature_rate",
    cause: "gradients through the case while it warms or cools turn the float",
    equation: "k dT/dt",
    unit: "deg/h/(K/s)",
    typical: [1.0, 1e3], // IEEE 517, thermal gradients; 0.001 to 0.1 deg/h at 1 K/h
    confused_with: &[Effect::TemperatureBias, Effect::Warmup, Effect::Periodic],
    shapes: &|_| vec![(Shape::Only(&[0]), 1.0), (Shape::Only(&[0, 1]), 0.5)],
    columns: &|s, _, shape| {
        let all = [temperature_slope(s), temperature_power(s, 1)];
        picked(shape).iter().map(|&i| all[i].clone()).collect()
    },
    of_temperature: true,
    ..COMPETING
};

pub const TEMPERATURE_LAG: Entry = Entry {
    effect: Effect::TemperatureLag,
    id: "temperature_lag",
    cause: "the float follows the case late",
    equation: "k T as an exponential lag leaves it",
    unit: "deg/h/K",
    typical: [0.001, 0.1], // thermal time constants of floated gyros, minutes to an hour
    confused_with: &[Effect::TemperatureBias, Effect::Warmup],
    shapes: &|s| [2.0, 4.0, 8.0, 16.0].into_iter().map(|x| (Shape::Tau(x * s.interval()), 1.0)).collect(),
    columns: &|s, _, shape| match shape {
        Shape::Tau(tau) => vec![temperature_lagged(s, tau)],
        _ => Vec::new(),
    },
    of_temperature: true,
    ..COMPETING
};

pub const TEMPERATURE_AND_TIME: Entry = Entry {
    effect: Effect::TemperatureAndTime,
    id: "temperature_and_time",
    cause: "the sensitivity to temperature changes as the unit settles",
    equation: "k t T",
    unit: "deg/h/K per campaign",
    typical: [0.0001, 0.05], // as temperature_bias, changing within a day
    confused_with: &[Effect::TemperatureBias, Effect::TimeRamp],
    columns: &|s, _, _| vec![s.column(|k| mid(s, k) * s.kelvin(k))],
    of_temperature: true,
    ..COMPETING
};

pub const TEMPERATURE_G_SQUARED: Entry = Entry {
    effect: Effect::TemperatureGSquared,
    id: "temperature_g_squared",
    cause: "stiffness of gimbal and bearings follows temperature: compliance does",
    equation: "T (k_x a_x^2 + k_y a_y^2 + k_z a_z^2)",
    unit: "deg/(h g0^2 K)",
    typical: [0.0001, 0.01], // IEEE 517, temperature sensitivity of compliance
    confused_with: &[Effect::TemperatureBias, Effect::TemperatureG],
    columns: &|s, _, _| s.by_axis(|k, i| s.kelvin(k) * s.force[k][i].powi(2)),
    of_temperature: true,
    ..COMPETING
};

pub const LAGGING_SENSITIVITY: Entry = Entry {
    effect: Effect::LaggingSensitivity,
    id: "lagging_sensitivity",
    cause: "magnet, float and fluid follow the case late: scale factor and mass unbalance do, too",
    equation: "k T w_I, or T (k_x a_x + k_y a_y + k_z a_z), T as an exponential lag leaves it",
    unit: "1/K, deg/(h g0 K)",
    typical: [1e-6, 0.01], // as temperature_scale and temperature_g
    confused_with: &[Effect::TemperatureScale, Effect::TemperatureG, Effect::GRateCoupling],
    shapes: &|s| LAGS.into_iter().flat_map(|x| [x, -x]).map(|x| (Shape::Tau(x * s.interval()), 1.0)).collect(),
    columns: &|s, j, shape| match shape {
        // The sign tells one from the other.
        Shape::Tau(tau) if tau > 0.0 => {
            let late = temperature_lagged(s, tau);
            vec![s.column(|k| late[k] * s.rate[k].dot(&s.gyros[j].input))]
        }
        Shape::Tau(tau) => {
            let late = temperature_lagged(s, -tau);
            s.by_axis(|k, i| late[k] * s.force[k][i])
        }
        _ => Vec::new(),
    },
    of_temperature: true,
    only_closer: true,
    ..COMPETING
};

/// Time constants of lags, in intervals between dwells.
const LAGS: [f64; 4] = [2.0, 5.0, 12.0, 30.0];

fn temperature_power(s: &Setting, degree: i32) -> Vec<f64> {
    s.column(|k| s.kelvin(k).powi(degree))
}

/// Temperature now less temperature one dwell before, over the time between.
fn temperature_slope(s: &Setting) -> Vec<f64> {
    s.column(|k| {
        let k = k.max(1).min(s.dwells() - 1);
        if s.dwells() < 2 { 0.0 } else { (s.kelvin(k) - s.kelvin(k - 1)) / (s.time[k] - s.time[k - 1]) }
    })
}

fn temperature_lagged(s: &Setting, tau: f64) -> Vec<f64> {
    let mut state = s.kelvin(0);
    (0..s.dwells())
        .map(|k| {
            if k > 0 {
                let keep = (-(s.time[k] - s.time[k - 1]) / tau).exp();
                state = keep * state + (1.0 - keep) * s.kelvin(k);
            }
            state
        })
        .collect()
}
