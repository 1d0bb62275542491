//! Carries the content of one file to the service, however large, and tells what became of every document in it.

use std::io::BufRead;
use std::ops::AddAssign;
use std::time::Duration;

use bytes::Bytes;
use reqwest::StatusCode;
use serde_json::Value;

use super::source::{Content, ImportDocument, MAX_DOCUMENT_BYTES, read_line};
use crate::cli::client::{ClientError, ImportLineAnswer, Sent, Service};
use crate::cli::faults;
use crate::cli::prelude::*;
use crate::core::message::{Message, list};
use crate::core::note::Note;
use crate::wire::differences::counted;
use crate::wire::document::DocumentKind;
use crate::wire::note;
use crate::wire::problem::ProblemBody;

/// A batch ends at either: enough to share a commit, little enough to answer soon.
const BATCH_LINES: usize = 1000;
const BATCH_BYTES: u64 = 1 << 20;
/// Pauses before a busy or absent service is asked again, for somebody who waits at the terminal.
pub const PATIENCE: [Duration; 5] = [
    Duration::from_millis(250),
    Duration::from_secs(1),
    Duration::from_secs(3),
    Duration::from_secs(8),
    Duration::from_secs(20),
];
const LONGEST_PAUSE: Duration = Duration::from_secs(60);

/// What became of the documents of one file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ImportCounts {
    pub stored: u64,
    pub known: u64,
    pub refused: u64,
}

impl AddAssign for ImportCounts {
    fn add_assign(&mut self, other: Self) {
        self.stored += other.stored;
        self.known += other.known;
        self.refused += other.refused;
    }
}

impl std::fmt::Display for ImportCounts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [stored, known, refused] = [self.stored, self.known, self.refused].map(|count| count.to_string());
        f.write_str(&said(message!("terminal_tally", stored, known, refused)))
    }
}

/// What happens on the way.
pub enum Event<'a> {
    /// So much of the file has gone out.
    Carried { bytes: u64 },
    /// A document is not stored.
    Refused(Refusal),
    /// The service's answer to a document sent alone.
    Answered(&'a Value),
    /// What is noted about a line.
    Noted { line: u64, note: &'a str },
}

/// A document that will never be stored as it is, and why, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// Line of the file, or number of the array's member, from 1; none for a file of one document.
    pub line: Option<u64>,
    pub why: String,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.line {
            Some(line) => write!(f, "{line}: {}", self.why),
            None => f.write_str(&self.why),
        }
    }
}

pub struct Importer<'a> {
    service: &'a Service,
    tell: &'a mut dyn FnMut(Event<'_>),
    /// Pauses between tries, before giving up.
    pauses: &'a [Duration],
    /// Rows of a table are being sent: nobody wrote the documents that they come to, nor their pointers.
    of_table: bool,
    tally: ImportCounts,
}

