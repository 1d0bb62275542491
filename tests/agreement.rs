//! Table 5 of the paper: the results of every method side by side.

use crate::lab::{NDJSON, assert_close, bench, verdict};
use crate::prelude::*;

/// Table 5: slot, serial, then D_I and D_S of bench before, separation, bench after, and the printed range in 1e-4.
const TABLE_5: [(&str, &str, [[f64; 3]; 2], [f64; 2]); 3] = [
    ("G1", "T5-1", [[4.193101, 4.192621, 4.192798], [5.771452, 5.771440, 5.772109]], [4.800, 6.690]),
    ("G2", "T5-2", [[1.584331, 1.584334, 1.584927], [6.132195, 6.131210, 6.132201]], [5.960, 9.910]),
    ("G3", "T5-3", [[1.686599, 1.686447, 1.6865143], [-9.977666, -9.976657, -9.976365]], [1.520, 13.010]),
];

async fn lab_with_table_5(before: &str, separation: &str, after: &str) -> Lab {
    let lab = Lab::open().await;
    let gyros = TABLE_5.map(|(slot, serial, [d_i, d_s], _)| (slot, serial, d_i[1], d_s[1]));
    lab.posts(&record("IMU-5", separation, &gyros)).await;
    for (_, serial, [d_i, d_s], _) in TABLE_5 {
        for (at, column) in [(before, 0), (after, 2)] {
            let result = bench(serial, at, d_i[column], d_s[column]);
            lab.post("/v1/bench-results", &result).await.created();
        }
    }
    lab
}

#[tokio::test]
async fn table_5_gives_its_range_column() {
    for [before, separation, after] in [
        ["2026-02-10T08:00:00Z", "2026-03-01T08:00:00Z", "2026-04-02T08:00:00Z"],
        ["2026-02-10T08:00:00Z", "2026-03-01T08:00:00Z", "2026-02-11T08:00:00Z"],
        ["2026-03-02T08:00:00Z", "2026-03-01T08:00:00Z", "2026-03-03T08:00:00Z"],
    ] {
        let lab = lab_with_table_5(before, separation, after).await;
        for (_, serial, _, range) in TABLE_5 {
            let agreement = lab.get(&format!("/v1/gyros/{serial}/agreement")).await.ok();
            for (coefficient, printed) in ["D_I", "D_S"].iter().zip(range) {
                assert_close(&agreement["range"][coefficient], printed * 1e-4, 5e-9);
                let judged = verdict(&agreement, serial, coefficient, "agreement");
                assert_close(&judged["value"], printed * 1e-4, 5e-9);
                assert_eq!(judged["state"], "within");
            }
            let counted = agreement["results"].as_array().unwrap().iter().filter(|r| r["counts"] == true).count();
            assert_eq!(counted, 3);
        }
    }
}

#[tokio::test]
async fn the_file_of_table_5_gives_its_range_column() {
    let lab = Lab::open().await;
    let lines = lab.post_text("/v1/import", NDJSON, include_str!("data/paper-table5.ndjson")).await.lines();
    assert!(lines.len() == 7 && lines.iter().all(|line| line["status"] == 201), "{lines:?}");
    for (serial, (.., range)) in ["LFG-0501", "LFG-0502", "LFG-0503"].iter().zip(TABLE_5) {
        let agreement = lab.get(&format!("/v1/gyros/{serial}/agreement")).await.ok();
        for (coefficient, printed) in ["D_I", "D_S"].iter().zip(range) {
            assert_close(&agreement["range"][coefficient], printed * 1e-4, 1e-12);
        }
    }
}

#[tokio::test]
async fn the_bench_tests_around_a_calibration_are_compared_with_it_not_those_of_other_years() {
    let lab = lab_with_table_5("2026-02-10T08:00:00Z", "2026-03-01T08:00:00Z", "2026-04-02T08:00:00Z").await;
    lab.post("/v1/bench-results", &bench("T5-1", "2015-01-01T00:00:00Z", 9.0, 9.0)).await.created();
    lab.posts(&record("IMU-5", "2026-10-01T08:00:00Z", &[("G1", "T5-1", 4.4, 5.9)])).await;
    let agreement = lab.get("/v1/gyros/T5-1/agreement").await.ok();
    assert_close(&agreement["range"]["D_I"], 4.8e-4, 5e-9);
    let whole = lab.get("/v1/gyros/T5-1/agreement?from=2015-01-01T00:00:00Z").await.ok();
    assert_close(&whole["range"]["D_I"], 9.0 - 4.192621, 1e-9);
    let methods: Vec<&Value> = whole["results"].as_array().unwrap().iter().map(|r| &r["method"]).collect();
    assert_eq!(
        methods,
        ["torque_feedback", "torque_feedback", "published", "rigid", "torque_feedback", "published", "rigid"]
    );
}

