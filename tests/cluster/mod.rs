//! PostgreSQL for tests: a server of their own on a free port of this machine, which ends with the process that
//! started it, however that ends, and takes its files along.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::support::{free_port, is_root};
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

/// The same; none where there is no PostgreSQL.
pub async fn database_if_there() -> Option<String> {
    if is_there() { Some(fresh_database().await) } else { None }
}

/// The one number that a query answers.
pub async fn count(url: &str, sql: &'static str) -> i64 {
    let mut connection = PgConnection::connect(url).await.unwrap();
    sqlx::query_scalar(sql).fetch_one(&mut connection).await.unwrap()
}

/// A server of one's own.
pub struct Cluster {
    keeper: Child,
    said: BufReader<ChildStdout>,
    dir: PathBuf,
    port: u16,
    databases: AtomicUsize,
}

/// What lies on a small disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Crowded {
    /// Everything of the server's.
    Everything,
    /// Its write-ahead log; for the data there is room.
    Log,
}

/// Runs the server until the standard input ends, and then kills it as a crash would; its files go. Meanwhile it does
/// what each line says, and says when it is done.
const KEEPER: &str = r#"
programs=$1 dir=$2 port=$3
shift 3
start() {
    "$programs/postgres" -D "$dir/data" -k "$dir" -p "$port" -c listen_addresses=127.0.0.1 -c max_connections=200 \
        -c shared_buffers=32MB "$@" >>"$dir/log" 2>&1 </dev/null &
    server=$!
}
crash() {
    kill -QUIT "$server"
    wait "$server"
}
look() { kill -0 "$server"; }
start "$@"
while read -r word; do
    if "$word" "$@"; then echo yes; else echo no; fi
done
crash
rm -rf "$dir"
"#;

