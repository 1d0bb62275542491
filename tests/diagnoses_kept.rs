//! Diagnoses over HTTP are made without anybody asking, kept on disk, and made again only when they must be.

use crate::lab::at;
use crate::prelude::*;

/// A practice campaign with `temperature_bias` in it, at some time.
fn campaign(measured_at: &str) -> Value {
    at(document("practice/campaign-02.json"), measured_at)
}

/// The one that is kept, inflated by hand.
async fn kept(lab: &Lab) -> Value {
    let packed: Vec<(Vec<u8>,)> = lab.rows("SELECT packed FROM diagnosis").await;
    serde_json::from_reader(flate2::read::ZlibDecoder::new(&packed[0].0[..])).unwrap()
}

async fn due(lab: &Lab) -> i64 {
    lab.rows::<(i64,)>("SELECT count(*) FROM diagnosis WHERE body IS NULL").await[0].0
}

/// Until nothing is due; nobody asks for a diagnosis meanwhile.
async fn all_made(lab: &Lab) {
    once(async || due(lab).await, |due| *due == 0).await;
}

#[tokio::test]
async fn a_kept_diagnosis_is_served_after_a_restart_and_made_again_by_another_program() {
    let mut lab = Lab::open().await;
    let stored = lab.post("/v1/campaigns", &campaign("2026-05-01T08:00:00Z")).await.created();
    let made = lab.diagnosis(id(&stored)).await.ok();
    assert_eq!(made["effects"][0]["effect"], "temperature_bias");

    lab.restart().await;
    assert_eq!(lab.diagnosis(id(&stored)).await.ok(), made);

    // What is served is what lies on disk, not what would be found now.
    lab.stop().await;
    let mut text = kept(&lab).await;
    text["verdict"] = "as kept".into();
    // As an earlier version kept it.
    lab.change_to("UPDATE diagnosis SET body = $1, packed = NULL", &[&text.to_string()]).await;
    lab.start().await;
    assert_eq!(lab.diagnosis(id(&stored)).await.ok()["verdict"], "as kept");

    lab.stop().await;
    assert!(lab.change("UPDATE diagnosis SET program = '0.0.1, method 0'").await > 0);
    lab.start().await;
    assert_eq!(lab.diagnosis(id(&stored)).await.ok(), made);
    lab.stop().await;
    assert_ne!(kept(&lab).await["verdict"], "as kept");
}

#[tokio::test]
async fn what_was_due_when_the_service_stopped_is_made_after_its_start() {
    let mut lab = Lab::open().await;
    for day in 1..=3 {
        lab.post("/v1/campaigns", &campaign(&format!("2026-05-0{day}T08:00:00Z"))).await.created();
    }
    lab.stop().await;
    assert!(lab.change("UPDATE diagnosis SET body = NULL").await > 0);
    lab.start().await;
    all_made(&lab).await;
}

#[tokio::test]
async fn an_adopted_model_has_the_diagnoses_of_its_imu_made_again_without_anybody_asking() {
    let lab = Lab::open().await;
    let sent = campaign("2026-05-01T08:00:00Z");
    let stored = lab.post("/v1/campaigns", &sent).await.created();
    all_made(&lab).await;
    let model = json!({"terms": [], "author": "M. Adopter", "reason": "held-out dwells say so",
        "effects": [{"effect": "temperature_bias", "gyros": ["G1", "G2", "G3"], "estimates": []}]});
    lab.post(&format!("/v1/imus/{}/model", sent["imu"].as_str().unwrap()), &model).await.created();
    all_made(&lab).await;
    assert_eq!(kept(&lab).await["model"]["effects"][0]["effect"], "temperature_bias");
    assert_eq!(lab.diagnosis(id(&stored)).await.ok()["verdict"], "no_gap");
}

#[tokio::test]
async fn who_does_not_wait_is_told_to_ask_again_and_then_gets_it() {
    let lab = Lab::open().await;
    let mut waiting = 0;
    for day in 1..=4 {
        let stored = lab.post("/v1/campaigns", &campaign(&format!("2026-05-0{day}T08:00:00Z"))).await.created();
        let path = format!("/v1/campaigns/{}/diagnosis", id(&stored));
        let at_once = lab.get(&format!("{path}?wait=0")).await;
        if at_once.status == 202 {
            assert!(at_once.header("retry-after").parse::<u32>().unwrap() > 0);
            waiting += 1;
        }
        assert_eq!(lab.diagnosis(id(&stored)).await.ok()["effects"][0]["effect"], "temperature_bias");
        lab.get(&format!("{path}?wait=11")).await.refused(400);
    }
    assert!(waiting > 0, "a diagnosis takes longer than a request");
}

/// The database takes no diagnosis for a while; the service goes on.
#[tokio::test]
async fn what_could_not_be_kept_is_made_again_without_anybody_asking() {
    let (refuses, takes) = if cluster::is_wanted() {
        let refuses = "ALTER TABLE diagnosis ADD CONSTRAINT refused CHECK (packed IS NULL) NOT VALID";
        (refuses, "ALTER TABLE diagnosis DROP CONSTRAINT refused")
    } else {
        let refuses = "CREATE TRIGGER refused BEFORE UPDATE ON diagnosis WHEN NEW.packed IS NOT NULL
                       BEGIN SELECT RAISE(ABORT, 'not now'); END";
        (refuses, "DROP TRIGGER refused")
    };
    let mut lab = Lab::open().await;
    lab.post("/v1/campaigns", &campaign("2026-05-01T08:00:00Z")).await.created();
    all_made(&lab).await;
    lab.stop().await;
    assert!(lab.change("UPDATE diagnosis SET body = NULL, packed = NULL").await > 0);
    lab.change(refuses).await;
    lab.start().await;
    tokio::time::sleep(Duration::from_secs(5)).await;
    assert_eq!(due(&lab).await, 1);
    lab.change(takes).await;
    all_made(&lab).await;
}