#[tokio::test]
async fn methods_that_disagree_are_named() {
    let lab = Lab::open().await;
    lab.posts(&record("IMU-1", "2026-03-01T08:00:00Z", &[("G1", "A", 1.0, 2.0)])).await;
    let alone = lab.get("/v1/gyros/A/agreement").await.ok();
    assert_eq!(alone["range"], json!({"D_I": null, "D_S": null}));
    assert_eq!(verdict(&alone, "A", "D_I", "agreement")["state"], "indeterminate");
    let mut servo = bench("A", "2026-03-05T08:00:00Z", 1.02, 2.001);
    servo["method"] = json!("turntable_servo");
    lab.post("/v1/bench-results", &servo).await.created();
    let agreement = lab.get("/v1/gyros/A/agreement").await.ok();
    let d_i = verdict(&agreement, "A", "D_I", "agreement");
    assert_eq!(d_i["state"], "exceeded");
    let of = |which: &str| &d_i["parameters"][which]["parameters"];
    assert_eq!([&d_i["code"], &of("highest")["method"]["code"]], ["agreement", "method_turntable_servo"]);
    assert_eq!(of("lowest")["method"]["code"], "method_separation");
    assert_eq!(verdict(&agreement, "A", "D_S", "agreement")["state"], "within");
}

/// State of a gyro, by itself and among the others.
async fn states(lab: &Lab, serial: &str) -> [Value; 2] {
    let alone = lab.get(&format!("/v1/gyros/{serial}")).await.ok();
    let all = lab.get("/v1/gyros").await.ok();
    let among = all["gyros"].as_array().unwrap().iter().find(|gyro| gyro["serial"] == serial).unwrap();
    [alone["state"].clone(), among["state"].clone()]
}

#[tokio::test]
async fn a_gyro_whose_methods_disagree_is_not_well_until_the_alert_is_over() {
    let lab = Lab::open().await;
    lab.posts(&record("IMU-1", "2026-03-01T08:00:00Z", &[("G1", "A", 1.0, 2.0), ("G2", "B", 1.0, 2.0)])).await;
    let before = states(&lab, "A").await;
    assert!(before[0] != "exceeded" && before[0] == before[1], "{before:?}");
    let off = lab.post("/v1/bench-results", &bench("A", "2026-03-05T08:00:00Z", 1.02, 2.001)).await.created();
    assert_eq!(states(&lab, "A").await, ["exceeded", "exceeded"]);
    let gyro = lab.get("/v1/gyros/A").await.ok();
    assert_eq!(gyro["status"], "unconfirmed");
    assert_eq!(lab.get("/v1/alerts?serial=A&rule=agreement").await.ok()["alerts"][0]["status"], "unconfirmed");
    assert_eq!(verdict(&gyro, "A", "D_I", "agreement")["state"], "exceeded");
    assert_eq!(verdict(&gyro, "A", "D_I", "agreement")["status"], "unconfirmed");
    assert_eq!(verdict(&gyro, "A", "D_S", "agreement")["state"], "within");
    assert_eq!(states(&lab, "B").await, before);
    let unmeasured = lab.get("/v1/gyros/B").await.ok();
    assert!(unmeasured["verdicts"].as_array().unwrap().iter().all(|verdict| verdict["rule"] != "agreement"));
    // Somebody knows: that makes it no better.
    let alert = lab.get("/v1/alerts?serial=A&rule=agreement").await.ok()["alerts"][0]["id"].clone();
    let known = json!({"by": "Li", "reason": "the bench is looked at"});
    lab.post(&format!("/v1/alerts/{}/acknowledge", alert.as_str().unwrap()), &known).await.ok();
    assert_eq!(states(&lab, "A").await, ["exceeded", "exceeded"]);
    let void = json!({"author": "Li", "reason": "the table slipped"});
    lab.post(&format!("/v1/bench-results/{}/void", off["id"].as_str().unwrap()), &void).await;
    assert_eq!(states(&lab, "A").await, before);
}

#[tokio::test]
async fn methods_that_nobody_asks_about_any_more_make_no_gyro_unwell() {
    let mut lab = Lab::open().await;
    lab.posts(&record("IMU-1", "2026-03-01T08:00:00Z", &[("G1", "A", 1.0, 2.0)])).await;
    let before = states(&lab, "A").await;
    lab.post("/v1/bench-results", &bench("A", "2026-03-05T08:00:00Z", 1.02, 2.001)).await.created();
    assert_eq!(states(&lab, "A").await, ["exceeded", "exceeded"]);
    lab.config.judging.rules = serde_json::from_value(json!({"off": ["agreement"]})).expect("rules");
    lab.restart().await;
    assert_eq!(states(&lab, "A").await, before);
    let firing = async |lab: &Lab| lab.get("/v1/alerts?serial=A&state=firing").await.ok()["alerts"].clone();
    assert_eq!(firing(&lab).await[0]["rule"], "agreement");
    lab.post("/v1/bench-results", &bench("A", "2026-03-06T08:00:00Z", 1.03, 2.001)).await.created();
    assert_eq!(firing(&lab).await, json!([]), "its next item ends the alert");
}

