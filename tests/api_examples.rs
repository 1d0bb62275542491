//! Examples in the description of the API: what the service answers in one scenario. They are kept in
//! `src/http/examples.json`, which `GYROWATCH_WRITE_EXAMPLES=1 cargo test --test all api_examples::` writes anew.

use crate::lab::{Answer, JSON, NDJSON};
use crate::prelude::*;
use gyrowatch::telemetry;
use reqwest::Method;
use reqwest::header::CONTENT_TYPE;
use serde_json::Map;

const FILE: &str = "src/http/examples.json";
const PROBLEM: &str = "application/problem+json";
const CSV: &str = "text/csv";
/// Identifiers and names of what is not there.
const UNKNOWN: [(&str, &str); 4] =
    [("{id}", "0000000000000"), ("{serial}", "LFG-9999"), ("{imu}", "IMU-9999"), ("{name}", "ST-99")];

/// What was sent and answered, by operation, then `request` or a status, then media type.
type Kept = BTreeMap<String, BTreeMap<String, BTreeMap<String, Value>>>;

/// An operation as it is described.
#[derive(Clone)]
struct Described {
    id: String,
    method: Method,
    path: String,
    whole: Value,
}

/// Calls the service and keeps what it answers.
struct Scenario {
    lab: Lab,
    operations: Vec<Described>,
    token: String,
    kept: Kept,
}

/// What is sent: media type and text.
type Body<'a> = Option<(&'a str, String)>;

fn sent(body: &Value) -> Body<'static> {
    Some((JSON, body.to_string()))
}

impl Scenario {
    async fn begin() -> Self {
        let lab = Lab::with(|config| config.access.failures_per_minute = 1_000_000).await;
        let document = lab.get("/openapi.json").await.ok();
        Self { operations: described(&document), lab, token: String::new(), kept: Kept::new() }
    }

    fn operation(&self, id: &str) -> &Described {
        self.operations.iter().find(|operation| operation.id == id).unwrap_or_else(|| panic!("no operation {id}"))
    }

    /// Calls an operation as administrator; `path` takes the places of its parameters and may go on with a query.
    async fn call(&mut self, id: &str, path: &str, body: Body<'_>) -> Answer {
        let headers = [("authorization", format!("Bearer {}", self.token))];
        let answer = self.send(id, path, &body, &headers).await;
        self.keep(id, &body, &answer);
        answer
    }

    async fn send(&self, id: &str, path: &str, body: &Body<'_>, headers: &[(&str, String)]) -> Answer {
        let mut request = self.lab.request(self.operation(id).method.clone(), path);
        for (name, value) in headers.iter().filter(|(_, value)| !value.ends_with(' ')) {
            request = request.header(*name, value);
        }
        if let Some((media_type, text)) = body {
            request = request.header(CONTENT_TYPE, *media_type).body(text.clone());
            // Whoever is refused while it sends is cut off; the next request needs a connection of its own.
            if text.len() > 1 << 20 {
                request = request.header("connection", "close");
            }
        }
        Answer::of(request).await
    }

    /// The first of its kind, and what was sent for it where it was taken.
    fn keep(&mut self, id: &str, body: &Body<'_>, answer: &Answer) {
        let status = answer.status.to_string();
        let described = &self.operation(id).whole["responses"];
        assert!(described.get(&status).is_some(), "{id}: {status} is not described: {}", answer.text);
        let of_operation = self.kept.entry(id.to_owned()).or_default();
        if let Some((media_type, text)) = body
            && answer.status < 300
        {
            let example = if *media_type == JSON { serde_json::from_str(text).unwrap() } else { json!(text) };
            of_operation.entry("request".into()).or_default().entry((*media_type).to_owned()).or_insert(example);
        }
        let media_type = answer.header("content-type").split(';').next().unwrap().to_owned();
        if !answer.text.is_empty() && !media_type.is_empty() {
            let example = match &*media_type {
                JSON | PROBLEM => shortened(answer.json()),
                NDJSON => answer.lines()[0].clone(),
                _ => json!(beginning(&answer.text)),
            };
            of_operation.entry(status).or_default().entry(media_type).or_insert(example);
        } else {
            of_operation.entry(status).or_default();
        }
    }

    fn has(&self, id: &str, status: &str) -> bool {
        self.kept.get(id).is_some_and(|kept| kept.contains_key(status))
    }
}

fn described(document: &Value) -> Vec<Described> {
    let paths = document["paths"].as_object().unwrap();
    let of_path = |(path, item): (&String, &Value)| {
        let operation = |(method, whole): (&String, &Value)| Described {
            id: whole["operationId"].as_str().unwrap().to_owned(),
            method: method.to_uppercase().parse().unwrap(),
            path: path.clone(),
            whole: whole.clone(),
        };
        item.as_object().unwrap().iter().map(operation).collect::<Vec<_>>()
    };
    paths.iter().flat_map(of_path).collect()
}

