//! Whether a target seems to be up: what its queue may send, and when.

use std::time::{Duration, Instant};

use crate::alert::deliver::{Attempt, DeliveryOutcome};

/// So many failures in a row, and the target is taken to be down.
const DOWN_AFTER: u32 = 3;
/// However long a target asks to be left alone, other messages than the one it said so of are tried after this.
const LONGEST_PAUSE: Duration = Duration::from_secs(60);

/// How the last attempts at a target went. A message that the target refuses by itself (4xx) says nothing about the
/// target.
#[derive(Debug, Default)]
pub(super) struct Circuit {
    failures: u32,
    resume_at: Option<Instant>,
}

impl Circuit {
    /// Takes note of an attempt; true where the target was down and is back.
    ///
    /// While a target is down it is asked one message at a time, `probe_every` apart: a queue of thousands costs no
    /// more than a queue of one.
    pub fn note(&mut self, attempt: &Attempt, probe_every: Duration, now: Instant) -> bool {
        match attempt.outcome {
            DeliveryOutcome::Delivered => {
                let was_down = self.failures >= DOWN_AFTER;
                *self = Self::default();
                was_down
            }
            DeliveryOutcome::Failed { retry_after } if is_the_targets(attempt.status) => {
                self.failures = self.failures.saturating_add(1);
                let probe = if self.failures >= DOWN_AFTER { probe_every } else { Duration::ZERO };
                let pause = probe.max(retry_after.unwrap_or_default().min(LONGEST_PAUSE));
                self.resume_at = (!pause.is_zero()).then(|| now + pause);
                false
            }
            DeliveryOutcome::Failed { .. }
            | DeliveryOutcome::Partly
            | DeliveryOutcome::Refused
            | DeliveryOutcome::Needless => false,
            // Nothing more, until it is written down that the hook is disabled.
            DeliveryOutcome::Gone => {
                self.resume_at = Some(now + LONGEST_PAUSE);
                false
            }
        }
    }

    /// How many attempts may be under way, of `most`.
    pub fn at_once(&self, most: usize, now: Instant) -> usize {
        match self.resume_at {
            Some(at) if now < at => 0,
            _ if self.failures > 0 => 1,
            _ => most,
        }
    }

    /// When a pause ends, if there is one.
    pub fn resume_at(&self) -> Option<Instant> {
        self.resume_at
    }
}

/// Whether a failure is of the target, not of the one message: a 2xx that does not say what it is to say is of the
/// message.
fn is_the_targets(status: Option<u16>) -> bool {
    status.is_none_or(|status| matches!(status, 408 | 429) || !matches!(status, 200..300 | 400..500))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROBE: Duration = Duration::from_secs(5);

    fn attempt(status: Option<u16>, retry_after: Option<u64>) -> Attempt {
        let outcome = match status {
            Some(200) => DeliveryOutcome::Delivered,
            _ => DeliveryOutcome::Failed { retry_after: retry_after.map(Duration::from_secs) },
        };
        Attempt { outcome, status, detail: None, answer: None, took: Duration::ZERO }
    }

    #[test]
    fn a_target_that_is_down_is_asked_one_message_every_few_seconds_and_told_all_when_it_is_back() {
        let (mut health, now) = (Circuit::default(), Instant::now());
        assert_eq!(health.at_once(8, now), 8);
        for failures in 1..=5 {
            assert!(!health.note(&attempt(None, None), PROBE, now));
            let expected = if failures < 3 { 1 } else { 0 };
            assert_eq!(health.at_once(8, now), expected, "after {failures} failures");
        }
        assert_eq!(health.at_once(8, now + PROBE), 1);
        assert!(health.note(&attempt(Some(200), None), PROBE, now));
        assert_eq!(health.at_once(8, now), 8);
        assert!(!health.note(&attempt(Some(200), None), PROBE, now), "it has not been down again");
    }

    #[test]
    fn one_refused_message_does_not_slow_the_others() {
        let (mut health, now) = (Circuit::default(), Instant::now());
        for status in [400, 404, 422] {
            health.note(&attempt(Some(status), None), PROBE, now);
        }
        assert_eq!(health.at_once(8, now), 8);
        for status in [302, 408, 429, 500] {
            let mut health = Circuit::default();
            health.note(&attempt(Some(status), None), PROBE, now);
            assert_eq!(health.at_once(8, now), 1, "{status}");
        }
    }

    #[test]
    fn a_target_that_asks_for_time_is_left_alone_for_a_minute_at_the_most() {
        let (mut health, now) = (Circuit::default(), Instant::now());
        health.note(&attempt(Some(429), Some(30)), PROBE, now);
        assert_eq!((health.at_once(8, now + Duration::from_secs(29)), health.resume_at()), (0, Some(now + PROBE * 6)));
        health.note(&attempt(Some(503), Some(7200)), PROBE, now);
        assert_eq!(health.at_once(8, now + LONGEST_PAUSE), 1);
    }
}
