//! Bare SQLite: what a service that does nothing but store could reach on this machine at most.
//!
//! A record is its text and three rows of 120 bytes, of a thousand gyros at random; WAL, `synchronous = FULL`, a
//! checkpoint every 20,000 pages. Nothing is read, separated or judged, and nobody is spoken to.

use std::sync::mpsc;
use std::thread;
use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rusqlite::{Connection, params};
use tempfile::TempDir;

use crate::client::record;

/// Of three gyros each.
pub const IMUS: usize = 333;

struct Bare {
    connection: Connection,
    random: ChaCha8Rng,
    stored: i64,
    _dir: TempDir,
}

impl Bare {
    fn new() -> Self {
        let dir = TempDir::new().expect("a directory");
        let connection = Connection::open(dir.path().join("bare.db")).expect("a database");
        connection
            .execute_batch(
                "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA wal_autocheckpoint = 20000; PRAGMA cache_size = -65536;
                 CREATE TABLE record (id INTEGER PRIMARY KEY, body TEXT NOT NULL) STRICT;
                 CREATE TABLE history (gyro INTEGER, at INTEGER, figures BLOB, PRIMARY KEY (gyro, at)) STRICT, WITHOUT ROWID",
            )
            .expect("tables");
        Self { connection, random: ChaCha8Rng::seed_from_u64(7_719_203), stored: 0, _dir: dir }
    }

    fn run(&self, sql: &str, cells: impl rusqlite::Params) {
        self.connection.prepare_cached(sql).expect("sound SQL").execute(cells).expect("a change");
    }

    /// One transaction.
    fn store<'a>(&mut self, texts: impl IntoIterator<Item = &'a str>) {
        self.run("BEGIN IMMEDIATE", []);
        for text in texts {
            self.run("INSERT INTO record VALUES (?1, ?2)", params![self.stored, text]);
            let imu = self.random.random_range(0..IMUS as i64);
            for gyro in 3 * imu..3 * imu + 3 {
                self.run("INSERT INTO history VALUES (?1, ?2, ?3)", params![gyro, self.stored, [7_u8; 120]]);
            }
            self.stored += 1;
        }
        self.run("COMMIT", []);
    }
}

/// Records/s with `each` of them in a transaction.
pub fn in_batches(count: usize, each: usize) -> f64 {
    let texts: Vec<String> = (0..count).map(|k| record(k % IMUS, k / IMUS)).collect();
    let mut bare = Bare::new();
    let begun = Instant::now();
    for batch in texts.chunks(each) {
        bare.store(batch.iter().map(String::as_str));
    }
    count as f64 / begun.elapsed().as_secs_f64()
}

/// Records/s of several threads that store one record after the other each; those that wait at a time share a
/// transaction.
pub fn together(count: usize, threads: usize) -> f64 {
    let (send, waiting) = mpsc::channel::<(String, mpsc::SyncSender<()>)>();
    let mut bare = Bare::new();
    let begun = Instant::now();
    thread::scope(|scope| {
        for imu in 0..threads {
            let send = send.clone();
            scope.spawn(move || {
                let (stored, answer) = mpsc::sync_channel(1);
                for k in 0..count / threads {
                    send.send((record(imu, k), stored.clone())).expect("the writer outlives its clients");
                    answer.recv().expect("the writer answers");
                }
            });
        }
        drop(send);
        while let Ok(first) = waiting.recv() {
            let group: Vec<_> = std::iter::once(first).chain(waiting.try_iter()).collect();
            bare.store(group.iter().map(|(text, _)| text.as_str()));
            for (_, stored) in group {
                stored.send(()).expect("its client waits");
            }
        }
    });
    count as f64 / begun.elapsed().as_secs_f64()
}
