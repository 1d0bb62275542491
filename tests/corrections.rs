//! What becomes of a gyro when a record turns out not to count: trends, verdicts, baselines, alerts; and of the
//! record itself.

use crate::lab::{self, bench, verdict};
use crate::prelude::*;

fn of_a(at: i64, d_i: f64) -> Value {
    record("IMU-1", &day(at), &[("G1", "A", d_i, 2.0)])
}

/// Posts D_I of gyro `A` on given days; the records' identifiers.
async fn station_posts(lab: &Lab, history: &[(i64, f64)]) -> Vec<String> {
    let mut ids = Vec::new();
    for (at, d_i) in history {
        ids.push(id_of(&lab.posts(&of_a(*at, *d_i)).await));
    }
    ids
}

/// As [`station_posts`], in one request.
async fn station_imports(lab: &Lab, history: &[(i64, f64)]) -> Vec<String> {
    let records: Vec<Value> = history.iter().map(|(at, d_i)| of_a(*at, *d_i)).collect();
    lab.imports(&records).await.iter().map(id_of).collect()
}

fn id_of(answer: &Value) -> String {
    answer["id"].as_str().expect("an identifier").to_owned()
}

fn said(reason: &str) -> Value {
    json!({"author": "Li Wei", "reason": reason})
}

async fn engineer_voids(lab: &Lab, id: &str) -> Value {
    lab.post(&format!("/v1/records/{id}/void"), &said("table was not level")).await.ok()
}

fn revision(record: &Value) -> Value {
    json!({"author": "Li Wei", "reason": "wrong serial of the table", "record": record})
}

/// `rule state severity` of every alert on D_I of gyro `A`.
async fn alerts(lab: &Lab) -> Vec<String> {
    let found = lab.get("/v1/alerts?serial=A&coefficient=D_I").await.ok();
    let word = |alert: &Value, member: &str| alert[member].as_str().expect("text").to_owned();
    let alerts = found["alerts"].as_array().expect("alerts").iter();
    let mut alerts: Vec<String> =
        alerts.map(|a| ["rule", "state", "severity"].map(|member| word(a, member)).join(" ")).collect();
    alerts.sort();
    alerts
}

/// Days and D_I of the trend, to six places.
async fn trend(lab: &Lab, query: &str) -> Vec<(String, f64)> {
    let points = lab.sees_trend("A", query).await;
    let rounded = |value: &Value| (value.as_f64().expect("a number") * 1e6).round() / 1e6;
    points
        .iter()
        .map(|point| (point["calibrated_at"].as_str().expect("a time").to_owned(), rounded(&point["value"])))
        .collect()
}

/// What a laboratory that never had the other records would say of gyro `A`: every record's verdicts, without
/// identifiers.
async fn verdicts(lab: &Lab, ids: &[&String]) -> Vec<Value> {
    let mut all = Vec::new();
    for id in ids {
        all.push(lab.get(&format!("/v1/records/{id}")).await.ok()["verdicts"].clone());
    }
    all
}

#[tokio::test]
async fn a_voided_record_stays_to_be_seen_and_counts_no_more() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02)]).await;
    assert_eq!(alerts(&lab).await, ["baseline firing warning", "range firing warning", "step firing warning"]);
    let sent = lab.get(&format!("/v1/records/{}", ids[3])).await.ok();
    assert_eq!((&sent["state"], &sent["voided"], &sent["revised_by"]), (&json!("valid"), &Value::Null, &Value::Null));

    let answer = engineer_voids(&lab, &ids[3]).await;
    let remark = json!({"at": "2026-11-21T12:00:00Z", "author": "Li Wei", "reason": "table was not level"});
    assert_eq!((&answer["id"], &answer["state"], &answer["voided"]), (&json!(ids[3]), &json!("voided"), &remark));
    let now = lab.get(&format!("/v1/records/{}", ids[3])).await.ok();
    assert_eq!(
        (&now["record"], &now["separations"], &now["voided"]),
        (&sent["record"], &sent["separations"], &remark),
        "kept word for word"
    );
    let (before, after) = (verdict(&sent, "A", "D_I", "step"), verdict(&now, "A", "D_I", "step"));
    assert_eq!((&after["state"], &after["value"]), (&before["state"], &before["value"]), "as it was decided");
    let words = |verdict: &Value| verdict["reason"].as_str().expect("words").to_owned();
    assert_eq!(
        words(after),
        format!("{} It does not count any more: the record was voided or revised.", words(before))
    );

    let over = ["baseline resolved warning", "range resolved warning", "step resolved warning"];
    assert_eq!(alerts(&lab).await, over, "they rested on it alone");
    let alert = lab.get("/v1/alerts?serial=A&rule=step").await.ok()["alerts"][0]["id"].clone();
    let history = lab.get(&format!("/v1/alerts/{}", alert.as_str().unwrap())).await.ok()["history"].clone();
    let last = history.as_array().unwrap().last().unwrap();
    assert_eq!(
        (&last["action"], &last["told"], &last["by"], &last["reason"]),
        (&json!("resolve"), &json!(true), &json!("Li Wei"), &json!("table was not level"))
    );
    assert_eq!(trend(&lab, "").await.len(), 3);
    let gyro = lab.get("/v1/gyros/A").await.ok();
    assert_eq!(gyro["calibrations"], 3);
    assert!(lab.get("/v1/gyros").await.text.contains(&day(80)), "the newest that counts");
}

