//! What an engineer sees when a gyro goes out of its limits, and what becomes of it.

use crate::lab::{self, bench};
use crate::prelude::*;
use gyrowatch::core::time::UtcMicros;
use gyrowatch::wire::time;

/// The alerts that a query finds, as `coefficient rule state severity`, in the order of these words.
async fn engineer_sees(lab: &Lab, query: &str) -> Vec<String> {
    let alerts = lab.get(&format!("/v1/alerts?{query}")).await.ok()["alerts"].clone();
    let text = |alert: &Value, member: &str| alert[member].as_str().unwrap().to_owned();
    let mut seen: Vec<String> = alerts
        .as_array()
        .unwrap()
        .iter()
        .map(|a| ["coefficient", "rule", "state", "severity"].map(|member| text(a, member)).join(" "))
        .collect();
    seen.sort();
    seen
}

/// The alert of a rule on D_I of gyro `A`.
async fn alert_of(lab: &Lab, rule: &str) -> Value {
    let found = lab.get(&format!("/v1/alerts?serial=A&coefficient=D_I&rule={rule}")).await.ok();
    assert_eq!(found["alerts"].as_array().unwrap().len(), 1, "one alert per gyro, coefficient and rule: {found}");
    found["alerts"][0].clone()
}

/// What became of an alert, step by step.
async fn story_of(lab: &Lab, rule: &str) -> Vec<String> {
    let id = alert_of(lab, rule).await["id"].as_str().unwrap().to_owned();
    let history = lab.get(&format!("/v1/alerts/{id}")).await.ok()["history"].clone();
    let steps = history.as_array().unwrap().iter();
    steps
        .map(|step| {
            format!("{}{}", step["action"].as_str().unwrap(), if step["told"] == true { "" } else { " (untold)" })
        })
        .collect()
}

/// A record of gyro `A` with the standard deviation of its coefficients.
fn of_a(at: i64, d_i: f64, sd: f64) -> Value {
    let mut sent = record("IMU-1", &day(at), &[("G1", "A", d_i, 2.0)]);
    sent["gyros"][0]["e_sd"] = json!([1e-7, 1e-7, 1e-7]);
    sent["gyros"][0]["g_sd"] = vec![1.4676 * sd; 3].into();
    sent
}

const LEVEL: [(i64, f64); 3] = [(0, 1.0), (40, 1.0), (80, 1.0)];

#[tokio::test]
async fn a_gyro_within_its_limits_raises_nothing() {
    let lab = Lab::holding(&LEVEL).await;
    assert_eq!(engineer_sees(&lab, "").await, [] as [&str; 0]);
}

#[tokio::test]
async fn a_step_fires_is_confirmed_and_resolves_while_the_baseline_goes_on_firing() {
    let lab = Lab::holding(&LEVEL).await;
    lab.posts_history("IMU-1", "A", &[(120, 1.02)]).await;
    assert_eq!(
        engineer_sees(&lab, "").await,
        ["D_I baseline firing warning", "D_I range firing warning", "D_I step firing warning"]
    );
    let step = alert_of(&lab, "step").await;
    assert_eq!((&step["imu"], &step["slot"], &step["station"]), (&json!("IMU-1"), &json!("G1"), &json!("ST-1")));
    assert_eq!(
        (&step["since"], &step["fired_at"]),
        (&json!(day(120)), &json!("2026-11-21T12:00:00Z")),
        "when the gyro did it, and when that was found"
    );
    assert_eq!(json!([step["calibrated_at"], step["limit"], step["unit"]]), json!([day(120), 0.01, "deg/(h*g0)"]));
    assert!(step["reason"].as_str().unwrap().contains("0.0200 deg/(h g0) above"), "{step}");
    assert_eq!(json!([step["resolved_at"], step["acknowledged"], step["silenced"]]), json!([null, null, null]));
    let answer = lab.get(&format!("/v1/records/{}", step["record"].as_str().unwrap())).await.ok();
    assert_eq!(answer["record"]["calibrated_at"], day(120));

    lab.posts_history("IMU-1", "A", &[(160, 1.02)]).await;
    assert_eq!(
        engineer_sees(&lab, "").await,
        ["D_I baseline firing critical", "D_I range firing warning", "D_I step firing critical"]
    );
    lab.posts_history("IMU-1", "A", &[(200, 1.02)]).await;
    assert_eq!(engineer_sees(&lab, "state=firing").await, ["D_I baseline firing critical"]);
    assert_eq!(
        engineer_sees(&lab, "state=resolved").await,
        ["D_I range resolved warning", "D_I step resolved critical"]
    );
    assert_eq!(story_of(&lab, "step").await, ["fire", "escalate", "resolve"]);

    let id = alert_of(&lab, "step").await["id"].clone();
    lab.posts_history("IMU-1", "A", &[(240, 1.05)]).await;
    let again = alert_of(&lab, "step").await;
    assert_eq!((&again["id"], &again["state"], &again["severity"]), (&id, &json!("firing"), &json!("warning")));
}

