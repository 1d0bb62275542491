//! Members that every document has in one form or another: each is checked here, its fault noted at its place.
//!
//! A refused member is given a stand-in, so that checking can go on and name the other faults as well; the
//! stand-in never leaves the conversion, which fails once any fault was noted.

use std::fmt::Display;

use nalgebra::Vector3;
use utoipa::PartialSchema;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

use super::time;
use crate::core::message::{Parameter, list, sent, text};
use crate::core::named::Named;
use crate::core::record::{MAX_NAME_CHARS, MAX_NOTE_CHARS, Name};
use crate::core::time::Span;
use crate::wire::json::said;
use crate::wire::prelude::*;

/// What is wrong with a text in TOML, at its line.
pub fn toml_fault(error: &toml::de::Error, text: &str) -> Message {
    message!("at_line", line = line_of(error, text), fault = said_of_keys(error.message()))
}

/// As [`toml_fault`], of a map.
pub fn map_fault(error: &toml::de::Error, text: &str) -> Message {
    let fault = message!("map_unreadable", why = said_of_keys(error.message()));
    message!("at_line", line = line_of(error, text), fault)
}

fn line_of(error: &toml::de::Error, text: &str) -> usize {
    error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count())
}

/// What serde says of a document whose members are called keys.
pub fn said_of_keys(text: &str) -> Message {
    let said = said(text);
    match (&*said.code, said.parameter("member"), said.parameter("known")) {
        ("unknown_member", Some(key), Some(Parameter::List(known))) => {
            let known = list(known.iter().map(|key| format!("`{key}`")));
            message!("unknown_toml_key", key = key.clone(), known)
        }
        _ => said,
    }
}

/// A name as one segment of a path, or a value within a query: every byte but RFC 3986's unreserved ones as %XX.
pub fn encoded(text: &str) -> String {
    let mut encoded = String::with_capacity(text.len());
    for byte in text.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            encoded.push(char::from(byte));
        } else {
            encoded.push_str(&format!("%{byte:02X}"));
        }
    }
    encoded
}

/// A name that something is to match: in its one spelling, without characters that nobody sees.
pub fn matched(pointer: &str, text: &str, faults: &mut Faults) -> Option<String> {
    let seen = Name::parse(text).and_then(|name| name.check_seen().map(|()| name.as_str().to_owned()));
    seen.map_err(|why| faults.push(pointer, why)).ok()
}

/// Largest standard deviation and temperature that is taken for a measured one.
pub(crate) const LARGEST_DEVIATION: f64 = 1e9;
pub(crate) const TEMPERATURE_RANGE_C: std::ops::RangeInclusive<f64> = -273.15..=1000.0;

/// Reads a name. A stand-in is returned where there is a fault, so that reading goes on.
pub fn name(pointer: &str, text: &str, faults: &mut Faults) -> Name {
    Name::parse(text).unwrap_or_else(|detail| {
        faults.push(pointer, detail);
        stand_in(pointer)
    })
}

/// A name of its own for each place, so that two refused serials are not taken for one gyro.
fn stand_in(pointer: &str) -> Name {
    let tail: String = pointer.chars().rev().take(MAX_NAME_CHARS).collect();
    Name::parse(&tail).expect("the end of a pointer is short, not empty and free of blanks")
}

/// The value that a member names.
pub fn named<T: Named>(pointer: &str, name: &str, faults: &mut Faults) -> Option<T> {
    let found = T::from_name(name);
    if found.is_none() {
        let known = list(T::NAMES.iter().copied());
        faults.push(pointer, message!("must_be_one_of", known, value = sent(name)));
    }
    found
}

/// Reads a time in RFC 3339; a fault where it is none.
pub fn instant(pointer: &str, text: &str, faults: &mut Faults) -> UtcMicros {
    read(time::parse(text), pointer, faults)
}

/// Where a stretch of time begins; a day begins at midnight UTC.
pub fn start(pointer: &str, text: &str, faults: &mut Faults) -> UtcMicros {
    read(time::parse_start(text), pointer, faults)
}

/// Where a stretch of time ends; a day (UTC) belongs to it.
pub fn end(pointer: &str, text: &str, faults: &mut Faults) -> UtcMicros {
    read(time::parse_end(text), pointer, faults)
}

fn read(instant: Result<UtcMicros, Message>, pointer: &str, faults: &mut Faults) -> UtcMicros {
    instant.unwrap_or_else(|detail| {
        faults.push(pointer, detail);
        UtcMicros(0)
    })
}

