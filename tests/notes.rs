//! What is noted about a record beside what is known of its IMU and gyros: nothing where there is nothing, each kind
//! where it was put in; and records whose time is in doubt, which count when somebody has confirmed it.

use crate::command::verified;
use crate::lab::{self, verdict};
use crate::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// The codes of an answer's notes, in order.
fn codes(answer: &Value) -> Vec<&str> {
    answer["notes"].as_array().into_iter().flatten().map(|note| note["code"].as_str().unwrap()).collect()
}

#[track_caller]
fn noted<'a>(answer: &'a Value, code: &str) -> &'a Value {
    let notes = answer["notes"].as_array().unwrap();
    notes.iter().find(|note| note["code"] == code).unwrap_or_else(|| panic!("no {code}: {answer}"))
}

/// A gyro of a made-up fleet.
#[derive(Clone)]
struct Unit {
    serial: String,
    d: [f64; 2],
    scale: f64,
}

const SLOTS: [&str; 3] = ["G1", "G2", "G3"];
fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

fn unit(serial: String, rng: &mut ChaCha8Rng) -> Unit {
    // One in ten is nearly balanced.
    let size = if rng.random_bool(0.1) { 0.05 } else { 8.0 };
    let mut d = || size * (2.0 * rng.random::<f64>() - 1.0);
    Unit { serial, d: [d(), d()], scale: 1.2 + 0.4 * rng.random::<f64>() }
}

/// A record of units in their slots, with noise.
fn measured(imu: &str, at: &str, units: &[Unit], rng: &mut ChaCha8Rng) -> Value {
    let mut noise = || 5e-4 * Distribution::<f64>::sample(&StandardNormal, rng);
    let noisy: Vec<(f64, f64)> = units.iter().map(|unit| (unit.d[0] + noise(), unit.d[1] + noise())).collect();
    let made: Vec<lab::Made<'_>> = SLOTS
        .iter()
        .zip(units)
        .zip(&noisy)
        .map(|((slot, unit), (d_i, d_s))| (*slot, unit.serial.as_str(), *d_i, *d_s))
        .collect();
    let mut record = record(imu, at, &made);
    for (gyro, unit) in record["gyros"].as_array_mut().unwrap().iter_mut().zip(units) {
        // |E| of the laboratory's gyros is 1.4676; D, which is G/|E|, stays.
        scaled(gyro, "e_pulse_per_arcsec", unit.scale / 1.4676);
        scaled(gyro, "g_pulse_per_s_g0", unit.scale / 1.4676);
    }
    record
}

fn scaled(gyro: &mut Value, member: &str, factor: f64) {
    for value in gyro[member].as_array_mut().unwrap() {
        *value = (value.as_f64().unwrap() * factor).into();
    }
}

/// An IMU of three units, and a service that has `records` of it, ten days apart.
async fn with_history(seed: u64, records: i64) -> (Lab, Vec<Unit>, ChaCha8Rng) {
    let (lab, mut rng) = (Lab::open().await, rng(seed));
    let mut units: Vec<Unit> = (0..3).map(|i| unit(format!("LFG-{seed}0{i}"), &mut rng)).collect();
    // Well apart, and large enough to be told from others.
    for (i, unit) in units.iter_mut().enumerate() {
        unit.d = [2.0 + i as f64 + rng.random::<f64>(), -4.0 + 1.5 * i as f64 + rng.random::<f64>()];
    }
    for k in 0..records {
        let answer = lab.posts(&measured("IMU-1", &day(10 * k), &units, &mut rng)).await;
        assert_eq!(codes(&answer), [""; 0], "{answer}");
    }
    (lab, units, rng)
}

#[tokio::test]
async fn a_fleet_to_which_only_what_happens_happens_has_no_note_but_its_moves() {
    const IMUS: usize = 67;
    let (lab, mut rng) = (Lab::open().await, rng(7));
    let mut fleet: Vec<Vec<Unit>> =
        (0..IMUS).map(|imu| (0..3).map(|i| unit(format!("LFG-{:04}", 3 * imu + i), &mut rng)).collect()).collect();
    let (mut moves, mut found) = (0, Vec::new());
    for round in 0..20 {
        let mut events = Vec::new();
        if round > 0 {
            for units in &mut fleet {
                // A step, mostly of a budget or two, seldom of fifty.
                if rng.random_bool(0.1) {
                    units[rng.random_range(0..3)].d[0] +=
                        *[0.015, -0.02, 0.03, 0.5].get(rng.random_range(0..4)).unwrap();
                }
                // An overhaul of all three.
                if rng.random_bool(0.03) {
                    for one in units {
                        one.d = unit(String::new(), &mut rng).d;
                        events.push(one.serial.clone());
                    }
                }
            }
            // Two gyros of different IMUs change places.
            for _ in 0..2 {
                let (a, b) = (rng.random_range(0..IMUS), rng.random_range(0..IMUS));
                let slot = rng.random_range(0..3);
                if a != b {
                    let other = fleet[b][slot].clone();
                    fleet[b][slot] = std::mem::replace(&mut fleet[a][slot], other);
                    moves += 2;
                }
            }
        }
        for serial in events {
            let repair = json!({"event": "repair", "reason": "overhaul", "at": day(15 * round - 5)});
            assert_eq!(lab.post(&format!("/v1/gyros/{serial}/events"), &repair).await.status, 201);
        }
        let documents: Vec<Value> = fleet
            .iter()
            .enumerate()
            .map(|(imu, units)| measured(&format!("IMU-{imu:02}"), &day(15 * round), units, &mut rng))
            .collect();
        for line in lab.imports(&documents).await {
            assert_eq!(line["status"], 201, "{line}");
            found.extend(codes(&line).into_iter().map(str::to_owned));
        }
    }
    let wrong: Vec<&String> = found.iter().filter(|code| *code != "moved").collect();
    assert_eq!(wrong, [""; 0], "of 4020 figures");
    // A pair that changed back in the same round was nowhere else in its last record.
    assert!(found.len() <= moves && found.len() + 4 >= moves, "{} of {moves} moves", found.len());
}

