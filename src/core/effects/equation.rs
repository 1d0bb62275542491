//! An equation as people write it, `k1 * exp(-t/tau) * a_S`, read once and computed often.
//!
//! ```text
//! sum = product {(+|-) product};  product = factor {(*|/) factor};  factor = -factor | atom [^ factor]
//! atom = number | name | function(sum) | (sum)
//! ```
//!
//! so that `-w^2` is `-(w^2)`. Length and depth are limited before anything is read; the steps lie in the order in
//! which a stack takes them, and computing runs no code but the functions of [`Function`].

use crate::core::message::{Message, sent};
use crate::core::named::named;
use crate::message;

/// Longest text, and most brackets, functions, signs and powers within one another.
const LONGEST: usize = 1000;
const DEEPEST: usize = 32;

/// An equation in names.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Equation {
    steps: Vec<Step>,
    names: Vec<EquationName>,
}

/// A name in an equation, and the character (from 1) at which it stands first.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EquationName {
    pub name: String,
    pub at: usize,
}

/// One step, and the character at which its sign stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    pub what: Instruction,
    pub at: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Instruction {
    Number(f64),
    /// By its place among the names.
    Name(usize),
    Minus,
    Function(Function),
    Two(Operator),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Operator {
    Plus,
    Minus,
    Times,
    Over,
    Power,
}

named! {
/// A function of one number, by its name in equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    Exp = "exp",
    Ln = "ln",
    Sqrt = "sqrt",
    Abs = "abs",
    Sign = "sign",
    Step = "step",
    Sin = "sin",
    Cos = "cos",
    Tan = "tan",
    Tanh = "tanh",
}
}

impl Function {
    fn of(self, x: f64) -> f64 {
        match self {
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Sqrt => x.sqrt(),
            Self::Abs => x.abs(),
            // Neither sense where there is none.
            Self::Sign => f64::from(i8::from(x > 0.0) - i8::from(x < 0.0)),
            Self::Step => f64::from(u8::from(x > 0.0)),
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Tanh => x.tanh(),
        }
    }
}

impl Operator {
    /// Its value. Whole powers up to 64 are exact products.
    pub fn of(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Plus => a + b,
            Self::Minus => a - b,
            Self::Times => a * b,
            Self::Over => a / b,
            // Whole powers exactly as products are.
            Self::Power if b.fract() == 0.0 && b.abs() <= 64.0 => a.powi(b as i32),
            Self::Power => a.powf(b),
        }
    }
}

impl Equation {
    /// Reads an equation.
    ///
    /// # Errors
    /// What cannot be read, and at which character.
    pub fn read(text: &str) -> Result<Self, Message> {
        let length = text.chars().count();
        if length > LONGEST {
            return Err(message!("equation_too_long", have = length, most = LONGEST));
        }
        let mut reader =
            EquationParser { rest: text.char_indices().collect(), next: 0, depth: 0, steps: vec![], names: vec![] };
        reader.sum()?;
        match reader.peek() {
            Some(_) => Err(reader.unexpected(message!("equation_operator"))),
            None => Ok(Self { steps: reader.steps, names: reader.names }),
        }
    }

    /// Names in the order of their first use.
    pub fn names(&self) -> &[EquationName] {
        &self.names
    }

    /// Steps of a stack machine, in the order in which they are carried out.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Its value for values of the names.
    pub fn value(&self, names: &[f64]) -> f64 {
        let mut stack: Vec<f64> = Vec::with_capacity(8);
        let pop = |stack: &mut Vec<f64>| stack.pop().unwrap_or(f64::NAN);
        for step in &self.steps {
            let value = match step.what {
                Instruction::Number(number) => number,
                Instruction::Name(place) => names[place],
                Instruction::Minus => -pop(&mut stack),
                Instruction::Function(function) => function.of(pop(&mut stack)),
                Instruction::Two(operator) => {
                    let b = pop(&mut stack);
                    operator.of(pop(&mut stack), b)
                }
            };
            stack.push(value);
        }
        pop(&mut stack)
    }
}