/// Long lists of objects, and long matrices, to their first two.
fn shortened(value: Value) -> Value {
    match value {
        Value::Array(items) => {
            let long = items.len() > 3 && items.iter().all(|item| item.is_object() || item.is_array());
            let most = if long { 2 } else { items.len() };
            items.into_iter().take(most).map(shortened).collect()
        }
        Value::Object(members) => members.into_iter().map(|(name, member)| (name, shortened(member))).collect(),
        other => other,
    }
}

/// The first three lines; of metrics, which are in no order, how many gyros are unconfirmed.
fn beginning(text: &str) -> String {
    let metric = ["# HELP gyrowatch_gyros ", "# TYPE gyrowatch_gyros ", "gyrowatch_gyros{status=\"unconfirmed\"}"];
    let is_of_it = |line: &&str| metric.iter().any(|of_it| line.starts_with(of_it));
    let of_metric: Vec<&str> = text.lines().filter(is_of_it).collect();
    let lines = if of_metric.is_empty() { text.lines().take(3).collect() } else { of_metric };
    lines.into_iter().map(|line| format!("{line}\n")).collect()
}

fn id(answer: &Value) -> String {
    answer["id"].as_str().unwrap_or_else(|| panic!("no identifier: {answer}")).to_owned()
}

/// The paper's record in a month of 2026; from the fifth on a gyro has changed.
fn record(month: usize) -> Value {
    let mut record = document("paper.json");
    record["calibrated_at"] = format!("2026-{month:02}-01T08:00:00Z").into();
    if month > 4 {
        record["gyros"][0]["g_pulse_per_s_g0"][0] = 2.4710.into();
    }
    record
}

/// A practice campaign with the slow half of its rates left out.
fn campaign(name: &str, day: usize) -> Value {
    let mut campaign = document(&format!("practice/{name}.json"));
    campaign["measured_at"] = format!("2026-03-{day:02}T08:00:00Z").into();
    let fast = |dwell: &Value| {
        let rates = dwell["rate_arcsec_s"].as_array().unwrap();
        dwell["phase"] == "static" || rates.iter().any(|rate| rate.as_f64().unwrap().abs() > 3000.0)
    };
    campaign["dwells"].as_array_mut().unwrap().retain(fast);
    campaign
}

/// Everything that is answered with what was asked for.
async fn what_is_taken(s: &mut Scenario) {
    let said = json!({ "author": "B. Li", "reason": "the table was not level" });
    let signed = json!({ "by": "B. Li", "reason": "the table was not level" });
    s.call("healthz", "/healthz", None).await;
    s.call("readyz", "/readyz", None).await;

    let token =
        json!({ "name": "station 2", "role": "station", "station": "ST-2", "expires_at": "2027-06-30T00:00:00Z" });
    let made = s.call("post_token", "/v1/tokens", sent(&token)).await.created();
    s.call("get_tokens", "/v1/tokens", None).await.ok();
    s.call("delete_token", &format!("/v1/tokens/{}", id(&made)), None).await;

    let mut records = Vec::new();
    for month in 1..=6 {
        records.push(id(&s.call("post_record", "/v1/records", sent(&record(month))).await.created()));
    }
    s.call("post_record", "/v1/records", sent(&record(1))).await.ok();
    let mut other = record(1);
    other["gyros"][0]["g_pulse_per_s_g0"][1] = 6.0.into();
    s.call("post_record", "/v1/records", sent(&other)).await.refused(409);
    let bench = json!({ "serial": "LFG-0101", "station": "BENCH-1", "measured_at": "2026-03-02T08:00:00Z",
        "method": "torque_feedback", "d_i_deg_per_h_g0": 2.95, "d_s_deg_per_h_g0": 4.62 });
    let stored = id(&s.call("post_bench_result", "/v1/bench-results", sent(&bench)).await.created());
    s.call("post_bench_result", "/v1/bench-results", sent(&bench)).await.ok();
    let mut other = bench.clone();
    other["d_i_deg_per_h_g0"] = 2.96.into();
    s.call("post_bench_result", "/v1/bench-results", sent(&other)).await.refused(409);
    s.call("get_bench_result", &format!("/v1/bench-results/{stored}"), None).await.ok();
    s.call("get_agreement", "/v1/gyros/LFG-0101/agreement", None).await.ok();
    let lines = data("paper-bench.ndjson");
    let two: String = lines.lines().take(2).map(|line| format!("{line}\n")).collect();
    s.call("post_import", "/v1/import", Some((NDJSON, two))).await;

    s.call("get_records", "/v1/records?limit=2", None).await.ok();
    s.call("get_record", &format!("/v1/records/{}", records[0]), None).await.ok();
    s.call("get_record_diagnosis", &format!("/v1/records/{}/diagnosis", records[0]), None).await.ok();

    what_a_gyro_is_asked(s).await;
    what_alerts_are_asked(s).await;
    what_hooks_are_asked(s).await;
    what_campaigns_are_asked(s).await;

    let window = json!({ "from": "2026-06-01T00:00:00Z", "to": "2026-06-30T00:00:00Z",
        "by": "B. Li", "reason": "the table was not level" });
    let station = record(1)["station"].as_str().unwrap().to_owned();
    s.call("get_stations", "/v1/stations", None).await.ok();
    s.call("get_station", &format!("/v1/stations/{station}"), None).await.ok();
    s.call("suspect_window", &format!("/v1/stations/{station}/suspect"), sent(&window)).await.ok();
    s.call("trust_window", &format!("/v1/stations/{station}/trust"), sent(&window)).await.ok();
    s.call("suspect_window", &format!("/v1/stations/{station}/suspect"), sent(&window)).await.ok();
    s.call("confirm_record", &format!("/v1/records/{}/confirm", records[5]), sent(&signed)).await.ok();
    s.call("confirm_record", &format!("/v1/records/{}/confirm", records[0]), sent(&signed)).await.refused(409);

    s.call("void_bench_result", &format!("/v1/bench-results/{stored}/void"), sent(&said)).await.ok();
    s.call("void_record", &format!("/v1/records/{}/void", records[5]), sent(&said)).await.ok();
    let mut revised = record(5);
    revised["gyros"][0]["g_pulse_per_s_g0"][0] = 2.4210.into();
    let revision = json!({ "author": "B. Li", "reason": "a digit was wrong", "record": revised });
    let path = format!("/v1/records/{}/revise", records[4]);
    s.call("revise_record", &path, sent(&revision)).await.created();
    s.call("revise_record", &path, sent(&revision)).await.ok();
    let mut another = said;
    another["reason"] = "sent by mistake".into();
    s.call("revise_record", &path, sent(&json!({ "author": "B. Li", "reason": "again", "record": record(5) })))
        .await
        .refused(409);
    s.call("void_record", &format!("/v1/records/{}/void", records[5]), sent(&another)).await.refused(409);
    s.call("void_bench_result", &format!("/v1/bench-results/{stored}/void"), sent(&another)).await.refused(409);
    s.call("get_audit", "/v1/audit?limit=2", None).await.ok();
    s.call("get_audit", "/v1/audit?format=csv&limit=2", None).await;
    s.call("get_metrics", "/metrics", None).await;
}

