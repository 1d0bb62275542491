//! `/v1/import`: one document a line, as many as there are, answered line by line.
//!
//! The body is read as it comes and never held whole. Lines that are there together are read together, on a thread
//! for computing, and share commits. A client that sends everything before it reads an answer is not blocked: answers wait
//! in memory, up to a bound.

use std::sync::Arc;

use axum::Extension;
use axum::body::{Body, BodyDataStream};
use axum::extract::{Request, State};
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use bytes::{Bytes, BytesMut};
use futures::future::BoxFuture;
use futures::{FutureExt, Stream, StreamExt};
use serde::Serialize;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::App;
use super::document::{Document, check_media_type};
use crate::pipeline::{Accepted, Caller, Origin, Pipeline, ReadDocument, Reply, Submission};
use crate::wire::problem::Problem;

pub fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(post_import))
}

/// Lines that are read and stored together, at the most.
const LINES_AT_ONCE: usize = 512;
/// Such chunks under way at the same time: some are read while others are judged and others wait for the disk.
const CHUNKS_UNDER_WAY: usize = 5;
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
    error: Option<Problem>,
}

/// Stores records, campaigns and bench results, one a line, each by itself: a bad line is named and holds up no other.
#[utoipa::path(post, path = "/v1/import", tag = "records",
    request_body(content = String, content_type = "application/x-ndjson", description = "one JSON document a line"),
    responses(
        (status = 200, description = "one line an answer, in order", body = LineAnswer, content_type = "application/x-ndjson"),
        (status = 415, description = "not application/x-ndjson", body = Problem, content_type = "application/problem+json")))]
async fn post_import(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    request: Request,
) -> Result<Response, Problem> {
    check_media_type(request.headers(), &["application/x-ndjson", "application/ndjson", "application/jsonl"])?;
    let (sender, receiver) = mpsc::unbounded_channel();
    let room = Arc::new(Semaphore::new(MAX_UNREAD_ANSWERS));
    tokio::spawn(import(app, caller, request.into_body(), Answers { sender, room }));
    let stream = futures::stream::unfold(receiver, |mut receiver| async {
        let (text, _room): (Bytes, OwnedSemaphorePermit) = receiver.recv().await?;
        Some((Ok::<_, std::convert::Infallible>(text), receiver))
    });
    // Compressing asks once more after the end.
    Ok(([(CONTENT_TYPE, "application/x-ndjson")], Body::from_stream(stream.fuse())).into_response())
}

/// The way of answers back to the client.
struct Answers {
    sender: mpsc::UnboundedSender<(Bytes, OwnedSemaphorePermit)>,
    room: Arc<Semaphore>,
}

impl Answers {
    /// False when the client has gone.
    async fn send(&self, text: Bytes) -> bool {
        let wanted = text.len().min(MAX_UNREAD_ANSWERS) as u32;
        let gone = self.sender.closed();
        tokio::select! {
            room = Arc::clone(&self.room).acquire_many_owned(wanted) => {
                room.is_ok_and(|room| self.sender.send((text, room)).is_ok())
            }
            () = gone => false,
        }
    }
}

