//! Whoever runs a fleet sets up hooks, tries them out, and sees what has become of what they were told.

use crate::prelude::*;
use crate::receiver::{self, Told};
use crate::support::Answer;
use axum::http::StatusCode;
use axum::response::IntoResponse;
use base64::Engine;
use tokio::io::AsyncWriteExt;
use tokio::sync::Notify;

/// Waits of the ladder that a test can wait for: three attempts in all.
const SHORT: (&str, &str) = ("GYROWATCH_HOOKS__RETRY_WAITS_S", "0.2,0.3");

fn key(bytes: usize) -> String {
    format!("whsec_{}", base64::prelude::BASE64_STANDARD.encode(vec![7; bytes]))
}

/// What the engineer does.
impl Server {
    async fn changes(&self, hook: &Value, change: Value) -> Answer {
        let path = format!("/v1/hooks/{}", hook["id"].as_str().unwrap());
        self.call("PATCH", &path, &[("content-type", "application/json")], change.to_string()).await
    }

    async fn tests(&self, hook: &Value) -> Value {
        let path = format!("/v1/hooks/{}/test", hook["id"].as_str().unwrap());
        self.call("POST", &path, &[], "").await.has(202).json()
    }

    /// Waits until the delivery is in one of `states`.
    async fn sees(&self, delivery: &Value, states: &[&str]) -> Value {
        wait(self, delivery, |now| states.contains(&now["state"].as_str().unwrap())).await
    }

    async fn sees_attempts(&self, delivery: &Value, count: usize) -> Value {
        wait(self, delivery, |now| now["attempts"].as_array().unwrap().len() >= count).await
    }
}

async fn wait(server: &Server, delivery: &Value, until: impl Fn(&Value) -> bool) -> Value {
    let path = format!("/v1/deliveries/{}", delivery["id"].as_str().unwrap());
    once(async || server.get(&path).await.json(), until).await
}

fn verifies(told: &Told, secret: &str) -> bool {
    standardwebhooks::Webhook::new(secret).unwrap().verify(&told.body, &told.headers).is_ok()
}

#[tokio::test]
async fn a_hook_is_set_up_shown_changed_and_deleted_and_its_secret_shown_once() {
    let server = Server::start().await;
    assert_eq!(server.get("/v1/hooks").await.json(), json!({ "hooks": [] }));
    let hook = server
        .sets_up(json!({
            "kind": "standard-webhooks", "url": "http://127.0.0.1:9/x?token=t", "name": "pager",
            "authorization": "Bearer hunter2",
            "filter": { "rules": ["step"], "gyros": ["LFG-0101"], "min_severity": "critical" },
        }))
        .await;
    assert!(hook["secret"].as_str().unwrap().starts_with("whsec_"));
    assert_eq!((&hook["enabled"], &hook["signed"], &hook["authorized"]), (&json!(true), &json!(true), &json!(true)));
    assert_eq!(hook["queue"], json!({ "open": 0, "oldest_open": null, "dead": 0 }));
    let path = format!("/v1/hooks/{}", hook["id"].as_str().unwrap());

    let shown = server.get(&path).await;
    assert!(!shown.text().contains("whsec_") && !shown.text().contains("hunter2"), "{}", shown.text());
    assert_eq!(server.get("/v1/hooks").await.json()["hooks"], json!([shown.json()]));
    assert_eq!(shown.json()["filter"], hook["filter"]);

    let changed = json!({ "name": "night pager", "authorization": null, "filter": {} });
    let changed = server.changes(&hook, changed).await.has(200).json();
    assert_eq!((&changed["name"], &changed["authorized"]), (&json!("night pager"), &json!(false)));
    assert_eq!(changed["filter"], json!({ "rules": [], "gyros": [], "min_severity": null }));
    assert_eq!((&changed["url"], &changed["kind"]), (&hook["url"], &hook["kind"]), "what is left out stays");

    assert_eq!(server.call("DELETE", &path, &[], "").await.status, 204);
    for (method, path) in [("GET", path.clone()), ("DELETE", path.clone()), ("POST", format!("{path}/test"))] {
        let answer = server.call(method, &path, &[], "").await;
        assert_eq!((answer.status, answer.content_type.as_str()), (404, "application/problem+json"), "{method} {path}");
    }
    assert_eq!(server.get(&format!("{path}/deliveries")).await.status, 404);
    assert_eq!(server.get("/v1/hooks").await.json(), json!({ "hooks": [] }));
}