async fn what_a_gyro_is_asked(s: &mut Scenario) {
    s.call("get_gyros", "/v1/gyros?limit=2", None).await.ok();
    s.call("get_gyro", "/v1/gyros/LFG-0101", None).await.ok();
    let trend = s.call("get_trend", "/v1/gyros/LFG-0101/trend?coefficient=D_I&limit=2", None).await;
    s.call("get_trend", "/v1/gyros/LFG-0101/trend?coefficient=D_I&format=csv", None).await;
    let path = "/v1/gyros/LFG-0101/trend?coefficient=D_I&limit=2";
    let headers =
        [("authorization", format!("Bearer {}", s.token)), ("if-none-match", trend.header("etag").to_owned())];
    let unchanged = s.send("get_trend", path, &None, &headers).await;
    s.keep("get_trend", &None, &unchanged);
    s.call("get_gyro_diagnosis", "/v1/gyros/LFG-0101/diagnosis", None).await.ok();
    s.call("patch_gyro", "/v1/gyros/LFG-0101", sent(&json!({ "batch": "2025-07", "unit": "vehicle 4" }))).await;
    let table = "serial,batch,type,unit\nLFG-0102,2025-07,,vehicle 4\nLFG-0103,2025-08,,vehicle 4\n";
    s.call("patch_gyros", "/v1/gyros", Some((CSV, table.into()))).await;

    let event =
        json!({ "event": "transport", "at": "2026-02-15T08:00:00Z", "author": "B. Li", "reason": "to station 2" });
    let baseline = json!({ "at": "2026-03-15T08:00:00Z", "author": "B. Li", "reason": "new motor",
        "fixed": { "D_I": 2.9576, "D_I_sd": 0.0004 } });
    for (operation, path, body) in
        [("post_event", "/v1/gyros/LFG-0102/events", event), ("post_baseline", "/v1/gyros/LFG-0103/baseline", baseline)]
    {
        let mut other = body.clone();
        other["reason"] = "in other words".into();
        s.call(operation, path, sent(&body)).await.created();
        s.call(operation, path, sent(&body)).await.ok();
        s.call(operation, path, sent(&other)).await.refused(409);
    }
    s.call("get_events", "/v1/gyros/LFG-0102/events", None).await.ok();
    s.call("get_imus", "/v1/imus", None).await.ok();
    let imu = record(1)["imu"].as_str().unwrap().to_owned();
    s.call("get_imu", &format!("/v1/imus/{imu}"), None).await.ok();
}

