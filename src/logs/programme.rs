//! A table's programme as CSV or xlsx: a row per position or turn, in the order in which the table went through them.

use nalgebra::Vector3;

use super::error::LogError;
use super::sheet::readable_table;
use super::source::log_column_unknown;
use crate::core::dwells::programme::{Position, attitude, twenty_four};
use crate::core::frames::Rotation;
use crate::core::message::{Message, sent};
use crate::message;
use crate::wire::table::{RecordLines, header_line, reader};

/// The name of the built-in programme.
pub const TWENTY_FOUR: &str = "24";

const COLUMNS: [&str; 10] = [
    "up",
    "north",
    "rate_deg_s",
    "rate_arcsec_s",
    "start_s",
    "duration_s",
    "attitude_w",
    "attitude_x",
    "attitude_y",
    "attitude_z",
];

/// The built-in programme of this name, or the one in a file.
pub fn read(choice: &str) -> Result<Vec<Position>, LogError> {
    if choice == TWENTY_FOUR {
        return Ok(twenty_four());
    }
    let fail = super::error::unreadable(choice);
    let bytes = std::fs::read(choice).map_err(fail)?;
    readable_table(bytes).and_then(|text| parse(&text)).map_err(|fault| LogError::new(choice, fault))
}

/// As [`read`], of its text in place of a file's name.
pub fn of_text(text: &str) -> Result<Vec<Position>, Message> {
    if text.trim() == TWENTY_FOUR { Ok(twenty_four()) } else { parse(text) }
}

fn parse(text: &str) -> Result<Vec<Position>, Message> {
    let first = header_line(text).unwrap_or_default();
    let mut reader = reader(text, first);
    let mut records = reader.records();
    let header = records.next().transpose().map_err(Message::verbatim)?.unwrap_or_default();
    let names: Vec<&str> = header.iter().map(named).collect::<Result<_, _>>()?;
    let again = |(k, name): (usize, &&str)| !name.is_empty() && names[..k].contains(name);
    if let Some((_, name)) = names.iter().enumerate().find(|column| again(*column)) {
        return Err(message!("second_column", name = sent(name)));
    }
    let (mut found, mut lines) = (Vec::new(), RecordLines::new(text, first));
    for record in records {
        let record = record.map_err(Message::verbatim)?;
        if record.iter().all(str::is_empty) {
            continue;
        }
        let line = lines.of(&record);
        let position = position(&names, &record).map_err(|fault| message!("at_line", line, fault))?;
        found.push(position);
    }
    if found.is_empty() { Err(message!("programme_empty")) } else { Ok(found) }
}

/// The column of a heading, in whichever case and with blanks or lines between its words.
fn named(heading: &str) -> Result<&'static str, Message> {
    let plain = heading.to_lowercase().replace([' ', '-'], "_");
    match COLUMNS.iter().find(|column| **column == plain) {
        Some(column) => Ok(column),
        None if heading.is_empty() => Ok(""),
        None => Err(log_column_unknown(heading, COLUMNS.iter().copied())),
    }
}

fn position(names: &[&str], record: &csv::StringRecord) -> Result<Position, Message> {
    if record.iter().skip(names.len()).any(|cell| !cell.is_empty()) {
        return Err(message!("row_too_long", cells = names.len()));
    }
    let cell = |name: &str| {
        let place = names.iter().position(|own| *own == name)?;
        record.get(place).filter(|cell| !cell.is_empty())
    };
    let number = |name: &'static str| cell(name).map(|cell| value(name, cell)).transpose();
    let quaternion = [number("attitude_w")?, number("attitude_x")?, number("attitude_y")?, number("attitude_z")?];
    let attitude = match (quaternion, cell("up"), cell("north")) {
        ([Some(w), Some(x), Some(y), Some(z)], None, None) => Rotation::from_attitude([w, x, y, z]),
        ([None, None, None, None], Some(up), Some(north)) => attitude(axis(up)?, axis(north)?)
            .ok_or_else(|| message!("programme_parallel", up = sent(up), north = sent(north)))?,
        _ => return Err(message!("programme_attitude")),
    };
    let rates = [number("rate_deg_s")?.map(|rate| 3600.0 * rate), number("rate_arcsec_s")?];
    let start_s = number("start_s")?;
    Ok(Position {
        attitude,
        turn_arcsec_s: rates.into_iter().flatten().next().unwrap_or(0.0),
        start_s: start_s.filter(|_| cell("duration_s").is_some()),
        duration_s: number("duration_s")?,
    })
}

