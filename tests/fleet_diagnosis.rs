//! Many campaigns diagnosed at once: an engineer orders it, follows it, cancels it, and reads what they say together.
//! The campaigns are the simulator's, so what is in them, and since when, is known.

use crate::lab;
use crate::prelude::*;
use gyrowatch::simulate::presets::preset;
use gyrowatch::simulate::scenario::EffectChoice;
use gyrowatch::simulate::{Scenario, simulate};
use gyrowatch::wire::campaign::to_json;
use reqwest::Method;

/// A campaign of an IMU: measured at noon of a day of May, by a station, with a cause in it.
fn campaign(imu: &str, day: u32, station: &str, hidden: Option<EffectChoice>) -> Value {
    let base = preset("24-position").unwrap();
    let mut gyros = base.gyros.clone();
    for (gyro, number) in gyros.iter_mut().zip(1..) {
        gyro.serial = Some(format!("{imu}-{number}"));
    }
    let scenario = Scenario {
        // Seeds of which none looks like a gap by chance.
        seed: u64::from(day % 7 + 1),
        imu: imu.into(),
        station: station.into(),
        measured_at: format!("2026-05-{day:02}T12:00:00Z"),
        gyros,
        effects: hidden.into_iter().collect(),
        ..base
    };
    serde_json::from_str(&to_json(&simulate(&scenario).unwrap().campaign)).unwrap()
}

fn in_gyros(effect: &str, gyros: &[&str]) -> EffectChoice {
    let gyros = gyros.iter().map(|slot| (*slot).to_owned()).collect();
    EffectChoice { gyros: Some(gyros), ..EffectChoice::detectable(effect, 30.0) }
}

/// Four IMUs: `WARM` has `temperature_bias` in G1 from its third campaign on, `LAG` hysteresis in G2 and G3 in all of
/// its two, `ODD` something that no catalogue knows, `FINE` nothing.
fn fleet() -> Vec<Value> {
    let warm = |day, station, hidden: bool| {
        campaign("WARM", day, station, hidden.then(|| in_gyros("temperature_bias", &["G1"])))
    };
    vec![
        warm(1, "ST-1", false),
        warm(8, "ST-2", false),
        warm(15, "ST-1", true),
        warm(22, "ST-2", true),
        campaign("LAG", 3, "ST-2", Some(in_gyros("hysteresis", &["G2", "G3"]))),
        campaign("LAG", 17, "ST-2", Some(in_gyros("hysteresis", &["G2", "G3"]))),
        campaign("ODD", 5, "ST-1", Some(EffectChoice::detectable("outside:orientation", 60.0))),
        campaign("FINE", 6, "ST-1", None),
        campaign("FINE", 20, "ST-2", None),
    ]
}

/// Until an order has ended.
async fn ended(lab: &Lab, id: &str) -> Value {
    let look = async || lab.get(&format!("/v1/diagnoses/{id}")).await.ok();
    once(look, |order| !order["ended_at"].is_null()).await
}

fn found<'a>(summary: &'a Value, effect: &str, serial: &str) -> &'a Value {
    let findings = summary["findings"].as_array().unwrap();
    let is_it = |f: &&Value| f["effect"] == effect && f["serial"] == serial;
    findings.iter().find(is_it).unwrap_or_else(|| panic!("no {effect} in {serial}: {summary}"))
}

