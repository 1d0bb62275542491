//! Why a coefficient changed: the history of a gyro, diagnosed from what the service holds.

use crate::lab::scatter;
use crate::prelude::*;
use gyrowatch::wire::time;

/// Twenty-four records, four weeks apart, every third one by the second station.
async fn station_history(lab: &Lab, imu: &str, serial: &str, shift: i64, d_i: impl Fn(i64, bool) -> f64) {
    let mut records = Vec::new();
    for k in 0..24 {
        let away = k % 3 == 2;
        let d_i = 3.0 + scatter(k + shift, 1e-4) + d_i(k, away);
        let mut sent = record(imu, &day(28 * k), &[("G1", serial, d_i, 4.0 + scatter(k + shift + 3, 1e-4))]);
        sent["station"] = if away { "ST-2" } else { "ST-1" }.into();
        sent["temperature_c"] = (40 + k * k % 7).into();
        records.push(sent);
    }
    for answer in lab.imports(&records).await {
        assert_eq!(answer["status"], 201, "{answer}");
    }
}

async fn diagnosis(lab: &Lab, serial: &str, coefficient: &str) -> Value {
    let answer = lab.get(&format!("/v1/gyros/{serial}/diagnosis")).await.ok();
    assert_eq!(answer["serial"], serial);
    let coefficients = answer["coefficients"].as_array().unwrap();
    coefficients.iter().find(|c| c["coefficient"] == coefficient).unwrap().clone()
}

#[tokio::test]
async fn an_ageing_gyro_is_told_from_a_stable_one() {
    let lab = Lab::open().await;
    station_history(&lab, "IMU-1", "AGES", 0, |k, _| 4e-4 * k as f64).await;
    station_history(&lab, "IMU-2", "STAYS", 4, |_, _| 0.0).await;
    let ages = diagnosis(&lab, "AGES", "D_I").await;
    assert_eq!(ages["verdict"], "explained", "{ages}");
    assert_eq!(ages["causes"][0]["cause"], "ageing");
    let slope = ages["causes"][0]["estimates"][0]["value"].as_f64().unwrap();
    let a_year = 4e-4 * 365.25 / 28.0;
    assert!((slope / a_year - 1.0).abs() < 0.1, "{slope} is not {a_year}");
    assert_eq!(diagnosis(&lab, "STAYS", "D_I").await["verdict"], "no_change");
}

#[tokio::test]
async fn a_stations_offset_is_seen_on_the_other_gyros_too() {
    let lab = Lab::open().await;
    for (k, serial) in ["A", "B", "C"].into_iter().enumerate() {
        let offset = |_, away| if away { 5e-3 } else { 0.0 };
        station_history(&lab, &format!("IMU-{k}"), serial, 3 * k as i64, offset).await;
    }
    let answer = lab.get("/v1/gyros/A/diagnosis").await.ok();
    assert_eq!(answer["peers"], 2);
    let shifted = diagnosis(&lab, "A", "D_I").await;
    assert_eq!(shifted["causes"][0]["cause"], "station", "{shifted}");
}

#[tokio::test]
async fn a_temperature_that_the_records_state_is_a_candidate() {
    let lab = Lab::open().await;
    station_history(&lab, "IMU-1", "WARM", 0, |k, _| 2e-3 * (k * k % 7) as f64).await;
    let warm = diagnosis(&lab, "WARM", "D_I").await;
    assert_eq!(warm["causes"][0]["cause"], "temperature", "{warm}");
    let per_kelvin = warm["causes"][0]["estimates"][0]["value"].as_f64().unwrap();
    assert!((per_kelvin - 2e-3).abs() < 2e-4, "{per_kelvin}");
}

