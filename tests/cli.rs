//! The command line as people and scripts use it: what it prints where, and how it ends.

use std::io::Write;

use crate::command::{answer, printed};
use crate::support::holds;
use assert_cmd::Command;
use gyrowatch::core::effects::{CATALOGUE, Effect};
use serde_json::Value;

const PAPER: &str = "tests/data/paper.json";

fn gyrowatch(arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("gyrowatch").unwrap();
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    command
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
    let answer = answer(&["separate", PAPER]);
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
fn what_lies_outside_its_requirement_is_said_without_a_history() {
    let file = paper_with("[2.4210, 4.0554, 6.5179]", "[20.0, 4.0554, 6.5179]");
    let path = file.path().to_str().unwrap();
    let answer = answer(&["separate", path]);
    let verdicts = answer["verdicts"].as_array().unwrap();
    let said: Vec<String> = verdicts
        .iter()
        .map(|v| ["serial", "coefficient", "rule", "state"].map(|member| v[member].as_str().unwrap()).join(" "))
        .collect();
    let expected = ["LFG-0101 E within", "LFG-0101 G exceeded", "LFG-0102 E within", "LFG-0102 G within"];
    let expected =
        expected.map(|words| words.replacen(" E ", " E requirement ", 1).replacen(" G ", " G requirement ", 1));
    assert_eq!(said[..4], expected);
    assert_eq!(said.len(), 6);
    assert_eq!((verdicts[1]["value"].as_f64(), verdicts[1]["limit"].as_f64()), (Some(20.0), Some(13.23)));
    let reason = verdicts[1]["reason"].as_str().unwrap();
    assert!(
        reason.contains("G_x = 20.0 pulse/(s g0) is outside -13.2 to 13.2. Limits from judging.requirements."),
        "{reason}"
    );
    let table = printed(&["separate", path]);
    assert!(table.contains(&format!("G1 LFG-0101: {reason}")), "{table}");
    assert!(table.contains("E and G against what is required of them") && table.contains("unconfirmed"), "{table}");
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
    for (arguments, names) in [
        (&["simulate", "--preset", "nope"][..], "presets are 24-position"),
        (&["simulate", "--count", "3"], "--dir"),
        (&["simulate", "--csv"], "--preset paper-experiment"),
        (&["simulate", "--preset", "paper-experiment", "--dir", "d", "--csv"], "--csv"),
        (&["simulate", "--preset", "paper-experiment", "--out", "x"], "--count, and --dir or --csv only"),
        (&["export", "x.dat"], "--format"),
        (&["import", "tests"], "--watch"),
        (&["blindcheck", "--count", "0"], "from 1 on"),
        (&["blindcheck", "--detectability", "8,-1"], "positive"),
    ] {
        let refused = complaint(&mut gyrowatch(arguments), 2);
        assert!(refused.contains(names), "{names} is not in {refused}");
    }
}

/// No code, and the reader's language: what is refused is a message, in every command.
#[test]
fn what_is_refused_is_said_in_both_languages() {
    let scenario = printed(&["simulate", "--print-scenario"]).replace("\ndwell_s = 180.0", "\ndwell_s = -1.0");
    let mut file = tempfile::Builder::new().suffix(".toml").tempfile().unwrap();
    file.write_all(scenario.as_bytes()).unwrap();
    let scenario = file.path().to_str().unwrap();
    let reversed = paper_with("[0.8473, -0.6011, 1.0367]", "[-0.8473, 0.6011, -1.0367]");
    let reversed = reversed.path().to_str().unwrap();
    let own = "docs/examples/creep.toml";
    let campaign = "tests/data/practice/campaign-00.json";
    let cases: [(&[&str], i32, &str, &str); 14] = [
        (&["separate", "absent.json"], 1, "No such file", "没有此文件"),
        (&["blindcheck", "--count", "0"], 2, "from 1 on", "从1起的整数"),
        (&["token", "create", "a", "--role", "b"], 2, "must be one of", "之一"),
        (&["export", "x.csv", "--from", "soon"], 2, "must be a day (UTC)", "2026-03-01"),
        (&["simulate", "--scenario", scenario], 1, "-1 is not a positive number of seconds", "仿真场景"),
        (&["blindcheck", "--hypothesis", own, "--scenario", scenario], 1, "not a positive number", "仿真场景"),
        (&["simulate", "--csv"], 2, "--csv needs --preset", "--csv只用于"),
        (&["separate", reversed], 1, "deg away from", "输入轴"),
        (&["separate", campaign], 1, "this is a campaign", "这是标定试验"),
        (&["calibrate", PAPER], 1, "this is a calibration record", "这是标定记录"),
        (&["import", "tests"], 2, "is a directory", "是文件夹"),
        (
            &["void", "1", "--author", "a", "--reason", "b", "--url", "http://127.0.0.1:9"],
            1,
            "cannot reach",
            "无法连接",
        ),
        (&["verify", "--config", "tests/data/absent.toml"], 1, "configuration cannot be read", "无法读取配置"),
        (&["token", "list"], 1, "there is no database", "没有数据库"),
    ];
    for (arguments, status, english, chinese) in cases {
        for (locale, words) in [("C", english), ("zh_CN.UTF-8", chinese)] {
            let mut command = gyrowatch(arguments);
            command.env("LC_ALL", locale).env("GYROWATCH_DATABASE_URL", "sqlite://absent/of/course.db");
            let refused = complaint(command.env("GYROWATCH_PLAUSIBILITY__MAX_MISALIGNMENT_DEG", "180"), status);
            assert!(refused.contains(words), "{words} is not in {refused}");
            let shown = gyrowatch::words::sources(gyrowatch::words::Language::English);
            let codes = shown.iter().flat_map(|source| source.lines()).filter_map(|line| line.split_once(" = "));
            let code = codes.map(|(code, _)| code).find(|code| code.contains('_') && refused.contains(code));
            assert_eq!(code, None, "{refused}");
        }
    }
    for (key, value, said) in [
        ("JUDGING__BUDGET", "-1", "配置项judging.budget：应为正数，实为-1"),
        ("JUDGING__BUDGET", "wide", "配置项judging.budget：应为数，实为字符串\"wide\""),
        ("JUDGING__BUDGE", "1", "未知的键`budge`，可用的有`method`、`budget`"),
        ("SERVER__LISTEN", "8080", "配置项server.listen：应为IP地址与端口"),
    ] {
        let mut wrong = gyrowatch(&["config"]);
        let refused = complaint(wrong.env("LC_ALL", "zh_CN.UTF-8").env(format!("GYROWATCH_{key}"), value), 1);
        assert!(refused.contains(said), "{refused}");
    }
}

#[test]
fn a_document_of_another_kind_is_sent_to_its_own_command() {
    let campaign = "tests/data/practice/campaign-00.json";
    let refused = complaint(&mut gyrowatch(&["separate", campaign]), 1);
    assert!(refused.contains(campaign) && refused.contains("this is a campaign: calibrate it with"), "{refused}");
    assert!(!refused.contains("unknown member"), "{refused}");
    let refused = complaint(&mut gyrowatch(&["calibrate", PAPER]), 1);
    assert!(refused.contains(PAPER) && refused.contains("this is a calibration record"), "{refused}");
    assert!(!refused.contains("unknown member"), "{refused}");
    let benches = std::fs::read_to_string("tests/data/paper-bench.ndjson").unwrap();
    for command in ["separate", "calibrate"] {
        let one = benches.lines().next().unwrap();
        let refused = complaint(gyrowatch(&[command, "-"]).write_stdin(one), 1);
        assert!(refused.contains("this is a bench result") && !refused.contains("unknown member"), "{refused}");
        let refused = complaint(&mut gyrowatch(&[command, "tests/data/paper-bench.ndjson"]), 1);
        let told = refused.contains("several JSON documents") && refused.contains("gyrowatch import");
        assert!(told && !refused.contains("unknown member"), "{refused}");
    }
    // A record that is not complete is refused as a record.
    let timeless = std::fs::read_to_string(PAPER).unwrap().replacen("calibrated_at", "measured_at", 1);
    let refused = complaint(gyrowatch(&["diagnose", "-"]).write_stdin(timeless), 1);
    assert!(refused.contains("`calibrated_at` is missing") && !refused.contains("dwells"), "{refused}");
}

#[test]
fn a_fit_for_people_shows_two_digits_of_every_standard_deviation_and_names_its_test() {
    let table = printed(&["calibrate", "tests/data/practice/campaign-00.json"]);
    assert!(table.contains("p, lack of fit"), "{table}");
    assert!(table.contains(" ± ") && !table.contains("± 0.000000 "), "{table}");
}

/// The paper's record with E or G of one gyro times a factor.
fn scaled(gyro: usize, member: &str, factor: f64) -> String {
    let mut record: Value = serde_json::from_str(&std::fs::read_to_string(PAPER).unwrap()).unwrap();
    for figure in record["gyros"][gyro][member].as_array_mut().unwrap() {
        *figure = (figure.as_f64().unwrap() * factor).into();
    }
    record.to_string()
}

#[test]
fn a_drift_in_another_unit_is_refused_by_place_limit_and_key() {
    let scaled = |factor| scaled(0, "g_pulse_per_s_g0", factor);
    let refused = complaint(gyrowatch(&["separate", "-"]).write_stdin(scaled(1e3)), 1);
    holds(&refused, &["/gyros/0/g_pulse_per_s_g0", "beyond 1000,", "plausibility.max_drift_deg_per_h_g0"]);
    // 6.5 pulse/s/g0 over 1.47 pulse/arcsec are 4.44 deg/(h g0); 432 is the largest that measured/xsens-mti.json gives.
    gyrowatch(&["separate", "-"]).write_stdin(scaled(432.0 / 4.44)).assert().success();
    let mut other = gyrowatch(&["separate", "-"]);
    other.env("GYROWATCH_PLAUSIBILITY__MAX_DRIFT_DEG_PER_H_G0", "1e4").write_stdin(scaled(1e3)).assert().success();
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

/// What is on standard error of a command that succeeds.
fn told(command: &mut Command) -> String {
    String::from_utf8(command.assert().success().get_output().stderr.clone()).unwrap()
}

#[test]
fn help_and_refusals_name_the_effects_that_there_are() {
    let known = CATALOGUE.iter().filter(|entry| entry.effect != Effect::Scale).map(|entry| entry.id);
    let dir = tempfile::tempdir().unwrap();
    let model = dir.path().join("model.json");
    std::fs::write(&model, r#"{"terms": [], "effects": [{"effect": "gremlins", "gyros": ["G1"], "estimates": []}]}"#)
        .unwrap();
    let scenario = dir.path().join("scenario.toml");
    std::fs::write(&scenario, "[[effects]]\neffect = \"gremlins\"\n").unwrap();
    let (model, scenario) = (model.to_str().unwrap(), scenario.to_str().unwrap());
    let texts = [
        printed(&["blindcheck", "--help"]),
        printed(&["simulate", "--help"]),
        complaint(&mut gyrowatch(&["blindcheck", "--effect", "gremlins"]), 2),
        complaint(&mut gyrowatch(&["simulate", "--scenario", scenario]), 1),
        complaint(&mut gyrowatch(&["simulate", "--model", model]), 1),
    ];
    for id in known {
        // Help wraps its lines.
        assert!(texts.iter().all(|text| text.contains(id)), "{id} is missing in one of {texts:#?}");
    }
    assert!(texts[4].contains("/effects/0/effect") && texts[4].contains(model), "{}", texts[4]);
}

#[test]
fn a_diagnosis_for_people_says_how_sure_a_name_is_and_what_it_does_to_each_gyro() {
    let file = "tests/data/practice/campaign-09.json";
    let dir = tempfile::tempdir().unwrap();
    let page = dir.path().join("report.html");
    let table = printed(&["diagnose", file, "--report", page.to_str().unwrap()]);
    let page = std::fs::read_to_string(page).unwrap();
    let answer = answer(&["diagnose", file]);
    for effect in answer["effects"].as_array().unwrap() {
        let (p, d) = (effect["p_value_adjusted"].as_f64().unwrap(), effect["detectability"].as_f64().unwrap());
        let id = effect["effect"].as_str().unwrap();
        let row = table.lines().find(|line| line.starts_with(&format!("│ {id} "))).unwrap();
        assert!(row.contains(&format!("{p:.1e}")) && row.contains(&format!("{d:.1}")), "{row}");
    }
    let list = |name: &str| answer[name].as_array().cloned().unwrap_or_default();
    let moved = list("impact");
    let told = [moved.clone(), list("impact_within_noise")].concat();
    assert_eq!(told.len(), 6, "D_I and D_S of three gyros");
    for one in &told {
        let [before, after] = ["plain", "augmented"].map(|name| one[name].as_f64().unwrap());
        let (slot, coefficient) = (one["slot"].as_str().unwrap(), one["coefficient"].as_str().unwrap());
        let mut rows = table.lines().filter(|line| line.contains(slot) && line.contains(coefficient));
        assert!(rows.any(|row| row.contains(&format!("{before:+.6}")) && row.contains(&format!("{after:+.6}"))));
        for (value, sd) in [(before, "plain_sd"), (after, "augmented_sd")] {
            // To two digits of the standard deviation.
            let sd = one[sd].as_f64().unwrap();
            let places = (1.0 - sd.log10().floor()) as usize;
            // The page has no rows of what is within the noise.
            let is_shown = page.contains(&format!("{value:.places$} ± {sd:.places$}"));
            assert!(is_shown || !moved.contains(one), "{one}");
        }
    }
    for text in [&table, &page] {
        assert!(text.contains("bias, g_linear, g_squared, scale"), "the model in use is not in\n{text}");
        assert!(text.contains("of the reducible gap"), "{text}");
    }
    // What explains the same and is not named has its reason, and is told from what is chance.
    let rival = table.lines().find(|line| line.starts_with("│ bias_step")).unwrap();
    assert!(rival.contains("it explains the same dwells as warm-up after power-up less well"), "{rival}");
}

#[test]
fn a_clean_campaign_shows_no_finding_and_says_that_what_was_tried_is_chance() {
    let file = "tests/data/practice/campaign-00.json";
    let table = printed(&["diagnose", file]);
    assert!(table.contains("No gap: fitted to this campaign, the model leaves no more than noise."), "{table}");
    assert!(table.contains("within the noise: no finding") && !table.contains("Also beyond the noise"), "{table}");
    let answer = answer(&["diagnose", file]);
    let gap = &answer["gap"];
    let alone = gap["noise_alone_deg_per_h"].as_f64().unwrap();
    assert!((gap["rms_deg_per_h"].as_f64().unwrap() / alone - 1.0).abs() < 0.1, "{gap}");
    assert!(alone < answer["noise_floor"]["deg_per_h"].as_f64().unwrap(), "the fit takes up part of the noise");
    for candidate in answer["candidates"].as_array().unwrap() {
        assert_eq!(candidate["within_noise"], true, "{candidate}");
        assert!(candidate["p_value_adjusted"].as_f64().unwrap() >= 0.008, "{candidate}");
    }
}

#[test]
fn files_are_replaced_whole_and_in_so_many_words_and_adopting_spares_what_is_no_model() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (campaign, model) = (path("campaign.json"), path("model.json"));
    let simulate = ["simulate", "--preset", "24-bare", "--seed", "3", "--out", &campaign];
    assert_eq!(told(&mut gyrowatch(&simulate)), "");
    let first = std::fs::read(&campaign).unwrap();
    assert_eq!(told(&mut gyrowatch(&simulate)), format!("replaced {campaign}\n"));
    assert_eq!(std::fs::read(&campaign).unwrap(), first);

    let folder = path("many");
    let many = ["simulate", "--preset", "24-bare", "--count", "2", "--dir", &folder];
    assert_eq!(told(&mut gyrowatch(&many)), "");
    let again = told(&mut gyrowatch(&many));
    assert_eq!(again, format!("replaced 2 files in {folder}\nreplaced {folder}/key.json\n"));

    let refused = complaint(&mut gyrowatch(&["diagnose", &campaign, "--adopt", &campaign]), 1);
    assert!(refused.contains(&campaign) && refused.contains("holds no model"), "{refused}");
    assert_eq!(std::fs::read(&campaign).unwrap(), first, "the campaign is as it was");
    let adopt = ["diagnose", &campaign, "--adopt", &model];
    assert!(!told(&mut gyrowatch(&adopt)).contains("replaced"));
    assert!(told(&mut gyrowatch(&adopt)).contains(&format!("replaced {model}")));
    // Nothing is left beside them.
    let mut names: Vec<_> = std::fs::read_dir(dir.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["campaign.json", "many", "model.json"]);
}

#[test]
fn a_scale_factor_in_another_unit_is_refused_by_place_value_limit_and_key() {
    let scaled = |factor| scaled(1, "e_pulse_per_arcsec", factor);
    for factor in [3600.0, 1e3, 1.0 / 3600.0] {
        let refused = complaint(gyrowatch(&["separate", "-"]).write_stdin(scaled(factor)), 1);
        holds(&refused, &["/gyros/1/e_pulse_per_arcsec", "0.001 to 1000", "plausibility.max_scale_factor"]);
    }
    // MEMS units, whose pulse is an arcsec, and whoever says that his gyros are of another kind.
    gyrowatch(&["separate", "-"]).write_stdin(scaled(1.0 / 1.47)).assert().success();
    let mut other = gyrowatch(&["separate", "-"]);
    other.env("GYROWATCH_PLAUSIBILITY__MAX_SCALE_FACTOR", "1e4").write_stdin(scaled(3600.0)).assert().success();

    let campaign = std::fs::read_to_string("tests/data/measured/xsens-mti.json").unwrap();
    let mut campaign: Value = serde_json::from_str(&campaign).unwrap();
    campaign["gyros"][0]["known_e_pulse_per_arcsec"] = serde_json::json!([3600.0, 0, 0]);
    for command in ["calibrate", "diagnose"] {
        let refused = complaint(gyrowatch(&[command, "-"]).write_stdin(campaign.to_string()), 1);
        assert!(refused.contains("/gyros/0/known_e_pulse_per_arcsec"), "{refused}");
    }
}

#[test]
fn a_document_of_a_wrong_form_is_told_all_of_it_in_words_of_json() {
    let paper = std::fs::read_to_string(PAPER).unwrap();
    let mut record: Value = serde_json::from_str(&paper).unwrap();
    record["colour"] = "red".into();
    record["gyros"][0]["e_pulse_per_arcsec"] = "0.8".into();
    record["gyros"][2]["slot"] = 3.into();
    let refused = complaint(gyrowatch(&["separate", "-"]).write_stdin(record.to_string()), 1);
    holds(&refused, &["/colour", "/gyros/0/e_pulse_per_arcsec", "must be an array of 3 numbers", "/gyros/2/slot"]);
    for text in [record.to_string(), "[]".to_owned(), "7".to_owned(), format!("[{paper}]")] {
        let refused = complaint(gyrowatch(&["separate", "-"]).write_stdin(text), 1);
        assert!(!refused.contains("struct") && !refused.contains("Body") && !refused.contains("enum"), "{refused}");
    }
}

#[test]
fn the_clocking_is_the_small_turn_also_where_d_s_is_negative() {
    let answer = answer(&["separate", PAPER]);
    for (separation, golden) in answer["separations"].as_array().unwrap().iter().zip(GOLDEN) {
        let expected = (golden[2] / golden[1]).atan().to_degrees();
        let clocking = separation["clocking_deg"]["value"].as_f64().unwrap();
        assert!((clocking - expected).abs() < 1e-4 && clocking.abs() < 4.0, "{clocking} against {expected}");
    }
}

#[test]
fn simulated_gyros_of_another_seed_are_other_gyros() {
    let serials = |seed: &str| {
        let campaign: Value =
            serde_json::from_str(&printed(&["simulate", "--preset", "24-bare", "--seed", seed])).unwrap();
        campaign["gyros"].as_array().unwrap().iter().map(|gyro| gyro["serial"].clone()).collect::<Vec<_>>()
    };
    let (first, other) = (serials("1"), serials("2"));
    assert_eq!(first, serials("1"));
    assert!(first.iter().all(|serial| !other.contains(serial)), "{first:?} and {other:?}");
}

#[test]
fn shells_and_man_know_every_command() {
    let commands = ["serve", "import", "diagnose", "healthcheck"];
    for shell in ["bash", "zsh", "fish", "powershell"] {
        let script = printed(&["completions", shell]);
        assert!(commands.iter().all(|command| script.contains(command)), "{shell}");
    }
    assert!(printed(&["man"]).contains(".TH gyrowatch 1"));
    let dir = tempfile::tempdir().unwrap();
    printed(&["man", dir.path().to_str().unwrap()]);
    for command in commands {
        let page = std::fs::read_to_string(dir.path().join(format!("gyrowatch-{command}.1"))).unwrap();
        assert!(page.contains(".TH") && page.contains(&format!("gyrowatch\\-{command}")), "{page}");
    }
    assert!(dir.path().join("gyrowatch-token-create.1").is_file());
}

#[test]
fn an_address_of_a_database_without_a_known_scheme_is_refused() {
    for url in ["gyrowatch.db", "mysql://root:secret@host/gyros", "/var/lib/gyrowatch.db", ""] {
        let dir = tempfile::tempdir().unwrap();
        let mut command = gyrowatch(&["token", "create", "Weber", "--role", "admin"]);
        let said = complaint(command.current_dir(dir.path()).env("GYROWATCH_DATABASE_URL", url), 1);
        assert!(said.contains("database.url") && said.contains("sqlite://"), "{said}");
        assert!(!said.contains("secret"), "{said}");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0, "{url}");
    }
}

/// What people read of a diagnosis is in the language of the environment, headings of tables as well.
#[test]
fn a_diagnosis_is_printed_in_the_language_of_the_environment() {
    let said = |language: &str| {
        let output = gyrowatch(&["diagnose", "docs/examples/march.csv"]).env("LC_ALL", language).assert().success();
        String::from_utf8(output.get_output().stdout.clone()).unwrap()
    };
    let (english, chinese) = (said("C"), said("zh_CN.UTF-8"));
    for (words, same) in [
        ("IMU-30, measured by ST-2 at 2026-03-02T08:00:00Z: explained", "IMU-30，ST-2，2026-03-02T08:00:00Z：已解释"),
        ("Named effects", "指出的效应"),
        ("Blind spots", "盲区"),
        ("closes: of the reducible gap", "留出闭合率：占可消除差异"),
        ("Drift coefficients before and after", "计入所指效应前后的一次项漂移系数"),
        ("Worth measuring next", "建议下一步测量"),
    ] {
        assert!(english.contains(words) && !chinese.contains(words), "{words}: {english}{chinese}");
        assert!(chinese.contains(same), "{same}: {chinese}");
    }
    // Names of effects and units stay as they are.
    let is_word = |word: &&str| word.len() > 3 && word.chars().all(char::is_alphabetic);
    let is_prose = |line: &&str| !line.contains(", ") && line.split(' ').filter(is_word).count() > 4;
    let left: Vec<&str> = chinese.lines().filter(|line| line.is_ascii()).filter(is_prose).collect();
    assert!(left.is_empty(), "{left:?}");
}
