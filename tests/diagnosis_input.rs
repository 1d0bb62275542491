//! Campaigns that a diagnosis can do little with: each gets an answer or a clear refusal, never a number that is
//! none, a panic, or a cause made up.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::command::run;
use crate::lab::effects;
use crate::prelude::*;
use gyrowatch::simulate::programme::{Positions, Programme};
use gyrowatch::simulate::scenario::EffectChoice;
use gyrowatch::simulate::{Scenario, simulate};
use gyrowatch::wire::campaign::to_json;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rstest::rstest;

/// Practice campaign 0: nothing is hidden in it.
fn clean() -> Value {
    document("practice/campaign-00.json")
}

/// What came of it: the answer, or what the refusal says.
fn diagnosed(campaign: &Value) -> Result<Value, String> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("campaign.json");
    std::fs::write(&path, campaign.to_string()).unwrap();
    let (status, out, error) = run(&["diagnose", path.to_str().unwrap(), "--format", "json"]);
    assert!(!error.contains("panicked"), "{error}");
    match status {
        0 => Ok(serde_json::from_str(&out).unwrap()),
        1 => {
            assert_eq!(out, "");
            Err(error)
        }
        other => panic!("{other}: {error}"),
    }
}

/// An answer: no number in it is missing but where the form allows null, and nothing is named in a clean campaign.
fn no_made_up_cause(answer: &Value) {
    assert_eq!(answer["effects"], json!([]), "{answer}");
    assert_eq!(nulls(answer, ""), Vec::<String>::new());
    for candidate in answer["candidates"].as_array().unwrap() {
        assert_eq!(candidate["closure"].is_null(), candidate["interval"].is_null(), "{candidate}");
    }
}

/// Pointers to null (JSON's NaN and infinity), but for candidates that could not be tried.
fn nulls(value: &Value, at: &str) -> Vec<String> {
    match value {
        Value::Null if at.starts_with("/candidates/") && (at.ends_with("/closure") || at.ends_with("/interval")) => {
            Vec::new()
        }
        Value::Null => vec![at.to_owned()],
        Value::Array(list) => list.iter().enumerate().flat_map(|(i, v)| nulls(v, &format!("{at}/{i}"))).collect(),
        Value::Object(map) => map.iter().flat_map(|(key, v)| nulls(v, &format!("{at}/{key}"))).collect(),
        _ => Vec::new(),
    }
}

fn dwells(campaign: &mut Value) -> &mut Vec<Value> {
    campaign["dwells"].as_array_mut().unwrap()
}

fn without(campaign: &mut Value, member: &str) {
    dwells(campaign).iter_mut().for_each(|dwell| {
        dwell.as_object_mut().unwrap().remove(member);
    });
}

fn outputs(campaign: &mut Value, change: impl Fn(usize, f64) -> f64) {
    for dwell in dwells(campaign) {
        for (j, y) in dwell["output_pulse_s"].as_array_mut().unwrap().iter_mut().enumerate() {
            *y = change(j, y.as_f64().unwrap()).into();
        }
    }
}

/// What model (6) predicts with made-up parameters, to the last digit.
fn noise_free(campaign: &mut Value) {
    for dwell in dwells(campaign) {
        let vector = |name: &str| [0, 1, 2].map(|i| dwell[name][i].as_f64().unwrap());
        let (a, w) = (vector("specific_force_g0"), vector("rate_arcsec_s"));
        let input = [
            [0.577350269, -0.408248290, FRAC_1_SQRT_2],
            [0.577350269, -0.408248290, -FRAC_1_SQRT_2],
            [0.577350269, 0.816496581, 0.0],
        ];
        let output = input.map(|e| {
            let drift: f64 = 0.3 + (0..3).map(|i| 2.0 * e[i] * a[i] + 0.01 * a[i] * a[i]).sum::<f64>();
            1.4676 * (drift + (0..3).map(|i| e[i] * w[i]).sum::<f64>())
        });
        dwell["output_pulse_s"] = json!(output);
    }
}

fn one_gyro(campaign: &mut Value) {
    campaign["gyros"].as_array_mut().unwrap().truncate(1);
    for dwell in dwells(campaign) {
        for member in ["output_pulse_s", "output_sem_pulse_s"] {
            dwell[member].as_array_mut().unwrap().truncate(1);
        }
    }
}

