//! Text tables as loggers write them: any delimiter, decimal commas, a header in brackets, a row of units.

use std::io::{BufRead, BufReader, Cursor, Read};

use super::clock;
use super::column::Column;
use super::error::{LogError, unreadable};
use super::units::QUANTITIES;
use crate::core::message::{Message, sent};
use crate::message;
use crate::wire::file_kind::{FileKind, HEAD, file_kind};

/// Longest line that is a row of a table.
const LONGEST_LINE: u64 = 1 << 20;
/// Rows of the head that the layout is taken from.
const SAMPLED: usize = 60;
/// Share of rows that may be no rows, before the table is refused.
const MOST_BAD: f64 = 0.01;
/// What no station measures in any unit: stamps in ns since 1970 are below.
pub const MOST: f64 = 1e30;
/// Cells in groups of three digits beside whole ones of a group, from which the marks may be those of thousands.
const GROUPED: usize = 20;

/// How a table is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// None: blanks of any number.
    pub delimiter: Option<u8>,
    pub decimal_comma: bool,
    /// Lines before the first row.
    pub skipped: u64,
    /// Cells of a row, at most; those that are empty at its end do not count.
    pub most: usize,
    pub columns: Vec<Column>,
}

/// A text file with its layout.
pub struct TextLog {
    place: String,
    reader: Box<dyn BufRead>,
    pub layout: Layout,
    /// Cells that are no numbers are empty ones: for a first look at what there is.
    pub lenient: bool,
    /// Columns in which times of day or dates were read as seconds.
    pub clocks: Vec<usize>,
    /// Columns that say of which IMU a row is, with what was in them.
    pub ids: Vec<(usize, Ids)>,
}

/// Lines that are left out, and what is wrong in the first.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SkippedLines {
    pub count: usize,
    pub first: Option<Message>,
}

impl SkippedLines {
    /// Adds rows that were left out; the first fault stays.
    pub fn add(&mut self, more: Self) {
        self.count += more.count;
        self.first = self.first.take().or(more.first);
    }

    /// How many rows were left out, with the first fault; nothing if there were none.
    pub fn remark(&self) -> Option<Message> {
        let said = match &self.first {
            Some(fault) => message!("rows_left_out_at", count = self.count, fault = fault.clone()),
            None => message!("rows_left_out", count = self.count),
        };
        (self.count > 0).then_some(said)
    }
}

impl TextLog {
    /// Looks at the layout of what stands at its beginning.
    ///
    /// # Errors
    /// Text without a table; what the operating system says.
    pub fn of(place: &str, from: impl Read + 'static, kind: FileKind) -> Result<Self, LogError> {
        let (mut rest, mut head) = (reader_of(from, kind), Vec::new());
        rest.by_ref().take(HEAD as u64).read_to_end(&mut head).map_err(unreadable(place))?;
        let whole = head.len() < HEAD;
        let text = Cursor::new(head.clone()).chain(rest);
        let reader: Box<dyn Read> =
            if of_carriage_returns(&head) { Box::new(CarriageReturns(text)) } else { Box::new(text) };
        let head = with_line_feeds(head);
        let layout = Layout::of(&head, whole).map_err(|fault| LogError::new(place, fault))?;
        let reader = Box::new(BufReader::with_capacity(1 << 18, reader));
        let of_ids = layout.columns.iter().enumerate().filter(|(_, column)| column.is_id());
        let ids = of_ids.map(|(k, _)| (k, Ids::default())).collect();
        Ok(Self { place: place.to_owned(), reader, layout, lenient: false, clocks: Vec::new(), ids })
    }

    /// The first number of a column, and whether it was read from a time of day or a date. The rows stay to be read.
    pub fn first(&mut self, column: usize) -> Option<(f64, bool)> {
        let (head, layout) = (self.reader.fill_buf().ok()?.to_vec(), self.layout.clone());
        let (place, reader) = (self.place.clone(), Box::new(Cursor::new(head)));
        let mut own = Self { place, reader, layout, lenient: true, clocks: Vec::new(), ids: Vec::new() };
        let mut first = None;
        let each = &mut |values: &[f64]| {
            first = first.or(Some(values[0]).filter(|value| value.is_finite()));
            Ok(())
        };
        // What is wrong with a row is said when it is read.
        own.rows(&[column], each).ok();
        first.map(|first| (first, own.clocks.contains(&column)))
    }

