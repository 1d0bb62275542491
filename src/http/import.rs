//! `/v1/import`: one document a line, as many as there are, answered line by line.
//!
//! The body is read as it comes and never held whole: so much of its text is under way at a time
//! ([`lines::UNDER_WAY_KIB`]). Lines that are there together are read together, on a thread for computing, and share
//! commits. A client that sends everything before it reads an answer is not blocked: answers wait in memory, up to a
//! bound.

mod lines;

use std::pin::{Pin, pin};
use std::sync::Arc;

use axum::Extension;
use axum::body::{Body, BodyDataStream};
use axum::extract::Request;
use axum::http::Version;
use axum::http::header::{CONTENT_TYPE, EXPECT};
use bytes::Bytes;
use futures::future::BoxFuture;
use futures::stream::Peekable;
use futures::{FutureExt, StreamExt};
use lines::{ImportLine, Longest, lines};
use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore, mpsc};

use super::document::check_media_type;
use super::edge::Forwarded;
use super::notify_query::NotifyQuery;
use crate::core::alert_decision::Late;
use crate::core::note::Note;
use crate::http::prelude::*;
use crate::pipeline::{Accepted, Caller, Origin, Pipeline, Reply, Submission};
use crate::wire::json::on_a_line;
use crate::wire::note::NoteBody;
use crate::wire::problem::ProblemBody;
use crate::words;

/// Lines that are read and stored together, at the most.
const LINES_AT_ONCE: usize = 512;
/// Such chunks that are read at the same time, while others are judged and others wait for the disk.
const CHUNKS_READ_AT_ONCE: usize = 4;
/// Such chunks that are judged or wait for the disk. What is under way is bounded by its text; this holds for those
/// who send line by line, so that one import does not fill the queue of all writes.
const CHUNKS_UNDER_WAY: usize = 64;
/// Answers that wait for a client that does not read them, bytes.
const MAX_UNREAD_ANSWERS: usize = 32 << 20;

/// The answer to one line.
#[derive(Serialize, ToSchema)]
struct LineAnswer {
    /// Counting from 1.
    line: u64,
    /// As if the line had been posted by itself.
    status: u16,
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<ProblemBody>,
    /// Of what is new: what was noticed beside what is known of the IMU and its gyros.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<NoteBody>,
}

/// Stores records, campaigns and bench results, one a line, each by itself: a bad line is named and holds up no other.
///
/// What a gyro did long ago and is found now (`alerts.backfill_days`) is told in one message a hook when the import
/// ends, as far as it fires still.
#[utoipa::path(post, path = "/v1/import", tag = "records", request_body(content = String, content_type = "application/x-ndjson", description = "one JSON document a line"),
    params(NotifyQuery),
    responses(
        (status = 200, description = "one line an answer, in order", body = LineAnswer, content_type = "application/x-ndjson")))]
pub async fn post_import(
    app: App,
    Extension(caller): Extension<Caller>,
    notify_query: NotifyQuery,
    request: Request,
) -> Answer<Response> {
    check_media_type(request.headers(), &["application/x-ndjson", "application/ndjson", "application/jsonl"])?;
    let asks_to_go_on = request.headers().contains_key(EXPECT);
    // nginx, whose requests have HTTP/1.0 unless it is told otherwise, sends no more of a body once the answer to it
    // has begun.
    let is_through = request.extensions().get::<Forwarded>().is_some() || request.version() == Version::HTTP_10;
    let mut body = request.into_body().into_data_stream().peekable();
    if asks_to_go_on {
        // hyper says `100 Continue` when the body is asked for, and not any more once an answer has begun.
        Pin::new(&mut body).peek().await;
    }
    let (sender, receiver) = mpsc::unbounded_channel();
    let room = Arc::new(Semaphore::new(MAX_UNREAD_ANSWERS));
    let full = Arc::new(Notify::new());
    let answers = AnswerSender { sender, room, full: Arc::clone(&full) };
    let language = words::asked();
    let done = tokio::spawn(async move {
        let late = notify_query.late_or(Late::Digest);
        // A task of its own does not know whose it is, nor their language.
        let work = caller.clone().during(import(&app, caller, late, body, &answers));
        words::asked_in(language, work).await;
        // Whoever has read the last answer finds the digest queued.
        notify_query.end(&app, late).await;
        drop(answers);
    });
    if is_through {
        tokio::select! {
            _ = done => {}
            () = full.notified() => {}
        }
    }
    let stream = futures::stream::unfold(receiver, |mut receiver| async {
        let (text, _room): (Bytes, OwnedSemaphorePermit) = receiver.recv().await?;
        Some((Ok::<_, std::convert::Infallible>(text), receiver))
    });
    // Compressing asks once more after the end.
    Ok(([(CONTENT_TYPE, "application/x-ndjson")], Body::from_stream(stream.fuse())).into_response())
}

/// The way of answers back to the client.
struct AnswerSender {
    sender: mpsc::UnboundedSender<(Bytes, OwnedSemaphorePermit)>,
    room: Arc<Semaphore>,
    /// Told when there is no room for a further answer.
    full: Arc<Notify>,
}