async fn what_alerts_are_asked(s: &mut Scenario) {
    let signed = json!({ "by": "B. Li", "reason": "it is looked into" });
    let alerts = s.call("get_alerts", "/v1/alerts?state=firing&limit=2", None).await.ok();
    s.call("get_alerts", "/v1/alerts?format=csv&limit=2", None).await;
    s.call("get_alerts", "/v1/alerts?serial=LFG-9999", None).await.refused(404);
    let alert = format!("/v1/alerts/{}", id(&alerts["alerts"][0]));
    s.call("acknowledge_alert", &format!("{alert}/acknowledge"), sent(&signed)).await.ok();
    s.call("unacknowledge_alert", &format!("{alert}/unacknowledge"), sent(&signed)).await.ok();
    let silence = json!({ "until": "2026-12-01T00:00:00Z", "by": "B. Li", "reason": "the gyro is being repaired" });
    s.call("silence_alert", &format!("{alert}/silence"), sent(&silence)).await.ok();
    s.call("get_alert", &alert, None).await.ok();
    let mut matching = silence;
    matching["matchers"] = json!({ "serial": "LFG-0103" });
    let made = id(&s.call("post_silence", "/v1/silences", sent(&matching)).await.created());
    s.call("get_silences", "/v1/silences", None).await.ok();
    s.call("get_silence", &format!("/v1/silences/{made}"), None).await.ok();
    s.call("end_silence", &format!("/v1/silences/{made}/end"), sent(&signed)).await.ok();
}

