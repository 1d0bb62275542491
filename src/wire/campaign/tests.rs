use serde_json::{Value, json};

use super::*;

/// Two dwells (Z up, Z down) and a rate dwell at latitude 0: exact by eye.
fn document() -> Value {
    let earth = 15.041_067;
    json!({
        "imu": "IMU-07", "station": "ST-2", "measured_at": "2026-03-01T08:00:00Z", "geometry": "skewed",
        "site": {"latitude_deg": 0.0, "gravity_g0": 1.0},
        "gyros": [{"slot": "G1", "serial": "A"}, {"slot": "G3", "serial": "B"}],
        "dwells": [
            {"phase": "static", "start_s": 0.0, "duration_s": 180.0, "attitude": [1.0, 0.0, 0.0, 0.0],
             "specific_force_g0": [0.0, 0.0, 1.0], "rate_arcsec_s": [0.0, earth, 0.0], "temperature_c": 45.0,
             "output_pulse_s": [1.0, 2.0], "output_sem_pulse_s": [0.1, 0.2]},
            {"phase": "static", "start_s": 240.0, "duration_s": 180.0, "attitude": [0.0, 1.0, 0.0, 0.0],
             "specific_force_g0": [0.0, 0.0, -1.0], "rate_arcsec_s": [0.0, -earth, 0.0], "temperature_c": 45.1,
             "output_pulse_s": [1.5, 2.5], "output_sem_pulse_s": [0.1, 0.2]},
            {"phase": "rate", "start_s": 480.0, "duration_s": 180.0, "attitude": [1.0, 0.0, 0.0, 0.0],
             "specific_force_g0": [0.0, 0.0, 1.0], "rate_arcsec_s": [0.0, 0.0, 7200.0], "temperature_c": 45.0,
             "output_pulse_s": [1.5, 2.5], "output_sem_pulse_s": [0.1, 0.2]}
        ]
    })
}

fn with(pointer: &str, value: Value) -> Value {
    let mut document = document();
    let (parent, field) = pointer.rsplit_once('/').expect("a pointer");
    match document.pointer_mut(parent).expect("the parent is there") {
        Value::Object(map) => {
            map.insert(field.to_owned(), value);
        }
        Value::Array(list) => list[field.parse::<usize>().expect("an index")] = value,
        other => panic!("{other} has no children"),
    }
    document
}

fn without(pointer: &str) -> Value {
    let mut document = document();
    let (parent, field) = pointer.rsplit_once('/').expect("a pointer");
    document.pointer_mut(parent).and_then(Value::as_object_mut).and_then(|m| m.remove(field)).expect("was there");
    document
}

fn places(document: &Value) -> Vec<String> {
    match parse_json(document.to_string().as_bytes()) {
        Ok(_) => Vec::new(),
        Err(faults) => faults.0.into_iter().map(|f| f.pointer).collect(),
    }
}

#[test]
fn gravity_of_no_place_is_refused_where_it_comes_in_and_not_where_it_is_stored() {
    let text = with("/site/gravity_g0", json!(1.012)).to_string();
    assert!(parse_json(text.as_bytes()).is_ok(), "what is stored is not asked again");
    let faults = parse_json_as_sent(text.as_bytes()).unwrap_err();
    assert_eq!(faults.0[0].pointer, "/site/gravity_g0");
    assert_eq!(faults.0[0].message.code, "gravity_of_no_place");
    assert_eq!(faults.0[0].message.parameter("normal"), Some(&figure(0.9973, 4)));
}

#[test]
fn a_sound_campaign_is_read_and_written_back() {
    let campaign = parse_json(document().to_string().as_bytes()).expect("sound");
    assert_eq!(campaign.dwells.len(), 3);
    assert_eq!(campaign.gyros[1].slot, Slot::G3);
    let again = parse_json(to_json(&campaign).as_bytes()).expect("what is written can be read");
    assert_eq!(again, campaign);
    let written: Value = serde_json::from_str(&to_json(&campaign)).expect("JSON");
    assert_eq!(written, document());
}

