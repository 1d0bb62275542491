use crate::core::figures::{Figures, States};
use crate::core::gyro_event::GyroEvent;
use crate::core::id::Id;
use crate::core::kind::Kind;
use crate::core::time::{Span, UtcMicros};
use crate::store;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use super::db::Readers;
use super::*;
use crate::core::bench::{BenchItem, BenchMethod};
use crate::core::judge::{Coefficient, Event, Measured, Rule, State};
use crate::core::mounting::Slot;

pub(super) async fn opened(dir: &TempDir) -> (Store, Writer) {
    open(&options(&url(dir))).await.unwrap()
}

pub(super) fn url(dir: &TempDir) -> String {
    format!("sqlite://{}", dir.path().join("test.db").display())
}

pub(super) fn options(url: &str) -> Options {
    Options {
        url: url.to_owned(),
        readers: 2,
        busy_timeout: Duration::from_secs(1),
        cache_kib: 1024,
        checkpoint_pages: 100,
        lease: Duration::from_secs(15),
    }
}

pub(super) fn record(id: Id, at: i64, note: &str) -> RecordRow {
    let verdict = StoredVerdict {
        coefficient: Coefficient::DI,
        rule: Rule::Step,
        state: State::Within,
        value: Some(0.002),
        limit: 0.01,
        sd: None,
        probability: None,
        confirmed: false,
    };
    RecordRow {
        id,
        kind: Kind::Record,
        imu: 1,
        station: 1,
        calibrated_at: UtcMicros(at),
        received_at: UtcMicros(at + 5),
        body: format!("{{\"note\": \"{note}\"}}").into(),
        body_sha256: [7; 32],
        verdicts: RecordVerdicts(vec![(1, vec![verdict])]),
        voided: false,
        notes: None,
        sent_by: None,
        temperature_c: None,
    }
}

/// Commits `count` records one by one, at 0, 1 and so on.
async fn write(writer: &mut Writer, count: i64, note: &str) {
    for at in 0..count {
        let id = writer.next_id(UtcMicros(0));
        writer.commit(&Changes { records: vec![record(id, at, note)], ..Changes::default() }).await.unwrap();
    }
}

pub(super) fn history(record: Id, gyro: u32, at: i64, d_i: f64) -> HistoryRow {
    let figures = Figures {
        at: UtcMicros(at),
        record,
        imu: 1,
        station: 1,
        slot: Slot::G1,
        rigid: [d_i, 4.6, 0.07],
        rigid_sd: None,
        published: None,
        states: States::default(),
        voided: false,
    };
    HistoryRow { gyro, figures }
}

pub(super) fn name(number: u32, name: &str) -> NewName {
    NewName { number, cell: 0, name: name.to_owned() }
}

pub(super) fn first_names() -> Changes {
    Changes {
        imus: vec![name(1, "IMU-07")],
        stations: vec![name(1, "站-2 'quoted'")],
        gyros: vec![name(1, "LFG-0101"), name(2, "LFG-0102")],
        ..Changes::default()
    }
}

