//! Targets of hooks on this machine: one that records what it is told, and some that misbehave.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinHandle;

/// One request as it came in.
#[derive(Debug, Clone)]
pub struct Told {
    pub at: Instant,
    pub path: String,
    pub headers: HeaderMap,
    pub body: Bytes,
}

impl Told {
    pub fn id(&self) -> String {
        self.header("webhook-id")
    }

    pub fn header(&self, name: &str) -> String {
        self.headers.get(name).map_or(String::new(), |value| value.to_str().unwrap().to_owned())
    }

    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }
}

type Answer = Arc<dyn Fn(usize, &Told) -> Response + Send + Sync>;

/// Records every request; its answers are made by a function of how many came before and of the request.
#[derive(Clone)]
pub struct Receiver {
    pub address: SocketAddr,
    told: Arc<Mutex<Vec<Told>>>,
    answer: Answer,
    gate: Arc<tokio::sync::Mutex<()>>,
}

impl Receiver {
    pub async fn start() -> Self {
        Self::answering(|_, _| ().into_response()).await
    }

    pub async fn answering(answer: impl Fn(usize, &Told) -> Response + Send + Sync + 'static) -> Self {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
        let address = listener.local_addr().unwrap();
        let receiver = Self { address, told: Arc::default(), answer: Arc::new(answer), gate: Arc::default() };
        let router = Router::new().fallback(record).with_state(receiver.clone());
        tokio::spawn(async move { axum::serve(listener, router).await });
        receiver
    }

    /// One that refuses everything while the switch is off, and the switch.
    pub async fn switched(on: bool, refusal: StatusCode) -> (Self, Arc<AtomicBool>) {
        let switch = Arc::new(AtomicBool::new(on));
        let is_on = switch.clone();
        let target = Self::answering(move |_, _| match is_on.load(Ordering::SeqCst) {
            true => ().into_response(),
            false => refusal.into_response(),
        });
        (target.await, switch)
    }

    /// While what is returned lives, requests come in and wait for their answers.
    pub async fn held(&self) -> tokio::sync::OwnedMutexGuard<()> {
        self.gate.clone().lock_owned().await
    }

    pub fn url(&self) -> String {
        format!("http://{}/hook", self.address)
    }

    pub fn told(&self) -> Vec<Told> {
        self.told.lock().unwrap().clone()
    }

    /// Waits until so many requests have come.
    pub async fn has_been_told(&self, count: usize) -> Vec<Told> {
        let patience = Instant::now() + Duration::from_secs(120);
        while self.told.lock().unwrap().len() < count {
            assert!(Instant::now() < patience, "{} of {count} requests came", self.told().len());
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        self.told()
    }
}

async fn record(State(receiver): State<Receiver>, uri: Uri, headers: HeaderMap, body: Bytes) -> Response {
    let told = Told { at: Instant::now(), path: uri.path().to_owned(), headers, body };
    let earlier = {
        let mut all = receiver.told.lock().unwrap();
        all.push(told.clone());
        all.len() - 1
    };
    drop(receiver.gate.lock().await);
    (receiver.answer)(earlier, &told)
}

/// A raw target: `talk` has the connection once the request's head and body have come in.
pub async fn raw<F>(talk: impl Fn(TcpStream) -> F + Send + 'static) -> (SocketAddr, JoinHandle<()>)
where
    F: Future<Output = std::io::Result<()>> + Send + 'static,
{
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
    let address = listener.local_addr().unwrap();
    let task = tokio::spawn(async move {
        while let Ok((mut stream, _)) = listener.accept().await {
            let mut head = [0; 4096];
            let _request = stream.read(&mut head).await;
            tokio::spawn(talk(stream));
        }
    });
    (address, task)
}

/// A target that takes the request and says `answer`, byte for byte.
pub async fn says(answer: &'static [u8]) -> SocketAddr {
    raw(move |mut stream| async move { stream.write_all(answer).await }).await.0
}

/// A target that takes the request and never says a word.
pub async fn hangs() -> SocketAddr {
    raw(|stream| async move {
        tokio::time::sleep(Duration::from_secs(600)).await;
        drop(stream);
        Ok(())
    })
    .await
    .0
}