/// Waits until the target has been told so often, and the service knows it.
async fn delivered(s: &Scenario, target: &Receiver, delivery: &str, times: usize) {
    target.has_been_told(times).await;
    let headers = [("authorization", format!("Bearer {}", s.token))];
    while s.send("get_delivery", delivery, &None, &headers).await.ok()["state"] != "delivered" {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
}

async fn what_hooks_are_asked(s: &mut Scenario) {
    let target = Receiver::start().await;
    let hook = json!({ "name": "laboratory", "kind": "standard-webhooks", "url": target.url(),
        "filter": { "min_severity": "critical" } });
    let hook = id(&s.call("post_hook", "/v1/hooks", sent(&hook)).await.created());
    let at = format!("/v1/hooks/{hook}");
    s.call("get_hooks", "/v1/hooks", None).await.ok();
    s.call("get_hook", &at, None).await.ok();
    // What is answered tells of a delivery that waits, however quickly the target answers.
    let held = target.held().await;
    let test = s.call("test_hook", &format!("{at}/test"), None).await;
    drop(held);
    assert_eq!(test.status, 202);
    let delivery = format!("/v1/deliveries/{}", id(&test.json()));
    delivered(s, &target, &delivery, 1).await;
    s.call("get_delivery", &delivery, None).await.ok();
    s.call("get_deliveries", &format!("{at}/deliveries?limit=2"), None).await.ok();
    let held = target.held().await;
    s.call("redeliver", &format!("{delivery}/redeliver"), None).await;
    drop(held);
    delivered(s, &target, &delivery, 2).await;
    s.call("patch_hook", &at, sent(&json!({ "enabled": false }))).await.ok();
    s.call("test_hook", &format!("{at}/test"), None).await.refused(409);
    s.call("redeliver", &format!("{delivery}/redeliver"), None).await.refused(409);
    s.call("delete_hook", &at, None).await;
    // Addresses of this machine are not an example.
    let text = serde_json::to_string(&s.kept).unwrap();
    s.kept = serde_json::from_str(&text.replace(&target.url(), "https://hooks.example/laboratory")).unwrap();
}

async fn what_campaigns_are_asked(s: &mut Scenario) {
    let said = json!({ "author": "B. Li", "reason": "the table was not level" });
    let first = campaign("campaign-00", 1);
    let path = "/v1/campaigns";
    let stored = id(&s.call("post_campaign", path, sent(&first)).await.created());
    let diagnosis = format!("/v1/campaigns/{stored}/diagnosis");
    assert_eq!(s.call("get_campaign_diagnosis", &format!("{diagnosis}?wait=0"), None).await.status, 202);
    s.call("post_campaign", path, sent(&first)).await.ok();
    let mut other = first.clone();
    other["dwells"][0]["temperature_c"] = 45.0.into();
    s.call("post_campaign", path, sent(&other)).await.refused(409);
    let table = std::fs::read_to_string("docs/examples/march.csv").unwrap();
    assert_eq!(s.call("post_campaign", path, Some((CSV, table))).await.status, 201);
    s.call("get_campaigns", "/v1/campaigns?limit=2", None).await.ok();
    s.call("get_campaign", &format!("/v1/campaigns/{stored}"), None).await.ok();

    let model = format!("/v1/imus/{}/model", first["imu"].as_str().unwrap());
    let adoption = json!({ "effects": [{ "effect": "temperature_bias", "gyros": ["G1", "G2", "G3"], "estimates": [] }],
        "author": "B. Li", "reason": "held-out dwells agree" });
    let hypothesis = json!({ "hypothesis": { "id": "unbalance_creep", "words": "mass unbalance that settles after power-up",
        "equation": "k * exp(-t/tau) * a_S", "unit": "deg/(h*g0)", "plausible": 10.0,
        "range": { "tau": { "from": 0.2, "to": 4.0, "unit": "h" } } }, "author": "B. Li", "reason": "three campaigns after a cold night" });
    s.call("post_hypothesis", "/v1/hypotheses", sent(&hypothesis)).await.created();
    s.call("post_hypothesis", "/v1/hypotheses", sent(&hypothesis)).await.ok();
    let mut other = hypothesis;
    other["hypothesis"]["equation"] = "k * a_S".into();
    other["hypothesis"].as_object_mut().unwrap().remove("range");
    s.call("post_hypothesis", "/v1/hypotheses", sent(&other)).await.refused(409);
    s.call("get_hypotheses", "/v1/hypotheses", None).await.ok();
    s.call("delete_hypothesis", "/v1/hypotheses/unbalance_creep", None).await;

    loop {
        let answer = s.call("get_campaign_diagnosis", &diagnosis, None).await;
        if answer.status == 200 {
            break;
        }
    }
    let of_other = format!("{diagnosis}?reference={}", other_imu(s).await);
    s.call("get_campaign_diagnosis", &of_other, None).await.refused(422);
    s.call("post_model", &model, sent(&adoption)).await.created();
    s.call("post_model", &model, sent(&adoption)).await.ok();
    s.call("get_model", &model, None).await.ok();
    s.call("post_campaign", path, sent(&campaign("campaign-00", 22))).await.created();
    s.call("get_forecast", &format!("/v1/imus/{}/forecast", first["imu"].as_str().unwrap()), None).await.ok();

    let order = json!({ "imu": first["imu"], "again": true });
    let ordered = s.call("order_diagnoses", "/v1/diagnoses", sent(&order)).await;
    assert_eq!(ordered.status, 202, "{}", ordered.text);
    s.call("order_diagnoses", "/v1/diagnoses", sent(&order)).await.ok();
    let order = format!("/v1/diagnoses/{}", id(&ordered.json()));
    s.call("get_diagnosis_orders", "/v1/diagnoses", None).await.ok();
    s.call("get_diagnosis_order", &order, None).await.ok();
    s.call("cancel_diagnosis_order", &order, None).await;
    // Nothing is left to be done of what is diagnosed.
    let empty = json!({ "since": "2020-01-01T00:00:00Z", "until": "2020-01-02T00:00:00Z" });
    let ended = s.call("order_diagnoses", "/v1/diagnoses", sent(&empty)).await.json();
    for _ in 0..200 {
        let canceled = s.call("cancel_diagnosis_order", &format!("/v1/diagnoses/{}", id(&ended)), None).await;
        if canceled.status == 409 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let headers = [("authorization", format!("Bearer {}", s.token))];
    let summary = "/v1/diagnoses/summary";
    while s.send("get_diagnosis_summary", summary, &None, &headers).await.ok()["campaigns"]["waiting"] != 0 {
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    s.call("get_diagnosis_summary", summary, None).await.ok();
    s.call("get_diagnosis_summary", "/v1/diagnoses/summary?format=csv", None).await;

    let mut revised = campaign("campaign-00", 1);
    revised["dwells"][0]["temperature_c"] = 45.5.into();
    let revision = json!({ "author": "B. Li", "reason": "a thermometer was read wrongly", "campaign": revised });
    let at = format!("/v1/campaigns/{stored}");
    s.call("revise_campaign", &format!("{at}/revise"), sent(&revision)).await.created();
    s.call("revise_campaign", &format!("{at}/revise"), sent(&revision)).await.ok();
    let mut again = revision;
    again["campaign"]["dwells"][0]["temperature_c"] = 45.6.into();
    s.call("revise_campaign", &format!("{at}/revise"), sent(&again)).await.refused(409);
    s.call("void_campaign", &format!("{at}/void"), sent(&said)).await.refused(409);
    let newest = s.call("get_campaigns", "/v1/campaigns?limit=1", None).await.ok();
    s.call("void_campaign", &format!("/v1/campaigns/{}/void", id(&newest["campaigns"][0])), sent(&said)).await.ok();
}

/// Identifier of a record of another IMU.
async fn other_imu(s: &mut Scenario) -> String {
    let records = s.call("get_records", "/v1/records?limit=1", None).await.ok();
    id(&records["records"][0])
}

/// Refusals by themselves, before there are tokens.
async fn who_is_not_let_in_without_tokens(s: &mut Scenario) {
    for Described { id, path, whole, .. } in s.operations.clone() {
        let least = whole["responses"]["403"]["description"].as_str().unwrap_or_default();
        if least.contains("`viewer`") || least.contains("loopback") {
            let answer =
                s.send(&id, &path.replace(['{', '}'], ""), &None, &[("x-forwarded-for", "192.0.2.7".into())]).await;
            assert_eq!(answer.status, 403, "{id}: {}", answer.text);
            s.keep(&id, &None, &answer);
        }
    }
}

/// What every operation refuses for reasons that several have in common.
async fn what_is_refused(s: &mut Scenario) {
    let viewer = json!({ "name": "screen", "role": "viewer" });
    let viewer = s.call("post_token", "/v1/tokens", sent(&viewer)).await.created();
    let viewer = format!("Bearer {}", viewer["token"].as_str().unwrap());
    let admin = format!("Bearer {}", s.token);
    for Described { id, path, whole, .. } in s.operations.clone() {
        let concrete = UNKNOWN.iter().fold(path.clone(), |path, (parameter, name)| path.replace(parameter, name));
        let request = s.kept[&id].get("request").cloned().unwrap_or_default();
        let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let good: Body<'_> = request.iter().next().map(|(media_type, value)| (&**media_type, text(value)));
        let of_body = |text: &str| good.as_ref().map(|(media_type, _)| (*media_type, text.to_owned()));
        let bad_json = if request.contains_key(JSON) { Some((JSON, "{".to_owned())) } else { None };
        let statuses: Vec<String> = whole["responses"].as_object().unwrap().keys().cloned().collect();
        for status in statuses.iter().filter(|status| status.starts_with('4')) {
            if s.has(&id, status) {
                continue;
            }
            let with = |headers: &[(&'static str, &str)]| {
                let admin = [("authorization", admin.clone())].into_iter();
                let own = headers.iter().map(|(name, value)| (*name, (*value).to_owned())).collect::<Vec<_>>();
                if own.iter().any(|(name, _)| *name == "authorization") { own } else { admin.chain(own).collect() }
            };
            let answer = match &**status {
                "400" if bad_json.is_some() => s.send(&id, &concrete, &bad_json, &with(&[])).await,
                "400" => s.send(&id, &format!("{concrete}?limit=none&notify=loud"), &good, &with(&[])).await,
                "401" => s.send(&id, &concrete, &good, &with(&[("authorization", "Bearer wrong")])).await,
                "403" => s.send(&id, &concrete, &good, &with(&[("authorization", &viewer)])).await,
                "404" => s.send(&id, &concrete, &good, &with(&[])).await,
                "413" => s.send(&id, &concrete, &of_body(&" ".repeat((4 << 20) + 1)), &with(&[])).await,
                "415" => s.send(&id, &concrete, &Some(("text/plain", "text".into())), &with(&[])).await,
                "422" if request.contains_key(JSON) => {
                    s.send(&id, &concrete, &Some((JSON, json!({ "comment": "none" }).to_string())), &with(&[])).await
                }
                "422" => s.send(&id, &concrete, &of_body("serial,weight\nLFG-0101,1\n"), &with(&[])).await,
                _ => continue,
            };
            assert_eq!(answer.status.to_string(), **status, "{id}: {}", answer.text);
            s.keep(&id, &None, &answer);
        }
    }
}

/// Refusals that say the same whatever is asked for, each as one service answers it.
async fn what_any_operation_may_answer() -> BTreeMap<&'static str, Value> {
    let mut found = BTreeMap::new();
    let guarded = Lab::with(|config| config.access.failures_per_minute = 1).await;
    let guess = async || Answer::of(guarded.request(Method::GET, "/v1/gyros").bearer_auth("wrong")).await;
    while found.is_empty() {
        let answer = guess().await;
        if answer.status == 429 {
            found.insert("429", answer.json());
        }
    }

    let held = Lab::with(|config| config.database.busy_timeout_s = 0.1).await;
    let mut other = behind::open(&held.database()).await;
    sqlx::query("BEGIN IMMEDIATE").execute(&mut other).await.unwrap();
    let refused = held.post("/v1/records", &record(1)).await;
    assert_eq!(refused.status, 503, "{}", refused.text);
    found.insert("503", refused.json());
    let ready = held.get("/readyz").await;
    assert_eq!(ready.status, 503, "{}", ready.text);
    found.insert("503 readyz", ready.json());

    if support::small_disks_work() {
        let dir = tempfile::tempdir().unwrap();
        let inside = dir.path().to_owned();
        let under = [support::on_a_small_disk("size=8m"), vec![inside.to_str().unwrap().to_owned()]].concat();
        let under: Vec<&str> = under.iter().map(String::as_str).collect();
        let server = support::Server::start_under(&under, dir, &[]);
        let filler = format!("/proc/{}/root{}/filler", server.pid(), inside.display());
        support::fill(Path::new(&filler));
        for number in 0..10_000 {
            let answer = server.post_json("/v1/records", &paper_record(number % 20, number)).await;
            if answer.status == 507 {
                found.insert("507", answer.json());
                break;
            }
        }
    }
    found
}

/// There may be so many.
async fn too_many(s: &mut Scenario) {
    let silence = json!({ "matchers": { "serial": "LFG-0103" }, "until": "2026-12-01T00:00:00Z", "by": "B. Li", "reason": "repair" });
    let hook = json!({ "kind": "cloudevents", "url": "https://hooks.example/laboratory", "enabled": false });
    for (operation, path, body) in [("post_silence", "/v1/silences", silence), ("post_hook", "/v1/hooks", hook)] {
        loop {
            let answer = s.call(operation, path, sent(&body)).await;
            if answer.status == 409 {
                break;
            }
            assert_eq!(answer.status, 201, "{}", answer.text);
        }
    }
}

async fn scenario() -> Kept {
    telemetry::start().unwrap();
    let mut s = Scenario::begin().await;
    who_is_not_let_in_without_tokens(&mut s).await;
    s.lab.restart().await;
    let admin = json!({ "name": "administrator", "role": "admin" });
    let made = s.lab.post("/v1/tokens", &admin).await.created();
    s.token = made["token"].as_str().unwrap().to_owned();
    what_is_taken(&mut s).await;
    let resolved = s.call("get_alerts", "/v1/alerts?state=resolved", None).await.ok();
    let path = format!("/v1/alerts/{}/acknowledge", id(&resolved["alerts"][0]));
    let signed = json!({ "by": "B. Li", "reason": "it is looked into" });
    s.call("acknowledge_alert", &path, sent(&signed)).await.refused(409);
    what_is_refused(&mut s).await;
    too_many(&mut s).await;
    let shared = what_any_operation_may_answer().await;
    for Described { id, whole, .. } in s.operations.clone() {
        for (status, value) in &shared {
            let (status, of) = status.split_once(' ').unwrap_or((status, &id));
            if of == id && whole["responses"].get(status).is_some() {
                let kept = s.kept.entry(id.clone()).or_default();
                kept.entry(status.to_owned()).or_default().insert(PROBLEM.to_owned(), value.clone());
            }
        }
    }
    s.kept
}

/// The examples by name, each once, and which has which.
fn named(kept: &Kept) -> Value {
    let (mut names, mut examples) = (BTreeMap::<String, String>::new(), Map::new());
    let mut operations = Map::new();
    for (operation, answers) in kept {
        let mut of_operation = Map::new();
        for (what, contents) in answers.iter().filter(|(_, contents)| !contents.is_empty()) {
            let mut of_answer = Map::new();
            for (media_type, value) in contents {
                let base = match value.get("code").and_then(Value::as_str).filter(|_| media_type == PROBLEM) {
                    Some(code) => format!("{what}_{code}"),
                    None if media_type == JSON || media_type == NDJSON => format!("{operation}_{what}"),
                    None => format!("{operation}_{what}_{}", media_type.rsplit('/').next().unwrap()),
                };
                let name = names.entry(value.to_string()).or_insert_with(|| {
                    let numbered = (2..).map(|number| format!("{base}_{number}"));
                    let free = std::iter::once(base.clone()).chain(numbered).find(|name| !examples.contains_key(name));
                    let name = free.unwrap();
                    examples.insert(name.clone(), value.clone());
                    name
                });
                of_answer.insert(media_type.clone(), json!(name));
            }
            of_operation.insert(what.clone(), Value::Object(of_answer));
        }
        operations.insert(operation.clone(), Value::Object(of_operation));
    }
    json!({ "examples": examples, "operations": operations })
}

/// One line an example and an operation, so that a change shows where it is.
fn written(file: &Value) -> String {
    let lines = |part: &str| {
        let members = file[part].as_object().unwrap().iter();
        let lines: Vec<String> = members.map(|(name, value)| format!("{}: {value}", json!(name))).collect();
        format!("{}: {{\n{}\n}}", json!(part), lines.join(",\n"))
    };
    format!("{{\n{},\n{}\n}}\n", lines("examples"), lines("operations"))
}

/// What differs from run to run: identifiers, secrets, how long something took, what hooks are still to be told.
fn masked(value: &Value) -> Value {
    let word = |word: &str| {
        let drawn = word.len() >= 12 && word.chars().any(|c| c.is_ascii_digit());
        if drawn { "*".to_owned() } else { word.to_owned() }
    };
    match value {
        Value::String(text) if text.starts_with("whsec_") || text.starts_with("gyrowatch_") => json!("*"),
        Value::String(text) => json!(text.split(|c: char| !c.is_ascii_alphanumeric()).map(word).collect::<Vec<_>>()),
        Value::Number(number) if number.is_f64() => json!(format!("{:.5e}", number.as_f64().unwrap())),
        Value::Array(items) => items.iter().map(masked).collect(),
        Value::Object(members) => {
            let stays = |name: &str| !["token", "secret", "took_ms", "duration_ms", "queue"].contains(&name);
            let members = members.iter().filter(|(name, _)| stays(name));
            members.map(|(name, member)| (name.clone(), masked(member))).collect()
        }
        other => other.clone(),
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn examples_are_what_the_service_answers() {
    if cluster::is_wanted() {
        return; // It is a file that is held by somebody else.
    }
    let now = named(&scenario().await);
    if std::env::var_os("GYROWATCH_WRITE_EXAMPLES").is_some() {
        std::fs::write(FILE, written(&now)).unwrap();
        return;
    }
    let kept: Value = serde_json::from_str(&std::fs::read_to_string(FILE).unwrap()).unwrap();
    let (kept, now) = (by_place(&kept), by_place(&now));
    assert_eq!(kept.keys().collect::<Vec<_>>(), now.keys().collect::<Vec<_>>(), "GYROWATCH_WRITE_EXAMPLES=1");
    for (place, example) in now {
        assert_eq!(example, kept[&place], "{place}: GYROWATCH_WRITE_EXAMPLES=1 writes it anew");
    }
}

/// What tells how far diagnoses and deliveries have come, which are made meanwhile.
const MEANWHILE: [&str; 4] = ["order_diagnoses", "get_diagnosis_order", "get_diagnosis_orders", "get_deliveries"];

/// Examples, masked, by operation, status and media type. A full disk cannot be had everywhere.
fn by_place(file: &Value) -> BTreeMap<String, Value> {
    let mut found = BTreeMap::new();
    for (operation, answers) in file["operations"].as_object().unwrap() {
        for (what, contents) in answers.as_object().unwrap().iter().filter(|(what, _)| *what != "507") {
            for (media_type, name) in contents.as_object().unwrap() {
                let example = masked(&file["examples"][name.as_str().unwrap()]);
                let is_stable = !(MEANWHILE.contains(&&**operation) && what.starts_with('2'));
                let example = if is_stable { example } else { Value::Null };
                found.insert(format!("{operation} {what} {media_type}"), example);
            }
        }
    }
    found
}

/// Where a schema is in the document, and the examples beside it.
fn contents<'a>(at: &str, part: &'a Value, found: &mut Vec<(String, &'a Value)>) {
    for (media_type, content) in part["content"].as_object().into_iter().flatten() {
        found.push((format!("{at}/content/{}", media_type.replace('/', "~1")), content));
    }
}

#[tokio::test]
async fn every_body_and_every_answer_has_an_example_that_its_schema_takes() {
    const DOCUMENT: &str = "https://gyrowatch.example/openapi.json";
    let lab = Lab::open().await;
    let document = lab.get("/openapi.json").await.ok();
    let mut compiler = boon::Compiler::new();
    compiler.enable_format_assertions();
    compiler.add_resource(DOCUMENT, document.clone()).unwrap();
    let mut schemas = boon::Schemas::new();
    let (mut without, mut checked) = (Vec::new(), 0);
    for Described { id, method, path, whole } in described(&document) {
        let at = format!("/paths/{}/{}", path.replace('/', "~1"), method.as_str().to_lowercase());
        let mut found = Vec::new();
        contents(&format!("{at}/requestBody"), &whole["requestBody"], &mut found);
        for (status, answer) in whole["responses"].as_object().unwrap() {
            contents(&format!("{at}/responses/{status}"), answer, &mut found);
        }
        for (at, content) in found {
            let Some(examples) = content["examples"].as_object() else {
                without.push(format!("{id} {at}"));
                continue;
            };
            // A pointer in an address, where braces have codes.
            let encoded = at.replace('{', "%7B").replace('}', "%7D");
            let schema = compiler.compile(&format!("{DOCUMENT}#{encoded}/schema"), &mut schemas).unwrap();
            for example in examples.values() {
                let pointer = example["$ref"].as_str().unwrap().strip_prefix('#').unwrap();
                let value = &document.pointer(pointer).unwrap_or_else(|| panic!("no {pointer}"))["value"];
                if let Err(fault) = schemas.validate(value, schema) {
                    panic!("{at}: {fault:#}\n{value}");
                }
                checked += 1;
            }
        }
    }
    assert_eq!(without, [""; 0]);
    assert!(checked > 400, "{checked}");

    // What is no answer of it is not taken.
    let schema = compiler.compile(&format!("{DOCUMENT}#/components/schemas/Problem"), &mut schemas).unwrap();
    assert!(schemas.validate(&json!({ "title": "Not found", "status": "404" }), schema).is_err());
}
