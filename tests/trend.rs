//! What an engineer sees of one gyro over the years.

use crate::lab::{self, Answer, assert_close, bench, verdict};
use crate::prelude::*;
use reqwest::Method;

fn states(points: &[Value]) -> Vec<&str> {
    points.iter().map(|point| point["state"].as_str().unwrap()).collect()
}

fn statuses(points: &[Value]) -> Vec<&str> {
    points.iter().map(|point| point["status"].as_str().unwrap()).collect()
}

#[tokio::test]
async fn a_trend_holds_every_point_with_where_it_comes_from() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.001)]).await;
    let trend = lab.get("/v1/gyros/A/trend?coefficient=D_I").await.ok();
    assert_eq!((&trend["serial"], &trend["coefficient"]), (&json!("A"), &json!("D_I")));
    assert_eq!((&trend["unit"], &trend["next"]), (&json!("deg/(h*g0)"), &Value::Null));
    let point = &trend["points"][1];
    assert_eq!(point["calibrated_at"], day(40));
    assert_close(&point["value"], 1.001, 1e-12);
    let expected = json!({"sd": null, "method": "rigid", "imu": "IMU-1", "slot": "G1", "station": "ST-1",
        "state": "within", "status": "in_tolerance"});
    for (member, value) in expected.as_object().unwrap() {
        assert_eq!(&point[member], value, "{member}");
    }
    let id = point["record"].as_str().unwrap();
    assert_eq!(lab.get(&format!("/v1/records/{id}")).await.ok()["record"]["calibrated_at"], day(40));
    assert_close(&lab.sees_trend("A", "coefficient=D_S").await[0]["value"], 2.0, 1e-12);
    assert_close(&lab.sees_trend("A", "coefficient=D_O").await[0]["value"], 0.0, 1e-12);
    let published = &lab.sees_trend("A", "method=published").await[0];
    assert_eq!(published["method"], "published");
}

#[tokio::test]
async fn a_step_is_flagged_with_its_size_and_reason() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.001), (80, 1.002)]).await;
    let answer = lab.posts(&record("IMU-1", &day(120), &[("G1", "A", 1.0142, 2.0)])).await;
    let step = verdict(&answer, "A", "D_I", "step");
    assert_eq!((&step["state"], &step["limit"]), (&json!("exceeded"), &json!(0.01)));
    // From 1.001, the median of the three before.
    assert_close(&step["value"], 0.0132, 1e-9);
    assert!(step["reason"].as_str().unwrap().starts_with("D_I is 0.0132 deg/(h g0) above"), "{step}");
    assert_eq!(verdict(&answer, "A", "D_S", "step")["state"], "within");
    assert_eq!(verdict(&answer, "A", "D_I", "baseline")["state"], "exceeded");
    // 30 days hold one record: the newest three, from 1.001 to 1.0142.
    assert_close(&verdict(&answer, "A", "D_I", "range")["value"], 0.0132, 1e-9);
    assert_eq!(states(&lab.sees_trend("A", "").await), ["indeterminate", "within", "within", "exceeded"]);
    let expected = ["not_enough_data", "in_tolerance", "in_tolerance", "unconfirmed"];
    assert_eq!(statuses(&lab.sees_trend("A", "").await), expected);
    let gyro = lab.get("/v1/gyros/A").await.ok();
    assert_eq!((&gyro["state"], &gyro["latest"]["states"]["D_S"]), (&json!("exceeded"), &json!("within")));
    assert_eq!((&gyro["status"], &gyro["latest"]["statuses"]["D_I"]), (&json!("unconfirmed"), &json!("unconfirmed")));
    assert_eq!(gyro["latest"]["statuses"]["D_S"], "in_tolerance");
    assert_eq!(verdict(&gyro, "A", "D_I", "step"), step);
    assert_eq!(gyro["calibrations"], 4);
}

