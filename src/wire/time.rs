//! Instants on the wire: RFC 3339 with an offset in, RFC 3339 in UTC out.

use crate::wire::prelude::*;
use std::fmt::{self, Display, Formatter};

use jiff::Timestamp;
use jiff::civil::DateTime;

/// Reads an RFC 3339 time (section 5.6): date, `T`, time with seconds, `Z` or `+hh:mm`. Digits beyond
/// microseconds are cut off. A leap second (`:60`) that there was is read as the second after it, as POSIX time counts.
pub fn parse(text: &str) -> Result<UtcMicros, Message> {
    let shape = StampShape::of(text).ok_or(message!("not_rfc3339"))?;
    if !shape.has_offset {
        return Err(message!("no_utc_offset"));
    }
    if shape.offset_hours > 23 || shape.offset_minutes > 59 {
        return Err(message!("utc_offset_range"));
    }
    let instant: Timestamp = text.parse().map_err(|_| match text[..19].parse::<DateTime>() {
        Ok(_) => message!("after_last_time", last = format(UtcMicros(i64::MAX))),
        Err(_) => message!("not_in_calendar"),
    })?;
    let instant = if shape.leap_second { after_leap_second(instant)? } else { UtcMicros(instant.as_microsecond()) };
    // It is written in UTC, and RFC 3339 has no year before 0.
    if instant.date().year < 0 {
        return Err(message!("before_year_0"));
    }
    Ok(instant)
}

/// Reads the beginning of a stretch of time: an RFC 3339 time, or a day, which begins at midnight UTC.
pub fn parse_start(text: &str) -> Result<UtcMicros, Message> {
    if is_day(text) { parse(&format!("{text}T00:00:00Z")) } else { parse(text).map_err(or_day) }
}

/// Reads the end of a stretch of time, itself included: an RFC 3339 time, or a day (UTC), which is in it as a whole.
pub fn parse_end(text: &str) -> Result<UtcMicros, Message> {
    if is_day(text) { Ok(UtcMicros(parse_start(text)?.0 + UtcMicros::DAY - 1)) } else { parse(text).map_err(or_day) }
}

fn or_day(fault: Message) -> Message {
    if fault.code == "not_rfc3339" { message!("not_day_or_rfc3339") } else { fault }
}

/// Whether it has the form of a day, `2026-03-01`.
pub fn is_day(text: &str) -> bool {
    text.len() == 10 && text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'-')
}

/// Writes an instant in UTC with as many digits as it needs.
pub fn format(instant: UtcMicros) -> String {
    Stamp(instant).to_string()
}

/// An instant as it is written; what no calendar of four-digit years holds, as the end of that calendar.
#[derive(Clone, Copy)]
pub struct Stamp(pub UtcMicros);

impl Display for Stamp {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [first, last] = [Timestamp::MIN, Timestamp::MAX].map(|end| end.as_second() * UtcMicros::SECOND);
        Timestamp::from_microsecond(self.0.0.clamp(first, last)).map_err(|_| fmt::Error)?.fmt(f)
    }
}

/// The leap seconds that there were (IERS Bulletin C): at the ends of these Junes and Decembers. None has been announced
/// since; a further one comes with a later version.
const JUNES: [i16; 11] = [1972, 1981, 1982, 1983, 1985, 1992, 1993, 1994, 1997, 2012, 2015];
const DECEMBERS: [i16; 16] =
    [1972, 1973, 1974, 1975, 1976, 1977, 1978, 1979, 1987, 1989, 1990, 1995, 1998, 2005, 2008, 2016];

/// Elsewhere `:60` is an error of the sender.
fn after_leap_second(read_as_59: Timestamp) -> Result<UtcMicros, Message> {
    let second = read_as_59.to_zoned(jiff::tz::TimeZone::UTC);
    let is_leap = match (second.month(), second.day(), second.hour(), second.minute()) {
        (6, 30, 23, 59) => JUNES.contains(&second.year()),
        (12, 31, 23, 59) => DECEMBERS.contains(&second.year()),
        _ => false,
    };
    let next = UtcMicros((read_as_59.as_second() + 1) * UtcMicros::SECOND);
    if is_leap { Ok(next) } else { Err(message!("no_leap_second")) }
}

/// What the digits do not show: whether there is an offset, whether the second is the 60th.
struct StampShape {
    has_offset: bool,
    offset_hours: u8,
    offset_minutes: u8,
    leap_second: bool,
}