#[rstest]
#[case::no_standard_errors(|c: &mut Value| without(c, "output_sem_pulse_s"))]
#[case::no_temperature(|c: &mut Value| without(c, "temperature_c"))]
#[case::a_constant_temperature(|c: &mut Value| dwells(c).iter_mut().for_each(|d| d["temperature_c"] = 20.0.into()))]
#[case::no_attitude(|c: &mut Value| without(c, "attitude"))]
#[case::nothing_but_what_must_be(|c: &mut Value| ["output_sem_pulse_s", "temperature_c", "attitude"].iter().for_each(|m| without(c, m)))]
#[case::one_gyro(one_gyro)]
#[case::no_site(|c: &mut Value| { c.as_object_mut().unwrap().remove("site"); })]
#[case::perfect_data(noise_free)]
#[case::perfect_data_without_standard_errors(|c: &mut Value| { noise_free(c); without(c, "output_sem_pulse_s"); })]
#[case::static_dwells_alone(|c: &mut Value| dwells(c).retain(|d| d["phase"] == "static"))]
fn a_clean_campaign_that_lacks_something_has_no_cause(#[case] spoil: fn(&mut Value)) {
    let mut campaign = clean();
    spoil(&mut campaign);
    match diagnosed(&campaign) {
        Ok(answer) => no_made_up_cause(&answer),
        Err(refusal) => panic!("it can be diagnosed: {refusal}"),
    }
}

#[test]
fn a_campaign_without_repeats_says_so() {
    let mut campaign = clean();
    let mut seen = Vec::new();
    dwells(&mut campaign).retain(|dwell| {
        let position = (dwell["specific_force_g0"].to_string(), dwell["rate_arcsec_s"].to_string());
        let new = !seen.contains(&position);
        seen.push(position);
        new
    });
    match diagnosed(&campaign) {
        Ok(answer) => {
            no_made_up_cause(&answer);
            assert!(answer["noise_floor"]["source"].as_str().unwrap().contains("sem"), "{}", answer["noise_floor"]);
        }
        Err(refusal) => assert!(refusal.contains("nothing can be held against it"), "{refusal}"),
    }
}

#[rstest]
#[case::no_dwell_to_spare(9)]
#[case::one_dwell_to_spare(10)]
#[case::few_to_spare(14)]
fn a_campaign_too_small_to_hold_anything_out_is_refused_or_names_nothing(#[case] count: usize) {
    let mut campaign = clean();
    dwells(&mut campaign).truncate(count);
    match diagnosed(&campaign) {
        Ok(answer) => no_made_up_cause(&answer),
        Err(refusal) => assert!(refusal.contains("nothing can be held against it"), "{refusal}"),
    }
}

#[test]
fn one_face_over_and_over_names_nothing() {
    let mut campaign = clean();
    let face = dwells(&mut campaign)[0].clone();
    let (force, rate, attitude) = (&face["specific_force_g0"], &face["rate_arcsec_s"], &face["attitude"]);
    dwells(&mut campaign).retain(|dwell| dwell["phase"] == "static");
    let first = face["output_pulse_s"].clone();
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for dwell in dwells(&mut campaign) {
        dwell["specific_force_g0"] = force.clone();
        dwell["rate_arcsec_s"] = rate.clone();
        dwell["attitude"] = attitude.clone();
        for j in 0..3 {
            let sem = dwell["output_sem_pulse_s"][j].as_f64().unwrap();
            let scatter: f64 = StandardNormal.sample(&mut random);
            dwell["output_pulse_s"][j] = (first[j].as_f64().unwrap() + sem * scatter).into();
        }
    }
    match diagnosed(&campaign) {
        Ok(answer) => no_made_up_cause(&answer),
        Err(refusal) => assert!(refusal.contains("nothing can be held against it"), "{refusal}"),
    }
}