#[tokio::test]
async fn exchanged_serials_are_noted_with_whose_figures_they_have() {
    for (seed, apart, order) in
        [(1, 5.0, [1, 0, 2]), (2, 0.2, [1, 0, 2]), (3, 0.05, [0, 2, 1]), (4, 3.0, [1, 2, 0]), (5, -0.5, [2, 1, 0])]
    {
        let (lab, mut units, mut rng) = with_history(seed, 0).await;
        units[1].d = [units[0].d[0] + apart, units[0].d[1] - apart];
        units[2].d = [units[0].d[0] - apart, units[0].d[1] + 2.0 * apart];
        for k in 0..4 {
            assert_eq!(codes(&lab.posts(&measured("IMU-1", &day(10 * k), &units, &mut rng)).await), [""; 0]);
        }
        let mut record = measured("IMU-1", &day(50), &units, &mut rng);
        for (gyro, other) in order.iter().enumerate() {
            record["gyros"][gyro]["serial"] = units[*other].serial.clone().into();
        }
        let answer = lab.posts(&record).await;
        let fits = noted(&answer, "serials_exchanged")["fits"].as_array().unwrap().clone();
        let expected: Vec<Value> = order
            .iter()
            .enumerate()
            .filter(|(gyro, other)| gyro != *other)
            .map(|(gyro, other)| json!({"serial": units[*other].serial, "figures_of": units[gyro].serial}))
            .collect();
        assert_eq!(fits, expected, "seed {seed}");
        assert_eq!(codes(&answer), ["serials_exchanged"], "that they changed slots is the same slip");
        // As it was answered, so it is read; the record before has none.
        let read = lab.get(&format!("/v1/records/{}", answer["id"].as_str().unwrap())).await.ok();
        assert_eq!(read["notes"], answer["notes"]);
        // A second one alike is no confirmation, and what is right again has no note.
        for (k, is_exchanged) in [(60, true), (70, false)] {
            let mut record = measured("IMU-1", &day(k), &units, &mut rng);
            if is_exchanged {
                for (gyro, other) in order.iter().enumerate() {
                    record["gyros"][gyro]["serial"] = units[*other].serial.clone().into();
                }
            }
            let again = lab.posts(&record).await;
            if is_exchanged {
                assert_eq!(noted(&again, "serials_exchanged")["fits"].as_array().unwrap(), &expected, "seed {seed}");
            } else {
                assert!(codes(&again).iter().all(|code| *code == "moved"), "seed {seed}: {again}");
            }
        }
    }
}

#[tokio::test]
async fn gyros_that_really_change_slots_have_moved_and_nothing_else() {
    let (lab, mut units, mut rng) = with_history(6, 4).await;
    units.swap(0, 1);
    let answer = lab.posts(&measured("IMU-1", &day(50), &units, &mut rng)).await;
    assert_eq!(codes(&answer), ["moved", "moved"]);
    let moved = noted(&answer, "moved");
    assert_eq!(moved["from"], json!({"imu": "IMU-1", "slot": "G2"}));
    assert_eq!(moved["to"], json!({"imu": "IMU-1", "slot": "G1"}));
    let elsewhere = lab.posts(&measured("IMU-2", &day(60), &units, &mut rng)).await;
    assert_eq!(codes(&elsewhere), ["moved"; 3]);
    assert_eq!(noted(&elsewhere, "moved")["to"]["imu"], "IMU-2");
}

#[tokio::test]
async fn another_units_figures_are_noted_but_not_after_a_repair() {
    for (seed, shift) in [(11, 0.06), (12, -0.3), (13, 4.0)] {
        let (lab, units, mut rng) = with_history(seed, 5).await;
        let shifted = |by: f64| -> Vec<Unit> {
            units.iter().map(|unit| Unit { d: [unit.d[0] + by, unit.d[1] - 0.7 * by], ..unit.clone() }).collect()
        };
        let two: Vec<Unit> = shifted(shift).into_iter().take(2).chain([units[2].clone()]).collect();
        let of_two = lab.posts(&measured("IMU-1", &day(60), &two, &mut rng)).await;
        assert_eq!(codes(&of_two), [""; 0], "the third is where it was");
        let all = lab.posts(&measured("IMU-1", &day(70), &shifted(-1.6 * shift), &mut rng)).await;
        assert_eq!(codes(&all), ["other_unit"], "seed {seed}");
        let repair = json!({"event": "repair", "reason": "new motor", "at": day(75)});
        lab.post(&format!("/v1/gyros/{}/events", units[1].serial), &repair).await.created();
        let repaired = lab.posts(&measured("IMU-1", &day(80), &shifted(3.0 * shift), &mut rng)).await;
        assert_eq!(codes(&repaired), [""; 0], "seed {seed}");
    }
}

#[tokio::test]
async fn another_gyro_under_the_serial_of_one_is_noted_but_not_after_a_repair() {
    for seed in [31, 32, 33] {
        let (lab, units, mut rng) = with_history(seed, 5).await;
        let mut other = units.clone();
        other[1] =
            Unit { d: [units[1].d[0] - 0.9, units[1].d[1] + 0.4], scale: 1.004 * units[1].scale, ..other[1].clone() };
        let answer = lab.posts(&measured("IMU-1", &day(60), &other, &mut rng)).await;
        assert_eq!(codes(&answer), ["another_gyro"], "seed {seed}");
        assert_eq!(noted(&answer, "another_gyro")["serials"], json!([units[1].serial]));
        // One of the two alone may be the gyro's own doing.
        other[2].d[0] += 0.9;
        other[2].scale *= 1.004;
        assert_eq!(codes(&lab.posts(&measured("IMU-1", &day(70), &other, &mut rng)).await), [""; 0], "seed {seed}");
        let repair = json!({"event": "repair", "reason": "new wheel", "at": day(75)});
        lab.post(&format!("/v1/gyros/{}/events", units[0].serial), &repair).await.created();
        other[0] =
            Unit { d: [units[0].d[0] - 1.9, units[0].d[1] + 1.4], scale: 0.99 * units[0].scale, ..other[0].clone() };
        assert_eq!(codes(&lab.posts(&measured("IMU-1", &day(80), &other, &mut rng)).await), [""; 0], "seed {seed}");
    }
}