#[tokio::test]
async fn what_one_record_of_one_gyro_violates_is_one_group() {
    let lab = Lab::holding(&LEVEL).await;
    let two = [("G1", "A", 1.02, 2.05), ("G2", "B/1", 1.0, 2.0)];
    lab.posts(&record("IMU-1", &day(120), &two)).await;
    lab.posts(&record("IMU-1", &day(121), &[("G2", "B/1", 1.1, 2.0)])).await;
    let alerts = lab.get("/v1/alerts").await.ok()["alerts"].as_array().unwrap().clone();
    assert_eq!(alerts.iter().filter(|alert| alert["serial"] == "A").count(), 6, "{alerts:?}");
    let groups: BTreeSet<String> = alerts.iter().map(|alert| alert["group"].as_str().unwrap().to_owned()).collect();
    let expected = alerts.iter().map(|alert| {
        let text = |member: &str| alert[member].as_str().unwrap();
        format!("{}/{}", text("serial"), text("record"))
    });
    assert_eq!(groups, expected.collect(), "the gyro and its record");
    assert_eq!(groups.len(), 2);
}

#[tokio::test]
async fn many_records_in_one_import_leave_the_alerts_that_posting_one_by_one_leaves() {
    let history = [(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02), (160, 1.02), (200, 1.001), (240, 1.0), (280, 1.0)];
    let one_by_one = Lab::holding(&history).await;
    let at_once = Lab::open().await;
    let records: Vec<Value> =
        history.iter().map(|(at, d_i)| record("IMU-1", &day(*at), &[("G1", "A", *d_i, 2.0)])).collect();
    at_once.imports(&records).await;
    assert_eq!(engineer_sees(&at_once, "").await, engineer_sees(&one_by_one, "").await);
    for rule in ["step", "baseline"] {
        assert_eq!(story_of(&at_once, rule).await, story_of(&one_by_one, rule).await, "{rule}");
    }
}

#[tokio::test]
async fn an_alert_that_fires_on_though_its_figure_is_within_says_what_ends_it() {
    let lab = Lab::holding(&LEVEL).await;
    lab.posts_history("IMU-1", "A", &[(120, 1.02), (160, 1.009)]).await;
    let held = alert_of(&lab, "baseline").await;
    assert_eq!([&held["state"], &held["status"], &held["code"]], ["firing", "unconfirmed", "baseline"]);
    let reason = held["reason"].as_str().unwrap();
    let ends = "Within its limit again: the alert ends once a campaign is below 0.0080 deg/(h g0) (80 % of it), or after 2 \
                campaigns within.";
    assert!(reason.ends_with(ends) && !reason.contains("In tolerance"), "{reason}");
    let said = lab.request(reqwest::Method::GET, "/v1/alerts?rule=baseline").header("accept-language", "zh");
    let said: Value = said.send().await.unwrap().json().await.unwrap();
    assert!(said["alerts"][0]["reason"].as_str().unwrap().contains("告警才结束"), "{said}");
}

#[tokio::test]
async fn a_late_record_that_explains_a_step_resolves_it_and_one_that_changes_nothing_is_silent() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.0), (80, 1.0), (160, 1.0145)]).await;
    assert_eq!(story_of(&lab, "step").await, ["fire"]);
    lab.posts_history("IMU-1", "A", &[(60, 1.0)]).await;
    assert_eq!(story_of(&lab, "step").await, ["fire"], "late, and no news");
    lab.posts_history("IMU-1", "A", &[(120, 1.0075)]).await;
    assert_eq!(story_of(&lab, "step").await, ["fire"], "one record moves no median");
    lab.posts_history("IMU-1", "A", &[(110, 1.0075)]).await;
    assert_eq!(story_of(&lab, "step").await, ["fire", "resolve"], "the step is now of 0.007");
    assert_eq!(story_of(&lab, "baseline").await, ["fire"]);
    lab.posts_history("IMU-1", "A", &[(100, 1.05)]).await;
    assert_eq!(
        alert_of(&lab, "step").await["state"],
        "resolved",
        "a late outlier is history: the newest record is well"
    );
}

