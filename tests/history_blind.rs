//! Fleets with a hidden cause, sent as records and asked for over HTTP: the answer is that of the blind check.

mod lab;

use gyrowatch::blindcheck::history::draw::{Draw, Fleet, Kind};
use gyrowatch::core::changes::{GyroHistory, diagnose_history};
use gyrowatch::core::mounting::Geometry;
use gyrowatch::wire::time;
use lab::Lab;
use serde_json::{Value, json};

/// Pulses per arcsecond.
const SCALE: f64 = 1.4676;

fn serial(gyro: usize) -> String {
    format!("GYRO-{gyro:02}")
}

/// The records of a fleet, an IMU's three gyros in each.
fn records(fleet: &Fleet) -> Vec<Value> {
    let mut all = Vec::new();
    for (imu, gyros) in fleet.gyros.chunks(3).enumerate() {
        for k in 0..gyros[0].entries.len() {
            let of_slot = |slot: usize| {
                let entry = &gyros[slot].entries[k];
                let triad = Geometry::Skewed.triad(entry.slot).expect("skewed names every slot");
                let [d_i, d_s, d_o] = entry.d.map(|figure| figure.value);
                let e: [f64; 3] = (triad.input() * SCALE).into();
                let g: [f64; 3] = ((triad.input() * d_i + triad.spin() * d_s + triad.output() * d_o) * SCALE).into();
                let (e_sd, g_sd) = ([0.0; 3], [entry.d[0].sd.expect("stated") * SCALE; 3]);
                json!({"slot": entry.slot.name(), "serial": serial(3 * imu + slot), "e_pulse_per_arcsec": e,
                    "g_pulse_per_s_g0": g, "e_sd": e_sd, "g_sd": g_sd})
            };
            let entry = &gyros[0].entries[k];
            let mut record = json!({"imu": &*entry.imu, "station": &*entry.station, "geometry": "skewed",
                "calibrated_at": time::format(entry.at), "gyros": (0..3).map(of_slot).collect::<Vec<_>>()});
            if let Some(temperature) = entry.temperature_c {
                record["temperature_c"] = temperature.into();
            }
            all.push(record);
        }
    }
    all.sort_by_key(|record| record["calibrated_at"].as_str().map(str::to_owned));
    all
}

#[tokio::test]
async fn the_service_answers_what_the_blind_check_scores() {
    let kinds =
        [Kind::Ageing, Kind::StationRelevelled, Kind::OneOfTwoDrifts, Kind::TemperatureMissing, Kind::LoneImuMoved];
    for (number, kind) in kinds.into_iter().enumerate() {
        let fleet = Draw::of(2026, number as u64).fleet(kind);
        let lab = Lab::open().await;
        for answer in lab.imports(&records(&fleet)).await {
            assert_eq!(answer["status"], 201, "{kind:?}: {answer}");
        }
        let answer = lab.get(&format!("/v1/gyros/{}/diagnosis", serial(fleet.asked))).await.ok();
        let others: Vec<&GyroHistory> =
            fleet.gyros.iter().enumerate().filter(|(g, _)| *g != fleet.asked).map(|(_, gyro)| gyro).collect();
        let scored = &diagnose_history(&fleet.gyros[fleet.asked], &others, [None; 3])[fleet.column];
        let over_http = &answer["coefficients"][fleet.column];
        assert_eq!(over_http["verdict"], scored.verdict.name(), "{kind:?}: {over_http}");
        let causes = over_http["causes"].as_array().unwrap();
        assert_eq!(causes.len(), scored.causes.len(), "{kind:?}: {over_http}");
        for (answered, scored) in causes.iter().zip(&scored.causes) {
            assert_eq!(answered["cause"], scored.cause, "{kind:?}: {over_http}");
            assert_eq!(answered["class"], json!(scored.class), "{kind:?}: {over_http}");
            let value = answered["estimates"][0]["value"].as_f64().unwrap();
            assert!((value - scored.estimate.value).abs() < 0.02 * scored.estimate.sd, "{kind:?}: {over_http}");
        }
        assert!(
            causes.iter().any(|cause| fleet.truth.contains(&cause["cause"].as_str().unwrap())),
            "{kind:?}: {over_http}"
        );
    }
}
