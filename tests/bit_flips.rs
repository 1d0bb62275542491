//! Single bits flipped in databases: `restore --check` of a backup and `verify` of the service's own file find them.
//!
//! A flip counts where SQLite uses the byte: what is free within a page, and pages that are free, say nothing. Which
//! bytes are used is read from the file itself, by its format (sqlite.org/fileformat2.html).

use std::ops::Range;

use crate::command::{self, on_database, verified};
use crate::prelude::*;
use crate::support::{SUMMARY, asked, file_url, seed};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Everything that the service keeps is in it.
async fn a_service_with_everything() -> Server {
    let mut server = Server::start().await;
    let hook = json!({ "kind": "standard-webhooks", "url": "http://127.0.0.1:9/hook", "authorization": "Bearer t" });
    assert_eq!(server.post_json("/v1/hooks", &hook).await.status, 201);
    let lines: String = (0..60).map(|k| format!("{}\n", paper_record(k % 3, 1440 * k))).collect();
    assert_eq!(server.post("/v1/import", "application/x-ndjson", lines).await.status, 200);
    // A step, which fires and is told, in vain; then a record that is voided, and one that comes late.
    let mut step = paper_record(0, 1440 * 70);
    step["gyros"][0]["g_pulse_per_s_g0"][1] = 0.9.into();
    let stored = server.post("/v1/import?notify=all", "application/x-ndjson", step.to_string()).await.text();
    assert!(stored.contains("\"status\":201"), "{stored}");
    let again = server.post_json("/v1/records", &paper_record(1, 1440 * 71)).await.json();
    let void = format!("/v1/records/{}/void", again["id"].as_str().unwrap());
    let said = json!({ "reason": "another table", "author": "Li Wei" });
    let voided = server.post_json(&void, &said).await;
    assert!(voided.status < 300, "{void}: {}", voided.text());
    assert_eq!(server.post_json("/v1/records", &paper_record(2, 30)).await.status, 201);
    let event = json!({ "event": "repair", "reason": "new motor", "at": "2001-10-20T00:00:00Z" });
    assert_eq!(server.post_json("/v1/gyros/G-0-0/events", &event).await.status, 201);
    assert_eq!(server.post("/v1/import", "application/x-ndjson", data("paper-bench.ndjson")).await.status, 200);
    for campaign in ["practice/campaign-00.json", "practice/campaign-02.json"] {
        assert_eq!(server.post("/v1/campaigns", "application/json", data(campaign)).await.status, 201);
    }
    server.settled(SUMMARY).await;
    let is_tried =
        |holdings: &Vec<(String, i64)>| holdings.iter().any(|(name, n)| name == "delivery_attempt" && *n > 0);
    once(async || server.holdings().await, is_tried).await;
    assert!(server.terminate().0.success());
    for table in
        ["record", "history", "voided_history", "event", "bench_result", "alert", "alert_step", "hook", "delivery"]
            .into_iter()
            .chain(["delivery_attempt", "diagnosis", "diagnosis_gist", "correction", "audit"])
    {
        let rows = server.holdings().await.into_iter().find(|(name, _)| name == table).map(|(_, rows)| rows);
        assert!(table == "history" || rows > Some(0), "{table} is empty");
    }
    server
}

/// A big-endian number, as the file has all of them.
fn number(file: &[u8], at: usize, bytes: usize) -> usize {
    file[at..at + bytes].iter().fold(0, |number, byte| number << 8 | usize::from(*byte))
}

/// A number of variable length, and how many bytes it has.
fn variable(file: &[u8], at: usize) -> (usize, usize) {
    let mut value = 0;
    for (k, byte) in file[at..at + 9].iter().enumerate() {
        if k == 8 {
            return (value << 8 | usize::from(*byte), 9);
        }
        value = value << 7 | usize::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            return (value, k + 1);
        }
    }
    unreachable!("nine bytes at the most")
}

