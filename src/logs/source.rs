//! One log, whichever format it is in: named columns, and rows of numbers from first to last.

use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;

use calamine::{Data, Reader, Xlsx};

use super::column::{Column, Named};
use super::error::{LogError, unreadable};
use super::text::{Ids, MOST, SkippedLines, TextLog};
use super::{clock, mat, npy};
use crate::core::message::{Message, list, sent};
use crate::message;
use crate::wire::file_kind::{FileKind, HEAD, file_kind};
use crate::wire::table::nearest;
use crate::words::asked;

pub enum Source {
    Text(TextLog),
    Whole { columns: Vec<Column>, first_line: u64, values: Vec<Vec<f64>>, clocks: Vec<usize> },
}

/// The table of a workbook.
struct Worksheet {
    named: Vec<Named>,
    first_line: u64,
    /// Columns of dates or times of day.
    clocks: Vec<usize>,
}

/// The file as messages name it.
pub fn name(path: &Path) -> String {
    if path == Path::new("-") { asked().word("standard_input").to_owned() } else { path.display().to_string() }
}

impl Source {
    /// Opens a log, or standard input for `-`, and looks at its layout.
    ///
    /// # Errors
    /// What it is, where it is no table; what the operating system says.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        let place = name(path);
        if path == Path::new("-") {
            return Self::read(&place, std::io::stdin());
        }
        let file = File::open(path).map_err(unreadable(&place))?;
        if file.metadata().is_ok_and(|m| m.is_dir()) {
            return Err(LogError::new(&place, message!("file_is_folder")));
        }
        Self::read(&place, file)
    }

    /// As [`Source::open`], of a log that is at hand; `place` is how messages name it.
    pub fn read(place: &str, mut from: impl Read + 'static) -> Result<Self, LogError> {
        let fail = unreadable(place);
        let mut head = Vec::new();
        from.by_ref().take(HEAD as u64).read_to_end(&mut head).map_err(&fail)?;
        if head.is_empty() {
            return Err(LogError::new(place, message!("file_is_empty")));
        }
        let of_file = |fault| LogError::new(place, fault);
        let kind = file_kind(&head).map_err(of_file)?;
        // A pipe cannot be read twice.
        let mut from = Cursor::new(head).chain(from);
        if matches!(kind, FileKind::Text | FileKind::Utf16 { .. }) {
            return TextLog::of(place, from, kind).map(Self::Text);
        }
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes).map_err(&fail)?;
        let from_first = |named| Worksheet { named, first_line: 1, clocks: Vec::new() };
        let sheet = match kind {
            FileKind::Mat5 => mat::arrays(&bytes).map(of_arrays).map(from_first),
            FileKind::Npy => npy::columns(&bytes).map(from_first),
            FileKind::Npz => npy::columns_of_archive(&bytes).map(from_first),
            FileKind::Parquet => of_parquet(bytes).map(from_first),
            FileKind::Xlsx | FileKind::Text | FileKind::Utf16 { .. } => of_workbook(&bytes),
        };
        sheet.and_then(Self::of_sheet).map_err(of_file)
    }

    fn of_sheet(Worksheet { named, first_line, clocks }: Worksheet) -> Result<Self, Message> {
        let rows = named.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
        let (columns, values): (Vec<_>, Vec<_>) = named.into_iter().filter(|(_, v)| v.len() == rows).unzip();
        if columns.is_empty() || rows < 2 {
            return Err(message!("no_numbers", lines = rows));
        }
        Ok(Self::Whole { columns, first_line, values, clocks })
    }

    /// Takes what is no number for an empty cell, where nobody has said yet which columns are numbers.
    pub fn leniently(&mut self) {
        if let Self::Text(log) = self {
            log.lenient = true;
        }
    }

    /// Columns in which times of day or dates were read as seconds.
    pub fn clocks(&self) -> &[usize] {
        match self {
            Self::Text(log) => &log.clocks,
            Self::Whole { clocks, .. } => clocks,
        }
    }

    /// The first number of a column, as far as the beginning of the log shows it, and whether it was read from a time
    /// of day or a date.
    pub fn first(&mut self, column: usize) -> Option<(f64, bool)> {
        match self {
            Self::Text(log) => log.first(column),
            Self::Whole { values, clocks, .. } => {
                let first = values[column].iter().copied().find(|value| value.is_finite());
                first.map(|first| (first, clocks.contains(&column)))
            }
        }
    }

    /// A column, none of those that are `used`, that says that the rows read are of several IMUs.
    pub fn several(&self, used: &[usize]) -> Option<Message> {
        let found: Vec<(usize, Vec<String>)> = match self {
            Self::Text(log) => {
                let texts = |ids: &Ids| ids.found.iter().map(|id| String::from_utf8_lossy(id).into_owned()).collect();
                log.ids.iter().map(|(column, ids)| (*column, texts(ids))).collect()
            }
            Self::Whole { columns, values, .. } => {
                let distinct = |column: usize| {
                    let mut found: Vec<f64> = Vec::new();
                    for value in values[column].iter().filter(|value| !value.is_nan()) {
                        if found.len() < Ids::MOST && !found.contains(value) {
                            found.push(*value);
                        }
                    }
                    found.iter().map(f64::to_string).collect()
                };
                (0..columns.len()).filter(|&k| columns[k].is_id()).map(|k| (k, distinct(k))).collect()
            }
        };
        let is_of_several =
            |(column, ids): &&(usize, Vec<String>)| (2..Ids::MOST).contains(&ids.len()) && !used.contains(column);
        let (column, ids) = found.iter().find(is_of_several)?;
        let name = self.columns()[*column].name.clone();
        Some(message!("log_of_several", column = sent(&name), ids = list(ids.iter().map(|id| sent(id)))))
    }

    /// The columns that the log has, in its order.
    pub fn columns(&self) -> &[Column] {
        match self {
            Self::Text(log) => &log.layout.columns,
            Self::Whole { columns, .. } => columns,
        }
    }

    /// Calls `each` with every row; the lines that were no rows.
    pub fn rows(
        &mut self,
        place: &str,
        wanted: &[usize],
        each: &mut dyn FnMut(&[f64]) -> Result<(), Message>,
    ) -> Result<SkippedLines, LogError> {
        match self {
            Self::Text(log) => log.rows(wanted, each),
            Self::Whole { values, first_line, .. } => {
                let mut row = vec![0.0; wanted.len()];
                let rows = values.first().map_or(0, Vec::len);
                for (k, line) in (*first_line..).take(rows).enumerate() {
                    for (cell, &column) in row.iter_mut().zip(wanted) {
                        *cell = Some(values[column][k]).filter(|value| value.abs() <= MOST).unwrap_or(f64::NAN);
                    }
                    each(&row)
                        .map_err(|fault| LogError::new(place, message!("at_line", line = line as usize, fault)))?;
                }
                Ok(SkippedLines::default())
            }
        }
    }

    /// The place of the column of a name, of a name with its unit, or of a number from 1.
    pub fn column(&self, name: &str) -> Result<usize, Message> {
        let columns = self.columns();
        let wanted = Column::named(name);
        let named = |is: &dyn Fn(&str) -> bool| -> Vec<(usize, &Column)> {
            columns.iter().enumerate().filter(|(_, c)| is(&c.name) && !c.name.is_empty()).collect()
        };
        // A single letter in the other case is another: `t` the time, `T` the temperature.
        let mut found = named(&|own| own == wanted.name);
        if found.is_empty() && wanted.name.chars().count() > 1 {
            found = named(&|own| own.to_lowercase() == wanted.name.to_lowercase());
        }
        // `s(K1)` and `s(K2)` differ in what looks like a unit.
        if found.len() > 1 && wanted.unit.is_some() {
            found.retain(|(_, c)| c.unit == wanted.unit);
        }
        match found[..] {
            [(place, _)] => return Ok(place),
            [] => {}
            _ => return Err(message!("log_column_twice", name = sent(name))),
        }
        if let Ok(number) = name.parse::<usize>() {
            return match number {
                1.. if number <= columns.len() => Ok(number - 1),
                _ => Err(message!("log_column_number", number, columns = columns.len())),
            };
        }
        let names: Vec<String> = columns.iter().map(|c| c.name.clone()).filter(|n| !n.is_empty()).collect();
        if names.is_empty() {
            return Err(message!("log_columns_unnamed", name = sent(name), columns = columns.len()));
        }
        Err(log_column_unknown(name, names.iter().map(String::as_str)))
    }
}