/// A campaign in CSV says its temperature as one in JSON does, and a sensor's fault value is none.
#[tokio::test]
async fn a_campaigns_temperature_is_the_mean_of_what_its_dwells_can_be_believed() {
    let lab = Lab::open().await;
    let csv = include_str!("../docs/examples/march.csv");
    let column =
        csv.lines().find(|line| line.starts_with("phase,")).unwrap().split(',').position(|c| c == "temperature_c");
    let (column, mut stated, mut faulty) = (column.unwrap(), Vec::new(), String::new());
    for line in csv.lines() {
        let mut cells: Vec<&str> = line.split(',').collect();
        match cells.get(column).and_then(|cell| cell.parse::<f64>().ok()) {
            Some(_) if stated.len() == 7 => {
                cells[column] = "999";
                stated.push(f64::NAN);
            }
            Some(temperature) => stated.push(temperature),
            None => {}
        }
        faulty += &(cells.join(",") + "\n");
    }
    let stored = lab.post_text("/v1/campaigns", "text/csv", faulty).await.created();
    assert!(stored["id"].is_string());
    let kept = lab.rows::<(f64,)>("SELECT temperature_c FROM record").await[0].0;
    // In the place of the fault stands what lies between its neighbours.
    stated[7] = 0.5 * (stated[6] + stated[8]);
    let mean = stated.iter().sum::<f64>() / stated.len() as f64;
    assert!((kept - mean).abs() < 1e-3, "{kept} {mean}");
}

#[tokio::test]
async fn too_few_records_say_so_and_unknown_gyros_are_not_found() {
    let lab = Lab::open().await;
    lab.posts(&record("IMU-1", &day(0), &[("G1", "NEW", 1.0, 2.0)])).await;
    assert_eq!(diagnosis(&lab, "NEW", "D_S").await["verdict"], "too_few");
    lab.get("/v1/gyros/NOBODY/diagnosis").await.refused(404);
}

#[tokio::test]
async fn stations_are_told_by_what_their_gyros_share() {
    let lab = Lab::open().await;
    for (k, serial) in ["A", "B", "C", "D"].into_iter().enumerate() {
        let offset = |_, away| if away { 5e-3 } else { 0.0 };
        station_history(&lab, &format!("IMU-{k}"), serial, 3 * k as i64, offset).await;
    }
    let stations = lab.get("/v1/stations").await.ok();
    assert_eq!((&stations["against"], stations["stations"].as_array().unwrap().len()), (&Value::from("ST-1"), 2));
    let mut second = lab.get("/v1/stations/ST-2").await.ok();
    assert_eq!(second.as_object_mut().and_then(|second| second.remove("suspect_windows")), Some(Value::Array(vec![])));
    assert_eq!(stations["stations"][1], second);
    assert_eq!((&second["records"], &second["gyros"], &second["imus"]), (&32.into(), &4.into(), &4.into()));
    let [value, sd] = ["value", "sd"].map(|of| second["D_I"]["offset"][of].as_f64().unwrap());
    assert!((value - 5e-3).abs() < 3.0 * sd && sd < 2e-4, "{value} +- {sd}");
    assert_eq!(second["D_I"]["drifts"], false);
    assert!(second["D_I"]["repeatability"]["sd"].as_f64().unwrap() < 3e-4, "{second}");
    lab.get("/v1/stations/NOWHERE").await.refused(404);
}

#[tokio::test]
async fn a_lone_imu_that_was_moved_gets_a_class() {
    let lab = Lab::open().await;
    let mut records = Vec::new();
    for k in 0..24 {
        let moved = if k >= 12 { 5e-3 } else { 0.0 };
        let mut sent = record(
            "IMU-1",
            &day(28 * k),
            &[("G1", "ALONE", 3.0 + moved + scatter(k, 1e-4), 4.0 + scatter(k + 3, 1e-4))],
        );
        sent["station"] = if k >= 12 { "ST-2" } else { "ST-1" }.into();
        records.push(sent);
    }
    for answer in lab.imports(&records).await {
        assert_eq!(answer["status"], 201, "{answer}");
    }
    let alone = diagnosis(&lab, "ALONE", "D_I").await;
    assert_eq!(alone["causes"][0]["class"], json!(["station", "step"]), "{alone}");
}

