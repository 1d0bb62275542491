//! Where a record is found does not depend on whether it has been entered, and nothing of it is lost when the service
//! is killed.

use crate::core::id::Id;
use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sqlx::SqlitePool;
use tempfile::TempDir;

use crate::core::time::UtcMicros;
use crate::store;
use crate::store::tests::{first_names, name, opened, options, record, url};
use crate::store::*;

const IMUS: u32 = 40;
const COMMITS: usize = 40;
const RECORDS: usize = 1_000;

/// Records by IMU and instant: the one that counts, if any, and those that do not.
type Expected = BTreeMap<(u32, i64), (Option<Id>, Vec<Id>)>;

async fn pool(dir: &TempDir) -> SqlitePool {
    SqlitePool::connect(&url(dir)).await.unwrap()
}

fn of_imu(imu: u32, id: Id, at: i64) -> RecordRow {
    RecordRow { imu, ..record(id, at, "") }
}

/// New records, most of them newer than all others of their IMU; now and then one is withdrawn, and sometimes another
/// takes its place.
fn some_records(random: &mut ChaCha8Rng, writer: &mut Writer, expected: &mut Expected) -> Changes {
    let mut changes = Changes::default();
    let mut store = |writer: &mut Writer, imu, at, expected: &mut Expected| {
        let id = writer.next_id(UtcMicros(0));
        changes.records.push(of_imu(imu, id, at));
        expected.entry((imu, at)).or_default().0 = Some(id);
    };
    let mut withdrawn = Vec::new();
    if !expected.is_empty() && random.random_ratio(1, 2) {
        for _ in 0..3 {
            let chosen = random.random_range(0..expected.len());
            let (&(imu, at), found) = expected.iter_mut().nth(chosen).unwrap();
            let Some(id) = found.0.take() else { continue };
            found.1.push(id);
            withdrawn.push(id);
            if random.random() {
                store(writer, imu, at, expected);
            }
        }
    }
    for _ in 0..RECORDS {
        // A quarter of them are one IMU's, so that it has many.
        let imu = if random.random_ratio(1, 4) { 1 } else { random.random_range(1..=IMUS) };
        let newest = expected.range((imu, i64::MIN)..=(imu, i64::MAX)).next_back().map_or(0, |((_, at), _)| *at);
        let late = random.random_ratio(1, 2_000);
        let at = if late { random.random_range(0..=newest) } else { newest + random.random_range(1..5) };
        if !expected.contains_key(&(imu, at)) {
            store(writer, imu, at, expected);
        }
    }
    changes.withdrawn.records = withdrawn;
    changes
}

async fn check_found(store: &Store, expected: &Expected, random: &mut ChaCha8Rng) {
    let mut newest = BTreeMap::new();
    for imu in 1..=IMUS {
        let all: Vec<_> =
            expected.range((imu, i64::MIN)..=(imu, i64::MAX)).map(|((_, at), found)| (*at, found)).collect();
        newest.extend(all.last().map(|(at, _)| (imu, UtcMicros(*at))));
        let limit = random.random_range(1..700);
        let counting = all.iter().rev().filter_map(|(at, found)| Some((found.0?, UtcMicros(*at)))).take(limit);
        let heads = store::record::of_imu(store, imu, limit as u32).await.unwrap();
        let heads: Vec<_> = heads.iter().map(|head| (head.id, head.calibrated_at)).collect();
        assert_eq!(heads, counting.collect::<Vec<_>>());
        for _ in 0..20 {
            let at = random.random_range(0..=all.last().map_or(9, |(at, _)| at + 1));
            let found = store::record::at(store, imu, UtcMicros(at)).await.unwrap();
            let (counts, mut not) = expected.get(&(imu, at)).cloned().unwrap_or_default();
            not.sort();
            let there: Vec<_> = found.iter().map(|found| (found.id, found.voided)).collect();
            let wanted: Vec<_> =
                counts.map(|id| (id, false)).into_iter().chain(not.iter().map(|id| (*id, true))).collect();
            assert_eq!(there, wanted);
        }
    }
    for imu in 1..=IMUS {
        assert_eq!(store::record::newest_of_imu(store, imu).await.unwrap(), newest.get(&imu).copied());
    }
}

