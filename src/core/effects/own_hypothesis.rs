//! A hypothesis of one's own: an equation for the drift that the catalogue does not hold.
//!
//! `k * T * w_I` or `k1 * exp(-t/tau) * a_S`: deg/h, proportional to its coefficients (names that begin with k), in
//! the quantities of [`QUANTITIES`] and at most one parameter with a range. Units are checked.
//!
//! D_I and D_S are those at the reference temperature. So an equation that is a drift of model (6) there, `k * exp(T/tau)
//! * a_S`, counts from it: in any fit with model (6) that is the same hypothesis.

use nalgebra::Vector3;

use super::dimension::{Dimension, Quantity, checked};
use super::equation::Equation;
use super::setting::{GyroAxes, Setting};
use crate::core::fault::Faults;
use crate::core::message::{Message, list, sent, text};
use crate::message;

/// As somebody wrote it.
#[derive(Debug, Clone, PartialEq)]
pub struct HypothesisDefinition {
    pub id: String,
    /// What people read in place of the id, and the physical cause.
    pub words: String,
    pub cause: String,
    pub equation: String,
    /// Of the coefficients.
    pub unit: String,
    /// Largest size that is believed, in that unit.
    pub plausible: f64,
    /// What is met in practice, in that unit.
    pub typical: [f64; 2],
    /// Whether all gyros share one set of coefficients.
    pub common: bool,
    pub range: Option<Range>,
}

/// The parameter that is not linear, and where it may lie, in its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Range {
    pub name: String,
    pub from: f64,
    pub to: f64,
    pub unit: String,
}

/// One that makes sense.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnHypothesis {
    pub written: HypothesisDefinition,
    equation: Equation,
    /// What each name of the equation is.
    names: Vec<Input>,
    coefficients: Vec<String>,
    /// Units of the coefficients and of the parameter in deg, h, g0 and K.
    coefficient: f64,
    parameter: f64,
    at_reference: AtReference,
}

/// What an equation is at the reference temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum AtReference {
    /// Zero, or the same at any temperature.
    Nothing,
    /// Linear in specific force and rate, and of nothing else.
    OfModel6,
    Other,
}

/// What a name stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Input {
    /// By its place.
    Coefficient(usize),
    Parameter,
    Signal(Signal),
}

/// A quantity of a dwell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Signal {
    Force(Axis),
    Rate(Axis),
    ForceBefore(Axis),
    RateBefore(Axis),
    /// Of a gyro's axis along east, north (0, 1) or up (2).
    Attitude(Axis, usize),
    Temperature,
    TemperatureSlope,
    Time,
    HalfTurn,
}

/// A gyro's axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Axis {
    I,
    S,
    O,
}

use Axis::{I, O, S};

/// Every quantity that an equation may hold.
const QUANTITIES: [(&str, Signal); 25] = [
    ("a_I", Signal::Force(I)),
    ("a_S", Signal::Force(S)),
    ("a_O", Signal::Force(O)),
    ("w_I", Signal::Rate(I)),
    ("w_S", Signal::Rate(S)),
    ("w_O", Signal::Rate(O)),
    ("a_I_before", Signal::ForceBefore(I)),
    ("a_S_before", Signal::ForceBefore(S)),
    ("a_O_before", Signal::ForceBefore(O)),
    ("w_I_before", Signal::RateBefore(I)),
    ("w_S_before", Signal::RateBefore(S)),
    ("w_O_before", Signal::RateBefore(O)),
    ("I_E", Signal::Attitude(I, 0)),
    ("I_N", Signal::Attitude(I, 1)),
    ("I_U", Signal::Attitude(I, 2)),
    ("S_E", Signal::Attitude(S, 0)),
    ("S_N", Signal::Attitude(S, 1)),
    ("S_U", Signal::Attitude(S, 2)),
    ("O_E", Signal::Attitude(O, 0)),
    ("O_N", Signal::Attitude(O, 1)),
    ("O_U", Signal::Attitude(O, 2)),
    ("T", Signal::Temperature),
    ("dT/dt", Signal::TemperatureSlope),
    ("t", Signal::Time),
    ("pi", Signal::HalfTurn),
];

/// More coefficients than this are no hypothesis.
const MOST_COEFFICIENTS: usize = 4;

/// Values of a parameter that are tried between the ends of its range.
const GRID: usize = 14;

