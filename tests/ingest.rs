//! What a station sees: records are accepted, judged and kept, or refused with the place named.

use gyrowatch::config::{Config, SlotRequirements};
use reqwest::Method;
use reqwest::header::CONTENT_TYPE;

use crate::lab::{Answer, JSON, NDJSON, assert_close, bench, tables_3_and_4, verdict};
use crate::prelude::*;

#[tokio::test]
async fn the_papers_record_is_separated_by_both_methods_to_the_golden_figures() {
    let lab = Lab::with(|config| config.judging.requirements = true).await;
    let answer = lab.posts(&tables_3_and_4()).await;
    let golden = [
        ("G1", "8", [2.957643, 4.618005, 0.075874], [2.958219, 4.618253]),
        ("G2", "10", [0.688549, 3.898225, 0.232169], [0.688255, 3.898324]),
        ("G3", "13", [1.191559, -6.752265, -0.019514], [1.187903, -6.752266]),
    ];
    for (separation, (slot, branch, rigid, published)) in answer["separations"].as_array().unwrap().iter().zip(golden) {
        assert_eq!((&separation["slot"], &separation["method"]), (&json!(slot), &json!("rigid")));
        for (member, figure) in ["d_i", "d_s", "d_o"].iter().zip(rigid) {
            assert_close(&separation[member]["value"], figure, 1e-6);
        }
        assert_eq!(separation["published"]["branch"], branch);
        assert_close(&separation["published"]["d_i"], published[0], 1e-6);
        assert_close(&separation["published"]["d_s"], published[1], 1e-6);
    }
    let step = verdict(&answer, "LFG-0101", "D_I", "step");
    assert_eq!(step["state"], "indeterminate");
    assert!(step["reason"].as_str().unwrap().contains("needs 2 records and has 1."), "{step}");
    let baseline = verdict(&answer, "LFG-0101", "D_I", "baseline");
    assert!(baseline["reason"].as_str().unwrap().contains("needs 4 records and has 1."), "{baseline}");
    let requirement = verdict(&answer, "LFG-0103", "G", "requirement");
    assert_eq!(requirement["state"], "within", "Table 4 calls all three gyros conforming");
}

#[tokio::test]
async fn a_stored_record_is_found_at_its_location_as_it_was_sent_and_answered() {
    let lab = Lab::open().await;
    let text = std::fs::read_to_string("tests/data/paper.json").unwrap();
    let posted = lab.post_text("/v1/records", JSON, text.clone()).await;
    let answer = posted.created();
    let location = posted.header("location");
    assert_eq!(location, format!("/v1/records/{}", answer["id"].as_str().unwrap()));
    let found = lab.get(location).await;
    assert!(found.text.contains(text.trim()), "the record word for word");
    let found = found.ok();
    for member in ["id", "separations", "verdicts"] {
        assert_eq!(found[member], answer[member], "{member}");
    }
    lab.get("/v1/records/0000000000000").await.refused(404);
    lab.get("/v1/records/nonsense").await.refused(404);
}

#[tokio::test]
async fn sending_again_does_no_harm_however_it_is_written() {
    let mut lab = Lab::open().await;
    let first = lab.posts(&tables_3_and_4()).await;
    let again = lab.post("/v1/records", &tables_3_and_4()).await;
    assert_eq!(again.ok(), first);

    let mut otherwise = tables_3_and_4();
    otherwise["calibrated_at"] = json!("2026-03-01T16:00:00.000+08:00");
    otherwise["note"] = Value::Null;
    otherwise["gyros"][0]["p_pulse_per_s_g02"] = json!([0, 0, 0]);
    assert_eq!(lab.post("/v1/records", &otherwise).await.ok()["id"], first["id"]);

    lab.restart().await;
    assert_eq!(lab.post("/v1/records", &tables_3_and_4()).await.ok(), first, "after a restart too");
    assert_eq!(lab.sees_trend("LFG-0101", "").await.len(), 1);
}