/// The bytes that the tree whose root is `page` uses.
fn used_by_tree(file: &[u8], page: usize, used: &mut Vec<Range<usize>>) {
    let size = match number(file, 16, 2) {
        1 => 65_536,
        size => size,
    };
    let usable = size - usize::from(file[20]);
    let start = (page - 1) * size;
    let head = start + if page == 1 { 100 } else { 0 };
    let kind = file[head];
    let (inner, of_table) = (matches!(kind, 2 | 5), matches!(kind, 5 | 13));
    assert!(matches!(kind, 2 | 5 | 10 | 13), "page {page} is no page of a tree: {kind}");
    let (cells, pointers) = (number(file, head + 3, 2), head + if inner { 12 } else { 8 });
    used.push(start..pointers + 2 * cells);
    for cell in 0..cells {
        let begin = start + number(file, pointers + 2 * cell, 2);
        let mut at = begin;
        if inner {
            used_by_tree(file, number(file, at, 4), used);
            at += 4;
        }
        let (payload, length) = variable(file, at);
        at += length;
        if inner && of_table {
            used.push(begin..at);
            continue;
        }
        if of_table {
            at += variable(file, at).1;
        }
        let least = (usable - 12) * 32 / 255 - 23;
        let most = if of_table { usable - 35 } else { (usable - 12) * 64 / 255 - 23 };
        let local = if payload <= most {
            payload
        } else {
            let fitting = least + (payload - least) % (usable - 4);
            if fitting <= most { fitting } else { least }
        };
        at += local;
        let mut rest = payload - local;
        used.push(begin..at + if rest > 0 { 4 } else { 0 });
        let mut next = if rest > 0 { number(file, at, 4) } else { 0 };
        while rest > 0 {
            let overflow = (next - 1) * size;
            let here = rest.min(usable - 4);
            used.push(overflow..overflow + 4 + here);
            next = number(file, overflow, 4);
            rest -= here;
        }
    }
    if inner {
        used_by_tree(file, number(file, head + 8, 4), used);
    }
}

/// The bytes that a database uses.
async fn used(path: &Path) -> Vec<Range<usize>> {
    let mut connection = behind::read(path).await;
    let roots: Vec<u32> = sqlx::query_scalar("SELECT rootpage FROM sqlite_schema WHERE rootpage > 0")
        .fetch_all(&mut connection)
        .await
        .unwrap();
    let file = std::fs::read(path).unwrap();
    let mut used = Vec::new();
    for root in roots.into_iter().map(|root| root as usize).chain([1]) {
        used_by_tree(&file, root, &mut used);
    }
    used
}

/// Flips one used bit of `whole` at a time, and says how many of them `finds` has found.
async fn found(whole: &Path, damaged: &Path, flips: usize, first: usize, finds: impl Fn() -> bool) -> usize {
    use rand::RngExt;
    let (used, bytes) = (used(whole).await, std::fs::read(whole).unwrap());
    let total: usize = used.iter().map(Range::len).sum();
    let mut found = 0;
    for flip in 0..flips {
        let mut random = ChaCha8Rng::seed_from_u64(seed(first + flip));
        let mut place = random.random_range(0..total);
        let range = used.iter().find(|range| {
            let here = place < range.len();
            place -= if here { 0 } else { range.len() };
            here
        });
        let at = range.unwrap().start + place;
        let mut changed = bytes.clone();
        changed[at] ^= 1 << random.random_range(0..8);
        std::fs::write(damaged, changed).unwrap();
        if finds() {
            found += 1;
        } else {
            println!("not found: byte {} of page {} (seed {})", at % 4096, at / 4096 + 1, seed(first + flip));
        }
    }
    println!("{found} of {flips} flipped bits found by {} ({total} bytes in use)", whole.display());
    found
}