#[tokio::test]
async fn the_summary_names_what_is_in_which_gyros_at_which_stations_since_when() {
    let lab = Lab::open().await;
    let mut ids = Vec::new();
    for body in fleet() {
        ids.push(lab.post("/v1/campaigns", &body).await.created()["id"].as_str().unwrap().to_owned());
    }
    let order = lab.post("/v1/diagnoses", &json!({ "again": true })).await;
    assert_eq!((order.status, order.header("location")), (202, &*format!("/v1/diagnoses/{}", id(&order.json()))));
    let order = ended(&lab, id(&order.json())).await;
    assert_eq!(order["state"], "done");
    assert_eq!(order["counts"], json!({"campaigns": 9, "waiting": 0, "done": 9, "failed": 0, "canceled": 0}));

    let summary = lab.get("/v1/diagnoses/summary").await.ok();
    let campaigns = &summary["campaigns"];
    assert_eq!(json!([campaigns["diagnosed"], campaigns["waiting"], campaigns["outdated"]]), json!([9, 0, 0]));
    assert_eq!((&campaigns["no_gap"], &campaigns["explained"]), (&json!(4), &json!(4)), "{summary}");

    // Since the third campaign, at both stations; the second was the last without.
    let warm = found(&summary, "temperature_bias", "WARM-1");
    assert_eq!(json!([warm["imu"], warm["slot"], warm["class"]]), json!(["WARM", "G1", ["temperature_bias"]]));
    assert_eq!((&warm["campaigns"], &warm["of"], &warm["of_since"]), (&json!(2), &json!(4), &json!(2)));
    assert_eq!([&warm["clear_at"], &warm["first"]["measured_at"]], ["2026-05-08T12:00:00Z", "2026-05-15T12:00:00Z"]);
    assert_eq!((&warm["first"]["campaign"], &warm["last"]["campaign"]), (&json!(ids[2]), &json!(ids[3])));
    let stations = json!([{"station": "ST-1", "campaigns": 1, "of": 2}, {"station": "ST-2", "campaigns": 1, "of": 2}]);
    assert_eq!(warm["stations"], stations);

    // The figures are those of the diagnoses themselves.
    let mut closures = Vec::new();
    for id in &ids[2..4] {
        let diagnosis = lab.get(&format!("/v1/campaigns/{id}/diagnosis")).await.ok();
        closures.push(diagnosis["effects"][0]["held_out"]["closure"].as_f64().unwrap());
        for impact in diagnosis["impact"].as_array().unwrap().iter().filter(|impact| impact["slot"] == "G1") {
            let largest = warm["impact"].as_array().unwrap().iter().find(|i| i["coefficient"] == impact["coefficient"]);
            let largest = largest.unwrap()["shift"].as_f64().unwrap().abs();
            assert!(largest >= impact["shift"].as_f64().unwrap().abs(), "{summary}");
        }
    }
    closures.sort_by(f64::total_cmp);
    assert_eq!((&warm["closure"]["least"], &warm["closure"]["greatest"]), (&json!(closures[0]), &json!(closures[1])));

    let lag = found(&summary, "hysteresis", "LAG-2");
    assert_eq!((&lag["campaigns"], &lag["of"], &lag["clear_at"]), (&json!(2), &json!(2), &Value::Null));
    let serials: BTreeSet<&str> =
        summary["findings"].as_array().unwrap().iter().filter_map(|f| f["serial"].as_str()).collect();
    let known = serials.iter().filter(|serial| !serial.starts_with("ODD"));
    assert_eq!(known.copied().collect::<Vec<_>>(), ["LAG-2", "LAG-3", "WARM-1"], "{summary}");
    let doubt = &summary["doubts"][0];
    assert_eq!((&doubt["imu"], &doubt["campaigns"], &doubt["of"]), (&json!("ODD"), &json!(1), &json!(1)), "{summary}");
    assert_eq!(summary["doubts"].as_array().unwrap().len(), 1);
    let overview = summary["effects"].as_array().unwrap().iter().find(|e| e["effect"] == "temperature_bias").unwrap();
    assert_eq!((&overview["imus"], &overview["first_at"]), (&json!(["WARM"]), &json!("2026-05-15T12:00:00Z")));

    narrowed_down(&lab).await;
    voided_campaigns_are_left_out(&lab, &ids[3]).await;
}

async fn narrowed_down(lab: &Lab) {
    for (query, serials) in [
        ("imu=LAG", &["LAG-2", "LAG-3"][..]),
        ("effect=temperature_bias", &["WARM-1"]),
        ("effect=warmup", &[]),
        ("station=ST-1&effect=hysteresis", &[]),
        ("since=2026-05-18T00:00:00Z", &["WARM-1"]),
        ("since=2026-05-18T00:00:00+00:00", &["WARM-1"]),
        ("until=2026-05-14T00:00:00%2B08:00&imu=WARM", &[]),
    ] {
        let summary = lab.get(&format!("/v1/diagnoses/summary?{query}")).await.ok();
        let findings = summary["findings"].as_array().unwrap();
        let named: Vec<&str> = findings.iter().filter_map(|f| f["serial"].as_str()).collect();
        assert_eq!(named, serials, "{query}: {summary}");
    }
    let csv = lab.get("/v1/diagnoses/summary?format=csv&imu=WARM").await;
    assert!(csv.header("content-type").starts_with("text/csv"));
    let lines: Vec<&str> = csv.text.lines().collect();
    assert_eq!(lines.len(), 2, "{}", csv.text);
    assert!(lines[0].starts_with("kind,effect,class,imu,slot,serial,stations,campaigns,of,"));
    assert!(
        lines[1].starts_with(
            "effect,temperature_bias,temperature_bias,WARM,G1,WARM-1,ST-1;ST-2,2,4,2,2026-05-08T12:00:00Z,"
        )
    );
}

