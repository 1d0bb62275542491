//! NumPy's arrays: `.npy`, and `.npz` that holds several by name.
//!
//! Format: NEP 1, "A Simple File Format for NumPy Arrays": eight bytes with the version, the length of a header, the
//! header (a Python dictionary: type, order, shape), the numbers. Crates that read it bring a grammar of all of
//! Python's literals, and types that are known before the file is opened; a log's are not.

use std::io::{Cursor, Read};

use zip::ZipArchive;

use super::column::{Column, Named};
use crate::core::message::Message;
use crate::message;

const MAGIC: &[u8] = b"\x93NUMPY";
/// Most bytes that an archive's member may unpack to, and most columns that an array may be.
const MOST_BYTES: u64 = 4 << 30;
const MOST_COLUMNS: usize = 10_000;
/// Longest text in a structured array.
const MOST_BYTES_OF_ONE: usize = 1 << 20;
/// An array of more columns than that, and of fewer rows than columns, holds a channel a row.
const CHANNELS: usize = 100;

/// The columns of an array: those of a structured one by their names, others without.
pub fn columns(file: &[u8]) -> Result<Vec<Named>, Message> {
    of_array(file, "")
}

/// The columns of all arrays of numbers in an archive, each by its array's name.
pub fn columns_of_archive(file: &[u8]) -> Result<Vec<Named>, Message> {
    let mut archive = ZipArchive::new(Cursor::new(file)).map_err(|_| message!("npy_broken"))?;
    let mut found = Vec::new();
    let mut refused = None;
    let single = archive.len() == 1;
    for place in 0..archive.len() {
        let member = archive.by_index(place).map_err(|_| message!("npy_broken"))?;
        let name = member.name().map_err(|_| message!("npy_broken"))?.into_owned();
        let Some(name) = name.strip_suffix(".npy") else { continue };
        let mut bytes = Vec::new();
        member.take(MOST_BYTES).read_to_end(&mut bytes).map_err(|_| message!("npy_broken"))?;
        // Beside a log there may be whatever else somebody has saved.
        match of_array(&bytes, if single { "" } else { name }) {
            Ok(columns) => found.extend(columns),
            Err(fault) => refused = Some(fault),
        }
    }
    match refused {
        Some(fault) if found.is_empty() => Err(fault),
        _ => Ok(found),
    }
}

fn of_array(file: &[u8], prefix: &str) -> Result<Vec<Named>, Message> {
    let broken = || message!("npy_broken");
    let rest = file.strip_prefix(MAGIC).ok_or_else(broken)?;
    let (length, from) = match *rest {
        [1, _, a, b, ..] => (usize::from(u16::from_le_bytes([a, b])), 4),
        [2 | 3, _, a, b, c, d, ..] => (u32::from_le_bytes([a, b, c, d]) as usize, 6),
        _ => return Err(broken()),
    };
    let header = rest[from..].get(..length).ok_or_else(broken)?;
    let header = Header::read(&String::from_utf8_lossy(header)).ok_or_else(broken)?;
    let data = &rest[from + length..];
    if header.fields.iter().any(|field| field.of.kind == 'O') {
        return Err(message!("npy_pickled"));
    }
    let size: usize = header.fields.iter().map(Field::size).sum();
    let [rows, across] = match header.shape[..] {
        [rows] => [rows, 1],
        [rows, across] => [rows, across],
        _ => return Err(message!("npy_shape", dimensions = header.shape.len())),
    };
    let bytes = rows.checked_mul(across).and_then(|cells| cells.checked_mul(size)).ok_or_else(broken)?;
    let data = data.get(..bytes).ok_or_else(broken)?;
    let lies = header.fortran_order != (across > CHANNELS && across > rows);
    let [rows, across] = if across > CHANNELS && across > rows { [across, rows] } else { [rows, across] };
    let columns = header.fields.iter().map(|field| field.parts).sum::<usize>().saturating_mul(across);
    if columns > MOST_COLUMNS {
        return Err(message!("npy_wide", columns, rows));
    }
    let place = |row: usize, column: usize| if lies { column * rows + row } else { row * across + column };
    let mut named = Vec::new();
    for column in 0..across {
        let mut at = 0;
        for field in &header.fields {
            for part in 0..field.parts {
                let begin = at + part * field.of.size;
                let value = |row: usize| field.of.value(&data[place(row, column) * size + begin..]);
                let Some(unit) = field.of.unit() else { continue };
                let heading = Column::named(&field.name);
                let names = [prefix, &heading.name].into_iter().filter(|name| !name.is_empty());
                let mut name = names.collect::<Vec<_>>().join(".");
                for (number, of) in [(column, across), (part, field.parts)] {
                    if of > 1 && !name.is_empty() {
                        name.push_str(&format!(".{}", number + 1));
                    }
                }
                named.push((Column { name, unit: unit.or(heading.unit) }, (0..rows).map(value).collect()));
            }
            at += field.size();
        }
    }
    if named.is_empty() { Err(message!("npy_no_numbers")) } else { Ok(named) }
}

