//! Closing the loop on the command line: an effect that was named enters the model, the next campaigns are fitted
//! with it and compared with it, a simulated one shows it, and leaving it out undoes it.

use crate::command::{Folder, answer, read_json, run};
use crate::lab::effects;
use crate::support::{data_path, document};
use serde_json::{Value, json};

/// The practice campaign with one effect alone, of those that other campaigns than the one it was found in can have,
/// and that effect.
fn practice_with_one_effect() -> (String, String) {
    let key = document("practice/key.json");
    let once = ["bias_step", "outlier_dwell"];
    let found =
        key.as_object().unwrap().iter().find_map(|(name, entry)| match entry["effects"].as_array()?.as_slice() {
            [one] if !once.contains(&one.as_str()?) && !one.as_str()?.contains(' ') && name != "campaign-00.json" => {
                Some((data_path("practice").join(name).to_str()?.to_owned(), one.as_str()?.to_owned()))
            }
            _ => None,
        });
    found.expect("practice campaigns with one effect")
}

/// D_I and D_S of a gyro as `calibrate` prints them, by serial.
fn drift(answer: &Value, serial: &str) -> [f64; 2] {
    let separations = answer["separations"].as_array().unwrap();
    let gyro = separations.iter().find(|s| s["serial"] == serial).unwrap();
    ["d_i", "d_s"].map(|name| gyro[name]["value"].as_f64().unwrap())
}

#[test]
fn an_adopted_effect_is_fitted_and_closes_the_gap_and_leaving_it_out_undoes_it() {
    let bench = Folder::new();
    let (campaign, cause) = practice_with_one_effect();
    let model = bench.path("model.json");
    let before = answer(&["diagnose", &campaign, "--adopt", &model]);
    assert_eq!(effects(&before), [cause.as_str()]);

    let file = read_json(&model);
    assert_eq!(file["terms"], json!(["bias", "g_linear", "g_squared", "scale"]));
    assert_eq!(file["effects"][0]["effect"], cause.as_str());
    assert_eq!(file["effects"][0]["gyros"], before["effects"][0]["gyros"]);
    assert_eq!(file["provenance"]["imu"], read_json(&campaign)["imu"]);

    let after = answer(&["diagnose", &campaign, "--model", &model]);
    assert_eq!(after["verdict"], "no_gap", "{after}");
    assert_eq!(after["model"]["effects"][0]["effect"], cause.as_str());
    let rms = |diagnosis: &Value, of: &str| diagnosis[of]["rms_deg_per_h"].as_f64().unwrap();
    assert!((rms(&after, "gap") / rms(&before, "remaining") - 1.0).abs() < 1e-3, "the gap is what remained");

    // The fit with the effect moves D_I and D_S to where the diagnosis said.
    let (plain, augmented) = (answer(&["calibrate", &campaign]), answer(&["calibrate", &campaign, "--model", &model]));
    assert_eq!(augmented["calibration"]["effects"], json!([cause]));
    let fitted = augmented["calibration"]["gyros"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|g| g["effects"].as_array().cloned().unwrap_or_default());
    let fitted: Vec<Value> = fitted.collect();
    assert_eq!(fitted.len(), file["effects"][0]["estimates"].as_array().unwrap().len());
    for (own, known) in fitted.iter().zip(file["effects"][0]["estimates"].as_array().unwrap()) {
        let (a, b, sd) =
            (own["value"].as_f64().unwrap(), known["value"].as_f64().unwrap(), known["sd"].as_f64().unwrap());
        assert!((a - b).abs() < sd, "{own} {known}");
    }
    for shift in before["impact"].as_array().unwrap() {
        let slot = &shift["slot"];
        let gyros = plain["calibration"]["gyros"].as_array().unwrap();
        let serial = gyros.iter().find(|g| g["slot"] == *slot).unwrap()["serial"].as_str().unwrap();
        let k = usize::from(shift["coefficient"] == "D_S");
        let moved = drift(&augmented, serial)[k] - drift(&plain, serial)[k];
        let (said, sd) = (shift["shift"].as_f64().unwrap(), shift["augmented_sd"].as_f64().unwrap());
        assert!((moved - said).abs() < 0.2 * sd + 1e-6, "{slot} {}: {moved} and not {said}", shift["coefficient"]);
    }

    // Undone: the file without the effect is the plain model again.
    let mut plain_file = file;
    plain_file["effects"] = json!([]);
    let undone = bench.file("undone.json", &plain_file.to_string());
    let again = answer(&["diagnose", &campaign, "--model", &undone]);
    assert_eq!(again, before);
}

