//! How often: wrong tokens by where they come from, requests by token. Memory is bounded whatever comes.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::time::{Duration, Instant};

const WINDOW: Duration = Duration::from_secs(60);
/// Sources that are remembered at the most.
const MOST_SOURCES: usize = 100_000;

/// Wrong tokens of the last minute, by source.
#[derive(Debug)]
pub(super) struct Failures {
    most: usize,
    by_source: HashMap<IpAddr, (usize, Instant)>,
}

impl Failures {
    pub fn new(most: usize) -> Self {
        Self { most, by_source: HashMap::new() }
    }

    /// How long a source that has failed too often is still to wait.
    pub fn wait(&self, source: IpAddr, now: Instant) -> Option<Duration> {
        let (count, since) = self.by_source.get(&network(source))?;
        let left = WINDOW.checked_sub(now.saturating_duration_since(*since)).filter(|left| !left.is_zero())?;
        (*count >= self.most).then_some(left)
    }

    pub fn note(&mut self, source: IpAddr, now: Instant) {
        if self.by_source.len() >= MOST_SOURCES {
            self.by_source.retain(|_, (_, since)| now.saturating_duration_since(*since) < WINDOW);
            if self.by_source.len() >= MOST_SOURCES {
                self.by_source.clear();
            }
        }
        let (count, since) = self.by_source.entry(network(source)).or_insert((0, now));
        if now.saturating_duration_since(*since) >= WINDOW {
            (*count, *since) = (0, now);
        }
        *count += 1;
    }
}

/// Whoever has one address of IPv6 has 2^64 of them.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(v6) => {
            let [a, b, c, d, ..] = v6.segments();
            IpAddr::V6(Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0))
        }
        v4 => v4,
    }
}

/// Requests of one token: as many at once as a second has, refilled evenly.
#[derive(Debug, Clone, Copy)]
pub(super) struct Allowance {
    left: f64,
    at: Instant,
}

impl Allowance {
    pub fn full(per_second: f64, now: Instant) -> Self {
        Self { left: per_second.max(1.0), at: now }
    }

    /// Takes one, or says how long to wait for it.
    pub fn take(&mut self, per_second: f64, now: Instant) -> Result<(), Duration> {
        let since = now.saturating_duration_since(self.at).as_secs_f64();
        self.left = (self.left + since * per_second).min(per_second.max(1.0));
        self.at = now;
        if self.left < 1.0 {
            return Err(Duration::from_secs_f64((1.0 - self.left) / per_second));
        }
        self.left -= 1.0;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn address(last: u16) -> IpAddr {
        IpAddr::V6(Ipv6Addr::new(0x2001, 0xdb8, 0, 1, 0, 0, 0, last))
    }

    #[test]
    fn the_tenth_failure_of_a_minute_shuts_out_its_source_alone_until_the_minute_is_over() {
        let (mut failures, start) = (Failures::new(10), Instant::now());
        let (source, other) = ("192.0.2.1".parse().unwrap(), "192.0.2.2".parse().unwrap());
        for _ in 0..9 {
            failures.note(source, start);
        }
        assert_eq!(failures.wait(source, start), None);
        failures.note("::ffff:192.0.2.1".parse().unwrap(), start);
        assert_eq!(failures.wait(source, start), Some(WINDOW));
        assert_eq!(failures.wait(other, start), None);
        let later = start + Duration::from_secs(59);
        assert_eq!(failures.wait(source, later), Some(Duration::from_secs(1)));
        assert_eq!(failures.wait(source, start + WINDOW), None);
        failures.note(source, start + WINDOW);
        assert_eq!(failures.wait(source, start + WINDOW), None, "a new minute begins at nought");
    }

    #[test]
    fn addresses_of_one_network_are_one_source_and_memory_is_bounded() {
        let (mut failures, now) = (Failures::new(2), Instant::now());
        failures.note(address(1), now);
        failures.note(address(2), now);
        assert!(failures.wait(address(3), now).is_some());
        for i in 0..MOST_SOURCES as u32 * 2 {
            failures.note(IpAddr::from((i | 0x0a00_0000).to_be_bytes()), now);
        }
        assert!(failures.by_source.len() <= MOST_SOURCES);
    }

    #[test]
    fn an_allowance_is_used_up_and_comes_back_evenly() {
        let now = Instant::now();
        let mut allowance = Allowance::full(4.0, now);
        assert!((0..4).all(|_| allowance.take(4.0, now).is_ok()));
        assert_eq!(allowance.take(4.0, now), Err(Duration::from_millis(250)));
        let later = now + Duration::from_millis(250);
        assert!(allowance.take(4.0, later).is_ok() && allowance.take(4.0, later).is_err());
        let much_later = later + Duration::from_secs(3600);
        assert!((0..4).all(|_| allowance.take(4.0, much_later).is_ok()));
        assert!(allowance.take(4.0, much_later).is_err(), "what is not used is not saved up");
    }
}
