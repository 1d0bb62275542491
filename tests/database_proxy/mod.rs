//! What may stand between a server and its database: it leads to another host, takes its time, or falls silent.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, sleep_until};

pub struct Proxy {
    pub address: SocketAddr,
    state: Arc<State>,
}

struct State {
    target: Mutex<SocketAddr>,
    delay: Mutex<Duration>,
    /// Connections up to this one are silent: nothing is handed on, nothing is closed.
    silent_up_to: AtomicU32,
    connections: AtomicU32,
    /// Whether rows are read without being locked.
    takes_locks_away: AtomicBool,
    /// How often somebody was asked after the answer before had come.
    questions: AtomicU64,
    answered_bytes: AtomicU64,
}

impl Proxy {
    pub async fn to(target: SocketAddr) -> Self {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
        let address = listener.local_addr().unwrap();
        let state = Arc::new(State {
            target: Mutex::new(target),
            delay: Mutex::new(Duration::ZERO),
            silent_up_to: AtomicU32::new(0),
            connections: AtomicU32::new(0),
            takes_locks_away: AtomicBool::new(false),
            questions: AtomicU64::new(0),
            answered_bytes: AtomicU64::new(0),
        });
        let shared = state.clone();
        tokio::spawn(async move {
            while let Ok((client, _)) = listener.accept().await {
                tokio::spawn(shared.clone().hand_on(client));
            }
        });
        Self { address, state }
    }

    /// Before the database of that address.
    pub async fn before(url: &str) -> Self {
        let (_, host) = url.split_once('@').unwrap();
        Self::to(host.split_once('/').unwrap().0.parse().unwrap()).await
    }

    /// The same database through this.
    pub fn url(&self, url: &str) -> String {
        let (user, path) = (url.split_once('@').unwrap().0, url.rsplit_once('/').unwrap().1);
        format!("{user}@{}/{path}", self.address)
    }

    /// New connections are led there.
    pub fn leads_to(&self, target: SocketAddr) {
        *self.state.target.lock().unwrap() = target;
    }

    /// Each question takes so much longer.
    pub fn delays(&self, round_trip: Duration) {
        *self.state.delay.lock().unwrap() = round_trip / 2;
    }

    /// Those whose connections there are hear nothing any more; new ones are served.
    pub fn silences_connections(&self) {
        self.state.silent_up_to.store(self.state.connections.load(Ordering::SeqCst), Ordering::SeqCst);
    }

    /// Nobody hears anything any more, old connections and new ones alike.
    pub fn falls_silent(&self) {
        self.state.silent_up_to.store(u32::MAX, Ordering::SeqCst);
    }

    /// From now on `FOR UPDATE` is blank.
    pub fn takes_locks_away(&self) {
        self.state.takes_locks_away.store(true, Ordering::SeqCst);
    }

    pub fn questions(&self) -> u64 {
        self.state.questions.load(Ordering::SeqCst)
    }

    pub fn answered_bytes(&self) -> u64 {
        self.state.answered_bytes.load(Ordering::SeqCst)
    }
}

impl State {
    async fn hand_on(self: Arc<Self>, client: TcpStream) {
        let number = self.connections.fetch_add(1, Ordering::SeqCst) + 1;
        let target = *self.target.lock().unwrap();
        while self.is_silent(number) {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        let Ok(database) = TcpStream::connect(target).await else { return };
        for stream in [&client, &database] {
            stream.set_nodelay(true).unwrap();
        }
        let (from_client, to_client) = client.into_split();
        let (from_database, to_database) = database.into_split();
        let answered = Arc::new(AtomicU64::new(1));
        tokio::join!(
            self.pass(number, from_client, to_database, |said| {
                self.questions.fetch_add(answered.swap(0, Ordering::SeqCst), Ordering::SeqCst);
                if self.takes_locks_away.load(Ordering::SeqCst) {
                    without_locks(said);
                }
            }),
            self.pass(number, from_database, to_client, |said| {
                answered.store(1, Ordering::SeqCst);
                self.answered_bytes.fetch_add(said.len() as u64, Ordering::SeqCst);
            }),
        );
    }

    async fn pass(&self, number: u32, mut from: OwnedReadHalf, mut to: OwnedWriteHalf, passed: impl Fn(&mut [u8])) {
        let mut said = vec![0; 1 << 16];
        while let Ok(len @ 1..) = from.read(&mut said).await {
            let due = Instant::now() + *self.delay.lock().unwrap();
            sleep_until(due).await;
            while self.is_silent(number) {
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
            passed(&mut said[..len]);
            if to.write_all(&said[..len]).await.is_err() {
                return;
            }
        }
    }

    fn is_silent(&self, number: u32) -> bool {
        number <= self.silent_up_to.load(Ordering::SeqCst)
    }
}

fn without_locks(said: &mut [u8]) {
    const LOCK: &[u8] = b"FOR UPDATE";
    let places: Vec<usize> =
        said.windows(LOCK.len()).enumerate().filter(|(_, at)| *at == LOCK).map(|(k, _)| k).collect();
    places.into_iter().for_each(|k| said[k..k + LOCK.len()].fill(b' '));
}
