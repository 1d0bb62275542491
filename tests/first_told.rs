//! A hook that begins to listen is first told what fires, and never hears the end of what it did not hear fire.

use std::sync::atomic::Ordering;

use axum::http::StatusCode;
use gyrowatch::core::time::UtcMicros;
use gyrowatch::pipeline::{AlertChange, AlertOrder};

use crate::prelude::*;

/// The gyro steps at its fourth record.
async fn steps(lab: &Lab, serial: &str) {
    lab.posts_history(&format!("IMU-{serial}"), serial, &[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.05)]).await;
}

/// The gyro is back at its level, so often that all is resolved.
async fn recovers(lab: &Lab, serial: &str) {
    lab.posts_history(&format!("IMU-{serial}"), serial, &[160, 200, 240].map(|at| (at, 1.0))).await;
    assert_eq!(firing(lab, serial).await, 0);
}

async fn firing(lab: &Lab, serial: &str) -> usize {
    lab.alerts(&format!("state=firing&serial={serial}")).await.len()
}

/// What a target has been told, alert by alert: gyro, rule and event; once nothing is open for the hook.
async fn told(lab: &Lab, hook: &str, target: &Receiver) -> Vec<Vec<String>> {
    lab.all_told(hook).await;
    let of_message = |body: &Value| -> Vec<String> {
        let text = |alert: &Value, member: &str| alert[member].as_str().unwrap().to_owned();
        let alerts = body["alerts"].as_array().unwrap().iter();
        let mut all: Vec<String> =
            alerts.map(|alert| ["serial", "rule", "event"].map(|member| text(alert, member)).join(" ")).collect();
        all.sort();
        all
    };
    target.told().iter().map(|told| of_message(&told.json())).collect()
}

/// Three rules see the step.
fn all_of(serial: &str, event: &str) -> Vec<String> {
    ["baseline", "range", "step"].map(|rule| format!("{serial} {rule} {event}")).into()
}

#[tokio::test]
async fn a_new_hook_is_told_at_once_what_fires_and_no_end_of_what_it_did_not_hear() {
    let mut lab = Lab::open().await;
    steps(&lab, "A").await;
    steps(&lab, "B").await;
    steps(&lab, "C").await;
    recovers(&lab, "C").await;
    let targets = [Receiver::start().await, Receiver::start().await, Receiver::start().await];
    let all = lab.tells(&targets[0], json!({})).await;
    let of_b = lab.tells(&targets[1], json!({ "filter": { "gyros": ["B"], "rules": ["step"] } })).await;
    let each = lab.tells(&targets[2], json!({ "batch": false })).await;
    assert_eq!(
        told(&lab, &all, &targets[0]).await,
        [[all_of("A", "alert.fired"), all_of("B", "alert.fired")].concat()]
    );
    assert_eq!(told(&lab, &of_b, &targets[1]).await, [["B step alert.fired"]]);
    let singly = told(&lab, &each, &targets[2]).await;
    assert_eq!(singly.len(), 6, "{singly:?}");
    // After a restart it is still known who has heard what.
    lab.restart().await;
    recovers(&lab, "A").await;
    let ended = told(&lab, &all, &targets[0]).await;
    assert_eq!(ended[1..].concat().iter().filter(|one| one.ends_with("alert.resolved")).count(), 3, "{ended:?}");
    assert_eq!(told(&lab, &of_b, &targets[1]).await.len(), 1, "A is nothing to it");
}

#[tokio::test]
async fn a_hook_whose_filter_changes_hears_what_it_lets_through_from_now_on_and_the_end_of_what_it_heard() {
    let lab = Lab::open().await;
    let target = Receiver::start().await;
    let id = lab.tells(&target, json!({ "filter": { "gyros": ["A"] } })).await;
    steps(&lab, "A").await;
    steps(&lab, "B").await;
    assert_eq!(told(&lab, &id, &target).await, [all_of("A", "alert.fired")]);
    lab.patch(&format!("/v1/hooks/{id}"), &json!({ "filter": { "gyros": ["B"] } })).await.ok();
    assert_eq!(told(&lab, &id, &target).await[1..], [all_of("B", "alert.fired")]);
    lab.patch(&format!("/v1/hooks/{id}"), &json!({ "name": "night" })).await.ok();
    recovers(&lab, "A").await;
    let all = told(&lab, &id, &target).await;
    let ends: Vec<String> = all[2..].concat();
    assert_eq!(ends.iter().filter(|one| *one == "A step alert.resolved").count(), 1, "{all:?}");
    assert!(ends.iter().all(|one| one.starts_with('A')), "nothing else of A, nothing twice of B: {all:?}");
}

