//! The clients that come with the service, against the service.

mod support;

use std::path::Path;
use std::process::Command;

use support::{Server, required};

#[tokio::test]
async fn the_python_client_posts_reads_and_retries() {
    if !required("python3") {
        return;
    }
    let server = Server::start().await;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new("python3")
        .args(["-m", "unittest", "discover", "-s", "tests"])
        .current_dir(root.join("clients/python"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("GYROWATCH_URL", server.url(""))
        .env("GYROWATCH_TEST_DATA", root.join("tests/data"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("OK"), "{said}");
    assert!(!said.contains("Ran 0 tests"), "{said}");
}
