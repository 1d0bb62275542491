use serde_json::{Value, json};

use super::*;
use crate::core::effects::CATALOGUE;
use crate::words::Language;

fn document() -> Value {
    json!({
        "terms": ["bias", "g_linear", "g_squared", "scale"],
        "effects": [{
            "effect": "warmup",
            "gyros": ["G1", "G3"],
            "shape": {"tau_s": 3600.0},
            "estimates": [{"slot": "G1", "name": "k", "value": 0.02, "sd": 1e-3, "unit": "deg/h"}],
        }],
        "provenance": {"imu": "IMU-1", "station": "ST-1", "measured_at": "2026-03-01T08:00:00Z"},
        "plausible_sizes": {"magnetic": 0.5},
    })
}

/// The document with one member replaced.
fn with(pointer: &str, value: Value) -> Vec<u8> {
    let mut document = document();
    *document.pointer_mut(pointer).unwrap() = value;
    document.to_string().into_bytes()
}

#[test]
fn a_model_file_is_read_and_written_without_loss() {
    let model = parse(document().to_string().as_bytes()).unwrap();
    assert_eq!(model.effects[0].adopted.shape, Shape::Tau(3600.0));
    assert_eq!(serde_json::from_str::<Value>(&to_json(&model)).unwrap(), document());
    assert_eq!(parse(to_json(&model).as_bytes()).unwrap(), model);
}

#[test]
fn every_bad_member_is_named_by_its_place() {
    let cases = [
        ("/terms/1", json!("gravity"), "/terms/1"),
        ("/terms/1", json!("bias"), "/terms/1"),
        ("/effects/0/effect", json!("poltergeist"), "/effects/0/effect"),
        ("/effects/0/gyros/1", json!("G4"), "/effects/0/gyros/1"),
        ("/effects/0/gyros/1", json!("G1"), "/effects/0/gyros/1"),
        ("/effects/0/gyros", json!([]), "/effects/0/gyros"),
        ("/effects/0/shape", json!({}), "/effects/0/shape"),
        ("/effects/0/shape", json!({"tau_s": -1.0}), "/effects/0/shape"),
        ("/effects/0/shape", json!({"period_s": 60.0}), "/effects/0/shape"),
        ("/effects/0/shape", json!({"tau_s": 1.0, "dwell": 3}), "/effects/0/shape"),
        ("/effects/0/shape", json!({"tau": 1.0}), "/effects/0/shape/tau"),
        ("/effects/0/estimates/0/slot", json!("G2"), "/effects/0/estimates/0/slot"),
        ("/effects/0/estimates/0/slot", json!("all"), "/effects/0/estimates/0/slot"),
        ("/effects/0/estimates/0/name", json!("q"), "/effects/0/estimates/0/name"),
        ("/effects/0/estimates/0/unit", json!("rad"), "/effects/0/estimates/0/unit"),
        ("/effects/0/estimates/0/value", json!(1e300), "/effects/0/estimates/0/value"),
        ("/effects/0/estimates/0/sd", json!(-1.0), "/effects/0/estimates/0/sd"),
        ("/provenance/measured_at", json!("yesterday"), "/provenance/measured_at"),
        ("/provenance/imu", json!(""), "/provenance/imu"),
        ("/plausible_sizes", json!({"poltergeist": 1.0}), "/plausible_sizes/poltergeist"),
        ("/plausible_sizes", json!({"magnetic": 0.0}), "/plausible_sizes/magnetic"),
        ("/plausible_sizes", json!({"magnetic": 1e300}), "/plausible_sizes/magnetic"),
        ("/plausible_sizes", json!({"outlier_dwell": 1.0}), "/plausible_sizes/outlier_dwell"),
    ];
    for (pointer, value, place) in cases {
        let faults = parse(&with(pointer, value.clone())).expect_err(place);
        assert!(faults.0.iter().any(|f| f.pointer == place), "{pointer} = {value}: {faults}");
    }
}

#[test]
fn a_size_that_is_given_twice_is_refused_and_one_of_an_entry_without_says_which_have_one() {
    let said = |text: &[u8]| {
        let faults = parse(text).expect_err("it is refused");
        (faults.0[0].pointer.clone(), Language::English.words(&faults.0[0].message))
    };
    let twice = document().to_string().replace(r#"{"magnetic":0.5}"#, r#"{"magnetic":0.5,"magnetic":0.6}"#);
    let (place, words) = said(twice.as_bytes());
    assert_eq!((place.as_str(), words.as_str()), ("/plausible_sizes/magnetic", "`magnetic` is given twice"));
    let (_, words) = said(&with("/plausible_sizes", json!({"outlier_dwell": 1.0})));
    assert!(words.starts_with("outlier_dwell has no plausible size; those that have one are "), "{words}");
    let known: Vec<&str> = words.rsplit(" are ").next().unwrap_or_default().split(", ").collect();
    assert!(known.contains(&"warmup") && !known.contains(&"outlier_dwell"), "{words}");
}

#[test]
fn each_entry_of_the_catalogue_can_be_kept_with_every_kind_of_shape_it_has() {
    let shapes = [
        Shape::Linear,
        Shape::Tau(3600.0),
        Shape::Instant(1e4),
        Shape::Dwell(7),
        Shape::Period(5400.0),
        Shape::Azimuth(0.5),
        Shape::Clocking(-1e-3),
        Shape::Only(PRODUCTS[1]),
        Shape::Tilt { with_rate: true },
        Shape::InputSpin,
    ];
    for entry in CATALOGUE {
        let possible: Vec<Shape> = shapes.into_iter().filter(|shape| entry.parameter.takes(*shape)).collect();
        assert!(!possible.is_empty(), "{}", entry.id);
        for shape in possible {
            let adopted = Adopted { effect: entry.effect, shape, slots: Slot::ALL.to_vec() };
            let slot = if entry.scope == Scope::Common { None } else { Some(Slot::G2) };
            let estimates = entry
                .coefficients(shape)
                .iter()
                .map(|c| Estimate { slot, name: c.name, value: 0.25, sd: 0.125, unit: c.unit })
                .collect();
            let model = AugmentedModel {
                terms: None,
                effects: vec![KnownEffect { adopted, estimates }],
                ..AugmentedModel::default()
            };
            assert_eq!(parse(to_json(&model).as_bytes()), Ok(model), "{}", entry.id);
        }
    }
}
