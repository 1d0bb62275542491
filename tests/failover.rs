//! The database behind the servers changes under them: a standby takes over that has lost commits, a host falls
//! silent, is far away, or is one of several. Nothing is mixed up, and writing goes on.

use crate::cluster::{Cluster, count};
use crate::command::verified;
use crate::database_proxy::Proxy;
use crate::prelude::*;
use crate::support::{NEVER_LATE, free_port};
use sqlx::{Connection, PgConnection};

const LEASE: Duration = Duration::from_secs(3);

async fn server_on(url: &str, others: &[(&str, &str)]) -> Server {
    let lease = LEASE.as_secs().to_string();
    let settings = [("GYROWATCH_DATABASE_URL", url), ("GYROWATCH_DATABASE__LEASE_S", &lease), NEVER_LATE];
    Server::start_with(&[&settings, others].concat()).await
}

/// An IMU of three gyros that nobody else has, whose figures tell it from every other.
fn record(imu: &str, level: f64, minute: usize) -> Value {
    let mut record = paper_record(1, minute);
    record["imu"] = json!(imu);
    let gyros = record["gyros"].as_array_mut().unwrap();
    for (place, gyro) in gyros.iter_mut().enumerate() {
        gyro["serial"] = json!(format!("{imu}-{place}"));
        for g in gyro["g_pulse_per_s_g0"].as_array_mut().unwrap() {
            *g = json!(g.as_f64().unwrap() + level);
        }
    }
    record
}

/// What a server shows of each gyro of an IMU: D_I of every record.
async fn shown(server: &Server, imu: &str) -> Vec<Vec<f64>> {
    let mut all = Vec::new();
    for place in 0..3 {
        let end = Instant::now() + Duration::from_secs(5);
        let mut answer = server.get(&format!("/v1/gyros/{imu}-{place}/trend")).await;
        // A server hears of another's new names within a quarter of a second.
        while answer.status == 404 && Instant::now() < end {
            tokio::time::sleep(Duration::from_millis(50)).await;
            answer = server.get(&format!("/v1/gyros/{imu}-{place}/trend")).await;
        }
        assert_eq!(answer.status, 200, "{}", answer.text());
        let points = answer.json()["points"].as_array().unwrap().clone();
        all.push(points.iter().map(|point| point["value"].as_f64().unwrap()).collect());
    }
    all
}

/// `scripts/soak failovers` does this 100 times.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_failover_that_loses_commits_mixes_nothing_up() {
    if !cluster::is_there() {
        return;
    }
    let rounds = support::asked("GYROWATCH_SOAK_FAILOVERS", 3);
    let mut primary = Cluster::start();
    let url = primary.fresh_database().await;
    let between = Proxy::to(primary.address()).await;
    let through = between.url(&url);
    let (a, b) = (server_on(&through, &[]).await, server_on(&through, &[]).await);
    let mut kept: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
    for round in 0..rounds {
        let name = |what: &str, k: usize| format!("{what}{round}-{k}");
        let known = record(&name("known", 0), 0.001 * round as f64, round);
        a.takes("/v1/records", &known).await;
        let mut standby = primary.standby();
        standby.crash();
        // How many commits are lost, and how many take their versions: fewer, as many, more.
        let (lost, others) = (1 + round % 2, 1 + round % 4);
        let levels = |what: usize, k: usize| 0.01 * (1 + what) as f64 + 0.003 * k as f64;
        for k in 0..lost {
            a.takes("/v1/records", &record(&name("lost", k), levels(0, k), k)).await;
        }
        primary.crash();
        standby.start_again();
        standby.promote().await;
        between.leads_to(standby.address());
        for k in 0..others {
            b.takes("/v1/records", &record(&name("other", k), levels(1, k), k)).await;
        }
        for k in 0..lost {
            a.takes("/v1/records", &record(&name("lost", k), levels(0, k), k)).await;
        }
        let own = [(name("lost", 0), levels(0, 0)), (name("other", 0), levels(1, 0))];
        for (imu, _) in &own {
            let (by_a, by_b) = (shown(&a, imu).await, shown(&b, imu).await);
            assert_eq!(by_a, by_b, "round {round}: both servers show the same of {imu}");
            assert!(by_a.iter().all(|points| points.len() == 1), "round {round}: one record of each: {by_a:?}");
            kept.insert(imu.clone(), by_a);
        }
        assert_ne!(kept[&own[0].0], kept[&own[1].0], "round {round}: two IMUs, two sets of figures");
        primary = standby;
    }
    for (imu, figures) in &kept {
        assert_eq!(&shown(&a, imu).await, figures, "{imu} is as it was");
    }
    let own = primary.url(url.rsplit_once('/').unwrap().1);
    println!("{rounds} failovers; {}", verified(&own));
}