#[test]
fn a_gyro_without_output_is_refused_by_its_slot() {
    let mut campaign = clean();
    outputs(&mut campaign, |j, y| if j == 1 { 0.0 } else { y });
    let refusal = diagnosed(&campaign).expect_err("nothing can be said of it");
    assert!(refusal.contains("the output of G2 is the same in every dwell"), "{refusal}");
    outputs(&mut campaign, |_, _| 0.0);
    let refusal = diagnosed(&campaign).expect_err("nothing can be said of it");
    assert!(refusal.contains("the output of G1 is the same in every dwell"), "{refusal}");
}

#[test]
fn several_huge_outliers_are_not_one_bad_dwell_and_no_drift() {
    let mut campaign = clean();
    for (k, j, off) in [(7, 0, 50.0), (21, 0, -80.0), (33, 1, 1e3), (52, 2, 300.0), (60, 2, -1e3)] {
        let y = &mut dwells(&mut campaign)[k]["output_pulse_s"][j];
        *y = (y.as_f64().unwrap() + off).into();
    }
    let answer = diagnosed(&campaign).expect("there are dwells enough");
    assert_ne!(answer["verdict"], "no_gap");
    assert_ne!(answer["verdict"], "explained", "{}", answer["effects"]);
    assert_eq!(nulls(&answer, ""), Vec::<String>::new());
}

/// A campaign with a hidden effect of temperature on the bias of G2, 14 standard deviations strong.
fn temperature_bias() -> Value {
    let effect = EffectChoice { gyros: Some(vec!["G2".into()]), ..EffectChoice::detectable("temperature_bias", 14.0) };
    let scenario = Scenario { seed: 5, effects: vec![effect], ..Scenario::default() };
    serde_json::from_str(&to_json(&simulate(&scenario).unwrap().campaign)).unwrap()
}

#[rstest]
#[case(999.0)]
#[case(-273.15)]
#[case(0.0)]
#[case(85.0)]
#[case(78.0)]
fn a_thermometers_fault_value_is_named_and_left_out(#[case] fault: f64) {
    let mut campaign = temperature_bias();
    dwells(&mut campaign)[40]["temperature_c"] = json!(fault);
    let answer = diagnosed(&campaign).unwrap();
    assert_eq!((&answer["verdict"], effects(&answer)), (&json!("explained"), vec!["temperature_bias"]));
    let notes: Vec<&str> = answer["notes"].as_array().unwrap().iter().map(|n| n.as_str().unwrap()).collect();
    let told = |note: &&str| note.contains(&format!("of /dwells/40 is {fault} deg C")) && note.contains("left out");
    assert!(notes.iter().any(told), "{notes:?}");
}

#[test]
fn temperatures_and_standard_errors_are_used_where_they_are() {
    let mut campaign = temperature_bias();
    for k in [0, 7, 8, 30, 55, 77] {
        dwells(&mut campaign)[k].as_object_mut().unwrap().remove("temperature_c");
        dwells(&mut campaign)[(k + 3) % 78].as_object_mut().unwrap().remove("output_sem_pulse_s");
    }
    let answer = diagnosed(&campaign).unwrap();
    assert_eq!((&answer["verdict"], effects(&answer)), (&json!("explained"), vec!["temperature_bias"]));
}

/// A chamber's log: one orientation, a ramp of temperature, an accelerometer that drifts with it, no attitude and no
/// standard errors.
fn thermal_log(seed: u64, bend: f64) -> Value {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = |sd: f64| -> f64 {
        let x: f64 = StandardNormal.sample(&mut rng);
        sd * x
    };
    let mut log = json!({
        "imu": "CH", "station": "chamber", "measured_at": "2024-06-22T20:13:55Z", "geometry": "orthogonal", "model": ["bias"],
        "gyros": [
            {"slot": "G1", "serial": "c1", "known_e_pulse_per_arcsec": [1.0, 0.0, 0.0]},
            {"slot": "G2", "serial": "c2", "known_e_pulse_per_arcsec": [0.0, 1.0, 0.0]},
            {"slot": "G3", "serial": "c3", "known_e_pulse_per_arcsec": [0.0, 0.0, 1.0]}
        ],
        "dwells": []
    });
    for k in 0..30 {
        let temperature = 1.0 + 2.2 * f64::from(k) + normal(0.4);
        let (x, y) = (0.011 - 5e-5 * temperature + normal(2e-4), -0.012 - 3e-5 * temperature + normal(2e-4));
        let course = (temperature - 35.0) * (1.0 + bend * (temperature - 35.0) / 60.0);
        let output: Vec<f64> = [3.1, -9.0, -6.5].into_iter().map(|slope| slope * course + normal(12.0)).collect();
        log["dwells"].as_array_mut().unwrap().push(json!({
            "phase": "static", "start_s": 60 * k, "duration_s": 60, "specific_force_g0": [x, y, (1.0 - x * x - y * y).sqrt()],
            "rate_arcsec_s": [0, 0, 0], "temperature_c": temperature, "output_pulse_s": output
        }));
    }
    log
}