impl OwnHypothesis {
    /// Checks what somebody wrote.
    ///
    /// # Errors
    /// Everything that is wrong with it, by JSON pointer, a place in the equation by its character.
    pub fn of(written: HypothesisDefinition) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        let sizes = [written.typical[0], written.typical[1], written.plausible];
        if !sizes.iter().all(|x| x.is_finite() && *x > 0.0) || !sizes.is_sorted() {
            faults.push("/plausible", message!("hypothesis_sizes"));
        }
        let unit = Dimension::read(&written.unit).map_err(|message| faults.push("/unit", message)).ok();
        let range = written.range.as_ref().and_then(|range| checked_range(range, &mut faults));
        let read = Equation::read(&written.equation).and_then(|equation| Ok((named(&equation, &written)?, equation)));
        match (read, unit) {
            (Err(message), _) => faults.push("/equation", message),
            (Ok(_), None) => {}
            (Ok(((names, coefficients), equation)), Some((dimension, coefficient))) => {
                let (of_parameter, parameter) = range.unwrap_or((Dimension::NUMBER, 1.0));
                let known = |name: &Input| match name {
                    Input::Coefficient(_) => Quantity::coefficient(dimension),
                    Input::Parameter => Quantity::of(of_parameter),
                    Input::Signal(of) => of.quantity(),
                };
                if let Err(message) = is_drift(&equation, &names.iter().map(known).collect::<Vec<_>>(), dimension) {
                    faults.push("/equation", message);
                }
                if let Some(range) = written.range.as_ref().filter(|range| spans_a_pole(&equation, &names, range)) {
                    let (from, to) = (text(range.from), text(range.to));
                    faults.push(format!("/range/{}", range.name), message!("range_through_zero", from, to));
                }
                let at_reference = AtReference::Nothing;
                let read = Self { written, equation, names, coefficients, coefficient, parameter, at_reference };
                return faults.or(Self { at_reference: read.found_at_reference(), ..read });
            }
        }
        Err(faults)
    }

    /// Names of the coefficients, in the order of the columns.
    pub fn coefficients(&self) -> impl Iterator<Item = &str> {
        self.coefficients.iter().map(String::as_str)
    }

    fn holds(&self, wanted: impl Fn(Signal) -> bool) -> bool {
        self.names.iter().any(|name| matches!(name, Input::Signal(of) if wanted(*of)))
    }

    /// Whether it holds the temperature or its change.
    pub fn is_of_temperature(&self) -> bool {
        self.holds(Signal::is_thermal)
    }

    /// Whether it holds an axis in east, north or up.
    pub fn needs_attitude(&self) -> bool {
        self.holds(|of| matches!(of, Signal::Attitude(..)))
    }

    /// Whether nothing but time and temperature changes it from dwell to dwell.
    pub fn follows_time(&self) -> bool {
        let slow = |of| matches!(of, Signal::Time | Signal::Temperature | Signal::TemperatureSlope | Signal::HalfTurn);
        !self.holds(|of| !slow(of)) && self.holds(|of| of != Signal::HalfTurn)
    }

    /// Whether it asks when a dwell was, or what came before it.
    pub fn is_of_order(&self) -> bool {
        self.holds(|of| {
            matches!(of, Signal::Time | Signal::ForceBefore(_) | Signal::RateBefore(_) | Signal::TemperatureSlope)
        })
    }

    /// Whether time alone changes it from dwell to dwell.
    pub fn is_course_in_time(&self) -> bool {
        self.follows_time() && !self.is_of_temperature()
    }

    /// Values of the parameter to try: evenly by ratio where the range is positive, else by difference. None without a
    /// parameter.
    pub fn grid(&self) -> Vec<f64> {
        let Some(Range { from, to, .. }) = self.written.range else { return Vec::new() };
        let share = |i: usize| i as f64 / (GRID - 1) as f64;
        let at = |i| if from > 0.0 { from * (to / from).powf(share(i)) } else { from + (to - from) * share(i) };
        (0..GRID).map(at).collect()
    }

    /// Whether D_I and D_S leave out what it is at the reference temperature, all of it: it is no drift of model (6).
    pub fn is_left_out_at_reference(&self) -> bool {
        self.at_reference == AtReference::Other
    }

    /// What one unit of each coefficient adds to gyro `j`, deg/h, dwell by dwell.
    pub fn columns(&self, setting: &Setting, j: usize, parameter: Option<f64>) -> Vec<Vec<f64>> {
        let parameter = parameter.map_or(f64::NAN, |value| value * self.parameter);
        let mut columns = vec![Vec::with_capacity(setting.dwells()); self.coefficients.len()];
        for k in 0..setting.dwells() {
            let then = self.by_coefficient(parameter, |of| of.value(setting, j, k));
            let there = |of: Signal| if of.is_thermal() { 0.0 } else { of.value(setting, j, k) };
            let at_reference = match self.at_reference {
                AtReference::OfModel6 => self.by_coefficient(parameter, there),
                AtReference::Nothing | AtReference::Other => vec![0.0; columns.len()],
            };
            for ((column, then), at_reference) in columns.iter_mut().zip(then).zip(at_reference) {
                column.push((then - at_reference) * self.coefficient);
            }
        }
        columns
    }

    /// The equation with one coefficient 1 and the others 0, for each of them.
    fn by_coefficient(&self, parameter: f64, of: impl Fn(Signal) -> f64) -> Vec<f64> {
        let value = |name: &Input| match name {
            Input::Coefficient(_) => 0.0,
            Input::Parameter => parameter,
            Input::Signal(quantity) => of(*quantity),
        };
        let mut values: Vec<f64> = self.names.iter().map(value).collect();
        let of_one = |c: usize| {
            for (value, name) in values.iter_mut().zip(&self.names) {
                if let Input::Coefficient(place) = name {
                    *value = f64::from(u8::from(*place == c));
                }
            }
            self.equation.value(&values)
        };
        (0..self.coefficients.len()).map(of_one).collect()
    }

    /// Tried at points spread over what campaigns command: linear where it is halfway between two of them the mean of
    /// both, whatever everything but force and rate is.
    fn found_at_reference(&self) -> AtReference {
        const POINTS: usize = 24;
        if !self.is_of_temperature() {
            return AtReference::Nothing;
        }
        // Multiples of the golden section are spread evenly.
        let spread = |at: usize| 2.0 * (0.618_033_988_749_895 * (at + 1) as f64).fract() - 1.0;
        let parameters = if self.grid().is_empty() { vec![f64::NAN] } else { self.grid() };
        let mut found = AtReference::Nothing;
        for (parameter, point) in parameters.into_iter().flat_map(|value| (0..POINTS).map(move |point| (value, point)))
        {
            let drawn = |of: Signal, point: usize| {
                let place = QUANTITIES.iter().position(|(_, known)| *known == of).unwrap_or(0);
                spread(point * QUANTITIES.len() + place) * of.extent()
            };
            let at = |force_and_rate: &dyn Fn(Signal) -> f64, others: usize| {
                let of = |of: Signal| match of {
                    Signal::Force(_) | Signal::Rate(_) => force_and_rate(of),
                    Signal::HalfTurn => std::f64::consts::PI,
                    _ => drawn(of, others),
                };
                self.by_coefficient(parameter * self.parameter, of)
            };
            let (one, other) = (3 * point, 3 * point + 1);
            let [first, second, halfway] = [
                at(&|of| drawn(of, one), one),
                at(&|of| drawn(of, other), other),
                at(&|of| 0.5 * (drawn(of, one) + drawn(of, other)), 3 * point + 2),
            ];
            for ((first, second), halfway) in first.into_iter().zip(second).zip(halfway) {
                if ![first, second, halfway].into_iter().all(f64::is_finite) {
                    return AtReference::Other;
                }
                let largest = first.abs().max(second.abs()).max(halfway.abs());
                if (0.5 * (first + second) - halfway).abs() > 1e-9 * largest {
                    return AtReference::Other;
                }
                if largest > 0.0 {
                    found = AtReference::OfModel6;
                }
            }
        }
        found
    }

    /// The first dwell in which it has no finite value in some gyro, at some value of its parameter.
    pub fn not_finite(&self, setting: &Setting) -> Option<usize> {
        let grid = self.grid();
        let values: Vec<Option<f64>> = if grid.is_empty() { vec![None] } else { grid.into_iter().map(Some).collect() };
        let places = (0..setting.gyros.len()).flat_map(|j| values.iter().map(move |value| (j, *value)));
        let columns = places.flat_map(|(j, value)| self.columns(setting, j, value));
        columns.filter_map(|column| column.iter().position(|x| !x.is_finite())).min()
    }
}

