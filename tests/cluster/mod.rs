//! PostgreSQL for tests: a server of their own on a free port of this machine, which ends with the process that started it, however
//! that ends, and takes its files along.
#![allow(dead_code, clippy::allow_attributes, reason = "each test file compiles its own copy and uses a part of it")]

use std::fs::File;
use std::io::Write;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use sqlx::{Connection, PgConnection};

/// Of a server that a test kills: the next takes its work over within the patience of tests.
pub const LEASE_S: f64 = 2.0;

/// Whether the tests of this run that can do without a file are to use PostgreSQL.
pub fn is_wanted() -> bool {
    std::env::var("GYROWATCH_TEST_DATABASE").as_deref() == Ok("postgres")
}

/// The directory of the server's programs; none where there is no PostgreSQL.
pub fn programs() -> Option<PathBuf> {
    let mut found: Vec<PathBuf> = std::fs::read_dir("/usr/lib/postgresql")
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path().join("bin")))
        .chain(std::env::var_os("PATH").iter().flat_map(std::env::split_paths))
        .filter(|bin| ["initdb", "postgres", "pg_isready"].iter().all(|program| bin.join(program).is_file()))
        .collect();
    found.sort();
    found.pop()
}

/// Whether there is PostgreSQL. `scripts/test` installs it where it can, and then its absence is a failure.
pub fn is_there() -> bool {
    let there = programs().is_some();
    if !there {
        assert_ne!(std::env::var("GYROWATCH_TEST_PROGRAMS").as_deref(), Ok("required"), "no PostgreSQL");
        println!("passed over: there is no PostgreSQL");
    }
    there
}

/// The address of an empty database on the server that the tests of this process share.
pub async fn fresh_database() -> String {
    static SHARED: OnceLock<Cluster> = OnceLock::new();
    SHARED.get_or_init(Cluster::start).fresh_database().await
}

/// A server of one's own.
pub struct Cluster {
    keeper: Child,
    dir: PathBuf,
    port: u16,
    databases: AtomicUsize,
}

/// Runs the server until the standard input ends, then kills it as a crash would; the files go, unless `keep` was said.
const KEEPER: &str = r#"
"$1/postgres" -D "$2/data" -k "$2" -p "$3" -c listen_addresses=127.0.0.1 -c max_connections=60 -c shared_buffers=32MB \
    >>"$2/log" 2>&1 </dev/null &
server=$!
word=
read -r word
kill -QUIT "$server"
wait "$server"
[ "$word" = keep ] || rm -rf "$2"
"#;

impl Cluster {
    pub fn start() -> Self {
        let template = template();
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let dir = std::env::temp_dir().join(format!("gyrowatch-postgres-{}-{port}", std::process::id()));
        let copied = as_postgres(&["cp", "-r"]).arg(&template).arg(&dir).status().unwrap();
        assert!(copied.success(), "{template:?} cannot be copied to {dir:?}");
        let keeper = keep(&dir, port);
        let cluster = Self { keeper, dir, port, databases: AtomicUsize::new(0) };
        cluster.comes_up();
        cluster
    }

    /// kill -9 of the whole server, in effect, and a new start on the same files.
    pub fn crash_and_restart(&mut self, pause: Duration) {
        writeln!(self.keeper.stdin.as_mut().unwrap(), "keep").unwrap();
        self.keeper.wait().unwrap();
        std::thread::sleep(pause);
        self.keeper = keep(&self.dir, self.port);
        self.comes_up();
    }

    fn comes_up(&self) {
        let programs = programs().unwrap();
        let patience = Instant::now() + Duration::from_secs(30);
        let port = self.port.to_string();
        let is_ready = || {
            let mut command = Command::new(programs.join("pg_isready"));
            command.args(["-q", "-h", "127.0.0.1", "-p", &port]).status().unwrap().success()
        };
        while !is_ready() {
            let log = || std::fs::read_to_string(self.dir.join("log")).unwrap_or_default();
            assert!(Instant::now() < patience, "PostgreSQL does not start: {}", log());
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    pub fn url(&self, database: &str) -> String {
        format!("postgres://postgres@127.0.0.1:{}/{database}", self.port)
    }

    /// From now on connections may be encrypted, under this certificate.
    pub async fn speaks_tls(&self, certificate: &Path, key: &Path) {
        for (from, name) in [(certificate, "server.crt"), (key, "server.key")] {
            let mut put = as_postgres(&["install", "-m", "600", "/dev/stdin"]);
            put.arg(self.dir.join("data").join(name)).stdin(File::open(from).unwrap());
            assert!(put.status().unwrap().success(), "{name}");
        }
        let mut connection = PgConnection::connect(&self.url("postgres")).await.unwrap();
        for sql in ["ALTER SYSTEM SET ssl = on", "SELECT pg_reload_conf()"] {
            sqlx::query(sql).execute(&mut connection).await.unwrap();
        }
    }

    /// The address of an empty database.
    pub async fn fresh_database(&self) -> String {
        let name = format!("t{}", self.databases.fetch_add(1, Ordering::Relaxed));
        let mut connection = PgConnection::connect(&self.url("postgres")).await.unwrap();
        let create = sqlx::AssertSqlSafe(format!("CREATE DATABASE {name}"));
        sqlx::query(create).execute(&mut connection).await.unwrap();
        self.url(&name)
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        drop(self.keeper.stdin.take());
        let _reaped = self.keeper.wait();
    }
}

fn keep(dir: &Path, port: u16) -> Child {
    let programs = programs().unwrap();
    as_postgres(&["sh", "-c", KEEPER, "keeper"])
        .arg(programs)
        .arg(dir)
        .arg(port.to_string())
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// PostgreSQL refuses to run as root.
fn as_postgres(words: &[&str]) -> Command {
    let is_root = Command::new("id").arg("-u").output().is_ok_and(|id| id.stdout.trim_ascii() == b"0");
    let under: &[&str] = if is_root { &["runuser", "-u", "postgres", "--"] } else { &[] };
    let words = [under, words].concat();
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).current_dir(std::env::temp_dir());
    command
}

/// An empty server, made once and copied.
fn template() -> PathBuf {
    let user = Command::new("id").arg("-un").output().unwrap();
    let user = String::from_utf8(user.stdout).unwrap();
    let programs = programs().expect("PostgreSQL");
    let version = programs.parent().and_then(Path::file_name).map_or("own".into(), |name| name.to_string_lossy());
    let template = std::env::temp_dir().join(format!("gyrowatch-postgres-{}-{version}", user.trim()));
    let lock = File::create(template.with_extension("lock")).unwrap();
    lock.lock().unwrap();
    if !template.join("data/whole").exists() {
        let made = as_postgres(&["sh", "-c", r#"rm -rf "$2"; mkdir -m 700 "$2" && exec "$1/initdb" -D "$2/data" -A trust -U postgres --locale=C -E UTF8"#, "init"])
            .arg(programs)
            .arg(&template)
            .output()
            .unwrap();
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        assert!(as_postgres(&["touch"]).arg(template.join("data/whole")).status().unwrap().success());
    }
    template
}