/// Optional text of one line.
pub fn short(pointer: &str, text: &Option<String>, faults: &mut Faults) -> Option<String> {
    optional(pointer, text, MAX_NAME_CHARS, |c| c.is_control(), faults)
}

/// Optional text of several lines.
pub fn note(pointer: &str, text: &Option<String>, faults: &mut Faults) -> Option<String> {
    optional(pointer, text, MAX_NOTE_CHARS, |c| c.is_control() && !matches!(c, '\n' | '\r' | '\t'), faults)
}

/// Two instants, the second not before the first.
pub fn span((from_at, from): (&str, &str), (to_at, to): (&str, &str), faults: &mut Faults) -> Span {
    let before = faults.0.len();
    let span = Span { from: start(from_at, from, faults), to: end(to_at, to, faults) };
    if faults.0.len() == before && span.to < span.from {
        faults.push(to_at, message!("to_before_from"));
    }
    span
}

/// Text of one line that must say something: who did it, say.
pub fn required_short(pointer: &str, text: String, faults: &mut Faults) -> String {
    required(pointer, &text, faults);
    short(pointer, &Some(text), faults).unwrap_or_default()
}

/// Text of several lines that must say something: why, say.
pub fn required_note(pointer: &str, text: String, faults: &mut Faults) -> String {
    required(pointer, &text, faults);
    note(pointer, &Some(text), faults).unwrap_or_default()
}

/// Who does something, in the member `who`, and why.
pub fn signed(who: &str, by: String, reason: String, faults: &mut Faults) -> (String, String) {
    (required_short(who, by, faults), required_note("/reason", reason, faults))
}

fn required(pointer: &str, text: &str, faults: &mut Faults) {
    if text.trim().is_empty() {
        faults.push(pointer, message!("empty_text"));
    }
}

fn optional(
    pointer: &str,
    text: &Option<String>,
    most: usize,
    forbidden: impl Fn(char) -> bool,
    faults: &mut Faults,
) -> Option<String> {
    let text = text.as_ref()?;
    let chars = text.chars().count();
    if chars > most {
        faults.push(pointer, message!("too_many_characters", most, have = chars));
    }
    if let Some(c) = text.chars().find(|&c| forbidden(c)) {
        faults.push(pointer, message!("control_character", character = format_args!("U+{:04X}", c as u32)));
    }
    Some(text.clone())
}

/// `pointer` is written out only for a fault.
pub fn temperature(pointer: impl Display, celsius: Option<f64>, faults: &mut Faults) -> Option<f64> {
    if let Some(t) = celsius
        && !TEMPERATURE_RANGE_C.contains(&t)
    {
        faults.push(pointer.to_string(), message!("temperature_range", value = text(t)));
    }
    celsius
}

/// Three standard deviations, each checked like [`deviation()`].
pub fn deviations(pointer: &str, sd: Option<Triple>, faults: &mut Faults) -> Option<Vector3<f64>> {
    for (axis, value) in sd.iter().flat_map(|sd| sd.0).enumerate() {
        deviation(&format!("{pointer}/{axis}"), Some(value), faults);
    }
    sd.map(Triple::vector)
}

/// A standard deviation; a fault where it is negative or beyond 1e9.
pub fn deviation(pointer: &str, sd: Option<f64>, faults: &mut Faults) -> Option<f64> {
    if let Some(sd) = sd
        && !(0.0..=LARGEST_DEVIATION).contains(&sd)
    {
        faults
            .push(pointer, message!("deviation_range", most = format_args!("{LARGEST_DEVIATION:e}"), value = text(sd)));
    }
    sd
}

/// Three standard deviations, as the description has them.
pub struct Deviations;

impl PartialSchema for Deviations {
    fn schema() -> RefOr<Schema> {
        let deviation =
            ObjectBuilder::new().schema_type(Type::Number).minimum(Some(0.0)).maximum(Some(LARGEST_DEVIATION));
        ArrayBuilder::new().items(deviation).min_items(Some(3)).max_items(Some(3)).into()
    }
}

impl ToSchema for Deviations {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fit_into_addresses_whatever_they_hold() {
        assert_eq!(encoded("LFG-0101_a.b~"), "LFG-0101_a.b~");
        assert_eq!(encoded("a/b?c d&陀"), "a%2Fb%3Fc%20d%26%E9%99%80");
    }
}
