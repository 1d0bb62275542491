//! Raw campaigns over HTTP and on the command line: fitted, stored whole, judged, diagnosed; or refused by name.

use crate::{command, lab};
use reqwest::Method;
use reqwest::header::CONTENT_TYPE;
use serde_json::{Value, json};

use crate::lab::{Answer, JSON, Lab, assert_close, tables_3_and_4, verdict};
use crate::support::{data_path, document, with_member};
use gyrowatch::config::StatedUncertainty;

const CSV: &str = "text/csv";

/// Practice campaign 0: no hidden effect; the key has its D_I and D_S.
fn campaign() -> Value {
    document("practice/campaign-00.json")
}

/// D_I and D_S of the key.
const KEY: [(&str, f64, f64); 1] = [("LFG-9000-1", 3.526959, 0.145471)];

/// The same as a table, every number as it stands in the JSON.
fn csv(campaign: &Value) -> String {
    let dwells = campaign["dwells"].as_array().unwrap();
    let head = campaign.as_object().unwrap().iter().filter(|(key, _)| *key != "dwells");
    let mut text: String = head
        .map(|(key, value)| format!("# {key}: {}\n", value.as_str().map_or_else(|| value.to_string(), str::to_owned)))
        .collect();
    let columns = |value: &Value| value.as_array().map_or(1, Vec::len);
    let names = dwells[0].as_object().unwrap().iter().flat_map(|(field, value)| {
        let suffixes: &[&str] = match field.as_str() {
            "attitude" => &["_w", "_x", "_y", "_z"],
            field if field.starts_with("output") => &["_1", "_2", "_3"],
            _ if value.is_array() => &["_x", "_y", "_z"],
            _ => &[""],
        };
        suffixes[..columns(value)].iter().map(move |suffix| format!("{field}{suffix}"))
    });
    text.push_str(&names.collect::<Vec<_>>().join(","));
    for dwell in dwells {
        let cells = dwell.as_object().unwrap().values().flat_map(|value| match value {
            Value::Array(list) => list.iter().map(Value::to_string).collect(),
            Value::String(text) => vec![text.clone()],
            number => vec![number.to_string()],
        });
        text.push_str(&format!("\n{}", cells.collect::<Vec<String>>().join(",")));
    }
    text + "\n"
}