#[tokio::test]
async fn a_record_that_arrives_late_takes_its_place_and_what_it_changes_is_judged_again() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.0), (80, 1.008), (160, 1.0155), (200, 1.0155)]).await;
    let before = lab.sees_trend("A", "").await;
    assert_eq!(states(&before)[3..], ["exceeded", "exceeded"]);
    let stepped = before[3]["record"].as_str().unwrap();
    let of_it = async |lab: &Lab| lab.get(&format!("/v1/records/{stepped}")).await.ok();
    assert_eq!(verdict(&of_it(&lab).await, "A", "D_I", "step")["state"], "exceeded");

    lab.posts(&record("IMU-1", &day(120), &[("G1", "A", 1.008, 2.0)])).await;
    let after = lab.sees_trend("A", "").await;
    assert_eq!(after[3]["calibrated_at"], day(120));
    assert_eq!(states(&after)[3], "within");
    let again = of_it(&lab).await;
    let step = verdict(&again, "A", "D_I", "step");
    assert_eq!(step["state"], "within", "the median of the three before is now 1.008");
    assert_close(&step["value"], 0.0075, 1e-9);
    assert_eq!(step["code"], "in_tolerance");
    assert_eq!(verdict(&again, "A", "D_I", "baseline")["state"], "exceeded", "that one has not changed");
}

#[tokio::test]
async fn a_late_record_within_the_baseline_moves_it_for_all() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.002), (80, 1.004), (120, 1.0105)]).await;
    assert_eq!(states(&lab.sees_trend("A", "").await)[3], "within");
    lab.posts(&record("IMU-1", &day(20), &[("G1", "A", 0.999, 2.0)])).await;
    let last = lab.sees_trend("A", "last=1").await;
    assert_eq!(states(&last), ["exceeded"], "the median of the first three is now 1.000, no more 1.002");
}

#[tokio::test]
async fn a_gyro_that_moves_keeps_its_history() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.001)]).await;
    lab.posts(&record("IMU-2", &day(80), &[("G3", "A", 1.002, 2.0), ("G1", "B", 7.0, 8.0)])).await;
    let points = lab.sees_trend("A", "").await;
    let seats: Vec<(&Value, &Value)> = points.iter().map(|p| (&p["imu"], &p["slot"])).collect();
    assert_eq!(
        seats,
        [(&json!("IMU-1"), &json!("G1")), (&json!("IMU-1"), &json!("G1")), (&json!("IMU-2"), &json!("G3"))]
    );
    assert_eq!(lab.sees_trend("B", "").await.len(), 1);
    let listed = lab.get("/v1/gyros").await.ok();
    let serials: Vec<&Value> = listed["gyros"].as_array().unwrap().iter().map(|gyro| &gyro["serial"]).collect();
    assert_eq!(serials, ["A", "B"]);
    assert_eq!(listed["gyros"][0]["latest"]["imu"], "IMU-2");
}

#[tokio::test]
async fn a_new_baseline_starts_the_comparison_anew() {
    let lab =
        Lab::holding(&[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.03), (160, 1.03), (200, 1.03), (240, 1.031)]).await;
    assert_eq!(states(&lab.sees_trend("A", "").await)[6], "exceeded");
    let mark = json!({"reason": "re-installed after repair", "at": day(100), "author": "Li"});
    let set = lab.post("/v1/gyros/A/baseline", &mark).await.created();
    assert_eq!((&set["serial"], &set["at"]), (&json!("A"), &json!(day(100))));
    // What happened is still a step and a range: a new baseline does not take that back.
    assert_eq!(states(&lab.sees_trend("A", "").await)[4..], ["exceeded", "within", "within"]);
    assert_eq!(lab.post("/v1/gyros/A/baseline", &mark).await.ok()["id"], set["id"]);
    let event = &lab.get("/v1/gyros/A").await.ok()["events"][0];
    assert_eq!((&event["event"], &event["author"]), (&json!("baseline"), &json!("Li")));
    let answer = lab.posts(&record("IMU-1", &day(280), &[("G1", "A", 1.03, 2.0)])).await;
    assert_eq!(verdict(&answer, "A", "D_I", "baseline")["state"], "within");

    lab.post("/v1/gyros/none/baseline", &mark).await.refused(404);
    assert_eq!(lab.post("/v1/gyros/A/baseline", &json!({"reason": " "})).await.refused(422), ["/reason"]);
    assert_eq!(lab.post("/v1/gyros/A/baseline", &json!({})).await.refused(422), ["/reason"]);
    let other = json!({"reason": "another", "at": day(100)});
    lab.post("/v1/gyros/A/baseline", &other).await.refused(409);
}

