//! What a file holds: one document, or many of them line by line.
//!
//! The content decides, not the name: stations call their files what they like. A single document goes to its own
//! endpoint, byte for byte, so that the service's complaints name places in the file as it is.

use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::time::Duration;

use serde::de::IgnoredAny;
use serde_json::value::RawValue;

use crate::cli::client::JSON;
use crate::cli::document::name;
use crate::cli::prelude::*;
use crate::cli::{Usage, faults};
use crate::core::fault::Faults;
use crate::core::message::Message;
use crate::core::note::Note;
use crate::logs::sheet::readable;
use crate::wire::json::{said_of, without_mark};
use crate::wire::note;
use crate::wire::record_table::{TableMap, documents};
use crate::wire::table::open_end;

/// Longest line, and largest single document: far above any campaign, far below memory.
pub const MAX_DOCUMENT_BYTES: u64 = 16 << 20;

pub enum Content {
    One(ImportDocument),
    /// NDJSON: one document a line.
    Lines(Box<dyn BufRead + Send>),
    /// The members of a JSON array by their number.
    Members(Vec<(u64, Vec<u8>)>),
    /// The documents of a table by the line of their first row, and what is to be said of its end.
    Table(Vec<(u64, Vec<u8>)>, Option<Note>),
}

/// Whether somebody may still be writing a text whose last line has no end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnfinishedFile {
    Waits,
    TakesAsItIs,
}

#[derive(Debug, PartialEq)]
pub struct ImportDocument {
    pub route: &'static str,
    pub content_type: &'static str,
    pub body: Vec<u8>,
}

/// Why a file is not sent. The place is inside `why`.
#[derive(Debug)]
pub struct Unreadable {
    pub why: String,
    /// How long somebody may still be writing it: its text ends before the document does. None at all else.
    pub may_go_on: Duration,
}

/// How long a text that breaks off may still be somebody's unfinished writing.
pub const CUT_SHORT: Duration = Duration::from_secs(60);
/// As [`CUT_SHORT`], of a table that says how many dwells it has: the next may take ten minutes and more.
const COUNTED: Duration = Duration::from_secs(3600);

/// Opens a file; `-` is standard input. The outer error is the file system's, the inner one the content's.
pub fn open(path: &Path, map: &TableMap) -> anyhow::Result<Result<Content, Unreadable>> {
    if path == Path::new("-") {
        let read = read(BufReader::new(std::io::stdin()), map, UnfinishedFile::TakesAsItIs);
        return read.with_context(|| name(path));
    }
    let file = std::fs::File::open(path).with_context(|| path.display().to_string())?;
    if file.metadata().is_ok_and(|m| m.is_dir()) {
        let folder = path.display().to_string();
        return Err(Usage(said(message!("terminal_is_folder", folder))).into());
    }
    read_file(file, map, UnfinishedFile::TakesAsItIs).with_context(|| path.display().to_string())
}

/// As [`open`], of a file that is open.
pub fn read_file(
    mut file: std::fs::File,
    map: &TableMap,
    if_unfinished: UnfinishedFile,
) -> anyhow::Result<Result<Content, Unreadable>> {
    let ends = if_unfinished == UnfinishedFile::TakesAsItIs || ends_with_a_line(&mut file)?;
    Ok(match read(BufReader::with_capacity(1 << 20, file), map, if_unfinished)? {
        Ok(Content::Lines(_)) if !ends => Err(unreadable(&message!("file_last_line_open"), CUT_SHORT)),
        read => read,
    })
}

/// Whether the last byte is a line break; what is no file to seek in is taken to end.
fn ends_with_a_line(file: &mut std::fs::File) -> std::io::Result<bool> {
    let mut last = [b'\n'];
    if file.seek(SeekFrom::End(-1)).is_ok() {
        file.read_exact(&mut last)?;
        file.rewind()?;
    }
    Ok(last == [b'\n'])
}

/// Reads the first line; when that alone is a JSON document and more follows, the rest is lines of such.
fn read(
    mut reader: impl BufRead + Send + 'static,
    map: &TableMap,
    if_unfinished: UnfinishedFile,
) -> anyhow::Result<Result<Content, Unreadable>> {
    let mut head = Vec::new();
    while head.trim_ascii().is_empty() {
        if read_line(&mut reader, &mut head)? == 0 {
            return Ok(Err(unreadable(&message!("file_empty"), CUT_SHORT)));
        }
    }
    let first_is_whole = serde_json::from_slice::<IgnoredAny>(without_mark(&head)).is_ok();
    if first_is_whole && starts_with(&head, b'{') && !reader.fill_buf()?.trim_ascii().is_empty() {
        return Ok(Ok(Content::Lines(Box::new(std::io::Cursor::new(head).chain(reader)))));
    }
    let mut rest = reader.take(MAX_DOCUMENT_BYTES);
    rest.read_to_end(&mut head)?;
    if head.len() as u64 >= MAX_DOCUMENT_BYTES {
        let why = message!("file_document_too_large", bytes = MAX_DOCUMENT_BYTES);
        return Ok(Err(unreadable(&why, Duration::ZERO)));
    }
    Ok(classify(head, map, if_unfinished))
}