#[tokio::test]
async fn an_alert_says_since_when_and_how_grave_it_is_as_though_its_records_had_come_in_order() {
    let history = [(120, 1.02), (160, 1.02), (200, 1.02)];
    for order in [[0, 1, 2], [2, 0, 1], [2, 1, 0], [1, 2, 0]] {
        let lab = Lab::holding(&LEVEL).await;
        for k in order {
            lab.posts_history("IMU-1", "A", &history[k..=k]).await;
        }
        let alert = alert_of(&lab, "baseline").await;
        assert_eq!(
            [&alert["state"], &alert["severity"], &alert["since"]],
            [&json!("firing"), &json!("critical"), &json!(day(120))],
            "{order:?}"
        );
        assert_eq!(lab.get("/v1/gyros/A").await.ok()["since"], day(120), "{order:?}");
        assert_eq!(lab.verified().await.faults, []);
    }
    // One that comes late parts what went on from what goes on.
    let lab = Lab::holding(&LEVEL).await;
    lab.posts_history("IMU-1", "A", &[(120, 1.02), (200, 1.02), (160, 1.001)]).await;
    assert_eq!(alert_of(&lab, "baseline").await["since"], day(200));
    assert_eq!(story_of(&lab, "baseline").await, ["fire", "escalate", "lower"], "nothing has confirmed it");
}

#[tokio::test]
async fn what_late_records_tell_of_an_alert_that_goes_on_though_its_figure_is_within_holds() {
    let lab = Lab::holding(&LEVEL).await;
    lab.posts_history("IMU-1", "A", &[(120, 1.02), (200, 1.009)]).await;
    assert_eq!(story_of(&lab, "baseline").await, ["fire"]);
    lab.posts_history("IMU-1", "A", &[(160, 1.02)]).await;
    assert_eq!(story_of(&lab, "baseline").await, ["fire", "escalate"], "it was confirmed before it came back");
    let held = alert_of(&lab, "baseline").await;
    assert_eq!([&held["state"], &held["severity"]], ["firing", "critical"]);
    lab.posts_history("IMU-1", "A", &[(180, 1.001)]).await;
    assert_eq!(
        story_of(&lab, "baseline").await,
        ["fire", "escalate", "resolve"],
        "it had ended before its newest record"
    );
}

/// Nine records at the level, two that exceed the budget, and a last one too uncertain to end or to begin anything.
#[tokio::test]
async fn what_fires_when_all_records_have_come_is_the_same_in_whatever_order_they_came() {
    let mut history: Vec<Value> = (0..9).map(|k| of_a(40 * k, 1.0, 5e-4)).collect();
    history.extend([(360, 1.0125, 5e-4), (400, 1.0125, 5e-4), (440, 1.0095, 4e-3)].map(|(at, d, sd)| of_a(at, d, sd)));
    let members = ["coefficient", "rule", "state", "status", "severity", "since", "value", "calibrated_at", "reason"];
    let end = async |lab: &Lab| {
        let alerts = lab.alerts("state=firing").await;
        let mut alerts: Vec<Vec<Value>> =
            alerts.iter().map(|alert| members.map(|member| alert[member].clone()).into()).collect();
        alerts.sort_by_key(|alert| format!("{alert:?}"));
        (alerts, lab.get("/v1/gyros/A").await.ok()["since"].clone())
    };
    let in_time = Lab::open().await;
    for record in &history {
        in_time.posts(record).await;
    }
    let expected = end(&in_time).await;
    assert_eq!(expected.1, day(360), "{expected:?}");
    let baseline = alert_of(&in_time, "baseline").await;
    assert_eq!([&baseline["state"], &baseline["severity"]], ["firing", "critical"]);
    let orders: [Vec<usize>; 4] = [
        (0..10).chain([11, 10]).collect(),
        (0..9).chain([11, 9, 10]).collect(),
        (0..12).rev().collect(),
        vec![4, 9, 1, 11, 0, 7, 3, 10, 2, 8, 6, 5],
    ];
    for order in orders {
        let lab = Lab::open().await;
        for k in &order {
            lab.posts(&history[*k]).await;
        }
        assert_eq!(end(&lab).await, expected, "{order:?}");
        assert_eq!(lab.verified().await.faults, []);
    }
}

