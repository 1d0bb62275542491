//! What must not happen whatever happens: short forms of the tests of docs/reliability.md. `scripts/soak` runs the long ones,
//! which differ in their numbers alone.

mod support;

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use sqlx::ConnectOptions;
use support::{Server, asked, data, gyrowatch};
use tokio::io::{AsyncReadExt, AsyncWriteExt};

fn client() -> reqwest::Client {
    gyrowatch::system::http_client(Duration::from_secs(5), Duration::from_secs(30)).build().unwrap()
}

fn record(number: usize) -> Value {
    let mut record: Value = serde_json::from_str(&data("paper.json")).unwrap();
    record["imu"] = format!("IMU-{}", number % 40).into();
    for (i, gyro) in record["gyros"].as_array_mut().unwrap().iter_mut().enumerate() {
        gyro["serial"] = format!("G-{}-{i}", number % 40).into();
    }
    let at = jiff::Timestamp::from_second(1_700_000_000 + 60 * number as i64).unwrap();
    record["calibrated_at"] = at.to_string().into();
    record
}

/// The time below which 99 of 100 lie.
fn p99(mut times: Vec<Duration>) -> Duration {
    times.sort();
    times[(times.len() * 99 / 100).min(times.len() - 1)]
}

#[tokio::test]
async fn what_was_acknowledged_survives_kill_9_under_load() {
    let (kills, connections) = (asked("GYROWATCH_SOAK_KILLS", 3), asked("GYROWATCH_SOAK_CONNECTIONS", 16));
    let mut server = Server::start().await;
    let next = Arc::new(AtomicUsize::new(0));
    let acknowledged = Arc::new(Mutex::new(Vec::<String>::new()));
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut slowest = Duration::ZERO;
    for _ in 0..kills {
        let senders: Vec<_> = (0..connections)
            .map(|_| {
                let (url, next, acknowledged) = (server.url("/v1/records"), next.clone(), acknowledged.clone());
                tokio::spawn(async move {
                    let http = client();
                    loop {
                        let body = record(next.fetch_add(1, Ordering::Relaxed)).to_string();
                        let sent = http.post(&url).header("content-type", "application/json").body(body).send().await;
                        let Ok(answer) = sent else { return };
                        if answer.status() == 201
                            && let Ok(text) = answer.text().await
                        {
                            let answer: Value = serde_json::from_str(&text).unwrap();
                            acknowledged.lock().unwrap().push(answer["id"].as_str().unwrap().to_owned());
                        }
                    }
                })
            })
            .collect();
        let before = acknowledged.lock().unwrap().len();
        while acknowledged.lock().unwrap().len() < before + 10 {
            tokio::time::sleep(Duration::from_millis(2)).await;
        }
        tokio::time::sleep(Duration::from_millis(random.random_range(0..350))).await;
        server.kill();
        for sender in senders {
            sender.await.unwrap();
        }
        let began = Instant::now();
        server.restart();
        assert_eq!(server.get("/readyz").await.status, 200);
        slowest = slowest.max(began.elapsed());
    }
    let file = server.dir().join("gyrowatch.db");
    let mut connection =
        sqlx::sqlite::SqliteConnectOptions::new().filename(file).read_only(true).connect().await.unwrap();
    let stored: Vec<i64> = sqlx::query_scalar("SELECT id FROM record").fetch_all(&mut connection).await.unwrap();
    let stored: BTreeSet<String> = stored.into_iter().map(|id| gyrowatch::pipeline::Id(id).to_string()).collect();
    let of_imus: Vec<(String, i64)> =
        sqlx::query_as("SELECT imu.name, count(*) FROM record JOIN imu ON imu.id = record.imu GROUP BY imu.id")
            .fetch_all(&mut connection)
            .await
            .unwrap();
    let mut half = 0;
    for (imu, records) in of_imus {
        for slot in 0..3 {
            let gyro = server.get(&format!("/v1/gyros/{}-{slot}", imu.replace("IMU", "G"))).await.json();
            half += (gyro["calibrations"].as_i64().unwrap() - records).abs();
        }
    }
    let acknowledged = acknowledged.lock().unwrap();
    let lost = acknowledged.iter().filter(|id| !stored.contains(*id)).count();
    println!(
        "kill -9: {kills} kills, {connections} connections, {} acknowledged, {lost} lost, {half} half stored, serving again after {} ms at the most",
        acknowledged.len(),
        slowest.as_millis()
    );
    assert!(acknowledged.len() >= 10 * kills && lost == 0 && half == 0);
    assert!(slowest < Duration::from_secs(10), "{slowest:?}");
}

/// Every number of a document, in order.
fn numbers(value: &Value, found: &mut Vec<f64>) {
    match value {
        Value::Number(number) => found.push(number.as_f64().unwrap()),
        Value::Array(items) => items.iter().for_each(|item| numbers(item, found)),
        Value::Object(members) => members.values().for_each(|member| numbers(member, found)),
        _ => {}
    }
}

