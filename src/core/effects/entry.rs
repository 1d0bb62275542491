//! What the catalogue knows of one effect.

use std::fmt::{self, Debug, Formatter};
use std::sync::OnceLock;

use super::own_hypothesis::OwnHypothesis;
use super::refusal::MissingInput;
use super::setting::Setting;

/// Effects of the program's own by name, numbered in their order, and one beside them for those of a user.
macro_rules! effects {
    ($($name:ident),* $(,)?) => {
        /// Name of an effect; [`Effect::id`] is the contract.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Effect {
            $($name,)*
            /// A hypothesis of one's own.
            Own(Own),
        }

        enum Place {
            $($name,)*
        }

        impl Effect {
            /// Its place among the entries of the program, or the hypothesis of one's own that it is.
            pub(super) const fn place(self) -> Result<usize, Own> {
                match self {
                    $(Self::$name => Ok(Place::$name as usize),)*
                    Self::Own(own) => Err(own),
                }
            }
        }
    };
}

effects! {
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
    Relevelling,
    Reseating,
    AxialCompliance,
    CrossCompliance,
    CubicG,
    OutputAxisG,
    MountClocking,
    // Competing hypotheses: never named.
    CurveInTime,
    WanderInTime,
    CorrelatedInTime,
    BendInTime,
    Burst,
    DriftingMassUnbalance,
    DriftingScale,
    SteppingMassUnbalance,
    SteppingScale,
    PartTime,
    BentTemperature,
    TemperatureRate,
    TemperatureLag,
    TemperatureAndTime,
    TemperatureGSquared,
    LaggingSensitivity,
    OrientationHarmonics,
    Friction,
    Heading,
    EarthRate,
    OrientationBefore,
    RateEven,
    RateOdd,
    RateCurve,
    RateAndForce,
    StaticToRate,
    TorquerHeating,
    RateBefore,
    RateProduct,
    SettlingAfterRate,
    TableRate,
    LeverArm,
    DriftingTable,
    Misalignment,
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
    /// Another effect, from an instant up to another, s.
    Part { of: Effect, from: f64, to: f64 },
    /// Time constant, s, from every power-up anew.
    Restart(f64),
    /// Components along the gyro's input and spin axes instead of body axes.
    InputSpin,
    /// Value of the parameter of a hypothesis of one's own, in the unit of its range.
    Own(f64),
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

/// Which parameter of an entry's regressors is not linear, if one is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    None,
    Tau,
    Instant,
    Dwell,
    Period,
    /// Of one direction, or its two parts each with coefficients of its own.
    FieldAzimuth,
    Clocking,
    Tilt,
    /// One of the products, or all of them.
    Product,
    /// Along the gyro's own axes or those of the body.
    Axes,
    /// From an instant on, or while the table turns.
    Seating,
    /// Of a hypothesis of one's own.
    Own,
}

impl Parameter {
    /// Whether a shape is one of this parameter.
    pub fn takes(self, shape: Shape) -> bool {
        match self {
            Self::None => shape == Shape::Linear,
            Self::Tau => matches!(shape, Shape::Tau(_)),
            Self::Instant => matches!(shape, Shape::Instant(_)),
            Self::Dwell => matches!(shape, Shape::Dwell(_)),
            Self::Period => matches!(shape, Shape::Period(_)),
            Self::FieldAzimuth => matches!(shape, Shape::Linear | Shape::Azimuth(_)),
            Self::Clocking => matches!(shape, Shape::Clocking(_)),
            Self::Tilt => matches!(shape, Shape::Tilt { .. }),
            Self::Product => matches!(shape, Shape::Linear | Shape::Only(_)),
            Self::Axes => matches!(shape, Shape::Linear | Shape::InputSpin),
            Self::Seating => matches!(shape, Shape::Linear | Shape::Instant(_)),
            Self::Own => matches!(shape, Shape::Own(_)),
        }
    }
}

/// How the coefficients of a competitor's columns are distributed before the data speak.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Prior {
    /// Any direction in the span of the columns alike.
    Flat,
    /// In proportion to the columns' own lengths: a smooth curve as a sum of ever smaller waves.
    Smooth,
}

/// What an entry computes: a function, or a closure over what somebody wrote.
type Of<F> = &'static F;

