//! Durable ingest over HTTP beside bare loops with the same durability, in one run: what counts is the ratio.
//!
//! `cargo bench --bench ingest`
//!
//! Client and service share the machine. Each connection posts records of one IMU of its own, one after the other; a
//! record counts when its 201 is read. It asks for whole answers, and for minimal ones. Then one import brings many
//! records of a fleet at once, as a move from another system does. After the records one connection posts raw
//! campaigns (78 dwells, three gyros), by turns with the records above and with records of the very calibration that
//! is fitted to the campaign: these raise the same alerts and have standard deviations too.
//!
//! The bare loops write the same text and three rows of 120 bytes a record, WAL and `synchronous = FULL` as the
//! service has them: one through sqlx, one transaction a record or many, and those of [`bare`] through SQLite itself.
//! Rounds are run by turns, and medians are printed: of the rates, and of the ratios round by round.

mod bare;
mod client;

use std::net::SocketAddr;
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use client::{Client, Times, Wanted, instant, record};
use gyrowatch::config::Config;
use gyrowatch::core::calibrate::{GyroCalibration, calibrate};
use gyrowatch::core::model::Terms;
use gyrowatch::http::{self, App};
use gyrowatch::pipeline::Pipeline;
use gyrowatch::routes::Routes;
use gyrowatch::store;
use gyrowatch::system::{self, Clock};
use gyrowatch::wire::campaign::parse_json;
use gyrowatch::wire::geometry::GeometryBody;
use gyrowatch::wire::record::{GyroBody, RecordBody};
use gyrowatch::wire::triple::Triple;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqliteSynchronous};
use sqlx::{ConnectOptions, Connection};
use tempfile::TempDir;
use tokio::net::TcpListener;
use tokio::task::{JoinHandle, JoinSet};

const RECORDS: usize = 8_000;
/// Of several connections together.
const RECORDS_OF_MANY: usize = 24_000;
const CAMPAIGNS: usize = 1_000;
const TURNS: u32 = 4;
const ROUNDS: usize = 3;
/// Records of one import.
const IMPORTED: usize = 60_000;
/// Records in a transaction of the bare loops that the import is held against, through sqlx and through SQLite itself.
const MANY: usize = 512;
const A_BATCH: usize = 1_000;
const CAMPAIGN: &str = include_str!("../tests/data/practice/campaign-00.json");

/// What is posted, and how often.
#[derive(Clone, Copy)]
struct Load {
    path: &'static str,
    body: fn(usize, usize) -> String,
    count: usize,
    wanted: Wanted,
}

const OF_RECORDS: Load = Load { path: "/v1/records", body: record, count: RECORDS, wanted: Wanted::Whole };
const OF_CAMPAIGNS: Load = Load { path: "/v1/campaigns", body: campaign, count: CAMPAIGNS, wanted: Wanted::Whole };
const OF_THE_SAME: Load = Load { path: "/v1/records", body: fitted, count: CAMPAIGNS, wanted: Wanted::Whole };

/// What was aimed at, as a part of what bare SQLite did on the machine on which the aims were set
/// (`docs/performance.md`).
fn aim(connections: usize) -> Option<f64> {
    match connections {
        1 => Some(4_000.0 / 8_500.0),
        16 => Some(16_000.0 / 17_920.0),
        64 => Some(16_000.0 / 19_670.0),
        _ => None,
    }
}
const AIM_OF_AN_IMPORT: f64 = 40_000.0 / 34_600.0;

fn main() {
    system::install_crypto();
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    runtime.block_on(async {
        let sqlx = bare_loop(1).await;
        println!("{:<42}{sqlx:>9.0} records/s", "bare sqlx, one commit a record");
        let sqlx_many = bare_loop(MANY).await;
        println!("{:<42}{sqlx_many:>9.0} records/s", format!("bare sqlx, {MANY} records a commit"));
        for connections in connections() {
            records(connections, sqlx).await;
        }
        let rounds = rounds(async || [bare::in_batches(IMPORTED, A_BATCH), imported().await]).await;
        let [bare, imports] = [0, 1].map(|which| median(rounds.iter().map(|rates| rates[which])));
        println!("{:<42}{bare:>9.0} records/s", format!("bare SQLite, {A_BATCH} records a commit"));
        let of_bare = median(rounds.iter().map(|[bare, import]| import / bare));
        let of_many = imports / sqlx_many;
        println!(
            "{:<42}{imports:>9.0} records/s  {of_bare:>5.2} of bare SQLite (aim {AIM_OF_AN_IMPORT:.2}), {of_many:.2} of bare sqlx with {MANY} a commit",
            "HTTP, one import of many"
        );
        campaigns().await;
    });
}

