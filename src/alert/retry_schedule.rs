//! When a delivery that failed is tried again: the retry schedule of Standard Webhooks.

use std::time::Duration;

const MINUTE: u64 = 60;
const HOUR: u64 = 60 * MINUTE;

/// Waits after the first attempt, the second, and so on; with the first attempt (at once) ten attempts in 75 h 35 min.
const STANDARD_WAITS_S: [u64; 9] =
    [5, 5 * MINUTE, 30 * MINUTE, 2 * HOUR, 5 * HOUR, 10 * HOUR, 14 * HOUR, 20 * HOUR, 24 * HOUR];

/// Waits after the attempts that failed, one by one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RetrySchedule(Vec<Duration>);

/// A wait is drawn out by up to this fraction of it, so that deliveries that failed together do not return together.
/// Never shortened: the schedule lasts at least as long as it says.
pub const JITTER: f64 = 0.1;

/// A longer Retry-After is cut to this.
pub const LONGEST_WAIT: Duration = Duration::from_secs(24 * HOUR);

/// No delivery that is to be tried again waits longer than this: a time further off was written by a clock gone wrong.
pub const HORIZON: Duration = Duration::from_secs(30 * HOUR);

/// What becomes of a delivery whose latest attempt failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RetryDecision {
    RetryIn(Duration),
    /// The schedule is at its end: a dead letter, which people look at and may replay.
    Dead,
}

impl Default for RetrySchedule {
    fn default() -> Self {
        Self(STANDARD_WAITS_S.map(Duration::from_secs).into())
    }
}

impl RetrySchedule {
    /// # Panics
    /// Where there is no wait: the configuration was checked to name one.
    pub fn new(waits: Vec<Duration>) -> Self {
        assert!(!waits.is_empty(), "a retry schedule has at least one wait");
        Self(waits)
    }

    /// The wait after a first failure.
    pub fn first_wait(&self) -> Duration {
        self.0[0]
    }

    /// * `attempts`: those that were made since the delivery was queued or replayed, the failed one included.
    /// * `tried_for`: time since the first of them. Attempts that came early (a target that is up again is tried at
    ///   once) do not shorten the schedule.
    /// * `retry_after`: what the target asked for.
    /// * `jitter`: from 0 to 1, drawn by the caller.
    pub fn next(
        &self,
        attempts: u32,
        tried_for: Duration,
        retry_after: Option<Duration>,
        jitter: f64,
    ) -> RetryDecision {
        let retries = attempts as usize;
        if retries > self.0.len() && tried_for >= self.0.iter().sum::<Duration>() {
            return RetryDecision::Dead;
        }
        let rung = retries.clamp(1, self.0.len()) - 1;
        let wait = self.0[rung].mul_f64(1.0 + JITTER * jitter.clamp(0.0, 1.0));
        let asked = retry_after.unwrap_or_default().min(LONGEST_WAIT);
        RetryDecision::RetryIn(wait.max(asked))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEVER_MIND: f64 = 0.0;

    fn climb(jitter: f64) -> (u32, Duration) {
        let (mut attempts, mut tried_for) = (1, Duration::ZERO);
        while let RetryDecision::RetryIn(wait) = RetrySchedule::default().next(attempts, tried_for, None, jitter) {
            tried_for += wait;
            attempts += 1;
        }
        (attempts, tried_for)
    }

    #[test]
    fn ten_attempts_span_three_days_and_a_bit() {
        assert_eq!(climb(0.0), (10, Duration::from_secs(75 * HOUR + 35 * MINUTE + 5)));
        let (attempts, tried_for) = climb(1.0);
        assert_eq!(attempts, 10);
        assert!(tried_for > Duration::from_secs(83 * HOUR) && tried_for < Duration::from_secs(84 * HOUR));
    }

    #[test]
    fn a_target_that_asks_for_time_gets_it_up_to_a_day() {
        let retry =
            |after| RetrySchedule::default().next(1, Duration::ZERO, Some(Duration::from_secs(after)), NEVER_MIND);
        assert_eq!(retry(1), RetryDecision::RetryIn(Duration::from_secs(5)));
        assert_eq!(retry(90), RetryDecision::RetryIn(Duration::from_secs(90)));
        assert_eq!(retry(u64::MAX), RetryDecision::RetryIn(LONGEST_WAIT));
    }

    #[test]
    fn attempts_that_came_early_do_not_kill_a_delivery_before_three_days() {
        assert_eq!(
            RetrySchedule::default().next(40, Duration::from_secs(60), None, NEVER_MIND),
            RetryDecision::RetryIn(Duration::from_secs(24 * HOUR))
        );
        assert_eq!(
            RetrySchedule::default().next(40, Duration::from_secs(76 * HOUR), None, NEVER_MIND),
            RetryDecision::Dead
        );
    }

    #[test]
    fn nothing_waits_beyond_the_horizon() {
        for attempts in 0..12 {
            let RetryDecision::RetryIn(wait) =
                RetrySchedule::default().next(attempts, Duration::ZERO, Some(Duration::MAX), 1.0)
            else {
                continue;
            };
            assert!(wait < HORIZON, "{wait:?}");
        }
    }
}
