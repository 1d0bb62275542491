//! Calibration records and bench results as a table: one row a gyro and calibration, or one a bench result.
//!
//! ```text
//! # station: ST-2
//! # geometry: skewed
//! imu,calibrated_at,slot,serial,e_pulse_per_arcsec_x,...,g_pulse_per_s_g0_z
//! IMU-07,2016-03-01T08:00:00Z,G1,LFG-0101,0.8473,...
//! ```
//!
//! Columns are the JSON's names, those of vectors with `_x _y _z`; a `# key: value` line above holds for every row.
//! Rows of one IMU and time are one record. A [`TableMap`] says what a table with a header of its own means.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use jiff::civil::{DateTime, Time};
use jiff::fmt::strtime::BrokenDownTime;
use serde_json::Map;

use super::table::{at_cell, check_quotes, comment, header_line, meant, number, reader, rows, too_many_cells, unknown};
use crate::core::message::{list, sent};
use crate::wire::prelude::*;

/// What a table's own header means, once for all its files (TOML).
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TableMap {
    /// By name of ours, the column that holds it. Columns that no entry names are left aside.
    columns: BTreeMap<String, String>,
    /// What is the same in every row.
    values: BTreeMap<String, Value>,
    /// What the numbers of a column are multiplied by.
    factors: BTreeMap<String, f64>,
    time: Option<TimeForm>,
}

/// How a table writes its times.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct TimeForm {
    /// As strftime has it, for example `%d.%m.%Y`; ISO 8601 where it is left out.
    format: Option<String>,
    /// From UTC, for example `+08:00`.
    offset: String,
}

#[derive(Clone, Copy)]
enum RowKind {
    /// A gyro of a record.
    Record,
    Bench,
}

/// A member of the JSON, and the columns that make it.
struct TableField {
    name: &'static str,
    parts: &'static [&'static str],
    is_number: bool,
    /// Of the record's gyro, not of the record.
    of_gyro: bool,
    is_required: bool,
}

const ONE: &[&str] = &[""];
const XYZ: &[&str] = &["_x", "_y", "_z"];

const fn text(name: &'static str) -> TableField {
    TableField { name, parts: ONE, is_number: false, of_gyro: false, is_required: false }
}

const fn figure(name: &'static str) -> TableField {
    TableField { is_number: true, ..text(name) }
}

const fn vector(name: &'static str) -> TableField {
    TableField { parts: XYZ, of_gyro: true, ..figure(name) }
}

const fn required(field: TableField) -> TableField {
    TableField { is_required: true, ..field }
}

const fn of_gyro(field: TableField) -> TableField {
    TableField { of_gyro: true, ..field }
}

static RECORD: [TableField; 17] = [
    required(text("imu")),
    required(text("station")),
    required(text("calibrated_at")),
    required(text("geometry")),
    figure("temperature_c"),
    text("campaign"),
    text("operator"),
    text("note"),
    required(of_gyro(text("slot"))),
    required(of_gyro(text("serial"))),
    required(vector("e_pulse_per_arcsec")),
    vector("g_pulse_per_s_g0"),
    vector("g_deg_per_h_g0"),
    vector("p_pulse_per_s_g02"),
    of_gyro(figure("bias_pulse_per_s")),
    vector("e_sd"),
    vector("g_sd"),
];

static BENCH: [TableField; 11] = [
    required(text("serial")),
    required(text("station")),
    required(text("measured_at")),
    required(text("method")),
    required(figure("d_i_deg_per_h_g0")),
    required(figure("d_s_deg_per_h_g0")),
    figure("d_i_sd"),
    figure("d_s_sd"),
    figure("temperature_c"),
    text("operator"),
    text("note"),
];

impl RowKind {
    /// By a column that only it has.
    fn of(names: &[Option<String>]) -> Option<Self> {
        let has = |name: &str| names.iter().flatten().any(|column| column == name);
        if has("e_pulse_per_arcsec_x") {
            return Some(Self::Record);
        }
        has("d_i_deg_per_h_g0").then_some(Self::Bench)
    }

    fn fields(self) -> &'static [TableField] {
        match self {
            Self::Record => &RECORD,
            Self::Bench => &BENCH,
        }
    }

    fn columns(self) -> impl Iterator<Item = String> {
        self.fields().iter().flat_map(TableField::columns)
    }
}