#[tokio::test]
async fn what_is_committed_is_read_back_and_survives_reopening() {
    let dir = TempDir::new().unwrap();
    let (store, mut writer) = opened(&dir).await;
    let ids = [writer.next_id(UtcMicros(1_000_000)), writer.next_id(UtcMicros(1_000_000))];
    let bench = BenchItem {
        id: writer.next_id(UtcMicros(0)),
        gyro: 2,
        station: 1,
        measured_at: UtcMicros(-3),
        method: BenchMethod::TorqueFeedback,
        d: [4.193101, -0.1 - 0.2],
        sd: [Some(3e-4), None],
        voided: false,
        received_at: UtcMicros(9),
        body: "{\"é\": \"\\u0000\"}".into(),
        body_sha256: [9; 32],
        sent_by: Some(Id(77)),
    };
    let event = EventRow {
        id: writer.next_id(UtcMicros(0)),
        gyro: 2,
        told: GyroEvent {
            at: UtcMicros(44),
            event: Event::Baseline,
            until: Some(UtcMicros(47)),
            test: Some("vibration".into()),
            fixed: [Some(Measured { value: 2.95, sd: Some(1e-4) }), None],
            reason: "bearing".into(),
            author: None,
        },
        received_at: UtcMicros(50),
    };
    let key = KeyRow { key: "k-1".into(), item: ids[0], body_sha256: [7; 32] };
    let records = vec![record(ids[0], 200, "b"), record(ids[1], 100, "a")];
    let rows = vec![history(ids[0], 1, 200, 2.0), history(ids[1], 1, 100, 1.0), history(ids[0], 2, 200, 3.0)];
    let changes = Changes {
        records: records.clone(),
        history: rows.clone(),
        benches: vec![bench.clone()],
        events: vec![event.clone()],
        keys: vec![key],
        ..first_names()
    };
    writer.commit(&changes).await.unwrap();
    store.close().await;
    writer.close().await.unwrap();

    let (store, mut writer) = opened(&dir).await;
    assert!(writer.next_id(UtcMicros(0)) > event.id, "identifiers go on where they were");
    assert_eq!(store.names().read().stations.name(1).unwrap(), "站-2 'quoted'");
    assert_eq!(store::record::get(&store, ids[1]).await.unwrap().unwrap(), records[1]);
    assert_eq!(store::record::get(&store, Id(1)).await.unwrap(), None);
    let of_1 = store::history::oldest(&store, 1, Span::EVER, 10).await.unwrap();
    assert_eq!(of_1, [rows[1].figures, rows[0].figures]);
    assert_eq!(store::history::newest(&store, 1, Span::EVER, 1).await.unwrap(), [rows[0].figures]);
    let early = Span { from: UtcMicros(0), to: UtcMicros(199) };
    assert_eq!(store::history::oldest(&store, 1, early, 10).await.unwrap(), [rows[1].figures]);
    assert_eq!(store::history::oldest(&store, 77, Span::EVER, 10).await.unwrap(), []);
    let ever = [(1, Span::EVER), (2, Span::EVER)];
    assert_eq!(store::histories::newest(&store, &ever, 1).await.unwrap(), [[rows[0].figures], [rows[2].figures]]);
    assert_eq!(store::bench::of_gyro(&store, 2, Span::EVER).await.unwrap(), [bench]);
    assert_eq!(store::event::of_gyro(&store, 2).await.unwrap(), [event]);
    assert_eq!(store::keys::get(&store, "k-1").await.unwrap(), Some((ids[0], vec![7; 32])));
    let there = RecordAt { id: ids[1], hash: vec![7; 32], voided: false };
    assert_eq!(store::record::at(&store, 1, UtcMicros(100)).await.unwrap(), [there]);
    assert_eq!(store::record::newest_of_imu(&store, 1).await.unwrap(), Some(UtcMicros(200)));
}

#[tokio::test]
async fn a_group_with_one_row_that_is_refused_leaves_nothing() {
    let dir = TempDir::new().unwrap();
    let (store, mut writer) = opened(&dir).await;
    let (first, second) = (writer.next_id(UtcMicros(0)), writer.next_id(UtcMicros(0)));
    let twice = Changes { records: vec![record(first, 5, "a"), record(second, 5, "b")], ..first_names() };
    assert!(matches!(writer.commit(&twice).await, Err(StoreError::Refused(_))));
    assert_eq!(store::record::get(&store, first).await.unwrap(), None);
    assert_eq!(store.names().read().gyros.len(), 0);

    let good = Changes { records: vec![record(first, 5, "a")], ..first_names() };
    writer.commit(&good).await.unwrap();
    assert!(store::record::get(&store, first).await.unwrap().is_some());
}

