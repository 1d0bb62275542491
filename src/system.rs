//! The only place that asks the world outside: the clock, random numbers, the network client, the cryptography.
//!
//! `clippy.toml` bans the same calls everywhere else, so that tests can put a clock of their own in, every draw is
//! seeded or meant to be secret, and no HTTP client follows redirects or proxies by accident.
#![expect(clippy::disallowed_methods, reason = "this is the one place that the bans point to")]

use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::Duration;

use crate::core::time::UtcMicros;

/// Wall-clock time, or a clock that a test moves by hand. Only for instants that people see: durations are measured
/// with `std::time::Instant`, which no clock change moves.
#[derive(Debug, Clone, Default)]
pub enum Clock {
    #[default]
    System,
    Manual(Arc<AtomicI64>),
}

impl Clock {
    /// A clock that stands at `now` until [`Clock::set`] moves it.
    pub fn manual(now: UtcMicros) -> Self {
        Self::Manual(Arc::new(AtomicI64::new(now.0)))
    }

    /// The system's time, or what a manual clock was set to.
    pub fn now(&self) -> UtcMicros {
        match self {
            Self::System => UtcMicros(jiff::Timestamp::now().as_microsecond()),
            Self::Manual(micros) => UtcMicros(micros.load(Ordering::SeqCst)),
        }
    }

    /// Moves a manual clock; the system's clock is not ours to set, and stays.
    pub fn set(&self, now: UtcMicros) {
        if let Self::Manual(micros) = self {
            micros.store(now.0, Ordering::SeqCst);
        }
    }
}

/// Fills `bytes` from the operating system's generator: for secrets and identifiers that must not be guessed.
/// Reproducible draws take a seeded ChaCha8 generator instead.
pub fn fill_random(bytes: &mut [u8]) -> Result<(), rand::rngs::SysError> {
    use rand::TryRng;
    rand::rngs::SysRng.try_fill_bytes(bytes)
}

pub fn sha256(bytes: &[u8]) -> [u8; 32] {
    let digest = ring::digest::digest(&ring::digest::SHA256, bytes);
    digest.as_ref().try_into().expect("SHA-256 has 32 bytes")
}

/// HMAC-SHA-256 under `key` of `parts` one after the other.
pub fn hmac_sha256(key: &[u8], parts: &[&[u8]]) -> [u8; 32] {
    let key = ring::hmac::Key::new(ring::hmac::HMAC_SHA256, key);
    let mut context = ring::hmac::Context::with_key(&key);
    parts.iter().for_each(|part| context.update(part));
    context.sign().as_ref().try_into().expect("HMAC-SHA-256 has 32 bytes")
}

/// An HTTP client that follows no redirect, uses no proxy from the environment and gives up in time.
pub fn http_client(connect_timeout: Duration, timeout: Duration) -> reqwest::ClientBuilder {
    base_client(connect_timeout, timeout).no_proxy()
}

fn base_client(connect_timeout: Duration, timeout: Duration) -> reqwest::ClientBuilder {
    reqwest::Client::builder()
        .redirect(reqwest::redirect::Policy::none())
        .connect_timeout(connect_timeout)
        .timeout(timeout)
        .user_agent(concat!("gyrowatch/", env!("CARGO_PKG_VERSION")))
}

/// The version, and the commit it was built from where the build knows it (`build.rs`).
pub fn version() -> &'static str {
    static VERSION: LazyLock<String> = LazyLock::new(|| match option_env!("GYROWATCH_COMMIT") {
        Some(commit) => format!("{} ({commit})", env!("CARGO_PKG_VERSION")),
        None => env!("CARGO_PKG_VERSION").to_owned(),
    });
    &VERSION
}

/// By way of which proxies hooks are told.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Proxies {
    #[default]
    None,
    /// One for all targets, `http://host:port`.
    One(String),
    /// What HTTPS_PROXY, HTTP_PROXY, ALL_PROXY and NO_PROXY say.
    Environment,
}

impl Proxies {
    /// Nothing, `environment`, or the address of one; none where it is none of these.
    pub fn parse(text: &str) -> Option<Self> {
        let is_address = |url: url::Url| matches!(url.scheme(), "http" | "https") && url.host().is_some();
        match text {
            "" => Some(Self::None),
            "environment" => Some(Self::Environment),
            url if url::Url::parse(url).is_ok_and(is_address) => Some(Self::One(url.to_owned())),
            _ => None,
        }
    }

    /// The names of the proxies' machines.
    pub fn hosts(&self) -> Vec<String> {
        let named = match self {
            Self::None => Vec::new(),
            Self::One(url) => vec![url.clone()],
            Self::Environment => {
                let names = ["HTTPS_PROXY", "HTTP_PROXY", "ALL_PROXY"];
                let both = names.iter().flat_map(|name| [(*name).to_owned(), name.to_ascii_lowercase()]);
                both.filter_map(|name| std::env::var(name).ok()).collect()
            }
        };
        let host = |text: &String| {
            let with_scheme = if text.contains("://") { text.clone() } else { format!("http://{text}") };
            url::Url::parse(&with_scheme).ok()?.host_str().map(str::to_ascii_lowercase)
        };
        named.iter().filter_map(host).collect()
    }
}

/// As [`http_client`], by way of proxies.
pub fn http_client_through(
    proxies: &Proxies,
    connect_timeout: Duration,
    timeout: Duration,
) -> reqwest::Result<reqwest::ClientBuilder> {
    Ok(match proxies {
        Proxies::None => http_client(connect_timeout, timeout),
        Proxies::One(url) => http_client(connect_timeout, timeout).proxy(reqwest::Proxy::all(url)?),
        Proxies::Environment => base_client(connect_timeout, timeout),
    })
}

/// Makes `ring` the process's only TLS provider. Call it first thing in `main`; a second call changes nothing.
pub fn install_crypto() {
    let _already_installed = rustls::crypto::ring::default_provider().install_default();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_manual_clock_stands_until_it_is_moved() {
        let clock = Clock::manual(UtcMicros(1));
        let seen_by_another = clock.clone();
        assert_eq!(seen_by_another.now(), UtcMicros(1));
        clock.set(UtcMicros(7));
        assert_eq!(seen_by_another.now(), UtcMicros(7));
    }

    #[test]
    fn the_system_clock_agrees_with_the_standard_library() {
        let since_epoch = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
        let apart = Clock::System.now().0 - since_epoch.as_micros() as i64;
        assert!(apart.abs() < UtcMicros::SECOND, "{apart} us");
    }

    #[test]
    fn random_bytes_differ() {
        let (mut one, mut other) = ([0; 16], [0; 16]);
        fill_random(&mut one).unwrap();
        fill_random(&mut other).unwrap();
        assert_ne!(one, other);
    }

    /// "abc" of FIPS 180-4, and the second case of RFC 4231.
    #[test]
    fn digests_are_those_of_their_standards() {
        let digest = hex::encode(sha256(b"abc"));
        assert_eq!(digest, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        let code = hex::encode(hmac_sha256(b"Jefe", &[b"what do ya want ", b"for nothing?"]));
        assert_eq!(code, "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
    }
}
