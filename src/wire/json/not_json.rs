//! What is wrong with bytes that are not one JSON document.

use serde::de::IgnoredAny;

use super::place::fault;
use super::words;
use crate::core::fault::Fault;
use crate::message;

/// Reading it as what it should be has stopped at `found`, on this line and column. What a document says before the
/// place where it ceases to be JSON is not what is wrong with it, and is not told.
pub(super) fn why(bytes: &[u8], found: Fault, place: (usize, usize)) -> Fault {
    if let Err(error) = std::str::from_utf8(bytes) {
        // serde passes over the letters of members that it does not know.
        let is_of_letters = words::innermost(&found.message).code == "json_invalid_code_point";
        let pointer = if is_of_letters { found.pointer } else { String::new() };
        return Fault { pointer, message: message!("not_utf8_from", byte = error.valid_up_to()) };
    }
    let Err(error) = serde_json::from_slice::<IgnoredAny>(bytes) else { return found };
    let stopped_there = (error.line(), error.column()) == place;
    let fault = if stopped_there { found } else { fault(String::new(), &error) };
    let message = match second_document(bytes) {
        Some((line, column)) => {
            message!("several_documents", place = message!("line_and_column", line, column))
        }
        None => message!("not_json", why = fault.message),
    };
    Fault { message, pointer: fault.pointer }
}

/// Line and column, from 1, of the object that follows the first document.
fn second_document(bytes: &[u8]) -> Option<(usize, usize)> {
    let mut documents = serde_json::Deserializer::from_slice(bytes).into_iter::<IgnoredAny>();
    documents.next()?.ok()?;
    let rest = bytes[documents.byte_offset()..].trim_ascii_start();
    let before = &bytes[..bytes.len() - rest.len()];
    let line = memchr::memchr_iter(b'\n', before).count() + 1;
    let column = before.len() - memchr::memrchr(b'\n', before).map_or(0, |end| end + 1) + 1;
    rest.starts_with(b"{").then_some((line, column))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_document_is_found_where_it_begins() {
        for (text, place) in [
            ("{\"a\":1}{\"b\":2}", Some((1, 8))),
            ("{\"a\":1}\r\n\n  {\"b\"", Some((3, 3))),
            ("{\"a\":1}", None),
            ("{\"a\":1} x", None),
            ("{\"a\":{}{}", None),
            ("", None),
        ] {
            assert_eq!(second_document(text.as_bytes()), place, "{text}");
        }
    }
}
