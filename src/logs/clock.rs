//! Times of day and dates in a log's cells, as loggers write them, in seconds.

use crate::core::time::UtcMicros;
use crate::wire::time;

/// `8:15:00,010` and `08:15` are seconds of the day. With a date before them (`2026-11-24`, `24.11.2026`,
/// `2026/11/24`; a `T` or a blank between) they count from [`EPOCH`], so that nobody takes local time for UTC; with an
/// offset or a Z they are Unix seconds. `20261124T081500` is a date with a time too; digits alone are a number.
pub fn seconds(text: &str) -> Option<f64> {
    let (date, time) = match text.split_once(['T', ' ']) {
        Some((date, time)) => (Some(days(date)?), time.trim()),
        None => (None, text),
    };
    let (time, offset) = offset(time)?;
    let mut parts: Vec<&str> = time.split(':').collect();
    if let ([digits], Some(_)) = (&parts[..], date)
        && digits.is_ascii()
        && digits.split(['.', ',']).next().is_some_and(|whole| whole.len() == 6)
    {
        parts = vec![&digits[..2], &digits[2..4], &digits[4..]];
    }
    let (hours, minutes, second) = match parts[..] {
        [hours, minutes] => (hours, minutes, 0.0),
        [hours, minutes, second] => (hours, minutes, fraction(second)?),
        _ => return None,
    };
    let (hours, minutes) = (whole(hours, 23)?, whole(minutes, 59)?);
    let of_day = f64::from(hours * 3600 + minutes * 60) + second;
    Some(match (date, offset) {
        (None, _) => of_day,
        (Some(days), None) => (days - EPOCH) as f64 * DAY + of_day,
        (Some(days), Some(offset)) => days as f64 * DAY + of_day - offset,
    })
}

const DAY: f64 = 86_400.0;
/// 2020-01-01, in days since 1970.
const EPOCH: i64 = 18_262;
/// Dates without an offset are below it until 2048, Unix seconds have been above it since 1998.
const LOCAL_S: f64 = 9e8;

/// From when the seconds of a clock count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Epoch {
    Unix,
    /// Dates and times of day of a place that nobody says.
    Local,
}

impl Epoch {
    /// That of seconds which were read from a cell; none of a time of day.
    pub fn of(seconds: f64) -> Option<Self> {
        match seconds {
            _ if (0.0..DAY + 1.0).contains(&seconds) => None,
            LOCAL_S.. => Some(Self::Unix),
            _ => Some(Self::Local),
        }
    }

    /// The moment of such seconds; of local time as if it were UTC.
    pub fn moment(self, seconds: f64) -> UtcMicros {
        let since_1970 = if self == Self::Local { seconds + EPOCH as f64 * DAY } else { seconds };
        UtcMicros((since_1970 * 1e6) as i64)
    }

    /// The moment as it is written; of local time without an offset.
    pub fn written(self, seconds: f64) -> String {
        let written = time::format(self.moment((seconds * 1e3).round() / 1e3));
        if self == Self::Local { written.trim_end_matches('Z').to_owned() } else { written }
    }
}

/// The time without its offset, and the offset in seconds.
fn offset(time: &str) -> Option<(&str, Option<f64>)> {
    if let Some(utc) = time.strip_suffix(['Z', 'z']) {
        return Some((utc.trim_end(), Some(0.0)));
    }
    let Some(at) = time.rfind(['+', '-']) else { return Some((time, None)) };
    let digits = &time[at + 1..];
    let (hours, minutes) = digits.split_once(':').or_else(|| digits.split_at_checked(2))?;
    let seconds = f64::from(whole(hours, 14)? * 3600 + whole(minutes, 59)? * 60);
    Some((time[..at].trim_end(), Some(if time[at..].starts_with('-') { -seconds } else { seconds })))
}

/// Whether a text begins with what looks like a date and is none whose order is plain: `03/04/2026`.
pub fn is_unclear_date(text: &str) -> bool {
    let date = text.split(['T', ' ']).next().unwrap_or_default();
    let parts: Vec<&str> = date.split(['/', '-', '.']).collect();
    let is_part = |part: &&str| (1..=4).contains(&part.len()) && part.bytes().all(|b| b.is_ascii_digit());
    parts.len() == 3 && parts.iter().all(is_part) && days(date).is_none()
}

/// Whether a text has the digits and marks of a time and is none.
pub fn is_like_time(text: &str) -> bool {
    let mark = |b: u8| b.is_ascii_digit() || b":.,-+/TZ ".contains(&b);
    text.contains(':') && text.starts_with(|c: char| c.is_ascii_digit()) && text.bytes().all(mark)
}

/// A moment as a spreadsheet keeps it, in days since 1899-12-30; below one day it is a time of day.
pub fn of_sheet(days: f64) -> f64 {
    const EPOCH_OF_SHEETS: f64 = 43_831.0;
    DAY * if days < 1.0 { days } else { days - EPOCH_OF_SHEETS }
}

