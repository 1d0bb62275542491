//! MATLAB's files of version 5 to 7: real numeric arrays, also in structures. (Version 7.3 is HDF5.)
//!
//! Format: "MAT-File Format", MathWorks, chapter 1. A file is a header of 128 bytes and elements, each a tag (type,
//! bytes) and its data, padded to eight; a tag whose upper half is not zero holds up to four bytes itself. A variable
//! is an element of type 14 (matrix) or 15 (the same, deflated).

use std::io::Read;

use crate::core::message::Message;
use crate::message;

/// A numeric array, column by column.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    pub name: String,
    pub rows: usize,
    pub values: Vec<f64>,
}

const HEADER: usize = 128;
const MATRIX: u32 = 14;
const DEFLATED: u32 = 15;
const STRUCTURE: u8 = 2;
/// Classes of numbers: double, single, and integers of one to eight bytes.
const NUMBERS: std::ops::RangeInclusive<u8> = 6..=15;
const COMPLEX: u8 = 0x08;
/// Deepest structure, and most bytes that a variable may unpack to.
const DEEPEST: usize = 8;
const MOST_BYTES: u64 = 4 << 30;

#[derive(Clone, Copy)]
struct Bytes<'a> {
    rest: &'a [u8],
    big_endian: bool,
}

struct Element<'a> {
    kind: u32,
    data: Bytes<'a>,
}

pub fn arrays(file: &[u8]) -> Result<Vec<Array>, Message> {
    let big_endian = match file.get(HEADER - 2..HEADER) {
        Some(b"IM") => false,
        Some(b"MI") => true,
        _ => return Err(message!("mat_broken")),
    };
    let mut found = Vec::new();
    let mut bytes = Bytes { rest: &file[HEADER..], big_endian };
    while let Some(Element { kind, data }) = bytes.element()? {
        match kind {
            MATRIX => matrix(data, "", 0, &mut found)?,
            DEFLATED => {
                let mut plain = Vec::new();
                let mut inflated = flate2::read::ZlibDecoder::new(data.rest).take(MOST_BYTES);
                inflated.read_to_end(&mut plain).map_err(|_| message!("mat_broken"))?;
                let mut bytes = Bytes { rest: &plain, big_endian };
                if let Some(Element { kind: MATRIX, data }) = bytes.element()? {
                    matrix(data, "", 0, &mut found)?;
                }
            }
            _ => {}
        }
    }
    Ok(found)
}

fn matrix(mut bytes: Bytes, prefix: &str, depth: usize, found: &mut Vec<Array>) -> Result<(), Message> {
    let Some(flags) = bytes.element()? else { return Ok(()) };
    let flags = flags.data.u32(0).ok_or_else(|| message!("mat_broken"))?;
    let (class, complex) = ((flags & 0xff) as u8, (flags >> 8) as u8 & COMPLEX != 0);
    let dimensions = bytes.must()?.unsigned();
    let own = String::from_utf8_lossy(bytes.must()?.data.rest).trim_matches('\0').to_owned();
    let name = if prefix.is_empty() { own } else { prefix.to_owned() };
    if class == STRUCTURE && depth < DEEPEST && dimensions.iter().product::<u32>() == 1 {
        let length = bytes.must()?.data.u32(0).unwrap_or(32).max(1) as usize;
        let names = bytes.must()?.data.rest;
        for field in names.chunks(length) {
            let field = String::from_utf8_lossy(field);
            let field = field.split('\0').next().unwrap_or_default();
            matrix(bytes.must()?.data, &format!("{name}.{field}"), depth + 1, found)?;
        }
    } else if NUMBERS.contains(&class) && !complex && dimensions.len() == 2 {
        let values = bytes.must()?.numbers()?;
        let (rows, columns) = (dimensions[0] as usize, dimensions[1] as usize);
        if rows.checked_mul(columns) != Some(values.len()) {
            return Err(message!("mat_broken"));
        }
        // A row of many is a column that lies down.
        let rows = if rows == 1 { columns } else { rows };
        if rows > 1 {
            found.push(Array { name, rows, values });
        }
    }
    Ok(())
}

impl<'a> Bytes<'a> {
    fn u32(&self, at: usize) -> Option<u32> {
        let bytes = self.rest.get(at..at + 4)?.try_into().ok()?;
        Some(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// The next element; none at the end.
    fn element(&mut self) -> Result<Option<Element<'a>>, Message> {
        if self.rest.len() < 8 {
            return Ok(None);
        }
        let broken = || message!("mat_broken");
        let of = |kind: u32, rest: &'a [u8]| Element { kind, data: Bytes { rest, ..*self } };
        let tag = self.u32(0).ok_or_else(broken)?;
        if tag >> 16 != 0 {
            let (kind, length) = (tag & 0xffff, (tag >> 16) as usize);
            let element = of(kind, self.rest.get(4..4 + length.min(4)).ok_or_else(broken)?);
            self.rest = &self.rest[8..];
            return Ok(Some(element));
        }
        let length = self.u32(4).ok_or_else(broken)? as usize;
        let element = of(tag, self.rest.get(8..8 + length).ok_or_else(broken)?);
        // What is deflated is not padded.
        let padded = if tag == DEFLATED { length } else { length.next_multiple_of(8) };
        self.rest = self.rest.get(8 + padded..).unwrap_or_default();
        Ok(Some(element))
    }

    fn must(&mut self) -> Result<Element<'a>, Message> {
        self.element()?.ok_or_else(|| message!("mat_broken"))
    }
}