/// What a service on `dir` answers to each path; none where it refuses to start, which it must say well.
async fn answers(dir: &std::path::Path, paths: &[String]) -> Option<Vec<(u16, Vec<f64>)>> {
    let mut command = gyrowatch();
    command.arg("serve").current_dir(dir).env("GYROWATCH_LISTEN", "127.0.0.1:0");
    command.env("GYROWATCH_DATABASE_URL", format!("sqlite://{}", dir.join("gyrowatch.db").display()));
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let Some((_, address)) = line.trim().split_once("://") else {
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(1) && said.contains("gyrowatch.db"), "{:?} {said}", output.status);
        return None;
    };
    let http = client();
    let mut answers = Vec::new();
    for path in paths {
        let answer = http.get(format!("http://{address}{path}")).send().await.unwrap();
        let status = answer.status().as_u16();
        let mut figures = Vec::new();
        if status == 200 {
            numbers(&serde_json::from_str(&answer.text().await.unwrap()).unwrap(), &mut figures);
        }
        answers.push((status, figures));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    Some(answers)
}

#[tokio::test]
async fn a_damaged_file_never_gives_wrong_figures() {
    let times = asked("GYROWATCH_SOAK_DAMAGES", 25);
    let mut server = Server::start().await;
    let mut paths = Vec::new();
    for number in 0..24 {
        let answer = server.post_json("/v1/records", &record(number % 3 + 40 * (number / 3))).await;
        assert_eq!(answer.status, 201, "{}", answer.text());
        paths.push(format!("/v1/records/{}", answer.json()["id"].as_str().unwrap()));
    }
    for gyro in ["G-0-0", "G-1-1", "G-2-2"] {
        paths.push(format!("/v1/gyros/{gyro}/trend?coefficient=D_I"));
    }
    assert!(server.terminate().0.success());
    let whole = std::fs::read(server.dir().join("gyrowatch.db")).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("gyrowatch.db");
    let put = |content: &[u8]| {
        for name in ["gyrowatch.db", "gyrowatch.db-wal", "gyrowatch.db-shm"] {
            let _may_not_be_there = std::fs::remove_file(dir.path().join(name));
        }
        std::fs::write(&file, content).unwrap();
    };
    put(&whole);
    let right = answers(dir.path(), &paths).await.expect("it starts on a whole file");
    assert!(right.iter().all(|(status, figures)| *status == 200 && !figures.is_empty()));
    let mut random = ChaCha8Rng::seed_from_u64(asked("GYROWATCH_SOAK_SEED", 11) as u64);
    let (mut refused, mut told, mut unseen, mut missing) = (0, 0, 0, 0);
    for time in 0..times {
        let mut damaged = whole.clone();
        if time % 5 == 4 {
            damaged.truncate(random.random_range(0..whole.len()));
        } else {
            for _ in 0..random.random_range(1..16) {
                let place = random.random_range(0..whole.len());
                damaged[place] ^= 1 << (random.next_u32() % 8);
            }
        }
        put(&damaged);
        let Some(found) = answers(dir.path(), &paths).await else {
            refused += 1;
            continue;
        };
        for ((path, (status, figures)), (_, expected)) in paths.iter().zip(&found).zip(&right) {
            match status {
                200 => assert!(figures == expected, "damage {time}: {path} has other figures and does not say so"),
                404 => missing += 1,
                status => assert!(*status >= 500, "damage {time}: {path} is answered {status}"),
            }
        }
        match found.iter().all(|(status, _)| *status == 200) {
            true => unseen += 1,
            false => told += 1,
        }
    }
    println!(
        "damaged file: {times} times; refused to start {refused}, reported {told}, nothing that was asked for hit {unseen}; \
         0 wrong figures; {missing} answers 404"
    );
}

#[tokio::test]
async fn clients_that_go_slow_are_cut_and_others_do_not_feel_them() {
    let count = asked("GYROWATCH_SOAK_CONNECTIONS", 300);
    let server =
        Server::start_with(&[("GYROWATCH_SERVER__HEADER_TIMEOUT_S", "2"), ("GYROWATCH_SERVER__BODY_TIMEOUT_S", "3")])
            .await;
    let done = Arc::new(AtomicBool::new(false));
    let others = tokio::spawn({
        let (url, done) = (server.url("/v1/gyros"), done.clone());
        async move {
            let (http, mut times) = (client(), Vec::new());
            while !done.load(Ordering::Relaxed) {
                let asked = Instant::now();
                assert_eq!(http.get(&url).send().await.unwrap().status(), 200);
                times.push(asked.elapsed());
                tokio::time::sleep(Duration::from_millis(1)).await;
            }
            times
        }
    });
    let mut slow = Vec::new();
    for number in 0..count {
        let text = match number % 3 {
            0 => "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX-Slow: ",
            1 => {
                "POST /v1/records HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 1000\r\n\r\n{"
            }
            _ => "",
        };
        let opened = Instant::now();
        let stream = server.open_and_send(text).await;
        slow.push(tokio::spawn(async move {
            tokio::time::timeout(Duration::from_secs(20), support::closed(stream)).await.expect("a slow client is cut");
            opened.elapsed()
        }));
    }
    let mut cut = Duration::ZERO;
    for client in slow {
        cut = cut.max(client.await.unwrap());
    }
    done.store(true, Ordering::Relaxed);
    let times = others.await.unwrap();
    let (asked, p99) = (times.len(), p99(times));
    println!(
        "slow clients: {count} connections, each cut after {} ms at the most, p99 of {asked} requests of others {} ms",
        cut.as_millis(),
        p99.as_millis()
    );
    assert!(asked > 100 && p99 < Duration::from_millis(500), "{asked} {p99:?}");
    assert!(cut < Duration::from_secs(8), "{cut:?}");
}

