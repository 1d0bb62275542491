//! Accepts connections and serves them: with a time limit on request heads, a limit on connections, and an end that
//! lets requests in flight finish. `axum::serve` has neither limit.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::http::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;

use super::edge::Edge;
use super::tls::Tls;
use crate::config::Server;

/// Largest request head; hyper answers 431 beyond it.
const MAX_HEAD_BYTES: usize = 64 * 1024;

/// Part of the grace that requests have; the rest is for what they have left to be written.
const OF_REQUESTS: f64 = 0.75;

/// Serves until `stop` resolves, then refuses new connections and waits for requests in flight, but not for ever.
pub async fn serve(
    listener: TcpListener,
    tls: Option<Tls>,
    router: Router,
    limits: &Server,
    stop: impl Future<Output = ()>,
) {
    let connections = Arc::new(Semaphore::new(limits.max_connections));
    let graceful = GracefulShutdown::new();
    let edge = Arc::new(Edge::of(limits));
    let header_timeout = Duration::from_secs_f64(limits.header_timeout_s);
    tokio::pin!(stop);
    loop {
        let permit = tokio::select! {
            () = &mut stop => break,
            permit = connections.clone().acquire_owned() => permit.expect("the semaphore is never closed"),
        };
        let (stream, peer) = tokio::select! {
            () = &mut stop => break,
            accepted = listener.accept() => match accepted {
                Ok(accepted) => accepted,
                Err(error) => {
                    // Out of file descriptors, most likely: others finish in the meantime.
                    tracing::warn!(%error, "a connection could not be accepted");
                    tokio::time::sleep(Duration::from_millis(50)).await;
                    continue;
                }
            },
        };
        let _nagle_stays_on = stream.set_nodelay(true);
        let (router, edge) = (router.clone(), Arc::clone(&edge));
        let service = hyper::service::service_fn(move |request: Request<Incoming>| {
            let (router, edge) = (router.clone(), Arc::clone(&edge));
            async move { Ok::<_, Infallible>(edge.pass(request.map(Body::new), peer, router).await) }
        });
        let mut http = http1::Builder::new();
        http.timer(TokioTimer::new()).header_read_timeout(header_timeout).max_buf_size(MAX_HEAD_BYTES);
        let (watcher, acceptor) = (graceful.watcher(), tls.as_ref().map(Tls::acceptor));
        tokio::spawn(async move {
            let ended = match acceptor {
                None => watcher.watch(http.serve_connection(TokioIo::new(stream), service)).await,
                Some(acceptor) => match tokio::time::timeout(header_timeout, acceptor.accept(stream)).await {
                    Ok(Ok(stream)) => watcher.watch(http.serve_connection(TokioIo::new(stream), service)).await,
                    Ok(Err(error)) => return tracing::debug!(%error, %peer, "no TLS came about"),
                    Err(_) => return tracing::debug!(%peer, "no TLS came about in time"),
                },
            };
            if let Err(error) = ended {
                tracing::debug!(%error, %peer, "a connection ended early");
            }
            drop(permit);
        });
    }
    drop(listener);
    let grace = Duration::from_secs_f64(limits.shutdown_grace_s * OF_REQUESTS);
    if tokio::time::timeout(grace, graceful.shutdown()).await.is_err() {
        tracing::warn!(grace_s = grace.as_secs_f64(), "requests still in flight were cut off");
    }
}
