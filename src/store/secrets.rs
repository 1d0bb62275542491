//! What hooks are told with and must not be read in a backup: addresses (some hold a token), authorizations, signing
//! secrets. With a key (GYROWATCH_SECRETS_KEY) they are stored encrypted, bound to their hook and column; without one
//! as they are.

use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::{STANDARD, STANDARD_NO_PAD, URL_SAFE, URL_SAFE_NO_PAD};
use ring::aead::{Aad, CHACHA20_POLY1305, LessSafeKey, NONCE_LEN, Nonce, UnboundKey};

use super::error::{Result, StoreError};
use crate::message;
use crate::system::fill_random;

/// Before an encrypted text, and with a character that no text of a hook may have. The number is that of the way it
/// is encrypted.
const MARK: &str = "\u{1}encrypted:1:";

/// The key, or none.
#[derive(Clone, Default)]
pub struct Secrets(Option<Arc<LessSafeKey>>);

impl std::fmt::Debug for Secrets {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if self.0.is_some() { "Secrets(a key)" } else { "Secrets(no key)" })
    }
}

impl Secrets {
    /// With a key of 32 bytes in hexadecimal or base64; with none where it is empty. None where it is neither.
    pub fn with_key(text: &str) -> Option<Self> {
        if text.trim().is_empty() {
            return Some(Self::default());
        }
        let text = text.trim();
        let bases = [STANDARD, STANDARD_NO_PAD, URL_SAFE, URL_SAFE_NO_PAD];
        let read = hex::decode(text).ok().or_else(|| bases.iter().find_map(|base| base.decode(text).ok()))?;
        let key = UnboundKey::new(&CHACHA20_POLY1305, &read).ok()?;
        Some(Self(Some(Arc::new(LessSafeKey::new(key)))))
    }

    /// Encrypts what is not encrypted yet of texts, each with where it stands: what strays to another place cannot be
    /// decrypted there. Says whether there was any.
    pub fn hide<'a>(&self, texts: impl Iterator<Item = (String, &'a mut String)>) -> Result<bool> {
        let Some(key) = &self.0 else { return Ok(false) };
        let mut any = false;
        for (place, text) in texts.filter(|(_, text)| !text.starts_with(MARK)) {
            let mut nonce = [0; NONCE_LEN];
            fill_random(&mut nonce).map_err(StoreError::other)?;
            let mut bytes = text.as_bytes().to_vec();
            key.seal_in_place_append_tag(Nonce::assume_unique_for_key(nonce), Aad::from(place), &mut bytes)
                .map_err(|_| StoreError::other("a secret cannot be encrypted"))?;
            *text = format!("{MARK}{}", STANDARD.encode([&nonce[..], &bytes].concat()));
            any = true;
        }
        Ok(any)
    }

    /// Decrypts the texts of what is `named` so, which stand where they were encrypted.
    ///
    /// # Errors
    /// [`StoreError::Key`] where something is encrypted, and not with this key.
    pub fn show<'a>(&self, named: &str, texts: impl Iterator<Item = (String, &'a mut String)>) -> Result<()> {
        for (place, text) in texts {
            let Some(hidden) = text.strip_prefix(MARK) else { continue };
            let Some(key) = &self.0 else {
                return Err(StoreError::Key(message!("secrets_key_missing", of = named.to_owned())));
            };
            let other = || StoreError::Key(message!("secrets_key_other", of = named.to_owned()));
            *text = shown(key, place, hidden).ok_or_else(other)?;
        }
        Ok(())
    }
}

fn shown(key: &LessSafeKey, place: String, hidden: &str) -> Option<String> {
    let bytes = STANDARD.decode(hidden).ok()?;
    let (nonce, hidden) = bytes.split_first_chunk()?;
    let mut hidden = hidden.to_vec();
    let shown = key.open_in_place(Nonce::assume_unique_for_key(*nonce), Aad::from(place), &mut hidden).ok()?;
    String::from_utf8(shown.to_vec()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::id::Id;
    use crate::store::tables::delivery_tests;
    use crate::store::tables::hook::HookRow;

    fn hook() -> HookRow {
        let (url, authorization) = ("https://example.org/token".into(), Some("Bearer abc".into()));
        HookRow { url, authorization, ..delivery_tests::hook(Id(7)) }
    }

    #[test]
    fn what_is_secret_is_hidden_and_comes_back_with_the_key_alone() {
        let key = |byte: u8| Secrets::with_key(&hex::encode([byte; 32])).unwrap();
        let mut hidden = hook();
        assert!(key(1).hide(hidden.secret_texts()).unwrap());
        let texts: Vec<String> = hidden.secret_texts().map(|(_, text)| text.clone()).collect();
        assert!(texts.len() == 4 && texts.iter().all(|text| text.starts_with(MARK)), "{texts:?}");
        assert!(!key(1).hide(hidden.secret_texts()).unwrap(), "once is enough");
        for other in [key(2), Secrets::default()] {
            assert!(matches!(other.show("", hidden.clone().secret_texts()), Err(StoreError::Key(_))));
        }
        let mut elsewhere = HookRow { id: Id(8), ..hidden.clone() };
        assert!(key(1).show("", elsewhere.secret_texts()).is_err(), "of another hook");
        key(1).show("", hidden.secret_texts()).unwrap();
        assert!(hidden == hook());
    }

    #[test]
    fn without_a_key_everything_stays_as_it_is() {
        let mut plain = hook();
        assert!(!Secrets::default().hide(plain.secret_texts()).unwrap());
        Secrets::default().show("", plain.secret_texts()).unwrap();
        assert!(plain == hook());
    }

    #[test]
    fn a_key_is_32_bytes_in_hexadecimal_or_base64() {
        let key = [0xfb; 32];
        for text in [hex::encode(key), STANDARD.encode(key), URL_SAFE_NO_PAD.encode(key), String::new()] {
            assert!(Secrets::with_key(&text).is_some(), "{text}");
        }
        for text in ["short", &hex::encode([1; 31]), &STANDARD.encode([1; 33])] {
            assert!(Secrets::with_key(text).is_none(), "{text}");
        }
    }
}