/// A campaign of five hours, of gyros that have this number in their serials.
fn five_hours(imu: &str, gyros: i64, measured_at: &str) -> Value {
    let mut campaign = lab::at(document("practice/campaign-00.json"), measured_at);
    campaign["imu"] = imu.into();
    for (slot, gyro) in campaign["gyros"].as_array_mut().unwrap().iter_mut().enumerate() {
        gyro["serial"] = format!("LFG-{gyros}-{slot}").into();
    }
    // Other data.
    for dwell in campaign["dwells"].as_array_mut().unwrap() {
        for output in dwell["output_pulse_s"].as_array_mut().unwrap() {
            *output =
                (output.as_f64().unwrap() * (1.0 + 1e-9 * measured_at.bytes().map(f64::from).sum::<f64>())).into();
        }
    }
    campaign
}

#[tokio::test]
async fn campaigns_and_bench_tests_of_one_gyro_at_the_same_time_are_noted_in_either_order() {
    let mut lab = Lab::open().await;
    let at = |hour: i64| format!("2026-03-{:02}T{:02}:00:00Z", 1 + hour / 24, hour % 24);
    let posts = async |lab: &Lab, sent: &Value| lab.post("/v1/campaigns", sent).await.created();
    let overlaps = |answer: &Value| -> Vec<Value> {
        let notes = answer["notes"].as_array().unwrap().iter().filter(|note| note["code"] == "overlaps_in_time");
        notes.map(|note| note["record"].clone()).collect()
    };
    let first = posts(&lab, &five_hours("IMU-1", 1, &at(48))).await;
    assert_eq!(overlaps(&first), [json!(null); 0]);
    let within = posts(&lab, &five_hours("IMU-1", 1, &at(50))).await;
    assert_eq!(overlaps(&within), [first["id"].clone()]);
    assert_eq!(noted(&within, "overlaps_in_time")["serials"], json!(["LFG-1-0", "LFG-1-1", "LFG-1-2"]));
    // What is stored says it, too, and what is not remembered is read.
    let stored = lab.get(&format!("/v1/campaigns/{}", within["id"].as_str().unwrap())).await.ok();
    assert_eq!(overlaps(&stored), [first["id"].clone()]);
    lab.restart().await;
    let sooner = posts(&lab, &five_hours("IMU-1", 1, &at(44))).await;
    assert_eq!(overlaps(&sooner), [first["id"].clone()], "it ends after the first has begun");
    for apart in [60, 30] {
        assert_eq!(overlaps(&posts(&lab, &five_hours("IMU-1", 1, &at(apart))).await), [json!(null); 0], "{apart}");
    }
    // In another IMU.
    let elsewhere = posts(&lab, &five_hours("IMU-2", 1, &at(63))).await;
    assert_eq!(overlaps(&elsewhere).len(), 1);
    // A finished calibration has no length.
    let mut finished = record("IMU-3", &at(80), &[("G1", "LFG-3-0", 1.0, 2.0)]);
    finished["station"] = first["station"].clone();
    lab.posts(&finished).await;
    assert_eq!(overlaps(&posts(&lab, &five_hours("IMU-3", 3, &at(78))).await), [json!(null); 0]);

    // One of its gyros on a bench, which is known by its own dwells.
    let bench = |serial: &str, measured_at: &str| {
        let mut bench = five_hours("FX-1", 9, measured_at);
        bench["test"] = "torque_feedback".into();
        bench["geometry"] = json!({"input": [1, 0, 0], "spin": [0, 1, 0]});
        bench["gyros"] = json!([{"serial": serial, "known_e_pulse_per_arcsec": [1.4676, 0.0, 0.0]}]);
        let is_static = |dwell: &Value| dwell["phase"] == "static";
        bench["dwells"].as_array_mut().unwrap().retain(is_static);
        for dwell in bench["dwells"].as_array_mut().unwrap() {
            let (force, rate) = (dwell["specific_force_g0"].clone(), dwell["rate_arcsec_s"].clone());
            let [a_i, a_s, w] = [&force[0], &force[1], &rate[0]].map(|x| x.as_f64().unwrap());
            dwell["output_pulse_s"] = json!([1.4676 * (w + 0.4 + 2.0 * a_i - 3.0 * a_s)]);
            dwell["output_sem_pulse_s"] = json!([1e-3]);
        }
        bench
    };
    let fourth = posts(&lab, &five_hours("IMU-4", 4, &at(120))).await;
    let tested = posts(&lab, &bench("LFG-4-1", &at(121))).await;
    assert_eq!(overlaps(&tested), [fourth["id"].clone()], "{tested}");
    assert_eq!(overlaps(&posts(&lab, &bench("LFG-4-1", &at(140))).await), [json!(null); 0]);
    let fifth = posts(&lab, &bench("LFG-5-1", &at(160))).await;
    lab.posts(&record("IMU-5", &at(10), &[("G2", "LFG-5-1", 1.0, 2.0)])).await;
    let later = posts(&lab, &five_hours("IMU-5", 5, &at(158))).await;
    assert_eq!(overlaps(&later), [fifth["id"].clone()]);
}