#[tokio::test]
async fn the_judged_method_and_the_budget_are_configuration() {
    let lab = Lab::with(|config| {
        config.judging.method = gyrowatch::config::JudgedMethod::Published;
        config.judging.budget = 0.5;
    })
    .await;
    let answer = lab.posts(&lab::tables_3_and_4()).await;
    assert_eq!(answer["separations"][0]["method"], "published");
    assert_close(&answer["separations"][0]["d_i"]["value"], 2.958219, 1e-6);
    assert_close(&lab.sees_trend("LFG-0101", "").await[0]["value"], 2.958219, 1e-6);
    assert_close(&lab.sees_trend("LFG-0101", "method=rigid").await[0]["value"], 2.957643, 1e-6);
    assert_eq!(verdict(&answer, "LFG-0101", "D_I", "step")["limit"], 0.5);
}

#[tokio::test]
async fn pages_follow_one_another_without_gap_or_overlap() {
    let history: Vec<(i64, f64)> = (0..23).map(|k| (k * 10, 1.0 + k as f64 * 1e-4)).collect();
    let lab = Lab::holding(&history).await;
    let all = lab.sees_trend("A", "").await;
    let mut paged = Vec::new();
    let mut path = "/v1/gyros/A/trend?coefficient=D_I&limit=5".to_owned();
    loop {
        let page = lab.get(&path).await;
        let body = page.ok();
        paged.extend(body["points"].as_array().unwrap().clone());
        let link = page.header("link");
        assert_eq!(link.is_empty(), body["next"].is_null());
        if link.is_empty() {
            break;
        }
        assert!(link.ends_with("; rel=\"next\"") && link.contains(body["next"].as_str().unwrap()), "{link}");
        path = link[1..link.find('>').unwrap()].to_owned();
    }
    assert_eq!(paged, all);
    assert_eq!(all.len(), 23);
    assert_eq!(lab.sees_trend("A", "last=3").await, all[20..]);
    let middle = lab.sees_trend("A", &format!("from={}&to={}", day(20), day(40))).await;
    assert_eq!(middle, all[2..5]);
    let at_eight = |sign| format!("from={}&to={}", day(20).replace('Z', &format!("{sign}00:00")), day(40));
    assert_eq!(lab.sees_trend("A", &at_eight("%2B")).await, middle);
    assert_eq!(lab.sees_trend("A", &at_eight("+")).await, middle, "a + that was sent as it is means a blank");
    assert_eq!(lab.sees_trend("A", "from=2031-01-01T00:00:00Z").await, Vec::<Value>::new());
}

#[tokio::test]
async fn bad_queries_are_refused_in_words() {
    let lab = Lab::holding(&[(0, 1.0)]).await;
    for (query, words) in [
        ("coefficient=D_X", "D_X"),
        ("from=yesterday", "from"),
        ("to=2026-01-01T00:00:00", "offset"),
        ("to=2026-01-01+00:00:00Z", "to: must be a day (UTC) such as"),
        ("limit=0", "limit"),
        ("limit=many", "limit"),
        ("limit=100001", "limit"),
        ("cursor=zzz", "cursor"),
        ("format=xml", "format"),
        ("method=guess", "method"),
        ("colour=red", "colour"),
        ("last=3&limit=4", "last"),
    ] {
        let answer = lab.get(&format!("/v1/gyros/A/trend?{query}")).await;
        answer.refused(400);
        assert!(answer.text.contains(words), "{query}: {}", answer.text);
    }
    lab.get("/v1/gyros/B/trend").await.refused(404);
    lab.get("/v1/gyros?limit=0").await.refused(400);
}

