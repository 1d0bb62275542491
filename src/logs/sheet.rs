//! A campaign that somebody keeps in a workbook: its first sheet as the CSV that it would be saved as.

use std::io::Cursor;

use calamine::{Data, Reader, Xlsx};

use super::text::{of_any, of_gbk, of_utf16, with_line_feeds};
use crate::core::message::Message;
use crate::message;
use crate::wire::document::is_csv;
use crate::wire::file_kind::{FileKind, HEAD, file_kind};

/// The first sheet as CSV: a line a row, cells parted by commas, head matter as it stands.
fn to_csv(bytes: &[u8]) -> Result<String, Message> {
    let broken = |error: calamine::XlsxError| message!("xlsx_broken", why = format_args!("{error}"));
    let mut book: Xlsx<_> = Xlsx::new(Cursor::new(bytes)).map_err(broken)?;
    let first = book.sheet_names().first().cloned().ok_or_else(|| message!("xlsx_no_table"))?;
    let range = book.worksheet_range(&first).map_err(broken)?;
    let mut text = String::new();
    for row in range.rows() {
        let filled = row.iter().rposition(|cell| !matches!(cell, Data::Empty)).map_or(0, |last| last + 1);
        let cells: Vec<String> = row[..filled].iter().map(cell).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    Ok(text)
}

fn cell(cell: &Data) -> String {
    match cell {
        Data::Float(value) => value.to_string(),
        Data::Int(value) => value.to_string(),
        Data::String(text) if !text.starts_with('#') && text.contains([',', '"', '\n']) => {
            format!("\"{}\"", text.replace('"', "\"\""))
        }
        // A workbook knows no offset from UTC: what reads the table has to say it.
        Data::DateTime(at) if at.is_datetime() => {
            let (year, month, day, hour, minute, second, _) = at.to_ymd_hms_milli();
            format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}")
        }
        other => other.to_string(),
    }
}

/// The text of a table of any encoding, or of a workbook.
pub fn readable_table(bytes: Vec<u8>) -> Result<String, Message> {
    file_kind(&bytes[..bytes.len().min(HEAD)])?;
    readable(bytes).map(|bytes| of_any(&bytes))
}

/// The bytes of a document; of UTF-16 and of a table in GBK those of UTF-8, of a workbook the CSV that it would be saved
/// as.
pub fn readable(bytes: Vec<u8>) -> Result<Vec<u8>, Message> {
    if bytes.trim_ascii().is_empty() {
        return Err(message!("file_is_empty"));
    }
    if !is_csv(&bytes) {
        return Ok(bytes);
    }
    match file_kind(&bytes[..bytes.len().min(HEAD)])? {
        FileKind::Xlsx => to_csv(&bytes).map(String::into_bytes),
        FileKind::Text => {
            let bytes = with_line_feeds(bytes);
            let text = bytes.iter().rposition(|&b| b != 0).map_or(0, |last| last + 1);
            if text < bytes.len() {
                let line = 1 + bytes[..text].iter().filter(|&&b| b == b'\n').count();
                return Err(message!("at_line", line, fault = message!("zeros_from_here")));
            }
            Ok(of_gbk(&bytes).map_or(bytes, String::into_bytes))
        }
        FileKind::Utf16 { big_endian } => Ok(of_utf16(&bytes, big_endian).into_bytes()),
        log @ (FileKind::Mat5 | FileKind::Npy | FileKind::Npz | FileKind::Parquet) => {
            Err(message!("file_is_log", name = log.name()))
        }
    }
}
