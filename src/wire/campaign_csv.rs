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

pub use write::{body_to_csv, to_csv};

use cells::{DwellRow, DwellTableColumns};
use head::Head;

use super::campaign::{CampaignBody, commanded};
use super::json;
use super::table::{at_cell, text_of};
use crate::core::campaign::Campaign;
use crate::wire::prelude::*;

/// Reads and checks a campaign in CSV.
pub fn parse_csv(bytes: &[u8]) -> Result<Campaign, Faults> {
    Ok(parse_csv_as_sent(bytes)?.1)
}

/// As [`parse_csv`], with the document that the table says, number by number as sent.
pub fn parse_csv_as_sent(bytes: &[u8]) -> Result<(CampaignBody, Campaign), Faults> {
    let text = text_of(bytes)?;
    let mut faults = Faults::default();
    let (head, table_line) = Head::read(text, &mut faults);
    let Some((columns, rows)) = cells::read(text, table_line, &head, &mut faults) else { return Err(faults) };
    if let Some((told, line)) = head.told.filter(|(told, _)| faults.is_empty() && *told != rows.len()) {
        let broken = message!("dwells_told", told, have = rows.len());
        faults.push("/dwells", message!("at_line", line, fault = broken));
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

/// Adds the line and column to faults that only know their JSON pointer.
fn located(part: Faults, head: &Head, columns: &DwellTableColumns, rows: &[DwellRow], faults: &mut Faults) {
    for fault in part.0 {
        let message = placed(fault.message, &fault.pointer, head, columns, rows);
        faults.push(fault.pointer, message);
    }
}

fn placed(fault: Message, pointer: &str, head: &Head, columns: &DwellTableColumns, rows: &[DwellRow]) -> Message {
    let mut tokens = pointer.split('/').skip(1);
    let first = tokens.next().unwrap_or_default();
    if first != "dwells" {
        return match head.line_of(pointer) {
            Some(line) => message!("at_line_key", line, key = first.to_owned(), fault),
            None => message!("at_head_line", key = first.to_owned(), fault),
        };
    }
    let row = tokens.next().and_then(|i| i.parse::<usize>().ok()).and_then(|i| rows.get(i));
    let (Some(row), Some(field)) = (row, tokens.next()) else { return fault };
    match columns.place(field, tokens.next().and_then(|k| k.parse().ok())) {
        Some((number, name)) => at_cell((row.line, number), name, fault),
        None => message!("at_line_key", line = row.line, key = field.to_owned(), fault),
    }
}

#[cfg(test)]
mod tests;