#[test]
fn a_simulated_campaign_shows_the_effects_of_a_model_file() {
    let bench = Folder::new();
    let estimate = |slot: &str| json!({"slot": slot, "name": "k", "value": 0.02, "sd": 0.001, "unit": "deg/h/K"});
    let file = json!({"terms": [], "effects": [
        {"effect": "temperature_bias", "gyros": ["G1", "G3"], "estimates": [estimate("G1"), estimate("G3")]}]});
    let model = bench.file("model.json", &file.to_string());
    let (campaign, truth) = (bench.path("c.json"), bench.path("t.json"));
    let (status, _, error) =
        run(&["simulate", "--seed", "7", "--model", &model, "--out", &campaign, "--truth", &truth]);
    assert_eq!(status, 0, "{error}");
    let key = read_json(truth);
    assert_eq!(key["c.json"]["effects"], json!(["temperature_bias"]));
    assert_eq!(key["c.json"]["gyros"], json!(["G1", "G3"]));
    assert!(key["c.json"]["seen"].as_f64().unwrap() > 8.0, "{key}");
    let diagnosis = answer(&["diagnose", &campaign]);
    assert_eq!(effects(&diagnosis), ["temperature_bias"]);
    for estimate in diagnosis["effects"][0]["estimates"].as_array().unwrap() {
        let (value, sd) = (estimate["value"].as_f64().unwrap(), estimate["sd"].as_f64().unwrap());
        assert!((value - 0.02).abs() < 4.0 * sd, "{estimate}");
    }
}

#[test]
fn a_tilt_of_the_table_is_fitted_once_for_all_gyros() {
    let bench = Folder::new();
    let tilt = |name: &str, value: f64| json!({"slot": "all", "name": name, "value": value, "sd": 1e-6, "unit": "rad"});
    let gyros = json!(["G1", "G2", "G3"]);
    let file = json!({"terms": [], "effects": [{"effect": "levelling", "gyros": gyros, "shape": {"with_rate": false},
        "estimates": [tilt("east", 4e-4), tilt("north", -2.5e-4)]}]});
    let model = bench.file("model.json", &file.to_string());
    let campaign = bench.path("c.json");
    let (status, _, error) = run(&["simulate", "--seed", "11", "--model", &model, "--out", &campaign]);
    assert_eq!(status, 0, "{error}");
    let fitted = answer(&["calibrate", &campaign, "--model", &model]);
    let of = |gyro: usize| fitted["calibration"]["gyros"][gyro]["effects"].clone();
    for (gyro, c) in [(1, 0), (1, 1), (2, 0), (2, 1)] {
        assert_eq!(of(gyro)[c]["value"], of(0)[c]["value"], "one tilt");
    }
    for (effect, truth) in of(0).as_array().unwrap().iter().zip([4e-4, -2.5e-4]) {
        let (value, sd) = (effect["value"].as_f64().unwrap(), effect["sd"].as_f64().unwrap());
        assert!((value - truth).abs() < 4.0 * sd && sd < 0.1 * truth.abs(), "{effect}");
    }
    // Two numbers were fitted to all gyros, not two to each.
    let dof = |answer: &Value| -> i64 {
        answer["calibration"]["gyros"].as_array().unwrap().iter().map(|g| g["dof"].as_i64().unwrap()).sum()
    };
    assert_eq!(dof(&answer(&["calibrate", &campaign])) - dof(&fitted), 2);
    // The diagnosis against that model finds nothing more, and the fit knows D_I and D_S hardly less well.
    let against = answer(&["diagnose", &campaign, "--model", &model]);
    assert_eq!(against["verdict"], "no_gap", "{against}");
}

#[test]
fn a_term_of_model_6_that_was_named_joins_the_terms() {
    let bench = Folder::new();
    let model = bench.path("model.json");
    let xsens = data_path("measured/xsens-mti.json");
    let xsens = xsens.to_str().unwrap();
    let before = answer(&["diagnose", xsens, "--model", "bias", "--adopt", &model]);
    assert!(effects(&before).contains(&"g_linear"));
    let fitted = answer(&["calibrate", xsens, "--model", &model]);
    let terms = fitted["calibration"]["model"].as_array().unwrap();
    assert!(terms.contains(&json!("g_linear")), "{terms:?}");
    assert!(fitted["calibration"]["gyros"][0]["g_pulse_per_s_g0"].is_array());
}

