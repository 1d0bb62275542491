//! What a record looks like beside what is known of its IMU and gyros: kinds and parameters; words are made at the
//! edge.

use super::mounting::Slot;
use super::time::{UtcDate, UtcMicros};
use crate::core::named::named;

/// What stands out in a calibration beside the history of its IMU, gyros and station.
#[derive(Debug, Clone, PartialEq)]
pub enum HistoryNote {
    /// Its time is that of a clock that was never set, or decades from everything else: it is set aside until
    /// somebody confirms it.
    TimeInDoubt(TimeDoubt),
    /// Earlier records are set aside because this one is decades after them.
    OthersSetAside { records: Vec<NamedRecord> },
    /// Somebody suspects what its station measured at that time: it is set aside until somebody confirms it.
    Suspect { station: String, author: String, reason: String },
    /// Others of its IMU and time are set aside with other content: one of them all can count.
    SameTimeSetAside { records: Vec<String> },
    /// Ahead of the service's clock, hours.
    AheadOfNow { hours: f64 },
    /// Far before its gyros' newest record, and with this year just after it.
    YearInDoubt { year: i64 },
    /// A slot in which another gyro was has a gyro that nobody knows.
    NewSerial { slot: Slot, serial: String, had: String, nearest: Option<String> },
    /// A new name looks like one that is known.
    LookAlike { of: NameKind, name: String, known: String },
    /// Each of these gyros has the figures of another of them.
    SerialsExchanged { fits: Vec<(String, String)> },
    /// All gyros are off their levels at once, by so many budgets at least.
    OtherUnit { serials: Vec<String>, budgets: f64 },
    /// The very figures of another record.
    IdenticalFigures { serials: Vec<String>, record: NamedRecord },
    /// E or G is so many times what it was before; `by_scale`: as by the gyro's own |E|.
    UnitFactor { serials: Vec<String>, quantity: Quantity, factor: f64, by_scale: bool },
    /// A campaign or bench test of these gyros was under way at the time.
    OverlapsInTime { serials: Vec<String>, record: NamedRecord },
    /// D_I and D_S of these gyros are both off their levels, by so many budgets at least.
    AnotherGyro { serials: Vec<String>, budgets: f64 },
    /// The gyro was elsewhere in its last record.
    Moved { serial: String, from: Seat, to: Seat },
    /// The stated standard deviations are so many times those before.
    UncertaintyFactor { serials: Vec<String>, factor: f64 },
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeDoubt {
    /// Clocks that were never set begin there.
    NearEpoch { epoch: UtcMicros },
    /// The nearest record of the same gyros.
    FarFromOthers { nearest: UtcMicros },
}

/// By whom, and the code of why, earlier records are set aside that [`TimeDoubt::FarFromOthers`] casts doubt on.
pub const SERVICE: &str = "gyrowatch";
pub const EARLIER_IN_DOUBT: &str = "earlier_in_doubt";

/// A stored record.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedRecord {
    pub record: String,
    pub at: UtcMicros,
}

named! {
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NameKind {
    Imu = "imu",
    Station = "station",
    Serial = "serial",
}
}

named! {
/// E or G, of a gyro.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    E = "E",
    G = "G",
}
}

/// A slot of an IMU.
#[derive(Debug, Clone, PartialEq)]
pub struct Seat {
    pub imu: String,
    pub slot: Slot,
}

impl HistoryNote {
    /// Its name in answers; never changes once it has been given out.
    pub fn code(&self) -> &'static str {
        match self {
            Self::TimeInDoubt(_) => "time_in_doubt",
            Self::OthersSetAside { .. } => "others_set_aside",
            Self::Suspect { .. } => "suspect",
            Self::SameTimeSetAside { .. } => "same_time_set_aside",
            Self::AheadOfNow { .. } => "ahead_of_now",
            Self::YearInDoubt { .. } => "year_in_doubt",
            Self::NewSerial { .. } => "new_serial",
            Self::LookAlike { .. } => "look_alike",
            Self::SerialsExchanged { .. } => "serials_exchanged",
            Self::OtherUnit { .. } => "other_unit",
            Self::IdenticalFigures { .. } => "identical_figures",
            Self::UnitFactor { .. } => "unit_factor",
            Self::OverlapsInTime { .. } => "overlaps_in_time",
            Self::AnotherGyro { .. } => "another_gyro",
            Self::Moved { .. } => "moved",
            Self::UncertaintyFactor { .. } => "uncertainty_factor",
        }
    }
}

