//! The disk under PostgreSQL is full: what servers answer then, and how they come back.

use std::collections::HashSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::cluster::{Cluster, Crowded};
use crate::prelude::*;
use crate::support::{fill, small_disks_work};
use sqlx::{Connection, PgConnection};

const SENDERS: usize = 16;
/// Serving again after there is room, and the database has come up.
const MOST: Duration = Duration::from_secs(5);
/// Reads the history of a gyro.
const TREND: &str = "/v1/gyros/G-1-0/trend?coefficient=D_I";
const PATIENCE: Duration = Duration::from_secs(60);

fn record(number: usize) -> String {
    paper_record(number % 20, number).to_string()
}

/// What was heard of the servers.
#[derive(Default)]
struct Heard {
    stored: Vec<(String, Instant)>,
    refused: Vec<u16>,
    /// Of questions that change nothing.
    read: Vec<u16>,
}

/// Two servers, the stations that send to them, and somebody who looks.
struct Crowd {
    servers: [Server; 2],
    heard: Mutex<Heard>,
    next: AtomicUsize,
    stop: AtomicBool,
}

impl Crowd {
    fn on(url: &str) -> Arc<Self> {
        let settings = [("GYROWATCH_DATABASE_URL", url), ("GYROWATCH_DATABASE__LEASE_S", "3")];
        let server = || Server::start_under(&[], tempfile::tempdir().unwrap(), &settings);
        Arc::new(Self {
            servers: [server(), server()],
            heard: Mutex::default(),
            next: AtomicUsize::new(0),
            stop: AtomicBool::new(false),
        })
    }

    fn stored_after(&self, instant: Instant) -> Option<Instant> {
        self.heard.lock().unwrap().stored.iter().map(|(_, at)| *at).find(|at| *at > instant)
    }

    fn refused(&self) -> usize {
        self.heard.lock().unwrap().refused.len()
    }

