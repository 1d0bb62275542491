//! The service beside databases that people would otherwise put such records into, on the same machine in the same run.
//!
//! `scripts/bench peers` starts them all and runs this. Each store is given where its variable names an address:
//! `GYROWATCH_BENCH_GYROWATCH`, `_INFLUXDB`, `_VICTORIAMETRICS` (`host:port`), `_POSTGRES` (a directory with pgbench
//! scripts).
//!
//! What each is sent for a calibration of three gyros: the service its record, which it parses, separates, judges and
//! keeps; InfluxDB and VictoriaMetrics six points (and InfluxDB the raw record as well); PostgreSQL one row with the
//! record and three of the history, in one transaction. Rounds are run by turns, and the medians of three are
//! printed.

mod client;

use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use client::{Client, DAY_S, EPOCH_S, Times, Wanted, record};
use tokio::task::JoinSet;

const ROUNDS: usize = 3;
const ROUND: Duration = Duration::from_secs(4);
const CONNECTIONS: [usize; 3] = [1, 16, 64];
/// Daily calibrations of the gyro whose trend is read.
const DAYS: usize = 10_000;

/// A store, and how it is spoken to.
#[derive(Debug, Clone)]
enum Peer {
    Gyrowatch(String, Wanted),
    Influxdb(String),
    VictoriaMetrics(String),
    Postgres(PathBuf),
}

/// What was asked for, per second and at which latency.
#[derive(Debug, Clone, Copy)]
struct Figure {
    rate: f64,
    p50: Duration,
    p99: Duration,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Read {
    Last1000,
    YearByDay,
}

impl Peer {
    fn all() -> Vec<Self> {
        let of = |name: &str| std::env::var(format!("GYROWATCH_BENCH_{name}")).ok();
        let peers = [
            of("GYROWATCH").map(|address| Self::Gyrowatch(address, Wanted::Whole)),
            of("GYROWATCH").map(|address| Self::Gyrowatch(address, Wanted::Minimal)),
            of("INFLUXDB").map(Self::Influxdb),
            of("VICTORIAMETRICS").map(Self::VictoriaMetrics),
            of("POSTGRES").map(|dir| Self::Postgres(dir.into())),
        ];
        peers.into_iter().flatten().collect()
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Gyrowatch(_, Wanted::Whole) => "gyrowatch",
            Self::Gyrowatch(_, Wanted::Minimal) => "gyrowatch, minimal answers",
            Self::Influxdb(_) => "InfluxDB, with the record",
            Self::VictoriaMetrics(_) => "VictoriaMetrics, not durable",
            Self::Postgres(_) => "PostgreSQL, pgbench",
        }
    }

    /// The service once more, asked for minimal answers.
    fn is_minimal(&self) -> bool {
        matches!(self, Self::Gyrowatch(_, Wanted::Minimal))
    }

    /// Path, media type and body of the calibration `k` of IMU `imu`.
    fn calibration(&self, imu: usize, k: usize) -> (&'static str, &'static str, String) {
        match self {
            Self::Gyrowatch(..) => ("/v1/records", "application/json", record(imu, k)),
            Self::Influxdb(_) => {
                let raw = record(imu, k).replace('\\', "\\\\").replace('"', "\\\"").replace('\n', " ");
                let at = (EPOCH_S + k * DAY_S) * 1_000_000_000;
                (
                    "/write?db=bench",
                    "text/plain",
                    format!("{}record,imu=IMU-{imu} raw=\"{raw}\" {at}\n", points(imu, k)),
                )
            }
            Self::VictoriaMetrics(_) => ("/write", "text/plain", points(imu, k)),
            Self::Postgres(_) => unreachable!("pgbench makes its own"),
        }
    }

    async fn ingest(&self, connections: usize, round: usize) -> Figure {
        match self {
            Self::Postgres(dir) => pgbench(dir, "ingest.sql", connections),
            Self::Gyrowatch(address, _) | Self::Influxdb(address) | Self::VictoriaMetrics(address) => {
                let begun = Instant::now();
                let mut senders = JoinSet::new();
                for sender in 0..connections {
                    let (peer, address) = (self.clone(), address.clone());
                    let imu =
                        1_000_000 * usize::from(self.is_minimal()) + 10_000 * (round + 1) + 100 * connections + sender;
                    senders.spawn(async move { peer.send(&address, imu).await });
                }
                figure(&Times::of(senders.join_all().await.into_iter().flatten().collect(), begun))
            }
        }
    }