#[tokio::test]
async fn judging_again_changes_states_and_verdicts_and_nothing_else() {
    let dir = TempDir::new().unwrap();
    let (store, mut writer) = opened(&dir).await;
    let id = writer.next_id(UtcMicros(0));
    let row = history(id, 1, 5, 2.0);
    writer
        .commit(&Changes { records: vec![record(id, 5, "a")], history: vec![row.clone()], ..first_names() })
        .await
        .unwrap();
    let mut sheet = store::record::verdicts_to_rejudge(&store, id).await.unwrap().unwrap();
    assert!(sheet.sheet.replace(1, vec![]));
    assert!(!sheet.sheet.replace(2, vec![]));
    let mut anew = row.clone();
    anew.figures.states = States([Some(State::Exceeded), None, None]);
    let rejudged = changes::Rejudged {
        history: vec![anew.clone()],
        sheets: vec![(id, sheet.clone())],
        ..changes::Rejudged::default()
    };
    writer.commit(&Changes { rejudged, ..Changes::default() }).await.unwrap();
    assert_eq!(store::history::oldest(&store, 1, Span::EVER, 9).await.unwrap(), [anew.figures]);
    let stored = store::record::get(&store, id).await.unwrap().unwrap();
    assert_eq!((stored.verdicts, stored.body), (sheet.sheet, record(id, 5, "a").body));
}

#[tokio::test]
async fn the_log_is_copied_and_begun_anew_under_steady_writing() {
    let dir = TempDir::new().unwrap();
    let (_store, mut writer) = opened(&dir).await;
    writer.commit(&first_names()).await.unwrap();
    write(&mut writer, 2_000, &"x".repeat(20_000)).await;
    let log = std::fs::metadata(dir.path().join("test.db-wal")).unwrap().len();
    assert!(log < 20_000_000, "the log has grown to {log} bytes of 40,000,000 written");
}

#[tokio::test]
async fn a_stop_empties_the_log_though_it_was_just_being_copied() {
    let dir = TempDir::new().unwrap();
    let (store, mut writer) = opened(&dir).await;
    writer.commit(&first_names()).await.unwrap();
    write(&mut writer, 20, &"x".repeat(400_000)).await;
    store.close().await;
    writer.close().await.unwrap();
    assert!(!dir.path().join("test.db-wal").exists());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_database_in_memory_is_written_when_who_reads_has_done() {
    let (store, mut writer) = open(&options("sqlite::memory:")).await.unwrap();
    writer.commit(&first_names()).await.unwrap();
    let Readers::Sqlite(readers, _) = &store.readers else { unreachable!("it is SQLite's") };
    let mut reading = readers.begin().await.unwrap();
    let count: i64 = sqlx::query_scalar("SELECT count(*) FROM record").fetch_one(&mut *reading).await.unwrap();
    assert_eq!(count, 0);
    let (begun, long) = (Instant::now(), Duration::from_millis(200));
    let reader = tokio::spawn(async move {
        tokio::time::sleep(long).await;
        reading.commit().await.unwrap();
    });
    write(&mut writer, 1, "a").await;
    assert!(begun.elapsed() >= long, "written although the table was being read");
    reader.await.unwrap();
    assert_eq!(store::record::at(&store, 1, UtcMicros(0)).await.unwrap().len(), 1);
}

#[tokio::test]
async fn a_parameter_that_only_those_who_read_would_heed_is_refused() {
    let dir = TempDir::new().unwrap();
    let url = |parameters| format!("sqlite://{}?{parameters}", dir.path().join("test.db").display());
    for (parameters, refused) in [("vfs=unix-excl", "vfs=unix-excl"), ("mode=rwc&immutable=true", "immutable=true")] {
        let error = open(&options(&url(parameters))).await.unwrap_err();
        assert_eq!(error.to_string(), format!("address_parameter (parameter: {refused})"));
    }
    assert!(!dir.path().join("test.db").exists());
    open(&options(&url("mode=rwc"))).await.unwrap();
}