#[tokio::test]
async fn a_hook_that_cannot_be_is_refused_at_its_place_and_no_secret_is_repeated() {
    let server = Server::start_with(&[("GYROWATCH_HOOKS__ALLOW", "10.0.0.0/8, fd12::/16")]).await;
    let good = json!({ "kind": "standard-webhooks", "url": "http://10.0.0.1/" });
    let with = |member: &str, value: Value| {
        let mut hook = good.clone();
        hook[member] = value;
        hook
    };
    let mut rows = vec![
        (with("kind", json!("pagerduty")), "/kind", "alertmanager-webhook"),
        (with("url", json!("ftp://10.0.0.1/")), "/url", "http://"),
        (with("url", json!("10.0.0.1/hook")), "/url", "not_a_url"),
        (with("url", json!("http://u:hunter2@10.0.0.1/")), "/url", "authorization"),
        (with("url", json!(7)), "/url", "string"),
        (with("secret", json!(key(23))), "/secret", "24 to 64 bytes"),
        (with("secret", json!("hunter2")), "/secret", "whsec_"),
        (with("secret", json!("whsec_hunter2!")), "/secret", "base64"),
        (with("authorization", json!("Bearer hunter2\r\nx: y")), "/authorization", "visible ASCII"),
        (with("authorization", json!("")), "/authorization", "1 to 4096"),
        (with("name", json!("")), "/name", "empty"),
        (with("filter", json!({ "rules": ["stpe"] })), "/filter/rules/0", "no rule"),
        (with("filter", json!({ "gyros": ["A\u{200b}"] })), "/filter/gyros/0", "U+200B"),
        (with("filter", json!({ "min_severity": "fatal" })), "/filter/min_severity", "critical"),
        (with("filter", json!({ "rule": "step" })), "/filter/rule", "unknown_member"),
        (with("enabled", json!("yes")), "/enabled", "boolean"),
        (with("secrets", json!([])), "/secrets", "unknown_member"),
        (json!({ "kind": "cloudevents" }), "/url", "missing"),
    ];
    let forbidden = [
        "127.0.0.1",
        "0x7f.1",
        "2130706433",
        "017700000001",
        "[::1]",
        "[::ffff:127.0.0.1]",
        "[::ffff:7f00:1]",
        "169.254.169.254",
        "2852039166",
        "[fe80::1]",
        "0.0.0.0",
        "192.168.1.1",
        "[64:ff9b::7f00:1]",
    ];
    for host in forbidden {
        rows.push((with("url", json!(format!("http://{host}/"))), "/url", "refused"));
    }
    for (hook, pointer, says) in rows {
        let answer = server.post_json("/v1/hooks", &hook).await;
        assert_eq!((answer.status, answer.content_type.as_str()), (422, "application/problem+json"), "{hook}");
        let text = answer.text();
        assert_eq!(answer.json()["errors"][0]["pointer"], pointer, "{hook}: {text}");
        assert!(text.contains(says) && !text.contains("hunter2"), "{hook}: {text}");
    }
    assert_eq!(server.post("/v1/hooks", "application/json", "{").await.status, 400);
    assert_eq!(server.post("/v1/hooks", "text/plain", good.to_string()).await.status, 415);
    assert_eq!(server.get("/v1/hooks").await.json(), json!({ "hooks": [] }));

    let hook = server.sets_up(good.clone()).await;
    for (change, pointer) in [
        (json!({ "url": "http://127.0.0.1/" }), "/url"),
        (json!({ "secret": null }), "/secret"),
        (json!({ "secret": "whsec_" }), "/secret"),
        (json!({ "secret": key(32), "rotate_secret": true }), "/rotate_secret"),
        (json!({ "kind": "cloudevents" }), "/kind"),
        (json!({ "filter": { "rules": ["stpe"] } }), "/filter/rules/0"),
    ] {
        let answer = server.changes(&hook, change.clone()).await;
        assert_eq!(answer.status, 422, "{change}");
        assert_eq!(answer.json()["errors"][0]["pointer"], pointer, "{change}: {}", answer.text());
    }
    for (path, status) in [("limit=0", 400), ("state=lost", 400), ("cursor=x", 400), ("state=dead&limit=5", 200)] {
        let path = format!("/v1/hooks/{}/deliveries?{path}", hook["id"].as_str().unwrap());
        assert_eq!(server.get(&path).await.status, status, "{path}");
    }
    assert_eq!(server.call("POST", "/v1/deliveries/0000000000000/redeliver", &[], "").await.status, 404);
    assert_eq!(server.get("/v1/deliveries/nonsense").await.status, 404);
}