impl<'a> Importer<'a> {
    pub fn new(service: &'a Service, pauses: &'a [Duration], tell: &'a mut dyn FnMut(Event<'_>)) -> Self {
        Self { service, tell, pauses, of_table: false, tally: ImportCounts::default() }
    }

    /// Stops at the first document of which nothing can be said (service gone, token wrong); what went before is
    /// stored, and sending it again does no harm.
    pub async fn carry(mut self, content: Content) -> anyhow::Result<ImportCounts> {
        match content {
            Content::One(document) => self.carry_one(document).await?,
            Content::Lines(mut reader) => {
                let mut line = 0;
                while let Some(batch) = self.next_batch(reader.as_mut(), &mut line)? {
                    self.carry_batch(batch).await?;
                }
            }
            Content::Members(members) => self.carry_members(&members).await?,
            Content::Table(members, open) => {
                if let Some(open @ Note::NoLineEnd { line, .. }) = &open {
                    let note = said(note::message(open));
                    (self.tell)(Event::Noted { line: *line as u64, note: &note });
                }
                self.of_table = true;
                self.carry_members(&members).await?;
            }
        }
        Ok(self.tally)
    }

    async fn carry_members(&mut self, members: &[(u64, Vec<u8>)]) -> Result<(), ClientError> {
        for members in members.chunks(BATCH_LINES) {
            let mut batch = UploadBatch::default();
            members.iter().for_each(|(number, text)| batch.push(*number, text.clone()));
            self.carry_batch(batch).await?;
        }
        Ok(())
    }

    async fn carry_one(&mut self, document: ImportDocument) -> Result<(), ClientError> {
        let ImportDocument { route, content_type, body } = document;
        let (bytes, body) = (body.len() as u64, Bytes::from(body));
        match patiently(self.pauses, async || self.service.post(route, content_type, body.clone()).await).await? {
            Sent::Stored(answer) => {
                self.tally.stored += 1;
                (self.tell)(Event::Answered(&answer));
            }
            Sent::Known(answer) => {
                self.tally.known += 1;
                (self.tell)(Event::Answered(&answer));
            }
            Sent::Refused(problem) => {
                self.refuse(None, of_document(&problem, &body).unwrap_or_else(|| refusal(&problem, &body, false)))
            }
        }
        (self.tell)(Event::Carried { bytes });
        Ok(())
    }

    /// Sends a batch; lines that the service was too busy for go again until they are decided.
    async fn carry_batch(&mut self, mut batch: UploadBatch) -> Result<(), ClientError> {
        let bytes = batch.bytes;
        patiently(self.pauses, async || {
            let answers = self.service.import(batch.body(), batch.lines.len()).await?;
            let mut busy = None;
            let mut answers = answers.into_iter();
            batch.lines.retain(|(number, text)| {
                let answer = answers.next().unwrap_or(ImportLineAnswer { status: 503, error: None, notes: Vec::new() });
                match self.decide(*number, text, answer) {
                    Ok(()) => false,
                    Err(trouble) => {
                        busy.get_or_insert(trouble);
                        true
                    }
                }
            });
            busy.map_or(Ok(()), Err)
        })
        .await?;
        (self.tell)(Event::Carried { bytes });
        Ok(())
    }

    fn decide(&mut self, line: u64, text: &[u8], answer: ImportLineAnswer) -> Result<(), ClientError> {
        let why = match &answer.error {
            Some(problem) => refusal(problem, text, self.of_table),
            None => format!("status {}", answer.status),
        };
        match answer.status {
            200 | 201 => {
                *(if answer.status == 201 { &mut self.tally.stored } else { &mut self.tally.known }) += 1;
                for note in &answer.notes {
                    (self.tell)(Event::Noted { line, note: &note.detail });
                }
            }
            401 | 403 => return Err(ClientError::stop(StatusCode::from_u16(answer.status).ok(), why)),
            408 | 425 | 429 | 500.. => {
                return Err(ClientError::Retry {
                    why: said(message!("at_line", line, fault = Message::verbatim(why))),
                    after: None,
                });
            }
            _ => self.refuse(Some(line), why),
        }
        Ok(())
    }

    fn refuse(&mut self, line: Option<u64>, why: String) {
        self.tally.refused += 1;
        (self.tell)(Event::Refused(Refusal { line, why }));
    }

    /// The next lines that are not blank, with their numbers; none at the end of the file.
    fn next_batch(&mut self, reader: &mut dyn BufRead, line: &mut u64) -> std::io::Result<Option<UploadBatch>> {
        let mut batch = UploadBatch::default();
        while batch.lines.len() < BATCH_LINES && batch.bytes < BATCH_BYTES {
            let mut text = Vec::new();
            if read_line(reader, &mut text)? == 0 {
                break;
            }
            *line += 1;
            if text.len() as u64 == MAX_DOCUMENT_BYTES && !text.ends_with(b"\n") {
                self.refuse(Some(*line), said(message!("terminal_too_large", most = MAX_DOCUMENT_BYTES.to_string())));
                skip_line(reader)?;
            } else if !text.trim_ascii().is_empty() {
                batch.push(*line, text);
            }
        }
        Ok(Some(batch).filter(|batch| !batch.lines.is_empty()))
    }
}

#[derive(Default)]
struct UploadBatch {
    /// Number in the file, and text.
    lines: Vec<(u64, Vec<u8>)>,
    bytes: u64,
}

impl UploadBatch {
    fn push(&mut self, number: u64, text: Vec<u8>) {
        self.bytes += text.len() as u64;
        self.lines.push((number, text));
    }

    fn body(&self) -> Bytes {
        let mut body = Vec::with_capacity(self.bytes as usize + self.lines.len());
        for (_, text) in &self.lines {
            body.extend_from_slice(text.trim_ascii_end());
            body.push(b'\n');
        }
        body.into()
    }
}

fn skip_line(reader: &mut dyn BufRead) -> std::io::Result<()> {
    loop {
        let mut part = Vec::new();
        if read_line(reader, &mut part)? == 0 || part.ends_with(b"\n") {
            return Ok(());
        }
    }
}