#[tokio::test]
async fn other_content_under_the_same_key_is_refused_and_the_difference_named() {
    let lab = Lab::open().await;
    let first = lab.posts(&tables_3_and_4()).await;
    let mut changed = tables_3_and_4();
    changed["gyros"][1]["g_pulse_per_s_g0"][2] = json!(-3.4082);
    let refused = lab.post("/v1/records", &changed).await;
    assert_eq!(refused.refused(409), ["/gyros/1/g_pulse_per_s_g0/2"]);
    assert_eq!(refused.json()["existing"], first["id"]);
    let mut noted = tables_3_and_4();
    noted["note"] = json!("changed");
    assert_eq!(lab.post("/v1/records", &noted).await.refused(409), ["/note"]);
    assert_eq!(
        lab.get(&format!("/v1/records/{}", first["id"].as_str().unwrap())).await.ok()["record"],
        tables_3_and_4()
    );
}

#[tokio::test]
async fn one_record_sent_sixteen_times_at_once_is_stored_once() {
    let lab = Lab::open().await;
    for round in 0..10 {
        let sent = record("IMU-1", &day(round), &[("G1", "A", 1.0, 2.0)]);
        let posts = (0..16).map(|_| lab.post("/v1/records", &sent));
        let answers: Vec<Answer> = futures::future::join_all(posts).await;
        let created = answers.iter().filter(|answer| answer.status == 201).count();
        assert_eq!(created, 1, "{:?}", answers.iter().map(|a| a.status).collect::<Vec<_>>());
        assert!(answers.iter().all(|answer| matches!(answer.status, 200 | 201)));
        let ids: std::collections::HashSet<String> = answers.iter().map(|a| a.json()["id"].to_string()).collect();
        assert_eq!(ids.len(), 1);
    }
    assert_eq!(lab.sees_trend("A", "").await.len(), 10);
}

#[tokio::test]
async fn an_idempotency_key_answers_for_its_request_and_for_no_other() {
    let lab = Lab::open().await;
    let send = |body: Value| {
        let request = lab.request(Method::POST, "/v1/records").header("idempotency-key", "k-1");
        Answer::of(request.header(CONTENT_TYPE, JSON).body(body.to_string()))
    };
    let first = send(tables_3_and_4()).await.created();
    assert_eq!(send(tables_3_and_4()).await.ok()["id"], first["id"]);
    let other = send(record("IMU-1", &day(1), &[("G1", "A", 1.0, 2.0)])).await;
    other.refused(409);
    assert_eq!(other.json()["existing"], first["id"]);
    lab.get("/v1/gyros/A").await.refused(404);
    let long = lab.request(Method::POST, "/v1/records").header("idempotency-key", "k".repeat(256));
    Answer::of(long.header(CONTENT_TYPE, JSON).body("{}")).await.refused(422);
}

#[tokio::test]
async fn a_key_that_was_answered_with_what_was_there_already_is_used_as_well() {
    let lab = Lab::open().await;
    let send = |path: &str, key: &str, body: String| {
        let request = lab.request(Method::POST, path).header("idempotency-key", key);
        Answer::of(request.header(CONTENT_TYPE, JSON).body(body))
    };
    let of_day = |at: i64, d_i: f64| record("IMU-1", &day(at), &[("G1", "A", d_i, 2.0)]);
    let of_bench = |at: i64, d_i: f64| bench("A", &day(at), d_i, 2.0);
    for (path, [sent, differs, other]) in [
        ("/v1/records", [of_day(0, 1.0), of_day(0, 1.5), of_day(1, 1.0)]),
        ("/v1/bench-results", [of_bench(2, 1.0), of_bench(2, 1.5), of_bench(3, 1.0)]),
    ] {
        let key = |of: &str| format!("{of}-{}", path.len());
        let id = lab.post(path, &sent).await.created()["id"].clone();
        let written_otherwise = serde_json::to_string_pretty(&sent).unwrap();
        for (key, body) in [(key("same"), sent.to_string()), (key("otherwise"), written_otherwise)] {
            assert_eq!(send(path, &key, body.clone()).await.ok()["id"], id);
            let reused = send(path, &key, other.to_string()).await;
            reused.refused(409);
            assert_eq!(reused.json()["existing"], id);
            assert_eq!(send(path, &key, body).await.ok()["id"], id);
        }
        // What was refused has used no key.
        send(path, &key("refused"), differs.to_string()).await.refused(409);
        send(path, &key("refused"), other.to_string()).await.created();
    }
}

