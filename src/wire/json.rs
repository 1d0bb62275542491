//! Reading JSON so that a fault names its place, and writing what is sure to be JSON.

mod lines;
mod not_json;
mod place;
mod several;
mod words;

use crate::wire::prelude::*;
use serde::Deserializer;
use serde::de::{DeserializeOwned, Error as _, IgnoredAny, MapAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt::{self, Formatter};
use std::marker::PhantomData;

pub use lines::{from_line, on_a_line};
use place::{fault, fault_at};
pub use place::{pointer_token, said_of};
pub(super) use words::said;

/// What the service has made or read itself: texts, finite numbers and members with names.
pub fn written(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("texts and finite numbers can be written as JSON")
}

/// Reads one JSON document. The error holds what is wrong with its form: of a short document every fault that can be
/// found by reading on past the first, of a long one the first.
///
/// Every document is an object. A leading byte-order mark is skipped, as RFC 8259 (section 8.1) allows.
/// The document is read without tracking places first, because almost all are good; only a refused one is read
/// again to name the place.
pub fn parse<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Faults> {
    let bytes = without_mark(bytes);
    if without_blanks_after(bytes).is_empty() {
        return Err(message!("file_is_empty").into());
    }
    if bytes.trim_ascii_start().starts_with(b"[") && is_json(bytes) {
        // serde would take the list for the members in their order.
        let (found, expected) = (message!("json_array"), message!("json_object"));
        return Err(message!("invalid_type", found, expected).into());
    }
    // Letters are looked at once for the whole document, which takes a fifth less than once a string.
    let read = std::str::from_utf8(bytes).ok().and_then(|text| serde_json::from_str(text).ok());
    // What is cut short ends where its text does, not on the empty line after it.
    let text = without_blanks_after(bytes);
    read.map_or_else(|| parse_naming_places(text), Ok).map_err(|(fault, place)| match is_json(text) {
        true => several::faults::<T>(text, fault),
        false => not_json::why(text, fault, place).into(),
    })
}

/// As [`parse`], and `read`: what it finds is named beside unknown members, where nothing else is wrong with the form.
pub fn parse_and_read<T: DeserializeOwned, R>(
    bytes: &[u8],
    read: impl Fn(&T) -> Result<R, Faults>,
) -> Result<R, Faults> {
    parse(bytes).and_then(|body| read(&body)).map_err(|mut faults| {
        let rest = several::without_unknown::<T>(without_mark(bytes), &faults);
        faults.0.extend(rest.and_then(|body| read(&body).err()).map_or_else(Vec::new, |more| more.0));
        faults
    })
}

/// The fault comes with the line and column at which reading has stopped.
fn parse_naming_places<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, (Fault, (usize, usize))> {
    let stopped = |fault, error: &serde_json::Error| (fault, (error.line(), error.column()));
    let mut reader = serde_json::Deserializer::from_slice(bytes);
    let value = serde_path_to_error::deserialize(&mut reader)
        .map_err(|error| stopped(fault_at(error.path(), error.inner()), error.inner()))?;
    reader.end().map_err(|error| stopped(fault(String::new(), &error), &error))?;
    Ok(value)
}

/// Whether `bytes` are JSON at all, whatever they say: what tells a 400 from a 422.
pub fn is_json(bytes: &[u8]) -> bool {
    let bytes = without_mark(bytes);
    std::str::from_utf8(bytes).is_ok() && serde_json::from_slice::<IgnoredAny>(bytes).is_ok()
}

/// Without the blanks at the end that JSON knows: what else counts as one is a fault.
fn without_blanks_after(bytes: &[u8]) -> &[u8] {
    let last = bytes.iter().rposition(|byte| !b" \t\r\n".contains(byte));
    &bytes[..last.map_or(0, |last| last + 1)]
}

pub(crate) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Tells `null` from left out.
pub fn present<'de, T: Deserialize<'de>, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Option<T>>, D::Error> {
    Option::deserialize(deserializer).map(Some)
}

/// Reads members of any names, each of which may be given once, as those of documents with set names.
pub fn each_once<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<BTreeMap<String, T>, D::Error> {
    struct EachOnce<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for EachOnce<T> {
        type Value = BTreeMap<String, T>;

        fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
            f.write_str("a map")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<Self::Value, A::Error> {
            let mut read = BTreeMap::new();
            while let Some(name) = members.next_key::<String>()? {
                if read.contains_key(&name) {
                    return Err(A::Error::custom(format_args!("duplicate field `{name}`")));
                }
                read.insert(name, members.next_value()?);
            }
            Ok(read)
        }
    }

    deserializer.deserialize_map(EachOnce(PhantomData))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Outer {
        #[expect(dead_code, reason = "only the reading of it is looked at")]
        list: Vec<Inner>,
    }
    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Inner {
        #[expect(dead_code, reason = "only the reading of it is looked at")]
        x: f64,
    }

    fn refused(text: &str) -> (String, String) {
        let fault = parse::<Outer>(text.as_bytes()).unwrap_err().0.remove(0);
        (fault.pointer, Language::English.words(&fault.message))
    }

    #[test]
    fn a_fault_is_named_at_the_member_that_causes_it() {
        assert_eq!(refused(r#"{"list":[{"x":1},{}]}"#), ("/list/1/x".into(), "`x` is missing".into()));
        assert_eq!(refused(r#"{"list":[{"x":1,"x":2}]}"#), ("/list/0/x".into(), "`x` is given twice".into()));
        let (pointer, detail) = refused(r#"{"list":[{"x":1,"a/b":2}]}"#);
        assert_eq!(pointer, "/list/0/a~1b");
        assert!(detail.contains("unknown member `a/b`"), "{detail}");
        assert_eq!(refused(r#"{"list":[{"x":"1"}]}"#).0, "/list/0/x");
        assert_eq!(refused(r#"{"list":[{"x":1e400}]}"#).0, "/list/0/x");
        assert_eq!(refused(r#"{"list":[]} {}"#).0, "");
    }

    #[test]
    fn no_word_of_the_programs_own_types_reaches_a_sender() {
        for text in ["[]", "3", "null", "\"x\"", r#"{"list":{}}"#, r#"{"list":[[]]}"#, r#"{"list":[{"x":[]}]}"#] {
            let (pointer, detail) = refused(text);
            for word in ["struct", "Outer", "Inner", "f64", "enum", "element"] {
                assert!(!detail.contains(word), "{text}: {pointer}: {detail}");
            }
        }
        assert_eq!(refused("3").1, "must be an object, is the integer 3 at line 1 column 1");
        assert_eq!(refused(r#"{"list":[[]]}"#).0, "/list/0");
    }

    #[test]
    fn what_is_not_json_is_told_where_it_ceases_to_be_and_nothing_of_what_it_says_before() {
        for (text, pointer, detail) in [
            (r#"{"list":[{"x":NaN}]}"#, "/list/0/x", "not JSON: expected a value at line 1 column 15"),
            (r#"{"colour":1,"list":NaN}"#, "", "not JSON: expected a value at line 1 column 20"),
            (r#"{"colour":1} x"#, "", "not JSON: trailing characters at line 1 column 14"),
            (r#"{"list":[{"x":1e400}]"#, "", "not JSON: it ends within an object at line 1 column 21"),
            ("{\"list\":[]\n", "", "not JSON: it ends within an object at line 1 column 10"),
        ] {
            assert_eq!(refused(text), (pointer.into(), detail.into()), "{text}");
        }
        for text in ["{\"list\":[]}\n{\"list\":[]}", "{\"colour\":1}\n{\"list\":"] {
            let (pointer, detail) = refused(text);
            assert_eq!(pointer, "");
            assert!(detail.starts_with("several JSON documents, but only one is accepted here"), "{detail}");
            assert!(detail.ends_with("the second begins at line 2 column 1"), "{detail}");
        }
    }

    #[test]
    fn json_is_told_from_what_is_not_json() {
        assert!(is_json(b"[1e999]"));
        assert!(is_json(b"\xef\xbb\xbf{}"));
        assert!(!is_json(b"{\"x\": NaN}"));
        assert!(!is_json(b"{\"x\": 1"));
        assert!(!is_json(b"{\"x\": \"\xff\"}"));
    }
}
