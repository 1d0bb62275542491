//! What must not happen whatever happens: short forms of the tests of docs/reliability.md. `scripts/soak` runs the
//! long ones, which differ in their numbers alone.

use std::io::{BufRead, BufReader};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::command::beside;
use crate::prelude::*;
use crate::support::{asked, client, seed};
use rand::seq::IndexedRandom;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tokio::io::{AsyncReadExt, AsyncWriteExt};

fn record(number: usize) -> Value {
    paper_record(number % 40, number)
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
    let mut connection = behind::read(&server.database()).await;
    let stored: Vec<i64> = sqlx::query_scalar("SELECT id FROM record").fetch_all(&mut connection).await.unwrap();
    let stored: BTreeSet<String> = stored.into_iter().map(|id| gyrowatch::core::id::Id(id).to_string()).collect();
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
async fn answers(dir: &Path, paths: &[String]) -> Option<Vec<(u16, Vec<f64>)>> {
    let mut command = beside(dir);
    let mut child = command
        .arg("serve")
        .env("GYROWATCH_LISTEN", "127.0.0.1:0")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
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

/// Where a gyro's D_I stands in the rows of the history, of which there may be several
/// (`src/store/packed/history_row.rs`): 28 bytes after their version and slot.
fn places_of(d_i: f64, file: &[u8]) -> Vec<usize> {
    let stands = |at: &usize| file[*at..*at + 8] == d_i.to_le_bytes() && file[*at - 28] == 1 && file[*at - 27] < 3;
    (28..file.len() - 8).filter(stands).collect()
}

#[tokio::test]
async fn a_damaged_file_never_gives_wrong_figures() {
    let times = asked("GYROWATCH_SOAK_DAMAGES", 25);
    let mut server = Server::start().await;
    let mut paths = Vec::new();
    for number in 0..24 {
        let answer = server.post_json("/v1/records", &record(number % 3 + 40 * (number / 3))).await.created();
        paths.push(format!("/v1/records/{}", answer["id"].as_str().unwrap()));
    }
    for gyro in ["G-0-0", "G-1-1", "G-2-2"] {
        paths.push(format!("/v1/gyros/{gyro}/trend?coefficient=D_I"));
    }
    assert!(server.terminate().0.success());
    let whole = std::fs::read(server.database()).unwrap();
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
    let of_trends = right.iter().skip(24).flat_map(|(_, figures)| figures);
    let stored: Vec<_> = of_trends.map(|d_i| places_of(*d_i, &whole)).filter(|places| !places.is_empty()).collect();
    assert!(stored.len() >= 24, "each figure of the trends is in the file");
    let mut random = ChaCha8Rng::seed_from_u64(asked("GYROWATCH_SOAK_SEED", 11) as u64);
    let (mut refused, mut told, mut unseen, mut missing) = (0, 0, 0, 0);
    for time in 0..times {
        let mut damaged = whole.clone();
        if time % 5 == 4 {
            damaged.truncate(random.random_range(0..whole.len()));
        } else if time % 5 == 3 {
            // Nothing but its checksum tells that a figure is another one.
            let (byte, bit) = (random.random_range(0..8), random.next_u32() % 8);
            for place in stored.choose(&mut random).unwrap() {
                damaged[place + byte] ^= 1 << bit;
            }
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
                200 => assert_eq!(figures, expected, "damage {time}: {path} has other figures and does not say so"),
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

/// The same record written otherwise: another offset, fractions of a second that are none, blanks, a note that says
/// nothing.
fn written_otherwise(record: &Value, chance: &mut ChaCha8Rng) -> String {
    let mut record = record.clone();
    let at: jiff::Timestamp = record["calibrated_at"].as_str().unwrap().parse().unwrap();
    let offset = jiff::tz::offset(chance.random_range(-12..=14));
    let local = at.to_zoned(offset.to_time_zone()).strftime("%Y-%m-%dT%H:%M:%S").to_string();
    let fraction = ["", ".0", ".000000"].choose(chance).unwrap();
    record["calibrated_at"] = format!("{local}{fraction}{:+03}:00", offset.seconds() / 3600).into();
    if chance.random() {
        record["note"] = Value::Null;
    }
    if chance.random() { record.to_string() } else { serde_json::to_string_pretty(&record).unwrap() }
}

/// Sends a record ten times, each written otherwise; what is not answered, because the service is killed, again.
async fn sends_ten_times(url: String, record: Value, mut chance: ChaCha8Rng) -> Vec<(u16, Value)> {
    let (mut http, mut answers) = (client(), Vec::new());
    while answers.len() < 10 {
        let body = written_otherwise(&record, &mut chance);
        let sent = http.post(&url).header("content-type", "application/json").body(body).send().await;
        let Ok(answer) = sent else {
            tokio::time::sleep(Duration::from_millis(5)).await;
            http = client();
            continue;
        };
        let status = answer.status().as_u16();
        if let Ok(text) = answer.text().await {
            answers.push((status, serde_json::from_str(&text).unwrap()));
        }
    }
    answers
}

/// `scripts/soak again`: every record 160 times, 16 at once, the service killed meanwhile now and then.
#[tokio::test]
async fn a_record_sent_160_times_while_the_service_is_killed_is_stored_once() {
    let records = asked("GYROWATCH_SOAK_RECORDS", 4);
    let mut server = Server::start().await;
    let (mut kills, mut unanswered, mut ids) = (0, 0, BTreeSet::new());
    for number in 0..records {
        let mut chance = ChaCha8Rng::seed_from_u64(seed(number));
        let (url, sent) = (server.url("/v1/records"), record(number));
        let of_sender = |sender: u64| ChaCha8Rng::seed_from_u64(seed(number) ^ (sender << 32));
        let senders: Vec<_> = (1..=16)
            .map(|sender| tokio::spawn(sends_ten_times(url.clone(), sent.clone(), of_sender(sender))))
            .collect();
        let killed = chance.random_bool(0.5);
        if killed {
            tokio::time::sleep(Duration::from_micros(chance.random_range(0..30_000))).await;
            server.kill();
            server.restart();
            kills += 1;
        }
        let (mut created, mut answered) = (0, BTreeSet::new());
        let what = format!("seed {}", seed(number));
        for sender in senders {
            for (status, answer) in sender.await.unwrap() {
                assert!(matches!(status, 200 | 201), "{what}: {status} {answer}");
                created += usize::from(status == 201);
                answered.insert(answer["id"].as_str().unwrap().to_owned());
            }
        }
        // The answer to the first may have been lost with the service.
        assert!(created == 1 || (created == 0 && killed), "{what}: stored {created} times");
        assert_eq!(answered.len(), 1, "{what}");
        unanswered += 1 - created;
        ids.extend(answered);
        let mut changed = sent;
        changed["note"] = "changed".into();
        let changed = (0..8).map(|_| server.post_json("/v1/records", &changed));
        let answers = futures::future::join_all(changed).await;
        assert!(answers.iter().all(|answer| answer.status == 409), "{what}: {answers:?}");
    }
    let stored = server.holdings().await.into_iter().find(|(table, _)| table == "record").unwrap().1;
    assert!(stored == records as i64 && ids.len() == records, "{stored} records, {} identifiers", ids.len());
    for imu in 0..records.min(40) {
        let gyro = server.get(&format!("/v1/gyros/G-{imu}-0")).await.json();
        assert_eq!(gyro["calibrations"], (imu..records).step_by(40).count(), "IMU-{imu}");
    }
    println!(
        "again: {records} records, each sent 160 times, 16 at once, and 8 times changed; {kills} kills, \
         {unanswered} stored without an answer; each stored once, every change refused"
    );
}

/// What makes the end of a request a matter of opinion: each alone is reason enough to read no second one behind it.
const AMBIGUOUS: [&str; 31] = [
    "Host: elsewhere\r\n",
    "Content-Length: 2\r\nContent-Length: 40\r\n",
    "Content-Length: 40\r\nContent-Length: 2\r\n",
    "Content-Length: 2, 40\r\n",
    "Content-Length: 2, 2\r\n",
    "Content-Length: +2\r\n",
    "Content-Length: -2\r\n",
    "Content-Length: 0x2\r\n",
    "Content-Length: 2 2\r\n",
    "Content-Length: 2;\r\n",
    "Content-Length: 2.0\r\n",
    "Content-Length: \r\n",
    "Content-Length: 18446744073709551618\r\n",
    "Content-Length : 2\r\n",
    "Content\tLength: 2\r\n",
    "X: y\r\n Content-Length: 2\r\n",
    "Content-Length: 2\x00\r\n",
    "Transfer-Encoding: xchunked\r\n",
    "Transfer-Encoding: identity\r\n",
    "Transfer-Encoding: chunked, identity\r\n",
    "Transfer-Encoding: chunked\r\nTransfer-Encoding: x\r\n",
    "Transfer-Encoding: \x0bchunked\r\n",
    "Transfer-Encoding: \"chunked\"\r\n",
    "Transfer-Encoding: chunked;q=1\r\n",
    "Transfer-Encoding : chunked\r\n",
    "X: y\r\n Transfer-Encoding: chunked\r\n",
    "Transfer-Encoding: chunked\r\nContent-Length: 2\r\n",
    "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n",
    "Transfer-Encoding: gzip, chunked\r\n",
    "Transfer-Encoding: chunked, chunked\r\n",
    "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n",
];

/// Harmless ones, to stand before and behind.
const PLAIN: [&str; 6] = [
    "Accept: */*\r\n",
    "Connection: keep-alive\r\n",
    "Content-Type: application/json\r\n",
    "X-Forwarded-For: 192.0.2.1\r\n",
    "Expect: 100-continue\r\n",
    "Cookie: a=b\r\n",
];

/// Bodies in chunks whose end readers may see in different places.
const BAD_CHUNKS: [&str; 10] = [
    "zz\r\n{}\r\n0\r\n\r\n",
    "0x2\r\n{}\r\n0\r\n\r\n",
    "-2\r\n{}\r\n0\r\n\r\n",
    "+2\r\n{}\r\n0\r\n\r\n",
    "10000000000000002\r\n{}\r\n0\r\n\r\n",
    "2\r\n{}0\r\n\r\n",
    "2\r\n{}xx0\r\n\r\n",
    "2\n{}\n0\n\n",
    "2\r{}\r0\r\r",
    "\r\n2\r\n{}\r\n0\r\n\r\n",
];

/// Case as chance will have it, which means nothing in the name of a header.
fn in_any_case(text: &str, chance: &mut ChaCha8Rng) -> String {
    let change = |c: char| if chance.random_bool(0.2) { c.to_ascii_uppercase() } else { c };
    text.chars().map(change).collect()
}

/// A request that can be read in two ways, with a second one where one of the readings ends.
fn ambiguous(chance: &mut ChaCha8Rng) -> String {
    let path = *["/v1/records", "/v1/bench-results", "/v1/import", "/v1/hooks", "/healthz", "/nowhere"]
        .choose(chance)
        .unwrap();
    let method = *["POST", "POST", "POST", "GET", "PUT"].choose(chance).unwrap();
    let in_chunks = chance.random_bool(0.25);
    let end = if in_chunks { "Transfer-Encoding: chunked\r\n" } else { AMBIGUOUS.choose(chance).unwrap() };
    let plain = chance.random_range(0..4);
    let mut headers: Vec<String> = PLAIN.sample(chance, plain).map(|text| (*text).to_owned()).collect();
    let further = (!in_chunks && chance.random_bool(0.3)).then(|| *AMBIGUOUS.choose(chance).unwrap());
    for text in [Some(end), further].into_iter().flatten() {
        let at = chance.random_range(0..=headers.len());
        headers.insert(at, in_any_case(text, chance));
    }
    let body = if in_chunks {
        BAD_CHUNKS.choose(chance).unwrap()
    } else {
        ["{}", "0\r\n\r\n", "2\r\n{}\r\n0\r\n\r\n", ""].choose(chance).unwrap()
    };
    let smuggled = "GET /v1/gyros HTTP/1.1\r\nHost: localhost\r\n\r\n";
    format!("{method} {path} HTTP/1.1\r\nHost: localhost\r\n{}\r\n{body}{smuggled}", headers.concat())
}

/// `scripts/soak smuggling`.
#[tokio::test]
async fn of_two_requests_whose_border_is_in_doubt_the_second_is_never_answered() {
    let rounds = asked("GYROWATCH_SOAK_ROUNDS", 150);
    let server = Server::start_with(&[
        ("GYROWATCH_SERVER__BODY_TIMEOUT_S", "0.3"),
        ("GYROWATCH_SERVER__HEADER_TIMEOUT_S", "0.3"),
    ])
    .await;
    let before = server.holdings().await;
    let mut statuses = BTreeMap::<String, usize>::new();
    for round in 0..rounds {
        let text = ambiguous(&mut ChaCha8Rng::seed_from_u64(seed(round)));
        let what = format!("seed {}: {text:?}", seed(round));
        let stream = server.open_and_send(&text).await;
        let mut answer = Vec::new();
        let mut reading = stream;
        let _reset_counts_too =
            tokio::time::timeout(Duration::from_secs(5), reading.read_to_end(&mut answer)).await.expect(&what);
        let answer = String::from_utf8_lossy(&answer).replace("HTTP/1.1 100 Continue\r\n\r\n", "");
        assert!(answer.matches("HTTP/1.1 ").count() <= 1, "{what}: {answer}");
        assert!(!answer.contains("\"gyros\""), "{what}: {answer}");
        *statuses.entry(answer.split(' ').nth(1).unwrap_or("none").to_owned()).or_default() += 1;
    }
    assert_eq!(server.holdings().await, before);
    assert_eq!(server.get("/healthz").await.status, 200);
    println!("smuggling: {rounds} requests, answered {statuses:?}; no second one answered, every connection closed");
}
