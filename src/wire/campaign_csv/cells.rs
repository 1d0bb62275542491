//! The table: a header that names columns, and rows whose cells are read by it.

use super::head::{Head, is_key, key_and_value};
use crate::core::message::{Parameter, list, sent};
use crate::wire::alike::together;
use crate::wire::campaign::DwellBody;
use crate::wire::numbers::Numbers;
use crate::wire::prelude::*;
use crate::wire::record_table::{TableMap, is_of_record, is_table};
use crate::wire::table::{at_cell, check_quotes, meant, number, reader, rows, too_many_cells, unknown};

/// Fields of a dwell, the suffixes of their columns, and whether every table has them.
pub(super) const FIELDS: &[(&str, &[&str], bool)] = &[
    ("phase", &[""], true),
    ("start_s", &[""], true),
    ("duration_s", &[""], true),
    ("attitude", &["_w", "_x", "_y", "_z"], false),
    ("specific_force_g0", &["_x", "_y", "_z"], true),
    ("rate_arcsec_s", &["_x", "_y", "_z"], true),
    ("temperature_c", &[""], false),
    ("output_pulse_s", &["_1", "_2", "_3"], true),
    ("output_sem_pulse_s", &["_1", "_2", "_3"], false),
];

/// Which column holds which part of which field.
pub(super) struct DwellTableColumns {
    names: Vec<String>,
    /// By field of [`FIELDS`] and part, the column's index.
    places: Vec<Vec<Option<usize>>>,
    /// Line of the header, counted from 1.
    line: usize,
}

/// One dwell's cells; none where a cell is empty.
pub(super) struct DwellRow {
    pub line: usize,
    phase: String,
    numbers: Vec<Option<f64>>,
}

/// Reads header and rows from `first_line` (counted from 0) on; none without a usable header, or where another
/// campaign begins below it.
pub(super) fn read(
    text: &str,
    first_line: usize,
    head: &Head,
    faults: &mut Faults,
) -> Option<(DwellTableColumns, Vec<DwellRow>)> {
    if text.lines().nth(first_line).is_none() {
        faults.push("/dwells", message!("no_table"));
        return None;
    }
    if let Err(fault) = check_quotes(text, first_line) {
        faults.push("/dwells", fault);
        return None;
    }
    let mut reader = reader(text, first_line);
    let mut records = reader.records();
    let header = records.next()?.ok()?;
    let of_records = || is_table(text, &TableMap::default()).then(|| message!("table_is_of_records"));
    let of_whole = of_head(&header).or_else(|| of_other_separator(&header));
    if let Some(foreign) = of_whole.or_else(of_records).or_else(|| foreign(&header)) {
        faults.push("", message!("at_line", line = first_line + 1, fault = foreign));
        return None;
    }
    if head.refuse_below(text, first_line, faults) {
        return None;
    }
    let columns = DwellTableColumns::read(&header, first_line + 1, faults);
    let records = rows(records, (text, first_line), "/dwells", faults);
    if records.is_empty() {
        faults.push("", message!("table_without_rows"));
    }
    let ranges = ranges(records.iter().map(|(_, record)| record).filter(|record| record.len() == columns.names.len()));
    let row = |(dwell, (line, record)): (usize, &(usize, csv::StringRecord))| {
        columns.row(record, &ranges, dwell, *line, faults)
    };
    let rows = records.iter().enumerate().filter_map(row).collect();
    // A program that writes one decimal comma writes all with one.
    faults.0 = together(&faults.0, |code| matches!(code, "decimal_comma" | "cells_decimal_comma"));
    Some((columns, rows))
}

/// A header with columns of ours, separated by what separates no cells here.
fn of_other_separator(header: &csv::StringRecord) -> Option<Message> {
    const AT_LEAST: usize = 3;
    let line = header.get(0).filter(|_| header.len() == 1)?;
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let known = line.split(|c| !is_of_name(c)).filter(|name| field_and_part(name).is_some()).count();
    let found = line.chars().find(|c| !is_of_name(*c)).filter(|_| known >= AT_LEAST)?;
    Some(message!("unknown_separator", found = sent(found.encode_utf8(&mut [0; 4]))))
}