/// No column of a name, with those that there are, and the one that was meant where one is alike but for marks between
/// its words, its unit, or a letter or two.
pub fn log_column_unknown<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> Message {
    const LEAST: usize = 3;
    let wanted = Column::named(name).name;
    let letters = |text: &str| text.to_lowercase().replace(|c: char| !c.is_alphanumeric(), "");
    let alike = known.clone().find(|own| letters(own) == letters(&wanted));
    let begins = || known.clone().find(|own| wanted.len() > LEAST && own.starts_with(wanted.as_str()));
    let near = || nearest(&wanted, known.clone().filter(|own| own.len() > LEAST), LEAST);
    let all = list(known.clone().map(sent));
    match alike.or_else(begins).or_else(near) {
        Some(like) => message!("log_column_like", name = sent(name), like = sent(like), known = all),
        None => message!("log_column_unknown", name = sent(name), known = all),
    }
}

/// Arrays as columns: `gyro` has `gyro.1`, `gyro.2`, `gyro.3` where it is of three.
fn of_arrays(arrays: Vec<mat::Array>) -> Vec<Named> {
    let mut named = Vec::new();
    for array in arrays {
        let columns = array.values.len() / array.rows;
        for (k, values) in array.values.chunks_exact(array.rows).enumerate() {
            let name = if columns == 1 { array.name.clone() } else { format!("{}.{}", array.name, k + 1) };
            named.push((Column { name, unit: None }, values.to_vec()));
        }
    }
    named
}