impl AnswerSender {
    /// False when the client has gone.
    async fn send(&self, text: Bytes) -> bool {
        let wanted = text.len().min(MAX_UNREAD_ANSWERS) as u32;
        let gone = self.sender.closed();
        if self.room.available_permits() < text.len() {
            self.full.notify_one();
        }
        tokio::select! {
            room = Arc::clone(&self.room).acquire_many_owned(wanted) => {
                room.is_ok_and(|room| self.sender.send((text, room)).is_ok())
            }
            () = gone => false,
        }
    }
}

async fn import(app: &App, caller: Caller, late: Late, body: Peekable<BodyDataStream>, answers: &AnswerSender) {
    let server = &app.config.server;
    let lines = lines(body, Longest { line: server.max_import_line_bytes, body: server.max_import_bytes });
    let pipeline = app.pipeline.clone();
    let read = lines.ready_chunks(LINES_AT_ONCE).map(move |chunk| {
        let (pipeline, caller) = (pipeline.clone(), caller.clone());
        words::spawn_blocking(move || Chunk::read(chunk, &pipeline, &caller))
    });
    let pipeline = app.pipeline.clone();
    // Queued one after the other, so that of two lines with the same key the first is the one that counts.
    let queued = read.buffered(CHUNKS_READ_AT_ONCE).then(move |chunk| queue(chunk.ok(), pipeline.clone(), late));
    let mut stored = pin!(queued.buffered(CHUNKS_UNDER_WAY));
    while let Some(answered) = stored.next().await {
        let Some((text, _room)) = answered else {
            tracing::error!("lines of an import could not be read: the reading failed");
            return;
        };
        if !answers.send(text).await {
            tracing::info!("the client of an import has gone; what was answered is stored");
            return;
        }
    }
}

/// Puts a chunk into the queue of writes; what is returned waits for the disk and gives the answers as text.
async fn queue(
    chunk: Option<Chunk>,
    pipeline: Arc<Pipeline>,
    late: Late,
) -> BoxFuture<'static, Option<(Bytes, Permits)>> {
    let Some(mut chunk) = chunk else { return async { None }.boxed() };
    let replies = pipeline.ingest.enqueue(std::mem::take(&mut chunk.items), late).await;
    async move { Some(chunk.answered(replies.await, &pipeline).await) }.boxed()
}

/// Lines that are stored together.
struct Chunk {
    items: Vec<Submission>,
    lines: Vec<ReadLine>,
    room: Permits,
}

/// What the lines of a chunk take of what may be under way, until they are answered.
type Permits = Vec<OwnedSemaphorePermit>;

/// A line after reading: what is needed to answer it.
struct ReadLine {
    number: u64,
    /// What the line's submission came from.
    read: Result<Option<Origin>, Problem>,
}

impl Chunk {
    /// Reads, checks and separates: computing, not waiting.
    fn read(lines: Vec<ImportLine>, pipeline: &Pipeline, caller: &Caller) -> Self {
        let (mut items, mut read_lines) = (Vec::with_capacity(lines.len()), Vec::with_capacity(lines.len()));
        let mut taken = Vec::with_capacity(lines.len());
        for ImportLine { number, text, room } in lines {
            taken.push(room);
            let read = text
                .and_then(|bytes| {
                    pipeline.reader.document(&bytes).map_err(|faults| Document::problem(&bytes, on_a_line(faults)))
                })
                .and_then(|read| Ok(read.may_be_sent_by(caller).map(|()| read)?));
            let read = read.map(|submission| {
                let origin = Origin::of(&submission);
                items.push(submission);
                origin
            });
            read_lines.push(ReadLine { number, read });
        }
        Self { items, lines: read_lines, room: taken }
    }

    /// The answers as text, and the room that is free again when it has gone out.
    async fn answered(self, replies: Vec<Reply>, pipeline: &Pipeline) -> (Bytes, Permits) {
        let mut replies = replies.into_iter();
        let mut text = Vec::with_capacity(64 * self.lines.len());
        for line in self.lines {
            let outcome = match line.read {
                Err(problem) => Err(problem),
                Ok(Some(origin)) => match replies.next() {
                    Some(reply) => settled(reply, &origin, pipeline).await,
                    None => Err(Problem::new(500, "title_internal_error", message!("line_not_answered"))),
                },
                Ok(None) => Err(Problem::new(500, "title_internal_error", message!("line_not_read"))),
            };
            let answer = match outcome {
                Ok((status, id, notes)) => LineAnswer { line: line.number, status, id: Some(id), error: None, notes },
                Err(problem) => LineAnswer {
                    line: line.number,
                    status: problem.status,
                    id: None,
                    error: Some(problem.body(words::asked())),
                    notes: Vec::new(),
                },
            };
            serde_json::to_writer(&mut text, &answer).expect("numbers and text can always be written to memory");
            text.push(b'\n');
        }
        (text.into(), self.room)
    }
}

async fn settled(reply: Reply, origin: &Origin, pipeline: &Pipeline) -> Answer<(u16, String, Vec<NoteBody>)> {
    let accepted = reply?;
    if let Accepted::Stored { id, notes, .. } = &accepted {
        return Ok((201, id.to_string(), notes.iter().map(NoteBody::of).collect()));
    }
    let id = pipeline.ingest.settle(&accepted, Some(origin)).await?;
    let withdrawn = matches!(accepted, Accepted::There { counts: false, .. }).then(|| NoteBody::of(&Note::Withdrawn));
    Ok((200, id.to_string(), withdrawn.into_iter().collect()))
}
