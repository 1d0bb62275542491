//! Where the next page of a list begins, as text that means nothing to clients.

use base64::Engine;
use base64::prelude::BASE64_URL_SAFE_NO_PAD;

const VERSION: u8 = 1;

/// The cursor of a position.
pub fn encode(position: i64) -> String {
    let mut bytes = [0; 9];
    bytes[0] = VERSION;
    bytes[1..].copy_from_slice(&position.to_be_bytes());
    BASE64_URL_SAFE_NO_PAD.encode(bytes)
}

/// The position of a cursor; none where [`encode`] cannot have made it.
pub fn decode(cursor: &str) -> Option<i64> {
    let bytes = BASE64_URL_SAFE_NO_PAD.decode(cursor).ok()?;
    match bytes.split_first() {
        Some((&VERSION, position)) => position.try_into().ok().map(i64::from_be_bytes),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cursor_comes_back_and_a_made_up_one_is_refused() {
        for at in [0, -1, 1_772_352_000_000_000, i64::MAX, i64::MIN] {
            assert_eq!(decode(&encode(at)), Some(at));
        }
        for made_up in ["", "x", "AAAA", "AgAAAAAAAAAA", "????"] {
            assert_eq!(decode(made_up), None, "{made_up}");
        }
    }
}
