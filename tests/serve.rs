//! Starting and stopping the service, as an init system or an engineer at the terminal does.

use tokio::io::{AsyncReadExt, AsyncWriteExt};

use crate::prelude::*;

#[tokio::test]
async fn it_says_where_it_listens_and_that_it_lives() {
    let server = Server::start().await;
    assert!(server.address().starts_with("127.0.0.1:") && !server.address().ends_with(":0"));
    assert_eq!(server.get("/healthz").await.status, 200);
    assert_eq!(server.get("/openapi.json").await.json()["openapi"], "3.1.0");
    assert_eq!(server.get("/docs").await.status, 200);
}

#[tokio::test]
async fn told_to_stop_it_stops_cleanly_and_soon() {
    let mut server = Server::start().await;
    assert_eq!(server.get("/healthz").await.status, 200);
    let (status, took) = server.terminate();
    assert!(status.success(), "{status}");
    assert!(took < Duration::from_secs(5), "{took:?}");
    server.restart();
    assert_eq!(server.get("/healthz").await.status, 200);
}

#[tokio::test]
async fn a_wrong_setting_stops_the_start_and_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let taken = taken.local_addr().unwrap().to_string();
    for (name, value, named) in [
        ("GYROWATCH_SERVER__COLOUR", "red", "colour"),
        ("GYROWATCH_JUDGING__BUDGET", "-1", "judging.budget"),
        ("GYROWATCH_JUDGING__METHOD", "guess", "judging.method"),
        ("GYROWATCH_LOG__FILTER", "loud", "log.filter"),
        ("GYROWATCH_LISTEN", "nowhere", "listen"),
        ("GYROWATCH_LISTEN", taken.as_str(), "listen"),
    ] {
        let output = gyrowatch()
            .arg("serve")
            .current_dir(dir.path())
            .env("GYROWATCH_LISTEN", "127.0.0.1:0")
            .env(name, value)
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{name}={value}: {stderr}");
        assert!(stderr.contains(named), "{name}={value}: {stderr}");
    }
}

/// curl does so before it sends more than a mebibyte, and waits for a second where it is not told.
#[tokio::test]
async fn who_asks_whether_to_send_a_body_is_told_to_go_on_before_anything_else() {
    let server = Server::start().await;
    let record = include_str!("data/paper.json").replace('\n', "");
    for (path, media_type) in [("/v1/import", "application/x-ndjson"), ("/v1/records", "application/json")] {
        let head = format!(
            "POST {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nExpect: 100-continue\r\n\
             Content-Type: {media_type}\r\nContent-Length: {}\r\n\r\n",
            record.len()
        );
        let mut stream = server.open_and_send(&head).await;
        let mut told = [0; "HTTP/1.1 100 Continue\r\n\r\n".len()];
        let told_at_all = tokio::time::timeout(Duration::from_secs(5), stream.read_exact(&mut told)).await;
        told_at_all.unwrap_or_else(|_| panic!("{path}: nothing is said before the body")).unwrap();
        assert_eq!(String::from_utf8_lossy(&told), "HTTP/1.1 100 Continue\r\n\r\n", "{path}");
        stream.write_all(record.as_bytes()).await.unwrap();
        let mut answer = String::new();
        let answered = tokio::time::timeout(Duration::from_secs(20), stream.read_to_string(&mut answer)).await;
        answered.unwrap_or_else(|_| panic!("{path}: no end of the answer")).unwrap();
        assert!(answer.starts_with("HTTP/1.1 20") && answer.contains("\"id\":"), "{path}: {answer}");
    }
}

#[tokio::test]
async fn an_http_1_1_request_without_a_host_is_refused() {
    let server = Server::start().await;
    for (request, expected) in [
        ("GET /healthz HTTP/1.1\r\nConnection: close\r\n\r\n", "HTTP/1.1 400"),
        ("GET http://localhost/healthz HTTP/1.1\r\nConnection: close\r\n\r\n", "HTTP/1.1 400"),
        ("GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n", "HTTP/1.1 200"),
        ("GET /healthz HTTP/1.0\r\n\r\n", "HTTP/1.0 200"),
    ] {
        let mut stream = server.open_and_send(request).await;
        let mut answer = String::new();
        stream.read_to_string(&mut answer).await.unwrap();
        assert!(answer.starts_with(expected), "{request}{answer}");
    }
}

const PARENT: &str = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";

#[tokio::test]
async fn every_answer_says_what_browsers_and_traces_need() {
    let server = Server::start_with(&[("GYROWATCH_LOG__FILTER", "gyrowatch=debug")]).await;
    for path in
        ["/", "/healthz", "/metrics", "/openapi.json", "/docs", "/docs/records", "/v1/gyros", "/v1/nothing", "/nowhere"]
    {
        let answer = server.get(path).await;
        assert_eq!(answer.headers["x-content-type-options"], "nosniff", "{path}");
        assert!(!answer.headers.contains_key("strict-transport-security"), "{path}: nothing is encrypted");
        let (id, parent) = (answer.headers["x-request-id"].to_str().unwrap(), &answer.headers["traceparent"]);
        assert!(id.len() == 32 && parent.to_str().unwrap().contains(id), "{path}: {id}, {parent:?}");
    }
    // Nothing inline is a style or runs, and what describes the API is no exception.
    for path in ["/", "/docs", "/docs/records"] {
        let policy = server.get(path).await.headers["content-security-policy"].clone();
        let policy = policy.to_str().unwrap();
        assert!(policy.starts_with("default-src 'none'; script-src 'self'") && !policy.contains("unsafe"), "{policy}");
    }

    let sent = [("x-request-id", "station-7/1"), ("traceparent", PARENT)];
    let answer = server.call("GET", "/v1/gyros?limit=3", &sent, "").await;
    assert_eq!(
        (&answer.headers["x-request-id"], &answer.headers["traceparent"]),
        (&"station-7/1".parse().unwrap(), &PARENT.parse().unwrap())
    );
    let wrong = server
        .call("GET", "/v1/gyros", &[("x-request-id", "a b"), ("authorization", "Bearer x"), ("traceparent", "x")], "")
        .await;
    assert_ne!(wrong.headers["x-request-id"], "a b");
    let log = server.log();
    let told = log.lines().find(|line| line.contains("station-7/1")).unwrap_or_else(|| panic!("{log}"));
    for part in ["DEBUG", "answered", "GET", "/v1/gyros", "status=200", PARENT, "client=127.0.0.1", "took_ms="] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(!told.contains("limit=3"), "a query may hold what is nobody's business: {told}");
    // What goes wrong on the way names the request that it went wrong with.
    let id = wrong.headers["x-request-id"].to_str().unwrap();
    assert!(log.lines().any(|line| line.contains("a wrong token") && line.contains(id)), "{log}");
}

#[tokio::test]
async fn connections_beyond_the_limit_wait_until_there_is_room() {
    let server = Server::start_with(&[("GYROWATCH_SERVER__MAX_CONNECTIONS", "2")]).await;
    let request = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
    let (first, _second) = (server.open_and_send("").await, server.open_and_send("").await);
    let mut third = server.open_and_send(request).await;
    let mut text = [0; 12];
    let early = tokio::time::timeout(Duration::from_millis(500), third.read_exact(&mut text)).await;
    assert!(early.is_err(), "it was answered beside two others");
    drop(first);
    tokio::time::timeout(Duration::from_secs(5), third.read_exact(&mut text)).await.expect("there is room").unwrap();
    assert_eq!(&text, b"HTTP/1.1 200");
}