#[tokio::test]
async fn wrong_units_are_noted_with_the_factor() {
    const E: &str = "e_pulse_per_arcsec";
    const G: &str = "g_pulse_per_s_g0";
    let cases: [(&[(&str, f64)], &[(&str, f64, &str)]); 13] = [
        (&[(E, 60.0)], &[("E", 60.0, "pulse/arcmin")]),
        (&[(E, 1.0 / 60.0)], &[("E", 1.0 / 60.0, "another")]),
        (&[(E, 9.80665)], &[("E", 9.80665, "another")]),
        (&[(G, 60.0)], &[("G", 60.0, "pulse/(min g0)")]),
        (&[(G, 9.80665)], &[("G", 9.80665, "another")]),
        (&[(G, 1.0 / 9.80665)], &[("G", 1.0 / 9.80665, "pulse/(s m/s^2)")]),
        (&[(G, 1.0 / 3600.0)], &[("G", 1.0 / 3600.0, "deg/(s g0)")]),
        (&[(G, 1.0 / 206264.8)], &[("G", 1.0 / 206264.8, "rad/s")]),
        (&[(E, 60.0), (G, 60.0)], &[("E", 60.0, "pulse/arcmin"), ("G", 60.0, "pulse/(min g0)")]),
        (&[(E, 180.0), (G, 180.0)], &[("E", 180.0, "another"), ("G", 180.0, "another")]),
        (&[(G, -1.0)], &[("G", -1.0, "opposite sign")]),
        (&[(G, 2.0)], &[("G", 2.0, "another")]),
        (&[(E, 2.0)], &[("E", 2.0, "another")]),
    ];
    for (seed, (wrong, expected)) in cases.into_iter().enumerate() {
        let (mut lab, units, mut rng) = with_history(20 + seed as u64, 3).await;
        let mut record = measured("IMU-1", &day(50), &units, &mut rng);
        for gyro in record["gyros"].as_array_mut().unwrap() {
            wrong.iter().for_each(|(member, factor)| scaled(gyro, member, *factor));
        }
        let answer = lab.posts(&record).await;
        record["calibrated_at"] = day(60).into();
        scaled(&mut record["gyros"][0], "g_pulse_per_s_g0", 1.0 + 1e-9);
        let again = lab.posts(&record).await;
        let of_units = codes(&again).into_iter().filter(|code| *code == "unit_factor").count();
        assert_eq!(of_units, expected.len(), "a second one alike: {again}");
        assert_eq!(codes(&answer), vec!["unit_factor"; expected.len()], "{wrong:?}: {}", answer["notes"]);
        for (note, (quantity, factor, words)) in answer["notes"].as_array().unwrap().iter().zip(expected) {
            assert_eq!(note["quantity"], *quantity);
            let tolerance = if [180.0, 2.0].contains(factor) { 1e-2 } else { 1e-5 };
            assert!((note["factor"].as_f64().unwrap() / factor - 1.0).abs() < tolerance, "{note}");
            assert!(note["detail"].as_str().unwrap().contains(words), "{note}");
            assert_eq!(note["serials"].as_array().unwrap().len(), 3);
        }
        lab.stop().await;
    }
}

#[tokio::test]
async fn stated_uncertainties_in_another_unit_are_noted() {
    let (lab, units, mut rng) = with_history(41, 0).await;
    let stating = |at: i64, factors: [f64; 3], rng: &mut ChaCha8Rng| {
        let mut record = measured("IMU-1", &day(at), &units, rng);
        for (gyro, factor) in record["gyros"].as_array_mut().unwrap().iter_mut().zip(factors) {
            (gyro["g_sd"], gyro["e_sd"]) = (vec![4e-4 * factor; 3].into(), vec![2e-6; 3].into());
        }
        record
    };
    for k in 0..4 {
        // A method that is three times as exact is no other unit.
        let factor = [1.0, 3.0][k as usize % 2];
        assert_eq!(codes(&lab.posts(&stating(10 * k, [factor; 3], &mut rng)).await), [""; 0]);
    }
    let answer = lab.posts(&stating(50, [1000.0, 1.0, 1.0], &mut rng)).await;
    assert_eq!(codes(&answer), ["uncertainty_factor"]);
    let note = noted(&answer, "uncertainty_factor");
    assert_eq!(note["serials"], json!([units[0].serial]));
    let factor = note["factor"].as_f64().unwrap();
    assert!((300.0..1100.0).contains(&factor), "{note}");
    let smaller = lab.posts(&stating(60, [1.0, 1.0, 1e-3], &mut rng)).await;
    assert!(noted(&smaller, "uncertainty_factor")["factor"].as_f64().unwrap() < 1.0 / 30.0, "{smaller}");
    // What G is multiplied by, its standard deviation is too: one note.
    let mut minutes = stating(70, [60.0; 3], &mut rng);
    minutes["gyros"].as_array_mut().unwrap().iter_mut().for_each(|gyro| scaled(gyro, "g_pulse_per_s_g0", 60.0));
    assert_eq!(codes(&lab.posts(&minutes).await), ["unit_factor"]);
}

#[tokio::test]
async fn one_gyros_g_that_was_divided_by_its_scale_factor_is_noted() {
    let (lab, mut units, mut rng) = with_history(42, 0).await;
    units[1].scale = 1.5;
    for k in 0..5 {
        assert_eq!(codes(&lab.posts(&measured("IMU-1", &day(10 * k), &units, &mut rng)).await), [""; 0]);
    }
    let sent = |at: i64, factor: f64, rng: &mut ChaCha8Rng| {
        let mut record = measured("IMU-1", &day(at), &units, rng);
        scaled(&mut record["gyros"][1], "g_pulse_per_s_g0", factor);
        record
    };
    // Divided by its scale factor already: in deg/(h g0).
    let scale = units[1].scale;
    for (at, factor, words) in [(60, scale.recip(), "is it in deg/(h g0)?"), (80, scale, "is it in another unit?")] {
        let answer = lab.posts(&sent(at, factor, &mut rng)).await;
        assert_eq!(codes(&answer), ["unit_factor"], "{factor}");
        let note = noted(&answer, "unit_factor");
        assert_eq!((&note["quantity"], &note["serials"]), (&json!("G"), &json!([units[1].serial])));
        assert!((note["factor"].as_f64().unwrap() / factor - 1.0).abs() < 0.02, "{note}");
        assert!(note["detail"].as_str().unwrap().contains(words), "{note}");
        assert_eq!(codes(&lab.posts(&sent(at + 10, 1.0, &mut rng)).await), [""; 0], "the next one is good");
    }
    // Seven is no unit's factor: whatever made one gyro drift so, it is not said to be one.
    assert_eq!(codes(&lab.posts(&sent(100, 7.0, &mut rng)).await), [""; 0]);
}

