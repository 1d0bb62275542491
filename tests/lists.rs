//! Lists of what is stored: every item once, whatever the page size, narrowed down by IMU, station, kind and time.

use rstest::rstest;

use crate::prelude::*;

/// All pages of a list, as the `Link` header leads on.
async fn pages(server: &Server, path: &str, member: &str) -> Vec<Value> {
    let (mut next, mut all) = (Some(path.to_owned()), Vec::new());
    while let Some(path) = next {
        let answer = server.get(&path).await;
        assert_eq!(answer.status, 200, "{path}: {}", answer.text());
        let body = answer.json();
        all.extend(body[member].as_array().unwrap().clone());
        next =
            answer.headers.get("link").map(|link| link.to_str().unwrap().split(['<', '>']).nth(1).unwrap().to_owned());
        assert_eq!(next.is_some(), body["next"].is_string(), "{path}");
    }
    all
}

fn ids(items: &[Value]) -> Vec<String> {
    items.iter().map(|item| item["id"].as_str().unwrap().to_owned()).collect()
}

async fn filled() -> (Server, Vec<String>) {
    let server = Server::start().await;
    let mut stored = Vec::new();
    for number in 0..12 {
        let record = paper_record(number % 3, number).to_string();
        let answer = server.post("/v1/records", "application/json", record).await.created();
        stored.push(answer["id"].as_str().unwrap().to_owned());
    }
    let campaign = server.post("/v1/campaigns", "application/json", data("practice/campaign-00.json")).await;
    stored.push(campaign.json()["id"].as_str().unwrap().to_owned());
    stored.reverse();
    (server, stored)
}

#[rstest]
#[case(1)]
#[case(5)]
#[case(1000)]
#[tokio::test]
async fn every_record_is_listed_once_the_last_to_arrive_first(#[case] limit: usize) {
    let (server, stored) = filled().await;
    let listed = pages(&server, &format!("/v1/records?limit={limit}"), "records").await;
    assert_eq!(ids(&listed), stored);
    let campaigns = pages(&server, &format!("/v1/campaigns?limit={limit}"), "campaigns").await;
    assert_eq!(ids(&campaigns), stored[..1]);
    assert_eq!(campaigns[0]["kind"], "campaign");
}

#[tokio::test]
async fn a_list_is_narrowed_down_by_imu_station_and_time() {
    let (server, stored) = filled().await;
    let all = pages(&server, "/v1/records", "records").await;
    for imu in all.iter().map(|item| item["imu"].as_str().unwrap()).collect::<BTreeSet<_>>() {
        let of_imu = pages(&server, &format!("/v1/records?imu={imu}&limit=2"), "records").await;
        let expected: Vec<Value> = all.iter().filter(|item| item["imu"] == imu).cloned().collect();
        assert_eq!(of_imu, expected, "{imu}");
    }
    let record = &all[4];
    let (at, station) = (record["calibrated_at"].as_str().unwrap(), record["station"].as_str().unwrap());
    let then = pages(&server, &format!("/v1/records?from={at}&to={at}&station={station}"), "records").await;
    assert_eq!(then, std::slice::from_ref(record));
    let day = &at[..10];
    let of_day = pages(&server, &format!("/v1/records?from={day}&to={day}"), "records").await;
    let on_it = |item: &&Value| item["calibrated_at"].as_str().unwrap().starts_with(day);
    assert_eq!(of_day, all.iter().filter(on_it).cloned().collect::<Vec<_>>());
    assert!(!of_day.is_empty() && at[10..] != *"T00:00:00Z", "{at}");
    for none in ["imu=nowhere", "station=nowhere", "to=1999-01-01T00:00:00Z"] {
        assert!(pages(&server, &format!("/v1/records?{none}"), "records").await.is_empty(), "{none}");
    }
    let order = json!({ "author": "Weber", "reason": "wrong unit" });
    let id = record["id"].as_str().unwrap();
    assert_eq!(server.post_json(&format!("/v1/records/{id}/void"), &order).await.status, 200);
    let again = pages(&server, &format!("/v1/records?imu={}", record["imu"].as_str().unwrap()), "records").await;
    let valid: Vec<bool> = again.iter().map(|item| item["valid"].as_bool().unwrap()).collect();
    assert_eq!(valid.iter().filter(|valid| !**valid).count(), 1, "{valid:?}");
    assert_eq!(stored.len(), all.len());
}

