//! The real service in a process of its own, on a free port, with a database in a fresh directory.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::{behind, cluster};
use gyrowatch::system;
use reqwest::header::{HeaderMap, HeaderName, HeaderValue};
use serde_json::Value;
use sqlx::{Connection, Row};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// What the diagnoses of stored campaigns have come to.
pub const SUMMARY: &str = "/v1/diagnoses/summary";

/// For stations that measure in 2025: nothing is late.
pub const NEVER_LATE: (&str, &str) = ("GYROWATCH_ALERTS__BACKFILL_DAYS", "100000");

/// What a browser's form is sent as.
pub const FORM: &str = "application/x-www-form-urlencoded";

/// A file of `tests/data`.
pub fn data(name: &str) -> String {
    std::fs::read_to_string(data_path(name)).unwrap()
}

pub fn data_path(name: &str) -> PathBuf {
    root().join("tests/data").join(name)
}

/// A file of `tests/data` that is JSON.
pub fn document(name: &str) -> Value {
    serde_json::from_str(&data(name)).unwrap()
}

/// A document with one member replaced, or added.
pub fn with_member(mut document: Value, pointer: &str, value: Value) -> Value {
    let (parent, member) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Object(members) => _ = members.insert(member.into(), value),
        Value::Array(items) => items[member.parse::<usize>().unwrap()] = value,
        other => panic!("{other} has no members"),
    }
    document
}

/// The directory of the project.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The address of a database in a file.
pub fn file_url(file: &Path) -> String {
    format!("sqlite://{}", file.display())
}

/// The value of the series of `/metrics` whose line begins so.
pub fn metric(text: &str, series: &str) -> f64 {
    let line = text.lines().find(|line| line.starts_with(series)).unwrap_or_else(|| panic!("{series} in\n{text}"));
    line.rsplit_once(' ').unwrap().1.parse().unwrap()
}

/// Each of these is in a text.
#[track_caller]
pub fn holds(text: &str, all: &[&str]) {
    for there in all {
        assert!(text.contains(there), "{there} is not in {text}");
    }
}