/// Head matter whose `#` is missing.
fn of_head(header: &csv::StringRecord) -> Option<Message> {
    let line = header.get(0)?;
    let (key, _) = key_and_value(line)?;
    is_key(key).then(|| message!("head_without_mark", text = sent(line)))
}

/// A header that is no campaign's: of records, of bench results, of samples, or of a station's own.
fn foreign(header: &csv::StringRecord) -> Option<Message> {
    const SHOWN: usize = 6;
    let known = header.iter().filter(|name| field_and_part(name).is_some()).count();
    let records: Vec<&str> = header.iter().filter(|name| is_of_record(name)).collect();
    let names = |names: &[&str]| list(names.iter().take(SHOWN).map(|name| sent(name)));
    if !records.is_empty() && records.len() >= known {
        return Some(message!("table_of_records", names = names(&records)));
    }
    let named: Vec<&str> = header.iter().filter(|name| !name.is_empty()).collect();
    (known == 0).then(|| message!("table_foreign", names = names(&named)))
}

impl DwellTableColumns {
    fn read(header: &csv::StringRecord, line: usize, faults: &mut Faults) -> Self {
        let names: Vec<String> = header.iter().map(str::to_owned).collect();
        let mut places: Vec<Vec<Option<usize>>> = FIELDS.iter().map(|(_, parts, _)| vec![None; parts.len()]).collect();
        for (index, name) in names.iter().enumerate() {
            let at = |fault: Message| message!("at_column", line, column = index + 1, fault);
            match field_and_part(name) {
                None if name.is_empty() => {}
                None => faults.push("/dwells", at(unknown(name, known_columns()))),
                Some((field, part)) if places[field][part].is_some() => {
                    faults.push(
                        format!("/dwells/0/{}", FIELDS[field].0),
                        at(message!("second_column", name = sent(name))),
                    );
                }
                Some((field, part)) => places[field][part] = Some(index),
            }
        }
        let columns = Self { names, places, line };
        let unknown = columns.names.iter().filter(|name| field_and_part(name).is_none());
        columns.check_complete(&unknown.filter_map(|name| meant(name, known_columns())).collect::<Vec<_>>(), faults);
        columns
    }

    /// A vector has all its columns or none, and some fields must be there, unless they are named `otherwise`.
    fn check_complete(&self, otherwise: &[String], faults: &mut Faults) {
        for ((field, parts, required), places) in FIELDS.iter().zip(&self.places) {
            let given = places.iter().flatten().count();
            let is_output = field.starts_with("output");
            if given == 0 && !required || given == parts.len() {
                continue;
            }
            // How many outputs there must be only the head knows: see `check_outputs`. What was said of a column that
            // stands for one is not said again.
            let missing: Vec<Parameter> = parts
                .iter()
                .zip(places)
                .take(if is_output { last_given(places).max(1) } else { parts.len() })
                .filter(|(_, place)| place.is_none())
                .map(|(part, _)| format!("{field}{part}"))
                .filter(|name| !otherwise.contains(name))
                .map(Parameter::from)
                .collect();
            if !missing.is_empty() {
                let missing = message!("missing_columns", names = list(missing));
                faults.push(format!("/dwells/0/{field}"), message!("at_line", line = self.line, fault = missing));
            }
        }
    }

    /// Outputs, and standard errors where there are any, have one column a gyro.
    pub fn check_outputs(&self, gyros: usize, faults: &mut Faults) {
        for ((field, ..), places) in FIELDS.iter().zip(&self.places).filter(|((f, ..), _)| f.starts_with("output")) {
            let given = last_given(places);
            if given != gyros && (given > 0 || *field == "output_pulse_s") {
                let counts = message!("columns_and_gyros", columns = given, field = *field, gyros);
                faults.push(format!("/dwells/0/{field}"), message!("at_line", line = self.line, fault = counts));
            }
        }
    }

