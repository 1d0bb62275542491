//! SQL in every string and in every parameter: it is stored word for word or refused, and does nothing else.

use crate::prelude::*;
use crate::support::{asked, seed};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SQL: [&str; 8] = [
    "'; DROP TABLE record; --",
    "\" OR \"\"=\"",
    "1' OR '1'='1",
    "') UNION SELECT hash FROM token --",
    "x'); DELETE FROM history WHERE ('1'='1",
    "%' ESCAPE '\\",
    "$1 ?1 :imu @imu",
    "1; PRAGMA writable_schema=ON",
];

fn encoded(text: &str) -> String {
    url::form_urlencoded::byte_serialize(text.as_bytes()).collect::<String>().replace('+', "%20")
}

/// Pointers to all strings of a document.
fn strings(value: &Value, at: &str, found: &mut Vec<String>) {
    match value {
        Value::String(_) => found.push(at.to_owned()),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, item)| strings(item, &format!("{at}/{i}"), found))
        }
        Value::Object(members) => {
            members.iter().for_each(|(name, member)| strings(member, &format!("{at}/{name}"), found))
        }
        _ => {}
    }
}

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// What stations and people send, each with every text that it may hold; `k` makes it another one.
fn documents(k: usize) -> Vec<(&'static str, Value)> {
    let at = jiff::Timestamp::from_second(1_700_000_000 + 60 * k as i64).unwrap().to_string();
    let mut record = parsed(&data("paper.json"));
    record["calibrated_at"] = at.as_str().into();
    record["operator"] = "B. Stander".into();
    record["note"] = "after transport".into();
    let mut campaign = parsed(&data("practice/campaign-00.json"));
    campaign["measured_at"] = at.as_str().into();
    campaign["dwells"].as_array_mut().unwrap().truncate(24);
    let mut bench = parsed(data("paper-bench.ndjson").lines().next().unwrap());
    bench["measured_at"] = at.as_str().into();
    let event = json!({ "event": "note", "reason": "seen", "author": "B. Stander", "at": at });
    let baseline = json!({ "reason": "repaired", "author": "B. Stander", "at": at });
    let hook = json!({ "name": "line", "url": "http://127.0.0.1:9/", "kind": "standard-webhooks" });
    vec![
        ("/v1/records", record),
        ("/v1/campaigns", campaign),
        ("/v1/bench-results", bench),
        ("/v1/gyros/LFG-0101/events", event),
        ("/v1/gyros/LFG-0101/baseline", baseline),
        ("/v1/hooks", hook),
    ]
}

/// Rows of each table.
async fn holdings(server: &Server) -> BTreeMap<String, i64> {
    server.holdings().await.into_iter().collect()
}

fn assert_nothing_gone(before: &BTreeMap<String, i64>, after: &BTreeMap<String, i64>, what: &str) {
    assert_eq!(before.keys().collect::<Vec<_>>(), after.keys().collect::<Vec<_>>(), "{what}");
    // What a server is at comes and goes by itself.
    let stays = |table: &str| table != "diagnosis_claim";
    let less: Vec<_> = before.iter().filter(|(table, rows)| stays(table) && after[*table] < **rows).collect();
    assert!(less.is_empty(), "{what}: {less:?} are {after:?}");
}

#[tokio::test]
async fn sql_in_any_string_of_a_body_is_stored_word_for_word_or_refused() {
    let server = Server::start().await;
    server.post_json("/v1/records", &parsed(&data("paper.json"))).await;
    let before = holdings(&server).await;
    let (mut stored, mut refused) = (0, 0);
    let mut k = 0;
    for kind in 0..documents(0).len() {
        let mut places = Vec::new();
        strings(&documents(0)[kind].1, "", &mut places);
        for place in places {
            // Each with one of its own: every place sees two, every text many places.
            for sql in [SQL[k % SQL.len()], SQL[(k + 3) % SQL.len()]] {
                k += 1;
                let (path, mut document) = documents(k).swap_remove(kind);
                *document.pointer_mut(&place).unwrap() = sql.into();
                let answer = server.post_json(path, &document).await;
                let what = format!("{path} {place} {sql}: {}", answer.text());
                match answer.status {
                    201 => stored += 1,
                    400 | 409 | 422 => refused += 1,
                    other => panic!("{other} {what}"),
                }
                let Some(location) = answer.headers.get("location").filter(|_| answer.status == 201) else { continue };
                let kept = server.get(location.to_str().unwrap()).await.text();
                let as_json = Value::from(sql).to_string();
                assert!(kept.contains(&as_json), "{what} is kept as {kept}");
            }
        }
    }
    assert!(stored > 20 && refused > 10, "{stored} {refused}");
    assert_nothing_gone(&before, &holdings(&server).await, "bodies");
}

