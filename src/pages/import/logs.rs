//! A station's own files on the import page: workbooks and foreign encodings become text, and a raw log becomes a
//! campaign by its map. A log without a map gets a first one, to be answered.

use std::io::Cursor;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::multipart::{Field, Upload};
use crate::core::fault::Faults;
use crate::core::message::{Message, Parameter};
use crate::logs::campaign::{LogCampaign, campaign_from};
use crate::logs::error::LogError;
use crate::logs::guess::{answered, guess_of};
use crate::logs::map::Map;
use crate::logs::programme;
use crate::logs::sheet::readable;
use crate::logs::source::Source;
use crate::logs::text::{decoded, of_utf16};
use crate::pipeline::Submission;
use crate::wire::campaign_csv::to_csv;
use crate::wire::document::is_csv;
use crate::wire::file_kind::{FileKind, HEAD, file_kind};
use crate::words;

/// Lines in which a campaign has its header.
const CAMPAIGN_HEAD: usize = 60;

/// The fields of the form as text/plain has them, with line ends as files have them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Sent {
    /// Name of the file.
    pub file: String,
    pub map: String,
    pub programme: String,
    /// Of the file; as a `data:` address where it is no UTF-8.
    pub text: String,
}

impl Sent {
    pub fn of(form: &str) -> Self {
        let mut rest = form;
        let file = taken(&mut rest, "file=", "\r\n");
        let map = taken(&mut rest, "map=", "\r\nprogramme=");
        let programme = taken(&mut rest, "programme=", "\r\ntext=");
        let text = rest.strip_prefix("text=").unwrap_or(rest);
        let text = text.strip_suffix("\r\n").unwrap_or(text).replace("\r\n", "\n");
        Self { file, map, programme, text }
    }

    /// A file counts before the text.
    pub fn of_form(form: &Upload) -> Self {
        let fields = match form {
            Upload::Plain(text) => return Self::of(text),
            Upload::Fields(fields) => fields,
        };
        let mut sent = Self::default();
        for Field { name, file, content } in fields {
            let text = || String::from_utf8_lossy(content).replace("\r\n", "\n");
            match name.as_str() {
                "map" => sent.map = text(),
                "programme" => sent.programme = text(),
                "document" if !file.is_empty() => {
                    sent.file.clone_from(file);
                    sent.text = match str::from_utf8(content) {
                        Ok(_) if !content.contains(&0) => text().trim_start_matches('\u{feff}').to_owned(),
                        _ => format!("data:application/octet-stream;base64,{}", STANDARD.encode(content)),
                    };
                }
                "text" if sent.file.is_empty() => sent.text = text(),
                _ => {}
            }
        }
        sent
    }

    fn bytes(&self) -> Vec<u8> {
        let base64 = self.text.strip_prefix("data:").and_then(|text| text.split_once(";base64,"));
        base64.and_then(|(_, text)| STANDARD.decode(text.trim()).ok()).unwrap_or_else(|| self.text.clone().into_bytes())
    }

    fn name(&self) -> &str {
        if self.file.is_empty() { "log" } else { &self.file }
    }
}

/// A field up to where the next begins, without its line end.
fn taken(rest: &mut &str, name: &str, end: &str) -> String {
    let Some(field) = rest.strip_prefix(name) else { return String::new() };
    let Some(at) = field.find(end) else { return String::new() };
    *rest = &field[at + "\r\n".len()..];
    field[..at].replace("\r\n", "\n")
}

/// What was sent, as far as it can be looked at.
pub(super) enum UploadContent {
    /// Documents, or a table of them.
    Text(String),
    /// The campaign of a raw log, and its text.
    LogCampaign(Box<LogCampaign>, String),
    /// A first map of a raw log.
    Guessed(String),
    Faulty(Message),
}

/// Turns what was sent into text that documents are read from.
pub(super) fn look(sent: &Sent) -> UploadContent {
    let bytes = sent.bytes();
    // A map that is left from the log before says nothing of a document.
    let is_document = !is_csv(&bytes) || is_campaigns(&sent.text);
    if !sent.map.trim().is_empty() && !is_document {
        return match made(sent, bytes) {
            Ok((made, text)) => UploadContent::LogCampaign(Box::new(made), text),
            Err(error) => UploadContent::Faulty(error.message()),
        };
    }
    let kind = file_kind(&bytes[..bytes.len().min(HEAD)]).ok().filter(|_| is_csv(&bytes));
    match kind {
        Some(FileKind::Mat5 | FileKind::Npy | FileKind::Npz | FileKind::Parquet) => guessed(sent),
        Some(FileKind::Utf16 { big_endian }) => UploadContent::Text(of_utf16(&bytes, big_endian)),
        _ => match readable(bytes) {
            Ok(text) => UploadContent::Text(decoded(&text)),
            Err(fault) => UploadContent::Faulty(LogError::new(sent.name(), fault).message()),
        },
    }
}

/// Whether a text that cannot be read is no campaign with a fault but a table of something else, such as a log.
pub(super) fn is_foreign(text: &str, read: &[(usize, Result<Submission, Faults>)]) -> bool {
    let [(_, Err(faults))] = read else { return false };
    let of_records = || faults.0.iter().any(|fault| says(&fault.message, "table_of_records"));
    is_csv(text.as_bytes()) && !is_campaigns(text) && !of_records()
}

/// Whether a text has what every campaign's table has, whatever else is wrong with it.
fn is_campaigns(text: &str) -> bool {
    let has = |line: &str| line.contains("phase") || line.starts_with('#') && line.contains("imu");
    text.lines().take(CAMPAIGN_HEAD).any(has)
}

/// Whether a message, or one within it, has this code.
fn says(message: &Message, code: &str) -> bool {
    let within = |parameter: &Parameter| matches!(parameter, Parameter::Message(nested) if says(nested, code));
    message.code == code || message.parameters.iter().any(|(_, parameter)| within(parameter))
}

/// A first map of the log that was sent, or why it is none.
pub(super) fn guessed(sent: &Sent) -> UploadContent {
    let source = Source::read(sent.name(), Cursor::new(sent.bytes()));
    match source.and_then(|source| guess_of(vec![(sent.name().to_owned(), source)], words::asked())) {
        Ok(map) => UploadContent::Guessed(map),
        Err(error) => UploadContent::Faulty(error.message()),
    }
}

fn made(sent: &Sent, bytes: Vec<u8>) -> Result<(LogCampaign, String), LogError> {
    let of_map = |fault| LogError::new("map", fault);
    answered(&sent.map).map_err(of_map)?;
    let map = Map::parse(&sent.map).map_err(of_map)?;
    let told = Some(sent.programme.as_str()).filter(|text| !text.trim().is_empty());
    let positions = told.map(programme::of_text).transpose().map_err(|fault| LogError::new("programme", fault))?;
    let source = Source::read(sent.name(), Cursor::new(bytes))?;
    let made = campaign_from(vec![(sent.name().to_owned(), source)], &map, positions.as_deref())?;
    let faults = |faults: Faults| {
        let first = faults.0.into_iter().next().map(|fault| fault.message);
        LogError::new(sent.name(), first.unwrap_or_else(|| Message::verbatim("")))
    };
    let campaign = made.campaign().map_err(faults)?;
    let text = to_csv(&campaign);
    Ok((made, text))
}
