//! What a file is, by its first bytes: text, or one of the formats that stations and loggers write.

use crate::core::message::Message;
use crate::message;

/// How a file is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    Text,
    Utf16 {
        big_endian: bool,
    },
    Mat5,
    Xlsx,
    Npy,
    /// A zip archive of NumPy's arrays.
    Npz,
    Parquet,
}

impl FileKind {
    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Text | Self::Utf16 { .. } => "text",
            Self::Mat5 => "MATLAB (.mat)",
            Self::Xlsx => "Excel (.xlsx)",
            Self::Npy => "NumPy (.npy)",
            Self::Npz => "NumPy (.npz)",
            Self::Parquet => "Parquet",
        }
    }
}

/// Bytes that are looked at.
pub const HEAD: usize = 64 * 1024;

/// Tells by the first bytes of a file how it is read.
///
/// # Errors
/// What it is, where it is known but not read, with what to do about it.
pub fn file_kind(head: &[u8]) -> Result<FileKind, Message> {
    let starts = |magic: &[u8]| head.starts_with(magic);
    let is_73 = starts(b"MATLAB 7.3 MAT-file");
    if is_73 || starts(b"\x89HDF\r\n\x1a\n") || head.get(512..520) == Some(b"\x89HDF\r\n\x1a\n") {
        return Err(if is_73 { message!("file_is_mat", version = "7.3") } else { message!("file_is_hdf5") });
    }
    if is_mat4(head) {
        return Err(message!("file_is_mat", version = "4"));
    }
    if starts(b"MATLAB 5.0 MAT-file") {
        return Ok(FileKind::Mat5);
    }
    if starts(b"PK\x03\x04") {
        let holds = |name: &[u8]| memchr::memmem::find(head, name).is_some();
        let first = head.get(26).and_then(|&length| head.get(30..30 + usize::from(length)));
        return if first.is_some_and(|name| name.ends_with(b".npy")) {
            Ok(FileKind::Npz)
        } else if holds(b"xl/") || holds(b"[Content_Types].xml") {
            Ok(FileKind::Xlsx)
        } else {
            Err(message!("file_is_zip"))
        };
    }
    if starts(b"\x93NUMPY") {
        return Ok(FileKind::Npy);
    }
    if starts(b"PAR1") {
        return Ok(FileKind::Parquet);
    }
    if let Some((_, fault)) = foreign().into_iter().find(|(magic, _)| starts(magic)) {
        return Err(fault);
    }
    if starts(b"\xff\xfe") || starts(b"\xfe\xff") {
        return Ok(FileKind::Utf16 { big_endian: head[0] == 0xfe });
    }
    match text_of(head) {
        Some(kind) => Ok(kind),
        None if head.iter().all(|&b| b == 0) && !head.is_empty() => Err(message!("file_is_zeros")),
        None => Err(message!("file_is_binary")),
    }
}

/// Version 4 of MATLAB's files has no mark: the first matrix begins with its type (numbers of ten kinds and orders of
/// bytes), rows, columns, whether it is complex, and the length of its name, which follows.
fn is_mat4(head: &[u8]) -> bool {
    let word = |at: usize| Some(u32::from_le_bytes(head.get(at..at + 4)?.try_into().ok()?));
    let of = |swap: fn(u32) -> u32| {
        let [kind, rows, columns, complex, length] = [0, 4, 8, 12, 16].map(|at| word(at).map_or(u32::MAX, swap));
        let name = head.get(20..20_usize.saturating_add(length as usize));
        let is_name = |name: &[u8]| name.strip_suffix(b"\0").is_some_and(|name| name.iter().all(u8::is_ascii_graphic));
        kind < 1100
            && kind % 100 < 53
            && rows.min(columns) > 0
            && complex < 2
            && length > 1
            && name.is_some_and(is_name)
    };
    of(|word| word) || of(u32::swap_bytes)
}

