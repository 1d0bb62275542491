//! What a real service seldom does: answers by script, so that busy lines, poisoned files and strange proxies happen.

use std::collections::VecDeque;
use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::http::{HeaderMap, StatusCode};
use clap::Parser;

use super::send::{Event, ImportCounts, Importer};
use super::source::Content;
use super::watch::watch;
use crate::cli::client::{ClientError, Connection, JSON, Sent, Service};
use crate::system;
use crate::wire::record_table::TableMap;

/// Answers with the next line of its script, then with its last words for ever; keeps what it was sent.
#[derive(Clone)]
struct Script {
    answers: Arc<Mutex<VecDeque<(u16, String)>>>,
    otherwise: (u16, String),
    heard: Arc<Mutex<Vec<String>>>,
}

impl Script {
    fn new(answers: &[(u16, &str)], otherwise: (u16, &str)) -> Self {
        let own = |&(status, text): &(u16, &str)| (status, text.to_owned());
        Self {
            answers: Arc::new(Mutex::new(answers.iter().map(own).collect())),
            otherwise: own(&otherwise),
            heard: Arc::default(),
        }
    }

    async fn serve(self) -> Service {
        Service::at(&self.address().await, None).unwrap()
    }

    async fn address(self) -> String {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let router = axum::Router::new().fallback(move |body: String| async move {
            self.heard.lock().unwrap().push(body);
            let (status, text) = self.answers.lock().unwrap().pop_front().unwrap_or(self.otherwise);
            (StatusCode::from_u16(status).unwrap(), text)
        });
        tokio::spawn(async move { axum::serve(listener, router).await });
        system::install_crypto();
        address
    }

    fn heard(&self) -> Vec<String> {
        self.heard.lock().unwrap().clone()
    }
}

const RECORD: &str = "{\"gyros\": []}\n";
const STORED: &str = r#"{"id":"r1"}"#;
const REFUSED: &str = r#"{"title":"t","status":422,"detail":"d","errors":[{"pointer":"/imu","detail":"is missing"}]}"#;

async fn carry(service: &Service, text: &'static str) -> (anyhow::Result<ImportCounts>, Vec<String>) {
    let mut refusals = Vec::new();
    let mut tell = |event: Event<'_>| {
        if let Event::Refused(refusal) = event {
            refusals.push(refusal.to_string());
        }
    };
    let content = Content::Lines(Box::new(text.as_bytes()));
    let pauses = [Duration::ZERO; 3];
    let carried = Importer::new(service, &pauses, &mut tell).carry(content).await;
    (carried, refusals)
}

#[tokio::test]
async fn lines_that_the_service_was_too_busy_for_go_again_alone() {
    let script = Script::new(
        &[
            (503, "{}"),
            (
                200,
                "{\"status\":201}\n{\"status\":503}\n{\"status\":422,\"error\":{\"title\":\"t\",\"status\":422,\"detail\":\"no such thing\"}}\n",
            ),
        ],
        (200, "{\"status\":200}\n"),
    );
    let service = script.clone().serve().await;
    let (carried, refusals) = carry(&service, "one\n\ntwo\nthree\n").await;
    assert_eq!(carried.unwrap(), ImportCounts { stored: 1, known: 1, refused: 1 });
    assert_eq!(refusals, ["4: no such thing"], "blank lines count");
    assert_eq!(script.heard(), ["one\ntwo\nthree\n", "one\ntwo\nthree\n", "two\n"]);
}

#[tokio::test]
async fn a_conflict_is_told_with_what_stands_in_the_way_and_how_the_two_differ() {
    const DETAIL: &str = "an item with the same key is stored with other content (id r7); they differ in everything, as a record and a campaign do";
    let problem = serde_json::json!({"title": "Already stored with other content", "status": 409, "detail": DETAIL,
        "existing": "r7", "errors": [{"pointer": "", "detail": "differs from what is stored"}]});
    let line = format!("{}\n", serde_json::json!({"status": 409, "error": problem}));
    let service = Script::new(&[], (200, &line)).serve().await;
    assert_eq!(carry(&service, "one\n").await.1, [format!("1: {DETAIL}")]);
}

