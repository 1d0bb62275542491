//! Two measured campaigns: what they tell, and what their order of orientations cannot.

use crate::command;
use crate::lab::effects;
use crate::support::data_path;
use serde_json::{Value, json};

const XSENS: &str = "measured/xsens-mti.json";
const MIMU: &str = "measured/mimu-imu1-run4.json";

fn diagnose(file: &str, options: &[&str]) -> Value {
    command::answer(&[&["diagnose", data_path(file).to_str().unwrap()], options].concat())
}

fn confounded<'a>(answer: &'a Value, effect: &str) -> Option<&'a Value> {
    let list = answer["not_identifiable"].as_array().unwrap();
    list.iter().find(|n| n["effect"] == effect && n["confounded_with"] == json!(["g_linear"]))
}

#[test]
fn xsens_with_bias_alone_names_g_linear_and_closes_most_of_the_gap() {
    let answer = diagnose(XSENS, &["--model", "bias"]);
    assert_eq!(effects(&answer), ["g_linear"]);
    assert_eq!(answer["effects"][0]["class"], json!(["g_linear"]));
    let closure = answer["effects"][0]["held_out"]["closure"].as_f64().unwrap();
    assert!(closure > 0.9, "an independent leave-one-dwell-out went from 0.056 to 0.013 deg/s, noise 0.009: {closure}");
    assert!(confounded(&answer, "time_ramp").is_none(), "its orientations hardly follow time");
}

#[test]
fn the_mimu_run_says_that_time_and_g_cannot_be_told_apart_and_which_dwells_would() {
    for options in [&[][..], &["--model", "bias"]] {
        let answer = diagnose(MIMU, options);
        let ramp =
            confounded(&answer, "time_ramp").unwrap_or_else(|| panic!("{options:?}: {}", answer["not_identifiable"]));
        // Computed apart from this program (numpy, weighted): 92 to 93 % of a ramp's power beside the bias is in
        // g_linear, 4.6 to 6.2 % is left by the whole model, most of it in G3.
        let visible = ramp["visible_fraction"].as_f64().unwrap();
        assert!((0.06..0.085).contains(&visible), "{ramp}");
        let next = answer["next_dwells"].as_array().unwrap();
        let telling = next.iter().filter(|n| {
            let separates = n["separates"].as_array().unwrap();
            separates.contains(&json!("time_ramp")) && separates.contains(&json!("g_linear"))
        });
        assert!(telling.count() > 0, "{options:?}: {next:?}");
    }
}

#[test]
fn a_campaign_whose_order_hides_nothing_ties_no_course_of_time_to_g() {
    let answer = diagnose("practice/campaign-00.json", &[]);
    for effect in ["time_ramp", "warmup", "bias_step", "temperature_bias"] {
        assert!(confounded(&answer, effect).is_none(), "{effect}");
    }
}