#[tokio::test]
async fn a_name_that_leads_to_a_forbidden_address_is_named_in_the_history() {
    let target = Receiver::start().await;
    let server = Server::start_with(&[("GYROWATCH_HOOKS__ALLOW", "10.0.0.0/8"), SHORT]).await;
    let url = format!("http://localhost:{}/", target.address.port());
    let hook = server.sets_up(json!({ "kind": "cloudevents", "url": url })).await;
    let delivery = server.tests(&hook).await;
    let seen = server.sees_attempts(&delivery, 1).await;
    let detail = seen["attempts"][0]["detail"].as_str().unwrap();
    assert!(detail.contains("localhost resolves to a forbidden address"), "{detail}");
    assert_eq!(target.told().len(), 0);
}

#[tokio::test]
async fn a_test_is_signed_and_while_a_secret_is_replaced_both_sign() {
    let (server, target) = (Server::start().await, Receiver::start().await);
    let hook =
        server.sets_up(json!({ "kind": "standard-webhooks", "url": target.url(), "authorization": "Bearer t" })).await;
    let first = hook["secret"].as_str().unwrap().to_owned();
    let delivery = server.tests(&hook).await;
    assert_eq!((&delivery["event"], &delivery["alert"]), (&json!("hook.test"), &Value::Null));
    let told = target.has_been_told(1).await.remove(0);
    assert!(verifies(&told, &first) && !verifies(&told, &key(32)));
    assert_eq!(told.id(), delivery["webhook_id"].as_str().unwrap());
    assert_eq!(
        (told.header("authorization"), told.header("content-type")),
        ("Bearer t".into(), "application/json".into())
    );
    assert_eq!((&told.json()["type"], told.path.as_str()), (&json!("hook.test"), "/hook"));
    let done = server.sees(&delivery, &["delivered"]).await;
    assert_eq!((&done["attempts"][0]["status"], &done["attempts"][0]["detail"]), (&json!(200), &json!("")));
    assert!(done["finished_at"].is_string() && done["due_at"].is_null());

    let rotated = server.changes(&hook, json!({ "rotate_secret": true })).await.json();
    let second = rotated["secret"].as_str().unwrap().to_owned();
    assert!(second != first && rotated["old_secret_until"].is_string());
    server.tests(&hook).await;
    let told = target.has_been_told(2).await.remove(1);
    assert_eq!(told.header("webhook-signature").split(' ').count(), 2);
    assert!(verifies(&told, &first) && verifies(&told, &second));

    let named = server.changes(&hook, json!({ "secret": key(24) })).await.json();
    assert_eq!(named.get("secret"), None, "who has named a secret knows it");
    server.tests(&hook).await;
    let told = target.has_been_told(3).await.remove(2);
    assert!(!verifies(&told, &first) && verifies(&told, &second) && verifies(&told, &key(24)));
}

#[tokio::test]
async fn a_secret_that_was_replaced_long_ago_signs_no_more() {
    let server = Server::start_with(&[("GYROWATCH_HOOKS__OLD_SECRET_HOURS", "0")]).await;
    let target = Receiver::start().await;
    let hook = server.sets_up(json!({ "kind": "cloudevents", "url": target.url(), "secret": key(24) })).await;
    let second = server.changes(&hook, json!({ "rotate_secret": true })).await.json()["secret"].clone();
    server.tests(&hook).await;
    let told = target.has_been_told(1).await.remove(0);
    assert!(verifies(&told, second.as_str().unwrap()) && !verifies(&told, &key(24)));
    let unsigned = server.changes(&hook, json!({ "secret": null })).await.json();
    assert_eq!(unsigned["signed"], false);
    server.tests(&hook).await;
    assert_eq!(target.has_been_told(2).await[1].header("webhook-signature"), "");
}

