//! Starting and stopping the service, as an init system or an engineer at the terminal does.

mod support;

use std::time::Duration;

use support::{Server, gyrowatch};

#[tokio::test]
async fn it_says_where_it_listens_and_that_it_lives() {
    let server = Server::start().await;
    assert!(server.address().starts_with("127.0.0.1:") && !server.address().ends_with(":0"));
    assert_eq!(server.get("/healthz").await.status, 200);
    assert_eq!(server.get("/openapi.json").await.json()["openapi"], "3.1.0");
    assert_eq!(server.get("/docs/").await.status, 200);
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