#[tokio::test]
async fn a_service_that_stays_busy_is_given_up_with_its_words() {
    let service = Script::new(&[], (429, r#"{"title":"t","status":429,"detail":"too many"}"#)).serve().await;
    let error = carry(&service, "one\n").await.0.unwrap_err();
    assert!(error.to_string().contains("too many"), "{error}");
}

#[tokio::test]
async fn a_page_that_answers_200_acknowledges_nothing() {
    let script = Script::new(&[], (200, "<html>Welcome to the guest network</html>"));
    let service = script.clone().serve().await;
    assert!(carry(&service, "one\n").await.0.is_err());
    assert_eq!(script.heard().len(), 1, "asking again would not help");
}

#[derive(Debug, clap::Parser)]
struct Line {
    #[command(flatten)]
    connection: Connection,
}

#[tokio::test]
async fn what_is_sent_goes_by_way_of_the_proxy_that_is_named() {
    let script = Script::new(&[], (201, STORED));
    let proxy = format!("http://{}", script.clone().address().await);
    let line = |proxy: &str| Line::try_parse_from(["import", "--url", "http://gyros.invalid", "--proxy", proxy]);
    let service = line(&proxy).unwrap().connection.service().unwrap();
    assert!(matches!(service.post("/v1/records", JSON, RECORD.into()).await, Ok(Sent::Stored(_))));
    assert_eq!(script.heard(), [RECORD]);
    let direct = line("").unwrap().connection.service().unwrap();
    assert!(matches!(direct.post("/v1/records", JSON, RECORD.into()).await, Err(ClientError::Unreachable(_))));
    assert!(line("ftp://user:secret@proxy").unwrap_err().to_string().contains("must be http://host:port"));
}

#[tokio::test]
async fn a_token_that_is_refused_is_read_again_from_its_file() {
    system::install_crypto();
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let router = axum::Router::new().fallback(|headers: HeaderMap| async move {
        let is_known = headers.get("authorization").is_some_and(|token| token == "Bearer two");
        if is_known { (StatusCode::CREATED, STORED) } else { (StatusCode::UNAUTHORIZED, "{}") }
    });
    tokio::spawn(async move { axum::serve(listener, router).await });
    let file = tempfile::NamedTempFile::new().unwrap();
    let write = |token: &str| fs::write(file.path(), token).unwrap();
    write("one");
    let path = file.path().to_str().unwrap();
    let line = Line::try_parse_from(["import", "--url", &address, "--token-file", path]).unwrap();
    let service = line.connection.service().unwrap();
    let post = async || service.post("/v1/records", JSON, RECORD.into()).await;
    assert!(matches!(post().await, Err(ClientError::Fatal { status: Some(StatusCode::UNAUTHORIZED), .. })));
    write("two\n");
    for _ in 0..2 {
        assert!(matches!(post().await, Ok(Sent::Stored(_))));
    }
}

/// Watches until `done`, or fails after ten seconds.
async fn watch_until(dir: &Path, service: &Service, digest: bool, done: impl Fn() -> bool) {
    let finished = async {
        while !done() {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    tokio::select! {
        stopped = watch(dir, TableMap::default(), Some(Duration::ZERO), service, digest) => stopped.unwrap(),
        waited = tokio::time::timeout(Duration::from_secs(10), finished) => waited.expect("it is done within ten seconds"),
    }
}

#[tokio::test]
async fn a_file_that_the_service_stumbles_over_holds_up_no_other() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("1-poison.json"), RECORD).unwrap();
    fs::write(dir.path().join("2-good.json"), RECORD).unwrap();
    let script = Script::new(&[(500, "oops"), (201, r#"{"id":"r2"}"#)], (200, r#"{"id":"r1"}"#));
    let service = script.serve().await;
    let sent = dir.path().join("sent");
    watch_until(dir.path(), &service, false, || sent.join("2-good.json").exists()).await;
    assert!(dir.path().join("1-poison.json").exists(), "it stays until it is acknowledged");
    watch_until(dir.path(), &service, false, || sent.join("1-poison.json").exists()).await;
}

#[tokio::test]
async fn what_is_refused_lies_aside_with_the_reason_and_what_is_unfinished_is_left_alone() {
    let dir = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| fs::write(dir.path().join(name), text).unwrap();
    put("bad.json", RECORD);
    put("writing.json.part", RECORD);
    put("cut.json", "{\"gyros\": [");
    put("not-json.json", "{\"gyros\" = 1}");
    let service = Script::new(&[], (422, REFUSED)).serve().await;
    let refused = dir.path().join("refused");
    let both = || refused.join("bad.json").exists() && refused.join("not-json.json").exists();
    watch_until(dir.path(), &service, false, both).await;
    assert_eq!(fs::read_to_string(refused.join("bad.json.reason.txt")).unwrap(), "/imu: is missing\n");
    let reason = fs::read_to_string(refused.join("not-json.json.reason.txt")).unwrap();
    assert!(reason.contains("line 1 column 10"), "{reason}");
    assert!(dir.path().join("writing.json.part").exists());
    assert!(dir.path().join("cut.json").exists(), "somebody may still be writing it");
}

#[tokio::test]
async fn a_wrong_token_or_address_moves_no_file() {
    for status in [401, 403, 404] {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("run.json"), RECORD).unwrap();
        let script = Script::new(&[(status, REFUSED)], (201, r#"{"id":"r1"}"#));
        let service = script.clone().serve().await;
        watch_until(dir.path(), &service, false, || !script.heard().is_empty()).await;
        assert!(dir.path().join("run.json").exists(), "{status}");
    }
}

const SAID: &str = "author: Li Wei\nreason: wrong latitude\n";

#[tokio::test]
async fn a_revision_whose_answer_was_lost_is_done_and_another_of_the_same_content_is_refused() {
    let stands = |author: &str| {
        format!(r#"{{"id":"r2","revises":{{"record":"r1","author":"{author}","reason":"wrong latitude"}}}}"#)
    };
    for (author, moved_to) in [("Li Wei", "sent"), ("Weber", "refused")] {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("revise")).unwrap();
        fs::write(dir.path().join("revise/run.json"), RECORD).unwrap();
        fs::write(dir.path().join("revise/run.json.why.txt"), SAID).unwrap();
        let script = Script::new(&[(200, r#"{"id":"r2"}"#)], (200, &stands(author)));
        let service = script.serve().await;
        let moved = dir.path().join(moved_to).join("run.json");
        watch_until(dir.path(), &service, false, || moved.exists()).await;
    }
}

#[tokio::test]
async fn a_revision_that_cannot_be_handled_holds_up_no_other() {
    let dir = tempfile::tempdir().unwrap();
    let file = |name: &str| dir.path().join("revise").join(name);
    fs::create_dir(dir.path().join("revise")).unwrap();
    fs::write(file("a.json"), RECORD).unwrap();
    fs::create_dir(file("a.json.why.txt")).unwrap();
    fs::write(file("b.json"), RECORD).unwrap();
    fs::write(file("b.json.why.txt"), SAID).unwrap();
    let script = Script::new(&[], (201, STORED));
    let service = script.serve().await;
    watch_until(dir.path(), &service, false, || dir.path().join("sent/b.json").exists()).await;
    assert!(file("a.json").exists(), "it stays");
}

#[tokio::test]
async fn a_file_whose_lines_a_broken_try_has_stored_ends_its_import_too() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("run.ndjson"), format!("{RECORD}{RECORD}")).unwrap();
    let known = "{\"status\":200}\n{\"status\":200}\n";
    let script = Script::new(&[(200, known)], (200, ""));
    let service = script.clone().serve().await;
    watch_until(dir.path(), &service, true, || dir.path().join("sent/run.ndjson").exists()).await;
    assert_eq!(script.heard(), [format!("{RECORD}{RECORD}"), String::new()], "the end of the import");
}