#[tokio::test]
async fn a_spreadsheet_gets_every_point_as_csv() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.0 / 3.0)]).await;
    let by_format = lab.get("/v1/gyros/A/trend?format=csv").await;
    let by_accept = Answer::of(lab.request(Method::GET, "/v1/gyros/A/trend").header("accept", "text/csv")).await;
    assert_eq!(by_format.text, by_accept.text);
    assert_eq!(by_format.header("content-type"), "text/csv; charset=utf-8");
    let mut reader = csv::Reader::from_reader(by_format.text.as_bytes());
    let rows: Vec<std::collections::HashMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 2);
    assert_eq!(rows[1]["calibrated_at"], day(40));
    let point = &lab.sees_trend("A", "").await[1];
    assert_eq!(rows[1]["value"].parse::<f64>().unwrap(), point["value"].as_f64().unwrap(), "at full precision");
    assert_eq!((rows[1]["imu"].as_str(), rows[1]["state"].as_str()), ("IMU-1", point["state"].as_str().unwrap()));
    assert_eq!(rows[1]["status"], point["status"].as_str().unwrap());
    for (asked, last) in [("", "record,state,status"), ("&voided=include", "record,state,voided,status")] {
        let text = lab.get(&format!("/v1/gyros/A/trend?format=csv{asked}")).await.text;
        assert!(text.lines().next().unwrap().ends_with(last), "{text}");
    }
}

/// One state, and what it means: a violation seen once, one seen twice, and a level that has moved by half a budget.
#[tokio::test]
async fn a_status_tells_what_a_state_leaves_open() {
    let violated: Vec<(i64, f64)> = (0..5).map(|k| (40 * k, if k < 3 { 1.0 } else { 1.02 })).collect();
    let lab = Lab::holding(&violated).await;
    let points = lab.sees_trend("A", "").await;
    assert_eq!(states(&points)[3..], ["exceeded", "exceeded"]);
    let expected = ["not_enough_data", "in_tolerance", "in_tolerance", "unconfirmed", "confirmed"];
    assert_eq!(statuses(&points), expected);
    assert_eq!(statuses(&lab.sees_trend("A", "coefficient=D_S").await)[1..], ["in_tolerance"; 4]);

    // Half a budget, four weeks long, after half a year: no specification is violated.
    for week in 0..28 {
        let d_i = if week < 24 { 1.0 } else { 1.005 };
        lab.posts(&record("IMU-2", &day(7 * week + 1), &[("G1", "B", d_i, 2.0)])).await;
    }
    let last = lab.sees_trend("B", "last=1").await;
    assert_eq!((states(&last), statuses(&last)), (vec!["exceeded"], vec!["drifting"]));
    // What an alert says, and the list of alerts as a table.
    let alerts = lab.get("/v1/alerts?serial=B&state=firing").await.ok();
    let alerts = alerts["alerts"].as_array().unwrap();
    assert!(!alerts.is_empty() && alerts.iter().all(|alert| alert["status"] == "drifting"), "{alerts:?}");
    let table = lab.get("/v1/alerts?serial=A&rule=baseline&format=csv").await.text;
    assert!(table.lines().next().unwrap().contains(",status") && table.contains("confirmed"), "{table}");
}