    /// Reads the rows from first to last: the numbers of the columns `wanted`, NaN where a cell is empty.
    /// Returns which lines were no rows.
    ///
    /// # Errors
    /// What `each` refuses, with its line; a table of which more than one row in a hundred cannot be read.
    pub fn rows(
        &mut self,
        wanted: &[usize],
        each: &mut dyn FnMut(&[f64]) -> Result<(), Message>,
    ) -> Result<SkippedLines, LogError> {
        let Layout { delimiter, decimal_comma, skipped, .. } = self.layout;
        let fail = unreadable(&self.place);
        let refuse =
            |line: u64, fault: Message| LogError::new(&self.place, message!("at_line", line = line as usize, fault));
        let marks = wanted.iter().map(|_| Marks::default()).collect();
        let mut cells = Cells { delimiter, decimal_comma, marks, ..Cells::default() };
        let (mut buffer, mut values) = (Vec::new(), vec![f64::NAN; wanted.len()]);
        let (mut line, mut seen) = (0_u64, RowsSeen::default());
        while !seen.are_hopeless() {
            buffer.clear();
            let read = (&mut self.reader).take(LONGEST_LINE).read_until(b'\n', &mut buffer).map_err(&fail)?;
            if read == 0 {
                break;
            }
            line += 1;
            let text = buffer.trim_ascii();
            if line <= skipped || text.is_empty() || is_comment(text) {
                continue;
            }
            if text[0] == 0 {
                return Err(refuse(line, message!("zeros_from_here")));
            }
            if let Some(fault) = self.layout.row(&mut cells, (text, line), (wanted, &mut values), self.lenient) {
                // The last line of a file that was being written breaks off anywhere.
                seen.bad.push(Some(fault).filter(|_| buffer.ends_with(b"\n")));
                continue;
            }
            seen.rows += 1;
            for (column, ids) in &mut self.ids {
                ids.see(cells.cell(text, *column).unwrap_or_default());
            }
            if cells.clocks.len() > self.clocks.len() {
                self.clocks.clone_from(&cells.clocks);
            }
            each(&values).map_err(|fault| refuse(line, fault))?;
        }
        let left_out = seen.left_out().map_err(|fault| LogError::new(&self.place, fault))?;
        match cells.marks.iter().zip(wanted).find(|(marks, _)| marks.are_unclear() && !self.lenient) {
            Some((marks, column)) => {
                let fault = message!("cell_thousands", value = sent(&marks.cell), count = marks.grouped);
                Err(LogError::new(&self.place, self.layout.at(marks.line, *column, fault)))
            }
            None => Ok(left_out),
        }
    }
}

/// How many rows were read, and what is wrong with the lines that are none; nothing is said of one that breaks off.
#[derive(Default)]
struct RowsSeen {
    rows: usize,
    bad: Vec<Option<Message>>,
}

impl RowsSeen {
    fn are_hopeless(&self) -> bool {
        self.bad.len() as f64 > 20.0 + MOST_BAD * self.rows as f64
    }

    fn left_out(self) -> Result<SkippedLines, Message> {
        let (count, serious) = (self.bad.len(), self.bad.iter().flatten().count());
        let (first, rows) = (self.bad.into_iter().flatten().next(), self.rows + serious);
        match first {
            Some(fault) if serious as f64 > MOST_BAD * rows as f64 => {
                Err(message!("rows_unreadable", count = serious, rows, fault))
            }
            first => Ok(SkippedLines { count, first }),
        }
    }
}

fn is_comment(line: &[u8]) -> bool {
    line.starts_with(b"#") || line.starts_with(b"%") || line.starts_with(b"//")
}

fn reader_of(from: impl Read + 'static, kind: FileKind) -> Box<dyn Read> {
    match kind {
        FileKind::Utf16 { big_endian } => Box::new(Utf16::of(BufReader::with_capacity(1 << 18, from), big_endian)),
        _ => Box::new(from),
    }
}

/// Whether lines end in carriage returns alone, as those of old Macintosh programs do.
fn of_carriage_returns(head: &[u8]) -> bool {
    !head.contains(&b'\n') && head.contains(&b'\r')
}

/// Text whose lines end in line feeds.
pub fn with_line_feeds(mut text: Vec<u8>) -> Vec<u8> {
    if of_carriage_returns(&text) {
        in_lines(&mut text);
    }
    text
}