/// So is that of all of them, however near to 1 their scale factors are.
#[tokio::test]
async fn the_g_of_all_gyros_that_was_divided_by_their_scale_factors_names_the_unit() {
    let (lab, mut units, mut rng) = with_history(44, 0).await;
    let scales = [1.08, 1.2, 1.5];
    units.iter_mut().zip(scales).for_each(|(unit, scale)| unit.scale = scale);
    for k in 0..5 {
        assert_eq!(codes(&lab.posts(&measured("IMU-1", &day(10 * k), &units, &mut rng)).await), [""; 0]);
    }
    let mut record = measured("IMU-1", &day(60), &units, &mut rng);
    for (gyro, scale) in record["gyros"].as_array_mut().unwrap().iter_mut().zip(scales) {
        scaled(gyro, "g_pulse_per_s_g0", scale.recip());
    }
    let answer = lab.posts(&record).await;
    assert_eq!(codes(&answer), ["unit_factor"; 3], "{answer}");
    for (note, unit) in answer["notes"].as_array().unwrap().iter().zip(&units) {
        assert_eq!(note["serials"], json!([unit.serial]), "{note}");
        assert!((note["factor"].as_f64().unwrap() * unit.scale - 1.0).abs() < 0.01, "{note}");
        assert!(note["detail"].as_str().unwrap().contains("is it in deg/(h g0)?"), "{note}");
    }
}

#[tokio::test]
async fn the_same_figures_with_another_time_name_the_record_they_are_identical_to() {
    let (lab, units, mut rng) = with_history(31, 3).await;
    let first = measured("IMU-1", &day(40), &units, &mut rng);
    let stored = lab.posts(&first).await;
    let later = lab.posts(&measured("IMU-1", &day(50), &units, &mut rng)).await;
    assert_eq!(codes(&later), [""; 0]);
    let mut again = first.clone();
    for (at, restart) in [(day(60), false), (day(45), false), (day(70), true)] {
        again["calibrated_at"] = at.as_str().into();
        let answer = lab.posts(&again).await;
        assert_eq!(codes(&answer), ["identical_figures"], "{at} {restart}");
        let note = noted(&answer, "identical_figures");
        assert_eq!(note["serials"].as_array().unwrap().len(), 3);
        if at == day(60) {
            assert_eq!((&note["record"], &note["calibrated_at"]), (&stored["id"], &first["calibrated_at"]));
        }
    }
    // A last digit more, and it is another measurement.
    let mut other = first.clone();
    other["calibrated_at"] = day(80).into();
    for gyro in other["gyros"].as_array_mut().unwrap() {
        scaled(gyro, "g_pulse_per_s_g0", 1.0 + 1e-9);
    }
    assert_eq!(codes(&lab.posts(&other).await), [""; 0]);
}

#[tokio::test]
async fn histories_are_known_after_a_restart_too() {
    let (mut lab, units, mut rng) = with_history(32, 3).await;
    let first = measured("IMU-1", &day(40), &units, &mut rng);
    lab.posts(&first).await;
    lab.restart().await;
    let mut again = first.clone();
    again["calibrated_at"] = day(50).into();
    assert_eq!(codes(&lab.posts(&again).await), ["identical_figures"]);
    lab.restart().await;
    let mut minutes = measured("IMU-1", &day(60), &units, &mut rng);
    minutes["gyros"].as_array_mut().unwrap().iter_mut().for_each(|gyro| scaled(gyro, "g_pulse_per_s_g0", 60.0));
    assert_eq!(codes(&lab.posts(&minutes).await), ["unit_factor"]);
}

#[tokio::test]
async fn a_new_serial_in_a_slot_names_who_was_there_and_the_nearest_known() {
    let lab = Lab::open().await;
    let gyros = |first: &str, k: f64| {
        record("IMU-1", &day(k as i64), &[("G1", first, 2.0 + 1e-4 * k, 1.0), ("G2", "LFG-0205", 3.0 + 1e-4 * k, -1.0)])
    };
    let fresh = lab.posts(&gyros("LFG-0101", 0.0)).await;
    assert_eq!(codes(&fresh), [""; 0], "an IMU that is new itself has new serials");
    for (k, (serial, nearest, alike)) in [
        ("LFG-O101", Some("LFG-0101"), true),
        ("LFG-0l01", Some("LFG-0101"), true),
        ("LFG-\u{41e}101", Some("LFG-0101"), true),
        ("lfg 0101", Some("LFG-0101"), true),
        ("LFG-0110", Some("LFG-0101"), false),
        ("QX-77", None, false),
    ]
    .into_iter()
    .enumerate()
    {
        // What is slipped into the slot goes again.
        let at = 20.0 * k as f64 + 10.0;
        let answer = lab.posts(&gyros(serial, at)).await;
        let expected: &[&str] = if alike { &["look_alike", "new_serial"] } else { &["new_serial"] };
        assert_eq!(codes(&answer), expected, "{serial}");
        let note = noted(&answer, "new_serial");
        assert_eq!(note["had"], "LFG-0101");
        assert_eq!(note["nearest"].as_str(), nearest, "{serial}");
        assert_eq!(codes(&lab.posts(&gyros("LFG-0101", at + 10.0)).await), [""; 0]);
    }
    let mut elsewhere = record("IMU-I", &day(200), &[("G1", "NEW-1", 2.0, 1.0)]);
    elsewhere["station"] = "st-1".into();
    let answer = lab.posts(&elsewhere).await;
    assert_eq!(codes(&answer), ["look_alike", "look_alike"]);
    assert_eq!((&answer["notes"][0]["of"], &answer["notes"][0]["known"]), (&json!("imu"), &json!("IMU-1")));
    assert_eq!((&answer["notes"][1]["of"], &answer["notes"][1]["known"]), (&json!("station"), &json!("ST-1")));
    let mut spelt = record("IMU1", &day(250), &[("G1", "NEW-2", 2.0, 1.0)]);
    spelt["station"] = "ST-1".into();
    let answer = lab.posts(&spelt).await;
    assert_eq!((codes(&answer), &answer["notes"][0]["of"]), (vec!["look_alike"], &json!("imu")));
    // Within one import, where nothing is stored before the next line is looked at.
    let two = [("S0", 300), ("SO", 310)].map(|(serial, at)| record("A-1", &day(at), &[("G1", serial, 2.0, 1.0)]));
    assert_eq!(codes(&lab.imports(&two).await[1]), ["look_alike", "new_serial"]);
}

