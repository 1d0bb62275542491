//! Databases that released versions wrote, opened by this one: `tests/data/kept/VERSION.db.z` (SQLite) and `.sql.z`
//! (PostgreSQL), with what that version answered in `….json.z`; each deflated.
//!
//! `GYROWATCH_KEEP_VERSION=1 cargo test --test all kept_versions::` writes those of the version at hand. Kept ones are never
//! written again.

use std::io::{Read, Write};

use crate::command::verified;
use crate::prelude::*;
use crate::support::{SUMMARY, data_path, file_url};
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use serde_json::Map;

/// Fills a service with some of everything that is kept.
async fn fill(server: &Server) {
    let stored = async |path: &str, body: &Value| {
        let answer = server.post_json(path, body).await;
        assert!([200, 201].contains(&answer.status), "{path}: {}", answer.text());
        answer.json()
    };
    server.stores_half_a_year().await;
    let event =
        json!({ "event": "transport", "at": "2026-02-15T08:00:00Z", "author": "B. Li", "reason": "to station 2" });
    stored("/v1/gyros/LFG-0102/events", &event).await;
    let baseline = json!({ "at": "2026-03-15T08:00:00Z", "reason": "new motor", "fixed": { "D_I": 2.9576 } });
    stored("/v1/gyros/LFG-0103/baseline", &baseline).await;
    let attributes = json!({ "batch": "2025-07" }).to_string();
    server.call("PATCH", "/v1/gyros/LFG-0101", &[("content-type", "application/json")], attributes).await.has(200);
    let hook = json!({ "kind": "cloudevents", "url": "https://hooks.example/laboratory", "enabled": false });
    stored("/v1/hooks", &hook).await;
    let silence = json!({ "matchers": { "serial": "LFG-0103" }, "until": "2999-01-01T00:00:00Z", "by": "B. Li", "reason": "repair" });
    stored("/v1/silences", &silence).await;
    let alerts = server.get("/v1/alerts?serial=LFG-0101").await.json();
    let alert = alerts["alerts"][0]["id"].as_str().unwrap().to_owned();
    stored(&format!("/v1/alerts/{alert}/acknowledge"), &json!({ "by": "B. Li", "reason": "it is known" })).await;
    let records = server.get("/v1/records?limit=1").await.json();
    let newest = records["records"][0]["id"].as_str().unwrap().to_owned();
    stored(&format!("/v1/records/{newest}/void"), &json!({ "author": "B. Li", "reason": "not level" })).await;

    let campaign = server.post("/v1/campaigns", "application/json", data("practice/campaign-02.json")).await;
    assert_eq!(campaign.status, 201, "{}", campaign.text());
    let sent = document("practice/campaign-02.json");
    let adoption = json!({ "effects": [{ "effect": "temperature_bias", "gyros": ["G1", "G2", "G3"], "estimates": [] }],
        "author": "B. Li", "reason": "held-out dwells agree" });
    stored(&format!("/v1/imus/{}/model", sent["imu"].as_str().unwrap()), &adoption).await;
    let hypothesis = json!({ "hypothesis": { "id": "unbalance_creep", "words": "mass unbalance that settles",
        "equation": "k * exp(-t/tau) * a_S", "unit": "deg/(h g0)", "plausible": 10.0,
        "range": { "tau": { "from": 0.2, "to": 4.0, "unit": "h" } } }, "author": "B. Li", "reason": "cold nights" });
    stored("/v1/hypotheses", &hypothesis).await;
}

