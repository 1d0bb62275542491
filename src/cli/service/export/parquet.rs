//! A history as Apache Parquet: typed columns, instants as microseconds UTC, gzip.

use std::fs::File;
use std::sync::Arc;

use parquet::basic::{Compression, GzipLevel, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int32Type, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

use super::columns::{COLUMNS, CellValue, ExportColumn, ExportRow};

/// Rows that are held in memory and written together.
const GROUP: usize = 65_536;

pub struct Parquet {
    writer: SerializedFileWriter<File>,
    waiting: Vec<ExportRow>,
}

impl Parquet {
    pub fn new(out: File) -> anyhow::Result<Self> {
        let unit = KeyValue::new("unit".to_owned(), "deg/(h*g0)".to_owned());
        let properties = WriterProperties::builder()
            .set_compression(Compression::GZIP(GzipLevel::default()))
            .set_key_value_metadata(Some(vec![unit]))
            .build();
        let writer = SerializedFileWriter::new(out, schema()?, Arc::new(properties))?;
        Ok(Self { writer, waiting: Vec::new() })
    }

    pub fn write(&mut self, rows: Vec<ExportRow>) -> anyhow::Result<()> {
        self.waiting.extend(rows);
        if self.waiting.len() >= GROUP {
            self.write_group()?;
        }
        Ok(())
    }

    pub fn finish(mut self) -> anyhow::Result<()> {
        self.write_group()?;
        self.writer.close()?;
        Ok(())
    }

    fn write_group(&mut self) -> anyhow::Result<()> {
        let rows = std::mem::take(&mut self.waiting);
        if rows.is_empty() {
            return Ok(());
        }
        let mut group = self.writer.next_row_group()?;
        for ExportColumn { cells, .. } in &COLUMNS {
            let Some(column) = group.next_column()? else { break };
            write_column(column, *cells, &rows)?;
        }
        group.close()?;
        Ok(())
    }
}

fn schema() -> anyhow::Result<TypePtr> {
    let fields = COLUMNS.iter().map(|column| Ok(Arc::new(field(column)?)));
    let fields = fields.collect::<anyhow::Result<_>>()?;
    Ok(Arc::new(Type::group_type_builder("history").with_fields(fields).build()?))
}

fn field(column: &ExportColumn) -> anyhow::Result<Type> {
    let instant = LogicalType::timestamp(true, TimeUnit::MICROS);
    let (physical, logical, repetition) = match column.cells {
        CellValue::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::REQUIRED),
        CellValue::Word(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::OPTIONAL),
        CellValue::Instant(_) => (Physical::INT64, Some(instant), Repetition::REQUIRED),
        CellValue::Number(_) => (Physical::DOUBLE, None, Repetition::OPTIONAL),
        CellValue::Count(_) => (Physical::INT32, None, Repetition::OPTIONAL),
        CellValue::Flag(_) => (Physical::BOOLEAN, None, Repetition::REQUIRED),
    };
    let builder = Type::primitive_type_builder(column.name, physical);
    Ok(builder.with_logical_type(logical).with_repetition(repetition).build()?)
}

fn write_column(column: SerializedColumnWriter<'_>, cells: CellValue, rows: &[ExportRow]) -> anyhow::Result<()> {
    match cells {
        CellValue::Text(of) => required::<ByteArrayType>(column, rows, |row| ByteArray::from(of(row).into_bytes())),
        CellValue::Word(of) => optional::<ByteArrayType>(column, rows, |row| of(row).map(ByteArray::from)),
        CellValue::Instant(of) => required::<Int64Type>(column, rows, |row| of(row).0),
        CellValue::Number(of) => optional::<DoubleType>(column, rows, of),
        CellValue::Count(of) => optional::<Int32Type>(column, rows, of),
        CellValue::Flag(of) => required::<BoolType>(column, rows, of),
    }
}

fn required<T: DataType>(
    mut column: SerializedColumnWriter<'_>,
    rows: &[ExportRow],
    of: impl Fn(&ExportRow) -> T::T,
) -> anyhow::Result<()> {
    let values: Vec<T::T> = rows.iter().map(of).collect();
    column.typed::<T>().write_batch(&values, None, None)?;
    Ok(column.close()?)
}

/// A definition level of 1 says that the row has a value.
fn optional<T: DataType>(
    mut column: SerializedColumnWriter<'_>,
    rows: &[ExportRow],
    of: impl Fn(&ExportRow) -> Option<T::T>,
) -> anyhow::Result<()> {
    let cells: Vec<Option<T::T>> = rows.iter().map(of).collect();
    let levels: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    let values: Vec<T::T> = cells.into_iter().flatten().collect();
    column.typed::<T>().write_batch(&values, Some(&levels), None)?;
    Ok(column.close()?)
}