#[tokio::test]
async fn gyros_are_listed_by_status() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.02), (160, 1.02)]).await;
    for serial in ["C", "D", "E"] {
        lab.posts(&record(&format!("IMU-{serial}"), &day(1), &[("G1", serial, 1.0, 2.0)])).await;
    }
    let serials = |page: &Value| -> Vec<Value> {
        page["gyros"].as_array().unwrap().iter().map(|gyro| gyro["serial"].clone()).collect()
    };
    for (query, expected) in [
        ("status=confirmed", vec!["A"]),
        ("state=exceeded", vec!["A"]),
        ("status=confirmed&state=within", vec![]),
        ("status=unconfirmed", vec![]),
        ("status=not_enough_data", vec!["C", "D", "E"]),
        ("state=indeterminate", vec!["C", "D", "E"]),
    ] {
        assert_eq!(serials(&lab.get(&format!("/v1/gyros?{query}")).await.ok()), expected, "{query}");
    }
    assert_eq!(lab.get("/v1/gyros?status=confirmed&limit=1").await.ok()["next"], Value::Null);
    // One page after another holds each once, however many are left out between.
    let asked = "/v1/gyros?status=not_enough_data&limit=2";
    let first = lab.get(asked).await.ok();
    let next = lab.get(&format!("{asked}&cursor={}", first["next"].as_str().unwrap())).await.ok();
    assert_eq!((serials(&first), serials(&next)), (vec![json!("C"), json!("D")], vec![json!("E")]));
    assert_eq!(next["next"], Value::Null);
    for (query, words) in [("status=well", "in_tolerance"), ("state=well", "within")] {
        let answer = lab.get(&format!("/v1/gyros?{query}")).await;
        answer.refused(400);
        assert!(answer.text.contains(words), "{}", answer.text);
    }
}

#[tokio::test]
async fn gyros_are_listed_by_serial_whatever_came_first() {
    let lab = Lab::holding(&[(0, 1.0)]).await;
    for serial in ["Z", "M", "B"] {
        lab.posts(&record(&format!("IMU-{serial}"), &day(1), &[("G1", serial, 1.0, 2.0)])).await;
    }
    let (mut listed, mut path) = (Vec::new(), "/v1/gyros?limit=1".to_owned());
    loop {
        let page = lab.get(&path).await.ok();
        listed.extend(page["gyros"].as_array().unwrap().iter().map(|gyro| gyro["serial"].clone()));
        let Some(cursor) = page["next"].as_str() else { break };
        path = format!("/v1/gyros?limit=1&cursor={cursor}");
    }
    assert_eq!(listed, ["A", "B", "M", "Z"]);
}

#[tokio::test]
async fn a_trend_that_has_not_changed_is_not_sent_again() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.0)]).await;
    let path = "/v1/gyros/A/trend";
    let tag = lab.get(path).await.header("etag").to_owned();
    let ask = |tag: String| Answer::of(lab.request(Method::GET, path).header("if-none-match", tag));
    let unchanged = ask(tag.clone()).await;
    assert_eq!((unchanged.status, unchanged.text.as_str()), (304, ""));
    assert_ne!(lab.get("/v1/gyros/A/trend?coefficient=D_S").await.header("etag"), tag);
    lab.posts(&record("IMU-1", &day(20), &[("G1", "A", 1.0, 2.0)])).await;
    assert_eq!(ask(tag).await.status, 200);
}

#[tokio::test]
async fn years_are_seen_by_day_week_and_month() {
    let history = [(0, 1.0), (3, 1.004), (5, 0.998), (31, 1.006), (32, 1.002)];
    let lab = Lab::holding(&history).await;
    assert!(day(0).starts_with("2025-01-01"), "a Wednesday");
    let months = lab.get("/v1/gyros/A/trend?every=month").await.ok();
    assert_eq!(json!([months["every"], months["method"], months["next"]]), json!(["month", "rigid", null]));
    let seen = |answer: &Value| -> Vec<(String, i64)> {
        let periods = answer["periods"].as_array().unwrap().iter();
        periods.map(|p| (p["begins"].as_str().unwrap()[..10].to_owned(), p["count"].as_i64().unwrap())).collect()
    };
    assert_eq!(seen(&months), [("2025-01-01".to_owned(), 3), ("2025-02-01".to_owned(), 2)]);
    let january = &months["periods"][0];
    for (figure, expected) in [("min", 0.998), ("max", 1.004), ("mean", (1.0 + 1.004 + 0.998) / 3.0), ("last", 0.998)] {
        assert_close(&january[figure], expected, 1e-12);
    }
    let weeks = lab.get("/v1/gyros/A/trend?every=week").await.ok();
    let expected = [("2024-12-30", 2), ("2025-01-06", 1), ("2025-01-27", 2)];
    assert_eq!(seen(&weeks), expected.map(|(begins, count)| (begins.to_owned(), count)));
    assert_eq!(seen(&lab.get("/v1/gyros/A/trend?every=day").await.ok()).len(), history.len());
}