#[tokio::test]
async fn a_time_ahead_of_the_clock_is_noted() {
    let lab = Lab::open().await;
    let of = |at: &str, d: f64| record("IMU-1", at, &[("G1", "A", d, 1.0)]);
    assert_eq!(codes(&lab.posts(&of("2026-11-21T12:05:00Z", 2.0)).await), [""; 0], "clocks differ by minutes");
    let ahead = lab.posts(&of("2026-11-21T15:00:00Z", 2.001)).await;
    assert_eq!(codes(&ahead), ["ahead_of_now"]);
    assert_eq!(noted(&ahead, "ahead_of_now")["hours"], 3.0);
    assert_eq!(lab.post("/v1/records", &of("2026-11-23T12:00:00Z", 2.0)).await.refused(422), ["/calibrated_at"]);
}

#[tokio::test]
async fn a_year_that_makes_a_record_old_and_another_that_makes_it_the_newest_is_asked_about() {
    let lab = Lab::open().await;
    let of = |at: &str, d: f64| record("IMU-1", at, &[("G1", "A", d, 1.0)]);
    for (k, at) in ["2025-05-20T08:00:00Z", "2026-09-20T08:00:00Z", "2026-10-20T08:00:00Z"].into_iter().enumerate() {
        assert_eq!(codes(&lab.posts(&of(at, 2.0 + 1e-4 * k as f64)).await), [""; 0], "{at}");
    }
    let slipped = lab.posts(&of("2025-11-20T08:00:00Z", 2.0005)).await;
    assert_eq!(codes(&slipped), ["year_in_doubt"]);
    assert_eq!(noted(&slipped, "year_in_doubt")["year"], 2026);
    assert_eq!(codes(&lab.posts(&of("2025-08-20T08:00:00Z", 2.0006)).await), [""; 0], "a late record of another day");
}

/// A record of one gyro, whose figures follow from a number.
fn of_m2(at: &str, k: i64, d: f64) -> Value {
    record("IMU-M2", at, &[("G1", "M2", d + 1e-5 * k as f64, 1.0)])
}

async fn trend(lab: &Lab) -> Vec<Value> {
    lab.sees_trend("M2", "coefficient=D_I").await
}

#[tokio::test]
async fn a_clock_that_counts_from_1970_is_refused_with_the_way_out() {
    let lab = Lab::open().await;
    for at in ["1970-01-01T00:00:12Z", "1969-12-31T20:00:00Z", "1970-11-05T08:00:00Z"] {
        let refused = lab.post("/v1/records", &of_m2(at, 0, 2.0)).await;
        assert_eq!(refused.refused(422), ["/calibrated_at"]);
        assert!(refused.text.contains("set the station's clock") && refused.text.contains("plausibility.clock_epochs"));
    }
    assert_eq!(lab.post("/v1/bench-results", &lab::bench("M2", "1970-01-01T00:00:12Z", 1.0, 2.0)).await.status, 422);
    let open = Lab::with(|config| config.plausibility.clock_epochs.clear()).await;
    assert_eq!(codes(&open.posts(&of_m2("1970-01-01T00:00:12Z", 0, 2.0)).await), [""; 0]);
    assert_eq!(codes(&open.posts(&of_m2("1971-06-01T00:00:00Z", 1, 2.0)).await), [""; 0]);
}

#[tokio::test]
async fn false_times_never_become_the_baseline_in_either_order() {
    let right: Vec<Value> = (0..4).map(|k| of_m2(&format!("2026-0{}-01T08:00:00Z", k + 1), k, 2.0)).collect();
    // Far from the right level: as a baseline they would make every right record exceed it.
    let false_times =
        |times: [&str; 3]| -> Vec<Value> { (0..3).map(|k| of_m2(times[k as usize], 10 + k, 3.0)).collect() };
    for times in [
        ["2000-01-01T00:00:12Z", "2000-01-01T00:01:12Z", "2000-01-02T00:00:00Z"],
        ["1980-01-01T00:00:12Z", "1980-01-06T00:00:12Z", "1980-02-01T00:00:00Z"],
        // A receiver that has miscounted its weeks, 1024 of them.
        ["2006-05-15T08:00:00Z", "2006-06-15T08:00:00Z", "2006-07-15T08:00:00Z"],
    ] {
        for (order, batches) in [
            ("false first, one by one", 0),
            ("false first, one import", 1),
            ("right first", 2),
            ("right first, one import", 3),
        ] {
            let lab = Lab::open().await;
            let wrong = false_times(times);
            let (first, second) = if batches < 2 { (&wrong, &right) } else { (&right, &wrong) };
            if batches % 2 == 0 {
                for record in first.iter().chain(second) {
                    assert_eq!(lab.post("/v1/records", record).await.status, 201);
                }
            } else {
                let all: Vec<Value> = first.iter().chain(second).cloned().collect();
                assert!(lab.imports(&all).await.iter().all(|line| line["status"] == 201));
            }
            let counting = trend(&lab).await;
            let times: Vec<&str> =
                counting.iter().map(|point| &point["calibrated_at"].as_str().unwrap()[..4]).collect();
            assert_eq!(times, ["2026"; 4], "{order}");
            let newest = lab.get(&format!("/v1/records/{}", counting[3]["record"].as_str().unwrap())).await.ok();
            for rule in ["step", "baseline", "range"] {
                assert_ne!(verdict(&newest, "M2", "D_I", rule)["state"], "exceeded", "{order}: {rule}");
            }
            assert_eq!(verdict(&newest, "M2", "D_I", "baseline")["state"], "within", "{order}");
            assert_eq!(lab.get("/v1/alerts?state=firing").await.ok()["alerts"].as_array().unwrap().len(), 0, "{order}");
            let all = lab.sees_trend("M2", "coefficient=D_I&voided=include").await;
            let aside: Vec<&Value> = all.iter().filter(|point| point["set_aside"] == true).collect();
            assert_eq!(aside.len(), 3, "{order}");
            for point in aside {
                assert_eq!(point["voided"], true);
                let read = lab.get(&format!("/v1/records/{}", point["record"].as_str().unwrap())).await.ok();
                assert_eq!(read["state"], "set_aside");
                assert_eq!(noted(&read, "time_in_doubt")["set_aside"], true, "{order}");
            }
            verify(lab).await;
        }
    }
}