struct Header {
    fields: Vec<Field>,
    fortran_order: bool,
    shape: Vec<usize>,
}

/// A member of a structured array; of a plain one all there is, without a name.
struct Field {
    name: String,
    of: Type,
    parts: usize,
}

impl Field {
    fn size(&self) -> usize {
        self.of.size * self.parts
    }
}

/// A type as NumPy writes it: `<f8`, `|b1`, `<M8[us]`.
struct Type {
    kind: char,
    size: usize,
    big_endian: bool,
    /// Of an instant, what it counts.
    counts: Option<String>,
}

impl Type {
    fn read(text: &str) -> Option<Self> {
        let rest = text.strip_prefix(['<', '>', '|', '=']).unwrap_or(text);
        let kind = rest.chars().next()?;
        let rest = &rest[kind.len_utf8()..];
        let (size, counts) = match rest.split_once('[') {
            Some((size, counts)) => (size, Some(counts.trim_end_matches(']').to_owned())),
            None => (rest, None),
        };
        let size = if kind == 'O' { 0 } else { size.parse::<usize>().ok()? };
        // Characters have four bytes.
        let size = if kind == 'U' { size.checked_mul(4)? } else { size };
        if size > MOST_BYTES_OF_ONE {
            return None;
        }
        Some(Self { kind, size, big_endian: text.starts_with('>'), counts })
    }

    /// The unit of its numbers, where that is known; none of what is no number.
    fn unit(&self) -> Option<Option<String>> {
        match (self.kind, self.size) {
            ('f', 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8) | ('b', 1) => Some(None),
            ('M', 8) => match self.counts.as_deref() {
                Some(counts @ ("s" | "ms" | "us" | "ns")) => Some(Some(format!("unix_{counts}"))),
                _ => None,
            },
            ('m', 8) => Some(self.counts.clone()),
            _ => None,
        }
    }

    /// The number at the begin of some bytes.
    fn value(&self, bytes: &[u8]) -> f64 {
        macro_rules! of {
            ($kind:ty) => {{
                let mut own = [0; size_of::<$kind>()];
                own.copy_from_slice(&bytes[..size_of::<$kind>()]);
                (if self.big_endian { <$kind>::from_be_bytes(own) } else { <$kind>::from_le_bytes(own) }) as f64
            }};
        }
        match (self.kind, self.size) {
            ('f', 4) => of!(f32),
            ('f', 8) => of!(f64),
            ('u' | 'b', 1) => of!(u8),
            ('u', 2) => of!(u16),
            ('u', 4) => of!(u32),
            ('u', 8) => of!(u64),
            ('i', 1) => of!(i8),
            ('i', 2) => of!(i16),
            ('i', 4) => of!(i32),
            // What is no time (NaT) is the least there is.
            ('M' | 'm', 8) if of!(i64) == i64::MIN as f64 => f64::NAN,
            ('i' | 'M' | 'm', 8) => of!(i64),
            _ => f64::NAN,
        }
    }
}

impl Header {
    /// `{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }`
    fn read(text: &str) -> Option<Self> {
        let Literal::Dictionary(pairs) = Literal::read(text)? else { return None };
        let value = |key: &str| pairs.iter().find(|(name, _)| name == key).map(|(_, value)| value);
        let fields = match value("descr")? {
            Literal::Text(kind) => vec![Field { name: String::new(), of: Type::read(kind)?, parts: 1 }],
            Literal::List(members) => members.iter().map(Self::field).collect::<Option<_>>()?,
            _ => return None,
        };
        let Literal::Word(order) = value("fortran_order")? else { return None };
        let Literal::List(shape) = value("shape")? else { return None };
        let shape = shape.iter().map(Literal::count).collect::<Option<_>>()?;
        Some(Self { fields, fortran_order: order == "True", shape })
    }

