//! Databases of every earlier version, with data in them, are brought up to date at the start, and say what they said
//! before.

use crate::command::{beside, ended, verified};
use crate::prelude::*;
use crate::support::{NEVER_LATE, SUMMARY, file_url};
use crate::{lab, receiver};
use sqlx::migrate::Migrator;
use sqlx::{AssertSqlSafe, ConnectOptions, Connection, PgConnection, SqliteConnection};

/// Bytes of a row of the history's log: the gyro's number, and its figures.
const ROW: usize = 124;

/// A service with records (one came late), a campaign, bench results and an event in it, and what it answers about
/// them.
async fn filled(settings: &[(&str, &str)]) -> (Server, Vec<(String, Value)>) {
    let server = Server::start_with(settings).await;
    let mut paths = Vec::new();
    for at in ["2026-03-01T08:00:00Z", "2026-03-22T08:00:00Z", "2026-03-08T08:00:00Z"] {
        let mut record = document("paper.json");
        record["calibrated_at"] = at.into();
        let stored = server.post_json("/v1/records", &record).await.created();
        paths.push(format!("/v1/records/{}", stored["id"].as_str().unwrap()));
    }
    let event = json!({ "event": "repair", "reason": "new motor", "at": "2026-03-20T00:00:00Z" });
    assert_eq!(server.post_json("/v1/gyros/LFG-0101/events", &event).await.status, 201);
    for campaign in ["practice/campaign-00.json", "practice/campaign-02.json"] {
        let stored = server.post("/v1/campaigns", "application/json", data(campaign)).await.created();
        paths.push(format!("/v1/campaigns/{}", stored["id"].as_str().unwrap()));
    }
    paths.push(SUMMARY.into());
    let benches = server.post("/v1/import", "application/x-ndjson", data("paper-bench.ndjson")).await.text();
    for line in benches.lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        paths.push(format!("/v1/bench-results/{}", line["id"].as_str().unwrap()));
    }
    paths.push("/v1/gyros/LFG-0101/events".into());
    paths.push("/v1/gyros".into());
    for gyro in ["LFG-0101", "LFG-0102"] {
        paths.push(format!("/v1/gyros/{gyro}/trend?coefficient=D_I"));
        paths.push(format!("/v1/gyros/{gyro}/agreement"));
    }
    let mut answers = Vec::new();
    for path in paths {
        let answer = server.settled(&path).await;
        answers.push((path, answer));
    }
    (server, answers)
}

/// What is known is known again, and what is new is stored.
async fn goes_on(upgraded: &Server, version: i64) {
    let known = upgraded.post("/v1/records", "application/json", data("paper.json")).await;
    assert!(matches!(known.status, 200 | 201), "version {version}: {}", known.text());
    let mut new = document("paper.json");
    new["calibrated_at"] = "2026-04-12T08:00:00Z".into();
    assert_eq!(upgraded.post_json("/v1/records", &new).await.status, 201, "version {version}");
}

