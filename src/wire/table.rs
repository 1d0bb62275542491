//! What tables have in common: their delimiter, the comments above them, cells, and names of columns.

use super::file_kind::{FileKind, HEAD, file_kind};
use super::json;
use crate::core::message::sent;
use crate::core::name::distance;
use crate::core::note::Note;
use crate::wire::prelude::*;

/// The bytes from a line on; lines end in LF or CRLF.
fn rest_from(text: &str, line: usize) -> &[u8] {
    let start = text.split_inclusive('\n').take(line).map(str::len).sum::<usize>();
    &text.as_bytes()[start..]
}

/// Reads the table whose header is a line of the text, counted from 0.
pub fn reader(text: &str, header: usize) -> csv::Reader<&[u8]> {
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

/// The line of a table's header, counted from 0: the first with more than a comment.
pub fn header_line(text: &str) -> Option<usize> {
    text.lines().position(|line| !line.trim().is_empty() && comment(line).is_none())
}

/// Lines in which records begin, counted from 1, asked for in the order of the records. Where the reader begins with
/// a record, remarks and empty lines may still stand above it.
pub struct RecordLines<'a> {
    rest: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> RecordLines<'a> {
    /// Of the table whose header is a line of the text, counted from 0.
    pub fn new(text: &'a str, header: usize) -> Self {
        Self { rest: rest_from(text, header), at: 0, line: header + 1 }
    }

    pub fn of(&mut self, record: &csv::StringRecord) -> usize {
        let start = record.position().map_or(self.at, |place| place.byte() as usize);
        let mut begin = start.clamp(self.at, self.rest.len());
        while let Some(first) = self.rest.get(begin) {
            begin += match first {
                b'\r' | b'\n' => 1,
                b'#' => memchr::memchr(b'\n', &self.rest[begin..]).unwrap_or(self.rest.len() - begin),
                _ => break,
            };
        }
        self.line += memchr::memchr_iter(b'\n', &self.rest[self.at..begin]).count();
        self.at = begin;
        self.line
    }
}

/// The rows that are not empty, each with its line counted from 1, of the table whose header is a line of the text.
pub(super) fn rows(
    records: csv::StringRecordsIter<'_, &[u8]>,
    (text, header): (&str, usize),
    pointer: &str,
    faults: &mut Faults,
) -> Vec<(usize, csv::StringRecord)> {
    let (mut rows, mut lines) = (Vec::new(), RecordLines::new(text, header));
    for record in records {
        match record {
            Ok(record) if record.iter().all(str::is_empty) => {}
            Ok(record) => rows.push((lines.of(&record), record)),
            Err(error) => faults.push(pointer, message!("table_unreadable", why = format_args!("{error}"))),
        }
    }
    rows
}

pub(super) fn too_many_cells(line: usize, cells: usize, columns: usize) -> Message {
    let fault = message!("cells_under_columns", cells, columns);
    message!("at_column", line, column = columns + 1, fault)
}

pub(super) fn at_cell((line, column): (usize, usize), name: &str, fault: Message) -> Message {
    message!("at_cell", line, column, name = name.to_owned(), fault)
}

/// An unknown column, with the known one that was meant where one can be told.
pub(super) fn unknown(name: &str, known: impl Iterator<Item = String>) -> Message {
    match meant(name, known) {
        Some(known) if without_unit(name) != name => {
            message!("unknown_column_with_unit", name = sent(name), known)
        }
        Some(known) => message!("unknown_column_like", name = sent(name), known),
        None => message!("unknown_column", name = sent(name)),
    }
}

/// What people call columns, and the beginning of ours.
const CALLED: [(&str, &str); 6] = [
    ("acc", "specific_force_g0"),
    ("force", "specific_force_g0"),
    ("gyr", "output_pulse_s"),
    ("pulse", "output_pulse_s"),
    ("omega", "rate_arcsec_s"),
    ("serial", "serial"),
];

/// The known column that another most resembles, its unit aside; else the one that it begins, or is called otherwise.
pub(super) fn meant(name: &str, known: impl Iterator<Item = String>) -> Option<String> {
    const LEAST: usize = 3;
    let known: Vec<String> = known.collect();
    let bare = without_unit(name).to_lowercase();
    let begins = || known.iter().find(|own| bare.len() > LEAST && own.starts_with(&bare)).map(String::as_str);
    let called = || {
        let (_, ours) = CALLED.iter().find(|(theirs, _)| bare.starts_with(theirs))?;
        let part = bare.rfind('_').map_or("", |at| &bare[at..]);
        known.iter().find(|own| own.strip_prefix(ours).is_some_and(|rest| rest == part)).map(String::as_str)
    };
    nearest(&bare, known.iter().map(String::as_str), LEAST).or_else(begins).or_else(called).map(str::to_owned)
}

/// A heading without the unit in brackets behind it.
fn without_unit(name: &str) -> &str {
    let open = name.rfind(['(', '[', '（']).filter(|&at| at > 0 && name.ends_with([')', ']', '）']));
    open.map_or(name, |at| name[..at].trim_end())
}

