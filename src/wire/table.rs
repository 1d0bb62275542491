//! What tables have in common: their delimiter, the comments above them, cells, and names of columns.

use crate::core::message::{Message, sent};
use crate::core::name::distance;
use crate::core::note::Note;
use crate::message;

/// The bytes from a line on; lines end in LF or CRLF.
fn rest_from(text: &str, line: usize) -> &[u8] {
    let start = text.split_inclusive('\n').take(line).map(str::len).sum::<usize>();
    &text.as_bytes()[start..]
}

/// Reads the table whose header is a line of the text, counted from 0.
pub(super) fn reader(text: &str, header: usize) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(delimiter_of(text.lines().nth(header).unwrap_or_default()))
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(rest_from(text, header))
}

/// Of a table whose last line has no end: that line, and its last cell. Where the file was cut, both may be more.
pub fn open_end(text: &[u8]) -> Option<Note> {
    let last = text.rsplit(|&b| b == b'\n').next()?.trim_ascii_end();
    // Carriage returns end lines too, and a comment is no row.
    if text.ends_with(b"\r") || last.is_empty() || last.starts_with(b"#") {
        return None;
    }
    let value = last.rsplit(|b| matches!(b, b',' | b';' | b'\t')).next()?.trim_ascii();
    let line = 1 + memchr::memchr_iter(b'\n', text).count();
    Some(Note::NoLineEnd { line, value: String::from_utf8_lossy(value).into_owned() })
}

fn delimiter_of(header: &str) -> u8 {
    let count = |d: &u8| header.bytes().filter(|b| b == d).count();
    // The last of equals wins: a header without any is taken for comma-separated.
    [b'\t', b';', b','].into_iter().max_by_key(count).unwrap_or(b',')
}

/// A fault in the cell of a line and column.
pub(super) fn at_cell((line, column): (usize, usize), name: &str, fault: Message) -> Message {
    message!("at_cell", line = line, column = column, name = name.to_owned(), fault = fault)
}

/// An unknown column, with the known one that it most resembles where one is near.
pub(super) fn unknown(name: &str, known: impl Iterator<Item = String>) -> Message {
    let known: Vec<String> = known.collect();
    match nearest(name, known.iter().map(String::as_str), 3) {
        Some(known) => message!("unknown_column_like", name = sent(name), known = sent(known)),
        None => message!("unknown_column", name = sent(name)),
    }
}

/// The known name that another most resembles, upper and lower case aside; none where it differs in more letters than
/// one and one in each `length`.
pub fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>, length: usize) -> Option<&'a str> {
    let name = name.to_lowercase();
    let near = |known: &'a str| Some((distance(&name, &known.to_lowercase(), 1 + known.len() / length)?, known));
    known.filter_map(near).min().map(|(_, known)| known)
}

/// A number with a decimal point.
pub(super) fn number(text: &str) -> Result<f64, Message> {
    let parsed = text.parse::<f64>().ok();
    match parsed {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(message!("not_finite", value = sent(text))),
        None if text.replacen(',', ".", 1).parse::<f64>().is_ok() => Err(message!("decimal_comma", value = sent(text))),
        None => Err(message!("not_a_number", value = sent(text))),
    }
}

/// The text of a `#` line, also where a spreadsheet has put it in quotes or padded it with delimiters.
pub(super) fn comment(line: &str) -> Option<String> {
    let line = line.trim_end_matches([',', ';', '\t', ' ', '\r']);
    if let Some(comment) = line.strip_prefix('#') {
        return Some(comment.to_owned());
    }
    let quoted = line.strip_prefix("\"#")?.strip_suffix('"')?;
    Some(quoted.replace("\"\"", "\""))
}
