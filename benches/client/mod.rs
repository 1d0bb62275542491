//! A client that takes little of the machine that it shares with what it measures: one connection, raw requests,
//! answers read whole.
#![allow(dead_code, clippy::allow_attributes, reason = "each bench compiles its own copy and uses a part of it")]

use std::time::{Duration, Instant};

use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::TcpStream;

/// 1990-01-01, s UTC: ten thousand days later is still in the past.
pub const EPOCH_S: usize = 631_152_000;
pub const DAY_S: usize = 86_400;
const PAPER: &str = include_str!("../../tests/data/paper.json");

/// The paper's record as IMU number `imu` would send it at its `k`-th calibration, one a day from [`EPOCH_S`] on.
pub fn record(imu: usize, k: usize) -> String {
    PAPER
        .replace("IMU-07", &format!("IMU-{imu}"))
        .replace("LFG-", &format!("L{imu}-"))
        .replace("2026-03-01T08:00:00Z", &instant(k))
}

/// When the `k`-th calibration is made.
pub fn instant(k: usize) -> String {
    jiff::Timestamp::from_second((EPOCH_S + k * DAY_S) as i64).expect("a time of this century").to_string()
}

/// What a client wants of the answers to what it sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    Whole,
    /// `Prefer: return=minimal`
    Minimal,
}

pub struct Client {
    stream: BufReader<TcpStream>,
    wanted: Wanted,
}

pub struct Answer {
    pub status: u16,
    pub body: Vec<u8>,
}

impl Client {
    pub async fn connect(address: &str) -> Self {
        let stream = TcpStream::connect(address).await.unwrap_or_else(|error| panic!("{address}: {error}"));
        stream.set_nodelay(true).expect("an option");
        Self { stream: BufReader::new(stream), wanted: Wanted::Whole }
    }

    pub fn wanting(self, wanted: Wanted) -> Self {
        Self { wanted, ..self }
    }

    pub async fn get(&mut self, path: &str) -> Answer {
        self.send(&format!("GET {path} HTTP/1.1\r\nhost: localhost\r\n\r\n")).await
    }

    pub async fn post(&mut self, path: &str, media_type: &str, body: &str) -> Answer {
        let prefer = if self.wanted == Wanted::Minimal { "prefer: return=minimal\r\n" } else { "" };
        let head = format!("POST {path} HTTP/1.1\r\nhost: localhost\r\ncontent-type: {media_type}\r\n");
        self.send(&format!("{head}{prefer}content-length: {}\r\n\r\n{body}", body.len())).await
    }

    async fn send(&mut self, request: &str) -> Answer {
        self.stream.write_all(request.as_bytes()).await.expect("a request");
        let mut answer = Answer { status: 0, body: Vec::new() };
        let (mut length, mut chunked) = (0, false);
        loop {
            let line = self.line().await.to_ascii_lowercase();
            match line.split_once(' ') {
                None => break,
                Some(("http/1.1", rest)) => answer.status = rest[..3].parse().expect("a status"),
                Some(("content-length:", bytes)) => length = bytes.parse().expect("a length"),
                Some(("transfer-encoding:", "chunked")) => chunked = true,
                Some(_) => {}
            }
        }
        if chunked {
            loop {
                let size = usize::from_str_radix(&self.line().await, 16).expect("a chunk's size");
                self.read(size, &mut answer.body).await;
                self.line().await;
                if size == 0 {
                    break;
                }
            }
        } else {
            self.read(length, &mut answer.body).await;
        }
        answer
    }

    async fn line(&mut self) -> String {
        let mut line = String::new();
        self.stream.read_line(&mut line).await.expect("a line");
        line.trim_end().to_owned()
    }

    async fn read(&mut self, count: usize, body: &mut Vec<u8>) {
        let begin = body.len();
        body.resize(begin + count, 0);
        self.stream.read_exact(&mut body[begin..]).await.expect("a body");
    }
}

/// Times of answers, and over how long they came.
pub struct Times {
    sorted: Vec<Duration>,
    took: Duration,
}

impl Times {
    pub fn of(mut times: Vec<Duration>, begun: Instant) -> Self {
        times.sort_unstable();
        Self { sorted: times, took: begun.elapsed() }
    }

    pub fn rate(&self) -> f64 {
        self.sorted.len() as f64 / self.took.as_secs_f64()
    }

    /// `share` of 0.5 is the median.
    pub fn quantile(&self, share: f64) -> Duration {
        let place = (self.sorted.len() as f64 * share) as usize;
        self.sorted[place.min(self.sorted.len() - 1)]
    }
}