/// Everything that is stored is as it is computed again.
async fn verify(mut lab: Lab) {
    lab.stop().await;
    if cluster::is_wanted() {
        return;
    }
    verified(&lab.config.database.url);
}

#[tokio::test]
async fn who_confirms_the_time_makes_a_record_count() {
    let mut lab = Lab::open().await;
    let stored = lab.posts(&of_m2("2000-01-05T08:00:00Z", 0, 2.0)).await;
    assert_eq!(codes(&stored), ["time_in_doubt"]);
    assert_eq!(stored["verdicts"].as_array().unwrap().iter().filter(|v| v["rule"] != "requirement").count(), 0);
    assert!(trend(&lab).await.is_empty());
    let id = stored["id"].as_str().unwrap().to_owned();
    let path = format!("/v1/records/{id}/confirm");
    let known = lab.post("/v1/records", &of_m2("2000-01-05T08:00:00Z", 0, 2.0)).await.ok();
    assert_eq!((&known["id"], &known["state"]), (&stored["id"], &json!("set_aside")), "sent again it stays as it is");
    assert_eq!(lab.post(&path, &json!({"by": "", "reason": "x"})).await.refused(422), ["/by"]);
    lab.post("/v1/records/00000000000000000/confirm", &json!({"by": "me", "reason": "x"})).await.refused(404);
    let said = json!({"by": "B. Li", "reason": "the log book says so"});
    let confirmed = lab.post(&path, &said).await.ok();
    assert_eq!((&confirmed["state"], &confirmed["confirmed"]["author"]), (&json!("valid"), &json!("B. Li")));
    assert_eq!(lab.post(&path, &said).await.ok()["id"], confirmed["id"], "and once more");
    let points = trend(&lab).await;
    assert_eq!((points.len(), &points[0]["record"]), (1, &stored["id"]));
    // With it, others of those days are in company; and it is never set aside again.
    assert_eq!(codes(&lab.posts(&of_m2("2000-02-05T08:00:00Z", 1, 2.0)).await), [""; 0]);
    lab.restart().await;
    let read = lab.get(&format!("/v1/records/{id}")).await.ok();
    assert_eq!(read["state"], "valid");
    assert_eq!(verdict(&read, "M2", "D_I", "step")["state"], "indeterminate", "judged as the first of its gyro");
    let others = lab.posts(&of_m2("2026-01-05T08:00:00Z", 2, 2.0)).await;
    assert_eq!(noted(&others, "others_set_aside")["records"].as_array().unwrap().len(), 1, "but for the confirmed one");
    let trail = lab.get("/v1/audit").await;
    assert!(trail.text.contains("confirm") && trail.text.contains("the log book says so"), "{}", trail.text);
    // What counts needs no confirmation, and what was voided is not confirmed.
    lab.post(&format!("/v1/records/{}/confirm", others["id"].as_str().unwrap()), &said).await.refused(409);
    verify(lab).await;
}

#[tokio::test]
async fn what_is_set_aside_can_be_voided_or_revised_and_gives_its_place() {
    let lab = Lab::open().await;
    let first = lab.posts(&of_m2("2000-01-05T08:00:00Z", 0, 2.0)).await;
    let second = lab.posts(&of_m2("2000-01-06T08:00:00Z", 1, 2.0)).await;
    let third = lab.posts(&of_m2("2000-01-07T08:00:00Z", 2, 2.0)).await;
    let id = |answer: &Value| answer["id"].as_str().unwrap().to_owned();
    let said = json!({"author": "B. Li", "reason": "the clock was not set"});
    for answer in [&first, &second, &third] {
        assert_eq!(codes(answer), ["time_in_doubt"], "in the company of what is set aside itself");
    }
    let voided = lab.post(&format!("/v1/records/{}/void", id(&first)), &said).await.ok();
    assert_eq!(voided["state"], "voided");
    let confirmed = json!({"by": "B. Li", "reason": "true"});
    lab.post(&format!("/v1/records/{}/confirm", id(&first)), &confirmed).await.refused(409);
    let revision = json!({"author": "B. Li", "reason": "true time", "record": of_m2("2026-03-06T08:00:00Z", 1, 2.0)});
    let revised = lab.post(&format!("/v1/records/{}/revise", id(&second)), &revision).await.created();
    assert_eq!(codes(&revised), [""; 0]);
    // Another record takes the place of the third, which then cannot be confirmed.
    let mut other = of_m2("2000-01-07T08:00:00Z", 3, 2.5);
    other["note"] = "another".into();
    let fourth = lab.posts(&other).await;
    lab.post(&format!("/v1/records/{}/confirm", id(&fourth)), &confirmed).await.ok();
    lab.post(&format!("/v1/records/{}/confirm", id(&third)), &confirmed).await.refused(409);
    verify(lab).await;
}

#[tokio::test]
async fn confirming_a_record_among_others_judges_again_what_it_alters() {
    let lab = Lab::open().await;
    let aside = lab.posts(&of_m2("2000-01-05T08:00:00Z", 0, 2.5)).await;
    for k in 0..4 {
        lab.posts(&of_m2(&format!("2001-0{}-05T08:00:00Z", k + 6), k, 2.0)).await;
    }
    let newest = trend(&lab).await[3]["record"].as_str().unwrap().to_owned();
    let before = lab.get(&format!("/v1/records/{newest}")).await.ok();
    assert_eq!(verdict(&before, "M2", "D_I", "baseline")["state"], "within");
    let path = format!("/v1/records/{}/confirm", aside["id"].as_str().unwrap());
    lab.post(&path, &json!({"by": "me", "reason": "true"})).await.ok();
    let after = lab.get(&format!("/v1/records/{newest}")).await.ok();
    assert_ne!(before["verdicts"], after["verdicts"], "the baseline has a record more");
    verify(lab).await;
}

