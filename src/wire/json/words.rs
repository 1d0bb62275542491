//! What serde says of a document's form, without the names of this program's types.

/// A message as a sender can read it: JSON's words for JSON's things.
pub(super) fn plain(message: &str) -> String {
    let (what, place) = match message.rsplit_once(" at line ") {
        Some((what, place)) => (what, format!(" at line {place}")),
        None => (message, String::new()),
    };
    let Some((found, expected)) = what.split_once(", expected ") else { return message.to_owned() };
    // An object given as the list of its members is short of them: what is wrong is that it is a list.
    let found = match found.strip_prefix("invalid length ") {
        Some(_) if is_structure(expected) => "invalid type: sequence",
        _ => found,
    };
    let found = found
        .replace("invalid type: map", "invalid type: an object")
        .replace("invalid type: sequence", "invalid type: an array");
    format!("{found}, expected {}{place}", of_json(expected))
}

fn is_structure(expected: &str) -> bool {
    ["struct ", "internally tagged enum "].iter().any(|start| expected.starts_with(start))
}

/// What JSON calls a type of Rust.
fn of_json(expected: &str) -> &str {
    match expected {
        "f64" | "f32" => "a number",
        "u64" | "u32" | "u16" | "u8" | "usize" => "a whole number, not negative",
        "i64" | "i32" | "isize" => "a whole number",
        "map" | "a map" => "an object",
        "a sequence" => "an array",
        "string or map" | "variant identifier" => "a string",
        _ if is_structure(expected) => "an object",
        _ if expected.starts_with("enum ") => "a string",
        _ if expected.starts_with("tuple ") || expected.starts_with("a tuple ") => "an array",
        _ => expected,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_of_the_program_are_said_in_words_of_json() {
        for (message, plain_words) in [
            (
                "invalid length 0, expected struct RecordBody with 9 elements",
                "invalid type: an array, expected an object",
            ),
            (
                "invalid type: string \"1\", expected f64 at line 1 column 7",
                "invalid type: string \"1\", expected a number at line 1 column 7",
            ),
            ("invalid type: map, expected a sequence", "invalid type: an object, expected an array"),
            ("invalid length 2, expected an array of 3 numbers", "invalid length 2, expected an array of 3 numbers"),
            (
                "invalid value: integer `-1`, expected usize",
                "invalid value: integer `-1`, expected a whole number, not negative",
            ),
            ("expected value at line 1 column 1", "expected value at line 1 column 1"),
            ("unknown variant `G4`, expected one of `G1`, `G2`", "unknown variant `G4`, expected one of `G1`, `G2`"),
        ] {
            assert_eq!(plain(message), plain_words);
        }
    }
}
