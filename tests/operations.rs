//! Running the service: is it ready, what does it count, and what does it refuse to be started on.

use std::io::{BufRead, BufReader};

use crate::prelude::*;
use crate::prometheus::Prometheus;
use crate::support::{metric, required};

#[tokio::test]
async fn it_is_not_ready_while_another_program_holds_the_database_and_says_so() {
    let server = Server::start_with(&[("GYROWATCH_DATABASE__BUSY_TIMEOUT_S", "0.1")]).await;
    assert_eq!(server.get("/readyz").await.status, 200);

    let mut other = behind::open(&server.database()).await;
    sqlx::query("BEGIN IMMEDIATE").execute(&mut other).await.unwrap();
    let answer = server.get("/readyz").await;
    assert_eq!((answer.status, answer.content_type.as_str()), (503, "application/problem+json"));
    assert!(answer.json()["detail"].as_str().unwrap().contains("locked"), "{}", answer.text());
    let refused = server.post("/v1/records", "application/json", data("paper.json")).await;
    assert_eq!(refused.status, 503, "{}", refused.text());
    assert!(refused.headers.contains_key("retry-after"));
    assert_eq!(server.get("/healthz").await.status, 200, "it lives all the same");

    sqlx::query("ROLLBACK").execute(&mut other).await.unwrap();
    assert_eq!(server.get("/readyz").await.status, 200);
    assert_eq!(server.post("/v1/records", "application/json", data("paper.json")).await.status, 201);
}

#[tokio::test]
async fn a_second_service_on_the_same_file_is_refused_until_the_first_is_gone() {
    let mut first = Server::start().await;
    let url = format!("sqlite://{}", first.dir().join("gyrowatch.db").display());
    let second = || {
        let mut command = gyrowatch();
        command.arg("serve").env("GYROWATCH_LISTEN", "127.0.0.1:0").env("GYROWATCH_DATABASE_URL", &url);
        command.current_dir(first.dir()).output().unwrap()
    };
    let output = second();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("another gyrowatch") && said.contains("gyrowatch.db"), "{said}");
    first.kill();
    first.restart();
    assert_eq!(first.get("/readyz").await.status, 200, "a killed service leaves no lock behind");
}

#[tokio::test]
async fn a_file_that_is_no_database_is_named_at_the_start() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("torn.db");
    std::fs::write(&file, "SQLite format 3\0 and then nothing of the kind").unwrap();
    let url = format!("sqlite://{}", file.display());
    let output = gyrowatch()
        .arg("serve")
        .current_dir(dir.path())
        .envs([("GYROWATCH_LISTEN", "127.0.0.1:0"), ("GYROWATCH_DATABASE_URL", &url)])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("torn.db") && said.contains("no SQLite database"), "{said}");
}

