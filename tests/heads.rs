//! The row of each gyro that lists are made of: as what is stored says, whatever has changed how the gyro stands; made
//! where it is missing, and found out where it is wrong.

use crate::lab::{JSON, NDJSON, bench};
use crate::prelude::*;
use gyrowatch::config::Config;
use gyrowatch::core::time::UtcMicros;
use gyrowatch::system::Clock;
use gyrowatch::words::Language;

/// A laboratory on a file, and one on PostgreSQL where there is that.
async fn on_both(change: impl Fn(&mut Config)) -> Vec<Lab> {
    let mut labs = vec![Lab::with(&change).await];
    if cluster::is_there() && !cluster::is_wanted() {
        let url = cluster::fresh_database().await;
        // Nobody is killed here, and everything is verified after each step beside other tests.
        let on_server = |config: &mut Config| {
            (config.database.url, config.database.busy_timeout_s) = (url.clone(), 60.0);
            change(config);
        };
        labs.push(Lab::with(on_server).await);
    }
    labs
}

/// What a column of the row of a gyro says.
async fn says(lab: &Lab, serial: &str, column: &str) -> String {
    let sql = format!("SELECT CAST({column} AS TEXT) FROM head WHERE serial = '{serial}'");
    let said: Vec<(Option<String>,)> = lab.rows(&sql).await;
    said[0].0.clone().unwrap_or_default()
}

/// Every row is as what is stored says.
async fn stand(lab: &Lab, after: &str) {
    let verified = lab.verified().await;
    assert!(verified.faults.is_empty(), "{after}: {:#?}", verified.faults);
    assert!(verified.heads.is_some_and(|gyros| gyros > 0), "{after}: {verified:?}");
}

