//! A campaign held against an earlier one or a record of its IMU: what of the gap is parameters, structure and noise.

use crate::command::{answer, ended};
use crate::prelude::*;
use crate::support::data_path;

/// Practice campaign 0: nothing is hidden in it.
fn clean() -> Value {
    document("practice/campaign-00.json")
}

/// |E| of the practice IMU's gyros, pulse/arcsec.
fn scale() -> f64 {
    let campaign = data_path("practice/campaign-00.json");
    let answer = answer(&["calibrate", campaign.to_str().unwrap()]);
    answer["separations"][0]["scale_factor"]["value"].as_f64().unwrap()
}

/// Adds to the output of gyro 0, dwell by dwell, what `drift` says (pulse/s), at a later time.
fn later(drift: impl Fn(usize, &Value) -> f64) -> Value {
    let mut campaign = clean();
    campaign["measured_at"] = "2031-01-01T00:00:00Z".into();
    for (k, dwell) in campaign["dwells"].as_array_mut().unwrap().iter_mut().enumerate() {
        let y = dwell["output_pulse_s"][0].as_f64().unwrap() + drift(k, dwell);
        dwell["output_pulse_s"][0] = y.into();
    }
    campaign
}

fn written(dir: &Path, name: &str, document: &Value) -> PathBuf {
    let path = dir.join(name);
    std::fs::write(&path, document.to_string()).unwrap();
    path
}

fn run(campaign: &Value, reference: &Value, more: &[&str]) -> (i32, String, String) {
    let dir = tempfile::tempdir().unwrap();
    let [campaign, reference] =
        [("campaign.json", campaign), ("reference.json", reference)].map(|(name, d)| written(dir.path(), name, d));
    ended(gyrowatch().arg("diagnose").arg(campaign).arg("--reference").arg(reference).args(more))
}

fn split(campaign: &Value, reference: &Value) -> Value {
    let (status, out, error) = run(campaign, reference, &["--format", "json"]);
    assert_eq!(status, 0, "{error}");
    serde_json::from_str::<Value>(&out).unwrap()["reference"].clone()
}

fn part(split: &Value, slot: &str, name: &str) -> f64 {
    let gyros = split["gyros"].as_array().unwrap();
    let of = if slot == "all" { &split["all"] } else { gyros.iter().find(|g| g["slot"] == slot).unwrap() };
    of[name].as_f64().unwrap()
}

fn shift(split: &Value, slot: &str, coefficient: &str) -> f64 {
    let moved = split["moved"].as_array().unwrap();
    moved.iter().find(|m| m["slot"] == slot && m["coefficient"] == coefficient).unwrap()["shift"].as_f64().unwrap()
}

fn adds_up(split: &Value) {
    for slot in ["all", "G1", "G2", "G3"] {
        let square = |name: &str| part(split, slot, name).powi(2);
        let whole = square("whole_deg_per_h");
        let sum = square("parameters_deg_per_h") + square("structure_deg_per_h") + square("noise_deg_per_h");
        assert!((sum - whole).abs() < 1e-9 * whole, "{slot}: {sum} {whole}");
    }
}

#[test]
fn a_bias_that_moved_is_parameters_of_that_size_in_that_gyro() {
    let moved = 0.05;
    let pulse = moved * scale();
    let split = split(&later(|_, _| pulse), &clean());
    adds_up(&split);
    // A bias is its own root mean square, whatever the weights.
    assert!((part(&split, "G1", "parameters_deg_per_h") - moved).abs() < 0.1 * moved, "{split}");
    assert!(part(&split, "G1", "p_value") < 1e-12);
    assert!(part(&split, "G1", "structure_deg_per_h") < 0.1 * moved);
    assert!((shift(&split, "G1", "D0") - moved).abs() < 1e-6);
    for slot in ["G2", "G3"] {
        assert!(part(&split, slot, "parameters_deg_per_h") < 1e-6 && part(&split, slot, "p_value") > 0.9, "{split}");
        assert!(shift(&split, slot, "D0").abs() < 1e-9);
    }
}

