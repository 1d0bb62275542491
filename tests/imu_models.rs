//! The error model of an IMU over HTTP: adopted with a reason, used by the later campaigns, kept through a restart,
//! undone.

use crate::lab::{Answer, at, effects};
use crate::prelude::*;
use gyrowatch::core::alert_decision::Late;
use gyrowatch::pipeline::{Accepted, Submission};
use gyrowatch::wire::campaign::Form;
use reqwest::Method;

/// A practice campaign with `temperature_bias` in it.
fn campaign() -> Value {
    let key = document("practice/key.json");
    let name = key.as_object().unwrap().iter().find(|(_, entry)| entry["effects"] == json!(["temperature_bias"]));
    document(&format!("practice/{}", name.unwrap().0))
}

fn adoption(effects: Value) -> Value {
    json!({"terms": [], "effects": effects, "author": "M. Adopter", "reason": "held-out dwells say so"})
}

/// `temperature_bias` in every gyro, as a model file holds it.
fn temperature_bias() -> Value {
    json!([{"effect": "temperature_bias", "gyros": ["G1", "G2", "G3"], "estimates": []}])
}

fn model_path(campaign: &Value) -> String {
    format!("/v1/imus/{}/model", campaign["imu"].as_str().unwrap())
}

async fn diagnosis(lab: &Lab, stored: &Value) -> Value {
    lab.diagnosis(stored["id"].as_str().unwrap()).await.ok()
}

#[tokio::test]
async fn an_adopted_model_is_used_by_the_later_campaigns_and_undone_by_an_empty_one() {
    let mut lab = Lab::open().await;
    let sent = campaign();
    let path = model_path(&sent);
    let first = lab.post("/v1/campaigns", &sent).await.created();
    let plain = diagnosis(&lab, &first).await;
    assert_eq!(effects(&plain), ["temperature_bias"]);
    assert_eq!(lab.get(&path).await.ok()["history"], json!([]));
    let trend = format!("/v1/gyros/{}/trend", sent["gyros"][0]["serial"].as_str().unwrap());
    let before = lab.get(&trend).await;

    let adopted = lab.post(&path, &adoption(temperature_bias())).await.created();
    assert_eq!(adopted["author"], "M. Adopter");
    assert_eq!(lab.post(&path, &adoption(temperature_bias())).await.ok()["id"], adopted["id"], "the same again");
    // What is stored is stated with the model in force; its diagnosis is against it, too.
    assert_eq!(adopted["campaigns"], 1);
    let again = lab.get(&format!("/v1/campaigns/{}", first["id"].as_str().unwrap())).await.ok();
    assert_eq!(again["imu_model"], adopted["id"]);
    assert_ne!(again["separations"], first["separations"]);
    let known = lab.request(Method::GET, &trend).header("if-none-match", before.header("etag"));
    let restated = Answer::of(known).await.ok();
    assert_ne!(restated["points"][0]["value"], before.ok()["points"][0]["value"], "a tag tells them apart");
    let against = diagnosis(&lab, &first).await;
    assert_eq!(against["model"]["effects"][0]["effect"], "temperature_bias");
    assert_eq!(against["verdict"], "no_gap", "{against}");

    let second = lab.post("/v1/campaigns", &at(sent.clone(), "2026-05-01T08:00:00Z")).await.created();
    assert_eq!(second["imu_model"], adopted["id"]);
    assert_eq!(second["calibration"]["effects"], json!(["temperature_bias"]));
    assert_eq!(second["separations"], again["separations"], "the same dwells, the same model");

    lab.restart().await;
    let stored = lab.get(&format!("/v1/campaigns/{}", second["id"].as_str().unwrap())).await.ok();
    for member in ["separations", "calibration", "verdicts", "imu_model"] {
        assert_eq!(stored[member], second[member], "{member}");
    }
    let shown = lab.get(&path).await.ok();
    assert_eq!(shown["model"]["effects"][0]["effect"], "temperature_bias");
    assert_eq!(diagnosis(&lab, &second).await["verdict"], "no_gap");

    let undone = lab.post(&path, &adoption(json!([]))).await.created();
    assert_ne!(undone["id"], adopted["id"]);
    let shown = lab.get(&path).await.ok();
    assert_eq!((&shown["model"]["terms"], &shown["model"]["effects"]), (&json!([]), &json!([])));
    assert_eq!(shown["history"].as_array().unwrap().len(), 2);
    assert_eq!(diagnosis(&lab, &first).await, plain);
    let as_it_was = lab.get(&format!("/v1/campaigns/{}", first["id"].as_str().unwrap())).await.ok();
    assert_eq!(as_it_was["separations"], first["separations"]);
    assert!(lab.verified().await.faults.is_empty());
    let third = lab.post("/v1/campaigns", &at(sent, "2026-06-01T08:00:00Z")).await.created();
    assert_eq!(third["separations"], first["separations"]);
    assert_eq!(third["calibration"]["effects"], Value::Null);
}

