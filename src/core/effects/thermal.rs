//! Effects of temperature, T = temperature minus the campaign's mean, K.

use super::entry::{Effect, Entry, PLAIN, Parameter, Shape, no_temperature};
use super::setting::Setting;

pub(super) const ENTRIES: &[&Entry] = &[&TEMPERATURE_BIAS, &TEMPERATURE_G, &TEMPERATURE_SCALE];

pub const TEMPERATURE_BIAS: Entry = Entry {
    effect: Effect::TemperatureBias,
    id: "temperature_bias",
    cause: "buoyancy, flex leads and electronics change with temperature: bias follows it",
    equation: "k T",
    unit: "deg/h/K",
    typical: [1e-3, 0.1], // IEEE 517, temperature sensitivity of bias of floated gyros
    plausible: 200.0,
    confused_with: &[Effect::TimeRamp, Effect::Warmup, Effect::Periodic],
    missing: &no_temperature,
    columns: &|s, _, _| vec![temperature_times(s, |_| 1.0)],
    of_temperature: true,
    follows_time: true,
    ..PLAIN
};

pub const TEMPERATURE_G: Entry = Entry {
    effect: Effect::TemperatureG,
    id: "temperature_g",
    cause: "thermal expansion shifts the centres of mass and buoyancy: mass unbalance follows temperature",
    equation: "T (k_x a_x + k_y a_y + k_z a_z), or T (k_I a_I + k_S a_S)",
    unit: "deg/(h g0 K)",
    typical: [1e-3, 0.1], // IEEE 517, temperature sensitivity of mass unbalance
    plausible: 50.0,
    confused_with: &[Effect::TemperatureBias, Effect::TemperatureScale],
    names: &|shape| if shape == Shape::InputSpin { vec!["k_I", "k_S"] } else { vec!["k_x", "k_y", "k_z"] },
    missing: &no_temperature,
    shapes: &|_| vec![(Shape::InputSpin, 1.0), (Shape::Linear, 1.0)],
    columns: &|s, j, shape| match shape {
        Shape::InputSpin => {
            let gyro = &s.gyros[j];
            vec![
                temperature_times(s, |k| s.force[k].dot(&gyro.input)),
                temperature_times(s, |k| s.force[k].dot(&gyro.spin)),
            ]
        }
        _ => (0..3).map(|i| temperature_times(s, |k| s.force[k][i])).collect(),
    },
    parameter: Parameter::Axes,
    of_temperature: true,
    ..PLAIN
};

pub const TEMPERATURE_SCALE: Entry = Entry {
    effect: Effect::TemperatureScale,
    id: "temperature_scale",
    cause: "torquer magnet and resistor change with temperature: scale factor follows it",
    equation: "k T w_I",
    unit: "1/K",
    typical: [1e-6, 1e-3], // temperature coefficient of torquer magnets, 2e-5 to 5e-4 per K
    plausible: 0.02,
    confused_with: &[Effect::TemperatureG, Effect::ScaleCubic],
    missing: &no_temperature,
    columns: &|s, j, _| vec![temperature_times(s, |k| s.rate[k].dot(&s.gyros[j].input))],
    beyond: Some(|s, j, _, size| temperature_times(s, |k| size[0] * s.drift(j, k))),
    beyond_is_linear: true,
    of_temperature: true,
    ..PLAIN
};

/// T times `factor`, dwell by dwell. Zero where there is no temperature, which `missing` has told before.
fn temperature_times(s: &Setting, factor: impl Fn(usize) -> f64) -> Vec<f64> {
    s.column(|k| s.temperature.as_ref().map_or(0.0, |t| t[k] * factor(k)))
}