struct EquationParser {
    rest: Vec<(usize, char)>,
    next: usize,
    depth: usize,
    steps: Vec<Step>,
    names: Vec<EquationName>,
}

impl EquationParser {
    fn peek(&mut self) -> Option<char> {
        while self.rest.get(self.next).is_some_and(|(_, c)| c.is_whitespace()) {
            self.next += 1;
        }
        self.rest.get(self.next).map(|(_, c)| *c)
    }

    fn take(&mut self, wanted: &[char]) -> Option<(char, usize)> {
        let found = self.peek().filter(|c| wanted.contains(c))?;
        self.next += 1;
        Some((found, self.next))
    }

    fn push(&mut self, what: Instruction, at: usize) {
        self.steps.push(Step { what, at });
    }

    fn sum(&mut self) -> Result<(), Message> {
        self.product()?;
        while let Some((sign, at)) = self.take(&['+', '-']) {
            self.product()?;
            self.push(Instruction::Two(if sign == '+' { Operator::Plus } else { Operator::Minus }), at);
        }
        Ok(())
    }

    fn product(&mut self) -> Result<(), Message> {
        self.factor()?;
        while let Some((sign, at)) = self.take(&['*', '/']) {
            self.factor()?;
            self.push(Instruction::Two(if sign == '*' { Operator::Times } else { Operator::Over }), at);
        }
        Ok(())
    }

    fn factor(&mut self) -> Result<(), Message> {
        if let Some((_, at)) = self.take(&['-']) {
            self.deeper(Self::factor)?;
            self.push(Instruction::Minus, at);
            return Ok(());
        }
        self.atom()?;
        if let Some((_, at)) = self.take(&['^']) {
            self.deeper(Self::factor)?;
            self.push(Instruction::Two(Operator::Power), at);
        }
        Ok(())
    }

    fn atom(&mut self) -> Result<(), Message> {
        let Some(first) = self.peek() else { return Err(self.unexpected(message!("equation_value"))) };
        let (begin, at) = (self.next, self.next + 1);
        match first {
            '(' => {
                self.next += 1;
                self.closed()
            }
            '0'..='9' | '.' => {
                let number = self.number();
                let value = number.parse().ok().filter(|value: &f64| value.is_finite());
                let value = value.ok_or_else(|| message!("equation_number", place = at, found = sent(&number)))?;
                self.push(Instruction::Number(value), at);
                Ok(())
            }
            c if c.is_alphabetic() => {
                let name = self.name();
                if self.take(&['(']).is_some() {
                    let known = || Function::ALL.map(Function::name).join(", ");
                    let function = Function::from_name(&name).ok_or_else(|| {
                        message!("equation_function", place = at, name = sent(&name), known = known())
                    })?;
                    self.closed()?;
                    self.push(Instruction::Function(function), at);
                    return Ok(());
                }
                let place = self.names.iter().position(|known| known.name == name).unwrap_or_else(|| {
                    self.names.push(EquationName { name, at });
                    self.names.len() - 1
                });
                self.push(Instruction::Name(place), at);
                Ok(())
            }
            _ => {
                self.next = begin;
                Err(self.unexpected(message!("equation_value")))
            }
        }
    }

    /// What stands in brackets, and the closing one.
    fn closed(&mut self) -> Result<(), Message> {
        self.deeper(Self::sum)?;
        match self.take(&[')']) {
            Some(_) => Ok(()),
            None => Err(self.unexpected(message!("equation_closing"))),
        }
    }

