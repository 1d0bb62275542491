//! Units of what equations are made of: products of powers of deg, h, g0 and K, checked like the equation itself.

use std::fmt::{self, Display, Formatter};

use super::equation::{Equation, Function, Instruction, Operator};
use crate::core::message::{Message, sent, text};
use crate::message;

/// Powers of deg, h, g0 and K.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dimension([f64; 4]);

/// Names of units: their dimension, and how many of the base units each is. An angle in rad is a pure number; deg is
/// not: it stands for what drifts are counted in. 1 arcsec/s is 1 deg/h.
const UNITS: [(&str, [f64; 4], f64); 10] = [
    ("deg", [1.0, 0.0, 0.0, 0.0], 1.0),
    ("h", [0.0, 1.0, 0.0, 0.0], 1.0),
    ("g0", [0.0, 0.0, 1.0, 0.0], 1.0),
    ("K", [0.0, 0.0, 0.0, 1.0], 1.0),
    ("rad", [0.0; 4], 1.0),
    ("ppm", [0.0; 4], 1e-6),
    ("s", [0.0, 1.0, 0.0, 0.0], 1.0 / 3600.0),
    ("min", [0.0, 1.0, 0.0, 0.0], 1.0 / 60.0),
    ("arcsec", [1.0, 0.0, 0.0, 0.0], 1.0 / 3600.0),
    ("arcmin", [1.0, 0.0, 0.0, 0.0], 1.0 / 60.0),
];

impl Dimension {
    pub const NUMBER: Self = Self([0.0; 4]);
    pub const TIME: Self = Self([0.0, 1.0, 0.0, 0.0]);
    pub const FORCE: Self = Self([0.0, 0.0, 1.0, 0.0]);
    pub const TEMPERATURE: Self = Self([0.0, 0.0, 0.0, 1.0]);
    /// Of rates, and of drift.
    pub const RATE: Self = Self([1.0, -1.0, 0.0, 0.0]);

    /// The dimension of x y^`power`.
    pub fn times(self, other: Self, power: f64) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + power * other.0[i]))
    }

    /// Reads `deg/(h g0 K)`: the dimension, and how many base units it is.
    ///
    /// # Errors
    /// What is no unit.
    pub fn read(unit: &str) -> Result<(Self, f64), Message> {
        let known = || UNITS.map(|(name, ..)| name).join(", ");
        let unknown = || message!("unknown_unit", value = sent(unit), known = known());
        // A space between two units is a product.
        let tight = unit.replace("( ", "(").replace(" )", ")").replace(" /", "/").replace("/ ", "/");
        let product = tight.split_whitespace().collect::<Vec<_>>().join("*");
        let equation = Equation::read(&product).map_err(|_| unknown())?;
        let unit_of = |name: &str| UNITS.iter().find(|(known, ..)| *known == name);
        let units: Option<Vec<_>> = equation.names().iter().map(|name| unit_of(&name.name)).collect();
        let units = units.ok_or_else(unknown)?;
        let quantities: Vec<Quantity> = units.iter().map(|(_, powers, _)| Quantity::of(Self(*powers))).collect();
        let dimension = checked(&equation, &quantities).map_err(|_| unknown())?.dimension;
        let factor = equation.value(&units.iter().map(|(.., factor)| *factor).collect::<Vec<_>>());
        if factor > 0.0 && factor.is_finite() { Ok((dimension, factor)) } else { Err(unknown()) }
    }

    fn is(self, other: Self) -> bool {
        self.0.iter().zip(&other.0).all(|(a, b)| (a - b).abs() < 1e-9)
    }
}

/// The unit of what a coefficient is multiplied by to be a drift in deg/h.
pub fn regressor_unit(coefficient: &str) -> String {
    match Dimension::read(coefficient) {
        Ok((dimension, 1.0)) => Dimension::RATE.times(dimension, -1.0).to_string(),
        _ => format!("deg/h/({coefficient})"),
    }
}

impl Display for Dimension {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let names = ["deg", "h", "g0", "K"];
        let part = |above: bool| {
            let powers = self.0.iter().map(|p| if above { *p } else { -p });
            let power = |(name, p): (&str, f64)| match p {
                p if p < 1e-9 => None,
                p if (p - 1.0).abs() < 1e-9 => Some(name.to_owned()),
                p => Some(format!("{name}^{p}")),
            };
            names.into_iter().zip(powers).filter_map(power).collect::<Vec<_>>()
        };
        let (above, below) = (part(true), part(false));
        f.write_str(&if above.is_empty() { "1".to_owned() } else { above.join(" ") })?;
        match below.as_slice() {
            [] => Ok(()),
            [one] => write!(f, "/{one}"),
            several => write!(f, "/({})", several.join(" ")),
        }
    }
}

/// What is known of a quantity before its value is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Quantity {
    pub dimension: Dimension,
    /// Its value, where it is the same always.
    constant: Option<f64>,
    /// Whether it is proportional to the coefficients.
    pub linear: bool,
}

impl Quantity {
    /// A value that may change from dwell to dwell.
    pub fn of(dimension: Dimension) -> Self {
        Self { dimension, constant: None, linear: false }
    }

    /// A coefficient to be fitted.
    pub fn coefficient(dimension: Dimension) -> Self {
        Self { linear: true, ..Self::of(dimension) }
    }