#[tokio::test]
async fn names_are_one_however_they_are_written() {
    let lab = Lab::open().await;
    let composed = record("Caf\u{e9}-1", &day(0), &[("G1", "\u{c5}-7", 2.0, 1.0)]);
    let stored = lab.posts(&composed).await;
    let decomposed = record(" Cafe\u{301}-1\u{a0}", &day(0), &[("G1", "\u{212b}-7 ", 2.0, 1.0)]);
    let again = lab.post("/v1/records", &decomposed).await.ok();
    assert_eq!(again["id"], stored["id"], "the same content, however its names are written");
    let second = lab.posts(&record("Cafe\u{301}-1", &day(10), &[("G1", "A\u{30a}-7", 2.001, 1.0)])).await;
    assert_eq!(codes(&second), [""; 0]);
    assert_eq!(second["separations"][0]["serial"], "\u{c5}-7");
    assert_eq!(verdict(&second, "\u{c5}-7", "D_I", "step")["serial"], "\u{c5}-7");
    for path in ["%C3%85-7", "A%CC%8A-7", "%E2%84%AB-7"] {
        let points = lab.get(&format!("/v1/gyros/{path}/trend?coefficient=D_I")).await.ok();
        assert_eq!(points["points"].as_array().unwrap().len(), 2, "{path}");
    }
    let bench = lab.post("/v1/bench-results", &lab::bench("A\u{30a}-7", &day(5), 2.0, 1.0)).await;
    assert_eq!(bench.status, 201);
    let event = json!({"event": "note", "reason": "x", "at": day(5)});
    assert_eq!(lab.post("/v1/gyros/A%CC%8A-7/events", &event).await.status, 201);
    let gyros = lab.get("/v1/gyros").await.ok();
    assert_eq!(gyros["gyros"].as_array().unwrap().len(), 1, "{gyros}");
}

#[tokio::test]
async fn what_nobody_can_see_is_refused_wherever_a_name_comes_in() {
    let lab = Lab::open().await;
    let good = || record("IMU-1", &day(0), &[("G1", "M3", 2.0, 1.0)]);
    for mark in ['\u{200b}', '\u{feff}', '\u{202e}', '\u{ad}', '\u{fe0f}', '\u{e0101}', '\u{2066}', '\u{3164}'] {
        for pointer in ["/imu", "/station", "/gyros/0/serial"] {
            let mut bad = good();
            let name = bad.pointer(pointer).unwrap().as_str().unwrap().to_owned();
            *bad.pointer_mut(pointer).unwrap() = format!("{name}{mark}").into();
            let refused = lab.post("/v1/records", &bad).await;
            assert_eq!(refused.refused(422), [pointer]);
            assert!(refused.text.contains(&format!("U+{:04X}", mark as u32)), "{}", refused.text);
            assert_eq!(lab.imports(&[bad]).await[0]["error"]["errors"][0]["pointer"], pointer);
        }
    }
    assert_eq!(
        lab.post("/v1/bench-results", &lab::bench("M\u{200b}3", &day(0), 1.0, 2.0)).await.refused(422),
        ["/serial"]
    );
    let campaign = include_str!("data/practice/campaign-00.json");
    let mut campaign: Value = serde_json::from_str(campaign).unwrap();
    campaign["gyros"][1]["serial"] = "M\u{200d}3".into();
    assert_eq!(lab.post("/v1/campaigns", &campaign).await.refused(422), ["/gyros/1/serial"]);
}

#[tokio::test]
async fn names_of_earlier_versions_are_found_and_go_on() {
    if cluster::is_wanted() {
        return;
    }
    let mut lab = Lab::open().await;
    let stored = lab.posts(&record("IMU-1", &day(0), &[("G1", "\u{c5}-7", 2.0, 1.0)])).await;
    lab.posts(&record("IMU-2", &day(0), &[("G1", "M3", 2.0, 1.0)])).await;
    lab.stop().await;
    // As an earlier version took them: a decomposed serial, and one with a character of no width.
    {
        let mut file = behind::open(&lab.database()).await;
        for (now, then) in [("\u{c5}-7", "A\u{30a}-7"), ("M3", "M3\u{200b}")] {
            sqlx::query("UPDATE gyro SET serial = $2 WHERE serial = $1")
                .bind(now)
                .bind(then)
                .execute(&mut file)
                .await
                .unwrap();
            let like = format!("%\"{now}\"%");
            let body: String = sqlx::query_scalar("SELECT body FROM record WHERE body LIKE $1")
                .bind(&like)
                .fetch_one(&mut file)
                .await
                .unwrap();
            let body = body.replace(&format!("\"{now}\""), &format!("\"{then}\""));
            // Earlier versions had none.
            sqlx::query("DELETE FROM head").execute(&mut file).await.unwrap();
            sqlx::query("UPDATE head_made SET limits = ''").execute(&mut file).await.unwrap();
            sqlx::query("UPDATE record SET body = $2, body_sha256 = $3 WHERE body LIKE $1")
                .bind(like)
                .bind(&body)
                .bind(gyrowatch::system::sha256(body.as_bytes()).to_vec())
                .execute(&mut file)
                .await
                .unwrap();
        }
        // That version kept no checksums.
        sqlx::query("DELETE FROM checksum").execute(&mut file).await.unwrap();
        sqlx::Connection::close(file).await.unwrap();
    }
    lab.start().await;
    let read = lab.get(&format!("/v1/records/{}", stored["id"].as_str().unwrap())).await.ok();
    assert_eq!(read["separations"][0]["serial"], "\u{c5}-7");
    assert!(read["verdicts"].as_array().unwrap().iter().all(|verdict| verdict["serial"] == "\u{c5}-7"), "{read}");
    let points = |path: &str| format!("/v1/gyros/{path}/trend?coefficient=D_I");
    for path in ["A%CC%8A-7", "%C3%85-7", "M3%E2%80%8B"] {
        assert_eq!(lab.get(&points(path)).await.ok()["points"].as_array().unwrap().len(), 1, "{path}");
    }
    lab.get(&points("M3")).await.refused(404);
    // Its history goes on under either spelling.
    lab.posts(&record("IMU-1", &day(10), &[("G1", "\u{c5}-7", 2.001, 1.0)])).await;
    assert_eq!(lab.get(&points("A%CC%8A-7")).await.ok()["points"].as_array().unwrap().len(), 2);
    verify(lab).await;
}