#[tokio::test]
async fn pages_of_periods_hold_every_measurement_once() {
    let history: Vec<(i64, f64)> = (0..120).map(|k| (k * 2, 1.0 + (k as f64) * 1e-5)).collect();
    let lab = Lab::holding(&history).await;
    for every in ["day", "week", "month"] {
        let whole = lab.get(&format!("/v1/gyros/A/trend?every={every}")).await.ok();
        let (mut pages, mut cursor) = (Vec::new(), String::new());
        loop {
            let page = lab.get(&format!("/v1/gyros/A/trend?every={every}&limit=3{cursor}")).await.ok();
            pages.extend(page["periods"].as_array().unwrap().clone());
            match page["next"].as_str() {
                Some(next) => cursor = format!("&cursor={next}"),
                None => break,
            }
        }
        assert_eq!(&Value::Array(pages), &whole["periods"], "{every}");
        let last = lab.get(&format!("/v1/gyros/A/trend?every={every}&last=2")).await.ok();
        let (last, whole) = (last["periods"].as_array().unwrap(), whole["periods"].as_array().unwrap());
        assert_eq!(last[..], whole[whole.len() - 2..], "{every}");
        let counted: i64 = whole.iter().map(|period| period["count"].as_i64().unwrap()).sum();
        assert_eq!(counted, 120, "{every}");
    }
}

#[tokio::test]
async fn periods_come_as_csv_and_a_wrong_period_is_named() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.001)]).await;
    let text = lab.get("/v1/gyros/A/trend?every=month&format=csv").await.text;
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "serial,coefficient,unit,method,every,begins,count,min,max,mean,last");
    assert!(lines[1].starts_with("A,D_I,deg/(h*g0),rigid,month,2025-01-01T00:00:00Z,1,"), "{}", lines[1]);
    assert_eq!(lines.len(), 3);
    let wrong = lab.get("/v1/gyros/A/trend?every=year").await;
    assert_eq!(wrong.status, 400);
    assert!(wrong.text.contains("every must be one of day, week, month, is year"), "{}", wrong.text);
    assert_eq!(lab.get("/v1/gyros/A/trend?every=day&voided=include").await.status, 400);
}

#[tokio::test]
async fn a_trend_as_columns_says_what_its_points_say() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.001), (80, 1.05), (120, 1.002)]).await;
    let points = lab.sees_trend("A", "").await;
    let all = lab.get("/v1/gyros/A/trend?columns=all").await.ok();
    assert!(all.get("points").is_none() && all["next"].is_null(), "{all}");
    for (name, column) in all["columns"].as_object().unwrap() {
        let of_points: Vec<&Value> = points.iter().map(|point| &point[name]).collect();
        assert_eq!(column.as_array().unwrap().iter().collect::<Vec<_>>(), of_points, "{name}");
    }
    assert_eq!(all["columns"].as_object().unwrap().len(), points[0].as_object().unwrap().len());
    let some = lab.get("/v1/gyros/A/trend?columns=value,calibrated_at&limit=2").await;
    let body = some.ok();
    assert_eq!(
        body["columns"],
        json!({"value": [points[0]["value"], points[1]["value"]],
        "calibrated_at": [day(0), day(40)]})
    );
    assert!(body["next"].is_string() && some.header("link").contains("columns=value"), "{}", some.header("link"));
    assert_ne!(some.header("etag"), lab.get("/v1/gyros/A/trend?limit=2").await.header("etag"));
    for wrong in ["columns=valeu", "columns=", "columns=all&format=csv", "columns=all&every=month"] {
        assert_eq!(lab.get(&format!("/v1/gyros/A/trend?{wrong}")).await.status, 400, "{wrong}");
    }
}

