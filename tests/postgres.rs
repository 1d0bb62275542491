//! Servers that share a PostgreSQL: what each stores the others judge by, what one leaves undone another takes over,
//! and nothing is lost or done twice when a server or the database itself is killed.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::cluster::{Cluster, count};
use crate::lab::verdict;
use crate::prelude::*;
use crate::support::{NEVER_LATE, client, file_url};
use crate::{command, receiver};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sqlx::{Connection, PgConnection, Row};

const LEASE: Duration = Duration::from_secs(3);

/// A server on the database; others may be on it too.
async fn server_on(url: &str) -> Server {
    let lease = LEASE.as_secs().to_string();
    Server::start_with(&[("GYROWATCH_DATABASE_URL", url), ("GYROWATCH_DATABASE__LEASE_S", &lease), NEVER_LATE]).await
}

/// Returns once `is_so`.
async fn until<F: Future<Output = bool>>(what: &str, patience: Duration, is_so: impl Fn() -> F) {
    let end = Instant::now() + patience;
    while !is_so().await {
        assert!(Instant::now() < end, "not within {patience:?}: {what}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

/// A station that knows several servers, and goes on asking them in turn until one has taken what it sends.
#[derive(Clone)]
struct Station {
    servers: Vec<String>,
    client: reqwest::Client,
}

impl Station {
    fn of(servers: &[&Server]) -> Self {
        let client = client();
        Self { servers: servers.iter().map(|server| server.url("/v1/records")).collect(), client }
    }

    /// The identifier that the record was stored under. `first` is the server that is asked first.
    async fn sends(&self, record: &Value, first: usize) -> String {
        let end = Instant::now() + Duration::from_secs(60);
        for server in (0..self.servers.len()).cycle().skip(first % self.servers.len()) {
            assert!(Instant::now() < end, "nobody takes {record}");
            match self.client.post(&self.servers[server]).json(record).send().await {
                Ok(answer) if answer.status().is_success() => {
                    let body: Value = answer.json().await.unwrap();
                    return body["id"].as_str().unwrap().to_owned();
                }
                Ok(answer) => assert_eq!(answer.status(), 503, "{}", answer.text().await.unwrap()),
                Err(_) => {}
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        unreachable!("the servers go round for ever")
    }
}

/// An hour of a station's life; a calibration each is years ahead of the present only after thousands.
fn hour(at: i64) -> String {
    jiff::Timestamp::from_second(1_735_732_800 + 3600 * at).unwrap().to_string()
}

/// Stations at work at the same time, each with gyros of its own whose drift jumps now and then.
struct Load {
    stations: usize,
    records_each: i64,
}

impl Load {
    fn records(&self) -> usize {
        self.stations * self.records_each as usize
    }

    /// Sends everything; `each` hears of every record that was acknowledged, and says whether to go on. Returns their
    /// identifiers.
    async fn run(&self, station: &Station, each: impl Fn(usize) -> bool + Send + Sync + 'static) -> Vec<String> {
        let (each, acknowledged) = (Arc::new(each), Arc::new(AtomicUsize::new(0)));
        let mut at_work = tokio::task::JoinSet::new();
        for number in 0..self.stations {
            let (station, each, acknowledged) = (station.clone(), each.clone(), acknowledged.clone());
            let records_each = self.records_each;
            at_work.spawn(async move {
                let mut ids = Vec::new();
                for at in 0..records_each {
                    // Every fourth calibration has jumped by ten times the budget, and the next is back.
                    let d_i = if at % 4 == 3 { 1.1 } else { 1.0 };
                    let serial = format!("LFG-{number}");
                    let record = record(&format!("IMU-{number}"), &hour(at), &[("G1", &serial, d_i, 2.0)]);
                    ids.push(station.sends(&record, number).await);
                    if !each(acknowledged.fetch_add(1, Ordering::SeqCst) + 1) {
                        break;
                    }
                }
                ids
            });
        }
        at_work.join_all().await.into_iter().flatten().collect()
    }
}

#[tokio::test]
async fn what_one_server_stores_the_others_judge_by_and_show() {
    let Some(url) = cluster::database_if_there().await else { return };
    let (one, other) = (server_on(&url).await, server_on(&url).await);
    for at in 0..12 {
        let server = if at % 2 == 0 { &one } else { &other };
        let d_i = 1.0 + 0.02 * at as f64;
        let answer =
            server.post_json("/v1/records", &record("IMU-1", &day(at), &[("G1", "LFG-1", d_i, 2.0)])).await.created();
        if at > 0 {
            let step = verdict(&answer, "LFG-1", "D_I", "step").clone();
            assert_eq!(step["state"], "exceeded", "{step}");
            // From the median of the three before, of which the other server has stored two or one.
            let expected = if at == 1 { 0.02 } else { 0.04 };
            assert!((step["value"].as_f64().unwrap() - expected).abs() < 1e-6, "{step}");
        }
    }
    for server in [&one, &other] {
        until("the gyro is known", Duration::from_secs(3), async || {
            server.get("/v1/gyros/LFG-1/trend?coefficient=D_I").await.status == 200
        })
        .await;
        let trend = server.get("/v1/gyros/LFG-1/trend?coefficient=D_I").await.json();
        assert_eq!(trend["points"].as_array().unwrap().len(), 12);
        assert_eq!(server.get("/readyz").await.status, 200);
    }
    assert_eq!(count(&url, "SELECT count(*) FROM alert WHERE rule = 'step' AND coefficient = 'D_I'").await, 1);
}

#[tokio::test]
async fn a_server_that_writes_nothing_shows_what_another_stores_and_has_it_told_by_whose_duty_that_is() {
    const SOON: Duration = Duration::from_secs(2);
    let Some(url) = cluster::database_if_there().await else { return };
    let on_duty = server_on(&url).await;
    let holder = "SELECT count(*) FROM lease WHERE holder <> 0 AND until > now()";
    until("the leases are taken", LEASE, async || count(&url, holder).await == 2).await;
    let other = server_on(&url).await;
    let told = told_of_steps(&on_duty).await;
    let first = record("IMU-1", &day(0), &[("G1", "LFG-1", 1.0, 2.0)]);
    assert_eq!(on_duty.post_json("/v1/records", &first).await.status, 201);
    until("the gyro is known", SOON, async || other.get("/v1/gyros/LFG-1/trend?coefficient=D_I").await.status == 200)
        .await;
    let jumped = record("IMU-1", &day(1), &[("G1", "LFG-1", 1.1, 2.0)]);
    assert_eq!(other.post_json("/v1/records", &jumped).await.status, 201);
    until("the message is told", SOON, async || !told.told().is_empty()).await;
}

#[tokio::test]
async fn a_record_whose_names_are_new_is_shown_by_another_server_at_once() {
    let Some(url) = cluster::database_if_there().await else { return };
    let (one, other) = (server_on(&url).await, server_on(&url).await);
    for number in 0..12 {
        let sent = record(&format!("IMU-{number}"), &day(0), &[("G1", &format!("LFG-{number}"), 1.0, 2.0)]);
        let stored = one.post_json("/v1/records", &sent).await.created();
        other.get(&format!("/v1/records/{}", stored["id"].as_str().unwrap())).await.has(200);
    }
}

/// A receiver that is told of every step, each in a message of its own.
async fn told_of_steps(server: &Server) -> Receiver {
    let told = Receiver::start().await;
    let hook = json!({"name": "h", "kind": "standard-webhooks", "url": told.url(), "filter": {"rules": ["step"]},
        "batch": false});
    assert_eq!(server.post_json("/v1/hooks", &hook).await.status, 201);
    told
}

/// Four gyros that jump and come back; each record of a gyro goes to another server than the one before.
async fn sent_in_turn(servers: &[&Server]) {
    for at in 0..24 {
        let d_i = if at % 4 == 3 { 1.1 } else { 1.0 };
        for gyro in 0..4 {
            let sent = record(&format!("IMU-{gyro}"), &hour(at), &[("G1", &format!("LFG-{gyro}"), d_i, 2.0)]);
            let server = servers[(at + gyro) as usize % servers.len()];
            assert_eq!(server.post_json("/v1/records", &sent).await.status, 201);
        }
    }
}

/// What became of the alerts of each gyro, in order.
async fn alerts_of(url: &str) -> Vec<(String, i64, String)> {
    let sql = "SELECT gyro.serial, dense_rank() OVER (ORDER BY gyro.serial, alert.id), alert_step.action
               FROM alert_step JOIN alert ON alert.id = alert_step.alert JOIN gyro ON gyro.id = alert.gyro
               ORDER BY 2, alert_step.id";
    let mut connection = PgConnection::connect(url).await.unwrap();
    sqlx::query_as(sql).fetch_all(&mut connection).await.unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn two_servers_raise_the_alerts_that_one_would_and_tell_each_step_once() {
    let Some(alone) = cluster::database_if_there().await else { return };
    sent_in_turn(&[&server_on(&alone).await]).await;

    let url = cluster::fresh_database().await;
    let servers = [server_on(&url).await, server_on(&url).await];
    let told = told_of_steps(&servers[0]).await;
    sent_in_turn(&[&servers[0], &servers[1]]).await;
    let (found, expected) = (alerts_of(&url).await, alerts_of(&alone).await);
    assert!(expected.len() > 24 && found == expected, "{found:?}\n{expected:?}");
    nothing_was_lost_or_invented(&url, &told).await;
    let made = count(&url, "SELECT count(*) FROM delivery").await;
    assert_eq!(told.told().len() as i64, made, "a message was sent twice");
}

#[tokio::test]
async fn a_token_made_at_one_server_opens_the_others_until_it_is_revoked_there() {
    let Some(url) = cluster::database_if_there().await else { return };
    let (one, other) = (server_on(&url).await, server_on(&url).await);
    let made = one.post_json("/v1/tokens", &json!({"name": "lead", "role": "admin"})).await.created();
    let bearer = format!("Bearer {}", made["token"].as_str().unwrap());
    until("the other asks for a token", Duration::from_secs(3), async || other.get("/v1/gyros").await.status == 401)
        .await;
    let asks = async || other.call("GET", "/v1/gyros", &[("authorization", &bearer)], Vec::new()).await;
    asks().await.has(200);

    let path = format!("/v1/tokens/{}", made["id"].as_str().unwrap());
    let revoked = one.call("DELETE", &path, &[("authorization", &bearer)], Vec::new()).await;
    assert!((200..300).contains(&revoked.status), "{}", revoked.text());
    until("it opens nothing any more", Duration::from_secs(3), async || asks().await.status == 401).await;
}

/// A server reads all tokens every second; what another has changed it reads as soon as it sees it.
#[tokio::test]
async fn a_token_that_is_revoked_at_one_server_opens_the_others_for_a_fraction_of_a_second() {
    const PHASES: u32 = 4;
    const MOST: Duration = Duration::from_millis(700);
    let Some(url) = cluster::database_if_there().await else { return };
    let (one, other) = (server_on(&url).await, server_on(&url).await);
    let lead = one.post_json("/v1/tokens", &json!({"name": "lead", "role": "admin"})).await.json();
    let lead = format!("Bearer {}", lead["token"].as_str().unwrap());
    let (begun, mut slowest) = (Instant::now(), Vec::new());
    // A machine that is busy may be late; whoever waits for the second is late at one of four phases, every time.
    for series in 0..4 {
        let mut late = Duration::ZERO;
        for phase in 0..PHASES {
            let wanted = json!({"name": format!("t{series}-{phase}"), "role": "engineer"}).to_string();
            let headers = [("authorization", lead.as_str()), ("content-type", "application/json")];
            let made = one.call("POST", "/v1/tokens", &headers, wanted).await.json();
            let bearer = format!("Bearer {}", made["token"].as_str().unwrap());
            let asks = async || other.call("GET", "/v1/gyros", &[("authorization", &bearer)], Vec::new()).await.status;
            until("the other knows it", Duration::from_secs(3), async || asks().await == 200).await;
            let at = Duration::from_millis(2250) * (series * PHASES + phase + 1);
            tokio::time::sleep_until((begun + at).into()).await;
            let path = format!("/v1/tokens/{}", made["id"].as_str().unwrap());
            let revoked = one.call("DELETE", &path, &[("authorization", &lead)], Vec::new()).await;
            assert!((200..300).contains(&revoked.status), "{}", revoked.text());
            let revoked = Instant::now();
            while asks().await != 401 {
                assert!(revoked.elapsed() < Duration::from_secs(5), "it opens the other for ever");
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
            late = late.max(revoked.elapsed());
        }
        if late < MOST {
            return;
        }
        slowest.push(late);
    }
    panic!("the other took so long to hear of it: {slowest:?}");
}

#[tokio::test]
async fn one_record_sent_160_times_through_two_servers_is_stored_once() {
    let Some(url) = cluster::database_if_there().await else { return };
    let servers = [server_on(&url).await, server_on(&url).await];
    let station = Station::of(&[&servers[0], &servers[1]]);
    let sent = Arc::new(record("IMU-1", &day(0), &[("G1", "LFG-1", 1.0, 2.0)]));
    let mut ids = HashSet::new();
    for _ in 0..10 {
        let mut at_once = tokio::task::JoinSet::new();
        for first in 0..16 {
            let (station, sent) = (station.clone(), sent.clone());
            at_once.spawn(async move { station.sends(&sent, first).await });
        }
        ids.extend(at_once.join_all().await);
    }
    assert_eq!(ids.len(), 1, "{ids:?}");
    assert_eq!(count(&url, "SELECT count(*) FROM record").await, 1);
    let changed = record("IMU-1", &day(0), &[("G1", "LFG-1", 1.5, 2.0)]);
    for server in &servers {
        assert_eq!(server.post_json("/v1/records", &changed).await.status, 409);
    }
}

/// A transaction of nobody's that holds a table until it is closed.
async fn holding(url: &str, table: &'static str) -> PgConnection {
    let mut connection = PgConnection::connect(url).await.unwrap();
    sqlx::raw_sql("BEGIN").execute(&mut connection).await.unwrap();
    sqlx::raw_sql(table).execute(&mut connection).await.unwrap();
    connection
}

/// Which cells a group needs is known by the names that are known: a gyro of which another server's commit tells while
/// the group is made ready is at home in none of them.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_gyro_that_is_heard_of_while_a_group_is_made_ready_is_judged_while_its_own_cell_is_held() {
    let waiting = "SELECT count(*) FROM pg_locks WHERE NOT granted AND relation = CAST('cell_commit' AS regclass)";
    let reading = "SELECT count(*) FROM pg_locks WHERE NOT granted AND relation = CAST('suspect_window' AS regclass)";
    let Some(url) = cluster::database_if_there().await else { return };
    let (one, other) = (server_on(&url).await, server_on(&url).await);
    let sends = async |server: &Server, imu: &str, at: i64, d_i: f64| {
        server.post_json("/v1/records", &record(imu, &day(at), &[("G1", "LFG-1", d_i, 2.0)])).await.created();
    };
    // Of a station that is known the windows are read.
    one.post_json("/v1/records", &record("IMU-0", &day(0), &[("G1", "LFG-0", 1.0, 2.0)])).await.created();
    let commits = holding(&url, "LOCK TABLE cell_commit IN SHARE MODE").await;
    let meanwhile = async {
        until("the first has written all but its end", LEASE, async || count(&url, waiting).await > 0).await;
        let windows = holding(&url, "LOCK TABLE suspect_window IN ACCESS EXCLUSIVE MODE").await;
        let heard_of = async {
            until("the second has chosen its cells", LEASE, async || count(&url, reading).await > 0).await;
            commits.close().await.unwrap();
            let trend = "/v1/gyros/LFG-1/trend?coefficient=D_I";
            until("the gyro is known", LEASE, async || other.get(trend).await.status == 200).await;
            windows.close().await.unwrap();
        };
        tokio::join!(sends(&other, "IMU-2", 40, 1.002), heard_of);
    };
    tokio::join!(sends(&one, "IMU-1", 10, 1.0), meanwhile);
    for at in 2..6 {
        sends(&one, "IMU-1", 10 * at + 5, 1.0 + 0.001 * at as f64 + 0.0005 * (at % 2) as f64).await;
    }
    command::verified(&url);
}

#[tokio::test]
async fn a_record_that_the_database_refuses_takes_no_other_of_its_group_along() {
    let Some(url) = cluster::database_if_there().await else { return };
    let server = server_on(&url).await;
    server.post_json("/v1/records", &record("IMU-0", &day(0), &[("G1", "LFG-0", 1.0, 2.0)])).await;
    // Behind the service's back, so that only the database knows.
    let mut connection = PgConnection::connect(&url).await.unwrap();
    sqlx::raw_sql("ALTER TABLE record ADD CONSTRAINT poisoned CHECK (body NOT LIKE '%POISON%')")
        .execute(&mut connection)
        .await
        .unwrap();
    let lines: Vec<String> = (0..64)
        .map(|number| {
            let imu = if number == 40 { "POISON".to_owned() } else { format!("IMU-{number}") };
            record(&imu, &day(1), &[("G1", &format!("LFG-{number}"), 1.0, 2.0)]).to_string()
        })
        .collect();
    let answer = server.post("/v1/import", "application/x-ndjson", lines.join("\n")).await.text();
    let stored = answer.lines().filter(|line| line.contains("\"id\"")).count();
    assert_eq!(stored, 63, "{answer}");
    assert_eq!(count(&url, "SELECT count(*) FROM record").await, 64);
}

/// What hooks were told, held against what the outbox says: every step once or again, none of an alert after a later
/// one.
async fn nothing_was_lost_or_invented(url: &str, told: &Receiver) {
    let open = "SELECT count(*) FROM delivery WHERE state <> 'delivered'";
    until("every delivery is made", LEASE * 2 + Duration::from_secs(60), async || count(url, open).await == 0).await;
    let steps = "SELECT count(*) FROM alert_step JOIN alert ON alert.id = alert_step.alert
                 WHERE told = 1 AND alert.rule = 'step'";
    let mut connection = PgConnection::connect(url).await.unwrap();
    let deliveries: Vec<(i64, i64)> =
        sqlx::query_as("SELECT step, alert FROM delivery").fetch_all(&mut connection).await.unwrap();
    let (made, steps) = (deliveries.len() as i64, count(url, steps).await);
    assert!(made > 0 && made == steps, "{made} deliveries of {steps} steps");
    let of_id: HashMap<String, (i64, i64)> = deliveries
        .into_iter()
        .map(|(step, alert)| (format!("evt_{}", gyrowatch::core::id::Id(step)), (step, alert)))
        .collect();
    let (mut heard, mut reached) = (HashSet::new(), HashMap::new());
    for id in told.told().iter().map(receiver::Told::id) {
        let (step, alert) = *of_id.get(&id).unwrap_or_else(|| panic!("{id} was invented"));
        let last = reached.insert(alert, step).unwrap_or(step);
        assert!(last <= step, "of alert {alert} step {step} was told after {last}");
        heard.insert(id);
    }
    assert_eq!(heard.len(), of_id.len(), "a message was lost");
}

/// Every acknowledged record is there under its identifier, and none twice.
async fn all_are_there(url: &str, acknowledged: &[String], sent: usize) {
    let mut connection = PgConnection::connect(url).await.unwrap();
    let rows = sqlx::query("SELECT id, imu, calibrated_at FROM record").fetch_all(&mut connection).await.unwrap();
    let stored: HashSet<String> =
        rows.iter().map(|row| gyrowatch::core::id::Id(row.get::<i64, _>("id")).to_string()).collect();
    let keys: HashMap<(i64, i64), usize> = rows.iter().fold(HashMap::new(), |mut keys, row| {
        *keys.entry((row.get("imu"), row.get("calibrated_at"))).or_default() += 1;
        keys
    });
    assert_eq!(rows.len(), sent);
    assert!(keys.values().all(|times| *times == 1));
    assert_eq!(acknowledged.iter().collect::<HashSet<_>>().len(), sent, "two records were given one identifier");
    assert!(acknowledged.iter().all(|id| stored.contains(id)));
    let history = count(url, "SELECT count(*) FROM history").await;
    assert_eq!(history, sent as i64, "one gyro a record");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_server_killed_under_load_loses_nothing_and_another_takes_its_work_over() {
    let Some(url) = cluster::database_if_there().await else { return };
    // The first one holds every lease.
    let mut first = server_on(&url).await;
    let holder = "SELECT count(DISTINCT holder) FROM lease WHERE holder <> 0 AND until > now()";
    until("the leases are taken", LEASE, async || count(&url, holder).await == 1).await;
    let second = server_on(&url).await;
    let told = told_of_steps(&second).await;
    let load = Load { stations: 8, records_each: 24 };
    let station = Station::of(&[&first, &second]);
    let (third, reached) = (load.records() / 3, Arc::new(tokio::sync::Notify::new()));
    let notify = reached.clone();
    let each = move |acknowledged| {
        if acknowledged == third {
            notify.notify_one();
        }
        true
    };
    let kill = async {
        reached.notified().await;
        first.kill();
        Instant::now()
    };
    let (acknowledged, killed) = tokio::join!(load.run(&station, each), kill);
    all_are_there(&url, &acknowledged, load.records()).await;
    nothing_was_lost_or_invented(&url, &told).await;
    let last = told.told().iter().map(|told| told.at).max().unwrap();
    assert!(last > killed, "everything was told before the kill: it proves nothing");
    let mine = "SELECT count(*) FROM lease WHERE until > now()";
    assert_eq!(count(&url, mine).await, 2, "the second server holds every lease");
    println!("taken over; everything told {:?} after the kill", last - killed);
}

/// `scripts/soak pg-kill` kills 100 times.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn servers_killed_at_random_lose_nothing_and_do_nothing_twice() {
    let kills = support::asked("GYROWATCH_SOAK_KILLS", 4);
    let Some(url) = cluster::database_if_there().await else { return };
    let mut servers = [server_on(&url).await, server_on(&url).await];
    let told = told_of_steps(&servers[0]).await;
    let station = Station::of(&[&servers[0], &servers[1]]);
    let over = Arc::new(AtomicBool::new(false));
    let acknowledged_at = Arc::new(Mutex::new(vec![Instant::now()]));
    let (is_over, times) = (over.clone(), acknowledged_at.clone());
    let each = move |_| {
        times.lock().unwrap().push(Instant::now());
        !is_over.load(Ordering::SeqCst)
    };
    let load = Load { stations: 8, records_each: i64::MAX };
    let at_work = tokio::spawn(async move { load.run(&station, each).await });
    let (mut chance, mut slowest) = (ChaCha8Rng::seed_from_u64(20_261_122), Duration::ZERO);
    for _ in 0..kills {
        tokio::time::sleep(Duration::from_millis(chance.random_range(50..1500))).await;
        let victim = &mut servers[chance.random_range(0..2)];
        victim.kill();
        tokio::time::sleep(Duration::from_millis(chance.random_range(0..500))).await;
        let began = Instant::now();
        tokio::task::block_in_place(|| victim.restart());
        slowest = slowest.max(began.elapsed());
    }
    over.store(true, Ordering::SeqCst);
    let acknowledged = at_work.await.unwrap();
    all_are_there(&url, &acknowledged, acknowledged.len()).await;
    nothing_was_lost_or_invented(&url, &told).await;
    let times = acknowledged_at.lock().unwrap().clone();
    let silent = times.windows(2).map(|two| two[1] - two[0]).max().unwrap();
    println!(
        "{kills} kills of two servers: {} acknowledged, 0 lost, none twice; {} messages, {} requests; \
         nothing acknowledged for {} ms at the most; serving again after {} ms at the most",
        acknowledged.len(),
        count(&url, "SELECT count(*) FROM delivery").await,
        told.told().len(),
        silent.as_millis(),
        slowest.as_millis(),
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_database_that_crashes_under_load_loses_nothing_and_servers_go_on_without_a_restart() {
    if !cluster::is_there() {
        return;
    }
    let mut cluster = Cluster::start();
    let url = cluster.fresh_database().await;
    let servers = [server_on(&url).await, server_on(&url).await];
    let told = told_of_steps(&servers[0]).await;
    let load = Load { stations: 8, records_each: 16 };
    let station = Station::of(&[&servers[0], &servers[1]]);
    let reached = Arc::new(AtomicUsize::new(0));
    let counter = reached.clone();
    let each = move |acknowledged| {
        counter.store(acknowledged, Ordering::SeqCst);
        true
    };
    let third = load.records() / 3;
    let crash = async {
        while reached.load(Ordering::SeqCst) < third {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        tokio::task::block_in_place(|| cluster.crash_and_restart(Duration::from_millis(500)));
    };
    let (acknowledged, ()) = tokio::join!(load.run(&station, each), crash);
    all_are_there(&url, &acknowledged, load.records()).await;
    nothing_was_lost_or_invented(&url, &told).await;
    for server in &servers {
        until("it is ready", Duration::from_secs(5), async || server.get("/readyz").await.status == 200).await;
    }
}

/// Campaigns as one import, of IMUs with these numbers.
fn campaigns(numbers: Range<usize>) -> String {
    let campaign = document("practice/campaign-00.json");
    let lines = numbers.map(|number| {
        let mut campaign = campaign.clone();
        campaign["imu"] = json!(format!("IMU-{number}"));
        for (slot, gyro) in campaign["gyros"].as_array_mut().unwrap().iter_mut().enumerate() {
            gyro["serial"] = json!(format!("LFG-{number}-{slot}"));
        }
        campaign.to_string() + "\n"
    });
    lines.collect()
}

/// Diagnoses that a server has made since its start.
async fn made_by(server: &Server) -> usize {
    let metrics = server.get("/metrics").await.text();
    let line = metrics.lines().find(|line| line.starts_with("gyrowatch_diagnoses_total{outcome=\"made\"}"));
    line.map_or(0, |line| line.rsplit(' ').next().unwrap().parse().unwrap())
}

const DIAGNOSED: &str = "SELECT count(*) FROM diagnosis WHERE body IS NOT NULL";

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn servers_share_the_diagnoses_and_make_those_of_one_that_is_killed() {
    const CAMPAIGNS: usize = 24;
    let Some(url) = cluster::database_if_there().await else { return };
    let servers = [server_on(&url).await, server_on(&url).await];
    let answer = servers[0].post("/v1/import", "application/x-ndjson", campaigns(0..CAMPAIGNS)).await;
    assert_eq!(answer.text().matches("\"status\":201").count(), CAMPAIGNS);
    until("all are diagnosed", Duration::from_secs(180), async || count(&url, DIAGNOSED).await == CAMPAIGNS as i64)
        .await;
    let order = json!({"again": true});
    let waiting = "SELECT count(*) FROM diagnosis_task WHERE state = 'waiting'";
    // Once more where one was so fast that it had made all of them before the other had looked.
    for round in 1.. {
        until("none waits", Duration::from_secs(180), async || count(&url, waiting).await == 0).await;
        let made = [made_by(&servers[0]).await, made_by(&servers[1]).await];
        assert_eq!(made.iter().sum::<usize>(), CAMPAIGNS * round, "{made:?}");
        if made.iter().all(|made| *made > 0) {
            break;
        }
        assert!(round < 20, "one makes them all, {round} times: {made:?}");
        assert_eq!(servers[1].post_json("/v1/diagnoses", &order).await.status, 202);
    }

    let [mut first, second] = servers;
    let claimed = "SELECT count(DISTINCT holder) FROM diagnosis_claim WHERE until > now()";
    let patience = Instant::now() + Duration::from_secs(120);
    // Once more where the machine was so fast that everything was done before the kill, which proves nothing.
    loop {
        second.post_json("/v1/diagnoses", &order).await.has(202);
        while count(&url, claimed).await < 2 && count(&url, waiting).await > 0 {}
        first.kill();
        if count(&url, waiting).await > 0 {
            break;
        }
        assert!(Instant::now() < patience, "both are never at work");
        first.restart();
    }
    until("all are diagnosed again", Duration::from_secs(180), async || count(&url, waiting).await == 0).await;
    let failed = "SELECT count(*) FROM diagnosis_task WHERE state <> 'done'";
    assert_eq!(count(&url, failed).await, 0);
    let left = "SELECT count(*) FROM diagnosis_claim WHERE until > now()";
    until("no claim is left", Duration::from_secs(10), async || count(&url, left).await == 0).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_server_has_claimed_stays_its_own_however_long_it_takes() {
    if !cluster::is_there() {
        return;
    }
    // Four one after another of as many at once as there are processors.
    let many = 4 * std::thread::available_parallelism().map_or(2, |n| n.get().max(2));
    let url = cluster::fresh_database().await;
    let server = server_on(&url).await;
    let sent = record("IMU-R", &day(0), &[("G1", "LFG-R", 1.0, 2.0)]);
    let mut connection = PgConnection::connect(&url).await.unwrap();
    let (begun, mut longest, mut brought) = (Instant::now(), Duration::ZERO, 0);
    // Once more where the machine was slow: what comes in then leaves gaps in which diagnoses are made.
    while longest <= LEASE && begun.elapsed() < Duration::from_secs(60) {
        let answer = server.post("/v1/import", "application/x-ndjson", campaigns(brought..brought + many)).await;
        assert_eq!(answer.text().matches("\"status\":201").count(), many);
        brought += many;
        let (mut claimed, mut since) = (Vec::new(), Instant::now());
        while count(&url, DIAGNOSED).await < brought as i64 {
            // A diagnosis gives way to what comes in, so that those that were claimed together take longer than a
            // claim holds.
            assert!(server.post_json("/v1/records", &sent).await.status < 300);
            let sql = "SELECT record, until > now() FROM diagnosis_claim ORDER BY record";
            let found: Vec<(i64, bool)> = sqlx::query_as(sql).fetch_all(&mut connection).await.unwrap();
            assert!(found.iter().all(|(_, holds)| *holds), "a claim has ended under the work");
            if found != claimed {
                (claimed, since) = (found, Instant::now());
            } else if !claimed.is_empty() {
                longest = longest.max(since.elapsed());
            }
            assert!(begun.elapsed() < Duration::from_secs(180), "not all are diagnosed");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }
    assert!(longest > LEASE, "nothing took longer than a claim holds: {longest:?} prove nothing");
    assert_eq!(made_by(&server).await, brought);
}

/// What a service says that ends by itself, with a failure.
fn does_not_start(mut serve: Command) -> String {
    let mut child = serve.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let end = Instant::now() + Duration::from_secs(120);
    while child.try_wait().unwrap().is_none() && Instant::now() < end {
        std::thread::sleep(Duration::from_millis(50));
    }
    // Kills nobody where it has ended.
    child.kill().unwrap();
    let ended = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(ended.status.code().is_some_and(|code| code != 0), "it has started: {said}");
    said
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_said_to_the_database_is_encrypted_and_only_under_the_certificate_asked_for() {
    if !cluster::is_there() {
        return;
    }
    let cluster = Cluster::start();
    cluster.speaks_tls(&support::data_path("tls/one.crt"), &support::data_path("tls/one.key")).await;
    let url = cluster.fresh_database().await;
    let trusting = |name: &str| format!("{url}?sslmode=verify-full&sslrootcert={}", support::data_path(name).display());
    let server = server_on(&trusting("tls/one.crt")).await;
    server.post_json("/v1/records", &record("IMU-1", &day(0), &[("G1", "LFG-1", 1.0, 2.0)])).await.created();
    let open = "SELECT count(*) FROM pg_stat_ssl JOIN pg_stat_activity USING (pid)
                WHERE application_name = 'gyrowatch' AND ssl = ";
    let mut connection = PgConnection::connect(&url).await.unwrap();
    let mut connections = async |encrypted: &str| -> i64 {
        let sql = sqlx::AssertSqlSafe(format!("{open}{encrypted}"));
        sqlx::query_scalar(sql).fetch_one(&mut connection).await.unwrap()
    };
    assert!(connections("true").await > 1);
    assert_eq!(connections("false").await, 0);

    let mut command = gyrowatch();
    command.arg("serve").env("GYROWATCH_LISTEN", "127.0.0.1:0").env("GYROWATCH_DATABASE_URL", trusting("tls/two.crt"));
    let said = tokio::task::block_in_place(|| does_not_start(command));
    assert!(said.contains("certificate"), "{said}");
}

/// A server on a file that holds so many records, of seven IMUs.
async fn a_file_of_seven_imus(records: i64) -> Server {
    let dir = tempfile::tempdir().unwrap();
    let database = file_url(&dir.path().join("gyrowatch.db"));
    let server = Server::start_under(&[], dir, &[("GYROWATCH_DATABASE_URL", &database)]);
    let line = |at: i64| {
        let (imu, serial) = (format!("IMU-{}", at % 7), format!("LFG-{}", at % 7));
        record(&imu, &day(at / 7), &[("G1", &serial, 1.0 + 0.03 * (at % 2) as f64, 2.0)]).to_string()
    };
    let lines: Vec<String> = (0..records).map(line).collect();
    server.post("/v1/import", "application/x-ndjson", lines.join("\n")).await.has(200);
    server
}

#[tokio::test]
async fn a_copy_that_is_killed_goes_on_and_is_the_same_in_the_end() {
    if !cluster::is_there() {
        return;
    }
    let mut file = a_file_of_seven_imus(3_000).await;
    let trend = "/v1/gyros/LFG-3/trend?coefficient=D_I&limit=1000";
    let expected = file.get(trend).await.json()["points"].clone();
    let url = cluster::fresh_database().await;
    let from = format!("sqlite://{}", file.dir().join("gyrowatch.db").display());
    let copy = || {
        let mut command = gyrowatch();
        command.args(["copy", "--from", &from, "--to", &url]);
        command
    };
    let served = copy().output().unwrap();
    assert!(!served.status.success(), "a file that is served was copied");
    assert!(file.terminate().0.success());

    let mut killed = copy().spawn().unwrap();
    let mut connection = PgConnection::connect(&url).await.unwrap();
    let patience = Instant::now() + Duration::from_secs(120);
    loop {
        // The table is not there at first.
        let rows = sqlx::query_scalar("SELECT count(*) FROM record").fetch_one(&mut connection).await;
        if rows.is_ok_and(|rows: i64| rows > 0) {
            break;
        }
        assert!(Instant::now() < patience && killed.try_wait().unwrap().is_none(), "nothing to interrupt");
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    let mut early = gyrowatch();
    early.args(["serve"]).env("GYROWATCH_DATABASE_URL", &url).env("GYROWATCH_LISTEN", "127.0.0.1:0");
    let said = does_not_start(early);
    assert!(said.contains("gyrowatch copy"), "{said}");
    let (code, _, said) = command::ended(command::on(&url).arg("verify"));
    assert!(code == 1 && said.contains("gyrowatch copy"), "{said}");

    let done = copy().output().unwrap();
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(done.status.success(), "{said}{}", String::from_utf8_lossy(&done.stderr));
    assert!(said.contains("row counts and checksums match") && !said.contains("DIFFERENT"), "{said}");
    assert!(!copy().output().unwrap().status.success(), "a database with data in it was copied into");

    let server = server_on(&url).await;
    assert_eq!(server.get(trend).await.json()["points"], expected);
    let next = record("IMU-3", &day(500), &[("G1", "LFG-3", 1.0, 2.0)]);
    assert_eq!(server.post_json("/v1/records", &next).await.status, 201);
    drop(server);
    command::verified(&url);
    let refused = command::on(&url).args(["backup", "x.db"]).output().unwrap();
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && said.contains("pg_dump"), "{said}");
}

/// What a database holds, table by table, but for what is random or a time.
async fn holdings(url: &str) -> Vec<(String, Vec<String>)> {
    let mut connection = PgConnection::connect(url).await.unwrap();
    let tables = "SELECT table_name FROM information_schema.tables
                  WHERE table_schema = current_schema() AND table_type = 'BASE TABLE' ORDER BY table_name";
    let tables: Vec<String> = sqlx::query_scalar(tables).fetch_all(&mut connection).await.unwrap();
    let passing = "stamp,names,settings,outbox,models,diagnoses,access,until,installed_on,execution_time";
    let mut all = Vec::new();
    for table in tables {
        let rows = format!("SELECT (to_jsonb(of_it) - '{{{passing}}}'::TEXT[])::TEXT FROM {table} AS of_it ORDER BY 1");
        let rows = sqlx::query_scalar(sqlx::AssertSqlSafe(rows)).fetch_all(&mut connection).await.unwrap();
        all.push((table, rows));
    }
    all
}

#[tokio::test]
async fn a_copy_into_a_database_that_a_server_has_opened_is_as_one_into_a_new_one() {
    if !cluster::is_there() {
        return;
    }
    let mut file = a_file_of_seven_imus(70).await;
    let seen = async |server: &Server| {
        let mut all = Vec::new();
        for path in ["/v1/gyros?limit=100", "/v1/gyros?q=lfg-3", "/v1/gyros?station=ST-1", "/v1/imus"] {
            all.push(server.get(path).await.json());
        }
        let metrics = server.get("/metrics").await.text();
        let fleet = metrics.lines().filter(|line| line.starts_with("gyrowatch_gyros"));
        all.push(json!(fleet.collect::<std::collections::BTreeSet<_>>()));
        all
    };
    let expected = seen(&file).await;
    assert_eq!(expected[0]["gyros"].as_array().map(Vec::len), Some(7));
    let from = format!("sqlite://{}", file.dir().join("gyrowatch.db").display());
    assert!(file.terminate().0.success());

    let (new, opened) = (cluster::fresh_database().await, cluster::fresh_database().await);
    let mut before = server_on(&opened).await;
    assert!(before.terminate().0.success());
    for url in [&new, &opened] {
        let (code, _, said) = command::ended(gyrowatch().args(["copy", "--from", &from, "--to", url]));
        assert_eq!(code, 0, "{said}");
    }
    let (one, other) = (holdings(&new).await, holdings(&opened).await);
    for (one, other) in one.iter().zip(&other) {
        assert_eq!(one, other);
    }
    assert_eq!(one.len(), other.len());
    // Before anybody has opened it, and after.
    command::verified(&opened);
    let server = server_on(&opened).await;
    assert_eq!(seen(&server).await, expected);
    drop(server);
    let said = command::verified(&opened);
    assert!(said.contains("7 gyros"), "{said}");
}
