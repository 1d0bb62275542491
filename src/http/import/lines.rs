//! The lines of a body, as it comes.

use axum::body::BodyDataStream;
use bytes::{Bytes, BytesMut};
use futures::{Stream, StreamExt};

use crate::wire::problem::Problem;

/// A line of the body, or what is wrong with it already.
pub type Line = (u64, Result<Bytes, Problem>);

/// Splits a body into its lines. Empty ones are left out but counted. Reading ends with a problem when the body is too long
/// or breaks off.
pub fn lines(body: BodyDataStream, longest: usize, most: usize) -> impl Stream<Item = Line> {
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