    /// Number (from 1) and name of the column of a field's part.
    pub fn place(&self, field: &str, part: Option<usize>) -> Option<(usize, &str)> {
        let index = FIELDS.iter().position(|(name, ..)| *name == field)?;
        let column = (*self.places[index].get(part.unwrap_or(0))?)?;
        Some((column + 1, &self.names[column]))
    }

    /// `ranges`: of each column, in the rows with a cell a column.
    fn row(
        &self,
        record: &csv::StringRecord,
        ranges: &[IndexRange],
        dwell: usize,
        line: usize,
        faults: &mut Faults,
    ) -> Option<DwellRow> {
        if record.len() > self.names.len() && record.iter().skip(self.names.len()).any(|cell| !cell.is_empty()) {
            faults.push(format!("/dwells/{dwell}"), self.too_many(record, ranges, line));
            return None;
        }
        let mut numbers = vec![None; self.names.len()];
        let before = faults.0.len();
        for (field, (name, ..)) in FIELDS.iter().enumerate().filter(|(_, (name, ..))| *name != "phase") {
            for column in self.places[field].iter().flatten() {
                let cell = record.get(*column).filter(|cell| !cell.is_empty());
                match cell.map(number).transpose() {
                    Ok(value) => numbers[*column] = value,
                    Err(fault) => {
                        let fault = if cell.is_some_and(is_no_value) { left_out(field, fault) } else { fault };
                        let fault = at_cell((line, column + 1), &self.names[*column], fault);
                        faults.push(format!("/dwells/{dwell}/{name}"), fault);
                    }
                }
            }
        }
        let phase = self.places[0][0].and_then(|c| record.get(c)).unwrap_or_default().to_owned();
        if faults.0.len() == before {
            self.check_filled(&numbers, record.len(), (dwell, line), faults);
        }
        (faults.0.len() == before).then_some(DwellRow { line, phase, numbers })
    }

    /// Empty cells: a vector has all its cells or none, and a required field all.
    fn check_filled(&self, numbers: &[Option<f64>], cells: usize, (dwell, line): (usize, usize), faults: &mut Faults) {
        for (index, ((field, _, required), places)) in FIELDS.iter().zip(&self.places).enumerate().skip(1) {
            let given: Vec<usize> = places.iter().flatten().copied().collect();
            let empty = || given.iter().filter(|&&column| numbers[column].is_none());
            if !*required && empty().count() == given.len() {
                continue;
            }
            let why = |column: usize| match column < cells {
                true => left_out(index, message!("empty_cell")),
                false => message!("cell_missing"),
            };
            for column in empty() {
                faults.push(
                    format!("/dwells/{dwell}/{field}"),
                    at_cell((line, column + 1), &self.names[*column], why(*column)),
                );
            }
        }
    }

    /// More cells than columns: most often decimal commas. Of cells that look like half a number it names, in columns
    /// with decimal points if it can, the one without which most of the row is in the ranges of its columns.
    fn too_many(&self, record: &csv::StringRecord, ranges: &[IndexRange], line: usize) -> Message {
        let digits = |cell: &str| !cell.is_empty() && cell.bytes().all(|b| b.is_ascii_digit());
        let half = |i: usize| {
            let whole = record.get(i).unwrap_or_default();
            digits(whole.trim_start_matches(['-', '+'])) && record.get(i + 1).is_some_and(digits)
        };
        let halves = (0..self.names.len()).filter(|&i| self.names[i] != "phase" && half(i));
        let pointed = |i: &usize| ranges.get(*i).is_some_and(|range| range.pointed);
        let half = halves.rev().max_by_key(|i| (pointed(i), within(record, ranges, *i)));
        let (cells, columns) = (record.len(), self.names.len());
        match half {
            Some(i) => {
                let number = format_args!("{},{}", &record[i], &record[i + 1]);
                let fault = message!("cells_decimal_comma", cells, columns, number);
                at_cell((line, i + 1), &self.names[i], fault)
            }
            None => too_many_cells(line, cells, columns),
        }
    }
}

