//! Whoever imports history is told once what still fires, and of what long ago began and ended, nothing.

use crate::lab::NDJSON;
use crate::prelude::*;

/// The day of 2025 that the laboratory's clock shows: noon of 2026-11-21.
const TODAY: i64 = 689;

/// A laboratory to which what is older than a month is old.
async fn lab() -> Lab {
    Lab::with(|config| {
        config.alerts.backfill_days = 30.0;
        config.alerts.tick_s = 0.02;
    })
    .await
}

/// What a target has been told, once nothing is open for the hook.
async fn told(lab: &Lab, hook: &str, target: &Receiver) -> Vec<Value> {
    lab.all_told(hook).await;
    target.told().iter().map(|told| told.json()).collect()
}

fn of(serial: &str, at: i64, d_i: f64) -> Value {
    record(&format!("IMU-{serial}"), &day(at), &[("G1", serial, d_i, 2.0)])
}

/// Twenty years' worth of events in two: A steps and stays there, B steps and comes back, C is well, D steps ten days
/// ago.
fn histories() -> Vec<Value> {
    let mut all = Vec::new();
    for at in (0..TODAY).step_by(20) {
        all.push(of("A", at, if at < 300 { 1.0 } else { 1.05 }));
        all.push(of("B", at, if (200..400).contains(&at) { 1.05 } else { 1.0 }));
        all.push(of("C", at, 1.0));
        all.push(of("D", at, if at < TODAY - 20 { 1.0 } else { 1.05 }));
    }
    all
}

#[tokio::test]
async fn an_import_tells_in_one_digest_what_fires_since_long_ago_and_what_is_recent_as_ever() {
    let (lab, target, single) = (lab().await, Receiver::start().await, Receiver::start().await);
    let hooks = [lab.tells(&target, json!({})).await, lab.tells(&single, json!({ "batch": false })).await];
    assert!(lab.imports(&histories()).await.iter().all(|line| line["status"] == 201));
    let (of_a, of_d) = (lab.alerts("state=firing&serial=A").await, lab.alerts("state=firing&serial=D").await);
    assert!(!of_a.is_empty() && !of_d.is_empty() && lab.alerts("state=firing&serial=B").await.is_empty());
    for (hook, target, recent) in [(&hooks[0], &target, 1), (&hooks[1], &single, of_d.len())] {
        let told = told(&lab, hook, target).await;
        let (digests, others): (Vec<&Value>, Vec<&Value>) =
            told.iter().partition(|body| body["type"] == "alerts.digest");
        let [digest] = digests[..] else { panic!("{digests:?}") };
        assert_eq!(digest["data"]["total"], of_a.len());
        assert_eq!((&digest["data"]["gyros"], &digest["data"]["listed"]), (&json!(1), &json!(of_a.len())));
        assert!(digest["alerts"].as_array().unwrap().iter().all(|alert| alert["serial"] == "A"), "{digest}");
        assert_eq!(others.len(), recent, "{others:?}");
        assert!(others.iter().all(|body| body["data"]["serial"] == "D" && body["type"] == "alert.fired"), "{others:?}");
    }
    let alert = of_a.iter().find(|alert| alert["rule"] == "baseline").unwrap();
    assert_eq!((&alert["since"], &alert["fired_at"]), (&json!(day(300)), &json!("2026-11-21T12:00:00Z")));
    let history = lab.get(&format!("/v1/alerts/{}", alert["id"].as_str().unwrap())).await.ok()["history"].clone();
    let steps: Vec<(&Value, &Value)> =
        history.as_array().unwrap().iter().map(|step| (&step["action"], &step["told"])).collect();
    let (yes, no) = (json!(true), json!(false));
    assert_eq!(steps, [(&json!("fire"), &no), (&json!("escalate"), &no), (&json!("digest"), &yes)]);
    let b = lab.get("/v1/alerts?serial=B").await.ok()["alerts"][0].clone();
    let history = lab.get(&format!("/v1/alerts/{}", b["id"].as_str().unwrap())).await.ok()["history"].clone();
    assert!(history.as_array().unwrap().len() > 1, "what began and ended is history: {history}");
    assert!(history.as_array().unwrap().iter().all(|step| step["told"] == false), "{history}");

    // Whoever has heard of it in the digest hears of its end, and another import tells nothing twice.
    lab.imports(&histories()).await;
    for at in [TODAY - 2, TODAY - 1, TODAY] {
        lab.posts(&of("A", at, 1.0)).await;
    }
    let all = told(&lab, &hooks[0], &target).await;
    assert_eq!(all.iter().filter(|body| body["type"] == "alerts.digest").count(), 1);
    let ended = all.iter().flat_map(|body| body["alerts"].as_array().unwrap());
    let ended = ended.filter(|alert| alert["event"] == "alert.resolved" && alert["serial"] == "A").count();
    assert!(ended > 0, "{all:?}");
}

