//! `gyrowatch import --watch` against the real service: files are sent, kept while the service is down, moved when their
//! fate is known.

mod support;

use std::fs;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use support::{Server, data, gyrowatch};

struct Agent(Child);

impl Agent {
    fn watches(dir: &Path, server: &Server) -> Self {
        let mut command = gyrowatch();
        command.args(["import", "--settle", "0", "--url", server.address(), "--watch"]).arg(dir);
        Self(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
    }
}

impl Drop for Agent {
    fn drop(&mut self) {
        let _gone = self.0.kill();
        let _reaped = self.0.wait();
    }
}

async fn appears(path: &Path) {
    let started = Instant::now();
    while !path.exists() {
        assert!(started.elapsed() < Duration::from_secs(180), "{} did not appear", path.display());
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

#[tokio::test]
async fn a_campaign_dropped_while_the_service_is_down_arrives_once_and_a_bad_one_is_set_aside_with_the_reason() {
    let mut server = Server::start().await;
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let campaign = data("practice/campaign-00.json");
    let _agent = Agent::watches(folder.path(), &server);
    fs::write(file("first.json"), &campaign).unwrap();
    appears(&file("sent/first.json")).await;

    server.kill();
    let later = campaign.replacen("2026-03-01T08:00:00Z", "2026-04-01T08:00:00Z", 1);
    fs::write(file("second.json"), &later).unwrap();
    fs::write(file("again.json"), &campaign).unwrap();
    let bad = campaign.replacen("\"duration_s\":180.0", "\"duration_s\":-180.0", 1);
    assert_ne!(bad, campaign);
    fs::write(file("bad.json"), bad).unwrap();
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert!(file("second.json").exists() && file("bad.json").exists(), "kept until their fate is known");

    server.restart();
    for name in ["sent/second.json", "sent/again.json", "refused/bad.json", "refused/bad.json.reason.txt"] {
        appears(&file(name)).await;
    }
    let reason = fs::read_to_string(file("refused/bad.json.reason.txt")).unwrap();
    assert!(reason.contains("/dwells/0/duration_s"), "{reason}");
    assert!(!file("second.json").exists() && !file("bad.json").exists());
    let trend = server.get("/v1/gyros/LFG-9000-1/trend?coefficient=D_I").await.json();
    assert_eq!(trend["points"].as_array().unwrap().len(), 2, "sent twice, stored once: {trend}");
}