/// What programs write in the place of a number that they do not have.
fn is_no_value(cell: &str) -> bool {
    matches!(cell.to_ascii_lowercase().as_str(), "nan" | "-" | "--" | "na" | "n/a" | "null" | "none" | "?")
}

/// The same fault, with what to do where a field has no value.
fn left_out(field: usize, fault: Message) -> Message {
    match FIELDS[field] {
        ("output_pulse_s", ..) => message!("row_without_output", fault),
        (field, _, false) => message!("row_without_value", fault, field),
        _ => fault,
    }
}

/// What a column's cells are like.
struct IndexRange {
    /// Least and largest number, twice as far apart as they are.
    least: f64,
    most: f64,
    /// Whether a decimal point is in any.
    pointed: bool,
}

fn ranges<'a>(whole: impl Iterator<Item = &'a csv::StringRecord>) -> Vec<IndexRange> {
    let mut ranges: Vec<IndexRange> = Vec::new();
    for record in whole {
        ranges.resize_with(record.len(), || IndexRange {
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
            pointed: false,
        });
        for (range, cell) in ranges.iter_mut().zip(record) {
            let number: f64 = cell.parse().unwrap_or(f64::NAN);
            (range.least, range.most) = (range.least.min(number), range.most.max(number));
            range.pointed |= cell.contains('.');
        }
    }
    for range in &mut ranges {
        let half = 0.5 * (range.most - range.least);
        (range.least, range.most) = (range.least - half, range.most + half);
    }
    ranges
}

/// Cells within the ranges of their columns, where the cells `i` and `i + 1` are one number.
fn within(record: &csv::StringRecord, ranges: &[IndexRange], i: usize) -> usize {
    let merged = format!("{}.{}", record.get(i).unwrap_or_default(), record.get(i + 1).unwrap_or_default());
    let cell = |k: usize| match k {
        _ if k < i => record.get(k),
        _ if k == i => Some(merged.as_str()),
        _ => record.get(k + 1),
    };
    let is_within = |(k, range): (usize, &IndexRange)| {
        let number = cell(k).and_then(|cell| cell.parse::<f64>().ok());
        number.is_some_and(|number| (range.least..=range.most).contains(&number))
    };
    ranges.iter().enumerate().filter(|range| is_within(*range)).count()
}

fn last_given(places: &[Option<usize>]) -> usize {
    places.iter().rposition(Option::is_some).map_or(0, |last| last + 1)
}

impl DwellRow {
    /// The dwell as the JSON would have it. All cells that must be filled are.
    pub fn dwell(&self, columns: &DwellTableColumns) -> DwellBody {
        let list = |field: &str| {
            let places = FIELDS.iter().zip(&columns.places).find(|((name, ..), _)| *name == field)?.1;
            let values: Vec<f64> = places.iter().flatten().filter_map(|&column| self.numbers[column]).collect();
            (!values.is_empty()).then(|| Numbers::from(values.as_slice()))
        };
        let one = |field: &str| columns.place(field, None).and_then(|(number, _)| self.numbers[number - 1]);
        let none = || Numbers::from([].as_slice());
        DwellBody {
            phase: self.phase.clone(),
            start_s: one("start_s").unwrap_or(f64::NAN),
            duration_s: one("duration_s").unwrap_or(f64::NAN),
            attitude: list("attitude"),
            specific_force_g0: list("specific_force_g0").unwrap_or_else(none),
            rate_arcsec_s: list("rate_arcsec_s").unwrap_or_else(none),
            temperature_c: one("temperature_c"),
            output_pulse_s: list("output_pulse_s").unwrap_or_else(none),
            output_sem_pulse_s: list("output_sem_pulse_s"),
        }
    }
}

fn field_and_part(column: &str) -> Option<(usize, usize)> {
    FIELDS.iter().enumerate().find_map(|(field, (name, parts, _))| {
        let suffix = column.strip_prefix(name)?;
        parts.iter().position(|part| *part == suffix).map(|part| (field, part))
    })
}

fn known_columns() -> impl Iterator<Item = String> {
    FIELDS.iter().flat_map(|(field, parts, _)| parts.iter().map(move |part| format!("{field}{part}")))
}