#[test]
fn every_fault_is_named_by_its_pointer() {
    for (pointer, value) in [
        ("/dwells/1/colour", json!("red")),
        ("/dwells/1/start_s", json!("240")),
        ("/dwells/1/rate_arcsec_s/2", Value::Null),
        ("/dwells/1/rate_arcsec_s", json!([0.0, 1.0])),
        ("/dwells/1/specific_force_g0", json!([0.0, 0.0, -1.0, 0.0])),
        ("/dwells/1/specific_force_g0", json!([0.0, 0.0, -1.0, 0.0, 1.0, 2.0])),
        ("/dwells/1/output_pulse_s", json!([1.0, 2.0, 3.0])),
        ("/dwells/1/output_sem_pulse_s", json!([1.0])),
        ("/dwells/1/output_pulse_s/1", json!(1e300)),
        ("/dwells/1/output_sem_pulse_s/1", json!(0.0)),
        ("/dwells/1/output_sem_pulse_s/0", json!(-0.1)),
        ("/dwells/1/duration_s", json!(0.0)),
        ("/dwells/1/duration_s", json!(-180.0)),
        ("/dwells/1/start_s", json!(100.0)),
        ("/dwells/1/phase", json!("still")),
        ("/dwells/1/attitude", json!([0.0, 1.01, 0.0, 0.0])),
        ("/dwells/1/attitude", json!([1.0, 0.0, 0.0, 0.0])),
        ("/dwells/1/specific_force_g0", json!([0.0, 0.0, -0.95])),
        ("/dwells/1/rate_arcsec_s", json!([0.0, 0.0, 3600.0])),
        ("/dwells/1/temperature_c", json!(-300.0)),
        ("/site/latitude_deg", json!(91.0)),
        ("/site/gravity_g0", json!(9.797)),
        ("/gyros/1/slot", json!("G4")),
        ("/gyros/1/slot", json!("G1")),
        ("/gyros/1/serial", json!("A")),
        ("/gyros/1/serial", json!("")),
        ("/gyros/1/known_e_pulse_per_arcsec", json!([1.0, 0.0, 0.0])),
        ("/measured_at", json!("2026-03-01T08:00:00")),
        ("/geometry", json!("tilted")),
        ("/test", json!("spin")),
        ("/model", json!(["jerk"])),
        ("/model", json!(["bias", "bias"])),
        ("/model", json!([])),
        ("/operator", json!("a\u{7}")),
    ] {
        let found = places(&with(pointer, value.clone()));
        assert!(found.len() == 1 && found[0].starts_with(pointer), "{pointer} = {value}: {found:?}");
    }
}

#[test]
fn what_is_missing_is_named() {
    for pointer in ["/imu", "/dwells/2/output_pulse_s", "/gyros/0/slot", "/site/gravity_g0"] {
        assert_eq!(places(&without(pointer)), [pointer]);
    }
}

#[test]
fn dwells_out_of_time_order_are_named() {
    let mut document = document();
    document["dwells"].as_array_mut().expect("a list").swap(1, 2);
    assert_eq!(places(&document), ["/dwells/2/start_s"]);
}

#[test]
fn all_faults_are_told_at_once() {
    let mut document = with("/dwells/0/duration_s", json!(-1.0));
    document["dwells"][1]["rate_arcsec_s"] = json!([1.0]);
    document["dwells"][2]["output_sem_pulse_s"] = json!([0.0, 0.1]);
    document["station"] = json!("");
    assert_eq!(
        places(&document),
        ["/station", "/dwells/1/rate_arcsec_s", "/dwells/0/duration_s", "/dwells/2/output_sem_pulse_s/0"]
    );
}

#[test]
fn a_bench_test_has_one_gyro_and_needs_no_slot() {
    let mut document = with("/test", json!("torque_feedback"));
    assert_eq!(places(&document), ["/gyros"]);
    document["gyros"] = json!([{"serial": "A"}]);
    document["geometry"] = json!({"input": [1, 0, 0], "spin": [0, 0, 1]});
    for dwell in document["dwells"].as_array_mut().expect("a list") {
        dwell["output_pulse_s"] = json!([1.0]);
        dwell["output_sem_pulse_s"] = json!([0.1]);
    }
    assert_eq!(places(&document), Vec::<String>::new());
    document["geometry"] = json!({"input": [1, 0, 0], "spin": [1, 0, 0]});
    assert_eq!(places(&document), ["/geometry/spin"]);
    document["geometry"] = json!({"input": [1, 0, 0]});
    assert_eq!(places(&document), ["/geometry/spin"]);
}

