//! Records that come a little late, or very densely: judged by what is remembered of their gyro, as if they had come
//! in order and all were.

use std::collections::VecDeque;
use std::ops::Range;

use crate::prelude::*;

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

/// In the order of time, with a mark and a repair among them; judged by everything.
async fn expected(records: impl Iterator<Item = Value>, marks: [String; 2]) -> Vec<Value> {
    let lab = Lab::open().await;
    let all: Vec<Value> = records.collect();
    for (k, part) in all.chunks(190).enumerate() {
        assert!(lab.imports(part).await.iter().all(|answer| answer["status"] == 201));
        if k == 0 {
            happen(&lab, &marks).await;
        }
    }
    let expected = judged(&lab).await;
    assert_eq!(expected.len(), 2 * all.len());
    for state in ["within", "exceeded"] {
        assert!(expected.iter().any(|of| of[1] == state), "{state}");
    }
    expected
}

/// A baseline begins, and later a repair restarts everything.
async fn happen(lab: &Lab, [mark, repair]: &[String; 2]) {
    let mark = json!({"reason": "new fixture", "author": "Li", "at": mark});
    lab.post("/v1/gyros/A/baseline", &mark).await.created();
    let repair = json!({"event": "repair", "at": repair, "author": "Li", "reason": "new float"});
    lab.post("/v1/gyros/A/events", &repair).await.created();
}

fn assert_alike(found: &[Value], expected: &[Value]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found, expected);
    }
}

#[tokio::test]
async fn records_that_come_a_little_late_are_judged_as_in_order() {
    let marks = [233, 301].map(day);
    let long_ago = record("IMU-2", &day(-400), &[("G1", "A", 1.3, 2.0)]);
    let expected = expected([long_ago.clone()].into_iter().chain((0..340).map(of_day)), marks.clone()).await;
    let mut late = Lab::open().await;
    let first: Vec<Value> = (0..190).map(of_day).collect();
    assert!(late.imports(&first).await.iter().all(|answer| answer["status"] == 201));
    happen(&late, &marks).await;
    // What it remembers of the gyro is then the newest of its records alone.
    late.restart().await;
    // Some come together, late ones with one from beyond the repair.
    let together = [vec![290, 291, 292, 293, 298], vec![297, 303], vec![296, 294, 295], vec![300, 299, 301, 302]];
    let rest = [a_little_late(190..290), together.to_vec(), a_little_late(304..340)].concat();
    for (k, days) in rest.iter().enumerate() {
        let records: Vec<Value> = days.iter().map(|at| of_day(*at)).collect();
        assert!(late.imports(&records).await.iter().all(|answer| answer["status"] == 201));
        if k == 60 {
            // It lies beyond what is remembered.
            late.posts(&long_ago).await;
        }
    }
    assert_alike(&judged(&late).await, &expected);
}

/// As [`of_day`], every two hours.
fn of_two_hours(k: i64) -> Value {
    let mut record = of_day(k);
    record["calibrated_at"] = json!(hours(2 * k));
    record
}

fn hours(hours: i64) -> String {
    let midnight = day(hours.div_euclid(24));
    midnight.replace("T12:", &format!("T{:02}:", hours.rem_euclid(24)))
}

#[tokio::test]
async fn records_too_many_to_be_remembered_one_by_one_are_judged_as_if_they_were() {
    let marks = [hours(2 * 640 + 1), hours(2 * 860 + 1)];
    let expected = expected((0..1000).map(of_two_hours), marks.clone()).await;
    let mut short = Lab::with(|config| config.judging.remembered_records = 150).await;
    let (mut groups, mut at) = (Vec::new(), 0);
    while at < 1000 {
        let size = [1, 1, 7, 40, 1, 90][groups.len() % 6];
        groups.push((at..1000.min(at + size)).collect::<Vec<i64>>());
        at += size;
    }
    for (k, group) in groups.iter().enumerate() {
        // Of two groups of one each the later comes first.
        let group = match k % 6 {
            0 => groups.get(k + 1),
            1 => groups.get(k - 1),
            _ => Some(group),
        };
        let records: Vec<Value> = group.into_iter().flatten().map(|at| of_two_hours(*at)).collect();
        assert!(short.imports(&records).await.iter().all(|answer| answer["status"] == 201));
        if k == 8 {
            happen(&short, &marks).await;
        }
        if k == 20 {
            short.restart().await;
        }
    }
    assert_alike(&judged(&short).await, &expected);
}

/// What should not have come.
fn stray(at: &str) -> Value {
    record("IMU-1", at, &[("G1", "A", 1.5, 2.5)])
}

#[tokio::test]
async fn what_is_put_right_among_too_many_to_be_remembered_is_judged_as_if_it_had_been_right() {
    let marks = [hours(2 * 340 + 1), hours(2 * 560 + 1)];
    let expected = expected((0..700).map(of_two_hours), marks.clone()).await;
    let mut short = Lab::with(|config| config.judging.remembered_records = 150).await;
    let mut wrong = VecDeque::new();
    for (k, first) in (0..700).step_by(20).enumerate() {
        let mut records: Vec<Value> = (first..first + 20).map(of_two_hours).collect();
        let right = std::mem::replace(&mut records[1], stray(&hours(2 * (first + 1))));
        records.push(stray(&hours(2 * (first + 10) + 1)));
        let answers = short.imports(&records).await;
        let id = |k: usize| answers[k]["id"].as_str().expect("it is stored").to_owned();
        wrong.push_back((id(1), right, id(20)));
        if k == 9 {
            happen(&short, &marks).await;
        }
        if k == 20 {
            short.restart().await;
        }
        // At once, or when much more has come.
        let left = if k == 34 { 0 } else { [7, 7, 7, 7, 7, 7, 7, 2, 0][k % 9] };
        while wrong.len() > left {
            let (revised, right, voided) = wrong.pop_front().expect("there is one");
            let said = json!({"author": "Li", "reason": "wrong fixture"});
            short.post(&format!("/v1/records/{voided}/void"), &said).await.ok();
            let said = json!({"author": "Li", "reason": "wrong fixture", "record": right});
            short.post(&format!("/v1/records/{revised}/revise"), &said).await.created();
        }
    }
    assert_alike(&judged(&short).await, &expected);
}
