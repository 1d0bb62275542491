//! From a record that a station posts to what a hook is told: nothing but HTTP.

use crate::prelude::*;
use crate::receiver::Told;
use crate::support::NEVER_LATE;

/// D_I of the gyro on given days, posted in the order given.
async fn station_posts(server: &Server, serial: &str, history: &[(i64, f64)]) {
    for (at, d_i) in history {
        let imu = format!("IMU-{serial}");
        server.post_json("/v1/records", &record(&imu, &day(*at), &[("G1", serial, *d_i, 2.0)])).await.created();
    }
}

/// A service to which nothing is late: stations measure in 2025.
async fn serving() -> Server {
    Server::start_with(&[NEVER_LATE]).await
}

/// The events that were told, by alert, in the order in which they came.
fn stories(told: &[Told]) -> BTreeMap<String, Vec<String>> {
    let mut stories: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for body in told.iter().map(Told::json) {
        let alert = body["data"]["id"].as_str().unwrap().to_owned();
        stories.entry(alert).or_default().push(body["type"].as_str().unwrap().to_owned());
    }
    stories
}

/// What the history of each alert says was told.
async fn histories(server: &Server) -> BTreeMap<String, Vec<String>> {
    let mut histories = BTreeMap::new();
    for alert in server.get("/v1/alerts").await.json()["alerts"].as_array().unwrap() {
        let id = alert["id"].as_str().unwrap().to_owned();
        let detail = server.get(&format!("/v1/alerts/{id}")).await.json();
        let steps = detail["history"].as_array().unwrap().iter().filter(|step| step["told"] == true);
        let event = |step: &Value| match step["action"].as_str().unwrap() {
            "fire" => "alert.fired",
            "escalate" => "alert.escalated",
            "repeat" => "alert.repeated",
            "resolve" => "alert.resolved",
            other => panic!("{other} was told"),
        };
        histories.insert(id, steps.map(|step| event(step).to_owned()).collect());
    }
    histories
}

/// A level, a jump that a second campaign confirms, and the new level.
const JUMP: [(i64, f64); 6] = [(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.03), (160, 1.03), (200, 1.03)];

#[tokio::test]
async fn the_life_of_every_alert_is_told_to_a_signed_hook_as_its_history_has_it() {
    let (server, target) = (serving().await, Receiver::start().await);
    let hook = server.sets_up(json!({ "kind": "standard-webhooks", "url": target.url(), "batch": false })).await;
    station_posts(&server, "A", &JUMP).await;
    server.all_told(&hook).await;
    let told = target.told();
    let stories = stories(&told);
    assert_eq!(stories, histories(&server).await);
    let is_step = |body: &Value| body["data"]["rule"] == "step" && body["data"]["coefficient"] == "D_I";
    let steps: Vec<Value> = told.iter().map(Told::json).filter(is_step).collect();
    let story: Vec<&str> = steps.iter().map(|body| body["type"].as_str().unwrap()).collect();
    assert_eq!(story, ["alert.fired", "alert.escalated", "alert.resolved"]);
    let first = &steps[0]["data"];
    assert_eq!([&first["serial"], &first["severity"], &first["imu"]], ["A", "warning", "IMU-A"]);
    assert!(first["reason"].as_str().unwrap().contains("0.03"), "{first}");
    let verifier = standardwebhooks::Webhook::new(hook["secret"].as_str().unwrap()).unwrap();
    assert!(told.iter().all(|told| verifier.verify(&told.body, &told.headers).is_ok()));
}

#[tokio::test]
async fn a_hook_hears_only_of_what_its_filter_lets_through() {
    let (server, target) = (serving().await, Receiver::start().await);
    let mut hooks = Vec::new();
    for (path, filter) in [
        ("/all", json!({})),
        ("/step", json!({ "rules": ["step"] })),
        ("/b", json!({ "gyros": ["B"] })),
        ("/critical", json!({ "min_severity": "critical", "rules": ["step"] })),
    ] {
        let url = format!("http://{}{path}", target.address);
        hooks.push(
            server.sets_up(json!({ "kind": "standard-webhooks", "url": url, "filter": filter, "batch": false })).await,
        );
    }
    let off = json!({ "kind": "standard-webhooks", "url": format!("http://{}/off", target.address), "enabled": false });
    server.sets_up(off).await;
    station_posts(&server, "A", &JUMP).await;
    station_posts(&server, "B", &JUMP).await;
    for hook in &hooks {
        server.all_told(hook).await;
    }
    let heard = |path: &str| -> Vec<Value> {
        let of_path = target.told().into_iter().filter(|told| told.path == path);
        of_path.map(|told| told.json()).collect()
    };
    let all = heard("/all");
    let among = |wanted: &dyn Fn(&Value) -> bool| -> Vec<Value> {
        all.iter().filter(|body| wanted(&body["data"])).cloned().collect()
    };
    let same = |mut a: Vec<Value>, mut b: Vec<Value>| {
        a.sort_by_key(Value::to_string);
        b.sort_by_key(Value::to_string);
        assert_eq!(a, b);
    };
    assert!(!heard("/step").is_empty() && heard("/step").len() < all.len());
    same(heard("/step"), among(&|data| data["rule"] == "step"));
    same(heard("/b"), among(&|data| data["serial"] == "B"));
    let critical: Vec<Value> = heard("/critical").iter().map(|body| body["type"].clone()).collect();
    assert_eq!(
        critical.iter().filter(|name| *name == "alert.fired").count(),
        2,
        "that it has become critical: {critical:?}"
    );
    assert_eq!(critical.iter().filter(|name| *name == "alert.resolved").count(), 2, "who heard of it hears of its end");
    assert_eq!(critical.len(), 4);
    assert!(heard("/off").is_empty());
}

