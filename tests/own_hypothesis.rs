//! A hypothesis of one's own from the command line: asked for, adopted, simulated, checked blind, refused.

use std::fs;

use crate::command::{Folder, answer, complaint, printed, read_json};

const CREEP: &str = "docs/examples/creep.toml";

fn hypothesis(id: &str, equation: &str, unit: &str) -> String {
    format!("id = \"{id}\"\nwords = \"mine\"\nequation = \"{equation}\"\nunit = \"{unit}\"\nplausible = 50.0\n")
}

#[test]
fn what_the_catalogue_lacks_is_named_adopted_and_then_no_gap() {
    let folder = Folder::new();
    let (campaign, model) = (folder.path("creep.json"), folder.path("model.json"));
    printed(&["simulate", "--hypothesis", CREEP, "--detectability", "15", "--seed", "4", "--out", &campaign]);
    let without = answer(&["diagnose", &campaign]);
    assert_ne!(without["verdict"], "no_gap");
    assert!(without.get("hypotheses").is_none());
    let with = answer(&["diagnose", &campaign, "--hypothesis", CREEP, "--adopt", &model]);
    assert_eq!(with["verdict"], "explained", "{with}");
    assert_eq!(with["effects"][0]["effect"], "unbalance_creep");
    assert_eq!(with["effects"].as_array().unwrap().len(), 1);
    assert_eq!(with["hypotheses"][0]["equation"], "k * exp(-t/tau) * a_S");
    let tau = with["effects"][0]["estimates"].as_array().unwrap().iter().find(|e| e["name"] == "tau").unwrap();
    assert!((0.2..=4.0).contains(&tau["value"].as_f64().unwrap()) && tau["unit"] == "h");
    let held = answer(&["diagnose", &campaign, "--model", &model]);
    assert_eq!(held["verdict"], "no_gap");
    // Another IMU that has it, made from the model file alone.
    let other = folder.path("other.json");
    printed(&["simulate", "--model", &model, "--seed", "9", "--out", &other]);
    let again = answer(&["diagnose", &other, "--hypothesis", CREEP]);
    assert_eq!(again["effects"][0]["effect"], "unbalance_creep");
    let imu = folder.path("imu.json");
    printed(&["model", "fit", &campaign, "--hypothesis", CREEP, "--effects", "unbalance_creep", "-o", &imu]);
    let next = folder.path("next.json");
    printed(&["simulate", "--model", &imu, "--seed", "11", "--out", &next]);
    let mut later = read_json(&next);
    later["measured_at"] = "2026-04-01T08:00:00Z".into();
    fs::write(&next, later.to_string()).unwrap();
    let forecast = answer(&["predict", &imu, &next]);
    assert_eq!(forecast["model"]["effects"][0], "unbalance_creep");
}

#[test]
fn one_that_says_what_an_entry_says_shares_its_class() {
    let folder = Folder::new();
    let twin = folder.file("twin.toml", &hypothesis("own_bias", "k * T", "deg/h/K"));
    let campaign = "tests/data/practice/campaign-02.json";
    let answer = answer(&["diagnose", campaign, "--hypothesis", &twin]);
    let effect = &answer["effects"][0];
    let mut class: Vec<&str> = effect["class"].as_array().unwrap().iter().map(|id| id.as_str().unwrap()).collect();
    class.sort_unstable();
    assert_eq!((class, answer["verdict"].as_str()), (vec!["own_bias", "temperature_bias"], Some("explained")));
}

#[test]
fn the_blind_check_says_what_size_a_design_would_find() {
    let folder = Folder::new();
    let slope = folder.file("slope.toml", &hypothesis("own_slope", "k * a_S * t", "deg/(h^2 g0)"));
    let report =
        answer(&["blindcheck", "--hypothesis", &slope, "--count", "6", "--detectability", "2,25", "--seed", "3"]);
    assert_eq!(report["hypothesis"], "own_slope");
    let rows = report["hidden"].as_array().unwrap();
    assert_eq!(rows[1]["named"]["hits"], 6, "{report}");
    assert!(rows[0]["named"]["hits"].as_u64().unwrap() <= 2, "{report}");
    let (small, large) = (rows[0]["size"].as_f64().unwrap(), rows[1]["size"].as_f64().unwrap());
    assert!(small > 0.0 && large > 5.0 * small);
    assert_eq!(report["found_from"].as_f64(), Some(large));
    // 6 of 6 may be 61 % (Wilson): nothing that shows 95 %.
    assert!(report["surely_from"].is_null(), "{report}");
    assert_eq!(report["clean"]["trials"], 6);
    assert!(report["errors"].as_array().unwrap().is_empty());
}

#[test]
fn what_makes_no_sense_is_refused_with_its_place_and_the_way_out() {
    let folder = Folder::new();
    let campaign = "tests/data/practice/campaign-02.json";
    let endless = vec!["k * T"; 1_000_000].join(" + ");
    let deep = format!("k * {}T{}", "(".repeat(100), ")".repeat(100));
    for (equation, unit, said) in [
        ("k * Q * T", "deg/h/K", "at character 5 stands \"Q\""),
        ("k * T / 0", "deg/h/K", "at character 7 something is divided by zero"),
        ("k * T * w_I", "deg/h/K", "the coefficients would have to be in 1/K"),
        ("k + T", "deg/h", "something in deg/h meets something in K"),
        ("k * T", "volts", "\"volts\" is no unit"),
        (endless.as_str(), "deg/h/K", "bytes"),
        (&endless[..8000], "deg/h/K", "an equation may have 1000"),
        (deep.as_str(), "deg/h/K", "more than 32 deep"),
        ("k * __import__(1)", "deg/h", "stands \"_\""),
    ] {
        let file = folder.file("wrong.toml", &hypothesis("wrong", equation, unit));
        let error = complaint(&["diagnose", campaign, "--hypothesis", &file], 1);
        assert!(
            error.contains(said) && error.contains("wrong.toml"),
            "{}: {error}",
            &equation[..20.min(equation.len())]
        );
    }
    // Twelve dwells stand with S horizontal: nothing can be divided by its specific force there.
    let file = folder.file("pole.toml", &hypothesis("pole", "k / (w_I - w_I)", "deg^2/h^2"));
    let error = complaint(&["diagnose", campaign, "--hypothesis", &file], 1);
    assert!(error.contains("no finite value in dwell 0") && error.contains("divides by zero"), "{error}");
    let twice = folder.file("twice.toml", &hypothesis("one", "k * T", "deg/h/K"));
    let error = complaint(&["diagnose", campaign, "--hypothesis", &twice, "--hypothesis", &twice], 1);
    assert!(error.contains("one"), "{error}");
    let error = complaint(&["diagnose", "tests/data/paper.json", "--hypothesis", CREEP], 1);
    assert!(error.contains("a record has no dwells"), "{error}");
}