/// What is wrong, in English.
async fn faults(lab: &Lab) -> Vec<String> {
    lab.verified().await.faults.iter().map(|fault| Language::English.words(fault)).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn whatever_changes_how_a_gyro_stands_its_row_follows() {
    let settings = |config: &mut Config| {
        config.judging.interval_days = 800.0;
        config.alerts.tick_s = 0.02;
        config.database.max_waiting_writes = 10_000;
    };
    for lab in on_both(settings).await {
        let of_three = |at: i64, d: f64| {
            record("IMU-1", &day(at), &[("G1", "A", d, 2.0), ("G2", "B", 1.0, d), ("G3", "C", 1.0, 2.0)])
        };
        for at in 0..6 {
            lab.posts(&of_three(10 * at, 1.0 + 1e-4 * at as f64)).await;
            stand(&lab, "a record").await;
        }
        lab.posts(&of_three(33, 1.001)).await;
        stand(&lab, "a late record").await;
        lab.posts(&of_three(55, 1.0 + 5e-4)).await;
        stand(&lab, "a record that repeats the one before").await;
        assert_eq!([says(&lab, "A", "status").await, says(&lab, "A", "firing").await], ["in_tolerance", "0"]);
        let beyond = lab.posts(&of_three(60, 1.05)).await;
        stand(&lab, "a record beyond the budget").await;
        assert_eq!([says(&lab, "A", "status").await, says(&lab, "A", "severity").await], ["unconfirmed", "warning"]);
        let alerts = lab.get("/v1/alerts?serial=A&state=firing").await.ok()["alerts"].clone();
        assert_eq!(says(&lab, "A", "firing").await, alerts.as_array().unwrap().len().to_string());
        let said = json!({"by": "Li Wei", "reason": "known", "until": "2026-12-24T08:00:00Z"});
        for what in ["acknowledge", "silence"] {
            let said = if what == "acknowledge" { json!({"by": "Li Wei", "reason": "known"}) } else { said.clone() };
            lab.post(&format!("/v1/alerts/{}/{what}", id(&alerts[0])), &said).await.ok();
            stand(&lab, what).await;
        }
        let again = lab.posts(&of_three(65, 1.05)).await;
        stand(&lab, "the same once more").await;
        lab.posts(&of_three(66, 1.0501)).await;
        stand(&lab, "a record that confirms it").await;
        assert_eq!([says(&lab, "A", "status").await, says(&lab, "A", "severity").await], ["confirmed", "critical"]);
        let reason = json!({"author": "Li Wei", "reason": "table was not level"});
        lab.post(&format!("/v1/records/{}/void", id(&beyond)), &reason).await.ok();
        stand(&lab, "a voided record").await;
        let newest = lab.posts(&of_three(70, 1.07)).await;
        lab.post(&format!("/v1/records/{}/void", id(&newest)), &reason).await.ok();
        stand(&lab, "the newest record voided").await;
        assert!((says(&lab, "A", "d_i").await.parse::<f64>().unwrap() - 1.0501).abs() < 1e-9);
        let revision = json!({"record": of_three(65, 1.0), "author": "Li Wei", "reason": "wrong table"});
        lab.post(&format!("/v1/records/{}/revise", id(&again)), &revision).await.created();
        stand(&lab, "a revised record").await;
        for (event, out_of_use) in
            [("baseline", ""), ("repair", ""), ("in_storage", "in_storage"), ("retired", "retired")]
        {
            let done = json!({"event": event, "reason": "planned", "at": day(75)});
            lab.post("/v1/gyros/C/events", &done).await.created();
            stand(&lab, event).await;
            assert_eq!(says(&lab, "C", "out_of_use").await, out_of_use);
        }
        assert_eq!((says(&lab, "C", "rank").await, says(&lab, "C", "overdue_at").await), ("1".into(), String::new()));
        lab.posts(&record("IMU-2", &day(80), &[("G1", "C", 1.0, 2.0), ("G2", "D", 5.0, 6.0)])).await;
        stand(&lab, "a gyro that has moved and is in use again").await;
        assert_eq!(says(&lab, "C", "out_of_use").await, "");
        lab.post("/v1/bench-results", &bench("E", &day(81), 1.0, 2.0)).await.created();
        stand(&lab, "a gyro that only a bench has seen").await;
        let measured = lab.post("/v1/bench-results", &bench("D", &day(81), 5.2, 6.0)).await.created();
        stand(&lab, "a bench result that disagrees").await;
        assert_eq!((says(&lab, "D", "state").await, says(&lab, "D", "firing").await), ("exceeded".into(), "1".into()));
        lab.post(&format!("/v1/bench-results/{}/void", id(&measured)), &reason).await.ok();
        stand(&lab, "a voided bench result").await;
        assert_eq!(says(&lab, "D", "firing").await, "0");
        let mut out_of_requirement = of_three(90, 1.0);
        out_of_requirement["imu"] = "IMU-3".into();
        for at in [90, 91] {
            out_of_requirement["calibrated_at"] = day(at).into();
            for (k, gyro) in out_of_requirement["gyros"].as_array_mut().unwrap().iter_mut().enumerate() {
                gyro["serial"] = format!("R{k}").into();
                for e in gyro["e_pulse_per_arcsec"].as_array_mut().unwrap() {
                    *e = (3.0 * e.as_f64().unwrap()).into();
                }
            }
            lab.posts(&out_of_requirement).await;
            stand(&lab, "a requirement that is not met").await;
        }
        let aside = lab.posts(&record("IMU-4", "2000-01-05T08:00:00Z", &[("G1", "F", 1.0, 2.0)])).await;
        stand(&lab, "a record whose time is in doubt").await;
        assert_eq!(says(&lab, "F", "calibrated_at").await, "");
        lab.post(&format!("/v1/records/{}/confirm", id(&aside)), &json!({"by": "B. Li", "reason": "true"})).await.ok();
        stand(&lab, "a confirmed record").await;
        assert_ne!(says(&lab, "F", "calibrated_at").await, "");
        lab.posts(&record("IMU-5", "2000-01-05T08:00:00Z", &[("G1", "G", 1.0, 2.0)])).await;
        lab.posts(&record("IMU-5", &day(100), &[("G1", "G", 3.0, 2.0)])).await;
        stand(&lab, "others set aside").await;
        let campaign = include_str!("data/practice/campaign-00.json");
        assert_eq!(lab.post_text("/v1/campaigns", JSON, campaign).await.status, 201);
        stand(&lab, "a campaign").await;
        // Groups that are judged while the one before is being written, and many new names at once.
        for round in 0..3 {
            let many: Vec<Value> = (0..900)
                .map(|k| {
                    let (imu, at) = (k % 150, 110 + 8 * round + k / 150);
                    let (a, b) = (format!("M{imu}-1"), format!("M{imu}-2"));
                    let d = 1.0 + if imu % 10 == 0 && at > 112 { 0.05 } else { 0.0 } + 1e-5 * at as f64;
                    record(&format!("M{imu}"), &day(at), &[("G1", &a, d, 2.0), ("G2", &b, 1.0, d)])
                })
                .collect();
            assert!(lab.imports(&many).await.iter().all(|line| line["status"] == 201));
            stand(&lab, "an import of many").await;
        }
        assert_eq!(says(&lab, "M0-1", "status").await, "confirmed");
        // Nothing but time has passed.
        lab.clock_shows("2028-11-01T12:00:00Z");
        once(async || says(&lab, "M5-1", "firing").await, |alerts_of_overdue| alerts_of_overdue == "1").await;
        stand(&lab, "a calibration that is overdue").await;
        let overdue = lab.get("/v1/gyros?status=overdue&limit=10000").await.ok()["gyros"].clone();
        let retired = lab.get("/v1/gyros").await.ok()["gyros"].clone();
        assert!(
            overdue.as_array().unwrap().len() + 1 >= retired.as_array().unwrap().len(),
            "but for what has no calibration"
        );
        let silence =
            json!({"matchers": {"serial": "M5-1"}, "until": "2029-01-01T00:00:00Z", "by": "Li", "reason": "planned"});
        lab.post("/v1/silences", &silence).await.created();
        stand(&lab, "a silence of many").await;
    }
}

#[tokio::test]
async fn a_row_that_is_wrong_or_missing_is_found_and_limits_that_change_make_all_anew() {
    for mut lab in on_both(|_| {}).await {
        for at in 0..4 {
            lab.posts(&record(
                "IMU-1",
                &day(at),
                &[("G1", "A", 1.0, 2.0), ("G2", "B", 1.0, 2.0), ("G3", "C", 1.0, 2.0)],
            ))
            .await;
        }
        stand(&lab, "as it was written").await;
        for (wrong, right) in [
            ("load = load + 1e-9", "load = load - 1e-9"),
            ("status = 'drifting'", "status = 'in_tolerance'"),
            ("overdue_at = 5", "overdue_at = NULL"),
            ("rank = rank + 1", "rank = rank - 1"),
            ("sought = upper(sought)", "sought = lower(sought)"),
            ("firing = 1", "firing = 0"),
            ("d_s_sd = 0.5", "d_s_sd = NULL"),
            ("since = 5", "since = NULL"),
            ("changed_at = 5", "changed_at = NULL"),
            ("d_i_load_sd = 0.5", "d_i_load_sd = NULL"),
            ("d_i_load = d_i_load + 0.1", "d_i_load = d_i_load - 0.1"),
            ("reach_of = 'D_I', reach_at = 5", "reach_of = NULL, reach_at = NULL"),
        ] {
            assert_eq!(lab.change(&format!("UPDATE head SET {wrong} WHERE serial = 'B'")).await, 1);
            let faults = faults(&lab).await;
            assert!(faults.len() == 1 && faults[0].starts_with("gyro B: the table head has"), "{wrong}: {faults:?}");
            lab.change(&format!("UPDATE head SET {right} WHERE serial = 'B'")).await;
        }
        lab.change("UPDATE head SET load = (SELECT load FROM head WHERE serial = 'A') WHERE serial = 'B'").await;
        stand(&lab, "as it was before").await;
        // A start that was broken off goes on after the last that it has made.
        lab.stop().await;
        let load = says(&lab, "A", "load").await;
        lab.change("UPDATE head SET load = 77 WHERE serial = 'A'").await;
        lab.change("UPDATE head_made SET through = 'A'").await;
        assert_eq!(lab.change("DELETE FROM head WHERE serial <> 'A'").await, 2);
        lab.start().await;
        assert_eq!(says(&lab, "A", "load").await.parse(), Ok(77.0), "it was made before");
        lab.change(&format!("UPDATE head SET load = {load} WHERE serial = 'A'")).await;
        stand(&lab, "a start that went on").await;
        lab.stop().await;
        assert_eq!(lab.change("DELETE FROM head WHERE serial = 'B'").await, 1);
        lab.start().await;
        let faults = faults(&lab).await;
        assert_eq!(faults, ["gyro B: is missing from the table head"]);
        lab.stop().await;
        lab.config.judging.interval_days = 30.0;
        assert_eq!(lab.verified().await.heads, None, "made with other limits");
        lab.start().await;
        stand(&lab, "made with other limits").await;
        let overdue = lab.get("/v1/gyros?status=overdue").await.ok();
        assert_eq!(overdue["gyros"].as_array().unwrap().len(), 3);
    }
}

/// The serials that the API lists.
async fn listed(lab: &Lab, query: &str) -> Vec<String> {
    let gyros = lab.get(&format!("/v1/gyros?{query}")).await.ok()["gyros"].clone();
    gyros.as_array().unwrap().iter().map(|gyro| gyro["serial"].as_str().unwrap().to_owned()).collect()
}

#[tokio::test]
async fn the_fleet_is_narrowed_down_by_station_imu_rule_and_time_and_says_where_gyros_go() {
    for mut lab in on_both(|config| config.alerts.backfill_days = 100_000.0).await {
        let sent = async |lab: &Lab, station: &str, at: i64, d: f64| {
            let mut body = record("IMU-1", &day(at), &[("G1", "A", d, 2.0), ("G2", "B", 1.0, 2.0 + 1e-5 * at as f64)]);
            body["station"] = station.into();
            lab.posts(&body).await;
        };
        for at in 0..4 {
            sent(&lab, "ST-1", 10 * at, 1.0 + 1e-5 * at as f64).await;
        }
        sent(&lab, "ST-2", 40, 0.97).await;
        sent(&lab, "ST-2", 50, 0.97).await;
        let mut other = record("IMU-2", &day(45), &[("G1", "C", 1.0, 2.0)]);
        other["station"] = "ST-2".into();
        lab.posts(&other).await;
        lab.post("/v1/bench-results", &bench("E", &day(46), 1.0, 2.0)).await.created();
        for (query, serials) in [
            ("", &["A", "B", "C", "E"][..]),
            ("station=ST-1", &[]),
            ("station=ST-1&station_when=ever", &["A", "B"]),
            ("station=ST-2&station_when=ever", &["A", "B", "C"]),
            ("station=ST-2", &["A", "B", "C"]),
            ("station=nowhere", &[]),
            ("imu=IMU-2", &["C"]),
            ("q=imu-1", &["A", "B"]),
            ("rule=baseline", &["A"]),
            ("rule=overdue", &[]),
            ("calibrated_since=2025-02-16", &["A", "B"]),
            ("calibrated_since=2025-02-16T12:00:00%2B02:00", &["A", "B"]),
            ("calibrated_since=2025-02-15", &["A", "B", "C"]),
            // Its step and its distance from the baseline began on 10 February.
            ("changed_since=2025-02-10", &["A"]),
            ("changed_since=2025-02-11", &[]),
            ("rule=baseline&imu=IMU-2", &[]),
            ("status=confirmed&station=ST-2&changed_since=2025-02-01", &["A"]),
        ] {
            assert_eq!(listed(&lab, query).await, serials, "{query}");
        }
        for (sort, first, last) in [("serial", "A", "E"), ("load", "A", "E"), ("age", "C", "E"), ("eta", "A", "E")] {
            let whole = listed(&lab, &format!("sort={sort}")).await;
            assert_eq!((whole.len(), &*whole[3]), (4, last), "{sort}: {whole:?}");
            assert!(sort == "eta" || whole[0] == first, "{sort}: {whole:?}");
            let (mut one_by_one, mut query) = (Vec::new(), format!("sort={sort}&limit=1"));
            loop {
                let page = lab.get(&format!("/v1/gyros?{query}")).await.ok();
                one_by_one.push(page["gyros"][0]["serial"].as_str().unwrap().to_owned());
                let Some(next) = page["next"].as_str() else { break };
                query = format!("sort={sort}&limit=1&cursor={next}");
            }
            assert_eq!(one_by_one, whole, "{sort}");
        }
        for wrong in ["rule=nonsense", "station_when=then", "changed_since=yesterday", "sort=size"] {
            assert_eq!(lab.get(&format!("/v1/gyros?{wrong}")).await.status, 400, "{wrong}");
        }
        let gyro = lab.get("/v1/gyros/A").await.ok();
        let load = gyro["latest"]["loads"]["D_I"]["value"].as_f64().unwrap();
        // 0.03 below the median of 1, 1.00001 and 1.00002.
        assert!((load + 3.001).abs() < 1e-6, "{gyro}");
        assert_eq!(gyro["since"], "2025-02-10T12:00:00Z");
        assert!(gyro["latest"]["reach"].is_null());
        // What stations have ever calibrated is made anew where it is missing.
        lab.stop().await;
        lab.change("DELETE FROM gyro_station").await;
        lab.change("UPDATE head_made SET limits = ''").await;
        lab.start().await;
        assert_eq!(listed(&lab, "station=ST-1&station_when=ever").await, ["A", "B"]);
        stand(&lab, "made anew").await;
        lab.stop().await;
        lab.config.judging.interval_days = 30.0;
        lab.start().await;
        // Thirty days after day 45 C became overdue, after day 50 A and B.
        for (query, serials) in [
            ("changed_since=2025-03-17", &["A", "B", "C"][..]),
            ("changed_since=2025-03-18", &["A", "B"]),
            ("changed_since=2025-03-23", &[]),
        ] {
            assert_eq!(listed(&lab, query).await, serials, "{query}");
        }
    }
}

#[tokio::test]
async fn a_gyro_that_ages_says_when_it_reaches_its_budget() {
    for lab in on_both(|_| {}).await {
        for week in 0..40 {
            let d = 1.0 + 1e-4 * week as f64 + if week % 2 == 0 { 5e-5 } else { -5e-5 };
            lab.posts(&record("IMU-1", &day(7 * week), &[("G1", "OLD", d, 2.0)])).await;
        }
        stand(&lab, "ageing").await;
        let latest = lab.get("/v1/gyros/OLD").await.ok()["latest"].clone();
        let load = latest["loads"]["D_I"]["value"].as_f64().unwrap();
        assert!((0.3..0.45).contains(&load), "{latest}");
        // 0.01 at 1e-4 a week is 100 weeks after the first few.
        let reach = &latest["reach"];
        assert_eq!(reach["coefficient"], "D_I");
        let at = &reach["at"].as_str().unwrap()[..7];
        assert!(("2026-10".."2027-03").contains(&at), "{reach}");
        assert!(reach["earliest"].as_str().unwrap() < reach["at"].as_str().unwrap(), "{reach}");
    }
}

/// The serials on a page of the fleet, in their order.
async fn shown(server: &Server, address: &str) -> Vec<String> {
    let page = server.get(address).await.text();
    let links = page.split("href=\"/gyros/").skip(1);
    links.map(|link| link.split('"').next().unwrap().to_owned()).collect()
}

#[tokio::test]
async fn pages_and_cursors_show_every_gyro_once_and_in_one_order() {
    let url = if cluster::is_there() { Some(cluster::fresh_database().await) } else { None };
    for url in [None, url] {
        // In 2025, and the clock is right: what was last calibrated in the first days is overdue.
        let days = Clock::System.now().0 / UtcMicros::DAY - 20_089;
        let interval = (days - 150).to_string();
        let mut settings = vec![("GYROWATCH_JUDGING__INTERVAL_DAYS", interval.as_str())];
        settings.extend(url.as_deref().map(|url| ("GYROWATCH_DATABASE_URL", url)));
        let server = Server::start_with(&settings).await;
        // As good as one another, so that only their serials tell them apart; some worse, some overdue.
        let records: Vec<Value> = (0..90)
            .flat_map(|k| (0..4).map(move |at| (k, at)))
            .map(|(k, at)| {
                let d = 1.0 + if k % 9 == 4 && at > 1 { 0.05 } else { 0.0 };
                let begun = if k % 7 == 3 { 0 } else { 200 };
                record(
                    &format!("IMU-{k:02}"),
                    &day(begun + 10 * at + k),
                    &[("G1", &format!("S-{:03}", 37 * k % 90), d, 2.0)],
                )
            })
            .collect();
        let lines: String = records.iter().map(|record| format!("{record}\n")).collect();
        let answer = server.post("/v1/import", NDJSON, lines).await.text();
        assert_eq!(answer.matches("\"status\":201").count(), records.len(), "{answer}");
        let mut paged = Vec::new();
        for number in 0..3 {
            paged.extend(shown(&server, &format!("/fleet?page={number}")).await);
        }
        assert_eq!(
            shown(&server, "/fleet?page=3").await,
            shown(&server, "/fleet?page=2").await,
            "beyond the last the last is shown"
        );
        let mut each_once = paged.clone();
        each_once.sort();
        each_once.dedup();
        assert_eq!((paged.len(), each_once.len()), (90, 90));
        let mut listed: Vec<Value> = Vec::new();
        let mut next = String::new();
        loop {
            let page = server.get(&format!("/v1/gyros?limit=7{next}")).await.json();
            listed.extend(page["gyros"].as_array().unwrap().iter().cloned());
            match page["next"].as_str() {
                Some(cursor) => next = format!("&cursor={cursor}"),
                None => break,
            }
        }
        let serials: Vec<&str> = listed.iter().map(|gyro| gyro["serial"].as_str().unwrap()).collect();
        assert!(serials.len() == 90 && serials.is_sorted(), "{serials:?}");
        let worst = [
            "in_tolerance",
            "not_enough_data",
            "too_uncertain",
            "borderline",
            "overdue",
            "drifting",
            "unconfirmed",
            "out_of_tolerance",
            "confirmed",
        ];
        let place = |serial: &String| {
            let gyro = listed.iter().find(|gyro| gyro["serial"] == serial.as_str()).unwrap();
            worst.iter().position(|status| gyro["status"] == *status).unwrap()
        };
        let places: Vec<usize> = paged.iter().map(place).collect();
        assert!(places.iter().rev().is_sorted() && places[0] > places[89], "{places:?}");
        for status in worst {
            let filtered =
                server.get(&format!("/v1/gyros?status={status}")).await.json()["gyros"].as_array().unwrap().len();
            let of_page = shown(&server, &format!("/fleet?status={status}&q=S-")).await.len();
            assert_eq!(of_page, filtered.min(40), "{status}");
        }
    }
}

#[tokio::test]
async fn every_gyro_has_a_status_though_no_calibration_of_it_counts_and_is_counted_once_everywhere() {
    for lab in on_both(|_| {}).await {
        lab.posts(&record("IMU-1", &day(0), &[("G1", "A", 1.0, 2.0)])).await;
        let typo = lab.posts(&record("IMU-1", &day(10), &[("G1", "A-TYP0", 1.0, 2.0)])).await;
        lab.post("/v1/bench-results", &bench("E", &day(11), 1.0, 2.0)).await.created();
        let why = json!({"author": "Li Wei", "reason": "another serial"});
        lab.post(&format!("/v1/records/{}/void", id(&typo)), &why).await.ok();
        stand(&lab, "a gyro of which nothing counts").await;
        assert_eq!(listed(&lab, "status=not_enough_data").await, ["A", "A-TYP0", "E"]);
        assert_eq!(listed(&lab, "").await.len(), 3);
        let gyro = lab.get("/v1/gyros/A-TYP0").await.ok();
        assert_eq!((&gyro["latest"], &gyro["status"]), (&Value::Null, &json!("not_enough_data")));
    }
}