    async fn send(&self, address: &str, imu: usize) -> Vec<Duration> {
        let wanted = if self.is_minimal() { Wanted::Minimal } else { Wanted::Whole };
        let mut client = Client::connect(address).await.wanting(wanted);
        let (mut times, until) = (Vec::new(), Instant::now() + ROUND);
        for k in 0.. {
            // Before its days reach the future, another IMU takes over.
            let (path, media_type, body) = self.calibration(imu + 10_000_000 * (k / DAYS), k % DAYS);
            let begun = Instant::now();
            if begun > until {
                break;
            }
            let status = client.post(path, media_type, &body).await.status;
            assert!(matches!(status, 201 | 204), "{}: {status}", self.name());
            times.push(begun.elapsed());
        }
        times
    }

    /// The gyro whose trend is read, [`DAYS`] long.
    async fn fill(&self) {
        let (Self::Gyrowatch(address, _) | Self::Influxdb(address) | Self::VictoriaMetrics(address)) = self else {
            return; // its script has filled it
        };
        let mut client = Client::connect(address).await;
        for block in (0..DAYS).step_by(500) {
            let answer = match self {
                Self::Gyrowatch(..) => {
                    let lines: String = (block..block + 500).map(|k| record(0, k).replace('\n', "") + "\n").collect();
                    client.post("/v1/import", "application/x-ndjson", &lines).await
                }
                _ => {
                    let lines: String = (block..block + 500).map(|k| points(0, k)).collect();
                    client.post(self.calibration(0, 0).0, "text/plain", &lines).await
                }
            };
            assert!(answer.status < 300, "{}: {}", self.name(), String::from_utf8_lossy(&answer.body));
        }
    }

    fn question(&self, read: Read) -> String {
        let year = EPOCH_S + (DAYS - 365) * DAY_S;
        match (self, read) {
            (Self::Gyrowatch(..), Read::Last1000) => "/v1/gyros/L0-0101/trend?coefficient=D_I&last=1000".to_owned(),
            (Self::Gyrowatch(..), Read::YearByDay) => {
                "/v1/gyros/L0-0101/trend?coefficient=D_I&every=day&from=2016-05-19T00:00:00Z".to_owned()
            }
            (Self::Influxdb(_), Read::Last1000) => {
                "/query?db=bench&q=SELECT+D_I+FROM+drift+WHERE+serial%3D'L0-0101'+ORDER+BY+time+DESC+LIMIT+1000"
                    .to_owned()
            }
            (Self::Influxdb(_), Read::YearByDay) => format!(
                "/query?db=bench&q=SELECT+min(D_I),max(D_I),mean(D_I),last(D_I)+FROM+drift+WHERE+serial%3D'L0-0101'+AND+time%3E%3D{year}s+AND+time%3C{}s+GROUP+BY+time(1d)",
                EPOCH_S + DAYS * DAY_S
            ),
            (Self::VictoriaMetrics(_), Read::Last1000) => format!(
                "/api/v1/export?match[]=drift_D_I%7Bserial=%22L0-0101%22%7D&start={}&end={}",
                EPOCH_S + (DAYS - 1000) * DAY_S,
                EPOCH_S + DAYS * DAY_S
            ),
            (Self::VictoriaMetrics(_), Read::YearByDay) => format!(
                "/api/v1/query_range?query=avg_over_time(drift_D_I%7Bserial=%22L0-0101%22%7D[1d])&start={year}&end={}&step=1d",
                EPOCH_S + DAYS * DAY_S
            ),
            (Self::Postgres(_), Read::Last1000) => "last1000.sql".to_owned(),
            (Self::Postgres(_), Read::YearByDay) => "year.sql".to_owned(),
        }
    }

    async fn read(&self, read: Read, connections: usize) -> Figure {
        let question = self.question(read);
        match self {
            Self::Postgres(dir) => pgbench(dir, &question, connections),
            Self::Gyrowatch(address, _) | Self::Influxdb(address) | Self::VictoriaMetrics(address) => {
                let begun = Instant::now();
                let mut readers = JoinSet::new();
                for _ in 0..connections {
                    let (address, question) = (address.clone(), question.clone());
                    readers.spawn(async move { ask(&address, &question).await });
                }
                figure(&Times::of(readers.join_all().await.into_iter().flatten().collect(), begun))
            }
        }
    }
}

async fn ask(address: &str, question: &str) -> Vec<Duration> {
    let mut client = Client::connect(address).await;
    let (mut times, until) = (Vec::new(), Instant::now() + ROUND);
    loop {
        let begun = Instant::now();
        if begun > until {
            return times;
        }
        let answer = client.get(question).await;
        // A store that finds nothing answers quickly.
        assert!(answer.status == 200 && answer.body.len() > 4_000, "{}", String::from_utf8_lossy(&answer.body));
        times.push(begun.elapsed());
    }
}

