//! What is queued arrives: every message, in order per alert, whatever becomes of the service or of other targets.

use std::sync::atomic::Ordering;

use crate::prelude::*;
use crate::queue::Queue;
use crate::receiver::Told;
use crate::support::{NEVER_LATE, asked, free_port};
use crate::{lab, receiver};
use axum::http::StatusCode;
use axum::response::IntoResponse;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// For what takes a moment, on a machine that is twenty times as slow as usual.
const PATIENCE: Duration = Duration::from_secs(120);

const SHORT: (&str, &str) = ("GYROWATCH_HOOKS__RETRY_WAITS_S", "0.1,0.1,0.1,0.1,0.1,0.1,0.1,0.1,0.1,0.1,0.1,0.1,0.1");

/// Waits until no delivery of the hooks is open.
async fn all_told(server: &Server, hooks: &[Value]) {
    for hook in hooks {
        assert_eq!(server.all_told(hook).await["dead"], 0, "{hook}");
    }
}

/// Every step of the queue came, and none after a later one of the same alert: repetitions follow at once.
#[track_caller]
fn came_whole_and_in_order(queue: Queue, told: &[Told]) {
    let mut reached: BTreeMap<i64, i64> = BTreeMap::new();
    let mut seen = BTreeSet::new();
    for (alert, step) in told.iter().filter_map(|told| queue.place(&told.id())) {
        let last = reached.insert(alert, step).unwrap_or(0);
        assert!(step == last || step == last + 1, "alert {alert}: step {step} came after {last}");
        seen.insert((alert, step));
    }
    let all: BTreeSet<_> = (0..queue.alerts).flat_map(|a| (0..queue.steps).map(move |s| (a, s))).collect();
    assert_eq!(seen, all);
}

#[tokio::test]
async fn every_step_of_every_alert_comes_in_order_while_the_target_fails_now_and_then() {
    let queue = Queue { alerts: 12, steps: 8 };
    let target = Receiver::answering(|earlier, _| match earlier % 5 {
        3 => StatusCode::SERVICE_UNAVAILABLE.into_response(),
        4 => StatusCode::BAD_REQUEST.into_response(),
        _ => ().into_response(),
    })
    .await;
    let mut server = Server::start_with(&[SHORT]).await;
    let hooks = [server.sets_up(json!({ "kind": "standard-webhooks", "url": target.url() })).await];
    server.terminate();
    queue.fill(server.dir(), &hooks).await;
    server.restart();
    all_told(&server, &hooks).await;
    came_whole_and_in_order(queue, &target.told());
    let taken = (0..target.told().len()).filter(|earlier| earlier % 5 < 3).count();
    assert_eq!(taken, queue_size(queue), "what was taken is not sent again");
    let verifier = standardwebhooks::Webhook::new(hooks[0]["secret"].as_str().unwrap()).unwrap();
    assert!(target.told().iter().all(|told| verifier.verify(&told.body, &told.headers).is_ok()));
}