async fn voided_campaigns_are_left_out(lab: &Lab, last: &str) {
    let said = json!({"author": "Li Wei", "reason": "wrong position"});
    lab.post(&format!("/v1/campaigns/{last}/void"), &said).await;
    let summary = lab.get("/v1/diagnoses/summary?imu=WARM").await.ok();
    let warm = found(&summary, "temperature_bias", "WARM-1");
    assert_eq!((&warm["campaigns"], &warm["of"]), (&json!(1), &json!(3)));
    let order = lab.post("/v1/diagnoses", &json!({ "imu": "WARM" })).await.json();
    assert_eq!(order["counts"]["campaigns"], 3);
}

#[tokio::test]
async fn an_order_leaves_alone_what_is_up_to_date_and_the_same_order_is_one_order() {
    let lab = Lab::open().await;
    let mut refused = campaign("SHORT", 2, "ST-1", None);
    refused["dwells"].as_array_mut().unwrap().truncate(2);
    lab.post("/v1/campaigns", &refused).await.created();
    for day in 1..=3 {
        lab.post("/v1/campaigns", &campaign("FINE", day, "ST-1", None)).await.created();
    }
    let again = json!({ "again": true });
    let (first, second) = (lab.post("/v1/diagnoses", &again).await, lab.post("/v1/diagnoses", &again).await);
    assert_eq!((first.status, second.status), (202, 200));
    assert_eq!(id(&first.json()), id(&second.json()));
    let order = ended(&lab, id(&first.json())).await;
    assert_eq!((&order["counts"]["done"], &order["counts"]["failed"]), (&json!(3), &json!(1)), "{order}");
    let failure = &order["failures"][0];
    assert_eq!(failure["imu"], "SHORT");
    assert!(failure["reason"].as_str().unwrap().contains("2 dwells leave nothing over"), "{failure}");
    let none = lab.get(&format!("/v1/diagnoses/{}?limit=0", id(&order))).await;
    none.refused(400);
    assert!(none.text.contains("limit must be 1 to 1000"), "{}", none.text);

    // Nothing is to be made: it has ended when it is answered, with what failed before.
    let current = lab.post("/v1/diagnoses", &json!({})).await.json();
    assert_eq!(
        (&current["state"], &current["counts"]["done"], &current["counts"]["failed"]),
        (&json!("done"), &json!(3), &json!(1))
    );
    let nothing = lab.post("/v1/diagnoses", &json!({ "since": "2030-01-01T00:00:00Z" })).await.json();
    assert_eq!((&nothing["state"], &nothing["counts"]["campaigns"]), (&json!("done"), &json!(0)));

    let listed = lab.get("/v1/diagnoses?limit=2").await.ok();
    assert_eq!(listed["diagnoses"][0]["id"], nothing["id"]);
    assert_eq!(listed["diagnoses"][1]["id"], current["id"]);
    let rest = lab.get(&format!("/v1/diagnoses?cursor={}", listed["next"].as_str().unwrap())).await.ok();
    assert_eq!((&rest["diagnoses"][0]["id"], &rest["next"]), (&first.json()["id"], &Value::Null));
    assert_eq!(rest["diagnoses"][0]["asked_by"], "local");
    let audit = lab.get("/v1/audit?action=start%20diagnoses").await.ok();
    assert_eq!(audit["lines"].as_array().unwrap().len(), 3, "{audit}");
}

