//! Gyros that moved together because their station or IMU did: one alert of that, and none of what it explains.

use crate::lab::{self, scatter};
use crate::prelude::*;
use crate::receiver::Told;
use gyrowatch::system::Clock;
use gyrowatch::wire::time;
use reqwest::Method;

const SLOTS: [&str; 3] = ["G1", "G2", "G3"];
/// Of the station, and of one gyro by itself, deg/(h g0); the budget is 0.01.
const SHIFT: f64 = 0.015;
const OWN: f64 = 0.03;

/// IMU `imu` on a day of 2025 at a station: its three gyros with D_I higher by `d_i` of each.
fn calibrated(imu: i64, at: i64, station: &str, d_i: impl Fn(i64) -> f64) -> Value {
    let serials: Vec<String> = (0..3).map(|slot| serial(3 * imu + slot)).collect();
    let value = |slot: usize| 3.0 + scatter(7 * imu + at + slot as i64, 3e-4) + d_i(slot as i64);
    let gyros: Vec<lab::Made<'_>> = (0..3)
        .map(|slot| (SLOTS[slot], &*serials[slot], value(slot), 4.0 + scatter(imu + 3 * at + slot as i64, 3e-4)))
        .collect();
    let mut sent = record(&format!("IMU-{imu}"), &day(at), &gyros);
    sent["station"] = station.into();
    sent
}

fn serial(gyro: i64) -> String {
    format!("GYRO-{gyro:02}")
}

/// Six IMUs at ST-2 and three at ST-1, weekly, with nothing to see; up to day 27.
fn quiet() -> Vec<Value> {
    let imus =
        |at: i64| (0..9).map(move |imu| calibrated(imu, at + imu % 6, if imu < 6 { "ST-2" } else { "ST-1" }, |_| 0.0));
    [0, 7, 14, 21].into_iter().flat_map(imus).collect()
}

/// ST-2 reads high by [`SHIFT`]; the first gyro of the last IMU has moved by [`OWN`] besides.
fn shifted(imus: std::ops::Range<i64>) -> Vec<Value> {
    let of =
        |imu: i64| calibrated(imu, 28 + imu, "ST-2", move |slot| SHIFT + if (imu, slot) == (5, 0) { OWN } else { 0.0 });
    imus.map(of).collect()
}

async fn lab() -> Lab {
    lab_whose_clock_looks_every(0.05).await
}

async fn lab_whose_clock_looks_every(seconds: f64) -> Lab {
    let lab = Lab::with(|config| {
        config.alerts.tick_s = seconds;
        config.alerts.backfill_days = 30.0;
    })
    .await;
    lab.clock_shows(&day(28));
    sent(&lab, &quiet()).await;
    lab
}

async fn sent(lab: &Lab, records: &[Value]) {
    for answer in lab.imports(records).await {
        assert_eq!(answer["status"], 201, "{answer}");
    }
}

async fn alerts(lab: &Lab) -> Vec<Value> {
    lab.alerts("limit=1000").await
}

/// Waits until the alerts are as wanted.
async fn become_so(lab: &Lab, wanted: impl Fn(&[Value]) -> bool) -> Vec<Value> {
    once(async || alerts(lab).await, |alerts| wanted(alerts)).await
}

fn of_station(alerts: &[Value]) -> Option<&Value> {
    alerts.iter().find(|alert| alert["subject"] == "station")
}

fn station_is(alerts: &[Value], state: &str) -> bool {
    of_station(alerts).is_some_and(|alert| alert["state"] == state)
}

/// Alerts of gyros on D_I in a state.
fn of_gyros<'a>(alerts: &'a [Value], state: &'a str) -> impl Iterator<Item = &'a Value> {
    alerts.iter().filter(move |alert| alert["serial"].is_string() && alert["state"] == state)
}

async fn hook(lab: &Lab, target: &Receiver, filter: Value) {
    lab.tells(target, json!({"batch": false, "filter": filter})).await;
}

fn name(data: &Value) -> String {
    let of = data["subject"].as_str().unwrap_or("serial");
    data[of].as_str().unwrap().to_owned()
}

/// What has been told of: serials, stations and IMUs.
fn heard(told: &[Told]) -> Vec<(String, String)> {
    told.iter().map(Told::json).map(|body| (body["type"].as_str().unwrap().to_owned(), name(&body["data"]))).collect()
}

/// Waits until somebody is told that the alert of `name` fires; answers all that was told until then.
async fn has_heard(target: &Receiver, name: &str) -> Vec<(String, String)> {
    let fired = ("alert.fired".to_owned(), name.to_owned());
    once(async || heard(&target.told()), |told| told.contains(&fired)).await
}