/// Records over so many connections, with whole and with minimal answers, by turns with bare SQLite.
async fn records(connections: usize, sqlx: f64) {
    let count = if connections == 1 { RECORDS } else { RECORDS_OF_MANY };
    let times = async |wanted| over_http(connections, Load { wanted, count, ..OF_RECORDS }).await;
    let rounds = rounds(async || {
        let bare = if connections == 1 { bare::in_batches(count, 1) } else { bare::together(count, connections) };
        (bare, times(Wanted::Whole).await, times(Wanted::Minimal).await)
    })
    .await;
    let bare = median(rounds.iter().map(|(bare, ..)| *bare));
    println!("{:<42}{bare:>9.0} records/s", format!("bare SQLite, {connections} threads"));
    let whole: Vec<(f64, &Times)> = rounds.iter().map(|(bare, whole, _)| (*bare, whole)).collect();
    let minimal: Vec<(f64, &Times)> = rounds.iter().map(|(bare, _, minimal)| (*bare, minimal)).collect();
    for (rounds, answers) in [(whole, ""), (minimal, ", minimal answers")] {
        let rate = median(rounds.iter().map(|(_, times)| times.rate()));
        let of_bare = median(rounds.iter().map(|(bare, times)| times.rate() / bare));
        let p99 = median(rounds.iter().map(|(_, times)| times.quantile(0.99).as_secs_f64()));
        let aim = aim(connections).map(|aim| format!(" (aim {aim:.2})")).unwrap_or_default();
        println!(
            "{:<42}{rate:>9.0} records/s  {of_bare:>5.2} of bare SQLite{aim}, {:.2} of bare sqlx  p99 {:.1} ms",
            format!("HTTP, {connections} connections{answers}"),
            rate / sqlx,
            p99 * 1e3
        );
    }
}

/// Short runs by turns: what else the machine does falls on all.
async fn campaigns() {
    let loads = [OF_CAMPAIGNS, Load { count: CAMPAIGNS, ..OF_RECORDS }, OF_THE_SAME];
    let mut seconds_each = [0.0; 3];
    for _ in 0..TURNS {
        for (load, seconds_each) in loads.iter().zip(&mut seconds_each) {
            *seconds_each += 1.0 / over_http(1, *load).await.rate() / f64::from(TURNS);
        }
    }
    let [campaign, record, same] = seconds_each;
    println!(
        "{:<42}{:>9.0} campaigns/s, a campaign takes {:.2} of a record, {:.2} of a record of the same calibration",
        "HTTP, 1 connection",
        1.0 / campaign,
        campaign / record,
        campaign / same
    );
}

async fn rounds<T>(mut round: impl AsyncFnMut() -> T) -> Vec<T> {
    let mut rounds = Vec::with_capacity(ROUNDS);
    for _ in 0..ROUNDS {
        rounds.push(round().await);
    }
    rounds
}

fn median(figures: impl Iterator<Item = f64>) -> f64 {
    let mut figures: Vec<f64> = figures.collect();
    figures.sort_by(f64::total_cmp);
    figures[figures.len() / 2]
}

/// Given on the command line (`cargo bench --bench ingest -- 64`), or 1, 16 and 64.
fn connections() -> Vec<usize> {
    let given: Vec<usize> = std::env::args().skip(1).filter_map(|argument| argument.parse().ok()).collect();
    if given.is_empty() { vec![1, 16, 64] } else { given }
}

/// A campaign of 78 dwells of IMU number `imu`, one a day.
fn campaign(imu: usize, k: usize) -> String {
    let at = instant(k);
    let (head, rest) = CAMPAIGN.split_once("\"measured_at\"").expect("a campaign says when it was measured");
    let (_, rest) = rest.split_once(',').expect("more fields follow");
    let head = head.replace("IMU-", &format!("IMU-{imu}-"));
    format!("{head}\"measured_at\":\"{at}\",{rest}")
}

/// What is fitted to [`campaign`], as a station that fits for itself would send it.
fn fitted(imu: usize, k: usize) -> String {
    static FITTED: LazyLock<RecordBody> = LazyLock::new(|| {
        let campaign = parse_json(CAMPAIGN.as_bytes()).expect("sound");
        let calibration = calibrate(&campaign, Terms::MODEL_6);
        let fitted = |gyro: &GyroCalibration| {
            let sd = gyro.covariance_eg().expect("the dwells have standard errors").diagonal().map(f64::sqrt);
            let triple = |first: usize| Triple([sd[first], sd[first + 1], sd[first + 2]]);
            GyroBody {
                slot: gyro.slot,
                serial: gyro.serial.to_string(),
                e_pulse_per_arcsec: Triple(gyro.e().expect("fitted").into()),
                g_pulse_per_s_g0: Some(Triple(gyro.g().expect("fitted").into())),
                g_deg_per_h_g0: None,
                p_pulse_per_s_g02: None,
                bias_pulse_per_s: None,
                e_sd: Some(triple(0)),
                g_sd: Some(triple(3)),
            }
        };
        RecordBody {
            imu: campaign.imu.to_string(),
            station: campaign.station.to_string(),
            calibrated_at: String::new(),
            geometry: GeometryBody::of(&campaign.geometry),
            gyros: calibration.gyros.iter().map(fitted).collect(),
            temperature_c: None,
            campaign: None,
            operator: None,
            note: None,
        }
    });
    let mut record = FITTED.clone();
    record.imu.push_str(&format!("-{imu}"));
    record.calibrated_at = instant(k);
    serde_json::to_string(&record).expect("strings and finite numbers always serialise")
}

