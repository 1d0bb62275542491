//! PostgreSQL under Patroni: its leader dies or hands over while records arrive, and nothing acknowledged is lost.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdout};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::command::verified;
use crate::prelude::*;
use crate::support::{free_port, required};
use gyrowatch::system;
use sqlx::{Connection, PgConnection};

const SENDERS: usize = 4;
/// Within which a leader that is gone is followed by another, and the old one has caught up again.
const PATIENCE: Duration = Duration::from_secs(120);

/// Runs etcd, and Patroni as often as it is told to, until the standard input ends; then all goes, as in a crash.
const KEEPER: &str = r#"
dir=$1 client=$2 peer=$3
etcd --data-dir "$dir/etcd" --listen-client-urls "$client" --advertise-client-urls "$client" --listen-peer-urls "$peer" \
    --initial-advertise-peer-urls "$peer" --initial-cluster "default=$peer" >"$dir/etcd.log" 2>&1 </dev/null &
etcd=$!
start() {
    patroni "$dir/$1.yml" >>"$dir/$1.log" 2>&1 </dev/null &
    echo $! >"$dir/$1.pid"
}
# A whole host: Patroni, and PostgreSQL, which goes on without it.
crash() {
    patroni=$(cat "$dir/$1.pid") server=$(head -1 "$dir/$1/postmaster.pid")
    kill -9 "$patroni"
    kill -STOP "$server"
    pkill -9 -P "$server"
    kill -9 "$server"
    wait "$patroni"
}
while read -r word node; do
    "$word" "$node"
    echo
done
crash a
crash b
kill -9 "$etcd"
rm -rf "$dir"
"#;

struct Patroni {
    keeper: Child,
    said: BufReader<ChildStdout>,
    dir: PathBuf,
    nodes: [Node; 2],
    http: reqwest::Client,
}

#[derive(Clone, Copy)]
struct Node {
    name: &'static str,
    postgres: u16,
    rest: u16,
}