impl TableField {
    fn columns(&self) -> impl Iterator<Item = String> {
        self.parts.iter().map(|part| format!("{}{part}", self.name))
    }
}

/// The documents of a table, each with the line (from 1) of its first row; none where the text is no such table.
///
/// # Errors
/// Every fault of the table's form, with line and column. What a document may hold is checked where it is read.
pub fn documents(text: &str, map: &TableMap) -> Option<Result<Vec<(usize, Value)>, Faults>> {
    let text = text.trim_start_matches('\u{feff}');
    let (first, kind) = found(text, map)?;
    if let Err(fault) = check_quotes(text, first) {
        return Some(Err(fault.into()));
    }
    let mut reader = reader(text, first);
    let mut records = reader.records();
    let header = records.next()?.ok()?;
    let mut faults = Faults::default();
    let table = RecordTable::new(kind, &header, map, (text, first), &mut faults);
    let mut documents = Documents::default();
    if !faults.is_empty() {
        return Some(Err(faults));
    }
    for (line, cells) in rows(records, (text, first), "", &mut faults) {
        documents.add(&TableRow { line, cells: &cells, table: &table }, &mut faults);
    }
    if faults.is_empty() && documents.0.is_empty() {
        faults.push("", message!("table_without_rows"));
    }
    Some(faults.or(documents.0))
}

/// Whether a column is named as those of records and bench results are, in our words or a station's.
pub fn is_of_record(name: &str) -> bool {
    const PARTS: [&str; 13] = [
        "serial", "calibrat", "slot", "d_i", "d_s", "k_i", "k_s", "gyro no", "bench", "e_pulse", "g_pulse", "g_deg",
        "bias",
    ];
    let plain = name.to_lowercase();
    PARTS.iter().any(|part| plain.contains(part)) || matches!(plain.as_str(), "imu" | "ki" | "ks" | "di" | "ds")
}

/// Whether a text is such a table, sound or not.
pub fn is_table(text: &str, map: &TableMap) -> bool {
    found(text.trim_start_matches('\u{feff}'), map).is_some()
}

/// The line of the header, counted from 0, and what the rows below it are.
fn found(text: &str, map: &TableMap) -> Option<(usize, RowKind)> {
    let first = header_line(text)?;
    let header = reader(text, first).records().next()?.ok()?;
    let names: Vec<Option<String>> = header.iter().map(|name| map.ours(name)).collect();
    Some((first, RowKind::of(&names).or_else(|| map.kind())?))
}

impl TableMap {
    /// Our name of a column of theirs.
    fn ours(&self, theirs: &str) -> Option<String> {
        let mapped = self.columns.iter().find(|(_, column)| column.trim() == theirs).map(|(name, _)| name.clone());
        mapped.or_else(|| (!self.columns.contains_key(theirs)).then(|| theirs.to_owned()))
    }

    /// What the tables of a map are, where the columns do not tell.
    fn kind(&self) -> Option<RowKind> {
        let of_record = |name: &String| {
            RECORD.iter().any(|field| field.of_gyro && name.starts_with(field.name) && name != "serial")
        };
        let mut told = self.columns.keys().chain(self.values.keys()).peekable();
        told.peek()?;
        Some(if told.any(of_record) { RowKind::Record } else { RowKind::Bench })
    }

    /// Names that are none of ours, columns of theirs that are taken twice, and those that the table has not;
    /// `places`: those that it has, by our names.
    fn check(&self, known: &[String], places: &HashMap<String, usize>, faults: &mut Faults) {
        let told = self.columns.keys().chain(self.values.keys()).chain(self.factors.keys());
        for name in told.filter(|name| !known.contains(name)) {
            faults.push("", message!("map_names", fault = unknown(name, known.iter().cloned())));
        }
        let shares = |column: &str| -> Vec<&str> {
            self.columns.iter().filter(|(_, own)| own.trim() == column).map(|(name, _)| name.as_str()).collect()
        };
        let columns: BTreeSet<&str> = self.columns.values().map(|column| column.trim()).collect();
        for (column, names) in columns.into_iter().map(|column| (column, shares(column))).filter(|(_, n)| n.len() > 1) {
            let names = list(names.into_iter().map(sent));
            faults.push("", message!("map_column_shared", column = sent(column), names));
        }
        for (name, column) in &self.columns {
            let is_alone = shares(column.trim()).len() == 1;
            if is_alone && known.contains(name) && !places.contains_key(name) {
                faults.push("", message!("map_column_missing", name = sent(name), column = sent(column)));
            }
        }
    }
}