#[test]
fn one_dwell_that_is_off_is_structure_and_hardly_parameters() {
    let off = 0.5;
    let pulse = off * scale();
    let split = split(&later(|k, _| if k == 20 { pulse } else { 0.0 }), &clean());
    adds_up(&split);
    let rms = off / 78.0_f64.sqrt();
    assert!((part(&split, "G1", "structure_deg_per_h") - rms).abs() < 0.2 * rms, "{split}");
    assert!(part(&split, "G1", "parameters_deg_per_h") < 0.6 * rms, "{split}");
    assert!(part(&split, "G2", "structure_deg_per_h") < 0.1 * rms);
}

#[test]
fn the_same_campaign_again_has_moved_nothing() {
    let split = split(&clean(), &clean());
    adds_up(&split);
    for slot in ["G1", "G2", "G3"] {
        assert!(part(&split, slot, "parameters_deg_per_h") < 1e-9, "{split}");
        for coefficient in ["D0", "D_I", "D_S", "D_O", "|E|"] {
            assert!(shift(&split, slot, coefficient).abs() < 1e-9);
        }
    }
}

#[test]
fn a_g_sensitivity_that_moved_shows_along_its_axis_in_table_and_report() {
    let pulse = scale();
    // Along X_b: the input axis of G1 lies at 54.7 deg to it.
    let campaign = later(|_, dwell| 0.02 * pulse * dwell["specific_force_g0"][0].as_f64().unwrap());
    let split = split(&campaign, &clean());
    let axes = ["D_I", "D_S", "D_O"].map(|coefficient| shift(&split, "G1", coefficient));
    assert!((axes.iter().map(|x| x * x).sum::<f64>().sqrt() - 0.02).abs() < 1e-5, "{axes:?}");
    assert!((axes[0].abs() - 0.02 / 3.0_f64.sqrt()).abs() < 1e-4, "{axes:?}");
    let dir = tempfile::tempdir().unwrap();
    let report = dir.path().join("report.html");
    let (status, table, error) = run(&campaign, &clean(), &["--report", report.to_str().unwrap()]);
    assert_eq!(status, 0, "{error}");
    assert!(table.contains("p, parameters") && table.contains("Then and now"), "{table}");
    let page = std::fs::read_to_string(report).unwrap();
    assert!(page.contains("Against an earlier calibration") && page.contains("D<sub>I</sub>"), "{page}");
}