#[tokio::test]
async fn many_stations_posting_at_once_lose_nothing() {
    let mut lab = Lab::open().await;
    let records: Vec<Value> = (0..400)
        .map(|i| {
            let (imu, serial) = (format!("IMU-{}", i % 20), format!("LFG-{}", i % 20));
            record(&imu, &day(i / 20), &[("G1", &serial, f64::from(i as i32) * 1e-4, 2.0)])
        })
        .collect();
    let answers = futures::future::join_all(records.iter().map(|record| lab.post("/v1/records", record))).await;
    assert!(answers.iter().all(|answer| answer.status == 201), "{:?}", answers.iter().find(|a| a.status != 201));
    lab.restart().await;
    for imu in 0..20 {
        let trend = lab.sees_trend(&format!("LFG-{imu}"), "").await;
        assert_eq!(trend.len(), 20);
        for (k, point) in trend.iter().enumerate() {
            assert_eq!(point["calibrated_at"], day(k as i64));
            assert_close(&point["value"], (k * 20 + imu) as f64 * 1e-4, 1e-12);
        }
    }
}

#[tokio::test]
async fn what_is_required_is_what_is_configured() {
    let own: SlotRequirements =
        serde_json::from_value(json!({"all": {"e_norm": [1.5, 2.0]}, "G3": {"g_z": []}})).expect("bounds");
    let lab = Lab::with(|config| (config.judging.requirements, config.judging.requirement) = (true, own)).await;
    let mut heavy = tables_3_and_4();
    heavy["gyros"][2]["g_pulse_per_s_g0"][2] = json!(-14.0);
    let answer = lab.posts(&heavy).await;
    let e = verdict(&answer, "LFG-0101", "E", "requirement");
    assert_eq!((&e["state"], &e["limit"]), (&json!("exceeded"), &json!(1.5)), "|E| of 1.4676: {e}");
    assert_eq!(verdict(&answer, "LFG-0103", "G", "requirement")["state"], "within", "nothing is required of G_z");
}

#[tokio::test]
async fn a_record_out_of_requirement_is_stored_and_flagged() {
    let lab = Lab::with(|config| config.judging.requirements = true).await;
    let mut heavy = tables_3_and_4();
    heavy["gyros"][2]["g_pulse_per_s_g0"][2] = json!(-14.0);
    heavy["gyros"][0]["e_pulse_per_arcsec"][0] = json!(0.8600);
    let answer = lab.posts(&heavy).await;
    let g = verdict(&answer, "LFG-0103", "G", "requirement");
    assert_eq!((&g["state"], &g["value"], &g["limit"]), (&json!("exceeded"), &json!(-14.0), &json!(-13.23)));
    assert!(g["reason"].as_str().unwrap().contains("G_z"), "{g}");
    assert_eq!(verdict(&answer, "LFG-0101", "E", "requirement")["state"], "exceeded");
    assert_eq!(verdict(&answer, "LFG-0102", "E", "requirement")["state"], "within");
    let id = answer["id"].as_str().unwrap();
    assert_eq!(lab.get(&format!("/v1/records/{id}")).await.ok()["verdicts"], answer["verdicts"]);
}