/// A port that was free a moment ago.
pub fn free_port() -> u16 {
    std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// What `look` sees once it is as `wanted`: it looks again and again, for as long as a busy machine may need.
pub async fn once<T: std::fmt::Debug>(look: impl AsyncFn() -> T, wanted: impl Fn(&T) -> bool) -> T {
    let patience = Instant::now() + Duration::from_secs(240);
    loop {
        let seen = look().await;
        if wanted(&seen) {
            return seen;
        }
        assert!(Instant::now() < patience, "{seen:#?}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// The paper's record as one of IMU number `imu` and its three gyros, the `minute`-th minute after a fixed instant.
pub fn paper_record(imu: usize, minute: usize) -> Value {
    let mut record = document("paper.json");
    record["imu"] = format!("IMU-{imu}").into();
    for (i, gyro) in record["gyros"].as_array_mut().unwrap().iter_mut().enumerate() {
        gyro["serial"] = format!("G-{imu}-{i}").into();
    }
    let at = jiff::Timestamp::from_second(1_000_000_000 + 60 * minute as i64).unwrap();
    record["calibrated_at"] = at.to_string().into();
    record
}

/// The service of this build, or the one that `scripts/soak` is told to put to the test (an absolute path), such as a
/// release build.
fn program() -> String {
    std::env::var("GYROWATCH_SOAK_PROGRAM").unwrap_or_else(|_| env!("CARGO_BIN_EXE_gyrowatch").to_owned())
}

/// The command line program, free of the tester's own GYROWATCH_ variables.
pub fn gyrowatch() -> Command {
    gyrowatch_under(&[])
}

/// The program, by one that turns into it.
pub fn gyrowatch_under(under: &[&str]) -> Command {
    let program = program();
    let words = [under, &[program.as_str()]].concat();
    let mut command = Command::new(words[0]);
    command.args(&words[1..]);
    for (name, _) in std::env::vars().filter(|(name, _)| name.starts_with("GYROWATCH_")) {
        command.env_remove(name);
    }
    command
}

/// How often, how many: `otherwise`, unless the long form (`scripts/soak`) asks for more.
pub fn asked(name: &str, otherwise: usize) -> usize {
    std::env::var(name).map_or(otherwise, |text| text.parse().unwrap())
}

/// What a test makes up follows from this and the number of the round: a round that fails says its own, and
/// `GYROWATCH_SOAK_SEED` repeats it. `scripts/soak` gives a fresh one.
pub fn seed(round: usize) -> u64 {
    (asked("GYROWATCH_SOAK_SEED", 1) + round) as u64
}

/// Whether a program that a test drives is there. `scripts/test` installs it where it can, and then its absence is a
/// failure.
pub fn required(program: &str) -> bool {
    let there = std::env::var_os("PATH")
        .is_some_and(|path| std::env::split_paths(&path).any(|dir| dir.join(program).is_file()));
    if !there {
        assert_ne!(std::env::var("GYROWATCH_TEST_PROGRAMS").as_deref(), Ok("required"), "no {program}");
        println!("passed over: there is no {program}");
    }
    there
}

pub fn is_root() -> bool {
    std::fs::metadata("/proc/self").is_ok_and(|own| std::os::unix::fs::MetadataExt::uid(&own) == 0)
}

/// Words that make a file system of `size` in memory at the directory that follows, which only the service sees, and
/// then run it.
pub fn on_a_small_disk(options: &str) -> Vec<String> {
    let script = format!("mount -t tmpfs -o {options} none \"$0\" && cd \"$0\" && exec \"$@\"");
    let namespaces = if is_root() { "-m" } else { "-rm" };
    ["unshare", namespaces, "sh", "-c", &script].map(str::to_owned).into()
}

/// Whether such a file system can be had here.
pub fn small_disks_work() -> bool {
    if !required("unshare") {
        return false;
    }
    let dir = tempfile::tempdir().unwrap();
    let words = on_a_small_disk("size=1m");
    let tried = Command::new(&words[0]).args(&words[1..]).arg(dir.path()).arg("true").output().unwrap();
    if !tried.status.success() {
        println!("passed over: no file system can be mounted here: {}", String::from_utf8_lossy(&tried.stderr));
    }
    tried.status.success()
}

/// Takes all room that is left.
pub fn fill(file: &Path) {
    let mut filler = File::options().create(true).append(true).open(file).unwrap();
    for size in [1 << 16, 1 << 12, 1] {
        while filler.write_all(&vec![0; size]).is_ok() {}
    }
}

/// Of what was stored or set up.
#[track_caller]
pub fn id(answer: &Value) -> &str {
    answer["id"].as_str().unwrap_or_else(|| panic!("no identifier: {answer}"))
}

#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub content_type: String,
    pub headers: HeaderMap,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn text(&self) -> String {
        String::from_utf8(self.body.clone()).unwrap()
    }

    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&self.body)))
    }

    /// The answer, which has this status.
    #[track_caller]
    pub fn has(&self, status: u16) -> &Self {
        assert_eq!(self.status, status, "{}", self.text());
        self
    }

    #[track_caller]
    pub fn created(&self) -> Value {
        self.has(201).json()
    }
}

pub struct Server {
    child: Child,
    address: String,
    dir: tempfile::TempDir,
    settings: Vec<(String, String)>,
    http: reqwest::Client,
}

impl Server {
    pub async fn start() -> Self {
        Self::start_with(&[]).await
    }

    /// With `GYROWATCH_…` variables beside the address and the database.
    pub async fn start_with(settings: &[(&str, &str)]) -> Self {
        if cluster::is_wanted() && !settings.iter().any(|(name, _)| *name == "GYROWATCH_DATABASE_URL") {
            let url = cluster::fresh_database().await;
            let lease = cluster::LEASE_S.to_string();
            let on_server = [("GYROWATCH_DATABASE_URL", url.as_str()), ("GYROWATCH_DATABASE__LEASE_S", &lease)];
            let settings = [settings, &on_server].concat();
            return Self::start_under(&[], tempfile::tempdir().unwrap(), &settings);
        }
        Self::start_under(&[], tempfile::tempdir().unwrap(), settings)
    }

    /// In `dir`, the first time by a program that turns into the service, as `strace -D` does.
    pub fn start_under(under: &[&str], dir: tempfile::TempDir, settings: &[(&str, &str)]) -> Self {
        system::install_crypto();
        let settings: Vec<_> = settings.iter().map(|&(name, value)| (name.to_owned(), value.to_owned())).collect();
        let (child, address) = spawn(under, dir.path(), "127.0.0.1:0", &settings);
        Self { child, address, dir, settings, http: client() }
    }

    /// The directory, with the service killed.
    pub fn into_dir(mut self) -> tempfile::TempDir {
        self.kill();
        std::mem::replace(&mut self.dir, tempfile::tempdir().unwrap())
    }