fn in_lines(bytes: &mut [u8]) {
    bytes.iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
}

/// Text with line feeds in place of its carriage returns.
struct CarriageReturns<R>(R);

impl<R: Read> Read for CarriageReturns<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let count = self.0.read(out)?;
        in_lines(&mut out[..count]);
        Ok(count)
    }
}

/// UTF-16 without its byte-order mark.
pub fn of_utf16(bytes: &[u8], big_endian: bool) -> String {
    let unit = if big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).filter(|&unit| unit != 0xfeff);
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// UTF-16 as UTF-8, as it is read.
struct Utf16<R> {
    from: BufReader<R>,
    big_endian: bool,
    /// The first half of a character whose other half comes with the next bytes.
    half: Vec<u8>,
    ready: Vec<u8>,
    given: usize,
}

impl<R> Utf16<R> {
    fn of(from: BufReader<R>, big_endian: bool) -> Self {
        Self { from, big_endian, half: Vec::new(), ready: Vec::new(), given: 0 }
    }
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        if self.given == self.ready.len() {
            let mut bytes = vec![0; 1 << 16];
            let mut filled = self.half.len();
            bytes[..filled].copy_from_slice(&self.half);
            self.half.clear();
            while filled < bytes.len() {
                match self.from.read(&mut bytes[filled..])? {
                    0 => break,
                    more => filled += more,
                }
            }
            let high = bytes[bytes.len() - if self.big_endian { 2 } else { 1 }];
            if filled == bytes.len() && matches!(high, 0xd8..=0xdb) {
                filled -= 2;
                self.half.extend_from_slice(&bytes[filled..]);
            }
            let text = of_utf16(&bytes[..filled], self.big_endian);
            (self.ready, self.given) = (text.into_bytes(), 0);
        }
        let count = out.len().min(self.ready.len() - self.given);
        out[..count].copy_from_slice(&self.ready[self.given..self.given + count]);
        self.given += count;
        Ok(count)
    }
}

/// Where the cells of a line begin and end.
#[derive(Default)]
struct Cells {
    delimiter: Option<u8>,
    decimal_comma: bool,
    ends: Vec<(usize, usize)>,
    plain: String,
    clocks: Vec<usize>,
    marks: Vec<Marks>,
}

/// What a column shows of its decimal marks: `1.234` beside `12`, and never `1.2`, may be thousands.
#[derive(Debug, Clone, Default)]
struct Marks {
    is_plain: bool,
    whole: usize,
    grouped: usize,
    /// The first cell in groups of three digits, and its line.
    cell: String,
    line: u64,
}

impl Marks {
    fn see(&mut self, cell: &str, mark: u8, line: u64) {
        let digits = cell.strip_prefix(['-', '+']).unwrap_or(cell).as_bytes();
        let (before, after) = match digits.iter().position(|b| *b == mark) {
            Some(at) => (&digits[..at], Some(&digits[at + 1..])),
            None => (digits, None),
        };
        let is_group = (1..=3).contains(&before.len()) && before.iter().all(u8::is_ascii_digit);
        match after {
            None if is_group => self.whole += 1,
            Some(after)
                if is_group && before[0] != b'0' && after.len() == 3 && after.iter().all(u8::is_ascii_digit) =>
            {
                if self.grouped == 0 {
                    (self.cell, self.line) = (cell.to_owned(), line);
                }
                self.grouped += 1;
            }
            _ => self.is_plain = true,
        }
    }

    fn are_unclear(&self) -> bool {
        !self.is_plain && self.whole > 0 && self.grouped >= GROUPED
    }
}

impl Cells {
    /// Finds the cells up to column `last`.
    fn split(&mut self, line: &[u8], last: usize) {
        self.ends.clear();
        match self.delimiter {
            Some(delimiter) if !line.contains(&b'"') => {
                let mut from = 0;
                for at in memchr::memchr_iter(delimiter, line) {
                    self.ends.push((from, at));
                    from = at + 1;
                    if self.ends.len() > last {
                        return;
                    }
                }
                self.ends.push((from, line.len()));
            }
            Some(delimiter) => {
                let (mut from, mut quoted) = (0, false);
                for (at, &byte) in line.iter().enumerate() {
                    quoted ^= byte == b'"';
                    if byte == delimiter && !quoted {
                        self.ends.push((from, at));
                        from = at + 1;
                    }
                }
                self.ends.push((from, line.len()));
            }
            None => {
                let mut from = None;
                for (at, byte) in line.iter().enumerate() {
                    match (byte.is_ascii_whitespace(), from) {
                        (false, None) => from = Some(at),
                        (true, Some(begin)) => {
                            self.ends.push((begin, at));
                            from = None;
                        }
                        _ => {}
                    }
                }
                self.ends.extend(from.map(|begin| (begin, line.len())));
            }
        }
    }

