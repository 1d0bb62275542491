//! The command line program, run to its end.

use std::process::Output;

use crate::prelude::*;
use crate::support::file_url;

/// A folder of a test's own.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    pub fn file(&self, name: &str, text: &str) -> String {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

pub fn read_json(path: impl AsRef<Path>) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// How it ended, what it printed, and what it said beside that.
pub fn run(arguments: &[&str]) -> (i32, String, String) {
    ended(gyrowatch().args(arguments))
}

pub fn ended(command: &mut Command) -> (i32, String, String) {
    let output = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// What it prints where it succeeds.
pub fn printed(arguments: &[&str]) -> String {
    let (status, out, error) = run(arguments);
    assert_eq!(status, 0, "{arguments:?}: {error}");
    out
}

/// The same as JSON.
pub fn answer(arguments: &[&str]) -> Value {
    serde_json::from_str(&printed(&[arguments, &["--format", "json"]].concat())).unwrap()
}

/// What it says where it ends with `status` and prints nothing.
pub fn complaint(arguments: &[&str], status: i32) -> String {
    let (code, out, error) = run(arguments);
    assert_eq!((code, out.as_str()), (status, ""), "{arguments:?}: {error}");
    error
}

/// On a database.
pub fn on(url: &str) -> Command {
    let mut command = gyrowatch();
    command.env("GYROWATCH_DATABASE_URL", url);
    command
}

/// On the database of the service in `dir`, and there.
pub fn beside(dir: &Path) -> Command {
    let mut command = on(&file_url(&dir.join("gyrowatch.db")));
    command.current_dir(dir);
    command
}

/// What was written to both outputs.
pub fn all_of(output: Output) -> String {
    String::from_utf8([output.stdout, output.stderr].concat()).unwrap()
}

/// How a command on the database of the service in `dir` ended, and all that it said.
pub fn on_database(arguments: &[&str], dir: &Path) -> (Option<i32>, String) {
    let output = beside(dir).args(arguments).output().unwrap();
    (output.status.code(), all_of(output))
}

/// What `gyrowatch verify` says of a database that is whole.
pub fn verified(url: &str) -> String {
    let output = on(url).arg("verify").output().unwrap();
    let whole = output.status.success();
    let said = all_of(output);
    assert!(whole, "{said}");
    said
}
