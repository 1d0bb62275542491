//! Power cuts: a run of the service is recorded down to each write and flush, the disk is rebuilt as it might be
//! found after a cut at a moment of that run, and what clients were told is looked for in it. `scripts/soak power`
//! tries 1,000 moments.

use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::power::disk::{Disk, Flushing};
use crate::power::{CALLS, Call, Moment, Recording};
use crate::prelude::*;
use crate::support::{asked, client, required};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Records of two IMUs, so that each gyro soon has enough of them to be folded into its place.
fn record(number: usize) -> String {
    let imu = if number < 505 { 0 } else { number % 2 };
    paper_record(imu, number).to_string()
}

/// What a run has left: every call, and the text of each record by the identifier that its sender was told.
struct Run {
    recording: Recording,
    /// The files as the operating system has them after the end.
    left: BTreeMap<String, Vec<u8>>,
    sent: HashMap<String, String>,
    ready: usize,
}

/// Stores records over many connections and then dies.
async fn recorded_run(records: usize) -> Run {
    let dir = tempfile::tempdir().unwrap();
    let trace = dir.path().join("trace");
    let under = ["strace", "-D", "-f", "--seccomp-bpf", "-y", "-xx", "-s", "1000000", "-e", CALLS, "-o"];
    let under = [&under[..], &[trace.to_str().unwrap()]].concat();
    let place = dir.path().to_owned();
    let mut server = Server::start_under(&under, dir, &[("GYROWATCH_DATABASE__CHECKPOINT_PAGES", "150")]);
    let sent = Arc::new(Mutex::new(HashMap::new()));
    // Nearly as many of the first IMU's as are folded at once, so that the load goes over that edge.
    let lines: Vec<String> = (0..505).map(record).collect();
    let answers = server.post("/v1/import", "application/x-ndjson", lines.join("\n")).await.text();
    for (line, answer) in lines.iter().zip(answers.lines()) {
        let answer: Value = serde_json::from_str(answer).unwrap();
        assert_eq!(answer["status"], 201, "{answer}");
        sent.lock().unwrap().insert(answer["id"].as_str().unwrap().to_owned(), line.clone());
    }
    let next = Arc::new(AtomicUsize::new(505));
    let senders: Vec<_> = (0..8)
        .map(|_| {
            let (url, next, sent) = (server.url("/v1/records"), next.clone(), sent.clone());
            tokio::spawn(async move {
                let http = client();
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= 505 + records {
                        return;
                    }
                    let body = record(number);
                    let request = http.post(&url).header("content-type", "application/json").body(body.clone());
                    let answer = request.send().await.unwrap();
                    assert_eq!(answer.status(), 201);
                    let answer: Value = serde_json::from_str(&answer.text().await.unwrap()).unwrap();
                    sent.lock().unwrap().insert(answer["id"].as_str().unwrap().to_owned(), body);
                }
            })
        })
        .collect();
    for sender in senders {
        sender.await.unwrap();
    }
    at_rest(&trace).await;
    server.kill();
    let began = Instant::now();
    let trace = loop {
        let text = std::fs::read_to_string(&trace).unwrap();
        if text.lines().last().is_some_and(|line| line.contains("+++ ")) && text.ends_with('\n') {
            break text;
        }
        assert!(began.elapsed() < Duration::from_secs(60), "strace does not end");
        tokio::time::sleep(Duration::from_millis(50)).await;
    };
    let recording = Recording::read(&trace, &place);
    let ready = recording.said("gyrowatch listens on");
    let files = ["gyrowatch.db", "gyrowatch.db-wal"];
    let left = files.map(|name| (name.to_owned(), std::fs::read(place.join(name)).unwrap())).into();
    Run { recording, left, sent: Arc::into_inner(sent).unwrap().into_inner().unwrap(), ready }
}

/// Waits until no call has been recorded for half a second: whether a write that is killed halfway reaches its file is
/// not in the recording.
async fn at_rest(trace: &Path) {
    let began = Instant::now();
    let mut seen = 0;
    loop {
        tokio::time::sleep(Duration::from_millis(500)).await;
        let size = std::fs::metadata(trace).unwrap().len();
        if size == seen {
            return;
        }
        assert!(began.elapsed() < Duration::from_secs(60), "the service is never at rest");
        seen = size;
    }
}

impl Run {
    /// The identifiers that clients were told before `moment`.
    fn told(&self, moment: usize) -> Vec<&str> {
        let mut told = Vec::new();
        for moment in &self.recording.moments[..moment] {
            let Moment::Begins(call) = moment else { continue };
            let Call::Tell { text } = &self.recording.calls[*call] else { continue };
            let text = String::from_utf8_lossy(text);
            let ids = text.split("\"id\":\"").skip(1).filter_map(|rest| rest.split('"').next());
            told.extend(ids.filter_map(|id| self.sent.get_key_value(id)).map(|(id, _)| id.as_str()));
        }
        told
    }

    /// Moments at which something hangs in the balance, as chance will have them, in order.
    fn moments(&self, count: usize, random: &mut ChaCha8Rng) -> Vec<usize> {
        let mut disk = Disk::new(&self.recording, Flushing::Honest);
        let risky: Vec<usize> = (0..self.recording.moments.len())
            .filter(|moment| {
                disk.pass(*moment);
                disk.at_risk() || *moment < self.ready
            })
            .collect();
        let mut moments: Vec<usize> = (0..count).map(|_| risky[random.random_range(0..risky.len())]).collect();
        moments.sort_unstable();
        moments
    }
}

