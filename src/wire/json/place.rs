//! What serde says, at the member that it concerns.

use serde_path_to_error::{Path, Segment};

use super::words;
use crate::core::fault::Fault;
use crate::core::message::{Message, Parameter};

/// A JSON pointer's token for one member name (RFC 6901, section 3).
pub fn pointer_token(member: &str) -> String {
    member.replace('~', "~0").replace('/', "~1")
}

pub(super) fn fault_at(path: &Path, error: &serde_json::Error) -> Fault {
    let mut pointer = String::new();
    for segment in path {
        match segment {
            Segment::Seq { index } => pointer.push_str(&format!("/{index}")),
            Segment::Map { key } => pointer.push_str(&format!("/{}", pointer_token(key))),
            Segment::Enum { .. } | Segment::Unknown => {}
        }
    }
    fault(pointer, error)
}

/// serde reports an absent, repeated or unknown member at the object that should or does hold it; the pointer
/// returned here names the member itself.
pub(super) fn fault(mut pointer: String, error: &serde_json::Error) -> Fault {
    let message = said_of(error);
    let within = words::innermost(&message);
    if let Some(Parameter::Text(member)) = within.parameter("member") {
        append_member(&mut pointer, member);
    }
    // Where a member is missing or given twice, its pointer says more than the end of its object.
    let message = match &*within.code {
        "missing_member" | "member_twice" => within.clone(),
        _ => message,
    };
    Fault { pointer, message }
}

/// What is wrong, with line and column where serde knows them.
pub fn said_of(error: &serde_json::Error) -> Message {
    words::said(&error.to_string())
}

fn append_member(pointer: &mut String, member: &str) {
    let token = format!("/{}", pointer_token(member));
    if !pointer.ends_with(&token) {
        pointer.push_str(&token);
    }
}