#[tokio::test]
async fn guesses_are_put_off_while_others_are_served() {
    let guesses = asked("GYROWATCH_SOAK_GUESSES", 2000);
    let server = Server::start().await;
    let made = server.post_json("/v1/tokens", &json!({ "name": "a", "role": "admin" })).await.json();
    let bearer = format!("Bearer {}", made["token"].as_str().unwrap());
    let id = made["id"].as_str().unwrap().to_owned();
    let url = server.url("/v1/gyros");
    let guessing: Vec<_> = (0..4)
        .map(|thread| {
            let (url, id) = (url.clone(), id.clone());
            tokio::spawn(async move {
                let (http, mut statuses) = (client(), [0; 2]);
                for guess in 0..guesses / 4 {
                    let token = format!("gyw_{id}_{:064x}", guess * 4 + thread);
                    match http.get(&url).bearer_auth(token).send().await.unwrap().status().as_u16() {
                        401 => statuses[0] += 1,
                        429 => statuses[1] += 1,
                        other => panic!("a guess is answered {other}"),
                    }
                }
                statuses
            })
        })
        .collect();
    let mut times = Vec::new();
    while !guessing.iter().all(tokio::task::JoinHandle::is_finished) || times.is_empty() {
        let asked = Instant::now();
        let answer = server.call("GET", "/v1/gyros", &[("authorization", &bearer)], "").await;
        assert_eq!(answer.status, 200);
        times.push(asked.elapsed());
    }
    let mut statuses = [0; 2];
    for guesses in guessing {
        let of_it = guesses.await.unwrap();
        statuses = [statuses[0] + of_it[0], statuses[1] + of_it[1]];
    }
    let [wrong, put_off] = statuses;
    println!(
        "guesses: {guesses}; {wrong} answered 401, {put_off} 429; p99 of the holder of a token {} ms",
        p99(times).as_millis()
    );
    // Guesses that were under way together when the tenth failed are still answered 401.
    assert!(wrong <= 10 * (1 + guesses / 10_000) + 4 && put_off + wrong == guesses / 4 * 4, "{wrong} {put_off}");
}

#[tokio::test]
async fn requests_that_can_be_read_in_two_ways_are_refused_and_the_connection_is_closed() {
    let server = Server::start().await;
    let head = "POST /v1/records HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n";
    let smuggled = "GET /v1/gyros HTTP/1.1\r\nHost: localhost\r\n\r\n";
    let many = (0..5000).map(|i| format!("X-{i}: y\r\n")).collect::<String>();
    for (what, text) in [
        ("two lengths", format!("{head}Content-Length: 2\r\nContent-Length: 40\r\n\r\n{{}}{smuggled}")),
        ("a length with a sign", format!("{head}Content-Length: +2\r\n\r\n{{}}{smuggled}")),
        ("an unknown coding", format!("{head}Transfer-Encoding: xchunked\r\n\r\n0\r\n\r\n{smuggled}")),
        ("a bad chunk size", format!("{head}Transfer-Encoding: chunked\r\n\r\nzz\r\n{{}}\r\n0\r\n\r\n{smuggled}")),
        ("a header of a megabyte", format!("{head}X: {}\r\n\r\n", "y".repeat(1 << 20))),
        ("5,000 headers", format!("{head}{many}\r\n")),
    ] {
        let mut stream = tokio::net::TcpStream::connect(server.address()).await.unwrap();
        let (mut reading, mut writing) = stream.split();
        let (_may_be_cut, answer) = tokio::join!(writing.write_all(text.as_bytes()), async {
            let mut answer = Vec::new();
            let _reset_counts_too =
                tokio::time::timeout(Duration::from_secs(5), reading.read_to_end(&mut answer)).await.expect(what);
            String::from_utf8_lossy(&answer).into_owned()
        });
        assert!(answer.matches("HTTP/1.1").count() <= 1, "{what}: {answer}");
        let status = answer.split(' ').nth(1).unwrap_or("431");
        assert!(matches!(status, "400" | "431" | "501"), "{what}: {answer}");
    }
    assert_eq!(server.get("/healthz").await.status, 200);
}