/// Read and fitted, as it waits to be stored.
fn fitted(lab: &Lab, campaign: &Value, measured_at: &str) -> Submission {
    let body = at(campaign.clone(), measured_at).to_string();
    lab.pipeline().reader.campaign_document(body.as_bytes(), Form::Json).unwrap().submission
}

async fn stored(lab: &Lab, items: Vec<Submission>) -> Vec<Value> {
    let replies = lab.pipeline().ingest.enqueue(items, Late::Quiet).await.await;
    let mut campaigns = Vec::new();
    for reply in replies {
        let Accepted::Stored { id, .. } = reply.unwrap() else { panic!("it is new") };
        campaigns.push(lab.get(&format!("/v1/campaigns/{id}")).await.ok());
    }
    campaigns
}

#[tokio::test]
async fn a_campaign_is_stated_by_the_model_in_force_when_it_is_stored_whichever_it_was_fitted_with() {
    let lab = Lab::open().await;
    let sent = campaign();
    let path = model_path(&sent);
    let first = lab.post("/v1/campaigns", &sent).await.created();

    let waiting = vec![fitted(&lab, &sent, "2026-05-01T08:00:00Z")];
    let adopted = lab.post(&path, &adoption(temperature_bias())).await.created();
    let restated = lab.get(&format!("/v1/campaigns/{}", first["id"].as_str().unwrap())).await.ok();
    let late = stored(&lab, waiting).await;
    assert_eq!(late[0]["imu_model"], adopted["id"]);
    assert_eq!(late[0]["separations"], restated["separations"], "the same dwells, the same model");

    // So many that they are judged while others are written.
    let many = (0..200).map(|k| fitted(&lab, &sent, &format!("2026-05-02T{:02}:{:02}:00Z", k / 60, k % 60)));
    let waiting = many.collect();
    let undone = lab.post(&path, &adoption(json!([]))).await.created();
    for late in stored(&lab, waiting).await {
        assert_eq!(late["imu_model"], undone["id"]);
        assert_eq!(late["separations"], first["separations"]);
    }
    assert_eq!(lab.verified().await.faults, []);
}

/// Another server on the same database.
#[tokio::test]
async fn a_campaign_is_stated_by_the_model_that_another_server_has_put_in_force() {
    if !cluster::is_wanted() {
        return;
    }
    let here = Lab::open().await;
    let there = Lab::with(|config| config.database.url.clone_from(&here.config.database.url)).await;
    let sent = campaign();
    let path = model_path(&sent);
    here.post("/v1/campaigns", &sent).await.created();
    for (day, effects) in [(1, temperature_bias()), (2, json!([])), (3, temperature_bias())] {
        let waiting = vec![fitted(&here, &sent, &format!("2026-05-{day:02}T08:00:00Z"))];
        let adopted = there.post(&path, &adoption(effects)).await.created();
        assert_eq!(stored(&here, waiting).await[0]["imu_model"], adopted["id"], "day {day}");
    }
    assert_eq!(here.verified().await.faults, []);
}