/// What begins with these bytes is known, and is not read.
fn foreign() -> [(&'static [u8], Message); 13] {
    let other = |name: &'static str| message!("file_is_other", name);
    [
        (b"ULog\x01\x12\x35", message!("file_is_ulog")),
        (b"#ROSBAG V", message!("file_is_rosbag")),
        (b"\x89MCAP0\r\n", message!("file_is_mcap")),
        (b"\xa3\x95", message!("file_is_dataflash")),
        (b"TDSm", message!("file_is_tdms")),
        (b"\xd0\xcf\x11\xe0", message!("file_is_xls")),
        (b"SQLite format 3", other("SQLite")),
        (b"\x1f\x8b", message!("file_is_gzip")),
        (b"%PDF", other("PDF")),
        (b"ARROW1", message!("file_is_arrow")),
        (b"FEA1", message!("file_is_arrow")),
        (b"{", message!("file_is_json")),
        (b"[{", message!("file_is_json")),
    ]
}

/// Text of one byte or more a character, or of two; none of what has control characters. A tail of zeros is what a
/// crash leaves, and said where it is read.
fn text_of(head: &[u8]) -> Option<FileKind> {
    let zeros = |from: usize| head.iter().skip(from).step_by(2).filter(|&&b| b == 0).count();
    let half = head.len() / 2;
    if half > 8 && zeros(1) * 10 > half * 9 && zeros(0) * 10 < half {
        return Some(FileKind::Utf16 { big_endian: false });
    }
    if half > 8 && zeros(0) * 10 > half * 9 && zeros(1) * 10 < half {
        return Some(FileKind::Utf16 { big_endian: true });
    }
    let text = &head[..head.iter().rposition(|&b| b != 0).map_or(0, |last| last + 1)];
    let odd = |b: &&u8| **b < 0x20 && !matches!(**b, 0 | b'\t' | b'\n' | b'\r' | 0x0c | 0x1a);
    // A logger that lost power leaves many zeros on end, and may have gone on behind them.
    let lone = text.windows(3).filter(|three| three[1] == 0 && three[0] != 0 && three[2] != 0).count();
    let controls = text.iter().filter(odd).count() + lone;
    (!text.is_empty() && controls * 1000 <= text.len()).then_some(FileKind::Text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_their_first_bytes() {
        let code = |head: &[u8]| file_kind(head).map_err(|fault| fault.code.into_owned());
        let refused = |code: &str| Err(code.to_owned());
        assert_eq!(code(b"t,ax\n0,1\n"), Ok(FileKind::Text));
        assert_eq!(code(b"\xef\xbb\xbft,ax\n"), Ok(FileKind::Text));
        assert_eq!(code(b"Beschleunigung [m/s\xb2]\n"), Ok(FileKind::Text));
        assert_eq!(code(b"\xff\xfet\0,\0"), Ok(FileKind::Utf16 { big_endian: false }));
        assert_eq!(code(b"t\0i\0m\0e\0,\0a\0x\0\n\x000\0,\x001\0"), Ok(FileKind::Utf16 { big_endian: false }));
        assert_eq!(code(b"PK\x03\x04....[Content_Types].xml"), Ok(FileKind::Xlsx));
        let zip = |name: &[u8]| {
            let header = [b"PK\x03\x04".as_slice(), &[0; 22], &[name.len() as u8, 0, 0, 0], name, b"..."];
            code(&header.concat())
        };
        assert_eq!(zip(b"gyro.npy"), Ok(FileKind::Npz));
        assert_eq!(zip(b"gyro.csv"), refused("file_is_zip"));
        assert_eq!(code(b"\x93NUMPY\x01\x00v\x00{'descr': "), Ok(FileKind::Npy));
        assert_eq!(code(b"PAR1\x15\x04\x15"), Ok(FileKind::Parquet));
        assert_eq!(code(b"MATLAB 5.0 MAT-file, Platform: PCWIN64"), Ok(FileKind::Mat5));
        assert_eq!(code(b"MATLAB 7.3 MAT-file, Platform"), refused("file_is_mat"));
        let mat4 =
            [0_u32, 100, 3, 0, 3].iter().flat_map(|word| word.to_le_bytes()).chain(*b"gx\0").collect::<Vec<u8>>();
        assert_eq!(code(&[&mat4[..], &[0; 99]].concat()), refused("file_is_mat"));
        assert_eq!(code(b"ULog\x01\x12\x35\x01...."), refused("file_is_ulog"));
        assert_eq!(code(b"#ROSBAG V2.0\n"), refused("file_is_rosbag"));
        assert_eq!(code(b"ARROW1\0\0\xff\xff"), refused("file_is_arrow"));
        assert_eq!(code(b"FEA1\x10\0\0\0"), refused("file_is_arrow"));
        assert_eq!(code(&[0; 64]), refused("file_is_zeros"));
        assert_eq!(code(&[&b"t,ax\n0,1\n"[..], &[0; 40], b"\n1,2\n"].concat()), Ok(FileKind::Text));
        assert_eq!(code(&[1, 2, 3, 4, 5, 6, 7, 250, 0, 1, 2, 3]), refused("file_is_binary"));
    }
}