    /// Of the process of the service.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// `host:port`.
    pub fn address(&self) -> &str {
        &self.address
    }

    pub fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }

    pub fn dir(&self) -> &Path {
        self.dir.path()
    }

    /// Its database, where that is a file.
    pub fn database(&self) -> PathBuf {
        self.dir.path().join("gyrowatch.db")
    }

    /// What the service has logged so far.
    pub fn log(&self) -> String {
        std::fs::read_to_string(self.dir.path().join("log")).unwrap()
    }

    /// kill -9: nothing is finished, nothing is flushed.
    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// SIGTERM; returns how the service ended, and after how long.
    pub fn terminate(&mut self) -> (std::process::ExitStatus, Duration) {
        let started = Instant::now();
        let pid = self.child.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
        (self.child.wait().unwrap(), started.elapsed())
    }

    /// Starts again on the same address and database.
    pub fn restart(&mut self) {
        let (child, address) = spawn(&[], self.dir.path(), &self.address, &self.settings);
        (self.child, self.address) = (child, address);
        self.http = client(); // the old one holds connections to the dead
    }

    pub async fn get(&self, path: &str) -> Answer {
        self.call("GET", path, &[], Vec::new()).await
    }

    /// An answer; of [`SUMMARY`] what rests on diagnoses, once all are made.
    pub async fn settled(&self, path: &str) -> Value {
        let look = async || {
            let answer = self.get(path).await;
            assert_eq!(answer.status, 200, "{path}: {}", answer.text());
            answer.json()
        };
        once(look, |answer| path != SUMMARY || answer["campaigns"]["waiting"] == 0).await
    }

    pub async fn post(&self, path: &str, content_type: &str, body: impl Into<reqwest::Body>) -> Answer {
        self.call("POST", path, &[("content-type", content_type)], body).await
    }

    pub async fn post_json(&self, path: &str, body: &Value) -> Answer {
        self.post(path, "application/json", body.to_string()).await
    }

    /// The answer once the service has taken it; the same again is no harm.
    pub async fn takes(&self, path: &str, body: &Value) -> Value {
        let answer = once(async || self.post_json(path, body).await, |answer| answer.status != 503).await;
        assert!(matches!(answer.status, 200 | 201), "{}: {}", answer.status, answer.text());
        answer.json()
    }

    /// Sends a form from a page of `origin`.
    pub async fn send_form(&self, origin: &str, path: &str, form: impl Into<reqwest::Body>) -> Answer {
        self.call("POST", path, &[("content-type", FORM), ("origin", origin)], form).await
    }

    /// Sets up a hook.
    pub async fn sets_up(&self, hook: Value) -> Value {
        let answer = self.post_json("/v1/hooks", &hook).await;
        let hook = answer.created();
        assert_eq!(answer.headers["location"], format!("/v1/hooks/{}", id(&hook)));
        hook
    }

    /// Waits until nothing is open for a hook; its queue then.
    pub async fn all_told(&self, hook: &Value) -> Value {
        let path = format!("/v1/hooks/{}", id(hook));
        once(async || self.get(&path).await.json()["queue"].clone(), |queue| queue["open"] == 0).await
    }

    /// Six records of the paper's IMU, the last two off by enough for an alert, and a bench result.
    pub async fn stores_half_a_year(&self) {
        let mut record = document("paper.json");
        for month in 1..=6 {
            record["calibrated_at"] = format!("2026-0{month}-01T08:00:00Z").into();
            record["gyros"][0]["g_pulse_per_s_g0"][0] = (2.4210 + if month > 4 { 0.05 } else { 0.0 }).into();
            assert_eq!(self.post_json("/v1/records", &record).await.status, 201);
        }
        let bench = serde_json::json!({ "serial": "LFG-0101", "station": "BENCH-1", "measured_at": "2026-03-02T08:00:00Z",
            "method": "torque_feedback", "d_i_deg_per_h_g0": 1.0, "d_s_deg_per_h_g0": 2.0 });
        assert_eq!(self.post_json("/v1/bench-results", &bench).await.status, 201);
    }

    /// An empty header value leaves the header out.
    pub async fn call(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: impl Into<reqwest::Body>,
    ) -> Answer {
        let mut map = HeaderMap::new();
        for (name, value) in headers.iter().filter(|(_, value)| !value.is_empty()) {
            map.insert(name.parse::<HeaderName>().unwrap(), HeaderValue::from_str(value).unwrap());
        }
        let request = self.http.request(method.parse().unwrap(), self.url(path)).headers(map).body(body);
        let answer = request.send().await.unwrap_or_else(|e| panic!("{method} {path}: {e:?}\n{}", self.log()));
        let (status, headers) = (answer.status().as_u16(), answer.headers().clone());
        let content_type = headers.get("content-type").map_or(String::new(), |v| v.to_str().unwrap().to_owned());
        Answer { status, content_type, headers, body: answer.bytes().await.unwrap().to_vec() }
    }

    /// Opens a connection and sends raw text.
    pub async fn open_and_send(&self, text: &str) -> TcpStream {
        let mut stream = TcpStream::connect(&self.address).await.unwrap();
        stream.write_all(text.as_bytes()).await.unwrap();
        stream
    }

    /// How many rows each table of the database holds: what is "stored", seen from below.
    pub async fn holdings(&self) -> Vec<(String, i64)> {
        if let Some((_, url)) = self.settings.iter().find(|(name, _)| name == "GYROWATCH_DATABASE_URL") {
            return holdings_on_server(url).await;
        }
        let mut connection = behind::read(&self.database()).await;
        let tables = "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite_%' ORDER BY name";
        let mut holdings = Vec::new();
        for row in sqlx::query(tables).fetch_all(&mut connection).await.unwrap() {
            let table: String = row.get(0);
            let count = sqlx::AssertSqlSafe(format!("SELECT count(*) FROM \"{table}\""));
            let count: i64 = sqlx::query_scalar(count).fetch_one(&mut connection).await.unwrap();
            holdings.push((table, count));
        }
        holdings
    }
}