#[tokio::test]
async fn a_station_that_asks_for_fewer_terms_gets_them_whatever_the_model_says() {
    let lab = Lab::open().await;
    let mut sent = campaign();
    lab.post("/v1/campaigns", &sent).await.created();
    let mut whole = adoption(json!([]));
    whole["terms"] = json!(["bias", "g_linear", "g_squared", "scale"]);
    lab.post(&model_path(&sent), &whole).await.created();
    sent["model"] = json!(["bias", "g_linear", "scale"]);
    let fitted = lab.post("/v1/campaigns", &at(sent, "2026-05-01T08:00:00Z")).await.created();
    assert_eq!(fitted["calibration"]["model"], json!(["bias", "g_linear", "scale"]));
}

#[tokio::test]
async fn what_is_no_model_is_refused_by_name() {
    let lab = Lab::open().await;
    let sent = campaign();
    let path = model_path(&sent);
    lab.post(&path, &adoption(json!([]))).await.refused(404);
    lab.get(&path).await.refused(404);
    lab.post("/v1/campaigns", &sent).await.created();
    let with = |member: &str, value: Value| {
        let mut body = adoption(temperature_bias());
        body[member] = value;
        body
    };
    let cases = [
        (with("author", json!(" ")), "/author"),
        (with("reason", json!("")), "/reason"),
        (with("terms", json!(["gravity"])), "/terms/0"),
        (with("effects", json!([{"effect": "ghost", "gyros": ["G1"], "estimates": []}])), "/effects/0/effect"),
        (with("sincerely", json!("me")), "/sincerely"),
    ];
    for (body, pointer) in cases {
        assert_eq!(lab.post(&path, &body).await.refused(422), [pointer]);
    }
    assert_eq!(lab.get(&path).await.ok()["history"], json!([]));
}

#[tokio::test]
async fn a_stored_campaign_is_diagnosed_without_anybody_asking_and_ingest_does_not_wait_for_it() {
    let lab = Lab::open().await;
    let campaigns: Vec<Value> = (1..=20).map(|k| at(campaign(), &format!("2026-05-{k:02}T08:00:00Z"))).collect();
    let lines = lab.imports(&campaigns).await;
    assert!(lines.iter().all(|line| line["status"] == 201), "{lines:?}");
    for line in &lines {
        let path = format!("/v1/campaigns/{}/diagnosis", line["id"].as_str().unwrap());
        let mut answer = lab.get(&path).await;
        while answer.status == 202 {
            assert!(answer.header("retry-after").parse::<u32>().unwrap() > 0);
            answer = lab.get(&path).await;
        }
        assert_eq!(effects(&answer.ok()), ["temperature_bias"]);
    }
}

fn hypothesis(id: &str, equation: &str, unit: &str) -> Value {
    let hypothesis = json!({"id": id, "words": "mine", "equation": equation, "unit": unit, "plausible": 50.0});
    json!({"hypothesis": hypothesis, "author": "M. Asker", "reason": "seen on the bench"})
}