/// What an earlier version stored as it was sent is deflated.
async fn deflates(count: impl AsyncFn(&'static str) -> i64) {
    let of_campaigns = "SELECT count(*) FROM record WHERE kind = 1 AND packed IS NULL";
    once(async || count(of_campaigns).await, |unpacked| *unpacked == 0).await;
    assert_eq!(count("SELECT count(*) FROM record WHERE kind = 1 AND body = ''").await, 2);
}

async fn names(connection: &mut SqliteConnection, sql: String) -> Vec<String> {
    sqlx::query_scalar(AssertSqlSafe(sql)).fetch_all(connection).await.unwrap()
}

/// Tables whose long texts are packed since version 23, on a server 16.
const PACKED: [(&str, &str); 2] = [("record", "id"), ("diagnosis", "record")];

fn inflated(packed: &[u8]) -> String {
    std::io::read_to_string(flate2::read::ZlibDecoder::new(packed)).unwrap()
}

/// Makes `file` a database as `version` left it, with what that version could hold of the database `from`.
async fn write_as_of(version: i64, file: &Path, from: &Path) {
    let migrations = root().join("migrations/sqlite");
    let all = Migrator::new(migrations).await.unwrap();
    let early = all.iter().filter(|migration| migration.version <= version).cloned().collect();
    let options = sqlx::sqlite::SqliteConnectOptions::new().filename(file).create_if_missing(true).foreign_keys(false);
    let mut connection = options.connect().await.unwrap();
    Migrator::with_migrations(early).run(&mut connection).await.unwrap();
    let attach = format!("ATTACH '{}' AS newer", from.display());
    sqlx::query(AssertSqlSafe(attach)).execute(&mut connection).await.unwrap();
    // Checksums are of the very rows that the database had, those of its migrations among them.
    let tables =
        "SELECT name FROM main.sqlite_schema WHERE type = 'table' AND name NOT LIKE '_sqlx%' AND name <> 'checksum'";
    for table in names(&mut connection, tables.to_owned()).await {
        let own = names(&mut connection, format!("SELECT name FROM pragma_table_info('{table}', 'main')")).await;
        let kept = names(&mut connection, format!("SELECT name FROM pragma_table_info('{table}', 'newer')")).await;
        // What a later version dropped may not be null before.
        let taken: Vec<&str> = own.iter().map(|name| if kept.contains(name) { name } else { "1" }).collect();
        let (own, taken) = (own.join(", "), taken.join(", "));
        let copy = format!("INSERT OR REPLACE INTO main.{table} ({own}) SELECT {taken} FROM newer.{table}");
        sqlx::query(AssertSqlSafe(copy)).execute(&mut connection).await.unwrap();
    }
    if version < 23 {
        for (table, key) in PACKED.into_iter().take(if version < 7 { 1 } else { 2 }) {
            let sql = format!("SELECT {key}, packed FROM newer.{table} WHERE packed IS NOT NULL");
            let packed: Vec<(i64, Vec<u8>)> =
                sqlx::query_as(AssertSqlSafe(sql)).fetch_all(&mut connection).await.unwrap();
            for (of, packed) in packed {
                let sql = format!("UPDATE main.{table} SET body = $1 WHERE {key} = $2");
                let put = sqlx::query(AssertSqlSafe(sql)).bind(inflated(&packed)).bind(of);
                put.execute(&mut connection).await.unwrap();
            }
        }
    }
    // Before there was a log, every row was in its place.
    if version < 6 {
        let entries: Vec<Vec<u8>> = sqlx::query_scalar("SELECT rows FROM newer.history_log ORDER BY id")
            .fetch_all(&mut connection)
            .await
            .unwrap();
        assert!(!entries.is_empty());
        for row in entries.iter().flat_map(|entry| entry.chunks_exact(ROW)) {
            let long = |from: usize| i64::from_le_bytes(row[from..from + 8].try_into().unwrap());
            sqlx::query(
                "INSERT OR REPLACE INTO main.history (gyro, calibrated_at, record, figures) VALUES ($1, $2, $3, $4)",
            )
            .bind(u32::from_le_bytes(row[..4].try_into().unwrap()))
            .bind(long(16))
            .bind(long(24))
            .bind(&row[4..])
            .execute(&mut connection)
            .await
            .unwrap();
        }
    }
    connection.close().await.unwrap();
}

/// Takes the instants out that say since when a gyro is beyond its limits.
fn forget_since(answer: &mut Value) {
    match answer {
        Value::Object(members) => {
            members.remove("since");
            members.values_mut().for_each(forget_since);
        }
        Value::Array(items) => items.iter_mut().for_each(forget_since),
        _ => {}
    }
}

/// Answers are as they were, but for what is kept from some versions on: notes, since when, and who sent it.
async fn answers_as_before<'a>(
    upgraded: &Server,
    answers: impl Iterator<Item = &'a (String, Value)>,
    version: i64,
    [notes, since, sender]: [i64; 3],
) {
    for (path, before) in answers {
        let mut before = before.clone();
        if version < notes && before.get("notes").is_some() && path.starts_with("/v1/records") {
            before["notes"] = json!([]);
        }
        if version < sender && before.get("sent_by").is_some() {
            assert_eq!(before["sent_by"]["name"], "local");
            before["sent_by"] = Value::Null;
        }
        let mut after = upgraded.settled(path).await;
        if version < since {
            [&mut before, &mut after].into_iter().for_each(forget_since);
        }
        assert_eq!(after, before, "version {version}: {path}");
    }
}

#[tokio::test]
async fn a_database_of_every_earlier_version_is_brought_up_to_date_with_all_that_is_in_it() {
    let (mut server, answers) = filled(&[]).await;
    assert!(server.terminate().0.success());
    let newest = std::fs::read_dir(root().join("migrations/sqlite")).unwrap().count();
    assert!(newest >= 9);
    // Of diagnoses that an earlier version made and kept, the migration keeps the gist.
    let summary = &answers.iter().find(|(path, _)| path == SUMMARY).unwrap().1;
    assert_eq!(summary["findings"][0]["effect"], "temperature_bias");
    for version in 1..=newest as i64 {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("gyrowatch.db");
        write_as_of(version, &file, &server.database()).await;
        let checked = gyrowatch().args(["restore", "--check"]).arg(&file).output().unwrap();
        assert!(checked.status.success(), "version {version}: {checked:?}");
        let mut upgraded = Server::start_under(&[], dir, &[]);
        // There were no alerts that say that the methods disagree.
        let kept = answers.iter().filter(|(path, _)| version >= 2 || path != "/v1/gyros");
        answers_as_before(&upgraded, kept, version, [13, 12, 15]).await;
        goes_on(&upgraded, version).await;
        let file = file_url(&upgraded.database());
        deflates(async |sql| {
            let mut connection = SqliteConnection::connect(&file).await.unwrap();
            sqlx::query_scalar(sql).fetch_one(&mut connection).await.unwrap()
        })
        .await;
        assert!(upgraded.terminate().0.success());
        let said = verified(&file_url(&upgraded.database()));
        assert!(said.contains("gyros compared in lists"), "version {version}: {said}");
    }
}