/// The newest record is recent, and ends nothing; what exceeded is old, and came late.
#[tokio::test]
async fn an_old_violation_that_comes_late_fires_and_is_told_when_a_recent_record_exceeds() {
    let lab = Lab::with(|config| config.alerts.backfill_days = 30.0).await;
    let target = Receiver::start().await;
    let hook = lab.tells(&target, json!({"filter": {"rules": ["baseline"]}})).await;
    for (at, d_i, sd) in [(0, 1.0, 5e-4), (40, 1.0, 5e-4), (80, 1.0, 5e-4), (680, 1.0095, 4e-3), (120, 1.0125, 5e-4)] {
        lab.posts(&of_a(at, d_i, sd)).await;
    }
    let alert = alert_of(&lab, "baseline").await;
    assert_eq!([&alert["state"], &alert["since"]], [&json!("firing"), &json!(day(120))]);
    lab.all_told(&hook).await;
    assert!(target.told().is_empty());
    lab.posts(&of_a(685, 1.0125, 5e-4)).await;
    lab.all_told(&hook).await;
    assert_eq!(target.told()[0].json()["data"]["since"], day(120));
}

#[tokio::test]
async fn an_engineer_acknowledges_and_the_alert_says_who_and_why() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02)]).await;
    let id = alert_of(&lab, "baseline").await["id"].as_str().unwrap().to_owned();
    lab.clock_shows("2026-11-22T08:00:00Z");
    let known = json!({"by": "Li Wei", "reason": "re-test on Monday"});
    let alert = lab.post(&format!("/v1/alerts/{id}/acknowledge"), &known).await.ok();
    assert_eq!(alert["state"], "acknowledged");
    assert_eq!(
        alert["acknowledged"],
        json!({"by": "Li Wei", "reason": "re-test on Monday", "at": "2026-11-22T08:00:00Z"})
    );
    assert_eq!(engineer_sees(&lab, "state=acknowledged").await, ["D_I baseline acknowledged warning"]);
    assert_eq!(engineer_sees(&lab, "state=firing").await, ["D_I range firing warning", "D_I step firing warning"]);

    lab.posts_history("IMU-1", "A", &[(160, 1.02)]).await;
    let alert = alert_of(&lab, "baseline").await;
    assert_eq!([&alert["state"], &alert["severity"]], ["firing", "critical"], "worse than was acknowledged");
    assert_eq!(alert["acknowledged"], Value::Null);
    let history = lab.get(&format!("/v1/alerts/{id}")).await.ok()["history"].clone();
    assert_eq!((&history[1]["action"], &history[1]["by"]), (&json!("acknowledge"), &json!("Li Wei")));
    assert_eq!([&history[1]["at"], &history[1]["alert"]["state"]], ["2026-11-22T08:00:00Z", "acknowledged"]);
}

#[tokio::test]
async fn a_silenced_alert_is_followed_without_telling_and_tells_at_its_end_what_still_fires() {
    let mut lab = Lab::with(|config| config.alerts.tick_s = 0.02).await;
    lab.posts_history("IMU-1", "A", &[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02)]).await;
    let id = alert_of(&lab, "baseline").await["id"].as_str().unwrap().to_owned();
    let order = json!({"until": "2026-11-23T00:00:00+01:00", "by": "Li Wei", "reason": "turntable under repair"});
    let alert = lab.post(&format!("/v1/alerts/{id}/silence"), &order).await.ok();
    assert_eq!((&alert["state"], &alert["silenced"]["until"]), (&json!("silenced"), &json!("2026-11-22T23:00:00Z")));
    assert_eq!(engineer_sees(&lab, "state=silenced").await, ["D_I baseline silenced warning"]);
    lab.posts_history("IMU-1", "A", &[(160, 1.02)]).await;
    lab.restart().await;
    assert_eq!(story_of(&lab, "baseline").await, ["fire", "silence (untold)", "escalate (untold)"]);

    lab.clock_shows("2026-11-22T23:00:00Z");
    let story = once(async || story_of(&lab, "baseline").await, |story| story.len() > 3).await;
    assert_eq!(story[3..], ["escalate"], "told once the silence has ended");
    assert_eq!(alert_of(&lab, "baseline").await["state"], "firing");
}