/// One of the three of its baseline, one that is revised, one that only ever was the newest; whatever is said of
/// others since.
#[tokio::test]
async fn what_a_record_was_judged_to_be_stays_readable_when_it_counts_no_more() {
    const VOIDED: &str = " It does not count any more: the record was voided or revised.";
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.0), (80, 1.001), (120, 1.02), (160, 1.0)]).await;
    let all: Vec<&String> = ids.iter().collect();
    let original = verdicts(&lab, &all).await;
    lab.post(&format!("/v1/records/{}/revise", ids[3]), &revision(&of_a(120, 1.003))).await.created();
    let rejudged = verdicts(&lab, &[&ids[4]]).await;
    for (minute, k) in [(1, 4), (2, 2)] {
        lab.clock_shows(&format!("2026-11-21T12:{minute:02}:00Z"));
        engineer_voids(&lab, &ids[k]).await;
    }
    let words = |verdict: &Value| verdict["reason"].as_str().expect("words").to_owned();
    for (k, then) in [(2, &original[2]), (3, &original[3]), (4, &rejudged[0])] {
        let now = lab.get(&format!("/v1/records/{}", ids[k])).await.ok()["verdicts"].clone();
        let (then, now) = (then.as_array().expect("verdicts"), now.as_array().expect("verdicts"));
        assert_eq!(then.len(), now.len());
        for (then, now) in then.iter().zip(now) {
            assert_eq!(words(now), words(then) + VOIDED, "record {k}");
        }
    }
    let step = verdict(&lab.get(&format!("/v1/records/{}", ids[4])).await.ok(), "A", "D_I", "step").clone();
    // 1.000 against the median 1.001 of the records before.
    assert_eq!(step["code"], "in_tolerance");
    assert!((step["value"].as_f64().unwrap() - 0.001).abs() < 1e-9, "{step}");
}

#[tokio::test]
async fn a_trend_shows_voided_points_where_it_is_asked_to_and_flags_them() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.1), (80, 1.0), (120, 1.2)]).await;
    let tag = lab.get("/v1/gyros/A/trend?voided=include").await.header("etag").to_owned();
    engineer_voids(&lab, &ids[1]).await;
    lab.post(&format!("/v1/records/{}/revise", ids[3]), &revision(&of_a(120, 1.3))).await.created();
    let plain = |points: &[(i64, f64)]| points.iter().map(|(at, d_i)| (day(*at), *d_i)).collect::<Vec<_>>();
    assert_eq!(trend(&lab, "").await, plain(&[(0, 1.0), (80, 1.0), (120, 1.3)]));
    let all = plain(&[(0, 1.0), (40, 1.1), (80, 1.0), (120, 1.2), (120, 1.3)]);
    assert_eq!(trend(&lab, "voided=include").await, all);
    assert_eq!(trend(&lab, "voided=include&last=3").await, all[2..]);
    assert_ne!(lab.get("/v1/gyros/A/trend?voided=include").await.header("etag"), tag);
    let flags: Vec<Value> = lab.sees_trend("A", "voided=include").await.iter().map(|p| p["voided"].clone()).collect();
    assert_eq!(flags, [false, true, false, true, false]);
    assert!(lab.sees_trend("A", "").await.iter().all(|point| point.get("voided").is_none()));

    let (mut cursor, mut pages) = (String::new(), Vec::new());
    loop {
        let page = lab.get(&format!("/v1/gyros/A/trend?voided=include&limit=2{cursor}")).await.ok();
        pages.push(page["points"].as_array().unwrap().len());
        let Some(next) = page["next"].as_str() else { break };
        cursor = format!("&cursor={next}");
    }
    assert_eq!(pages, [2, 3], "an instant is not torn apart");
    let one = lab.get("/v1/gyros/A/trend?voided=include&limit=4").await.ok();
    assert_eq!(
        (one["points"].as_array().unwrap().len(), &one["next"]),
        (5, &Value::Null),
        "an instant is not torn apart"
    );

    let csv = lab.get("/v1/gyros/A/trend?voided=include&format=csv").await.text;
    let place = csv.lines().next().unwrap().split(',').position(|name| name == "voided").expect("a column");
    let ends: Vec<&str> = csv.lines().map(|line| line.split(',').nth(place).unwrap()).collect();
    assert_eq!(ends, ["voided", "false", "true", "false", "true", "false"]);
    assert!(!lab.get("/v1/gyros/A/trend?format=csv").await.text.contains("voided"));
    lab.get("/v1/gyros/A/trend?voided=yes").await.refused(400);
}

#[tokio::test]
async fn whatever_is_voided_the_rest_is_judged_as_if_it_had_never_come() {
    let history: Vec<(i64, f64)> = (0..30)
        .map(|i| (i * 10, 1.0 + 0.004 * f64::from((i * i % 7) as i32) + if i > 20 { 0.02 } else { 0.0 }))
        .collect();
    for gone in [vec![0, 1, 2], vec![0], vec![2, 21], vec![15], vec![29], vec![21, 22, 23, 24, 25, 26, 27, 28, 29]] {
        let lab = Lab::open().await;
        let ids = station_imports(&lab, &history).await;
        for &k in &gone {
            engineer_voids(&lab, &ids[k]).await;
        }
        let kept: Vec<usize> = (0..history.len()).filter(|k| !gone.contains(k)).collect();
        let clean = Lab::open().await;
        let left: Vec<(i64, f64)> = kept.iter().map(|&k| history[k]).collect();
        let clean_ids = station_imports(&clean, &left).await;
        let still: Vec<&String> = kept.iter().map(|&k| &ids[k]).collect();
        let (found, expected) =
            (verdicts(&lab, &still).await, verdicts(&clean, &clean_ids.iter().collect::<Vec<_>>()).await);
        for (k, (found, expected)) in kept.iter().zip(found.iter().zip(&expected)) {
            assert_eq!(found, expected, "record {k} of {gone:?}");
        }
        let states = async |lab: &Lab| {
            lab.sees_trend("A", "").await.iter().map(|point| point["state"].clone()).collect::<Vec<_>>()
        };
        assert_eq!(states(&lab).await, states(&clean).await, "{gone:?}");
        let firing = async |lab: &Lab| {
            let rules = alerts(lab).await.into_iter().filter(|alert| alert.contains(" firing "));
            rules.collect::<Vec<_>>()
        };
        let (fires, would_fire) = (firing(&lab).await, firing(&clean).await);
        assert!(fires.iter().all(|rule| would_fire.contains(rule)), "{gone:?}: {fires:?}, not {would_fire:?}");
        let newest = lab.get(&format!("/v1/records/{}", still.last().expect("some are left"))).await.ok();
        for rule in would_fire.iter().filter(|rule| !fires.contains(rule)) {
            let rule = rule.split(' ').next().unwrap();
            let state = &verdict(&newest, "A", "D_I", rule)["state"];
            assert_eq!(state, "within", "{gone:?}: {rule} had resolved, and is not taken up by hysteresis alone");
        }
    }
}

