//! The clients that come with the service, against the service.

use crate::prelude::*;
use crate::support::required;

/// By the system's Python, which needs nothing else, and by one that has pandas.
#[tokio::test]
async fn the_python_client_posts_reads_and_retries() {
    if !required("python3") {
        return;
    }
    let root = root();
    let server = Server::start().await;
    let mut plain = Command::new("python3");
    plain.args(["-m", "unittest", "discover", "-s", "tests"]).current_dir(root.join("clients/python"));
    passes(plain.env("PYTHONDONTWRITEBYTECODE", "1").env("GYROWATCH_URL", server.url("")));
    if are_there() {
        let server = Server::start().await;
        let said = passes(script().arg("library").arg(server.url("")));
        assert!(!said.contains("skipped"), "{said}");
    }
}

/// Runs the tests of `clients/python`.
fn passes(tests: &mut Command) -> String {
    let data = root().join("tests/data");
    let output = tests.env("GYROWATCH_TEST_DATA", data).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && said.contains("OK") && !said.contains("Ran 0 tests"), "{said}");
    said
}

/// The service needs no token before there is one; a client that is generated always sends one.
async fn with_token(server: &Server) -> String {
    let asked = json!({"name": "client", "role": "admin"}).to_string();
    let made = server.post("/v1/tokens", "application/json", asked).await.created();
    made["token"].as_str().unwrap().to_owned()
}

fn script() -> Command {
    Command::new(root().join("scripts/clients"))
}

/// Whether there are generators and types; where they cannot be had a test says so and passes over.
fn are_there() -> bool {
    let installed = script().arg("install").output().unwrap();
    let there = installed.status.code() != Some(3);
    if !there {
        let why = String::from_utf8_lossy(&installed.stdout).into_owned();
        assert_ne!(std::env::var("GYROWATCH_TEST_CLIENTS").as_deref(), Ok("required"), "{why}");
        println!("passed over: {why}");
    }
    there
}

#[test]
fn dashboards_are_what_grafana_s_own_types_say() {
    if !are_there() {
        return;
    }
    let config = root().join("config/grafana");
    let checked = |dir: &Path| {
        let output = script().arg("dashboards").arg(dir).output().unwrap();
        (output.status.success(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (well, said) = checked(&config);
    assert!(well, "{said}");
    let dir = tempfile::tempdir().unwrap();
    let wrong = std::fs::read_to_string(config.join("gyros.json")).unwrap().replacen("\"gridPos\"", "\"gridpos\"", 1);
    std::fs::write(dir.path().join("gyros.json"), wrong).unwrap();
    let (well, said) = checked(dir.path());
    assert!(!well && said.contains("gridpos"), "{said}");
}

#[tokio::test]
async fn generated_clients_in_python_and_typescript_compile_and_are_used() {
    let root = root();
    if !are_there() {
        return;
    }
    for used in ["python", "typescript"] {
        let server = Server::start().await;
        let dir = tempfile::tempdir().unwrap();
        let output = script()
            .arg(server.url(""))
            .arg(dir.path())
            .arg(used)
            .env("GYROWATCH_URL", server.url(""))
            .env("GYROWATCH_TOKEN", with_token(&server).await)
            .env("GYROWATCH_TEST_DATA", root.join("tests/data"))
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        assert!(output.status.success() && said.to_lowercase().contains(&format!("used from {used}")), "{said}");
        assert!(!said.contains("WARNING"), "an operation is left out: {said}");
    }
}