#[tokio::test]
async fn a_gyro_that_only_benches_have_seen_is_not_well_where_they_disagree() {
    let lab = Lab::open().await;
    lab.post("/v1/bench-results", &bench("A", "2026-03-05T08:00:00Z", 1.0, 2.0)).await.created();
    assert_eq!(states(&lab, "A").await, [Value::Null, Value::Null]);
    lab.post("/v1/bench-results", &bench("A", "2026-03-06T08:00:00Z", 1.03, 2.0)).await.created();
    assert_eq!(states(&lab, "A").await, ["exceeded", "exceeded"]);
}

#[tokio::test]
async fn what_is_too_old_beside_the_newest_result_does_not_count() {
    let mut lab = Lab::open().await;
    lab.posts(&record("IMU-1", "2025-01-01T08:00:00Z", &[("G1", "A", 1.0, 2.0)])).await;
    lab.post("/v1/bench-results", &bench("A", "2026-01-01T08:00:00Z", 1.5, 2.0)).await.created();
    let counted = |agreement: &Value| -> Vec<bool> {
        let results = agreement["results"].as_array().unwrap().iter().filter(|result| result["method"] != "published");
        results.map(|result| result["counts"].as_bool().unwrap()).collect()
    };
    let apart = lab.get("/v1/gyros/A/agreement").await.ok();
    assert_eq!((counted(&apart), &apart["range"]), (vec![false, true], &json!({"D_I": null, "D_S": null})));
    let d_i = verdict(&apart, "A", "D_I", "agreement");
    assert_eq!((&d_i["state"], &d_i["value"]), (&json!("indeterminate"), &Value::Null));
    assert_eq!(
        d_i["reason"],
        "D_I: not enough data for agreement of methods. It needs 2 results within 180 days and has 1."
    );
    assert_eq!(d_i["status"], "not_enough_data");
    // Whoever names a span compares what is in it.
    let named = lab.get("/v1/gyros/A/agreement?from=2025-01-01T00:00:00Z").await.ok();
    assert_eq!(counted(&named), [true, true]);
    assert_close(&named["range"]["D_I"], 0.5, 1e-9);
    assert_eq!(verdict(&named, "A", "D_I", "agreement")["state"], "exceeded");
    lab.stop().await;
    lab.config.judging.agreement_days = 366.0;
    lab.start().await;
    let near = lab.get("/v1/gyros/A/agreement").await.ok();
    assert_eq!(counted(&near), [true, true]);
    assert_close(&near["range"]["D_I"], 0.5, 1e-9);
    assert_close(&verdict(&near, "A", "D_I", "agreement")["value"], 0.5, 1e-9);
}

#[tokio::test]
async fn bench_results_follow_the_rules_of_records() {
    let lab = Lab::open().await;
    let mut result = bench("LFG-0101", "2026-02-10T08:00:00Z", 4.193101, 5.771452);
    result["d_i_sd"] = json!(0.0003);
    let posted = lab.post("/v1/bench-results", &result).await;
    let id = posted.created()["id"].clone();
    assert_eq!(posted.header("location"), format!("/v1/bench-results/{}", id.as_str().unwrap()));
    assert_eq!(lab.get(posted.header("location")).await.ok()["bench_result"], result);
    assert_eq!(lab.post("/v1/bench-results", &result).await.ok()["id"], id);
    let mut changed = result.clone();
    changed["d_s_deg_per_h_g0"] = json!(5.8);
    assert_eq!(lab.post("/v1/bench-results", &changed).await.refused(409), ["/d_s_deg_per_h_g0"]);
    let alike = bench("LFG-O101", "2026-02-10T08:00:00Z", 4.193101, 5.771452);
    let noted = lab.post("/v1/bench-results", &alike).await.created();
    assert_eq!(
        (&noted["notes"][0]["code"], noted["notes"].as_array().unwrap().len()),
        (&json!("look_alike"), 1),
        "{noted}"
    );
    for (member, value) in [
        ("method", json!("guess")),
        ("d_i_sd", json!(-1)),
        ("measured_at", json!("2026-02-10")),
        ("d_i_deg_per_h_g0", json!(1e300)),
        ("serial", json!("")),
        ("surprise", json!(1)),
    ] {
        let mut bad = result.clone();
        bad[member] = value;
        assert_eq!(lab.post("/v1/bench-results", &bad).await.refused(422), [format!("/{member}")]);
    }
    let gyro = lab.get("/v1/gyros/LFG-0101").await.ok();
    assert_eq!((&gyro["latest"], &gyro["bench_results"]), (&Value::Null, &json!(1)));
}