#[tokio::test]
async fn imus_are_listed_with_the_gyros_in_them() {
    let (server, _) = filled().await;
    let imus = pages(&server, "/v1/imus?limit=2", "imus").await;
    let names: Vec<&str> = imus.iter().map(|imu| imu["imu"].as_str().unwrap()).collect();
    assert!(names.is_sorted() && names.len() == 4, "{names:?}");
    for imu in &imus {
        let detail = server.get(&format!("/v1/imus/{}", imu["imu"].as_str().unwrap())).await.json();
        let serials: Vec<&Value> = detail["gyros"].as_array().unwrap().iter().map(|gyro| &gyro["serial"]).collect();
        assert_eq!(imu["gyros"].as_array().unwrap().iter().collect::<Vec<_>>(), serials);
        assert_eq!(detail["status"], imu["status"]);
        assert_eq!(serials.len(), 3);
    }
    assert_eq!(server.get("/v1/imus/nowhere").await.status, 404);
    for bad in [
        "/v1/imus?cursor=x",
        "/v1/records?limit=0",
        "/v1/records?from=x",
        "/v1/records?to=2026-02-30",
        "/v1/campaigns?kind=record",
    ] {
        assert_eq!(server.get(bad).await.status, 400, "{bad}");
    }
}

#[tokio::test]
async fn a_cursor_leads_on_in_its_own_list_and_order_only() {
    let (server, _) = filled().await;
    let serial = server.get("/v1/gyros").await.json()["gyros"][0]["serial"].as_str().unwrap().to_owned();
    let lists = [
        "/v1/records?",
        "/v1/campaigns?",
        "/v1/imus?",
        "/v1/gyros?",
        "/v1/gyros?sort=load&",
        "/v1/gyros?sort=age&",
        "/v1/gyros?sort=eta&",
        &format!("/v1/gyros/{serial}/trend?"),
        &format!("/v1/gyros/{serial}/trend?every=day&"),
        &format!("/v1/gyros/{serial}/trend?every=month&"),
    ];
    for list in lists {
        let first = server.get(&format!("{list}limit=1")).await.json();
        let Some(next) = first["next"].as_str() else { continue };
        for other in lists {
            let answer = server.get(&format!("{other}cursor={next}")).await;
            let code = answer.json()["code"].clone();
            let wanted = if list == other { Value::Null } else { "cursor_of_other_list".into() };
            assert_eq!(code, wanted, "a cursor of {list} in {other}");
        }
    }
    let by_serial = server.get("/v1/gyros?limit=1").await.json()["next"].as_str().unwrap().to_owned();
    assert_eq!(server.get(&format!("/v1/gyros?sort=serial&cursor={by_serial}")).await.status, 200);
}

#[tokio::test]
async fn gyros_are_found_by_their_batch_and_what_is_said_of_them_is_audited() {
    let (server, _) = filled().await;
    let all = pages(&server, "/v1/gyros", "gyros").await;
    let serials: Vec<String> = all.iter().map(|gyro| gyro["serial"].as_str().unwrap().to_owned()).collect();
    assert_eq!(all[0]["attributes"], json!({"batch": null, "type": null, "unit": null}));
    let patch = async |serial: &str, body: Value| {
        let path = format!("/v1/gyros/{serial}");
        server.call("PATCH", &path, &[("content-type", "application/json")], body.to_string()).await
    };
    for serial in &serials[..2] {
        let changed = patch(serial, json!({"batch": "2024-B", "type": "LFG-4"})).await.has(200).json();
        assert_eq!(changed["attributes"], json!({"batch": "2024-B", "type": "LFG-4", "unit": null}));
    }
    let of_batch = pages(&server, "/v1/gyros?batch=2024-B&limit=1", "gyros").await;
    assert_eq!(of_batch.iter().map(|gyro| gyro["serial"].clone()).collect::<Vec<_>>(), serials[..2]);
    let shown = server.get("/fleet?batch=2024-B").await.text();
    assert!(serials.iter().enumerate().all(|(k, serial)| shown.contains(&format!("/gyros/{serial}\"")) == (k < 2)));

    // What is left out stays, null takes away.
    let changed = patch(&serials[0], json!({"batch": null})).await.json();
    assert_eq!(changed["attributes"], json!({"batch": null, "type": "LFG-4", "unit": null}));
    assert_eq!(pages(&server, "/v1/gyros?batch=2024-B", "gyros").await.len(), 1);
    let audit = server.get("/v1/audit?limit=100").await.json();
    let lines: Vec<&Value> =
        audit["lines"].as_array().unwrap().iter().filter(|line| line["action"] == "set attributes").collect();
    assert_eq!(
        (lines.len(), &lines[0]["before"]["batch"], &lines[0]["after"]["batch"]),
        (3, &json!("2024-B"), &Value::Null)
    );
    // The same again changes nothing, and is no line.
    assert_eq!(patch(&serials[0], json!({"batch": null})).await.status, 200);
    assert_eq!(
        server.get("/v1/audit?limit=100").await.json()["lines"].as_array().unwrap().len(),
        audit["lines"].as_array().unwrap().len()
    );

    for (body, status, pointer) in [
        (json!({"batch": "x".repeat(65)}), 422, "/batch"),
        (json!({"batsch": "x"}), 422, "/batsch"),
        (json!({"type": 4}), 422, "/type"),
    ] {
        let refused = patch(&serials[0], body).await;
        assert_eq!(
            (refused.status, &refused.json()["errors"][0]["pointer"]),
            (status, &json!(pointer)),
            "{}",
            refused.text()
        );
    }
    assert_eq!(patch("NOBODY", json!({"batch": "x"})).await.status, 404);
}