/// Of a synchronous standby nothing that was acknowledged is missing.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_synchronous_standby_has_all_that_was_acknowledged() {
    if !cluster::is_there() {
        return;
    }
    let rounds = support::asked("GYROWATCH_SOAK_FAILOVERS", 1);
    let mut primary = Cluster::start();
    let url = primary.fresh_database().await;
    let between = Proxy::to(primary.address()).await;
    let server = server_on(&between.url(&url), &[]).await;
    let mut acknowledged = 0;
    for round in 0..rounds {
        let standby = primary.standby();
        let mut admin = PgConnection::connect(&primary.url("postgres")).await.unwrap();
        for sql in ["ALTER SYSTEM SET synchronous_standby_names = '*'", "SELECT pg_reload_conf()"] {
            sqlx::query(sql).execute(&mut admin).await.unwrap();
        }
        let sent = std::sync::atomic::AtomicUsize::new(0);
        let (load, kill) = (
            async {
                for k in 0..40 {
                    let answer = server.post_json("/v1/records", &record(&format!("r{round}-{k}"), 0.0, k)).await;
                    if answer.status != 201 {
                        assert_eq!(answer.status, 503, "{}", answer.text());
                        break;
                    }
                    sent.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
                }
            },
            async {
                while sent.load(std::sync::atomic::Ordering::SeqCst) < 12 {
                    tokio::time::sleep(Duration::from_millis(5)).await;
                }
                tokio::task::block_in_place(|| primary.crash());
            },
        );
        tokio::join!(load, kill);
        standby.promote().await;
        let mut admin = PgConnection::connect(&standby.url("postgres")).await.unwrap();
        for sql in ["ALTER SYSTEM RESET synchronous_standby_names", "SELECT pg_reload_conf()"] {
            sqlx::query(sql).execute(&mut admin).await.unwrap();
        }
        between.leads_to(standby.address());
        acknowledged += sent.into_inner() as i64;
        let own = standby.url(url.rsplit_once('/').unwrap().1);
        let there = count(&own, "SELECT count(*) FROM record").await;
        assert!(there >= acknowledged, "round {round}: {there} of {acknowledged} are there");
        // One may have been stored without an answer.
        server.takes("/v1/records", &record(&format!("after{round}"), 0.0, 0)).await;
        acknowledged = count(&own, "SELECT count(*) FROM record").await;
        primary = standby;
    }
    verified(&primary.url(url.rsplit_once('/').unwrap().1));
    println!("{rounds} failovers to a synchronous standby, {acknowledged} records");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_host_that_falls_silent_holds_nobody_up_for_longer_than_two_leases() {
    let Some(url) = cluster::database_if_there().await else { return };
    let between = Proxy::before(&url).await;
    let mut server = server_on(&between.url(&url), &[("GYROWATCH_SERVER__SHUTDOWN_GRACE_S", "4")]).await;
    server.takes("/v1/records", &record("before", 0.0, 0)).await;
    // What held its connections is gone, and another has its address.
    between.silences_connections();
    let silent = Instant::now();
    server.takes("/v1/records", &record("after", 0.0, 1)).await;
    let took = silent.elapsed();
    assert!(took < 2 * LEASE, "writing again after {took:?}");
    let answer = server.get("/v1/gyros/after-0/trend").await;
    assert_eq!(answer.status, 200, "{}", answer.text());
    println!("writing again {took:?} after the host fell silent; the lease is {LEASE:?}");
    // Nobody answers any more, whoever asks.
    between.falls_silent();
    let waits = tokio::spawn({
        let client = gyrowatch::system::http_client(LEASE, 2 * LEASE).build().unwrap();
        let post = client.post(server.url("/v1/records")).json(&record("never", 0.0, 2));
        async move { post.send().await.map(|answer| answer.status().as_u16()) }
    });
    tokio::time::sleep(Duration::from_millis(500)).await;
    let (_, took) = tokio::task::block_in_place(|| server.terminate());
    assert!(took < Duration::from_secs(5), "SIGTERM took {took:?}");
    assert_ne!(waits.await.unwrap().ok(), Some(201));
    println!("ended {took:?} after SIGTERM, of a grace of 4 s");
}