/// D_I and D_S of its three gyros in InfluxDB's line protocol.
fn points(imu: usize, k: usize) -> String {
    let at = (EPOCH_S + k * DAY_S) * 1_000_000_000;
    let point = |slot| {
        let (d_i, d_s) = (2.9 + slot as f64 + 1e-4 * (k % 97) as f64, 4.6 - 1e-4 * (k % 89) as f64);
        format!("drift,serial=L{imu}-010{slot},imu=IMU-{imu} D_I={d_i},D_S={d_s} {at}\n")
    };
    (1..=3).map(point).collect()
}

/// Runs a script of PostgreSQL's own client for one round.
fn pgbench(dir: &std::path::Path, script: &str, connections: usize) -> Figure {
    let log = dir.join("log");
    let _may_not_be_there = std::fs::remove_dir_all(&log);
    std::fs::create_dir(&log).expect("a directory for times");
    let output = Command::new(dir.join("pgbench"))
        .args(["-n", "-M", "prepared", "-c", &connections.to_string(), "-j", "1", "-T", &ROUND.as_secs().to_string()])
        .args(["--log", "--log-prefix"])
        .arg(log.join("times"))
        .arg("-f")
        .arg(dir.join(script))
        .output()
        .expect("pgbench runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let files = std::fs::read_dir(&log).expect("the times").map(|file| file.expect("a file").path());
    let text: String = files.map(|file| std::fs::read_to_string(file).expect("times")).collect();
    let micros = text.lines().map(|line| line.split(' ').nth(2).expect("a time").parse().expect("a number"));
    let times = micros.map(Duration::from_micros).collect();
    figure(&Times::of(times, Instant::now() - ROUND))
}

fn figure(times: &Times) -> Figure {
    Figure { rate: times.rate(), p50: times.quantile(0.5), p99: times.quantile(0.99) }
}

/// The round with the median rate.
fn median(mut rounds: Vec<Figure>) -> Figure {
    rounds.sort_by(|a, b| a.rate.total_cmp(&b.rate));
    rounds[rounds.len() / 2]
}

/// By turns, so that what else the machine does falls on all of them; each is held against the service, with each of
/// its answers.
async fn compare(title: &str, peers: &[Peer], measure: impl AsyncFn(&Peer, usize) -> Figure) {
    let mut rounds = vec![Vec::new(); peers.len()];
    for round in 0..ROUNDS {
        for (peer, figures) in peers.iter().zip(&mut rounds) {
            figures.push(measure(peer, round).await);
        }
    }
    println!("\n{title}");
    let figures: Vec<Figure> = rounds.into_iter().map(median).collect();
    let own = peers.iter().take_while(|peer| matches!(peer, Peer::Gyrowatch(..))).count();
    for (peer, figure) in peers.iter().zip(&figures) {
        let ratios: String = figures[..own].iter().map(|own| format!(" {:>6.2}", own.rate / figure.rate)).collect();
        println!(
            "  {:<30}{:>9.0}/s{ratios}   p50 {:>7.0} us   p99 {:>7.0} us",
            peer.name(),
            figure.rate,
            figure.p50.as_secs_f64() * 1e6,
            figure.p99.as_secs_f64() * 1e6
        );
    }
}

fn main() {
    let peers = Peer::all();
    if peers.is_empty() {
        println!("no store to measure: scripts/bench peers starts them");
        return;
    }
    println!(
        "medians of {ROUNDS} rounds of {} s; then gyrowatch over the store, with whole and with minimal answers",
        ROUND.as_secs()
    );
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    runtime.block_on(async {
        for connections in CONNECTIONS {
            let title = format!("calibrations of three gyros, {connections} connections");
            compare(&title, &peers, async |peer, round| peer.ingest(connections, round).await).await;
        }
        // Who reads is answered alike.
        let peers: Vec<Peer> = peers.into_iter().filter(|peer| !peer.is_minimal()).collect();
        for peer in &peers {
            peer.fill().await;
        }
        for (read, title) in
            [(Read::Last1000, "the last 1,000 points of a gyro"), (Read::YearByDay, "a year of a gyro by day")]
        {
            for connections in [1, 8] {
                let title = format!("{title}, {connections} connections");
                compare(&title, &peers, async |peer, _| peer.read(read, connections).await).await;
            }
        }
    });
}