#[cfg(feature = "parquet")]
use super::parquet::columns as of_parquet;

#[cfg(not(feature = "parquet"))]
fn of_parquet(_: Vec<u8>) -> Result<Vec<Named>, Message> {
    Err(message!("file_is_parquet"))
}

/// The first sheet of a workbook that holds a table.
fn of_workbook(bytes: &[u8]) -> Result<Worksheet, Message> {
    let broken = |error: calamine::XlsxError| message!("xlsx_broken", why = format_args!("{error}"));
    let mut book: Xlsx<_> = Xlsx::new(Cursor::new(bytes)).map_err(broken)?;
    for name in book.sheet_names() {
        let range = book.worksheet_range(&name).map_err(broken)?;
        let rows: Vec<&[Data]> = range.rows().collect();
        let numbers = |row: &[Data]| row.iter().filter(|cell| number(cell).is_finite()).count();
        let is_row = |row: &&[Data]| {
            let filled = row.iter().filter(|cell| !matches!(cell, Data::Empty)).count();
            let numbers = numbers(row);
            numbers > 0 && 2 * numbers >= filled
        };
        let Some(first) = rows.iter().position(is_row) else { continue };
        let width = rows[first].len();
        let heads: Vec<Vec<String>> =
            rows[..first].iter().map(|row| row.iter().map(ToString::to_string).collect()).collect();
        let columns = super::text::columns(heads, &[], width, None);
        let values = (0..width).map(|k| rows[first..].iter().map(|row| row.get(k).map_or(f64::NAN, number)).collect());
        let start = range.start().map_or(0, |(row, _)| u64::from(row));
        let clocks = (0..width).filter(|&k| rows[first].get(k).is_some_and(is_clock)).collect();
        return Ok(Worksheet {
            named: columns.into_iter().zip(values).collect(),
            first_line: start + first as u64 + 1,
            clocks,
        });
    }
    Err(message!("xlsx_no_table"))
}

fn number(cell: &Data) -> f64 {
    match cell {
        Data::Float(value) => *value,
        Data::Int(value) => *value as f64,
        Data::DateTime(days) => clock::of_sheet(days.as_f64()),
        Data::DateTimeIso(text) => clock::seconds(text).unwrap_or(f64::NAN),
        Data::String(text) => {
            let plain = text.trim().replacen(',', ".", 1).parse().ok();
            plain.or_else(|| clock::seconds(text.trim())).unwrap_or(f64::NAN)
        }
        _ => f64::NAN,
    }
}

fn is_clock(cell: &Data) -> bool {
    match cell {
        Data::DateTime(_) | Data::DateTimeIso(_) => true,
        Data::String(text) => clock::seconds(text.trim()).is_some(),
        _ => false,
    }
}