#[tokio::test]
async fn an_alert_that_other_records_bear_out_goes_on_firing() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02), (160, 1.021), (200, 1.02)]).await;
    assert_eq!(alerts(&lab).await, ["baseline firing critical", "range resolved warning", "step resolved critical"]);
    engineer_voids(&lab, &ids[5]).await;
    let two = ["baseline firing critical", "range firing warning", "step firing critical"];
    assert_eq!(alerts(&lab).await, two, "two records bear the step out");
    engineer_voids(&lab, &ids[4]).await;
    let one = ["baseline firing warning", "range firing warning", "step firing warning"];
    assert_eq!(alerts(&lab).await, one, "one record alone confirms nothing");
    engineer_voids(&lab, &ids[3]).await;
    let none = ["baseline resolved warning", "range resolved warning", "step resolved warning"];
    assert_eq!(alerts(&lab).await, none);
    for id in &ids[..3] {
        engineer_voids(&lab, id).await;
    }
    assert_eq!(trend(&lab, "").await, []);
    assert_eq!(lab.get("/v1/gyros/A").await.ok()["calibrations"], 0);
    station_posts(&lab, &[(240, 5.0)]).await;
    assert_eq!(alerts(&lab).await, none, "it begins anew");
}

#[tokio::test]
async fn what_a_voided_record_raised_shows_the_newest_that_counts_once_it_is_resolved() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.001), (80, 1.0), (120, 1.001), (160, 1.05)]).await;
    engineer_voids(&lab, &ids[4]).await;
    let newest = lab.get(&format!("/v1/records/{}", ids[3])).await.ok();
    let found = lab.get("/v1/alerts?serial=A&coefficient=D_I").await.ok();
    let found = found["alerts"].as_array().expect("alerts");
    assert!(found.len() >= 3, "{found:?}");
    for alert in found {
        let now = verdict(&newest, "A", "D_I", alert["rule"].as_str().expect("a rule"));
        assert_eq!(alert["state"], "resolved");
        for member in ["value", "reason"] {
            assert_eq!(alert[member], now[member], "{alert} {now}");
        }
        let alert = lab.get(&format!("/v1/alerts/{}", alert["id"].as_str().expect("an id"))).await.ok();
        let last = alert["history"].as_array().expect("steps").last().expect("a step").clone();
        assert_eq!(last["action"], "resolve");
    }
}

#[tokio::test]
async fn an_alert_that_a_voided_record_ended_goes_on_since_the_same_day_and_is_known_to_those_who_knew_of_it() {
    let lab = Lab::open().await;
    station_posts(&lab, &[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02), (160, 1.021)]).await;
    let step = async || lab.alerts("serial=A&coefficient=D_I&rule=step").await.remove(0);
    let before = step().await;
    let id = before["id"].as_str().unwrap();
    let said = json!({"by": "Li Wei", "reason": "known since May"});
    let before = lab.post(&format!("/v1/alerts/{id}/acknowledge"), &said).await.ok();
    assert_eq!([&before["state"], &before["since"]], [&json!("acknowledged"), &json!(day(120))]);
    lab.clock_shows("2026-11-22T12:00:00Z");
    let wrong = station_posts(&lab, &[(200, 1.02)]).await;
    assert_eq!(step().await["state"], "resolved");
    engineer_voids(&lab, &wrong[0]).await;
    let after = step().await;
    for member in ["state", "severity", "since", "fired_at", "resolved_at", "acknowledged", "value", "record"] {
        assert_eq!(after[member], before[member], "{member}: {after}");
    }
    assert_eq!(lab.verified().await.faults, []);
}

#[tokio::test]
async fn an_alert_that_began_with_a_voided_record_dates_from_what_is_left() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02), (160, 1.021)]).await;
    let since = async || lab.alerts("serial=A&coefficient=D_I&rule=baseline").await.remove(0)["since"].clone();
    assert_eq!(since().await, day(120));
    engineer_voids(&lab, &ids[3]).await;
    assert_eq!(since().await, day(160));
}

#[tokio::test]
async fn a_revised_record_is_judged_in_the_place_of_the_old() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02), (160, 1.0)]).await;
    let path = format!("/v1/records/{}/revise", ids[3]);
    let answer = lab.post(&path, &revision(&of_a(120, 1.001))).await;
    let new = answer.created();
    assert_eq!(answer.header("location"), format!("/v1/records/{}", id_of(&new)));
    assert_eq!(verdict(&new, "A", "D_I", "step")["state"], "within");
    assert_eq!((&new["state"], &new["revises"]["record"]), (&json!("valid"), &json!(ids[3])));
    let old = lab.get(&format!("/v1/records/{}", ids[3])).await.ok();
    assert_eq!(
        (&old["state"], &old["revised_by"]["record"], &old["voided"]),
        (&json!("revised"), &new["id"], &Value::Null)
    );
    let next = lab.get(&format!("/v1/records/{}", ids[4])).await.ok();
    lab::assert_close(&verdict(&next, "A", "D_I", "step")["value"], 0.0, 1e-9);

    assert_eq!(lab.post(&path, &revision(&of_a(120, 1.001))).await.ok()["id"], new["id"], "sent again");
    let resent = lab.post("/v1/records", &of_a(120, 1.02)).await.ok();
    assert_eq!((&resent["id"], &resent["state"]), (&json!(ids[3]), &json!("revised")), "the station does not know");
    let imported = lab.imports(&[of_a(120, 1.02), of_a(120, 1.03)]).await;
    assert_eq!((&imported[0]["id"], &imported[1]["status"]), (&json!(ids[3]), &json!(409)), "{imported:?}");
    let other = lab.post(&path, &revision(&of_a(120, 1.005))).await;
    other.refused(409);
    assert_eq!(other.json()["existing"], new["id"]);
    lab.post(&format!("/v1/records/{}/void", ids[3]), &said("not this one")).await.refused(409);
    let again = lab.post(&format!("/v1/records/{}/revise", id_of(&new)), &revision(&of_a(125, 1.002))).await.created();
    assert_eq!(again["revises"]["record"], new["id"], "a revision can be revised, to another time as well");
    assert_eq!(trend(&lab, "from=2025-04-01T00:00:00Z").await, [(day(125), 1.002), (day(160), 1.0)]);
}

