//! Many writers on several servers judge as one would: what they store at the same time is computed again afterwards,
//! and the alerts of gyros that have a sender of their own take the steps that they take at a single server.

use std::panic::AssertUnwindSafe;

use crate::cluster::count;
use crate::command;
use crate::database_proxy::Proxy;
use crate::lab::JSON;
use crate::prelude::*;
use crate::support::{NEVER_LATE, client};
use futures::FutureExt as _;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use reqwest::{Client, Method, StatusCode};
use sqlx::{Connection, PgConnection};
use tokio::task::JoinSet;

/// IMUs that all senders share: their records meet in the same cells.
const IMUS: i64 = 6;

async fn server_on(url: &str) -> Server {
    Server::start_with(&[("GYROWATCH_DATABASE_URL", url), NEVER_LATE]).await
}

/// An instant, in half days, that no other record of any sender has.
fn instant(sender: i64, half_day: i64) -> String {
    jiff::Timestamp::from_second(1_735_732_800 + 43_200 * half_day + sender).unwrap().to_string()
}

/// What a sender does, one after the other, each at any of the servers: new records, now and then one that is late, is
/// voided, or is revised. Its own gyros move among the IMUs; a gyro that all share is in every third record.
async fn send(servers: Arc<[String]>, sender: i64, steps: i64, shared: bool) {
    let http = client();
    let seed = support::seed(0).wrapping_add(sender.unsigned_abs());
    let (mut chance, mut choice) = (ChaCha8Rng::seed_from_u64(seed), ChaCha8Rng::seed_from_u64(!seed));
    let mut stored: Vec<(String, i64)> = Vec::new();
    let made = |half_day: i64, imu: i64, d_i: f64| {
        let own = [format!("OWN-{sender}-1"), format!("OWN-{sender}-2")];
        let mut gyros = vec![("G1", own[0].as_str(), d_i, 2.0), ("G2", own[1].as_str(), 3.0, 2.0 - d_i / 50.0)];
        if shared && half_day % 3 == 0 {
            gyros.push(("G3", "SHARED", d_i, 2.0));
        }
        record(&format!("IMU-{imu}"), &instant(sender, half_day), &gyros)
    };
    let said = |mut body: Value| {
        body["author"] = json!("Li Wei");
        body["reason"] = json!("table was not level");
        body
    };
    for step in 0..steps {
        let server = &servers[choice.random_range(0..servers.len())];
        // It stays in an IMU for a while; what has jumped comes back with the next record but one.
        let (imu, jumped) = ((sender + step / 5) % IMUS, step % 7 >= 5);
        let d_i = 1.0 + if jumped { 0.1 } else { 0.0 } + chance.random_range(-1e-3..1e-3);
        // After every fourth comes one that was made before it.
        let half_days = if step % 4 == 2 { vec![2 * step, 2 * step - 1] } else { vec![2 * step] };
        for half_day in half_days {
            let answer = answer(&http, Method::POST, server, "/v1/records", &made(half_day, imu, d_i)).await;
            stored.push((id(&answer).to_owned(), half_day));
        }
        match chance.random_range(0..8) {
            0 => {
                let (id, _) = stored.swap_remove(chance.random_range(0..stored.len()));
                answer(&http, Method::POST, server, &format!("/v1/records/{id}/void"), &said(json!({}))).await;
            }
            1 => {
                let (id, of) = stored.swap_remove(chance.random_range(0..stored.len()));
                // In the IMU in which it was.
                let there = answer(&http, Method::GET, server, &format!("/v1/records/{id}"), &Value::Null).await;
                let imu: i64 = there["record"]["imu"].as_str().unwrap()["IMU-".len()..].parse().unwrap();
                let revised = said(json!({"record": made(of, imu, 1.002)}));
                answer(&http, Method::POST, server, &format!("/v1/records/{id}/revise"), &revised).await;
            }
            _ => {}
        }
    }
}

