//! Effects that show when the table turns. w in arcsec/s = deg/h.

use super::entry::{Effect, Entry, PLAIN, Parameter, Shape};
use super::setting::Setting;

pub(super) const ENTRIES: &[&Entry] =
    &[&SCALE_ASYMMETRY, &SCALE_QUADRATIC, &SCALE_CUBIC, &ANISOINERTIA, &G_RATE_COUPLING];

pub const SCALE_ASYMMETRY: Entry = Entry {
    effect: Effect::ScaleAsymmetry,
    id: "scale_asymmetry",
    cause: "positive and negative torquing currents are switched or weighted differently",
    equation: "k sign(w_I) w_I",
    unit: "1",
    typical: [1e-6, 1e-4], // IEEE 517, scale-factor asymmetry
    plausible: 0.05,
    confused_with: &[Effect::ScaleQuadratic, Effect::Anisoinertia],
    columns: &|s, j, _| vec![input_rate(s, j, f64::abs)],
    beyond: Some(|s, j, _, size| s.column(|k| size[0] * s.rate[k].dot(&s.gyros[j].input).signum() * s.drift(j, k))),
    ..PLAIN
};

pub const SCALE_QUADRATIC: Entry = Entry {
    effect: Effect::ScaleQuadratic,
    id: "scale_quadratic",
    cause: "torquer heating and saturation: the scale factor depends on rate, evenly",
    equation: "k w_I^2",
    unit: "deg/h/(deg/h)^2",
    typical: [1e-10, 1e-7], // IEEE 517, scale-factor non-linearity of 1e-6 to 1e-4 at full rate
    plausible: 1e-5,
    confused_with: &[Effect::ScaleAsymmetry, Effect::Anisoinertia],
    columns: &|s, j, _| vec![input_rate(s, j, |w| w * w)],
    ..PLAIN
};

pub const SCALE_CUBIC: Entry = Entry {
    effect: Effect::ScaleCubic,
    id: "scale_cubic",
    cause: "saturation of the torquer: the scale factor depends on rate, oddly",
    equation: "k w_I^3",
    unit: "deg/h/(deg/h)^3",
    typical: [1e-14, 1e-11], // IEEE 517, scale-factor non-linearity of 1e-6 to 1e-4 at full rate
    plausible: 1e-9,
    confused_with: &[Effect::TemperatureScale],
    columns: &|s, j, _| vec![input_rate(s, j, |w| w.powi(3))],
    ..PLAIN
};

/// S about I is known to the mounting's tolerance only (some arc-minutes), and where w_I w_S nearly vanishes on the
/// table's axes the clocking decides the pattern: it is profiled over a few milliradians.
pub const ANISOINERTIA: Entry = Entry {
    effect: Effect::Anisoinertia,
    id: "anisoinertia",
    cause: "the float's moments of inertia about its input and spin axes differ",
    equation: "k w_I w_S",
    unit: "deg/h/(deg/h)^2",
    typical: [1e-10, 1e-7], // IEEE 517, anisoinertia of floated gyros
    plausible: 1e-5,
    confused_with: &[Effect::ScaleQuadratic, Effect::ScaleAsymmetry],
    shapes: &|_| CLOCKINGS.iter().map(|&(phi, weight)| (Shape::Clocking(phi), weight)).collect(),
    columns: &|s, j, shape| {
        let Shape::Clocking(phi) = shape else { return Vec::new() };
        let gyro = &s.gyros[j];
        let spin = gyro.spin * phi.cos() + gyro.output * phi.sin();
        vec![s.column(|k| s.rate[k].dot(&gyro.input) * s.rate[k].dot(&spin))]
    },
    parameter: Parameter::Clocking,
    ..PLAIN
};

pub const G_RATE_COUPLING: Entry = Entry {
    effect: Effect::GRateCoupling,
    id: "g_rate_coupling",
    cause: "specific force along the input axis loads the torquer's gap: scale factor depends on it",
    equation: "k a_I w_I",
    unit: "1/g0",
    typical: [1e-6, 1e-4], // IEEE 517, acceleration sensitivity of scale factor
    plausible: 0.05,
    confused_with: &[Effect::ScaleAsymmetry],
    columns: &|s, j, _| {
        let input = &s.gyros[j].input;
        vec![s.column(|k| s.force[k].dot(input) * s.rate[k].dot(input))]
    },
    beyond: Some(|s, j, _, size| s.column(|k| size[0] * s.force[k].dot(&s.gyros[j].input) * s.drift(j, k))),
    ..PLAIN
};

/// Clocking angles, rad, and weights of a normal distribution with 1.5 mrad.
const CLOCKINGS: [(f64, f64); 7] =
    [(0.0, 0.4), (1e-3, 0.32), (-1e-3, 0.32), (2e-3, 0.16), (-2e-3, 0.16), (4e-3, 0.02), (-4e-3, 0.02)];

fn input_rate(s: &Setting, j: usize, of: impl Fn(f64) -> f64) -> Vec<f64> {
    s.column(|k| of(s.rate[k].dot(&s.gyros[j].input)))
}