#[tokio::test]
async fn a_canceled_order_ends_and_keeps_what_was_done() {
    let lab = Lab::open().await;
    for day in 1..=20 {
        lab.post("/v1/campaigns", &campaign("FINE", day, "ST-1", None)).await.created();
    }
    let order = lab.post("/v1/diagnoses", &json!({ "again": true })).await.json();
    let path = format!("/v1/diagnoses/{}", id(&order));
    assert_eq!(cancels(&lab, &path).await, 204);
    let order = lab.get(&path).await.ok();
    let counts = &order["counts"];
    assert_eq!((&order["state"], &counts["waiting"]), (&json!("canceled"), &json!(0)));
    assert!(counts["canceled"].as_u64().unwrap() > 0, "{order}");
    assert_eq!(counts["canceled"].as_u64().unwrap() + counts["done"].as_u64().unwrap(), 20);
    assert_eq!(cancels(&lab, &path).await, 204, "once more changes nothing");
    let current = lab.post("/v1/diagnoses", &json!({ "imu": "FINE", "until": "2026-05-02T00:00:00Z" })).await.json();
    ended(&lab, id(&current)).await;
    assert_eq!(cancels(&lab, &format!("/v1/diagnoses/{}", id(&current))).await, 409);
    for unknown in ["/v1/diagnoses/0000000000000", "/v1/diagnoses/nonsense"] {
        assert_eq!(cancels(&lab, unknown).await, 404);
        lab.get(unknown).await.refused(404);
    }
}

async fn cancels(lab: &Lab, path: &str) -> u16 {
    lab.request(Method::DELETE, path).send().await.unwrap().status().as_u16()
}

#[tokio::test]
async fn what_cannot_be_meant_is_refused_at_its_place() {
    let lab = Lab::open().await;
    lab.post("/v1/campaigns", &campaign("FINE", 1, "ST-1", None)).await.created();
    for (body, places) in [
        (json!({"imu": "NOBODY", "station": "NOWHERE"}), &["/imu", "/station"][..]),
        (json!({"since": "yesterday", "until": "2026-05-32"}), &["/since", "/until"]),
        (json!({"since": "2026-05-02T00:00:00Z", "until": "2026-05-01T00:00:00Z"}), &["/until"]),
        (json!({"gyro": "FINE-1"}), &["/gyro"]),
        (json!({"again": "yes"}), &["/again"]),
    ] {
        assert_eq!(lab.post("/v1/diagnoses", &body).await.refused(422), places, "{body}");
    }
    lab.post_text("/v1/diagnoses", lab::JSON, "{").await.refused(400);
    lab.post_text("/v1/diagnoses", "text/plain", "{}").await.refused(415);
    for (query, said) in [
        ("imu=NOBODY", "imu: no IMU is named NOBODY"),
        ("effect=gremlins", "effect: unknown effect \\\"gremlins\\\"; the catalogue has g_linear"),
        ("since=2026", "since: must be a day (UTC) such as"),
        ("format=xml", "format must be one of json, csv"),
        ("gyro=x", "unknown parameter `gyro`"),
    ] {
        let answer = lab.get(&format!("/v1/diagnoses/summary?{query}")).await;
        answer.refused(400);
        assert!(answer.text.contains(said), "{query}: {}", answer.text);
    }
    assert_eq!(lab.get("/v1/diagnoses").await.ok()["diagnoses"], json!([]), "nothing was begun");
}

/// How many tasks of an order have been settled.
async fn settled(server: &Server, path: &str) -> (u64, u64, bool) {
    let order = server.get(path).await.json();
    let count = |name: &str| order["counts"][name].as_u64().unwrap();
    (count("done"), count("waiting"), order["ended_at"].is_null())
}