#[tokio::test]
async fn a_hook_with_another_address_tells_there_what_fires() {
    let lab = Lab::open().await;
    let (old, new) = (Receiver::start().await, Receiver::start().await);
    let id = lab.tells(&old, json!({})).await;
    steps(&lab, "A").await;
    steps(&lab, "B").await;
    recovers(&lab, "B").await;
    let heard = told(&lab, &id, &old).await.len();
    // The same address again is no other.
    lab.patch(&format!("/v1/hooks/{id}"), &json!({ "url": old.url() })).await.ok();
    lab.patch(&format!("/v1/hooks/{id}"), &json!({ "url": new.url() })).await.ok();
    assert_eq!(told(&lab, &id, &new).await, [all_of("A", "alert.fired")]);
    assert_eq!(told(&lab, &id, &old).await.len(), heard);
}

#[tokio::test]
async fn a_hook_that_is_enabled_again_hears_how_things_stand_and_not_what_it_missed() {
    let lab = Lab::open().await;
    let target = Receiver::start().await;
    let id = lab.tells(&target, json!({})).await;
    steps(&lab, "A").await;
    steps(&lab, "B").await;
    assert_eq!(told(&lab, &id, &target).await.len(), 2);
    lab.patch(&format!("/v1/hooks/{id}"), &json!({ "enabled": false })).await.ok();
    recovers(&lab, "A").await;
    steps(&lab, "C").await;
    steps(&lab, "D").await;
    recovers(&lab, "D").await;
    lab.patch(&format!("/v1/hooks/{id}"), &json!({ "enabled": true })).await.ok();
    let all = told(&lab, &id, &target).await;
    let expected = [all_of("A", "alert.resolved"), all_of("B", "alert.fired"), all_of("C", "alert.fired")].concat();
    assert_eq!(all[2..], [expected], "of D, which came and went, nothing");
    recovers(&lab, "C").await;
    let ends = told(&lab, &id, &target).await[3..].concat();
    assert_eq!(ends.iter().filter(|one| one.ends_with("alert.resolved")).count(), 3, "{ends:?}");
}

#[tokio::test]
async fn a_hook_that_is_back_from_410_hears_what_fires_instead_of_what_waited() {
    let lab = Lab::with(|config| config.hooks.retry_waits_s = vec![3600.0]).await;
    let (target, takes) = Receiver::switched(false, StatusCode::GONE).await;
    let id = lab.tells(&target, json!({})).await;
    steps(&lab, "A").await;
    once(async || lab.get(&format!("/v1/hooks/{id}")).await.ok(), |hook| hook["enabled"] == false).await;
    steps(&lab, "B").await;
    recovers(&lab, "A").await;
    takes.store(true, Ordering::SeqCst);
    let refused = target.told().len();
    lab.patch(&format!("/v1/hooks/{id}"), &json!({ "enabled": true })).await.ok();
    let all = told(&lab, &id, &target).await;
    assert_eq!(all[refused..], [all_of("B", "alert.fired")], "that A fires never came, so its end does not either");
}

#[tokio::test]
async fn what_a_silence_has_held_back_is_told_at_its_end_to_hooks_that_came_during_it_too() {
    let lab = Lab::open().await;
    let (early, late) = (Receiver::start().await, Receiver::start().await);
    let first = lab.tells(&early, json!({})).await;
    steps(&lab, "A").await;
    assert_eq!(told(&lab, &first, &early).await, [all_of("A", "alert.fired")]);
    let order = json!({"matchers": {"serial": "A"}, "until": "2026-11-30T00:00:00Z", "by": "Li", "reason": "known"});
    let silence = lab.post("/v1/silences", &order).await.created()["id"].as_str().unwrap().to_owned();
    let second = lab.tells(&late, json!({})).await;
    steps(&lab, "B").await;
    assert_eq!(told(&lab, &second, &late).await, [all_of("B", "alert.fired")], "A is silenced");
    lab.post(&format!("/v1/silences/{silence}/end"), &json!({"by": "Li", "reason": "over"})).await.ok();
    assert_eq!(told(&lab, &second, &late).await[1..], [all_of("A", "alert.fired")]);
    assert_eq!(told(&lab, &first, &early).await.len(), 2, "it knows already");
}

#[tokio::test]
async fn a_silence_that_is_taken_off_one_alert_is_told_to_hooks_that_came_during_it() {
    let lab = Lab::open().await;
    let (early, late) = (Receiver::start().await, Receiver::start().await);
    let first = lab.tells(&early, json!({"filter": {"rules": ["step"]}})).await;
    steps(&lab, "A").await;
    assert_eq!(told(&lab, &first, &early).await, [["A step alert.fired"]]);
    let alert = lab.get("/v1/alerts?serial=A&rule=step").await.ok()["alerts"][0]["id"].as_str().unwrap().to_owned();
    let silence = json!({"until": "2026-11-30T00:00:00Z", "by": "Li", "reason": "known"});
    lab.post(&format!("/v1/alerts/{alert}/silence"), &silence).await.ok();
    let second = lab.tells(&late, json!({"filter": {"rules": ["step"]}})).await;
    assert!(told(&lab, &second, &late).await.is_empty(), "it is silenced");
    let (by, reason) = ("Li".to_owned(), "mended".to_owned());
    let order = AlertOrder { alert: alert.parse().unwrap(), change: AlertChange::Unsilence, by, reason };
    assert_eq!(lab.pipeline().alerts.change(order).await.unwrap().state, "firing");
    assert_eq!(told(&lab, &second, &late).await, [["A step alert.fired"]]);
    assert_eq!(told(&lab, &first, &early).await.len(), 1, "it knows already");
}