/// `scripts/soak kill-deliveries` kills 200 times.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn nothing_is_lost_invented_or_overtaken_when_the_service_is_killed_while_it_takes_records_and_delivers() {
    let kills = asked("GYROWATCH_SOAK_KILLS", 8);
    let queue = Queue { alerts: 20 + kills as i64 * 2, steps: 6 };
    // Slow enough that a kill finds deliveries under way.
    let target = Receiver::answering(|earlier, _| {
        std::thread::sleep(Duration::from_millis(2));
        if earlier % 11 == 7 { StatusCode::BAD_GATEWAY.into_response() } else { ().into_response() }
    })
    .await;
    let mut server = Server::start_with(&[SHORT, NEVER_LATE, ("GYROWATCH_HOOKS__ATTEMPTS_AT_ONCE", "4")]).await;
    let kinds = ["standard-webhooks", "cloudevents"];
    let mut hooks = Vec::new();
    for kind in kinds {
        let url = format!("http://{}/{kind}", target.address);
        hooks.push(server.sets_up(json!({ "kind": kind, "url": url, "batch": false })).await);
    }
    server.terminate();
    queue.fill(server.dir(), &hooks).await;
    server.restart();

    let mut chance = ChaCha8Rng::seed_from_u64(20_260_301);
    let mut station = Station { acknowledged: 0, chance: ChaCha8Rng::seed_from_u64(7) };
    let mut killed = 0;
    // On a slow machine a life may be too short for records that cause anything.
    while killed < kills || station.acknowledged < ENOUGH {
        let posting = tokio::spawn(station.posts_until_nobody_answers(server.url("/v1/records")));
        tokio::time::sleep(Duration::from_micros(chance.random_range(3_000..120_000))).await;
        server.kill();
        killed += 1;
        station = posting.await.unwrap();
        server.restart();
    }
    all_told(&server, &hooks).await;

    let (told, steps) = (target.told(), steps_of_records(&server, queue).await);
    for kind in kinds {
        let of_kind: Vec<Told> = told.iter().filter(|told| told.path == format!("/{kind}")).cloned().collect();
        came_whole_and_in_order(queue, &of_kind);
        came_as_stored(&steps, &of_kind, queue);
    }
    let stored = server.holdings().await.into_iter().find(|(table, _)| table == "record").unwrap().1;
    assert!((station.acknowledged..=station.acknowledged + 1).contains(&stored), "{stored} records are stored");
    let messages = (queue_size(queue) + steps.values().map(Vec::len).sum::<usize>()) * kinds.len();
    println!("{killed} kills, {} records, {messages} messages, {} requests", station.acknowledged, told.len());
}

/// Records after which several of the station's gyros have jumped.
const ENOUGH: i64 = 40;

/// Posts records of four gyros whose D_I jumps now and then; what was not acknowledged is posted again.
struct Station {
    acknowledged: i64,
    chance: ChaCha8Rng,
}

impl Station {
    async fn posts_until_nobody_answers(mut self, url: String) -> Self {
        let http = gyrowatch::system::http_client(Duration::from_secs(5), Duration::from_secs(20)).build().unwrap();
        loop {
            let (serial, at) = (format!("P-{}", self.acknowledged % 4), lab::day(self.acknowledged / 4));
            // The same figures whenever the same record is posted.
            let mut figures = ChaCha8Rng::seed_from_u64(self.acknowledged as u64);
            let d_i = if figures.random_bool(0.3) { 1.05 } else { 1.0 };
            let record = lab::record(&format!("IMU-{serial}"), &at, &[("G1", &serial, d_i, 2.0)]);
            let Ok(answer) = http.post(&url).json(&record).send().await else { return self };
            let status = answer.status().as_u16();
            assert!(matches!(status, 200 | 201), "{status}: {}", answer.text().await.unwrap_or_default());
            self.acknowledged += 1;
            tokio::time::sleep(Duration::from_millis(self.chance.random_range(0..10))).await;
        }
    }
}

/// What records have caused to be told, by alert, in the order in which it was stored.
async fn steps_of_records(server: &Server, queue: Queue) -> BTreeMap<i64, Vec<String>> {
    let mut database = behind::read(&server.database()).await;
    let sql = "SELECT id, alert FROM alert_step WHERE told = 1 AND alert > $1 ORDER BY id";
    let rows: Vec<(i64, i64)> = sqlx::query_as(sql).bind(queue.alerts).fetch_all(&mut database).await.unwrap();
    let mut steps: BTreeMap<i64, Vec<String>> = BTreeMap::new();
    for (id, alert) in rows {
        steps.entry(alert).or_default().push(format!("evt_{}", gyrowatch::core::id::Id(id)));
    }
    assert!(steps.len() > 4, "records have caused alerts: {steps:?}");
    steps
}

