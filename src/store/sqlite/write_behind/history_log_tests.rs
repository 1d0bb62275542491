//! What readers see does not depend on what has been folded, and nothing of it is lost when the service is killed.

use crate::core::figures::Figures;
use crate::core::id::Id;
use crate::core::time::{Span, UtcMicros};
use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sqlx::SqlitePool;
use tempfile::TempDir;

use crate::store;
use crate::store::tests::{first_names, history, name, opened, options, record, url};
use crate::store::*;

const GYROS: u32 = 60;
const COMMITS: usize = 30;
const ROWS: usize = 1_500;

/// What was committed, by gyro and instant.
type Expected = BTreeMap<(u32, i64), Figures>;

fn names() -> Changes {
    Changes { gyros: (1..=GYROS).map(|k| name(k, &format!("LFG-{k:02}"))).collect(), ..first_names() }
}

/// New rows at any instants, some of which are there already and are judged again.
fn some_rows(random: &mut ChaCha8Rng, record: Id, expected: &mut Expected) -> Changes {
    let mut group: BTreeMap<(u32, i64), Figures> = BTreeMap::new();
    for _ in 0..ROWS {
        let (gyro, at) = (random.random_range(1..=GYROS), random.random_range(0..20_000));
        let mut figures = history(record, gyro, at, random.random()).figures;
        figures.voided = random.random_ratio(1, 6);
        group.insert((gyro, at), figures);
    }
    let mut changes = Changes::default();
    for (key, figures) in group {
        let row = HistoryRow { gyro: key.0, figures };
        match expected.insert(key, figures) {
            None => changes.history.push(row),
            Some(_) => changes.rejudged.history.push(row),
        }
    }
    changes
}

async fn counts(dir: &TempDir) -> (i64, i64) {
    let pool = SqlitePool::connect(&url(dir)).await.unwrap();
    let sql = "SELECT (SELECT count(*) FROM history), (SELECT count(*) FROM history_log)";
    sqlx::query_as(sql).fetch_one(&pool).await.unwrap()
}

async fn check(store: &Store, expected: &Expected, random: &mut ChaCha8Rng) {
    let (mut newest, mut stretches, mut oldest_of_many, mut newest_of_many) = (vec![], vec![], vec![], vec![]);
    let at_once = random.random_range(1..30);
    for gyro in 1..=GYROS {
        let of_gyro = expected.range((gyro, 0)..=(gyro, i64::MAX)).map(|(_, row)| *row);
        let all: Vec<Figures> = of_gyro.filter(|row| !row.voided).collect();
        assert_eq!(store::history::oldest(store, gyro, Span::EVER, usize::MAX).await.unwrap(), all);
        assert_eq!(store::history::count(store, gyro).await.unwrap(), all.len());
        let (a, b) = (random.random_range(0..20_000), random.random_range(0..20_000));
        let (from, to) = (a.min(b), a.max(b));
        let limit = random.random_range(1..300);
        let span = Span { from: UtcMicros(from), to: UtcMicros(to) };
        let within: Vec<Figures> = all.iter().filter(|row| (from..=to).contains(&row.at.0)).copied().collect();
        assert_eq!(store::history::oldest(store, gyro, span, limit).await.unwrap(), within[..limit.min(within.len())]);
        let skipped = within.len().saturating_sub(limit);
        assert_eq!(store::history::newest(store, gyro, span, limit).await.unwrap(), within[skipped..]);
        newest.push((gyro, all.last().copied()));
        stretches.push((gyro, span));
        oldest_of_many.push(within[..at_once.min(within.len())].to_vec());
        newest_of_many.push(within[within.len().saturating_sub(at_once)..].to_vec());
    }
    assert_eq!(store::histories::oldest(store, &stretches, at_once).await.unwrap(), oldest_of_many);
    assert_eq!(store::histories::newest(store, &stretches, at_once).await.unwrap(), newest_of_many);
    let ever: Vec<Stretch> = (1..=GYROS).map(|gyro| (gyro, Span::EVER)).collect();
    let last: Vec<Option<Figures>> =
        store::histories::newest(store, &ever, 1).await.unwrap().iter().map(|rows| rows.last().copied()).collect();
    assert_eq!(last, newest.iter().map(|(_, row)| *row).collect::<Vec<_>>());
}

#[tokio::test]
async fn readers_see_every_row_once_whether_it_is_folded_or_waits_and_after_a_kill() {
    let dir = TempDir::new().unwrap();
    let (mut random, mut expected) = (ChaCha8Rng::seed_from_u64(20), Expected::new());
    let (mut store, mut writer) = opened(&dir).await;
    let id = writer.next_id(UtcMicros(1));
    writer.commit(&Changes { records: vec![record(id, 1, "")], ..names() }).await.unwrap();
    for commit in 0..COMMITS {
        writer.commit(&some_rows(&mut random, id, &mut expected)).await.unwrap();
        if commit % 10 == 4 {
            // Dropped as a kill would: nothing is written when it ends.
            drop((store, writer));
            (store, writer) = opened(&dir).await;
        }
        if commit % 5 == 4 {
            check(&store, &expected, &mut random).await;
        }
    }
    let (folded, entries) = counts(&dir).await;
    assert!(folded > 5_000, "{folded} rows are in their places");
    assert!(entries < COMMITS as i64, "{entries} entries of the log are left");
}

#[tokio::test]
async fn a_row_of_the_log_that_was_altered_is_found_out_at_the_start() {
    let dir = TempDir::new().unwrap();
    let (_store, mut writer) = opened(&dir).await;
    let id = writer.next_id(UtcMicros(1));
    let (records, rows) = (vec![record(id, 1, "")], vec![history(id, 1, 7, 2.9)]);
    writer.commit(&Changes { records, history: rows, ..names() }).await.unwrap();
    drop((_store, writer));
    let pool = SqlitePool::connect(&url(&dir)).await.unwrap();
    for damage in ["CAST(substr(rows, 1, 40) || x'ff' || substr(rows, 42) AS BLOB)", "substr(rows, 1, 100)"] {
        let sql = format!("UPDATE history_log SET rows = {damage}");
        sqlx::query(sqlx::AssertSqlSafe(sql)).execute(&pool).await.unwrap();
        assert!(matches!(open(&options(&url(&dir))).await, Err(StoreError::Damaged(_))));
    }
}