#[test]
fn what_is_no_reference_is_refused_by_what_differs() {
    let change = |change: &dyn Fn(&mut Value)| {
        let mut reference = clean();
        change(&mut reference);
        run(&clean(), &reference, &["--format", "json"])
    };
    let cases: [(&dyn Fn(&mut Value), &str); 5] = [
        (&|r: &mut Value| r["geometry"] = "orthogonal".into(), "the reference has another geometry"),
        (&|r: &mut Value| r["imu"] = "ANOTHER".into(), "the reference is of IMU ANOTHER"),
        (&|r: &mut Value| r["gyros"][1]["serial"] = "STRANGER".into(), "the reference has gyro STRANGER in G2"),
        (
            &|r: &mut Value| {
                r["gyros"].as_array_mut().unwrap().truncate(2);
                for dwell in r["dwells"].as_array_mut().unwrap() {
                    for member in ["output_pulse_s", "output_sem_pulse_s"] {
                        dwell[member].as_array_mut().unwrap().truncate(2);
                    }
                }
            },
            "the reference holds no gyro in G3",
        ),
        (&|r: &mut Value| r["dwells"] = json!([]), "reference.json"),
    ];
    for (spoil, words) in cases {
        let (status, out, error) = change(spoil);
        assert_eq!((status, out.as_str()), (1, ""), "{words}");
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[tokio::test]
async fn over_http_a_stored_campaign_is_held_against_another_one() {
    let lab = Lab::open().await;
    let moved = 0.05;
    let pulse = moved * scale();
    let first = lab.post("/v1/campaigns", &clean()).await.created();
    let mut second = later(|_, _| pulse);
    second["measured_at"] = "2026-05-01T08:00:00Z".into();
    let second = lab.post("/v1/campaigns", &second).await.created();
    let [first, second] = [&first, &second].map(|stored| stored["id"].as_str().unwrap().to_owned());
    let path = format!("/v1/campaigns/{second}/diagnosis");
    assert_eq!(lab.get(&path).await.ok()["reference"], Value::Null);
    let answer = lab.get(&format!("{path}?reference={first}")).await.ok();
    assert!((shift(&answer["reference"], "G1", "D0") - moved).abs() < 1e-6);
    lab.get(&format!("{path}?reference=0000000000000")).await.refused(404);
    lab.get(&format!("{path}?reference=nonsense")).await.refused(404);
    lab.get(&format!("{path}?referense={first}")).await.refused(400);
}

#[tokio::test]
async fn the_page_shows_the_parts_against_the_calibration_before_or_another_one() {
    let server = Server::start().await;
    let moved = 0.05;
    let pulse = moved * scale();
    let mut second = later(|_, _| pulse);
    second["measured_at"] = "2026-05-01T08:00:00Z".into();
    let mut third = clean();
    third["measured_at"] = "2026-06-01T08:00:00Z".into();
    let mut ids = Vec::new();
    for campaign in [clean(), second, third] {
        let answer = server.post_json("/v1/campaigns", &campaign).await.json();
        ids.push(answer["id"].as_str().unwrap().to_owned());
    }
    let page = async |path: &str| server.get(path).await.text();
    // Without being asked it is held against the one before: the bias moved back by as much.
    let body = server.get(&format!("/v1/campaigns/{}/diagnosis?reference={}", ids[2], ids[1])).await.json();
    assert!((shift(&body["reference"], "G1", "D0") + moved).abs() < 1e-6);
    let shown = page(&format!("/campaigns/{}/diagnosis", ids[2])).await;
    let back = format!("<td class=\"n\">{:+.4}", shift(&body["reference"], "G1", "D0"));
    assert!(shown.contains("Against an earlier calibration") && shown.contains(&back), "{back}");
    assert!(shown.contains(&format!("<option value=\"{}\" selected>", ids[1])));
    let chosen = page(&format!("/campaigns/{}/diagnosis?reference={}", ids[2], ids[0])).await;
    assert!(!chosen.contains(&back) && chosen.contains(&format!("<option value=\"{}\" selected>", ids[0])));
    // The first one has nothing before it, but later ones can be chosen.
    assert!(page(&format!("/campaigns/{}/diagnosis", ids[0])).await.contains("No calibration of this IMU is earlier"));
    assert_eq!(server.get(&format!("/campaigns/{}/diagnosis?reference=nonsense", ids[2])).await.status, 404);
}

#[tokio::test]
async fn the_page_says_what_a_gyro_alone_cannot_tell_apart() {
    let server = Server::start().await;
    // Its rates tell the asymmetry of G1 and G3 from a quadratic scale factor together, G1's alone do not.
    let answer = server.post("/v1/campaigns", "application/json", data("practice/campaign-05.json")).await;
    let id = answer.json()["id"].as_str().unwrap().to_owned();
    let body = server.get(&format!("/v1/campaigns/{id}/diagnosis")).await.json();
    assert_eq!(body["effects"][0]["wider_in"][0]["slot"], "G1", "{body}");
    let english = server.get(&format!("/campaigns/{id}/diagnosis")).await.text();
    assert!(english.contains("G1 alone cannot tell it from:</strong>"), "{english}");
    let after = english.split("alone cannot tell it from:").nth(1).unwrap().split("</p>").next().unwrap().to_owned();
    assert!(after.contains("scale_quadratic") && !after.contains("scale_asymmetry"), "{after}");
}