/// Lists, and where what they list is read by itself: the list, its member, what names an item, and the paths.
const LISTS: [(&str, &str, &str, &[&str]); 8] = [
    ("/v1/records", "records", "id", &["/v1/records/{}", "/v1/records/{}/diagnosis"]),
    ("/v1/campaigns", "campaigns", "id", &["/v1/campaigns/{}"]),
    ("/v1/alerts", "alerts", "id", &["/v1/alerts/{}"]),
    ("/v1/hooks", "hooks", "id", &["/v1/hooks/{}", "/v1/hooks/{}/deliveries"]),
    ("/v1/silences", "silences", "id", &["/v1/silences/{}"]),
    ("/v1/imus", "imus", "imu", &["/v1/imus/{}", "/v1/imus/{}/model"]),
    ("/v1/stations", "stations", "name", &["/v1/stations/{}"]),
    (
        "/v1/gyros",
        "gyros",
        "serial",
        &[
            "/v1/gyros/{}",
            "/v1/gyros/{}/events",
            "/v1/gyros/{}/agreement",
            "/v1/gyros/{}/trend?coefficient=D_I&voided=include",
            "/v1/gyros/{}/trend?coefficient=D_S",
            "/v1/gyros/{}/trend?coefficient=D_O",
        ],
    ),
];

/// Everything that a service answers of what is stored, by path.
async fn readings(server: &Server) -> Map<String, Value> {
    let mut found = Map::new();
    for (list, member, name, paths) in LISTS {
        let listed = server.settled(list).await;
        for item in listed[member].as_array().unwrap() {
            for path in paths {
                let path = path.replace("{}", item[name].as_str().unwrap());
                if server.get(&path).await.status == 308 {
                    continue; // A campaign, which is read below.
                }
                found.insert(path.clone(), server.settled(&path).await);
            }
        }
        found.insert(list.to_owned(), listed);
    }
    for path in ["/v1/hypotheses", "/v1/audit", "/v1/tokens", SUMMARY] {
        found.insert(path.to_owned(), server.settled(path).await);
    }
    found
}

/// Where an answer no longer says what it said. Members may come anew, words beside a code may change, and how many
/// diagnoses are of another method depends on the program's own.
fn differences(path: &str, before: &Value, after: &Value, found: &mut Vec<String>) {
    match (before, after) {
        (Value::Object(before), Value::Object(after)) => {
            for (name, member) in before {
                let of_code = before.contains_key("code") && ["reason", "detail"].contains(&&**name);
                if !of_code && name != "outdated" {
                    differences(&format!("{path}/{name}"), member, after.get(name).unwrap_or(&Value::Null), found);
                }
            }
        }
        (Value::Array(before), Value::Array(after)) if before.len() == after.len() => {
            for (place, (before, after)) in before.iter().zip(after).enumerate() {
                differences(&format!("{path}/{place}"), before, after, found);
            }
        }
        (Value::Number(x), Value::Number(y)) => {
            let (x, y) = (x.as_f64().unwrap(), y.as_f64().unwrap());
            // Since 0.3.0 the rank is of model (6) alone, without the effects that are fitted beside it.
            let is_rank = path.ends_with("/rank") && y < x;
            // Since then a station's records are counted once for all gyros in them, and its IMUs are all that it has
            // calibrated.
            let is_count = path.contains("/stations")
                && (path.ends_with("/records") && (1.0..x).contains(&y) || path.ends_with("/imus") && y > x);
            if !is_rank && !is_count && (x - y).abs() > 1e-9 * x.abs().max(y.abs()) {
                found.push(format!("{path}: {x} was, {y} is"));
            }
        }
        _ if before == after => {}
        // Since 0.3.0 units in parameters are spelled as in all of the API.
        (Value::String(x), Value::String(y)) if is_unit(path) && x.replace("h g0", "h*g0") == *y => {}
        _ => found.push(format!("{path}: {before} was, {after} is")),
    }
}

fn is_unit(path: &str) -> bool {
    path.ends_with("/unit/text") || path.ends_with("/hypothesis/unit")
}

fn kept(name: &str) -> PathBuf {
    data_path("kept").join(name)
}

/// What is at hand is kept where it is asked for; else the versions that are kept as `ending`.
fn versions(ending: &str) -> Vec<String> {
    let files = std::fs::read_dir(kept("")).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut versions: Vec<String> = files.filter_map(|name| Some(name.strip_suffix(ending)?.to_owned())).collect();
    versions.sort();
    versions
}

fn is_keeping() -> bool {
    std::env::var_os("GYROWATCH_KEEP_VERSION").is_some()
}

