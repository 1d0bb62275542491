//! What hooks are told with is not to be read in a backup, where there is a key (GYROWATCH_SECRETS_KEY).

use crate::command::{beside, on_database};
use crate::prelude::*;
use standardwebhooks::Webhook;

const KEY: &str = "GYROWATCH_SECRETS_KEY";
const SIGNING: &str = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw";
const HIDDEN: [&str; 3] = ["hunter2", SIGNING, "url-token"];

fn key(byte: u8) -> String {
    [byte; 32].map(|byte| format!("{byte:02x}")).concat()
}

/// Which of the secrets a backup gives away.
fn given_away(server: &Server) -> Vec<&'static str> {
    let file = server.dir().join("copy.db");
    let (status, said) = on_database(&["backup", "copy.db"], server.dir());
    assert_eq!(status, Some(0), "{said}");
    let bytes = std::fs::read(&file).unwrap();
    std::fs::remove_file(file).unwrap();
    HIDDEN.into_iter().filter(|text| bytes.windows(text.len()).any(|part| part == text.as_bytes())).collect()
}

/// Why the service does not start.
fn refusal(server: &Server, key: Option<&str>) -> String {
    let mut command = beside(server.dir());
    command.arg("serve").env("GYROWATCH_LISTEN", "127.0.0.1:0");
    if let Some(key) = key {
        command.env(KEY, key);
    }
    let output = command.output().unwrap();
    assert!(!output.status.success());
    String::from_utf8(output.stderr).unwrap()
}

#[tokio::test]
async fn a_backup_gives_no_secret_away_once_there_is_a_key() {
    let target = Receiver::start().await;
    let hook = json!({
        "kind": "standard-webhooks", "url": format!("{}/url-token", target.url()), "authorization": "Bearer hunter2",
        "secret": SIGNING,
    });
    let mut server = Server::start().await;
    let made = server.post_json("/v1/hooks", &hook).await;
    assert_eq!(made.status, 201, "{}", made.text());
    let id = made.json()["id"].as_str().unwrap().to_owned();
    assert_eq!(given_away(&server), HIDDEN, "without a key");

    assert!(server.terminate().0.success());
    let mut server = Server::start_under(&[], server.into_dir(), &[(KEY, &key(1))]);
    assert!(server.log().contains("the secrets of hooks are encrypted now"), "{}", server.log());
    assert_eq!(given_away(&server), [""; 0], "of a hook that was there before");
    let told = tested(&server, &target, &id, 1).await;
    assert!(told["path"].as_str().unwrap().ends_with("/url-token"), "{told}");
    // One that is made, and one that is changed, with the key in place.
    assert_eq!(server.post_json("/v1/hooks", &hook).await.status, 201);
    let renamed = json!({ "name": "pager", "secret": "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSx" }).to_string();
    let route = format!("/v1/hooks/{id}");
    let json_type = [("content-type", "application/json")];
    assert_eq!(server.call("PATCH", &route, &json_type, renamed).await.status, 200);
    assert_eq!(given_away(&server), [""; 0], "of a hook that is made or changed");
    tested(&server, &target, &id, 2).await;

    assert!(server.terminate().0.success());
    assert!(refusal(&server, None).contains("GYROWATCH_SECRETS_KEY is missing"));
    assert!(refusal(&server, Some(&key(2))).contains("another key"));
    let wrong = refusal(&server, Some("short"));
    assert!(wrong.contains("must be 32 bytes") && !wrong.contains("short"), "{wrong}");
    // What only reads needs no key.
    assert_eq!(given_away(&server), [""; 0]);
    server.restart();
    tested(&server, &target, &id, 3).await;
}

/// Has a hook tell the target something, which checks what it comes with: the `count`-th message.
async fn tested(server: &Server, target: &Receiver, hook: &str, count: usize) -> Value {
    let test = server.post(&format!("/v1/hooks/{hook}/test"), "application/json", "").await;
    assert!(test.status < 300, "{}", test.text());
    let told = target.has_been_told(count).await.pop().unwrap();
    assert_eq!(told.header("authorization"), "Bearer hunter2");
    // While a secret is being replaced, the one before signs too.
    Webhook::new(SIGNING).unwrap().verify(&told.body, &told.headers).unwrap();
    json!({ "path": told.path })
}