    /// Whether there is anything behind the first `most` cells.
    fn is_longer(&self, line: &[u8], most: usize) -> bool {
        let is_empty = |byte: &u8| Some(*byte) == self.delimiter || byte.is_ascii_whitespace();
        self.ends.get(most).is_some_and(|(from, _)| !line[*from..].iter().all(is_empty))
    }

    fn cell<'a>(&self, line: &'a [u8], column: usize) -> Option<&'a [u8]> {
        let &(from, to) = self.ends.get(column)?;
        let cell = line[from..to].trim_ascii();
        Some(cell.strip_prefix(b"\"").and_then(|c| c.strip_suffix(b"\"")).unwrap_or(cell).trim_ascii())
    }

    fn parsed(&mut self, text: &str) -> Option<f64> {
        text.parse().ok().or_else(|| {
            let comma = text.find(',').filter(|_| self.decimal_comma)?;
            self.plain.clear();
            self.plain.push_str(text);
            self.plain.replace_range(comma..=comma, ".");
            self.plain.parse().ok()
        })
    }

    /// The number of a cell; `place` is that of its column among the wanted ones, and its line.
    fn number(&mut self, row: &[u8], column: usize, (place, line): (usize, u64)) -> Result<f64, Message> {
        let Some(cell) = self.cell(row, column) else { return Err(message!("cell_missing")) };
        let text = std::str::from_utf8(cell).map_err(|_| message!("not_utf8_text"))?;
        if let Some(number) = self.parsed(text) {
            let mark = if self.decimal_comma { b',' } else { b'.' };
            if let Some(marks) = self.marks.get_mut(place).filter(|marks| !marks.is_plain) {
                marks.see(text, mark, line);
            }
            // An empty cell is NaN; infinite is none.
            return if number.abs() > MOST { Err(message!("not_finite", value = sent(text))) } else { Ok(number) };
        }
        if let Some(seconds) = clock::seconds(text) {
            if !self.clocks.contains(&column) {
                self.clocks.push(column);
            }
            return Ok(seconds);
        }
        match text {
            _ if is_empty(text) => Ok(f64::NAN),
            _ if clock::is_unclear_date(text) => Err(message!("date_unclear", value = sent(text))),
            _ if clock::is_like_time(text) => Err(message!("time_unread", value = sent(text))),
            _ => Err(message!("not_a_number", value = sent(text))),
        }
    }
}

/// What a column of ids holds.
#[derive(Debug, Clone, Default)]
pub struct Ids {
    pub found: Vec<Vec<u8>>,
}

impl Ids {
    /// More values than a file has IMUs: a counter.
    pub const MOST: usize = 9;

    fn see(&mut self, cell: &[u8]) {
        if self.found.len() < Self::MOST && !cell.is_empty() && !self.found.iter().any(|own| own == cell) {
            self.found.push(cell.to_vec());
        }
    }
}

fn is_empty(text: &str) -> bool {
    matches!(text, "" | "-" | "--" | "NA" | "N/A" | "n/a" | "null" | "NULL" | "None")
}

fn is_number(cell: &str, decimal_comma: bool) -> bool {
    cell.parse::<f64>().is_ok() || decimal_comma && cell.replacen(',', ".", 1).parse::<f64>().is_ok()
}

