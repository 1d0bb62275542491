//! The disk is full, cannot be written, or fails to flush: what the service answers then, and how it comes back.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::command::beside;
use crate::prelude::*;
use crate::prometheus::Prometheus;
use crate::support::{Answer, client, file_url, fill, gyrowatch_under, on_a_small_disk, required, small_disks_work};

fn record(number: usize) -> String {
    paper_record(number % 20, number).to_string()
}

async fn post(server: &Server, number: usize) -> Answer {
    server.post("/v1/records", "application/json", record(number)).await
}

/// A server on a disk of so many MiB, and the file that fills it.
fn start_on(mib: usize, settings: &[(&str, &str)]) -> (Server, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let inside = dir.path().to_owned();
    let under = [on_a_small_disk(&format!("size={mib}m")), vec![inside.to_str().unwrap().to_owned()]].concat();
    let under: Vec<&str> = under.iter().map(String::as_str).collect();
    let server = Server::start_under(&under, dir, settings);
    let filler = PathBuf::from(format!("/proc/{}/root{}/filler", server.pid(), inside.display()));
    (server, filler)
}

#[tokio::test]
async fn a_full_disk_is_answered_507_while_reading_goes_on_and_there_is_room_again_without_a_restart() {
    if !small_disks_work() {
        return;
    }
    let rounds = support::asked("GYROWATCH_SOAK_ROUNDS", 2);
    // Room for what is stored in every round as well, which a release build does fast.
    let (server, filler) = start_on(16 + 8 * rounds, &[("GYROWATCH_DATABASE__CHECKPOINT_PAGES", "200")]);
    let server = Arc::new(server);

    let (next, stop) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
    let stored = Arc::new(Mutex::new(Vec::<(String, Instant)>::new()));
    let refused = Arc::new(Mutex::new(Vec::<(u16, Instant)>::new()));
    let senders: Vec<_> = (0..16)
        .map(|_| {
            let (server, next, stop) = (server.clone(), next.clone(), stop.clone());
            let (stored, refused) = (stored.clone(), refused.clone());
            tokio::spawn(async move {
                while !stop.load(Ordering::Relaxed) {
                    let answer = post(&server, next.fetch_add(1, Ordering::Relaxed)).await;
                    if answer.status == 201 {
                        let id = answer.json()["id"].as_str().unwrap().to_owned();
                        stored.lock().unwrap().push((id, Instant::now()));
                    } else {
                        assert_eq!(answer.content_type, "application/problem+json");
                        refused.lock().unwrap().push((answer.status, Instant::now()));
                        tokio::time::sleep(Duration::from_millis(20)).await;
                    }
                }
            })
        })
        .collect();
    let mut slowest = Duration::ZERO;
    for _ in 0..rounds {
        tokio::time::sleep(Duration::from_millis(700)).await;
        let before = refused.lock().unwrap().len();
        fill(&filler);
        let began = Instant::now();
        while refused.lock().unwrap().len() < before + 16 {
            assert!(began.elapsed() < Duration::from_secs(120), "a full disk refuses nothing");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        let (last, _) = stored.lock().unwrap().last().unwrap().clone();
        assert_eq!(server.get(&format!("/v1/records/{last}")).await.status, 200, "reading goes on");
        assert_eq!(server.get("/v1/gyros/G-1-0/trend?coefficient=D_I").await.status, 200, "reading goes on");
        std::fs::remove_file(&filler).unwrap();
        let room = Instant::now();
        let again = loop {
            let found = stored.lock().unwrap().iter().map(|(_, at)| *at).find(|at| *at > room);
            if let Some(at) = found {
                break at;
            }
            assert!(
                room.elapsed() < Duration::from_secs(60),
                "nothing is stored though there is room\n{}",
                server.log()
            );
            tokio::time::sleep(Duration::from_millis(5)).await;
        };
        slowest = slowest.max(again - room);
        assert_eq!(server.get("/readyz").await.status, 200);
    }
    stop.store(true, Ordering::Relaxed);
    for sender in senders {
        sender.await.unwrap();
    }
    let (stored, refused) = (stored.lock().unwrap().clone(), refused.lock().unwrap().clone());
    let mut lost = 0;
    for (id, _) in &stored {
        lost += usize::from(server.get(&format!("/v1/records/{id}")).await.status != 200);
    }
    let others: Vec<u16> =
        refused.iter().map(|(status, _)| *status).filter(|status| !matches!(status, 503 | 507)).collect();
    println!(
        "disk full: {rounds} times, {} stored, {} answered 507, {} 503, {} otherwise, {lost} lost; stored again {} ms after there was room",
        stored.len(),
        refused.iter().filter(|(status, _)| *status == 507).count(),
        refused.iter().filter(|(status, _)| *status == 503).count(),
        others.len(),
        slowest.as_millis()
    );
    assert!(others.is_empty() && refused.iter().any(|(status, _)| *status == 507), "{others:?}");
    assert!(lost == 0 && slowest < Duration::from_secs(5));
}

/// A balancer that asks sends no more there, so that no write could tell that there is room again.
#[tokio::test]
async fn a_service_whose_disk_is_full_is_not_ready_until_there_is_room_written_to_or_not() {
    if !small_disks_work() {
        return;
    }
    let (server, filler) = start_on(16, &[]);
    fill(&filler);
    let (refused, stored) = until_refused(&server).await;
    assert_eq!(refused.status, 507, "{}", refused.text());
    for _ in 0..3 {
        let ready = server.get("/readyz").await;
        assert_eq!((ready.status, &ready.json()["code"]), (503, &json!("not_writing")), "{}", ready.text());
        assert_eq!(post(&server, stored).await.status, 507);
    }
    assert_eq!(server.get("/healthz").await.status, 200);
    std::fs::remove_file(&filler).unwrap();
    assert_eq!(server.get("/readyz").await.status, 200, "nobody has written");
    assert_eq!(post(&server, stored).await.status, 201);
}

#[tokio::test]
async fn a_log_that_cannot_be_written_ends_nothing() {
    gyrowatch::system::install_crypto();
    let dir = tempfile::tempdir().unwrap();
    let mut command = beside(dir.path());
    command.arg("serve").env("GYROWATCH_LISTEN", "127.0.0.1:0").env("GYROWATCH_LOG__FILTER", "trace");
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let mut child = command.stdout(Stdio::piped()).stderr(full).spawn().unwrap();
    let mut line = String::new();
    std::io::BufRead::read_line(&mut std::io::BufReader::new(child.stdout.take().unwrap()), &mut line).unwrap();
    let address = line.trim().split_once("://").expect("it starts").1.to_owned();
    let http = client();
    for number in 0..3 {
        let request = http.post(format!("http://{address}/v1/records")).header("content-type", "application/json");
        let answer = request.body(record(number)).send().await.unwrap();
        assert_eq!(answer.status(), 201);
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Sends records until one is not stored: its answer, and how many were.
async fn until_refused(server: &Server) -> (Answer, usize) {
    for number in 0..2000 {
        let answer = post(server, number).await;
        if answer.status != 201 {
            return (answer, number);
        }
    }
    panic!("everything was stored though the disk fails");
}

/// strace counts the calls of each thread by itself, and several take turns to write: one may still do so when
/// another fails. What it has then answered 201 is stored.
async fn until_every_thread_fails(server: &Server) {
    let mut refused_in_a_row = 0;
    for number in 3_000..9_000 {
        let answer = post(server, number).await;
        refused_in_a_row += 1;
        if answer.status != 503 {
            assert_eq!(answer.status, 201, "{}", answer.text());
            let id = answer.json()["id"].as_str().unwrap().to_owned();
            assert_eq!(server.get(&format!("/v1/records/{id}")).await.status, 200, "{id}");
            refused_in_a_row = 0;
        } else if refused_in_a_row == 20 {
            return;
        }
    }
    panic!("some are stored still");
}

/// A service whose calls of `what` fail with `error`, as `when` says, of those that touch `file`.
fn failing(what: &str, error: &str, when: &str, file: &str, settings: &[(&str, &str)]) -> (Server, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let (trace, file) = (dir.path().join("trace"), dir.path().join(file));
    let (calls, inject) = (format!("trace={what}"), format!("inject={what}:error={error}:when={when}"));
    let under = ["strace", "-D", "-f", "-y", "-P", file.to_str().unwrap(), "-e", &calls, "-e", &inject, "-o"];
    let under = [&under[..], &[trace.to_str().unwrap()]].concat();
    (Server::start_under(&under, dir, settings), trace)
}

/// The calls that were seen, up to the end of the service.
async fn seen(trace: &Path) -> Vec<String> {
    let began = Instant::now();
    loop {
        let text = std::fs::read_to_string(trace).unwrap();
        if text.lines().last().is_some_and(|line| line.contains("+++ ")) && text.ends_with('\n') {
            return text.lines().filter(|line| line.contains("sync(")).map(str::to_owned).collect();
        }
        assert!(began.elapsed() < Duration::from_secs(60), "strace does not end");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

#[tokio::test]
async fn after_a_failed_flush_nothing_is_stored_and_none_is_tried_again() {
    if !required("strace") {
        return;
    }
    let copying = [("GYROWATCH_DATABASE__CHECKPOINT_PAGES", "40")];
    for (what, file, when, settings) in [
        ("of a commit", "gyrowatch.db-wal", "64", &[][..]),
        ("of the database while the log is copied into it", "gyrowatch.db", "18", &copying),
    ] {
        // One flush of a thread fails and later ones would succeed: who tries again is found out.
        let (mut server, trace) = failing("fsync,fdatasync", "EIO", when, file, settings);
        let (answer, stored) = until_refused(&server).await;
        assert_eq!(answer.status, 503, "{what}: {}", answer.text());
        assert!(answer.text().contains("disk failed"), "{what}: {}", answer.text());
        for number in 0..5 {
            assert_eq!(post(&server, 10_000 + number).await.status, 503, "{what}");
        }
        assert_eq!(server.get("/v1/gyros/G-1-0/trend?coefficient=D_I").await.status, 200, "{what}: reading goes on");
        let ready = server.get("/readyz").await;
        assert_eq!(ready.status, 503, "{what}");
        assert!(server.log().contains("a flush of the disk failed"), "{what}");
        assert!(server.terminate().0.success(), "{what}: {}", server.log());
        let seen = seen(&trace).await;
        let failed = seen.iter().position(|line| line.contains("INJECTED")).expect("a flush has failed");
        assert_eq!(seen.len(), failed + 1, "{what}: flushed after a failure:\n{}", seen[failed..].join("\n"));

        server.restart();
        assert_eq!(server.get("/readyz").await.status, 200, "{what}");
        for number in 0..stored {
            assert_eq!(post(&server, number).await.status, 200, "{what}: record {number} was stored");
        }
        assert_eq!(post(&server, 20_000).await.status, 201, "{what}");
    }
}

#[tokio::test]
async fn a_disk_that_cannot_be_written_is_answered_503_and_never_2xx() {
    if !required("strace") {
        return;
    }
    for error in ["EROFS", "EIO", "EDQUOT"] {
        let (server, _) = failing("pwrite64", error, "600+", "gyrowatch.db-wal", &[]);
        let (answer, stored) = until_refused(&server).await;
        assert!(stored > 0);
        assert_eq!(answer.status, 503, "{error}: {}", answer.text());
        assert!(answer.headers.contains_key("retry-after"), "{error}");
        until_every_thread_fails(&server).await;
        assert_eq!(server.get("/v1/gyros/G-0-0/trend?coefficient=D_I").await.status, 200, "{error}: reading goes on");
        assert_eq!(server.get("/readyz").await.status, 503, "{error}");
        assert_eq!(server.get("/healthz").await.status, 200, "{error}");
    }
}

#[tokio::test]
async fn on_a_read_only_file_system_it_does_not_start_and_names_the_file() {
    if !small_disks_work() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let under = [on_a_small_disk("size=1m,ro"), vec![dir.path().to_str().unwrap().to_owned()]].concat();
    let under: Vec<&str> = under.iter().map(String::as_str).collect();
    let mut command = gyrowatch_under(&under);
    command.arg("serve").env("GYROWATCH_LISTEN", "127.0.0.1:0");
    command.env("GYROWATCH_DATABASE_URL", file_url(&dir.path().join("gyrowatch.db")));
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("gyrowatch.db") && said.contains("Read-only"), "{said}");
}

#[tokio::test]
async fn a_prometheus_with_the_rules_that_ship_tells_of_a_full_disk() {
    if !small_disks_work() || !required("prometheus") {
        return;
    }
    let (server, filler) = start_on(16, &[]);
    let prometheus = Prometheus::watching(&server);
    let patience = Instant::now() + Duration::from_secs(60);
    let waits = async || {
        assert!(Instant::now() < patience, "{:?}", prometheus.firing().await);
        tokio::time::sleep(Duration::from_millis(200)).await;
    };
    assert_eq!(post(&server, 0).await.status, 201);
    while !prometheus.scrapes().await {
        waits().await;
    }
    assert_eq!(prometheus.firing().await, [""; 0]);
    fill(&filler);
    let mut number = 1;
    while post(&server, number).await.status != 507 {
        number += 1;
    }
    while !prometheus.firing().await.contains(&"GyrowatchNotStored".to_owned()) {
        waits().await;
    }
}