#[tokio::test]
async fn bad_records_are_refused_with_the_place_and_nothing_is_stored() {
    let lab = Lab::open().await;
    let with = |pointer: &str, value: Value| {
        let mut document = tables_3_and_4();
        let (parent, member) = pointer.rsplit_once('/').unwrap();
        match document.pointer_mut(parent).unwrap() {
            Value::Array(items) => items[member.parse::<usize>().unwrap()] = value,
            object => object[member] = value,
        }
        document
    };
    let cases = [
        ("/unknown", json!(1)),
        ("/imu", json!(7)),
        ("/imu", json!("")),
        ("/imu", json!("x".repeat(65))),
        ("/station", json!("ST\u{0}2")),
        ("/calibrated_at", json!("2026-03-01T08:00:00")),
        ("/calibrated_at", json!("2126-03-01T08:00:00Z")),
        ("/calibrated_at", json!("2026-11-22T12:00:01Z")),
        ("/geometry", json!("cubic")),
        ("/gyros/1/slot", json!("G1")),
        ("/gyros/1/serial", json!("LFG-0101")),
        ("/gyros/0/serial", json!("s".repeat(1_000_000))),
        ("/gyros/0/e_pulse_per_arcsec", json!([1, 2])),
        ("/gyros/0/e_pulse_per_arcsec", json!([1, 2, 3, 4])),
        ("/gyros/0/e_pulse_per_arcsec", json!([0, 0, 0])),
        ("/gyros/0/e_pulse_per_arcsec", json!([1e308, 1e308, 1e308])),
        ("/gyros/0/e_pulse_per_arcsec", json!([-0.8473, 0.6011, -1.0367])),
        ("/gyros/0/g_pulse_per_s_g0", json!([1e308, 0, 0])),
        ("/temperature_c", json!("warm")),
    ];
    for (pointer, value) in cases {
        let shown = value.to_string();
        let refused = lab.post("/v1/records", &with(pointer, value)).await.refused(422);
        assert!(
            refused.iter().any(|p| p.starts_with(pointer)),
            "{pointer} {}: {refused:?}",
            &shown[..shown.len().min(60)]
        );
    }
    let sd = lab.post("/v1/records", &with("/gyros/0/e_sd", json!([1e-4, -1e-4, 0]))).await;
    assert_eq!(sd.refused(422), ["/gyros/0/e_sd/1"]);
    let off = lab.post("/v1/records", &with("/gyros/0/e_pulse_per_arcsec", json!([1.0367, -0.6011, 0.8473]))).await;
    off.refused(422);
    assert!(off.text.contains("deg from the input axis"), "the angle is named: {}", off.text);
    assert!(!off.text.contains("interchanged"), "it fits no other: {}", off.text);
    let other_axes = tables_3_and_4()["gyros"][2]["e_pulse_per_arcsec"].clone();
    let swapped = lab.post("/v1/records", &with("/gyros/0/e_pulse_per_arcsec", other_axes)).await;
    swapped.refused(422);
    assert!(swapped.text.contains("it fits that of G3: have two been interchanged?"), "{}", swapped.text);
    let mut campaign = tables_3_and_4();
    campaign["dwells"] = json!([]);
    let elsewhere = lab.post("/v1/records", &campaign).await;
    assert_eq!(elsewhere.refused(422), [""]);
    assert!(elsewhere.text.contains("send it to /v1/campaigns"), "{}", elsewhere.text);
    let back = lab.post("/v1/campaigns", &tables_3_and_4()).await;
    back.refused(422);
    assert!(back.text.contains("this is a calibration record: send it to /v1/records"), "{}", back.text);
    assert_eq!(lab.get("/v1/gyros").await.ok()["gyros"], json!([]));
}

#[tokio::test]
async fn what_is_no_record_at_all_is_refused_in_the_common_form() {
    let lab = Lab::with(|config| config.server.max_body_bytes = 100_000).await;
    let text = tables_3_and_4().to_string();
    for not_json in ["", "{", "NaN", "{\"imu\": Infinity}", &text[..text.len() - 1], &format!("{text}x")] {
        lab.post_text("/v1/records", JSON, not_json.to_owned()).await.refused(400);
    }
    lab.post_text("/v1/records", JSON, &b"{\"imu\": \"\xff\"}"[..]).await.refused(400);
    let huge = text.replace("2.421", "1e400");
    assert_eq!(lab.post_text("/v1/records", JSON, huge).await.refused(422), ["/gyros/0/g_pulse_per_s_g0/0"]);
    let twice = text.replacen("\"imu\"", "\"imu\":\"X\",\"imu\"", 1);
    assert_eq!(lab.post_text("/v1/records", JSON, twice).await.refused(422), ["/imu"]);
    for deep in [format!("{{\"imu\":{}", "[".repeat(40_000)), format!("{{\"x\":{}", "{\"a\":".repeat(10_000))] {
        assert!(matches!(lab.post_text("/v1/records", JSON, deep).await.status, 400 | 422));
    }
    lab.post_text("/v1/records", JSON, "x".repeat(100_001)).await.refused(413);
    lab.post_text("/v1/records", "text/plain", text.clone()).await.refused(415);
    let coded = |coding: &str, body: Vec<u8>| {
        let request = lab.request(Method::POST, "/v1/records").header(CONTENT_TYPE, JSON);
        Answer::of(request.header("content-encoding", coding).body(body))
    };
    coded("br", text.clone().into_bytes()).await.refused(415);
    coded("gzip", text.clone().into_bytes()).await.refused(400);
    coded("gzip", gzip(&"x".repeat(100_001))).await.refused(413);
    let mut torn = gzip(&text);
    torn.truncate(torn.len() / 2);
    coded("gzip", torn).await.refused(400);
    coded("gzip", [gzip(&text), b"junk".to_vec()].concat()).await.refused(400);
    lab.get("/v1/nothing").await.refused(404);
    let no_text = lab.get("/v1/gyros/%ff").await;
    no_text.refused(400);
    assert_eq!(no_text.json()["code"], "path_not_utf8");
    let wrong_method = Answer::of(lab.request(Method::DELETE, "/v1/records")).await;
    wrong_method.refused(405);
    assert!(wrong_method.header("allow").contains("POST"));
    lab.post_text("/v1/records", "application/json; charset=utf-8", text.clone()).await.created();
    let (begin, end) = text.split_at(text.len() / 2);
    for (coding, body) in [("gzip", gzip(&text)), ("x-gzip", gzip(&text)), ("GZIP", [gzip(begin), gzip(end)].concat())]
    {
        assert_eq!(coded(coding, body).await.status, 200, "{coding}: the same record");
    }
}

