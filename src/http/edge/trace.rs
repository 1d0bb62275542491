//! Identifiers of a request: `X-Request-Id`, and `traceparent` of the W3C's Trace Context. Kept where they are sent
//! and sound.

use axum::http::{HeaderMap, HeaderName, HeaderValue};

use crate::system;

pub(super) const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
pub(super) const TRACEPARENT: HeaderName = HeaderName::from_static("traceparent");

/// Longest identifier that is kept.
const MOST: usize = 128;

#[derive(Debug)]
pub(super) struct Trace {
    pub id: String,
    pub parent: String,
}

impl Trace {
    pub fn of(headers: &HeaderMap) -> Self {
        let sent = |name, is_sound: fn(&str) -> bool| {
            let text = headers.get(name).and_then(|value: &HeaderValue| value.to_str().ok());
            text.filter(|text| is_sound(text)).map(str::to_owned)
        };
        let parent = sent(TRACEPARENT, is_parent).unwrap_or_else(drawn);
        // One that nobody has named goes by the trace that it belongs to.
        let id = sent(REQUEST_ID, is_id).unwrap_or_else(|| parent[3..35].to_owned());
        Self { id, parent }
    }
}

pub(super) fn header(text: &str) -> HeaderValue {
    HeaderValue::from_str(text).expect("identifiers are plain ASCII")
}

fn is_id(text: &str) -> bool {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.:/+=".contains(&byte);
    !text.is_empty() && text.len() <= MOST && text.bytes().all(is_plain)
}

/// Version, trace, parent and flags; of later versions more may follow.
fn is_parent(text: &str) -> bool {
    let is_hex = |part: &str, digits: usize| {
        part.len() == digits && part.bytes().all(|byte| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte))
    };
    let is_not_zero = |part: &str| part.bytes().any(|byte| byte != b'0');
    let parts: Vec<&str> = text.split('-').collect();
    let [version, trace, parent, flags, further @ ..] = &parts[..] else { return false };
    let plain = text.len() <= MOST && text.bytes().all(|byte| byte.is_ascii_graphic());
    plain
        && is_hex(version, 2)
        && *version != "ff"
        && (*version != "00" || further.is_empty())
        && (is_hex(trace, 32) && is_not_zero(trace))
        && (is_hex(parent, 16) && is_not_zero(parent))
        && is_hex(flags, 2)
}

fn drawn() -> String {
    let mut bits = [1; 24];
    if let Err(error) = system::fill_random(&mut bits) {
        tracing::warn!(%error, "the operating system gives no random numbers: requests share an identifier");
    }
    let (trace, parent) = bits.split_at(16);
    format!("00-{}-{}-00", hex::encode(trace), hex::encode(parent))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARENT: &str = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";

    fn trace(sent: &[(HeaderName, &str)]) -> Trace {
        Trace::of(&sent.iter().map(|(name, value)| (name.clone(), value.parse().unwrap())).collect())
    }

    #[test]
    fn what_is_sent_is_kept_and_what_is_not_is_made() {
        let kept = trace(&[(REQUEST_ID, "order-17.a:b/c"), (TRACEPARENT, PARENT)]);
        assert_eq!((kept.id.as_str(), kept.parent.as_str()), ("order-17.a:b/c", PARENT));
        let later = format!("01{}-what-comes", &PARENT[2..]);
        assert_eq!(trace(&[(TRACEPARENT, &later)]).parent, later);
        assert_eq!(trace(&[(TRACEPARENT, PARENT)]).id, "4bf92f3577b34da6a3ce929d0e0e4736");
        let (one, other) = (trace(&[]), trace(&[]));
        assert!(is_parent(&one.parent) && one.parent != other.parent && one.id != other.id);
    }

    #[test]
    fn what_is_not_sound_is_replaced() {
        for id in ["", "a b", "x\"", "a,b", &"a".repeat(MOST + 1)] {
            assert_ne!(trace(&[(REQUEST_ID, id)]).id, id);
        }
        for parent in [
            "",
            "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7",
            &PARENT.to_uppercase(),
            &PARENT.replace("4bf92f3577b34da6a3ce929d0e0e4736", &"0".repeat(32)),
            &PARENT.replace("00f067aa0ba902b7", &"0".repeat(16)),
            &format!("ff{}", &PARENT[2..]),
            &format!("{PARENT}-more"),
        ] {
            assert_ne!(trace(&[(TRACEPARENT, parent)]).parent, parent);
        }
    }
}
