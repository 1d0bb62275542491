//! Identifiers of stored items: 63 bits that ascend in order of storing, written as 13 characters that sort alike.

use std::fmt;
use std::str::FromStr;

/// 42 bits of milliseconds since 1970, then 21 bits that keep items of one millisecond apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id(pub i64);

/// Crockford's base 32: no I, L, O, U, so that an identifier can be read aloud.
const DIGITS: &[u8; 32] = b"0123456789abcdefghjkmnpqrstvwxyz";
const LENGTH: usize = 13;

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = [0; LENGTH];
        for (i, place) in text.iter_mut().rev().enumerate() {
            *place = DIGITS[(self.0 >> (5 * i)) as usize & 31];
        }
        f.write_str(std::str::from_utf8(&text).expect("the digits are ASCII"))
    }
}

/// The text is no identifier of this service.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("an identifier is {LENGTH} characters of 0-9 and a-z without i, l, o, u")]
pub struct NotAnId;

impl FromStr for Id {
    type Err = NotAnId;

    fn from_str(text: &str) -> Result<Self, NotAnId> {
        if text.len() != LENGTH {
            return Err(NotAnId);
        }
        let mut value: u128 = 0;
        for byte in text.bytes() {
            let digit = DIGITS.iter().position(|&d| d == byte.to_ascii_lowercase()).ok_or(NotAnId)?;
            value = value << 5 | digit as u128;
        }
        i64::try_from(value).map(Id).map_err(|_| NotAnId)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_number_sort_alike_and_turn_into_one_another() {
        let ids = [0, 1, 31, 32, 1 << 40, 3_734_526_000_000_000_123, i64::MAX].map(Id);
        let texts = ids.map(|id| id.to_string());
        assert!(texts.is_sorted());
        assert_eq!(texts.clone().map(|text| text.parse::<Id>().unwrap()), ids);
        assert_eq!(texts[0], "0000000000000");
    }

    #[test]
    fn what_is_no_identifier_is_refused() {
        for text in ["", "000000000000", "00000000000000", "000000000000l", "zzzzzzzzzzzzz", "é00000000000"] {
            assert_eq!(text.parse::<Id>(), Err(NotAnId), "{text}");
        }
    }
}