#[tokio::test]
async fn what_fires_is_told_again_in_a_week_unless_somebody_knows() {
    let lab = Lab::with(|config| config.alerts.tick_s = 0.02).await;
    lab.posts_history("IMU-1", "A", &[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02)]).await;
    let known = alert_of(&lab, "step").await["id"].as_str().unwrap().to_owned();
    let order = json!({"by": "Li Wei", "reason": "turntable under repair"});
    lab.post(&format!("/v1/alerts/{known}/acknowledge"), &order).await.ok();
    lab.clock_shows("2026-11-28T11:59:59Z");
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert_eq!(story_of(&lab, "baseline").await, ["fire"]);
    lab.clock_shows("2026-11-28T12:00:00Z");
    let story = once(async || story_of(&lab, "baseline").await, |story| story.len() > 1).await;
    assert_eq!(story, ["fire", "repeat"]);
    assert_eq!(story_of(&lab, "step").await, ["fire", "acknowledge (untold)"]);
}

#[tokio::test]
async fn an_acknowledgement_is_taken_back_with_who_and_why() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02)]).await;
    let id = alert_of(&lab, "baseline").await["id"].as_str().unwrap().to_owned();
    let remark = json!({"by": "Li Wei", "reason": "the wrong gyro"});
    let path = format!("/v1/alerts/{id}/unacknowledge");
    assert_eq!(lab.post(&path, &remark).await.ok()["state"], "firing", "there is nothing to take back");
    lab.post(&format!("/v1/alerts/{id}/acknowledge"), &remark).await.ok();
    let alert = lab.post(&path, &remark).await.ok();
    assert_eq!((&alert["state"], &alert["acknowledged"]), (&json!("firing"), &Value::Null));
    assert_eq!(story_of(&lab, "baseline").await, ["fire", "acknowledge (untold)", "unacknowledge (untold)"]);
    assert_eq!(lab.post(&path, &json!({"by": "", "reason": "x"})).await.refused(422), ["/by"]);
    assert_eq!(lab.post("/v1/alerts/0000000000000/unacknowledge", &remark).await.status, 404);
}

#[tokio::test]
async fn a_silence_of_all_that_match_holds_for_what_fires_and_will_fire_and_ends() {
    let mut lab = Lab::with(|config| config.alerts.tick_s = 0.02).await;
    lab.posts_history("IMU-1", "A", &[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02)]).await;
    let order = |matchers: Value| json!({"matchers": matchers, "until": "2026-11-23T00:00:00Z", "by": "Li Wei", "reason": "turntable under repair"});
    for (wrong, place) in [
        (order(json!({})), "/matchers"),
        (order(json!({"rule": "stpe"})), "/matchers/rule"),
        (order(json!({"serial": "A\u{200b}"})), "/matchers/serial"),
        (order(json!({"gyro": "A"})), "/matchers/gyro"),
        (json!({"matchers": {"rule": "step"}, "until": "2020-01-01T00:00:00Z", "by": "L", "reason": "r"}), "/until"),
    ] {
        assert_eq!(lab.post("/v1/silences", &wrong).await.refused(422), [place], "{wrong}");
    }
    let answer = lab.post("/v1/silences", &order(json!({"imu": "IMU-1", "rule": "step"}))).await;
    let by_imu = answer.created();
    assert_eq!(answer.header("location"), format!("/v1/silences/{}", by_imu["id"].as_str().unwrap()));
    assert_eq!(engineer_sees(&lab, "state=silenced").await, ["D_I step silenced warning"]);
    assert_eq!(alert_of(&lab, "step").await["silenced"]["silence"], by_imu["id"]);
    let by_station = lab.post("/v1/silences", &order(json!({"station": "ST-1"}))).await.created();
    lab.posts_history("IMU-1", "A", &[(160, 1.02)]).await;
    assert_eq!(engineer_sees(&lab, "state=firing").await, [] as [&str; 0], "of all that this station measures");
    let of_another = [("G1", "B", 1.0, 2.0)];
    for (at, gyros) in [(0, of_another), (40, of_another), (80, [("G1", "B", 1.02, 2.0)])] {
        lab.posts(&record("IMU-2", &day(at), &gyros)).await;
    }
    assert!(engineer_sees(&lab, "serial=B&state=firing").await.is_empty(), "and of what begins only now");
    lab.restart().await;
    let listed = lab.get("/v1/silences").await.ok()["silences"].clone();
    let ids: Vec<&Value> = listed.as_array().unwrap().iter().map(|silence| &silence["id"]).collect();
    assert_eq!(ids, [&by_station["id"], &by_imu["id"]], "the newest first");
    assert_eq!(story_of(&lab, "step").await, ["fire", "escalate (untold)"]);

    let path = format!("/v1/silences/{}", by_station["id"].as_str().unwrap());
    let ended = lab.post(&format!("{path}/end"), &json!({"by": "Li Wei", "reason": "repaired"})).await.ok();
    assert_eq!((&ended["active"], &ended["ended"]["reason"]), (&json!(false), &json!("repaired")));
    assert_eq!(
        lab.post(&format!("{path}/end"), &json!({"by": "X", "reason": "again"})).await.ok(),
        ended,
        "it is over"
    );
    assert_eq!(engineer_sees(&lab, "state=silenced").await, ["D_I step silenced critical"], "the other silence holds");
    assert_eq!(story_of(&lab, "baseline").await, ["fire", "escalate (untold)", "escalate"], "told at its end");
    lab.clock_shows("2026-11-23T00:00:00Z");
    assert_eq!(engineer_sees(&lab, "state=silenced").await, [] as [&str; 0]);
    let story = once(async || story_of(&lab, "step").await, |story| story.len() > 2).await;
    assert_eq!(story[2..], ["escalate"], "at the end of its time");
    assert_eq!(lab.get("/v1/silences").await.ok(), json!({"silences": []}));
    assert_eq!(lab.get("/v1/silences?state=all").await.ok()["silences"].as_array().unwrap().len(), 2);
    assert_eq!(lab.get("/v1/silences?state=old").await.status, 400);
    assert_eq!(lab.get("/v1/silences/0000000000000").await.status, 404);
}

