//! What axum says of a query or a form that it cannot read, in words of ours.

use crate::core::message::{Message, text};
use crate::message;

/// `said`: as the rejection of an extractor says it.
pub fn in_words(said: &str) -> Message {
    let what = said.split_once(": ").filter(|(begins, _)| begins.starts_with("Failed to deserialize"));
    let what = what.map_or(said, |(_, what)| what);
    let quoted = |before: &str| Some(text(what.split_once(before)?.1.split('`').next()?));
    if let Some(parameter) = quoted("duplicate field `") {
        return message!("parameter_twice", parameter);
    }
    if let Some(parameter) = quoted("missing field `") {
        return message!("parameter_missing", parameter);
    }
    match what.split_once(": ") {
        Some((parameter, why)) if why.contains("digit") || why.contains("number too") || why.contains("integer") => {
            message!("parameter_whole", parameter = text(parameter))
        }
        Some((parameter, why)) if why.contains("float") => message!("parameter_number", parameter = text(parameter)),
        Some((parameter, why)) if why.contains("`true`") => message!("parameter_flag", parameter = text(parameter)),
        _ if said.starts_with("Failed to deserialize form") || said.starts_with("Form ") => message!("form_unreadable"),
        _ => message!("query_unreadable"),
    }
}