    /// `('t', '<f8')`, or `('gyro', '<f8', (3,))`; a name may be a pair of title and name.
    fn field(member: &Literal) -> Option<Field> {
        let Literal::List(parts) = member else { return None };
        let name = match parts.first()? {
            Literal::Text(name) => name.clone(),
            Literal::List(names) => match names.last()? {
                Literal::Text(name) => name.clone(),
                _ => return None,
            },
            _ => return None,
        };
        let Literal::Text(kind) = parts.get(1)? else { return None };
        let count = match parts.get(2) {
            None => 1,
            Some(Literal::List(shape)) => shape.iter().try_fold(1_usize, |all, n| all.checked_mul(n.count()?))?,
            Some(one) => one.count()?,
        };
        if count > MOST_COLUMNS {
            return None;
        }
        Some(Field { name, of: Type::read(kind)?, parts: count })
    }
}

/// As much of Python as headers are written in.
enum Literal {
    Dictionary(Vec<(String, Literal)>),
    /// A tuple too.
    List(Vec<Literal>),
    Text(String),
    /// A number, True or False.
    Word(String),
}

/// Deepest nesting of a header.
const DEEPEST: usize = 8;

impl Literal {
    fn read(text: &str) -> Option<Self> {
        Self::take(&mut text.trim(), 0)
    }

    fn count(&self) -> Option<usize> {
        match self {
            // Python 2 wrote `3L`.
            Self::Word(word) => word.trim_end_matches('L').parse().ok(),
            _ => None,
        }
    }

    /// Takes one from the begin of `rest`.
    fn take(rest: &mut &str, depth: usize) -> Option<Self> {
        if depth > DEEPEST {
            return None;
        }
        let first = rest.chars().next()?;
        match first {
            '{' => {
                let mut pairs = Vec::new();
                *rest = rest[1..].trim_start();
                while !ends(rest, '}')? {
                    let Self::Text(key) = Self::take(rest, depth + 1)? else { return None };
                    *rest = rest.trim_start().strip_prefix(':')?.trim_start();
                    pairs.push((key, Self::take(rest, depth + 1)?));
                    next(rest);
                }
                Some(Self::Dictionary(pairs))
            }
            '(' | '[' => {
                let mut members = Vec::new();
                *rest = rest[1..].trim_start();
                while !ends(rest, if first == '(' { ')' } else { ']' })? {
                    members.push(Self::take(rest, depth + 1)?);
                    next(rest);
                }
                Some(Self::List(members))
            }
            '\'' | '"' => {
                let text = &rest[1..];
                let end = text.find(first)?;
                let (text, after) = text.split_at(end);
                *rest = &after[1..];
                Some(Self::Text(text.to_owned()))
            }
            _ => {
                let end = rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
                let (word, after) = rest.split_at(end);
                *rest = after;
                (!word.is_empty()).then(|| Self::Word(word.to_owned()))
            }
        }
    }
}

/// Whether the closing bracket is next, which is then taken; none at the end of the text.
fn ends(rest: &mut &str, bracket: char) -> Option<bool> {
    match rest.strip_prefix(bracket) {
        Some(after) => {
            *rest = after;
            Some(true)
        }
        None => (!rest.is_empty()).then_some(false),
    }
}

