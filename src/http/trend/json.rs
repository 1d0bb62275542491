//! A trend as JSON: what serde writes, byte for byte, in a fraction of the time. There may be a hundred thousand
//! points, and serde looks through every word of each for what has to be escaped.

use std::io::Write;

use super::body::{LEVELS, Point, PointColumn, Trend};
use crate::wire::time::Stamp;

/// A point takes about 220 bytes; growing would copy hundreds of kilobytes again and again.
const POINT: usize = 256;
/// And one member of it, in a list of its own, on average.
const COLUMN: usize = 20;

pub(super) fn written(trend: &Trend<'_>) -> Option<Vec<u8>> {
    let mut text = Vec::with_capacity(POINT * (trend.points.len() + 2));
    write(trend, &mut text).ok()?;
    Some(text)
}

fn write(trend: &Trend<'_>, text: &mut Vec<u8>) -> std::io::Result<()> {
    head(trend, text)?;
    text.write_all(b"\"points\":[")?;
    let mut names = [Quoted::default(), Quoted::default()];
    let mut before = '{';
    let heads = PointColumn::ALL.map(|column| format!("{}\"{}\":", std::mem::replace(&mut before, ','), column.name()));
    for (i, point) in trend.points.iter().enumerate() {
        if i > 0 {
            text.push(b',');
        }
        write_point(point, &heads, &mut names, text)?;
    }
    text.push(b']');
    tail(trend, text)
}

/// The points as one list per member.
pub(super) fn columns(trend: &Trend<'_>, of: &[PointColumn], with_levels: bool) -> Option<Vec<u8>> {
    let mut text = Vec::with_capacity(COLUMN * of.len() * (trend.points.len() + 2));
    write_columns(trend, of, with_levels, &mut text).ok()?;
    Some(text)
}

fn write_columns(trend: &Trend<'_>, of: &[PointColumn], with_levels: bool, text: &mut Vec<u8>) -> std::io::Result<()> {
    head(trend, text)?;
    text.write_all(b"\"columns\":{")?;
    for (k, column) in of.iter().enumerate() {
        write!(text, "{}\"{}\":[", if k > 0 { "," } else { "" }, column.name())?;
        let mut names = [Quoted::default(), Quoted::default()];
        for (i, point) in trend.points.iter().enumerate() {
            if i > 0 {
                text.push(b',');
            }
            write_member(*column, point, &mut names, text)?;
        }
        text.push(b']');
    }
    for (name, figure) in if with_levels { &LEVELS[..] } else { &[] } {
        let figures: Vec<_> = trend.points.iter().map(|point| point.level.and_then(figure)).collect();
        write!(text, ",\"{name}\":")?;
        serde_json::to_writer(&mut *text, &figures)?;
    }
    text.push(b'}');
    tail(trend, text)
}

/// What stands before the points.
fn head(trend: &Trend<'_>, text: &mut Vec<u8>) -> std::io::Result<()> {
    text.write_all(b"{\"serial\":")?;
    serde_json::to_writer(&mut *text, trend.serial)?;
    write!(text, ",\"coefficient\":\"{}\",\"unit\":\"{}\",", trend.coefficient, trend.unit)
}

/// What stands after them.
fn tail(trend: &Trend<'_>, text: &mut Vec<u8>) -> std::io::Result<()> {
    text.write_all(b",\"events\":")?;
    serde_json::to_writer(&mut *text, trend.events)?;
    text.write_all(b",\"next\":")?;
    serde_json::to_writer(&mut *text, &trend.next)?;
    text.write_all(b"}")
}

/// What serde writes of a column's member. `names`: of the last IMU and station.
fn write_member<'t>(
    column: PointColumn,
    point: &Point<'t>,
    [imu, station]: &mut [Quoted<'t>; 2],
    text: &mut Vec<u8>,
) -> std::io::Result<()> {
    match column {
        PointColumn::CalibratedAt => write!(text, "\"{}\"", Stamp(point.calibrated_at)),
        PointColumn::Value => Ok(serde_json::to_writer(text, &point.value)?),
        PointColumn::Sd => Ok(serde_json::to_writer(text, &point.sd)?),
        PointColumn::Method => word(Some(point.method), text),
        PointColumn::Imu => match point.imu {
            Some(name) => imu.write(name, text),
            None => text.write_all(b"null"),
        },
        PointColumn::Slot => word(point.slot, text),
        PointColumn::Station => station.write(point.station, text),
        PointColumn::Record => write!(text, "\"{}\"", point.record),
        PointColumn::State => word(point.state, text),
        PointColumn::Status => word(point.status, text),
    }
}

