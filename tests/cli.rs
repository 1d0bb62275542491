//! The command line as people and scripts use it: what it prints where, and how it ends.

use std::io::Write;

use assert_cmd::Command;
use serde_json::Value;

const PAPER: &str = "tests/data/paper.json";

fn gyrowatch(arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("gyrowatch").unwrap();
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    command
}

fn printed(arguments: &[&str]) -> String {
    let output = gyrowatch(arguments).assert().success();
    String::from_utf8(output.get_output().stdout.clone()).unwrap()
}

/// What goes to standard error, and that nothing goes to standard output.
fn complaint(command: &mut Command, status: i32) -> String {
    let output = command.assert().code(status);
    assert_eq!(String::from_utf8_lossy(&output.get_output().stdout), "");
    String::from_utf8(output.get_output().stderr.clone()).unwrap()
}

fn paper_with(from: &str, to: &str) -> tempfile::NamedTempFile {
    let text = std::fs::read_to_string(PAPER).unwrap();
    assert!(text.contains(from));
    let mut file = tempfile::Builder::new().suffix(".json").tempfile().unwrap();
    file.write_all(text.replacen(from, to, 1).as_bytes()).unwrap();
    file
}

/// The golden figures of Tables 3 and 4, computed apart from this program: rigid D_I, D_S, D_O and published D_I, D_S.
const GOLDEN: [[f64; 5]; 3] = [
    [2.957643, 4.618005, 0.075874, 2.958219, 4.618253],
    [0.688549, 3.898225, 0.232169, 0.688255, 3.898324],
    [1.191559, -6.752265, -0.019514, 1.187903, -6.752266],
];

fn near(value: &Value, golden: f64) {
    let value = value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    assert!((value - golden).abs() < 1e-6, "{value} against {golden}");
}

#[test]
fn the_papers_record_is_separated_into_its_golden_figures() {
    let answer: Value = serde_json::from_str(&printed(&["separate", PAPER, "--format", "json"])).unwrap();
    for (separation, golden) in answer["separations"].as_array().unwrap().iter().zip(GOLDEN) {
        assert_eq!(separation["method"], "rigid");
        for (name, golden) in ["d_i", "d_s", "d_o"].iter().zip(golden) {
            near(&separation[name]["value"], golden);
            assert!(separation[name]["sd"].is_null(), "the paper gives no standard deviations");
        }
        near(&separation["published"]["d_i"], golden[3]);
        near(&separation["published"]["d_s"], golden[4]);
    }
    let branches: Vec<_> = (0..3).map(|i| answer["separations"][i]["published"]["branch"].clone()).collect();
    assert_eq!(branches, ["8", "10", "13"]);
}

#[test]
fn another_method_can_stand_first() {
    let json = printed(&["separate", PAPER, "--format", "json", "--method", "published"]);
    let answer: Value = serde_json::from_str(&json).unwrap();
    for (separation, golden) in answer["separations"].as_array().unwrap().iter().zip(GOLDEN) {
        assert_eq!(separation["method"], "published");
        near(&separation["d_i"]["value"], golden[3]);
        near(&separation["rigid"]["d_i"], golden[0]);
    }
}

#[test]
fn people_get_a_table_with_every_method() {
    let table = printed(&["separate", PAPER]);
    for figure in ["+2.957643", "+4.618005", "+0.075874", "+2.958219", "published (8)", "as printed (10)", "LFG-0103"] {
        assert!(table.contains(figure), "{figure} is not in\n{table}");
    }
}

#[test]
fn standard_deviations_are_carried_through() {
    let stated = r#"[2.4210, 4.0554, 6.5179], "e_sd": [0,0,0], "g_sd": [0.001, 0.001, 0.001]}"#;
    let file = paper_with("[2.4210, 4.0554, 6.5179]}", stated);
    let json = printed(&["separate", file.path().to_str().unwrap(), "--format", "json"]);
    let answer: Value = serde_json::from_str(&json).unwrap();
    // Equal and independent errors of G keep their size under a rotation and are divided by |E| = 1.467646.
    for name in ["d_i", "d_s", "d_o"] {
        near(&answer["separations"][0][name]["sd"], 0.001 / 1.467646);
    }
}

#[test]
fn a_dash_reads_standard_input() {
    let record = std::fs::read(PAPER).unwrap();
    let output = gyrowatch(&["separate", "-"]).write_stdin(record).assert().success();
    assert_eq!(output.get_output().stdout, printed(&["separate", PAPER]).into_bytes());
}

#[test]
fn an_error_names_the_file_and_the_field_and_exits_with_1() {
    let missing = complaint(&mut gyrowatch(&["separate", "no-such-file.json"]), 1);
    assert!(missing.contains("no-such-file.json"), "{missing}");

    let file = paper_with(r#""slot": "G2""#, r#""slot": "G1""#);
    let name = file.path().to_str().unwrap();
    let wrong = complaint(&mut gyrowatch(&["separate", name]), 1);
    assert!(wrong.contains(name) && wrong.contains("/gyros/1/slot"), "{wrong}");

    let not_json = complaint(gyrowatch(&["separate", "-"]).write_stdin("not json"), 1);
    assert!(not_json.contains("standard input"), "{not_json}");
}

#[test]
fn wrong_usage_exits_with_2() {
    for arguments in [&["separate"][..], &["no-such-command"], &[], &["separate", PAPER, "--format", "xml"]] {
        gyrowatch(arguments).assert().code(2);
    }
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_gyrowatch"))
        .args(["separate", PAPER, "--format", "json"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert!(output.status.success());
}

#[test]
fn import_says_which_address_does_not_answer() {
    // Port 9 (discard) of the loopback: nobody listens there, so that the connection is refused at once.
    let output = gyrowatch(&["import", "--url", "127.0.0.1:9", "--no-retry", PAPER]).assert().code(1);
    let stderr = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(stderr.contains("127.0.0.1:9") && stderr.contains(PAPER), "{stderr}");
}
