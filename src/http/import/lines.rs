//! The lines of a body, as it comes.

use std::sync::Arc;

use bytes::{Bytes, BytesMut};
use futures::{Stream, StreamExt};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::http::problem;
use crate::message;
use crate::wire::problem::Problem;

/// Text that may be under way at a time, from reading a line to its answer, KiB begun a line. What is made of a
/// record takes dozens of times the memory of its text until it is stored.
pub const UNDER_WAY_KIB: u32 = 2048;

/// A line of the body.
pub struct ImportLine {
    /// Counting from 1.
    pub number: u64,
    /// Or what is wrong with it already.
    pub text: Result<Bytes, Problem>,
    /// What it takes of [`UNDER_WAY_KIB`] until this is dropped.
    pub room: OwnedSemaphorePermit,
}

/// How long a line and a body may be, bytes.
#[derive(Clone, Copy)]
pub struct Longest {
    pub line: usize,
    pub body: usize,
}

/// Splits a body into its lines, each when there is room for it. Empty ones are left out but counted. Reading ends
/// with a problem when the body is too long or breaks off.
pub fn lines<B>(body: B, longest: Longest) -> impl Stream<Item = ImportLine>
where
    B: Stream<Item = Result<Bytes, axum::Error>> + Unpin,
{
    let splitter = Splitter { body: Some(body), pending: BytesMut::new(), line: 0, read: 0, skipping: false, longest };
    let room = Arc::new(Semaphore::new(UNDER_WAY_KIB as usize));
    futures::stream::unfold((splitter, room), |(mut splitter, room)| async {
        let (number, text) = splitter.next_line().await?;
        let bytes = text.as_ref().map_or(0, Bytes::len);
        let kib = u32::try_from(bytes.div_ceil(1024)).unwrap_or(u32::MAX).clamp(1, UNDER_WAY_KIB);
        // Waiting, even for what is there, ends a task's turn now and then, and with it the chunk that the lines come
        // in.
        let taken = match Arc::clone(&room).try_acquire_many_owned(kib) {
            Ok(taken) => taken,
            Err(_) => Arc::clone(&room).acquire_many_owned(kib).await.expect("nobody closes it"),
        };
        Some((ImportLine { number, text, room: taken }, (splitter, room)))
    })
}

struct Splitter<B> {
    body: Option<B>,
    pending: BytesMut,
    line: u64,
    read: usize,
    /// Within a line that was refused for its length.
    skipping: bool,
    longest: Longest,
}

impl<B: Stream<Item = Result<Bytes, axum::Error>> + Unpin> Splitter<B> {
    async fn next_line(&mut self) -> Option<(u64, Result<Bytes, Problem>)> {
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
            if searched > self.longest.line && !self.skipping {
                self.skipping = true;
                self.pending.clear();
                self.line += 1;
                return Some((self.line, Err(too_long(self.longest.line))));
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
    fn counted(&mut self, line: Bytes) -> Option<(u64, Result<Bytes, Problem>)> {
        self.line += 1;
        let blank = line.iter().all(u8::is_ascii_whitespace);
        let checked = if line.len() > self.longest.line + 1 { Err(too_long(self.longest.line)) } else { Ok(line) };
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
                let (most, key) = (self.longest.body, "server.max_import_bytes");
                (self.read > most).then(|| problem::too_large(message!("too_long_import", most, key)))
            }
            Some(Err(_)) => Some(Problem::new(400, "title_broken_off", message!("body_broke_off"))),
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
    problem::too_large(message!("too_long_line", most = longest, key = "server.max_import_line_bytes"))
}

#[cfg(test)]
mod tests {
    use futures::FutureExt;

    use super::*;

    const LONGEST: Longest = Longest { line: 8 << 20, body: 64 << 20 };

    fn lines_of(text: String) -> impl Stream<Item = ImportLine> {
        lines(futures::stream::iter([Ok(Bytes::from(text))]), LONGEST)
    }

    #[test]
    fn so_much_text_is_under_way_and_more_when_a_line_is_done_with() {
        let text = format!("{}\n", "x".repeat(1500)).repeat(UNDER_WAY_KIB as usize);
        let mut lines = Box::pin(lines_of(text));
        let mut under_way = Vec::new();
        while let Some(Some(line)) = lines.next().now_or_never() {
            under_way.push(line);
        }
        assert_eq!(under_way.len(), UNDER_WAY_KIB as usize / 2);
        assert!(lines.next().now_or_never().is_none());
        drop(under_way.swap_remove(7));
        let next = lines.next().now_or_never().flatten().expect("there is room again");
        assert_eq!(next.number, u64::from(UNDER_WAY_KIB) / 2 + 1);
    }

    #[test]
    fn a_line_that_is_longer_than_all_that_may_be_under_way_goes_alone() {
        let long = "y".repeat(UNDER_WAY_KIB as usize * 1024 + 5000);
        let mut lines = Box::pin(lines_of(format!("a\n{long}\nb\n")));
        let first = lines.next().now_or_never().flatten().expect("a line");
        assert!(lines.next().now_or_never().is_none(), "not beside another");
        drop(first);
        let second = lines.next().now_or_never().flatten().expect("when nothing else is under way");
        assert_eq!(second.text.as_ref().map_or(0, Bytes::len), long.len() + 1);
        assert!(lines.next().now_or_never().is_none());
        drop(second);
        assert_eq!(lines.next().now_or_never().flatten().map(|line| line.number), Some(3));
    }
}