async fn holdings_on_server(url: &str) -> Vec<(String, i64)> {
    let mut connection = sqlx::PgConnection::connect(url).await.unwrap();
    let tables = "SELECT CAST(table_name AS TEXT) FROM information_schema.tables
                  WHERE table_schema = 'public' AND table_type = 'BASE TABLE'
                  AND table_name NOT IN ('turn', 'turn_commit', 'lease') ORDER BY 1";
    let mut holdings = Vec::new();
    for table in sqlx::query_scalar::<_, String>(tables).fetch_all(&mut connection).await.unwrap() {
        let count = sqlx::AssertSqlSafe(format!("SELECT count(*) FROM \"{table}\""));
        let count: i64 = sqlx::query_scalar(count).fetch_one(&mut connection).await.unwrap();
        holdings.push((table, count));
    }
    holdings
}

/// A program that is killed where its test ends.
pub struct Running(pub Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _already_gone = self.0.kill();
        let _reaped = self.0.wait();
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _already_gone = self.child.kill();
        let _reaped = self.child.wait();
        if std::thread::panicking() {
            eprintln!("--- log of the service\n{}", self.log());
        }
    }
}

/// A client that is patient with a busy machine.
pub fn client() -> reqwest::Client {
    system::http_client(Duration::from_secs(20), Duration::from_secs(240)).build().unwrap()
}

/// Reads until the other end closes.
pub async fn closed(mut stream: TcpStream) {
    let mut rest = Vec::new();
    let _reset_counts_too = stream.read_to_end(&mut rest).await;
}

/// Starts `gyrowatch serve`, and waits for the line that names its address. Without tokens this machine may do
/// everything, unless `settings` say otherwise; an empty value leaves a variable out.
fn spawn(under: &[&str], dir: &Path, listen: &str, settings: &[(String, String)]) -> (Child, String) {
    let log = File::options().create(true).append(true).open(dir.join("log")).unwrap();
    let left_out = |name: &str| settings.iter().any(|(other, value)| other == name && value.is_empty());
    let given = |(name, _): &&(String, String)| !left_out(name);
    let pair = |(name, value): &(String, String)| (name.clone(), value.clone());
    let mut child = gyrowatch_under(under)
        .arg("serve")
        .current_dir(dir)
        .env("GYROWATCH_LISTEN", listen)
        .env("GYROWATCH_DATABASE_URL", file_url(&dir.join("gyrowatch.db")))
        .envs([("GYROWATCH_ACCESS__OPEN".to_owned(), "true".to_owned())].iter().chain(settings).filter(given).map(pair))
        .stdout(Stdio::piped())
        .stderr(log)
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let Some((_, address)) = line.trim().split_once("://") else {
        let _reaped = child.wait();
        panic!("the service did not start: {line}\n{}", std::fs::read_to_string(dir.join("log")).unwrap());
    };
    (child, address.to_owned())
}