/// So near to another record of its gyros, days, a time is beyond doubt.
const COMPANY_DAYS: f64 = 730.0;
/// Decades from every other record: a receiver that has miscounted its weeks is 19.6 years behind.
pub const FAR_DAYS: f64 = 15.0 * 365.25;
/// A campaign or bench test may have lasted so many days where it is asked what was under way.
pub const LONGEST_DAYS: f64 = 7.0;
/// A clock that was never set has run for so many days at the most, the day before for those that are behind UTC.
const RUNNING_DAYS: std::ops::Range<f64> = -1.0..100.0;
/// Before so many days after 1970-01-01 nothing is taken: see [`is_unset`].
const UNSET_DAYS: std::ops::Range<f64> = -1.0..400.0;

/// Whether a time is that of a clock that counts from 1970 and was never set.
pub fn is_unset(at: UtcMicros) -> bool {
    UNSET_DAYS.contains(&at.days_since(UtcMicros(0)))
}

/// Whether a time is in doubt, by the epochs at which clocks that were never set begin, and by the nearest record of
/// the same gyros.
pub fn doubt(at: UtcMicros, epochs: &[UtcMicros], nearest: Option<UtcMicros>) -> Option<TimeDoubt> {
    let away = nearest.map(|nearest| nearest.days_since(at));
    if away.is_some_and(|days| days.abs() <= COMPANY_DAYS) {
        return None;
    }
    let near = |epoch: &&UtcMicros| RUNNING_DAYS.contains(&at.days_since(**epoch));
    if let Some(epoch) = epochs.iter().find(near) {
        return Some(TimeDoubt::NearEpoch { epoch: *epoch });
    }
    nearest.filter(|_| away.is_some_and(|days| days > FAR_DAYS)).map(|nearest| TimeDoubt::FarFromOthers { nearest })
}

/// A year is in doubt only so many days before the newest record, and where another makes it no older than this.
const SLIPPED_DAYS: f64 = 180.0;
const FRESH_DAYS: f64 = 31.0;
const SLIPPED_YEARS: std::ops::RangeInclusive<i64> = 1..=10;

/// The year with which `at` is between the newest record of the same gyros and `now`, within a month of it, where that
/// record is half a year after `at`: a station's calendar, or a hand in January, is behind by whole years.
pub fn slipped_year(at: UtcMicros, newest: UtcMicros, now: UtcMicros) -> Option<i64> {
    if newest.days_since(at) < SLIPPED_DAYS {
        return None;
    }
    let date = at.date();
    let of_day = at.days_since(date.midnight());
    let is_fresh = |year: &i64| {
        let then = UtcDate { year: *year, ..date }.midnight().plus_days(of_day);
        then > newest && (0.0..FRESH_DAYS).contains(&now.days_since(then))
    };
    SLIPPED_YEARS.map(|years| date.year + years).find(is_fresh)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The day of 2000 that is so many days after its first.
    fn day(days: f64) -> UtcMicros {
        UtcMicros(946_684_800_000_000).plus_days(days)
    }

    #[test]
    fn a_time_is_in_doubt_near_an_epoch_or_decades_before_all_else() {
        let epochs = [UtcMicros(0), day(0.0)];
        let near = Some(TimeDoubt::NearEpoch { epoch: day(0.0) });
        for (at, nearest, expected) in [
            (0.0, None, near),
            (-0.9, None, near),
            (99.9, None, near),
            (100.1, None, None),
            (-1.1, None, None),
            // The company of other records, on either side, and of such as are too far for it.
            (1.0, Some(731.0), None),
            (1.0, Some(-729.0), None),
            (1.0, Some(732.0), near),
            // Decades before, not after.
            (3000.0, Some(3000.0 + 5479.0), Some(TimeDoubt::FarFromOthers { nearest: day(8479.0) })),
            (3000.0, Some(3000.0 + 5478.0), None),
            (9000.0, Some(9000.0 - 6000.0), None),
        ] {
            assert_eq!(doubt(day(at), &epochs, nearest.map(day)), expected, "{at} {nearest:?}");
        }
        assert_eq!(doubt(day(1.0), &[], None), None);
        let unset = [-0.9, 0.0, 399.9, -1.1, 400.1].map(|days| is_unset(UtcMicros(0).plus_days(days)));
        assert_eq!(unset, [true, true, true, false, false]);
    }

    #[test]
    fn a_year_is_in_doubt_where_another_makes_a_record_the_newest() {
        // 2000-01-10 is now, the newest record is of 1999-12-20.
        let (now, newest) = (day(9.0), day(-12.0));
        for (at, year) in [
            (day(8.0 - 365.0), Some(2000)),
            (day(8.0 - 365.0 - 1461.0), Some(2000)),
            (day(-15.0 - 365.0), None),
            (day(9.5 - 365.0), None),
            (day(8.0 - 11.0 * 365.25), None),
            (day(8.0), None),
        ] {
            assert_eq!(slipped_year(at, newest, now), year, "{}", at.date());
        }
        assert_eq!(slipped_year(day(8.0 - 365.0), day(-300.0), now), None, "the newest is as old");
    }
}