impl Layout {
    /// The layout that a file's first bytes show.
    pub fn of(head: &[u8], whole: bool) -> Result<Self, Message> {
        let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
        let text = decoded(head);
        let mut lines: Vec<&str> = text.split('\n').map(str::trim).collect();
        // The last line of a piece is a piece itself.
        if !whole || lines.last().is_some_and(|line| line.is_empty()) {
            lines.pop();
        }
        let rows: Vec<(usize, &str)> =
            lines.iter().copied().enumerate().filter(|(_, l)| !l.is_empty() && !is_comment(l.as_bytes())).collect();
        let sampled: Vec<&str> = rows.iter().rev().take(SAMPLED).map(|(_, line)| *line).collect();
        let candidates = [Some(b'\t'), Some(b';'), Some(b','), Some(b'|'), None];
        let best = candidates
            .into_iter()
            .flat_map(|delimiter| [false, true].map(|comma| (delimiter, comma)))
            // Between commas, decimal commas stand in quotation marks.
            .filter(|&(delimiter, comma)| !comma || delimiter != Some(b',') || text.contains('"'))
            .map(|(delimiter, comma)| (numbers(&sampled, delimiter, comma), delimiter, comma))
            // The first of equals: a decimal comma only where it makes more numbers.
            .fold((0.0, None, false), |best, next| if next.0 > best.0 + 1e-9 { next } else { best });
        let (found, delimiter, decimal_comma) = best;
        if found < 1.0 {
            return Err(message!("no_numbers", lines = lines.len()));
        }
        let fields = |line: &str| split(line, delimiter);
        let mut widths: Vec<usize> = sampled.iter().map(|line| fields(line).len()).collect();
        widths.sort_unstable();
        let usual = widths.get(widths.len() / 2).copied().unwrap_or(0);
        let begins_with_word =
            |cells: &[String]| cells.first().is_some_and(|c| !is_empty(c) && !is_number(c, decimal_comma));
        let later = &sampled[..sampled.len().div_ceil(2)];
        let with_words = later.iter().filter(|line| begins_with_word(&fields(line))).count();
        let is_row = |line: &str| {
            let cells = fields(line);
            // A program's own lines of a word and numbers.
            if begins_with_word(&cells) && (2 * with_words < later.len() || cells.len() + 1 < usual) {
                return false;
            }
            let filled = cells.iter().filter(|c| !is_empty(c)).count();
            let numbers = cells.iter().filter(|c| is_number(c, decimal_comma)).count();
            numbers > 0 && 2 * numbers >= filled
        };
        let Some(first) = rows.iter().position(|(_, line)| is_row(line)) else {
            return Err(message!("no_numbers", lines = lines.len()));
        };
        let mut widths: Vec<usize> = rows[first..].iter().take(SAMPLED).map(|(_, line)| fields(line).len()).collect();
        widths.sort_unstable();
        let width = widths.last().copied().unwrap_or(0);
        let above: Vec<Vec<String>> = rows[..first].iter().map(|(_, line)| fields(line)).collect();
        let named = above.last().map_or(0, |cells| cells.iter().filter(|cell| !cell.is_empty()).count());
        let is_whole = |cell: &String| cell.bytes().all(|b| b.is_ascii_digit() || b == b'-');
        if delimiter == Some(b',') && named > 1 && width > named + 1 && width <= 2 * named {
            let cells = rows[first..].iter().take(SAMPLED).flat_map(|(_, line)| fields(line)).collect::<Vec<_>>();
            if cells.iter().all(is_whole) {
                return Err(message!("commas_of_two_kinds", columns = named, cells = width));
            }
        }
        let above_rows = &lines[..rows[first].0];
        // As many as the head has, or a usual row; without a head, as many as two rows have.
        let mut heads = above_rows.iter().rev().map(|line| fields(line.trim_start_matches(['#', '%', '/', ' '])).len());
        let head = heads.find(|cells| (width.max(2) - 1..=width + 1).contains(cells));
        let most = usual.max(head.unwrap_or(widths[widths.len().saturating_sub(2)]));
        let columns = columns(above, above_rows, width.min(most), delimiter);
        Ok(Self { delimiter, decimal_comma, skipped: rows[first].0 as u64, most, columns })
    }

    /// Reads the cells `wanted` of a row; what is wrong with it. `lenient`: a cell that is no number is an empty one.
    fn row(
        &self,
        cells: &mut Cells,
        (text, line): (&[u8], u64),
        (wanted, values): (&[usize], &mut [f64]),
        lenient: bool,
    ) -> Option<Message> {
        cells.split(text, self.most);
        let too_long = cells.is_longer(text, self.most).then(|| message!("row_too_long", cells = self.most));
        let mut fault = too_long.map(|why| message!("at_line", line = line as usize, fault = why));
        for (k, (value, &column)) in values.iter_mut().zip(wanted).enumerate() {
            match cells.number(text, column, (k, line)) {
                Ok(number) => *value = number,
                Err(_) if lenient => *value = f64::NAN,
                Err(why) => fault = fault.or_else(|| Some(self.at(line, column, why))),
            }
        }
        fault
    }