#[tokio::test]
async fn whoever_asks_for_it_hears_everything_or_nothing_of_an_import() {
    for (notify, old) in [("all", true), ("none", false)] {
        let (lab, target) = (lab().await, Receiver::start().await);
        let hook = lab.tells(&target, json!({ "batch": false })).await;
        let text: String = histories().iter().map(|record| format!("{record}\n")).collect();
        lab.post_text(&format!("/v1/import?notify={notify}"), NDJSON, text).await.lines();
        let told = told(&lab, &hook, &target).await;
        assert!(told.iter().all(|body| body["type"] != "alerts.digest"), "{notify}");
        let serials: Vec<&str> = told.iter().map(|body| body["data"]["serial"].as_str().unwrap()).collect();
        assert_eq!(serials.contains(&"A") && serials.contains(&"B"), old, "{notify}: {serials:?}");
        assert!(serials.contains(&"D"), "{notify}: what is recent");
        assert!(!lab.alerts("state=firing&serial=A").await.is_empty(), "it fires all the same");
        let wrong = lab.post_text("/v1/import?notify=some", NDJSON, "").await;
        assert_eq!(wrong.status, 400);
        assert!(wrong.text.contains("all, digest, none"), "{}", wrong.text);
    }
}

#[tokio::test]
async fn an_old_record_that_is_posted_by_itself_is_told_to_nobody_and_a_recent_one_is() {
    let (mut lab, target) = (lab().await, Receiver::start().await);
    let hook = lab.tells(&target, json!({})).await;
    for (at, d_i) in [(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.05), (160, 1.05)] {
        lab.posts(&of("A", at, d_i)).await;
    }
    lab.restart().await;
    tokio::time::sleep(Duration::from_millis(100)).await;
    assert_eq!(told(&lab, &hook, &target).await, [] as [Value; 0], "nor does the clock tell it later");
    assert!(!lab.alerts("state=firing&serial=A").await.is_empty());
    lab.posts(&of("A", TODAY - 1, 1.05)).await;
    let told = told(&lab, &hook, &target).await;
    assert_eq!((told.len(), &told[0]["type"]), (1, &json!("alert.fired")));
    assert_eq!(told[0]["data"]["since"], day(120));
}

