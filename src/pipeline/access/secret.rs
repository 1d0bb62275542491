//! Secrets of tokens and sessions: drawn, written, read, compared.
//!
//! 256 random bits need no slow hash: nobody guesses them, from the hash or without it.

use std::hint::black_box;

use crate::core::id::Id;
use crate::system;

/// A secret with the identifier of what it opens. Written once, to whom it is given; its `Debug` shows nothing.
#[derive(Clone)]
pub struct Secret {
    pub id: Id,
    bits: [u8; 32],
}

impl std::fmt::Debug for Secret {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Secret").field("id", &self.id).finish_non_exhaustive()
    }
}

/// So that tokens are found where they should not be (in logs, in repositories).
const PREFIX: &str = "gyw_";

impl Secret {
    pub fn draw(id: Id) -> Result<Self, rand::rngs::SysError> {
        let mut bits = [0; 32];
        system::fill_random(&mut bits)?;
        Ok(Self { id, bits })
    }

    /// `gyw_`, the identifier, `_`, 64 hexadecimal digits.
    pub fn reveal(&self) -> String {
        format!("{PREFIX}{}_{}", self.id, hex::encode(self.bits))
    }

    /// None for what was never written by [`Secret::reveal`].
    pub fn read(text: &str) -> Option<Self> {
        let (id, digits) = text.strip_prefix(PREFIX)?.split_once('_')?;
        let mut bits = [0; 32];
        hex::decode_to_slice(digits, &mut bits).ok()?;
        Some(Self { id: id.parse().ok()?, bits })
    }

    /// What is kept of it.
    pub fn sha256(&self) -> [u8; 32] {
        system::sha256(&self.bits)
    }

    /// Whether it is the one whose hash was kept; takes as long whether it is or not. `None` compares with nothing
    /// and is never it.
    pub fn is(&self, kept: Option<&[u8; 32]>) -> bool {
        let mine = self.sha256();
        let theirs = kept.copied().unwrap_or_default();
        let apart = mine.iter().zip(&theirs).fold(0, |apart, (a, b)| black_box(apart | (a ^ b)));
        (apart == 0) & kept.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_secret_is_known_by_its_text_and_by_nothing_near_it() {
        let secret = Secret::draw(Id(77)).unwrap();
        let text = secret.reveal();
        let read = Secret::read(&text).unwrap();
        assert_eq!(read.id, Id(77));
        assert!(read.is(Some(&secret.sha256())));
        assert!(!read.is(None) && !read.is(Some(&[0; 32])));
        for place in 0..256 {
            let mut other = secret.clone();
            other.bits[place / 8] ^= 1 << (place % 8);
            assert!(!other.is(Some(&secret.sha256())), "bit {place}");
        }
        assert!(!format!("{secret:?}").contains(&text[20..]));
    }

    #[test]
    fn what_was_never_written_here_is_no_secret() {
        let text = Secret::draw(Id(1)).unwrap().reveal();
        for wrong in
            ["", "gyw_", &text[4..], &text[..text.len() - 1], &format!("{text}0"), &text.replace("gyw_", "gyx_")]
        {
            assert!(Secret::read(wrong).is_none(), "{wrong}");
        }
    }

    #[test]
    fn no_two_secrets_are_alike() {
        assert_ne!(Secret::draw(Id(1)).unwrap().reveal(), Secret::draw(Id(1)).unwrap().reveal());
    }
}