#[test]
fn a_missing_column_is_fine_and_its_check_is_said_to_be_skipped() {
    let mut document = document();
    for dwell in document["dwells"].as_array_mut().expect("a list") {
        let dwell = dwell.as_object_mut().expect("an object");
        for column in ["attitude", "temperature_c", "output_sem_pulse_s"] {
            dwell.remove(column);
        }
    }
    let campaign = parse_json(document.to_string().as_bytes()).expect("all three are optional");
    assert_eq!(notes(&campaign), ["no_attitudes", "no_temperatures"]);
}

fn notes(campaign: &Campaign) -> Vec<&'static str> {
    crate::core::campaign::notes(campaign).iter().map(crate::core::note::Note::code).collect()
}

#[test]
fn a_column_may_be_missing_in_some_dwells() {
    for (column, code) in [
        ("attitude", "attitudes_missing"),
        ("temperature_c", "temperatures_missing"),
        ("output_sem_pulse_s", "standard_errors_missing"),
    ] {
        let document = without(&format!("/dwells/1/{column}"));
        let campaign = parse_json(document.to_string().as_bytes()).expect("it may be missing");
        assert_eq!(notes(&campaign), [code]);
        let note = crate::wire::note::NoteBody::of(&crate::core::campaign::notes(&campaign)[0]);
        assert_eq!(note.parameters["pointers"], json!([format!("/dwells/1/{column}")]));
        assert!(note.detail.contains("1 of 3 dwells (/dwells/1)"), "{}", note.detail);
        let csv = crate::wire::campaign_csv::to_csv(&campaign);
        assert_eq!(crate::wire::campaign_csv::parse_csv(csv.as_bytes()).expect("empty cells"), campaign, "{csv}");
    }
}

/// Six static dwells of these durations and six of 180 s that turn, the last of each without standard errors; those of
/// G1 and G3 are 0.1 and 0.2 times what `law` says of their duration and share of the rate.
fn with_two_missing(durations: [f64; 6], law: impl Fn(f64, f64) -> f64) -> (Campaign, [[f64; 2]; 2]) {
    let mut document = document();
    let (still, turning) = (document["dwells"][0].clone(), document["dwells"][2].clone());
    let rates = [3600.0, -3600.0, 7200.0, -7200.0, 1800.0, 7200.0];
    let still = durations.map(|duration| (&still, duration, 0.0));
    let mut expected = [[0.0; 2]; 2];
    let dwells = still.into_iter().chain(rates.map(|rate| (&turning, 180.0, rate))).enumerate();
    let dwells = dwells.map(|(k, (dwell, duration, rate))| {
        let mut dwell = dwell.clone();
        dwell["start_s"] = json!(1000.0 * k as f64);
        dwell["duration_s"] = json!(duration);
        if rate != 0.0 {
            dwell["rate_arcsec_s"] = json!([0.0, 0.0, rate]);
        }
        // Half of the square of a rate about z lies along the input axis of G1, none along that of G3.
        let sems = [0.1 * law(duration, 0.5 * (rate / 7200.0_f64).powi(2)), 0.2 * law(duration, 0.0)];
        dwell["output_sem_pulse_s"] = json!(sems);
        if k % 6 == 5 {
            expected[k / 6] = sems;
            dwell.as_object_mut().expect("an object").remove("output_sem_pulse_s");
        }
        dwell
    });
    document["dwells"] = dwells.collect();
    (parse_json(document.to_string().as_bytes()).expect("sound"), expected)
}

fn filled_in(campaign: &Campaign) -> [[f64; 2]; 2] {
    [5, 11].map(|k| [0, 1].map(|j| campaign.errors_of(j).expect("stated")[k]))
}