impl Signal {
    fn quantity(self) -> Quantity {
        match self {
            Self::Force(_) | Self::ForceBefore(_) => Quantity::of(Dimension::FORCE),
            Self::Rate(_) | Self::RateBefore(_) => Quantity::of(Dimension::RATE),
            Self::Attitude(..) => Quantity::of(Dimension::NUMBER),
            Self::Temperature => Quantity::of(Dimension::TEMPERATURE),
            Self::TemperatureSlope => Quantity::of(Dimension::TEMPERATURE.times(Dimension::TIME, -1.0)),
            Self::Time => Quantity::of(Dimension::TIME),
            Self::HalfTurn => Quantity::constant(std::f64::consts::PI),
        }
    }

    fn is_thermal(self) -> bool {
        matches!(self, Self::Temperature | Self::TemperatureSlope)
    }

    /// How large it may be in a campaign at the reference temperature; zero for what does not vary there.
    fn extent(self) -> f64 {
        match self {
            Self::Force(_) | Self::ForceBefore(_) | Self::Attitude(..) => 1.0,
            Self::Rate(_) | Self::RateBefore(_) => 1e4,
            Self::Temperature | Self::TemperatureSlope | Self::HalfTurn => 0.0,
            Self::Time => 10.0,
        }
    }

    /// In dwell `k` for gyro `j`. Before the first dwell there is nothing; a temperature or attitude that the campaign
    /// lacks is asked before.
    fn value(self, s: &Setting, j: usize, k: usize) -> f64 {
        let axis = |axis: Axis| axis.of(&s.gyros[j]);
        match self {
            Self::Force(of) => s.force[k].dot(axis(of)),
            Self::Rate(of) => s.rate[k].dot(axis(of)),
            Self::ForceBefore(of) => k.checked_sub(1).map_or(0.0, |k| s.force[k].dot(axis(of))),
            Self::RateBefore(of) => k.checked_sub(1).map_or(0.0, |k| s.rate[k].dot(axis(of))),
            Self::Attitude(of, along) => {
                s.nav_to_body.as_ref().map_or(0.0, |c| axis(of).dot(&c[k].column(along).into_owned()))
            }
            Self::Temperature => s.kelvin(k),
            // The first dwell has the slope of the second, per hour.
            Self::TemperatureSlope if s.dwells() > 1 => {
                let k = k.max(1);
                3600.0 * (s.kelvin(k) - s.kelvin(k - 1)) / (s.time[k] - s.time[k - 1])
            }
            Self::TemperatureSlope => 0.0,
            Self::Time => s.elapsed(k) / 3600.0,
            Self::HalfTurn => std::f64::consts::PI,
        }
    }
}