#[tokio::test]
async fn what_is_sent_again_does_not_come_back_to_life_and_what_differs_counts() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.1)]).await;
    engineer_voids(&lab, &ids[1]).await;
    let again = lab.post("/v1/records", &of_a(40, 1.1)).await.ok();
    assert_eq!((&again["id"], &again["state"]), (&json!(ids[1]), &json!("voided")), "the station does not know");
    let mut elsewhere = of_a(40, 1.1);
    elsewhere["calibrated_at"] = json!(day(40).replace("12:00:00Z", "13:00:00+01:00"));
    assert_eq!(id_of(&lab.post("/v1/records", &elsewhere).await.ok()), ids[1], "in other words");
    let imported = lab.imports(&[of_a(40, 1.1)]).await;
    assert_eq!(imported[0]["id"], json!(ids[1]), "{imported:?}");
    assert_eq!(trend(&lab, "").await, [(day(0), 1.0)]);

    let other = lab.posts(&of_a(40, 1.05)).await;
    assert_eq!(trend(&lab, "").await, [(day(0), 1.0), (day(40), 1.05)]);
    assert_eq!(id_of(&lab.post("/v1/records", &of_a(40, 1.05)).await.ok()), id_of(&other));
    let again = lab.post("/v1/records", &of_a(40, 1.1)).await.ok();
    assert_eq!((&again["id"], &again["state"]), (&json!(ids[1]), &json!("voided")), "whatever stands there now");
    lab.post("/v1/records", &of_a(40, 1.2)).await.refused(409);

    engineer_voids(&lab, &id_of(&other)).await;
    let path = format!("/v1/records/{}/revise", ids[1]);
    let back = lab.post(&path, &json!({"author": "Li", "reason": "it was level", "record": of_a(40, 1.1)})).await;
    assert_eq!(back.created()["state"], "valid", "what was voided by mistake counts again");
    assert_eq!(trend(&lab, "").await, [(day(0), 1.0), (day(40), 1.1)]);
    let first = lab.get(&format!("/v1/records/{}", ids[1])).await.ok();
    assert_eq!((&first["state"], &first["voided"]["author"]), (&json!("revised"), &json!("Li Wei")), "both are told");
}

#[tokio::test]
async fn late_records_find_their_place_among_those_that_count() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.0), (80, 1.0), (160, 1.0145)]).await;
    engineer_voids(&lab, &ids[2]).await;
    let late = lab.posts(&of_a(60, 1.012)).await;
    assert_eq!(verdict(&late, "A", "D_I", "step")["state"], "exceeded");
    let newest = lab.get(&format!("/v1/records/{}", ids[3])).await.ok();
    lab::assert_close(&verdict(&newest, "A", "D_I", "step")["value"], 0.0145, 1e-9);
    lab::assert_close(&verdict(&newest, "A", "D_I", "baseline")["value"], 0.0145, 1e-9);
    let same_time = lab.posts(&of_a(80, 1.01)).await;
    assert_ne!(id_of(&same_time), ids[2]);
    assert_eq!(trend(&lab, "").await.len(), 5);
}

#[tokio::test]
async fn a_record_of_several_gyros_is_voided_for_all_of_them_and_its_seats_are_free() {
    let lab = Lab::open().await;
    let both = record("IMU-1", &day(0), &[("G1", "A", 1.0, 2.0), ("G2", "B", 3.0, 2.0)]);
    let id = id_of(&lab.posts(&both).await);
    let elsewhere = record("IMU-2", &day(0), &[("G1", "B", 3.1, 2.0)]);
    lab.post("/v1/records", &elsewhere).await.refused(409);
    engineer_voids(&lab, &id).await;
    lab.posts(&elsewhere).await;
    assert_eq!(lab.sees_trend("A", "").await.len(), 0);
    assert_eq!(lab.sees_trend("B", "").await[0]["imu"], "IMU-2");
    let shown = lab.sees_trend("B", "voided=include").await;
    assert_eq!(shown.iter().map(|point| &point["imu"]).collect::<Vec<_>>(), ["IMU-1", "IMU-2"]);
    let conflict = lab.post(&format!("/v1/records/{id}/revise"), &revision(&both)).await;
    assert_eq!(conflict.refused(409), ["/record/gyros/1/serial"]);
    assert_eq!(lab.sees_trend("A", "").await.len(), 0, "nothing of it is stored");
    assert_eq!(lab.get(&format!("/v1/records/{id}")).await.ok()["state"], "voided");
}

