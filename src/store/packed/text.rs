//! Long texts, deflated (RFC 1950): campaigns and their diagnoses are five times smaller.

use std::io::Read;

use flate2::Compression;
use flate2::read::{ZlibDecoder, ZlibEncoder};

use crate::store::error::StoreError;

/// Shorter ones are kept as they are, for anybody to read in the database.
const LONG: usize = 2048;
/// No text that was taken in is longer.
const LONGEST: u64 = 1 << 30;

/// What goes into a text column, and what into the one of bytes beside it: one of the two holds the text.
pub(in crate::store) fn pack(text: &str) -> (&str, Option<Vec<u8>>) {
    if text.len() < LONG {
        return (text, None);
    }
    let mut packed = Vec::with_capacity(text.len() / 4);
    match ZlibEncoder::new(text.as_bytes(), Compression::default()).read_to_end(&mut packed) {
        Ok(_) if packed.len() < text.len() => ("", Some(packed)),
        _ => (text, None),
    }
}

/// # Errors
/// [`StoreError::Damaged`] by `what` it is.
pub(in crate::store) fn unpack(
    text: String,
    packed: Option<Vec<u8>>,
    what: impl FnOnce() -> String,
) -> Result<String, StoreError> {
    let Some(packed) = packed else { return Ok(text) };
    let mut text = String::with_capacity(5 * packed.len());
    match ZlibDecoder::new(&packed[..]).take(LONGEST).read_to_string(&mut text) {
        Ok(_) => Ok(text),
        Err(error) => Err(StoreError::damaged(format_args!("{}: its text cannot be unpacked: {error}", what()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_comes_back_word_for_word_and_one_that_is_damaged_is_named() {
        let long: String = (0..500).map(|k| format!("{{\"pulse\": {k}, \"temp\u{e9}rature\": 20.5}}\n")).collect();
        for text in ["", "short", &long] {
            let (plain, packed) = pack(text);
            assert_eq!(packed.is_some(), text.len() >= LONG);
            assert!(packed.as_ref().is_none_or(|packed| plain.is_empty() && 4 * packed.len() < text.len()));
            assert_eq!(unpack(plain.to_owned(), packed, String::new).unwrap(), text);
        }
        let mut damaged = pack(&long).1.unwrap();
        let middle = damaged.len() / 2;
        damaged[middle] ^= 4;
        let found = unpack(String::new(), Some(damaged), || "record 7".to_owned());
        assert!(
            matches!(&found, Err(StoreError::Damaged(why)) if why.to_string().starts_with("record 7: ")),
            "{found:?}"
        );
        let cut = pack(&long).1.unwrap()[..middle].to_vec();
        assert!(unpack(String::new(), Some(cut), String::new).is_err());
    }
}