/// All that the program knows of one effect: nothing outside the catalogue lists effects.
#[derive(Clone, Copy)]
pub struct Entry {
    pub effect: Effect,
    pub id: &'static str,
    /// Whether it may be named as a cause. The others are competing hypotheses: reported as signs, never adopted.
    pub nameable: bool,
    pub cause: &'static str,
    /// Drift added, deg/h, or change of scale, with the letters of the crate page.
    pub equation: &'static str,
    /// Of the coefficients.
    pub unit: &'static str,
    /// Least and largest size met in practice, in the unit of the coefficients.
    pub typical: [f64; 2],
    /// Largest size that a gyro of any kind may have, poor MEMS included, in the unit of the coefficients: beyond it
    /// something else that the campaign hardly shows has been blown up.
    pub plausible: f64,
    pub confused_with: &'static [Effect],
    /// What is as good a name wherever this is one, because its columns hold all that the other's leave.
    pub never_told_from: &'static [Effect],
    /// What it is where it acts from the first dwell on.
    pub throughout: Option<Effect>,
    /// The entries that together are this one, each with some of its coefficients; empty where it is no such whole.
    pub parts: &'static [Effect],
    pub scope: Scope,
    pub prior: Prior,
    /// Of the shapes that its regressors are made for. Competing hypotheses have shapes of any kind.
    pub parameter: Parameter,
    /// A course of the bias in time alone.
    pub course_in_time: bool,
    /// Follows any course of the bias in time, from smooth to a random walk.
    pub wanders: bool,
    /// Changes slowly from dwell to dwell: it is held out in blocks of time.
    pub follows_time: bool,
    pub of_temperature: bool,
    /// Asks when a dwell was, or what came before it: a finished calibration does not tell.
    pub of_order: bool,
    /// Belongs to the campaign in which it happened and to no other.
    pub one_occasion: bool,
    /// Asked only where something would be named: too many shapes to look for in every campaign.
    pub only_closer: bool,
    /// How many hypotheses of equal standing its shapes hold: their weights add up to that.
    pub standing: usize,
    /// Lies inside G: residuals of dwells never show it, the closure of G does.
    pub closure_only: bool,
    /// Of the coefficients.
    pub names: Of<dyn Fn(Shape) -> Vec<&'static str> + Sync>,
    /// Why this campaign cannot hold the effect's regressors at all, if it cannot.
    pub missing: Of<dyn Fn(&Setting) -> Option<MissingInput> + Sync>,
    /// Values of the non-linear parameter to try, with prior weights (not normalised). Never empty.
    pub shapes: Of<dyn Fn(&Setting) -> Vec<(Shape, f64)> + Sync>,
    /// Regressors of gyro `j`, deg/h per unit coefficient, one vector over the dwells each.
    pub columns: Of<dyn Fn(&Setting, usize, Shape) -> Vec<Vec<f64>> + Sync>,
    /// What coefficients of this size in gyro `j` add beyond their regressors, deg/h: rotations are linear while they are
    /// small, and a scale factor's change is that of drift, too. Nothing where the effect is linear.
    pub beyond: Option<fn(&Setting, usize, Shape, &[f64]) -> Vec<f64>>,
    /// Whether that is linear in the coefficients: it is part of the regressors once a gyro's drift is known.
    pub beyond_is_linear: bool,
}

impl Debug for Entry {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.id)
    }
}

impl Entry {
    /// Whether it has a largest plausible size: a diagnosis names nothing larger.
    pub fn has_size(&self) -> bool {
        self.plausible.is_finite()
    }

    /// Whether two entries whose coefficients all gyros share can pass for this one, each gyro with its own.
    pub fn may_be_two_shared(&self) -> bool {
        let shared = self.confused_with.iter().filter(|other| other.entry().scope == Scope::Common);
        self.scope == Scope::Gyro && shared.count() > 1
    }

    /// Name and unit of each coefficient at one value of its non-linear parameter.
    pub fn coefficients(&self, shape: Shape) -> Vec<Coefficient> {
        (self.names)(shape).into_iter().map(|name| Coefficient { name, unit: self.unit }).collect()
    }

    /// The regressors of gyro `j`, and what lies beyond them where that is linear, too: a torquer's scale factor
    /// multiplies drift as it does rate, so that G/|E| stays.
    pub fn regressors(&self, setting: &Setting, j: usize, shape: Shape) -> Vec<Vec<f64>> {
        let mut columns = (self.columns)(setting, j, shape);
        if let Some(beyond) = self.beyond.filter(|_| self.beyond_is_linear) {
            columns[0].iter_mut().zip(beyond(setting, j, shape, &[1.0])).for_each(|(column, more)| *column += more);
        }
        columns
    }

    /// Whether it sets one dwell aside.
    pub fn is_one_dwell(&self) -> bool {
        self.parameter == Parameter::Dwell
    }
}

