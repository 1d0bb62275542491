//! Copies of the database: taken while it is served, checked, damaged, and put back.

use std::os::unix::fs::PermissionsExt;

use crate::command::on_database;
use crate::prelude::*;
use sqlx::ConnectOptions;

async fn with_the_papers_figures() -> Server {
    let server = Server::start().await;
    assert_eq!(server.post("/v1/records", "application/json", data("paper.json")).await.status, 201);
    let benches = server.post("/v1/import", "application/x-ndjson", data("paper-bench.ndjson")).await.text();
    assert_eq!(benches.matches("\"status\":201").count(), 6, "{benches}");
    server
}

#[tokio::test]
async fn a_backup_of_a_running_service_is_whole_and_restores_what_was_there() {
    let mut server = with_the_papers_figures().await;
    let trend = "/v1/gyros/LFG-0101/trend?coefficient=D_I";
    let before = server.get(trend).await.json();
    let (status, said) = on_database(&["backup", "copy.db"], server.dir());
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("1 records, 6 bench results, 3 calibrations"), "{said}");
    assert_eq!(on_database(&["restore", "--check", "copy.db"], server.dir()), (Some(0), said));

    let (status, said) = on_database(&["restore", "--check", "nofile.db"], server.dir());
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("nofile.db: there is no such file"), "{said}");

    let (status, said) = on_database(&["backup", "copy.db"], server.dir());
    assert_eq!(status, Some(1), "an earlier backup is not overwritten: {said}");
    assert!(said.contains("copy.db"), "{said}");
    let (status, said) = on_database(&["restore", "copy.db"], server.dir());
    assert_eq!(status, Some(1), "a database is not overwritten: {said}");
    assert!(said.contains("gyrowatch.db"), "{said}");

    server.kill();
    for file in ["gyrowatch.db", "gyrowatch.db-wal", "gyrowatch.db-shm"] {
        std::fs::remove_file(server.dir().join(file)).unwrap();
    }
    let (status, said) = on_database(&["restore", "copy.db"], server.dir());
    assert_eq!(status, Some(0), "{said}");
    server.restart();
    assert_eq!(server.get(trend).await.json(), before);
    assert_eq!(server.post("/v1/records", "application/json", data("paper.json")).await.status, 200, "it is known");
}

#[tokio::test]
async fn a_damaged_backup_is_found_out_and_says_where() {
    let server = with_the_papers_figures().await;
    for (change, named) in [
        ("UPDATE history_log SET rows = zeroblob(length(rows))", "damaged"),
        ("UPDATE record SET body = replace(body, '0.8473', '0.8474')", "record"),
        ("UPDATE record SET verdicts = zeroblob(length(verdicts))", "damaged"),
        ("UPDATE bench_result SET body = body || ' ' WHERE id = (SELECT max(id) FROM bench_result)", "bench result"),
        ("DELETE FROM gyro WHERE id = 1", "damaged"),
        ("DROP TABLE history", "no database of gyrowatch"),
    ] {
        let (status, said) = on_database(&["backup", "copy.db"], server.dir());
        assert_eq!(status, Some(0), "{said}");
        let file = server.dir().join("copy.db");
        let options = sqlx::sqlite::SqliteConnectOptions::new().filename(&file).foreign_keys(false);
        let mut connection = options.connect().await.unwrap();
        sqlx::query(change).execute(&mut connection).await.unwrap();
        sqlx::Connection::close(connection).await.unwrap();
        let (status, said) = on_database(&["restore", "--check", "copy.db"], server.dir());
        assert_eq!(status, Some(1), "{change}: {said}");
        assert!(said.contains("copy.db") && said.contains(named), "{change}: {said}");
        std::fs::remove_file(file).unwrap();
    }
}

#[tokio::test]
async fn a_backup_that_is_cut_off_or_of_no_database_leaves_nothing_behind() {
    let server = with_the_papers_figures().await;
    assert_eq!(on_database(&["backup", "copy.db"], server.dir()).0, Some(0));
    let whole = std::fs::read(server.dir().join("copy.db")).unwrap();
    std::fs::write(server.dir().join("cut.db"), &whole[..whole.len() / 2]).unwrap();
    let (status, said) = on_database(&["restore", "--check", "cut.db"], server.dir());
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("damaged"), "{said}");
    std::fs::write(server.dir().join("text.db"), "these are notes of a laboratory\n".repeat(200)).unwrap();
    let (status, said) = on_database(&["restore", "--check", "text.db"], server.dir());
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("text.db") && said.contains("no SQLite database") && !said.contains("damaged"), "{said}");

    let empty = tempfile::tempdir().unwrap();
    let (status, said) = on_database(&["backup", "copy.db"], empty.path());
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("gyrowatch.db"), "{said}");
    assert_eq!(std::fs::read_dir(empty.path()).unwrap().count(), 0);
}

/// Files beside the log of the test, and who may read and write them.
fn modes(dir: &Path) -> Vec<(String, u32)> {
    let entries = std::fs::read_dir(dir).unwrap().map(Result::unwrap);
    let name = |entry: &std::fs::DirEntry| entry.file_name().into_string().unwrap();
    let mode = |entry: &std::fs::DirEntry| entry.metadata().unwrap().permissions().mode() & 0o7777;
    let mut modes: Vec<_> = entries.map(|entry| (name(&entry), mode(&entry))).filter(|(n, _)| n != "log").collect();
    modes.sort();
    modes
}

const OPEN_UMASK: [&str; 3] = ["sh", "-c", "umask 0; exec \"$0\" \"$@\""];

#[tokio::test]
async fn the_database_and_its_copies_are_their_owners_alone_whatever_the_umask() {
    let mut server = Server::start_under(&OPEN_UMASK, tempfile::tempdir().unwrap(), &[]);
    assert_eq!(server.post("/v1/records", "application/json", data("paper.json")).await.status, 201);
    let under = |arguments: &[&str], dir: &Path, database: &str| {
        let mut command = support::gyrowatch_under(&OPEN_UMASK);
        let url = format!("sqlite://{}", dir.join(database).display());
        let output = command.args(arguments).current_dir(dir).env("GYROWATCH_DATABASE_URL", url).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    let dir = server.dir().to_owned();
    under(&["backup", "copy.db"], &dir, "gyrowatch.db");
    let files = ["copy.db", "gyrowatch.db", "gyrowatch.db-shm", "gyrowatch.db-wal", "gyrowatch.db.lock"];
    assert_eq!(modes(&dir), files.map(|name| (name.to_owned(), 0o600)));
    // A copy that somebody has opened to others is not restored so.
    std::fs::set_permissions(dir.join("copy.db"), std::fs::Permissions::from_mode(0o644)).unwrap();
    under(&["restore", "copy.db"], &dir, "restored.db");
    under(&["token", "create", "a", "--role", "admin"], &dir, "fresh.db");
    let open = modes(&dir).into_iter().filter(|(name, mode)| name != "copy.db" && *mode != 0o600).collect::<Vec<_>>();
    assert_eq!(open, []);
    assert!(!server.log().contains("may read the database"), "{}", server.log());
    server.kill();
    std::fs::set_permissions(dir.join("gyrowatch.db"), std::fs::Permissions::from_mode(0o640)).unwrap();
    server.restart();
    assert!(server.log().contains("others on this machine may read the database"), "{}", server.log());
}
