//! One log, whichever format it is in: named columns, and rows of numbers from first to last.

use std::fs::File;
use std::io::{Cursor, Read, Seek};
use std::path::Path;

use calamine::{Data, Reader, Xlsx};

use super::column::{Column, Sample};
use super::error::{LogError, unreadable};
use super::text::TextLog;
use super::{mat, npy};
use crate::core::message::{Message, list, sent};
use crate::message;
use crate::wire::file_kind::{FileKind, HEAD, file_kind};

pub enum Source {
    Text(TextLog),
    Whole { columns: Vec<Column>, first_line: u64, values: Vec<Vec<f64>> },
}

/// A named column of whole numbers in memory.
type Named = (Column, Vec<f64>);

impl Source {
    /// Opens a log and looks at its layout.
    ///
    /// # Errors
    /// What it is, where it is no table; what the operating system says.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        let place = path.display().to_string();
        let file = File::open(path).map_err(unreadable(&place))?;
        if file.metadata().is_ok_and(|m| m.is_dir()) {
            return Err(LogError::new(&place, message!("file_is_folder")));
        }
        Self::read(&place, file)
    }

    /// As [`Source::open`], of a log that is at hand; `place` is how messages name it.
    ///
    /// # Errors
    /// As [`Source::open`].
    pub fn read(place: &str, mut from: impl Read + Seek + 'static) -> Result<Self, LogError> {
        let fail = unreadable(place);
        let mut head = Vec::new();
        from.by_ref().take(HEAD as u64).read_to_end(&mut head).map_err(&fail)?;
        from.rewind().map_err(&fail)?;
        if head.is_empty() {
            return Err(LogError::new(place, message!("file_is_empty")));
        }
        let of_file = |fault| LogError::new(place, fault);
        let kind = file_kind(&head).map_err(of_file)?;
        if matches!(kind, FileKind::Text | FileKind::Utf16 { .. }) {
            return TextLog::of(place, from, kind).map(Self::Text);
        }
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes).map_err(&fail)?;
        let from_first = |columns| (columns, 1);
        let (columns, first_line) = match kind {
            FileKind::Mat5 => mat::arrays(&bytes).map(of_arrays).map(from_first),
            FileKind::Npy => npy::columns(&bytes).map(from_first),
            FileKind::Npz => npy::columns_of_archive(&bytes).map(from_first),
            FileKind::Parquet => of_parquet(bytes).map(from_first),
            FileKind::Xlsx | FileKind::Text | FileKind::Utf16 { .. } => of_workbook(&bytes),
        }
        .map_err(of_file)?;
        Self::of_columns(columns, first_line).map_err(of_file)
    }

    fn of_columns(named: Vec<Named>, first_line: u64) -> Result<Self, Message> {
        let rows = named.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
        let (columns, values): (Vec<_>, Vec<_>) = named.into_iter().filter(|(_, v)| v.len() == rows).unzip();
        if columns.is_empty() || rows < 2 {
            return Err(message!("no_numbers", lines = rows));
        }
        Ok(Self::Whole { columns, first_line, values })
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
            Self::Whole { .. } => &[],
        }
    }

    pub fn columns(&self) -> &[Column] {
        match self {
            Self::Text(log) => &log.layout.columns,
            Self::Whole { columns, .. } => columns,
        }
    }

    /// Calls `each` with every row; the number of lines that were no rows.
    ///
    /// # Errors
    /// What `each` refuses, with its line.
    pub fn rows(
        &mut self,
        place: &str,
        wanted: &[usize],
        each: &mut dyn FnMut(Sample<'_>) -> Result<(), Message>,
    ) -> Result<usize, LogError> {
        match self {
            Self::Text(log) => log.rows(wanted, each),
            Self::Whole { values, first_line, .. } => {
                let mut row = vec![0.0; wanted.len()];
                let rows = values.first().map_or(0, Vec::len);
                for (k, line) in (*first_line..).take(rows).enumerate() {
                    for (cell, &column) in row.iter_mut().zip(wanted) {
                        *cell = values[column][k];
                    }
                    each(Sample { line, values: &row }).map_err(|fault| {
                        LogError::new(place, message!("at_line", line = line as usize, fault = fault))
                    })?;
                }
                Ok(0)
            }
        }
    }

    /// The place of the column of a name, of a name with its unit, or of a number from 1.
    ///
    /// # Errors
    /// No such column, with those that there are.
    pub fn column(&self, name: &str) -> Result<usize, Message> {
        let columns = self.columns();
        let wanted = Column::named(name);
        let is = |c: &&Column| c.name == wanted.name || c.name.eq_ignore_ascii_case(&wanted.name);
        let named = columns.iter().enumerate().filter(|(_, c)| is(c) && !c.name.is_empty());
        let mut found: Vec<(usize, &Column)> = named.collect();
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
                _ => Err(message!("log_column_number", number = number, columns = columns.len())),
            };
        }
        let names: Vec<String> = columns.iter().map(|c| c.name.clone()).filter(|n| !n.is_empty()).collect();
        if names.is_empty() {
            return Err(message!("log_columns_unnamed", name = sent(name), columns = columns.len()));
        }
        Err(message!("log_column_unknown", name = sent(name), known = list(names.into_iter().map(|n| sent(&n)))))
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

/// The first sheet of a workbook that holds a table: its columns, and the line of its first row of numbers.
fn of_workbook(bytes: &[u8]) -> Result<(Vec<Named>, u64), Message> {
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
        return Ok((columns.into_iter().zip(values).collect(), start + first as u64 + 1));
    }
    Err(message!("xlsx_no_table"))
}

fn number(cell: &Data) -> f64 {
    match cell {
        Data::Float(value) => *value,
        Data::Int(value) => *value as f64,
        Data::DateTime(days) => days.as_f64() * 86_400.0,
        Data::String(text) => text.trim().replacen(',', ".", 1).parse().unwrap_or(f64::NAN),
        _ => f64::NAN,
    }
}
