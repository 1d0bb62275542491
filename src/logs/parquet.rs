//! Logs in Apache Parquet: the columns of numbers, and instants as they count.

use bytes::Bytes;
use parquet::basic::{Compression, ConvertedType, LogicalType, TimeUnit};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{DataType, Int96};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::column::{Column, Named};
use crate::core::message::Message;
use crate::message;

/// The columns of numbers, by their names; NaN where nothing stands.
pub fn columns(file: Vec<u8>) -> Result<Vec<Named>, Message> {
    let broken = |error: ParquetError| message!("parquet_broken", why = format_args!("{error}"));
    let reader = SerializedFileReader::new(Bytes::from(file)).map_err(broken)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let mut named: Vec<_> = schema.columns().iter().map(|column| (named(column), Vec::new())).collect();
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(broken)?;
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        for (place, (_, values)) in named.iter_mut().enumerate() {
            // A list in a cell is no column.
            if schema.column(place).max_rep_level() > 0 {
                continue;
            }
            match group.metadata().column(place).compression() {
                Compression::UNCOMPRESSED | Compression::SNAPPY | Compression::GZIP(_) => {}
                other => {
                    let codec = format!("{other:?}").split('(').next().unwrap_or_default().to_lowercase();
                    return Err(message!("parquet_codec", codec));
                }
            }
            let column = group.get_column_reader(place).map_err(broken)?;
            append(column, schema.column(place).max_def_level(), rows, values).map_err(broken)?;
        }
    }
    named.retain(|(_, values)| !values.is_empty());
    if named.is_empty() { Err(message!("parquet_no_numbers")) } else { Ok(named) }
}

/// The name of a column, and what instants count.
fn named(column: &ColumnDescriptor) -> Column {
    let own = Column::named(&column.path().string());
    let counts = match column.logical_type_ref() {
        Some(LogicalType::Timestamp(of)) => match of.unit {
            TimeUnit::MILLIS => Some("unix_ms"),
            TimeUnit::MICROS => Some("unix_us"),
            TimeUnit::NANOS => Some("unix_ns"),
        },
        _ => match column.converted_type() {
            ConvertedType::TIMESTAMP_MILLIS => Some("unix_ms"),
            ConvertedType::TIMESTAMP_MICROS => Some("unix_us"),
            _ => None,
        },
    };
    let is_int96 = column.physical_type() == parquet::basic::Type::INT96;
    let unit = counts.or(is_int96.then_some("unix_ns")).map(str::to_owned);
    Column { unit: unit.or(own.unit), name: own.name }
}

fn append(column: ColumnReader, most: i16, rows: usize, values: &mut Vec<f64>) -> Result<(), ParquetError> {
    match column {
        ColumnReader::BoolColumnReader(column) => read(column, most, rows, values, |v| f64::from(u8::from(v))),
        ColumnReader::Int32ColumnReader(column) => read(column, most, rows, values, f64::from),
        ColumnReader::Int64ColumnReader(column) => read(column, most, rows, values, |v| v as f64),
        ColumnReader::Int96ColumnReader(column) => read(column, most, rows, values, |v: Int96| v.to_nanos() as f64),
        ColumnReader::FloatColumnReader(column) => read(column, most, rows, values, f64::from),
        ColumnReader::DoubleColumnReader(column) => read(column, most, rows, values, |v| v),
        // Text and bytes.
        ColumnReader::ByteArrayColumnReader(_) | ColumnReader::FixedLenByteArrayColumnReader(_) => Ok(()),
    }
}

fn read<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    most: i16,
    rows: usize,
    values: &mut Vec<f64>,
    number: impl Fn(T::T) -> f64,
) -> Result<(), ParquetError> {
    let mut left = rows;
    while left > 0 {
        let (mut there, mut levels) = (Vec::new(), Vec::new());
        let (records, ..) = column.read_records(left, Some(&mut levels), None, &mut there)?;
        if records == 0 {
            return Err(ParquetError::EOF("a column has fewer rows than its group".to_owned()));
        }
        let mut numbers = there.into_iter().map(&number);
        match most {
            0 => values.extend(numbers),
            _ => values.extend(
                levels.iter().map(|&level| if level == most { numbers.next().unwrap_or(f64::NAN) } else { f64::NAN }),
            ),
        }
        left -= records;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType, Int64Type};
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
    use parquet::schema::parser::parse_message_type;

    use super::*;

    fn put<T: DataType>(
        group: &mut SerializedRowGroupWriter<'_, &mut Vec<u8>>,
        values: &[T::T],
        there: Option<&[i16]>,
    ) {
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<T>().write_batch(values, there, None).unwrap();
        column.close().unwrap();
    }

    /// Two groups of two rows each.
    fn file(compression: Compression) -> Vec<u8> {
        let schema = "message log { required int64 t (TIMESTAMP(MICROS,true)); required binary state (UTF8); \
                      optional float gyro; required group acc { required double z; } }";
        let schema = Arc::new(parse_message_type(schema).unwrap());
        let properties = Arc::new(WriterProperties::builder().set_compression(compression).build());
        let mut bytes = Vec::new();
        let mut writer = SerializedFileWriter::new(&mut bytes, schema, properties).unwrap();
        for first in [0_i64, 2] {
            let mut group = writer.next_row_group().unwrap();
            put::<Int64Type>(&mut group, &[first, first + 1], None);
            put::<ByteArrayType>(&mut group, &["idle", "move"].map(ByteArray::from), None);
            put::<FloatType>(&mut group, &[first as f32 + 0.5], Some(&[0, 1]));
            put::<DoubleType>(&mut group, &[first as f64, -1.0], None);
            group.close().unwrap();
        }
        writer.close().unwrap();
        bytes
    }

    #[test]
    fn columns_of_numbers_are_read_over_all_groups() {
        for compression in [Compression::UNCOMPRESSED, Compression::SNAPPY, Compression::GZIP(Default::default())] {
            let found = columns(file(compression)).unwrap();
            let named: Vec<_> = found.iter().map(|(c, _)| (c.name.as_str(), c.unit.as_deref())).collect();
            assert_eq!(named, [("t", Some("unix_us")), ("gyro", None), ("acc.z", None)]);
            assert_eq!(found[0].1, [0.0, 1.0, 2.0, 3.0]);
            let gyro = &found[1].1;
            assert!(gyro[0].is_nan() && gyro[2].is_nan(), "{gyro:?}");
            assert_eq!((gyro[1], gyro[3]), (0.5, 2.5));
            assert_eq!(found[2].1, [0.0, -1.0, 2.0, -1.0]);
        }
    }

    #[test]
    fn a_file_that_breaks_off_is_refused() {
        let whole = file(Compression::UNCOMPRESSED);
        for end in [4, whole.len() / 2, whole.len() - 1] {
            assert_eq!(columns(whole[..end].to_vec()).unwrap_err().code, "parquet_broken", "{end}");
        }
    }
}