#[tokio::test]
async fn a_stored_hypothesis_competes_in_the_diagnoses_made_from_then_on_until_it_is_taken_out() {
    let mut lab = Lab::open().await;
    let first = lab.post("/v1/campaigns", &campaign()).await.created();
    assert!(diagnosis(&lab, &first).await.get("hypotheses").is_none());

    let twin = hypothesis("own_bias", "k * T", "deg/h/K");
    let added = lab.post("/v1/hypotheses", &twin).await;
    assert_eq!(added.header("location"), "/v1/hypotheses/own_bias");
    assert_eq!(added.created()["hypothesis"]["equation"], "k * T");
    assert_eq!(lab.post("/v1/hypotheses", &twin).await.ok()["author"], "M. Asker", "the same again");
    // It says what an entry says: both are one class. What was made without it is made anew.
    let class = |diagnosis: &Value| diagnosis["effects"][0]["class"].clone();
    let with = diagnosis(&lab, &first).await;
    assert!(class(&with).as_array().unwrap().contains(&json!("own_bias")), "{with}");
    let second = lab.post("/v1/campaigns", &at(campaign(), "2026-05-01T08:00:00Z")).await.created();
    assert_eq!(diagnosis(&lab, &second).await["hypotheses"][0]["id"], "own_bias");

    lab.restart().await;
    assert_eq!(lab.get("/v1/hypotheses").await.ok()["hypotheses"][0]["hypothesis"]["id"], "own_bias");
    let trail = lab.get("/v1/audit").await.ok().to_string();
    assert!(trail.contains("add hypothesis") && trail.contains("hypotheses/own_bias"), "{trail}");

    let gone = Answer::of(lab.request(Method::DELETE, "/v1/hypotheses/own_bias")).await;
    assert_eq!(gone.status, 204, "{}", gone.text);
    assert_eq!(lab.get("/v1/hypotheses").await.ok(), json!({"hypotheses": []}));
    assert!(diagnosis(&lab, &second).await.get("hypotheses").is_none());
    let gone = Answer::of(lab.request(Method::DELETE, "/v1/hypotheses/own_bias")).await;
    assert_eq!(gone.refused(404), [] as [String; 0]);
}

#[tokio::test]
async fn a_hypothesis_that_makes_no_sense_is_refused_by_its_place() {
    let lab = Lab::open().await;
    let endless = vec!["k * T"; 100_000].join(" + ");
    let place = "/hypothesis/equation";
    for (equation, unit, pointer) in [
        ("k * Q * T", "deg/h/K", place),
        ("k * T / 0", "deg/h/K", place),
        ("k * T * w_I", "deg/h/K", place),
        (endless.as_str(), "deg/h/K", place),
        ("k * T", "volts", "/hypothesis/unit"),
    ] {
        let found = lab.post("/v1/hypotheses", &hypothesis("wrong", equation, unit)).await.refused(422);
        assert_eq!(found, [pointer], "{}", &equation[..equation.len().min(20)]);
    }
    let mut nobody = hypothesis("one", "k * T", "deg/h/K");
    nobody["author"] = " ".into();
    assert_eq!(lab.post("/v1/hypotheses", &nobody).await.refused(422), ["/author"]);
    lab.post("/v1/hypotheses", &hypothesis("one", "k * T", "deg/h/K")).await.created();
    lab.post("/v1/hypotheses", &hypothesis("one", "k * a_S * T", "deg/(h g0 K)")).await.refused(409);
    lab.post("/v1/hypotheses", &hypothesis("warmup", "k * T", "deg/h/K")).await.refused(422);
    for number in 1..16 {
        let one = hypothesis(&format!("h{number}"), "k * a_S * t", "deg/(h^2 g0)");
        lab.post("/v1/hypotheses", &one).await.created();
    }
    lab.post("/v1/hypotheses", &hypothesis("one_more", "k * T", "deg/h/K")).await.refused(409);
}

#[tokio::test]
async fn an_equation_without_a_value_in_a_campaign_is_said_and_the_rest_is_diagnosed() {
    let lab = Lab::open().await;
    lab.post("/v1/hypotheses", &hypothesis("pole", "k / (w_I - w_I)", "deg^2/h^2")).await.created();
    let stored = lab.post("/v1/campaigns", &campaign()).await.created();
    let found = diagnosis(&lab, &stored).await;
    assert_eq!(effects(&found), ["temperature_bias"]);
    let said = found["not_identifiable"].as_array().unwrap().iter().find(|one| one["effect"] == "pole");
    assert!(said.is_some_and(|one| one["reason"].as_str().unwrap().contains("no finite value")), "{said:?}");
}