/// Makes an empty database of a server one as `version` left it, with what that version could hold of the database
/// `from`.
async fn write_server_as_of(version: i64, all: &Migrator, url: &str, from: &mut PgConnection) {
    let early = all.iter().filter(|migration| migration.version <= version).cloned().collect();
    let mut connection = PgConnection::connect(url).await.unwrap();
    Migrator::with_migrations(early).run(&mut connection).await.unwrap();
    // Rows come in any order of tables.
    sqlx::query("SET session_replication_role = replica").execute(&mut connection).await.unwrap();
    let tables = "SELECT CAST(table_name AS TEXT) FROM information_schema.tables
                  WHERE table_schema = 'public' AND table_type = 'BASE TABLE' AND table_name NOT LIKE '\\_sqlx%'";
    let newer: Vec<String> = sqlx::query_scalar(tables).fetch_all(&mut *from).await.unwrap();
    let own: Vec<String> = sqlx::query_scalar(tables).fetch_all(&mut connection).await.unwrap();
    for table in own.iter().filter(|table| newer.contains(table)) {
        // What a later version dropped may not be null before.
        let row = if table == "head" { "to_jsonb(t) || '{\"version\": 1}'" } else { "to_jsonb(t)" };
        let rows = AssertSqlSafe(format!("SELECT coalesce(CAST(jsonb_agg({row}) AS TEXT), '[]') FROM {table} AS t"));
        let rows: String = sqlx::query_scalar(rows).fetch_one(&mut *from).await.unwrap();
        let delete = AssertSqlSafe(format!("DELETE FROM {table}"));
        sqlx::query(delete).execute(&mut connection).await.unwrap();
        let put = format!(
            "INSERT INTO public.{table} SELECT * FROM jsonb_populate_recordset(NULL::public.{table}, CAST($1 AS JSONB))"
        );
        sqlx::query(AssertSqlSafe(put)).bind(rows).execute(&mut connection).await.unwrap();
    }
    for (table, key) in PACKED.into_iter().filter(|_| version < 16) {
        let sql = format!("SELECT {key}, packed FROM {table} WHERE packed IS NOT NULL");
        let packed: Vec<(i64, Vec<u8>)> = sqlx::query_as(AssertSqlSafe(sql)).fetch_all(&mut *from).await.unwrap();
        for (of, packed) in packed {
            let sql = format!("UPDATE {table} SET body = $1 WHERE {key} = $2");
            let put = sqlx::query(AssertSqlSafe(sql)).bind(inflated(&packed)).bind(of);
            put.execute(&mut connection).await.unwrap();
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_database_of_a_server_of_every_earlier_version_is_brought_up_to_date_with_all_that_is_in_it() {
    let Some(url) = cluster::database_if_there().await else { return };
    let (mut server, answers) = filled(&[("GYROWATCH_DATABASE_URL", &url)]).await;
    assert!(server.terminate().0.success());
    let migrations = root().join("migrations/postgres");
    let all = Migrator::new(migrations).await.unwrap();
    let mut from = PgConnection::connect(&url).await.unwrap();
    for version in all.iter().map(|migration| migration.version) {
        let url = cluster::fresh_database().await;
        write_server_as_of(version, &all, &url, &mut from).await;
        let upgraded = Server::start_with(&[("GYROWATCH_DATABASE_URL", &url)]).await;
        answers_as_before(&upgraded, answers.iter(), version, [5, 4, 7]).await;
        goes_on(&upgraded, version).await;
        deflates(async |sql| {
            let mut connection = PgConnection::connect(&url).await.unwrap();
            sqlx::query_scalar(sql).fetch_one(&mut connection).await.unwrap()
        })
        .await;
        let said = verified(&url);
        assert!(said.contains("gyros compared in lists"), "version {version}: {said}");
    }
}

/// Until version 11 nobody kept what a hook had heard, nor since when a gyro does what it does.
#[tokio::test]
async fn alerts_and_hooks_of_an_earlier_version_go_on_as_they_were_told() {
    let never_late = [NEVER_LATE];
    let target = receiver::Receiver::start().await;
    let mut server = Server::start_with(&never_late).await;
    let mut hooks = Vec::new();
    for path in ["told", "deaf"] {
        let url = format!("http://{}/{path}", target.address);
        let filter = if path == "deaf" { json!({ "gyros": ["B"] }) } else { json!({ "rules": ["baseline"] }) };
        let hook = json!({ "kind": "standard-webhooks", "url": url, "filter": filter, "batch": false });
        hooks.push(server.sets_up(hook).await);
    }
    let post = async |server: &Server, at: i64, d_i: f64| {
        let record = lab::record("IMU-1", &lab::day(at), &[("G1", "A", d_i, 2.0)]);
        assert_eq!(server.post_json("/v1/records", &record).await.status, 201);
    };
    for (at, d_i) in [(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.05)] {
        post(&server, at, d_i).await;
    }
    target.has_been_told(1).await;
    server.all_told(&hooks[0]).await;
    let path = format!("/v1/hooks/{}", id(&hooks[0]));
    assert!(server.terminate().0.success());
    let dir = tempfile::tempdir().unwrap();
    write_as_of(11, &dir.path().join("gyrowatch.db"), &server.database()).await;
    let upgraded = Server::start_under(&[], dir, &never_late);
    let alerts = upgraded.get("/v1/alerts?rule=baseline").await.json()["alerts"].clone();
    assert_eq!(alerts[0]["since"], alerts[0]["fired_at"], "the best that is known");
    assert_eq!(upgraded.get(&path).await.json()["batch"], false);
    let deliveries = upgraded.get(&format!("{path}/deliveries")).await.json()["deliveries"].clone();
    assert_eq!(json!([deliveries[0]["event"], deliveries[0]["attempts"][0]["answer"]]), json!(["alert.fired", null]));
    for at in [160, 200, 240] {
        post(&upgraded, at, 1.0).await;
    }
    let told = target.has_been_told(2).await;
    assert_eq!((told.len(), &told[1].json()["type"]), (2, &json!("alert.resolved")), "of what it had heard");
    assert!(told.iter().all(|told| told.path == "/told"));
}

/// Earlier versions stored sentences instead of codes with parameters.
#[tokio::test]
async fn prose_that_an_earlier_version_stored_is_shown_as_it_is() {
    const PROSE: &str = "D_I lies +0.05000 from its baseline 1.00000; the limit is 0.01000.";
    let never_late = [NEVER_LATE];
    let mut server = Server::start_with(&never_late).await;
    for (at, d_i) in [(0, 1.0), (40, 1.0), (80, 1.0), (120, 1.05)] {
        let record = lab::record("IMU-1", &lab::day(at), &[("G1", "A", d_i, 2.0)]);
        assert_eq!(server.post_json("/v1/records", &record).await.status, 201);
    }
    assert!(server.terminate().0.success());
    let mut connection = behind::open(&server.database()).await;
    for sql in [
        "UPDATE alert SET finding = json_set(finding, '$.reason', $1)",
        "UPDATE alert_step SET body = json_set(body, '$.reason', $1)",
    ] {
        assert!(sqlx::query(sql).bind(PROSE).execute(&mut connection).await.unwrap().rows_affected() > 0, "{sql}");
    }
    connection.close().await.unwrap();
    server.restart();
    for language in ["en", "zh"] {
        let get = async |path: &str| {
            let headers = [("accept-language", language)];
            let answer = server.call("GET", path, &headers, "").await;
            assert_eq!(answer.status, 200, "{path}: {}", answer.text());
            answer
        };
        let alerts = get("/v1/alerts?rule=baseline").await.json();
        let alert = &alerts["alerts"][0];
        assert_eq!((&alert["code"], &alert["reason"]), (&json!("verbatim"), &json!(PROSE)), "{language}");
        let page = get("/alerts?rule=baseline").await.text();
        assert_eq!(page.matches(PROSE).count(), 1, "{language}: {page}");
        get("/gyros/A").await;
    }
}

#[tokio::test]
async fn a_database_of_a_later_version_is_refused_and_left_alone() {
    let (mut server, _) = filled(&[]).await;
    assert!(server.terminate().0.success());
    let file = server.database();
    let mut connection = behind::open(&file).await;
    let later = "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
                 VALUES (9999, 'later', true, x'00', 1)";
    sqlx::query(later).execute(&mut connection).await.unwrap();
    connection.close().await.unwrap();
    let before = std::fs::read(&file).unwrap();
    let mut command = beside(server.dir());
    let (status, _, said) = ended(command.arg("serve").env("GYROWATCH_LISTEN", "127.0.0.1:0"));
    assert_eq!(status, 1, "{said}");
    assert!(said.contains("gyrowatch.db") && said.contains("9999"), "{said}");
    assert!(std::fs::read(&file).unwrap() == before, "it was written to");
}
