//! What takes long or takes much: giant bodies, a clock that jumps, and hours of load. `scripts/soak` runs the long
//! forms.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::prelude::*;
use crate::receiver;
use crate::support::{NEVER_LATE, asked, required};
use axum::http::StatusCode;
use axum::response::IntoResponse;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

fn record(number: usize) -> String {
    paper_record(number % 40, number).to_string()
}

/// A line of `/proc/PID/status`, kB.
fn memory(server: &Server, line: &str) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", server.pid())).unwrap();
    let found = status.lines().find_map(|text| text.strip_prefix(line)).unwrap();
    found.trim_start_matches(':').trim().trim_end_matches(" kB").parse().unwrap()
}

/// Sends a head and then `megabytes` of `filling`, each framed by `frame`, as far as the service takes it; what it
/// answers, up to what is expected.
async fn sends(
    server: &Server,
    head: &str,
    megabytes: usize,
    frame: (&str, &str),
    filling: &[u8],
    expected: &str,
) -> String {
    let mut stream = TcpStream::connect(server.address()).await.unwrap();
    let (mut reading, mut writing) = stream.split();
    let megabyte = [frame.0.as_bytes(), &filling.repeat((1 << 20) / filling.len()), frame.1.as_bytes()].concat();
    let send = async {
        writing.write_all(head.as_bytes()).await?;
        for _ in 0..megabytes {
            writing.write_all(&megabyte).await?;
        }
        if !frame.0.is_empty() {
            writing.write_all(b"0\r\n\r\n").await?;
        }
        std::io::Result::Ok(())
    };
    let read = async {
        let (mut answer, mut part) = (String::new(), vec![0; 1 << 14]);
        while !answer.contains(expected) {
            match reading.read(&mut part).await {
                Ok(read) if read > 0 => answer += &String::from_utf8_lossy(&part[..read]),
                _ => break,
            }
        }
        answer
    };
    let (answer, sent) = tokio::join!(tokio::time::timeout(Duration::from_secs(120), read), async {
        tokio::time::timeout(Duration::from_secs(120), send).await
    });
    let _cut_off = sent;
    answer.unwrap_or_default()
}