/// What a message tells, alert by alert: gyro, coefficient, rule and event, in the order of these words.
fn told_of(body: &Value) -> Vec<String> {
    let text = |alert: &Value, member: &str| alert[member].as_str().unwrap().to_owned();
    let alerts = body["alerts"].as_array().unwrap().iter();
    let mut told: Vec<String> =
        alerts.map(|a| ["serial", "coefficient", "rule", "event"].map(|member| text(a, member)).join(" ")).collect();
    told.sort();
    told
}

#[tokio::test]
async fn all_that_a_record_changes_of_all_its_gyros_is_one_message() {
    let server = serving().await;
    let kinds = ["standard-webhooks", "cloudevents", "alertmanager-webhook", "alertmanager"];
    let target = Receiver::start().await;
    let mut hooks = Vec::new();
    for kind in kinds {
        let url = format!("http://{}/{kind}", target.address);
        let hook = server.sets_up(json!({ "kind": kind, "url": url })).await;
        assert_eq!(hook["batch"], true, "new hooks hear so unless they ask otherwise");
        hooks.push(hook);
    }
    let one_by_one = json!({ "kind": "cloudevents", "url": format!("http://{}/one", target.address), "batch": false });
    hooks.push(server.sets_up(one_by_one).await);
    let post = async |at: i64, a: [f64; 2], b: f64| {
        let gyros = [("G1", "A", a[0], a[1]), ("G2", "B", b, 2.0)];
        assert_eq!(server.post_json("/v1/records", &record("IMU-1", &day(at), &gyros)).await.status, 201);
    };
    for at in [0, 40, 80] {
        post(at, [1.0, 2.0], 1.0).await;
    }
    post(120, [1.05, 2.05], 1.05).await;
    for hook in &hooks {
        server.all_told(hook).await;
    }
    let heard = |path: &str| -> Vec<Value> {
        let of_path = target.told().into_iter().filter(|told| told.path.starts_with(path));
        of_path.map(|told| told.json()).collect()
    };
    let alerts = server.get("/v1/alerts").await.json()["alerts"].as_array().unwrap().len();
    let [whole] = &heard("/standard-webhooks")[..] else { panic!("{:?}", heard("/standard-webhooks")) };
    assert_eq!((&whole["type"], told_of(whole).len()), (&json!("alert.fired"), alerts));
    assert!(alerts >= 6, "{alerts}");
    assert!(told_of(whole).contains(&"A D_I step alert.fired".to_owned()), "{:?}", told_of(whole));
    assert!(told_of(whole).iter().any(|told| told.starts_with("B ")), "{:?}", told_of(whole));
    assert_eq!(whole["data"]["id"], whole["alerts"][0]["id"]);
    let page = format!("{}/gyros/{}", server.url(""), whole["alerts"][0]["serial"].as_str().unwrap());
    assert_eq!(whole["alerts"][0]["links"]["gyro"], page, "without hooks.external_url: the address listened on");
    let [event] = &heard("/cloudevents")[..] else { panic!() };
    assert_eq!(told_of(&event["data"]), told_of(whole));
    let [webhook] = &heard("/alertmanager-webhook")[..] else { panic!() };
    assert_eq!(webhook["alerts"].as_array().unwrap().len(), alerts);
    assert_eq!(heard("/one").len(), alerts, "whoever wants each by itself gets it");

    // A second campaign confirms some, and one gyro recovers: still one message, the gravest first.
    post(160, [1.05, 2.05], 1.0).await;
    server.all_told(&hooks[0]).await;
    let all = heard("/standard-webhooks");
    assert_eq!(all.len(), 2);
    let first = &all[1]["alerts"][0];
    assert_eq!((&all[1]["type"], &first["severity"]), (&json!("alert.escalated"), &json!("critical")));
    let delivery = server.get(&format!("/v1/hooks/{}/deliveries", hooks[0]["id"].as_str().unwrap())).await.json();
    let delivery = &delivery["deliveries"][0];
    assert_eq!((&delivery["event"], &delivery["alert"]), (&all[1]["type"], &first["id"]));
}