/// `heads`: what stands before each member, made once for all points.
fn write_point<'t>(
    point: &Point<'t>,
    heads: &[String],
    names: &mut [Quoted<'t>; 2],
    text: &mut Vec<u8>,
) -> std::io::Result<()> {
    for (column, head) in PointColumn::ALL.into_iter().zip(heads) {
        text.write_all(head.as_bytes())?;
        write_member(column, point, names, text)?;
    }
    if let Some(voided) = point.voided {
        write!(text, ",\"voided\":{voided}")?;
    }
    if let Some(set_aside) = point.set_aside {
        write!(text, ",\"set_aside\":{set_aside}")?;
    }
    if let Some(level) = point.level {
        text.write_all(b",\"level\":")?;
        serde_json::to_writer(&mut *text, &level)?;
    }
    text.write_all(b"}")
}

/// One of the program's own words, in which nothing has to be escaped.
fn word(word: Option<&'static str>, text: &mut Vec<u8>) -> std::io::Result<()> {
    let Some(word) = word else { return text.write_all(b"null") };
    text.write_all(b"\"")?;
    text.write_all(word.as_bytes())?;
    text.write_all(b"\"")
}

/// A name as JSON, escaped once for the points that have it in a row.
#[derive(Default)]
struct Quoted<'t> {
    name: Option<&'t str>,
    text: Vec<u8>,
}

impl<'t> Quoted<'t> {
    fn write(&mut self, name: &'t str, text: &mut Vec<u8>) -> std::io::Result<()> {
        if self.name != Some(name) {
            self.name = Some(name);
            self.text.clear();
            serde_json::to_writer(&mut self.text, name)?;
        }
        text.write_all(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::super::body::PointLevel;
    use super::*;
    use crate::core::id::Id;
    use crate::core::time::UtcMicros;

    #[test]
    fn it_is_byte_for_byte_what_serde_writes() {
        let values = [2.957642758199023, -0.0, 1e-300, -1.5e21, 0.1, 7.0, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE];
        let names = ["IMU-07", "IMU-07", "a \"quoted\" \\ one", "\u{1}\t\n", "陀螺 é", "", "IMU-07"];
        let words = [Some("within"), None, Some("exceeded")];
        let point = |i: usize| Point {
            calibrated_at: UtcMicros(1_700_000_000_123_456 * i as i64 / 7),
            value: values[i % values.len()],
            sd: (!i.is_multiple_of(3)).then_some(values[i * i % values.len()]),
            method: "rigid",
            imu: (!i.is_multiple_of(5)).then_some(names[i % names.len()]),
            slot: (!i.is_multiple_of(4)).then_some("G2"),
            station: names[i * 3 % names.len()],
            record: Id(i as i64 * 123_456_789_012),
            state: words[i % words.len()],
            status: [None, Some("drifting")][i % 2],
            voided: [None, Some(true), Some(false)][i % 3],
            set_aside: [None, Some(true)][i % 2],
            level: (!i.is_multiple_of(6)).then(|| PointLevel {
                baseline: values[i % values.len()],
                lower: (!i.is_multiple_of(4)).then_some(values[i * 5 % values.len()]),
                upper: None,
            }),
        };
        for count in [0, 1, 200] {
            for next in [None, Some("b3".to_owned())] {
                let (points, coefficient, unit) = ((0..count).map(point).collect(), "D_I", "deg/(h*g0)");
                let trend = Trend { serial: "LFG-\"1\"", coefficient, unit, points, events: &[], next };
                let expected = serde_json::to_string(&trend).unwrap();
                assert_eq!(String::from_utf8(written(&trend).unwrap()).unwrap(), expected);
            }
        }
    }
}