#[tokio::test]
async fn metrics_count_requests_items_verdicts_and_commits() {
    let server = Server::start().await;
    for status in [201, 200] {
        assert_eq!(server.post("/v1/records", "application/json", data("paper.json")).await.status, status);
    }
    assert_eq!(server.post("/v1/records", "application/json", "{").await.status, 400);
    assert_eq!(server.get("/v1/gyros/LFG-0101").await.status, 200);
    assert_eq!(server.get("/v1/gyros/LFG-0102").await.status, 200);
    assert_eq!(server.get("/nowhere").await.status, 404);

    let answer = server.get("/metrics").await;
    assert_eq!((answer.status, answer.content_type.as_str()), (200, "text/plain; version=0.0.4; charset=utf-8"));
    let text = answer.text();
    let requests = |rest: &str| metric(&text, &format!("gyrowatch_http_requests_total{{{rest}}}"));
    assert_eq!(requests(r#"method="POST",route="/v1/records",status="201""#), 1.0);
    assert_eq!(requests(r#"method="POST",route="/v1/records",status="200""#), 1.0);
    assert_eq!(requests(r#"method="POST",route="/v1/records",status="400""#), 1.0);
    assert_eq!(requests(r#"method="GET",route="/v1/gyros/{serial}",status="200""#), 2.0);
    assert_eq!(requests(r#"method="GET",route="none",status="404""#), 1.0);
    assert_eq!(metric(&text, r#"gyrowatch_items_total{kind="calibration",outcome="stored"}"#), 1.0);
    assert_eq!(metric(&text, r#"gyrowatch_items_total{kind="calibration",outcome="there"}"#), 1.0);
    assert_eq!(metric(&text, "gyrowatch_commit_duration_seconds_count"), 1.0);
    assert!(metric(&text, "gyrowatch_commit_duration_seconds_sum") > 0.0);
    let steps = metric(&text, r#"gyrowatch_verdicts_total{rule="step",state="indeterminate"}"#);
    assert_eq!(steps, 6.0, "three gyros, two coefficients, no earlier record");
    assert_eq!(metric(&text, r#"gyrowatch_verdict_statuses_total{rule="step",status="not_enough_data"}"#), 6.0);
    assert!(metric(&text, "gyrowatch_database_log_size_bytes") > 4096.0);
    assert_eq!(metric(&text, "gyrowatch_writes_waiting"), 0.0);
}

/// Lets a program read `input` and say what it thinks of it.
fn judged_by(program: &str, arguments: &[&str], input: &str) -> (bool, String) {
    use std::io::Write as _;
    let piped = Stdio::piped;
    let mut command = Command::new(program);
    let mut child = command.args(arguments).stdin(piped()).stdout(piped()).stderr(piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    (output.status.success(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
}

#[tokio::test]
async fn prometheus_finds_no_fault_with_the_metrics_nor_with_its_configuration() {
    if !required("promtool") {
        return;
    }
    let server = Server::start().await;
    assert_eq!(server.post("/v1/records", "application/json", data("paper.json")).await.status, 201);
    assert_eq!(server.get("/nowhere").await.status, 404);
    let metrics = server.get("/metrics").await.text();
    let (well, said) = judged_by("promtool", &["check", "metrics"], &metrics);
    assert!(well && said.is_empty(), "{said}");
    let (well, said) = judged_by("promtool", &["check", "metrics"], "gyrowatch_x_total{ 1\n");
    assert!(!well && !said.is_empty(), "promtool takes anything");
    let config = root().join("config/prometheus/prometheus.yml");
    let (well, said) = judged_by("promtool", &["check", "config", "--syntax-only", config.to_str().unwrap()], "");
    assert!(well, "{said}");
}

#[tokio::test]
async fn a_healthcheck_asks_the_service_where_the_configuration_says() {
    let mut server = Server::start().await;
    let asked = |address: &str| gyrowatch().arg("healthcheck").env("GYROWATCH_LISTEN", address).output().unwrap();
    let address = server.address().to_owned();
    let well = asked(&address);
    assert!(well.status.success() && well.stdout.is_empty(), "{}", String::from_utf8_lossy(&well.stderr));
    server.kill();
    let away = asked(&address);
    assert_eq!(away.status.code(), Some(1));
    let said = String::from_utf8_lossy(&away.stderr);
    assert!(said.contains("/readyz does not answer: nothing listens there"), "{said}");
    assert_eq!(said.matches("readyz").count(), 1, "one fault, once: {said}");
}

/// Who makes a token beside a running service, and names no database, would wait in vain for it to be known there.
#[tokio::test]
async fn a_token_is_not_made_where_the_running_service_does_not_look_for_it() {
    let mut server = Server::start().await;
    let dir = tempfile::tempdir().unwrap();
    let address = server.address().to_owned();
    let create = || {
        let mut command = gyrowatch();
        command.args(["token", "create", "Weber", "--role", "admin"]).current_dir(dir.path());
        let output = command.env("GYROWATCH_LISTEN", &address).output().unwrap();
        (output.status.success(), String::from_utf8(output.stderr).unwrap())
    };
    let (made, said) = create();
    assert!(!made && said.contains(&address) && said.contains("GYROWATCH_DATABASE_URL"), "{said}");
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
    server.kill();
    let (made, said) = create();
    assert!(made && said.contains("there is no database sqlite://gyrowatch.db: making it"), "{said}");
}

#[tokio::test]
async fn the_service_is_where_an_option_or_else_the_environment_says() {
    let server = Server::start().await;
    let said = |option: &[&str], variables: &[(&str, &str)]| {
        let mut command = gyrowatch();
        command.args(["void", "none", "--author", "Weber", "--reason", "torn"]).args(option);
        let output = command.envs(variables.iter().copied()).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stderr).unwrap()
    };
    let (here, url, nowhere) = (server.address(), server.url(""), "http://127.0.0.1:9");
    let url = url.as_str();
    for (option, variables) in [
        (&["--url", url][..], &[("GYROWATCH_URL", nowhere)][..]),
        (&[][..], &[("GYROWATCH_URL", url), ("GYROWATCH_LISTEN", "127.0.0.1:9")][..]),
        (&[][..], &[("GYROWATCH_LISTEN", here)][..]),
    ] {
        let said = said(option, variables);
        assert!(said.contains("404: no record"), "{option:?} {variables:?}: {said}");
    }
    let said = said(&[], &[("GYROWATCH_URL", nowhere), ("GYROWATCH_LISTEN", here)]);
    assert!(said.contains(&format!("cannot reach {nowhere}")), "{said}");
}

/// On a terminal, which util-linux's `script` makes.
#[test]
fn no_color_is_heeded() {
    if !required("script") {
        return;
    }
    // What it says until it ends, or until it listens.
    let said = |order: &str, no_color: &str| {
        let dir = tempfile::tempdir().unwrap();
        let mut script = Command::new("script");
        script.args(["-qec", &format!("{} {order}", env!("CARGO_BIN_EXE_gyrowatch")), "/dev/null"]);
        script.current_dir(dir.path()).env("GYROWATCH_LISTEN", "127.0.0.1:0");
        script.env("NO_COLOR", no_color).env("TERM", "xterm").stdin(Stdio::null()).stdout(Stdio::piped());
        let mut terminal = script.spawn().unwrap();
        let lines = BufReader::new(terminal.stdout.take().unwrap()).lines().map(Result::unwrap);
        let said: Vec<String> = lines.take_while(|line| !line.contains("listens on")).collect();
        let _already_ended = terminal.kill();
        let _reaped = terminal.wait();
        said.join("\n")
    };
    for order in ["--help", "nonsense", "serve"] {
        let (plain, coloured) = (said(order, "1"), said(order, ""));
        assert!(!plain.is_empty() && !plain.contains('\x1b'), "{order}: {plain}");
        assert!(coloured.contains('\x1b'), "{order}: {coloured}");
    }
}

/// The counters among the series, but for those of requests, which come as they are asked for: only failures begin at 0.
fn counters(text: &str) -> BTreeSet<&str> {
    let series = text.lines().filter_map(|line| line.rsplit_once(' ').map(|(series, _)| series));
    let counts =
        |series: &&str| series.contains("_total{") || series.contains("_seconds_count") || series.ends_with("_count");
    series.filter(|series| counts(series) && !series.starts_with("gyrowatch_http")).collect()
}

#[tokio::test]
async fn every_counter_and_histogram_begins_at_zero() {
    let server = Server::start().await;
    let before = server.get("/metrics").await.text();
    assert_eq!(metric(&before, r#"gyrowatch_items_total{kind="calibration",outcome="failed"}"#), 0.0);
    assert_eq!(metric(&before, r#"gyrowatch_items_total{kind="window",outcome="stored"}"#), 0.0);
    let failed = |method: &str, route: &str, status: u16| {
        format!(r#"gyrowatch_http_requests_total{{method="{method}",route="{route}",status="{status}"}}"#)
    };
    assert_eq!(metric(&before, &failed("POST", "/v1/records", 503)), 0.0);
    assert_eq!(metric(&before, &failed("PATCH", "/v1/gyros/{serial}", 500)), 0.0);
    assert_eq!(metric(&before, r#"gyrowatch_delivery_attempts_total{kind="alertmanager",outcome="dead"}"#), 0.0);
    assert_eq!(metric(&before, r#"gyrowatch_delivery_attempt_duration_seconds_count{kind="email"}"#), 0.0);
    assert_eq!(server.post("/v1/records", "application/json", data("paper.json")).await.status, 201);
    assert_eq!(server.post("/v1/campaigns", "application/json", data("practice/campaign-00.json")).await.status, 201);
    let bench = data("paper-bench.ndjson").lines().next().unwrap().to_owned();
    assert_eq!(server.post("/v1/bench-results", "application/json", bench).await.status, 201);
    let after = server.get("/metrics").await.text();
    assert_eq!(counters(&after), counters(&before), "a counter is born with its first event");
    assert!(!counters(&before).is_empty());
}

#[tokio::test]
async fn metrics_tell_how_the_fleet_stands_and_what_the_process_takes() {
    let server = Server::start().await;
    assert_eq!(server.post("/v1/records", "application/json", data("paper.json")).await.status, 201);
    let text = server.get("/metrics").await.text();
    assert_eq!(metric(&text, r#"gyrowatch_gyros{status="not_enough_data"}"#), 3.0);
    assert_eq!(metric(&text, r#"gyrowatch_gyros{status="confirmed"}"#), 0.0);
    assert_eq!(metric(&text, r#"gyrowatch_alerts_firing{severity="critical"}"#), 0.0);
    assert!(metric(&text, "gyrowatch_station_newest_calibration_timestamp_seconds{station=") > 1e9);
    assert!(metric(&text, "process_resident_memory_bytes") > 1e6);
    assert!(metric(&text, "process_open_fds") > 3.0);
}

#[tokio::test]
async fn metrics_tell_how_far_forecasts_come_true() {
    let server = Server::start().await;
    let mut campaign = document("practice/campaign-00.json");
    for day in ["2026-03-01", "2026-03-22", "2026-04-12"] {
        campaign["measured_at"] = format!("{day}T08:00:00Z").into();
        let stored = server.post_json("/v1/campaigns", &campaign).await.created();
        let diagnosis = format!("/v1/campaigns/{}/diagnosis", stored["id"].as_str().unwrap());
        while server.get(&diagnosis).await.status == 202 {}
    }
    let text = server.get("/metrics").await.text();
    assert_eq!(metric(&text, "gyrowatch_forecast_rms_over_sd_count"), 2.0, "the first has none before it");
    let mean = metric(&text, "gyrowatch_forecast_rms_over_sd_sum") / 2.0;
    assert!((0.3..1.2).contains(&mean), "the very dwells again: {mean}");
}

#[test]
fn the_rules_of_prometheus_and_of_an_alertmanager_do_what_they_say() {
    if !required("promtool") || !required("amtool") {
        return;
    }
    let config = root().join("config/prometheus");
    let file = |name: &str| config.join(name).to_str().unwrap().to_owned();
    let (well, said) = judged_by("promtool", &["test", "rules", &file("rules.test.yml")], "");
    assert!(well, "{said}");
    let (well, said) = judged_by("amtool", &["check-config", &file("alertmanager.yml")], "");
    assert!(well, "{said}");
}

/// Every member of a document with that name.
fn members<'a>(value: &'a Value, name: &str, found: &mut Vec<&'a Value>) {
    match value {
        Value::Object(object) => {
            found.extend(object.get(name));
            object.values().for_each(|member| members(member, name, found));
        }
        Value::Array(items) => items.iter().for_each(|item| members(item, name, found)),
        _ => {}
    }
}

/// The labels that a query of the dashboard names: in `by (…)` and in `{…}`.
fn labels(query: &str) -> impl Iterator<Item = &str> {
    let within = |open: &'static str, close: char| {
        query.split(open).skip(1).flat_map(move |rest| rest.split(close).next().unwrap().split(','))
    };
    let compared = within("{", '}').map(|matcher| matcher.split(['=', '!']).next().unwrap());
    within("by (", ')').chain(compared).map(str::trim)
}

#[tokio::test]
async fn the_dashboard_asks_for_what_the_metrics_hold() {
    let server = Server::start().await;
    let target = Receiver::start().await;
    let hook =
        server.post_json("/v1/hooks", &json!({ "kind": "standard-webhooks", "url": target.url() })).await.created();
    let mut record = document("paper.json");
    // So many that there is a baseline.
    for day in 1..=5 {
        record["calibrated_at"] = json!(format!("2026-03-0{day}T08:00:00Z"));
        assert_eq!(server.post_json("/v1/records", &record).await.status, 201);
    }
    let test = format!("/v1/hooks/{}/test", hook["id"].as_str().unwrap());
    assert!(server.post_json(&test, &json!({})).await.status < 300);
    let campaign = server.post("/v1/campaigns", "application/json", data("practice/campaign-00.json")).await.created();
    let diagnosis = format!("/v1/campaigns/{}/diagnosis", campaign["id"].as_str().unwrap());
    assert_eq!(server.get(&diagnosis).await.status, 200);
    let metrics = server.get("/metrics").await.text();

    let of_file = |name: &str| -> Value {
        let file = root().join("config/grafana").join(name);
        serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap()
    };
    let dashboards = json!([of_file("dashboard.json"), of_file("gyros.json")]);
    let mut queries = Vec::new();
    members(&dashboards, "expr", &mut queries);
    // As Grafana fills them in; the labels of targets are Prometheus's own.
    let filled = |query: &&Value| {
        let query = query.as_str().unwrap().replace("$__rate_interval", "5m");
        query.replace("instance=~\"$instance\",", "").replace("{instance=~\"$instance\"}", "")
    };
    let queries = queries.iter().map(filled).collect::<Vec<_>>();
    assert!(queries.len() >= 20 && queries.iter().all(|query| !query.contains('$')), "{queries:?}");
    for query in &queries {
        let names = query.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
        // `up` is Prometheus's own, with the name of its job.
        for name in names.filter(|name| name.starts_with("gyrowatch_")) {
            let series = metrics
                .lines()
                .find(|line| line.starts_with(&format!("{name}{{")) || line.starts_with(&format!("{name} ")));
            let series = series.unwrap_or_else(|| panic!("{query}: there is no {name} in\n{metrics}"));
            for label in labels(query) {
                assert!(series.contains(&format!("{label}=\"")), "{query}: {series} has no {label}");
            }
        }
    }
    let mut panels = Vec::new();
    members(&dashboards, "panels", &mut panels);
    let panels: Vec<&Value> = panels.into_iter().flat_map(|panels| panels.as_array().unwrap()).collect();
    for panel in &panels {
        assert!(["${datasource}", "${api}"].contains(&panel["datasource"]["uid"].as_str().unwrap()), "{panel}");
        assert!(panel["description"].as_str().is_some_and(|said| !said.is_empty()), "{panel}");
    }
    let targets: Vec<&Value> = panels.iter().flat_map(|panel| panel["targets"].as_array().unwrap()).collect();
    let of_the_api: Vec<&&Value> = targets.iter().filter(|target| target["url"].is_string()).collect();
    assert_eq!(of_the_api.len(), 5);
    for target in of_the_api {
        let path = target["url"].as_str().unwrap().replace("${serial}", "LFG-0101");
        let path = path.replace("${__from:date:iso}", "2000-01-01T00:00:00.000Z");
        let path = path.replace("${__to:date:iso}", "2100-01-01T00:00:00.000Z");
        let answer = server.get(&path).await;
        assert_eq!(answer.status, 200, "{path}");
        let said = answer.json();
        let rows = match target["root_selector"].as_str().unwrap() {
            "" => vec![said],
            list => said[list].as_array().unwrap().clone(),
        };
        // The fleet of one gyro has none beyond a limit.
        assert!(!rows.is_empty() || path.contains("state="), "{path}");
        for (row, column) in
            rows.iter().flat_map(|row| target["columns"].as_array().unwrap().iter().map(move |of| (row, of)))
        {
            let pointer = format!("/{}", column["selector"].as_str().unwrap().replace('.', "/"));
            assert!(row.pointer(&pointer).is_some(), "{path}: no {pointer} in {row}");
        }
    }
    if required("prometheus") {
        let prometheus = Prometheus::watching(&server);
        let end = Instant::now() + Duration::from_secs(60);
        for query in &queries {
            // It has to start, and a rate needs two looks. A panel that stays empty would show nothing.
            let mut series = prometheus.series(query).await;
            while !series.as_ref().is_ok_and(|series| !series.is_empty()) {
                assert!(Instant::now() < end, "{query}: {series:?}");
                tokio::time::sleep(Duration::from_millis(200)).await;
                series = prometheus.series(query).await;
            }
        }
    }
}

/// Whether the file has a test of that name, and not only a function.
fn has_test(file: &Path, name: &str) -> bool {
    let text = std::fs::read_to_string(file).unwrap_or_else(|why| panic!("{}: {why}", file.display()));
    text.split_once(&format!("fn {name}() {{")).is_some_and(|(before, _)| {
        let attributes = before.rsplit("\n\n").next().unwrap();
        attributes.contains("#[test]") || attributes.contains("#[tokio::test")
    })
}

#[test]
fn what_users_of_other_programs_expect_is_tested_where_the_document_says() {
    let tests = root().join("tests");
    let page = std::fs::read_to_string(tests.with_file_name("docs").join("integrations.md")).unwrap();
    let rows: Vec<&str> =
        page.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| expected")).collect();
    assert!(rows.len() >= 30, "{}", rows.len());
    for row in rows {
        let cell = row.trim_end_matches(" |").rsplit(" | ").next().unwrap();
        let named: Vec<&str> = cell.split('`').skip(1).step_by(2).collect();
        assert!(!named.is_empty(), "{row}");
        for test in named {
            let (file, name) = test.split_once("::").unwrap_or_else(|| panic!("{test}: {row}"));
            assert!(has_test(&tests.join(file).with_extension("rs"), name), "there is no test {test}: {row}");
        }
    }
    assert!(!has_test(&tests.join("operations.rs"), "has_test"));
}

#[test]
fn systemd_finds_no_fault_with_the_unit_and_calls_it_well_hardened() {
    if !required("systemd-analyze") {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let unit = std::fs::read_to_string(root().join("config/gyrowatch.service"));
    // The program is where this build has put it; all else as it ships.
    let unit = unit.unwrap().replace("/usr/local/bin/gyrowatch", env!("CARGO_BIN_EXE_gyrowatch"));
    let file = dir.path().join("gyrowatch.service");
    std::fs::write(&file, unit).unwrap();
    let file = file.to_str().unwrap();
    let (well, said) = judged_by("systemd-analyze", &["verify", "--man=no", file], "");
    let about_it = said.lines().filter(|line| line.contains("gyrowatch.service")).collect::<Vec<_>>();
    assert!(well && about_it.is_empty(), "{said}");
    let (well, said) = judged_by("systemd-analyze", &["security", "--offline=true", "--threshold=20", file], "");
    assert!(well, "{said}");
}

/// Every `$ref` of a document.
fn references(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Object(members) => {
            for (name, member) in members {
                match member {
                    Value::String(target) if name == "$ref" => found.push(target.clone()),
                    member => references(member, found),
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| references(item, found)),
        _ => {}
    }
}

#[tokio::test]
async fn the_description_of_the_api_is_whole() {
    let server = Server::start().await;
    let document = server.get("/openapi.json").await.json();
    assert_eq!(document["openapi"], "3.1.0");
    let paths = document["paths"].as_object().unwrap();
    for (method, path) in [
        ("post", "/v1/records"),
        ("get", "/v1/records/{id}"),
        ("post", "/v1/bench-results"),
        ("post", "/v1/import"),
        ("get", "/v1/gyros"),
        ("get", "/v1/gyros/{serial}"),
        ("get", "/v1/gyros/{serial}/trend"),
        ("get", "/v1/gyros/{serial}/agreement"),
        ("post", "/v1/gyros/{serial}/baseline"),
        ("get", "/v1/hooks"),
        ("post", "/v1/hooks"),
        ("patch", "/v1/hooks/{id}"),
        ("delete", "/v1/hooks/{id}"),
        ("post", "/v1/hooks/{id}/test"),
        ("get", "/v1/hooks/{id}/deliveries"),
        ("post", "/v1/deliveries/{id}/redeliver"),
        ("get", "/healthz"),
        ("get", "/readyz"),
        ("get", "/metrics"),
    ] {
        assert!(paths.get(path).is_some_and(|operations| operations.get(method).is_some()), "{method} {path}");
    }
    let mut ids = Vec::new();
    let mut guarded = 0;
    for (path, operations) in paths {
        for (method, operation) in operations.as_object().unwrap() {
            let named = format!("{method} {path}");
            ids.push(operation["operationId"].as_str().unwrap_or_else(|| panic!("{named}")).to_owned());
            assert!(operation["summary"].is_string(), "{named}: no summary");
            if operation["security"].is_array() {
                let described = |status: &str| operation["responses"].get(status).is_some();
                assert!(["401", "403", "429"].into_iter().all(described), "{named}");
                guarded += 1;
            }
            let parameters = operation["parameters"].as_array().cloned().unwrap_or_default();
            for variable in path.split('{').skip(1).map(|rest| rest.split('}').next().unwrap()) {
                let described = |p: &Value| p["in"] == "path" && p["name"] == variable && p["required"] == true;
                assert!(parameters.iter().any(described), "{named}: {variable} is not described");
            }
            // Served at all: another method's refusal names it, and no method is taken that is not described.
            let concrete = path.replace(['{', '}'], "");
            let allowed = server.call("TRACE", &concrete, &[], "").await;
            assert_eq!(allowed.status, 405, "{named}");
            let allow = allowed.headers["allow"].to_str().unwrap().to_ascii_lowercase();
            assert!(allow.split(',').any(|one| one.trim() == method), "{named}: {allow}");
        }
    }
    let operations = ids.len();
    assert!(guarded > 60 && document["components"]["securitySchemes"]["token"].is_object(), "{guarded}");
    assert!(
        ids.iter().all(|id| id.chars().all(|c| c.is_ascii_lowercase() || c == '_')),
        "a name of a function: {ids:?}"
    );
    let mut links = 0;
    for link in paths.values().flat_map(|operations| operations.as_object().unwrap().values()) {
        for answer in link["responses"].as_object().unwrap().values() {
            for link in answer["links"].as_object().into_iter().flat_map(|links| links.values()) {
                assert!(ids.iter().any(|id| *id == link["operationId"]), "{link} leads nowhere");
                links += 1;
            }
        }
    }
    assert!(links >= 25, "{links}");
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), operations, "an operationId twice");
    let mut targets = Vec::new();
    references(&document, &mut targets);
    assert!(!targets.is_empty());
    for target in targets {
        let pointer = target.strip_prefix('#').unwrap_or_else(|| panic!("{target} lies outside"));
        assert!(document.pointer(pointer).is_some(), "{target} points nowhere");
    }
}

/// The limits that scripts/schemathesis holds against what is taken are there at all.
#[tokio::test]
async fn the_description_says_what_is_read_as_a_time_a_name_or_a_choice() {
    let server = Server::start().await;
    let document = server.get("/openapi.json").await.json();
    let member = |schema: &str, member: &str| document["components"]["schemas"][schema]["properties"][member].clone();
    for (schema, name) in [("RecordBody", "calibrated_at"), ("Point", "calibrated_at"), ("NewSilenceBody", "until")] {
        assert_eq!(member(schema, name)["format"], "date-time", "{schema} {name}");
    }
    for (schema, name, most) in [("RecordBody", "imu", 64), ("VoidOrder", "reason", 4096), ("BenchBody", "note", 4096)]
    {
        let found = member(schema, name);
        assert!(found["maxLength"] == most && found["pattern"].is_string(), "{schema} {name}: {found}");
    }
    assert_eq!(member("NewTokenBody", "role")["enum"], json!(["viewer", "station", "engineer", "admin"]));
    assert_eq!(member("CampaignBody", "rates")["enum"], json!(["inertial", "table", null]));
    assert_eq!(member("CampaignBody", "model")["uniqueItems"], true);
    let latitude = member("SiteBody", "latitude_deg");
    assert_eq!((latitude["minimum"].as_f64(), latitude["maximum"].as_f64()), (Some(-90.0), Some(90.0)));
    let version = member("AdoptionBody", "version");
    assert_eq!((&version["minimum"], &version["maximum"]), (&json!(1), &json!(2)), "whole numbers as such");
    // 24 to 64 bytes in base64, behind `whsec_`.
    let secret = member("HookPatchBody", "secret");
    assert_eq!((&secret["minLength"], &secret["maxLength"]), (&json!(6 + 32), &json!(6 + 88)));
    // What an answer always has is required, though it may be null.
    let required = document["components"]["schemas"]["Gyros"]["required"].clone();
    assert_eq!(required, json!(["gyros", "next"]));

    let parameters = document["paths"]["/v1/gyros"]["get"]["parameters"].as_array().unwrap();
    let parameter = |name: &str| &parameters.iter().find(|one| one["name"] == name).unwrap()["schema"];
    let statuses = parameter("status")["enum"].as_array().unwrap();
    assert!(statuses.len() > 5);
    for status in statuses {
        assert_eq!(server.get(&format!("/v1/gyros?status={}", status.as_str().unwrap())).await.status, 200, "{status}");
    }
    let limit = parameter("limit");
    let (least, most) = (limit["minimum"].as_f64().unwrap(), limit["maximum"].as_f64().unwrap());
    for (limit, status) in [(least, 200), (most, 200), (least - 1.0, 400), (most + 1.0, 400)] {
        assert_eq!(server.get(&format!("/v1/gyros?limit={limit}")).await.status, status, "{limit}");
    }
}

#[tokio::test]
async fn an_import_is_answered_whole_to_a_client_that_takes_it_compressed() {
    let server = Server::start().await;
    let lines = data("paper-bench.ndjson");
    let headers = [("content-type", "application/x-ndjson"), ("accept-encoding", "gzip")];
    let answer = server.call("POST", "/v1/import", &headers, lines).await;
    assert_eq!((answer.status, answer.headers["content-encoding"].to_str().unwrap()), (200, "gzip"));
    let mut text = String::new();
    std::io::Read::read_to_string(&mut flate2::read::GzDecoder::new(answer.body.as_slice()), &mut text).unwrap();
    assert_eq!(text.matches("\"status\":201").count(), 6, "{text}");
}