#[tokio::test]
async fn every_record_of_an_imu_is_found_whether_it_is_entered_or_waits_and_after_a_kill() {
    let dir = TempDir::new().unwrap();
    let (mut random, mut expected) = (ChaCha8Rng::seed_from_u64(11), Expected::new());
    let (mut store, mut writer) = opened(&dir).await;
    let imus = (1..=IMUS).map(|k| name(k, &format!("IMU-{k}"))).collect();
    writer.commit(&Changes { imus, ..first_names() }).await.unwrap();
    for commit in 0..COMMITS {
        let changes = some_records(&mut random, &mut writer, &mut expected);
        writer.commit(&changes).await.unwrap();
        if commit % 10 == 4 {
            // Dropped as a kill would: nothing is written when it ends.
            drop((store, writer));
            (store, writer) = opened(&dir).await;
        }
        if commit % 5 == 4 {
            check_found(&store, &expected, &mut random).await;
        }
    }
    let sql = "SELECT count(*), (SELECT count(*) FROM record), (SELECT count(*) FROM record
                   WHERE id < (SELECT record FROM calendar_begun)) FROM calendar";
    let (entered, records, before): (i64, i64, i64) = sqlx::query_as(sql).fetch_one(&pool(&dir).await).await.unwrap();
    assert!(entered > records / 3, "{entered} of {records} are entered");
    assert!(before > 1_000, "{before} of {records} need not be read again");
    check_all_but_records(&options(&url(&dir))).await.unwrap();
}

#[tokio::test]
async fn a_second_record_of_an_imu_and_instant_is_refused_wherever_the_first_stands() {
    let dir = TempDir::new().unwrap();
    let (store, mut writer) = opened(&dir).await;
    let ids: Vec<Id> = (0..5).map(|_| writer.next_id(UtcMicros(0))).collect();
    let of = |id: Id, at| Changes { records: vec![of_imu(1, id, at)], ..Changes::default() };
    writer.commit(&Changes { records: vec![of_imu(1, ids[0], 20)], ..first_names() }).await.unwrap();
    for entered in [false, true] {
        assert_eq!(store.write_behind.index.read().at(1, UtcMicros(20)).is_none(), entered);
        assert!(matches!(writer.commit(&of(ids[1], 20)).await, Err(StoreError::Refused(_))));
        assert_eq!(store::record::get(&store, ids[1]).await.unwrap(), None);
        let there: Vec<Id> =
            store::record::at(&store, 1, UtcMicros(20)).await.unwrap().iter().map(|found| found.id).collect();
        assert_eq!(there, [ids[0]]);
        // A late one, before which all that waits is entered.
        let late = 10 - i64::from(entered);
        writer.commit(&of(ids[2 + usize::from(entered)], late)).await.unwrap();
    }
    writer.commit(&of(ids[4], 30)).await.unwrap();
    assert!(store.write_behind.index.read().at(1, UtcMicros(30)).is_some());
    let all: Vec<Id> = store::record::of_imu(&store, 1, 9).await.unwrap().iter().map(|head| head.id).collect();
    assert_eq!(all, [ids[4], ids[0], ids[2], ids[3]]);
}

async fn begun(dir: &TempDir) -> i64 {
    sqlx::query_scalar("SELECT record FROM calendar_begun").fetch_one(&pool(dir).await).await.unwrap()
}