fn gzip(text: &str) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packed, text.as_bytes()).unwrap();
    packed.finish().unwrap()
}

#[tokio::test]
async fn a_gyro_cannot_be_calibrated_in_two_imus_at_the_same_time() {
    let lab = Lab::open().await;
    let first = lab.posts(&record("IMU-1", &day(0), &[("G1", "A", 1.0, 2.0), ("G2", "B", 1.0, 2.0)])).await;
    let elsewhere = record("IMU-2", &day(0), &[("G1", "C", 1.0, 2.0), ("G2", "B", 1.0, 2.0)]);
    let refused = lab.post("/v1/records", &elsewhere).await;
    assert_eq!(refused.refused(409), ["/gyros/1/serial"]);
    assert_eq!(refused.json()["existing"], first["id"]);
    lab.get("/v1/gyros/C").await.refused(404);
}

#[tokio::test]
async fn an_import_answers_every_line_in_order_and_stores_the_good_ones() {
    let mut lab = Lab::open().await;
    let good = record("IMU-1", &day(0), &[("G1", "A", 1.0, 2.0)]);
    let mut changed = good.clone();
    changed["note"] = json!("changed");
    let mut unknown = record("IMU-2", &day(0), &[("G1", "B", 1.0, 2.0)]);
    unknown["gyros"][0]["colour"] = json!("red");
    let lines = [
        good.to_string(),
        "not json".into(),
        String::new(),
        good.to_string(),
        changed.to_string(),
        unknown.to_string(),
        bench("A", &day(3), 1.001, 2.002).to_string(),
        "{\"method\":\"torque_feedback\",\"measured_at\":\"2026\"}".into(),
        record("IMU-1", &day(1), &[("G1", "A", 1.0, 2.0)]).to_string(),
    ];
    let answers = lab.post_text("/v1/import", NDJSON, lines.join("\r\n")).await;
    assert_eq!(answers.header("content-type"), NDJSON);
    let answers = answers.lines();
    let statuses: Vec<(u64, u64)> =
        answers.iter().map(|a| (a["line"].as_u64().unwrap(), a["status"].as_u64().unwrap())).collect();
    assert_eq!(statuses, [(1, 201), (2, 400), (4, 200), (5, 409), (6, 422), (7, 201), (8, 422), (9, 201)]);
    assert_eq!(answers[2]["id"], answers[0]["id"]);
    assert_eq!(answers[3]["error"]["errors"][0]["pointer"], "/note");
    assert_eq!(answers[4]["error"]["errors"][0]["pointer"], "/gyros/0/colour");
    assert_eq!(answers[6]["error"]["errors"][0]["pointer"], "/serial");
    lab.restart().await;
    assert_eq!(lab.sees_trend("A", "").await.len(), 2);
    assert_eq!(lab.sees_trend("A", "method=torque_feedback").await.len(), 1);
    lab.get("/v1/gyros/B").await.refused(404);
}

#[tokio::test]
async fn an_import_of_thousands_is_judged_as_if_posted_one_by_one() {
    let (by_import, by_post) = (Lab::open().await, Lab::open().await);
    let value = |k: i64| 1.0 + ((k * 7919) % 13) as f64 * 1e-3;
    let records: Vec<Value> = (0..120).map(|k| record("IMU-1", &day(k * 3), &[("G1", "A", value(k), 2.0)])).collect();
    for record in &records {
        by_post.posts(record).await;
    }
    let mut shuffled: Vec<Value> = records.clone();
    shuffled.sort_by_key(|record| record["calibrated_at"].as_str().unwrap().bytes().rev().collect::<Vec<u8>>());
    assert_ne!(shuffled, records);
    assert!(by_import.imports(&shuffled).await.iter().all(|answer| answer["status"] == 201));
    let states = |points: Vec<Value>| -> Vec<(Value, Value)> {
        points.iter().map(|p| (p["calibrated_at"].clone(), p["state"].clone())).collect()
    };
    let posted = states(by_post.sees_trend("A", "").await);
    assert_eq!(states(by_import.sees_trend("A", "").await), posted);
    assert!(posted.iter().any(|(_, state)| state == "exceeded") && posted.iter().any(|(_, state)| state == "within"));
}