    fn deeper(&mut self, read: fn(&mut Self) -> Result<(), Message>) -> Result<(), Message> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(message!("equation_too_deep", place = self.next, most = DEEPEST));
        }
        read(self)?;
        self.depth -= 1;
        Ok(())
    }

    /// Digits, a point, an exponent.
    fn number(&mut self) -> String {
        let mut number = String::new();
        while let Some((_, c)) = self.rest.get(self.next) {
            let exponent = matches!(c, 'e' | 'E') && !number.contains(['e', 'E']);
            let sign = matches!(c, '+' | '-') && number.ends_with(['e', 'E']);
            if !(c.is_ascii_digit() || *c == '.' || exponent || sign) {
                break;
            }
            number.push(*c);
            self.next += 1;
        }
        number
    }

    /// Letters, digits and underscores; `dT/dt` is one name.
    fn name(&mut self) -> String {
        let mut name = String::new();
        while let Some((_, c)) = self.rest.get(self.next).filter(|(_, c)| c.is_alphanumeric() || *c == '_') {
            name.push(*c);
            self.next += 1;
        }
        let slope: String = self.rest[self.next..].iter().take(3).map(|(_, c)| c).collect();
        let ends = self.rest.get(self.next + 3).is_none_or(|(_, c)| !(c.is_alphanumeric() || *c == '_'));
        if name == "dT" && slope == "/dt" && ends {
            self.next += 3;
            name.push_str(&slope);
        }
        name
    }

    fn unexpected(&mut self, wanted: Message) -> Message {
        match self.peek() {
            Some(found) => {
                message!("equation_unexpected", place = self.next + 1, found = sent(&found.to_string()), wanted)
            }
            None => message!("equation_ends", wanted),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str, names: &[f64]) -> f64 {
        Equation::read(text).unwrap().value(names)
    }

    #[test]
    fn signs_bind_as_in_a_textbook() {
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("8 / 4 / 2", 1.0),
            ("10 - 4 - 3", 3.0),
            ("-3^2", -9.0),
            ("(-3)^2", 9.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("-(1 - 2) * 4e1", 40.0),
            ("2 * -3", -6.0),
            ("sign(-7) + sign(0) + step(2) + abs(-5)", 5.0),
            ("1.5e-3 * 1E3", 1.5),
        ] {
            assert_eq!(value(text, &[]), expected, "{text}");
        }
        assert!((value("exp(ln(5)) + sqrt(9) + tanh(0) + sin(0) * tan(1) + cos(0)", &[]) - 9.0).abs() < 1e-12);
    }

    #[test]
    fn names_are_numbered_as_they_come() {
        let read = Equation::read("k * dT/dt * w_I / k").unwrap();
        let names: Vec<(&str, usize)> = read.names().iter().map(|n| (n.name.as_str(), n.at)).collect();
        assert_eq!(names, [("k", 1), ("dT/dt", 5), ("w_I", 13)]);
        assert_eq!(read.value(&[2.0, 3.0, 5.0]), 15.0);
    }

    #[test]
    fn what_cannot_be_read_is_said_with_its_place() {
        for (text, code, place) in [
            ("", "equation_ends", None),
            ("k * ", "equation_ends", None),
            ("k T", "equation_unexpected", Some("3")),
            ("k * (T + 1", "equation_ends", None),
            ("k * T)", "equation_unexpected", Some("6")),
            ("k ** T", "equation_unexpected", Some("4")),
            ("k * {T}", "equation_unexpected", Some("5")),
            ("k * system(1)", "equation_function", Some("5")),
            ("k * 1.2.3", "equation_number", Some("5")),
            ("k * 1e999", "equation_number", Some("5")),
        ] {
            let refused = Equation::read(text).unwrap_err();
            assert_eq!(refused.code, code, "{text}");
            let at = refused.parameter("place").map(ToString::to_string);
            assert_eq!(at.as_deref(), place, "{text}");
        }
    }

    #[test]
    fn neither_length_nor_depth_costs_anything() {
        let terms = vec!["k * T"; 1_000_000].join(" + ");
        assert_eq!(Equation::read(&terms).unwrap_err().code, "equation_too_long");
        for deep in ["(".repeat(400), "-".repeat(400), "exp(".repeat(200), "2^".repeat(400)] {
            assert_eq!(Equation::read(&deep).unwrap_err().code, "equation_too_deep", "{deep}");
        }
        let open = DEEPEST - 1;
        assert_eq!(value(&format!("{}3{}", "(".repeat(open), ")".repeat(open)), &[]), 3.0);
    }
}