#[tokio::test]
async fn an_archive_of_late_records_is_not_read_again_at_every_start() {
    let dir = TempDir::new().unwrap();
    let (store, mut writer) = opened(&dir).await;
    let first = writer.next_id(UtcMicros(0));
    let names = Changes { imus: vec![name(1, "A"), name(2, "B")], ..first_names() };
    writer.commit(&Changes { records: vec![of_imu(1, first, 1_000_000)], ..names }).await.unwrap();
    let mut archive =
        |count: i64| -> Vec<RecordRow> { (0..count).map(|at| of_imu(1, writer.next_id(UtcMicros(0)), at)).collect() };
    let late = archive(50);
    let last = late.last().unwrap().id;
    writer.commit(&Changes { records: late, ..Changes::default() }).await.unwrap();
    assert_eq!(begun(&dir).await, last.0 + 1, "nothing waits");

    // One of another IMU waits while what comes is entered at once: not for ever, even over a start.
    let waits = writer.next_id(UtcMicros(0));
    writer.commit(&Changes { records: vec![of_imu(2, waits, 1)], ..Changes::default() }).await.unwrap();
    let count = crate::store::sqlite::write_behind::queues::LATER as i64 / 2 + 100;
    for part in 0..2 {
        let late = (0..count).map(|k| of_imu(1, writer.next_id(UtcMicros(0)), 100 + part * count + k)).collect();
        writer.commit(&Changes { records: late, ..Changes::default() }).await.unwrap();
        if part == 0 {
            drop((store.clone(), writer));
            writer = opened(&dir).await.1;
        }
    }
    let id = writer.next_id(UtcMicros(0));
    writer.commit(&Changes { records: vec![of_imu(1, id, 99)], ..Changes::default() }).await.unwrap();
    assert_eq!(begun(&dir).await, id.0 + 1);
}

#[tokio::test]
async fn an_entry_that_is_not_the_records_own_is_found_out() {
    let dir = TempDir::new().unwrap();
    let (store, mut writer) = opened(&dir).await;
    let ids: Vec<Id> = (0..3).map(|_| writer.next_id(UtcMicros(0))).collect();
    let records = vec![of_imu(1, ids[0], 20), of_imu(1, ids[1], 10)];
    writer.commit(&Changes { records, ..first_names() }).await.unwrap();
    writer.commit(&Changes { records: vec![of_imu(1, ids[2], 5)], ..Changes::default() }).await.unwrap();
    check_all_but_records(&options(&url(&dir))).await.unwrap();
    let pool = pool(&dir).await;
    for damage in [
        "DELETE FROM calendar WHERE calibrated_at = 10",
        "UPDATE calendar SET record = (SELECT max(record) FROM calendar) WHERE calibrated_at = 10",
        "UPDATE calendar SET voided = 1 WHERE calibrated_at = 10",
        "UPDATE calendar SET calibrated_at = 11 WHERE calibrated_at = 10",
        "INSERT INTO calendar VALUES (1, 17, 0, 5)",
        "INSERT INTO record SELECT id + 1000, kind, imu, station, calibrated_at, received_at, body, body_sha256, verdicts, voided, notes, sent_by,
                 temperature_c, packed FROM record WHERE calibrated_at = 10",
    ] {
        let copy = TempDir::new().unwrap();
        let into = copy.path().join("test.db");
        sqlx::query("VACUUM INTO $1").bind(into.to_str().unwrap()).execute(&pool).await.unwrap();
        let damaged = self::pool(&copy).await;
        sqlx::query("UPDATE calendar_begun SET record = 9223372036854775807").execute(&damaged).await.unwrap();
        sqlx::query(damage).execute(&damaged).await.unwrap();
        damaged.close().await;
        let found = check_all_but_records(&options(&url(&copy))).await;
        assert!(matches!(found, Err(StoreError::Damaged(_))), "{damage}: {found:?}");
    }
    sqlx::query("UPDATE calendar SET record = $1").bind(ids[2].0).execute(&pool).await.unwrap();
    assert!(matches!(store::record::at(&store, 1, UtcMicros(20)).await, Err(StoreError::Damaged(_))));
}