#[tokio::test]
async fn a_gyro_that_is_not_calibrated_in_time_is_overdue_until_it_is() {
    let lab = Lab::with(|config| {
        config.judging.interval_days = 30.0;
        config.alerts.tick_s = 0.02;
    })
    .await;
    let last = time::parse("2026-11-01T12:00:00Z").unwrap();
    let at = |days: i64| time::format(UtcMicros(last.0 + days * UtcMicros::DAY));
    lab.posts(&record("IMU-1", &at(0), &[("G1", "A", 1.0, 2.0), ("G2", "B", 1.0, 2.0)])).await;
    lab.clock_shows("2026-12-01T11:59:59Z");
    tokio::time::sleep(Duration::from_millis(100)).await;
    assert_eq!(engineer_sees(&lab, "").await, [] as [&str; 0]);
    lab.clock_shows("2026-12-01T13:00:00Z");
    let seen = sees_at_last(&lab, "rule=overdue", 2).await;
    assert_eq!(seen, ["all overdue firing warning", "all overdue firing warning"]);
    let alert = lab.get("/v1/alerts?serial=A").await.ok()["alerts"][0].clone();
    assert!(alert["reason"].as_str().unwrap().contains("2026-11-01"), "{alert}");
    lab.posts(&record("IMU-1", &at(30), &[("G1", "A", 1.0, 2.0)])).await;
    assert_eq!(engineer_sees(&lab, "serial=A").await, ["all overdue resolved warning"]);
    assert_eq!(engineer_sees(&lab, "serial=B").await, ["all overdue firing warning"]);
}

/// What a query finds once there are so many.
async fn sees_at_last(lab: &Lab, query: &str, count: usize) -> Vec<String> {
    once(async || engineer_sees(lab, query).await, |seen| seen.len() == count).await
}