/// The one document that a file holds.
pub fn single(text: Vec<u8>) -> Result<ImportDocument, Unreadable> {
    match classify(text, &TableMap::default(), UnfinishedFile::TakesAsItIs)? {
        Content::One(document) => Ok(document),
        Content::Members(mut all) | Content::Table(mut all, _) => match (all.pop(), all.len()) {
            (Some((_, body)), 0) => Ok(ImportDocument { route: route_of(&body)?, content_type: JSON, body }),
            (_, others) => Err(unreadable(&message!("file_of_several", count = others + 1), Duration::ZERO)),
        },
        Content::Lines(_) => Err(unreadable(&message!("file_of_lines"), Duration::ZERO)),
    }
}

/// Like `read_until`, but a line without end cannot fill the memory.
pub fn read_line(reader: &mut (impl BufRead + ?Sized), line: &mut Vec<u8>) -> std::io::Result<usize> {
    reader.take(MAX_DOCUMENT_BYTES).read_until(b'\n', line)
}

fn classify(text: Vec<u8>, map: &TableMap, if_unfinished: UnfinishedFile) -> Result<Content, Unreadable> {
    if starts_with(&text, b'[') {
        return members(&text);
    }
    if !starts_with(&text, b'{') {
        let text = readable(text).map_err(|fault| unreadable(&fault, Duration::ZERO))?;
        let open = open_end(&text);
        if let (UnfinishedFile::Waits, Some(open)) = (if_unfinished, &open) {
            return Err(Unreadable { why: said(note::message(open)), may_go_on: CUT_SHORT });
        }
        if let Some(documents) = std::str::from_utf8(&text).ok().and_then(|text| documents(text, map)) {
            let refused = |found: Faults| Unreadable { why: faults::in_words(&found), may_go_on: Duration::ZERO };
            let lines = documents.map_err(refused)?.into_iter();
            let lines = lines.map(|(line, document)| (line as u64, document.to_string().into_bytes()));
            return Ok(Content::Table(lines.collect(), open));
        }
        if let Some((told, have)) = unfinished(&text) {
            return Err(unreadable(&message!("dwells_told", told, have), COUNTED));
        }
        let content_type = "text/csv";
        return Ok(Content::One(ImportDocument { route: "/v1/campaigns", content_type, body: text }));
    }
    let route = route_of(without_mark(&text))?;
    Ok(Content::One(ImportDocument { route, content_type: JSON, body: text }))
}

/// Of a table whose head says how many dwells follow (`# dwells: 78`) and that has fewer: both numbers.
fn unfinished(text: &[u8]) -> Option<(usize, usize)> {
    let lines = || text.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    let told = lines().find_map(|line| line.strip_prefix(b"# dwells:"))?;
    let told: usize = std::str::from_utf8(told.trim_ascii()).ok()?.parse().ok()?;
    let have = lines().filter(|line| !line.is_empty() && !line.starts_with(b"#")).count().saturating_sub(1);
    (have < told).then_some((told, have))
}

/// Which endpoint takes the document, by the member that only its kind has.
fn route_of(text: &[u8]) -> Result<&'static str, Unreadable> {
    let members: std::collections::BTreeMap<String, IgnoredAny> = serde_json::from_slice(text).map_err(not_json)?;
    let has = |name: &str| members.contains_key(name);
    if has("dwells") {
        Ok("/v1/campaigns")
    } else if has("gyros") {
        Ok("/v1/records")
    } else if has("method") {
        Ok("/v1/bench-results")
    } else {
        Err(unreadable(&message!("file_of_no_kind"), Duration::ZERO))
    }
}

/// No line break may stand inside a JSON string, so every one between tokens can become a blank.
fn members(text: &[u8]) -> Result<Content, Unreadable> {
    let members: Vec<&RawValue> = serde_json::from_slice(without_mark(text)).map_err(not_json)?;
    let one_line = |raw: &&RawValue| raw.get().replace(['\n', '\r'], " ").into_bytes();
    Ok(Content::Members((1..).zip(members.iter().map(one_line)).collect()))
}

fn not_json(error: serde_json::Error) -> Unreadable {
    let may_go_on = if error.is_eof() { CUT_SHORT } else { Duration::ZERO };
    unreadable(&message!("value_not_json", why = said_of(&error)), may_go_on)
}