#[tokio::test]
async fn a_station_that_shifts_is_one_alert_and_a_gyro_that_moves_by_itself_another() {
    let (lab, target) = (lab().await, Receiver::start().await);
    hook(&lab, &target, json!({})).await;
    lab.clock_shows(&day(34));
    sent(&lab, &shifted(0..6)).await;
    let found =
        become_so(&lab, |alerts| station_is(alerts, "firing") && of_gyros(alerts, "inhibited").count() >= 17).await;
    let station = of_station(&found).unwrap();
    assert_eq!(
        [&station["station"], &station["rule"], &station["coefficient"], &station["severity"]],
        ["ST-2", "station_shift", "D_I", "critical"]
    );
    lab::assert_close(&station["value"], SHIFT, 5e-4);
    assert!(station["serial"].is_null() && station["reason"].as_str().unwrap().contains("3 IMUs"), "{station}");
    assert!(of_gyros(&found, "inhibited").all(|alert| alert["inhibited_by"] == station["id"]), "{found:#?}");
    let own: Vec<&Value> = of_gyros(&found, "firing").collect();
    assert!(!own.is_empty() && own.iter().all(|alert| alert["serial"] == serial(15)), "{own:#?}");
    let detail = lab.get(&format!("/v1/alerts/{}", station["id"].as_str().unwrap())).await.ok();
    assert_eq!(detail["inhibits"].as_array().unwrap().len(), of_gyros(&found, "inhibited").count());
    let inhibited = lab.get("/v1/alerts?state=inhibited").await.ok();
    assert_eq!(inhibited["alerts"].as_array().unwrap().len(), of_gyros(&found, "inhibited").count());

    // The station, and the gyro that moved by itself: nobody hears of the sixteen others. Among servers the clock
    // alone looks at stations: by then they have been told.
    let told = target.has_been_told(1 + own.len()).await;
    tokio::time::sleep(Duration::from_millis(300)).await;
    if !cluster::is_wanted() {
        assert_eq!(target.told().len(), told.len());
        let told = heard(&told);
        assert!(told.iter().all(|(_, name)| name == "ST-2" || *name == serial(15)), "{told:?}");
    }
    has_heard(&target, "ST-2").await;

    // Levelled again. The first IMU shows it before the station's alert ends, and has not moved by itself.
    lab.clock_shows(&day(36));
    sent(&lab, &[calibrated(0, 35, "ST-2", |_| 0.0)]).await;
    tokio::time::sleep(Duration::from_millis(300)).await;
    let of_imus = alerts(&lab).await.into_iter().filter(|alert| alert["subject"] == "imu").collect::<Vec<_>>();
    assert!(of_imus.is_empty(), "{of_imus:#?}");
    // Both ends are told, and those of the gyros to nobody.
    lab.clock_shows(&day(41));
    let back: Vec<Value> = (1..6).map(|imu| calibrated(imu, 35 + imu, "ST-2", |_| 0.0)).collect();
    sent(&lab, &back).await;
    become_so(&lab, |alerts| station_is(alerts, "resolved")).await;
    tokio::time::sleep(Duration::from_millis(300)).await;
    let told = heard(&target.told());
    assert!(told.contains(&("alert.resolved".to_owned(), "ST-2".to_owned())), "{told:?}");
    assert_eq!(lab.verified().await.faults, []);
}

#[tokio::test]
async fn the_clock_goes_on_beside_alerts_of_a_version_that_did_not_keep_since_when() {
    let lab = lab().await;
    lab.clock_shows(&day(34));
    sent(&lab, &shifted(0..6)).await;
    become_so(&lab, |alerts| station_is(alerts, "firing") && of_gyros(alerts, "inhibited").count() >= 17).await;
    let of_before = "UPDATE alert SET since = NULL WHERE status = 'firing' AND gyro IS NOT NULL";
    assert!(lab.change(of_before).await >= 17);
    lab.clock_shows(&day(41));
    sent(&lab, &(0..6).map(|imu| calibrated(imu, 35 + imu, "ST-2", |_| 0.0)).collect::<Vec<_>>()).await;
    become_so(&lab, |alerts| station_is(alerts, "resolved")).await;
}

/// A service that holds these records, on the clock of this machine: day 34 is now.
async fn holding(records: impl Iterator<Item = Value>) -> Server {
    holding_where(34, "0", records).await
}

/// As [`holding`], with the day that it is, and the days within which a gyro is to be calibrated.
async fn holding_where(today: i64, interval_days: &str, records: impl Iterator<Item = Value>) -> Server {
    let set = [("GYROWATCH_ALERTS__TICK_S", "0.05"), ("GYROWATCH_JUDGING__INTERVAL_DAYS", interval_days)];
    let server = Server::start_with(&set).await;
    let now = Clock::System.now();
    let mut lines = String::new();
    for mut record in records {
        let at = time::parse(record["calibrated_at"].as_str().unwrap()).unwrap();
        let ago = time::parse(&day(today)).unwrap().days_since(at);
        record["calibrated_at"] = time::format(now.plus_days(-ago)).into();
        lines += &format!("{record}\n");
    }
    assert_eq!(server.post("/v1/import", lab::NDJSON, lines).await.status, 200);
    server
}

/// What is the matter with one of its gyros is not to be decided by that gyro alone.
#[tokio::test]
async fn that_an_imu_moved_stands_on_the_pages_and_reports_of_its_gyros_and_on_its_own() {
    let moved = calibrated(1, 28, "ST-2", |slot| [0.02, -0.03, 0.045][slot as usize]);
    let server = holding(quiet().into_iter().chain([moved])).await;
    let look = async || server.get("/v1/alerts?rule=imu_shift").await.json()["alerts"][0].clone();
    once(look, |shift| !shift.is_null()).await;
    for path in ["/gyros/GYRO-04", "/gyros/GYRO-04/report", "/imus/IMU-1", "/imus/IMU-1/report"] {
        let text = server.get(path).await.text();
        assert!(text.contains("All 3 gyros of the IMU have moved at once"), "{path}: {text}");
    }
    let other = server.get("/gyros/GYRO-07/report").await.text();
    assert!(!other.contains("have moved at once"), "{other}");
}