#[tokio::test]
async fn a_gyro_whose_serial_is_sql_is_found_by_it_and_by_nothing_else() {
    let server = Server::start().await;
    for (k, sql) in SQL.iter().enumerate() {
        let (path, mut record) = documents(k).swap_remove(0);
        record["imu"] = (*sql).into();
        for (i, gyro) in record["gyros"].as_array_mut().unwrap().iter_mut().enumerate() {
            gyro["serial"] = format!("{sql}{i}").into();
        }
        let answer = server.post_json(path, &record).await;
        assert_eq!(answer.status, 201, "{sql}: {}", answer.text());
    }
    for sql in SQL {
        let of_it = format!("/v1/gyros/{}", encoded(&format!("{sql}0")));
        let gyro = server.get(&of_it).await.json();
        assert_eq!((&gyro["serial"], &gyro["calibrations"]), (&json!(format!("{sql}0")), &json!(1)));
        let trend = server.get(&format!("{of_it}/trend?coefficient=D_I")).await.json();
        assert_eq!(trend["points"].as_array().unwrap().len(), 1, "{sql}");
        assert_eq!(trend["points"][0]["imu"], sql);
        assert_eq!(server.get(&format!("/v1/gyros/{}", encoded(&format!("{sql}' OR '1'='1")))).await.status, 404);
        let page = server.get(&format!("/gyros/{}", encoded(&format!("{sql}0")))).await;
        assert_eq!(page.status, 200, "{sql}");
        assert!(!page.text().contains("\" OR \"\"=\""), "quotes are escaped on pages");
    }
}

#[tokio::test]
async fn sql_in_any_parameter_reads_and_changes_nothing_else() {
    let server = Server::start().await;
    for (path, document) in documents(0) {
        assert_eq!(server.post_json(path, &document).await.status, 201, "{path}");
    }
    let description = server.get("/openapi.json").await.json();
    let before = holdings(&server).await;
    let mut tried = 0;
    for (path, operations) in description["paths"].as_object().unwrap() {
        for (method, operation) in operations.as_object().unwrap() {
            let method = method.to_uppercase();
            let parameters = operation["parameters"].as_array().cloned().unwrap_or_default();
            for parameter in &parameters {
                let name = parameter["name"].as_str().unwrap();
                for sql in SQL {
                    // The other parameters of the path are good ones, so that it is this one that is read.
                    let filled = path.replace("{serial}", if name == "serial" { "{this}" } else { "LFG-0101" });
                    let filled = filled.replace(&format!("{{{name}}}"), "{this}").replace("{this}", &encoded(sql));
                    let asked = match parameter["in"].as_str() {
                        Some("path") => filled,
                        Some("query") => format!("{filled}?{name}={}", encoded(sql)),
                        _ => continue,
                    };
                    let body = if method == "GET" { "" } else { "{}" };
                    let content_type = if method == "GET" { "" } else { "application/json" };
                    let answer = server.call(&method, &asked, &[("content-type", content_type)], body).await;
                    assert!(answer.status < 500, "{method} {asked}: {} {}", answer.status, answer.text());
                    assert!(method == "GET" || answer.status >= 400, "{method} {asked}: {}", answer.status);
                    tried += 1;
                }
            }
        }
    }
    for page in [
        "/fleet?q=",
        "/fleet?imu=",
        "/fleet?station=",
        "/find?q=",
        "/?since=",
        "/alerts?state=",
        "/alerts?serial=",
        "/gyros/",
    ] {
        for sql in SQL {
            let answer = server.get(&format!("{page}{}", encoded(sql))).await;
            assert!(answer.status < 500, "{page}{sql}: {}", answer.status);
            tried += 1;
        }
    }
    assert!(tried > 300, "{tried}");
    assert_nothing_gone(&before, &holdings(&server).await, "parameters");
}

