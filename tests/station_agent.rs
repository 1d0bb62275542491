//! `gyrowatch import --watch` against the real service: files are sent, kept while the service is down, moved when
//! their fate is known.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};

use crate::prelude::*;

fn agent(dir: &Path, server: &Server) -> Command {
    let mut command = gyrowatch();
    command.args(["import", "--settle", "0", "--url", server.address(), "--watch"]).arg(dir);
    command
}

fn watches(dir: &Path, server: &Server) -> Running {
    Running(agent(dir, server).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
}

async fn appears(path: &Path) {
    once(async || (path, path.exists()), |(_, there)| *there).await;
}

#[tokio::test]
async fn a_campaign_dropped_while_the_service_is_down_arrives_once_and_a_bad_one_is_set_aside_with_the_reason() {
    let mut server = Server::start().await;
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let campaign = data("practice/campaign-00.json");
    let _agent = watches(folder.path(), &server);
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

/// What is still open may be cut within a number; what others leave in a folder is no document.
#[tokio::test]
async fn a_table_waits_for_the_end_of_its_last_line() {
    let server = Server::start().await;
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let made = gyrowatch().args(["template", "campaign", "--format", "csv"]).output().unwrap();
    let table = String::from_utf8(made.stdout).unwrap();
    let cut = table.trim_end();
    for name in ["RUN.PART", "~$run.xlsx", "Thumbs.db", "desktop.ini"] {
        fs::write(file(name), "of others").unwrap();
    }
    fs::write(file("run.csv"), &cut[..cut.len() - 1]).unwrap();
    fs::write(file("stored.json"), data("practice/campaign-00.json")).unwrap();
    let _agent = watches(folder.path(), &server);
    appears(&file("sent/stored.json")).await;
    tokio::time::sleep(Duration::from_secs(2)).await;
    assert!(file("run.csv").exists(), "nothing says that its last number is whole");
    fs::write(file("run.csv"), table).unwrap();
    appears(&file("sent/run.csv")).await;
    for name in ["RUN.PART", "~$run.xlsx", "Thumbs.db", "desktop.ini"] {
        assert!(file(name).exists(), "{name}");
    }
    assert_eq!(fs::read_dir(file("refused")).unwrap().count(), 0);
}

/// Whoever may write to the folder cannot make the agent read, send or overwrite what lies elsewhere.
#[tokio::test]
async fn links_pipes_and_linked_directories_lead_nowhere() {
    let server = Server::start().await;
    let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let file = |name: &str| folder.path().join(name);
    let secret = elsewhere.path().join("passwords");
    fs::write(&secret, "root:secret\n").unwrap();
    fs::create_dir(file("sent")).unwrap();
    symlink(elsewhere.path(), file("refused")).unwrap();
    let mut refuses =
        Running(agent(folder.path(), &server).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap());
    let begun = Instant::now();
    while refuses.0.try_wait().unwrap().is_none() {
        assert!(begun.elapsed() < Duration::from_secs(30), "it watches");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let said = std::io::read_to_string(refuses.0.stderr.take().unwrap()).unwrap();
    assert!(said.contains("refused must be a directory"), "{said}");

    fs::remove_file(file("refused")).unwrap();
    symlink(&secret, file("a.json")).unwrap();
    symlink("/dev/zero", file("b.json")).unwrap();
    assert!(Command::new("mkfifo").arg(file("c.json")).status().unwrap().success());
    // A directory of many files, beneath the one that is watched.
    symlink(elsewhere.path(), file("d")).unwrap();
    fs::write(file("good.json"), data("practice/campaign-00.json")).unwrap();
    fs::write(file("z.json"), "{\"neither\": 1}").unwrap();
    let _agent = watches(folder.path(), &server);
    for name in ["sent/good.json", "refused/z.json"] {
        appears(&file(name)).await;
    }
    for name in ["a.json", "b.json", "c.json", "d"] {
        assert!(fs::symlink_metadata(file(name)).is_ok(), "{name} stays where it is");
    }
    assert_eq!(fs::read_dir(file("refused")).unwrap().count(), 2, "one file and its reason");
    assert_eq!(fs::read_dir(file("sent")).unwrap().count(), 1);
    let mode = fs::metadata(file("refused/z.json.reason.txt")).unwrap().permissions().mode();
    assert_eq!(mode & 0o7777, 0o600, "the reason quotes the file");

    // The directory is swapped for a link while the agent runs.
    fs::remove_dir_all(file("refused")).unwrap();
    symlink(elsewhere.path(), file("refused")).unwrap();
    fs::write(file("y.json"), "{\"neither\": 1}").unwrap();
    fs::write(file("again.json"), data("practice/campaign-00.json")).unwrap();
    appears(&file("sent/again.json")).await;
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert!(file("y.json").exists() && fs::read_dir(elsewhere.path()).unwrap().count() == 1);
}
