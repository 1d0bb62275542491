//! The web pages as they leave the service, before any script: whole, in the viewer's language, naming no other host.

use crate::lab::bench;
use crate::prelude::*;
use crate::spoken;
use crate::support::{Answer, FORM};

/// A calibration of one gyro: D_I and D_S along its nominal triad, E of length one.
fn record(imu: &str, station: &str, serial: &str, day: u32, d: [f64; 2]) -> Value {
    let (input, spin) = ([0.5773502691896258, -0.4082482904638631, 0.7071067811865475], [0.0, 0.8660254037844387, 0.5]);
    let g: Vec<f64> = (0..3).map(|i| d[0] * input[i] + d[1] * spin[i]).collect();
    json!({
        "imu": imu, "station": station, "calibrated_at": format!("2026-{:02}-{:02}T08:00:00Z", 1 + day / 28, 1 + day % 28),
        "geometry": {"G1": {"input": input, "spin": spin}},
        "gyros": [{"slot": "G1", "serial": serial, "e_pulse_per_arcsec": input, "g_pulse_per_s_g0": g}]
    })
}

async fn a_small_fleet() -> Server {
    let server = Server::start().await;
    for day in 0..8 {
        let steady = record("IMU-A", "ST-1", "STEADY", 7 * day, [1.5, -2.25]);
        let jump = if day < 4 { 0.0 } else { 0.05 };
        let jumping = record("IMU-B", "ST-2", "JUMP/1", 7 * day, [3.0 + jump, 4.0]);
        for body in [steady, jumping] {
            server.post_json("/v1/records", &body).await.created();
        }
    }
    server
}

async fn page(server: &Server, path: &str, headers: &[(&str, &str)]) -> String {
    let answer = server.call("GET", path, headers, "").await;
    assert_eq!((answer.status, answer.content_type.as_str()), (200, "text/html; charset=utf-8"), "{path}");
    answer.text()
}

fn place(text: &str, what: &str) -> usize {
    text.find(what).unwrap_or_else(|| panic!("{what} is not in {text}"))
}

