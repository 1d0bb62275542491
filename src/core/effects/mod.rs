//! The catalogue: every effect that model (6) leaves out and that a campaign may show.
//!
//! An effect adds `sum_m k_m x_m` to the drift of a gyro (deg/h), where the regressors `x_m` follow from what the
//! station commanded and read: specific force, rate, temperature, time, attitude, order of dwells. Some regressors
//! hold one unknown [`Shape`] parameter (a time constant, an instant, a period) that is profiled over a grid.
//!
//! Two standings. *Contract* entries may be named as a cause. *Competing hypotheses* are what physics or table work also
//! produces and what nobody asked to have named: they compete in the search, so that a contract entry which
//! merely resembles one of them does not get its name, but they are reported as signs, never adopted.
//!
//! One file a family; `catalogue` puts them in the order of the contract.

mod acceleration;
pub mod axes;
pub mod competitors;
mod entry;
mod estimate;
mod memory;
mod model_terms;
mod rate;
mod refusal;
mod setting;
mod station;
mod thermal;
mod time;

pub use entry::{Coefficient, Effect, Entry, Scope, Shape, Typical};
pub use estimate::Estimate;
pub use refusal::Refusal;
pub use setting::{GyroAxes, Setting};

/// All contract entries, in the order of the contract.
pub const CATALOGUE: [&Entry; 24] = [
    &model_terms::G_LINEAR,
    &model_terms::G_SQUARED,
    &model_terms::SCALE,
    &thermal::TEMPERATURE_BIAS,
    &thermal::TEMPERATURE_G,
    &thermal::TEMPERATURE_SCALE,
    &time::WARMUP,
    &time::TIME_RAMP,
    &time::BIAS_STEP,
    &time::OUTLIER_DWELL,
    &time::PERIODIC,
    &memory::HYSTERESIS,
    &rate::SCALE_ASYMMETRY,
    &rate::SCALE_QUADRATIC,
    &rate::SCALE_CUBIC,
    &rate::ANISOINERTIA,
    &rate::G_RATE_COUPLING,
    &station::LEVELLING,
    &station::AZIMUTH,
    &station::MAGNETIC,
    &acceleration::CROSS_COMPLIANCE,
    &acceleration::CUBIC_G,
    &acceleration::OUTPUT_AXIS_G,
    &acceleration::MOUNT_CLOCKING,
];

impl Effect {
    pub fn entry(self) -> &'static Entry {
        CATALOGUE[self as usize]
    }

    pub fn id(self) -> &'static str {
        self.entry().id
    }

    /// Whether the entry's regressors are made for this kind of shape.
    pub fn can_have(self, shape: Shape) -> bool {
        match self {
            Effect::Warmup => matches!(shape, Shape::Tau(_)),
            Effect::BiasStep => matches!(shape, Shape::Instant(_)),
            Effect::OutlierDwell => matches!(shape, Shape::Dwell(_)),
            Effect::Periodic => matches!(shape, Shape::Period(_)),
            Effect::Magnetic => matches!(shape, Shape::Azimuth(_)),
            Effect::Anisoinertia => matches!(shape, Shape::Clocking(_)),
            Effect::Levelling => matches!(shape, Shape::Tilt { .. }),
            Effect::CrossCompliance => matches!(shape, Shape::Linear | Shape::Only(_)),
            Effect::TemperatureG => matches!(shape, Shape::Linear | Shape::InputSpin),
            _ => shape == Shape::Linear,
        }
    }

    /// Whether it is a course of the bias in time alone.
    pub fn is_course_in_time(self) -> bool {
        matches!(self, Self::Warmup | Self::TimeRamp | Self::BiasStep | Self::Periodic)
    }

    pub fn is_of_temperature(self) -> bool {
        matches!(self, Self::TemperatureBias | Self::TemperatureG | Self::TemperatureScale)
    }

    pub fn from_id(id: &str) -> Option<Self> {
        CATALOGUE.iter().find(|entry| entry.id == id).map(|entry| entry.effect)
    }
}

/// The names of all contract entries, for messages.
pub fn known() -> String {
    CATALOGUE.map(|entry| entry.id).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effect_finds_its_own_entry_and_its_own_id() {
        for (i, entry) in CATALOGUE.iter().enumerate() {
            assert_eq!(entry.effect as usize, i, "{}", entry.id);
            assert_eq!(Effect::from_id(entry.id), Some(entry.effect));
            assert!(!entry.cause.is_empty() && !entry.equation.is_empty() && !entry.needs.is_empty());
            assert!(!entry.typical.source.is_empty() && entry.typical.low <= entry.typical.high);
            assert!(entry.plausible >= 10.0 * entry.typical.high, "{}", entry.id);
            assert!(!entry.confused_with.contains(&entry.effect));
        }
    }

    /// Some shape that the entry's regressors are made for: names and units of coefficients hang on its kind alone.
    fn any_shape(effect: Effect) -> Shape {
        let kinds = [
            Shape::Linear,
            Shape::Tau(1.0),
            Shape::Instant(1.0),
            Shape::Dwell(0),
            Shape::Period(1.0),
            Shape::Azimuth(0.0),
            Shape::Clocking(0.0),
            Shape::Tilt { with_rate: false },
        ];
        kinds.into_iter().find(|shape| effect.can_have(*shape)).unwrap()
    }

    #[test]
    fn the_documentation_holds_the_catalogue_row_by_row() {
        let row = |entry: &&Entry| {
            let unit = (entry.coefficients)(any_shape(entry.effect))[0].unit;
            let of = if entry.scope == Scope::Common { "all gyros alike" } else { "each gyro" };
            let others: Vec<String> = entry.confused_with.iter().map(|other| format!("`{}`", other.id())).collect();
            let equation = entry.equation.replace('|', "\\|");
            let (id, cause, needs) = (entry.id, entry.cause, entry.needs);
            format!("| `{id}` | {cause} | {equation} | {unit} | {of} | {needs} | {} |", others.join(", "))
        };
        let expected: Vec<String> = CATALOGUE.iter().map(row).collect();
        let documented: Vec<&str> =
            include_str!("../../../docs/diagnosis.md").lines().filter(|line| line.starts_with("| `")).collect();
        assert_eq!(documented, expected, "docs/diagnosis.md should hold\n{}", expected.join("\n"));
    }
}