/// `scripts/soak far` measures it.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_import_over_a_long_way_asks_a_handful_of_questions() {
    let records = support::asked("GYROWATCH_SOAK_FAR", 600);
    let Some(url) = cluster::database_if_there().await else { return };
    let near = server_on(&url, &[]).await;
    let import = |minutes: std::ops::Range<usize>| {
        let lines = minutes.map(|k| record(&format!("far{}", k % (records / 3)), 0.0, k).to_string());
        lines.collect::<Vec<_>>().join("\n")
    };
    let answer = near.post("/v1/import", "application/x-ndjson", import(0..records)).await;
    assert_eq!(answer.text().matches("\"id\"").count(), records);
    drop(near);
    let between = Proxy::before(&url).await;
    between.delays(Duration::from_millis(3));
    let server = server_on(&between.url(&url), &[]).await;
    // What is asked once a connection, to open it and to prepare statements, is not of the import.
    let answer = server.post("/v1/import", "application/x-ndjson", import(records..2 * records)).await;
    assert_eq!(answer.text().matches("\"id\"").count(), records, "{}", answer.text());
    for (what, minutes) in [("newer", 2 * records..3 * records), ("the same again", 2 * records..3 * records)] {
        let (begun, asked) = (Instant::now(), between.questions());
        let answer = server.post("/v1/import", "application/x-ndjson", import(minutes)).await;
        let (took, asked) = (begun.elapsed(), between.questions() - asked);
        assert_eq!(answer.text().matches("\"id\"").count(), records, "{}", answer.text());
        println!(
            "{what}: {records} records at 3 ms, {asked} questions, {:.0} records/s",
            records as f64 / took.as_secs_f64()
        );
        // Four writers ask at the same time.
        assert!(asked / 4 < records as u64 / 4, "{what}: {asked} questions");
    }
    assert_eq!(count(&url, "SELECT count(*) FROM record").await, 3 * records as i64);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_note_at_one_server_makes_another_read_that_gyro_alone() {
    let Some(url) = cluster::database_if_there().await else { return };
    let between = Proxy::before(&url).await;
    let (a, b) = (server_on(&between.url(&url), &[]).await, server_on(&url, &[]).await);
    let lines: Vec<String> = (0..400).map(|k| record(&format!("n{k}"), 0.0, k).to_string()).collect();
    let answer = b.post("/v1/import", "application/x-ndjson", lines.join("\n")).await;
    assert_eq!(answer.text().matches("\"id\"").count(), 400);
    a.takes("/v1/records", &record("n0", 0.0, 1000)).await;
    tokio::time::sleep(Duration::from_secs(1)).await;
    let read_for = async |minute: usize| {
        let before = between.answered_bytes();
        a.takes("/v1/records", &record("n0", 0.0, minute)).await;
        between.answered_bytes() - before
    };
    let without = read_for(1001).await;
    let event = json!({"event": "note", "at": "2026-01-01T00:00:00Z", "reason": "looked at", "author": "tester"});
    let noted = b.post_json("/v1/gyros/n1-0/events", &event).await;
    assert_eq!(noted.status, 201, "{}", noted.text());
    // The clock, which looks at every station now and then, may fall into one of them.
    let mut with = read_for(1002).await;
    for minute in 1003..1006 {
        with = with.min(read_for(minute).await);
    }
    println!("bytes read for a record: {without} before, {with} after a note elsewhere");
    assert!(with < without + 20_000, "{without} bytes before, {with} after a note");
    // And what was noted counts at once.
    let event = json!({"event": "baseline", "at": "2026-01-02T00:00:00Z", "reason": "new level", "author": "tester"});
    b.post_json("/v1/gyros/n0-0/events", &event).await.created();
    a.takes("/v1/records", &record("n0", 0.0, 1003)).await;
    verified(&url);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_several_hosts_the_one_that_takes_writes_is_found() {
    if !cluster::is_there() {
        return;
    }
    let mut primary = Cluster::start();
    let url = primary.fresh_database().await;
    let name = url.rsplit_once('/').unwrap().1;
    let standby = primary.standby();
    let both = format!(
        "postgres://postgres@{},{}/{name}?target_session_attrs=read-write",
        standby.address(),
        primary.address()
    );
    let server = server_on(&both, &[]).await;
    server.takes("/v1/records", &record("one", 0.0, 0)).await;
    primary.crash();
    standby.promote().await;
    server.takes("/v1/records", &record("two", 0.0, 1)).await;
    server.get("/v1/gyros/two-0/trend").await.has(200);
    assert_eq!(count(&standby.url(name), "SELECT count(*) FROM record").await, 2);
}

/// PgBouncer in a process of its own before a database.
struct Pooler {
    _child: Running,
    port: u16,
    _settings: tempfile::TempDir,
}

impl Pooler {
    async fn start(database: &str, mode: &str) -> Self {
        use std::os::unix::fs::PermissionsExt;
        let port = free_port();
        let dir = tempfile::tempdir().unwrap();
        std::fs::set_permissions(dir.path(), std::fs::Permissions::from_mode(0o755)).unwrap();
        let (host, name) = database.split_once('@').unwrap().1.split_once('/').unwrap();
        let (host, its_port) = host.split_once(':').unwrap();
        let settings = format!(
            "[databases]\n{name} = host={host} port={its_port} dbname={name}\n[pgbouncer]\nlisten_addr = 127.0.0.1\n\
             listen_port = {port}\nauth_type = any\npool_mode = {mode}\nunix_socket_dir =\nuser = postgres\n"
        );
        // Whoever it is that asks, the database sees its own user.
        let settings = settings.replace(&format!("dbname={name}\n"), &format!("dbname={name} user=postgres\n"));
        let file = dir.path().join("pgbouncer.ini");
        std::fs::write(&file, settings).unwrap();
        let mut pooler = Command::new("pgbouncer");
        let child = pooler.arg(&file).stderr(Stdio::null()).stdout(Stdio::null()).spawn().unwrap();
        for _ in 0..100 {
            if tokio::net::TcpStream::connect(("127.0.0.1", port)).await.is_ok() {
                break;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        Self { _child: Running(child), port, _settings: dir }
    }

    fn url(&self, database: &str) -> String {
        format!("postgres://postgres@127.0.0.1:{}/{}", self.port, database.rsplit_once('/').unwrap().1)
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_pooler_serves_by_the_session_and_is_refused_by_the_transaction() {
    if !cluster::is_there() || !support::required("pgbouncer") {
        return;
    }
    let url = cluster::fresh_database().await;
    let by_session = Pooler::start(&url, "session").await;
    let server = server_on(&by_session.url(&url), &[]).await;
    for minute in 0..5 {
        server.takes("/v1/records", &record("pooled", 0.0, minute)).await;
    }
    assert_eq!(shown(&server, "pooled").await[0].len(), 5);
    drop(server);
    let by_transaction = Pooler::start(&url, "transaction").await;
    let mut serve = gyrowatch();
    let output = serve
        .arg("serve")
        .env("GYROWATCH_LISTEN", "127.0.0.1:0")
        .env("GYROWATCH_DATABASE_URL", by_transaction.url(&url))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && said.contains("pool_mode = session"), "{said}");
}
