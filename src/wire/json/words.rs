//! What serde says of a document's form, as messages without the names of this program's types.

use crate::core::message::{Message, list};
use crate::message;

/// What an error of serde says. Its own words get no further than the log, but for those that nobody foresaw.
pub fn said(text: &str) -> Message {
    let Some((what, place)) = text.rsplit_once(" at line ") else { return of_form(text) };
    let place =
        place.split_once(" column ").and_then(|(line, column)| Some((line.parse().ok()?, column.parse().ok()?)));
    let Some((line, column)): Option<(u64, u64)> = place else { return of_form(text) };
    message!("at_place", fault = of_form(what), place = message!("line_and_column", line, column))
}

/// The fault itself where it is told with its place in the text.
pub(super) fn innermost(message: &Message) -> &Message {
    match message.parameter("fault") {
        Some(crate::core::message::Parameter::Message(fault)) if message.code == "at_place" => innermost(fault),
        _ => message,
    }
}

fn of_form(what: &str) -> Message {
    if let Some(message) = of_members(what) {
        return message;
    }
    let Some((found, expected)) = what.split_once(", expected ") else { return of_syntax(what) };
    let (found, value) = (found.to_owned(), expected);
    // An object given as the list of its members is short of them: what is wrong is that it is a list.
    if found.starts_with("invalid length ") && is_structure(value) {
        return message!("invalid_type", found = message!("json_array"), expected = kind(value));
    }
    if let Some(have) = found.strip_prefix("invalid length ").and_then(|have| have.parse::<u64>().ok()) {
        return message!("invalid_length", have, expected = kind(value));
    }
    if let Some(found) = found.strip_prefix("invalid type: ") {
        return message!("invalid_type", found = of_json(found), expected = kind(value));
    }
    if let Some(found) = found.strip_prefix("invalid value: ") {
        return message!("invalid_value", found = of_json(found), expected = kind(value));
    }
    Message::verbatim(what)
}

/// Members and values by name.
fn of_members(what: &str) -> Option<Message> {
    let mut quoted = what.split('`').skip(1).step_by(2).map(str::to_owned);
    let starts = |start: &str| what.starts_with(start);
    if starts("missing field `") {
        return Some(message!("missing_member", member = quoted.next()?));
    }
    if starts("duplicate field `") {
        return Some(message!("member_twice", member = quoted.next()?));
    }
    if starts("unknown field `") {
        let member = quoted.next()?;
        let known: Vec<String> = quoted.collect();
        return Some(match known.is_empty() {
            true => message!("no_members_here", member),
            false => message!("unknown_member", member, known = list(known)),
        });
    }
    let value = if starts("unknown variant `") { quoted.next()? } else { return None };
    Some(message!("unknown_value", value, known = list(quoted)))
}

/// Where a document ceases to be JSON.
fn of_syntax(what: &str) -> Message {
    match what {
        "EOF while parsing a value" => message!("json_ends_early", within = message!("json_value")),
        "EOF while parsing an object" => message!("json_ends_early", within = message!("json_object")),
        "EOF while parsing a list" => message!("json_ends_early", within = message!("json_array")),
        "EOF while parsing a string" => message!("json_ends_early", within = message!("json_a_string")),
        "expected value" => message!("json_expected_value"),
        "expected ident" => message!("json_expected_ident"),
        "expected `:`" => message!("json_expected_colon"),
        "expected `,` or `}`" => message!("json_expected_comma_or_brace"),
        "expected `,` or `]`" => message!("json_expected_comma_or_bracket"),
        "key must be a string" => message!("json_key_not_string"),
        "trailing characters" => message!("json_trailing_characters"),
        "trailing comma" => message!("json_trailing_comma"),
        "invalid number" => message!("json_invalid_number"),
        "number out of range" => message!("json_number_out_of_range"),
        "invalid escape" => message!("json_invalid_escape"),
        "unexpected end of hex escape" => message!("json_escape_ends_early"),
        "lone leading surrogate in hex escape" => message!("json_lone_surrogate"),
        "invalid unicode code point" => message!("json_invalid_code_point"),
        "control character (\\u0000-\\u001F) found while parsing a string" => message!("json_control_character"),
        "recursion limit exceeded" => message!("json_too_deep"),
        other => Message::verbatim(other),
    }
}

fn is_structure(expected: &str) -> bool {
    ["struct ", "internally tagged enum "].iter().any(|start| expected.starts_with(start))
}

fn of_json(found: &str) -> Message {
    let value = |opening: &str| found.strip_prefix(opening).map(|value| value.trim_matches('`').to_owned());
    if let Some(value) = value("string ") {
        return message!("json_string", value);
    }
    if let Some(value) = value("integer ") {
        return message!("json_integer", value);
    }
    if let Some(value) = value("floating point ") {
        return message!("json_number", value);
    }
    if let Some(value) = value("boolean ") {
        return message!("json_boolean", value);
    }
    match found {
        "map" => message!("json_object"),
        "sequence" => message!("json_array"),
        "null" => message!("json_null"),
        other => Message::verbatim(other),
    }
}

/// What JSON calls a type of Rust.
fn kind(expected: &str) -> Message {
    match expected {
        "f64" | "f32" => message!("json_a_number"),
        "u64" | "u32" | "u16" | "u8" | "usize" => message!("json_a_count"),
        "i64" | "i32" | "isize" => message!("json_an_integer"),
        "map" | "a map" => message!("json_object"),
        "a sequence" => message!("json_array"),
        "a boolean" => message!("json_a_boolean"),
        "a string" | "string or map" | "variant identifier" => message!("json_a_string"),
        "a list of numbers" => message!("json_numbers"),
        "an array of 3 numbers" => message!("json_three_numbers"),
        "\"skewed\", \"orthogonal\" or an object with the axes of each slot" => message!("json_geometry"),
        _ if is_structure(expected) => message!("json_object"),
        _ if expected.starts_with("enum ") => message!("json_a_string"),
        _ if expected.starts_with("tuple ") || expected.starts_with("a tuple ") => message!("json_array"),
        _ => Message::verbatim(expected),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn serdes_words_become_messages_of_json() {
        for (text, log) in [
            (
                "invalid length 0, expected struct RecordBody with 9 elements",
                "invalid_type (found: json_array, expected: json_object)",
            ),
            (
                "invalid type: string \"1\", expected f64 at line 1 column 7",
                "at_place (fault: invalid_type (found: json_string (value: \"1\"), expected: json_a_number), place: line_and_column (line: 1, column: 7))",
            ),
            ("invalid type: map, expected a sequence", "invalid_type (found: json_object, expected: json_array)"),
            (
                "invalid length 2, expected an array of 3 numbers",
                "invalid_length (have: 2, expected: json_three_numbers)",
            ),
            (
                "invalid value: integer `-1`, expected usize",
                "invalid_value (found: json_integer (value: -1), expected: json_a_count)",
            ),
            (
                "expected value at line 1 column 1",
                "at_place (fault: json_expected_value, place: line_and_column (line: 1, column: 1))",
            ),
            ("unknown variant `G4`, expected one of `G1`, `G2`", "unknown_value (value: G4, known: G1, G2)"),
            ("unknown field `x`, there are no fields", "no_members_here (member: x)"),
            (
                "missing field `imu` at line 1 column 2",
                "at_place (fault: missing_member (member: imu), place: line_and_column (line: 1, column: 2))",
            ),
        ] {
            assert_eq!(said(text).to_string(), log);
        }
    }
}