#[tokio::test]
async fn a_trend_says_what_its_points_are_held_against() {
    let lab = Lab::holding(&[(0, 1.0), (40, 1.003), (80, 1.0), (120, 1.05)]).await;
    assert!(lab.sees_trend("A", "").await.iter().all(|point| point.get("level").is_none()));
    let held = |point: &Value, baseline: f64| {
        for (name, expected) in [("baseline", baseline), ("lower", baseline - 0.01), ("upper", baseline + 0.01)] {
            assert_close(&point["level"][name], expected, 1e-9);
        }
    };
    // The median of the first three, and the budget.
    lab.sees_trend("A", "levels=include").await.iter().for_each(|point| held(point, 1.0));
    let before = lab.get("/v1/gyros/A/trend?levels=include").await.header("etag").to_owned();
    assert_ne!(before, lab.get("/v1/gyros/A/trend").await.header("etag"));
    let columns = lab.get("/v1/gyros/A/trend?levels=include&columns=value").await.ok()["columns"].clone();
    assert_eq!((columns.as_object().unwrap().len(), columns["lower"].as_array().unwrap().len()), (4, 4), "{columns}");
    assert_close(&columns["upper"][3], 1.01, 1e-9);
    let csv = lab.get("/v1/gyros/A/trend?levels=include&format=csv").await.text;
    assert!(csv.lines().next().unwrap().ends_with(",state,baseline,lower,upper,status"), "{csv}");
    let first: Vec<&str> = csv.lines().nth(1).unwrap().split(',').collect();
    let [baseline, upper] = [12, 14].map(|place| first[place].parse::<f64>().unwrap());
    assert!((baseline - 1.0).abs() < 1e-9 && (upper - 1.01).abs() < 1e-9, "{csv}");

    // Another level from a day on: what came before keeps its own.
    let stated = json!({"reason": "rebuilt", "fixed": {"D_I": 1.05}, "at": day(100)});
    lab.post("/v1/gyros/A/baseline", &stated).await.created();
    let points = lab.sees_trend("A", "levels=include").await;
    held(&points[2], 1.0);
    held(&points[3], 1.05);
    assert_ne!(before, lab.get("/v1/gyros/A/trend?levels=include").await.header("etag"));
    for wrong in ["levels=yes", "levels=include&every=month"] {
        assert_eq!(lab.get(&format!("/v1/gyros/A/trend?{wrong}")).await.status, 400, "{wrong}");
    }
}

/// A row of the view for SQL: serial, day, method, then D_I, D_S, D_O with their standard deviations, and what was said of D_I.
type Plain = (String, String, String, [Option<f64>; 6], Option<String>);

async fn plain_history(lab: &Lab) -> Vec<Plain> {
    type Columns = (
        String,
        String,
        String,
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<String>,
    );
    let sql =
        "SELECT serial, substr(CAST(time AS TEXT), 1, 10), method, d_i, d_i_sd, d_s, d_s_sd, d_o, d_o_sd, state_d_i
               FROM gyro_history ORDER BY serial, method, time";
    let rows: Vec<Columns> = lab.rows(sql).await;
    let row = |(serial, day, method, d_i, d_i_sd, d_s, d_s_sd, d_o, d_o_sd, state): Columns| -> Plain {
        (serial, day, method, [d_i, d_i_sd, d_s, d_s_sd, d_o, d_o_sd], state)
    };
    rows.into_iter().map(row).collect()
}

