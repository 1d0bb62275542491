//! The connection to PostgreSQL breaks in the middle of a commit: what came about counts, and what did not is done again, once.

mod lab;
mod support;

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

use lab::{day, record};
use serde_json::json;
use support::Server;
use support::cluster::{self, count};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

/// When a connection is to be cut, once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
enum Cut {
    Never,
    /// All was written, and the question to commit it gets lost.
    Before,
    /// It is committed, and the answer gets lost.
    After,
}

/// Stands between a server and its database.
struct Between {
    address: SocketAddr,
    cut: Arc<AtomicU8>,
    /// Once it has cut a connection, it lets none through.
    then_closed: Arc<AtomicBool>,
}

impl Between {
    async fn start(database: SocketAddr) -> Self {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
        let address = listener.local_addr().unwrap();
        let cut = Arc::new(AtomicU8::new(Cut::Never as u8));
        let then_closed = Arc::new(AtomicBool::new(false));
        let (when, closed) = (cut.clone(), then_closed.clone());
        tokio::spawn(async move {
            while let Ok((server, _)) = listener.accept().await {
                if closed.load(Ordering::SeqCst) && when.load(Ordering::SeqCst) == Cut::Never as u8 {
                    continue;
                }
                let database = TcpStream::connect(database).await.unwrap();
                let when = when.clone();
                tokio::spawn(async move {
                    // However the talk ends, both ends are closed.
                    let _broken = hand_on(server, database, &when).await;
                });
            }
        });
        Self { address, cut, then_closed }
    }

    fn cuts(&self, when: Cut) {
        self.cut.store(when as u8, Ordering::SeqCst);
    }

    /// The database cannot be reached any more once a connection has been cut; or it can again.
    fn closes_then(&self, closed: bool) {
        self.then_closed.store(closed, Ordering::SeqCst);
    }

    fn has_cut(&self) -> bool {
        self.cut.load(Ordering::SeqCst) == Cut::Never as u8
    }
}

/// Hands on what either says until a connection ends or is to be cut.
async fn hand_on(mut server: TcpStream, mut database: TcpStream, cut: &AtomicU8) -> std::io::Result<()> {
    let takes =
        |when: Cut| cut.compare_exchange(when as u8, Cut::Never as u8, Ordering::SeqCst, Ordering::SeqCst).is_ok();
    let (mut asked, mut answered) = (vec![0; 1 << 16], vec![0; 1 << 16]);
    // The last statement before a commit changes the one row of the turn, in a transaction that has locked it.
    let (mut in_turn, mut all_written) = (false, false);
    loop {
        tokio::select! {
            len = server.read(&mut asked) => {
                let said = &asked[..len?];
                if said.is_empty() || all_written && takes(Cut::Before) {
                    return Ok(());
                }
                in_turn |= has(said, b"FOR UPDATE");
                database.write_all(said).await?;
            }
            len = database.read(&mut answered) => {
                let said = &answered[..len?];
                let committed = has(said, b"COMMIT\0");
                if said.is_empty() || committed && takes(Cut::After) {
                    return Ok(());
                }
                all_written = in_turn && has(said, b"UPDATE 1\0");
                in_turn &= !committed;
                server.write_all(said).await?;
            }
        }
    }
}

fn has(said: &[u8], words: &[u8]) -> bool {
    said.windows(words.len()).any(|found| found == words)
}

async fn server_behind(url: &str) -> (Server, Between) {
    let there = url.strip_prefix("postgres://postgres@").unwrap().split_once('/').unwrap();
    let between = Between::start(there.0.parse().unwrap()).await;
    let through = format!("postgres://postgres@{}/{}", between.address, there.1);
    (Server::start_with(&[("GYROWATCH_DATABASE_URL", &through)]).await, between)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_commit_without_an_answer_has_stored_is_neither_refused_nor_done_twice() {
    if !cluster::is_there() {
        return;
    }
    let url = cluster::fresh_database().await;
    let (server, between) = server_behind(&url).await;
    let mut expected = 0;
    for when in [Cut::After, Cut::Before, Cut::After, Cut::Before] {
        between.cuts(when);
        let hook = json!({"name": format!("h{expected}"), "kind": "standard-webhooks", "url": "http://127.0.0.1:9/"});
        let made = server.post_json("/v1/hooks", &hook).await;
        assert_eq!(made.status, 201, "{when:?}: {}", made.text());
        assert!(between.has_cut(), "{when:?}");

        between.cuts(when);
        let sent = record("IMU-1", &day(expected), &[("G1", "LFG-1", 1.0, 2.0)]);
        let stored = server.post_json("/v1/records", &sent).await;
        assert_eq!(stored.status, 201, "{when:?}: {}", stored.text());
        assert!(between.has_cut(), "{when:?}");
        expected += 1;
        assert_eq!(count(&url, "SELECT count(*) FROM hook").await, expected, "{when:?}");
        assert_eq!(count(&url, "SELECT count(*) FROM audit WHERE action = 'create hook'").await, expected, "{when:?}");
        assert_eq!(count(&url, "SELECT count(*) FROM record").await, expected, "{when:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_a_commit_that_nobody_can_be_asked_about_it_is_not_said_that_nothing_was_stored() {
    if !cluster::is_there() {
        return;
    }
    let url = cluster::fresh_database().await;
    let (server, between) = server_behind(&url).await;
    between.closes_then(true);
    between.cuts(Cut::After);
    let sent = record("IMU-1", &day(1), &[("G1", "LFG-1", 1.0, 2.0)]);
    let answer = server.post_json("/v1/records", &sent).await;
    assert!(between.has_cut());
    assert_eq!(answer.status, 503, "{}", answer.text());
    assert!(answer.text().contains("cannot be asked whether it is"), "{}", answer.text());
    assert_eq!(count(&url, "SELECT count(*) FROM record").await, 1);

    between.closes_then(false);
    let again = server.post_json("/v1/records", &sent).await;
    assert_eq!(again.status, 200, "{}", again.text());
    let next = server.post_json("/v1/records", &record("IMU-1", &day(2), &[("G1", "LFG-1", 1.0, 2.0)])).await;
    assert_eq!(next.status, 201, "{}", next.text());
    assert_eq!(count(&url, "SELECT count(*) FROM record").await, 2);
}