/// Records/s with `each` of them in a transaction.
async fn bare_loop(each: usize) -> f64 {
    let dir = TempDir::new().expect("a directory");
    let mut connection = SqliteConnectOptions::new()
        .filename(dir.path().join("bare.db"))
        .create_if_missing(true)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(SqliteSynchronous::Full)
        .disable_statement_logging()
        .connect()
        .await
        .expect("a database");
    for sql in [
        "CREATE TABLE record (id INTEGER PRIMARY KEY, body TEXT NOT NULL) STRICT",
        "CREATE TABLE history (gyro INTEGER, at INTEGER, figures BLOB, PRIMARY KEY (gyro, at)) STRICT, WITHOUT ROWID",
    ] {
        sqlx::query(sql).execute(&mut connection).await.expect("a table");
    }
    let count = if each == 1 { RECORDS } else { IMPORTED };
    let begun = Instant::now();
    for first in (0..count).step_by(each) {
        let mut transaction = connection.begin_with("BEGIN IMMEDIATE").await.expect("a transaction");
        for k in first..count.min(first + each) {
            sqlx::query("INSERT INTO record VALUES ($1, $2)")
                .bind(k as i64)
                .bind(record(0, k))
                .execute(&mut *transaction)
                .await
                .expect("a row");
            sqlx::query("INSERT INTO history VALUES (1, $1, $2), (2, $1, $2), (3, $1, $2)")
                .bind(k as i64)
                .bind(vec![7_u8; 120])
                .execute(&mut *transaction)
                .await
                .expect("rows");
        }
        transaction.commit().await.expect("a commit");
    }
    count as f64 / begun.elapsed().as_secs_f64()
}

/// The service on a free port with a fresh database.
struct Running {
    address: SocketAddr,
    stop: tokio::sync::oneshot::Sender<()>,
    served: JoinHandle<()>,
    written: JoinHandle<()>,
    _dir: TempDir,
}

impl Running {
    async fn start() -> Self {
        let dir = TempDir::new().expect("a directory");
        let mut config = Config::defaults();
        config.database.url = format!("sqlite://{}", dir.path().join("gyrowatch.db").display());
        let config = Arc::new(config);
        let (store, writer) = store::open(&config.database.options()).await.expect("a database");
        let (pipeline, written) =
            Pipeline::start(store, writer, Arc::clone(&config), Clock::System).await.expect("a pipeline");
        let listener = TcpListener::bind("127.0.0.1:0").await.expect("a port");
        let address = listener.local_addr().expect("an address");
        let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
        let app = App { config: Arc::clone(&config), clock: Clock::System, pipeline: Arc::new(pipeline) };
        let router = http::router(app, Routes::default());
        let served = tokio::spawn(async move {
            let stop = async move { drop(stopped.await) };
            http::server::serve(listener, None, router, &config.server, stop).await;
        });
        Self { address, stop, served, written, _dir: dir }
    }

    async fn stop(self) {
        self.stop.send(()).expect("the service runs");
        self.served.await.expect("the service stops");
        self.written.await.expect("the writer stops");
    }
}

async fn over_http(connections: usize, load: Load) -> Times {
    let running = Running::start().await;
    let begun = Instant::now();
    let mut senders = JoinSet::new();
    for imu in 0..connections {
        senders.spawn(post(running.address, imu, load, load.count / connections));
    }
    let times = Times::of(senders.join_all().await.into_iter().flatten().collect(), begun);
    running.stop().await;
    times
}

/// Records a second of one import, until its last answer is read.
async fn imported() -> f64 {
    let running = Running::start().await;
    let lines = (0..IMPORTED).map(|k| record(k % bare::IMUS, k / bare::IMUS).replace('\n', "") + "\n");
    let text: String = lines.collect();
    let client = system::http_client(Duration::from_secs(5), Duration::from_secs(600)).build().expect("a client");
    let begun = Instant::now();
    let request = client.post(format!("http://{}/v1/import", running.address)).body(text);
    let answer = request.header("content-type", "application/x-ndjson").send().await.expect("an answer");
    let answers = answer.text().await.expect("a whole answer");
    let rate = IMPORTED as f64 / begun.elapsed().as_secs_f64();
    assert_eq!(answers.matches("\"status\":201").count(), IMPORTED);
    running.stop().await;
    rate
}

async fn post(address: SocketAddr, imu: usize, load: Load, count: usize) -> Vec<Duration> {
    let mut client = Client::connect(&address.to_string()).await.wanting(load.wanted);
    let mut times = Vec::with_capacity(count);
    for k in 0..count {
        let body = (load.body)(imu, k);
        let begun = Instant::now();
        assert_eq!(client.post(load.path, "application/json", &body).await.status, 201);
        times.push(begun.elapsed());
    }
    times
}
