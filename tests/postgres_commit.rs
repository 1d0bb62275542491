//! The connection to PostgreSQL breaks in the middle of a commit: what came about counts, and what did not is done
//! again, once.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

use crate::cluster::count;
use crate::prelude::*;
use crate::support::NEVER_LATE;
use axum::http::StatusCode;
use axum::response::IntoResponse;
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
    /// Once it has cut a connection, it lets no new one through.
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

    /// No new connection reaches the database once one has been cut; or one does again.
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
    // The last statement before a commit changes the rows of the cells, one or all, in a transaction that has locked them.
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
                all_written = in_turn && (has(said, b"UPDATE 1\0") || has(said, b"UPDATE 256\0"));
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
    let variables =
        [("GYROWATCH_DATABASE_URL", through.as_str()), ("GYROWATCH_HOOKS__RETRY_WAITS_S", "0.1,0.1,0.1"), NEVER_LATE];
    (Server::start_with(&variables).await, between)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_commit_without_an_answer_has_stored_is_neither_refused_nor_done_twice() {
    let Some(url) = cluster::database_if_there().await else { return };
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
    let Some(url) = cluster::database_if_there().await else { return };
    let (server, between) = server_behind(&url).await;
    for (when, stored, again, before) in [(Cut::After, 1, 200, 0), (Cut::Before, 0, 201, 1)] {
        between.closes_then(true);
        between.cuts(when);
        let sent = record("IMU-1", &day(before + 1), &[("G1", "LFG-1", 1.0, 2.0)]);
        let answer = server.post_json("/v1/records", &sent).await;
        assert!(between.has_cut(), "{when:?}");
        assert_eq!(answer.status, 503, "{when:?}: {}", answer.text());
        assert!(answer.json()["code"] == "perhaps_stored", "{when:?}: {}", answer.text());
        assert!(answer.headers.contains_key("retry-after"), "{when:?}");
        assert_eq!(count(&url, "SELECT count(*) FROM record").await, before + stored, "{when:?}");

        between.closes_then(false);
        let sent_again = server.post_json("/v1/records", &sent).await;
        assert_eq!(sent_again.status, again, "{when:?}: {}", sent_again.text());
        assert_eq!(count(&url, "SELECT count(*) FROM record").await, before + 1, "{when:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_attempt_that_was_perhaps_written_down_is_not_counted_twice() {
    let Some(url) = cluster::database_if_there().await else { return };
    let (server, between) = server_behind(&url).await;
    let between = Arc::new(between);
    let breaks = between.clone();
    // What comes next through the connection is the attempt, written down.
    let target = Receiver::answering(move |earlier, _| {
        if earlier > 0 {
            return StatusCode::OK.into_response();
        }
        breaks.closes_then(true);
        breaks.cuts(Cut::After);
        StatusCode::INTERNAL_SERVER_ERROR.into_response()
    })
    .await;
    let hook = json!({"name": "h", "kind": "standard-webhooks", "url": target.url()});
    assert_eq!(server.post_json("/v1/hooks", &hook).await.status, 201);
    for (at, d_i) in [(1, 1.0), (2, 1.5)] {
        let sent = record("IMU-1", &day(at), &[("G1", "LFG-1", d_i, 2.0)]);
        assert_eq!(server.post_json("/v1/records", &sent).await.status, 201);
    }
    target.has_been_told(1).await;
    // Longer than the service goes on asking what became of the commit.
    tokio::time::sleep(Duration::from_secs(13)).await;
    assert!(between.has_cut());
    between.closes_then(false);
    let open = "SELECT count(*) FROM delivery WHERE state = 'waiting'";
    once(async || count(&url, open).await, |waiting| *waiting == 0).await;
    let twice = "SELECT count(*) FROM (SELECT 1 FROM delivery_attempt GROUP BY delivery, at HAVING count(*) > 1) AS t";
    assert_eq!(count(&url, twice).await, 0);
    let counted = count(&url, "SELECT CAST(sum(attempts) AS BIGINT) FROM delivery").await;
    assert_eq!(counted, target.told().len() as i64);
}