#[tokio::test]
async fn the_fleet_shows_the_worst_first_and_is_narrowed_down_by_its_address() {
    let server = a_small_fleet().await;
    let all = page(&server, "/fleet", &[]).await;
    assert!(place(&all, "JUMP/1") < place(&all, "STEADY"));
    assert!(all.contains(r#"href="/gyros/JUMP%2F1""#) && all.contains("distance from baseline"));
    for (address, shown, hidden) in [
        ("/fleet?status=confirmed", "JUMP/1", "STEADY"),
        ("/fleet?status=in_tolerance", "STEADY", "JUMP/1"),
        // As earlier versions had it.
        ("/fleet?state=exceeded", "JUMP/1", "STEADY"),
        ("/fleet?state=within", "STEADY", "JUMP/1"),
        ("/fleet?q=imu-b", "JUMP/1", "STEADY"),
        ("/fleet?q=steady", "STEADY", "JUMP/1"),
        ("/fleet?station=ST-1", "STEADY", "JUMP/1"),
    ] {
        let some = page(&server, address, &[]).await;
        assert!(some.contains(shown) && !some.contains(hidden), "{address}: {some}");
    }
    for nothing in ["/fleet?q=nobody", "/fleet?status=drifting"] {
        assert!(page(&server, nothing, &[]).await.contains("Nothing fits"), "{nothing}");
    }
    // Counts follow the other filters, and where these stood before they lead on.
    let narrowed = page(&server, "/fleet?q=steady&sort=load", &[]).await;
    assert!(narrowed.contains("href=\"/fleet?q=steady&amp;status=in_tolerance&amp;sort=load\""), "{narrowed}");
    assert!(!narrowed.contains("status=confirmed"), "{narrowed}");
    let earlier = server.get("/?status=confirmed").await;
    assert_eq!(earlier.status, 308);
    assert_eq!(earlier.headers["location"], "/fleet?status=confirmed");
    for (sort, first, second) in
        [("load", "JUMP/1", "STEADY"), ("serial", "JUMP/1", "STEADY"), ("eta", "JUMP/1", "STEADY")]
    {
        let sorted = page(&server, &format!("/fleet?sort={sort}"), &[]).await;
        assert!(place(&sorted, first) < place(&sorted, second) && sorted.contains("aria-sort"), "{sort}");
    }
    let wall = server.get("/fleet?view=imu&refresh=60").await;
    assert_eq!(wall.headers["refresh"], "60");
    let wall = wall.text();
    assert!(wall.contains("article class=\"card confirmed\"") && wall.contains("href=\"/imus/IMU-B\""), "{wall}");
    assert_eq!(server.get("/fleet?changed_since=soon").await.status, 400);
    for unknown in
        ["/fleet?status=foo", "/fleet?rule=bar", "/fleet?view=imu&rule=bar", "/alerts?rule=bar", "/alerts?state=foo"]
    {
        let answer = server.get(unknown).await;
        assert!(answer.status == 400 && answer.text().contains("must be one of"), "{unknown}");
    }
    let both = page(&server, "/reports?gyro=JUMP%2F1&gyro=STEADY", &[]).await;
    assert!(both.contains("Report on gyro JUMP/1") && both.contains("Report on gyro STEADY"), "{both}");
    let chinese = page(&server, "/fleet", &[("accept-language", "zh")]).await;
    assert!(place(&chinese, "已证实") < place(&chinese, "合格") && !chinese.contains("超限"), "{chinese}");
}

#[tokio::test]
async fn what_is_found_is_gone_to_where_it_is_one_thing() {
    let server = a_small_fleet().await;
    let record = server.get("/v1/gyros/STEADY").await.json()["latest"]["record"].as_str().unwrap().to_owned();
    let alert = server.get("/v1/alerts").await.json()["alerts"][0]["id"].as_str().unwrap().to_owned();
    for (sought, place) in [
        ("STEADY", "/gyros/STEADY".to_owned()),
        ("steady", "/gyros/STEADY".to_owned()),
        ("JUMP/1", "/gyros/JUMP%2F1".to_owned()),
        ("IMU-B", "/imus/IMU-B".to_owned()),
        ("ST-2", "/stations/ST-2".to_owned()),
        ("imu", "/fleet?q=imu".to_owned()),
        ("nobody", "/fleet?q=nobody".to_owned()),
        ("", "/fleet".to_owned()),
        (&record, format!("/records/{record}")),
        (&alert, format!("/alerts/{alert}")),
    ] {
        let answer = server.get(&format!("/find?q={}", sought.replace('/', "%2F"))).await;
        assert_eq!((answer.status, goes_on_at(&answer)), (303, place.as_str()), "{sought}");
    }
}

#[tokio::test]
async fn limits_say_where_they_come_from_and_tokens_are_for_administrators() {
    let server =
        Server::start_with(&[("GYROWATCH_JUDGING__BUDGET", "0.02"), ("GYROWATCH_JUDGING__INTERVAL_DAYS", "45")]).await;
    let setup = page(&server, "/setup", &[]).await;
    let default =
        "Nothing is required of E and G. <code>judging.requirements</code> <span class=\"quiet\">default</span>";
    let stated = "<code>judging.budget</code> <span class=\"quiet\">environment</span>";
    holds(&setup, &[stated, "judging.interval_days", "0.0200", "Audit trail", default]);
    let admin = server.post_json("/v1/tokens", &json!({"name": "Chen", "role": "admin"})).await.json();
    let admin = format!("Bearer {}", admin["token"].as_str().unwrap());
    let made = json!({"name": "Li Wei", "role": "engineer"}).to_string();
    let headers = [("authorization", admin.as_str()), ("content-type", "application/json")];
    let engineer = server.call("POST", "/v1/tokens", &headers, made).await.json();
    let engineer = format!("Bearer {}", engineer["token"].as_str().unwrap());
    let all = page(&server, "/setup", &[("authorization", &admin)]).await;
    assert!(all.contains("Li Wei") && all.contains("create token"), "{all}");
    let some = page(&server, "/setup", &[("authorization", &engineer)]).await;
    assert!(some.contains("judging.budget") && !some.contains("Chen"), "{some}");
}

#[tokio::test]
async fn what_is_required_of_e_and_g_is_among_the_limits_with_its_key() {
    let server = Server::start_with(&[("GYROWATCH_JUDGING__REQUIREMENTS", "true")]).await;
    let setup = page(&server, "/setup", &[]).await;
    let required = &setup[place(&setup, "|E|")..];
    let there =
        ["1 … 3", "0.8425 … 0.8529", "-13.23 … 13.23", "judging.requirements</code> <span class=\"quiet\">environment"];
    holds(required, &there);
}

#[tokio::test]
async fn today_shows_what_became_worse_and_several_gyros_at_once() {
    let server = Server::start_with(&[("GYROWATCH_JUDGING__INTERVAL_DAYS", "30")]).await;
    for day in 0..6 {
        for k in 0..9 {
            // All that this station reads goes up by a third of the budget; one gyro leaves it.
            let d = 1.5 + if day == 5 { 0.0035 } else { 0.0 } + if k == 4 && day > 3 { 0.05 } else { 0.0 };
            let d = d + 1e-4 * f64::from((k * 7 + day as i32 * 3) % 5);
            let body = record(&format!("IMU-{k}"), "ST-7", &format!("MANY-{k}"), 7 * day, [d, 1.0]);
            assert_eq!(server.post_json("/v1/records", &body).await.status, 201);
        }
    }
    let today = page(&server, "/?since=2026-01-20", &[]).await;
    let there = [
        "MANY-4",
        "href=\"/stations/ST-7\">ST-7</a>",
        "9 gyros, median +3",
        "badge overdue",
        "/alerts/bulk?gyro=MANY-4",
    ];
    holds(&today, &there);
    assert!(!today.contains("MANY-3"), "it has not become worse: {today}");
    // What is new of a gyro that is out already stands with its own day.
    let body = record("IMU-4", "ST-7", "MANY-4", 42, [1.55, 1.05]);
    assert_eq!(server.post_json("/v1/records", &body).await.status, 201);
    let later = page(&server, "/?since=2026-02-10", &[]).await;
    let line = part(&later, "MANY-4</a>", "</tr>");
    assert!(line.contains("D<sub>S</sub>") && !line.contains("D<sub>I</sub>"), "{line}");
    assert!(line.contains("datetime=\"2026-02-15"), "{line}");
    let quiet = page(&server, "/?since=2100-01-01", &[("accept-language", "zh")]).await;
    let (new, still) = (place(&quiet, "没有新出现或加重的情况"), place(&quiet, "仍超差"));
    assert!(new < still && still < place(&quiet, "MANY-4"), "not new, and still out: {quiet}");
    assert_eq!(server.get("/?since=yesterday").await.status, 400);
}

#[tokio::test]
async fn a_gyro_is_shown_down_to_every_figure_without_a_script() {
    let server = a_small_fleet().await;
    let bench = json!({"serial": "STEADY", "station": "BENCH-1", "measured_at": "2026-02-20T08:00:00Z",
        "method": "torque_feedback", "d_i_deg_per_h_g0": 1.5005, "d_s_deg_per_h_g0": -2.2501, "d_i_sd": 4e-4, "d_s_sd": 4e-4});
    assert_eq!(server.post_json("/v1/bench-results", &bench).await.status, 201);
    let steady = page(&server, "/gyros/STEADY", &[]).await;
    holds(&steady, &["1.500000", "-2.250000", "IMU-A G1", "ST-1", "1.50050 ± 0.00040", "torque feedback", "0.000500"]);
    let jumping = page(&server, "/gyros/JUMP%2F1", &[]).await;
    assert!(jumping.contains("D_I is 0.0500 deg/(h g0) above its baseline 3.0000"), "{jumping}");
    assert!(jumping.contains("/v1/gyros/JUMP%2F1/trend?coefficient=D_I&amp;method=rigid&amp;format=csv"));
    let published = page(&server, "/gyros/STEADY?method=published", &[]).await;
    assert!(published.contains("method=published&amp;format=csv"));
}

#[tokio::test]
async fn a_gyro_whose_methods_disagree_is_unconfirmed_however_well_it_keeps_its_budget() {
    let server = a_small_fleet().await;
    let bench = bench("STEADY", "2026-02-20T08:00:00Z", 2.5, -2.2501);
    assert_eq!(server.post_json("/v1/bench-results", &bench).await.status, 201);
    // A hundred budgets apart in two results; the other gyro has moved by five, in several campaigns.
    let fleet = page(&server, "/fleet?state=exceeded", &[]).await;
    let table = &fleet[place(&fleet, "<tbody>")..];
    assert!(place(table, "JUMP/1") < place(table, "STEADY"), "{table}");
    assert!(table[place(table, "STEADY")..].contains("agreement of methods"), "{table}");
    for path in ["/gyros/STEADY", "/gyros/STEADY/report"] {
        let shown = page(&server, path, &[]).await;
        let head = &shown[place(&shown, "<h1>")..place(&shown, "</h1>")];
        assert!(head.contains("badge unconfirmed\">") && head.contains(">unconfirmed<"), "{path}: {head}");
    }
    let imu = page(&server, "/imus/IMU-A", &[]).await;
    assert!(imu[place(&imu, "STEADY")..].contains("badge unconfirmed"), "{imu}");
}

#[tokio::test]
async fn beyond_the_oldest_calibration_the_last_page_is_shown() {
    let server = a_small_fleet().await;
    for skip in ["500", "18446744073709551615"] {
        let shown = page(&server, &format!("/gyros/STEADY?skip={skip}"), &[]).await;
        let calibrations = &shown[place(&shown, "id=\"calibrations\"")..];
        assert!(calibrations.contains("1–8 / 8") && calibrations.contains("2026-01-01"), "{skip}: {calibrations}");
    }
}

#[tokio::test]
async fn what_does_not_exist_is_said_on_a_page() {
    let server = Server::start().await;
    let answer = server.get("/gyros/NOBODY").await;
    assert_eq!((answer.status, answer.content_type.as_str()), (404, "text/html; charset=utf-8"));
    assert!(answer.text().contains("no gyro has the serial NOBODY"));
    assert!(page(&server, "/fleet", &[]).await.contains("Nothing is stored yet"));
}

#[tokio::test]
async fn where_there_is_nothing_a_browser_is_answered_with_a_page_and_a_program_with_a_problem() {
    let server = Server::start().await;
    for path in ["/nowhere", "/v1/nowhere"] {
        let page = server.call("GET", path, &[("accept", "text/html,*/*;q=0.8")], "").await;
        assert_eq!((page.status, page.content_type.as_str()), (404, "text/html; charset=utf-8"), "{path}");
        assert!(page.text().contains("href=\"/fleet\""), "{}", page.text());
        let problem = server.call("GET", path, &[("accept", "*/*")], "").await;
        assert_eq!((problem.status, problem.content_type.as_str()), (404, "application/problem+json"), "{path}");
        assert!(problem.json()["detail"].as_str().unwrap().contains(path));
    }
}

#[tokio::test]
async fn an_address_or_a_form_that_cannot_be_read_is_said_on_a_page_in_words_of_this_service() {
    let server = Server::start().await;
    for (path, words) in
        [("/fleet?page=x", "page must be a whole number"), ("/fleet?page=1&page=2", "page is given twice")]
    {
        let answer = server.call("GET", path, &[("accept", "text/html")], "").await;
        assert_eq!((answer.status, answer.content_type.as_str()), (400, "text/html; charset=utf-8"), "{path}");
        assert!(answer.text().contains(words) && !answer.text().contains("deserialize"), "{path}: {}", answer.text());
    }
    let answer = sends_form(&server, "/diagnoses", &[("imu", "A"), ("imu", "B")]).await;
    assert_eq!((answer.status, answer.content_type.as_str()), (400, "text/html; charset=utf-8"), "{}", answer.text());
    assert!(answer.text().contains("imu is given twice"), "{}", answer.text());
}

#[tokio::test]
async fn nothing_is_loaded_from_elsewhere_and_nothing_inline_runs() {
    let server = a_small_fleet().await;
    for path in ["/", "/fleet", "/fleet?view=imu", "/gyros/STEADY"] {
        let answer = server.get(path).await;
        let policy = answer.headers["content-security-policy"].to_str().unwrap().to_owned();
        assert!(policy.contains("default-src 'none'") && policy.contains("script-src 'self';"), "{policy}");
        assert!(!policy.contains("unsafe"), "{policy}");
        let text = answer.text();
        assert!(!text.contains("http://") && !text.contains("https://"), "{path} names another host: {text}");
        assert!(!text.contains(" onclick=") && !text.contains("javascript:") && !text.contains(" style="));
        for script in text.split("<script").skip(1) {
            assert!(script.starts_with(" src=\"/assets/"), "{}", &script[..80]);
        }
    }
    let figure = server.get("/book/figures/paper-experiment.svg").await;
    assert_eq!(figure.headers["content-security-policy"], "default-src 'none'");
    assert!(!figure.text().contains("style"), "what the policy forbids is not in it");
}

#[tokio::test]
async fn assets_are_compressed_and_kept_for_ever() {
    let server = a_small_fleet().await;
    let text = page(&server, "/gyros/STEADY", &[]).await;
    let mut seen = 0;
    for path in text.split('"').filter(|part| part.starts_with("/assets/")) {
        let packed = server.call("GET", path, &[("accept-encoding", "gzip")], "").await;
        assert_eq!(packed.status, 200, "{path}");
        assert_eq!(packed.headers["content-encoding"], "gzip");
        assert_eq!(packed.headers["vary"], "accept-encoding");
        assert!(packed.headers["cache-control"].to_str().unwrap().contains("immutable"));
        let plain = server.get(path).await;
        assert!(!plain.headers.contains_key("content-encoding") && plain.body.len() > packed.body.len());
        seen += 1;
    }
    assert_eq!(seen, 2, "style sheet, script");
    assert_eq!(server.get("/assets/style-00000000.css").await.status, 404);
}

#[tokio::test]
async fn the_viewers_language_and_theme_are_kept() {
    let server = a_small_fleet().await;
    assert!(page(&server, "/", &[("accept-language", "zh-CN,en;q=0.5")]).await.contains("<html lang=\"zh\">"));
    let english = page(&server, "/", &[("accept-language", "zh"), ("cookie", "language=en; theme=dark")]).await;
    assert!(english.contains("<html lang=\"en\" data-theme=\"dark\">"));
    let chosen = server.get("/preference?language=zh&back=%2Fgyros%2FSTEADY").await;
    assert_eq!((chosen.status, &chosen.headers["location"]), (303, &"/gyros/STEADY".parse().unwrap()));
    assert!(chosen.headers["set-cookie"].to_str().unwrap().starts_with("language=zh; Path=/"));
    let away = server.get("/preference?theme=dark&back=%2F%2Fevil.example").await;
    assert_eq!(away.headers["location"], "/");
}

#[tokio::test]
async fn a_campaign_its_imu_and_its_diagnosis_are_shown_from_what_was_sent() {
    let server = Server::start_with(&[("GYROWATCH_JUDGING__REQUIREMENTS", "true")]).await;
    let campaign = data("practice/campaign-02.json");
    let answer = server.post("/v1/campaigns", "application/json", campaign).await.json();
    let id = answer["id"].as_str().unwrap();
    let shown = page(&server, &format!("/campaigns/{id}"), &[]).await;
    // What is shown is what the interface answers: E of the first gyro to the place of its uncertainty.
    let e = answer["calibration"]["gyros"][0]["e_pulse_per_arcsec"][0].as_f64().unwrap();
    let cell = shown
        .split("<td class=\"n\" data-label=\"E X, pulse/arcsec\"><div>")
        .find(|cell| cell.starts_with(&format!("{e:.7}")[..8]));
    assert!(cell.is_some_and(|cell| cell.contains(" ± ") && cell.contains("0.8425 … 0.8529")), "{cell:?}");
    assert_eq!(shown.matches("<figure class=\"chart\"").count(), 3, "residuals of three gyros");
    // What the standard deviations are made of, as it is answered; open where more than noise is in them.
    let budget = shown.split("id=\"budget\"").nth(1).unwrap().split("</details>").next().unwrap();
    let of_d_i = &answer["separations"][0]["uncertainty"]["d_i"];
    let [noise, discrepancy] = ["statistical", "discrepancy"].map(|part| of_d_i[part].as_f64().unwrap());
    assert!(noise > 0.0 && budget.contains(&format!("{noise:.2e}")[..4].replace('.', "")), "{noise} in {budget}");
    assert_eq!(budget.starts_with(" open"), discrepancy > 0.0, "{discrepancy}: {budget}");
    assert_eq!(budget.matches("<tr>").count(), 1 + 9, "three coefficients of three gyros");
    let imu = page(&server, "/imus/IMU-9002", &[]).await;
    assert!(imu.contains(&format!("/campaigns/{id}/diagnosis")) && imu.contains("/gyros/LFG-9002-1"));
    let moved = server.get(&format!("/records/{id}")).await;
    assert_eq!((moved.status, moved.headers["location"].to_str().unwrap()), (303, &*format!("/campaigns/{id}")));

    let diagnosis = page(&server, &format!("/campaigns/{id}/diagnosis"), &[]).await;
    let body = server.get(&format!("/v1/campaigns/{id}/diagnosis")).await.json();
    assert_eq!((&body["verdict"], &body["effects"][0]["effect"]), (&json!("explained"), &json!("temperature_bias")));
    assert!(place(&diagnosis, "Explained by the causes below.") < place(&diagnosis, "bias changes with temperature"));
    for candidate in body["candidates"].as_array().unwrap() {
        assert!(diagnosis.contains(candidate["effect"].as_str().unwrap()));
    }
    let chinese = page(&server, &format!("/campaigns/{id}/diagnosis"), &[("accept-language", "zh")]).await;
    assert!(chinese.contains("零偏随温度变化"));
    // What is said of it has the same codes in either language, and words in the language asked for.
    let in_chinese =
        server.call("GET", &format!("/v1/campaigns/{id}/diagnosis"), &[("accept-language", "zh")], "").await.json();
    let pairs =
        ["candidates", "not_identifiable"].map(|list| [&body, &in_chinese].map(|d| d[list].as_array().unwrap()));
    for ([english, chinese], words) in pairs.into_iter().zip(["why_not", "reason"]) {
        assert!(!english.is_empty() && english.len() == chinese.len());
        for (english, chinese) in english.iter().zip(chinese) {
            assert_eq!(english["finding"]["code"], chinese["finding"]["code"]);
            assert!(english[words].as_str().unwrap().is_ascii() && !chinese[words].as_str().unwrap().is_ascii());
            assert!(chinese["needs"].as_str().is_none_or(|needs| !needs.is_ascii()), "{chinese}");
        }
    }
    assert_eq!(body["note_codes"].as_array().unwrap().len(), body["notes"].as_array().unwrap().len());
    assert_eq!(server.get("/campaigns/0000000000000/diagnosis").await.status, 404);
}

#[tokio::test]
async fn an_imu_shows_its_models_and_how_its_campaigns_came_out_as_foretold() {
    let server = Server::start().await;
    let mut campaign = document("practice/campaign-02.json");
    // Two earlier campaigns tell of ageing; in the last one a gyro is another.
    for (day, added) in [("2026-05-01", 0.0), ("2026-05-08", 0.0), ("2026-05-15", 0.05)] {
        campaign["measured_at"] = format!("{day}T08:00:00Z").into();
        for dwell in campaign["dwells"].as_array_mut().unwrap() {
            let output = dwell["output_pulse_s"][0].as_f64().unwrap();
            let force = dwell["specific_force_g0"][0].as_f64().unwrap();
            dwell["output_pulse_s"][0] = (output + added * force).into();
        }
        let stored = server.post_json("/v1/campaigns", &campaign).await.json();
        let diagnosis = format!("/v1/campaigns/{}/diagnosis", stored["id"].as_str().unwrap());
        while server.get(&diagnosis).await.status == 202 {}
    }
    let imu = page(&server, "/imus/IMU-9002", &[]).await;
    let there = [
        "id=\"forecasts\"",
        "as forecast",
        "<strong>outside its forecast</strong>",
        "Error model, eq. (6)",
        "no earlier campaign",
    ];
    holds(&imu, &there);
    assert_eq!(imu.matches("<figure class=\"chart\"").count(), 1, "the forecast error over time");
    assert!(!imu.contains("id=\"models\""));
    let today = page(&server, "/?since=2026-05-10", &[]).await;
    assert!(place(&today, "Outside their forecast") < place(&today, "/imus/IMU-9002#forecasts"), "{today}");
    assert!(!page(&server, "/?since=2026-05-16", &[]).await.contains("Outside their forecast"));
    let adoption = json!({"effects": [{"effect": "temperature_bias", "gyros": ["G1", "G2", "G3"], "estimates": []}],
        "author": "M. Adopter", "reason": "it closes the gap"});
    assert_eq!(server.post_json("/v1/imus/IMU-9002/model", &adoption).await.status, 201);
    let imu = page(&server, "/imus/IMU-9002", &[("accept-language", "zh")]).await;
    assert!(imu.contains("id=\"models\"") && imu.contains("M. Adopter") && imu.contains("现用"), "{imu}");
    // What was foretold of them was foretold before: no diagnosis has to be made anew for it.
    assert_eq!(imu.matches("<figure class=\"chart\"").count(), 1, "{imu}");
    assert!(imu.contains("id=\"forecasts\"") && imu.contains("<strong>超出预报</strong>"), "{imu}");
}

#[tokio::test]
async fn a_record_is_shown_with_what_was_separated_from_it() {
    let server = Server::start_with(&[("GYROWATCH_JUDGING__REQUIREMENTS", "true")]).await;
    let answer = server.post("/v1/records", "application/json", data("paper.json")).await.json();
    let shown = page(&server, &format!("/records/{}", answer["id"].as_str().unwrap()), &[]).await;
    // Golden figures of Tables 3 and 4.
    let there = [
        "2.957643",
        "4.618005",
        "0.075874",
        "2.958219",
        "54.737806",
        "114.177661",
        "0.8425 … 0.8529",
        "judging.requirements",
    ];
    holds(&shown, &there);
    assert_eq!(server.get("/records/nonsense").await.status, 404);
    assert_eq!(server.get("/imus/NOBODY").await.status, 404);
}

#[tokio::test]
async fn the_diagnoses_of_a_record_and_of_a_gyro_are_found_from_their_pages() {
    let server = Server::start().await;
    let sends = async |day: u32, d_o: f64| {
        let mut body = record("IMU-A", "ST-1", "TURNED/1", day, [1.0, 2.0]);
        // O = I x S of the triad above.
        for (k, o) in [-0.8164965809277261, -0.2886751345948129, 0.5].into_iter().enumerate() {
            let g = &mut body["gyros"][0]["g_pulse_per_s_g0"][k];
            *g = json!(g.as_f64().unwrap() + d_o * o);
        }
        let answer = server.post_json("/v1/records", &body).await.created();
        answer["id"].as_str().unwrap().to_owned()
    };
    // The first of its gyro says nothing by its rule, whatever its D_O is.
    let (first, straight) = (sends(0, 0.3).await, sends(7, 0.0).await);
    sends(14, 0.0).await;
    let turned = sends(21, 0.3).await;
    let larger = "<strong>G1</strong>: D_O is larger than its noise";
    for (id, verdict, said, speaks) in [
        (straight, "no_gap", "D_I and D_S explain G", false),
        (first, "partly_explained", larger, false),
        (turned, "partly_explained", larger, true),
    ] {
        let shown = page(&server, &format!("/records/{id}"), &[]).await;
        let address = format!("/v1/records/{id}/diagnosis");
        assert!(shown.contains(said) && shown.contains(&format!("href=\"{address}\"")), "{shown}");
        let answer = server.get(&address).await.json();
        assert_eq!(answer["verdict"], verdict);
        // The page says what the answer does: D_O, the angle that would explain it, D_S then, what to measure.
        let closure = part(&shown, "<details id=\"closure\"", "</details>");
        let d_o = answer["where"]["gyros"][0]["d_o"].as_f64().unwrap();
        let impact = &answer["impact"][0];
        assert_eq!([closure.contains("seat it again"), closure.contains(" open>")], [speaks; 2], "{closure}");
        if impact.is_object() {
            assert!(closure.contains(&format!("{d_o:+.6}")), "{d_o}: {closure}");
            let then = impact["augmented"].as_f64().unwrap();
            let turn = answer["effects"][0]["estimates"][1]["value"].as_f64().unwrap().to_degrees() * 60.0;
            assert!(
                closure.contains(&format!(" → {then:.6}")) && closure.contains(&format!("{turn:+.1}")),
                "{closure}"
            );
        }
    }
    let address = "/v1/gyros/TURNED%2F1/diagnosis";
    let gyro = page(&server, "/gyros/TURNED%2F1", &[("accept-language", "zh")]).await;
    assert!(gyro.contains("href=\"/gyros/TURNED%2F1/diagnosis\">变化原因"), "{gyro}");
    let gyro = page(&server, "/gyros/TURNED%2F1/diagnosis", &[]).await;
    assert!(gyro.contains(&format!("href=\"{address}\"")), "{gyro}");
    assert_eq!(server.get(address).await.json()["serial"], "TURNED/1");
}

#[tokio::test]
async fn a_gyro_that_was_replaced_is_in_its_imu_no_more() {
    let server = Server::start().await;
    let sends = async |imu: &str, serial: &str, day: u32| {
        server.post_json("/v1/records", &record(imu, "ST-1", serial, day, [1.0, 2.0])).await.created();
    };
    sends("IMU-A", "FIRST", 0).await;
    sends("IMU-A", "SECOND", 7).await;
    for path in ["/imus/IMU-A", "/imus/IMU-A/report"] {
        let shown = page(&server, path, &[]).await;
        let before = place(&shown, "In it before");
        assert!(place(&shown, "/gyros/SECOND") < before && before < place(&shown, "/gyros/FIRST"), "{shown}");
        assert!(place(&shown[before..], "Last calibrated in it") < place(&shown[before..], "2026-01-01"), "{shown}");
        assert!(!shown.contains("<h2>Gyro FIRST"), "a report has a sheet for each gyro that is in it");
    }
    // The slot does not fall back to the first when the second goes on to another IMU.
    sends("IMU-B", "SECOND", 14).await;
    let left = page(&server, "/imus/IMU-A", &[("accept-language", "zh")]).await;
    let seats = &left[..place(&left, "最新参数")];
    assert!(!seats.contains("/gyros/SECOND") && place(seats, "曾装陀螺") < place(seats, "/gyros/FIRST"), "{left}");
    assert!(page(&server, "/imus/IMU-B", &[]).await.contains("/gyros/SECOND"));
}

#[tokio::test]
async fn a_gyro_that_was_replaced_stays_so_when_a_record_leaves_its_slot_out() {
    let server = Server::start().await;
    let sends = async |imu: &str, slot: &str, serial: &str, day: u32| {
        let mut body = record(imu, "ST-1", serial, day, [1.0, 2.0]);
        body["gyros"][0]["slot"] = slot.into();
        body["geometry"] = json!({slot: body["geometry"]["G1"]});
        server.post_json("/v1/records", &body).await.created();
    };
    sends("IMU-A", "G1", "FIRST", 0).await;
    sends("IMU-A", "G3", "ALONE", 3).await;
    sends("IMU-A", "G1", "SECOND", 7).await;
    // More than are looked at in one go.
    for day in 10..20 {
        sends("IMU-A", "G2", "OTHER", day).await;
    }
    sends("IMU-B", "G1", "SECOND", 21).await;
    let shown = page(&server, "/imus/IMU-A", &[]).await;
    let before = place(&shown, "In it before");
    assert!(place(&shown, "/gyros/OTHER") < before && before < place(&shown, "/gyros/FIRST"), "{shown}");
    assert!(place(&shown, "/gyros/ALONE") < before, "nothing came into its slot since: {shown}");
}

#[tokio::test]
async fn an_imu_without_gyros_says_why_there_are_none() {
    let server = Server::start().await;
    let answer = server.post_json("/v1/records", &record("IMU-A", "ST-1", "GYRO", 0, [1.0, 2.0])).await;
    let id = answer.json()["id"].as_str().unwrap().to_owned();
    let said = json!({"author": "Li Wei", "reason": "table was not level"});
    assert_eq!(server.post_json(&format!("/v1/records/{id}/void"), &said).await.status, 200);
    let voided = page(&server, "/imus/IMU-A", &[]).await;
    assert!(voided.contains("no calibration that counts") && !voided.contains("in another IMU since"), "{voided}");
    for (imu, day) in [("IMU-A", 7), ("IMU-B", 14)] {
        server.post_json("/v1/records", &record(imu, "ST-1", "GYRO", day, [1.0, 2.0])).await.created();
    }
    let left = page(&server, "/imus/IMU-A", &[]).await;
    assert!(left.contains("in another IMU since") && !left.contains("no calibration that counts"), "{left}");
}

#[tokio::test]
async fn a_preview_says_what_storing_would_refuse() {
    let server = Server::start().await;
    let there = record("IMU-A", "ST-1", "GYRO", 7, [1.0, 2.0]);
    let id = server.post_json("/v1/records", &there).await.json()["id"].as_str().unwrap().to_owned();
    let bench = |d_i: f64| bench("GYRO", "2026-02-20T08:00:00Z", d_i, -2.25);
    assert_eq!(server.post_json("/v1/bench-results", &bench(1.5)).await.status, 201);
    let lines = [
        there.clone(),
        record("IMU-A", "ST-1", "GYRO", 7, [1.5, 2.0]),
        record("IMU-B", "ST-1", "GYRO", 7, [1.0, 2.0]),
        record("IMU-A", "ST-1", "GYRO", 14, [1.0, 2.0]),
        record("IMU-A", "ST-1", "GYRO", 14, [1.5, 2.0]),
        record("IMU-C", "ST-1", "GYRO", 14, [1.0, 2.0]),
        record("IMU-A", "ST-1", "GYRO", 14, [1.0, 2.0]),
        bench(1.6),
    ];
    let text: Vec<String> = lines.iter().map(Value::to_string).collect();
    let form = format!("text={}\r\n", text.join("\r\n"));
    let sends =
        async |path: &str| server.call("POST", path, &[("content-type", "text/plain")], form.clone()).await.text();
    let preview = sends("/import/preview").await;
    assert!(preview.contains("3 can be stored") && preview.contains("<strong>5 cannot"), "{preview}");
    let said = |page: &str, line: usize| {
        let from = place(page, &format!("Line {line} · refused"));
        page[from..from + place(&page[from..], "</article>")].to_owned()
    };
    assert!(
        said(&preview, 2).contains(&format!("stored with other content (id {id}); they differ at gyros 1 ")),
        "{preview}"
    );
    assert!(said(&preview, 3).contains(&format!("gyro GYRO has another calibration at the same time (id {id})")));
    for line in [5, 6] {
        assert!(said(&preview, line).contains("same IMU or gyro and time as on line 4"), "{preview}");
    }
    assert!(said(&preview, 8).contains("they differ at d_i_deg_per_h_g0"), "{preview}");
    // Nothing was stored by looking, and storing refuses the same.
    assert_eq!(server.get("/v1/gyros/GYRO/trend").await.json()["points"].as_array().unwrap().len(), 1);
    let stored = sends("/import/store").await;
    for line in 1..=lines.len() {
        let refused = stored.contains(&format!("<p class=\"fault\">Line {line} · "));
        assert_eq!(refused, preview.contains(&format!("Line {line} · refused")), "line {line}: {stored}");
    }
}

#[tokio::test]
async fn a_preview_compares_with_the_last_values_and_is_not_green_for_what_is_hardly_true() {
    let server = Server::start().await;
    for day in 0..5 {
        let d = 1.0 + 1e-5 * f64::from(day);
        assert_eq!(
            server.post_json("/v1/records", &record("IMU-A", "ST-1", "GYRO", 7 * day, [d, 2.0])).await.status,
            201
        );
    }
    let preview = async |body: &Value| {
        let form = format!("file=Monday.json\r\ntext={body}\r\n");
        server.call("POST", "/import/preview", &[("content-type", "text/plain")], form).await.text()
    };
    let good = preview(&record("IMU-A", "ST-1", "GYRO", 35, [1.0012, 2.0])).await;
    holds(&good, &["article class=\"sound\"", "Monday.json", "1.000040", "2026-02-01", ">+12<", "badge in_tolerance"]);
    assert!(!good.contains("Check before storing"), "{good}");
    // 0.03 up: three budgets, which a gyro may do.
    let worse = preview(&record("IMU-A", "ST-1", "GYRO", 35, [1.03, 2.0])).await;
    assert!(worse.contains("article class=\"sound\"") && worse.contains("badge unconfirmed"), "{worse}");
    for (body, said) in [
        (record("IMU-A", "ST-1", "GYRO", 35, [6.19, 2.0]), "from its last value"),
        (record("IMU-A", "ST-9", "GYRO", 35, [1.0, 2.0]), "No calibration of this station is stored:"),
        (record("IMU-A", "ST-1", "OTHER", 35, [1.0, 2.0]), "this gyro is not:"),
    ] {
        let shown = preview(&body).await;
        assert!(shown.contains("article class=\"doubtful\"") && shown.contains(said), "{said}: {shown}");
        assert!(shown.contains("1 to be checked") && !shown.contains("class=\"sound\""), "{shown}");
    }
    assert_eq!(server.get("/v1/gyros/GYRO").await.json()["calibrations"], 5, "a preview stores nothing");
}

#[tokio::test]
async fn a_preview_marks_the_faulty_line_and_its_cell() {
    let server = Server::start().await;
    let preview = async |text: &str| {
        let form = format!("text={}\r\n", text.replace('\n', "\r\n"));
        server.call("POST", "/import/preview", &[("content-type", "text/plain")], form).await.text()
    };
    let mut bad = record("IMU-A", "ST-1", "GYRO", 7, [1.0, 2.0]);
    bad["gyros"][0]["e_pulse_per_arcsec"] = json!([0.0, 0.0, 0.0]);
    let shown = preview(&format!("{}\n{bad}\n", record("IMU-A", "ST-1", "GYRO", 0, [1.0, 2.0]))).await;
    assert!(shown.contains("<mark>[0.0,0.0,0.0]</mark>") && shown.contains("id=\"line-2\""), "{shown}");
    assert!(shown.contains("gyro 1, <code>e_pulse_per_arcsec</code>: ") && !shown.contains("/gyros/0"), "{shown}");
    let campaign = "# imu: IMU-1\nphase,start_s\nstatic,soon\n";
    let shown = preview(campaign).await;
    assert!(shown.contains("<mark>") && shown.contains("class=\"faulty\""), "{shown}");
}

#[tokio::test]
async fn a_preview_holds_no_more_documents_against_what_is_stored_than_it_shows() {
    let server = Server::start().await;
    let bench = |minute: usize, d_i: f64| {
        let at = format!("2026-02-20T{:02}:{:02}:00Z", minute / 60, minute % 60);
        bench("GYRO", &at, d_i, -2.25)
    };
    for minute in [199, 200] {
        assert_eq!(server.post_json("/v1/bench-results", &bench(minute, 1.5)).await.status, 201);
    }
    let previewed = async |count: usize| {
        let text: String = (0..count).map(|minute| format!("{}\r\n", bench(minute, 1.6))).collect();
        let kind = [("content-type", "text/plain")];
        server.call("POST", "/import/preview", &kind, format!("text={text}")).await.text()
    };
    let note = "storing tells of the others: 200";
    let (whole, larger) = (previewed(200).await, previewed(201).await);
    assert!(whole.contains("199 can be stored") && whole.contains("<strong>1 cannot") && !whole.contains(note));
    assert!(larger.contains("200 can be stored") && larger.contains("<strong>1 cannot") && larger.contains(note));
    assert!(larger.contains("Line 200 · refused") && !larger.contains("Line 201 · refused"));
}

#[tokio::test]
async fn a_station_is_shown_with_what_it_does_to_results() {
    let server = Server::start().await;
    for (day, station, d_i) in [(0, "ST-1", 1.0), (7, "ST-1", 1.002), (14, "ST-1", 1.0), (21, "ST-2", 1.5)] {
        server.post_json("/v1/records", &record("IMU-A", station, "ROAMER", day, [d_i, 2.0])).await.created();
    }
    let shown = page(&server, "/stations", &[]).await;
    // ST-2 reads 1.5 of the one gyro that was at both, the mean of ST-1 being 1.0007: 4,993 % of the budget, so it is first.
    assert!(shown.contains("+4993 ± 24<"), "{shown}");
    assert!(place(&shown, "/stations/ST-2") < place(&shown, "/stations/ST-1"), "{shown}");
    let one = page(&server, "/stations/ST-2", &[]).await;
    assert!(one.contains("Offset against ST-1") && one.contains("href=\"/v1/stations/ST-2\""), "{one}");
    let gyro = page(&server, "/gyros/ROAMER/diagnosis", &[]).await;
    assert!(
        gyro.contains("4 records: not enough data") && gyro.contains("href=\"/v1/gyros/ROAMER/diagnosis\""),
        "{gyro}"
    );
}

#[tokio::test]
async fn a_gyro_that_stepped_is_not_its_stations_scatter() {
    let server = Server::start().await;
    let noise = [0.3, -1.1, 0.8, 0.1, -0.6, 1.2, -0.2, -0.9, 0.5, 0.7, -1.0];
    // The same fleet at two stations, but for one gyro that steps at the first.
    for (station, step) in [("ST-1", 0.02), ("ST-2", 0.0)] {
        for gyro in 0..4_usize {
            for k in 0..8_u32 {
                let wobble = 6e-4 * noise[(3 * gyro + 5 * k as usize) % noise.len()];
                let stepped = if gyro == 2 && k >= 4 { step } else { 0.0 };
                let (imu, serial) = (format!("{station}-IMU-{gyro}"), format!("{station}-{gyro}"));
                let body = record(&imu, station, &serial, 7 * k, [1.0, 2.0 + stepped + wobble]);
                assert_eq!(server.post_json("/v1/records", &body).await.status, 201);
            }
        }
    }
    let shown = page(&server, "/stations", &[]).await;
    // D_S is the last figure of its cell.
    let of_cell = |cell: &str| cell[..place(cell, "</span> </td>")].rsplit(' ').next().unwrap().parse().unwrap();
    let cells: Vec<f64> = shown.split("data-label=\"Repeatability\">").skip(1).map(of_cell).collect();
    let [stepping, quiet] = cells[..] else { panic!("{shown}") };
    assert!((3.0..12.0).contains(&quiet) && (stepping / quiet - 1.0).abs() < 0.2, "{cells:?}");
}

/// A form as a browser sends it from a page of this service.
async fn sends_form(server: &Server, path: &str, fields: &[(&str, &str)]) -> Answer {
    sends_form_from(server, &server.url(""), path, fields).await
}

async fn sends_form_from(server: &Server, origin: &str, path: &str, fields: &[(&str, &str)]) -> Answer {
    let body = url::form_urlencoded::Serializer::new(String::new()).extend_pairs(fields).finish();
    server.send_form(origin, path, body).await
}

fn goes_on_at(answer: &Answer) -> &str {
    assert_eq!(answer.status, 303, "{}", answer.text());
    answer.headers["location"].to_str().unwrap()
}

#[tokio::test]
async fn an_alert_is_found_acknowledged_and_silenced_on_its_pages() {
    let server = a_small_fleet().await;
    let firing = page(&server, "/alerts", &[]).await;
    assert!(firing.contains(r#"href="/gyros/JUMP%2F1""#) && !firing.contains("STEADY"), "{firing}");
    assert!(
        firing.contains("badge confirmed\">")
            && firing.contains("</svg>confirmed<")
            && !firing.contains("badge warning"),
        "{firing}"
    );
    for empty in
        ["/alerts?state=silenced", "/alerts?serial=STEADY&state=all", "/alerts?serial=nobody", "/alerts?rule=overdue"]
    {
        assert!(page(&server, empty, &[]).await.contains("No alert fits"), "{empty}");
    }
    assert!(page(&server, "/alerts?serial=JUMP/1&rule=baseline", &[]).await.contains("distance from baseline"));
    let of_gyro = page(&server, "/gyros/JUMP%2F1", &[]).await;
    let link = of_gyro.split('"').find(|part| part.starts_with("/alerts/") && part.contains("/acknowledge")).unwrap();
    let path = link.split('?').next().unwrap();
    let alert = format!("/v1{}", path.strip_suffix("/acknowledge").unwrap());
    let asked = page(&server, &link.replace("&amp;", "&"), &[]).await;
    assert!(asked.contains("Stops the repeats of this alert") && !asked.contains("checkbox"), "{asked}");

    let said = [("by", "Li Wei"), ("reason", "the station was moved"), ("back", "/gyros/JUMP%2F1")];
    let nobody = sends_form(&server, path, &said[1..]).await;
    assert!(nobody.status == 422 && nobody.text().contains("the station was moved"), "{}", nobody.text());
    assert_eq!(sends_form(&server, path, &[said[0], said[2]]).await.status, 422, "without a reason");
    assert_eq!(sends_form_from(&server, "https://evil.example", path, &said).await.status, 403);
    assert!(server.get(&alert).await.json()["acknowledged"].is_null());

    assert_eq!(goes_on_at(&sends_form(&server, path, &said).await), "/gyros/JUMP%2F1");
    assert_eq!(server.get(&alert).await.json()["acknowledged"]["by"], "Li Wei");
    assert!(page(&server, "/alerts?state=acknowledged", &[]).await.contains("the station was moved"));

    let silence = path.replace("acknowledge", "silence");
    for days in ["", "0", "-1", "NaN", "1000"] {
        let fields = [said[0], said[1], said[2], ("days", days)];
        assert_eq!(sends_form(&server, &silence, &fields).await.status, 422, "{days:?} days");
    }
    let away = [said[0], said[1], ("days", "3"), ("back", "//evil.example")];
    assert_eq!(goes_on_at(&sends_form(&server, &silence, &away).await), "/alerts", "nobody is sent elsewhere");
    assert_eq!(server.get(&alert).await.json()["state"], "silenced");
    assert_eq!(server.get("/alerts/0000000000000/acknowledge").await.status, 404);
}

/// What a record shows that came late began before the week that is asked for: it says when it was found.
#[tokio::test]
async fn today_tells_when_a_record_that_came_late_was_found() {
    let server = a_small_fleet().await;
    let shown = page(&server, "/", &[]).await;
    let still = part(&shown, "Still out of tolerance", "</section>");
    holds(still, &["JUMP/1", "Found ", "datetime=\"2026-"]);
    let all = page(&server, "/?since=2026-01-01", &[]).await;
    assert!(!part(&all, "New or worse since", "</section>").contains("Found "), "{all}");
}

#[tokio::test]
async fn what_a_gyro_violates_stands_together_and_many_are_acknowledged_at_once() {
    let server = a_small_fleet().await;
    let again = record("IMU-B", "ST-2", "JUMP/1", 7 * 8, [3.5, 4.0]);
    assert_eq!(server.post_json("/v1/records", &again).await.status, 201);
    let firing = page(&server, "/alerts", &[]).await;
    assert_eq!(firing.matches("<article").count(), 1, "{firing}");
    let head = &firing[place(&firing, "<article")..];
    let summary = &head[place(head, "<summary")..place(head, "</summary>")];
    let alerts = server.get("/v1/alerts?state=firing").await.json()["alerts"].as_array().unwrap().len();
    assert!(alerts > 2 && summary.matches("class=\"violated\"").count() == alerts, "{alerts}: {summary}");
    holds(head, &["/gyros/JUMP%2F1", "distance from baseline", "</var> step", "IMU-B", "ST-2", "badge confirmed"]);
    assert!(firing.contains(&format!("firing <span class=\"count\">{alerts}</span>")), "{firing}");
    // Another gyro stands apart, after the one that is confirmed; three of one record stand together.
    let other = record("IMU-A", "ST-1", "STEADY", 7 * 8, [1.7, -2.25]);
    assert_eq!(server.post_json("/v1/records", &other).await.status, 201);
    let both = page(&server, "/alerts", &[]).await;
    assert!(both.matches("<article").count() == 2 && place(&both, "JUMP%2F1") < place(&both, "STEADY"), "{both}");
    assert!(!both.contains("class=\"together\""), "{both}");
    let nobody = [("gyro", "JUMP/1"), ("gyro", "STEADY"), ("deed", "acknowledge"), ("reason", "seen on Monday")];
    let refused = sends_form(&server, "/alerts/bulk", &nobody).await;
    assert!(refused.status == 422 && refused.text().contains("seen on Monday"), "nobody says who: {}", refused.text());
    let mut meant = nobody.to_vec();
    meant.extend([("by", "Li Wei"), ("back", "/alerts?state=firing")]);
    assert_eq!(sends_form_from(&server, "https://evil.example", "/alerts/bulk", &meant).await.status, 403);
    let done = sends_form(&server, "/alerts/bulk", &meant).await;
    let after = page(&server, goes_on_at(&done), &[]).await;
    assert!(!after.contains("<article") && after.contains("acknowledged: "), "{after}");
    let known = server.get("/v1/alerts?state=acknowledged").await.json()["alerts"].as_array().unwrap().clone();
    assert!(known.len() > alerts && known.iter().all(|alert| alert["acknowledged"]["by"] == "Li Wei"), "{known:?}");
    // One of them has a page of its own, with what was said; a comment changes nothing.
    let id = known[0]["id"].as_str().unwrap();
    let said =
        [("alert", id), ("deed", "comment"), ("by", "Zhao"), ("reason", "bearing ordered"), ("back", "/alerts/x")];
    assert_eq!(sends_form(&server, "/alerts/bulk", &said).await.status, 303);
    let own = page(&server, &format!("/alerts/{id}"), &[]).await;
    assert!(own.contains("bearing ordered") && own.contains("seen on Monday") && own.contains("comment"), "{own}");
    assert_eq!(server.get(&format!("/v1/alerts/{id}")).await.json()["state"], "acknowledged");
    // It is taken back for all that the address names.
    let ids = goes_on_at(&done).split("done=").nth(1).unwrap().split(',').collect::<Vec<_>>();
    let mut undo = vec![("deed", "unacknowledge"), ("by", "Li Wei"), ("reason", "too soon")];
    undo.extend(ids.iter().map(|id| ("alert", *id)));
    assert_eq!(goes_on_at(&sends_form(&server, "/alerts/bulk", &undo).await), "/alerts");
    assert_eq!(server.get("/v1/alerts?state=acknowledged").await.json()["alerts"], json!([]));
    assert_eq!(sends_form(&server, "/alerts/bulk", &[("deed", "acknowledge"), ("by", "L")]).await.status, 422);
    assert_eq!(sends_form(&server, "/alerts/bulk", &[("gyro", "NOBODY"), ("by", "L")]).await.status, 404);
    for unknown in ["/alerts/0000000000000", "/alerts/nonsense"] {
        assert_eq!(server.get(unknown).await.status, 404);
    }
    let silence = [("gyro", "STEADY"), ("deed", "silence"), ("by", "Li Wei"), ("reason", "table moved"), ("days", "2")];
    sends_form(&server, "/alerts/bulk", &silence).await;
    let silenced = page(&server, "/alerts?state=silenced", &[]).await;
    assert!(silenced.contains("STEADY") && !silenced.contains("JUMP%2F1"), "{silenced}");
    // What the next page says was done can be taken back from there; also on the start page.
    let from_today = |deed| {
        [("gyro", "STEADY"), ("deed", deed), ("by", "Li Wei"), ("reason", "moved"), ("days", "2"), ("back", "/")]
    };
    for (deed, back, state) in [("silence", "unsilence", "silenced"), ("acknowledge", "unacknowledge", "acknowledged")]
    {
        let address = format!("/v1/alerts?state={state}&serial=STEADY");
        let done = sends_form(&server, "/alerts/bulk", &from_today(deed)).await;
        let said = page(&server, goes_on_at(&done), &[]).await;
        let form = part(&said, "class=\"done\"", "</form>");
        assert!(form.contains(&format!("{state}: ")) && form.contains(&format!("value=\"{back}\"")), "{form}");
        let held = server.get(&address).await.json()["alerts"].as_array().unwrap().clone();
        let ids: Vec<&str> = held.iter().map(|alert| alert["id"].as_str().unwrap()).collect();
        assert!(!ids.is_empty() && ids.iter().all(|id| form.contains(id)), "{form}");
        let mut undo = vec![("deed", back), ("by", "Li Wei"), ("reason", "too soon")];
        undo.extend(ids.iter().map(|id| ("alert", *id)));
        goes_on_at(&sends_form(&server, "/alerts/bulk", &undo).await);
        assert_eq!(server.get(&address).await.json()["alerts"], json!([]), "{back}");
    }
}

#[tokio::test]
async fn gyros_that_one_record_has_shown_stand_under_their_imu() {
    let server = Server::start_with(&[("GYROWATCH_ALERTS__TICK_S", "0.1")]).await;
    for day in 0..5 {
        let shift = if day < 4 { 0.0 } else { 5.0 };
        let mut body = record("IMU-T", "ST-1", "T-1", 7 * day, [1.5 + shift, 2.0]);
        let first = body["gyros"][0].clone();
        for (slot, serial) in [("G2", "T-2"), ("G3", "T-3")] {
            let mut gyro = first.clone();
            (gyro["slot"], gyro["serial"]) = (slot.into(), serial.into());
            body["gyros"].as_array_mut().unwrap().push(gyro);
            body["geometry"][slot] = body["geometry"]["G1"].clone();
        }
        assert_eq!(server.post_json("/v1/records", &body).await.status, 201);
    }
    // Among servers the clock alone looks at IMUs.
    let together = |page: &String| page.contains("All 3 gyros of the IMU") && !page.contains("/gyros/T-1");
    let firing = once(async || page(&server, "/alerts", &[]).await, together).await;
    let of_imu = part(&firing, "class=\"together\"", "</section>");
    assert!(of_imu.contains("All 3 gyros of the IMU"), "{firing}");
    assert!(of_imu.contains("<th>IMU</th>") && !of_imu.contains("<th>Gyro</th>"), "{of_imu}");
    let inhibited = page(&server, "/alerts?state=inhibited", &[]).await;
    let together = &inhibited[place(&inhibited, "class=\"together\"")..];
    assert!(together.matches("<article").count() == 3 && together.contains("3 gyros by one record"), "{inhibited}");
    let today = page(&server, "/?since=2026-01-01", &[]).await;
    assert!(today.contains("Wrong file or wrong serials?") && today.contains("/imus/IMU-T"), "{today}");
}

#[tokio::test]
async fn gyros_that_are_overdue_with_their_imu_are_one_job() {
    let server =
        Server::start_with(&[("GYROWATCH_JUDGING__INTERVAL_DAYS", "60"), ("GYROWATCH_ALERTS__TICK_S", "1")]).await;
    for (imu, gyros) in [("IMU-T", 3), ("IMU-S", 1)] {
        let mut body = record(imu, "ST-1", &format!("{imu}-1"), 0, [1.5, 2.0]);
        let first = body["gyros"][0].clone();
        for k in 2..=gyros {
            let mut gyro = first.clone();
            (gyro["slot"], gyro["serial"]) = (format!("G{k}").into(), format!("{imu}-{k}").into());
            body["gyros"].as_array_mut().unwrap().push(gyro);
            body["geometry"][format!("G{k}")] = body["geometry"]["G1"].clone();
        }
        assert_eq!(server.post_json("/v1/records", &body).await.status, 201);
    }
    let look = async || page(&server, "/alerts", &[]).await;
    let alerts = once(look, |page| page.matches("<article").count() == 4).await;
    let together = part(&alerts, "class=\"together\"", "</section>");
    assert!(together.matches("<article").count() == 3 && together.contains("3 gyros · overdue"), "{alerts}");
    // What fires is the time since each was calibrated, and no load.
    assert!(together.matches(" days ago</span>").count() == 3 && !together.contains("class=\"bullet\""), "{together}");
}

#[tokio::test]
async fn what_was_done_to_a_gyro_is_noted_on_its_page() {
    let server = a_small_fleet().await;
    let path = "/gyros/STEADY/events/new";
    assert!(page(&server, &format!("{path}?event=baseline"), &[]).await.contains("distance from baseline"));
    let fields = [("event", "repair"), ("by", "Zhao Min"), ("reason", "bearing replaced")];
    let future = [fields[0], fields[1], fields[2], ("at", "2999-01-01T00:00:00Z")];
    for wrong in [&future[..], &fields[..2], &fields[1..]] {
        assert_eq!(sends_form(&server, path, wrong).await.status, 422, "{wrong:?}");
    }
    assert_eq!(sends_form_from(&server, "null", path, &fields).await.status, 403);
    assert_eq!(server.get("/v1/gyros/STEADY/events").await.json()["events"], json!([]));
    assert_eq!(goes_on_at(&sends_form(&server, path, &fields).await), "/gyros/STEADY#happenings");
    let event = &server.get("/v1/gyros/STEADY/events").await.json()["events"][0];
    assert_eq!((&event["event"], &event["author"]), (&json!("repair"), &json!("Zhao Min")));
    assert!(page(&server, "/gyros/STEADY", &[]).await.contains("bearing replaced"));
    // A repair ends what fires, and the alert says so.
    let alerts = server.get("/v1/alerts?serial=JUMP%2F1").await.json()["alerts"].clone();
    let fires = alerts.as_array().unwrap().iter().find(|alert| alert["rule"] == "baseline").unwrap();
    assert_eq!(fires["state"], "firing", "{alerts}");
    let alert = format!("/alerts/{}", fires["id"].as_str().unwrap());
    assert!(!page(&server, &alert, &[]).await.contains("bearing replaced"));
    assert_eq!(sends_form(&server, "/gyros/JUMP%2F1/events/new", &fields).await.status, 303);
    let ended = page(&server, &alert, &[]).await;
    assert!(place(&ended, ">resolved<") < place(&ended, "bearing replaced"), "{ended}");
    assert!(place(&ended, "Zhao Min") < place(&ended, "repair "), "{ended}");
    assert_eq!(sends_form(&server, "/gyros/NOBODY/events/new", &fields).await.status, 404);
}

/// The first address on a page that begins and ends so, as a browser would follow it.
fn link(page: &str, start: &str, end: &str) -> String {
    let addresses = page.split('"').filter(|part| part.starts_with(start));
    let found =
        addresses.map(|part| part.replace("&amp;", "&")).find(|part| part.split('?').next().unwrap().ends_with(end));
    found.unwrap_or_else(|| panic!("no {start}…{end} in {page}"))
}

#[tokio::test]
async fn a_calibration_is_voided_on_its_page_and_counts_no_more() {
    let server = a_small_fleet().await;
    let of_gyro = page(&server, "/gyros/JUMP%2F1", &[]).await;
    let ask = link(&of_gyro, "/records/", "/void");
    let (path, id) = (ask.split('?').next().unwrap(), ask.split('/').nth(2).unwrap());
    let form = page(&server, &ask, &[]).await;
    assert!(form.contains("It counts no more") && form.contains("3.050000"), "what is voided is shown: {form}");

    let said = [("by", "Li Wei"), ("reason", "table was not level"), ("back", "/gyros/JUMP%2F1")];
    let meant = [said[0], said[1], said[2], ("confirm", "yes")];
    let unmeant = sends_form(&server, path, &said).await;
    let shown = unmeant.text();
    assert!(unmeant.status == 422 && shown.contains("table was not level"), "{shown}");
    assert!(shown.contains("tick that you mean it"), "what cannot be undone is to be meant: {shown}");
    assert_eq!(sends_form(&server, path, &[meant[0], meant[3]]).await.status, 422, "without a reason");
    assert_eq!(sends_form_from(&server, "https://evil.example", path, &meant).await.status, 403);
    assert_eq!(server.get(&format!("/v1/records/{id}")).await.json()["state"], "valid");

    assert_eq!(goes_on_at(&sends_form(&server, path, &meant).await), "/gyros/JUMP%2F1");
    let stands = server.get(&format!("/v1/records/{id}")).await.json();
    assert_eq!((&stands["state"], &stands["voided"]["author"]), (&json!("voided"), &json!("Li Wei")));
    let after = page(&server, "/gyros/JUMP%2F1", &[]).await;
    let happened = &after[place(&after, "id=\"happenings\"")..];
    assert!(happened.contains("voided") && happened.contains("Li Wei: table was not level"), "{happened}");
    let calibrations = &after[place(&after, "id=\"calibrations\"")..];
    assert!(!calibrations.contains(id) && calibrations.contains("1–7 / 7"), "it is no longer among those that count");
    let own = page(&server, &format!("/records/{id}"), &[]).await;
    assert!(own.contains("Voided: it counts no more.") && !own.contains("/void"), "{own}");
    let words = stands["verdicts"].as_array().unwrap().iter().find(|said| said["rule"] == "baseline").unwrap();
    let words = words["reason"].as_str().unwrap().split(" (").next().unwrap();
    assert!(words.starts_with("D_I is 0.0500 deg/(h g0) above") && own.contains(words), "{words} is not in {own}");
    assert!(own.contains("None of this counts any more.") && own.contains("class=\"uncounted\""), "{own}");
    let chinese = page(&server, &format!("/records/{id}"), &[("accept-language", "zh")]).await;
    assert!(chinese.contains("现均不再计入") && chinese.contains("D_I比基线3.0000"), "{chinese}");
    for again in [server.get(path).await, sends_form(&server, path, &meant).await] {
        assert_eq!(again.status, 409, "what does not count cannot be voided");
    }
    assert_eq!(server.get("/records/0000000000000/void").await.status, 404);
}

#[tokio::test]
async fn a_campaign_and_a_bench_result_are_voided_on_their_pages() {
    let server = a_small_fleet().await;
    let campaign = server.post("/v1/campaigns", "application/json", data("practice/campaign-02.json")).await.json();
    let id = campaign["id"].as_str().unwrap();
    let ask = link(&page(&server, &format!("/campaigns/{id}"), &[]).await, "/campaigns/", "/void");
    assert!(page(&server, &ask, &[]).await.contains("Void this campaign"));
    let meant = [("by", "Li Wei"), ("reason", "wrong position"), ("confirm", "yes")];
    let path = format!("/campaigns/{id}");
    assert_eq!(goes_on_at(&sends_form(&server, &format!("{path}/void"), &meant).await), path);
    assert_eq!(server.get(&format!("/v1{path}")).await.json()["state"], "voided");

    let bench = bench("STEADY", "2026-02-20T08:00:00Z", 1.7005, -2.2501);
    assert_eq!(server.post_json("/v1/bench-results", &bench).await.status, 201);
    let of_gyro = page(&server, "/gyros/STEADY", &[]).await;
    assert!(of_gyro.contains("1.700500"));
    let ask = link(&of_gyro, "/bench-results/", "/void");
    assert!(page(&server, &ask, &[("accept-language", "zh")]).await.contains("作废该单表测试结果"));
    let path = ask.split('?').next().unwrap();
    assert_eq!(goes_on_at(&sends_form(&server, path, &meant).await), "/gyros/STEADY");
    let after = page(&server, "/gyros/STEADY", &[]).await;
    assert!(!after.contains("1.700500") && after.contains("Li Wei: wrong position"), "{after}");
    assert_eq!(server.get(path).await.status, 409);
}

/// Whoever has signed in is in the audit trail by the name of their token, whatever name the form has.
#[tokio::test]
async fn what_is_done_on_a_page_is_audited_under_the_name_that_signed_in() {
    let server = a_small_fleet().await;
    let made = server.post_json("/v1/tokens", &json!({"name": "Zhao Min", "role": "admin"})).await.json();
    let token = made["token"].as_str().unwrap();
    let signed_in = sends_form(&server, "/sign-in", &[("token", token)]).await;
    let cookie = signed_in.headers["set-cookie"].to_str().unwrap().split(';').next().unwrap().to_owned();
    let asked = |path: String| {
        let (server, cookie) = (&server, &cookie);
        async move { page(server, &path, &[("cookie", cookie)]).await }
    };
    let of_gyro = asked("/gyros/JUMP%2F1".into()).await;
    let alert = link(&of_gyro, "/alerts/", "/acknowledge");
    let record = link(&of_gyro, "/records/", "/void");
    let deeds = [
        (alert.split('?').next().unwrap(), "acknowledge", ""),
        ("/gyros/JUMP%2F1/events/new", "mark event", "repair"),
        ("/gyros/JUMP%2F1/events/new", "mark event", "baseline"),
        (record.split('?').next().unwrap(), "void", ""),
    ];
    let bearer = format!("Bearer {token}");
    for (path, action, event) in deeds {
        assert!(asked(path.to_owned()).await.contains("name=\"by\" value=\"Zhao Min\""), "{path}: who has signed in");
        let fields = [("by", "somebody"), ("reason", "to see"), ("confirm", "yes"), ("event", event)];
        let body = url::form_urlencoded::Serializer::new(String::new()).extend_pairs(fields).finish();
        let own = server.url("");
        let headers = [("content-type", FORM), ("origin", own.as_str()), ("cookie", cookie.as_str())];
        let done = server.call("POST", path, &headers, body).await;
        assert_eq!(done.status, 303, "{path}: {}", done.text());
        let trail = server.call("GET", "/v1/audit?limit=1", &[("authorization", &bearer)], "").await.json();
        let line = &trail["lines"][0];
        assert_eq!((&line["action"], &line["who"]), (&json!(action), &json!("Zhao Min")), "{line}");
    }
}

#[tokio::test]
async fn a_form_of_another_site_voids_nothing() {
    let server = a_small_fleet().await;
    let gyro = page(&server, "/gyros/JUMP%2F1", &[]).await;
    let void = link(&gyro, "/records/", "/void");
    let path = void.split('?').next().unwrap();
    let fields = [("by", "somebody"), ("reason", "to see"), ("confirm", "yes")];
    sends_form_from(&server, "http://elsewhere.example", path, &fields).await.has(403);
    assert_eq!(sends_form(&server, path, &fields).await.status, 303);
}

#[tokio::test]
async fn a_hook_is_set_up_tried_switched_off_and_deleted_on_its_pages() {
    let (server, target) = (Server::start().await, Receiver::start().await);
    let (url, meant) = (target.url(), ("confirm", "yes"));
    let fields = [("name", "chat"), ("kind", "standard-webhooks"), ("url", &*url), ("rules", "step, baseline")];
    let wrong = sends_form(&server, "/hooks/new", &[fields[0], fields[1], ("url", "ftp://x"), ("rules", "stpe")]).await;
    assert!(
        wrong.status == 422
            && wrong.text().contains("Address: must begin with http")
            && wrong.text().contains("/filter/rules/0")
    );
    let wrong = sends_form(&server, "/hooks/new", &[fields[0], fields[1], fields[2], ("expect", "errcode")]).await;
    assert!(wrong.status == 422 && wrong.text().contains("errcode = 0"), "{}", wrong.text());
    assert!(page(&server, "/hooks", &[]).await.contains("No hook is set up"));
    let robot = [("batch", "true"), ("expect", "errcode = 0, result=ok")];
    let robot = [("name", "robot"), fields[1], fields[2], robot[0], robot[1]];
    assert_eq!(sends_form(&server, "/hooks/new", &robot).await.status, 201);
    let robot = server.get("/v1/hooks").await.json()["hooks"][0].clone();
    assert_eq!((&robot["batch"], &robot["expect"]), (&json!(true), &json!({"json": {"errcode": 0, "result": "ok"}})));
    goes_on_at(&sends_form(&server, &format!("/hooks/{}/delete", robot["id"].as_str().unwrap()), &[meant]).await);

    let set_up = sends_form(&server, "/hooks/new", &fields).await;
    assert!(set_up.status == 201 && set_up.text().contains("whsec_"), "{}", set_up.text());
    let hook = server.get("/v1/hooks").await.json()["hooks"][0].clone();
    assert_eq!(hook["filter"]["rules"], json!(["step", "baseline"]));
    let path = format!("/hooks/{}", hook["id"].as_str().unwrap());
    assert!(!page(&server, &path, &[]).await.contains("whsec_"), "the secret is shown once");

    assert_eq!(goes_on_at(&sends_form(&server, &format!("{path}/test"), &[]).await), path);
    let told = async |count: usize| {
        target.has_been_told(count).await;
        let look = async || page(&server, &format!("{path}?state=delivered"), &[]).await;
        once(look, |page| page.contains("hook.test")).await;
    };
    told(1).await;
    let shown = page(&server, &path, &[]).await;
    let again = shown.split('"').find(|part| part.contains("/deliveries/")).unwrap().to_owned();
    assert_eq!(goes_on_at(&sends_form(&server, &again, &[]).await), path);
    told(2).await;
    assert_eq!(sends_form_from(&server, "https://evil.example", &format!("{path}/test"), &[]).await.status, 403);

    goes_on_at(&sends_form(&server, &format!("{path}/enabled"), &[("enabled", "false")]).await);
    assert!(page(&server, "/hooks", &[]).await.contains("disabled"));
    assert_eq!(sends_form(&server, &format!("{path}/test"), &[]).await.status, 409);
    assert_eq!(sends_form(&server, &format!("{path}/delete"), &[]).await.status, 422);
    assert_eq!(goes_on_at(&sends_form(&server, &format!("{path}/delete"), &[meant]).await), "/hooks");
    assert_eq!(server.get("/v1/hooks").await.json()["hooks"], json!([]));
}

#[tokio::test]
async fn a_delivery_names_its_gyro_and_what_comes_of_it_appears_by_itself() {
    let server = a_small_fleet().await;
    // Takes connections, and never answers.
    let silent = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("http://{}/", silent.local_addr().unwrap());
    let hook = json!({"kind": "cloudevents", "name": "chat", "url": url});
    let hook = server.post_json("/v1/hooks", &hook).await.json()["id"].as_str().unwrap().to_owned();
    let path = format!("/hooks/{hook}");
    once(async || page(&server, &path, &[]).await, |page| page.contains("JUMP/1")).await;
    let pending = server.get(&path).await;
    assert_eq!(pending.headers["refresh"], "2");
    let shown = pending.text();
    assert!(shown.contains("href=\"/alerts/") && shown.contains("<sub>I</sub>"), "{shown}");
    assert_eq!(sends_form(&server, &format!("{path}/enabled"), &[("enabled", "false")]).await.status, 303);
    assert!(!server.get(&path).await.headers.contains_key("refresh"), "nothing is about to come");
}

#[tokio::test]
async fn a_report_has_its_plots_without_a_script() {
    let server = a_small_fleet().await;
    let gyro = page(&server, "/gyros/JUMP%2F1/report", &[]).await;
    let there = [
        "role=\"group\" tabindex=\"0\" aria-label=\"JUMP/1 D_I",
        "<path class=\"confirmed\"",
        "above its baseline 3.0000",
        "judging.budget",
        "firing",
    ];
    holds(&gyro, &there);
    // One picture each of D_I, D_S and the closure, with a shape for every calibration, which leads to its record.
    assert_eq!(gyro.matches("<figure class=\"chart\"").count(), 3);
    let shapes = [
        "path class=\"confirmed",
        "path class=\"unconfirmed",
        "path class=\"drifting",
        "circle class=\"in_tolerance",
        "path class=\"not_enough_data",
    ];
    let keys = gyro.matches("<svg class=\"key\"").count();
    let drawn = shapes.iter().map(|shape| gyro.matches(&format!("<{shape}\"")).count()).sum::<usize>();
    assert!((3 * 8..=3 * 8 + keys).contains(&drawn), "{drawn} shapes, {keys} of them may be the legend's: {gyro}");
    assert_eq!(gyro.matches("<a class=\"point\" href=\"/records/").count(), 3 * 8);
    let imu = page(&server, "/imus/IMU-B/report", &[("accept-language", "zh")]).await;
    assert!(imu.contains("IMU报告") && imu.contains("JUMP/1") && imu.contains("偏离基线"));
    assert_eq!(server.get("/gyros/NOBODY/report").await.status, 404);
    // The first sheet is for deciding: limits in force, what the verdicts rest on, boxes; every sheet has its name.
    let decide = part(&gyro, "<section class=\"decide\"", "</section>");
    let there =
        ["+500 %", "judging.budget", "SHA-256", "newest record", "decision: re-test", "class=\"tick\"", "signature"];
    holds(decide, &there);
    assert_eq!(decide.matches("<figure class=\"chart\"").count(), 2);
    assert!(gyro.contains("counter(page)") && gyro.contains("content: \"JUMP\\2f 1\""), "{gyro}");
    let answer = server.get("/gyros/JUMP%2F1/report").await;
    let policy = answer.headers["content-security-policy"].to_str().unwrap();
    assert!(policy.contains("style-src 'self' 'sha256-") && !policy.contains("unsafe"), "{policy}");
}

/// A gyro without standard deviations, a month apart, in whatever IMU; its D_O is zero.
async fn posts(server: &Server, imu: &str, month: u32, d: [f64; 2]) -> String {
    let mut body = record(imu, "ST-1", "TESTED", 0, d);
    body["calibrated_at"] = format!("2025-{month:02}-01T08:00:00Z").into();
    let answer = server.post_json("/v1/records", &body).await.created();
    answer["id"].as_str().unwrap().to_owned()
}

#[tokio::test]
async fn an_environmental_test_is_seen_with_what_the_gyro_was_before_and_after() {
    let server = Server::start().await;
    for (month, d_s) in [(1, 2.0), (2, 2.001)] {
        posts(&server, "IMU-A", month, [1.0, d_s]).await;
    }
    let test = json!({"event": "environmental_test", "kind": "random vibration", "reason": "acceptance", "author": "Li",
        "from": "2025-02-10T00:00:00Z", "to": "2025-02-12T00:00:00Z"});
    assert_eq!(server.post_json("/v1/gyros/TESTED/events", &test).await.status, 201);
    let waiting = page(&server, "/gyros/TESTED", &[]).await;
    let table = &waiting[place(&waiting, "id=\"tests\"")..];
    assert!(table[..place(table, "</section>")].contains("not enough data"), "{table}");
    let after = posts(&server, "IMU-A", 3, [1.0, 2.0213]).await;
    posts(&server, "IMU-A", 4, [1.0, 2.001]).await;

    for path in ["/gyros/TESTED", "/gyros/TESTED/report", "/imus/IMU-A/report"] {
        let shown = page(&server, path, &[]).await;
        let table = &shown[place(&shown, "id=\"tests\"")..];
        let table = &table[..place(table, "</section>")];
        // 2.0213 - 2.001, in one campaign: the next one is back where the gyro was.
        for there in [
            "random vibration",
            "2.001000",
            "2.021300",
            "+0.020300",
            "0.0100",
            "judging.budget",
            "unconfirmed",
            "in tolerance",
            &after,
        ] {
            assert!(table.contains(there), "{path}: {there} is not in {table}");
        }
        assert!(!table.contains("not compared"), "{table}");
        assert!(shown.contains("environmental test: random vibration"), "{path}");
    }
    let report = page(&server, "/gyros/TESTED/report", &[]).await;
    assert_eq!(report.matches("<rect class=\"test\"").count(), 3, "one in each picture");
    let chinese = page(&server, "/gyros/TESTED/report", &[("accept-language", "zh")]).await;
    assert!(chinese.contains("环境试验前后") && chinese.contains("待复测"), "{chinese}");
    // An event that takes time is part of every stretch that it reaches into.
    for (from, count) in [("2025-02-11T00:00:00Z", 1), ("2025-02-13T00:00:00Z", 0)] {
        let trend = server.get(&format!("/v1/gyros/TESTED/trend?from={from}")).await.json();
        let events = trend["events"].as_array().unwrap();
        assert_eq!(events.len(), count, "{from}: {trend}");
        assert!(
            events.iter().all(|event| event["kind"] == "random vibration" && event["to"] == "2025-02-12T00:00:00Z")
        );
    }
}

#[tokio::test]
async fn a_gyro_that_moves_begins_a_new_level_of_d_o_alone() {
    let server = Server::start().await;
    for month in 1..=8 {
        posts(&server, if month < 5 { "IMU-A" } else { "IMU-B" }, month, [1.0, 2.0]).await;
    }
    let shown = page(&server, "/gyros/TESTED", &[]).await;
    let pictures: Vec<&str> = shown.split("<figure class=\"chart\"").skip(1).collect();
    let levels = |k: usize| pictures[k].matches("<line class=\"level\"").count();
    assert_eq!([levels(0), levels(1), levels(2)], [1, 1, 2], "{shown}");
    assert!(!shown.contains("Since the last baseline"), "no event has begun one");
    for picture in pictures {
        assert!(picture.contains("IMU-A G1</text>") && picture.contains("IMU-B G1</text>"), "a lane: {picture}");
    }
    // It is in tolerance where it is now, whatever it was elsewhere.
    assert!(shown[place(&shown, "<h1>")..place(&shown, "</h1>")].contains("badge in_tolerance"));
}

/// The part of a page that an element with this beginning holds.
fn part<'a>(page: &'a str, start: &str, end: &str) -> &'a str {
    let from = &page[place(page, start)..];
    &from[..place(from, end)]
}

#[tokio::test]
async fn a_gyro_is_headed_by_how_much_of_its_budget_it_takes_since_when_and_what_to_do() {
    let server = a_small_fleet().await;
    let jumping = page(&server, "/gyros/JUMP%2F1", &[]).await;
    let loads = part(&jumping, "<table class=\"loads\"", "</table>");
    // 0.05 above its baseline, five budgets; four records since the fifth week.
    holds(loads, &["+500 %", "badge confirmed", "2026-02-01 08:00 UTC", "(4 records)", "+0.050000", "0 %"]);
    assert!(place(&jumping, "class=\"loads\"") < place(&jumping, "Take it out. If it has stepped once"));
    assert!(place(&jumping, "Take it out. If it has stepped once") < place(&jumping, "<figure class=\"chart\""));
    assert!(place(&jumping, "<figure class=\"chart\"") < place(&jumping, "<table class=\"judged cards\""));
    let steady = page(&server, "/gyros/STEADY", &[("accept-language", "zh")]).await;
    assert!(steady.contains("放行") && steady.contains("占允许范围"), "{steady}");
    // The alert stands in the line of its verdict.
    let judged = part(&jumping, "<table class=\"judged cards\"", "</table>");
    holds(judged, &["D<sub>I</sub></var> distance from baseline", "firing", "/acknowledge", ">500<", "0.0100"]);
    assert_eq!(jumping.matches("D_I is 0.0500 deg/(h g0) above its baseline").count(), 1, "said once");
}

/// Its course has left the budget since its last calibration, which found it at nine tenths of it.
#[tokio::test]
async fn what_has_reached_its_budget_by_its_course_is_calibrated_now_and_stays_on_today() {
    let server = Server::start().await;
    for week in 0..36 {
        let noise = [2e-4, -2e-4, 1e-4, -1e-4, 0.0][week as usize % 5];
        let d_i = 1.5 + 2.6e-4 * f64::from(week) + noise;
        server.post_json("/v1/records", &record("IMU-A", "ST-1", "AGES", 7 * week, [d_i, -2.25])).await.created();
    }
    let report = page(&server, "/gyros/AGES/report", &[]).await;
    let suggested = part(&report, "<p class=\"suggestion\"", "</p>");
    assert!(suggested.contains("Calibrate now") && !suggested.contains("2026-"), "{suggested}");
    assert!(
        part(&report, "<div class=\"causes\"", "</div>").contains("it reached its budget on 2026-10-2"),
        "{report}"
    );
    let today = page(&server, "/", &[]).await;
    let reached = part(&today, "Will reach the budget", "</section>");
    holds(reached, &["AGES", "reached by its course", "Calibrate now", "2026-10-2"]);
    assert!(!reached.contains("Calibrate by"), "{reached}");
}

#[tokio::test]
async fn the_scatter_of_one_step_is_no_want_of_a_level() {
    let server = Server::start().await;
    let wander = [0.0, 0.9, 0.2, 1.7, 0.5, 1.4, -0.2, -0.9, -0.5, -1.4, 0.4, 1.6, 2.5, 2.0];
    for (k, wandered) in wander.into_iter().enumerate() {
        let d_i = 1.5 + [2e-4, -2e-4, 1e-4, -1e-4, 0.0][k % 5];
        let step = if k < 12 { 0.0 } else { 0.018 };
        let noise = 3e-4 * [0.3, -1.0, 0.8, 0.1, -0.6, 1.2, -0.2][k % 7];
        for (imu, serial, d_s) in [("IMU-B", "STEPS", step + noise), ("IMU-C", "WANDERS", 8e-3 * wandered)] {
            let sent = record(imu, "ST-1", serial, 10 * k as u32, [d_i, -2.25 + d_s]);
            server.post_json("/v1/records", &sent).await.created();
        }
    }
    // Both are out of tolerance for certain, and of both the rule of the scatter speaks.
    for (serial, expected) in [("STEPS", "If it has stepped once"), ("WANDERS", "it has no steady level")] {
        let report = page(&server, &format!("/gyros/{serial}/report"), &[]).await;
        let violated = part(&report, "<table class=\"judged cards\"", "</table>");
        assert!(violated.contains("scatter"), "{violated}");
        let suggested = part(&report, "<p class=\"suggestion\"", "</p>");
        assert!(suggested.contains(expected), "{serial}: {suggested}");
    }
}

/// It wanders by more than the rule of the level allows for, and each record is as good as ever.
#[tokio::test]
async fn a_gyro_that_scatters_needs_no_better_record_and_its_cause_is_told() {
    let server = Server::start().await;
    let noise = [0.3, -1.1, 0.8, 0.1, -0.6, 1.2, -0.2, -0.9, 0.5, 0.7, -1.0, 0.4, -0.3, 1.0, -0.8, 0.2, 0.6];
    for k in 0..31_u32 {
        let (at, i) = (f64::from(k), k as usize);
        let wander = 7e-3 * ((0.5 * at).sin() + 0.4 * (1.15 * at).sin());
        let [n, m] = [i, i + 4].map(|i| 5e-4 * noise[i * 5 % 17]);
        let mut sent = record("IMU-A", "ST-1", "WANDERS", 10 * k, [1.5 + wander + n, -2.25 + m]);
        sent["gyros"][0]["g_sd"] = json!([7e-4, 7e-4, 7e-4]);
        sent["gyros"][0]["e_sd"] = json!([1e-7, 1e-7, 1e-7]);
        server.post_json("/v1/records", &sent).await.created();
    }
    let report = page(&server, "/gyros/WANDERS/report", &[]).await;
    assert!(part(&report, "<h1>", "</h1>").contains("too uncertain"), "{report}");
    assert!(part(&report, "<p class=\"suggestion\"", "</p>").contains("Find why it changes"), "{report}");
    holds(part(&report, "<div class=\"causes\"", "</div>"), &["Unexplained", "It wanders by"]);
}

#[tokio::test]
async fn a_record_in_another_unit_or_under_a_misspelt_name_is_checked_first() {
    let server = Server::start().await;
    let stating = |serial: &str, day: u32, factor: f64, sd: f64| {
        let d_i = 1.5 + 1e-4 * f64::from(day % 5);
        let mut sent = record("IMU-A", "ST-1", serial, day, [factor * d_i, factor * -2.25]);
        sent["gyros"][0]["g_sd"] = vec![sd; 3].into();
        sent["gyros"][0]["e_sd"] = vec![1e-7; 3].into();
        sent
    };
    for day in 0..5 {
        server.post_json("/v1/records", &stating("LFG-01", 7 * day, 1.0, 7e-4)).await.created();
    }
    const CHECK: &str = "Check the newest record first";
    server.post_json("/v1/records", &stating("LFG-01", 35, 60.0, 7e-4)).await.created();
    holds(&page(&server, "/gyros/LFG-01", &[]).await, &["is it in pulse/(min g0)?", CHECK]);
    // The next one is good, and what was odd before is still told of.
    server.post_json("/v1/records", &stating("LFG-01", 42, 1.0, 7e-4)).await.created();
    for path in ["/gyros/LFG-01", "/gyros/LFG-01/report"] {
        let shown = page(&server, path, &[]).await;
        holds(
            &shown,
            &["The record of 2026-02-08 was out of tolerance and the newest is not", "is it in pulse/(min g0)?"],
        );
        assert!(!shown.contains(CHECK), "{shown}");
    }
    server.post_json("/v1/records", &stating("LFG-01", 49, 1.0, 0.7)).await.created();
    holds(
        &page(&server, "/gyros/LFG-01", &[]).await,
        &["are e_sd or g_sd in another unit?", CHECK, "The record of 2026-02-08 was out of tolerance and the newest"],
    );
    // The few records of a misspelt name name the known one; its own doubt nothing.
    for day in [56, 63] {
        server.post_json("/v1/records", &stating("lfg01", day, 1.0, 7e-4)).await.created();
        holds(&page(&server, "/gyros/lfg01", &[]).await, &["looks like the known serial LFG-01", CHECK]);
    }
    assert!(!page(&server, "/gyros/LFG-01", &[]).await.contains("looks like the known"));
    // Today tells that it is counted, until it has records of its own.
    const COUNTED: &str = "serial lfg01 looks like the known serial LFG-01. It is counted as another gyro";
    holds(&page(&server, "/", &[]).await, &[COUNTED]);
    for day in [70, 77] {
        server.post_json("/v1/records", &stating("lfg01", day, 1.0, 7e-4)).await.created();
    }
    assert!(!page(&server, "/", &[]).await.contains("looks like the known"));
}

#[tokio::test]
async fn a_decision_is_recorded_with_name_and_reason_and_stands_in_plot_report_and_audit() {
    let server = a_small_fleet().await;
    let path = "/gyros/JUMP%2F1/events/new";
    let asked = page(&server, &format!("{path}?event=decision_remove"), &[]).await;
    assert!(
        asked.contains("value=\"decision_remove\" selected") && asked.contains("value=\"decision_release\""),
        "{asked}"
    );
    assert!(!asked.contains("value=\"repair\""), "{asked}");
    // What it is decided by stands above it, after a fault as well; nothing is decided by other events.
    let amiss = sends_form(&server, path, &[("event", "decision_release"), ("by", "Li Wei")]).await;
    assert_eq!(amiss.status, 422);
    for text in [&asked, &amiss.text()] {
        holds(part(text, "<h1>", "<form class=\"deed\""), &["badge confirmed", "Take it out. If it has stepped once"]);
    }
    assert!(!page(&server, &format!("{path}?event=baseline"), &[]).await.contains("class=\"suggestion\""));
    assert!(!page(&server, path, &[]).await.contains("decision_release"), "a decision has a form of its own");
    let fields = [("event", "decision_remove"), ("by", "Li Wei"), ("reason", "D_I ages")];
    assert_eq!(goes_on_at(&sends_form(&server, path, &fields).await), "/gyros/JUMP%2F1#happenings");
    let event = &server.get("/v1/gyros/JUMP%2F1/events").await.json()["events"][0];
    assert_eq!((&event["event"], &event["resets"]), (&json!("decision_remove"), &json!([])));
    for path in ["/gyros/JUMP%2F1", "/gyros/JUMP%2F1/report"] {
        let shown = page(&server, path, &[]).await;
        let decided = part(&shown, "<p class=\"decided\"", "</p>");
        assert!(decided.contains("decision: take out") && decided.contains("Li Wei: D_I ages"), "{decided}");
    }
    // A later record does not undo it, but it is said.
    let later = record("IMU-B", "ST-2", "JUMP/1", 7 * 8, [3.05, 4.0]);
    assert_eq!(server.post_json("/v1/records", &later).await.status, 201);
    let at = json!({"event": "decision_retest", "reason": "see", "at": "2026-01-20T08:00:00Z"});
    assert_eq!(server.post_json("/v1/gyros/STEADY/events", &at).await.status, 201);
    let steady = page(&server, "/gyros/STEADY", &[]).await;
    assert!(part(&steady, "<p class=\"decided\"", "</p>").contains("records since: 5"), "{steady}");
    assert!(steady.contains("2026-01-20 decision: re-test</title>"), "a flag in the pictures");
    // In error: it is withdrawn, and stands in the history alone.
    assert!(page(&server, "/gyros/JUMP%2F1", &[]).await.contains("events/new?event=decision_withdrawn"));
    let form = page(&server, &format!("{path}?event=decision_withdrawn"), &[]).await;
    holds(&form, &["value=\"decision_withdrawn\" selected", "By its verdicts this gyro is out of tolerance"]);
    let fields = [("event", "decision_withdrawn"), ("by", "Li Wei"), ("reason", "wrong gyro")];
    goes_on_at(&sends_form(&server, path, &fields).await);
    for path in ["/gyros/JUMP%2F1", "/gyros/JUMP%2F1/report"] {
        let shown = page(&server, path, &[]).await;
        assert!(!shown.contains("<p class=\"decided\"") && shown.contains("wrong gyro"), "{shown}");
        assert!(!shown.contains("events/new?event=decision_withdrawn"), "nothing is left to be withdrawn");
    }
    let today = page(&server, "/", &[]).await;
    assert!(!today.contains("decision: take out"), "{today}");
}

#[tokio::test]
async fn gyros_and_campaigns_are_compared_from_the_page_of_their_imu() {
    let server = Server::start().await;
    for month in [3, 4] {
        let body = campaign_with("/measured_at", json!(format!("2026-0{month}-01T08:00:00Z")));
        server.post("/v1/campaigns", "application/json", body).await.has(201);
    }
    let campaign = document("practice/campaign-00.json");
    let imu = page(&server, &format!("/imus/{}", campaign["imu"].as_str().unwrap()), &[]).await;
    let ticked: Vec<&str> =
        imu.split("name=\"campaign\" value=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert_eq!(ticked.len(), 2, "{imu}");
    let two = format!("/compare?campaign={}&campaign={}", ticked[1], ticked[0]);
    let shown = page(&server, &two, &[]).await;
    // The same dwells twice: every difference is nothing.
    let there = [
        "No parameter differs by",
        "(B - A)/σ",
        ">0.0</span>",
        "Effects found",
        "2026-03-01 08:00 UTC",
        "2026-04-01 08:00 UTC",
    ];
    holds(&shown, &there);
    assert_eq!(shown.matches("<figure class=\"chart\"").count(), 6, "residuals of three gyros in two campaigns");
    assert!(!shown.contains("beyond2") && !shown.contains("beyond3"), "{shown}");
    let gyros = link(&imu, "/compare?gyro=", "/compare");
    let shown = page(&server, &gyros, &[]).await;
    assert_eq!(shown.matches("<figure class=\"chart\"").count(), 3);
    holds(&shown, &["<g class=\"k0\"", "<g class=\"k2\"", "align=baseline", "+100 %", "Δ|E|, ppm"]);
    let serial = campaign["gyros"][0]["serial"].as_str().unwrap();
    // The same dwells twice: |E| has not moved. What happened to one of them is marked in every picture.
    let moved = shown.split("data-label=\"Δ|E|, ppm, since the baseline began\">").nth(1).unwrap();
    assert!(moved.starts_with("0") && !shown.contains("class=\"flag\""), "{shown}");
    let repair = json!({"event": "repair", "at": "2026-03-20T00:00:00Z", "reason": "bearing", "author": "Zhao Min"});
    assert_eq!(server.post_json(&format!("/v1/gyros/{serial}/events"), &repair).await.status, 201);
    let marked = page(&server, &gyros, &[]).await;
    assert_eq!(marked.matches("class=\"flag\"").count(), 3, "{marked}");
    assert!(marked.contains(&format!("2026-03-20 {serial} · repair")), "{marked}");
    for (query, status) in [
        (format!("gyro={serial}"), 400),
        (format!("gyro={serial}&gyro=NOBODY"), 404),
        (String::new(), 400),
        ("campaign=x&campaign=y".into(), 404),
    ] {
        assert_eq!(server.get(&format!("/compare?{query}")).await.status, status, "{query}");
    }
}

#[tokio::test]
async fn a_stretch_of_a_history_is_shown_by_its_address_without_a_script() {
    let server = a_small_fleet().await;
    let points = |page: &str| page.matches("<a class=\"point\"").count();
    let whole = page(&server, "/gyros/STEADY", &[]).await;
    assert_eq!(points(&whole), 3 * 8);
    let some = page(&server, "/gyros/STEADY?from=2026-01-08&to=2026-01-22", &[]).await;
    assert_eq!(points(&some), 3 * 3, "{some}");
    let absolute = page(&server, "/gyros/STEADY?axis=absolute&from=2026-01-08", &[]).await;
    assert!(absolute.contains("D_I 1.500000 deg/(h g0)") && !absolute.contains(">+100 %</text>"), "{absolute}");
    assert!(absolute.contains("href=\"?from=2026-01-08#history\""), "the way back to deviations keeps the stretch");
    assert!(whole.contains(">+100 %</text>") && whole.contains(">-0.010</text>"), "{whole}");
    // What cannot be read is left out.
    assert_eq!(points(&page(&server, "/gyros/STEADY?from=soon&to=later", &[]).await), 3 * 8);
}

#[tokio::test]
async fn a_page_with_all_that_it_loads_is_light() {
    let server = Server::start().await;
    let lines: Vec<String> = (0..1200_u32)
        .map(|k| {
            let mut body = record("IMU-A", "ST-1", "OFTEN", 0, [1.5 + 1e-3 * f64::from(k % 7), -2.25]);
            body["calibrated_at"] =
                format!("20{:02}-{:02}-{:02}T08:00:00Z", 10 + k / 120, 1 + k / 10 % 12, 1 + k % 10).into();
            body.to_string()
        })
        .collect();
    server.post("/v1/import", "application/x-ndjson", lines.join("\n")).await.has(200);
    let gzip = [("accept-encoding", "gzip")];
    let mut weight = 0;
    let shown = page(&server, "/gyros/OFTEN", &[]).await;
    let assets = shown.split('"').filter(|part| part.starts_with("/assets/"));
    for path in assets.chain(["/gyros/OFTEN"]) {
        weight += server.call("GET", path, &gzip, "").await.body.len();
    }
    assert!(weight < 60_000, "{weight} bytes");
    assert!(shown.contains("class=\"envelope\"") && shown.contains("class=\"median\""), "{shown}");
    // Zoomed in, every record is there again.
    let year = page(&server, "/gyros/OFTEN?from=2019-01-01", &[]).await;
    assert_eq!(year.matches("<circle class=\"in_tolerance\" cx=").count(), 3 * 120, "one each");
}

#[tokio::test]
async fn a_gyro_out_of_use_is_not_overdue_and_says_so() {
    let server = Server::start_with(&[("GYROWATCH_JUDGING__INTERVAL_DAYS", "60")]).await;
    for (serial, imu) in [("RETIRED", "IMU-A"), ("STORED", "IMU-B"), ("LATE", "IMU-C")] {
        for day in 0..4 {
            server.post_json("/v1/records", &record(imu, "ST-1", serial, day * 7, [1.0, 2.0])).await.created();
        }
    }
    for (serial, event) in [("RETIRED", "retired"), ("STORED", "in_storage")] {
        let ended = json!({"event": event, "reason": "spare", "at": "2026-02-20T00:00:00Z"});
        assert_eq!(server.post_json(&format!("/v1/gyros/{serial}/events"), &ended).await.status, 201);
    }
    let fleet = page(&server, "/fleet", &[]).await;
    let table = &fleet[place(&fleet, "<tbody>")..];
    let [late, retired, stored] = ["/gyros/LATE", "/gyros/RETIRED", "/gyros/STORED"].map(|link| place(table, link));
    assert!(late < retired && late < stored, "what is in use comes first: {table}");
    assert!(table.contains(">retired<") && table.contains(">in storage<"), "{table}");
    assert_eq!(table.matches("badge overdue").count(), 1, "{table}");
    let overdue = page(&server, "/fleet?status=overdue", &[]).await;
    let overdue = &overdue[place(&overdue, "<tbody>")..];
    assert!(overdue.contains("LATE") && !overdue.contains("RETIRED") && !overdue.contains("STORED"), "{overdue}");
    let listed = server.get("/v1/gyros?status=overdue").await.json();
    assert_eq!((listed["gyros"].as_array().unwrap().len(), &listed["gyros"][0]["serial"]), (1, &json!("LATE")));
    let listed = server.get("/v1/gyros").await.json();
    let of = |serial: &str| listed["gyros"].as_array().unwrap().iter().find(|gyro| gyro["serial"] == serial).unwrap();
    assert_eq!((&of("LATE")["status"], &of("LATE")["state"]), (&json!("overdue"), &json!("within")));
    assert_eq!((&of("STORED")["status"], &of("STORED")["out_of_use"]), (&json!("in_tolerance"), &json!("in_storage")));
    // The next record brings it back.
    server.post_json("/v1/records", &record("IMU-B", "ST-1", "STORED", 60, [1.0, 2.0])).await.created();
    assert_eq!(server.get("/v1/gyros/STORED").await.json()["out_of_use"], Value::Null);
}

/// A campaign with one member replaced, or added.
fn campaign_with(pointer: &str, value: Value) -> String {
    support::with_member(document("practice/campaign-00.json"), pointer, value).to_string()
}

#[tokio::test]
async fn what_is_wrong_with_a_campaign_is_said_in_the_viewers_language() {
    let server = Server::start().await;
    let members = [
        ("/dwells/1/start_s", json!(100.0)),
        ("/dwells/5/start_s", json!(240.0)),
        ("/dwells/1/start_s", json!(-1.0)),
        ("/dwells/1/duration_s", json!(0.0)),
        ("/dwells/1/attitude", json!([-0.5, 0.5, 0.5, 0.6])),
        ("/dwells/1/attitude", json!([1.0, 0.0, 0.0, 0.0])),
        ("/dwells/1/specific_force_g0", json!([0.0, 0.9, 0.0])),
        ("/dwells/1/rate_arcsec_s", json!([0.0, 3600.0, 0.0])),
        ("/dwells/1/rate_arcsec_s", json!([0.0, 1.0])),
        ("/dwells/1/output_sem_pulse_s/2", json!(0.0)),
        ("/dwells/1/output_pulse_s", json!([1.0, 2.0, 3.0, 4.0])),
        ("/dwells/1/output_pulse_s", json!("1, 2, 3")),
        ("/dwells/1/temperature_c", json!(5000.0)),
        ("/dwells/1/phase", json!("still")),
        ("/dwells/1/colour", json!("red")),
        ("/dwells", json!([])),
        ("/dwells", json!(7)),
        ("/dwells/1", json!(true)),
        ("/model", json!(["bias", "jerk"])),
        ("/model", json!([])),
        ("/model", json!(["bias", "bias"])),
        ("/test", json!("spin")),
        ("/test", json!("torque_feedback")),
        ("/geometry", json!("cubic")),
        ("/geometry", json!({"G1": {"input": [0, 0, 0], "spin": [0, 1, 0]}})),
        ("/gyros", json!([])),
        ("/gyros/1/serial", json!("LFG-9000-1")),
        ("/gyros/1/slot", json!("G1")),
        ("/gyros/1/known_e_pulse_per_arcsec", json!([0.0, 0.0, 1e9])),
        ("/measured_at", json!("2026-03-01T08:00:00")),
        ("/site", json!({"latitude_deg": 91.0, "gravity_g0": 9.8})),
        ("/site", json!({"latitude_deg": 34.25})),
        ("/station", json!("ST\u{200b}")),
        ("/note", json!("x".repeat(100_000))),
    ];
    let mut documents: Vec<String> =
        members.into_iter().map(|(pointer, value)| campaign_with(pointer, value)).collect();
    let table = "# imu: IMU-7\n# station: ST-1\n# measured_at: 2026-03-01T08:00:00Z\n# geometry: orthogonal\n\
        # gyros: G1 A\n# note: a, b\n\
        phase,start_s,duration_s,specific_force_g0_x,specific_force_g0_y,specific_force_g0_z,\
        rate_arcsec_s_x,rate_arcsec_s_y,rate_arcsec_s_z,temperature_c,output_pulse_s_1\n\
        static,0,180,1,0,0,0,0,15,45.1,1.5\nstatic,200,180,0,1,0,0,0,15,45.1,2.5\n";
    let cells = [
        ("temperature_c,", "Temperature,"),
        ("temperature_c,", "colour,"),
        ("rate_arcsec_s_y", "rate_arcsec_s_x"),
        ("static,200", "rest,200"),
        ("45.1,2.5", "45,1,2.5"),
        ("45.1,2.5", "\"45,1\",2.5"),
        ("45.1,2.5", "45.1,"),
        ("45.1,2.5", "warm,2.5"),
        ("45.1,2.5", "NaN,2.5"),
        ("static,200", "static,100"),
        ("static,200", "static,"),
        ("# imu: IMU-7\n", ""),
        ("# imu", "# imu: X\n# imu"),
        ("# imu", "# operater: x\n# imu"),
        ("G1 A", "G1 A, G1 B"),
        ("G1 A", "G7 A"),
        ("G1 A", "[{"),
        ("G1 A", "A"),
        ("2026-03-01T08:00:00Z", "1.3.2026"),
        ("# note: a, b", "# latitude_deg: 34,25"),
    ];
    documents.extend(cells.into_iter().map(|(from, to)| table.replacen(from, to, 1)));
    documents.extend(["# imu: X\n".to_owned(), "{".to_owned(), "phase,start_s\nstatic,0\n".to_owned()]);
    documents.extend(contrary_to_the_earth());
    let mut wrong = Vec::new();
    for document in &documents {
        wrong.extend(spoken::english_left(&server, document).await);
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// A campaign with what stations get wrong in what they command.
fn contrary_to_the_earth() -> Vec<String> {
    let campaign = document("practice/campaign-00.json");
    let each = |change: &dyn Fn(&mut Value)| {
        let mut campaign = campaign.clone();
        campaign["dwells"].as_array_mut().unwrap().iter_mut().for_each(change);
        campaign
    };
    let times = |dwell: &mut Value, field: &str, factors: [f64; 3]| {
        for (k, factor) in factors.into_iter().enumerate() {
            dwell[field][k] = (dwell[field][k].as_f64().unwrap() * factor).into();
        }
    };
    let bare = |dwell: &mut Value| {
        dwell.as_object_mut().unwrap().remove("attitude");
    };
    let (force, rate) = ("specific_force_g0", "rate_arcsec_s");
    let mut documents = vec![
        each(&|d| times(d, force, [-1.0; 3])),
        each(&|d| {
            bare(d);
            times(d, force, [-1.0; 3]);
        }),
        each(&|d| times(d, force, [9.80665; 3])),
        each(&|d| times(d, force, [1.002; 3])),
        each(&|d| times(d, force, [1.0, -1.0, 1.0])),
        each(&|d| times(d, rate, [1.0 / 3600.0; 3])),
        each(&|d| {
            if d["phase"] == "static" {
                times(d, rate, [0.0; 3]);
            }
        }),
        each(&|d| times(d, rate, [15.0 / 15.041; 3])),
        each(&|d| {
            bare(d);
            d[rate].as_array_mut().unwrap().swap(0, 1);
        }),
        each(&|d| {
            bare(d);
            if d["phase"] == "static" {
                times(d, rate, [1.1; 3]);
            }
        }),
        each(&|d| {
            if d["phase"] == "static" {
                d[force].as_array_mut().unwrap().swap(1, 2);
                times(d, rate, [0.7, 1.2, 0.9]);
            }
        }),
    ];
    for site in [json!({"latitude_deg": 31.0, "gravity_g0": 0.9989857550529864}), Value::Null] {
        let mut other = each(&bare);
        other["site"] = site;
        other["rates"] = if other["site"].is_null() { json!("table") } else { Value::Null };
        other.as_object_mut().unwrap().retain(|_, member| !member.is_null());
        documents.push(other);
    }
    let mut few = campaign.clone();
    times(&mut few["dwells"][4], force, [-1.0; 3]);
    bare(&mut few["dwells"][4]);
    documents.push(few);
    let mut unknown = campaign;
    unknown["rates"] = json!("both");
    documents.push(unknown);
    documents.iter().map(Value::to_string).collect()
}

#[tokio::test]
async fn notes_are_shown_before_and_after_storing_and_a_doubtful_time_is_confirmed_on_a_page() {
    let server = a_small_fleet().await;
    let mut early = record("IMU-A", "ST-1", "STEADY", 0, [1.5, -2.25]);
    early["calibrated_at"] = "2000-01-03T08:00:00Z".into();
    let sends = async |language: &str| {
        let headers = [("content-type", "text/plain"), ("accept-language", language)];
        let text = format!("text={early}\r\n");
        server.call("POST", "/import/preview", &headers, text).await.text()
    };
    let words = "clocks that were never set begin: set aside until the time is confirmed";
    assert!(sends("en").await.contains(words));
    let chinese = sends("zh").await;
    assert!(chinese.contains("暂不计入，待确认时间") && !chinese.contains(words), "{chinese}");
    let id = server.post_json("/v1/records", &early).await.json()["id"].as_str().unwrap().to_owned();
    let shown = page(&server, &format!("/records/{id}"), &[]).await;
    assert!(shown.contains(words) && shown.contains("Set aside: it does not count"), "{shown}");
    assert!(page(&server, "/gyros/STEADY", &[]).await.contains("<strong>set aside</strong>"));
    let ask = link(&shown, "/records/", "/confirm");
    let path = ask.split('?').next().unwrap();
    assert!(page(&server, &ask, &[]).await.contains(words));
    let fields = [("by", "Zhao Min"), ("reason", "the log book says so")];
    for wrong in [&fields[..1], &fields[1..]] {
        assert_eq!(sends_form(&server, path, wrong).await.status, 422, "{wrong:?}");
    }
    goes_on_at(&sends_form(&server, path, &fields).await);
    let confirmed = page(&server, &format!("/records/{id}"), &[]).await;
    assert!(confirmed.contains("the log book says so") && !confirmed.contains("Set aside:"), "{confirmed}");
    assert_eq!(sends_form(&server, path, &fields).await.status, 409, "there is nothing left to confirm");
    assert!(!page(&server, "/gyros/STEADY", &[]).await.contains("<strong>set aside</strong>"));
}

#[tokio::test]
async fn a_window_is_marked_as_suspect_and_trusted_and_a_gyro_gets_its_batch_on_pages() {
    let server = a_small_fleet().await;
    let records = async || -> Vec<Value> {
        let station = "ST-1";
        let listed = server.get(&format!("/v1/records?station={station}&limit=1000")).await.json();
        listed["records"].as_array().unwrap().iter().filter(|record| record["valid"] == true).cloned().collect()
    };
    let before = records().await;
    let at = before[0]["calibrated_at"].as_str().unwrap().to_owned();
    let said = [("by", "Li Wei"), ("reason", "loose fixture"), ("from", &at), ("to", &at)];
    assert!(page(&server, "/stations/ST-1", &[]).await.contains("href=\"/stations/ST-1/suspect\""));
    assert!(page(&server, "/stations/ST-1/suspect", &[]).await.contains("Mark a window as suspect"));
    let wrong = sends_form(&server, "/stations/ST-1/suspect", &said[..3]).await;
    assert!(wrong.status == 422 && wrong.text().contains("<li>To: "), "{}", wrong.text());
    assert_eq!(goes_on_at(&sends_form(&server, "/stations/ST-1/suspect", &said).await), "/stations/ST-1");
    let of_instant = before.iter().filter(|record| record["calibrated_at"] == *at).count();
    assert_eq!(records().await.len(), before.len() - of_instant);
    let shown = page(&server, &format!("/records/{}", before[0]["id"].as_str().unwrap()), &[]).await;
    assert!(shown.contains("what ST-1 measured at that time is suspect (Li Wei: loose fixture)"), "{shown}");
    let station = page(&server, "/stations/ST-1", &[]).await;
    let link = format!("href=\"/stations/ST-1/trust?from={at}&amp;to={at}\"");
    assert!(station.contains("Suspect windows") && station.contains(&link), "{station}");
    let ever = [said[0], said[1], ("from", "2000-01-01 00:00"), ("to", "2100-01-01 00:00")];
    goes_on_at(&sends_form(&server, "/stations/ST-1/suspect", &ever).await);
    let station = page(&server, "/stations/ST-1", &[]).await;
    assert!(
        station.contains("No calibration of this station counts.") && station.contains("/trust?from="),
        "{station}"
    );
    goes_on_at(&sends_form(&server, "/stations/ST-1/trust", &ever).await);
    assert!(!page(&server, "/stations/ST-1", &[]).await.contains("Suspect windows"));
    assert_eq!(records().await.len(), before.len());
    assert_eq!(server.get("/stations/NOWHERE/suspect").await.status, 404);

    let fields = [("batch", "2024-B"), ("type", ""), ("unit", "vehicle 3")];
    assert_eq!(goes_on_at(&sends_form(&server, "/gyros/JUMP%2F1/attributes", &fields).await), "/gyros/JUMP%2F1");
    let gyro = page(&server, "/gyros/JUMP%2F1", &[]).await;
    assert!(gyro.contains("href=\"/fleet?batch=2024-B\"") && gyro.contains("vehicle 3"), "{gyro}");
    assert!(page(&server, "/gyros/JUMP%2F1/attributes", &[]).await.contains("value=\"2024-B\""));
    assert!(page(&server, "/fleet?batch=2024-B", &[]).await.contains("/gyros/JUMP%2F1\""));
}

#[tokio::test]
async fn every_route_of_the_description_stands_on_a_page_with_what_it_takes_and_answers() {
    let server = Server::start().await;
    let document = server.get("/openapi.json").await.json();
    let gzip = [("accept-encoding", "gzip")];
    let all = page(&server, "/docs", &[]).await;
    let assets = all.split('"').filter(|part| part.starts_with("/assets/"));
    let mut of_assets = 0;
    for path in assets {
        of_assets += server.call("GET", path, &gzip, "").await.body.len();
    }
    let mut seen = BTreeMap::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            let (group, id) = (operation["tags"][0].as_str().unwrap(), operation["operationId"].as_str().unwrap());
            let address = format!("/docs/{}", group.replace(' ', "%20"));
            assert!(all.contains(&format!("href=\"{address}#{id}\"><code>{path}</code>")), "{method} {path}");
            if !seen.contains_key(&address) {
                seen.insert(address.clone(), page(&server, &address, &[]).await);
            }
            let own = seen[&address].split(&format!("<section id=\"{id}\">")).nth(1);
            let own = own.unwrap_or_else(|| panic!("{method} {path} is not on {address}"));
            let own = own.split("</section>").next().unwrap();
            place(own, &format!("<code>{} {path}</code>", method.to_uppercase()));
            for parameter in operation["parameters"].as_array().into_iter().flatten() {
                place(own, &format!("<code>{}</code>", parameter["name"].as_str().unwrap()));
            }
            for (status, answer) in operation["responses"].as_object().unwrap() {
                place(own, &format!("<th scope=\"row\">{status}</th>"));
                assert!(answer["content"].is_null() || !status.starts_with('2') || own.contains("<details>"), "{path}");
            }
            assert_eq!(own.contains("Bearer $TOKEN"), operation["security"].is_array(), "{method} {path}");
            let body = &operation["requestBody"]["content"];
            assert_eq!(own.contains("--data-binary @FILE"), body.is_object(), "{method} {path}");
            // What has to be sent is a table beside it.
            if let Some(name) = body["application/json"]["schema"]["$ref"].as_str() {
                let schema = &document.pointer(name.trim_start_matches('#')).unwrap();
                for required in schema["required"].as_array().into_iter().flatten() {
                    place(own, &format!("<code>{}</code></th>", required.as_str().unwrap()));
                }
            }
        }
    }
    assert!(seen.len() > 8, "{:?}", seen.keys());
    for (address, shown) in &seen {
        let weight = of_assets + server.call("GET", address, &gzip, "").await.body.len();
        assert!(weight < 60_000, "{address}: {weight} bytes");
        for anchor in shown.split("href=\"#").skip(1).map(|rest| rest.split('"').next().unwrap()) {
            assert!(shown.contains(&format!(" id=\"{anchor}\"")), "{address}: #{anchor} leads nowhere");
        }
        for part in [" style=", "<style", "<script>"] {
            assert!(!shown.contains(part), "{address}: {part}");
        }
    }
    assert!(page(&server, "/book/api", &[]).await.contains("href=\"/docs\""), "it is found from the book");
    assert_eq!(server.get("/docs/nothing").await.status, 404);
}
