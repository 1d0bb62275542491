//! What a calibration record says by itself: Tables 3-4 of the paper, whose closure two coefficients cannot explain.

use crate::command::answer;
use crate::lab::{Lab, day, record, tables_3_and_4};
use crate::support::{data_path, gyrowatch};
use serde_json::{Value, json};

#[test]
fn the_paper_s_tables_have_a_gap_of_one_class_and_say_what_would_tell_it_apart() {
    let answer = answer(&["diagnose", data_path("paper.json").to_str().unwrap()]);
    assert_eq!(answer["verdict"], "partly_explained");
    let effects = answer["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 1, "one class, not two causes");
    assert_eq!(effects[0]["class"], json!(["output_axis_g", "mount_clocking"]));
    assert_eq!(effects[0]["gyros"], json!(["G1", "G2", "G3"]));
    // Computed apart from this program: the rigid resolution of Tables 3 and 4.
    for (k, (d_o, d_s)) in [(0.075874, 4.618005), (0.232169, 3.898225), (-0.019514, -6.752265_f64)].iter().enumerate() {
        let at = &answer["where"]["gyros"][k];
        assert!((at["d_o"].as_f64().unwrap() - d_o).abs() < 1e-6, "{at}");
        assert!((at["of_budget"].as_f64().unwrap() - d_o.abs() / 1e-2).abs() < 1e-3, "{at}");
        let phi = effects[0]["estimates"].as_array().unwrap().iter().filter(|e| e["unit"] == "rad").nth(k).unwrap();
        let angle: f64 = d_o / d_s;
        assert!((phi["value"].as_f64().unwrap() - angle.atan()).abs() < 1e-6, "{phi}");
    }
    // If G2's closure is clocking, its D_S is 0.0069 longer: most of the budget.
    let impact = answer["impact"].as_array().unwrap().iter().find(|i| i["slot"] == "G2").unwrap();
    assert!((impact["shift"].as_f64().unwrap() - 0.006908).abs() < 1e-5, "{impact}");
    for next in answer["next_measurements"].as_array().unwrap() {
        assert_eq!(next["separates"], json!(["output_axis_g", "mount_clocking"]));
    }
    let first = &answer["next_measurements"][0];
    assert_eq!(
        (&first["code"], first["parameters"]["changes"].as_array().unwrap().len()),
        (&json!("closure_after_change"), 3)
    );
    assert!(
        first["measurement"].as_str().unwrap().contains("after D_S has changed (G1 by 1.83, G2 by 0.50,"),
        "{first}"
    );
    let codes: Vec<&Value> = answer["note_codes"].as_array().unwrap().iter().map(|note| &note["code"]).collect();
    assert_eq!(codes, ["closure_without_deviations", "closure_is_not_tested"]);
}

#[test]
fn a_record_without_a_closure_has_no_gap_and_what_needs_dwells_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("record.json");
    std::fs::write(&path, record("IMU-1", &day(0), &[("G1", "A", 3.0, 4.0)]).to_string()).unwrap();
    let answer = answer(&["diagnose", path.to_str().unwrap()]);
    assert_eq!((&answer["verdict"], &answer["effects"]), (&json!("no_gap"), &json!([])));
    let model = dir.path().join("model.json");
    let output = gyrowatch().arg("diagnose").arg(&path).arg("--adopt").arg(&model).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("a record has no dwells"));
    assert!(!model.exists());
}

#[tokio::test]
async fn the_service_answers_the_same_for_a_stored_record() {
    let lab = Lab::open().await;
    let stored = lab.posts(&tables_3_and_4()).await;
    let served = lab.get(&format!("/v1/records/{}/diagnosis", stored["id"].as_str().unwrap())).await.ok();
    assert_eq!(served, answer(&["diagnose", data_path("paper.json").to_str().unwrap()]));
    lab.get("/v1/records/0000000000000/diagnosis").await.refused(404);
}