#[test]
fn a_step_or_a_bad_dwell_stays_in_the_campaign_in_which_it_happened() {
    let bench = Folder::new();
    let campaign = document("practice/campaign-00.json");
    let file = json!({
        "terms": [],
        "effects": [{"effect": "outlier_dwell", "gyros": ["G1"], "shape": {"dwell": 5}, "estimates": []}],
        "provenance": {"imu": campaign["imu"], "station": campaign["station"], "measured_at": campaign["measured_at"]},
    });
    let model = bench.file("model.json", &file.to_string());
    let mut later = campaign.clone();
    later["measured_at"] = "2030-01-01T00:00:00Z".into();
    let next = bench.file("later.json", &later.to_string());
    let here = answer(&["calibrate", data_path("practice/campaign-00.json").to_str().unwrap(), "--model", &model]);
    assert_eq!(here["calibration"]["effects"], json!(["outlier_dwell"]));
    let later = answer(&["calibrate", &next, "--model", &model]);
    assert_eq!(later["calibration"]["effects"], Value::Null);
}

#[test]
fn what_a_campaign_cannot_be_fitted_with_is_left_out_and_said() {
    let bench = Folder::new();
    let file = json!({"terms": [], "effects": [
        {"effect": "output_axis_g", "gyros": ["G1"], "estimates": []},
        {"effect": "temperature_bias", "gyros": ["G2"], "estimates": []}]});
    let model = bench.file("model.json", &file.to_string());
    let mut cold = document("practice/campaign-00.json");
    for dwell in cold["dwells"].as_array_mut().unwrap() {
        dwell.as_object_mut().unwrap().remove("temperature_c");
    }
    let campaign = bench.file("cold.json", &cold.to_string());
    let (plain, fitted) = (answer(&["calibrate", &campaign]), answer(&["calibrate", &campaign, "--model", &model]));
    assert_eq!(plain["separations"], fitted["separations"]);
    let notes = fitted["notes"].to_string();
    assert!(notes.contains("output_axis_g is left out"), "{notes}");
    assert!(notes.contains("temperature_bias is left out of the fit: the dwells carry no temperature"), "{notes}");
}

#[test]
fn a_bad_model_file_is_refused_by_the_place_of_its_fault() {
    let bench = Folder::new();
    let model = bench.path("model.json");
    let campaign = data_path("practice/campaign-00.json");
    let campaign = campaign.to_str().unwrap();
    std::fs::write(
        &model,
        json!({"terms": ["bias"], "effects": [{"effect": "ghost", "gyros": ["G1"], "estimates": []}]}).to_string(),
    )
    .unwrap();
    let path = &*model;
    for command in ["diagnose", "calibrate"] {
        let (status, out, error) = run(&[command, campaign, "--model", path]);
        assert_eq!((status, out.as_str()), (1, ""));
        assert!(error.contains("model.json") && error.contains("/effects/0/effect"), "{error}");
    }
    let (status, _, error) = run(&["simulate", "--model", path]);
    assert!(status == 1 && error.contains("/effects/0/effect"), "{error}");
    let (status, _, error) = run(&["diagnose", campaign, "--model", "bias,jerk"]);
    assert!(status == 2 && error.contains("jerk"), "{error}");
    let (status, _, error) = run(&["diagnose", campaign, "--adopt", "/nowhere/model.json"]);
    assert!(status == 1 && error.contains("/nowhere/model.json"), "{error}");
}

/// What gyros of a kind cannot be as large as is no cause of theirs.
#[test]
fn nothing_is_named_larger_than_gyros_of_this_kind_have_it() {
    let bench = Folder::new();
    let (campaign, effect) = practice_with_one_effect();
    let named_with = |most: f64| {
        let file = json!({"terms": [], "effects": [], "plausible_sizes": {effect.as_str(): most}});
        let model = bench.file("kind.json", &file.to_string());
        let answer = answer(&["diagnose", &campaign, "--model", &model]);
        effects(&answer).contains(&effect.as_str())
    };
    assert!(named_with(1e3));
    assert!(!named_with(1e-9));
    // An adoption keeps what is known of the kind.
    let (kind, adopted) = (bench.path("kind.json"), bench.path("adopted.json"));
    std::fs::write(&kind, json!({"terms": [], "effects": [], "plausible_sizes": {"magnetic": 0.5}}).to_string())
        .unwrap();
    answer(&["diagnose", &campaign, "--model", &kind, "--adopt", &adopted]);
    assert_eq!(read_json(&adopted)["plausible_sizes"], json!({"magnetic": 0.5}));
}