    /// Sends one record after another, each until a server has taken it: what is not answered with an identifier is
    /// sent again.
    async fn send(self: Arc<Self>, sender: usize) {
        while !self.stop.load(Ordering::Relaxed) {
            let record = record(self.next.fetch_add(1, Ordering::Relaxed));
            for server in self.servers.iter().cycle().skip(sender % 2) {
                let answer = server.post("/v1/records", "application/json", record.clone()).await;
                if matches!(answer.status, 200 | 201) {
                    let id = answer.json()["id"].as_str().unwrap().to_owned();
                    self.heard.lock().unwrap().stored.push((id, Instant::now()));
                    break;
                }
                assert_eq!(answer.content_type, "application/problem+json", "{}", answer.text());
                assert!(answer.status != 503 || answer.headers.contains_key("retry-after"));
                if !matches!(answer.status, 503 | 507) {
                    println!("{}: {}", answer.status, answer.text());
                }
                self.heard.lock().unwrap().refused.push(answer.status);
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        }
    }

    async fn look(self: Arc<Self>) {
        while !self.stop.load(Ordering::Relaxed) {
            let last = self.heard.lock().unwrap().stored.last().map(|(id, _)| format!("/v1/records/{id}"));
            for path in last.as_deref().into_iter().chain([TREND]) {
                for server in &self.servers {
                    let status = server.get(path).await.status;
                    self.heard.lock().unwrap().read.push(status);
                }
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }
}

/// What became of a disk that was filled under load so many times.
struct Outcome {
    heard: Heard,
    /// How often the database ended by itself and was started again by hand.
    ended: usize,
    /// How often a part of it did, and the rest began anew.
    panics: usize,
    /// How long a start by hand took at the most.
    starting: Duration,
    /// How long after there was room, and a database that answers, something was stored again, at the most.
    slowest: Duration,
}

/// Fills the disk under load and makes room again, so many times; whoever looks after the database starts it where it
/// has ended, and leaves the servers alone.
async fn fills_up(cluster: &mut Cluster, url: &str, rounds: usize) -> Outcome {
    let crowd = Crowd::on(url);
    let mut at_work: Vec<_> = (0..SENDERS).map(|sender| tokio::spawn(crowd.clone().send(sender))).collect();
    let filler = cluster.on_its_disk("filler");
    let (mut ended, mut starting, mut slowest) = (0, Duration::ZERO, Duration::ZERO);
    for server in &crowd.servers {
        while server.get(TREND).await.status != 200 {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }
    at_work.push(tokio::spawn(crowd.clone().look()));
    for _ in 0..rounds {
        tokio::time::sleep(Duration::from_millis(700)).await;
        let (before, full) = (crowd.refused(), Instant::now());
        while crowd.refused() < before + SENDERS || full.elapsed() < Duration::from_secs(2) {
            assert!(full.elapsed() < PATIENCE, "a full disk refuses nothing");
            fill(&filler);
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        std::fs::remove_file(&filler).unwrap();
        let room = Instant::now();
        let mut answers = room;
        let again = loop {
            if let Some(at) = crowd.stored_after(room) {
                break at;
            }
            // It may end later than there is room, where it was about to.
            if !cluster.lives() {
                ended += 1;
                let began = Instant::now();
                tokio::task::block_in_place(|| cluster.start_again());
                answers = Instant::now();
                starting = starting.max(answers - began);
            }
            assert!(room.elapsed() < PATIENCE, "nothing is stored though there is room\n{}", cluster.log());
            tokio::time::sleep(Duration::from_millis(5)).await;
        };
        slowest = slowest.max(again.saturating_duration_since(answers));
    }
    crowd.stop.store(true, Ordering::Relaxed);
    for worker in at_work {
        worker.await.unwrap();
    }
    for server in &crowd.servers {
        assert_eq!(server.get("/readyz").await.status, 200);
    }
    let heard = std::mem::take(&mut *crowd.heard.lock().unwrap());
    Outcome { heard, ended, panics: cluster.log().matches("PANIC:").count(), starting, slowest }
}

/// Every acknowledged record is there under its identifier, whole, and none twice.
async fn lost(url: &str, acknowledged: &[(String, Instant)]) -> usize {
    let mut connection = PgConnection::connect(url).await.unwrap();
    let rows: Vec<(i64, i64)> =
        sqlx::query_as("SELECT id, calibrated_at FROM record").fetch_all(&mut connection).await.unwrap();
    let history: i64 = sqlx::query_scalar("SELECT count(*) FROM history").fetch_one(&mut connection).await.unwrap();
    let ids: HashSet<String> = rows.iter().map(|(id, _)| gyrowatch::core::id::Id(*id).to_string()).collect();
    let times: HashSet<i64> = rows.iter().map(|(_, at)| *at).collect();
    assert_eq!(times.len(), rows.len(), "a record is there twice");
    assert_eq!(history as usize, 3 * rows.len(), "a record is there in part");
    assert_eq!(rows.len(), acknowledged.len(), "each record was sent until it was acknowledged");
    acknowledged.iter().filter(|(id, _)| !ids.contains(id)).count()
}

fn times(statuses: &[u16], status: u16) -> usize {
    statuses.iter().filter(|found| **found == status).count()
}

async fn a_full_disk_loses_nothing(what: Crowded) -> Outcome {
    let rounds = support::asked("GYROWATCH_SOAK_ROUNDS", 2);
    let mut cluster = Cluster::start_on_a_small_disk("160m", what);
    let url = cluster.fresh_database().await;
    let outcome = fills_up(&mut cluster, &url, rounds).await;
    let Outcome { heard, ended, panics, starting, slowest } = &outcome;
    let lost = lost(&url, &heard.stored).await;
    let (refused, read) = (&heard.refused, &heard.read);
    let otherwise = refused.len() - times(refused, 507) - times(refused, 503);
    println!(
        "disk full under PostgreSQL ({what:?}): {rounds} times, {} stored, {} answered 507, {} 503, {otherwise} otherwise, {lost} lost; \
         of {} readings {} answered 200, {} 503; PostgreSQL failed {panics} times and ended {ended} times, \
         started again in {} ms at the most; \
         stored again {} ms after that, or after there was room, at the most",
        heard.stored.len(),
        times(refused, 507),
        times(refused, 503),
        read.len(),
        times(read, 200),
        times(read, 503),
        starting.as_millis(),
        slowest.as_millis(),
    );
    assert!(otherwise == 0 && lost == 0 && *slowest < MOST);
    assert_eq!(read.len(), times(read, 200) + times(read, 503));
    outcome
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_full_disk_under_the_database_is_answered_507_while_reading_goes_on() {
    if !cluster::is_there() || !small_disks_work() {
        return;
    }
    let outcome = a_full_disk_loses_nothing(Crowded::Everything).await;
    assert!(times(&outcome.heard.refused, 507) > 0);
    assert!(outcome.panics > 0 || times(&outcome.heard.read, 200) == outcome.heard.read.len(), "reading goes on");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_full_disk_that_ends_the_database_is_answered_503_until_it_is_started_again() {
    if !cluster::is_there() || !small_disks_work() {
        return;
    }
    let outcome = a_full_disk_loses_nothing(Crowded::Log).await;
    assert!(outcome.ended > 0, "the database has held out: it proves nothing");
}