fn unreadable(why: &Message, may_go_on: Duration) -> Unreadable {
    Unreadable { why: said(why), may_go_on }
}

fn starts_with(text: &[u8], first: u8) -> bool {
    without_mark(text).trim_ascii_start().first() == Some(&first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn content(text: &'static str) -> Result<Content, Unreadable> {
        read(text.as_bytes(), &TableMap::default(), UnfinishedFile::TakesAsItIs).unwrap()
    }

    fn route(text: &'static str) -> &'static str {
        match content(text) {
            Ok(Content::One(document)) => {
                assert_eq!(document.body, text.as_bytes(), "sent byte for byte");
                document.route
            }
            _ => panic!("{text} is one document"),
        }
    }

    #[test]
    fn a_document_goes_to_the_endpoint_of_its_kind() {
        assert_eq!(route("{\"imu\": \"A\",\n \"gyros\": []}\n"), "/v1/records");
        assert_eq!(route("{\"gyros\": [], \"dwells\": []}"), "/v1/campaigns");
        assert_eq!(route("\u{feff}{\"method\": \"torque_feedback\"}"), "/v1/bench-results");
        assert_eq!(route("# imu: A\nphase,start_s\nstatic,0\n"), "/v1/campaigns");
    }

    #[test]
    fn a_table_that_excel_saved_in_china_is_read() {
        const TABLE: &str = "# imu: A\n# station: 北京一站\nphase,start_s\nstatic,0\n";
        let saved = |bytes: Vec<u8>| match classify(bytes, &TableMap::default(), UnfinishedFile::TakesAsItIs) {
            Ok(Content::One(document)) => document.body,
            _ => panic!("one document"),
        };
        assert_eq!(saved(encoding_rs::GBK.encode(TABLE).0.into_owned()), TABLE.as_bytes());
        let broken =
            TABLE.replace("北京一站", "ST-1").replace('1', "\u{e9}").chars().map(|c| c as u8).collect::<Vec<u8>>();
        assert_eq!(saved(broken.clone()), broken, "a byte by itself is for the service to name");
    }

    #[test]
    fn lines_are_told_from_one_document_by_what_the_first_line_holds() {
        assert!(matches!(content("{\"gyros\": []}\n{\"gyros\": []}\n"), Ok(Content::Lines(_))));
        assert!(matches!(content("\n{\"gyros\": []}\nnot json\n"), Ok(Content::Lines(_))));
        assert!(matches!(content("{\"gyros\": []}\n\n"), Ok(Content::One(_))));
        let Ok(Content::Members(members)) = content("[{\"a\":\n1},\n{\"b\":2}]") else { panic!("an array") };
        assert_eq!(members, [(1, b"{\"a\": 1}".to_vec()), (2, b"{\"b\":2}".to_vec())]);
    }

    #[test]
    fn a_text_that_breaks_off_is_told_from_one_that_is_wrong() {
        let cut = |text| content(text).err().expect("cannot be sent").may_go_on > Duration::ZERO;
        assert!(cut("{\"gyros\": [\n"));
        assert!(cut(""));
        assert!(cut("[{\"gyros\": []},\n"));
        assert!(cut("# dwells: 2\nphase,start_s\nstatic,0\n"));
        assert!(content("# dwells: 1\nphase,start_s\nstatic,0\n").is_ok());
        assert!(!cut("{\"gyros\" = 1}\n"));
        assert!(!cut("{\"imu\": \"A\"}\n"));
    }

    #[test]
    fn a_table_whose_last_line_has_no_end_may_go_on() {
        const TABLE: &str = "phase,start_s\nstatic,0\nstatic,18";
        const RECORDS: &str = "serial,measured_at,station,method,d_i_deg_per_h_g0,d_s_deg_per_h_g0\n\
                               A-1,2026-03-01T08:00:00Z,ST-1,torque_feedback,1.5,-2.2";
        let waiting = |text: &'static str| read(text.as_bytes(), &TableMap::default(), UnfinishedFile::Waits).unwrap();
        for text in [TABLE, RECORDS] {
            assert!(waiting(text).is_err_and(|unreadable| unreadable.may_go_on == CUT_SHORT));
        }
        for text in ["phase,start_s\nstatic,0\n", "phase,start_s\r\nstatic,0\r\n", "{\"gyros\": []}"] {
            assert!(waiting(text).is_ok(), "{text}");
        }
        assert!(matches!(content(TABLE), Ok(Content::One(_))));
        let Ok(Content::Table(_, Some(open))) = content(RECORDS) else { panic!("a table of bench results") };
        assert_eq!(open, Note::NoLineEnd { line: 2, value: "-2.2".to_owned() });
    }
}