#[tokio::test]
async fn what_was_measured_before_a_station_shifted_is_not_explained_by_it() {
    let lab = lab().await;
    lab.clock_shows(&day(34));
    sent(&lab, &shifted(0..6)).await;
    become_so(&lab, |alerts| station_is(alerts, "firing") && of_gyros(alerts, "inhibited").count() >= 17).await;
    // The last of them six days before.
    let late = |at: i64| calibrated(9, at, "ST-2", move |slot| if (at, slot) == (22, 0) { SHIFT } else { 0.0 });
    sent(&lab, &[1, 8, 15, 22].map(late)).await;
    let found = become_so(&lab, |alerts| alerts.iter().any(|alert| alert["serial"] == serial(27))).await;
    let states = |found: &[Value]| -> Vec<Value> {
        let its = found.iter().filter(|alert| alert["serial"] == serial(27));
        its.map(|alert| alert["state"].clone()).collect()
    };
    assert!(states(&found).iter().all(|state| state == "firing"), "{found:#?}");
    tokio::time::sleep(Duration::from_millis(300)).await;
    let found = alerts(&lab).await;
    assert!(states(&found).iter().all(|state| state == "firing"), "the clock has looked at it: {found:#?}");
    assert!(station_is(&found, "firing"), "{found:#?}");
}

/// As a person sees it, on the clock of this machine.
#[tokio::test]
async fn pages_show_the_station_and_what_its_alert_explains() {
    let server = holding(quiet().into_iter().chain(shifted(0..6))).await;
    let look = async || server.get("/v1/alerts?rule=station_shift").await.json()["alerts"][0].clone();
    let station = once(look, |station| !station.is_null()).await;
    let id = station["id"].as_str().unwrap();
    // What another alert explains is not counted with what fires.
    let counts = async || {
        let metrics = server.get("/metrics").await.text();
        let of_severities = metrics.lines().filter(|line| line.starts_with("gyrowatch_alerts_firing{"));
        let counted: f64 = of_severities.map(|line| line.rsplit(' ').next().unwrap().parse::<f64>().unwrap()).sum();
        let of = async |state: &str| {
            let found = server.get(&format!("/v1/alerts?state={state}&limit=1000")).await.json();
            found["alerts"].as_array().unwrap().len()
        };
        (counted as usize, of("firing").await, of("inhibited").await)
    };
    once(counts, |(counted, firing, inhibited)| counted == firing && *inhibited >= 17).await;
    for (page, shows) in [
        ("/alerts".to_owned(), ["href=\"/stations/ST-2\"", "shift of a station"]),
        ("/alerts?state=inhibited".to_owned(), ["GYRO-04", "explained by another alert"]),
        (format!("/alerts/{id}"), ["GYRO-04", "inhibited"]),
        ("/".to_owned(), ["href=\"/stations/ST-2\">ST-2</a>", "shift of a station"]),
        ("/stations/ST-2".to_owned(), ["The median D_I of", "overdue"]),
        ("/stations".to_owned(), ["overdue", "ST-2"]),
    ] {
        let text = server.get(&page).await.text();
        assert!(shows.iter().all(|shown| text.contains(shown)), "{page}: {text}");
    }
}

#[tokio::test]
async fn what_was_held_back_is_told_when_it_is_not_the_stations_after_all() {
    let (lab, target) = (lab().await, Receiver::start().await);
    hook(&lab, &target, json!({ "gyros": [serial(0)] })).await;
    lab.clock_shows(&day(34));
    sent(&lab, &shifted(0..6)).await;
    become_so(&lab, |alerts| station_is(alerts, "firing") && of_gyros(alerts, "inhibited").count() >= 17).await;
    // The hook asked for one gyro, and hears of the station in its place.
    if !cluster::is_wanted() {
        assert_eq!(heard(&target.has_been_told(1).await), [("alert.fired".to_owned(), "ST-2".to_owned())]);
    }
    // All but that gyro are found to be in order.
    lab.clock_shows(&day(41));
    let stays = |imu: i64| move |slot: i64| if (imu, slot) == (0, 0) { SHIFT } else { 0.0 };
    let back: Vec<Value> = (0..6).map(|imu| calibrated(imu, 35 + imu, "ST-2", stays(imu))).collect();
    sent(&lab, &back).await;
    let found =
        become_so(&lab, |alerts| station_is(alerts, "resolved") && of_gyros(alerts, "inhibited").count() == 0).await;
    let held: Vec<&Value> = of_gyros(&found, "firing").filter(|alert| alert["serial"] == serial(0)).collect();
    assert!(!held.is_empty(), "{found:#?}");
    let told = heard(&target.has_been_told(2 + held.len()).await);
    assert!(told.contains(&("alert.fired".to_owned(), serial(0))), "{told:?}");
}