    fn at(&self, line: u64, column: usize, fault: Message) -> Message {
        let name = self.columns.get(column).map_or(String::new(), |c| c.name.clone());
        message!("at_cell", line = line as usize, column = column + 1, name, fault)
    }
}

/// The text of a file that somebody typed or saved with whichever program, without its mark.
pub fn of_any(bytes: &[u8]) -> String {
    match file_kind(&bytes[..bytes.len().min(HEAD)]) {
        Ok(FileKind::Utf16 { big_endian }) => of_utf16(bytes, big_endian),
        _ => decoded(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)),
    }
}

/// UTF-8, or what Windows writes otherwise: GBK in China, one byte a character in Western Europe.
pub fn decoded(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        // Cut within a character: the piece ends there.
        Err(error) if error.error_len().is_none() => {
            String::from_utf8_lossy(&bytes[..error.valid_up_to()]).into_owned()
        }
        Err(_) => of_gbk(bytes).unwrap_or_else(|| bytes.iter().map(|&b| char::from(b)).collect()),
    }
}

/// The text of what is no UTF-8 and may be GBK.
pub fn of_gbk(bytes: &[u8]) -> Option<String> {
    let is_it = std::str::from_utf8(bytes).is_err() && is_chinese(bytes);
    is_it.then(|| encoding_rs::GBK.decode_without_bom_handling(bytes).0.into_owned())
}

/// Whether all that is no ASCII are pairs of GB 2312: letters of Western Europe mostly stand alone. The
/// last may be cut.
fn is_chinese(bytes: &[u8]) -> bool {
    let is_high = |byte: &u8| *byte >= 0x80;
    let runs = bytes.chunk_by(|a, b| is_high(a) == is_high(b)).filter(|run| is_high(&run[0]));
    let at_end = |run: &[u8]| run.as_ptr_range().end == bytes.as_ptr_range().end;
    let is_pair = |pair: &[u8]| matches!(pair, [0xa1..=0xf7, 0xa1..=0xfe]);
    let mut all = runs.map(|run| {
        let pairs = run.chunks_exact(2);
        (pairs.remainder().is_empty() || at_end(run)) && pairs.into_iter().all(is_pair)
    });
    all.all(|is_of_pairs| is_of_pairs)
}

fn split(line: &str, delimiter: Option<u8>) -> Vec<String> {
    let mut cells = Cells { delimiter, ..Cells::default() };
    cells.split(line.as_bytes(), usize::MAX - 1);
    let text = |k: usize| cells.cell(line.as_bytes(), k).map(|c| String::from_utf8_lossy(c).into_owned());
    (0..cells.ends.len()).filter_map(text).collect()
}

/// Numbers a row, where most rows have the same number of cells; fewer where they differ.
fn numbers(rows: &[&str], delimiter: Option<u8>, decimal_comma: bool) -> f64 {
    let cells: Vec<Vec<String>> = rows.iter().map(|row| split(row, delimiter)).collect();
    let mut widths: Vec<usize> = cells.iter().map(Vec::len).collect();
    widths.sort_unstable();
    let Some(&usual) = widths.get(widths.len() / 2) else { return 0.0 };
    let alike: Vec<&Vec<String>> = cells.iter().filter(|row| row.len() == usual).collect();
    let numbers = alike.iter().flat_map(|row| row.iter()).filter(|cell| is_number(cell, decimal_comma)).count();
    numbers as f64 / rows.len().max(1) as f64
}

/// Names and units from the rows above the first row of numbers, or from a comment just above it.
pub fn columns(mut above: Vec<Vec<String>>, lines: &[&str], width: usize, delimiter: Option<u8>) -> Vec<Column> {
    above.retain(|cells| cells.len() >= width.max(2) - 1 && cells.len() <= width + 1);
    if above.is_empty() {
        let comments = lines.iter().rev().filter(|line| is_comment(line.as_bytes()));
        let named = comments.map(|line| split(line.trim_start_matches(['#', '%', '/', ' ']), delimiter));
        above.extend(named.filter(|cells| cells.len() == width && width > 1).take(1));
    }
    let mut last = above.pop().unwrap_or_default();
    let mut units = if above.is_empty() || !last.iter().any(|cell| is_unit(cell)) {
        Vec::new()
    } else {
        std::mem::replace(&mut last, above.pop().unwrap_or_default())
    };
    let mut names = last;
    split_headings(&mut names, &mut units);
    (0..width)
        .map(|k| {
            let column = Column::named(names.get(k).map_or("", String::as_str));
            let below = units.get(k).map(|u| u.trim_matches(['[', ']', '(', ')', ' ']).to_owned());
            Column { unit: column.unit.or(below.filter(|u| !u.is_empty())), ..column }
        })
        .collect()
}