impl Axis {
    fn of(self, gyro: &GyroAxes) -> &Vector3<f64> {
        match self {
            I => &gyro.input,
            S => &gyro.spin,
            O => &gyro.output,
        }
    }
}

/// What each name is, and the coefficients in the order in which they come.
fn named(equation: &Equation, written: &HypothesisDefinition) -> Result<(Vec<Input>, Vec<String>), Message> {
    let mut coefficients: Vec<String> = Vec::new();
    let mut inputs = Vec::new();
    for name in equation.names() {
        let known = QUANTITIES.iter().find(|(known, _)| *known == name.name);
        let input = match known {
            Some((_, of)) => Input::Signal(*of),
            None if written.range.as_ref().is_some_and(|range| range.name == name.name) => Input::Parameter,
            None if name.name.starts_with('k') => {
                coefficients.push(name.name.clone());
                Input::Coefficient(coefficients.len() - 1)
            }
            None => {
                let known = list(QUANTITIES.map(|(known, _)| known));
                return Err(message!("equation_name", place = name.at, name = sent(&name.name), known));
            }
        };
        inputs.push(input);
    }
    if !(1..=MOST_COEFFICIENTS).contains(&coefficients.len()) {
        return Err(message!("equation_coefficients", have = coefficients.len(), most = MOST_COEFFICIENTS));
    }
    match &written.range {
        Some(range) if !inputs.contains(&Input::Parameter) => {
            Err(message!("equation_without_parameter", name = sent(&range.name)))
        }
        _ => Ok((inputs, coefficients)),
    }
}