#[tokio::test]
async fn records_that_are_suspect_end_the_alert_of_their_station() {
    let lab = lab().await;
    lab.clock_shows(&day(34));
    sent(&lab, &shifted(0..6)).await;
    become_so(&lab, |alerts| station_is(alerts, "firing")).await;
    let window = json!({"from": day(27), "to": day(34), "by": "Li Wei", "reason": "fixture was loose"});
    let marked = lab.post("/v1/stations/ST-2/suspect", &window).await.ok();
    assert_eq!(marked["records"].as_array().unwrap().len(), 6, "{marked}");
    let found = become_so(&lab, |alerts| station_is(alerts, "resolved")).await;
    assert_eq!(of_gyros(&found, "inhibited").count() + of_gyros(&found, "firing").count(), 0, "{found:#?}");
    // And back.
    lab.post("/v1/stations/ST-2/trust", &window).await.ok();
    become_so(&lab, |alerts| station_is(alerts, "firing") && of_gyros(alerts, "inhibited").count() >= 17).await;
}

/// What is left of the station is older than its shift, and too uncertain to say that there is none.
#[tokio::test]
async fn an_uncertain_record_of_before_does_not_keep_the_alert_of_a_station_whose_records_are_suspect() {
    let lab = lab().await;
    let mut unsure: Vec<Value> = (0..3).map(|imu| calibrated(imu, 25, "ST-2", |_| 0.0)).collect();
    for gyro in unsure.iter_mut().flat_map(|record| record["gyros"].as_array_mut().unwrap()) {
        (gyro["e_sd"], gyro["g_sd"]) = (json!([1e-7, 1e-7, 1e-7]), json!([0.02, 0.02, 0.02]));
    }
    sent(&lab, &unsure).await;
    lab.clock_shows(&day(34));
    sent(&lab, &shifted(0..6)).await;
    become_so(&lab, |alerts| station_is(alerts, "firing") && of_gyros(alerts, "inhibited").count() >= 17).await;
    let window = json!({"from": day(27), "to": day(34), "by": "Li Wei", "reason": "fixture was loose"});
    lab.post("/v1/stations/ST-2/suspect", &window).await.ok();
    let found = become_so(&lab, |alerts| station_is(alerts, "resolved")).await;
    assert_eq!(of_gyros(&found, "inhibited").count(), 0, "{found:#?}");
}

#[tokio::test]
async fn imus_that_come_one_by_one_are_told_until_there_are_enough_and_the_alert_outlives_a_restart() {
    let (mut lab, target) = (lab().await, Receiver::start().await);
    hook(&lab, &target, json!({})).await;
    for imu in 0..6 {
        lab.clock_shows(&day(28 + imu));
        sent(&lab, &shifted(imu..imu + 1)).await;
        if imu == 2 {
            become_so(&lab, |alerts| station_is(alerts, "firing") && of_gyros(alerts, "firing").count() == 0).await;
            lab.restart().await;
        }
    }
    let found =
        become_so(&lab, |alerts| of_gyros(alerts, "inhibited").any(|alert| alert["serial"] == serial(14))).await;
    assert!(of_gyros(&found, "firing").all(|alert| alert["serial"] == serial(15)), "{found:#?}");
    tokio::time::sleep(Duration::from_millis(300)).await;
    let told = heard(&target.told());
    let names: Vec<&str> = told.iter().map(|(_, name)| name.as_str()).collect();
    assert!(!names.contains(&"GYRO-09") && !names.contains(&"GYRO-14"), "{told:?}");
    // Among servers the clock alone looks at IMUs: by then their gyros have been told.
    if !cluster::is_wanted() {
        assert!(names.contains(&"IMU-0") && !names.contains(&"GYRO-00"), "{told:?}");
    }
    // Somebody knows: an alert of a station is an alert.
    let id = of_station(&found).unwrap()["id"].as_str().unwrap().to_owned();
    let said = json!({"by": "Li Wei", "reason": "the mason comes on Monday"});
    let known = lab.post(&format!("/v1/alerts/{id}/acknowledge"), &said).await.ok();
    assert_eq!((&known["state"], &known["subject"]), (&json!("acknowledged"), &json!("station")));
    let csv = lab.request(Method::GET, "/v1/alerts?format=csv&state=acknowledged").send().await.unwrap();
    let csv = csv.text().await.unwrap();
    assert!(csv.lines().nth(1).unwrap().ends_with(",station,,"), "{csv}");
}