#[tokio::test]
async fn a_voided_bench_result_is_compared_no_more_and_its_alert_ends() {
    let lab = Lab::open().await;
    station_posts(&lab, &[(0, 1.0)]).await;
    let sent = bench("A", &day(5), 1.03, 2.0);
    let id = id_of(&lab.post("/v1/bench-results", &sent).await.created());
    assert_eq!(alerts(&lab).await, ["agreement firing warning"]);
    let path = format!("/v1/bench-results/{id}/void");
    let answer = lab.post(&path, &said("clamped")).await.ok();
    assert_eq!((&answer["state"], &answer["voided"]["reason"]), (&json!("voided"), &json!("clamped")));
    assert_eq!(alerts(&lab).await, ["agreement resolved warning"]);
    let stored = lab.get(&format!("/v1/bench-results/{id}")).await.ok();
    assert_eq!((&stored["state"], &stored["bench_result"]), (&json!("voided"), &sent));
    assert_eq!(lab.sees_trend("A", "method=torque_feedback").await.len(), 0);
    assert_eq!(lab.sees_trend("A", "method=torque_feedback&voided=include").await[0]["voided"], true);
    assert_eq!(id_of(&lab.post("/v1/bench-results", &sent).await.ok()), id, "sent again, it stays voided");
    let better = id_of(&lab.post("/v1/bench-results", &bench("A", &day(5), 1.001, 2.0)).await.created());
    assert_ne!(better, id);
    let again = lab.post("/v1/bench-results", &sent).await.ok();
    assert_eq!(again["id"], json!(id), "whatever stands there now");
    lab.post("/v1/bench-results", &bench("A", &day(5), 1.04, 2.0)).await.refused(409);
    assert_eq!(lab.sees_trend("A", "method=torque_feedback").await.len(), 1);
    assert_eq!(lab.post(&path, &said("clamped")).await.ok()["id"], json!(id));
    lab.post(&path, &said("dropped")).await.refused(409);
}

#[tokio::test]
async fn a_voided_separation_is_compared_no_more_with_the_bench() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (10, 1.03)]).await;
    lab.post("/v1/bench-results", &bench("A", &day(12), 1.0, 2.0)).await.created();
    assert!(alerts(&lab).await.contains(&"agreement firing warning".to_owned()));
    engineer_voids(&lab, &ids[1]).await;
    assert!(alerts(&lab).await.contains(&"agreement resolved warning".to_owned()));
}

#[tokio::test]
async fn a_campaign_is_voided_and_revised_like_a_record() {
    let lab = Lab::open().await;
    let campaign = document("practice/campaign-00.json");
    let id = id_of(&lab.post("/v1/campaigns", &campaign).await.created());
    let serial = campaign["gyros"][0]["serial"].as_str().unwrap();
    assert_eq!(lab.sees_trend(serial, "").await.len(), 1);
    let mut again = campaign.clone();
    again["dwells"].as_array_mut().unwrap().pop();
    let body = json!({"author": "Li", "reason": "the last dwell was disturbed", "campaign": again});
    let new = lab.post(&format!("/v1/campaigns/{id}/revise"), &body).await.created();
    assert_eq!(new["revises"]["record"], json!(id));
    assert_eq!(lab.sees_trend(serial, "").await[0]["record"], new["id"]);
    let path = format!("/v1/campaigns/{}/void", id_of(&new));
    assert_eq!(lab.post(&path, &said("warm")).await.ok()["state"], "voided");
    assert_eq!(lab.sees_trend(serial, "").await.len(), 0);
    assert_eq!(lab.post("/v1/campaigns", &campaign).await.ok()["state"], "revised");

    let record = id_of(&lab.posts(&of_a(0, 1.0)).await);
    lab.post(&format!("/v1/campaigns/{record}/void"), &said("x")).await.refused(404);
    let body = json!({"author": "", "reason": "x", "campaign": {"imu": "A"}});
    let places = lab.post(&format!("/v1/campaigns/{id}/revise"), &body).await.refused(422);
    assert!(places.contains(&"/author".to_owned()) && places.iter().any(|p| p.starts_with("/campaign/")), "{places:?}");
}

#[tokio::test]
async fn a_correction_that_cannot_be_is_refused_with_the_place_and_changes_nothing() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.0)]).await;
    let path = format!("/v1/records/{}", ids[0]);
    for id in ["x", "0123456789ABC", "0000000000000"] {
        lab.post(&format!("/v1/records/{id}/void"), &said("x")).await.refused(404);
        lab.post(&format!("/v1/bench-results/{id}/void"), &said("x")).await.refused(404);
        lab.post(&format!("/v1/records/{id}/revise"), &revision(&of_a(0, 1.0))).await.refused(404);
    }
    for (body, places) in [
        (json!({"author": " ", "reason": ""}), vec!["/author", "/reason"]),
        (json!({"reason": "x"}), vec!["/author"]),
        (json!({"author": "Li", "reason": "x", "by": "Li"}), vec!["/by"]),
    ] {
        assert_eq!(lab.post(&format!("{path}/void"), &body).await.refused(422), places, "{body}");
    }
    lab.post_text(&format!("{path}/void"), lab::JSON, "{").await.refused(400);
    lab.post_text(&format!("{path}/void"), "text/plain", "{}").await.refused(415);
    let revise = format!("{path}/revise");
    let elsewhere = record("IMU-2", &day(0), &[("G1", "A", 1.0, 2.0)]);
    assert_eq!(lab.post(&revise, &revision(&elsewhere)).await.refused(422), ["/record/imu"]);
    let taken = lab.post(&revise, &revision(&of_a(40, 1.2))).await;
    assert_eq!((taken.refused(409), &taken.json()["existing"]), (vec!["/record/calibrated_at".into()], &json!(ids[1])));
    let mut bad = of_a(0, 1.0);
    bad["gyros"][0]["e_pulse_per_arcsec"] = json!([1, 2]);
    let body = json!({"author": "", "reason": "x", "record": bad});
    assert_eq!(lab.post(&revise, &body).await.refused(422), ["/author", "/record/gyros/0/e_pulse_per_arcsec"]);
    assert_eq!(lab.post(&revise, &json!({"author": "Li", "reason": "x"})).await.refused(422), ["/record"]);
    assert_eq!(lab.get(&path).await.ok()["state"], "valid");
    assert_eq!(trend(&lab, "").await.len(), 2);
    assert_eq!(engineer_voids(&lab, &ids[0]).await, engineer_voids(&lab, &ids[0]).await, "said twice");
    lab.post(&format!("{path}/void"), &said("another reason")).await.refused(409);
}

