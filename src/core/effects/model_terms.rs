//! Model (6)'s own terms as effects: candidates whenever the model in use leaves them out.

use super::entry::{Effect, Entry, PLAIN};
use super::refusal::MissingInput;
use super::setting::Setting;

pub(super) const ENTRIES: &[&Entry] = &[&G_LINEAR, &G_SQUARED, &SCALE];

pub const G_LINEAR: Entry = Entry {
    effect: Effect::GLinear,
    id: "g_linear",
    cause: "mass unbalance and buoyancy offset of the float: drift in proportion to specific force",
    equation: "G_x a_x + G_y a_y + G_z a_z",
    unit: "deg/(h g0)",
    typical: [0.1, 10.0], // Tables 4 and 5 of the paper
    plausible: 5e3,
    confused_with: &[Effect::TimeRamp, Effect::Warmup, Effect::GSquared],
    names: &|_| vec!["G_x", "G_y", "G_z"],
    columns: &|s, _, _| s.by_axis(|k, i| s.force[k][i]),
    ..PLAIN
};

pub const G_SQUARED: Entry = Entry {
    effect: Effect::GSquared,
    id: "g_squared",
    cause: "compliance of the float's suspension along its axes: drift in proportion to squared specific force",
    equation: "P_x a_x^2 + P_y a_y^2 + P_z a_z^2",
    unit: "deg/(h g0^2)",
    typical: [1e-3, 0.1], // IEEE 517: g-squared sensitivities of floated gyros
    plausible: 1e3,
    confused_with: &[Effect::GLinear, Effect::CubicG],
    names: &|_| vec!["P_x", "P_y", "P_z"],
    columns: &|s, _, _| s.by_axis(|k, i| s.force[k][i].powi(2)),
    ..PLAIN
};

pub const SCALE: Entry = Entry {
    effect: Effect::Scale,
    id: "scale",
    cause: "scale factor and installation of the input axis",
    equation: "(E_x w_x + E_y w_y + E_z w_z)/|E|",
    unit: "1",
    typical: [1e-4, 1.0], // Table 3 of the paper
    plausible: 10.0,
    confused_with: &[Effect::Magnetic, Effect::TemperatureScale],
    names: &|_| vec!["E_x", "E_y", "E_z"],
    missing: &no_rates,
    columns: &|s, _, _| s.by_axis(|k, i| s.rate[k][i]),
    ..PLAIN
};

fn no_rates(s: &Setting) -> Option<MissingInput> {
    s.rate.iter().all(|w| w.norm() == 0.0).then_some(MissingInput::Rate)
}