#[tokio::test]
async fn an_imu_of_which_every_gyro_moves_is_one_alert_and_what_one_does_later_another() {
    let (lab, target) = (lab().await, Receiver::start().await);
    hook(&lab, &target, json!({})).await;
    // Dropped: each of its gyros has moved by another amount.
    let dropped = |slot: i64| [0.02, -0.03, 0.045][slot as usize];
    lab.clock_shows(&day(29));
    sent(
        &lab,
        &[calibrated(1, 28, "ST-2", dropped), calibrated(2, 28, "ST-2", |slot| if slot < 2 { 0.03 } else { 0.0 })],
    )
    .await;
    let of_imu = |alert: &&Value| alert["subject"] == "imu";
    let is_told = |alerts: &[Value]| {
        let is_held = |k: i64| {
            let its = |state: &str| alerts.iter().any(|alert| alert["serial"] == serial(k) && alert["state"] == state);
            its("inhibited") && !its("firing")
        };
        alerts.iter().any(|alert| of_imu(&alert) && alert["state"] == "firing") && (3..6).all(is_held)
    };
    let found = become_so(&lab, is_told).await;
    let shifts: Vec<&Value> = found.iter().filter(of_imu).collect();
    let [shift] = shifts[..] else { panic!("{shifts:#?}") };
    assert_eq!(
        [&shift["imu"], &shift["rule"], &shift["coefficient"], &shift["severity"], &shift["status"]],
        ["IMU-1", "imu_shift", "D_I", "warning", "unconfirmed"]
    );
    lab::assert_close(&shift["value"], 0.02, 1e-3);
    assert!(of_gyros(&found, "inhibited").all(|alert| alert["inhibited_by"] == shift["id"]), "{found:#?}");
    // Two of three gyros of the other have moved by themselves.
    let by_themselves: Vec<&Value> = of_gyros(&found, "firing").map(|alert| &alert["serial"]).collect();
    assert!((6..8).all(|k| by_themselves.contains(&&json!(serial(k)))), "{by_themselves:?}");
    let told = has_heard(&target, "IMU-1").await;
    if !cluster::is_wanted() {
        assert!((3..6).all(|k| told.iter().all(|(_, name)| *name != serial(k))), "{told:?}");
    }

    // A second campaign confirms it: told as graver, of the IMU alone.
    lab.clock_shows(&day(36));
    sent(&lab, &[calibrated(1, 35, "ST-2", dropped)]).await;
    let confirmed = |alerts: &[Value]| {
        is_told(alerts) && alerts.iter().any(|alert| of_imu(&alert) && alert["severity"] == "critical")
    };
    become_so(&lab, confirmed).await;

    // One of them moves again: that is its own.
    for (at, again) in [(42, 0.0), (49, 0.1)] {
        lab.clock_shows(&day(at + 1));
        sent(&lab, &[calibrated(1, at, "ST-2", |slot| dropped(slot) + if slot == 1 { again } else { 0.0 })]).await;
    }
    let moves_again = |alert: &Value| {
        (&alert["serial"], &alert["rule"]) == (&json!(serial(4)), &json!("step")) && alert["state"] == "firing"
    };
    become_so(&lab, |alerts| alerts.iter().any(moves_again)).await;
    // And so is how far from its baseline it has come since its IMU moved, though that began with the IMU.
    let baseline = |k: i64, state: &str| {
        let is_its = move |alert: &Value| (&alert["serial"], &alert["rule"]) == (&json!(serial(k)), &json!("baseline"));
        let state = state.to_owned();
        move |alert: &Value| is_its(alert) && alert["state"] == state
    };
    let (grown, held) = (baseline(4, "firing"), [baseline(3, "inhibited"), baseline(5, "inhibited")]);
    let found =
        become_so(&lab, |alerts| alerts.iter().any(&grown) && held.iter().all(|is| alerts.iter().any(is))).await;
    lab::assert_close(&found.iter().find(|alert| grown(alert)).unwrap()["with_imu"], 0.03, 1e-3);

    // Its seat is mended.
    for back in [56, 63] {
        lab.clock_shows(&day(back + 1));
        sent(&lab, &[calibrated(1, back, "ST-2", |_| 0.0)]).await;
    }
    let is_over = |alert: &&Value| of_imu(alert) && alert["state"] == "resolved";
    become_so(&lab, |alerts| alerts.iter().any(|alert| is_over(&alert))).await;
    assert_eq!(lab.verified().await.faults, []);
}

#[tokio::test]
async fn the_alert_of_an_imu_ends_with_the_record_that_is_voided_and_not_with_the_next_tick() {
    let lab = lab_whose_clock_looks_every(3600.0).await;
    lab.clock_shows(&day(29));
    let dropped = calibrated(1, 28, "ST-2", |slot| [0.02, -0.03, 0.045][slot as usize]);
    let id = lab.posts(&dropped).await["id"].as_str().unwrap().to_owned();
    // Among several servers the clock alone begins it; here it is asked to look.
    lab.pipeline().ingest.look_at_shared().await.unwrap();
    let state = |alerts: &[Value]| {
        let shift = alerts.iter().find(|alert| alert["rule"] == "imu_shift").expect("the IMU has moved");
        shift["state"].as_str().unwrap().to_owned()
    };
    assert_eq!(state(&alerts(&lab).await), "firing");
    let said = json!({"author": "Li Wei", "reason": "clamped askew"});
    lab.post(&format!("/v1/records/{id}/void"), &said).await.ok();
    assert_eq!(state(&alerts(&lab).await), "resolved");
    assert_eq!(lab.verified().await.faults, []);
}