#[tokio::test]
async fn an_order_goes_on_after_kill_9_and_what_was_done_stays_done() {
    let mut server = Server::start().await;
    const CAMPAIGNS: u32 = 12;
    for day in 1..=CAMPAIGNS {
        let body = campaign("FINE", day, "ST-1", (day > 6).then(|| in_gyros("temperature_bias", &["G2"])));
        assert_eq!(server.post_json("/v1/campaigns", &body).await.status, 201);
    }
    let order = server.post_json("/v1/diagnoses", &json!({ "again": true })).await.json();
    let path = format!("/v1/diagnoses/{}", id(&order));
    let mut kills = 0;
    let patience = Instant::now() + Duration::from_secs(180);
    let mut before = 0;
    loop {
        let (done, waiting, open) = settled(&server, &path).await;
        assert!(
            done >= before && done + waiting == u64::from(CAMPAIGNS),
            "{done} done, {waiting} waiting, {before} before"
        );
        if !open {
            break;
        }
        if done >= 3 * (kills + 1) && waiting > 0 {
            server.kill();
            server.restart();
            kills += 1;
        }
        before = done;
        assert!(Instant::now() < patience, "{done} done");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    assert!(kills > 1, "it was over too soon");
    assert_eq!(settled(&server, &path).await, (u64::from(CAMPAIGNS), 0, false));
    let summary = server.get("/v1/diagnoses/summary").await.json();
    let warm = found(&summary, "temperature_bias", "FINE-2");
    assert_eq!((&warm["campaigns"], &warm["first"]["measured_at"]), (&json!(6), &json!("2026-05-07T12:00:00Z")));
    let metrics = server.get("/metrics").await.text();
    assert!(metrics.contains("gyrowatch_diagnoses_waiting{for=\"ordered\"} 0"), "{metrics}");
}

#[tokio::test]
async fn the_command_line_orders_follows_and_prints_what_was_found() {
    let server = Server::start().await;
    let mut short = campaign("SHORT", 2, "ST-1", None);
    short["dwells"].as_array_mut().unwrap().truncate(2);
    for body in [campaign("WARM", 1, "ST-1", Some(in_gyros("temperature_bias", &["G1"]))), short] {
        assert_eq!(server.post_json("/v1/campaigns", &body).await.status, 201);
    }
    let run = |arguments: &[&str]| {
        let mut command = gyrowatch();
        command.args(["diagnose", "--all", "--url", server.address()]).args(arguments);
        tokio::task::spawn_blocking(move || command.output().unwrap())
    };
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();

    let printed = run(&["--imu", "WARM"]).await.unwrap();
    assert!(printed.status.success(), "{printed:?}");
    let table = text(&printed.stdout);
    let there = ["1 campaign diagnosed: 1 with a gap that is explained", "temperature_bias", "WARM-1 G1", "2026-05-01"];
    holds(&table, &there);
    // One that leaves nothing to diagnose: named, and told by the exit status; the summary is printed all the same.
    let all = run(&["--format", "json", "--again"]).await.unwrap();
    assert_eq!(all.status.code(), Some(1), "{all:?}");
    let summary: Value = serde_json::from_slice(&all.stdout).unwrap();
    assert_eq!(summary, server.get("/v1/diagnoses/summary").await.json());
    let said = text(&all.stderr);
    assert!(said.contains("of SHORT") && said.contains("2 dwells leave nothing over"), "{said}");
    assert!(said.contains("1 of 2 campaigns could not be diagnosed"), "{said}");

    let unknown = run(&["--station", "NOWHERE"]).await.unwrap();
    assert_eq!(unknown.status.code(), Some(1));
    assert!(unknown.stdout.is_empty() && text(&unknown.stderr).contains("/station: no station is named NOWHERE"));
    for wrong in
        [&["diagnose"][..], &["diagnose", "--imu", "X", "campaign.json"], &["diagnose", "--all", "campaign.json"]]
    {
        assert_eq!(gyrowatch().args(wrong).output().unwrap().status.code(), Some(2), "{wrong:?}");
    }
}

#[tokio::test]
async fn the_page_shows_what_was_found_and_takes_an_order() {
    let server = Server::start().await;
    let body = campaign("WARM", 1, "ST-1", Some(in_gyros("temperature_bias", &["G1"])));
    let stored = server.post_json("/v1/campaigns", &body).await.json();
    let empty = server.get("/diagnoses").await;
    assert!(empty.status == 200 && empty.text().contains("No order yet"));

    let origin = server.url("");
    let send = async |path: &str, origin: &str, form: &'static str| server.send_form(origin, path, form).await;
    let wrong = send("/diagnoses", &origin, "imu=NOBODY&since=2026-05-01").await;
    assert_eq!(wrong.status, 422);
    assert!(wrong.text().contains("IMU: no IMU is named NOBODY") && wrong.text().contains("value=\"NOBODY\""));
    assert_eq!(send("/diagnoses", "https://evil.example", "again=yes").await.status, 403);
    assert_eq!(server.get("/v1/diagnoses").await.json()["diagnoses"], json!([]));

    let taken = send("/diagnoses", &origin, "imu=WARM&since=2026-05-01&until=2026-05-01&again=yes").await;
    assert_eq!((taken.status, &taken.headers["location"]), (303, &"/diagnoses#orders".parse().unwrap()));
    once(async || server.get("/diagnoses").await.text(), |page| page.contains("</svg>done</span>")).await;
    let order = &server.get("/v1/diagnoses").await.json()["diagnoses"][0];
    assert_eq!(order["asked"]["until"], "2026-05-01T23:59:59.999999Z");
    assert_eq!(order["counts"]["done"], 1, "{order}");

    let page = server.get("/diagnoses").await.text();
    let diagnosis = format!("href=\"/campaigns/{}/diagnosis\"", stored["id"].as_str().unwrap());
    holds(&page, &["bias changes with temperature", "WARM-1", "href=\"/imus/WARM\"", "ST-1", &diagnosis, "1 / 1 / 1"]);
    let chinese = server.call("GET", "/diagnoses?imu=NOBODY", &[("accept-language", "zh")], "").await;
    assert!(chinese.status == 400 && chinese.text().contains("没有名为NOBODY的IMU"), "{}", chinese.text());
    let chinese = server.call("GET", "/diagnoses", &[("accept-language", "zh")], "").await.text();
    assert!(chinese.contains("零偏随温度变化") && chinese.contains("首次出现") && !chinese.contains("First with it"));
    assert!(!server.get("/diagnoses?effect=warmup").await.text().contains("WARM-1"));

    let path = format!("/diagnoses/{}/cancel", id(order));
    assert_eq!(send(&path, "https://evil.example", "").await.status, 403);
    assert_eq!(send(&path, &origin, "").await.status, 409, "it has ended");
    assert_eq!(send("/diagnoses/0000000000000/cancel", &origin, "").await.status, 404);
}

#[tokio::test]
async fn what_a_diagnosis_names_is_adopted_and_undone_on_the_pages() {
    let server = Server::start().await;
    let sent = campaign("WARM", 3, "ST-1", Some(in_gyros("temperature_bias", &["G1", "G2", "G3"])));
    let stored = server.post_json("/v1/campaigns", &sent).await.created();
    let id = id(&stored);
    let diagnosed = || async {
        let look = async || server.get(&format!("/v1/campaigns/{id}/diagnosis")).await;
        once(look, |answer| answer.status != 202).await.json()
    };
    let named = diagnosed().await["effects"].clone();
    assert!(!named.as_array().unwrap().is_empty());
    let form = format!("/campaigns/{id}/adopt");
    let page = server.get(&format!("/campaigns/{id}/diagnosis")).await.text();
    assert!(page.contains(&format!("href=\"{form}\"")), "{page}");
    assert!(server.get(&form).await.text().contains("enters the model of this IMU"));
    let origin = server.url("");
    let send = async |path: &str, form: &'static str| server.send_form(&origin, path, form).await;
    let models = || async { server.get("/v1/imus/WARM/model").await.json() };
    assert_eq!(send(&form, "by=M&reason=").await.status, 422, "without a reason");
    assert_eq!(models().await["history"], json!([]));
    let adopted = send(&form, "by=M.+Adopter&reason=held+out").await;
    assert_eq!((adopted.status, &adopted.headers["location"]), (303, &"/imus/WARM#models".parse().unwrap()));
    let in_force = models().await;
    assert_eq!(in_force["model"]["effects"][0]["effect"], named[0]["effect"], "{in_force}");
    assert_eq!(in_force["history"][0]["author"], "M. Adopter");
    assert_eq!(diagnosed().await["verdict"], "no_gap");
    assert_eq!(server.get(&form).await.status, 409, "nothing is named beside the model");

    let undo = "/imus/WARM/model/undo";
    assert!(server.get("/imus/WARM").await.text().contains(&format!("href=\"{undo}\"")));
    assert!(server.get(undo).await.text().contains("temperature_bias"));
    assert_eq!(send(undo, "by=M.+Adopter&reason=too+early").await.status, 303);
    let in_force = models().await;
    assert_eq!((&in_force["model"]["effects"], in_force["history"].as_array().unwrap().len()), (&json!([]), 2));
    assert_eq!(diagnosed().await["effects"][0]["effect"], named[0]["effect"]);
    assert_eq!(server.get("/imus/NOBODY/model/undo").await.status, 404);
}