/// That it is a drift, deg/h, with coefficients of this dimension; else which one they would need.
fn is_drift(equation: &Equation, names: &[Quantity], coefficient: Dimension) -> Result<(), Message> {
    let whole = checked(equation, names)?;
    if !whole.linear {
        return Err(message!("equation_free_term", place = 1_usize));
    }
    if whole.dimension == Dimension::RATE {
        return Ok(());
    }
    let needed = coefficient.times(Dimension::RATE, 1.0).times(whole.dimension, -1.0);
    Err(message!("equation_no_drift", unit = text(whole.dimension), needed = text(needed)))
}

/// Whether the range holds zero, where the equation has no value: it divides by the parameter, say. The values tried
/// lie on either side of it and show nothing.
fn spans_a_pole(equation: &Equation, names: &[Input], range: &Range) -> bool {
    let at = |zero: f64| {
        // Other quantities differ from one another, so that no difference of theirs vanishes.
        let other = |place: usize| 1.0 + 0.37 * place as f64;
        let values = names.iter().zip(0..).map(|(name, i)| if *name == Input::Parameter { zero } else { other(i) });
        equation.value(&values.collect::<Vec<_>>())
    };
    range.from <= 0.0 && range.to >= 0.0 && !(at(0.0).is_finite() && at(-0.0).is_finite())
}