#[tokio::test]
async fn an_imu_that_is_calibrated_again_before_anybody_looks_is_one_alert_since_it_moved() {
    let lab = lab_whose_clock_looks_every(0.5).await;
    let dropped = |slot: i64| [0.02, -0.03, 0.045][slot as usize];
    let again = |imu: i64, from: usize| {
        let moved = move |at: i64, slot: i64| if (at - 28) / 7 >= slot * from as i64 { dropped(slot) } else { 0.0 };
        [28, 35, 42].map(|at| calibrated(imu, at, "ST-2", move |slot| moved(at, slot)))
    };
    lab.clock_shows(&day(43));
    // Of the second each gyro has moved in a week of its own.
    sent(&lab, &[again(1, 0), again(2, 1)].concat()).await;
    let of_imu = |alert: &&Value| alert["subject"] == "imu";
    let is_held = |alert: &Value| alert["state"] == "inhibited" && alert["rule"] == "baseline";
    let found = become_so(&lab, |alerts| alerts.iter().filter(|alert| is_held(alert)).count() == 3).await;
    let shifts: Vec<&Value> = found.iter().filter(of_imu).collect();
    let [shift] = shifts[..] else { panic!("{shifts:#?}") };
    assert_eq!(
        [&shift["imu"], &shift["rule"], &shift["state"], &shift["severity"], &shift["since"]],
        [&json!("IMU-1"), &json!("imu_shift"), &json!("firing"), &json!("critical"), &json!(day(28))]
    );
    assert!(of_gyros(&found, "inhibited").all(|alert| alert["inhibited_by"] == shift["id"]), "{found:#?}");

    // What is over is not told again, though two of its gyros are not back.
    lab.clock_shows(&day(50));
    sent(&lab, &[calibrated(1, 49, "ST-2", |slot| if slot == 0 { 0.0 } else { dropped(slot) })]).await;
    let is_over = |alert: &Value| of_imu(&alert) && alert["state"] == "resolved";
    let ended = become_so(&lab, |alerts| alerts.iter().any(is_over)).await;
    let id = ended.iter().find(|alert| is_over(alert)).unwrap()["id"].as_str().unwrap().to_owned();
    sent(&lab, &[calibrated(3, 49, "ST-2", |_| 0.0)]).await;
    tokio::time::sleep(Duration::from_millis(1200)).await;
    let history = lab.get(&format!("/v1/alerts/{id}")).await.ok()["history"].clone();
    let steps: Vec<&Value> = history.as_array().unwrap().iter().map(|step| &step["action"]).collect();
    assert_eq!(steps.iter().filter(|step| **step == "fire").count(), 1, "{steps:?}");
    assert_eq!(**steps.last().unwrap(), "resolve", "{steps:?}");
}

#[tokio::test]
async fn the_alert_of_an_imu_begins_with_a_record_that_comes_late_and_goes_on_to_explain_its_gyros() {
    let lab = lab().await;
    let dropped = |at: i64| calibrated(1, at, "ST-2", |slot| [0.02, -0.03, 0.045][slot as usize]);
    lab.clock_shows(&day(43));
    sent(&lab, &[dropped(42)]).await;
    let of_imu = |alert: &Value| alert["subject"] == "imu" && alert["state"] == "firing";
    let is_since = |alert: &Value, at: i64| alert["since"] == day(at);
    become_so(&lab, |alerts| alerts.iter().any(|alert| of_imu(alert) && is_since(alert, 42))).await;
    for late in [28, 35] {
        sent(&lab, &[dropped(late)]).await;
    }
    let is_held = |alert: &Value| alert["rule"] == "baseline" && alert["state"] == "inhibited" && is_since(alert, 28);
    let found = become_so(&lab, |alerts| {
        let held = alerts.iter().filter(|alert| is_held(alert)).count();
        held == 3 && alerts.iter().any(|alert| of_imu(alert) && is_since(alert, 28))
    })
    .await;
    assert_eq!(found.iter().find(|alert| of_imu(alert)).unwrap()["severity"], "critical", "{found:#?}");
}

#[tokio::test]
async fn an_imu_of_which_one_gyro_has_drifted_within_its_budget_moves_at_once_all_the_same() {
    let lab = lab().await;
    let drifts = |slot: i64| if slot == 0 { 0.005 } else { 0.0 };
    let quiet = (4..14).map(|week| calibrated(1, 7 * week, "ST-2", |_| 0.0));
    let drifted = (14..18).map(|week| calibrated(1, 7 * week, "ST-2", drifts));
    lab.clock_shows(&day(7 * 17));
    sent(&lab, &quiet.chain(drifted).collect::<Vec<_>>()).await;
    let before = alerts(&lab).await;
    let of_d_i: Vec<&Value> = of_gyros(&before, "firing").filter(|alert| alert["coefficient"] == "D_I").collect();
    assert!(!of_d_i.is_empty() && of_d_i.iter().all(|alert| alert["status"] == "drifting"), "{before:#?}");
    lab.clock_shows(&day(7 * 18));
    sent(&lab, &[calibrated(1, 7 * 18, "ST-2", |slot| [0.03, -0.03, 0.045][slot as usize])]).await;
    let of_imu = |alert: &Value| alert["subject"] == "imu" && alert["state"] == "firing";
    become_so(&lab, |alerts| alerts.iter().any(of_imu)).await;
}

async fn is_of(lab: &Lab, gyro: i64, batch: &str) {
    let changed = lab.request(Method::PATCH, &format!("/v1/gyros/{}", serial(gyro)));
    let changed = changed.header("content-type", "application/json").body(json!({ "batch": batch }).to_string());
    assert_eq!(changed.send().await.unwrap().status(), 200);
}