/// What statements are made of, and what ends the place that a value was meant for.
const FRAGMENTS: [&str; 32] = [
    "'",
    "''",
    "\"",
    "`",
    ")",
    "))",
    "(",
    ";",
    "--",
    "/*",
    "*/",
    "%",
    "_",
    "\\",
    "\\'",
    "||",
    " OR ",
    " AND ",
    " UNION SELECT ",
    " 1=1",
    "'1'='1'",
    "DROP TABLE record",
    "DELETE FROM history",
    "UPDATE token SET role = 'admin'",
    "INSERT INTO hook VALUES (",
    "PRAGMA ",
    "ATTACH 'x' AS y",
    "load_extension('x')",
    "randomblob(1e9)",
    "$1",
    "?1",
    ":imu",
];

/// A statement that nobody has thought of: some are SQL, most are not.
fn made_up(chance: &mut ChaCha8Rng) -> String {
    let mut text = String::new();
    for _ in 0..chance.random_range(1..8) {
        text += FRAGMENTS.choose(chance).unwrap();
    }
    // Names have 64 characters at the most, and none at their ends that is a blank.
    text.trim().chars().take(60).collect::<String>().trim().to_owned()
}

/// `scripts/soak sql`: made-up statements in every string of every document, and as every parameter.
#[tokio::test]
async fn sql_that_is_made_up_does_no_more() {
    let rounds = asked("GYROWATCH_SOAK_ROUNDS", 120);
    let server = Server::start().await;
    for (path, document) in documents(0) {
        assert_eq!(server.post_json(path, &document).await.status, 201, "{path}");
    }
    let description = server.get("/openapi.json").await.json();
    let mut queries = Vec::new();
    for (path, operations) in description["paths"].as_object().unwrap() {
        for parameter in operations["get"]["parameters"].as_array().into_iter().flatten() {
            queries.push((path.replace("{serial}", "LFG-0101"), parameter["name"].as_str().unwrap().to_owned()));
        }
    }
    let (mut before, mut stored, mut refused, mut asked) = (holdings(&server).await, 0, 0, 0);
    for round in 0..rounds {
        let mut chance = ChaCha8Rng::seed_from_u64(seed(round));
        let sql = made_up(&mut chance);
        let mut all = documents(1 + round);
        let (path, mut document) = all.swap_remove(chance.random_range(0..all.len()));
        let mut places = Vec::new();
        strings(&document, "", &mut places);
        *document.pointer_mut(places.choose(&mut chance).unwrap()).unwrap() = sql.as_str().into();
        let answer = server.post_json(path, &document).await;
        let what = format!("seed {}: {sql} to {path}: {}", seed(round), answer.text());
        match answer.status {
            201 => stored += 1,
            400 | 409 | 422 => refused += 1,
            other => panic!("{other} {what}"),
        }
        if let Some(location) = answer.headers.get("location").filter(|_| answer.status == 201) {
            let kept = server.get(location.to_str().unwrap()).await.text();
            assert!(kept.contains(&Value::from(sql.as_str()).to_string()), "{what} is kept as {kept}");
        }
        let (path, name) = queries.choose(&mut chance).unwrap();
        let query = match path.contains(&format!("{{{name}}}")) {
            true => path.replace(&format!("{{{name}}}"), &encoded(&sql)),
            false => format!("{path}?{name}={}", encoded(&sql)),
        };
        let answer = server.get(&query).await;
        assert!(answer.status < 500, "seed {}: {query}: {} {}", seed(round), answer.status, answer.text());
        asked += 1;
        if round % 100 == 99 || round + 1 == rounds {
            let after = holdings(&server).await;
            assert_nothing_gone(&before, &after, &format!("the hundred up to seed {}", seed(round)));
            before = after;
        }
    }
    println!(
        "sql: {stored} documents stored word for word, {refused} refused, {asked} questions; nothing else changed"
    );
}