#[tokio::test]
async fn every_kind_speaks_its_dialect() {
    let (server, target) = (Server::start().await, Receiver::start().await);
    let cases = ["alertmanager-webhook", "alertmanager", "cloudevents"];
    for (i, kind) in cases.into_iter().enumerate() {
        let hook = server.sets_up(json!({ "kind": kind, "url": target.url(), "name": "lab" })).await;
        assert_eq!(hook.get("secret"), None, "{kind} is signed only where a secret is named");
        let delivery = server.tests(&hook).await;
        let told = target.has_been_told(i + 1).await.remove(i);
        assert_eq!(told.id(), delivery["webhook_id"].as_str().unwrap());
        let body = told.json();
        match kind {
            "alertmanager-webhook" => {
                assert_eq!([&body["version"], &body["receiver"], &body["status"]], ["4", "lab", "firing"]);
                assert_eq!(body["alerts"][0]["labels"]["alertname"], "GyrowatchTest");
            }
            "alertmanager" => {
                assert_eq!(told.path, "/hook/api/v2/alerts");
                assert_eq!(body[0]["labels"]["alertname"], "GyrowatchTest");
            }
            _ => {
                assert_eq!((&body["specversion"], &body["type"]), (&json!("1.0"), &json!("gyrowatch.hook.test")));
                assert_eq!(told.header("content-type"), "application/cloudevents+json; charset=UTF-8");
            }
        }
        server.sees(&delivery, &["delivered"]).await;
    }
}