/// What is known of a table before its rows are read.
struct RecordTable<'a> {
    kind: RowKind,
    header: &'a csv::StringRecord,
    /// By column of ours, the index of theirs.
    places: HashMap<String, usize>,
    /// What holds for every row that does not say otherwise.
    values: BTreeMap<String, String>,
    map: &'a TableMap,
}

impl<'a> RecordTable<'a> {
    fn new(
        kind: RowKind,
        header: &'a csv::StringRecord,
        map: &'a TableMap,
        (text, first): (&str, usize),
        faults: &mut Faults,
    ) -> Self {
        let line = first + 1;
        let known: Vec<String> = kind.columns().collect();
        let at = |fault: Message, column: usize| message!("at_column", line, column = column + 1, fault);
        let mut places = HashMap::new();
        let mut otherwise = Vec::new();
        for (column, theirs) in header.iter().enumerate() {
            let Some(name) = map.ours(theirs).filter(|name| !name.is_empty()) else { continue };
            if !known.contains(&name) {
                // Those that no entry of a map names are left aside.
                if map.columns.is_empty() {
                    faults.push("", at(unknown(&name, known.iter().cloned()), column));
                    otherwise.extend(meant(&name, known.iter().cloned()));
                }
            } else if places.insert(name, column).is_some() {
                faults.push("", at(message!("second_column", name = sent(theirs)), column));
            }
        }
        map.check(&known, &places, faults);
        let mut values: BTreeMap<String, String> =
            map.values.iter().map(|(name, value)| (name.clone(), plain(value))).collect();
        values.extend(said_above(text, first, &known, faults));
        let table = Self { kind, header, places, values, map };
        table.check_complete(&otherwise, line, faults);
        table
    }

    /// Fields that must be there, and those of which a part is; `otherwise`: columns that are named so.
    fn check_complete(&self, otherwise: &[String], line: usize, faults: &mut Faults) {
        let given = |name: &String| self.places.contains_key(name) || self.values.contains_key(name);
        let is_there = |field: &TableField| field.columns().any(|name| given(&name));
        for field in self.kind.fields().iter().filter(|field| field.is_required || is_there(field)) {
            let is_missing = |name: &String| !given(name) && !otherwise.contains(name);
            let missing: Vec<String> = field.columns().filter(is_missing).collect();
            if !missing.is_empty() {
                let missing = message!("missing_columns", names = list(missing));
                faults.push(format!("/{}", field.name), message!("at_line", line, fault = missing));
            }
        }
    }
}

/// What the `# key: value` lines above the header say.
fn said_above(text: &str, first: usize, known: &[String], faults: &mut Faults) -> Vec<(String, String)> {
    let mut said = Vec::new();
    for (number, line) in text.lines().take(first).enumerate() {
        let comment = comment(line).unwrap_or_default();
        let Some((key, value)) = comment.split_once(':').map(|(key, value)| (key.trim(), value.trim())) else {
            continue;
        };
        if known.iter().any(|name| name == key) {
            said.push((key.to_owned(), value.to_owned()));
        } else if !key.is_empty() && !key.contains(char::is_whitespace) {
            let unknown = message!("unknown_key", key = sent(key), known = list(known.iter().cloned()));
            faults.push(format!("/{key}"), message!("at_line", line = number + 1, fault = unknown));
        }
    }
    said
}

fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

struct TableRow<'a> {
    line: usize,
    cells: &'a csv::StringRecord,
    table: &'a RecordTable<'a>,
}