fn next(rest: &mut &str) {
    *rest = rest.trim_start();
    *rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn file(descr: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n");
        let length = (header.len() as u16).to_le_bytes();
        [MAGIC, &[1, 0], &length, header.as_bytes(), data].concat()
    }

    fn doubles(values: &[f64]) -> Vec<u8> {
        values.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    fn read(file: &[u8]) -> Vec<(String, Vec<f64>)> {
        columns(file).unwrap().into_iter().map(|(column, values)| (column.name, values)).collect()
    }

    fn refused(file: &[u8]) -> String {
        columns(file).unwrap_err().code.into_owned()
    }

    #[test]
    fn arrays_are_read_in_either_order_and_lying_down() {
        let by_rows = doubles(&[1.0, 10.0, 2.0, 20.0, 3.0, 30.0]);
        let by_columns = doubles(&[1.0, 2.0, 3.0, 10.0, 20.0, 30.0]);
        let two = [(String::new(), vec![1.0, 2.0, 3.0]), (String::new(), vec![10.0, 20.0, 30.0])];
        assert_eq!(read(&file("'<f8'", "False", "(3, 2)", &by_rows)), two);
        assert_eq!(read(&file("'<f8'", "True", "(3, 2)", &by_columns)), two);
        let line: Vec<f64> = (0..400).map(f64::from).collect();
        let lying = read(&file("'<f8'", "False", "(2, 200)", &doubles(&line)));
        assert_eq!((lying.len(), &lying[1].1[..2]), (2, &[200.0, 201.0][..]));
        let lying = read(&file("'<f8'", "True", "(2, 200)", &doubles(&line)));
        assert_eq!((lying.len(), &lying[1].1[..2]), (2, &[1.0, 3.0][..]));
        let whole: Vec<u8> = [-2_i16, 300].iter().flat_map(|value| value.to_be_bytes()).collect();
        assert_eq!(read(&file("'>i2'", "False", "(2,)", &whole)), [(String::new(), vec![-2.0, 300.0])]);
    }

    #[test]
    fn members_of_a_structured_array_are_columns_by_their_names() {
        let row = |at: i64, text: &[u8; 4], gyro: [f32; 2]| {
            [&at.to_le_bytes()[..], text, &gyro[0].to_le_bytes(), &gyro[1].to_le_bytes()].concat()
        };
        let data = [row(5, b"idle", [0.5, 1.5]), row(i64::MIN, b"move", [2.5, 3.5])].concat();
        let descr = "[('t', '<M8[us]'), ('state', '|S4'), (('angular rate', 'gyro [deg/s]'), '<f4', (2,))]";
        let found = columns(&file(descr, "False", "(2,)", &data)).unwrap();
        let named: Vec<_> = found.iter().map(|(c, _)| (c.name.as_str(), c.unit.as_deref())).collect();
        assert_eq!(named, [("t", Some("unix_us")), ("gyro.1", Some("deg/s")), ("gyro.2", Some("deg/s"))]);
        assert_eq!((found[0].1[0], found[0].1[1].is_nan()), (5.0, true));
        assert_eq!(found[2].1, [1.5, 3.5]);
    }

    #[test]
    fn arrays_of_an_archive_have_its_names() {
        let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, content) in [
            ("t.npy", file("'<f8'", "False", "(2,)", &doubles(&[0.0, 1.0]))),
            ("gyro.npy", file("'<f8'", "False", "(2, 2)", &doubles(&[1.0, 2.0, 3.0, 4.0]))),
            ("comment.npy", file("'|O'", "False", "()", b"pickled")),
            ("read me.txt", b"text".to_vec()),
        ] {
            archive.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
            archive.write_all(&content).unwrap();
        }
        let found = columns_of_archive(&archive.finish().unwrap().into_inner()).unwrap();
        let named: Vec<_> = found.iter().map(|(column, values)| (column.name.as_str(), values[1])).collect();
        assert_eq!(named, [("t", 1.0), ("gyro.1", 3.0), ("gyro.2", 4.0)]);
    }

    #[test]
    fn what_holds_no_table_is_refused() {
        let whole = file("'<f8'", "False", "(2, 2)", &doubles(&[1.0; 4]));
        for end in [6, 9, 20, whole.len() - 1] {
            assert_eq!(refused(&whole[..end]), "npy_broken", "{end}");
        }
        assert_eq!(refused(&file("'|O'", "False", "(2,)", &[0; 16])), "npy_pickled");
        assert_eq!(refused(&file("'<f8'", "False", "(2, 1, 1)", &doubles(&[1.0; 2]))), "npy_shape");
        assert_eq!(refused(&file("'<U2'", "False", "(2,)", &[0; 16])), "npy_no_numbers");
        assert_eq!(refused(&file("'<f8'", "False", "(99999999999, 99999999999)", &[])), "npy_broken");
        assert_eq!(refused(&file("'<f8'", "False", "((((((((((((2", &[])), "npy_broken");
    }
}
