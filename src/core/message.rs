//! What is to be said, before it is words: a code that never changes once it has been given out, and its parameters.
//!
//! Words are made at the edge, in the language that was asked for ([`crate::words`]). Figures are parameters as they
//! are to be read, rounded to what they are known to; counts stay numbers, because words agree with them.

use std::borrow::Cow;
use std::fmt::{self, Display, Formatter};

/// A code with its parameters. Made with [`message!`](crate::message).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    pub code: Cow<'static, str>,
    pub parameters: Vec<(Cow<'static, str>, Parameter)>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Parameter {
    /// The same in every language: a figure, a name, a key, a date, what somebody wrote.
    Text(Cow<'static, str>),
    Count(u64),
    /// Something that is itself said in the reader's language.
    Message(Message),
    List(Vec<Parameter>),
}

impl Message {
    /// Code and named parameters; its words are made where somebody reads it.
    pub fn new(code: &'static str, parameters: Vec<(Cow<'static, str>, Parameter)>) -> Self {
        Self { code: Cow::Borrowed(code), parameters }
    }

    /// A text of others, which is said as it is: of a library, of the operating system, of a database that an older
    /// version wrote.
    pub fn verbatim(text: impl Display) -> Self {
        crate::message!("verbatim", text = text.to_string())
    }

    /// A parameter by name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }
}

/// For logs and for programmers: the code and its parameters, in no language; a text of others as it is.
impl Display for Message {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let ("verbatim", [(_, text)]) = (&*self.code, &self.parameters[..]) {
            return write!(f, "{text}");
        }
        f.write_str(&self.code)?;
        for (k, (name, value)) in self.parameters.iter().enumerate() {
            write!(f, "{}{name}: {value}", if k == 0 { " (" } else { ", " })?;
        }
        f.write_str(if self.parameters.is_empty() { "" } else { ")" })
    }
}

impl Display for Parameter {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Count(count) => write!(f, "{count}"),
            Self::Message(message) => write!(f, "{message}"),
            Self::List(list) => {
                for (k, one) in list.iter().enumerate() {
                    write!(f, "{}{one}", if k == 0 { "" } else { ", " })?;
                }
                Ok(())
            }
        }
    }
}

/// A figure with so many decimals.
pub fn figure(value: f64, decimals: usize) -> Parameter {
    Parameter::Text(format!("{value:.decimals$}").into())
}

/// A p value: 0.004, 3e-6.
pub fn p_value(p: f64) -> Parameter {
    if p > 0.0 && p < 1e-4 { Parameter::Text(format!("{p:.0e}").into()) } else { significant(p, 1) }
}

/// A figure with so many significant digits, as far as they are decimals.
pub fn significant(value: f64, digits: i32) -> Parameter {
    let first = value.abs().max(1e-9).log10().floor() as i32;
    figure(value, (digits - 1 - first).max(0) as usize)
}

/// A figure with so many decimals and its sign.
pub fn signed(value: f64, decimals: usize) -> Parameter {
    Parameter::Text(format!("{value:+.decimals$}").into())
}

/// What reads the same in every language.
pub fn text(value: impl Display) -> Parameter {
    Parameter::Text(value.to_string().into())
}

/// What somebody sent, with its control characters escaped. Its words put it in quotes.
pub fn sent(text: &str) -> Parameter {
    Parameter::Text(text.escape_debug().to_string().into())
}

/// Several, in the reader's way of listing them.
pub fn list<T: Into<Parameter>>(of: impl IntoIterator<Item = T>) -> Parameter {
    Parameter::List(of.into_iter().map(Into::into).collect())
}

impl From<&'static str> for Parameter {
    fn from(text: &'static str) -> Self {
        Self::Text(Cow::Borrowed(text))
    }
}

impl From<String> for Parameter {
    fn from(text: String) -> Self {
        Self::Text(Cow::Owned(text))
    }
}

impl From<usize> for Parameter {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl From<u64> for Parameter {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

/// What reads the same in every language, as [`text`].
impl From<fmt::Arguments<'_>> for Parameter {
    fn from(text: fmt::Arguments<'_>) -> Self {
        Self::Text(text.to_string().into())
    }
}

impl From<Message> for Parameter {
    fn from(message: Message) -> Self {
        Self::Message(message)
    }
}

/// `message!("too_few", have, need = least + 1)`: a [`Message`] with its parameters by name; `have` says `have = have`.
///
/// The code and the names are those of a message in `src/words/en` and `src/words/zh`; `tests/words.rs` compares them.
#[macro_export]
macro_rules! message {
    (@ $name:ident) => { $name };
    (@ $name:ident = $value:expr) => { $value };
    ($code:literal $(, $name:ident $(= $value:expr)?)* $(,)?) => {
        $crate::core::message::Message::new(
            $code,
            vec![$((
                stringify!($name).into(),
                $crate::core::message::Parameter::from($crate::message!(@ $name $(= $value)?)),
            )),*],
        )
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_shows_the_code_and_its_parameters() {
        let inner = message!("inner", of = list(["a", "b"]));
        let outer = message!("outer", count = 3_usize, value = signed(0.5, 2), why = inner);
        assert_eq!(outer.to_string(), "outer (count: 3, value: +0.50, why: inner (of: a, b))");
        assert_eq!(message!("plain").to_string(), "plain");
        assert_eq!(Message::verbatim("as it is").to_string(), "as it is");
    }
}