#[test]
fn a_dwell_without_standard_errors_gets_them_by_the_law_of_the_others() {
    let unequal = [60.0, 180.0, 600.0, 60.0, 180.0, 600.0];
    for (fall, growth) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.5), (1.0, 4.0)] {
        let (campaign, expected) =
            with_two_missing(unequal, |duration, x| ((1.0 + growth * x) * (180.0 / duration).powf(fall)).sqrt());
        for (found, expected) in filled_in(&campaign).iter().flatten().zip(expected.iter().flatten()) {
            assert!((found / expected - 1.0).abs() < 0.06, "{found} is not {expected}: {fall}, {growth}");
        }
    }
}

#[test]
fn a_standard_error_is_wider_where_the_others_do_not_tell_the_law() {
    // A quarter of the only duration that is told: once, the root of two or twice the others' error, whichever law
    // holds; in the mean of squares 7/3 of its square.
    let (campaign, _) = with_two_missing([180.0, 180.0, 180.0, 180.0, 180.0, 45.0], |_, _| 1.0);
    let [[g1, g3], _] = filled_in(&campaign);
    let wider = (7.0_f64 / 3.0).sqrt();
    assert!((g1 / (0.1 * wider) - 1.0).abs() < 0.02 && (g3 / (0.2 * wider) - 1.0).abs() < 0.02, "{g1} {g3}");
}

#[test]
fn the_service_adds_the_earths_rate_to_rates_of_the_table() {
    let mut document = document();
    document["site"]["latitude_deg"] = json!(30.0);
    document["rates"] = json!("table");
    for k in [0, 1] {
        document["dwells"][k]["rate_arcsec_s"] = json!([0.0, 0.0, 0.0]);
    }
    let campaign = parse_json(document.to_string().as_bytes()).expect("sound");
    // 15.041067 arcsec/s: half of it up, 0.8660254 of it north; the second dwell is turned over about east.
    let expected = [[0.0, 13.025_946, 7.520_534], [0.0, -13.025_946, -7.520_534], [0.0, 0.0, 7_207.520_534]];
    for (dwell, expected) in campaign.dwells.iter().zip(expected) {
        let off = (dwell.rate_arcsec_s - nalgebra::Vector3::from(expected)).norm();
        assert!(off < 1e-5, "{:?} {expected:?}", dwell.rate_arcsec_s);
    }
    document["dwells"][1].as_object_mut().expect("an object").remove("attitude");
    let fault = |document: &Value| parse_json(document.to_string().as_bytes()).unwrap_err().0.remove(0);
    assert_eq!(fault(&document).pointer, "/rates");
    let lacks = |document: &Value| fault(document).message.to_string();
    let attitudes = "attitudes_missing (count: 1, first: /dwells/1)";
    assert_eq!(lacks(&document), format!("earth_rate_needs (missing: {attitudes})"));
    document.as_object_mut().expect("an object").remove("site");
    assert_eq!(lacks(&document), format!("earth_rate_needs (missing: site_missing, {attitudes})"));
    assert_eq!(places(&with("/rates", json!("relative"))), ["/rates"]);
}

#[test]
fn a_rate_that_is_not_the_earths_at_attitude_and_site_is_told_of() {
    let oddities = |document: &Value| -> Vec<String> {
        let campaign = parse_json(document.to_string().as_bytes()).expect("no fault");
        let notes = crate::core::campaign::notes(&campaign);
        let of_rate = notes.iter().filter(|note| note.code() == "rate_not_of_attitude");
        of_rate.map(|note| crate::wire::note::NoteBody::of(note).detail).collect()
    };
    assert_eq!(oddities(&document()), [""; 0]);
    assert_eq!(oddities(&with("/dwells/1/rate_arcsec_s", json!([0.4, -15.041, 0.0]))), [""; 0]);
    let turned = with("/dwells/1/rate_arcsec_s", json!([0.0, 15.041_067, 0.0]));
    let words = "rate_arcsec_s of 1 of 2 static dwells is not the Earth's at their attitude and the site's latitude: by 30.08 arcsec/s \
                 in /dwells/1";
    assert_eq!(oddities(&turned), [words]);
    let mut unknown = turned;
    unknown.as_object_mut().expect("an object").remove("site");
    assert_eq!(oddities(&unknown), [""; 0], "where the Earth's rate is not known nothing is said");
}

