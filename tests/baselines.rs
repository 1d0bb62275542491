//! Levels that an engineer states: what comes after them is compared with these, until the next mark.

use crate::lab::{Lab, assert_close, day, record, verdict};
use serde_json::{Value, json};

async fn station_posts(lab: &Lab, at: i64, d_i: f64, d_s: f64) -> Value {
    lab.posts(&record("IMU-1", &day(at), &[("G1", "A", d_i, d_s)])).await
}

fn stated(at: i64, fixed: Value) -> Value {
    json!({"reason": "acceptance file 7", "author": "Li", "at": day(at), "fixed": fixed})
}

#[tokio::test]
async fn a_stated_level_judges_the_very_next_record_and_one_that_is_left_out_is_measured() {
    let lab = Lab::open().await;
    station_posts(&lab, 0, 1.0, 2.0).await;
    let answer = lab.post("/v1/gyros/A/baseline", &stated(10, json!({"D_I": 1.1, "D_I_sd": 0.001}))).await.created();
    assert_eq!(answer["fixed"], json!({"D_I": 1.1, "D_I_sd": 0.001}));
    let first = station_posts(&lab, 20, 1.102, 2.0).await;
    let (d_i, d_s) = (verdict(&first, "A", "D_I", "baseline"), verdict(&first, "A", "D_S", "baseline"));
    assert_close(&d_i["value"], 0.002, 1e-9);
    assert_eq!((&d_i["state"], &d_s["state"]), (&json!("within"), &json!("indeterminate")));
    let out = station_posts(&lab, 30, 1.12, 2.0).await;
    assert_eq!(verdict(&out, "A", "D_I", "baseline")["state"], "exceeded");
    station_posts(&lab, 40, 1.1, 2.0).await;
    let fourth = station_posts(&lab, 50, 1.1, 2.02).await;
    assert_close(&verdict(&fourth, "A", "D_S", "baseline")["value"], 0.02, 1e-9);
    let event = lab.get("/v1/gyros/A/events").await.ok()["events"][0].clone();
    assert_eq!((&event["event"], &event["fixed"]), (&json!("baseline"), &answer["fixed"]));
    assert_eq!(lab.get("/v1/gyros/A/trend").await.ok()["events"][0]["fixed"], answer["fixed"]);
}

#[tokio::test]
async fn stated_levels_hold_until_the_next_mark_and_over_a_restart_and_judge_what_is_stored_already() {
    let mut lab = Lab::open().await;
    let mut ids = Vec::new();
    for at in [0, 10, 20, 30] {
        ids.push(station_posts(&lab, at, 1.0, 2.0).await["id"].as_str().unwrap().to_owned());
    }
    lab.post("/v1/gyros/A/baseline", &stated(25, json!({"D_I": 1.05, "D_S": 2.0}))).await.created();
    let again = lab.get(&format!("/v1/records/{}", ids[3])).await.ok();
    assert_close(&verdict(&again, "A", "D_I", "baseline")["value"], 0.05, 1e-9);
    let fires = async |lab: &Lab| lab.get("/v1/alerts?rule=baseline&state=firing").await.ok()["alerts"].clone();
    assert_eq!(fires(&lab).await[0]["coefficient"], "D_I");
    lab.restart().await;
    let after = station_posts(&lab, 40, 1.05, 2.0).await;
    assert_close(&verdict(&after, "A", "D_I", "baseline")["value"], 0.0, 1e-9);
    assert_eq!(fires(&lab).await, json!([]));
    lab.post("/v1/gyros/A/baseline", &json!({"reason": "repaired", "at": day(45)})).await.created();
    let next = station_posts(&lab, 50, 1.3, 2.0).await;
    assert_eq!(verdict(&next, "A", "D_I", "baseline")["value"], Value::Null, "levels are measured again");
    let late = station_posts(&lab, 35, 1.08, 2.0).await;
    assert_close(&verdict(&late, "A", "D_I", "baseline")["value"], 0.03, 1e-9);
}

#[tokio::test]
async fn a_stated_level_takes_the_place_of_a_configured_one() {
    use gyrowatch::config::Config;
    let lab = Lab::with(|config: &mut Config| {
        config.judging.rules.fixed_baseline = Some(gyrowatch::config::FixedBaseline { value: 1.0, sd: None });
    })
    .await;
    let before = station_posts(&lab, 0, 1.004, 1.004).await;
    assert_close(&verdict(&before, "A", "D_I", "baseline")["value"], 0.004, 1e-9);
    lab.post("/v1/gyros/A/baseline", &stated(5, json!({"D_I": 1.003}))).await.created();
    let after = station_posts(&lab, 10, 1.004, 1.004).await;
    assert_close(&verdict(&after, "A", "D_I", "baseline")["value"], 0.001, 1e-9);
    assert_close(&verdict(&after, "A", "D_S", "baseline")["value"], 0.004, 1e-9);
}

#[tokio::test]
async fn levels_that_cannot_be_are_refused_with_the_place_and_sent_twice_are_stored_once() {
    let lab = Lab::open().await;
    station_posts(&lab, 0, 1.0, 2.0).await;
    for (fixed, places) in [
        (json!({}), vec!["/fixed"]),
        (json!({"D_I": 1e9}), vec!["/fixed/D_I"]),
        (json!({"D_I": 1.0, "D_I_sd": -1.0}), vec!["/fixed/D_I_sd"]),
        (json!({"D_I": 1.0, "D_S_sd": 0.1}), vec!["/fixed/D_S_sd"]),
        (json!({"D_I": "1.0"}), vec!["/fixed/D_I"]),
        (json!({"D_O": 1.0}), vec!["/fixed/D_O"]),
    ] {
        assert_eq!(lab.post("/v1/gyros/A/baseline", &stated(1, fixed.clone())).await.refused(422), places, "{fixed}");
    }
    let blank = lab.post("/v1/gyros/A/baseline", &json!({"reason": " "})).await;
    assert_eq!(blank.refused(422), ["/reason"]);
    assert!(blank.text.contains("must say what was done to the gyro"));
    lab.post("/v1/gyros/none/baseline", &stated(1, json!({"D_I": 1.0}))).await.refused(404);
    let first = lab.post("/v1/gyros/A/baseline", &stated(1, json!({"D_I": 1.0}))).await.created();
    assert_eq!(lab.post("/v1/gyros/A/baseline", &stated(1, json!({"D_I": 1.0}))).await.ok()["id"], first["id"]);
    lab.post("/v1/gyros/A/baseline", &stated(1, json!({"D_I": 1.1}))).await.refused(409);
    assert_eq!(lab.get("/v1/gyros/A/events").await.ok()["events"].as_array().unwrap().len(), 1);
}
