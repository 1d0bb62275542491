//! What a station copies: each example is run where Debian has its program, and each template fits.

use std::sync::Mutex;

use tokio::io::AsyncWriteExt;

use crate::prelude::*;
use crate::receiver;

fn example(name: &str) -> PathBuf {
    root().join("examples/stations").join(name)
}

fn template(of: &str, format: &str, to: &Path) {
    let made = gyrowatch().args(["template", of, "--format", format, "--out"]).arg(to).output().unwrap();
    assert!(made.status.success(), "{of} {format}: {}", String::from_utf8_lossy(&made.stderr));
}

fn run(mut command: Command, server: &Server) -> (bool, String) {
    let output = command.env("GYROWATCH_URL", format!("http://{}", server.address())).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8_lossy(&said).into_owned())
}

#[tokio::test(flavor = "multi_thread")]
async fn python_and_curl_send_templates_twice_and_hear_of_faults() {
    let server = Server::start().await;
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    template("record", "json", &at("record.json"));
    template("bench", "json", &at("bench.json"));
    template("campaign", "csv", &at("campaign.csv"));
    let python = |file: &str| {
        let mut command = Command::new("python3");
        command.arg(example("post.py")).arg(at(file));
        command
    };
    for file in ["record.json", "bench.json", "campaign.csv"] {
        let (sent, said) = run(python(file), &server);
        assert!(sent && said.contains("stored as"), "{file}: {said}");
    }
    let curl = |file: &str, kind: &str, content_type: &str| {
        let mut command = Command::new("sh");
        command.arg(example("post.sh")).arg(at(file)).args([kind, content_type]);
        command
    };
    let (sent, said) = run(curl("campaign.csv", "campaigns", "text/csv"), &server);
    assert!(sent && said.contains("separations"), "{said}");
    let text = std::fs::read_to_string(at("record.json")).unwrap();
    std::fs::write(at("wrong.json"), text.replace("2.4210", "\"a\"")).unwrap();
    let (sent, said) = run(python("wrong.json"), &server);
    assert!(!sent && said.contains("refused (4") && said.contains("/gyros/0/g_pulse_per_s_g0"), "{said}");
    let (sent, said) = run(python("missing.json"), &server);
    assert!(!sent && said.contains("missing.json: cannot be sent") && said.lines().count() == 1, "{said}");
    std::fs::write(at("binary.json"), b"\xff\xfe\x00").unwrap();
    let (sent, said) = run(python("binary.json"), &server);
    assert!(!sent && said.contains("cannot be sent") && said.lines().count() == 1, "{said}");
    let mut lost = python("record.json");
    let lost = lost.env("GYROWATCH_URL", "nowhere").output().unwrap();
    let said = String::from_utf8_lossy(&lost.stderr).into_owned();
    assert!(lost.status.code() == Some(1) && said.contains("is no address") && said.lines().count() == 1, "{said}");
    let (sent, said) = run(curl("wrong.json", "records", "application/json"), &server);
    assert!(!sent && (said.contains("refused (422)") || said.contains("refused (400)")), "{said}");
}