#[test]
fn times_in_minutes_hours_or_milliseconds_are_told_of() {
    let told = |unit: f64, with_turns: bool| {
        let mut document = document();
        for dwell in document["dwells"].as_array_mut().expect("dwells") {
            for time in ["start_s", "duration_s"] {
                dwell[time] = (dwell[time].as_f64().expect("a number") * unit).into();
            }
        }
        if !with_turns {
            document["dwells"].as_array_mut().expect("dwells").pop();
        }
        let campaign = parse_json(document.to_string().as_bytes()).expect("no fault");
        let notes = crate::core::campaign::notes(&campaign);
        let note = notes.iter().find(|note| note.code() == "time_unit");
        note.map(|note| crate::wire::note::NoteBody::of(note).parameters)
    };
    // A turn at 2 deg/s takes 180 s: 3 min.
    assert_eq!(json!(told(1.0 / 60.0, true)), json!({"median_s": 3.0, "turn_deg": 6.0}));
    assert_eq!(json!(told(1.0 / 3600.0, false)), json!({"median_s": 0.05}));
    assert_eq!(json!(told(1000.0, true)), json!({"median_s": 180_000.0}));
    // Without turns three seconds may be what they say.
    assert!([(1.0, true), (1.0, false), (0.26, true), (1.0 / 60.0, false)].iter().all(|(u, t)| told(*u, *t).is_none()));
}

#[test]
fn temperatures_in_another_unit_are_told_of() {
    let told = |celsius: f64| {
        let mut document = document();
        (0..3).for_each(|k| document["dwells"][k]["temperature_c"] = json!(celsius));
        let campaign = parse_json(document.to_string().as_bytes()).expect("no fault");
        crate::core::campaign::notes(&campaign).iter().any(|note| note.code() == "temperature_unit")
    };
    assert!([318.15, 113.0, -80.0].into_iter().all(told));
    assert!(![-40.0, 23.0, 75.0].into_iter().any(told));
}

#[test]
fn numbers_beyond_a_double_are_refused_at_their_place() {
    let text = document().to_string().replacen("180.0", "1e999", 1);
    let faults = parse_json(text.as_bytes()).unwrap_err();
    assert_eq!(faults.0[0].pointer, "/dwells/0/duration_s");
}

/// A campaign of the laboratory with other outputs of G2 from the dwell `first` on.
fn with_g2(first: usize, change: impl Fn(f64) -> f64) -> Result<Campaign, Faults> {
    let mut document: Value =
        serde_json::from_str(include_str!("../../../tests/data/practice/campaign-00.json")).expect("sound");
    for dwell in document["dwells"].as_array_mut().expect("a list").iter_mut().skip(first) {
        dwell["output_pulse_s"][1] = json!(change(dwell["output_pulse_s"][1].as_f64().expect("a number")));
    }
    parse_json_as_sent(document.to_string().as_bytes())
}

#[test]
fn a_gyro_that_gives_nothing_is_refused_by_its_slot() {
    for value in [0.0, 12.5] {
        let fault = with_g2(0, |_| value).unwrap_err().0.remove(0);
        assert_eq!((fault.pointer.as_str(), fault.message.code.as_ref()), ("/gyros/1", "output_is_constant"));
    }
}

#[test]
fn a_gyro_that_stops_is_named_with_the_dwell_whether_its_scale_still_can_be_or_not() {
    assert!(!notes(&with_g2(0, |y| y).expect("sound")).contains(&"output_stuck"));
    for first in [30, 66] {
        match with_g2(first, |_| 12.5) {
            Ok(campaign) => assert!(notes(&campaign).contains(&"output_stuck"), "{first}"),
            Err(faults) => {
                let place = format!("/dwells/{first}/output_pulse_s");
                assert_eq!((&faults.0[0].pointer, faults.0[0].message.code.as_ref()), (&place, "output_stuck"));
            }
        }
    }
}