#[tokio::test]
async fn gyros_of_a_batch_that_move_together_are_one_alert_of_the_batch_and_none_of_a_station() {
    let (mut lab, target) = (lab().await, Receiver::start().await);
    hook(&lab, &target, json!({})).await;
    // Three IMUs of nine, two of them at one station and one at the other.
    let of_batch = |imu: i64| imu % 3 == 1;
    for gyro in (0..9).filter(|imu| of_batch(*imu)).flat_map(|imu| 3 * imu..3 * imu + 3) {
        is_of(&lab, gyro, "2024/B").await;
    }
    let all = |at: i64, d_i: fn(i64, i64) -> f64| -> Vec<Value> {
        let station = |imu: i64| if imu < 6 { "ST-2" } else { "ST-1" };
        let one = |imu: i64| {
            let d_i = move |slot: i64| if of_batch(imu) { d_i(imu, slot) } else { 0.0 };
            calibrated(imu, at + imu % 6, station(imu), d_i)
        };
        (0..9).map(one).collect()
    };
    lab.clock_shows(&day(34));
    sent(&lab, &all(28, |_, _| SHIFT)).await;
    let of = |alerts: &[Value], subject: &str, state: &str| {
        alerts.iter().filter(|alert| alert["subject"] == subject && alert["state"] == state).count()
    };
    let is_told = |alerts: &[Value]| {
        of(alerts, "batch", "firing") == 1
            && of_gyros(alerts, "inhibited").count() >= 9
            && of_gyros(alerts, "firing").count() == 0
    };
    let found = become_so(&lab, is_told).await;
    let batch = found.iter().find(|alert| alert["subject"] == "batch").unwrap();
    assert_eq!(
        [&batch["batch"], &batch["rule"], &batch["coefficient"], &batch["severity"], &batch["serial"]],
        [&json!("2024/B"), &json!("batch_shift"), &json!("D_I"), &json!("critical"), &Value::Null]
    );
    lab::assert_close(&batch["value"], SHIFT, 5e-4);
    assert!(batch["reason"].as_str().unwrap().contains("9 gyros of 3 IMUs of the batch"), "{batch}");
    assert!(of_gyros(&found, "inhibited").all(|alert| alert["inhibited_by"] == batch["id"]), "{found:#?}");
    assert_eq!(of(&found, "station", "firing") + of(&found, "imu", "firing"), 0, "{found:#?}");
    if !cluster::is_wanted() {
        let told = heard(&target.has_been_told(1).await);
        assert_eq!(told, [("alert.fired".to_owned(), "2024/B".to_owned())]);
    }
    let csv = lab.get("/v1/alerts?format=csv&rule=batch_shift").await;
    assert!(csv.text.lines().nth(1).unwrap().ends_with(",batch,,2024/B"), "{}", csv.text);
    // It is no gyro's, and not in its list.
    let of_one = lab.get(&format!("/v1/alerts?serial={}", serial(3))).await.ok();
    assert!(of_one["alerts"].as_array().unwrap().iter().all(|alert| alert["rule"] != "batch_shift"), "{of_one}");

    // After a restart too, a gyro that has moved by more is told by itself, and its mates are not.
    lab.restart().await;
    lab.clock_shows(&day(41));
    sent(&lab, &all(35, |imu, slot| if (imu, slot) == (7, 2) { SHIFT + OWN } else { SHIFT })).await;
    let its_own = |alerts: &[Value]| {
        let own: Vec<&Value> = of_gyros(alerts, "firing").collect();
        !own.is_empty() && own.iter().all(|alert| alert["serial"] == serial(23))
    };
    become_so(&lab, its_own).await;
    // One that is found to be of another batch is told by itself; the alert of those that it was listed with stays.
    is_of(&lab, 3, "2024/C").await;
    lab.clock_shows(&day(43));
    sent(&lab, &all(37, |_, _| SHIFT)).await;
    let is_left = |alerts: &[Value]| {
        let of_batches: Vec<&Value> = alerts.iter().filter(|alert| alert["subject"] == "batch").collect();
        let [same] = of_batches[..] else { panic!("{of_batches:#?}") };
        assert_eq!([&same["id"], &same["batch"], &same["state"]], [&batch["id"], &json!("2024/B"), &json!("firing")]);
        of_gyros(alerts, "firing").any(|alert| alert["serial"] == serial(3))
    };
    become_so(&lab, is_left).await;
    // As they were.
    for at in [44, 51] {
        lab.clock_shows(&day(at + 6));
        sent(&lab, &all(at, |_, _| 0.0)).await;
    }
    become_so(&lab, |alerts| of(alerts, "batch", "resolved") == 1 && of(alerts, "batch", "firing") == 0).await;
    assert_eq!(lab.verified().await.faults, []);
}

#[tokio::test]
async fn what_a_suspect_window_ends_or_begins_is_told_at_once() {
    // Among servers the clock alone tells of stations first.
    if cluster::is_wanted() {
        return;
    }
    let lab = lab_whose_clock_looks_every(3600.0).await;
    lab.clock_shows(&day(34));
    sent(&lab, &shifted(0..6)).await;
    assert!(station_is(&alerts(&lab).await, "firing"));
    let window = json!({"from": day(27), "to": day(34), "by": "Li Wei", "reason": "fixture was loose"});
    lab.post("/v1/stations/ST-2/suspect", &window).await.ok();
    assert!(station_is(&alerts(&lab).await, "resolved"));
    lab.post("/v1/stations/ST-2/trust", &window).await.ok();
    assert!(station_is(&alerts(&lab).await, "firing"));
}