/// `days` records of each of twenty IMUs in the order of time; of every fourth the gyro moves by ten budgets and
/// back, ten days in forty.
fn of_a_fleet(from: i64, days: i64) -> Vec<Value> {
    let of_day = |day_of: i64| {
        (0..20).map(move |imu| {
            let moved = imu % 4 == 0 && day_of % 40 >= 30;
            let value = 1.0 + ((day_of * 7919 + imu) % 13) as f64 * 2e-4 + if moved { 0.1 } else { 0.0 };
            record(&format!("IMU-{imu}"), &day(day_of), &[("G1", &format!("A{imu}"), value, 2.0)])
        })
    };
    (from..from + days).flat_map(of_day).collect()
}

/// Makes the database take half a millisecond or more for a record, so that more comes while a group is written.
const SLOW: &str = "CREATE TRIGGER slow AFTER INSERT ON record BEGIN SELECT length(hex(randomblob(100000))); END";

/// What is said of a gyro's calibrations, without identifiers.
async fn states_of(lab: &Lab, serial: &str) -> Vec<[Value; 3]> {
    let trend = lab.sees_trend(serial, "coefficient=D_I").await;
    trend.iter().map(|point| ["calibrated_at", "value", "state"].map(|name| point[name].clone())).collect()
}

/// A gyro's alerts, each with what became of it step by step.
async fn stories_of(lab: &Lab, serial: &str) -> Vec<String> {
    let found = lab.get(&format!("/v1/alerts?serial={serial}&limit=200")).await.ok();
    let mut stories = Vec::new();
    for alert in found["alerts"].as_array().expect("alerts") {
        let story =
            lab.get(&format!("/v1/alerts/{}", alert["id"].as_str().expect("an id"))).await.ok()["history"].clone();
        let actions = story.as_array().expect("a history").iter().map(|step| step["action"].to_string());
        let actions = actions.collect::<Vec<_>>().join(" ");
        stories.push(format!("{} {} {}: {actions}", alert["coefficient"], alert["rule"], alert["value"]));
    }
    stories.sort_unstable();
    stories
}

#[tokio::test]
async fn an_import_that_is_judged_while_it_is_written_ends_as_in_small_parts() {
    // What lies long ago does not hide what a late record alters.
    let steps_alone = |config: &mut Config| {
        let others = json!(["range", "baseline", "trend", "shift", "rms_successive", "closure"]);
        config.judging.rules.off = serde_json::from_value(others).unwrap();
    };
    let (at_once, in_parts) = (Lab::with(steps_alone).await, Lab::with(steps_alone).await);
    if !cluster::is_wanted() {
        behind::execute(&at_once.database(), SLOW).await;
    }
    // Stretches of 25 days, of which the later comes first twice.
    let stretch = |k: i64| of_a_fleet(1 + 25 * k, 25);
    let (first, rest) = (of_a_fleet(0, 1), [0, 1, 3, 2, 5, 4].map(stretch).concat());
    for part in first.chunks(20).chain(rest.chunks(100)) {
        assert!(in_parts.imports(part).await.iter().all(|answer| answer["status"] == 201));
    }
    assert!(at_once.imports(&first).await.iter().all(|answer| answer["status"] == 201));
    let twice: Vec<Value> = rest.iter().chain(&rest).cloned().collect();
    let answers = at_once.imports(&twice).await;
    let (new, again) = answers.split_at(rest.len());
    assert!(new.iter().all(|answer| answer["status"] == 201));
    let ids: BTreeSet<&str> = new.iter().map(|answer| answer["id"].as_str().unwrap()).collect();
    assert_eq!(ids.len(), rest.len());
    let are_the_same = |(new, again): (&Value, &Value)| again["status"] == 200 && again["id"] == new["id"];
    assert!(new.iter().zip(again).all(are_the_same), "what is sent twice is stored once");
    let mut exceeded = 0;
    for imu in 0..20 {
        let serial = format!("A{imu}");
        let states = states_of(&at_once, &serial).await;
        assert_eq!(states, states_of(&in_parts, &serial).await, "{serial}");
        assert_eq!(states.len(), 151);
        exceeded += states.iter().filter(|[_, _, state]| state == "exceeded").count();
    }
    assert_eq!(exceeded, 5 * 13, "two records each, three times there and back, and one of the last time there");
}

