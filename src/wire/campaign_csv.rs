//! The campaign as a station's table program writes it: head matter in `# key: value` lines, then one row a dwell.
//!
//! ```text
//! # imu: IMU-07
//! # measured_at: 2026-03-01T08:00:00Z
//! # geometry: skewed
//! # site.latitude_deg: 34.25
//! # gyros: G1 LFG-0101, G2 LFG-0102
//! phase,start_s,duration_s,specific_force_g0_x,...,output_pulse_s_1,output_pulse_s_2
//! static,0,180,0,0,0.99905,...
//! ```
//!
//! Columns are the JSON's names with `_x _y _z`, for the attitude `_w _x _y _z`, for outputs `_1 _2 _3`. They may
//! come in any order, and commas, semicolons or tabs may part them. A byte-order mark and CRLF are fine. Every
//! fault names line and column besides the JSON pointer of the same place.

mod cells;
mod head;
mod write;

pub use write::to_csv;

use cells::{Columns, Row};
use head::Head;

use super::campaign::{CampaignBody, commanded};
use super::file_kind::{FileKind, HEAD, file_kind};
use super::json;
use super::table::at_cell;
use crate::core::campaign::Campaign;
use crate::core::fault::{Fault, Faults};
use crate::core::message::Message;
use crate::message;

/// Reads and checks a campaign in CSV.
///
/// # Errors
/// All faults that could be found, with line and column.
pub fn parse_csv(bytes: &[u8]) -> Result<Campaign, Faults> {
    Ok(parse_csv_as_sent(bytes)?.1)
}

/// As [`parse_csv`], with the document that the table says, number by number as sent.
///
/// # Errors
/// All faults that could be found, with line and column.
pub fn parse_csv_as_sent(bytes: &[u8]) -> Result<(CampaignBody, Campaign), Faults> {
    let text = text_of(bytes)?;
    let mut faults = Faults::default();
    let (head, table_line) = Head::read(text, &mut faults);
    let Some((columns, rows)) = cells::read(text, table_line, &mut faults) else { return Err(faults) };
    if rows.is_empty() {
        faults.push("", message!("table_without_rows"));
    }
    if let Some((told, line)) = head.told.filter(|(told, _)| faults.is_empty() && *told != rows.len()) {
        let broken = message!("dwells_told", told = told, have = rows.len());
        faults.push("/dwells", message!("at_line", line = line, fault = broken));
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let mut body = match json::parse::<CampaignBody>(head.document.to_string().as_bytes()) {
        Ok(body) => body,
        Err(part) => {
            located(part, &head, &columns, &rows, &mut faults);
            return Err(faults);
        }
    };
    columns.check_outputs(body.gyros.len(), &mut faults);
    if !faults.is_empty() {
        return Err(faults);
    }
    body.dwells = rows.iter().map(|row| row.dwell(&columns)).collect();
    match body.to_core().and_then(|campaign| commanded::check(&campaign).map(|()| campaign)) {
        Ok(campaign) => Ok((body, campaign)),
        Err(part) => {
            located(part, &head, &columns, &rows, &mut faults);
            Err(faults)
        }
    }
}

fn text_of(bytes: &[u8]) -> Result<&str, Faults> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(fault("", message!("utf16")));
    }
    let bytes = json::without_mark(bytes);
    match file_kind(&bytes[..bytes.len().min(HEAD)]) {
        Ok(FileKind::Text) => {}
        Ok(FileKind::Utf16 { .. }) => return Err(fault("", message!("utf16"))),
        Ok(kind) => return Err(fault("", message!("file_is_no_text", name = kind.name()))),
        // What is text is said by line and column.
        Err(what) if what.code == "file_is_json" || std::str::from_utf8(bytes).is_ok() => {}
        Err(what) => return Err(fault("", what)),
    }
    let written = bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    if written < bytes.len() {
        let line = 1 + memchr::memchr_iter(b'\n', &bytes[..written]).count();
        return Err(fault("", message!("at_line", line = line, fault = message!("zeros_from_here"))));
    }
    std::str::from_utf8(bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        fault("", message!("at_line", line = line, fault = message!("not_utf8_text")))
    })
}

fn fault(pointer: &str, message: Message) -> Faults {
    Fault { pointer: pointer.to_owned(), message }.into()
}

/// Adds the line and column to faults that only know their JSON pointer.
fn located(part: Faults, head: &Head, columns: &Columns, rows: &[Row], faults: &mut Faults) {
    for fault in part.0 {
        let message = placed(fault.message, &fault.pointer, head, columns, rows);
        faults.push(fault.pointer, message);
    }
}

fn placed(fault: Message, pointer: &str, head: &Head, columns: &Columns, rows: &[Row]) -> Message {
    let mut tokens = pointer.split('/').skip(1);
    let first = tokens.next().unwrap_or_default();
    if first != "dwells" {
        return match head.line_of(pointer) {
            Some(line) => message!("at_line_key", line = line, key = first.to_owned(), fault = fault),
            None => message!("at_head_line", key = first.to_owned(), fault = fault),
        };
    }
    let row = tokens.next().and_then(|i| i.parse::<usize>().ok()).and_then(|i| rows.get(i));
    let (Some(row), Some(field)) = (row, tokens.next()) else { return fault };
    match columns.place(field, tokens.next().and_then(|k| k.parse().ok())) {
        Some((number, name)) => at_cell((row.line, number), name, fault),
        None => message!("at_line_key", line = row.line, key = field.to_owned(), fault = fault),
    }
}

#[cfg(test)]
mod tests;