#[derive(Debug, Default)]
struct Audit {
    told: usize,
    lost: usize,
    corrupt: Vec<String>,
}

/// What is in the files that were found, held against what was told.
async fn audit(dir: &Path, told: &[&str], sent: &HashMap<String, String>) -> Audit {
    let mut audit = Audit { told: told.len(), ..Audit::default() };
    let file = dir.join("gyrowatch.db");
    let output = gyrowatch().args(["restore", "--check"]).arg(&file).output().unwrap();
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    if !output.status.success() {
        audit.corrupt.push(said);
        audit.lost = told.len();
        return audit;
    }
    let mut connection = behind::read(&file).await;
    let stored: Vec<(i64, String)> =
        sqlx::query_as("SELECT id, body FROM record").fetch_all(&mut connection).await.unwrap();
    if !said.contains(&format!("{} records", stored.len()))
        || !said.contains(&format!("{} calibrations", 3 * stored.len()))
    {
        audit.corrupt.push(format!("{} records are stored: {said}", stored.len()));
    }
    let stored: HashMap<String, String> =
        stored.into_iter().map(|(id, body)| (gyrowatch::core::id::Id(id).to_string(), body)).collect();
    // A line of an import is stored with its end.
    let there = |id: &&&str| stored.get(**id).is_some_and(|body| body.trim_end() == sent[**id]);
    audit.lost = told.len() - told.iter().filter(there).count();
    audit
}

/// Starts the service on what was found: it comes up, knows what was told last, and takes more.
async fn serves_again(dir: tempfile::TempDir, told: &[&str], sent: &HashMap<String, String>) -> tempfile::TempDir {
    let server = Server::start_under(&[], dir, &[]);
    if let Some(last) = told.last() {
        assert_eq!(server.get(&format!("/v1/records/{last}")).await.status, 200, "{last}");
        assert_eq!(server.post("/v1/records", "application/json", sent[*last].clone()).await.status, 200, "{last}");
    }
    let new = record(1_000_001);
    assert_eq!(server.post("/v1/records", "application/json", new).await.status, 201);
    server.into_dir()
}

fn put(dir: &Path, files: &BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(dir).unwrap() {
        std::fs::remove_file(entry.unwrap().path()).unwrap();
    }
    for (name, content) in files {
        std::fs::write(dir.join(name), content).unwrap();
    }
}

#[tokio::test]
async fn what_was_acknowledged_survives_a_power_cut() {
    if !required("strace") {
        return;
    }
    let points = asked("GYROWATCH_SOAK_CUTS", 24);
    let run = recorded_run(asked("GYROWATCH_SOAK_RECORDS", 60)).await;
    let mut random = ChaCha8Rng::seed_from_u64(asked("GYROWATCH_SOAK_SEED", 5) as u64);
    let mut disk = Disk::new(&run.recording, Flushing::Honest);
    let mut dir = tempfile::tempdir().unwrap();
    let (mut told_in_all, mut lost, mut corrupt, mut served) = (0, 0, Vec::new(), 0);
    for (point, moment) in run.moments(points, &mut random).into_iter().enumerate() {
        disk.pass(moment);
        let told = run.told(moment);
        put(dir.path(), &disk.cut(&mut random));
        if moment >= run.ready {
            let audit = audit(dir.path(), &told, &run.sent).await;
            told_in_all += audit.told;
            lost += audit.lost;
            corrupt.extend(audit.corrupt.into_iter().map(|what| format!("moment {moment}: {what}")));
        }
        if point % 8 == 0 || moment < run.ready {
            dir = serves_again(dir, &told, &run.sent).await;
            served += 1;
        }
    }
    println!(
        "power cut: {points} moments of {} calls, {} records, {told_in_all} acknowledgements held against what was found: \
         {lost} lost, {} corrupt; started again {served} times",
        run.recording.calls.len(),
        run.sent.len(),
        corrupt.len()
    );
    assert!(told_in_all > 0 && lost == 0 && corrupt.is_empty(), "{lost} lost, {corrupt:#?}");

    // The same run on a disk that is told to flush less often: a check that finds nothing here would find nothing ever.
    let mut disk = Disk::new(&run.recording, Flushing::LogOnlyBeforeCopying);
    let (mut cuts_with_losses, mut lost, cuts) = (0, 0, points.clamp(100, 200));
    for moment in run.moments(cuts, &mut random).into_iter().filter(|moment| *moment >= run.ready) {
        disk.pass(moment);
        put(dir.path(), &disk.cut(&mut random));
        let audit = audit(dir.path(), &run.told(moment), &run.sent).await;
        cuts_with_losses += usize::from(audit.lost > 0);
        lost += audit.lost;
    }
    println!(
        "power cut, flushed as synchronous = NORMAL would: {cuts} moments, {cuts_with_losses} with losses, {lost} lost"
    );
    assert!(cuts_with_losses > 0, "without flushes something must be missing");
}

#[tokio::test]
async fn the_recording_holds_every_byte_of_the_files() {
    if !required("strace") {
        return;
    }
    let run = recorded_run(4).await;
    let end = run.recording.moments.len();
    assert_eq!(run.told(end).len(), run.sent.len());
    let mut disk = Disk::new(&run.recording, Flushing::Honest);
    disk.pass(end);
    assert!(disk.cached() == run.left, "the calls that were seen do not make the files that are there");
}