/// Every record is wrong at first, and is revised; others come, and are voided; one is suspect, and is trusted again.
#[tokio::test]
async fn a_history_full_of_voids_and_revisions_is_diagnosed_by_what_counts() {
    let (lab, plain) = (Lab::open().await, Lab::open().await);
    let d_i = |k: i64| 3.0 + scatter(k, 1e-4) + 4e-4 * k as f64;
    let sent = |k: i64, d_i: f64| record("IMU-1", &day(28 * k), &[("G1", "AGES", d_i, 4.0 + scatter(k + 3, 1e-4))]);
    let said = |record: &Value| json!({"author": "Li Wei", "reason": "wrong serial", "record": record});
    for k in 0..24 {
        plain.posts(&sent(k, d_i(k))).await;
        let wrong = lab.posts(&sent(k, 9.0 - 0.1 * k as f64)).await["id"].as_str().unwrap().to_owned();
        lab.post(&format!("/v1/records/{wrong}/revise"), &said(&sent(k, d_i(k)))).await.created();
        let more = record("IMU-1", &day(28 * k + 5), &[("G1", "AGES", -2.0, 4.0)]);
        let more = lab.posts(&more).await["id"].as_str().unwrap().to_owned();
        let why = json!({"author": "Li Wei", "reason": "table was not level"});
        lab.post(&format!("/v1/records/{more}/void"), &why).await.ok();
    }
    let window = json!({"from": day(200), "to": day(400), "by": "Li Wei", "reason": "loose"});
    for way in ["suspect", "trust"] {
        lab.post(&format!("/v1/stations/ST-1/{way}"), &window).await.ok();
    }
    let [corrected, plain] = [diagnosis(&lab, "AGES", "D_I").await, diagnosis(&plain, "AGES", "D_I").await];
    assert_eq!(plain["causes"][0]["cause"], "ageing", "{plain}");
    assert_eq!(corrected, plain);
}

/// Records of one gyro of an IMU of its own at ST-1, `days` apart.
async fn sends(lab: &Lab, serial: &str, records: i64, days: f64, d_i: impl Fn(i64) -> f64) {
    let shift = serial.bytes().map(i64::from).sum::<i64>();
    let noise = |k: i64| scatter(k + k / 17 * 3 + shift, 1e-4);
    let of = |k: i64| {
        let figures = ("G1", serial, 3.0 + noise(k) + d_i(k), 4.0 + noise(k + 3));
        let start = time::parse(&day(0)).unwrap();
        record(&format!("IMU-{serial}"), &time::format(start.plus_days(days * k as f64)), &[figures])
    };
    for answer in lab.imports(&(0..records).map(of).collect::<Vec<_>>()).await {
        assert_eq!(answer["status"], 201, "{answer}");
    }
}

#[tokio::test]
async fn records_of_one_day_do_not_age() {
    let lab = Lab::open().await;
    sends(&lab, "HOURS", 24, 1.0 / 86_400.0, |k| 2e-3 * k as f64).await;
    let answer = diagnosis(&lab, "HOURS", "D_I").await;
    assert_eq!((&answer["verdict"], &answer["due"]), (&Value::from("too_few"), &Value::Null), "{answer}");
    assert!(answer["said"][0].as_str().unwrap().starts_with("24 records within one day"), "{answer}");
}

#[tokio::test]
async fn what_happened_long_ago_in_a_long_history_is_not_passed_over() {
    let lab = Lab::open().await;
    sends(&lab, "LONG", 1200, 0.25, |k| if k >= 100 { 5e-3 } else { 0.0 }).await;
    let whole = lab.get("/v1/gyros/LONG/diagnosis").await.ok();
    assert_eq!((&whole["records"], &whole["coefficients"][0]["records"]), (&1200.into(), &600.into()));
    let answer = diagnosis(&lab, "LONG", "D_I").await;
    assert!(answer["causes"][0]["class"].as_array().unwrap().contains(&"step".into()), "{answer}");
    let said = answer["said"].as_array().unwrap();
    assert_eq!(said.last().unwrap(), "600 of 1200 records are looked at, spread over their time.", "{answer}");
}