/// The first gyro of the campaign as a polar-axis tumble on a bench: its static dwells.
fn bench_test() -> Value {
    let mut campaign = campaign();
    campaign["test"] = "torque_feedback".into();
    campaign["geometry"] =
        serde_json::from_str(r#"{"input": [0.57735, -0.40825, 0.70711], "spin": [0, 0.866025, 0.5]}"#).unwrap();
    campaign["gyros"] = json!([{"serial": "LFG-9000-1"}]);
    let dwells = campaign["dwells"].as_array_mut().unwrap();
    dwells.retain(|dwell| dwell["phase"] == "static");
    for column in ["output_pulse_s", "output_sem_pulse_s"] {
        dwells.iter_mut().for_each(|dwell| dwell[column].as_array_mut().unwrap().truncate(1));
    }
    campaign
}

async fn posts(lab: &Lab, campaign: &Value) -> Answer {
    lab.post("/v1/campaigns", campaign).await
}

/// Cut within its last number a table reads as a whole one.
#[tokio::test]
async fn a_table_whose_last_line_has_no_end_is_stored_with_a_note() {
    let lab = Lab::open().await;
    let table = csv(&campaign());
    let lines = table.lines().count();
    let cut = table.trim_end();
    let last = cut.rsplit(',').next().unwrap();
    let answer = lab.post_text("/v1/campaigns", CSV, cut.to_owned()).await.created();
    let note = answer["notes"].as_array().unwrap().iter().find(|note| note["code"] == "no_line_end").expect("a note");
    assert_eq!((&note["line"], &note["value"]), (&json!(lines), &json!(last)));
    assert!(note["detail"].as_str().unwrap().contains(&format!("line {lines}, the last,")), "{note}");
    let later = table.replacen("2026-03-01", "2026-03-08", 1);
    let answer = lab.post_text("/v1/campaigns", CSV, later).await.created();
    assert!(!answer.to_string().contains("no_line_end"), "{answer}");
}

#[tokio::test]
async fn a_campaign_is_fitted_separated_judged_and_kept_whole() {
    let lab = Lab::open().await;
    let sent = campaign();
    let answer = posts(&lab, &sent).await;
    let location = answer.header("location").to_owned();
    let answer = answer.created();
    assert_eq!(location, format!("/v1/campaigns/{}", answer["id"].as_str().unwrap()));
    for (serial, d_i, d_s) in KEY {
        let separations = answer["separations"].as_array().unwrap();
        let separated = separations.iter().find(|s| s["serial"] == serial).unwrap();
        for (name, truth) in [("d_i", d_i), ("d_s", d_s)] {
            let sd = separated[name]["sd"].as_f64().unwrap();
            assert!(sd > 0.0 && sd < 2e-3, "{name}: the sigma of the fit, not {sd}");
            assert_close(&separated[name]["value"], truth, 3.0 * sd);
        }
        verdict(&answer, serial, "D_I", "step");
    }
    let fitted = &answer["calibration"]["gyros"][0];
    assert_eq!(fitted["covariance"].as_array().unwrap().len(), 10);
    assert_eq!(fitted["residuals"]["leverage"].as_array().unwrap().len(), 78);
    assert_eq!((&fitted["rank"], &fitted["null_directions"][0]["gauge"]), (&json!(9), &json!("P_x + P_y + P_z = 0")));
    let stored = lab.get(&location).await.ok();
    assert_eq!(stored["campaign"], sent);
    let as_a_point_names_it = lab.get(&location.replace("campaigns", "records")).await;
    assert_eq!((as_a_point_names_it.status, as_a_point_names_it.header("location")), (308, &*location));
    assert_eq!(stored["calibration"], answer["calibration"]);
    assert_eq!(stored["separations"], answer["separations"]);
    assert_eq!(stored["verdicts"], answer["verdicts"]);
}

#[tokio::test]
async fn a_campaign_and_a_record_share_one_history() {
    let mut lab = Lab::open().await;
    let first = posts(&lab, &campaign()).await.created();
    let mut later = campaign();
    later["measured_at"] = "2026-04-01T08:00:00Z".into();
    let second = posts(&lab, &later).await.created();
    // The same dwells a month later: a step of nothing, with the sigma of both fits.
    let step = verdict(&second, "LFG-9000-1", "D_I", "step");
    assert_eq!(step["state"], "within");
    let sd = first["separations"][0]["d_i"]["sd"].as_f64().unwrap();
    assert_close(&step["sd"], sd * f64::sqrt(2.0), 1e-9);
    let trend = lab.sees_trend("LFG-9000-1", "coefficient=D_I").await;
    assert_eq!(trend.len(), 2);
    assert_close(&trend[0]["sd"], sd, 1e-12);
    assert_eq!(trend[1]["record"], second["id"]);
    lab.restart().await;
    assert_eq!(lab.sees_trend("LFG-9000-1", "coefficient=D_I").await, trend);
}

#[tokio::test]
async fn what_a_station_states_of_itself_is_in_what_is_judged_and_kept() {
    let stated = |station: Option<&str>, levelling_arcsec, azimuth_arcsec| StatedUncertainty {
        station: station.map(str::to_owned),
        levelling_arcsec,
        azimuth_arcsec,
        fixture_arcsec: None,
    };
    let everywhere = stated(None, Some(40.0), Some(30.0));
    let of_others = stated(Some("ST-B"), Some(900.0), None);
    let lab = Lab::with(|config| config.stations.uncertainty = vec![everywhere, of_others]).await;
    let mut sent = campaign();
    sent["station_uncertainty"] = json!({"levelling_arcsec": 20.0});
    let answer = posts(&lab, &sent).await.created();
    let said = json!({"stated": true, "levelling_arcsec": 20.0, "azimuth_arcsec": 30.0});
    assert_eq!(answer["calibration"]["station_uncertainty"], said);
    let d_i = &answer["separations"][0]["uncertainty"]["d_i"];
    let part = |name: &str| d_i[name].as_f64().unwrap();
    // Levelling moves D_I by Omega cos L a radian: 20 arcsec at 34.25 deg are 0.0012 deg/(h g0). But for the repeats,
    // which are not in all headings, azimuths cancel.
    assert!((part("levelling") / 1.2055e-3 - 1.0).abs() < 0.05, "{d_i}");
    assert!(part("azimuth") < 0.1 * part("levelling"), "{d_i}");
    let squares = part("statistical").powi(2) + part("station").powi(2) + part("discrepancy").powi(2);
    assert_close(&d_i["combined"], squares.sqrt(), 1e-12);
    assert_close(&answer["separations"][0]["d_i"]["sd"], part("combined"), 1e-12);
    let trend = lab.sees_trend("LFG-9000-1", "coefficient=D_I").await;
    assert_close(&trend[0]["sd"], part("combined"), 1e-12);
    let id = answer["id"].as_str().unwrap();
    let kept = lab.get(&format!("/v1/campaigns/{id}")).await.ok();
    assert_eq!(kept["separations"], answer["separations"]);
    sent["measured_at"] = "2026-04-01T08:00:00Z".into();
    let later = posts(&lab, &sent).await.created();
    assert_close(&verdict(&later, "LFG-9000-1", "D_I", "step")["sd"], part("combined") * f64::sqrt(2.0), 1e-9);
}

#[tokio::test]
async fn sending_again_is_harmless_in_either_form_and_other_content_is_a_conflict() {
    let lab = Lab::open().await;
    let sent = campaign();
    let id = posts(&lab, &sent).await.created()["id"].clone();
    assert_eq!(posts(&lab, &sent).await.ok()["id"], id);
    assert_eq!(lab.post_text("/v1/campaigns", CSV, csv(&sent)).await.ok()["id"], id);
    let pretty = serde_json::to_string_pretty(&sent).unwrap();
    assert_eq!(lab.post_text("/v1/campaigns", JSON, pretty).await.ok()["id"], id);
    assert_eq!(lab.imports(std::slice::from_ref(&sent)).await[0], json!({"line": 1, "status": 200, "id": id}));
    // Its gyros in another order, each with its outputs, are the same dwells.
    let mut turned = sent.clone();
    turned["gyros"].as_array_mut().unwrap().rotate_left(1);
    for dwell in turned["dwells"].as_array_mut().unwrap() {
        for list in ["output_pulse_s", "output_sem_pulse_s"] {
            if let Some(outputs) = dwell.get_mut(list) {
                outputs.as_array_mut().unwrap().rotate_left(1);
            }
        }
    }
    assert_eq!(posts(&lab, &turned).await.ok()["id"], id);
    turned["dwells"][7]["output_pulse_s"][0] = json!(5.79);
    turned["station"] = json!("ST-9");
    let mut differing = posts(&lab, &turned).await.refused(409);
    differing.sort();
    assert_eq!(differing, ["/dwells/7/output_pulse_s/0", "/station"]);
    let mut other = sent.clone();
    other["dwells"][7]["output_pulse_s"][1] = json!(5.79);
    assert_eq!(posts(&lab, &other).await.refused(409), ["/dwells/7/output_pulse_s/1"]);
    assert_eq!(lab.sees_trend("LFG-9000-1", "coefficient=D_S").await.len(), 1);
}

#[tokio::test]
async fn a_csv_from_a_spreadsheet_is_taken_as_well() {
    let lab = Lab::open().await;
    let text = format!("\u{feff}{}", csv(&campaign()).replace('\n', "\r\n"));
    let answer = lab.post_text("/v1/campaigns", CSV, text).await.created();
    let by_json = Lab::open().await;
    assert_eq!(answer["separations"], posts(&by_json, &campaign()).await.created()["separations"]);
    let stored = lab.get(&format!("/v1/campaigns/{}", answer["id"].as_str().unwrap())).await.ok();
    assert_eq!(stored["campaign"], campaign());
}

#[tokio::test]
async fn a_raw_bench_test_becomes_a_bench_result_beside_the_separation() {
    let lab = Lab::open().await;
    posts(&lab, &campaign()).await.created();
    let answer = posts(&lab, &bench_test()).await;
    let location = answer.header("location").to_owned();
    let answer = answer.created();
    assert_eq!(location, format!("/v1/bench-results/{}", answer["id"].as_str().unwrap()));
    assert_eq!(posts(&lab, &bench_test()).await.ok()["id"], answer["id"]);
    let stored = lab.get(&location).await.ok();
    assert_eq!(stored["bench_result"], answer["bench_result"]);
    assert_eq!(stored["campaign"], bench_test());
    let agreement = lab.get("/v1/gyros/LFG-9000-1/agreement").await.ok();
    let methods: Vec<&Value> = agreement["results"].as_array().unwrap().iter().map(|r| &r["method"]).collect();
    assert!(methods.contains(&&json!("rigid")) && methods.contains(&&json!("torque_feedback")), "{agreement}");
    assert!(agreement["range"]["D_I"].as_f64().unwrap() < 5e-3, "the same dwells, the same drift: {agreement}");
}

#[tokio::test]
async fn a_bench_test_that_gave_next_to_no_output_has_no_scale_to_divide_by() {
    let lab = Lab::open().await;
    for one_output in [0.0, 1e-306] {
        let mut silent = bench_test();
        for (number, dwell) in silent["dwells"].as_array_mut().unwrap().iter_mut().enumerate() {
            dwell["output_pulse_s"] = json!([if number == 3 { one_output } else { 0.0 }]);
            dwell.as_object_mut().unwrap().remove("output_sem_pulse_s");
        }
        assert_eq!(posts(&lab, &silent).await.refused(422), ["/dwells"]);
    }
}

#[tokio::test]
async fn what_cannot_be_separated_is_fitted_stored_and_named() {
    let lab = Lab::open().await;
    let mut slow = campaign();
    slow["model"] = json!(["bias", "g_linear"]);
    let answer = posts(&lab, &slow).await.created();
    assert_eq!(answer["calibration"]["model"], json!(["bias", "g_linear"]));
    assert_eq!(answer["separations"], json!([]));
    let reasons = answer["not_separated"].as_array().unwrap();
    assert!(reasons.iter().all(|r| r["reason"].as_str().unwrap().contains("known_e_pulse_per_arcsec")), "{answer}");
    let mut held = campaign();
    held["measured_at"] = "2026-03-02T08:00:00Z".into();
    held["dwells"].as_array_mut().unwrap().retain(|dwell| dwell["phase"] == "static");
    for (j, gyro) in answer["calibration"]["gyros"].as_array().unwrap().iter().enumerate() {
        assert_eq!(gyro["e_source"], "missing");
        let whole = posts(&Lab::open().await, &campaign()).await.created();
        held["gyros"][j]["known_e_pulse_per_arcsec"] = whole["calibration"]["gyros"][j]["e_pulse_per_arcsec"].clone();
    }
    let answer = posts(&lab, &held).await.created();
    assert_eq!(answer["calibration"]["gyros"][0]["e_source"], "held");
    assert_close(&answer["separations"][0]["d_i"]["value"], KEY[0].1, 5e-3);
}

#[tokio::test]
async fn designs_that_show_too_little_are_answered_with_what_is_missing() {
    let lab = Lab::open().await;
    let of = |keep: fn(usize, &Value) -> bool, minute: usize| {
        let mut campaign = campaign();
        campaign["measured_at"] = format!("2026-03-01T09:{minute:02}:00Z").into();
        let mut index = 0;
        campaign["dwells"].as_array_mut().unwrap().retain(|dwell| {
            index += 1;
            keep(index - 1, dwell)
        });
        campaign
    };
    let designs: [fn(usize, &Value) -> bool; 4] = [
        |k, _| k < 3,
        |_, dwell| dwell["specific_force_g0"] == json!([0.0, 0.0, -0.99905]),
        |k, _| k == 0,
        |_, dwell| dwell["phase"] == "rate",
    ];
    for (minute, keep) in designs.into_iter().enumerate() {
        let answer = posts(&lab, &of(keep, minute)).await.created();
        let fitted = answer["calibration"]["gyros"].as_array().unwrap();
        assert!(fitted.iter().all(|gyro| gyro["rank"].as_u64().unwrap() < 10));
        let named = answer["separations"].as_array().unwrap().len() + answer["not_separated"].as_array().unwrap().len();
        assert_eq!(named, 3, "each gyro is separated or the reason is given: {answer}");
        lab.get(&format!("/v1/campaigns/{}", answer["id"].as_str().unwrap())).await.ok();
        let diagnosis = lab.diagnosis(answer["id"].as_str().unwrap()).await;
        assert!([200, 422].contains(&diagnosis.status), "{}", diagnosis.text);
    }
}

#[tokio::test]
async fn the_diagnosis_of_a_stored_campaign_is_the_command_lines() {
    let mut lab = Lab::open().await;
    let path = data_path("practice/campaign-03.json");
    let sent = document("practice/campaign-03.json");
    let id = posts(&lab, &sent).await.created()["id"].as_str().unwrap().to_owned();
    let diagnosis = lab.diagnosis(&id).await.ok();
    let printed = command::answer(&["diagnose", path.to_str().unwrap()]);
    let mut alone = diagnosis.clone();
    // What was foretold of a campaign follows from the stored ones before it.
    assert!(alone.as_object_mut().unwrap().remove("forecast").is_some());
    assert_eq!(alone, printed);
    lab.restart().await;
    assert_eq!(lab.diagnosis(&id).await.ok(), diagnosis);
    lab.get("/v1/campaigns/0000000000000/diagnosis").await.refused(404);
    let record = lab.posts(&lab::tables_3_and_4()).await;
    let id = record["id"].as_str().unwrap();
    lab.get(&format!("/v1/campaigns/{id}")).await.refused(404);
    lab.diagnosis(id).await.refused(404);
}

/// One fault and its place: put into the JSON, it is refused by its pointer, over HTTP and on the command line.
fn bad_members() -> Vec<(&'static str, &'static str, Value)> {
    vec![
        ("a dwell that overlaps the one before", "/dwells/1/start_s", json!(100.0)),
        ("a dwell out of time order", "/dwells/5/start_s", json!(240.0)),
        ("no duration", "/dwells/1/duration_s", json!(0.0)),
        ("a negative duration", "/dwells/1/duration_s", json!(-180.0)),
        ("an attitude that is no unit quaternion", "/dwells/1/attitude", json!([-0.5, 0.5, 0.5, 0.6])),
        ("an attitude that contradicts the specific force", "/dwells/1/attitude", json!([1.0, 0.0, 0.0, 0.0])),
        ("a specific force far from gravity", "/dwells/1/specific_force_g0", json!([0.0, 0.9, 0.0])),
        ("a static dwell that turns", "/dwells/1/rate_arcsec_s", json!([0.0, 3600.0, 0.0])),
        ("a standard error of zero", "/dwells/1/output_sem_pulse_s/2", json!(0.0)),
        ("a negative standard error", "/dwells/1/output_sem_pulse_s/2", json!(-0.001)),
        ("two components", "/dwells/1/rate_arcsec_s", json!([0.0, 1.0])),
        ("four outputs", "/dwells/1/output_pulse_s", json!([1.0, 2.0, 3.0, 4.0])),
        ("a number as text", "/dwells/1/start_s", json!("240")),
        ("null", "/dwells/1/rate_arcsec_s/2", Value::Null),
        ("an unknown phase", "/dwells/1/phase", json!("still")),
        ("an unknown member", "/dwells/1/colour", json!("red")),
        ("an unknown term", "/model/1", json!(["bias", "jerk"])),
        ("an unknown test", "/test", json!("spin")),
        ("a serial twice", "/gyros/1/serial", json!("LFG-9000-1")),
        ("no dwells", "/dwells", json!([])),
        ("a time without offset", "/measured_at", json!("2026-03-01T08:00:00")),
        ("a negative uncertainty", "/station_uncertainty/fixture_arcsec", json!(-1.0)),
        ("an uncertainty of degrees", "/station_uncertainty/fixture_arcsec", json!(7200.0)),
        ("gravity of no place", "/site/gravity_g0", json!(0.985)),
        ("a latitude beyond the pole", "/site/latitude_deg", json!(91.0)),
    ]
}

fn with(pointer: &str, value: Value) -> Value {
    let mut document = campaign();
    let pointer = pointer.strip_suffix("/1").filter(|p| *p == "/model").unwrap_or(pointer);
    document["station_uncertainty"] = json!({"levelling_arcsec": 5.0});
    with_member(document, pointer, value)
}

fn command_line_refuses(text: &str, words: &str) {
    let mut command = assert_cmd::Command::cargo_bin("gyrowatch").unwrap();
    let refused = command.args(["calibrate", "-"]).write_stdin(text).assert().code(1);
    let (out, error) = (&refused.get_output().stdout, &refused.get_output().stderr);
    assert!(out.is_empty());
    assert!(String::from_utf8_lossy(error).contains(words), "{words}: {}", String::from_utf8_lossy(error));
}

#[tokio::test]
async fn bad_campaigns_are_refused_by_name_and_leave_nothing() {
    let lab = Lab::open().await;
    for (what, pointer, value) in bad_members() {
        let bad = with(pointer, value);
        let places = posts(&lab, &bad).await.refused(422);
        assert!(places.iter().any(|place| place.starts_with(pointer)), "{what}: {places:?}");
        let line = &lab.imports(std::slice::from_ref(&bad)).await[0];
        assert_eq!((&line["line"], &line["status"]), (&json!(1), &json!(422)), "{what}: {line}");
        command_line_refuses(&bad.to_string(), pointer);
    }
    for (text, status) in [("{", 400), ("[]", 422), ("{\"dwells\": NaN}", 400), ("not a campaign", 400)] {
        lab.post_text("/v1/campaigns", JSON, text).await.refused(status);
    }
    lab.post_text("/v1/campaigns", "application/xml", "<dwells/>").await.refused(415);
    let mut swapped = campaign();
    for dwell in swapped["dwells"].as_array_mut().unwrap() {
        dwell["output_pulse_s"].as_array_mut().unwrap().swap(0, 1);
    }
    assert!(posts(&lab, &swapped).await.refused(422)[0].starts_with("/gyros/"), "outputs of two gyros exchanged");
    assert_eq!(lab.get("/v1/gyros").await.ok()["gyros"], json!([]));
}

/// The campaign with the specific force reversed, without attitudes and with.
fn reversed_force() -> [Value; 2] {
    let mut campaign = campaign();
    for dwell in campaign["dwells"].as_array_mut().unwrap() {
        for x in dwell["specific_force_g0"].as_array_mut().unwrap() {
            *x = json!(-x.as_f64().unwrap());
        }
    }
    let mut bare = campaign.clone();
    for dwell in bare["dwells"].as_array_mut().unwrap() {
        dwell.as_object_mut().unwrap().remove("attitude");
    }
    [bare, campaign]
}

#[tokio::test]
async fn what_the_earth_does_not_allow_is_refused_on_every_way_in() {
    let lab = Lab::open().await;
    for bad in reversed_force() {
        let words = "the specific force is reversed: it must point up, away from the Earth, in a static dwell";
        let answer = posts(&lab, &bad).await;
        assert_eq!(answer.refused(422), ["/dwells/0/specific_force_g0"]);
        assert!(answer.text.contains(words), "{}", answer.text);
        let table = csv(&bad);
        let line = table.lines().position(|line| line.contains("duration_s,")).unwrap() + 2;
        let answer = lab.post_text("/v1/campaigns", CSV, table.clone()).await;
        assert_eq!(answer.refused(422), ["/dwells/0/specific_force_g0"]);
        assert!(
            answer.text.contains(&format!("line {line}, column ")) && answer.text.contains(words),
            "{}",
            answer.text
        );
        let imported = lab.imports(std::slice::from_ref(&bad)).await;
        assert!(imported[0]["status"] == 422 && imported[0].to_string().contains(words), "{imported:?}");
        for command in ["calibrate", "diagnose"] {
            for text in [bad.to_string(), table.clone()] {
                let file = tempfile::NamedTempFile::new().unwrap();
                std::fs::write(file.path(), text).unwrap();
                let refused =
                    assert_cmd::Command::cargo_bin("gyrowatch").unwrap().arg(command).arg(file.path()).assert();
                let output = refused.code(1).get_output().clone();
                assert!(String::from_utf8_lossy(&output.stderr).contains(words), "{command}: {output:?}");
            }
        }
    }
    assert_eq!(lab.get("/v1/gyros").await.ok()["gyros"], json!([]));
}

#[tokio::test]
async fn columns_may_be_missing_in_some_dwells_and_rates_be_those_of_the_table() {
    let lab = Lab::open().await;
    let mut some = campaign();
    for (k, column) in [(3, "attitude"), (4, "temperature_c"), (5, "output_sem_pulse_s")] {
        some["dwells"][k].as_object_mut().unwrap().remove(column);
    }
    let answer = posts(&lab, &some).await.created();
    let codes: Vec<&str> = answer["notes"].as_array().unwrap().iter().map(|n| n["code"].as_str().unwrap()).collect();
    assert_eq!(codes, ["attitudes_missing", "temperatures_missing", "standard_errors_missing"]);
    assert_eq!(answer["notes"][2]["pointers"], json!(["/dwells/5/output_sem_pulse_s"]));
    let id = answer["id"].as_str().unwrap();
    assert_eq!(
        lab.get(&format!("/v1/campaigns/{id}")).await.ok()["notes"],
        answer["notes"],
        "and again from what is stored"
    );

    // The table stood still in static dwells: the Earth's rate is all that there is.
    let mut table = campaign();
    table["rates"] = json!("table");
    for dwell in table["dwells"].as_array_mut().unwrap() {
        if dwell["phase"] == "static" {
            dwell["rate_arcsec_s"] = json!([0, 0, 0]);
        } else {
            let up = 15.041_067_178_669_1 * campaign()["site"]["latitude_deg"].as_f64().unwrap().to_radians().sin();
            let g = campaign()["site"]["gravity_g0"].as_f64().unwrap();
            for axis in 0..3 {
                let along = dwell["specific_force_g0"][axis].as_f64().unwrap() / g;
                dwell["rate_arcsec_s"][axis] = json!(dwell["rate_arcsec_s"][axis].as_f64().unwrap() - up * along);
            }
        }
    }
    let drift = |answer: &Value| [0, 1, 2].map(|i| answer["separations"][i]["d_i"]["value"].as_f64().unwrap());
    let of_table = drift(&posts(&Lab::open().await, &table).await.created());
    let expected = drift(&posts(&Lab::open().await, &campaign()).await.created());
    assert!(of_table.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{of_table:?} {expected:?}");
}

#[tokio::test]
async fn a_bad_csv_is_refused_by_line_and_column() {
    let lab = Lab::open().await;
    let sound = csv(&campaign());
    let header = sound.lines().position(|line| line.contains("duration_s,")).unwrap() + 1;
    let first = sound.lines().nth(header).unwrap();
    let comma = first.replacen("45.67", "45,67", 1);
    assert_ne!(comma, first);
    for (what, text, words) in [
        ("yesterday's header", sound.replacen("temperature_c", "Temperature", 1), format!("line {header}, column")),
        ("a decimal comma", sound.replacen(first, &comma, 1), format!("line {}, column", header + 1)),
        ("a word among numbers", sound.replacen("45.67", "warm", 1), format!("line {}, column", header + 1)),
        ("a column too few", sound.replacen("rate_arcsec_s_z", "rate_arcsec_s_y", 1), format!("line {header}")),
        ("no table", "# imu: X\n".to_owned(), "no table".to_owned()),
    ] {
        let answer = lab.post_text("/v1/campaigns", CSV, text.clone()).await;
        answer.refused(422);
        assert!(answer.text.contains(&words), "{what}: {words} is not in {}", answer.text);
        command_line_refuses(&text, &words);
    }
    assert_eq!(lab.get("/v1/gyros").await.ok()["gyros"], json!([]));
}

#[tokio::test]
async fn who_prefers_a_minimal_answer_is_told_the_identifier_and_the_states_of_the_verdicts() {
    let lab = Lab::open().await;
    let documents = [("/v1/records", tables_3_and_4()), ("/v1/campaigns", campaign()), ("/v1/campaigns", bench_test())];
    for (path, document) in documents {
        let send = || lab.request(Method::POST, path).header(CONTENT_TYPE, JSON).body(document.to_string());
        let minimal = Answer::of(send().header("Prefer", "return=minimal")).await;
        let created = minimal.created();
        let id = created["id"].as_str().unwrap();
        assert!(minimal.header("location").ends_with(id));
        assert_eq!(minimal.header("preference-applied"), "return=minimal");
        let again = Answer::of(send().header("Prefer", "return=minimal")).await;
        assert_eq!((again.status, again.text.as_str()), (200, minimal.text.as_str()));
        assert_eq!(again.header("preference-applied"), "return=minimal");
        let whole = Answer::of(send().header("Prefer", "return=representation")).await;
        assert_eq!((whole.status, whole.header("preference-applied")), (200, ""));
        let whole = whole.json();
        let verdicts = whole["verdicts"].as_array().map_or(&[][..], Vec::as_slice);
        let count = |state: &str| verdicts.iter().filter(|verdict| verdict["state"] == state).count();
        let [within, indeterminate, exceeded] = ["within", "indeterminate", "exceeded"].map(count);
        let states = json!({"within": within, "indeterminate": indeterminate, "exceeded": exceeded});
        assert_eq!(created, json!({"id": whole["id"], "states": states}), "{path}");
        lab.post(&format!("{}/void", minimal.header("location")), &json!({"author": "E. Ito", "reason": "a trial"}))
            .await
            .ok();
        let voided = Answer::of(send().header("Prefer", "return=minimal")).await.ok();
        assert_eq!((&voided["id"], &voided["states"]), (&created["id"], &created["states"]), "{path}");
    }
}