impl StampShape {
    /// None where `text` is not `YYYY-MM-DDThh:mm:ss`, an optional fraction and an optional offset.
    fn of(text: &str) -> Option<Self> {
        let bytes = text.as_bytes();
        let (head, mut rest) = (bytes.get(..19)?, &bytes[19..]);
        let pattern = b"dddd-dd-ddTdd:dd:dd";
        let fits = head.iter().zip(pattern).all(|(&b, &p)| match p {
            b'd' => b.is_ascii_digit(),
            b'T' => b == b'T' || b == b't',
            _ => b == p,
        });
        if !fits {
            return None;
        }
        if rest.first() == Some(&b'.') {
            let digits = rest[1..].iter().take_while(|b| b.is_ascii_digit()).count();
            if !(1..=9).contains(&digits) {
                return None;
            }
            rest = &rest[1 + digits..];
        }
        let two = |a: u8, b: u8| (a.is_ascii_digit() && b.is_ascii_digit()).then(|| (a - b'0') * 10 + (b - b'0'));
        let (has_offset, offset_hours, offset_minutes) = match *rest {
            [] => (false, 0, 0),
            [b'Z' | b'z'] => (true, 0, 0),
            [b'+' | b'-', a, b, b':', c, d] => (true, two(a, b)?, two(c, d)?),
            _ => return None,
        };
        Some(Self { has_offset, offset_hours, offset_minutes, leap_second: &head[17..] == b"60" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(text: &str) -> String {
        format(parse(text).unwrap())
    }

    #[test]
    fn an_instant_is_the_same_in_every_offset() {
        assert_eq!(written("2026-03-01T08:00:00Z"), "2026-03-01T08:00:00Z");
        assert_eq!(written("2026-03-01T16:00:00+08:00"), "2026-03-01T08:00:00Z");
        assert_eq!(written("2026-03-01t08:00:00.250z"), "2026-03-01T08:00:00.25Z");
        assert_eq!(parse("1970-01-01T00:00:00.000001999Z"), Ok(UtcMicros(1)));
        assert_eq!(written("0000-01-01T08:00:00+08:00"), "0000-01-01T00:00:00Z");
    }

    #[test]
    fn no_instant_is_too_early_or_too_late_to_be_written() {
        assert_eq!(format(UtcMicros(i64::MAX)), "9999-12-30T22:00:00Z");
        assert_eq!(format(UtcMicros(i64::MIN)), "-009999-01-02T01:59:59Z");
    }

    #[test]
    fn what_is_no_instant_is_refused() {
        for (text, code) in [
            ("2026-03-01T08:00:00", "no_utc_offset"),
            ("2026-03-01T08:00:00+99:99", "utc_offset_range"),
            ("2026-03-01 08:00:00Z", "not_rfc3339"),
            ("2026-03-01T08:00Z", "not_rfc3339"),
            ("2026-03-01", "not_rfc3339"),
            ("yesterday", "not_rfc3339"),
            ("2026-02-30T08:00:00Z", "not_in_calendar"),
            ("2026-03-01T24:00:00Z", "not_in_calendar"),
            ("2026-03-01T08:00:60Z", "no_leap_second"),
            ("2026-06-30T23:59:60Z", "no_leap_second"),
            ("2016-06-30T23:59:60Z", "no_leap_second"),
            ("9999-12-31T23:59:59Z", "after_last_time"),
            ("2026-03-01T08:00:00[UTC]", "not_rfc3339"),
            ("0000-01-01T08:00:00+08:01", "before_year_0"),
        ] {
            assert_eq!(parse(text).unwrap_err().code, code, "{text}");
        }
    }

    #[test]
    fn a_stretch_has_the_whole_of_its_first_and_last_day() {
        let ends = |from, to| [parse_start(from), parse_end(to)].map(|end| format(end.unwrap()));
        assert_eq!(ends("2026-03-01", "2026-03-02"), ["2026-03-01T00:00:00Z", "2026-03-02T23:59:59.999999Z"]);
        assert_eq!(
            ends("2026-03-01T08:00:00+08:00", "2026-03-02T08:00:00Z"),
            ["2026-03-01T00:00:00Z", "2026-03-02T08:00:00Z"]
        );
        for (text, code) in [
            ("2026-02-30", "not_in_calendar"),
            ("2026-3-1", "not_day_or_rfc3339"),
            ("01.03.2026", "not_day_or_rfc3339"),
        ] {
            assert_eq!([parse_start(text), parse_end(text)].map(|end| end.unwrap_err().code), [code; 2], "{text}");
        }
    }

    #[test]
    fn a_real_leap_second_counts_as_the_second_after_it() {
        assert_eq!(written("2016-12-31T23:59:60Z"), "2017-01-01T00:00:00Z");
        assert_eq!(written("2017-01-01T07:59:60+08:00"), "2017-01-01T00:00:00Z");
        assert_eq!(written("2015-06-30T23:59:60.5Z"), "2015-07-01T00:00:00Z");
    }
}
