//! The only place that asks the world outside: the clock, random numbers, the network client, the cryptography.
//!
//! `clippy.toml` bans the same calls everywhere else, so that tests can put a clock of their own in, every draw is
//! seeded or meant to be secret, and no HTTP client follows redirects or proxies by accident.
#![expect(clippy::disallowed_methods, reason = "this is the one place that the bans point to")]

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
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

/// An HTTP client that follows no redirect, uses no proxy from the environment and gives up in time.
pub fn http_client(connect_timeout: Duration, timeout: Duration) -> reqwest::ClientBuilder {
    reqwest::Client::builder()
        .redirect(reqwest::redirect::Policy::none())
        .no_proxy()
        .connect_timeout(connect_timeout)
        .timeout(timeout)
        .user_agent(concat!("gyrowatch/", env!("CARGO_PKG_VERSION")))
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
}