    /// A number written in the equation.
    pub fn constant(value: f64) -> Self {
        Self { constant: Some(value), ..Self::of(Dimension::NUMBER) }
    }
}

/// What an equation comes to, by what its names are.
///
/// # Errors
/// The first step that makes no sense, and at which character it stands: units that differ, a division by zero,
/// coefficients that are no mere factors.
pub(super) fn checked(equation: &Equation, names: &[Quantity]) -> Result<Quantity, Message> {
    let mut stack: Vec<Quantity> = Vec::new();
    let nothing = Quantity::of(Dimension::NUMBER);
    for step in equation.steps() {
        let next = match step.what {
            Instruction::Number(value) => Quantity::constant(value),
            Instruction::Name(place) => names[place],
            Instruction::Minus => {
                let x = stack.pop().unwrap_or(nothing);
                Quantity { constant: x.constant.map(|x| -x), ..x }
            }
            Instruction::Function(function) => of_function(function, stack.pop().unwrap_or(nothing), step.at)?,
            Instruction::Two(operator) => {
                let b = stack.pop().unwrap_or(nothing);
                of_two(operator, stack.pop().unwrap_or(nothing), b, step.at)?
            }
        };
        stack.push(next);
    }
    Ok(stack.pop().unwrap_or(nothing))
}

fn of_function(function: Function, x: Quantity, at: usize) -> Result<Quantity, Message> {
    if x.linear {
        return Err(message!("equation_not_linear", place = at));
    }
    let any = Quantity { constant: None, ..x };
    match function {
        Function::Abs => Ok(any),
        Function::Sqrt => Ok(Quantity { dimension: Dimension::NUMBER.times(x.dimension, 0.5), ..any }),
        Function::Sign | Function::Step => Ok(Quantity::of(Dimension::NUMBER)),
        _ if x.dimension.is(Dimension::NUMBER) => Ok(any),
        _ => Err(message!("equation_pure_number", place = at, unit = text(x.dimension))),
    }
}

fn of_two(operator: Operator, a: Quantity, b: Quantity, at: usize) -> Result<Quantity, Message> {
    let constant = a.constant.zip(b.constant).map(|(a, b)| operator.of(a, b));
    let not_linear = || message!("equation_not_linear", place = at);
    let (dimension, linear) = match operator {
        Operator::Plus | Operator::Minus if !a.dimension.is(b.dimension) => {
            let (left, right) = (text(a.dimension), text(b.dimension));
            return Err(message!("equation_units_differ", place = at, left, right));
        }
        Operator::Plus | Operator::Minus if a.linear != b.linear => {
            return Err(message!("equation_free_term", place = at));
        }
        Operator::Plus | Operator::Minus => (a.dimension, a.linear),
        Operator::Times if a.linear && b.linear => return Err(not_linear()),
        Operator::Times => (a.dimension.times(b.dimension, 1.0), a.linear || b.linear),
        Operator::Over if b.constant == Some(0.0) => return Err(message!("equation_over_zero", place = at)),
        Operator::Over if b.linear => return Err(not_linear()),
        Operator::Over => (a.dimension.times(b.dimension, -1.0), a.linear),
        Operator::Power if a.linear || b.linear => return Err(not_linear()),
        Operator::Power if !b.dimension.is(Dimension::NUMBER) => {
            return Err(message!("equation_pure_number", place = at, unit = text(b.dimension)));
        }
        Operator::Power => match b.constant {
            Some(power) => (Dimension::NUMBER.times(a.dimension, power), false),
            None if a.dimension.is(Dimension::NUMBER) => (a.dimension, false),
            None => return Err(message!("equation_pure_number", place = at, unit = text(a.dimension))),
        },
    };
    Ok(Quantity { dimension, constant, linear })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regressor_has_the_unit_that_its_coefficient_leaves_of_a_drift() {
        for (coefficient, unit) in [
            ("deg/(h g0 K)", "g0 K"),
            ("deg/h", "1"),
            ("1/K", "deg K/h"),
            ("deg/h/K", "K"),
            ("arcsec/min", "deg/h/(arcsec/min)"),
        ] {
            assert_eq!(regressor_unit(coefficient), unit);
        }
    }

    #[test]
    fn every_unit_of_the_catalogue_is_read_and_said() {
        for entry in crate::core::effects::CATALOGUE {
            let (dimension, factor) = Dimension::read(entry.unit).unwrap_or_else(|e| panic!("{}: {e}", entry.unit));
            assert_eq!(factor, 1.0, "{}", entry.unit);
            assert!(Dimension::read(&dimension.to_string()).unwrap().0.is(dimension), "{} {dimension}", entry.unit);
        }
        assert_eq!(Dimension::read("deg/(h g0 K)").unwrap().0.to_string(), "deg/(h g0 K)");
        assert_eq!(Dimension::read("arcsec/s").unwrap(), (Dimension::RATE, 1.0));
        assert_eq!(Dimension::read("ppm/K").unwrap().1, 1e-6);
        for wrong in ["", "volt", "deg/", "deg + h", "deg/h K)", "0", "k"] {
            assert_eq!(Dimension::read(wrong).unwrap_err().code, "unknown_unit", "{wrong}");
        }
    }
}