#[tokio::test]
async fn who_has_heard_that_an_alert_is_grave_hears_that_it_is_less_so() {
    let lab = Lab::open().await;
    let target = Receiver::start().await;
    let id = lab.tells(&target, json!({"filter": {"min_severity": "critical", "rules": ["baseline"]}})).await;
    steps(&lab, "A").await;
    let confirms = record("IMU-A", &day(150), &[("G1", "A", 1.05, 2.0)]);
    let confirms = lab.posts(&confirms).await["id"].as_str().unwrap().to_owned();
    assert_eq!(told(&lab, &id, &target).await, [["A baseline alert.fired"]]);
    let void = json!({"author": "Li", "reason": "the table was not level"});
    lab.post(&format!("/v1/records/{confirms}/void"), &void).await.ok();
    assert_eq!(told(&lab, &id, &target).await[1..], [["A baseline alert.lowered"]]);
    recovers(&lab, "A").await;
    assert_eq!(told(&lab, &id, &target).await[2..], [["A baseline alert.resolved"]]);
}

/// The clock of the service stands still by itself.
async fn a_second_passes(lab: &Lab) {
    lab.clock.set(UtcMicros(lab.clock.now().0 + 1_000_000));
    tokio::time::sleep(Duration::from_millis(10)).await;
}

/// Waits, as time passes, until nothing is open for the hook; says how many messages it has given up.
async fn settles(lab: &Lab, hook: &str) -> i64 {
    let patience = Instant::now() + Duration::from_secs(60);
    loop {
        let queue = lab.get(&format!("/v1/hooks/{hook}")).await.ok()["queue"].clone();
        if queue["open"] == 0 {
            return queue["dead"].as_i64().unwrap();
        }
        assert!(Instant::now() < patience, "{queue}");
        a_second_passes(lab).await;
    }
}

#[tokio::test]
async fn a_target_that_was_down_too_long_is_told_what_still_fires_once_it_takes_messages_again() {
    for batch in [true, false] {
        let mut lab = Lab::with(|config| config.hooks.retry_waits_s = vec![0.05]).await;
        let (target, takes) = Receiver::switched(false, StatusCode::INTERNAL_SERVER_ERROR).await;
        let id = lab.tells(&target, json!({ "batch": batch })).await;
        steps(&lab, "A").await;
        steps(&lab, "B").await;
        let of_two = if batch { 2 } else { 6 };
        assert_eq!(settles(&lab, &id).await, of_two);
        // Whatever the service knew of the target's health is forgotten.
        lab.restart().await;
        takes.store(true, Ordering::SeqCst);
        let before = target.told().len();
        recovers(&lab, "B").await;
        assert!(told(&lab, &id, &target).await[before..].is_empty(), "it never heard that B fires");
        steps(&lab, "C").await;
        let mut heard = told(&lab, &id, &target).await[before..].concat();
        heard.sort();
        assert_eq!(heard, [all_of("A", "alert.fired"), all_of("C", "alert.fired")].concat(), "batch: {batch}");
        let before = target.told().len();
        recovers(&lab, "A").await;
        let ends = told(&lab, &id, &target).await[before..].concat();
        let of_step = ends.iter().filter(|one| *one == "A step alert.resolved").count();
        assert_eq!((of_step, ends.iter().all(|one| one.ends_with("resolved"))), (1, true), "{ends:?}");
    }
}

#[tokio::test]
async fn what_waited_behind_a_message_that_was_given_up_begins_and_never_ends_what_was_not_heard() {
    let lab = Lab::with(|config| config.hooks.retry_waits_s = vec![1.0]).await;
    let (target, takes) = Receiver::switched(false, StatusCode::UNPROCESSABLE_ENTITY).await;
    let id = lab.tells(&target, json!({ "batch": false, "filter": { "rules": ["step", "baseline"] } })).await;
    steps(&lab, "A").await;
    steps(&lab, "B").await;
    // While the target refuses that they fire, A is confirmed and B is over: both wait behind.
    lab.posts_history("IMU-A", "A", &[(160, 1.05)]).await;
    recovers(&lab, "B").await;
    while lab.get(&format!("/v1/hooks/{id}")).await.ok()["queue"]["dead"] == 0 {
        a_second_passes(&lab).await;
    }
    takes.store(true, Ordering::SeqCst);
    let refused = target.told().len();
    settles(&lab, &id).await;
    let heard = told(&lab, &id, &target).await[refused..].concat();
    assert!(heard.iter().any(|one| one.starts_with("A baseline alert.fired")), "{heard:?}");
    let begun = |end: &String| heard.contains(&end.replace("resolved", "fired"));
    assert!(heard.iter().filter(|one| one.ends_with("resolved")).all(begun), "{heard:?}");
}