async fn import(app: App, caller: Caller, body: Body, answers: Answers) {
    let server = &app.config.server;
    let lines = lines(body.into_data_stream(), server.max_import_line_bytes, server.max_import_bytes);
    let pipeline = app.pipeline.clone();
    let read = lines.ready_chunks(LINES_AT_ONCE).map(move |chunk| {
        let (pipeline, caller) = (pipeline.clone(), caller.clone());
        tokio::task::spawn_blocking(move || Chunk::read(chunk, &pipeline, &caller))
    });
    let pipeline = app.pipeline.clone();
    // Queued one after the other, so that of two lines with the same key the first is the one that counts.
    let queued = read.buffered(CHUNKS_UNDER_WAY).then(move |chunk| queue(chunk.ok(), pipeline.clone()));
    let mut stored = std::pin::pin!(queued.buffered(CHUNKS_UNDER_WAY));
    while let Some(text) = stored.next().await {
        let Some(text) = text else {
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
async fn queue(chunk: Option<Chunk>, pipeline: Arc<Pipeline>) -> BoxFuture<'static, Option<Bytes>> {
    let Some(mut chunk) = chunk else { return async { None }.boxed() };
    let replies = pipeline.enqueue(std::mem::take(&mut chunk.items)).await;
    async move { Some(chunk.answered(replies.await, &pipeline).await) }.boxed()
}

/// A line of the body, or what is wrong with it already.
type Line = (u64, Result<Bytes, Problem>);

/// Splits a body into its lines. Empty ones are left out but counted. Reading ends with a problem when the body is too long
/// or breaks off.
fn lines(body: BodyDataStream, longest: usize, most: usize) -> impl Stream<Item = Line> {
    let splitter =
        Splitter { body: Some(body), pending: BytesMut::new(), line: 0, read: 0, skipping: false, longest, most };
    futures::stream::unfold(splitter, |mut splitter| async { Some((splitter.next_line().await?, splitter)) })
}

struct Splitter {
    body: Option<BodyDataStream>,
    pending: BytesMut,
    line: u64,
    read: usize,
    /// Within a line that was refused for its length.
    skipping: bool,
    longest: usize,
    most: usize,
}

impl Splitter {
    async fn next_line(&mut self) -> Option<Line> {
        let mut searched = 0;
        loop {
            if let Some(end) = memchr::memchr(b'\n', &self.pending[searched..]) {
                let line = self.pending.split_to(searched + end + 1).freeze();
                searched = 0;
                if std::mem::take(&mut self.skipping) {
                    continue;
                }
                if let Some(line) = self.counted(line) {
                    return Some(line);
                }
                continue;
            }
            searched = self.pending.len();
            if searched > self.longest && !self.skipping {
                self.skipping = true;
                self.pending.clear();
                self.line += 1;
                return Some((self.line, Err(too_long(self.longest))));
            }
            if self.skipping {
                self.pending.clear();
                searched = 0;
            }
            match self.more().await {
                Some(Ok(())) => {}
                Some(Err(problem)) => {
                    self.line += 1;
                    return Some((self.line, Err(problem)));
                }
                None if self.pending.is_empty() => return None,
                None => {
                    let rest = self.pending.split().freeze();
                    return self.counted(rest);
                }
            }
        }
    }

    /// The line with its number, unless it is blank.
    fn counted(&mut self, line: Bytes) -> Option<Line> {
        self.line += 1;
        let blank = line.iter().all(u8::is_ascii_whitespace);
        let checked = if line.len() > self.longest + 1 { Err(too_long(self.longest)) } else { Ok(line) };
        (!blank).then_some((self.line, checked))
    }

    /// Reads on; none at the end. After a failure the body is left alone.
    async fn more(&mut self) -> Option<Result<(), Problem>> {
        let data = self.body.as_mut()?.next().await;
        let failed = match data {
            None => {
                self.body = None;
                return None;
            }
            Some(Ok(bytes)) => {
                self.read += bytes.len();
                self.pending.extend_from_slice(&bytes);
                let detail = format!("an import may have {} bytes; what came before this line is answered", self.most);
                (self.read > self.most).then(|| Problem::new(413, "Too large", detail))
            }
            Some(Err(error)) => Some(Problem::new(400, "Broken off", format!("the body broke off: {error}"))),
        };
        match failed {
            None => Some(Ok(())),
            Some(problem) => {
                self.body = None;
                self.pending.clear();
                Some(Err(problem))
            }
        }
    }
}

fn too_long(longest: usize) -> Problem {
    Problem::new(413, "Too large", format!("a line may have {longest} bytes"))
}

/// Lines that are stored together.
struct Chunk {
    items: Vec<Submission>,
    lines: Vec<ReadLine>,
}

/// A line after reading: what is needed to answer it.
struct ReadLine {
    number: u64,
    /// None where the line became a submission.
    problem: Option<Problem>,
    origin: Option<Origin>,
}

impl Chunk {
    /// Reads, checks and separates: computing, not waiting.
    fn read(lines: Vec<Line>, pipeline: &Pipeline, caller: &Caller) -> Self {
        let mut chunk = Self { items: Vec::with_capacity(lines.len()), lines: Vec::with_capacity(lines.len()) };
        for (number, line) in lines {
            let read = line
                .and_then(|bytes| pipeline.read_document(&bytes).map_err(|faults| Document::problem(&bytes, faults)))
                .and_then(|read| Ok(caller.may_submit(&read.submission).map(|()| read)?));
            let (problem, origin) = match read {
                Ok(ReadDocument { submission, origin }) => {
                    chunk.items.push(submission);
                    (None, Some(origin))
                }
                Err(problem) => (Some(problem), None),
            };
            chunk.lines.push(ReadLine { number, problem, origin });
        }
        chunk
    }

    /// The answers as text.
    async fn answered(self, replies: Vec<Reply>, pipeline: &Pipeline) -> Bytes {
        let mut replies = replies.into_iter();
        let mut text = Vec::with_capacity(64 * self.lines.len());
        for line in self.lines {
            let outcome = match (line.problem, line.origin) {
                (Some(problem), _) => Err(problem),
                (None, Some(origin)) => match replies.next() {
                    Some(reply) => settled(reply, &origin, pipeline).await,
                    None => Err(Problem::new(500, "Internal error", "the line was not answered")),
                },
                (None, None) => Err(Problem::new(500, "Internal error", "the line was not read")),
            };
            let answer = match outcome {
                Ok((status, id)) => LineAnswer { line: line.number, status, id: Some(id), error: None },
                Err(problem) => {
                    LineAnswer { line: line.number, status: problem.status, id: None, error: Some(problem) }
                }
            };
            serde_json::to_writer(&mut text, &answer).expect("numbers and text can always be written to memory");
            text.push(b'\n');
        }
        text.into()
    }
}

async fn settled(reply: Reply, origin: &Origin, pipeline: &Pipeline) -> Result<(u16, String), Problem> {
    let accepted = reply?;
    if let Accepted::Stored { id, .. } = accepted {
        return Ok((201, id.to_string()));
    }
    let id = pipeline.settle_document(&accepted, origin).await?;
    Ok((200, id.to_string()))
}