impl TableRow<'_> {
    /// What the row says of a column of ours: its cell, or what holds for every row.
    fn said(&self, name: &str) -> &str {
        let cell = self.table.places.get(name).and_then(|column| self.cells.get(*column)).unwrap_or_default();
        if cell.is_empty() { self.table.values.get(name).map_or("", String::as_str) } else { cell }
    }

    fn at(&self, name: &str, fault: Message) -> Message {
        match self.table.places.get(name) {
            Some(column) => at_cell((self.line, column + 1), &self.table.header[*column], fault),
            None => message!("at_line_key", line = self.line, key = name.to_owned(), fault),
        }
    }

    /// None where it is left empty, or faulty.
    fn value(&self, field: &TableField, faults: &mut Faults) -> Option<Value> {
        let names: Vec<String> = field.columns().collect();
        if !field.is_required && names.iter().all(|name| self.said(name).is_empty()) {
            return None;
        }
        let mut values = Vec::with_capacity(names.len());
        for name in names {
            match self.one(field, &name) {
                Ok(value) => values.push(value),
                Err(fault) => faults.push(format!("/{}", field.name), self.at(&name, fault)),
            }
        }
        (values.len() == field.parts.len()).then(|| if field.parts == ONE { values.remove(0) } else { values.into() })
    }

    fn one(&self, field: &TableField, name: &str) -> Result<Value, Message> {
        let said = self.said(name);
        if said.is_empty() {
            return Err(message!("empty_cell"));
        }
        if field.is_number {
            let factor = self.table.map.factors.get(name).copied().unwrap_or(1.0);
            return number(said).map(|value| Value::from(value * factor));
        }
        match &self.table.map.time {
            Some(form) if field.name.ends_with("_at") => form.instant(said).map(Value::from),
            _ if said.starts_with('{') => {
                serde_json::from_str(said).map_err(|e| message!("value_not_json", why = super::json::said_of(&e)))
            }
            _ => Ok(said.into()),
        }
    }
}

impl TimeForm {
    /// RFC 3339, with the offset that the map states.
    fn instant(&self, said: &str) -> Result<String, Message> {
        let civil = match &self.format {
            None => said.parse::<DateTime>(),
            Some(format) => BrokenDownTime::parse(format, said).and_then(|parts| {
                let time = if parts.hour().is_some() { parts.to_time()? } else { Time::midnight() };
                Ok(parts.to_date()?.to_datetime(time))
            }),
        };
        let civil = civil.map_err(|_| {
            let format = self.format.as_deref().unwrap_or("ISO 8601");
            message!("time_not_in_format", value = sent(said), format = sent(format))
        })?;
        Ok(format!("{civil}{}", self.offset))
    }
}

/// Documents, each with the line of its first row.
#[derive(Default)]
struct Documents(Vec<(usize, Value)>);

impl Documents {
    fn add(&mut self, row: &TableRow<'_>, faults: &mut Faults) {
        let table = row.table;
        if row.cells.iter().skip(table.header.len()).any(|cell| !cell.is_empty()) {
            faults.push("", too_many_cells(row.line, row.cells.len(), table.header.len()));
            return;
        }
        let before = faults.0.len();
        let (mut own, mut gyro) = (Map::new(), Map::new());
        for field in table.kind.fields() {
            if let Some(value) = row.value(field, faults) {
                let part = if field.of_gyro { &mut gyro } else { &mut own };
                part.insert(field.name.to_owned(), value);
            }
        }
        if faults.0.len() > before {
            return;
        }
        if matches!(table.kind, RowKind::Bench) {
            self.0.push((row.line, own.into()));
            return;
        }
        let same =
            |(_, other): &&mut (usize, Value)| ["imu", "calibrated_at"].iter().all(|key| other[key] == own[*key]);
        // Rows of one record stand near one another.
        let Some((first, record)) = self.0.iter_mut().rev().take(1000).find(same) else {
            own.insert("gyros".to_owned(), json!([gyro]));
            self.0.push((row.line, own.into()));
            return;
        };
        for field in table.kind.fields().iter().filter(|field| !field.of_gyro) {
            if record.get(field.name) != own.get(field.name) {
                let fault = message!("differs_from_line", first = *first);
                faults.push(format!("/{}", field.name), row.at(field.name, fault));
            }
        }
        if let Some(gyros) = record["gyros"].as_array_mut() {
            gyros.push(gyro.into());
        }
    }
}
