//! An instant as the core sees it: a number. Reading and writing calendars is the edge's work.

/// Microseconds since 1970-01-01T00:00:00Z, without leap seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct UtcMicros(pub i64);

impl UtcMicros {
    pub const SECOND: i64 = 1_000_000;
    pub const DAY: i64 = 86_400 * Self::SECOND;

    /// Time from `earlier` to `self` in days of 86,400 s; negative where `earlier` is the later one.
    pub fn days_since(self, earlier: Self) -> f64 {
        (self.0 - earlier.0) as f64 / Self::DAY as f64
    }

    /// This instant moved by `days`, saturating at the ends of the representable range.
    pub fn plus_days(self, days: f64) -> Self {
        Self(self.0.saturating_add((days * Self::DAY as f64) as i64))
    }
}

/// A day of the proleptic Gregorian calendar, UTC. Displays as `2026-03-01`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct UtcDate {
    pub year: i64,
    pub month: u8,
    pub day: u8,
}

impl UtcMicros {
    /// The UTC day of this instant, for words that name a date. (Days to civil date after H. Hinnant, whose eras
    /// of 400 years begin on 1 March.)
    pub fn date(self) -> UtcDate {
        let days = self.0.div_euclid(Self::DAY) + 719_468;
        let era = days.div_euclid(146_097);
        let day_of_era = days.rem_euclid(146_097);
        let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
        let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        let shifted_month = (5 * day_of_year + 2) / 153;
        let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
        let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
        let year = year_of_era + era * 400 + i64::from(month <= 2);
        UtcDate { year, month: month as u8, day: day as u8 }
    }
}

impl UtcDate {
    /// When the day begins: the inverse of [`UtcMicros::date`].
    pub fn midnight(self) -> UtcMicros {
        let year = self.year - i64::from(self.month <= 2);
        let era = year.div_euclid(400);
        let shifted_month = (i64::from(self.month) + 9) % 12;
        let day_of_year = (153 * shifted_month + 2) / 5 + i64::from(self.day) - 1;
        let year_of_era = year.rem_euclid(400);
        let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
        UtcMicros((era * 146_097 + day_of_era - 719_468) * UtcMicros::DAY)
    }
}

impl std::fmt::Display for UtcDate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

/// A stretch of time, its ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    pub from: UtcMicros,
    pub to: UtcMicros,
}

impl Span {
    pub const EVER: Span = Span { from: UtcMicros(i64::MIN), to: UtcMicros(i64::MAX) };

    /// Whether an instant is in the span, both ends included.
    pub fn contains(&self, at: UtcMicros) -> bool {
        (self.from..=self.to).contains(&at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_agree_with_the_calendar_over_four_centuries() {
        let jiff_date = |micros| jiff::Timestamp::from_microsecond(micros).expect("in range").strftime("%Y-%m-%d");
        for day in (-80_000..80_000).step_by(17) {
            let instant = UtcMicros(day * UtcMicros::DAY + 86_399_999_999);
            assert_eq!(instant.date().to_string(), jiff_date(instant.0).to_string());
        }
        assert_eq!(UtcMicros(951_782_400_000_000).date().to_string(), "2000-02-29");
    }
}