#[tokio::test]
async fn corrections_outlive_a_restart_and_a_gyro_is_overdue_from_its_newest_record_that_counts() {
    let mut lab = Lab::with(|config| {
        config.judging.interval_days = 30.0;
        config.alerts.tick_s = 0.02;
    })
    .await;
    lab.clock_shows(&day(50));
    let ids = station_posts(&lab, &[(40, 1.0), (0, 1.0)]).await;
    tokio::time::sleep(Duration::from_millis(100)).await;
    let overdue = async |lab: &Lab| lab.get("/v1/alerts?rule=overdue").await.ok()["alerts"].clone();
    assert_eq!(overdue(&lab).await, json!([]));
    engineer_voids(&lab, &ids[0]).await;
    assert_eq!(overdue(&lab).await[0]["state"], "firing", "at once: the last that counts is 50 days old");
    lab.restart().await;
    assert_eq!(lab.get(&format!("/v1/records/{}", ids[0])).await.ok()["state"], "voided");
    assert_eq!(trend(&lab, "").await.len(), 1);
    assert_eq!(overdue(&lab).await[0]["state"], "firing");
    lab.posts(&of_a(45, 1.0)).await;
    assert_eq!(overdue(&lab).await[0]["state"], "resolved");
}

/// The alert goes with the record that it rests on, in one transaction: whenever the service dies, both are there or
/// neither.
#[tokio::test]
async fn a_service_that_is_killed_while_a_record_is_voided_has_done_all_of_it_or_nothing() {
    let mut server = support::Server::start().await;
    let mut done = 0;
    for round in 0..12_i64 {
        let serial = format!("K{round}");
        let made = |at: i64, d_i| record(&format!("IMU-{round}"), &day(at), &[("G1", &serial, d_i, 2.0)]);
        let mut last = String::new();
        for (at, d_i) in [(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02)] {
            last = id_of(&server.post_json("/v1/records", &made(at, d_i)).await.json());
        }
        let text = said("x").to_string();
        let head =
            format!("POST /v1/records/{last}/void HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n");
        let stream = server.open_and_send(&format!("{head}content-length: {}\r\n\r\n{text}", text.len())).await;
        tokio::time::sleep(Duration::from_micros(400 * round as u64)).await;
        server.kill();
        drop(stream);
        server.restart();
        let voided = server.get(&format!("/v1/records/{last}")).await.json()["state"] == "voided";
        let points = server.get(&format!("/v1/gyros/{serial}/trend")).await.json()["points"].as_array().unwrap().len();
        let found = server.get(&format!("/v1/alerts?serial={serial}&state=firing")).await.json();
        let firing = found["alerts"].as_array().unwrap().len();
        assert_eq!((points, firing), if voided { (3, 0) } else { (4, 3) }, "round {round}: {found}");
        done += u32::from(voided);
    }
    println!("{done} of 12 were voided before the service died");
}

fn of_window(from: i64, to: i64) -> Value {
    json!({"from": day(from), "to": day(to), "by": "Li Wei", "reason": "the fixture was loose"})
}

#[tokio::test]
async fn a_suspect_window_of_a_station_does_not_count_until_it_is_trusted_again() {
    let lab = Lab::open().await;
    // A level, a jump that a second record confirms, and the level again: as it is without the window, and with it.
    let history = [(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.05), (160, 1.05), (200, 1.0)];
    let ids = station_posts(&lab, &history).await;
    let before = (alerts(&lab).await, trend(&lab, "").await);
    assert!(before.0.iter().any(|alert| alert.starts_with("step")), "{before:?}");

    let path = |deed: &str| format!("/v1/stations/ST-1/{deed}");
    let aside = lab.post(&path("suspect"), &of_window(100, 170)).await.ok();
    assert_eq!(aside["records"], json!(ids[3..5]), "{aside}");
    let left: Vec<f64> = trend(&lab, "").await.into_iter().map(|(_, d_i)| d_i).collect();
    assert_eq!(left, [1.0; 4]);
    let firing = lab.get("/v1/alerts?state=firing&serial=A").await.ok();
    assert_eq!(firing["alerts"], json!([]), "as though they had never come");
    let one = lab.get(&format!("/v1/records/{}", ids[3])).await.ok();
    assert_eq!(one["state"], "set_aside", "{one}");
    let note = &one["notes"][0];
    assert_eq!([&note["code"], &note["station"], &note["author"]], ["suspect", "ST-1", "Li Wei"]);

    let again = lab.post(&path("suspect"), &of_window(100, 170)).await.ok();
    assert_eq!(again["records"], json!([]), "said already");
    let back = lab.post(&path("trust"), &of_window(100, 170)).await.ok();
    assert_eq!(back["records"], json!(ids[3..5]), "{back}");
    assert_eq!(trend(&lab, "").await, before.1);
    // It may be doubted a second time, and trusted again.
    assert_eq!(lab.post(&path("suspect"), &of_window(0, 300)).await.ok()["records"], json!(ids));
    assert_eq!(lab.post(&path("trust"), &of_window(0, 300)).await.ok()["records"], json!(ids));
    assert_eq!(trend(&lab, "").await, before.1);
}