/// Days since 1970 of a date whose order is plain: the year first, or points between day, month and year.
fn days(date: &str) -> Option<i64> {
    let is_plain = date.len() == 8 && date.bytes().all(|b| b.is_ascii_digit());
    let mark = ['-', '/', '.'].into_iter().find(|mark| date.contains(*mark));
    let parts: Vec<&str> = match mark {
        Some(mark) => date.split(mark).collect(),
        None if is_plain => vec![&date[..4], &date[4..6], &date[6..]],
        None => return None,
    };
    let [first, month, last] = parts[..] else { return None };
    let (year, day) = match (first.len(), last.len(), mark) {
        (4, ..) => (first, last),
        (_, 4, Some('.')) => (last, first),
        _ => return None,
    };
    let [month, day] = [(month, 12), (day, 31)].map(|(text, most)| Some(whole(text, most)? as i8));
    let date = jiff::civil::Date::new(year.parse().ok()?, month?, day?).ok()?;
    Some(date.duration_since(jiff::civil::date(1970, 1, 1)).as_hours() / 24)
}

fn whole(text: &str, most: u32) -> Option<u32> {
    let is_digits = (1..=2).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    text.parse().ok().filter(|value| is_digits && *value <= most)
}

fn fraction(text: &str) -> Option<f64> {
    let plain = text.replacen(',', ".", 1);
    let is_plain = plain.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    plain.parse().ok().filter(|seconds| is_plain && (0.0..61.0).contains(seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_of_loggers_are_seconds() {
        for (text, expected) in [
            ("08:15:00,010", Some(29_700.01)),
            ("8:15", Some(29_700.0)),
            ("24.11.2026 08:15:00.5", Some(2_519.0 * DAY + 29_700.5)),
            ("2026-11-24T08:15:00", Some(2_519.0 * DAY + 29_700.0)),
            ("2026/11/24 08:15:00", Some(2_519.0 * DAY + 29_700.0)),
            ("2026-11-24T08:15:00Z", Some(1_795_508_100.0)),
            ("2026-11-24 08:15:00 +08:00", Some(1_795_508_100.0 - 28_800.0)),
            ("20261124T081500", Some(2_519.0 * DAY + 29_700.0)),
            ("20261124 081500.5", Some(2_519.0 * DAY + 29_700.5)),
            ("20261124T081500Z", Some(1_795_508_100.0)),
            ("20261124T081500+0800", Some(1_795_508_100.0 - 28_800.0)),
            ("20261324T081500", None),
            ("20261124T0815000", None),
            ("2026112T081500", None),
            ("081500", None),
            // The order of day and month is not plain.
            ("11/10/2026 08:15:00", None),
            ("24:15:00", None),
            ("08:15:00:10", None),
            ("2026-13-24 08:15:00", None),
            ("3.5", None),
            ("a:b", None),
        ] {
            assert_eq!(seconds(text), expected, "{text}");
        }
    }

    #[test]
    fn dates_whose_order_is_not_plain_are_known_as_such() {
        for text in ["11/10/2026 08:15:00", "03/04/2026", "13/02/2026T08:15", "1/2/26", "2026-13-24 08:15:00"] {
            assert!(is_unclear_date(text), "{text}");
        }
        for text in ["2026-11-24", "24.11.2026 08:15", "1.2.3.4", "a/b/c", "-0.5", "8:15:00", "1e-5"] {
            assert!(!is_unclear_date(text), "{text}");
        }
    }

    #[test]
    fn times_that_cannot_be_read_are_known_as_such() {
        for text in ["25:10", "08:15:00:10", "24:15:00.5", "2026-13-24T08:15:00Z"] {
            assert!(is_like_time(text) && seconds(text).is_none(), "{text}");
        }
        for text in ["a:b", "12 pulses", ":", "3.5", "G1: off"] {
            assert!(!is_like_time(text), "{text}");
        }
    }

    #[test]
    fn spreadsheets_and_texts_have_one_clock() {
        // 2026-11-24 is day 46350 of a spreadsheet.
        let days = 46_350.0 + 29_700.0 / DAY;
        assert!((of_sheet(days) - seconds("2026-11-24 08:15:00").unwrap()).abs() < 1e-4);
        assert_eq!(of_sheet(0.5), 43_200.0);
    }

    #[test]
    fn seconds_say_from_when_they_count() {
        for (text, written) in [
            ("2026-11-24T08:15:00.5+08:00", Some("2026-11-24T00:15:00.5Z")),
            ("24.11.2026 08:15:00", Some("2026-11-24T08:15:00")),
            ("2019-11-24 08:15", Some("2019-11-24T08:15:00")),
            ("23:59:60.9", None),
        ] {
            let seconds = seconds(text).unwrap();
            assert_eq!(Epoch::of(seconds).map(|epoch| epoch.written(seconds)).as_deref(), written, "{text}");
        }
    }
}
