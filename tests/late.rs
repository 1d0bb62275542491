//! Records that come a little late: judged by what is remembered of their gyro, as if they had come in order.

mod lab;

use std::ops::Range;

use lab::{Lab, day, record};
use serde_json::{Value, json};

/// A record of one gyro that scatters, jumps and creeps.
fn of_day(k: i64) -> Value {
    let scatter = ((k * 7919) % 13) as f64 * 4e-4;
    let jump = if (100..130).contains(&(k % 200)) { 0.02 } else { 0.0 };
    record("IMU-1", &day(k), &[("G1", "A", 1.0 + scatter + jump, 2.0 - 1e-4 * k as f64)])
}

/// Each stretch of two to seven days the other way round, day by day.
fn a_little_late(days: Range<i64>) -> Vec<Vec<i64>> {
    let (mut order, mut at) = (Vec::new(), days.start);
    while at < days.end {
        let end = days.end.min(at + 2 + at % 6);
        order.extend((at..end).rev().map(|day| vec![day]));
        at = end;
    }
    order
}

/// What is stored of every record of the gyro: when it was made, its verdicts in words, and how its points stand.
async fn judged(lab: &Lab) -> Vec<Value> {
    let mut all = Vec::new();
    for coefficient in ["D_I", "D_S"] {
        for point in lab.sees_trend("A", &format!("coefficient={coefficient}")).await {
            let id = point["record"].as_str().expect("a point names its record");
            let verdicts = lab.get(&format!("/v1/records/{id}")).await.ok()["verdicts"].clone();
            assert!(verdicts.as_array().is_some_and(|verdicts| verdicts.len() > 5));
            all.push(json!([point["calibrated_at"], point["state"], verdicts]));
        }
    }
    all
}

#[tokio::test]
async fn records_that_come_a_little_late_are_judged_as_in_order() {
    let (in_order, mut late) = (Lab::open().await, Lab::open().await);
    for lab in [&in_order, &late] {
        let first: Vec<Value> = (0..190).map(of_day).collect();
        assert!(lab.imports(&first).await.iter().all(|answer| answer["status"] == 201));
        // A baseline begins among what comes after, and a repair restarts everything.
        let mark = json!({"reason": "new fixture", "author": "Li", "at": day(233)});
        lab.post("/v1/gyros/A/baseline", &mark).await.created();
        let repair = json!({"event": "repair", "at": day(301), "author": "Li", "reason": "new float"});
        lab.post("/v1/gyros/A/events", &repair).await.created();
    }
    // What it remembers of the gyro is then the newest of its records alone.
    late.restart().await;
    for k in 190..340 {
        in_order.posts(&of_day(k)).await;
    }
    // Some come together, late ones with one from beyond the repair.
    let together = [vec![290, 291, 292, 293, 298], vec![297, 303], vec![296, 294, 295], vec![300, 299, 301, 302]];
    let rest = [a_little_late(190..290), together.to_vec(), a_little_late(304..340)].concat();
    for (k, days) in rest.iter().enumerate() {
        let records: Vec<Value> = days.iter().map(|at| of_day(*at)).collect();
        assert!(late.imports(&records).await.iter().all(|answer| answer["status"] == 201));
        if k == 60 {
            // One that came long ago lies beyond what is remembered.
            late.posts(&record("IMU-2", &day(-400), &[("G1", "A", 1.3, 2.0)])).await;
            in_order.posts(&record("IMU-2", &day(-400), &[("G1", "A", 1.3, 2.0)])).await;
        }
    }
    let expected = judged(&in_order).await;
    assert_eq!(expected.len(), 2 * 341);
    for state in ["within", "exceeded"] {
        assert!(expected.iter().any(|of| of[1] == state), "{state}");
    }
    for (found, expected) in judged(&late).await.iter().zip(&expected) {
        assert_eq!(found, expected);
    }
}