/// The answer of a server, once there is one: it may be busy, or killed with the question half done. The same again is
/// no harm. (A task of its own cannot wait by `once`: its borrowing closure is not `Send`.)
async fn answer(http: &Client, method: Method, server: &str, path: &str, body: &Value) -> Value {
    for _ in 0..600 {
        let asked = http.request(method.clone(), format!("http://{server}{path}"));
        if let Ok(answer) = asked.header("content-type", JSON).body(body.to_string()).send().await {
            let status = answer.status();
            match answer.text().await {
                Ok(text) if status.is_success() => return serde_json::from_str(&text).unwrap(),
                Ok(text) => assert_eq!(status, StatusCode::SERVICE_UNAVAILABLE, "{text}"),
                Err(_broken_off) => {}
            }
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    panic!("nobody takes {body}")
}

/// Steps of alerts, by gyro, coefficient and rule.
type Steps = BTreeMap<(String, String, String), Vec<String>>;

/// What became of the alerts of each sender's own gyros, in order.
async fn steps_of(url: &str) -> Steps {
    let sql = "SELECT gyro.serial, alert.coefficient, alert.rule, alert_step.action
               FROM alert_step JOIN alert ON alert.id = alert_step.alert JOIN gyro ON gyro.id = alert.gyro
               WHERE gyro.serial LIKE 'OWN-%' ORDER BY alert_step.id";
    let mut connection = PgConnection::connect(url).await.unwrap();
    let rows: Vec<(String, String, String, String)> = sqlx::query_as(sql).fetch_all(&mut connection).await.unwrap();
    let mut steps = Steps::new();
    for (serial, coefficient, rule, action) in rows {
        steps.entry((serial, coefficient, rule)).or_default().push(action);
    }
    steps
}

async fn sent_by_all(servers: &[Server], senders: i64, steps: i64, shared: bool) {
    sending(servers, senders, steps, shared).join_all().await;
}

/// All senders, each at work on its own.
fn sending(servers: &[Server], senders: i64, steps: i64, shared: bool) -> JoinSet<()> {
    let servers: Arc<[String]> = servers.iter().map(|server| server.address().to_owned()).collect();
    (0..senders).map(|sender| send(servers.clone(), sender, steps, shared)).collect()
}

/// The same while servers are killed (kill -9) by turns, each started again after a while. Answers how many were.
async fn sent_by_all_through_kills(servers: &mut [Server], senders: i64, steps: i64) -> usize {
    let (mut sending, mut kills) = (sending(servers, senders, steps, true), 0);
    while !sending.is_empty() {
        let victim = &mut servers[kills % servers.len()];
        victim.kill();
        kills += 1;
        tokio::time::sleep(Duration::from_millis(200)).await;
        victim.restart();
        let until = tokio::time::Instant::now() + Duration::from_millis(700);
        while let Ok(Some(done)) = tokio::time::timeout_at(until, sending.join_next()).await {
            done.unwrap();
        }
    }
    kills
}

/// An alert fires and ends by turns.
const TWICE: &str = "SELECT count(*) FROM (SELECT alert_step.action, lag(alert_step.action) OVER (PARTITION BY alert ORDER BY alert_step.id) AS before
                         FROM alert_step WHERE action IN ('fire', 'resolve')) AS steps WHERE action = before";

/// `scripts/soak exactness` does it with many more records.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn sixteen_senders_at_four_servers_are_judged_as_by_one() {
    if !cluster::is_there() {
        return;
    }
    const SENDERS: i64 = 16;
    let steps = support::asked("GYROWATCH_SOAK_STEPS", 16) as i64;
    let (expected, url) = (alerts_at_one_server(SENDERS, steps).await, cluster::fresh_database().await);
    let servers = [server_on(&url).await, server_on(&url).await, server_on(&url).await, server_on(&url).await];
    sent_by_all(&servers, SENDERS, steps, true).await;
    is_as_at_one_server(&url, &expected, SENDERS).await;
}

/// The same with servers that are killed in the middle of it.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_killed_servers_had_begun_is_judged_as_by_one_that_lives() {
    if !cluster::is_there() {
        return;
    }
    const SENDERS: i64 = 8;
    let steps = support::asked("GYROWATCH_SOAK_STEPS", 16) as i64;
    let (expected, url) = (alerts_at_one_server(SENDERS, steps).await, cluster::fresh_database().await);
    let mut servers = [server_on(&url).await, server_on(&url).await, server_on(&url).await];
    let kills = sent_by_all_through_kills(&mut servers, SENDERS, steps).await;
    println!("{kills} kills");
    assert!(kills > 1, "it was over before a second server was killed");
    is_as_at_one_server(&url, &expected, SENDERS).await;
}

async fn alerts_at_one_server(senders: i64, steps: i64) -> Steps {
    let alone = cluster::fresh_database().await;
    sent_by_all(&[server_on(&alone).await], senders, steps, false).await;
    command::verified(&alone);
    steps_of(&alone).await
}

async fn is_as_at_one_server(url: &str, expected: &Steps, senders: i64) {
    command::verified(url);
    let found = steps_of(url).await;
    assert!(expected.len() as i64 > senders / 2, "{expected:?}");
    let differing: Vec<_> =
        expected.keys().chain(found.keys()).filter(|key| expected.get(*key) != found.get(*key)).collect();
    assert!(
        differing.is_empty(),
        "{:?}",
        differing.iter().map(|key| (key, expected.get(*key), found.get(*key))).collect::<Vec<_>>()
    );
    // What all share is judged in the order in which it came, whatever that was.
    assert_eq!(count(url, TWICE).await, 0);
    let of_all = count(url, "SELECT count(*) FROM history JOIN gyro ON gyro.id = gyro WHERE serial = 'SHARED'").await;
    assert!(of_all > 50 * senders / 16, "{of_all}");
}

/// The same where a transaction reads its cells without locking them: what the check above would miss, this one shows.
/// Whether two transactions meet where it matters is chance.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn without_locks_the_check_fails() {
    if !cluster::is_there() {
        return;
    }
    for _ in 0..6 {
        if goes_wrong_without_locks().await {
            return;
        }
    }
    panic!("everything is as with locks");
}

async fn goes_wrong_without_locks() -> bool {
    let url = cluster::fresh_database().await;
    let between = Proxy::before(&url).await;
    let through = between.url(&url);
    let servers = [server_on(&through).await, server_on(&through).await];
    between.takes_locks_away();
    let sent = AssertUnwindSafe(sent_by_all(&servers, 8, 12, true)).catch_unwind().await;
    let whole = command::on(&url).arg("verify").output().unwrap().status.success();
    sent.is_err() || !whole || count(&url, TWICE).await > 0
}