#[tokio::test]
async fn whatever_a_target_does_is_named_in_the_history_and_harms_nobody() {
    let settings = [("GYROWATCH_HOOKS__ATTEMPT_TIMEOUT_S", "1"), ("GYROWATCH_HOOKS__CONNECT_TIMEOUT_S", "0.5"), SHORT];
    let server = Server::start_with(&settings).await;
    let elsewhere = Receiver::start().await;
    let (to, away) = (elsewhere.url(), elsewhere.address);
    let redirecting =
        Receiver::answering(move |_, _| (StatusCode::FOUND, [("location", to.clone())]).into_response()).await;
    let failing =
        Receiver::answering(|_, _| (StatusCode::INTERNAL_SERVER_ERROR, "no such channel").into_response()).await;
    let flood = receiver::raw(|mut stream| async move {
        stream.write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 10485760\r\n\r\n").await?;
        stream.write_all(&vec![b'a'; 10 << 20]).await
    });
    let drip = receiver::raw(|mut stream| async move {
        stream.write_all(b"HTTP/1.1 200 OK\r\n").await?;
        loop {
            stream.write_all(b"x-drip: drop\r\n").await?;
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    });
    let garbage = receiver::says(b"\x00\x01SSH-2.0-OpenSSH\r\n\r\n").await;
    let plain = receiver::says(b"HTTP/1.1 400 Bad Request\r\ncontent-length: 0\r\n\r\n").await;
    let closed = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let rows = [
        (format!("http://{}/", receiver::hangs().await), json!(null), "no answer within 1 s"),
        (failing.url(), json!(500), "answered 500 Internal Server Error: no such channel"),
        (redirecting.url(), json!(302), "redirects are not followed"),
        (format!("http://{garbage}/"), json!(null), "no HTTP answer"),
        (format!("http://{}/", flood.await.0), json!(200), "cut off after 4096 bytes"),
        (format!("http://{}/", drip.await.0), json!(null), "no answer within 1 s"),
        (format!("https://{plain}/"), json!(null), "TLS failed"),
        (format!("http://{closed}/"), json!(null), "no connection"),
    ];
    let mut deliveries = Vec::new();
    for (url, status, says) in rows {
        let hook = server.sets_up(json!({ "kind": "standard-webhooks", "url": url })).await;
        deliveries.push((server.tests(&hook).await, status, says));
    }
    for (delivery, status, says) in &deliveries {
        let seen = server.sees_attempts(delivery, 1).await;
        let attempt = &seen["attempts"][0];
        assert_eq!(&attempt["status"], status, "{seen:#}");
        assert!(attempt["detail"].as_str().unwrap().contains(says), "{says}: {attempt}");
        assert!(attempt["took_ms"].as_f64().unwrap() < 3000.0, "{attempt}");
    }
    assert!(elsewhere.told().is_empty(), "a redirect to {away} was followed");
    for (delivery, _, _) in deliveries {
        server.sees(&delivery, &["dead", "delivered"]).await;
    }
    assert_eq!(server.get("/readyz").await.status, 200);
}

/// Its waits are of the time that writing down an attempt takes, so that some end between the look for what is due
/// after it and the question what will be; nothing else wakes the lane.
#[tokio::test]
async fn a_delivery_that_becomes_due_while_others_are_looked_for_is_not_left_until_somebody_looks_again() {
    let waits: Vec<String> = (0..50).map(|k| (0.0005 * 1.1_f64.powi(k)).to_string()).collect();
    let server = Server::start_with(&[("GYROWATCH_HOOKS__RETRY_WAITS_S", &waits.join(","))]).await;
    let target = Receiver::answering(|_, _| StatusCode::NOT_FOUND.into_response()).await;
    let mut hooks = Vec::new();
    for _ in 0..6 {
        hooks.push(server.sets_up(json!({ "kind": "standard-webhooks", "url": target.url() })).await);
    }
    let mut deliveries = Vec::new();
    for hook in &hooks {
        deliveries.push(server.tests(hook).await);
    }
    for delivery in &deliveries {
        let dead = server.sees(delivery, &["dead"]).await;
        assert_eq!(dead["attempts"].as_array().unwrap().len(), 51);
    }
    let told = target.told();
    for earlier in &told {
        let next = told.iter().find(|next| next.id() == earlier.id() && next.at > earlier.at);
        let waited = next.map_or(Duration::ZERO, |next| next.at - earlier.at);
        assert!(waited < Duration::from_secs(20), "{waited:?}");
    }
}

#[tokio::test]
async fn a_delivery_climbs_the_ladder_becomes_a_dead_letter_and_is_replayed_with_the_same_id() {
    let server = Server::start_with(&[SHORT]).await;
    let target = Receiver::answering(|earlier, _| match earlier {
        0..3 => StatusCode::BAD_GATEWAY.into_response(),
        _ => ().into_response(),
    })
    .await;
    let hook = server.sets_up(json!({ "kind": "standard-webhooks", "url": target.url() })).await;
    let delivery = server.tests(&hook).await;
    let dead = server.sees(&delivery, &["dead"]).await;
    assert_eq!(dead["attempts"].as_array().unwrap().len(), 3);
    let told = target.told();
    let waits: Vec<f64> = told.windows(2).map(|w| (w[1].at - w[0].at).as_secs_f64()).collect();
    assert!((0.2..0.6).contains(&waits[0]) && (0.3..0.8).contains(&waits[1]), "{waits:?}");

    let path = format!("/v1/hooks/{}", hook["id"].as_str().unwrap());
    assert_eq!(server.get(&path).await.json()["queue"]["dead"], 1);
    let letters = server.get(&format!("{path}/deliveries?state=dead")).await.json();
    assert_eq!((letters["deliveries"][0]["id"].clone(), &letters["next"]), (delivery["id"].clone(), &Value::Null));

    let again =
        server.call("POST", &format!("/v1/deliveries/{}/redeliver", delivery["id"].as_str().unwrap()), &[], "").await;
    assert_eq!(again.status, 202, "{}", again.text());
    let done = server.sees(&delivery, &["delivered"]).await;
    assert_eq!(done["attempts"].as_array().unwrap().len(), 4, "the history stays");
    let told = target.told();
    assert!(told.iter().all(|t| t.id() == told[0].id() && t.body == told[0].body));
}

#[tokio::test]
async fn a_target_that_asks_for_time_gets_it() {
    let server = Server::start_with(&[SHORT]).await;
    let target = Receiver::answering(|earlier, _| match earlier {
        0 => (StatusCode::TOO_MANY_REQUESTS, [("retry-after", "2")]).into_response(),
        _ => ().into_response(),
    })
    .await;
    let hook = server.sets_up(json!({ "kind": "standard-webhooks", "url": target.url() })).await;
    server.tests(&hook).await;
    let told = target.has_been_told(2).await;
    let waited = (told[1].at - told[0].at).as_secs_f64();
    assert!((1.9..4.0).contains(&waited), "{waited} s");
}

#[tokio::test]
async fn a_target_that_is_gone_disables_its_hook_until_somebody_enables_it() {
    let server = Server::start_with(&[SHORT]).await;
    let target = Receiver::answering(|earlier, _| match earlier {
        0 => StatusCode::GONE.into_response(),
        _ => ().into_response(),
    })
    .await;
    let hook = server.sets_up(json!({ "kind": "standard-webhooks", "url": target.url() })).await;
    let delivery = server.tests(&hook).await;
    server.sees(&delivery, &["dead"]).await;
    let path = format!("/v1/hooks/{}", hook["id"].as_str().unwrap());
    let disabled = server.get(&path).await.json();
    assert_eq!(disabled["enabled"], false);
    assert!(disabled["disabled_because"].as_str().unwrap().contains("410 Gone"), "{disabled}");
    for path in [format!("{path}/test"), format!("/v1/deliveries/{}/redeliver", delivery["id"].as_str().unwrap())] {
        let refused = server.call("POST", &path, &[], "").await;
        assert_eq!(refused.status, 409, "{path}");
        assert!(refused.text().contains("disabled"), "{}", refused.text());
    }
    // It shows in every place where one looks at the service.
    let gauge = async |value: u32| {
        let text = server.get("/metrics").await.text();
        assert!(text.contains(&format!("\ngyrowatch_hooks_disabled {value}\n")), "{text}");
    };
    gauge(1).await;
    let page = server.get("/").await.text();
    assert!(page.contains("It is told nothing until somebody enables it."), "{page}");
    let trail = server.get("/v1/audit").await.json();
    let line = trail["lines"].as_array().unwrap().iter().find(|line| line["action"] == "disable hook");
    let line = line.unwrap_or_else(|| panic!("{trail}"));
    assert_eq!(
        (&line["who"], &line["before"]["enabled"], &line["after"]["enabled"]),
        (&json!("service"), &json!(true), &json!(false))
    );
    assert!(server.log().contains("the target of a hook is gone (410)"), "{}", server.log());
    let enabled = server.changes(&hook, json!({ "enabled": true })).await.json();
    assert_eq!((&enabled["enabled"], &enabled["disabled_because"]), (&json!(true), &Value::Null));
    gauge(0).await;
    assert!(!server.get("/").await.text().contains("It is told nothing until"));
    let delivery = server.tests(&hook).await;
    server.sees(&delivery, &["delivered"]).await;
    assert_eq!(target.told().len(), 2);
}

#[tokio::test]
async fn what_an_address_says_that_its_hook_has_no_longer_is_not_held_against_the_hook() {
    let server = Server::start_with(&[SHORT]).await;
    let (asked, may_answer) = (Arc::new(Notify::new()), Arc::new(Notify::new()));
    let (ask, answer) = (Arc::clone(&asked), Arc::clone(&may_answer));
    let old = receiver::raw(move |mut stream| {
        let (ask, answer) = (Arc::clone(&ask), Arc::clone(&answer));
        async move {
            ask.notify_one();
            answer.notified().await;
            stream.write_all(b"HTTP/1.1 410 Gone\r\ncontent-length: 0\r\n\r\n").await
        }
    });
    let url = format!("http://{}/", old.await.0);
    let hook = server.sets_up(json!({ "kind": "standard-webhooks", "url": url })).await;
    let to_old = server.tests(&hook).await;
    asked.notified().await;
    let new = Receiver::start().await;
    assert_eq!(server.changes(&hook, json!({ "url": new.url() })).await.status, 200);
    server.sees(&server.tests(&hook).await, &["delivered"]).await;
    may_answer.notify_one();
    server.sees(&to_old, &["dead"]).await;
    let path = format!("/v1/hooks/{}", hook["id"].as_str().unwrap());
    assert_eq!(server.get(&path).await.json()["enabled"], true);
    server.sees(&server.tests(&hook).await, &["delivered"]).await;
}

#[tokio::test]
async fn what_a_target_answers_is_kept_and_a_200_that_does_not_say_what_it_is_to_say_is_a_failed_attempt() {
    let server = Server::start_with(&[SHORT]).await;
    let robot = Receiver::answering(|earlier, _| {
        let code = if earlier == 0 { 45_009 } else { 0 };
        format!("{{\"errcode\": {code},\r\n \"errmsg\": \"频道{}\"}}", "x".repeat(2000)).into_response()
    })
    .await;
    let expect = json!({ "json": { "errcode": 0 } });
    let hook = server.sets_up(json!({ "kind": "cloudevents", "url": robot.url(), "expect": expect })).await;
    assert_eq!(hook["expect"], expect);
    let delivery = server.tests(&hook).await;
    let done = server.sees(&delivery, &["delivered"]).await;
    let attempts = done["attempts"].as_array().unwrap();
    assert_eq!(attempts.len(), 2, "{done:#}");
    assert_eq!(attempts[0]["status"], 200);
    let detail = attempts[0]["detail"].as_str().unwrap();
    assert!(
        detail.starts_with("answered 200 OK, but errcode is 45009, not 0: {\"errcode\": 45009, \"errmsg\": \"频道x"),
        "{detail}"
    );
    let answer = attempts[1]["answer"].as_str().unwrap();
    assert!(answer.starts_with("{\"errcode\": 0, \"errmsg\": \"频道x") && answer.len() < 1030, "{answer}");
    assert_eq!(attempts[1]["detail"], "");

    for (wrong, place) in [
        (json!({ "json": {} }), "/expect/json"),
        (json!({ "jsn": {} }), "/expect/jsn"),
        (json!({ "json": [0] }), "/expect/json"),
    ] {
        let refused = server.changes(&hook, json!({ "expect": wrong })).await;
        assert_eq!(
            (refused.status, &refused.json()["errors"][0]["pointer"]),
            (422, &json!(place)),
            "{}",
            refused.text()
        );
    }
    let changed = server.changes(&hook, json!({ "expect": null, "batch": false })).await.json();
    assert_eq!((&changed["expect"], &changed["batch"]), (&Value::Null, &json!(false)));
}

#[tokio::test]
async fn hooks_are_told_by_way_of_a_proxy_that_somebody_has_named_and_by_none_otherwise() {
    let proxy = Receiver::start().await;
    let address = format!("http://{}", proxy.address);
    let named = json!({ "kind": "cloudevents", "url": "http://alerts.gyrowatch.invalid/x" });
    for settings in [
        vec![("GYROWATCH_HOOKS__PROXY", address.as_str()), SHORT],
        vec![
            ("GYROWATCH_HOOKS__PROXY", "environment"),
            ("HTTP_PROXY", address.as_str()),
            ("NO_PROXY", "127.0.0.1"),
            SHORT,
        ],
    ] {
        let before = proxy.told().len();
        let server = Server::start_with(&settings).await;
        let hook = server.sets_up(named.clone()).await;
        server.sees(&server.tests(&hook).await, &["delivered"]).await;
        let told = proxy.told().remove(before);
        assert_eq!((told.path.as_str(), told.header("host")), ("/x", "alerts.gyrowatch.invalid".to_owned()));
        let literal = json!({ "kind": "cloudevents", "url": "http://169.254.169.254/" });
        assert_eq!(server.post_json("/v1/hooks", &literal).await.status, 422, "an address is refused all the same");
        let own = server.sets_up(json!({ "kind": "cloudevents", "url": "http://localhost:1/" })).await;
        let seen = server.sees_attempts(&server.tests(&own).await, 1).await;
        assert!(seen["attempts"][0]["detail"].as_str().unwrap().contains("proxy's own machine"), "{seen}");
        assert_eq!(proxy.told().len(), before + 1);
    }
    let server = Server::start_with(&[("HTTP_PROXY", address.as_str()), SHORT]).await;
    let hook = server.sets_up(named).await;
    let seen = server.sees_attempts(&server.tests(&hook).await, 1).await;
    assert!(seen["attempts"][0]["detail"].as_str().unwrap().contains("does not resolve"), "{seen}");
    assert_eq!(proxy.told().len(), 2, "the environment alone sends nothing elsewhere");
}

#[tokio::test]
async fn a_hook_that_is_mended_sends_what_waits_at_once() {
    let mut server = Server::start_with(&[("GYROWATCH_HOOKS__RETRY_WAITS_S", "3600")]).await;
    let target = Receiver::start().await;
    let closed = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let hook = server.sets_up(json!({ "kind": "cloudevents", "url": format!("http://{closed}/") })).await;
    let delivery = server.tests(&hook).await;
    let waiting = server.sees_attempts(&delivery, 1).await;
    assert_eq!(waiting["state"], "waiting");
    assert!(waiting["due_at"].is_string(), "in an hour, as the ladder says");
    server.kill();
    server.restart();
    assert_eq!(server.get(&format!("/v1/deliveries/{}", delivery["id"].as_str().unwrap())).await.json(), waiting);
    let mended = Instant::now();
    server.changes(&hook, json!({ "url": target.url() })).await;
    target.has_been_told(1).await;
    assert!(mended.elapsed() < Duration::from_secs(3), "{:?}", mended.elapsed());
    server.sees(&delivery, &["delivered"]).await;
}

#[tokio::test]
async fn a_deleted_hooks_queue_is_thrown_away() {
    let server = Server::start().await;
    let closed = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let hook = server.sets_up(json!({ "kind": "cloudevents", "url": format!("http://{closed}/") })).await;
    let delivery = server.tests(&hook).await;
    server.sees_attempts(&delivery, 1).await;
    let path = format!("/v1/hooks/{}", hook["id"].as_str().unwrap());
    server.changes(&hook, json!({ "enabled": false })).await;
    server.changes(&hook, json!({ "enabled": true })).await;
    server.sees(&delivery, &["dropped"]).await;
    let redeliver = format!("/v1/deliveries/{}/redeliver", delivery["id"].as_str().unwrap());
    let refused = server.call("POST", &redeliver, &[], "").await;
    assert!(refused.status == 409 && refused.text().contains("was dropped"), "{}", refused.text());
    let delivery = server.tests(&hook).await;
    assert_eq!(server.call("DELETE", &path, &[], "").await.status, 204);
    server.sees(&delivery, &["dropped"]).await;
    let path = format!("/v1/deliveries/{}/redeliver", delivery["id"].as_str().unwrap());
    assert_eq!(server.call("POST", &path, &[], "").await.status, 404);
}

#[tokio::test]
async fn the_service_stops_in_time_while_a_target_hangs_and_tells_it_again_after_the_start() {
    let mut server = Server::start().await;
    let hook =
        server.sets_up(json!({ "kind": "cloudevents", "url": format!("http://{}/", receiver::hangs().await) })).await;
    let delivery = server.tests(&hook).await;
    tokio::time::sleep(Duration::from_millis(200)).await;
    let (status, took) = server.terminate();
    assert!(status.success(), "{status:?}");
    assert!(took < Duration::from_secs(9), "{took:?}");
    server.restart();
    assert_eq!(server.sees(&delivery, &["waiting"]).await["attempts"], json!([]));
}

#[tokio::test]
async fn metrics_tell_of_attempts_and_of_the_age_of_the_outbox() {
    let (server, target) = (Server::start().await, Receiver::start().await);
    let hook = server.sets_up(json!({ "kind": "cloudevents", "url": target.url() })).await;
    let delivery = server.tests(&hook).await;
    server.sees(&delivery, &["delivered"]).await;
    let down = server.sets_up(json!({ "kind": "standard-webhooks", "url": "http://127.0.0.1:1/" })).await;
    let delivery = server.tests(&down).await;
    server.sees_attempts(&delivery, 1).await;
    let text = server.get("/metrics").await.text();
    let value = |series: &str| -> f64 {
        let line = text.lines().find(|line| line.starts_with(series)).unwrap_or_else(|| panic!("{series} in\n{text}"));
        line.rsplit_once(' ').unwrap().1.parse().unwrap()
    };
    assert_eq!(value(r#"gyrowatch_delivery_attempts_total{kind="cloudevents",outcome="delivered"}"#), 1.0);
    assert_eq!(value(r#"gyrowatch_delivery_attempts_total{kind="standard-webhooks",outcome="failed"}"#), 1.0);
    assert_eq!(value(r#"gyrowatch_outbox_deliveries{state="open"}"#), 1.0);
    assert_eq!(value(r#"gyrowatch_outbox_deliveries{state="dead"}"#), 0.0);
    assert!((0.0..20.0).contains(&value("gyrowatch_outbox_age_seconds")));
    assert_eq!(value(r#"gyrowatch_delivery_attempt_duration_seconds_count{kind="cloudevents"}"#), 1.0);
}
