//! A history as CSV: one header line, times in UTC, every figure with all its digits.

use std::io::Write;

use super::columns::{COLUMNS, CellValue, ExportRow};
use crate::wire::time;

pub struct Csv<W: Write>(csv::Writer<W>);

impl<W: Write> Csv<W> {
    pub fn new(out: W) -> anyhow::Result<Self> {
        let mut writer = csv::Writer::from_writer(out);
        writer.write_record(COLUMNS.iter().map(|column| column.name))?;
        Ok(Self(writer))
    }

    pub fn write(&mut self, rows: &[ExportRow]) -> anyhow::Result<()> {
        for row in rows {
            self.0.write_record(COLUMNS.iter().map(|column| cell(column.cells, row)))?;
        }
        Ok(())
    }

    pub fn finish(mut self) -> anyhow::Result<()> {
        Ok(self.0.flush()?)
    }
}

/// Empty where there is nothing to say.
fn cell(cells: CellValue, row: &ExportRow) -> String {
    match cells {
        CellValue::Text(of) => of(row),
        CellValue::Word(of) => of(row).unwrap_or_default().to_owned(),
        CellValue::Instant(of) => time::format(of(row)),
        CellValue::Number(of) => of(row).map(|number| number.to_string()).unwrap_or_default(),
        CellValue::Count(of) => of(row).map(|count| count.to_string()).unwrap_or_default(),
        CellValue::Flag(of) => of(row).to_string(),
    }
}