/// Asks again after each of `pauses` while that can help; the service's own Retry-After goes before them.
async fn patiently<T>(
    pauses: &[Duration],
    mut attempt: impl AsyncFnMut() -> Result<T, ClientError>,
) -> Result<T, ClientError> {
    let mut told = false;
    for &pause in pauses {
        let trouble = match attempt().await {
            Err(trouble @ (ClientError::Retry { .. } | ClientError::Unreachable(_))) => trouble,
            decided => return decided,
        };
        if !std::mem::replace(&mut told, true) {
            eprintln!("{}", said(message!("terminal_again", trouble = trouble.to_string())));
        }
        let pause = match trouble {
            ClientError::Retry { after: Some(after), .. } => after.min(LONGEST_PAUSE),
            _ => pause,
        };
        tokio::time::sleep(pause).await;
    }
    attempt().await
}

/// The places at fault, or the detail where the problem names none. Of a conflict the detail too: it alone names what
/// stands in the way, and how the two differ.
fn refusal(problem: &ProblemBody, body: &[u8], of_table: bool) -> String {
    if let (true, Some(id)) = (problem.message.code.starts_with("differs"), &problem.existing) {
        return format!("{}; {}", problem.detail, way_out(id, body));
    }
    if problem.errors.is_empty() || problem.status == 409 {
        return problem.detail.clone();
    }
    if let Some(words) = faults::of_problem(problem) {
        return words;
    }
    let place = |pointer: &str| match pointer {
        "" => word("whole_document").to_owned(),
        pointer if of_table => counted(pointer),
        pointer => pointer.to_owned(),
    };
    let places = problem.errors.iter().map(|e| format!("{}: {}", place(&e.pointer), e.detail));
    places.collect::<Vec<_>>().join("; ")
}

/// As [`refusal`], of a document that was sent alone and is stored with other content: which it is, and where they
/// differ, as its table counts.
fn of_document(problem: &ProblemBody, body: &[u8]) -> Option<String> {
    let existing = problem.existing.as_ref().filter(|_| problem.message.code.starts_with("differs"))?;
    let (what, at) = key(body)?;
    let places = problem.errors.iter().map(|error| counted(&error.pointer)).filter(|place| !place.is_empty());
    let places: Vec<String> = places.collect();
    let differs = match places.is_empty() {
        true => message!("stored_otherwise", what, at, id = existing.clone()),
        false => message!("stored_otherwise_at", what, at, id = existing.clone(), places = list(places)),
    };
    Some(format!("{}; {}", said(differs), way_out(existing, body)))
}

/// What takes a stored item out of the way of a right one; a bench result cannot be revised.
fn way_out(existing: &str, body: &[u8]) -> String {
    let id = existing.to_owned();
    said(match DocumentKind::of(body) {
        DocumentKind::Bench => message!("replace_bench", id),
        _ => message!("replace_it", id),
    })
}

/// IMU or gyro, and time.
fn key(body: &[u8]) -> Option<(String, String)> {
    let document: Option<Value> = serde_json::from_slice(body).ok();
    let value = |name: &str| match &document {
        Some(document) => document[name].as_str().map(str::to_owned),
        None => std::str::from_utf8(body).ok()?.lines().take_while(|line| line.starts_with('#')).find_map(|line| {
            let (key, value) = line[1..].split_once(':')?;
            (key.trim() == name).then(|| value.trim().trim_matches('"').to_owned())
        }),
    };
    Some((value("imu").or_else(|| value("serial"))?, value("measured_at").or_else(|| value("calibrated_at"))?))
}

/// Says that the import has come to its end: the service tells what it has left firing. It does so by itself in a
/// quarter of an hour.
pub(super) async fn end(service: &Service) {
    let ended = service.clone().with_notify_query("?notify=digest").import(Bytes::new(), 0).await;
    if let Err(trouble) = ended {
        let late = message!("terminal_digest_late", trouble = trouble.to_string());
        eprintln!("{}", said(late));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stored_otherwise_is_named_by_its_key() {
        let csv = b"# imu: IMU-30\n# measured_at: 2026-03-02T08:00:00Z\nphase\n".as_slice();
        let json = br#"{"serial": "L-1", "measured_at": "2026-01-01T00:00:00Z"}"#.as_slice();
        let pair = |what: &str, at: &str| Some((what.to_owned(), at.to_owned()));
        assert_eq!(key(csv), pair("IMU-30", "2026-03-02T08:00:00Z"));
        assert_eq!(key(json), pair("L-1", "2026-01-01T00:00:00Z"));
        assert_eq!(key(b"phase,start_s\n"), None);
    }
}
