//! Batch, type and unit of many gyros as a table: `serial`, and any of `batch`, `type`, `unit`. What is left empty
//! stays.

use std::collections::HashMap;

use super::table::{at_cell, check_quotes, header_line, reader, rows, text_of, too_many_cells, unknown};
use super::text;
use crate::core::gyro_attributes::GyroAttributesPatch;
use crate::core::record::Name;
use crate::wire::prelude::*;

#[derive(Debug, Clone, PartialEq)]
pub struct GyroRow {
    /// From 1.
    pub line: usize,
    pub serial: Name,
    pub patch: GyroAttributesPatch,
}

const COLUMNS: [&str; 4] = ["serial", "batch", "type", "unit"];

pub fn parse(bytes: &[u8]) -> Result<Vec<GyroRow>, Faults> {
    let text = text_of(bytes)?;
    let mut faults = Faults::default();
    let first = header_line(text).unwrap_or(0);
    check_quotes(text, first)?;
    let mut reader = reader(text, first);
    let mut records = reader.records();
    let Some(Ok(header)) = records.next() else {
        faults.push("", message!("table_without_rows"));
        return Err(faults);
    };
    let mut places: [Option<usize>; COLUMNS.len()] = [None; COLUMNS.len()];
    for (column, name) in header.iter().enumerate() {
        let at = |fault| message!("at_column", line = first + 1, column = column + 1, fault);
        match COLUMNS.iter().position(|known| *known == name) {
            None => faults.push("", at(unknown(name, COLUMNS.iter().map(|known| (*known).to_owned())))),
            Some(place) if places[place].replace(column).is_some() => {
                faults.push("", at(message!("second_column", name = name.to_owned())));
            }
            Some(_) => {}
        }
    }
    if places[0].is_none() {
        let missing = message!("missing_columns", names = crate::core::message::list(["serial"]));
        faults.push("", message!("at_line", line = first + 1, fault = missing));
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let (mut gyros, mut lines) = (Vec::new(), HashMap::new());
    for (line, record) in rows(records, (text, first), "", &mut faults) {
        if record.iter().skip(header.len()).any(|cell| !cell.is_empty()) {
            faults.push("", too_many_cells(line, record.len(), header.len()));
            continue;
        }
        let cell = |place: usize| places[place].and_then(|column| record.get(column)).unwrap_or_default();
        let at = |place: usize| (line, places[place].unwrap_or_default() + 1);
        let mut word = |place: usize| {
            let mut own = Faults::default();
            let said = Some(cell(place)).filter(|said| !said.is_empty());
            let word = said.map(|said| text::matched("", said, &mut own));
            own.0.into_iter().for_each(|fault| faults.push("", at_cell(at(place), COLUMNS[place], fault.message)));
            word
        };
        let patch = GyroAttributesPatch { batch: word(1), r#type: word(2), unit: word(3) };
        match Name::parse(cell(0)) {
            Ok(serial) => match lines.insert(serial.clone(), line) {
                Some(first) => {
                    let fault = message!("serial_twice", serial = serial.to_string(), first);
                    faults.push("", at_cell(at(0), COLUMNS[0], fault));
                }
                None => gyros.push(GyroRow { line, serial, patch }),
            },
            Err(fault) => faults.push("", at_cell(at(0), COLUMNS[0], fault)),
        }
    }
    if gyros.is_empty() && faults.is_empty() {
        faults.push("", message!("table_without_rows"));
    }
    faults.or(gyros)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_empty_stays_and_what_is_wrong_is_named_by_line_and_column() {
        let rows = parse(b"# from the shop\nserial;batch;unit\nA-1;B-7;\nA-2;;Kestrel\n\n").unwrap();
        assert_eq!((rows[0].line, rows[0].serial.as_str(), rows[1].line), (3, "A-1", 4));
        let said = |word: &str| Some(Some(word.to_owned()));
        assert_eq!(rows[0].patch, GyroAttributesPatch { batch: said("B-7"), ..Default::default() });
        assert_eq!(rows[1].patch, GyroAttributesPatch { unit: said("Kestrel"), ..Default::default() });
        for (text, fault) in [
            ("", "table_without_rows"),
            ("serial,batch\n", "table_without_rows"),
            ("batch\nB-7\n", "at_line"),
            ("serial,bach\nA-1,B-7\n", "at_column"),
            ("serial,batch,batch\nA-1,B-7,B-8\n", "at_column"),
            ("serial,batch\nA\u{7}1,B-7\n", "at_cell"),
            ("serial,batch\nA-1,B-7\nA-1,B-8\n", "at_cell"),
            ("serial,batch\nA-1,B-7,x\n", "at_column"),
            ("serial,batch\nA-1,\"B-7\nA-2,B-8\n", "at_column"),
        ] {
            let faults = parse(text.as_bytes()).unwrap_err();
            assert_eq!(faults.0[0].message.code, fault, "{text}: {faults:?}");
        }
        let long = format!("serial,batch\nA-1,{}\n", "x".repeat(65));
        assert_eq!(parse(long.as_bytes()).unwrap_err().0[0].message.code, "at_cell");
    }
}