impl Element<'_> {
    fn unsigned(&self) -> Vec<u32> {
        (0..self.data.rest.len() / 4).filter_map(|k| self.data.u32(4 * k)).collect()
    }

    /// Numbers are stored in the smallest type that holds them, whatever their class.
    fn numbers(&self) -> Result<Vec<f64>, Message> {
        let Bytes { rest, big_endian } = self.data;
        macro_rules! of {
            ($kind:ty) => {
                rest.chunks_exact(size_of::<$kind>())
                    .map(|bytes| {
                        let mut own = [0; size_of::<$kind>()];
                        own.copy_from_slice(bytes);
                        (if big_endian { <$kind>::from_be_bytes(own) } else { <$kind>::from_le_bytes(own) }) as f64
                    })
                    .collect()
            };
        }
        Ok(match self.kind {
            1 => of!(i8),
            2 => of!(u8),
            3 => of!(i16),
            4 => of!(u16),
            5 => of!(i32),
            6 => of!(u32),
            7 => of!(f32),
            9 => of!(f64),
            12 => of!(i64),
            13 => of!(u64),
            _ => return Err(message!("mat_broken")),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn element(kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend_from_slice(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }

    fn small(kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = (kind | (data.len() as u32) << 16).to_le_bytes().to_vec();
        bytes.extend_from_slice(data);
        bytes.resize(8, 0);
        bytes
    }

    fn array(class: u32, name: &str, rows: u32, columns: u32, values: &[u8]) -> Vec<u8> {
        let flags = element(6, &[class.to_le_bytes(), [0; 4]].concat());
        let dimensions = element(5, &[rows.to_le_bytes(), columns.to_le_bytes()].concat());
        let name = if name.len() <= 4 { small(1, name.as_bytes()) } else { element(1, name.as_bytes()) };
        element(14, &[flags, dimensions, name, values.to_vec()].concat())
    }

    fn file(elements: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = b"MATLAB 5.0 MAT-file, made by hand".to_vec();
        bytes.resize(124, b' ');
        bytes.extend_from_slice(&[0, 1, b'I', b'M']);
        bytes.extend(elements.iter().flatten());
        bytes
    }

    #[test]
    fn arrays_are_read_plain_deflated_and_in_structures() {
        let doubles: Vec<u8> = [1.5_f64, -2.0, 3.0, 4.0, 5.0, 6.25].iter().flat_map(|v| v.to_le_bytes()).collect();
        let plain = array(6, "gyro", 3, 2, &element(9, &doubles));
        // Doubles that are whole numbers are stored as bytes, a row of them.
        let row = array(6, "time", 1, 3, &small(2, &[7, 8, 9]));
        let mut deflated = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        deflated.write_all(&row).unwrap();
        let deflated = deflated.finish().unwrap();
        let tag = [15_u32.to_le_bytes(), (deflated.len() as u32).to_le_bytes()].concat();
        let field = array(6, "", 2, 1, &element(9, &doubles[..16]));
        let head = [
            element(6, &[2_u32.to_le_bytes(), [0; 4]].concat()),
            element(5, &[1_u32.to_le_bytes(), 1_u32.to_le_bytes()].concat()),
            small(1, b"log"),
            small(5, &8_u32.to_le_bytes()),
            element(1, b"temp\0\0\0\0"),
            field,
        ];
        let found = arrays(&file(&[plain, [tag, deflated].concat(), element(14, &head.concat())])).unwrap();
        let names: Vec<_> = found.iter().map(|a| (a.name.as_str(), a.rows)).collect();
        assert_eq!(names, [("gyro", 3), ("time", 3), ("log.temp", 2)]);
        assert_eq!(found[0].values, [1.5, -2.0, 3.0, 4.0, 5.0, 6.25]);
        assert_eq!(found[1].values, [7.0, 8.0, 9.0]);
    }

    #[test]
    fn a_file_that_breaks_off_is_refused() {
        let whole = file(&[array(6, "gyro", 2, 1, &element(9, &[0; 16]))]);
        for end in [127, 140, 150, whole.len() - 9] {
            assert_eq!(
                arrays(&whole[..end]).map(|a| a.len()).map_err(|m| m.code.into_owned()).err().as_deref(),
                Some("mat_broken"),
                "{end}"
            );
        }
    }
}