/// A hypothesis of one's own as an effect. Two are the same where they are one and the same in memory:
/// [`super::own()`] keeps one of each.
#[derive(Clone, Copy)]
pub struct Own(&'static InternedHypothesis);

struct InternedHypothesis {
    hypothesis: OwnHypothesis,
    entry: OnceLock<Entry>,
}

impl Own {
    /// Kept for as long as the program runs.
    pub(super) fn keeping(hypothesis: OwnHypothesis) -> Self {
        Self(Box::leak(Box::new(InternedHypothesis { hypothesis, entry: OnceLock::new() })))
    }

    /// The equation, as it was stated.
    pub fn hypothesis(self) -> &'static OwnHypothesis {
        &self.0.hypothesis
    }

    /// The equation as an entry of the catalogue, made at the first use.
    pub fn entry(self) -> &'static Entry {
        self.0.entry.get_or_init(|| self.made())
    }

    fn made(self) -> Entry {
        let own = self.hypothesis();
        let written = &own.written;
        let names: Vec<&'static str> = own.coefficients().collect();
        Entry {
            effect: Effect::Own(self),
            id: &written.id,
            cause: &written.cause,
            equation: &written.equation,
            unit: &written.unit,
            typical: written.typical, // who wrote the hypothesis
            plausible: written.plausible,
            scope: if written.common { Scope::Common } else { Scope::Gyro },
            parameter: if written.range.is_some() { Parameter::Own } else { Parameter::None },
            course_in_time: own.is_course_in_time(),
            follows_time: own.follows_time(),
            of_temperature: own.is_of_temperature(),
            of_order: own.is_of_order(),
            names: Box::leak(Box::new(move |_| names.clone())),
            missing: Box::leak(Box::new(move |s: &Setting| lacking(own, s))),
            shapes: Box::leak(Box::new(move |_: &Setting| match own.grid() {
                grid if grid.is_empty() => vec![(Shape::Linear, 1.0)],
                grid => grid.into_iter().map(|value| (Shape::Own(value), 1.0)).collect(),
            })),
            columns: Box::leak(Box::new(move |s: &Setting, j: usize, shape: Shape| match shape {
                Shape::Own(value) => own.columns(s, j, Some(value)),
                _ => own.columns(s, j, None),
            })),
            ..PLAIN
        }
    }
}

fn lacking(own: &OwnHypothesis, setting: &Setting) -> Option<MissingInput> {
    let temperature = if own.is_of_temperature() { no_temperature(setting) } else { None };
    let attitude = if own.needs_attitude() { no_attitude(setting) } else { None };
    temperature.or(attitude).or_else(|| own.not_finite(setting).map(|dwell| MissingInput::NotFinite { dwell }))
}

impl PartialEq for Own {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Eq for Own {}

impl PartialOrd for Own {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Own {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let place = |own: &Self| std::ptr::from_ref(own.0);
        self.0.hypothesis.written.id.cmp(&other.0.hypothesis.written.id).then_with(|| place(self).cmp(&place(other)))
    }
}

impl std::hash::Hash for Own {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.0.hypothesis.written.id.hash(state);
    }
}

impl Debug for Own {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.hypothesis.written.id)
    }
}

/// What most entries have in common: one coefficient a gyro, no parameter, nothing that a campaign may lack.
pub(super) const PLAIN: Entry = Entry {
    effect: Effect::GLinear,
    id: "",
    nameable: true,
    cause: "",
    equation: "",
    unit: "",
    typical: [0.0, 0.0],
    plausible: f64::INFINITY,
    confused_with: &[],
    never_told_from: &[],
    throughout: None,
    parts: &[],
    scope: Scope::Gyro,
    prior: Prior::Flat,
    parameter: Parameter::None,
    course_in_time: false,
    wanders: false,
    follows_time: false,
    of_temperature: false,
    of_order: false,
    one_occasion: false,
    only_closer: false,
    standing: 1,
    closure_only: false,
    names: &|_| vec!["k"],
    missing: &|_| None,
    shapes: &|_| vec![(Shape::Linear, 1.0)],
    columns: &|_, _, _| Vec::new(),
    beyond: None,
    beyond_is_linear: false,
};

/// What competing hypotheses have in common.
pub(super) const COMPETING: Entry = Entry { nameable: false, ..PLAIN };

pub(super) fn no_temperature(setting: &Setting) -> Option<MissingInput> {
    match &setting.temperature {
        None => Some(MissingInput::Temperature),
        Some(t) if t.iter().all(|x| x.abs() < 1e-9) => Some(MissingInput::TemperatureChange),
        Some(_) => None,
    }
}

pub(super) fn no_attitude(setting: &Setting) -> Option<MissingInput> {
    setting.nav_to_body.is_none().then_some(MissingInput::Attitude)
}