/// Whichever mark is the later, all records of the window are as it says.
#[tokio::test]
async fn a_window_that_is_suspected_and_trusted_at_once_is_one_or_the_other() {
    let lab = Lab::open().await;
    let history: Vec<(i64, f64)> = (0..60).map(|k| (3 * k, 1.0)).collect();
    let ids = station_posts(&lab, &history).await;
    let mark = async |deed: &str| {
        let marked = lab.post(&format!("/v1/stations/ST-1/{deed}"), &of_window(-1, 300)).await;
        assert_eq!(marked.status, 200);
    };
    for _ in 0..12 {
        tokio::join!(mark("suspect"), mark("trust"), mark("suspect"), mark("trust"));
        let station = lab.get("/v1/stations/ST-1").await.ok();
        let is_suspect = station["suspect_windows"] != json!([]);
        let counting = trend(&lab, "").await.len();
        assert_eq!(counting, if is_suspect { 0 } else { ids.len() }, "{station}");
    }
}

#[tokio::test]
async fn two_of_one_instant_that_come_together_into_a_suspect_window_are_both_kept() {
    let lab = Lab::open().await;
    station_posts(&lab, &[(0, 1.0), (40, 1.0)]).await;
    lab.post("/v1/stations/ST-1/suspect", &of_window(50, 90)).await.ok();
    let [one, other] = [1.5, 1.0].map(|d_i| of_a(60, d_i));
    let answers = lab.imports(&[one.clone(), other.clone(), one, other]).await;
    let statuses: Vec<&Value> = answers.iter().map(|answer| &answer["status"]).collect();
    assert_eq!(statuses, [201, 201, 200, 200], "{answers:?}");
}

/// Nobody could tell which is right: the sender hears of it, and so does the engineer who trusts the window again.
#[tokio::test]
async fn of_two_of_one_instant_in_a_suspect_window_the_second_names_the_first_and_trust_what_it_leaves_aside() {
    let lab = Lab::open().await;
    station_posts(&lab, &[(0, 1.0), (40, 1.0)]).await;
    lab.post("/v1/stations/ST-1/suspect", &of_window(50, 90)).await.ok();
    let [first, second] = [lab.posts(&of_a(60, 1.5)).await, lab.posts(&of_a(60, 1.0)).await];
    let beside = |stored: &Value| {
        let notes = stored["notes"].as_array().unwrap();
        notes.iter().find(|note| note["code"] == "same_time_set_aside").map(|note| note["records"].clone())
    };
    assert_eq!((beside(&first), beside(&second)), (None, Some(json!([first["id"]]))));
    let read = lab.get(&format!("/v1/records/{}", id_of(&second))).await.ok();
    assert_eq!((&read["state"], beside(&read)), (&json!("set_aside"), beside(&second)));
    let trusted = lab.post("/v1/stations/ST-1/trust", &of_window(50, 90)).await.ok();
    assert_eq!(trusted["records"], json!([first["id"]]));
    assert_eq!(trusted["refused"][0]["record"], second["id"], "{trusted}");
    // What is voided is beside nothing.
    engineer_voids(&lab, &id_of(&first)).await;
    engineer_voids(&lab, &id_of(&second)).await;
    assert_eq!(beside(&lab.posts(&of_a(60, 1.1)).await), None);
}

#[tokio::test]
async fn what_comes_later_into_a_suspect_window_does_not_count_either() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.0), (80, 1.0)]).await;
    let path = |deed: &str| format!("/v1/stations/ST-1/{deed}");
    // The window has not ended, and holds nothing yet: until somebody has tightened the fixture.
    assert_eq!(lab.post(&path("suspect"), &of_window(100, 200)).await.ok()["records"], json!([]));
    let windows = async || lab.get("/v1/stations/ST-1").await.ok()["suspect_windows"].clone();
    let marked = json!({"from": day(100), "to": day(200), "by": "Li Wei", "reason": "the fixture was loose"});
    assert_eq!(windows().await, json!([marked]));

    let [inside, also, after] = [120, 140, 201].map(|days| of_a(days, 1.5));
    let posted = lab.posts(&inside).await;
    assert_eq!((&posted["notes"][0]["code"], &posted["notes"][0]["author"]), (&json!("suspect"), &json!("Li Wei")));
    let inside = posted["id"].as_str().unwrap().to_owned();
    let also = id_of(&lab.posts(&also).await);
    let state = async |id: &str| lab.get(&format!("/v1/records/{id}")).await.ok()["state"].clone();
    assert_eq!((state(&inside).await, state(&ids[2]).await), (json!("set_aside"), json!("valid")));
    let counting = async || trend(&lab, "").await.into_iter().map(|(_, d_i)| d_i).collect::<Vec<f64>>();
    assert_eq!(counting().await, [1.0; 3], "a half more, and nobody is told");
    assert_eq!(lab.get("/v1/alerts?state=firing&serial=A").await.ok()["alerts"], json!([]));

    // What is confirmed by itself counts, and a part that is trusted ends there.
    let confirmed = json!({"by": "Li Wei", "reason": "measured on the granite block"});
    lab.post(&format!("/v1/records/{also}/confirm"), &confirmed).await.ok();
    assert_eq!(counting().await, [1.0, 1.0, 1.0, 1.5]);
    assert_eq!(lab.post(&path("trust"), &of_window(100, 130)).await.ok()["records"], json!([inside]));
    let left = windows().await;
    assert_eq!(left.as_array().map(Vec::len), Some(1), "{left}");
    assert!(left[0]["from"].as_str().unwrap().starts_with(day(130).trim_end_matches('Z')), "{left}");
    let free = id_of(&lab.posts(&of_a(125, 1.5)).await);
    let held = id_of(&lab.posts(&of_a(150, 1.5)).await);
    let after = id_of(&lab.posts(&after).await);
    let states = (state(&free).await, state(&held).await, state(&after).await);
    assert_eq!(states, (json!("valid"), json!("set_aside"), json!("valid")));
    assert_eq!(lab.post(&path("trust"), &of_window(100, 200)).await.ok()["records"], json!([held]));
    assert_eq!(windows().await, json!([]));
}