#[tokio::test]
async fn a_station_counts_all_that_it_has_calibrated() {
    let lab = Lab::open().await;
    lab.clock_shows(&day(400));
    let mut all: Vec<Value> = (0..130).map(|at| calibrated(0, at, "ST-2", |_| 0.0)).collect();
    all.extend((0..9).map(|at| calibrated(1, 200 + at, "ST-2", |_| 0.0)));
    sent(&lab, &all).await;
    let counts = |station: &Value| [&station["records"], &station["gyros"], &station["imus"]].map(|n| n.as_u64());
    let station = lab.get("/v1/stations/ST-2").await.ok();
    assert_eq!(counts(&station), [Some(139), Some(6), Some(2)], "{station}");
    assert_eq!([&station["first"], &station["last"]], [&json!(day(0)), &json!(day(208))]);
    let window = json!({"from": day(0), "to": day(9), "by": "Li Wei", "reason": "fixture was loose"});
    lab.post("/v1/stations/ST-2/suspect", &window).await.ok();
    assert_eq!(counts(&lab.get("/v1/stations/ST-2").await.ok())[0], Some(129));
    lab.post("/v1/stations/ST-2/trust", &window).await.ok();
    assert_eq!(counts(&lab.get("/v1/stations").await.ok()["stations"][0])[0], Some(139));
}

/// By less than any gyro's limit: no rule of a gyro speaks.
#[tokio::test]
async fn a_small_shift_of_a_station_is_told_with_the_record_that_shows_it_and_since_the_first() {
    let small = |imu: i64, at: i64| calibrated(imu, at + imu, "ST-2", |_| 0.006);
    if !cluster::is_wanted() {
        let lab = lab_whose_clock_looks_every(3600.0).await;
        for imu in 0..2 {
            assert_eq!(of_station(&alerts(&lab).await), None, "{imu}");
            lab.clock_shows(&day(28 + imu));
            lab.posts(&small(imu, 28)).await;
        }
        let found = alerts(&lab).await;
        let station = of_station(&found).expect("two of the newest three IMUs show it").clone();
        assert_eq!([&station["state"], &station["since"]], [&json!("firing"), &json!(day(28))]);
    }
    // Looked at late: the newest of the same IMUs show it since the second week.
    let lab = lab().await;
    lab.clock_shows(&day(41));
    sent(&lab, &[28, 35].into_iter().flat_map(|at| (0..6).map(move |imu| small(imu, at))).collect::<Vec<_>>()).await;
    let found = become_so(&lab, |alerts| station_is(alerts, "firing")).await;
    assert_eq!(of_station(&found).unwrap()["since"], day(28));
}

/// A table that is wrongly levelled turns each gyro's figures its own way: no gyro has stepped.
#[tokio::test]
async fn gyros_that_a_station_moves_each_its_own_way_are_told_to_check_the_station() {
    let off = |week: i64, imu: i64, slot: i64| match (week, slot) {
        (..8, _) | (_, 0) => 0.0,
        _ if (imu + slot) % 2 == 0 => SHIFT,
        _ => -SHIFT,
    };
    let of_week = move |week: i64| {
        (0..6).map(move |imu| calibrated(imu, 7 * week + imu, "ST-2", move |slot| off(week, imu, slot)))
    };
    let server = holding_where(76, "0", (0..11).flat_map(of_week)).await;
    let stations: Value = server.get("/v1/stations").await.json();
    let of = stations["stations"].as_array().unwrap().iter().find(|one| one["name"] == "ST-2").unwrap();
    assert_eq!([&of["unlike"][0]["gyros"], &of["unlike"][0]["of"]], [12, 18], "{of}");
    let table = server.get("/stations").await.text();
    assert!(table.contains("12 of 18 gyros, each its own way"), "{table}");
    for gyro in [1, 8, 17] {
        let told: Value = server.get(&format!("/v1/gyros/{}/diagnosis", serial(gyro))).await.json();
        let cause = &told["coefficients"][0]["causes"][0];
        assert_eq!((&cause["cause"], &cause["class"]), (&json!("station"), &json!(["station", "step"])), "{told}");
        assert!(cause["detail"].as_str().unwrap().contains("ST-2 are off since"), "{cause}");
        for page in ["", "/report"] {
            let page = server.get(&format!("/gyros/{}{page}", serial(gyro))).await.text();
            assert!(page.contains("Check the station first"), "{page}");
        }
    }
}

/// Its drift is in the list of what another alert explains; among those that fire it is overdue, and as bad as ever.
#[tokio::test]
async fn a_gyro_that_its_station_explains_is_as_bad_among_the_alerts_of_overdue_gyros() {
    let server = holding_where(34, "3", quiet().into_iter().chain(shifted(0..6))).await;
    let states = async || {
        let found = server.get(&format!("/v1/alerts?serial={}&limit=1000", serial(4))).await.json();
        let of = |state: &str| found["alerts"].as_array().unwrap().iter().filter(|one| one["state"] == state).count();
        (of("inhibited"), of("firing"))
    };
    once(states, |(inhibited, firing)| *inhibited > 0 && *firing > 0).await;
    let firing = server.get("/alerts").await.text();
    let row = firing.split("<article").find(|one| one.contains("/gyros/GYRO-04\"")).expect("it is overdue");
    let head = &row[..row.find("<details").unwrap()];
    assert!(head.contains("badge unconfirmed") && !head.contains("badge overdue"), "{head}");
}