/// The dimension of a parameter, and its unit in base units.
fn checked_range(range: &Range, faults: &mut Faults) -> Option<(Dimension, f64)> {
    let place = format!("/range/{}", range.name);
    if !(range.from.is_finite() && range.to.is_finite() && range.from < range.to) {
        faults.push(place.clone(), message!("range_empty", from = text(range.from), to = text(range.to)));
    }
    let quantity = QUANTITIES.iter().any(|(known, _)| *known == range.name);
    let named =
        range.name.starts_with(char::is_alphabetic) && range.name.chars().all(|c| c.is_alphanumeric() || c == '_');
    if quantity || !named || range.name.starts_with('k') {
        faults.push(place.clone(), message!("range_name", name = sent(&range.name)));
    }
    Dimension::read(&range.unit).map_err(|message| faults.push(format!("{place}/unit"), message)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::effects::{CATALOGUE, Effect, Shape, own};

    fn written(equation: &str, unit: &str) -> HypothesisDefinition {
        HypothesisDefinition {
            id: "mine".into(),
            words: "mine".into(),
            cause: "it is".into(),
            equation: equation.into(),
            unit: unit.into(),
            plausible: 1.0,
            typical: [1e-3, 1e-2],
            common: false,
            range: None,
        }
    }

    fn refused(written: HypothesisDefinition) -> Vec<(String, String)> {
        let faults = OwnHypothesis::of(written).unwrap_err();
        faults.0.into_iter().map(|fault| (fault.pointer, fault.message.to_string())).collect()
    }

    fn setting() -> Setting {
        let campaign = std::fs::read("tests/data/practice/campaign-02.json").unwrap();
        let campaign = crate::wire::campaign::parse_json(&campaign).unwrap();
        crate::core::effects::axes::setting(&campaign).unwrap().0
    }

    #[test]
    fn entries_of_the_catalogue_written_out_are_those_entries() {
        let setting = setting();
        for (id, equation) in [
            ("temperature_bias", "k * T"),
            ("temperature_scale", "k * T * w_I"),
            ("time_ramp", "k * t"),
            ("hysteresis", "k * a_O_before"),
            ("scale_asymmetry", "k * sign(w_I) * w_I"),
            ("scale_quadratic", "k * w_I^2"),
            ("scale_cubic", "k * w_I^3"),
            ("g_rate_coupling", "k * a_I * w_I"),
            ("cubic_g", "k * a_I^3"),
            ("cross_compliance", "k_IS * a_I * a_S + k_IO * a_I * a_O + k_OS * a_O * a_S"),
        ] {
            let entry = CATALOGUE.into_iter().find(|entry| entry.id == id).unwrap();
            let effect = own(OwnHypothesis::of(written(equation, entry.unit)).unwrap()).unwrap();
            for j in 0..setting.gyros.len() {
                let theirs = (entry.columns)(&setting, j, Shape::Linear);
                let mine = (effect.entry().columns)(&setting, j, Shape::Linear);
                assert_eq!(mine.len(), theirs.len());
                for (mine, theirs) in mine.iter().flatten().zip(theirs.iter().flatten()) {
                    assert!((mine - theirs).abs() <= 1e-12 * theirs.abs().max(1e-12), "{id}: {mine} {theirs}");
                }
            }
            assert_eq!(effect.entry().of_temperature, entry.of_temperature, "{id}");
            assert_eq!(effect.entry().follows_time, entry.follows_time, "{id}");
            assert_eq!(effect.entry().course_in_time, entry.course_in_time, "{id}");
        }
    }

    #[test]
    fn a_parameter_runs_over_its_range_in_its_unit() {
        let range = Range { name: "tau".into(), from: 10.0, to: 1000.0, unit: "min".into() };
        let decay = HypothesisDefinition { range: Some(range), ..written("k1 * exp(-t/tau) * a_S", "deg/(h g0)") };
        let decay = OwnHypothesis::of(decay).unwrap();
        let grid = decay.grid();
        assert_eq!((grid.len(), grid[0]), (GRID, 10.0));
        assert!((grid[GRID - 1] - 1000.0).abs() < 1e-9 && (grid[1] / grid[0] - grid[2] / grid[1]).abs() < 1e-9);
        let setting = setting();
        let column = &decay.columns(&setting, 1, Some(30.0))[0];
        let expected = (-setting.elapsed(7) / 1800.0).exp() * setting.force[7].dot(&setting.gyros[1].spin);
        assert!((column[7] - expected).abs() < 1e-12);
        assert!(!decay.follows_time());
    }

    #[test]
    fn what_it_is_at_the_reference_temperature_belongs_to_model_6_where_that_has_it() {
        let setting = setting();
        let of = |equation, unit, name: &str| {
            let range = Some(Range { name: name.into(), from: 1.0, to: 40.0, unit: "K".into() });
            OwnHypothesis::of(HypothesisDefinition { range, ..written(equation, unit) }).unwrap()
        };
        let (axes, t) = (&setting.gyros[1], setting.temperature.clone().unwrap());
        let spin = |k: usize| setting.force[k].dot(&axes.spin);
        let input = |k: usize| setting.rate[k].dot(&axes.input);
        let grown = |k: usize| (t[k] / 5.0).exp();
        let cases: [(&str, &str, bool, &dyn Fn(usize) -> f64); 6] = [
            ("k * exp(T/warm) * a_S", "deg/(h g0)", false, &|k| (grown(k) - 1.0) * spin(k)),
            ("k * (T + warm) * w_I", "1/K", false, &|k| t[k] * input(k)),
            ("k * (exp(T/warm) - 1) * w_I^2", "h/deg", false, &|k| (grown(k) - 1.0) * input(k).powi(2)),
            ("k * exp(T/warm) * w_I^2", "h/deg", true, &|k| grown(k) * input(k).powi(2)),
            ("k * (T + warm) * t * a_S", "deg/(h^2 g0 K)", true, &|k| {
                (t[k] + 5.0) * setting.elapsed(k) / 3600.0 * spin(k)
            }),
            // It has no value there.
            ("k * warm / T * a_S", "deg/(h g0)", true, &|k| 5.0 / t[k] * spin(k)),
        ];
        for (equation, unit, is_left_out, expected) in cases {
            let own = of(equation, unit, "warm");
            assert_eq!(own.is_left_out_at_reference(), is_left_out, "{equation}");
            let columns = own.columns(&setting, 1, Some(5.0));
            for (k, found) in columns[0].iter().enumerate().filter(|(k, _)| expected(*k).is_finite()) {
                assert!((found - expected(k)).abs() < 1e-9 * expected(k).abs().max(1e-3), "{equation}, {k}");
            }
        }
    }

    #[test]
    fn an_equation_asks_for_an_order_of_dwells_where_it_holds_what_came_before() {
        let asks = |equation| OwnHypothesis::of(written(equation, "deg/(h g0 K)")).unwrap().is_of_order();
        assert!(!asks("k1 * T * a_I") && asks("k1 * T * a_I_before"));
    }

    #[test]
    fn attitude_slope_and_units_of_coefficients_are_what_they_say() {
        let setting = setting();
        let field = OwnHypothesis::of(written("k1 * I_N + k2 * S_U * pi", "arcsec/h")).unwrap();
        let columns = field.columns(&setting, 0, None);
        let c = setting.nav_to_body.as_ref().unwrap()[3];
        let north = setting.gyros[0].input.dot(&(c * Vector3::y()));
        let up = setting.gyros[0].spin.dot(&(c * Vector3::z())) * std::f64::consts::PI;
        assert!((columns[0][3] - north / 3600.0).abs() < 1e-15 && (columns[1][3] - up / 3600.0).abs() < 1e-15);
        let slope = OwnHypothesis::of(written("k * dT/dt", "deg/K")).unwrap().columns(&setting, 0, None);
        let t = setting.temperature.as_ref().unwrap();
        assert!((slope[0][5] * (setting.time[5] - setting.time[4]) / 3600.0 - (t[5] - t[4])).abs() < 1e-9);
    }

    #[test]
    fn what_makes_no_sense_is_said_with_its_place_and_the_way_out() {
        for (equation, unit, expected) in [
            ("k * T * w_I", "deg/h/K", "equation_no_drift (unit: deg^2/h^2, needed: 1/K)"),
            ("k * (T + t)", "1", "equation_units_differ (place: 8, left: K, right: h)"),
            ("k * exp(T)", "deg/h", "equation_pure_number (place: 5, unit: K)"),
            ("k / 0", "deg/h", "equation_over_zero (place: 3)"),
            ("k * T / (2 - 2)", "deg/h/K", "equation_over_zero (place: 7)"),
            ("k * k2 * T", "deg/h/K", "equation_not_linear (place: 3)"),
            ("exp(k)", "1", "equation_not_linear (place: 1)"),
            ("k * w_I + w_I", "1", "equation_free_term (place: 9)"),
            ("w_I", "1", "equation_coefficients (have: 0, most: 4)"),
            ("k1*T + k2*T + k3*T + k4*T + k5*T", "deg/h/K", "equation_coefficients (have: 5, most: 4)"),
            ("k * Tau", "deg/h", "equation_name (place: 5, name: Tau"),
            ("k", "volt", "unknown_unit (value: volt"),
            ("k * a_I^t", "deg/h", "equation_pure_number (place: 8, unit: h)"),
        ] {
            let refused = refused(written(equation, unit));
            assert_eq!(refused.len(), 1, "{refused:?}");
            assert!(refused[0].1.starts_with(expected), "{equation}: {refused:?}");
        }
        let range = |name: &str, from, to| Some(Range { name: name.into(), from, to, unit: "h".into() });
        for (range, pointer, expected) in [
            (range("tau", 2.0, 1.0), "/range/tau", "range_empty"),
            (range("t", 1.0, 2.0), "/range/t", "range_name"),
            (range("tau", 1.0, 2.0), "/equation", "equation_without_parameter"),
        ] {
            let refused = refused(HypothesisDefinition { range, ..written("k * t", "deg/h/h") });
            assert_eq!(refused[0].0, pointer, "{refused:?}");
            assert!(refused[0].1.starts_with(expected), "{refused:?}");
        }
        for (equation, unit) in [("k * exp(-t/tau) * a_S", "deg/(h g0)"), ("k * t / tau", "deg/h")] {
            for (from, to) in [(-1.0, 1.0), (0.0, 1.0)] {
                let refused =
                    refused(HypothesisDefinition { range: range("tau", from, to), ..written(equation, unit) });
                assert_eq!(refused[0].0, "/range/tau", "{refused:?}");
                assert!(refused[0].1.starts_with("range_through_zero"), "{refused:?}");
            }
        }
        let shifted = HypothesisDefinition { range: range("t0", -1.0, 1.0), ..written("k * (t - t0)", "deg/h/h") };
        OwnHypothesis::of(shifted).unwrap();
        let sizes = refused(HypothesisDefinition { plausible: f64::NAN, ..written("k * T", "deg/h/K") });
        assert_eq!(sizes, [("/plausible".to_owned(), "hypothesis_sizes".to_owned())]);
    }

    #[test]
    fn a_dwell_in_which_it_divides_by_zero_is_a_lack_of_the_campaign() {
        let mut setting = setting();
        setting.force[4] = setting.gyros[0].output;
        let ratio = OwnHypothesis::of(written("k / (a_I - a_I_before)", "deg g0/h")).unwrap();
        setting.force[5] = setting.force[4];
        assert!(ratio.not_finite(&setting).is_some_and(|dwell| dwell <= 5));
        let effect = own(OwnHypothesis::of(written("k * a_I^3", "deg/(h g0^3)")).unwrap()).unwrap();
        assert!((effect.entry().missing)(&setting).is_none());
        assert!(matches!(effect, Effect::Own(_)) && effect.is_nameable());
        assert_eq!(own(OwnHypothesis::of(written("k * a_I^3", "deg/(h g0^3)")).unwrap()).unwrap(), effect);
    }
}