fn value(name: &'static str, cell: &str) -> Result<f64, Message> {
    let parsed = cell.replacen(',', ".", 1).parse::<f64>().ok().filter(|v| v.is_finite());
    let fault = || message!("at_programme_column", name, fault = message!("not_a_number", value = sent(cell)));
    parsed.ok_or_else(fault)
}

/// `+X`, `-Z`, `y`, or three numbers in body axes.
pub fn axis(text: &str) -> Result<Vector3<f64>, Message> {
    let plain = text.trim().to_lowercase();
    let (sign, name) = match plain.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, plain.strip_prefix('+').unwrap_or(&plain)),
    };
    let unit = match name {
        "x" => Some(Vector3::x()),
        "y" => Some(Vector3::y()),
        "z" => Some(Vector3::z()),
        _ => None,
    };
    if let Some(unit) = unit {
        return Ok(sign * unit);
    }
    let numbers: Option<Vec<f64>> = plain.split_whitespace().map(|part| part.parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if x * x + y * y + z * z > 0.0 => Ok(Vector3::new(x, y, z)),
        _ => Err(message!("not_an_axis", text = sent(text))),
    }
}

/// `east`, `north`, `up`, with a minus for the opposite.
pub fn earth_axis(text: &str) -> Result<Vector3<f64>, Message> {
    let plain = text.trim().to_lowercase();
    let (sign, name) = plain.strip_prefix('-').map_or((1.0, plain.as_str()), |rest| (-1.0, rest));
    match name {
        "east" => Ok(sign * Vector3::x()),
        "north" => Ok(sign * Vector3::y()),
        "up" => Ok(sign * Vector3::z()),
        _ => Err(message!("not_an_earth_axis", text = sent(text))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_axes_or_attitudes_and_turns_have_rates() {
        let rows = parse("up,north,rate_deg_s,start_s,duration_s\n+Z,+Y,,0,180\n-x,+z,-0.1,240,180\n").unwrap();
        // Z up, Y north: body and nav coincide.
        assert_eq!(rows[0].attitude.to_attitude(), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!((rows[0].turn_arcsec_s, rows[1].turn_arcsec_s), (0.0, -360.0));
        assert_eq!((rows[1].start_s, rows[1].duration_s), (Some(240.0), Some(180.0)));
        assert!((rows[1].up() + Vector3::x()).norm() < 1e-12);
        let same = parse("attitude_w;attitude_x;attitude_y;attitude_z\n0,5;0,5;0,5;0,5\n").unwrap();
        assert_eq!(same.len(), 1);
        let loud = parse("Up,NORTH,Rate deg-s\n+Z,+Y,0.1\n").unwrap();
        assert_eq!(loud[0].turn_arcsec_s, 360.0);
    }

    #[test]
    fn what_is_no_position_is_said_with_its_line() {
        let code = |text: &str| match parse(text).unwrap_err() {
            fault if fault.code == "at_line" => format!("{:?}", fault.parameter("fault").unwrap()),
            fault => fault.code.into_owned(),
        };
        assert_eq!(code("up,colour\n"), "log_column_unknown");
        let like = parse("up,north,rate [deg/s]\n+Z,+Y,0\n").unwrap_err();
        assert_eq!((like.code.as_ref(), like.parameter("like")), ("log_column_like", Some(&"rate_deg_s".into())));
        assert_eq!(code("up,Up,north\n"), "second_column");
        assert_eq!(code("up,north\n"), "programme_empty");
        assert!(code("up,north\n+Z,-Z\n").contains("programme_parallel"));
        assert!(code("up,north\n+Z,\n").contains("programme_attitude"));
        assert!(code("up,north\n+W,+X\n").contains("not_an_axis"));
        assert!(code("up,north,rate_deg_s\n+Z,+Y,0,5\n").contains("row_too_long"));
    }
}
