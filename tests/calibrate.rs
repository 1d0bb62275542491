//! `gyrowatch calibrate` as an operator uses it.

use std::io::Write;

use crate::command::{answer, complaint, printed, run};
use crate::prelude::*;

const CAMPAIGN: &str = "tests/data/practice/campaign-00.json";
const XSENS: &str = "tests/data/measured/xsens-mti.json";

fn file(suffix: &str, text: &str) -> tempfile::NamedTempFile {
    let mut file = tempfile::Builder::new().suffix(suffix).tempfile().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    file
}

/// The campaign as the station's table program would write it, made here from the JSON.
fn as_csv(path: &str) -> String {
    let campaign: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let mut text = String::new();
    for (key, value) in campaign.as_object().unwrap().iter().filter(|(key, _)| *key != "dwells") {
        let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        text.push_str(&format!("# {key}: {value}\r\n"));
    }
    let suffixes = |field: &str| match field {
        "attitude" => vec!["_w", "_x", "_y", "_z"],
        f if f.starts_with("output") => vec!["_1", "_2", "_3"],
        _ => vec!["_x", "_y", "_z"],
    };
    for (k, dwell) in campaign["dwells"].as_array().unwrap().iter().enumerate() {
        let (mut names, mut cells) = (Vec::new(), Vec::new());
        for (field, value) in dwell.as_object().unwrap() {
            match value {
                Value::Array(list) => {
                    names.extend(suffixes(field).iter().map(|s| format!("{field}{s}")));
                    cells.extend(list.iter().map(Value::to_string));
                }
                Value::String(text) => {
                    names.push(field.clone());
                    cells.push(text.clone());
                }
                number => {
                    names.push(field.clone());
                    cells.push(number.to_string());
                }
            }
        }
        if k == 0 {
            text.push_str(&format!("{}\r\n", names.join(",")));
        }
        text.push_str(&format!("{}\r\n", cells.join(",")));
    }
    text
}

#[test]
fn a_campaign_yields_drift_with_sigmas_and_the_fit_with_its_evidence() {
    let answer = answer(&["calibrate", CAMPAIGN]);
    assert_eq!(answer["calibration"]["model"], json!(["bias", "g_linear", "g_squared", "scale"]));
    assert_eq!(answer["calibration"]["repeats"].as_array().unwrap().len(), 6);
    for (gyro, separation) in
        answer["calibration"]["gyros"].as_array().unwrap().iter().zip(answer["separations"].as_array().unwrap())
    {
        assert_eq!((&gyro["rank"], &gyro["dof"]), (&Value::from(9), &Value::from(69)));
        assert_eq!(gyro["null_directions"][0]["gauge"], "P_x + P_y + P_z = 0");
        let p: f64 = (0..3).map(|i| gyro["p_pulse_per_s_g02"][i].as_f64().unwrap()).sum();
        assert!(p.abs() < 1e-12);
        assert_eq!(gyro["covariance"].as_array().unwrap().len(), 10);
        for list in ["pulse_per_s", "deg_per_h", "standardised", "leverage"] {
            assert_eq!(gyro["residuals"][list].as_array().unwrap().len(), 78, "{list}");
        }
        let leverage: f64 = gyro["residuals"]["leverage"].as_array().unwrap().iter().map(|h| h.as_f64().unwrap()).sum();
        assert!((leverage - 9.0).abs() < 1e-9);
        let sd = separation["d_i"]["sd"].as_f64().unwrap();
        assert!((1e-4..4e-4).contains(&sd), "{sd}");
        assert!(separation["published"]["branch"].is_string());
    }
}

#[test]
fn a_table_without_a_last_line_end_is_noted() {
    let whole = as_csv(CAMPAIGN);
    let open = |answer: &Value| answer["notes"].as_array().unwrap().iter().any(|note| note["code"] == "no_line_end");
    for (text, noted) in [(whole.as_str(), false), (whole.trim_end(), true)] {
        let csv = file(".csv", text);
        let path = csv.path().to_str().unwrap();
        assert_eq!(open(&answer(&["calibrate", path])), noted);
        let (status, _, complaints) = run(&["diagnose", path]);
        assert_eq!((status, complaints.contains("does not end with a line break")), (0, noted), "{complaints}");
    }
}

