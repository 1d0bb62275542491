//! Every kind of bad input, against the real service: the answer names the place, and nothing of it is kept.
//!
//! A row is one request. Each must be answered with problem+json of the given status, name the given place (a JSON
//! pointer, or the code of a fault), and leave the service's holdings as they were.

use crate::prelude::*;
use crate::support::{asked, seed, with_member};
use crate::{lab, spoken};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tokio::io::{AsyncReadExt, AsyncWriteExt};

/// Tables 3 and 4 of the paper.
fn paper() -> Value {
    document("paper.json")
}

fn bench() -> Value {
    lab::bench("LFG-0101", "2026-02-10T08:00:00Z", 4.193101, 5.771452)
}

/// The paper's record with one member replaced, or added.
fn with(pointer: &str, value: Value) -> Vec<u8> {
    changed(paper(), pointer, value)
}

fn changed(document: Value, pointer: &str, value: Value) -> Vec<u8> {
    with_member(document, pointer, value).to_string().into_bytes()
}

fn without(pointer: &str) -> Vec<u8> {
    let mut document = paper();
    let (parent, member) = pointer.rsplit_once('/').unwrap();
    document.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(member).unwrap();
    document.to_string().into_bytes()
}

/// The paper's record as text, with one piece of it replaced: for what no JSON value can express.
fn text(from: &str, to: &str) -> Vec<u8> {
    let record = paper().to_string();
    assert!(record.contains(from), "{from} is not in {record}");
    record.replacen(from, to, 1).into_bytes()
}