fn keep(ending: &str, bytes: &[u8]) {
    std::fs::create_dir_all(kept("")).unwrap();
    let file = kept(&format!("{}{ending}", env!("CARGO_PKG_VERSION")));
    assert!(!file.exists(), "{} is kept as it is", file.display());
    let mut packed = ZlibEncoder::new(std::fs::File::create(file).unwrap(), Compression::best());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap();
}

fn unpacked(name: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    ZlibDecoder::new(std::fs::File::open(kept(name)).unwrap()).read_to_end(&mut bytes).unwrap();
    bytes
}

/// The service says what the version that wrote its database said, and goes on from there.
async fn says_the_same(version: &str, kind: &str, server: &mut Server, url: &str) {
    let before: Map<String, Value> = serde_json::from_slice(&unpacked(&format!("{version}.{kind}.json.z"))).unwrap();
    assert!(before.len() > 40, "{}", before.len());
    let mut found = Vec::new();
    for (path, before) in &before {
        differences(path, before, &server.settled(path).await, &mut found);
    }
    assert_eq!(found, [""; 0], "{version}");
    let known = server.get("/v1/records").await.json()["records"].as_array().unwrap().len();
    let mut record = document("paper.json");
    record["calibrated_at"] = "2026-04-12T08:00:00Z".into();
    assert_eq!(server.post_json("/v1/records", &record).await.status, 201);
    assert_eq!(server.get("/v1/records").await.json()["records"].as_array().unwrap().len(), known + 1);
    assert!(server.terminate().0.success());
    verified(url);
}

#[tokio::test]
async fn a_file_that_a_released_version_wrote_says_what_it_said() {
    let url = |dir: &Path| file_url(&dir.join("gyrowatch.db"));
    if is_keeping() {
        let mut server = Server::start_under(&[], tempfile::tempdir().unwrap(), &[]);
        fill(&server).await;
        let answers = readings(&server).await;
        assert!(server.terminate().0.success());
        let copy = server.dir().join("copy.db");
        let backup = gyrowatch().arg("backup").arg(&copy).env("GYROWATCH_DATABASE_URL", url(server.dir())).output();
        assert!(backup.unwrap().status.success());
        keep(".db.z", &std::fs::read(copy).unwrap());
        keep(".db.json.z", json!(answers).to_string().as_bytes());
    }
    let versions = versions(".db.z");
    assert!(!versions.is_empty());
    for version in versions {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("gyrowatch.db"), unpacked(&format!("{version}.db.z"))).unwrap();
        let mut server = Server::start_under(&[], dir, &[]);
        let url = url(server.dir());
        says_the_same(&version, "db", &mut server, &url).await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_database_on_a_server_that_a_released_version_wrote_says_what_it_said() {
    if !cluster::is_there() {
        return;
    }
    let program = |name: &str| Command::new(cluster::programs().unwrap().join(name));
    let on = |url: &str| [("GYROWATCH_DATABASE_URL".to_owned(), url.to_owned())];
    let start = |url: &str| {
        let [(name, url)] = on(url);
        Server::start_under(&[], tempfile::tempdir().unwrap(), &[(&name, &url)])
    };
    if is_keeping() {
        let url = cluster::fresh_database().await;
        let mut server = start(&url);
        fill(&server).await;
        let answers = readings(&server).await;
        assert!(server.terminate().0.success());
        let dump = program("pg_dump").args(["--no-owner", "--no-privileges", &url]).output().unwrap();
        assert!(dump.status.success(), "{dump:?}");
        keep(".sql.z", &dump.stdout);
        keep(".sql.json.z", json!(answers).to_string().as_bytes());
    }
    let versions = versions(".sql.z");
    assert!(!versions.is_empty());
    for version in versions {
        let url = cluster::fresh_database().await;
        let mut psql = program("psql");
        let psql = psql.args(["--quiet", "--set", "ON_ERROR_STOP=1", &url]).stdin(Stdio::piped()).stdout(Stdio::null());
        let mut restored = psql.spawn().unwrap();
        restored.stdin.take().unwrap().write_all(&unpacked(&format!("{version}.sql.z"))).unwrap();
        assert!(restored.wait().unwrap().success());
        says_the_same(&version, "sql", &mut start(&url), &url).await;
    }
}