#[tokio::test]
async fn an_import_of_many_requests_is_one_digest_and_one_that_is_broken_off_is_told_in_a_while() {
    let (mut lab, target) = (lab().await, Receiver::start().await);
    let hook = lab.tells(&target, json!({})).await;
    let all = histories();
    for part in all.chunks(30) {
        let text: String = part.iter().map(|record| format!("{record}\n")).collect();
        lab.post_text("/v1/import?notify=digest&more=true", NDJSON, text).await.lines();
    }
    let digests = |told: Vec<Value>| told.iter().filter(|body| body["type"] == "alerts.digest").count();
    lab.restart().await;
    lab.clock_shows("2026-11-21T12:14:00Z");
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert_eq!(digests(told(&lab, &hook, &target).await), 0, "more may follow");
    lab.clock_shows("2026-11-21T12:16:00Z");
    // It is told though its end was never said.
    once(async || digests(told(&lab, &hook, &target).await), |digests| *digests > 0).await;
    // What comes after it is another import.
    lab.imports(&[of("E", 0, 1.0), of("E", 30, 1.0), of("E", 60, 1.0), of("E", 90, 1.05)]).await;
    let all = told(&lab, &hook, &target).await;
    assert_eq!(digests(all.clone()), 2);
    let last = all.iter().rfind(|body| body["type"] == "alerts.digest").unwrap();
    assert!(last["alerts"].as_array().unwrap().iter().all(|alert| alert["serial"] == "E"), "{last}");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_command_line_sends_many_files_and_batches_and_hooks_hear_one_digest() {
    let (lab, target) = (lab().await, Receiver::start().await);
    let hook = lab.tells(&target, json!({})).await;
    let dir = tempfile::tempdir().unwrap();
    // More lines than one request holds, then documents by themselves.
    let lines: String = (0..680)
        .flat_map(|at| [of("A", at, if at < 300 { 1.0 } else { 1.05 }), of("B", at, 1.0)])
        .map(|record| format!("{record}\n"))
        .collect();
    std::fs::write(dir.path().join("all.ndjson"), lines).unwrap();
    for (name, at, d_i) in [("c1.json", 0, 1.0), ("c2.json", 30, 1.0), ("c3.json", 60, 1.0), ("c4.json", 90, 1.05)] {
        std::fs::write(dir.path().join(name), of("C", at, d_i).to_string()).unwrap();
    }
    let import = |notify: &[&str]| {
        let mut command = gyrowatch();
        command.current_dir(dir.path()).args(["import", "all.ndjson", "c1.json", "c2.json", "c3.json", "c4.json"]);
        command.args(notify).arg("--url").arg(lab.url("")).output().unwrap()
    };
    let done = tokio::task::block_in_place(|| import(&[]));
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let told = told(&lab, &hook, &target).await;
    assert_eq!(told.len(), 1, "{told:?}");
    let fires = lab.alerts("state=firing&serial=A").await.len() + lab.alerts("state=firing&serial=C").await.len();
    assert_eq!((&told[0]["type"], &told[0]["data"]["total"]), (&json!("alerts.digest"), &json!(fires)));
    assert_eq!(told[0]["data"]["gyros"], 2);
    let wrong = tokio::task::block_in_place(|| import(&["--notify", "some"]));
    assert_eq!(wrong.status.code(), Some(2));
}

#[tokio::test]
async fn what_an_import_leaves_overdue_is_in_its_digest_and_nothing_of_it_is_told_by_itself() {
    let lab = Lab::with(|config| {
        config.alerts.backfill_days = 30.0;
        config.judging.interval_days = 30.0;
    })
    .await;
    let target = Receiver::start().await;
    let hook = lab.tells(&target, json!({})).await;
    // Two have become overdue yesterday, one of which has other alerts; one is in time, though barely.
    let all = [("A", 31, 1.05), ("B", 31, 1.0), ("C", 29, 1.0)];
    let records = (0..9).flat_map(|k| {
        all.map(|(serial, ago, last)| of(serial, TODAY - ago - 35 * (8 - k), if k < 6 { 1.0 } else { last }))
    });
    lab.imports(&records.collect::<Vec<_>>()).await;
    let overdue = lab.alerts("state=firing&rule=overdue").await;
    assert_eq!(overdue.len(), 2, "{overdue:?}");
    assert!(overdue.iter().all(|alert| alert["since"] == day(TODAY - 1)), "{overdue:?}");
    let told = told(&lab, &hook, &target).await;
    let listed = |body: &Value| {
        let alerts = body["alerts"].as_array().cloned().unwrap_or_default();
        alerts.iter().filter(|alert| alert["rule"] == "overdue").count()
    };
    let of_overdue: Vec<(&Value, usize)> =
        told.iter().map(|body| (&body["type"], listed(body))).filter(|(_, listed)| *listed > 0).collect();
    assert_eq!(of_overdue, [(&json!("alerts.digest"), 2)], "{told:?}");
}