/// `GYROWATCH_SOAK_FLIPS` for more (`scripts/soak flips`).
#[tokio::test]
async fn a_flipped_bit_in_a_backup_or_in_the_services_own_file_is_found() {
    let server = a_service_with_everything().await;
    let flips = asked("GYROWATCH_SOAK_FLIPS", 60);
    let own = server.database();
    let run = |arguments: &[&str], database: &Path| {
        let output = command::on(&file_url(database)).args(arguments).current_dir(server.dir()).output().unwrap();
        assert!(output.status.code().is_some(), "{arguments:?}: {output:?}");
        output.status.success()
    };
    assert!(run(&["backup", "backup.db"], &own));
    let (backup, damaged) = (server.dir().join("backup.db"), server.dir().join("damaged.db"));
    assert!(run(&["restore", "--check", "backup.db"], &own) && run(&["verify"], &own), "whole");
    let of_backup = found(&backup, &damaged, flips, 0, || !run(&["restore", "--check", "damaged.db"], &own)).await;
    let of_own = found(&own, &damaged, flips, flips, || !run(&["verify"], &damaged)).await;
    // 99 in 100 (1,399 of 1,400 were found): of 60 one may be missed.
    for found in [of_backup, of_own] {
        assert!(flips - found <= (flips / 100).max(1), "{found} of {flips}");
    }
}

/// What the checksums alone find: each of these fits the structure, and no other check reads it.
#[tokio::test]
async fn a_change_of_any_table_is_named_and_the_service_keeps_its_own() {
    let server = a_service_with_everything().await;
    let own = server.database();
    let whole = std::fs::read(&own).unwrap();
    let verify = || on_database(&["verify"], server.dir());
    for (table, change) in [
        ("alert", "UPDATE alert SET fired_at = fired_at + 1 WHERE id = (SELECT min(id) FROM alert)"),
        ("alert_step", "UPDATE alert_step SET body = replace(body, 'warning', 'varning')"),
        ("audit", "DROP TRIGGER audit_is_not_deleted; DELETE FROM audit"),
        ("correction", "UPDATE correction SET author = 'Li Wai'"),
        ("delivery_attempt", "DELETE FROM delivery_attempt"),
        ("diagnosis", "UPDATE diagnosis SET packed = zeroblob(9)"),
        ("diagnosis_gist", "UPDATE diagnosis_gist SET program = program || 'x'"),
        ("event", "UPDATE event SET reason = 'old motor'"),
        ("head", "UPDATE head SET d_i = d_i + 1"),
        ("hook", "UPDATE hook SET url = 'http://127.0.0.1:8/hook'"),
        ("record", "UPDATE record SET received_at = received_at + 1"),
        ("sqlite_schema", "DROP INDEX delivery_dead"),
        ("_sqlx_migrations", "UPDATE _sqlx_migrations SET description = 'other' WHERE version = 3"),
        ("checksum", "DELETE FROM checksum WHERE name = 'alert'"),
    ] {
        behind::execute(&own, change).await;
        let (status, said) = verify();
        assert!(status != Some(0) && said.contains(table), "{change}: {said}");
        std::fs::write(&own, &whole).unwrap();
    }
    let (status, said) = verify();
    assert_eq!(status, Some(0), "{said}");
}

/// Checksums follow every kind of change, an interrupted one, and a change by another process.
#[tokio::test]
async fn the_checksums_hold_while_the_service_writes_and_after_it_was_killed() {
    let mut server = a_service_with_everything().await;
    let url = file_url(&server.database());
    server.restart();
    let alerts = server.get("/v1/alerts").await.json();
    let alert = alerts["alerts"][0]["id"].as_str().unwrap();
    let remark = json!({ "by": "Li Wei", "reason": "known" });
    assert!(server.post_json(&format!("/v1/alerts/{alert}/acknowledge"), &remark).await.status < 300);
    let hook = server.get("/v1/hooks").await.json()["hooks"][0]["id"].as_str().unwrap().to_owned();
    let patch = json!({ "enabled": false, "name": "x" }).to_string();
    let json_type = [("content-type", "application/json")];
    assert_eq!(server.call("PATCH", &format!("/v1/hooks/{hook}"), &json_type, patch).await.status, 200);
    for k in 0..40 {
        assert_eq!(server.post_json("/v1/records", &paper_record(4, 1440 * k)).await.status, 201);
    }
    verified(&url);
    let (status, said) = on_database(&["token", "create", "a", "--role", "admin"], server.dir());
    assert_eq!(status, Some(0), "{said}");
    verified(&url);
    server.kill();
    verified(&url);
    server.restart();
    assert!(server.terminate().0.success());
    verified(&url);
}
