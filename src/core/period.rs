//! Measurements gathered by day, week or month: what a plot of years needs.

use super::time::UtcMicros;
use crate::core::named::named;

named! {
/// A stretch of the calendar, UTC.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Period {
    Day = "day",
    Week = "week",
    Month = "month",
}
}

impl Period {
    /// First instant of the period that holds `at`; weeks begin on Monday (ISO 8601).
    pub fn begin(self, at: UtcMicros) -> UtcMicros {
        let day = at.0.div_euclid(UtcMicros::DAY);
        let first = match self {
            Self::Day => day,
            // Day 0, 1970-01-01, was a Thursday.
            Self::Week => day - (day + 3).rem_euclid(7),
            Self::Month => day + 1 - i64::from(at.date().day),
        };
        UtcMicros(first.saturating_mul(UtcMicros::DAY))
    }

    /// First instant of the period after the one that holds `at`.
    pub fn next(self, at: UtcMicros) -> UtcMicros {
        // The longest month has 31 days; four more reach into the next and not beyond it.
        let days = match self {
            Self::Day => 1,
            Self::Week => 7,
            Self::Month => 35,
        };
        self.begin(UtcMicros(self.begin(at).0.saturating_add(days * UtcMicros::DAY)))
    }
}

/// What the measurements of one period have in common; in the unit of what was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// First instant of the period.
    pub begins: UtcMicros,
    /// Measurements in it, at least one.
    pub count: usize,
    pub min: f64,
    pub max: f64,
    /// Arithmetic mean, unweighted.
    pub mean: f64,
    /// The newest.
    pub last: f64,
}

/// Takes measurements in order of time, a few at a time if need be. Periods without any are left out.
#[derive(Debug)]
pub struct SummaryBuilder {
    period: Period,
    summaries: Vec<Summary>,
}

impl SummaryBuilder {
    /// Without measurements yet.
    pub fn new(period: Period) -> Self {
        Self { period, summaries: Vec::new() }
    }

    /// Adds a measurement that is not older than the one before.
    pub fn push(&mut self, at: UtcMicros, value: f64) {
        let begins = self.period.begin(at);
        match self.summaries.last_mut().filter(|summary| summary.begins == begins) {
            Some(summary) => summary.push(value),
            None => self.summaries.push(Summary { begins, count: 1, min: value, max: value, mean: value, last: value }),
        }
    }

    /// Oldest first.
    pub fn finish(self) -> Vec<Summary> {
        self.summaries
    }
}

impl Summary {
    fn push(&mut self, value: f64) {
        self.count += 1;
        self.min = self.min.min(value);
        self.max = self.max.max(value);
        // Updated rather than summed: a sum of large values would lose the small differences between them.
        self.mean += (value - self.mean) / self.count as f64;
        self.last = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn periods_begin_where_the_calendar_says() {
        for day in (-80_000..80_000).step_by(13) {
            let at = UtcMicros(day * UtcMicros::DAY + 12_345_678_901);
            let civil = |at: UtcMicros| {
                let instant = jiff::Timestamp::from_microsecond(at.0).expect("in range");
                instant.to_zoned(jiff::tz::TimeZone::UTC)
            };
            let midnight = civil(at).start_of_day().expect("UTC has every midnight");
            let days_since_monday = i64::from(midnight.weekday().to_monday_zero_offset());
            let expected = [
                midnight.clone(),
                midnight.checked_sub(jiff::Span::new().days(days_since_monday)).expect("in range"),
                midnight.first_of_month().expect("in range"),
            ];
            for (period, expected) in Period::ALL.into_iter().zip(expected) {
                assert_eq!(civil(period.begin(at)), expected, "{} of {at:?}", period.name());
                let following = match period {
                    Period::Day => jiff::Span::new().days(1),
                    Period::Week => jiff::Span::new().weeks(1),
                    Period::Month => jiff::Span::new().months(1),
                };
                let expected = expected.checked_add(following).expect("in range");
                assert_eq!(civil(period.next(at)), expected, "after the {} of {at:?}", period.name());
            }
        }
        for at in [i64::MIN, i64::MAX] {
            assert!(
                Period::ALL
                    .into_iter()
                    .all(|period| period.begin(UtcMicros(at)).0 <= at.saturating_add(UtcMicros::DAY))
            );
        }
    }

    #[test]
    fn a_summary_holds_the_extremes_the_mean_and_the_last_of_its_period() {
        let mut gatherer = SummaryBuilder::new(Period::Day);
        for (hour, value) in [(1, 3.0), (2, -1.0), (23, 1.0), (24, 7.0), (72, 2.0)] {
            gatherer.push(UtcMicros(hour * 3600 * UtcMicros::SECOND), value);
        }
        let day = |day: i64, count, [min, max, mean, last]: [f64; 4]| Summary {
            begins: UtcMicros(day * UtcMicros::DAY),
            count,
            min,
            max,
            mean,
            last,
        };
        let expected = [day(0, 3, [-1.0, 3.0, 1.0, 1.0]), day(1, 1, [7.0; 4]), day(3, 1, [2.0; 4])];
        assert_eq!(gatherer.finish(), expected, "the empty day is left out");
    }
}