/// Headings over several columns, as merged cells are saved: `Rate,,` above `x,y,z` are `Rate x`, `Rate y`, `Rate z`.
fn split_headings(names: &mut [String], below: &mut [String]) {
    let wide: Vec<bool> =
        (0..names.len()).map(|k| names[k].is_empty() || names.get(k + 1).is_some_and(String::is_empty)).collect();
    let mut above = String::new();
    for (k, part) in below.iter_mut().enumerate().take(wide.len()) {
        if !names[k].is_empty() {
            above.clone_from(&names[k]);
        }
        if wide[k] && !part.is_empty() && !is_unit(part) {
            names[k] = format!("{above} {}", std::mem::take(part));
        }
    }
}

/// Whether a cell of a second header row is a unit.
fn is_unit(cell: &str) -> bool {
    let bare = cell.trim_matches(['[', ']', '(', ')', ' ']);
    !bare.is_empty() && (cell.trim_start().starts_with(['[', '(']) || QUANTITIES.iter().any(|q| q.unit(bare).is_some()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> Layout {
        Layout::of(text.as_bytes(), true).unwrap()
    }

    fn heads(layout: &Layout) -> Vec<(&str, Option<&str>)> {
        layout.columns.iter().map(|c| (c.name.as_str(), c.unit.as_deref())).collect()
    }

    #[test]
    fn a_character_of_two_halves_is_one_where_a_block_ends_between_them() {
        for filler in [0, 1, 2] {
            let text = format!("{}{}", "a".repeat(filler), "\u{1d465}".repeat(40_000));
            for big_endian in [false, true] {
                let in_bytes = |unit: u16| if big_endian { unit.to_be_bytes() } else { unit.to_le_bytes() };
                let bytes: Vec<u8> = text.encode_utf16().flat_map(in_bytes).collect();
                let mut read = String::new();
                Utf16::of(BufReader::new(bytes.as_slice()), big_endian).read_to_string(&mut read).unwrap();
                assert!(read == text, "{filler} {big_endian}");
            }
        }
    }

    #[test]
    fn delimiters_decimals_headers_and_units_are_seen() {
        let plain = layout("t (s),gx [deg/s],gy (deg/s)\n0.00,1.5,2\n0.01,1.6,2\n");
        assert_eq!((plain.delimiter, plain.decimal_comma, plain.skipped), (Some(b','), false, 1));
        assert_eq!(heads(&plain), [("t", Some("s")), ("gx", Some("deg/s")), ("gy", Some("deg/s"))]);

        let german = layout("Datum;25.11.2026\nZeit;Drehrate\ns;deg/s\n0,00;1,5\n0,01;1,25\n0,02;1,75\n");
        assert_eq!((german.delimiter, german.decimal_comma, german.skipped), (Some(b';'), true, 3));
        assert_eq!(heads(&german), [("Zeit", Some("s")), ("Drehrate", Some("deg/s"))]);

        let blanks = layout("   2.98e-02   3.3e+04   3.3e+04\n   3.98e-02   3.3e+04   3.3e+04\n");
        assert_eq!((blanks.delimiter, blanks.skipped, blanks.columns.len()), (None, 0, 3));

        let tabs = layout("% t\tax\n0,1\t2,5\n0,2\t2,5\n");
        assert_eq!((tabs.delimiter, tabs.decimal_comma), (Some(b'\t'), true));
        assert_eq!(heads(&tabs), [("t", None), ("ax", None)]);

        let merged = layout("Time,Rate,,,T\ns,x,y,z,degC\n0,1,2,3,20\n1,1,2,3,20\n");
        let expected = [("Time", Some("s")), ("Rate x", None), ("Rate y", None), ("Rate z", None), ("T", Some("degC"))];
        assert_eq!(heads(&merged), expected);

        let quoted = layout("\"t\",\"a\"\n\"0,5\",\"1,5\"\n\"1,5\",\"1,25\"\n");
        assert_eq!((quoted.delimiter, quoted.decimal_comma), (Some(b','), true));

        let titled = layout("Run 3;;\n;;\nt [s];a [g];b [g]\n0,5;1;2\n1,5;1;2\n");
        assert_eq!(heads(&titled), [("t", Some("s")), ("a", Some("g")), ("b", Some("g"))]);

        let labview =
            layout("Writer_Version\t2\nChannels\t3\t\nX_Value\ta\tb\tc\tComment\n0.5\t1\t2\t3\n1.5\t1\t2\t3\n");
        assert_eq!(heads(&labview), [("X_Value", None), ("a", None), ("b", None), ("c", None)]);

        assert_eq!(with_line_feeds(b"a\rb\r".to_vec()), b"a\nb\n");
        assert_eq!(with_line_feeds(b"a\r\nb".to_vec()), b"a\r\nb");

        let tagged = layout("LOG:  9,   1.38, 19674, -0.1\nLOG: 10,   3.23, 81550, -0.2\n");
        assert_eq!((tagged.delimiter, tagged.columns.len()), (Some(b','), 4));
    }

    #[test]
    fn what_has_no_numbers_is_no_table() {
        assert_eq!(Layout::of(b"dear all,\nplease find\n", true).unwrap_err().code, "no_numbers");
        let two_kinds = Layout::of(b"t,a,b\n0,5,1,25,2,5\n0,6,1,26,2,5\n", true).unwrap_err();
        assert_eq!(two_kinds.code, "commas_of_two_kinds");
    }

    fn read(text: &str, wanted: &[usize]) -> Result<(SkippedLines, TextLog), String> {
        let of = std::io::Cursor::new(text.to_owned().into_bytes());
        let mut log = TextLog::of("log", of, FileKind::Text).unwrap();
        let left_out = log.rows(wanted, &mut |_| Ok(())).map_err(|error| format!("{:?}", error.fault))?;
        Ok((left_out, log))
    }

    #[test]
    fn a_cell_that_is_no_finite_number_is_named() {
        for wrong in ["inf", "-Infinity", "1e400", "1e300"] {
            let rows = |k: usize| if k == 50 { format!("{k};{wrong}\n") } else { format!("{k};0.5\n") };
            let text: String = std::iter::once("t;a\n".to_owned()).chain((0..400).map(rows)).collect();
            let left_out = read(&text, &[0, 1]).unwrap().0;
            assert_eq!(left_out.count, 1);
            let first = format!("{:?}", left_out.first.unwrap());
            assert!(first.contains("not_finite") && first.contains("52") && first.contains(wrong), "{first}");
        }
    }

    #[test]
    fn marks_of_thousands_are_no_decimals() {
        let rows = |of: &dyn Fn(usize) -> String| -> String {
            std::iter::once("t;a\n".to_owned()).chain((0..200).map(|k| format!("{k};{}\n", of(k)))).collect()
        };
        let marked = |k: usize, mark: &str| {
            if k.is_multiple_of(3) { "782".to_owned() } else { format!("{}{mark}271", 1 + k % 9) }
        };
        for mark in [".", ","] {
            let fault = read(&rows(&|k| marked(k, mark)), &[0, 1]).map(|_| ()).unwrap_err();
            assert!(fault.contains("cell_thousands") && fault.contains("271"), "{fault}");
        }
        // Decimals of other lengths, or below one, are plain; and so are cells that all have three.
        for plain in [
            rows(&|k| if k == 7 { "2.27".to_owned() } else { marked(k, ".") }),
            rows(&|k| if k == 7 { "0.271".to_owned() } else { marked(k, ".") }),
            rows(&|k| format!("{}.271", 1 + k % 9)),
        ] {
            read(&plain, &[0, 1]).unwrap();
        }
    }

    #[test]
    fn a_column_of_ids_is_seen_without_being_asked_for() {
        let text: String = (0..100).map(|k| format!("{k},1.5,{}\n", if k % 2 == 0 { "A" } else { "B" })).collect();
        let log = read(&format!("t,a,IMU\n{text}"), &[0, 1]).unwrap().1;
        assert_eq!(log.ids[0].1.found, [b"A", b"B"]);
    }
}