#[test]
fn csv_gives_the_same_answer_as_json() {
    let csv = file(".csv", &as_csv(CAMPAIGN));
    assert_eq!(answer(&["calibrate", csv.path().to_str().unwrap()]), answer(&["calibrate", CAMPAIGN]));
}

#[test]
fn the_table_shows_fit_parameters_residuals_and_drift() {
    let text = printed(&["calibrate", CAMPAIGN]);
    for words in ["IMU-9000, measured by ST-A", "Gauge: P_x + P_y + P_z = 0", "E_z", "Largest residuals", "published"] {
        assert!(text.contains(words), "{words} is missing in\n{text}");
    }
}

#[test]
fn fewer_terms_are_fitted_with_model() {
    let xsens = answer(&["calibrate", XSENS, "--model", "bias,g_linear"]);
    assert_eq!(xsens["calibration"]["gyros"][0]["e_source"], "held");
    assert_eq!(xsens["separations"].as_array().unwrap().len(), 3);
    let words: Vec<&str> = xsens["notes"].as_array().unwrap().iter().map(|n| n["code"].as_str().unwrap()).collect();
    // The Earth's rate is below the noise of these gyros: leaving it out is told of and no more.
    assert_eq!(words, ["static_rate", "no_attitudes", "no_temperatures", "no_repeats", "residuals_exceed_noise"]);

    let no_scale = answer(&["calibrate", CAMPAIGN, "--model", "bias,g_linear"]);
    assert_eq!(no_scale["separations"], json!([]));
    let reason = no_scale["not_separated"][0]["reason"].as_str().unwrap();
    assert!(reason.contains("there is no D_I and D_S in deg/(h g0)"), "{reason}");
    assert!(
        printed(&["calibrate", CAMPAIGN, "--model", "bias,scale"])
            .contains("is not separated: the model has no g_linear term")
    );
    assert!(complaint(&["calibrate", CAMPAIGN, "--model", "bias,jerk"], 2).contains("unknown term \"jerk\""));
}

#[test]
fn a_refused_file_says_where_and_why() {
    let text = std::fs::read_to_string(CAMPAIGN).unwrap();
    let json = file(".json", &text.replacen("\"start_s\":240.0", "\"start_s\":100.0", 1));
    let words = complaint(&["calibrate", json.path().to_str().unwrap()], 1);
    assert!(words.contains(json.path().to_str().unwrap()) && words.contains("/dwells/1/start_s: overlaps"), "{words}");
    let csv = file(".csv", &as_csv(CAMPAIGN).replacen("temperature_c", "temp", 1));
    let words = complaint(&["calibrate", csv.path().to_str().unwrap()], 1);
    assert!(words.contains("line 7, column"), "{words}");
}

#[test]
fn exchanged_outputs_are_refused_as_an_impossible_e() {
    let mut campaign = document("practice/campaign-00.json");
    for dwell in campaign["dwells"].as_array_mut().unwrap() {
        dwell["output_pulse_s"].as_array_mut().unwrap().swap(0, 2);
    }
    let exchanged = file(".json", &campaign.to_string());
    let words = complaint(&["calibrate", exchanged.path().to_str().unwrap()], 1);
    assert!(
        words.contains("/gyros/0") && words.contains("/gyros/2") && words.contains("deg from the input axis"),
        "{words}"
    );
}