/// What a row's answer has to name.
enum Place {
    /// `errors[*].pointer` holds it.
    At(&'static str),
    /// A fault has the code, or some fault is named where it is empty.
    Says(&'static str),
}
use Place::{At, Says};

struct Row {
    what: &'static str,
    body: Vec<u8>,
    status: u16,
    place: Place,
}

fn row(what: &'static str, body: Vec<u8>, status: u16, place: Place) -> Row {
    Row { what, body, status, place }
}

fn records() -> Vec<Row> {
    let e = "/gyros/0/e_pulse_per_arcsec";
    let g = "/gyros/0/g_pulse_per_s_g0";
    // As a station writes it that knows nothing of UTF-8.
    let latin = |note: &str| -> Vec<u8> {
        String::from_utf8(with("/note", json!(note))).expect("UTF-8").chars().map(|letter| letter as u8).collect()
    };
    let deep = |n: usize| format!("{}{}", "[".repeat(n), "]".repeat(n));
    let at = |what, pointer, value| row(what, with(pointer, value), 422, At(pointer));
    let long = "x".repeat(65);
    vec![
        row("not JSON", b"imu: IMU-07".to_vec(), 400, Says("not_json")),
        row("nothing", Vec::new(), 400, Says("file_is_empty")),
        row("half a document", paper().to_string().into_bytes()[..200].to_vec(), 400, Says("not_json")),
        row(
            "two documents",
            [paper().to_string(), paper().to_string()].concat().into_bytes(),
            400,
            Says("several_documents"),
        ),
        row(
            "an unknown member before what is no JSON",
            text("\"imu\"", "\"colour\":1,\"imu\"").into_iter().chain(*b"x").collect(),
            400,
            Says("json_trailing_characters"),
        ),
        row(
            "bad UTF-8",
            text("IMU-07", "IMU-07").into_iter().map(|b| if b == b'7' { 0xff } else { b }).collect(),
            400,
            Says("not_utf8_from"),
        ),
        row("bad UTF-8 in a word alone", latin("M\u{fc}nchen"), 400, Says("not_utf8_from")),
        row(
            "bad UTF-8 behind an unknown member",
            [b"{\"colour\":1,".to_vec(), latin("M\u{fc}nchen")[1..].to_vec()].concat(),
            400,
            Says("not_utf8_from"),
        ),
        row("a NUL between members", text("\"imu\"", "\0\"imu\""), 400, Says("not_json")),
        row("no object", b"[]".to_vec(), 422, At("")),
        row("null", b"null".to_vec(), 422, At("")),
        at("unknown member", "/colour", json!("red")),
        at("unknown member of a gyro", "/gyros/1/colour", json!("red")),
        row(
            "unknown member holding 10^5 brackets",
            text("\"imu\"", &format!("\"x\":{},\"imu\"", deep(100_000))),
            422,
            At("/x"),
        ),
        row("10^5 brackets", deep(100_000).into_bytes(), 422, Says("")),
        row("a million brackets", "[".repeat(1_000_000).into_bytes(), 400, Says("")),
        row("member given twice", text("\"imu\"", "\"imu\":\"IMU-08\",\"imu\""), 422, At("/imu")),
        row(
            "member of a gyro given twice",
            text("\"slot\":\"G1\"", "\"slot\":\"G1\",\"slot\":\"G1\""),
            422,
            At("/gyros/0/slot"),
        ),
        row("missing member", without("/station"), 422, At("/station")),
        row("missing E", without(e), 422, At(e)),
        row("missing G", without(g), 422, At(g)),
        at("G in both units", "/gyros/0/g_deg_per_h_g0", json!([1, 2, 3])),
        at("text for a number", "/temperature_c", json!("45")),
        at("number for a text", "/imu", json!(7)),
        at("object for an array", e, json!({"x": 1})),
        row("text among numbers", with(e, json!([0.8, "x", 1.0])), 422, At("/gyros/0/e_pulse_per_arcsec/1")),
        row("null among numbers", with(e, json!([0.8, null, 1.0])), 422, At("/gyros/0/e_pulse_per_arcsec/1")),
        at("two elements", e, json!([0.8, 1.0])),
        at("four elements", e, json!([0.8, -0.6, 1.0, 0.0])),
        at("no gyro", "/gyros", json!([])),
        at(
            "four gyros",
            "/gyros",
            json!([paper()["gyros"][0], paper()["gyros"][1], paper()["gyros"][2], paper()["gyros"][0]]),
        ),
        row("NaN", text("0.8473", "NaN"), 400, Says("not_json")),
        row("Infinity", text("0.8473", "Infinity"), 400, Says("not_json")),
        row("1e999", text("0.8473", "1e999"), 422, At("/gyros/0/e_pulse_per_arcsec/0")),
        row("1e400", text("0.8473", "1e400"), 422, At("/gyros/0/e_pulse_per_arcsec/0")),
        row("1e308", text("0.8473", "1e308"), 422, At(e)),
        row("G of 1e308", text("2.421", "1e308"), 422, At(g)),
        at("E of zero", e, json!([0, 0, 0])),
        at("E beyond its limits", e, json!([8.473e6, -6.011e6, 1.0367e7])),
        at("E far from the declared geometry", e, json!([1.0, 1.0, 0.0])),
        at("E of the wrong sign", e, json!([-0.8473, 0.6011, -1.0367])),
        at("unknown geometry", "/geometry", json!("cubic")),
        row(
            "a geometry of skewed axes that are not perpendicular",
            with("/geometry", json!({"G1": {"input": [1, 0, 0], "spin": [0.6, 0.8, 0]}})),
            422,
            At("/geometry/G1/spin"),
        ),
        row(
            "a geometry that leaves out the slot",
            with("/geometry", json!({"G2": {"input": [1, 0, 0], "spin": [0, 1, 0]}})),
            422,
            At("/gyros/0/slot"),
        ),
        at("unknown slot", "/gyros/0/slot", json!("G4")),
        at("the same slot twice", "/gyros/1/slot", json!("G1")),
        at("the same serial twice", "/gyros/1/serial", json!("LFG-0101")),
        at("empty serial", "/gyros/0/serial", json!("")),
        at("over-long serial", "/gyros/0/serial", json!(long)),
        at("serial of half a megabyte", "/gyros/0/serial", json!("x".repeat(500_000))),
        at("NUL in the serial", "/gyros/0/serial", json!("LFG\u{0}0101")),
        at("line break in the IMU", "/imu", json!("IMU\n07")),
        at("nothing but blanks", "/imu", json!(" \u{3000}")),
        at("no width in the IMU", "/imu", json!("IMU-07\u{200b}")),
        at("direction in the serial", "/gyros/0/serial", json!("LFG\u{202e}-0101")),
        at("a clock that was never set", "/calibrated_at", json!("1970-01-01T00:00:12Z")),
        at("escape character in the note", "/note", json!("\u{1b}[31m")),
        row("half a surrogate pair", text("IMU-07", "IMU-\\ud800"), 422, At("/imu")),
        at("time without offset", "/calibrated_at", json!("2026-03-01T08:00:00")),
        at("time of another kind", "/calibrated_at", json!("01.03.2026 08:00")),
        at("time as a number", "/calibrated_at", json!(1_772_352_000)),
        at("offset +99:99", "/calibrated_at", json!("2026-03-01T08:00:00+99:99")),
        at("30 February", "/calibrated_at", json!("2026-02-30T08:00:00Z")),
        at("a leap second where there is none", "/calibrated_at", json!("2026-03-01T08:00:60Z")),
        at("a leap second that was never inserted", "/calibrated_at", json!("2025-12-31T23:59:60Z")),
        at("the year 9999", "/calibrated_at", json!("9999-12-31T23:59:59Z")),
        at("the year mistyped", "/calibrated_at", json!("0206-03-01T08:00:00Z")),
        at("far future", "/calibrated_at", json!("2140-01-01T00:00:00Z")),
        row("negative sd", with("/gyros/0/e_sd", json!([1e-6, -1e-6, 1e-6])), 422, At("/gyros/0/e_sd/1")),
        row("negative sd of G", with("/gyros/2/g_sd", json!([1e-3, 1e-3, -0.5])), 422, At("/gyros/2/g_sd/2")),
        at("colder than can be", "/temperature_c", json!(-300)),
    ]
}

fn bench_results() -> Vec<Row> {
    let at = |what, pointer, value| row(what, changed(bench(), pointer, value), 422, At(pointer));
    vec![
        row("not JSON", b"serial,station".to_vec(), 400, Says("not_json")),
        at("unknown method", "/method", json!("guess")),
        at("unknown member", "/colour", json!("red")),
        at("empty serial", "/serial", json!("")),
        at("negative sd", "/d_i_sd", json!(-1e-4)),
        at("a drift beyond belief", "/d_s_deg_per_h_g0", json!(1e300)),
        at("time without offset", "/measured_at", json!("2026-02-10T08:00:00")),
        at("the year mistyped", "/measured_at", json!("0206-02-10T08:00:00Z")),
        at("far future", "/measured_at", json!("2140-01-01T00:00:00Z")),
    ]
}

/// Whether a message, or one within it, has the code.
fn has_code(errors: &Value, code: &str) -> bool {
    match errors {
        Value::Object(members) => errors["code"] == code || members.values().any(|member| has_code(member, code)),
        Value::Array(items) => items.iter().any(|item| has_code(item, code)),
        _ => false,
    }
}

/// Sends every row, to a program and to a Chinese page, and collects all that is wrong with the answers, so that one
/// run shows the whole table.
async fn refuse(server: &Server, route: &str, rows: Vec<Row>) {
    let before = server.holdings().await;
    let mut wrong = Vec::new();
    for Row { what, body, status, place } in rows {
        if let Ok(document) = std::str::from_utf8(&body) {
            let english = spoken::english_left(server, document).await;
            wrong.extend(english.iter().map(|fault| format!("{what}: not in Chinese: {fault}")));
        }
        let answer = server.post(route, "application/json", body).await;
        let problem: Value = serde_json::from_slice(&answer.body).unwrap_or_default();
        let named = match place {
            At(pointer) => problem["errors"].as_array().is_some_and(|e| e.iter().any(|e| e["pointer"] == pointer)),
            Says(code) => {
                let said = problem["detail"].as_str().is_some_and(|detail| !detail.is_empty());
                said && (code.is_empty() || has_code(&problem["errors"], code))
            }
        };
        let formed = answer.content_type == "application/problem+json"
            && problem["status"] == answer.status
            && problem["title"].as_str().is_some_and(|t| !t.is_empty());
        if answer.status != status || !named || !formed {
            wrong.push(format!("{what}: wanted {status}, got {} {}: {problem}", answer.status, answer.content_type));
        }
        if server.holdings().await != before {
            wrong.push(format!("{what}: something was kept"));
            break;
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[tokio::test]
async fn a_bad_record_is_refused_at_its_place_and_nothing_is_kept() {
    refuse(&Server::start().await, "/v1/records", records()).await;
}

#[tokio::test]
async fn a_problem_is_said_in_the_language_asked_for_and_has_the_same_codes_in_each() {
    let server = Server::start().await;
    let record = with_member(paper(), "/imu", json!("x".repeat(65))).to_string();
    let asked = |language: &'static str| {
        let (headers, body) = ([("content-type", "application/json"), ("accept-language", language)], record.clone());
        let server = &server;
        async move { server.call("POST", "/v1/records", &headers, body).await.json() }
    };
    let (english, chinese) = (asked("fr, en;q=0.5").await, asked("zh-CN, en;q=0.5").await);
    for (problem, title, detail) in [
        (&english, "Cannot be stored as it is", "must have at most 64 characters, has 65"),
        (&chinese, "不能按原样存储", "最多64个字符，实有65个"),
    ] {
        let place = json!({ "pointer": "/imu", "code": "too_many_characters", "parameters": { "most": 64, "have": 65 }, "detail": detail });
        assert_eq!((&problem["title"], &problem["code"]), (&json!(title), &json!("faults_in_document")));
        assert_eq!(problem["errors"], json!([place]), "{problem}");
    }
    let answer = server.call("GET", "/v1/gyros/GL-1", &[("accept-language", "zh")], "").await;
    let problem = answer.json();
    assert_eq!(
        (answer.headers["content-language"].to_str().unwrap(), &problem["code"]),
        ("zh", &json!("unknown_gyro"))
    );
    assert_eq!(
        json!([problem["parameters"], problem["detail"]]),
        json!([{ "serial": "GL-1" }, "没有编号为GL-1的陀螺"])
    );
}

#[tokio::test]
async fn a_bad_bench_result_is_refused_at_its_place_and_nothing_is_kept() {
    refuse(&Server::start().await, "/v1/bench-results", bench_results()).await;
}

#[tokio::test]
async fn many_documents_where_one_is_taken_are_told_where_they_belong() {
    let server = Server::start().await;
    let benches = format!("{}\n{}\n", bench(), with_member(bench(), "/serial", json!("LFG-0102")));
    for (route, body) in [
        ("/v1/records", benches.clone()),
        ("/v1/campaigns", benches.clone()),
        ("/v1/bench-results", benches),
        ("/v1/records", format!("{}\r\n{}", paper(), paper())),
    ] {
        let (status, detail, pointers) = problem(&server.post(route, "application/json", body).await);
        assert_eq!((status, pointers), (400, vec![String::new()]), "{route}: {detail}");
        assert!(detail.contains("several JSON documents"), "{route}: {detail}");
        assert!(detail.contains("/v1/import") && detail.ends_with("at line 2 column 1"), "{route}: {detail}");
    }
}

#[tokio::test]
async fn a_document_of_another_kind_is_told_where_it_belongs_and_nothing_else() {
    let server = Server::start().await;
    let before = server.holdings().await;
    let campaign = support::data("practice/campaign-00.json");
    for (document, kind, place) in [
        (bench().to_string(), "a bench result", "/v1/bench-results"),
        (json!({"method": "torque_feedback"}).to_string(), "a bench result", "/v1/bench-results"),
        (paper().to_string(), "a calibration record", "/v1/records"),
        (campaign, "a campaign of raw dwells", "/v1/campaigns"),
    ] {
        for route in ["/v1/records", "/v1/campaigns", "/v1/bench-results"].into_iter().filter(|route| *route != place) {
            let (status, detail, pointers) = problem(&server.post(route, "application/json", document.clone()).await);
            assert_eq!((status, pointers), (422, vec![String::new()]), "{kind} to {route}: {detail}");
            assert_eq!(detail, format!("document: this is {kind}: send it to {place}"), "{route}");
        }
    }
    assert_eq!(server.holdings().await, before);
}

#[tokio::test]
async fn a_line_that_lacks_its_time_is_refused_as_what_it_is() {
    let server = Server::start().await;
    let campaign = document("practice/campaign-00.json");
    let mut lines = [bench(), campaign, paper()];
    for (document, time) in lines.iter_mut().zip(["measured_at", "measured_at", "calibrated_at"]) {
        document.as_object_mut().unwrap().remove(time).unwrap();
    }
    let body = lines.map(|document| document.to_string()).join("\n");
    let answers = server.post("/v1/import", "application/x-ndjson", body).await.text();
    for (answer, place) in answers.lines().zip(["/measured_at", "/measured_at", "/calibrated_at"]) {
        let error = serde_json::from_str::<Value>(answer).unwrap()["error"].take();
        let errors = error["errors"].as_array().unwrap();
        assert!(error["status"] == 422 && errors.len() == 1 && errors[0]["pointer"] == place, "{error}");
    }
}

/// Status, content type, detail, and the pointers that are named.
fn problem(answer: &support::Answer) -> (u16, String, Vec<String>) {
    assert_eq!(answer.content_type, "application/problem+json", "{answer:?}");
    let problem: Value = serde_json::from_slice(&answer.body).unwrap();
    assert_eq!(problem["status"], answer.status);
    let pointers = problem["errors"].as_array().into_iter().flatten();
    let pointers = pointers.map(|e| e["pointer"].as_str().unwrap().to_owned()).collect();
    (answer.status, problem["detail"].as_str().unwrap().to_owned(), pointers)
}

#[tokio::test]
async fn a_time_of_long_ago_is_refused_wherever_it_is_said() {
    let server = Server::start().await;
    let first = with("/calibrated_at", json!("1950-01-01T00:00:00Z"));
    assert_eq!(server.post("/v1/records", "application/json", first).await.status, 201, "the limit itself is accepted");
    let (ago, before) = (json!("0206-03-01T08:00:00Z"), json!("1949-12-31T23:59:59Z"));
    let mut campaign = document("practice/campaign-00.json");
    campaign["measured_at"] = ago.clone();
    let done = json!({"event": "repair", "reason": "new motor", "at": before});
    for (route, body, place) in [
        ("/v1/campaigns", campaign, "/measured_at"),
        ("/v1/gyros/LFG-0101/events", done, "/at"),
        ("/v1/gyros/LFG-0101/baseline", json!({"reason": "accepted", "at": ago}), "/at"),
    ] {
        let (status, detail, pointers) = problem(&server.post_json(route, &body).await);
        assert_eq!((status, pointers), (422, vec![place.to_owned()]), "{route}: {detail}");
    }
    let line = server.post("/v1/import", "application/x-ndjson", with("/calibrated_at", ago)).await.text();
    assert!(line.contains("/calibrated_at") && line.contains("plausibility.earliest"), "{line}");
}

#[tokio::test]
async fn every_fault_of_a_record_is_named_at_once() {
    let server = Server::start().await;
    let mut record = paper();
    record["imu"] = json!("");
    record["calibrated_at"] = json!("yesterday");
    record["gyros"][1]["e_sd"] = json!([-1, 0, -1]);
    record["gyros"][2]["serial"] = json!("\t");
    let answer = server.post_json("/v1/records", &record).await;
    let (status, _, mut pointers) = problem(&answer);
    pointers.sort();
    assert_eq!(status, 422);
    assert_eq!(pointers, ["/calibrated_at", "/gyros/1/e_sd/0", "/gyros/1/e_sd/2", "/gyros/2/serial", "/imu"]);
}

#[tokio::test]
async fn the_angle_of_a_wrong_input_axis_is_told() {
    let server = Server::start().await;
    let answer =
        server.post("/v1/records", "application/json", with("/gyros/2/e_pulse_per_arcsec", json!([1, 0, 0]))).await;
    let (_, detail, _) = problem(&answer);
    // The third gyro's input axis lies 54.7356 deg from X_b.
    assert!(detail.contains("54.73"), "{detail}");
}

#[tokio::test]
async fn a_body_of_the_wrong_kind_is_415() {
    let server = Server::start().await;
    for (route, kind) in [
        ("/v1/records", "text/plain"),
        ("/v1/records", "application/xml"),
        ("/v1/records", ""),
        ("/v1/bench-results", "multipart/form-data; boundary=x"),
        ("/v1/import", "application/json"),
        ("/v1/records", "application/json; charset=iso-8859-1"),
        ("/v1/import", "application/x-ndjson; Charset=\"GBK\""),
    ] {
        let answer = server.post(route, kind, paper().to_string()).await;
        assert_eq!(problem(&answer).0, 415, "{route} {kind}: {answer:?}");
    }
    for (kind, status) in [("application/json; charset=utf-8", 201), ("application/json;charset=\"UTF-8\"", 200)] {
        assert_eq!(server.post("/v1/records", kind, paper().to_string()).await.status, status, "{kind}");
    }
}

/// Python's http.client sends the head and the body by themselves, and goes on with the connection.
#[tokio::test]
async fn a_refusal_that_comes_before_the_body_leaves_the_connection_usable_or_says_that_it_closes() {
    let server = Server::start().await;
    let body = paper().to_string();
    let head = |route: &str, kind: &str, bytes: usize| {
        format!("POST {route} HTTP/1.1\r\nhost: localhost\r\ncontent-type: {kind}\r\ncontent-length: {bytes}\r\n\r\n")
    };
    for (route, kind, status) in [
        ("/v1/records", "text/plain", "415"),
        ("/v1/nowhere", "application/json", "404"),
        ("/v1/records", "application/json", "201"),
    ] {
        let mut stream = server.open_and_send(&head(route, kind, body.len())).await;
        tokio::time::sleep(Duration::from_millis(30)).await;
        for (sent, expected) in [(&*body, status), ("GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n", "200")] {
            stream.write_all(sent.as_bytes()).await.unwrap();
            let mut answer = Vec::new();
            while !answer.ends_with(b"}") && stream.read_buf(&mut answer).await.unwrap_or(0) > 0 {}
            let answer = String::from_utf8_lossy(&answer).to_lowercase();
            assert!(answer.starts_with(&format!("http/1.1 {expected} ")), "{route} {kind}: {answer}");
            assert!(!answer.contains("connection: close"), "{answer}");
        }
    }
    for bytes in [1000, 1_000_000] {
        let mut stream = server.open_and_send(&head("/v1/records", "text/plain", bytes)).await;
        let mut answer = String::new();
        stream.read_to_string(&mut answer).await.unwrap();
        assert!(answer.starts_with("HTTP/1.1 415 "), "{bytes}: {answer}");
        assert!(answer.to_lowercase().contains("connection: close"), "{bytes}: {answer}");
    }
}

#[tokio::test]
async fn a_body_over_the_limit_is_413_however_it_is_declared() {
    let server = Server::start().await;
    // Just over the limit: of a longer body the rest is never read, and the connection breaks under the sender.
    let large = "x".repeat((4 << 20) + 1);
    let declared = format!("content-length: {}\r\n\r\n{large}", large.len());
    let chunked = format!("transfer-encoding: chunked\r\n\r\n{:x}\r\n{large}", large.len());
    let routes = ["/v1/records", "/v1/campaigns", "/v1/bench-results"];
    for (route, body) in routes.into_iter().flat_map(|route| [(route, &declared), (route, &chunked)]) {
        let head = format!("POST {route} HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n");
        let mut stream = server.open_and_send(&format!("{head}{body}")).await;
        let mut answer = Vec::new();
        while !answer.ends_with(b"}") && stream.read_buf(&mut answer).await.unwrap_or(0) > 0 {}
        let answer = String::from_utf8_lossy(&answer).to_lowercase();
        assert!(answer.starts_with("http/1.1 413 "), "{answer}");
        assert!(answer.contains("content-type: application/problem+json"), "{answer}");
        assert!(answer.contains("\"title\":\"too large\""), "{answer}");
        assert!(answer.contains("may have 4194304 bytes, the limit that server.max_body_bytes sets"), "{answer}");
    }
    assert_eq!(server.post_json("/v1/records", &paper()).await.status, 201);
}

#[tokio::test]
async fn unknown_paths_methods_and_items_are_told() {
    let server = Server::start().await;
    for path in [
        "/v1/recods",
        "/v2/records",
        "/v1/gyros/NO-SUCH",
        "/v1/records/no-such-id",
        "/v1/gyros/NO-SUCH/trend?coefficient=D_I",
        "/v1/gyros/NO-SUCH/agreement",
        "/v1/records/%00",
        "/v1/gyros/%ff%fe",
    ] {
        let (status, ..) = problem(&server.get(path).await);
        assert!(matches!(status, 404 | 400), "{path}: {status}");
    }
    for (method, path) in [
        ("DELETE", "/v1/records"),
        ("PUT", "/v1/gyros"),
        ("GET", "/v1/import"),
        ("POST", "/v1/gyros"),
        ("PATCH", "/healthz"),
    ] {
        let answer = server.call(method, path, &[], Vec::new()).await;
        assert_eq!(problem(&answer).0, 405, "{method} {path}: {answer:?}");
        assert!(answer.headers.contains_key("allow"), "{method} {path}");
    }
}

#[tokio::test]
async fn bad_queries_are_refused_by_name() {
    let server = Server::start().await;
    server.post_json("/v1/records", &paper()).await;
    let trend = "/v1/gyros/LFG-0101/trend?coefficient=D_I";
    assert_eq!(server.get(trend).await.status, 200);
    for (query, name) in [
        ("coefficient=D_X", "coefficient"),
        ("coefficient=D_I&limit=0", "limit"),
        ("coefficient=D_I&limit=-1", "limit"),
        ("coefficient=D_I&limit=many", "limit"),
        ("coefficient=D_I&limit=99999999999999999999", "limit"),
        ("coefficient=D_I&cursor=garbage", "cursor"),
        ("coefficient=D_I&cursor=%00", "cursor"),
        ("coefficient=D_I&from=yesterday", "from"),
        ("coefficient=D_I&to=2026-13-01T00:00:00Z", "to"),
        ("coefficient=D_I&from=2026-03-02T00:00:00Z&to=2026-03-01T00:00:00Z", "from"),
        ("coefficient=D_I&format=xml", "format"),
        ("coefficient=D_I&colour=red", "colour"),
    ] {
        let answer = server.get(&format!("/v1/gyros/LFG-0101/trend?{query}")).await;
        let (status, detail, pointers) = problem(&answer);
        assert!(matches!(status, 400 | 422), "{query}: {status}");
        let named = detail.contains(name) || pointers.iter().any(|p| p.contains(name));
        assert!(named, "{query}: {detail} {pointers:?}");
    }
}

#[tokio::test]
async fn the_same_calibration_with_other_content_is_a_conflict_that_names_the_member() {
    let server = Server::start().await;
    let first = server.post_json("/v1/records", &paper()).await.created();
    let before = server.holdings().await;
    for (pointer, value) in [
        ("/station", json!("ST-9")),
        ("/gyros/1/g_pulse_per_s_g0/2", json!(-3.4082)),
        ("/gyros/2/serial", json!("LFG-0999")),
        ("/note", json!("measured again")),
    ] {
        let (status, _, pointers) =
            problem(&server.post("/v1/records", "application/json", with(pointer, value)).await);
        assert_eq!(status, 409);
        let named = pointers.iter().any(|p| pointer.starts_with(p.as_str()) && p.len() > 1);
        assert!(named, "{pointer}: {pointers:?}");
    }
    // The same content written otherwise is the same calibration.
    let rewritten =
        paper().to_string().replace("2026-03-01T08:00:00Z", "2026-03-01T16:00:00.000+08:00").replace("2.421", "2.4210");
    let again = server.post("/v1/records", "application/json", rewritten).await;
    assert_eq!(again.status, 200);
    assert_eq!(again.json()["id"], first["id"]);
    assert_eq!(server.holdings().await, before);
}

#[tokio::test]
async fn a_conflict_names_every_member_that_differs_of_the_gyro_in_its_slot() {
    let server = Server::start().await;
    let first = server.post_json("/v1/records", &paper()).await.json();
    let before = server.holdings().await;
    // The gyros in another order are the same record.
    let mut turned = paper();
    turned["gyros"].as_array_mut().unwrap().rotate_left(1);
    let again = server.post_json("/v1/records", &turned).await;
    assert_eq!((again.status, &again.json()["id"]), (200, &first["id"]), "{}", again.text());
    let line = server.post("/v1/import", "application/x-ndjson", turned.to_string()).await;
    assert_eq!((&line.json()["status"], &line.json()["id"]), (&json!(200), &first["id"]));
    // The first gyro of this one is the second of what is stored, the last its first.
    turned["station"] = json!("ST-9");
    turned["note"] = json!("measured again");
    turned["gyros"][0]["g_pulse_per_s_g0"][2] = json!(-3.4082);
    turned["gyros"][2]["serial"] = json!("LFG-0999");
    let answer = server.post_json("/v1/records", &turned).await;
    let (status, detail, mut pointers) = problem(&answer);
    pointers.sort();
    assert_eq!(status, 409);
    assert_eq!(pointers, ["/gyros/0/g_pulse_per_s_g0/2", "/gyros/2/serial", "/note", "/station"]);
    // For people, as they count.
    assert!(detail.ends_with("differ at gyros 1 g_pulse_per_s_g0 3, gyros 3 serial, note, station"), "{detail}");
    // A gyro that is stored is missing here; one of another slot is not stored.
    let mut fewer = paper();
    fewer["gyros"].as_array_mut().unwrap().remove(0);
    let (_, _, pointers) = problem(&server.post_json("/v1/records", &fewer).await);
    assert_eq!(pointers, ["/gyros"]);
    // Of many members so many are named, and how many more there are.
    let mut other = paper();
    for gyro in other["gyros"].as_array_mut().unwrap() {
        for name in ["e_pulse_per_arcsec", "g_pulse_per_s_g0"] {
            let nearly = gyro[name].as_array().unwrap().iter().map(|x| json!(x.as_f64().unwrap() * 1.0001 + 1e-6));
            gyro[name] = nearly.collect();
        }
        gyro["bias_pulse_per_s"] = json!(2.0);
    }
    let (_, detail, pointers) = problem(&server.post_json("/v1/records", &other).await);
    assert_eq!(pointers.len(), 20, "{pointers:?}");
    assert!(detail.ends_with(" … and 1 more"), "{detail}");
    assert_eq!(server.holdings().await, before);
}

#[tokio::test]
async fn good_lines_of_an_import_are_stored_and_bad_ones_named_by_line() {
    let server = Server::start().await;
    let record = |imu: &str| {
        let mut record = paper();
        record["imu"] = json!(imu);
        for gyro in 0..3 {
            record["gyros"][gyro]["serial"] = json!(format!("{imu}-{gyro}"));
        }
        record
    };
    let lines = [
        record("A").to_string(),
        "not json".into(),
        bench().to_string(),
        String::from_utf8(with("/colour", json!("red"))).unwrap(),
        record("B").to_string(),
        "{}".into(),
        record("A").to_string(),
        "{\"gyros\": [  ".into(),
    ];
    let answer = server.post("/v1/import", "application/x-ndjson", lines.join("\n") + "\n").await;
    assert_eq!((answer.status, answer.content_type.as_str()), (200, "application/x-ndjson"));
    let answers: Vec<Value> = answer.text().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let seen: Vec<_> = answers.iter().map(|a| (a["line"].as_u64().unwrap(), a["status"].as_u64().unwrap())).collect();
    assert_eq!(seen, [(1, 201), (2, 400), (3, 201), (4, 422), (5, 201), (6, 422), (7, 200), (8, 400)]);
    assert_eq!(answers[3]["error"]["errors"][0]["pointer"], "/colour");
    // The line is said once, by its number in what was sent.
    for (line, detail) in
        [(1, "not JSON: expected true, false or null at column 2"), (7, "it ends within an array at column 11")]
    {
        let said = answers[line]["error"]["errors"][0]["detail"].as_str().unwrap();
        assert!(said.ends_with(detail) && !said.contains("line"), "{said}");
        assert!(answers[line]["error"]["detail"].as_str().unwrap().ends_with(said), "{}", answers[line]);
    }
    let of_form = answers[3]["error"]["errors"][0]["detail"].as_str().unwrap();
    assert!(!of_form.contains("line"), "{of_form}");
    // As on the page that looks at a file first: there, too, each document stands beside the line on which it begins.
    let form = format!("text={}\r\n", lines.join("\r\n"));
    let preview = server.call("POST", "/import/preview", &[("content-type", "text/plain")], form).await.text();
    assert!(
        preview.contains("not JSON: expected true, false or null at column 2") && !preview.contains("at line 1"),
        "{preview}"
    );
    assert_eq!(answers[6]["id"], answers[0]["id"]);
    assert_eq!(server.get("/v1/gyros").await.json()["gyros"].as_array().unwrap().len(), 7);
}

#[tokio::test]
async fn what_looks_odd_but_is_legal_is_accepted() {
    let server = Server::start().await;
    let odd = [
        ("a leap second", "calibrated_at", json!("2016-12-31T23:59:60Z")),
        ("the largest offset", "calibrated_at", json!("2026-03-02T13:00:00+14:00")),
        ("nanoseconds", "calibrated_at", json!("2026-03-03T08:00:00.123456789Z")),
        ("a name in Chinese", "imu", json!("IMU-七")),
        ("a name of 64 characters", "imu", json!("七".repeat(64))),
        ("an apostrophe and a semicolon", "imu", json!("'; DROP TABLE record; --")),
        ("a note of many lines", "note", json!("one\ntwo\r\n\tthree \u{1F600}")),
        ("quotes and brackets", "operator", json!("\"<script>alert(1)</script>\" %s ${x}")),
    ];
    for (day, (what, member, value)) in odd.into_iter().enumerate() {
        let mut record = paper();
        record["calibrated_at"] = json!(format!("2026-04-{:02}T08:00:00Z", day + 1));
        record[member] = value.clone();
        let answer = server.post_json("/v1/records", &record).await;
        assert_eq!(answer.status, 201, "{what}: {}", answer.text());
        let stored = server.get(&format!("/v1/records/{}", answer.json()["id"].as_str().unwrap())).await.json();
        if member != "calibrated_at" {
            assert_eq!(stored["record"][member], value, "{what} comes back as it was sent");
        }
    }
    let marked = [b"\xef\xbb\xbf".to_vec(), with("/imu", json!("MARKED"))].concat();
    // JSON knows fewer blanks than other formats do; what it does not know could not be read again.
    let fed = [paper().to_string(), "\u{c}".into()].concat();
    assert_eq!(server.post("/v1/records", "application/json", fed).await.status, 400, "a form feed");
    let marked = server.post("/v1/records", "application/json", marked).await;
    assert_eq!(marked.status, 201, "a byte-order mark");
    let again = server.get(&format!("/v1/records/{}", marked.json()["id"].as_str().unwrap())).await;
    assert_eq!((again.status, &again.json()["record"]["imu"]), (200, &json!("MARKED")), "it can be read again");
    let mut one_gyro = paper();
    one_gyro["imu"] = json!("ONE");
    one_gyro["calibrated_at"] = json!("2026-03-04T08:00:00Z");
    one_gyro["gyros"] = json!([one_gyro["gyros"][2]]);
    assert_eq!(server.post_json("/v1/records", &one_gyro).await.status, 201);
}

#[tokio::test]
async fn parameters_out_of_requirement_are_stored_and_flagged() {
    let server = Server::start_with(&[("GYROWATCH_JUDGING__REQUIREMENTS", "true")]).await;
    // Table 4 asks for less than 13.23 pulse/(s g0).
    let answer = server.post("/v1/records", "application/json", with("/gyros/0/g_pulse_per_s_g0/2", json!(13.5))).await;
    assert_eq!(answer.status, 201);
    let answer = answer.json();
    let flagged = answer["verdicts"].as_array().unwrap().iter().any(|v| {
        v["serial"] == "LFG-0101" && v["rule"] == "requirement" && v["coefficient"] == "G" && v["state"] == "exceeded"
    });
    assert!(flagged, "{}", answer["verdicts"]);
}

#[tokio::test]
async fn a_sender_that_goes_silent_is_cut_and_harms_nobody() {
    let server = Server::start().await;
    let silent = server.open_and_send("POST /v1/records HTTP/1.1\r\nHost: localhost\r\nContent-Le").await;
    assert_eq!(server.get("/healthz").await.status, 200);
    let cut = tokio::time::timeout(Duration::from_secs(15), support::closed(silent)).await;
    assert!(cut.is_ok(), "a header that never ends is cut within ten seconds");
}

/// Brackets and braces one within another: how deep, which, and whether they are closed, as chance will have it.
fn nest(chance: &mut ChaCha8Rng) -> (usize, String) {
    let depth = 10_f64.powf(chance.random_range(0.0..6.0)) as usize;
    // More braces than that make a body over the limit.
    let of_braces = if depth > 500_000 { 0.0 } else { *[0.0, 0.5, 1.0].choose(chance).unwrap() };
    let braces: Vec<bool> = (0..depth).map(|_| chance.random_bool(of_braces)).collect();
    let mut text: String = braces.iter().map(|brace| if *brace { "{\"a\":" } else { "[" }).collect();
    text.push('1');
    let mut ends: Vec<char> = braces.iter().rev().map(|brace| if *brace { '}' } else { ']' }).collect();
    match chance.random_range(0..8) {
        0 => ends.clear(),
        1 => ends.truncate(chance.random_range(0..depth)),
        2 => ends.push(']'),
        3 => ends[chance.random_range(0..depth)] = '!',
        _ => {}
    }
    text.extend(ends);
    (depth, text)
}

/// `scripts/soak nesting`: as a whole document, as a member that is known or not, on every way in.
#[tokio::test]
async fn nesting_of_any_depth_and_kind_is_refused_and_nothing_is_kept() {
    let rounds = asked("GYROWATCH_SOAK_ROUNDS", 60);
    let server = Server::start().await;
    assert_eq!(server.post_json("/v1/records", &paper()).await.status, 201);
    let ways = [
        ("/v1/records", paper()),
        ("/v1/campaigns", document("practice/campaign-00.json")),
        ("/v1/bench-results", bench()),
        ("/v1/hooks", json!({"name": "line", "url": "http://127.0.0.1:9/", "kind": "standard-webhooks"})),
        ("/v1/tokens", json!({"name": "a", "role": "station"})),
        ("/v1/gyros/LFG-0101/events", json!({"event": "note", "reason": "seen", "at": "2026-03-02T08:00:00Z"})),
        ("/v1/gyros/LFG-0101/baseline", json!({"reason": "repaired", "at": "2026-03-02T08:00:00Z"})),
        ("/v1/import", paper()),
    ];
    let (before, mut deepest) = (server.holdings().await, 0);
    for round in 0..rounds {
        let mut chance = ChaCha8Rng::seed_from_u64(seed(round));
        let (path, mut document) = ways.choose(&mut chance).unwrap().clone();
        let (depth, nest) = nest(&mut chance);
        deepest = deepest.max(depth);
        let members: Vec<String> = document.as_object().unwrap().keys().cloned().collect();
        let body = match chance.random_range(0..3) {
            0 => nest,
            of_them => {
                let member = if of_them == 1 { "x" } else { members.choose(&mut chance).unwrap() };
                document[member] = "HERE".into();
                document.to_string().replacen("\"HERE\"", &nest, 1)
            }
        };
        let what = format!("seed {}: {depth} deep to {path}", seed(round));
        let kind = if path == "/v1/import" { "application/x-ndjson" } else { "application/json" };
        let answer = server.post(path, kind, body).await;
        let statuses: Vec<u16> = match (path, answer.status) {
            ("/v1/import", 200) => {
                let lines = answer.text();
                let lines = lines.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
                lines.map(|line| line["status"].as_u64().unwrap() as u16).collect()
            }
            (_, status) => vec![status],
        };
        assert!(!statuses.is_empty(), "{what}");
        assert!(statuses.iter().all(|status| matches!(status, 400 | 413 | 422)), "{what}: {statuses:?}");
    }
    assert_eq!(server.holdings().await, before);
    assert_eq!(server.get("/healthz").await.status, 200);
    println!("nesting: {rounds} documents, at the most {deepest} deep; each refused, nothing kept");
}

/// What a fault makes of the document.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fault {
    /// It is no JSON.
    Syntax,
    /// It is JSON of another form, and what it says is not looked at. It can be read on past the fault.
    Form,
    /// As [`Fault::Form`], and the end of reading: a number beyond all numbers, a member given twice.
    Last,
    /// It says what cannot be.
    Content,
}
use Fault::{Content, Form, Last, Syntax};

/// What may stand where something else belongs.
const NO_NUMBER: [(&str, Fault); 20] = [
    ("NaN", Syntax),
    ("-Infinity", Syntax),
    ("+1", Syntax),
    ("01", Syntax),
    (".5", Syntax),
    ("1.", Syntax),
    ("1e", Syntax),
    ("0x1p3", Syntax),
    ("--1", Syntax),
    ("", Syntax),
    ("1e999", Last),
    ("-1e400", Last),
    ("1e308", Content),
    ("-1e308", Content),
    ("\"1.0\"", Form),
    ("null", Form),
    ("true", Form),
    ("[]", Form),
    ("{}", Form),
    ("{\"x\":[1]}", Form),
];
const NO_NAME: [(&str, Fault); 13] = [
    ("\"\\ud800\"", Last),
    ("\"\\x41\"", Syntax),
    ("\"a\nb\"", Syntax),
    ("'a'", Syntax),
    ("\"", Syntax),
    ("7", Form),
    ("null", Form),
    ("[\"a\"]", Form),
    ("{\"x\":1}", Form),
    ("\"\"", Content),
    ("\"\\u0000\"", Content),
    ("\"\\t\\n\"", Content),
    ("\"xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx\"", Content),
];
const NO_TIME: [(&str, Fault); 8] = [
    ("\"2026-02-30T08:00:00Z\"", Content),
    ("\"2026-03-01T08:00:00\"", Content),
    ("\"2026-03-01T25:00:00Z\"", Content),
    ("\"9999-12-31T23:59:59Z\"", Content),
    ("\"yesterday\"", Content),
    ("\"\"", Content),
    ("1772352000", Form),
    ("2026-03-01", Syntax),
];

/// Places of a record where a value stands, in order.
fn leaves(value: &Value, at: &str, found: &mut Vec<String>) {
    match value {
        Value::Object(members) => members.iter().for_each(|(name, of)| leaves(of, &format!("{at}/{name}"), found)),
        Value::Array(items) => items.iter().enumerate().for_each(|(i, of)| leaves(of, &format!("{at}/{i}"), found)),
        _ => found.push(at.to_owned()),
    }
}

/// The document with other text at some places, and further members in some objects.
fn written(value: &Value, at: &str, other: &BTreeMap<String, &str>, further: &BTreeMap<String, String>) -> String {
    if let Some(text) = other.get(at) {
        return (*text).to_owned();
    }
    let below = |name: &str, value: &Value| written(value, &format!("{at}/{name}"), other, further);
    match value {
        Value::Object(members) => {
            let mut all: Vec<String> =
                members.iter().map(|(name, of)| format!("\"{name}\":{}", below(name, of))).collect();
            all.extend(further.get(at).cloned());
            format!("{{{}}}", all.join(","))
        }
        Value::Array(items) => {
            let items: Vec<String> = items.iter().enumerate().map(|(i, of)| below(&i.to_string(), of)).collect();
            format!("[{}]", items.join(","))
        }
        value => value.to_string(),
    }
}

/// A record with up to four faults: its text, and where each is.
fn faulty(chance: &mut ChaCha8Rng) -> (String, BTreeMap<String, Fault>) {
    let (record, mut places) = (paper(), Vec::new());
    leaves(&record, "", &mut places);
    let (mut other, mut further, mut faults) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    let count = chance.random_range(1..4);
    for place in places.sample(chance, count).cloned().collect::<Vec<_>>() {
        let of_few = place.ends_with("slot") || place.ends_with("geometry");
        let instead: &[(&str, Fault)] = match record.pointer(&place).unwrap() {
            Value::Number(_) => &NO_NUMBER,
            _ if place.ends_with("_at") => &NO_TIME,
            _ => &NO_NAME,
        };
        let (text, fault) = *instead.choose(chance).unwrap();
        other.insert(place.clone(), text);
        // One word of a few that are known is a matter of form.
        faults.insert(place, if of_few && fault == Content { Form } else { fault });
    }
    let (object, member) =
        *[("", "imu"), ("/gyros/1", "slot"), ("", "colour"), ("/gyros/2", "colour")].choose(chance).unwrap();
    let place = format!("{object}/{member}");
    if chance.random_bool(0.3) && !faults.contains_key(&place) {
        further.insert(object.to_owned(), format!("\"{member}\":\"G1\""));
        faults.insert(place, if member == "colour" { Form } else { Last });
    }
    (written(&record, "", &other, &further), faults)
}

/// `scripts/soak bad-values`.
#[tokio::test]
async fn faults_in_any_combination_are_named_at_their_places_and_nothing_is_kept() {
    let rounds = asked("GYROWATCH_SOAK_ROUNDS", 300);
    let server = Server::start().await;
    let before = server.holdings().await;
    let (mut no_json, mut faults) = (0, 0);
    for round in 0..rounds {
        let (text, places) = faulty(&mut ChaCha8Rng::seed_from_u64(seed(round)));
        let what = format!("seed {}: {text}", seed(round));
        let answer = server.post("/v1/records", "application/json", text).await;
        let (status, detail, pointers) = problem(&answer);
        let what = format!("{what}: {}", answer.text());
        let any = |kind: Fault| places.values().any(|fault| *fault == kind);
        if any(Syntax) {
            assert!(status == 400 && detail.contains("JSON"), "{what}");
            no_json += 1;
            continue;
        }
        assert_eq!(status, 422, "{what}");
        let is_named = |place: &str| {
            pointers.iter().any(|named| !named.is_empty() && (place.starts_with(named) || named.starts_with(place)))
        };
        // Content is looked at where the form is right, and G of a gyro where its E is plausible.
        let of_form = any(Form) || any(Last);
        let hidden = |place: &str| {
            of_form || place.starts_with("/gyros/") && pointers.iter().any(|named| named.get(..8) == place.get(..8))
        };
        let missed = |place: &str, fault: Fault| !(is_named(place) || fault == Content && hidden(place));
        let missing = places.iter().filter(|(place, fault)| missed(place, **fault)).count();
        let named = places.keys().filter(|place| is_named(place)).count();
        assert!(missing == 0 || (any(Last) && named > 0), "{what}: {missing} not named");
        faults += named;
    }
    assert_eq!(server.holdings().await, before);
    println!(
        "bad values: {rounds} records, {no_json} no JSON, {faults} faults in the others; each named, nothing kept"
    );
}

/// A record of one IMU, which a word in its note makes one that the database refuses.
fn of_imu(number: usize, day: usize, poisoned: bool) -> Value {
    let mut record = paper();
    record["imu"] = json!(format!("IMU-{number}"));
    for (i, gyro) in record["gyros"].as_array_mut().unwrap().iter_mut().enumerate() {
        gyro["serial"] = json!(format!("G-{number}-{i}"));
    }
    let at = jiff::Timestamp::from_second(1_500_000_000 + 3600 * day as i64).unwrap();
    record["calibrated_at"] = json!(at.to_string());
    record["note"] = json!(if poisoned { "POISON" } else { "good" });
    record
}

/// Status and answer to each of `bodies`: the first `imported` of them are sent as lines of one import, the others as
/// posts, all at once.
async fn sent(server: &Server, bodies: &[String], imported: usize) -> Vec<(u16, Value)> {
    let (lines, posts) = bodies.split_at(imported);
    let import = async {
        let answer = server.post("/v1/import", "application/x-ndjson", lines.join("\n")).await.text();
        let of_lines = answer.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        of_lines.map(|line| (line["status"].as_u64().unwrap() as u16, line)).collect::<Vec<_>>()
    };
    let posts = posts.iter().map(|body| server.post("/v1/records", "application/json", body.clone()));
    let (mut answers, posted) = futures::future::join(import, futures::future::join_all(posts)).await;
    answers.extend(posted.iter().map(|answer| (answer.status, answer.json())));
    answers
}

/// `scripts/soak poison`. `tests/postgres.rs` has one for PostgreSQL.
#[tokio::test]
async fn a_record_that_the_database_refuses_takes_no_other_of_its_group_along() {
    if cluster::is_wanted() {
        return;
    }
    let groups = asked("GYROWATCH_SOAK_ROUNDS", 4);
    let server = Server::start().await;
    behind::execute(&server.database(), behind::POISON).await;
    // The larger ones are judged while another is being written.
    let sizes = [64, 320];
    let (mut good, mut poisoned, mut unreadable, mut ids) = ([0_i64; 320], 0, 0, BTreeSet::new());
    for group in 0..groups {
        let mut chance = ChaCha8Rng::seed_from_u64(seed(group));
        let of_poison = chance.random_range(0.01..0.2);
        let size = sizes[group % sizes.len()];
        let kinds: Vec<u16> = (0..size)
            .map(|_| match chance.random_bool(of_poison) {
                false => 201,
                true => *[500, 500, 400].choose(&mut chance).unwrap(),
            })
            .collect();
        let bodies: Vec<String> = kinds
            .iter()
            .enumerate()
            .map(
                |(number, kind)| {
                    if *kind == 400 { "{".to_owned() } else { of_imu(number, group, *kind == 500).to_string() }
                },
            )
            .collect();
        let imported = *[0, size / 2, size].choose(&mut chance).unwrap();
        let answers = sent(&server, &bodies, imported).await;
        let what = format!("seed {}", seed(group));
        assert_eq!(answers.iter().map(|answer| answer.0).collect::<Vec<_>>(), kinds, "{what}");
        for (number, (status, answer)) in answers.into_iter().enumerate() {
            match status {
                201 => {
                    // What was made ready for a group that was refused as a whole has come to nothing.
                    let id = answer["id"].as_str().unwrap().to_owned();
                    let stored = server.get(&format!("/v1/records/{id}")).await.json();
                    assert_eq!(stored["record"]["imu"], json!(format!("IMU-{number}")), "{what}: {id}");
                    if number >= imported {
                        assert_eq!(stored["verdicts"], answer["verdicts"], "{what}: {id}");
                        assert_eq!(stored["separations"], answer["separations"], "{what}: {id}");
                    }
                    assert!(ids.insert(id), "{what}: an identifier twice");
                    good[number] += 1;
                }
                500 => poisoned += 1,
                _ => unreadable += 1,
            }
        }
    }
    for (number, good) in good.iter().enumerate() {
        for slot in 0..3 {
            let gyro = server.get(&format!("/v1/gyros/G-{number}-{slot}")).await.json();
            assert_eq!(gyro["calibrations"].as_i64().unwrap_or(0), *good, "G-{number}-{slot}");
        }
    }
    let stored = server.holdings().await.into_iter().find(|(table, _)| table == "record").unwrap().1;
    assert_eq!(stored, ids.len() as i64);
    println!(
        "poison: {groups} groups of 64 and 320: {stored} stored, {poisoned} refused by the database, {unreadable} unreadable"
    );
}