/// The text of a table.
///
/// # Errors
/// What the file is, where it is no text; line and cell of what is no UTF-8.
pub(super) fn text_of(bytes: &[u8]) -> Result<&str, Faults> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(message!("utf16").into());
    }
    let bytes = json::without_mark(bytes);
    match file_kind(&bytes[..bytes.len().min(HEAD)]) {
        Ok(FileKind::Text) => {}
        Ok(FileKind::Utf16 { .. }) => return Err(message!("utf16").into()),
        Ok(kind) => return Err(message!("file_is_no_text", name = kind.name()).into()),
        // What is text is said by line and column.
        Err(what) if what.code == "file_is_json" || std::str::from_utf8(bytes).is_ok() => {}
        Err(what) => return Err(what.into()),
    }
    let written = bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    if written < bytes.len() {
        let line = 1 + memchr::memchr_iter(b'\n', &bytes[..written]).count();
        return Err(message!("at_line", line, fault = message!("zeros_from_here")).into());
    }
    std::str::from_utf8(bytes).map_err(|e| {
        let before = String::from_utf8_lossy(&bytes[..e.valid_up_to()]);
        let line = before.matches('\n').count() + 1;
        let cells = before.rsplit('\n').next().unwrap_or_default();
        let delimiter = delimiter_of(before.lines().find(|line| comment(line).is_none()).unwrap_or_default());
        let column = 1 + cells.bytes().filter(|&b| b == delimiter).count();
        match comment(cells) {
            Some(_) => message!("at_line", line, fault = message!("not_utf8_text")).into(),
            None => message!("at_column", line, column, fault = message!("not_utf8_text")).into(),
        }
    })
}

/// What is wrong with the quotation marks of the table whose header is a line of the text: a cell whose mark is never
/// closed would swallow the rows below it, and text behind a closing mark is part of nothing.
pub(super) fn check_quotes(text: &str, header: usize) -> Result<(), Message> {
    let delimiter = delimiter_of(text.lines().nth(header).unwrap_or_default());
    let rest = rest_from(text, header);
    let (mut line, mut column, mut at) = (header + 1, 1_usize, 0);
    while at < rest.len() {
        let begins_row = column == 1;
        match rest[at] {
            b'#' if begins_row => at += memchr::memchr(b'\n', &rest[at..]).unwrap_or(rest.len() - at),
            b'"' => {
                let fault = |code: fn() -> Message| message!("at_column", line, column, fault = code());
                let closing = closing_quote(&rest[at + 1..]).ok_or_else(|| fault(|| message!("quote_open")))?;
                let cell = &rest[at + 1..at + 1 + closing];
                at += closing + 2;
                let behind = rest[at..].iter().find(|b| **b != b' ').copied();
                if !behind.is_none_or(|b| b == delimiter || b == b'\n' || b == b'\r') {
                    return Err(fault(|| message!("quote_within")));
                }
                line += memchr::memchr_iter(b'\n', cell).count();
                at += rest[at..].iter().position(|&b| b == delimiter || b == b'\n').unwrap_or(rest.len() - at);
            }
            _ => at += rest[at..].iter().position(|&b| b == delimiter || b == b'\n').unwrap_or(rest.len() - at),
        }
        match rest.get(at) {
            Some(b'\n') => (line, column) = (line + 1, 1),
            _ => column += 1,
        }
        at += 1;
    }
    Ok(())
}

/// Where the quotation mark that closes a cell is; two are one within it.
fn closing_quote(cell: &[u8]) -> Option<usize> {
    let mut from = 0;
    loop {
        let at = from + memchr::memchr(b'"', &cell[from..])?;
        if cell.get(at + 1) != Some(&b'"') {
            return Some(at);
        }
        from = at + 2;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_column_that_was_meant_is_found_beside_units_and_other_names() {
        let known = || {
            let vector = ["_x", "_y", "_z"].map(|axis| format!("specific_force_g0{axis}"));
            ["start_s", "temperature_c", "output_pulse_s_1"].map(str::to_owned).into_iter().chain(vector)
        };
        for (name, expected) in [
            ("Temp (°F)", Some("temperature_c")),
            ("temperature_c [°C]", Some("temperature_c")),
            ("Start_s [s]", Some("start_s")),
            ("accel_x [m/s2]", Some("specific_force_g0_x")),
            ("pulses_1", Some("output_pulse_s_1")),
            ("colour", None),
        ] {
            assert_eq!(meant(name, known()).as_deref(), expected, "{name}");
        }
        assert_eq!(unknown("Temp (°F)", known()).code, "unknown_column_with_unit");
        assert_eq!(unknown("start_", known()).code, "unknown_column_like");
    }

    #[test]
    fn a_quotation_mark_that_is_cut_off_is_found_where_it_opens() {
        let place = |text: &str| match check_quotes(text, 0) {
            Ok(()) => None,
            Err(fault) => {
                let of = |name: &str| format!("{:?}", fault.parameter(name).unwrap());
                Some((of("line"), of("column"), of("fault")))
            }
        };
        for sound in ["a,b\n1,2\n", "a,b\n\"1\",\"x \"\"y\"\" z\"\n", "a;b\n\"1\n2\" ;3\r\n# \"\n4;5", "a,b\n5\",6\n"] {
            assert_eq!(place(sound), None, "{sound}");
        }
        for (text, line, column, code) in [
            ("a,b\n1,\"2\n3,4\n", 2, 2, "quote_open"),
            ("a,b\n\"1\n2\",3\n4,\"5\n", 4, 2, "quote_open"),
            ("a,b\n1,\"2\n3,\"4\"\n", 2, 2, "quote_within"),
            ("a,b\n\"1\"x,2\n", 2, 1, "quote_within"),
        ] {
            let (at_line, at_column, fault) = place(text).expect(text);
            let is = |found: &str, expected: usize| found.contains(&format!("({expected})"));
            assert!(
                is(&at_line, line) && is(&at_column, column) && fault.contains(code),
                "{text}: {at_line} {at_column} {fault}"
            );
        }
    }

    #[test]
    fn what_is_no_utf8_is_named_by_line_and_cell() {
        let faults = text_of(b"# note\nserial;batch\nA-1;B\xff\n").unwrap_err();
        let said = crate::words::Language::English.words(&faults.0[0].message);
        assert!(said.starts_with("line 3, column 2: not UTF-8"), "{said}");
    }
}
