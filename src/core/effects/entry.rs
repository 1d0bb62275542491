//! What the catalogue knows of one effect.

use super::setting::Setting;

/// Name of an effect; [`Effect::id`] is the contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    GLinear,
    GSquared,
    Scale,
    TemperatureBias,
    TemperatureG,
    TemperatureScale,
    Warmup,
    TimeRamp,
    BiasStep,
    OutlierDwell,
    Periodic,
    Hysteresis,
    ScaleAsymmetry,
    ScaleQuadratic,
    ScaleCubic,
    Anisoinertia,
    GRateCoupling,
    Levelling,
    Azimuth,
    Magnetic,
    CrossCompliance,
    CubicG,
    OutputAxisG,
    MountClocking,
}

/// The parameter of a regressor that is not linear, at one value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// The regressor has none.
    Linear,
    /// Time constant, s.
    Tau(f64),
    /// Instant of a change, s from the first dwell's clock.
    Instant(f64),
    /// Index of one dwell.
    Dwell(usize),
    /// Period, s.
    Period(f64),
    /// Direction of a horizontal field, radians from north towards east.
    Azimuth(f64),
    /// Rotation of S about I that E cannot show, radians.
    Clocking(f64),
    /// Only these of the regressors, by number.
    Only(&'static [usize]),
    /// Whether the IMU is tilted on the table, so that the table's rate is seen turned too.
    Tilt { with_rate: bool },
    /// From one dwell up to, not including, another.
    Window(usize, usize),
    /// Components along the gyro's input and spin axes instead of body axes.
    InputSpin,
}

/// Whether each gyro has coefficients of its own or all share one set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    Gyro,
    Common,
}

/// One coefficient of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficient {
    pub name: &'static str,
    pub unit: &'static str,
}

/// Magnitudes met in practice, in the unit of the coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Typical {
    pub low: f64,
    pub high: f64,
    pub source: &'static str,
}

/// One entry of the catalogue.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    pub effect: Effect,
    pub id: &'static str,
    pub cause: &'static str,
    /// Drift added, deg/h, or change of scale, with the letters of the crate page.
    pub equation: &'static str,
    pub typical: Typical,
    /// Largest size that a gyro of any kind may have, poor MEMS included, in the unit of the coefficients: beyond it something else that the
    /// campaign hardly shows has been blown up.
    pub plausible: f64,
    /// What a campaign must hold for the effect to show.
    pub needs: &'static str,
    pub confused_with: &'static [Effect],
    pub scope: Scope,
    pub coefficients: fn(Shape) -> Vec<Coefficient>,
    /// Why this campaign cannot hold the effect's regressors at all, if it cannot.
    pub missing: fn(&Setting) -> Option<&'static str>,
    /// Values of the non-linear parameter to try, with prior weights (not normalised). Never empty.
    pub shapes: fn(&Setting) -> Vec<(Shape, f64)>,
    /// Regressors of gyro `j`, deg/h per unit coefficient, one vector over the dwells each.
    pub columns: fn(&Setting, usize, Shape) -> Vec<Vec<f64>>,
}

/// The shapes of an entry without a non-linear parameter.
pub(super) fn linear(_: &Setting) -> Vec<(Shape, f64)> {
    vec![(Shape::Linear, 1.0)]
}

pub(super) fn nothing_missing(_: &Setting) -> Option<&'static str> {
    None
}

pub(super) fn no_temperature(setting: &Setting) -> Option<&'static str> {
    match &setting.temperature {
        None => Some("the dwells carry no temperature"),
        Some(t) if t.iter().all(|x| x.abs() < 1e-9) => Some("the temperature is constant"),
        Some(_) => None,
    }
}

pub(super) fn no_attitude(setting: &Setting) -> Option<&'static str> {
    setting.nav_to_body.is_none().then_some("the dwells carry no attitude")
}