#[tokio::test(flavor = "multi_thread")]
async fn examples_ask_for_the_language_of_the_station() {
    let server = Server::start().await;
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("wrong.json"), r#"{"gyros": []}"#).unwrap();
    for (program, example_of) in [("sh", "post.sh"), ("python3", "post.py")] {
        let said = |language: &str| {
            let mut command = Command::new(program);
            command.arg(example(example_of)).arg(dir.path().join("wrong.json"));
            command.args((program == "sh").then_some("records")).env("LC_ALL", language);
            run(command, &server)
        };
        let (sent, words) = said("zh_CN.UTF-8");
        assert!(!sent && !words.is_ascii(), "{words}");
        let (sent, words) = said("C.UTF-8");
        assert!(!sent && words.contains("missing"), "{words}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn curl_sends_again_where_the_line_drops_and_waits_as_it_is_told() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("record.json");
    template("record", "json", &file);
    let tries = Arc::new(Mutex::new(Vec::new()));
    let times = Arc::clone(&tries);
    let (address, _serving) = receiver::raw(move |mut stream| {
        let times = Arc::clone(&times);
        async move {
            let before = {
                let mut times = times.lock().unwrap();
                times.push(Instant::now());
                times.len()
            };
            match before {
                // Hangs up without a word.
                1 => Ok(()),
                2 => {
                    let busy = "HTTP/1.1 503 Busy\r\nretry-after: 3\r\ncontent-length: 0\r\nconnection: close\r\n\r\n";
                    stream.write_all(busy.as_bytes()).await
                }
                _ => {
                    let stored =
                        "HTTP/1.1 201 Created\r\ncontent-length: 11\r\nconnection: close\r\n\r\n{\"id\":\"r1\"}";
                    stream.write_all(stored.as_bytes()).await
                }
            }
        }
    })
    .await;
    let mut command = Command::new("sh");
    command.arg(example("post.sh")).arg(&file).arg("records").env("GYROWATCH_URL", format!("http://{address}"));
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && output.stdout.starts_with(br#"{"id":"r1"}"#), "{said}");
    let tries = tries.lock().unwrap();
    assert_eq!(tries.len(), 3, "{said}");
    assert!(tries[2].duration_since(tries[1]) > Duration::from_millis(2900), "as Retry-After says");
}

#[tokio::test(flavor = "multi_thread")]
async fn octave_sends_a_campaign_and_hears_of_faults() {
    if !support::required("octave-cli") {
        return;
    }
    let server = Server::start().await;
    let dir = tempfile::tempdir().unwrap();
    template("campaign", "csv", &dir.path().join("campaign.csv"));
    std::fs::write(dir.path().join("wrong.csv"), "# imu: IMU-08\nphase;start_s\nstatic;0\n").unwrap();
    let post = |file: &str| {
        let mut command = Command::new("octave-cli");
        let call = format!("answer = post('{file}', 'campaigns', 'text/csv'); disp(['stored as ' answer.id])");
        command.current_dir(dir.path()).args(["--no-init-file", "--path"]).arg(example(""));
        command.args(["--eval", &call]);
        command
    };
    let (sent, said) = run(post("campaign.csv"), &server);
    assert!(sent && said.contains("stored as"), "{said}");
    let wrong = |language: &str| {
        let mut command = post("wrong.csv");
        command.env("LC_ALL", language);
        run(command, &server)
    };
    let (sent, said) = wrong("C.UTF-8");
    assert!(!sent && said.contains("\"status\":422") && said.is_ascii(), "{said}");
    let (sent, said) = wrong("zh_CN.UTF-8");
    assert!(!sent && !said.is_ascii(), "{said}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wrong_campaign_is_revised_from_csv_and_voided_by_commands() {
    let server = Server::start().await;
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    template("campaign", "csv", &at("wrong.csv"));
    let text = std::fs::read_to_string(at("wrong.csv")).unwrap();
    std::fs::write(at("right.csv"), format!("# operator: Li Wei\n{text}")).unwrap();
    let command = |arguments: &[&str]| {
        let mut command = gyrowatch();
        command.current_dir(dir.path()).args(arguments).args(["--url", server.address()]);
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        (output.status.success(), said)
    };
    assert!(command(&["import", "wrong.csv"]).0);
    let (stored, said) = command(&["import", "right.csv"]);
    assert!(!stored && said.contains("gyrowatch revise"), "{said}");
    let who = ["--author", "Li Wei", "--reason", "operator was missing"];
    let (revised, said) = command(&[&["revise", "right.csv"][..], &who[..]].concat());
    assert!(revised && said.contains("stands in the place of"), "{said}");
    let id = said.trim().rsplit(' ').next().unwrap().to_owned();
    let (known, said) = command(&["import", "wrong.csv"]);
    assert!(
        known && said.contains("1 already known") && said.contains("stands in its place (Li Wei: operator"),
        "{said}"
    );
    assert!(!said.contains("D_I"), "not the figures of what counts no more: {said}");
    let (again, said) = command(&[&["revise", "wrong.csv"][..], &who[..]].concat());
    assert!(!again && said.contains("is stored already, as") && said.contains(&format!("--of {id}")), "{said}");
    let answer: Value = server.get(&format!("/v1/campaigns/{id}")).await.json();
    assert_eq!((&answer["campaign"]["operator"], &answer["state"]), (&"Li Wei".into(), &"valid".into()));
    let (voided, said) = command(&[&["void", id.as_str()][..], &who[..]].concat());
    assert!(voided && said.contains("is voided"), "{said}");
    let answer: Value = server.get(&format!("/v1/campaigns/{id}")).await.json();
    assert_eq!(answer["state"], "voided");
    let (voided, said) = command(&[&["void", "r999"][..], &who[..]].concat());
    assert!(!voided && said.contains("404"), "{said}");
    // A record from a table; of two, neither.
    template("record", "csv", &at("record.csv"));
    assert!(command(&["import", "record.csv"]).0);
    let text = std::fs::read_to_string(at("record.csv")).unwrap().replace("45.0", "45.5");
    std::fs::write(at("record.csv"), &text).unwrap();
    let (revised, said) = command(&[&["revise", "record.csv"][..], &who[..]].concat());
    assert!(revised && said.contains("stands in the place of"), "{said}");
    template("record", "csv", &at("first.csv"));
    let (known, said) = command(&["import", "first.csv"]);
    assert!(known && said.contains("first.csv:4: note: is stored and counts no more"), "{said}");
    let rows = text.lines().filter(|line| line.starts_with("IMU-07"));
    let other: String = rows.map(|row| row.replace("2026-03-08", "2026-03-09") + "\n").collect();
    std::fs::write(at("two.csv"), text.clone() + &other).unwrap();
    let (revised, said) = command(&[&["revise", "two.csv"][..], &who[..]].concat());
    assert!(!revised && said.contains("holds 2 documents"), "{said}");
    // What is wrong with it is said in words.
    std::fs::write(at("wrong.csv"), "# imu: IMU-08\nphase;start_s\nstatic;0\n").unwrap();
    let (revised, said) = command(&[&["revise", "wrong.csv"][..], &who[..]].concat());
    assert!(!revised && !said.contains("at_line") && !said.contains("fault:"), "{said}");
}

#[test]
fn every_template_fits() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let fits = |arguments: &[&str]| {
        let output = gyrowatch().current_dir(dir.path()).args(arguments).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let mut answers = Vec::new();
    for format in ["csv", "json", "xlsx"] {
        let name = format!("campaign.{format}");
        template("campaign", format, &at(&name));
        answers.push(fits(&["calibrate", &name, "--format", "json"]));
    }
    assert!(answers[0] == answers[1] && answers[1] == answers[2], "one campaign in three formats");
    template("record", "json", &at("record.json"));
    assert!(fits(&["separate", "record.json"]).contains("LFG-0101"));
    template("programme", "csv", &at("programme.csv"));
    let programme = std::fs::read_to_string(at("programme.csv")).unwrap();
    assert_eq!(programme.lines().filter(|line| !line.starts_with('#')).count(), 1 + 24 + 12);
    // Of another IMU than the record's: both templates can be sent. Its figures are such as a station writes.
    let campaign = std::fs::read_to_string(at("campaign.csv")).unwrap();
    assert!(campaign.contains("# imu: IMU-08\n"), "{campaign}");
    let cells = || campaign.lines().filter(|line| !line.starts_with('#')).skip(1).flat_map(|line| line.split(','));
    let noise: Vec<&str> = cells().filter(|cell| cell.len() > 15 || *cell == "-0" || cell.contains("e-")).collect();
    assert!(noise.is_empty() && cells().count() > 1000, "{noise:?}");
}