/// What came of each alert is what was stored of it, in its order; only the same message again may follow a message.
#[track_caller]
fn came_as_stored(steps: &BTreeMap<i64, Vec<String>>, told: &[Told], queue: Queue) {
    let alert_of: BTreeMap<&String, i64> =
        steps.iter().flat_map(|(alert, ids)| ids.iter().map(|id| (id, *alert))).collect();
    let mut came: BTreeMap<i64, Vec<String>> = BTreeMap::new();
    for id in told.iter().map(Told::id).filter(|id| queue.place(id).is_none()) {
        let alert = alert_of.get(&id).unwrap_or_else(|| panic!("{id} was told and is not stored"));
        came.entry(*alert).or_default().push(id);
    }
    came.values_mut().for_each(Vec::dedup);
    assert_eq!(&came, steps);
}

fn queue_size(queue: Queue) -> usize {
    (queue.alerts * queue.steps) as usize
}

/// `scripts/soak slow-target` queues 10,000.
#[tokio::test]
async fn a_target_that_hangs_holds_up_no_other() {
    let messages = asked("GYROWATCH_SOAK_DELIVERIES", 600);
    let queue = Queue { alerts: (messages / 20 / 5) as i64, steps: 5 };
    let target = Receiver::start().await;
    let mut server = Server::start().await;
    let hanging =
        server.sets_up(json!({ "kind": "cloudevents", "url": format!("http://{}/", receiver::hangs().await) }));
    let hanging = hanging.await;
    let mut hooks = Vec::new();
    for i in 1..20 {
        let url = format!("http://{}/{i}", target.address);
        hooks.push(server.sets_up(json!({ "kind": "standard-webhooks", "url": url })).await);
    }
    server.terminate();
    let all: Vec<Value> = hooks.iter().chain([&hanging]).cloned().collect();
    queue.fill(server.dir(), &all).await;
    let others = queue_size(queue) * hooks.len();

    let started = Instant::now();
    server.restart();
    while target.told().len() < others {
        assert!(started.elapsed() < PATIENCE, "{} of {others}", target.told().len());
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let took = started.elapsed();
    all_told(&server, &hooks).await;
    assert_eq!(target.told().len(), others, "each was sent once");
    for i in 1..20 {
        let of_hook: Vec<Told> = target.told().into_iter().filter(|told| told.path == format!("/{i}")).collect();
        came_whole_and_in_order(queue, &of_hook);
    }
    let path = format!("/v1/hooks/{}", hanging["id"].as_str().unwrap());
    assert_eq!(server.get(&path).await.json()["queue"]["open"], queue_size(queue));
    let rate = others as f64 / took.as_secs_f64();
    println!("{others} deliveries to 19 targets in {:.2} s beside one that hangs: {rate:.0}/s", took.as_secs_f64());
    let least = asked("GYROWATCH_SOAK_RATE", 50) as f64;
    assert!(rate >= least, "{rate:.0}/s, at least {least}/s are asked for");
}

#[tokio::test]
async fn a_target_that_comes_back_is_told_all_that_waits_at_once() {
    let queue = Queue { alerts: 40, steps: 2 };
    let mut server = Server::start_with(&[("GYROWATCH_HOOKS__RETRY_WAITS_S", "0.3,3600,3600")]).await;
    let (target, up) = Receiver::switched(false, StatusCode::BAD_GATEWAY).await;
    let hooks = [server.sets_up(json!({ "kind": "cloudevents", "url": target.url() })).await];
    server.terminate();
    queue.fill(server.dir(), &hooks).await;
    server.restart();
    target.has_been_told(4).await;
    tokio::time::sleep(Duration::from_secs(2)).await;
    let asked = target.told().len();
    assert!(asked < 24, "a target that is down is asked now and then, not {asked} times");
    up.store(true, Ordering::SeqCst);
    let back = Instant::now();
    all_told(&server, &hooks).await;
    assert!(back.elapsed() < Duration::from_secs(5), "{:?}: the ladder's next rung was an hour away", back.elapsed());
}

#[tokio::test]
async fn what_waits_for_an_alertmanager_is_told_when_what_fires_finds_it_back() {
    let server = Server::start_with(&[
        ("GYROWATCH_HOOKS__RETRY_WAITS_S", "0.2,3600,3600"),
        ("GYROWATCH_HOOKS__RESEND_S", "0.5"),
        NEVER_LATE,
    ])
    .await;
    let (target, up) = Receiver::switched(true, StatusCode::BAD_GATEWAY).await;
    let hook = json!({ "kind": "alertmanager", "url": target.url(), "filter": { "rules": ["step"] } });
    let hooks = [server.sets_up(hook).await];
    for (at, d_i) in [(0, 1.0), (40, 1.0), (80, 1.03)] {
        let record = lab::record("IMU-1", &lab::day(at), &[("G1", "LFG-0101", d_i, 2.0)]);
        assert_eq!(server.post_json("/v1/records", &record).await.status, 201);
    }
    all_told(&server, &hooks).await;
    up.store(false, Ordering::SeqCst);
    let id = hooks[0]["id"].as_str().unwrap();
    let waiting = server.call("POST", &format!("/v1/hooks/{id}/test"), &[], "").await.json();
    let path = format!("/v1/deliveries/{}", waiting["id"].as_str().unwrap());
    let patience = Instant::now() + PATIENCE;
    // Its next rung is an hour away, and the target is known to be down.
    while server.get(&path).await.json()["attempts"].as_array().unwrap().len() < 2 {
        assert!(Instant::now() < patience, "{}", server.log());
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let asked = target.told().len();
    target.has_been_told(asked + 2).await;
    up.store(true, Ordering::SeqCst);
    all_told(&server, &hooks).await;
    assert_eq!(server.get(&path).await.json()["state"], "delivered");
}

/// Debian's Alertmanager, or any on the PATH; killed at the end.
struct Alertmanager {
    _child: Running,
    url: String,
    http: reqwest::Client,
    _dir: tempfile::TempDir,
}

/// As an installation has them.
fn inhibit_rules() -> String {
    let file = root().join("config/prometheus/alertmanager.yml");
    let text = std::fs::read_to_string(file).unwrap();
    text[text.find("inhibit_rules:").unwrap()..].to_owned()
}

impl Alertmanager {
    /// None where no such program is installed.
    async fn start(tells: &Receiver) -> Option<Self> {
        let program = ["prometheus-alertmanager", "alertmanager"]
            .into_iter()
            .find(|program| Command::new(program).arg("--version").output().is_ok());
        let Some(program) = program else {
            assert_ne!(std::env::var("GYROWATCH_TEST_PROGRAMS").as_deref(), Ok("required"), "no Alertmanager");
            println!("passed over: no Alertmanager is installed");
            return None;
        };
        let dir = tempfile::tempdir().unwrap();
        let config = format!(
            "route: {{ receiver: recorder, group_by: [serial], group_wait: 0s, group_interval: 1s }}\n\
             receivers: [{{ name: recorder, webhook_configs: [{{ url: 'http://{}/' }}] }}]\n{}",
            tells.address,
            inhibit_rules()
        );
        std::fs::write(dir.path().join("config.yml"), config).unwrap();
        let port = free_port();
        let child = Command::new(program)
            .current_dir(dir.path())
            .args(["--config.file=config.yml", "--storage.path=data", "--cluster.listen-address="])
            .arg(format!("--web.listen-address=127.0.0.1:{port}"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let http = gyrowatch::system::http_client(Duration::from_secs(1), Duration::from_secs(5)).build().unwrap();
        let started = Self { _child: Running(child), url: format!("http://127.0.0.1:{port}"), http, _dir: dir };
        once(async || started.http.get(format!("{}/-/ready", started.url)).send().await, Result::is_ok).await.unwrap();
        Some(started)
    }

    async fn shows(&self) -> Vec<Value> {
        let answer = self.http.get(format!("{}/api/v2/alerts", self.url)).send().await.unwrap();
        answer.json().await.unwrap()
    }

    /// As Prometheus tells it that an alert fires, or does no more.
    async fn is_told(&self, alert: &str, fires: bool) {
        let now = gyrowatch::system::Clock::System.now();
        let end = gyrowatch::wire::time::format(now.plus_days(if fires { 1.0 } else { -1e-5 }));
        let told = json!([{ "labels": { "alertname": alert, "severity": "critical" }, "endsAt": end }]);
        let answer = self.http.post(format!("{}/api/v2/alerts", self.url)).json(&told).send().await.unwrap();
        assert!(answer.status().is_success(), "{answer:?}");
    }

    /// Waits until what it shows is as `wanted`.
    async fn comes_to_show(&self, wanted: impl Fn(&[Value]) -> bool) -> Vec<Value> {
        once(async || self.shows().await, |shown| wanted(shown)).await
    }
}

#[tokio::test]
async fn a_real_alertmanager_receives_shows_and_resolves_an_alert() {
    gyrowatch::system::install_crypto();
    let recorder = Receiver::start().await;
    let Some(alertmanager) = Alertmanager::start(&recorder).await else { return };
    let server = Server::start_with(&[("GYROWATCH_HOOKS__RESEND_S", "0.5"), NEVER_LATE]).await;
    let station_posts = async |at: i64, d_i: f64| {
        let record = lab::record("IMU-1", &lab::day(at), &[("G1", "LFG-0101", d_i, 2.0)]);
        assert_eq!(server.post_json("/v1/records", &record).await.status, 201);
    };
    let hook = json!({ "kind": "alertmanager", "url": alertmanager.url, "filter": { "rules": ["step"] } });
    server.sets_up(hook).await;
    for (at, d_i) in [(0, 1.0), (40, 1.0), (80, 1.03)] {
        station_posts(at, d_i).await;
    }
    let shown = alertmanager.comes_to_show(|shown| shown.len() == 1).await.remove(0);
    let labels = json!({
        "alertname": "GyroStep", "serial": "LFG-0101", "coefficient": "D_I", "rule": "step", "severity": "warning",
    });
    assert_eq!((&shown["labels"], &shown["status"]["state"]), (&labels, &json!("active")));
    assert!(shown["annotations"]["description"].as_str().unwrap().contains("0.03"), "{shown}");
    let first = shown["endsAt"].as_str().unwrap();
    // It would let the alert go after 2 s if it were not sent again.
    tokio::time::sleep(Duration::from_millis(2500)).await;
    let later = alertmanager.comes_to_show(|shown| shown.len() == 1).await.remove(0);
    assert!(later["endsAt"].as_str().unwrap() > first, "{first}: {later:#}");
    assert_eq!(recorder.has_been_told(1).await[0].json()["status"], "firing");

    // One server of several that is down mutes nothing; where none answers nobody knows how gyros stand.
    let of_gyro = |shown: &[Value], state: &str| {
        shown.iter().any(|alert| alert["labels"]["serial"] == "LFG-0101" && alert["status"]["state"] == state)
    };
    alertmanager.is_told("GyrowatchDown", true).await;
    alertmanager.comes_to_show(|shown| shown.len() == 2 && of_gyro(shown, "active")).await;
    alertmanager.is_told("GyrowatchAllDown", true).await;
    alertmanager.comes_to_show(|shown| of_gyro(shown, "suppressed")).await;
    for alert in ["GyrowatchDown", "GyrowatchAllDown"] {
        alertmanager.is_told(alert, false).await;
    }
    alertmanager.comes_to_show(|shown| shown.len() == 1 && of_gyro(shown, "active")).await;

    station_posts(120, 1.03).await;
    let critical = |shown: &[Value]| shown.len() == 1 && shown[0]["labels"]["severity"] == "critical";
    alertmanager.comes_to_show(critical).await;

    station_posts(160, 1.03).await;
    alertmanager.comes_to_show(|shown| shown.is_empty()).await;
    let patience = Instant::now() + PATIENCE;
    while !recorder.told().iter().any(|told| told.json()["status"] == "resolved") {
        assert!(Instant::now() < patience, "its receiver was not told");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert!(alertmanager.shows().await.is_empty(), "what is resolved is not sent again");
}