#[tokio::test]
async fn giant_bodies_are_refused_and_take_no_memory() {
    let megabytes = asked("GYROWATCH_SOAK_MEGABYTES", 64);
    let server = Server::start().await;
    for number in 0..20 {
        assert_eq!(server.post("/v1/records", "application/json", record(number)).await.status, 201);
    }
    let head = |path: &str, kind: &str, further: &str| {
        format!("POST {path} HTTP/1.1\r\nhost: localhost\r\ncontent-type: {kind}\r\n{further}\r\n\r\n")
    };
    let declared = format!("content-length: {}", megabytes << 20);
    let (chunked, chunk) = ("transfer-encoding: chunked", ("100000\r\n", "\r\n"));
    let gzip = format!("{chunked}\r\ncontent-encoding: gzip");
    // A megabyte of zeros, compressed: a thousandth of it.
    let mut bomb = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    std::io::Write::write_all(&mut bomb, &vec![b' '; 1 << 24]).unwrap();
    let mut bomb = bomb.finish().unwrap();
    bomb.resize(1 << 15, 0);
    let deep = "[".repeat(1 << 15);
    let (json, lines) = ("application/json", "application/x-ndjson");
    for (what, head, frame, filling, expected) in [
        ("declared", head("/v1/records", json, &declared), ("", ""), &b"x"[..], " 413 "),
        ("in chunks", head("/v1/records", json, chunked), chunk, b" ", " 413 "),
        ("deep, in chunks", head("/v1/campaigns", json, chunked), chunk, deep.as_bytes(), " 413 "),
        ("one line of an import", head("/v1/import", lines, chunked), chunk, b"x", "\"status\":413"),
        ("compressed", head("/v1/records", json, &gzip), chunk, &bomb, " 413 "),
        ("a form of the pages", head("/import/preview", "text/plain", &declared), ("", ""), b"x", " 413 "),
    ] {
        std::fs::write(format!("/proc/{}/clear_refs", server.pid()), "5").unwrap();
        let before = memory(&server, "VmRSS");
        let answer = sends(&server, &head, megabytes, frame, filling, expected).await;
        let growth = memory(&server, "VmHWM").saturating_sub(before);
        println!(
            "bodies of {megabytes} MB: {what}: {:.60}..., {growth} kB more at the most",
            answer.replace("\r\n", " ")
        );
        assert!(answer.contains(expected), "{what}: {answer}");
        assert!(growth < 20_000, "{what}: {growth} kB");
    }
    assert_eq!(server.post("/v1/records", json, record(99)).await.status, 201);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_clock_that_jumps_loses_and_doubles_nothing() {
    if !required("faketime") {
        return;
    }
    let jumps = asked("GYROWATCH_SOAK_ROUNDS", 1);
    let library = Command::new("sh").args(["-c", "ls /usr/lib/*/faketime/libfaketimeMT.so.1"]).output().unwrap();
    let library = String::from_utf8(library.stdout).unwrap().trim().to_owned();
    let clock = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(clock.path(), "+0").unwrap();
    let far = Arc::new(AtomicBool::new(false));
    let refusing = far.clone();
    // What is tried again was put off by a clock that is ten years ahead.
    let target = Receiver::answering(move |_, _| {
        if refusing.load(Ordering::Relaxed) {
            StatusCode::SERVICE_UNAVAILABLE.into_response()
        } else {
            ().into_response()
        }
    })
    .await;
    let server = Server::start_with(&[
        ("LD_PRELOAD", &library),
        ("FAKETIME_TIMESTAMP_FILE", clock.path().to_str().unwrap()),
        ("FAKETIME_NO_CACHE", "1"),
        ("FAKETIME_DONT_FAKE_MONOTONIC", "1"),
        ("DONT_FAKE_MONOTONIC", "1"),
        ("GYROWATCH_HOOKS__RETRY_WAITS_S", "0.2,0.2,0.2,0.2,0.2,0.2,0.2,0.2,0.2,0.2,0.2,0.2,0.2"),
        // Stations measure long ago, and are not late.
        NEVER_LATE,
    ])
    .await;
    let server = Arc::new(server);
    let hook = json!({ "kind": "standard-webhooks", "url": target.url(), "batch": false });
    let hook = server.post_json("/v1/hooks", &hook).await.created();
    let hook = hook["id"].as_str().unwrap().to_owned();

    let (next, stop) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
    let times = Arc::new(Mutex::new(Vec::<(String, String)>::new()));
    let senders: Vec<_> = (0..4)
        .map(|_| {
            let (server, next, stop, times) = (server.clone(), next.clone(), stop.clone(), times.clone());
            tokio::spawn(async move {
                let mut last = String::new();
                while !stop.load(Ordering::Relaxed) {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    // Every fourth record of one gyro steps away, and the next one back: what all of an IMU do would be
                    // the IMU's. Each has a station of its own: what all gyros of one do would be the station's.
                    let mut body: Value = serde_json::from_str(&record(number)).unwrap();
                    body["station"] = format!("ST-{}", number % 40).into();
                    if number / 40 % 4 == 3 {
                        let g = &mut body["gyros"][0]["g_pulse_per_s_g0"][1];
                        *g = (g.as_f64().unwrap() + 1.0).into();
                    }
                    let answer = server.post_json("/v1/records", &body).await.created();
                    let id = answer["id"].as_str().unwrap().to_owned();
                    assert!(id > last, "{id} was given after {last}: identifiers ascend, whatever the clock does");
                    last.clone_from(&id);
                    times.lock().unwrap().push((id, body["calibrated_at"].as_str().unwrap().to_owned()));
                }
            })
        })
        .collect();
    for _ in 0..jumps {
        for offset in ["+0", "+3600", "+0", "-3600", "+0", "+315360000", "+0"] {
            far.store(offset == "+315360000", Ordering::Relaxed);
            std::fs::write(clock.path(), offset).unwrap();
            tokio::time::sleep(Duration::from_millis(700)).await;
        }
    }
    far.store(false, Ordering::Relaxed);
    stop.store(true, Ordering::Relaxed);
    for sender in senders {
        sender.await.unwrap();
    }
    // As long as it gets on, however slowly.
    let (mut least, mut since) = (i64::MAX, Instant::now());
    loop {
        let queue = server.get(&format!("/v1/hooks/{hook}")).await.json()["queue"].clone();
        assert_eq!(queue["dead"], 0, "{queue}");
        let open = queue["open"].as_i64().unwrap();
        if open == 0 {
            break;
        }
        if open < least {
            (least, since) = (open, Instant::now());
        }
        assert!(since.elapsed() < Duration::from_secs(120), "{queue}\n{}", server.log());
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let times = times.lock().unwrap().clone();
    for (id, calibrated_at) in &times {
        let stored = server.get(&format!("/v1/records/{id}")).await.json();
        let at: jiff::Timestamp = stored["record"]["calibrated_at"].as_str().unwrap().parse().unwrap();
        assert_eq!(at, calibrated_at.parse().unwrap(), "the time of a record is its own");
    }
    let ids: BTreeSet<&String> = times.iter().map(|(id, _)| id).collect();
    assert_eq!(ids.len(), times.len(), "an identifier twice");
    let steps = server.holdings().await.into_iter().find(|(table, _)| table == "alert_step").unwrap().1;
    let told: BTreeSet<String> = target.told().iter().map(receiver::Told::id).collect();
    println!(
        "clock jumps: {} of an hour and of ten years, {} records, {steps} steps of alerts, each told",
        6 * jumps,
        times.len()
    );
    assert!(steps > 0 && told.len() as i64 == steps, "{steps} steps, {} told", told.len());
}

/// Bytes that `/metrics` gives for a series.
async fn metric(server: &Server, name: &str) -> f64 {
    let text = server.get("/metrics").await.text();
    support::metric(&text, name)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn hours_of_load_with_slow_readers_and_restarts_change_nothing() {
    let seconds = asked("GYROWATCH_SOAK_SECONDS", 6) as u64;
    // In the first half; in the second it is left alone, so that what grows can be seen.
    let restart_every = Duration::from_secs((seconds / 6).max(2));
    let rate = asked("GYROWATCH_SOAK_RATE", 60) as f64;
    let senders = asked("GYROWATCH_SOAK_CONNECTIONS", 1);
    let pages = 1000_u64;
    let mut server = Server::start_with(&[("GYROWATCH_DATABASE__CHECKPOINT_PAGES", &pages.to_string())]).await;
    let began = Instant::now();
    let (mut number, mut latencies, mut samples) = (0_usize, Vec::<(f64, Duration)>::new(), Vec::<(f64, f64)>::new());
    let (mut largest_log, mut restarts, mut since) = (0.0_f64, 0, Instant::now());
    while began.elapsed() < Duration::from_secs(seconds) {
        // Somebody who asks for much and reads none of it, all the time.
        let _slow =
            server.open_and_send("GET /v1/gyros/G-1-0/trend?coefficient=D_I HTTP/1.1\r\nHost: localhost\r\n\r\n").await;
        for _ in 0..20 {
            let due = began + Duration::from_secs_f64(number as f64 / rate);
            tokio::time::sleep_until(due.into()).await;
            let posts = (number..number + senders).map(async |number| {
                let asked = Instant::now();
                assert_eq!(server.post("/v1/records", "application/json", record(number)).await.status, 201);
                (began.elapsed().as_secs_f64(), asked.elapsed())
            });
            latencies.extend(futures::future::join_all(posts).await);
            number += senders;
        }
        largest_log = largest_log.max(metric(&server, "gyrowatch_database_log_size_bytes").await);
        samples.push((began.elapsed().as_secs_f64(), memory(&server, "VmRSS") as f64));
        // On a busy machine the first half may be over before.
        if since.elapsed() > restart_every && (restarts == 0 || began.elapsed() < Duration::from_secs(seconds / 2)) {
            assert!(server.terminate().0.success());
            server.restart();
            (restarts, since) = (restarts + 1, Instant::now());
        }
    }
    let p99 = |from: f64, to: f64| {
        let mut of: Vec<Duration> =
            latencies.iter().filter(|(at, _)| (from..to).contains(at)).map(|(_, took)| *took).collect();
        of.sort();
        of[(of.len() * 99 / 100).min(of.len() - 1)]
    };
    let half = began.elapsed().as_secs_f64() / 2.0;
    let later: Vec<(f64, f64)> = samples.iter().copied().filter(|(at, _)| *at > half).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| later.iter().map(of).sum::<f64>() / later.len() as f64;
    let (t, m) = (mean(|s| s.0), mean(|s| s.1));
    let spread: f64 = later.iter().map(|s| (s.0 - t).powi(2)).sum();
    let slope = later.iter().map(|s| (s.0 - t) * (s.1 - m)).sum::<f64>() / spread.max(1e-9);
    let mut from = 0.0;
    for part in samples.chunks(samples.len().div_ceil(20)) {
        let to = part[part.len() - 1].0;
        let mean = part.iter().map(|sample| sample.1).sum::<f64>() / part.len() as f64;
        println!("soak: {from:6.0} s to {to:6.0} s: memory {mean:.0} kB, p99 {} ms", p99(from, to).as_millis());
        from = to;
    }
    println!(
        "soak: {seconds} s at {rate} records/s, {number} stored, {restarts} restarts; p99 {} ms in the first half, {} ms in the second; \
         memory {:.0} kB, slope {:.1} kB/s in the second half; log at most {:.1} MB",
        p99(0.0, half).as_millis(),
        p99(half, f64::INFINITY).as_millis(),
        m,
        slope,
        largest_log / 1e6
    );
    assert!(restarts > 0 && m < 300_000.0);
    assert!(largest_log < 4.0 * pages as f64 * 4096.0, "the log grows: {largest_log} bytes");
    let stored = server.holdings().await.into_iter().find(|(table, _)| table == "record").unwrap().1;
    assert_eq!(stored, number as i64);
}