impl Patroni {
    async fn start() -> Self {
        let node = |name| Node { name, postgres: free_port(), rest: free_port() };
        let (nodes, etcd) = ([node("a"), node("b")], free_port());
        let dir = std::env::temp_dir().join(format!("gyrowatch-patroni-{etcd}"));
        let made = cluster::as_postgres(&["mkdir", "-m", "700"]).arg(&dir).status().unwrap();
        assert!(made.success(), "{dir:?} cannot be made");
        for node in &nodes {
            // YAML takes JSON.
            let mut write = cluster::as_postgres(&["sh", "-c", r#"cat >"$0""#]);
            let mut write = write.arg(dir.join(format!("{}.yml", node.name))).stdin(Stdio::piped()).spawn().unwrap();
            write.stdin.take().unwrap().write_all(settings(node, &dir, etcd).to_string().as_bytes()).unwrap();
            assert!(write.wait().unwrap().success());
        }
        let url = |port: u16| format!("http://127.0.0.1:{port}");
        let mut keeper = cluster::as_postgres(&["sh", "-c", KEEPER, "keeper"]);
        let keeper = keeper.arg(&dir).args([url(etcd), url(free_port())]);
        let mut keeper = keeper.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let said = BufReader::new(keeper.stdout.take().unwrap());
        system::install_crypto();
        let http = system::http_client(Duration::from_secs(2), Duration::from_secs(10)).build().unwrap();
        let mut patroni = Self { keeper, said, dir, nodes, http };
        patroni.tell("start a");
        patroni.until_all_is_well().await;
        patroni
    }

    fn tell(&mut self, order: &str) {
        writeln!(self.keeper.stdin.as_mut().unwrap(), "{order}").unwrap();
        self.said.read_line(&mut String::new()).unwrap();
    }

    /// The members as one of them sees them.
    async fn members(&self) -> Vec<Value> {
        for node in &self.nodes {
            let asked = self.http.get(format!("http://127.0.0.1:{}/cluster", node.rest)).send().await;
            if let Ok(answer) = asked
                && let Ok(said) = serde_json::from_str::<Value>(&answer.text().await.unwrap())
            {
                return said["members"].as_array().cloned().unwrap_or_default();
            }
        }
        Vec::new()
    }

    /// Place of the member that has a role, and is at work.
    async fn with_role(&self, role: &str) -> Option<usize> {
        let members = self.members().await;
        let at_work = |state: &Value| ["running", "streaming"].contains(&state.as_str().unwrap_or_default());
        let found = members.iter().find(|member| member["role"] == role && at_work(&member["state"]))?;
        self.nodes.iter().position(|node| found["name"] == node.name)
    }

    /// A leader, and a standby that has every commit before it is acknowledged; the second node begins once there is a
    /// first. Returns the leader.
    async fn until_all_is_well(&mut self) -> usize {
        let end = Instant::now() + PATIENCE;
        loop {
            let leader = self.with_role("leader").await;
            if let (Some(leader), Some(_)) = (leader, self.with_role("sync_standby").await) {
                return leader;
            }
            if leader.is_some() && !self.dir.join("b.pid").exists() {
                self.tell("start b");
            }
            let log = || std::fs::read_to_string(self.dir.join("a.log")).unwrap_or_default();
            assert!(Instant::now() < end, "{:?}: {}", self.members().await, log());
            tokio::time::sleep(Duration::from_millis(200)).await;
        }
    }

    fn url(&self, node: usize, database: &str) -> String {
        format!("postgres://postgres@127.0.0.1:{}/{database}", self.nodes[node].postgres)
    }

    /// As a service is told of both: the one that takes writes is found.
    fn url_of_both(&self, database: &str) -> String {
        let [a, b] = self.nodes.map(|node| format!("127.0.0.1:{}", node.postgres));
        format!("postgres://postgres@{a},{b}/{database}?target_session_attrs=read-write")
    }

    async fn switch_over(&self, from: usize) {
        let names = json!({ "leader": self.nodes[from].name, "candidate": self.nodes[1 - from].name });
        let asked = self.http.post(format!("http://127.0.0.1:{}/switchover", self.nodes[from].rest));
        let answer = asked.body(names.to_string()).send().await.unwrap();
        assert!(answer.status().is_success(), "{}", answer.text().await.unwrap());
    }
}

impl Drop for Patroni {
    fn drop(&mut self) {
        drop(self.keeper.stdin.take());
        let _reaped = self.keeper.wait();
    }
}

fn settings(node: &Node, dir: &Path, etcd: u16) -> Value {
    let at = |port: u16| format!("127.0.0.1:{port}");
    json!({
        "scope": "gyros",
        "name": node.name,
        "restapi": { "listen": at(node.rest), "connect_address": at(node.rest) },
        "etcd3": { "host": at(etcd) },
        "bootstrap": {
            "dcs": {
                "ttl": 6, "loop_wait": 1, "retry_timeout": 2, "synchronous_mode": true,
                "postgresql": { "use_pg_rewind": true, "parameters": { "shared_buffers": "32MB" } },
            },
            "initdb": [{ "auth": "trust" }, { "encoding": "UTF8" }, { "locale": "C" }],
        },
        "postgresql": {
            "listen": at(node.postgres),
            "connect_address": at(node.postgres),
            "data_dir": dir.join(node.name),
            "pgpass": dir.join(format!("{}.pass", node.name)),
            "bin_dir": cluster::programs().unwrap(),
            "authentication": { "superuser": { "username": "postgres" }, "replication": { "username": "postgres" } },
            "parameters": { "unix_socket_directories": dir },
            "pg_hba": ["local all all trust", "host all all 127.0.0.1/32 trust", "host replication all 127.0.0.1/32 trust"],
        },
    })
}

/// `scripts/soak patroni` does this 20 times; every other time the leader hands over instead of dying.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_leader_that_dies_or_hands_over_under_load_loses_nothing() {
    if !cluster::is_there() || !required("patroni") || !required("etcd") {
        return;
    }
    let rounds = support::asked("GYROWATCH_SOAK_PATRONI", 1);
    let mut patroni = Patroni::start().await;
    let mut leader = patroni.until_all_is_well().await;
    let mut admin = PgConnection::connect(&patroni.url(leader, "postgres")).await.unwrap();
    sqlx::query("CREATE DATABASE gyros").execute(&mut admin).await.unwrap();
    let url = patroni.url_of_both("gyros");
    let keys = [("GYROWATCH_DATABASE_URL", &*url), ("GYROWATCH_DATABASE__LEASE_S", "3")];
    let server = Server::start_with(&keys).await;

    let acknowledged: [AtomicUsize; SENDERS] = Default::default();
    let all = || acknowledged.iter().map(|sent| sent.load(Ordering::SeqCst)).sum::<usize>();
    let over = AtomicBool::new(false);
    let sending = async |sender: usize| {
        let mut busy = 0;
        while !over.load(Ordering::SeqCst) {
            let minute = acknowledged[sender].load(Ordering::SeqCst);
            let answer = server.post_json("/v1/records", &paper_record(sender, minute)).await;
            match answer.status {
                200 | 201 => _ = acknowledged[sender].fetch_add(1, Ordering::SeqCst),
                503 => {
                    busy += 1;
                    tokio::time::sleep(Duration::from_millis(50)).await;
                }
                status => panic!("{status}: {}", answer.text()),
            }
        }
        busy
    };
    let beyond = async |count: usize| {
        let end = Instant::now() + PATIENCE;
        while all() < count {
            assert!(Instant::now() < end, "{} of {count} are acknowledged\n{}", all(), server.log());
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    };
    let failing = async {
        let mut longest = Duration::ZERO;
        for round in 0..rounds {
            beyond(all() + 20).await;
            let (old, before, begun) = (leader, all(), Instant::now());
            match round % 2 {
                0 => patroni.tell(&format!("crash {}", patroni.nodes[old].name)),
                _ => patroni.switch_over(old).await,
            }
            // What was on its way may still be acknowledged.
            beyond(before + 2 * SENDERS + 1).await;
            while patroni.with_role("leader").await.is_none_or(|leader| leader == old) {
                assert!(begun.elapsed() < PATIENCE, "{:?}", patroni.members().await);
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
            beyond(all() + 1).await;
            longest = longest.max(begun.elapsed());
            if round % 2 == 0 {
                patroni.tell(&format!("start {}", patroni.nodes[old].name));
            }
            leader = patroni.until_all_is_well().await;
            assert_ne!(leader, old, "round {round}");
        }
        over.store(true, Ordering::SeqCst);
        longest
    };
    let (a, b, c, d, longest) = tokio::join!(sending(0), sending(1), sending(2), sending(3), failing);

    for (sender, sent) in acknowledged.iter().enumerate() {
        let trend = server.get(&format!("/v1/gyros/G-{sender}-0/trend?last=100000")).await;
        let points = trend.json()["points"].as_array().unwrap().len();
        assert_eq!(points, sent.load(Ordering::SeqCst), "each of sender {sender} is there once");
    }
    verified(&patroni.url(leader, "gyros"));
    println!(
        "{rounds} failovers, {} acknowledged, 0 lost; {} answered 503; writing again within {longest:?}",
        all(),
        a + b + c + d
    );
}