#[tokio::test]
async fn a_new_baseline_or_a_repair_ends_what_it_resets() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02)]).await;
    lab.post("/v1/gyros/A/baseline", &json!({"reason": "accepted", "at": day(130)})).await.created();
    let jump = ["D_I range firing warning", "D_I step firing warning"];
    assert_eq!(engineer_sees(&lab, "state=firing").await, jump, "a jump remains to be seen");
    assert_eq!(story_of(&lab, "baseline").await, ["fire", "resolve"]);
    let repair = json!({"event": "repair", "reason": "float suspension", "at": day(131), "author": "Li"});
    let event = lab.post("/v1/gyros/A/events", &repair).await.created();
    assert_eq!((&event["event"], &event["at"]), (&json!("repair"), &json!(day(131))));
    assert_eq!(engineer_sees(&lab, "state=firing").await, [] as [&str; 0]);
    lab.posts_history("IMU-1", "A", &[(110, 1.0)]).await;
    assert_eq!(
        engineer_sees(&lab, "state=firing").await,
        [] as [&str; 0],
        "a late record before the repair is history"
    );
    let trend = lab.get("/v1/gyros/A/trend").await.ok();
    let events: Vec<&Value> = trend["events"].as_array().unwrap().iter().map(|event| &event["event"]).collect();
    assert_eq!(events, ["baseline", "repair"]);
    let of_gyro = lab.get("/v1/gyros/A/events").await.ok();
    assert_eq!(of_gyro["events"], trend["events"]);
    assert_eq!(lab.post("/v1/gyros/A/events", &repair).await.ok()["id"], event["id"], "sent twice, stored once");
}

#[tokio::test]
async fn methods_that_disagree_raise_an_alert_and_a_bench_that_agrees_again_ends_it() {
    let lab = Lab::holding(&[(0, 1.0)]).await;
    lab.post("/v1/bench-results", &bench("A", &day(5), 1.03, 2.0)).await.created();
    assert_eq!(engineer_sees(&lab, "").await, ["D_I agreement firing warning"]);
    let alert = alert_of(&lab, "agreement").await;
    assert_eq!((&alert["station"], &alert["imu"]), (&json!("BENCH-1"), &json!("IMU-1")));
    lab.post("/v1/gyros/A/events", &json!({"event": "repair", "reason": "bearing", "at": day(6)})).await.created();
    lab.post("/v1/bench-results", &bench("A", &day(7), 1.0, 2.0)).await.created();
    lab.posts_history("IMU-1", "A", &[(8, 1.0)]).await;
    assert_eq!(engineer_sees(&lab, "").await, ["D_I agreement resolved warning"]);
}

#[tokio::test]
async fn a_requirement_that_a_second_campaign_misses_is_critical() {
    let lab = Lab::with(|config| config.judging.requirements = true).await;
    let mut out = lab::record("IMU-1", &day(0), &[("G1", "A", 1.0, 2.0)]);
    out["gyros"][0]["g_pulse_per_s_g0"] = json!([20.0, 1.0, 1.0]);
    lab.posts(&out).await;
    assert_eq!(engineer_sees(&lab, "rule=requirement&coefficient=G").await, ["G requirement firing warning"]);
    out["calibrated_at"] = json!(day(40));
    lab.posts(&out).await;
    assert_eq!(engineer_sees(&lab, "rule=requirement&coefficient=G").await, ["G requirement firing critical"]);
}

#[tokio::test]
async fn a_requirement_missed_by_a_record_that_comes_late_fires_until_two_campaigns_have_met_it() {
    for (met, firing) in [(&[80][..], 1), (&[40, 80], 0)] {
        for in_time in [true, false] {
            let lab = Lab::with(|config| config.judging.requirements = true).await;
            let mut history: Vec<(i64, f64)> = met.iter().map(|at| (*at, 0.8)).collect();
            history.insert(if in_time { 0 } else { met.len() }, (0, 20.0));
            for (at, g) in history {
                let mut sent = lab::record("IMU-1", &day(at), &[("G1", "A", 1.0, 2.0)]);
                sent["gyros"][0]["g_pulse_per_s_g0"] = json!([g, 1.0, 1.0]);
                lab.posts(&sent).await;
            }
            let found = engineer_sees(&lab, "rule=requirement&coefficient=G&state=firing").await;
            assert_eq!(found.len(), firing, "{met:?}, in time: {in_time}");
        }
    }
}