#[tokio::test]
async fn what_a_station_did_before_the_newest_hundred_records_of_its_gyros_is_still_the_stations() {
    let lab = Lab::open().await;
    for serial in ["A", "B", "C", "D"] {
        sends(&lab, serial, 150, 2.0, |k| if k >= 25 { 5e-3 } else { 0.0 }).await;
    }
    let answer = diagnosis(&lab, "B", "D_I").await;
    let causes: Vec<&Value> = answer["causes"].as_array().unwrap().iter().map(|cause| &cause["cause"]).collect();
    assert_eq!(causes, ["station"], "{answer}");
}

/// Records of one gyro in an IMU of its own, four weeks apart, each by the station and of the D_I that are given.
fn by_stations(serial: &str, records: i64, of: impl Fn(i64) -> (&'static str, f64)) -> Vec<Value> {
    let shift = serial.bytes().map(i64::from).sum::<i64>();
    let one = |k: i64| {
        let (station, d_i) = of(k);
        let d_i = 3.0 + scatter(k + shift, 1e-4) + d_i;
        let mut sent = record(&format!("IMU-{serial}"), &day(28 * k), &[("G1", serial, d_i, 4.0 + scatter(k, 1e-4))]);
        sent["station"] = station.into();
        sent
    };
    (0..records).map(one).collect()
}

#[tokio::test]
async fn gyros_of_a_busy_station_do_not_crowd_out_those_of_another() {
    let lab = Lab::open().await;
    let drifts = |k: i64| ("QB", 8e-4 * k as f64);
    let mut records = by_stations("MOVED", 24, |k| if k < 10 { ("QA", 0.0) } else { drifts(k) });
    records.extend((0..70).flat_map(|gyro| by_stations(&format!("A{gyro}"), 6, |_| ("QA", 0.0))));
    records.extend((0..8).flat_map(|gyro| by_stations(&format!("B{gyro}"), 24, drifts)));
    for answer in lab.imports(&records).await {
        assert_eq!(answer["status"], 201, "{answer}");
    }
    let moved = diagnosis(&lab, "MOVED", "D_I").await;
    let causes: Vec<&Value> = moved["causes"].as_array().unwrap().iter().map(|cause| &cause["cause"]).collect();
    assert!(!causes.is_empty() && causes.iter().all(|cause| **cause == "station"), "{moved}");
    assert!(moved["said"].to_string().contains("QB"), "{moved}");
}

#[tokio::test]
async fn a_station_of_one_gyro_in_a_large_fleet_is_among_the_stations() {
    let lab = Lab::open().await;
    let mut records: Vec<Value> =
        (0..610).flat_map(|gyro| by_stations(&format!("A{gyro}"), 1, |_| ("BUSY", 0.0))).collect();
    records.extend(by_stations("R1", 6, |_| ("RARE-1", 0.0)));
    records.extend(by_stations("R2", 6, |_| ("RARE-2", 0.0)));
    for answer in lab.imports(&records).await {
        assert_eq!(answer["status"], 201, "{answer}");
    }
    let stations = lab.get("/v1/stations").await.ok()["stations"].as_array().unwrap().clone();
    let seen: Vec<(&str, &Value)> =
        stations.iter().map(|one| (one["name"].as_str().unwrap(), &one["records"])).collect();
    assert_eq!(seen.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["BUSY", "RARE-1", "RARE-2"]);
    assert!(*seen[1].1 == 6 && *seen[2].1 == 6 && seen[0].1.as_u64().unwrap() >= 100, "{seen:?}");
    assert_eq!(lab.get("/v1/stations/RARE-2").await.ok()["records"], 6);
}