/// The same from trends.
async fn from_trends(lab: &Lab, serial: &str, method: &str) -> Vec<Plain> {
    let mut rows: Vec<Plain> = Vec::new();
    for (k, coefficient) in ["D_I", "D_S", "D_O"].into_iter().enumerate() {
        let points = lab.sees_trend(serial, &format!("coefficient={coefficient}&method={method}&last=10000")).await;
        for (n, point) in points.iter().filter(|point| point["method"] == method).enumerate() {
            if k == 0 {
                let day = point["calibrated_at"].as_str().unwrap()[..10].to_owned();
                let state = point["state"].as_str().map(str::to_owned);
                rows.push((serial.to_owned(), day, method.to_owned(), [None; 6], state));
            }
            let known = method != "published" || coefficient != "D_O";
            rows[n].3[2 * k] = point["value"].as_f64().filter(|_| known);
            rows[n].3[2 * k + 1] = point["sd"].as_f64().filter(|_| known);
        }
    }
    rows
}

/// Bit for bit, whatever has been corrected, and whether or not it has been moved to its place.
#[tokio::test]
async fn sql_reads_the_history_of_every_gyro_in_plain_columns() {
    let lab = Lab::open().await;
    let sizes = [1.0, -2.5e-9, 370.0, 0.0, 1.0 / 3.0];
    let of = |n: i64, at: &str| {
        let d_i = sizes[n as usize % sizes.len()] + 1e-4 * n as f64;
        let mut record = record("IMU-1", at, &[("G1", "A", d_i, -2.0), ("G2", "B", 1.0, d_i)]);
        if n % 2 == 0 {
            (record["gyros"][0]["e_sd"], record["gyros"][0]["g_sd"]) =
                (json!([1e-7, 1e-7, 1e-7]), json!([1e-4, 2e-4, 3e-4]));
        }
        record
    };
    let mut ids = Vec::new();
    // Two come late.
    for n in [0, 1, 4, 5, 2, 6, 7, 3, 8] {
        ids.push(lab.posts(&of(n, &day(n))).await["id"].as_str().unwrap().to_owned());
    }
    let said = json!({"author": "A. Turing", "reason": "table was not level"});
    lab.post(&format!("/v1/records/{}/void", ids[1]), &said).await.ok();
    let revision = json!({"author": "A. Turing", "reason": "wrong scale", "record": of(3, &day(5))});
    lab.post(&format!("/v1/records/{}/revise", ids[3]), &revision).await.created();
    lab.post("/v1/bench-results", &bench("A", &day(3), 0.5, -0.25)).await.created();
    let mut expected = Vec::new();
    for (serial, method) in
        [("A", "published"), ("A", "rigid"), ("A", "torque_feedback"), ("B", "published"), ("B", "rigid")]
    {
        let bench = (serial.to_owned(), day(3)[..10].to_owned(), method.to_owned(), [0.5, -0.25]);
        expected.extend(match method {
            "torque_feedback" => {
                vec![(bench.0, bench.1, bench.2, [Some(bench.3[0]), None, Some(bench.3[1]), None, None, None], None)]
            }
            method => from_trends(&lab, serial, method).await,
        });
    }
    let seen = plain_history(&lab).await;
    assert!(seen.iter().any(|row| row.3[1].is_some()) && seen.len() == 4 * 8 + 1, "{seen:?}");
    assert_eq!(seen, expected);
    if cluster::is_wanted() {
        return;
    }
    // So many that the first ones leave the log of a file.
    let minutes = |n: i64| format!("{}T{:02}:{:02}:00Z", &day(9 + n / 1_440)[..10], n / 60 % 24, n % 60);
    let documents: Vec<Value> = (9..9_000).map(|n| of(n, &minutes(n))).collect();
    assert!(lab.imports(&documents).await.iter().all(|line| line["status"] == 201), "all are stored");
    let seen = plain_history(&lab).await;
    let rigid: Vec<Plain> = seen.into_iter().filter(|row| row.0 == "A" && row.2 == "rigid").collect();
    assert_eq!(rigid.len(), 8 + 8_991);
    assert_eq!(rigid, from_trends(&lab, "A", "rigid").await);
}