#[tokio::test]
async fn alerts_are_filtered_paged_and_exported() {
    let lab = Lab::open().await;
    for (second, (imu, serial)) in [("IMU-1", "A"), ("IMU-2", "B"), ("IMU-3", "C, \"old\"")].into_iter().enumerate() {
        // Of one instant, those of several cells are in no order.
        lab.clock_shows(&format!("2026-11-21T13:00:0{second}Z"));
        for (at, d_i) in LEVEL.into_iter().chain([(120, 1.02)]) {
            lab.posts(&record(imu, &day(at), &[("G1", serial, d_i, 2.0)])).await;
        }
    }
    assert_eq!(engineer_sees(&lab, "").await.len(), 9);
    assert_eq!(engineer_sees(&lab, "imu=IMU-2&rule=step").await, ["D_I step firing warning"]);
    assert_eq!(engineer_sees(&lab, "severity=critical").await, [] as [&str; 0]);
    let (mut cursor, mut serials) = (String::new(), Vec::new());
    for _ in 0..3 {
        let page = lab.get(&format!("/v1/alerts?limit=3{cursor}")).await;
        let body = page.ok();
        serials.extend(body["alerts"].as_array().unwrap().iter().map(|a| a["serial"].as_str().unwrap().to_owned()));
        if let Some(next) = body["next"].as_str() {
            assert!(page.header("link").contains(next));
            cursor = format!("&cursor={next}");
        }
    }
    assert_eq!(serials, [["C, \"old\""; 3], ["B"; 3], ["A"; 3]].concat());
    let csv = lab.get("/v1/alerts?format=csv&rule=step").await;
    assert_eq!((csv.status, csv.header("content-type")), (200, "text/csv; charset=utf-8"));
    let lines: Vec<&str> = csv.text.lines().collect();
    assert!(lines[0].starts_with("id,serial,coefficient,rule,state,severity,fired_at"), "{}", lines[0]);
    assert_eq!(lines.len(), 4);
    assert!(lines[1].contains(",\"C, \"\"old\"\"\",D_I,step,firing,warning,"), "{}", lines[1]);
}

#[tokio::test]
async fn what_cannot_be_asked_or_said_is_refused_with_the_place() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02), (160, 1.0)]).await;
    for query in [
        "state=on",
        "rule=steps",
        "severity=bad",
        "coefficient=D",
        "limit=0",
        "limit=x",
        "cursor=x",
        "format=xml",
        "who=me",
    ] {
        lab.get(&format!("/v1/alerts?{query}")).await.refused(400);
    }
    lab.get("/v1/alerts?serial=none").await.refused(404);
    let resolved = alert_of(&lab, "baseline").await;
    assert_eq!(resolved["state"], "resolved");
    let at = |what: &str| format!("/v1/alerts/{}/{what}", resolved["id"].as_str().unwrap());
    let said = json!({"by": "Li", "reason": "known"});
    lab.post(&at("acknowledge"), &said).await.refused(409);
    for id in ["x", "0123456789ABC", "0000000000000"] {
        lab.get(&format!("/v1/alerts/{id}")).await.refused(404);
        lab.post(&format!("/v1/alerts/{id}/acknowledge"), &said).await.refused(404);
    }
    for (body, places) in [
        (json!({"by": " ", "reason": ""}), vec!["/by", "/reason"]),
        (json!({"by": "Li"}), vec!["/reason"]),
        (json!({"by": "a\u{1}b", "reason": "x".repeat(5000)}), vec!["/by", "/reason"]),
    ] {
        assert_eq!(lab.post(&at("acknowledge"), &body).await.refused(422), places, "{body}");
    }
    for until in ["2026-11-21T12:00:00Z", "tomorrow", "2027-01-01T00:00:00"] {
        let order = json!({"until": until, "by": "Li", "reason": "x"});
        assert_eq!(lab.post(&at("silence"), &order).await.refused(422), ["/until"], "{until}");
    }
    lab.post_text(&at("silence"), lab::JSON, "{").await.refused(400);
    lab.post_text(&at("silence"), "text/plain", "{}").await.refused(415);

    lab.post("/v1/gyros/none/events", &json!({"event": "note", "reason": "x"})).await.refused(404);
    lab.get("/v1/gyros/none/events").await.refused(404);
    for (body, places) in [
        (json!({"event": "explosion", "reason": "x"}), vec!["/event"]),
        (json!({"event": "note", "reason": " "}), vec!["/reason"]),
        (json!({"event": "note", "reason": "x", "at": "2030-01-01T00:00:00Z"}), vec!["/at"]),
        (json!({"event": "note", "reason": "x", "when": "now"}), vec!["/when"]),
    ] {
        assert_eq!(lab.post("/v1/gyros/A/events", &body).await.refused(422), places, "{body}");
    }
    let note = |reason: &str| json!({"event": "note", "reason": reason, "at": day(10)});
    lab.post("/v1/gyros/A/events", &note("seen")).await.created();
    lab.post("/v1/gyros/A/events", &note("heard")).await.refused(409);
}