#[test]
fn a_thermal_log_is_put_down_to_temperature_and_to_nothing_implausible() {
    for seed in 0..6 {
        let answer = diagnosed(&thermal_log(seed, 0.0)).unwrap();
        assert_eq!(effects(&answer).first(), Some(&"temperature_bias"), "{seed}: {answer}");
        let bent = diagnosed(&thermal_log(seed, 0.6)).unwrap();
        let signs = bent["remaining"]["signs"].to_string();
        match effects(&bent).first() {
            Some(name) => assert!(name.starts_with("temperature"), "{seed}: {:?}", effects(&bent)),
            None => assert!(signs.contains("temperature"), "{seed}: {signs}"),
        }
        for answer in [answer, bent] {
            for effect in answer["effects"].as_array().unwrap() {
                assert!(effect["held_out"]["closure"].as_f64().unwrap() > 0.0, "{effect}");
            }
        }
    }
}

/// An accelerometer that drifts with temperature gives specific force the course of the outputs: coefficients of 1e5
/// deg/(h g0) fit.
#[test]
fn nothing_is_named_that_no_gyro_can_have() {
    for seed in 0..6 {
        let mut log = thermal_log(seed, 0.6);
        without(&mut log, "temperature_c");
        let answer = diagnosed(&log).unwrap();
        let of_force = ["g_linear", "g_squared", "cross_compliance", "cubic_g"];
        assert!(effects(&answer).iter().all(|name| !of_force.contains(name)), "{seed}: {:?}", effects(&answer));
        let implausible = |c: &&Value| c["why_not"] == "its size would be beyond what is plausible";
        assert!(answer["candidates"].as_array().unwrap().iter().filter(implausible).count() > 0, "{seed}: {answer}");
    }
}

#[rstest]
#[case("axial_compliance")]
#[case("cross_compliance")]
fn compliance_along_the_axes_of_skewed_gyros_is_told_from_that_across_them(#[case] effect: &str) {
    for seed in 1..6 {
        let programme = Programme { positions: Positions::WithTilts, ..Programme::default() };
        let hidden = vec![EffectChoice::detectable(effect, 20.0)];
        let run = simulate(&Scenario { seed, programme, effects: hidden, ..Scenario::default() }).unwrap();
        let answer = diagnosed(&serde_json::from_str(&to_json(&run.campaign)).unwrap()).unwrap();
        assert_eq!(effects(&answer), [effect], "{seed}");
    }
}

#[test]
fn more_dwells_than_a_search_has_memory_for_are_refused() {
    let mut campaign = clean();
    let dwells = campaign["dwells"].as_array().unwrap().clone();
    let span = 1e5;
    let again = |k: usize| {
        let mut dwell = dwells[k % dwells.len()].clone();
        dwell["start_s"] = json!(dwell["start_s"].as_f64().unwrap() + span * (k / dwells.len()) as f64);
        dwell
    };
    campaign["dwells"] = (0..1201).map(again).collect();
    let refused = diagnosed(&campaign).unwrap_err();
    assert!(refused.contains("1201 dwells are more than a diagnosis takes, 1200 of so many gyros"), "{refused}");
}

#[test]
fn a_scale_that_no_gyro_has_is_refused_as_a_calibration_refuses_it() {
    let mut campaign = clean();
    outputs(&mut campaign, |_, y| 1e3 * y);
    let said = diagnosed(&campaign).unwrap_err();
    assert!(said.contains("is outside 0.001 to 1000"), "{said}");
}