#[tokio::test]
async fn a_record_that_the_database_refuses_takes_nothing_of_a_great_import_along() {
    if cluster::is_wanted() {
        return;
    }
    let (lab, spared) = (Lab::open().await, Lab::open().await);
    behind::execute(&lab.database(), behind::POISON).await;
    behind::execute(&lab.database(), SLOW).await;
    let (first, mut rest) = (of_a_fleet(0, 1), of_a_fleet(1, 150));
    lab.imports(&first).await;
    spared.imports(&first).await;
    let poisoned = [401, 1_422];
    let good: Vec<Value> = (0..).zip(&rest).filter(|(k, _)| !poisoned.contains(k)).map(|(_, of)| of.clone()).collect();
    for k in poisoned {
        // Seen by nobody, its step is nobody's alert.
        rest[k] =
            record(&format!("IMU-{}", k % 20), &day(1 + k as i64 / 20), &[("G1", &format!("A{}", k % 20), 9.0, 2.0)]);
        rest[k]["note"] = json!("POISON");
    }
    let statuses: Vec<u64> = lab.imports(&rest).await.iter().map(|answer| answer["status"].as_u64().unwrap()).collect();
    let expected: Vec<u64> = (0..rest.len()).map(|k| if poisoned.contains(&k) { 500 } else { 201 }).collect();
    assert_eq!(statuses, expected);
    for part in good.chunks(100) {
        spared.imports(part).await;
    }
    for imu in 0..20 {
        let serial = format!("A{imu}");
        assert_eq!(states_of(&lab, &serial).await, states_of(&spared, &serial).await, "{serial}");
        assert_eq!(stories_of(&lab, &serial).await, stories_of(&spared, &serial).await, "{serial}");
    }
}

#[tokio::test]
async fn an_over_long_line_is_named_and_the_next_ones_are_read() {
    let lab = Lab::with(|config| config.server.max_import_line_bytes = 5_000).await;
    let good = |k| record("IMU-1", &day(k), &[("G1", "A", 1.0, 2.0)]).to_string();
    let text = format!("{}\n{}\n{}\n", good(0), "x".repeat(100_000), good(1));
    let answers = lab.post_text("/v1/import", NDJSON, text).await.lines();
    let statuses: Vec<&Value> = answers.iter().map(|answer| &answer["status"]).collect();
    assert_eq!(statuses, [201, 413, 201]);
    assert_eq!(answers[2]["line"], 3);
    let (error, limit) =
        (&answers[1]["error"], "a line may have 5000 bytes, the limit that server.max_import_line_bytes sets");
    assert_eq!((&error["title"], &error["detail"]), (&json!("Too large"), &json!(limit)));
    let lab = Lab::with(|config| config.server.max_import_bytes = 1_000).await;
    let error = lab.post_text("/v1/import", NDJSON, "x".repeat(2_000)).await.lines()[0]["error"].clone();
    assert_eq!(error["title"], "Too large");
    let limit = "an import may have 1000 bytes, the limit that server.max_import_bytes sets";
    assert!(error["detail"].as_str().unwrap().starts_with(limit), "{error}");
}

#[tokio::test]
async fn the_service_says_that_it_is_alive_ready_and_what_it_offers() {
    let lab = Lab::open().await;
    assert_eq!(lab.get("/healthz").await.ok()["status"], "ok");
    assert_eq!(lab.get("/readyz").await.ok()["status"], "ok");
    let openapi = lab.get("/openapi.json").await.ok();
    assert!(openapi["openapi"].as_str().unwrap().starts_with("3.1"));
    for path in ["/v1/records", "/v1/import", "/v1/gyros/{serial}/trend", "/v1/gyros/{serial}/agreement"] {
        assert!(openapi["paths"].get(path).is_some(), "{path}");
    }
}