#[test]
fn a_bench_test_yields_a_bench_result() {
    let text = std::fs::read_to_string(CAMPAIGN).unwrap();
    let mut campaign: Value = serde_json::from_str(&text).unwrap();
    campaign["test"] = "torque_feedback".into();
    campaign["geometry"] =
        serde_json::from_str(r#"{"input": [0.57735, -0.40825, 0.70711], "spin": [0, 0.866025, 0.5]}"#).unwrap();
    campaign["gyros"] = json!([{"serial": "LFG-9000-1"}]);
    let dwells = campaign["dwells"].as_array_mut().unwrap();
    dwells.retain(|d| d["phase"] == "static");
    for dwell in dwells {
        dwell["output_pulse_s"].as_array_mut().unwrap().truncate(1);
        dwell["output_sem_pulse_s"].as_array_mut().unwrap().truncate(1);
    }
    let bench = file(".json", &campaign.to_string());
    let answer = answer(&["calibrate", bench.path().to_str().unwrap()]);
    let result = &answer["bench_result"];
    assert_eq!((&result["method"], &result["serial"]), (&"torque_feedback".into(), &"LFG-9000-1".into()));
    // The same gyro in the same campaign: the key's D_I and D_S.
    for (name, truth) in [("d_i", 3.526959), ("d_s", 0.145471)] {
        let found = result[format!("{name}_deg_per_h_g0")].as_f64().unwrap();
        let sd = result[format!("{name}_sd")].as_f64().unwrap();
        assert!((found - truth).abs() < 4.0 * sd && sd < 2e-3, "{name}: {found} +- {sd}");
    }
}

/// The campaign with something else in it, in a file of its own.
fn changed(change: impl FnOnce(&mut Value)) -> tempfile::NamedTempFile {
    let mut campaign = document("practice/campaign-00.json");
    change(&mut campaign);
    file(".json", &campaign.to_string())
}

fn path(file: &tempfile::NamedTempFile) -> &str {
    file.path().to_str().unwrap()
}

#[test]
fn every_sd_says_what_it_is_made_of_and_is_as_before_where_the_station_states_nothing() {
    let plain = answer(&["calibrate", CAMPAIGN]);
    assert_eq!(plain["calibration"]["station_uncertainty"], json!({"stated": false}));
    for separation in plain["separations"].as_array().unwrap() {
        for name in ["d_i", "d_s", "d_o", "scale_factor"] {
            let parts = &separation["uncertainty"][name];
            assert_eq!((&parts["station"], &parts["discrepancy"]), (&Value::Null, &Value::from(0.0)), "{parts}");
            assert_eq!((&parts["statistical"], &parts["combined"]), (&separation[name]["sd"], &separation[name]["sd"]));
        }
    }
    assert!(printed(&["calibrate", CAMPAIGN]).contains("No uncertainty of the station is stated"));
    let stated = changed(|campaign| {
        campaign["station_uncertainty"] = json!({"levelling_arcsec": 20, "azimuth_arcsec": 30, "fixture_arcsec": 5})
    });
    let found = answer(&["calibrate", path(&stated)]);
    for (before, after) in plain["separations"].as_array().unwrap().iter().zip(found["separations"].as_array().unwrap())
    {
        assert_eq!(before["d_i"]["value"], after["d_i"]["value"]);
        let [sd, combined] =
            [&after["d_i"]["sd"], &after["uncertainty"]["d_i"]["combined"]].map(|x| x.as_f64().unwrap());
        assert!((sd / combined - 1.0).abs() < 1e-12, "{sd} is not {combined}");
        assert!(after["d_i"]["sd"].as_f64() > before["d_i"]["sd"].as_f64());
    }
    let as_csv = file(".csv", &as_csv(path(&stated)));
    assert_eq!(answer(&["calibrate", path(&as_csv)]), found);
    assert!(!printed(&["calibrate", path(&stated)]).contains("No uncertainty"));
}

#[test]
fn what_a_campaign_cannot_tell_of_its_station_is_said() {
    let without = changed(|campaign| {
        campaign["station_uncertainty"] = json!({"levelling_arcsec": 20, "fixture_arcsec": 5});
        for dwell in campaign["dwells"].as_array_mut().unwrap() {
            dwell.as_object_mut().unwrap().remove("attitude");
        }
    });
    let found = answer(&["calibrate", path(&without)]);
    let parts = &found["separations"][0]["uncertainty"]["d_s"];
    assert!(parts["levelling"].is_null() && parts["fixture"].is_number(), "{parts}");
    let note = found["notes"].as_array().unwrap().iter().find(|n| n["code"] == "station_left_out").expect("said");
    assert_eq!(note["parts"], json!(["levelling"]));
}

/// Three campaigns, a day apart, with noise of their own and another bias.
fn three(bias: f64) -> Vec<tempfile::NamedTempFile> {
    let of_day = |day: usize| {
        changed(|campaign| {
            campaign["measured_at"] = format!("2026-03-0{}T08:00:00Z", day + 1).into();
            for (k, dwell) in campaign["dwells"].as_array_mut().unwrap().iter_mut().enumerate() {
                for j in 0..3 {
                    let noise = 0.0012 * f64::sin(1.7 * (k * k + 31 * j + 101 * day) as f64);
                    let output = dwell["output_pulse_s"][j].as_f64().unwrap();
                    dwell["output_pulse_s"][j] = (output + noise + bias * day as f64).into();
                }
            }
        })
    };
    (0..3).map(of_day).collect()
}

#[test]
fn several_campaigns_say_what_repeats_between_them() {
    let files = three(0.02);
    // The order of the files is that of a shell, and says nothing.
    let arguments = ["calibrate", path(&files[2]), path(&files[0]), path(&files[1])];
    let found = answer(&arguments);
    let campaigns = found["campaigns"].as_array().unwrap();
    let times: Vec<&str> = campaigns.iter().map(|one| one["measured_at"].as_str().unwrap()).collect();
    assert_eq!(times, ["2026-03-01T08:00:00Z", "2026-03-02T08:00:00Z", "2026-03-03T08:00:00Z"]);
    assert_eq!(answer(&["calibrate", path(&files[1])]), campaigns[1]);
    let of = |slot: &str, coefficient: &str| {
        let all = found["between_campaigns"].as_array().unwrap().iter();
        all.clone().find(|r| r["slot"] == slot && r["coefficient"] == coefficient).unwrap().clone()
    };
    let d_i = of("G1", "D_I");
    let values: Vec<(f64, f64)> = campaigns
        .iter()
        .map(|one| &one["separations"][0]["d_i"])
        .map(|figure| (figure["value"].as_f64().unwrap(), figure["sd"].as_f64().unwrap()))
        .collect();
    let weights: f64 = values.iter().map(|(_, sd)| sd.powi(-2)).sum();
    let mean = values.iter().map(|(x, sd)| x * sd.powi(-2)).sum::<f64>() / weights;
    let chi2: f64 = values.iter().map(|(x, sd)| ((x - mean) / sd).powi(2)).sum();
    let close = |value: &Value, expected: f64| {
        let value = value.as_f64().unwrap();
        assert!((value - expected).abs() < 1e-9 * expected.abs(), "{value} is not {expected}");
    };
    assert_eq!((&d_i["campaigns"], &d_i["dof"], &d_i["beyond_sd"]), (&3.into(), &2.into(), &0.0.into()));
    close(&d_i["mean"], mean);
    close(&d_i["chi2"], chi2);
    close(&d_i["sd"], weights.sqrt().recip());
    // P(chi-square of two > x) = exp(-x/2).
    close(&d_i["p_value"], (-0.5 * chi2).exp());
    let d_f = of("G1", "D_F");
    assert!(d_f["p_value"].as_f64().unwrap() < 1e-3, "{d_f}");
    let between = 0.02 / campaigns[0]["separations"][0]["scale_factor"]["value"].as_f64().unwrap();
    let beyond = d_f["beyond_sd"].as_f64().unwrap();
    assert!((0.9..1.1).contains(&(beyond / between)), "{d_f}");
    assert!(d_f["sd"].as_f64().unwrap() > 0.9 * between / f64::sqrt(3.0), "{d_f}");
    let text = printed(&arguments);
    assert!(text.contains("the sd of the mean holds it: G1 D_F, G2 D_F, G3 D_F"), "{text}");
    let alike = three(0.0);
    let text = printed(&["calibrate", path(&alike[0]), path(&alike[1])]);
    assert!(text.contains("No coefficient differs between campaigns by more than is stated"), "{text}");
}

#[test]
fn campaigns_of_other_imus_gyros_or_instants_are_refused_by_file() {
    let later = |change: fn(&mut Value)| {
        changed(|campaign| {
            campaign["measured_at"] = "2026-05-01T08:00:00Z".into();
            change(campaign);
        })
    };
    let other_imu = later(|campaign| campaign["imu"] = "IMU-1".into());
    let other_gyro = later(|campaign| campaign["gyros"][1]["serial"] = "LFG-1".into());
    let same_instant = changed(|_| ());
    for (file, why) in [(&other_imu, "IMU-1"), (&other_gyro, "LFG-1"), (&same_instant, "")] {
        let words = complaint(&["calibrate", CAMPAIGN, path(file)], 1);
        assert!(words.contains(path(file)) && words.contains(CAMPAIGN) && words.contains(why), "{words}");
    }
    let copy = later(|_| ());
    let words = complaint(&["calibrate", CAMPAIGN, path(&copy)], 1);
    assert!(words.contains(path(&copy)) && words.contains("the same to the last digit"), "{words}");
}