#[tokio::test]
async fn a_table_says_the_batches_of_many_gyros_all_of_it_or_nothing() {
    let server = Server::start().await;
    assert_eq!(server.post("/v1/records", "application/json", data("paper.json")).await.status, 201);
    let send = |text: &str| {
        let (server, text) = (&server, text.to_owned());
        async move { server.call("PATCH", "/v1/gyros", &[("content-type", "text/csv")], text).await }
    };
    let changed = send("serial;batch;unit\nLFG-0101;2024-B;\nLFG-0102;2024-B;Kestrel\n").await;
    assert_eq!(changed.status, 200, "{}", changed.text());
    assert_eq!(changed.json(), json!({"changed": ["LFG-0101", "LFG-0102"], "unchanged": 0}));
    let again = send("serial,batch\nLFG-0101,2024-B\nLFG-0103,2025-A\n").await.json();
    assert_eq!(again, json!({"changed": ["LFG-0103"], "unchanged": 1}));
    let kept = server.get("/v1/gyros/LFG-0102").await.json();
    assert_eq!(kept["attributes"], json!({"batch": "2024-B", "type": null, "unit": "Kestrel"}));
    let refused = send("serial,batch\nLFG-0101,2030-Z\nNOBODY,2030-Z\n").await;
    assert_eq!(refused.status, 422);
    assert!(refused.text().contains("line 3") && refused.text().contains("NOBODY"), "{}", refused.text());
    for (text, expected) in [
        (
            "serial,batch\nLFG-0101,2030-Z\nLFG-0101,2031-Z\n",
            "line 3, column 1 (serial): LFG-0101 is in line 2 already",
        ),
        ("serial,batch\nLFG-0101,2030-Z,Kestrel\n", "line 2, column 3: 3 cells under 2 columns"),
        ("serial,batch\nLFG-0101,\"2030-Z\nLFG-0102,2030-Z\n", "line 2, column 2: a quotation mark opens here"),
    ] {
        let refused = send(text).await;
        assert!(refused.status == 422 && refused.text().contains(expected), "{expected}: {}", refused.text());
    }
    let cut = b"serial,batch\nLFG-0101,20\xff\n".to_vec();
    let refused = server.call("PATCH", "/v1/gyros", &[("content-type", "text/csv")], cut).await;
    assert!(refused.text().contains("line 2, column 2: not UTF-8 text"), "{}", refused.text());
    assert_eq!(server.get("/v1/gyros/LFG-0101").await.json()["attributes"]["batch"], "2024-B");
    let audit = server.get("/v1/audit").await.json();
    let lines = audit["lines"].as_array().unwrap().iter().filter(|line| line["action"] == "set attributes");
    assert_eq!(lines.count(), 3, "{audit}");
}

#[tokio::test]
async fn what_an_operation_does_not_take_is_refused_and_not_ignored() {
    let server = Server::start().await;
    let description = server.get("/openapi.json").await.json();
    let (mut refused_parameters, mut refused_keys) = (0, 0);
    for (path, item) in description["paths"].as_object().unwrap().iter().filter(|(path, _)| path.starts_with("/v1/")) {
        let at = path.replace(['{', '}'], "");
        for (method, operation) in item.as_object().unwrap().iter().filter(|(_, one)| one["responses"].is_object()) {
            let (method, named) = (method.to_uppercase(), operation["parameters"].to_string());
            let answer = server.call(&method, &format!("{at}?page=2"), &[], "").await;
            let code = answer.json()["code"].as_str().unwrap_or_default().to_owned();
            if code == "first_token_needed" {
                continue;
            }
            let takes_some = named.contains("\"in\":\"query\"");
            let wanted = if takes_some { "unknown_parameter" } else { "no_parameters" };
            assert_eq!((answer.status, &*code), (400, wanted), "{method} {path}");
            refused_parameters += 1;
            let takes_key = named.contains("Idempotency-Key");
            let answer = server.call(&method, &at, &[("idempotency-key", "k-1")], "").await;
            let is_refused = answer.text().contains("idempotency_key_not_taken");
            assert_eq!(is_refused, method == "POST" && !takes_key, "{method} {path}: {}", answer.text());
            refused_keys += usize::from(is_refused);
        }
    }
    assert!(refused_parameters > 40 && refused_keys > 10, "{refused_parameters} {refused_keys}");
}
