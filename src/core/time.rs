//! An instant as the core sees it: a number. Reading and writing calendars is the edge's work.

/// Microseconds since 1970-01-01T00:00:00Z, without leap seconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
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