/// Mounts a small disk, puts what is to lie there onto it, and runs the keeper, all but the first as somebody who may
/// start a server. Segments of the log are as small as they get and none is used again: a server ends where it cannot
/// begin the next one.
const ON_A_SMALL_DISK: &str = r#"
dir=$1 size=$2 template=$3 what=$4 programs=$5
shift 5
mount -t tmpfs -o "size=$size,mode=700" none "$dir/disk" && chown --reference="$dir" "$dir/disk" || exit
"$@" sh -c '
    dir=$1 template=$2 what=$3 programs=$4
    if [ "$what" = Everything ]; then ln -s disk "$dir/data"; else mkdir -m 700 "$dir/data"; fi
    cp -r "$template/data/." "$dir/data" && "$programs/pg_resetwal" --wal-segsize=1 -D "$dir/data" || exit
    if [ "$what" = Log ]; then mv "$dir"/data/pg_wal/* "$dir/disk" && rmdir "$dir/data/pg_wal" && ln -s "$dir/disk" "$dir/data/pg_wal"; fi
' put "$dir" "$template" "$what" "$programs" >/dev/null || exit
"$@" sh -c "$KEEPER" keeper "$programs" "$dir" "$PORT" -c wal_recycle=off
umount "$dir/disk"
rm -rf "$dir"
"#;

impl Cluster {
    pub fn start() -> Self {
        let template = template();
        let (dir, port) = place();
        let copied = as_postgres(&["cp", "-r"]).arg(&template).arg(&dir).status().unwrap();
        assert!(copied.success(), "{template:?} cannot be copied to {dir:?}");
        let mut keeper = as_postgres(&["sh", "-c", KEEPER, "keeper"]);
        keeper.arg(programs().unwrap()).arg(&dir).arg(port.to_string());
        Self::kept(keeper, dir, port)
    }

    /// A standby that follows this server, until it is promoted or this one is gone.
    pub fn standby(&self) -> Self {
        let (dir, port) = place();
        let made = as_postgres(&["mkdir", "-m", "700"]).arg(&dir).status().unwrap();
        assert!(made.success(), "{dir:?} cannot be made");
        let programs = programs().unwrap();
        let copied = as_postgres(&[programs.join("pg_basebackup").to_str().unwrap(), "--write-recovery-conf"])
            .args(["--checkpoint=fast", "--wal-method=stream", "--dbname"])
            .arg(self.url("postgres"))
            .arg("--pgdata")
            .arg(dir.join("data"))
            .output()
            .unwrap();
        assert!(copied.status.success(), "{}", String::from_utf8_lossy(&copied.stderr));
        let mut keeper = as_postgres(&["sh", "-c", KEEPER, "keeper"]);
        keeper.arg(programs).arg(&dir).arg(port.to_string());
        Self::kept(keeper, dir, port)
    }

    /// The server ends at once, as in a crash, and stays down.
    pub fn crash(&mut self) {
        self.tell("crash");
    }

    /// A standby becomes a server of its own.
    pub async fn promote(&self) {
        let mut connection = PgConnection::connect(&self.url("postgres")).await.unwrap();
        let promoted: bool = sqlx::query_scalar("SELECT pg_promote()").fetch_one(&mut connection).await.unwrap();
        assert!(promoted);
    }

    pub fn address(&self) -> std::net::SocketAddr {
        (std::net::Ipv4Addr::LOCALHOST, self.port).into()
    }

    /// With a part of it on a disk of `size` in memory, which none but the server sees.
    pub fn start_on_a_small_disk(size: &str, what: Crowded) -> Self {
        let template = template();
        let (dir, port) = place();
        let made = as_postgres(&["mkdir", "-m", "700"]).arg(&dir).arg(dir.join("disk")).status().unwrap();
        assert!(made.success(), "{dir:?} cannot be made");
        // Who is root in a space of their own is nobody in particular in one inside of it, as PostgreSQL wants it.
        let (namespaces, user): (_, &[&str]) = if is_root() {
            ("-m", &["runuser", "-u", "postgres", "--"])
        } else {
            ("-rm", &["unshare", "-U", "--map-user=1000"])
        };
        let mut keeper = Command::new("unshare");
        keeper.args([namespaces, "sh", "-c", ON_A_SMALL_DISK, "disk"]).arg(&dir).arg(size).arg(template);
        keeper.arg(format!("{what:?}")).arg(programs().unwrap()).args(user);
        keeper.env("KEEPER", KEEPER).env("PORT", port.to_string()).current_dir(std::env::temp_dir());
        Self::kept(keeper, dir, port)
    }

    fn kept(mut keeper: Command, dir: PathBuf, port: u16) -> Self {
        let mut keeper = keeper.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let said = BufReader::new(keeper.stdout.take().unwrap());
        let cluster = Self { keeper, said, dir, port, databases: AtomicUsize::new(0) };
        cluster.comes_up();
        cluster
    }

    /// kill -9 of the whole server, in effect, and a new start on the same files.
    pub fn crash_and_restart(&mut self, pause: Duration) {
        self.tell("crash");
        std::thread::sleep(pause);
        self.start_again();
    }

    /// Starts a server that has ended, as whoever looks after it would.
    pub fn start_again(&mut self) {
        self.tell("start");
        self.comes_up();
    }

    /// Whether the server has not ended, which it may have by itself.
    pub fn lives(&mut self) -> bool {
        self.tell("look")
    }

    fn tell(&mut self, word: &str) -> bool {
        writeln!(self.keeper.stdin.as_mut().unwrap(), "{word}").unwrap();
        let mut answer = String::new();
        self.said.read_line(&mut answer).unwrap();
        answer.trim() == "yes"
    }

    /// What the server has logged so far.
    pub fn log(&self) -> String {
        std::fs::read_to_string(self.dir.join("log")).unwrap_or_default()
    }

    /// A place on the small disk, as this process sees it.
    pub fn on_its_disk(&self, name: &str) -> PathBuf {
        format!("/proc/{}/root{}/disk/{name}", self.keeper.id(), self.dir.display()).into()
    }

    fn comes_up(&self) {
        let programs = programs().unwrap();
        let patience = Instant::now() + Duration::from_secs(120);
        let port = self.port.to_string();
        let is_ready = || {
            let mut command = Command::new(programs.join("pg_isready"));
            command.args(["-q", "-h", "127.0.0.1", "-p", &port]).status().unwrap().success()
        };
        while !is_ready() {
            assert!(Instant::now() < patience, "PostgreSQL does not start: {}", self.log());
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

/// A directory that is not there yet, and a free port.
fn place() -> (PathBuf, u16) {
    let port = free_port();
    (std::env::temp_dir().join(format!("gyrowatch-postgres-{}-{port}", std::process::id())), port)
}

/// PostgreSQL refuses to run as root.
pub fn as_postgres(words: &[&str]) -> Command {
    let under: &[&str] = if is_root() { &["runuser", "-u", "postgres", "--"] } else { &[] };
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