#[tokio::test]
async fn a_window_that_is_trusted_again_does_not_vouch_for_a_time_in_doubt() {
    let lab = Lab::open().await;
    station_posts(&lab, &[(0, 1.0), (40, 1.0)]).await;
    let path = |deed: &str| format!("/v1/stations/ST-1/{deed}");
    let long_ago = json!({"from": "1999-01-01T00:00:00Z", "to": "2003-01-01T00:00:00Z", "by": "Li Wei", "reason": "x"});
    lab.post(&path("suspect"), &long_ago).await.ok();
    let mut unset = of_a(0, 1.0);
    unset["calibrated_at"] = json!("2001-05-05T08:00:00Z");
    let posted = lab.posts(&unset).await;
    let codes: Vec<&str> = posted["notes"].as_array().unwrap().iter().filter_map(|it| it["code"].as_str()).collect();
    assert!(codes.contains(&"time_in_doubt") && codes.contains(&"suspect"), "{codes:?}");
    assert_eq!(lab.post(&path("trust"), &long_ago).await.ok()["records"], json!([]));
    let id = posted["id"].as_str().unwrap();
    assert_eq!(lab.get(&format!("/v1/records/{id}")).await.ok()["state"], "set_aside");
}

/// In doubt, confirmed, suspect, trusted: what somebody has vouched for comes back.
#[tokio::test]
async fn a_time_that_was_confirmed_comes_back_with_its_window() {
    let lab = Lab::open().await;
    station_posts(&lab, &[(0, 1.0), (40, 1.0)]).await;
    let mut unset = of_a(0, 1.0);
    unset["calibrated_at"] = json!("2001-05-05T08:00:00Z");
    let id = id_of(&lab.posts(&unset).await);
    let sure = json!({"by": "Li Wei", "reason": "from the paper log"});
    lab.post(&format!("/v1/records/{id}/confirm"), &sure).await.ok();
    let window = json!({"from": "2001-01-01T00:00:00Z", "to": "2002-01-01T00:00:00Z", "by": "Li Wei", "reason": "x"});
    for deed in ["suspect", "trust", "suspect", "trust"] {
        let marked = lab.post(&format!("/v1/stations/ST-1/{deed}"), &window).await.ok();
        assert_eq!(marked["records"], json!([id]), "{deed}");
    }
    assert_eq!(lab.get(&format!("/v1/records/{id}")).await.ok()["state"], "valid");
}

/// Of two of one instant that a window set aside the right one is confirmed, and the wrong one voided.
#[tokio::test]
async fn what_is_voided_takes_nothing_from_what_counts_at_its_instant() {
    let lab = Lab::open().await;
    station_posts(&lab, &[(0, 1.0), (40, 1.0)]).await;
    lab.post("/v1/stations/ST-1/suspect", &of_window(50, 90)).await.ok();
    let [wrong, right] = [1.5, 1.0];
    let mut ids = Vec::new();
    for d_i in [wrong, right] {
        ids.push(id_of(&lab.posts(&of_a(60, d_i)).await));
    }
    let sure = json!({"by": "Li Wei", "reason": "after the repair"});
    lab.post(&format!("/v1/records/{}/confirm", ids[1]), &sure).await.ok();
    engineer_voids(&lab, &ids[0]).await;
    let counting: Vec<f64> = trend(&lab, "").await.into_iter().map(|(_, d_i)| d_i).collect();
    assert_eq!(counting, [1.0; 3]);
    let states = [&ids[0], &ids[1]].map(|id| format!("/v1/records/{id}"));
    assert_eq!(lab.get(&states[0]).await.ok()["state"], "voided");
    assert_eq!(lab.get(&states[1]).await.ok()["state"], "valid");
}

#[tokio::test]
async fn a_station_of_which_nothing_counts_still_tells_its_windows() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.0)]).await;
    lab.post("/v1/stations/ST-1/suspect", &of_window(-10, 300)).await.ok();
    let station = lab.get("/v1/stations/ST-1").await.ok();
    assert_eq!((&station["records"], &station["first"]), (&json!(0), &Value::Null));
    assert_eq!(station["suspect_windows"].as_array().map(Vec::len), Some(1), "{station}");
    assert_eq!(lab.get(&format!("/v1/records/{}", ids[0])).await.ok()["state"], "set_aside");
    lab.get("/v1/stations/NOWHERE").await.refused(404);
}

#[tokio::test]
async fn a_window_leaves_other_stations_and_times_alone_and_what_was_voided_voided() {
    let lab = Lab::open().await;
    let ids = station_posts(&lab, &[(0, 1.0), (40, 1.0), (80, 1.0)]).await;
    let mut other = of_a(41, 1.0);
    other["station"] = json!("ST-ELSEWHERE");
    let elsewhere = id_of(&lab.posts(&other).await);
    engineer_voids(&lab, &ids[2]).await;
    let path = |station: &str, deed: &str| format!("/v1/stations/{station}/{deed}");
    let aside = lab.post(&path("ST-1", "suspect"), &of_window(30, 100)).await.ok();
    assert_eq!(aside["records"], json!([ids[1]]));
    let state = async |id: &str| lab.get(&format!("/v1/records/{id}")).await.ok()["state"].clone();
    assert_eq!((state(&ids[2]).await, state(&elsewhere).await), (json!("voided"), json!("valid")));
    assert_eq!(lab.post(&path("ST-1", "trust"), &of_window(0, 100)).await.ok()["records"], json!([ids[1]]));
    assert_eq!(state(&ids[2]).await, "voided");
    assert_eq!(lab.post(&path("nowhere", "suspect"), &of_window(0, 1)).await.status, 404);
    let backwards = lab.post(&path("ST-1", "suspect"), &of_window(5, 1)).await;
    assert_eq!(backwards.refused(422), ["/to"]);
}
