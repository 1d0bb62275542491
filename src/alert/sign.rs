//! Signatures after Standard Webhooks 1.0: HMAC-SHA-256 over `id.timestamp.body`.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::core::message::Message;
use crate::core::time::UtcMicros;
use crate::{message, system};

const PREFIX: &str = "whsec_";
/// Lengths of a key in bytes that the specification allows.
const KEY_BYTES: std::ops::RangeInclusive<usize> = 24..=64;

/// A key that signs. It shows itself only when asked for ([`Secret::reveal`]), never in a log.
#[derive(Clone, PartialEq, Eq)]
pub struct Secret(Vec<u8>);

impl std::fmt::Debug for Secret {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Secret(hidden)")
    }
}

impl Secret {
    /// A new key of 32 bytes from the operating system's generator.
    pub fn generate() -> Result<Self, rand::rngs::SysError> {
        let mut key = vec![0; 32];
        system::fill_random(&mut key)?;
        Ok(Self(key))
    }

    /// Reads `whsec_` and the key in base64. The error never repeats the text.
    pub fn parse(text: &str) -> Result<Self, Message> {
        let encoded = text.strip_prefix(PREFIX).ok_or(message!("secret_prefix", prefix = PREFIX))?;
        let key = STANDARD.decode(encoded).map_err(|_| message!("secret_base64", prefix = PREFIX))?;
        if KEY_BYTES.contains(&key.len()) {
            Ok(Self(key))
        } else {
            let (least, most) = (KEY_BYTES.start(), KEY_BYTES.end());
            Err(message!("secret_length", least = *least, most = *most, have = key.len()))
        }
    }

    /// The secret as its owner has to keep it.
    pub fn reveal(&self) -> String {
        format!("{PREFIX}{}", STANDARD.encode(&self.0))
    }

    fn sign(&self, id: &str, timestamp: i64, body: &[u8]) -> String {
        let head = format!("{id}.{timestamp}.");
        format!("v1,{}", STANDARD.encode(system::hmac_sha256(&self.0, &[head.as_bytes(), body])))
    }
}

/// The three headers of a message. While a secret is being replaced both sign, so that the receiver may change over
/// at any time.
pub fn headers(id: &str, now: UtcMicros, body: &[u8], secrets: &[Secret]) -> Vec<(&'static str, String)> {
    let timestamp = now.0.div_euclid(UtcMicros::SECOND);
    let mut headers = vec![("webhook-id", id.to_owned()), ("webhook-timestamp", timestamp.to_string())];
    if !secrets.is_empty() {
        let signatures: Vec<String> = secrets.iter().map(|secret| secret.sign(id, timestamp, body)).collect();
        headers.push(("webhook-signature", signatures.join(" ")));
    }
    headers
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the Standard Webhooks specification's reference libraries.
    #[test]
    fn the_reference_example_is_signed_as_printed() {
        let secret = Secret::parse("whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw").unwrap();
        let body = br#"{"test": 2432232314}"#;
        let signature = secret.sign("msg_p5jXN8AQM9LWM0D4loKWxJek", 1_614_265_330, body);
        assert_eq!(signature, "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=");
    }

    #[test]
    fn a_secret_is_read_back_from_what_was_revealed_and_hides_from_logs() {
        let secret = Secret::generate().unwrap();
        assert_eq!(Secret::parse(&secret.reveal()).unwrap(), secret);
        assert_eq!(format!("{secret:?}"), "Secret(hidden)");
    }

    #[test]
    fn short_long_and_unreadable_secrets_are_refused_without_repeating_them() {
        let of_bytes = |n| format!("whsec_{}", STANDARD.encode(vec![7; n]));
        for (text, log) in [
            (of_bytes(23), "secret_length (least: 24, most: 64, have: 23)"),
            (of_bytes(65), "secret_length (least: 24, most: 64, have: 65)"),
            ("hunter2hunter2hunter2hunter2hunter2".into(), "secret_prefix (prefix: whsec_)"),
            ("whsec_hunter2!hunter2!hunter2!hunter2!".into(), "secret_base64 (prefix: whsec_)"),
        ] {
            assert_eq!(Secret::parse(&text).unwrap_err().to_string(), log);
        }
        assert!(Secret::parse(&of_bytes(24)).is_ok() && Secret::parse(&of_bytes(64)).is_ok());
    }
}
