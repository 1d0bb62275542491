use super::*;
use crate::core::campaign::{Dwell, Phase};
use crate::wire::campaign::{parse_json, to_json};
use crate::wire::document::parse;
use crate::words::Language;

const TABLE: &str = "\
# imu: IMU-07
# station: ST-2
# measured_at: 2026-03-01T08:00:00Z
# geometry: skewed
# started by hand at 08:02
# site.latitude_deg: 0
# site.gravity_g0: 1.0
# gyros: G1 A, G3 B
phase,start_s,duration_s,attitude_w,attitude_x,attitude_y,attitude_z,specific_force_g0_x,specific_force_g0_y,specific_force_g0_z,rate_arcsec_s_x,rate_arcsec_s_y,rate_arcsec_s_z,temperature_c,output_pulse_s_1,output_pulse_s_2,output_sem_pulse_s_1,output_sem_pulse_s_2
static,0,180,1,0,0,0,0,0,1,0,15.041067,0,45.0,1.0,2.0,0.1,0.2
static,240,180,0,1,0,0,0,0,-1,0,-15.041067,0,45.1,1.5,2.5,0.1,0.2
rate,480,180,1,0,0,0,0,0,1,0,0,7200,45.0,1.5,2.5,0.1,0.2
";

const JSON: &str = r#"{"imu": "IMU-07", "station": "ST-2", "measured_at": "2026-03-01T08:00:00Z", "geometry": "skewed",
 "site": {"latitude_deg": 0, "gravity_g0": 1.0}, "gyros": [{"slot": "G1", "serial": "A"}, {"slot": "G3", "serial": "B"}],
 "dwells": [
 {"phase": "static", "start_s": 0, "duration_s": 180, "attitude": [1, 0, 0, 0], "specific_force_g0": [0, 0, 1],
  "rate_arcsec_s": [0, 15.041067, 0], "temperature_c": 45.0, "output_pulse_s": [1, 2], "output_sem_pulse_s": [0.1, 0.2]},
 {"phase": "static", "start_s": 240, "duration_s": 180, "attitude": [0, 1, 0, 0], "specific_force_g0": [0, 0, -1],
  "rate_arcsec_s": [0, -15.041067, 0], "temperature_c": 45.1, "output_pulse_s": [1.5, 2.5], "output_sem_pulse_s": [0.1, 0.2]},
 {"phase": "rate", "start_s": 480, "duration_s": 180, "attitude": [1, 0, 0, 0], "specific_force_g0": [0, 0, 1],
  "rate_arcsec_s": [0, 0, 7200], "temperature_c": 45.0, "output_pulse_s": [1.5, 2.5], "output_sem_pulse_s": [0.1, 0.2]}]}"#;

fn faults(text: &str) -> Vec<String> {
    match parse(text.as_bytes()) {
        Ok(_) => Vec::new(),
        Err(faults) => faults.0.into_iter().map(|f| Language::English.words(&f.message)).collect(),
    }
}

/// The one fault of the table after a replacement.
fn fault_after(from: &str, to: &str) -> String {
    assert!(TABLE.contains(from), "{from} is not in the table");
    let mut found = faults(&TABLE.replacen(from, to, 1));
    assert_eq!(found.len(), 1, "{from} -> {to}: {found:?}");
    found.remove(0)
}

#[test]
fn the_table_says_what_the_json_says() {
    assert_eq!(parse(TABLE.as_bytes()), parse(JSON.as_bytes()));
    assert!(parse(TABLE.as_bytes()).is_ok());
}

#[test]
fn what_is_written_as_csv_reads_back() {
    let mut campaign = parse_json(JSON.as_bytes()).expect("sound");
    campaign.note = Some("two\nlines, \"quoted\",".into());
    campaign.gyros[0].known_e = Some(nalgebra::Vector3::new(0.8473, -0.6011, 1.0367));
    assert_eq!(parse(to_csv(&campaign).as_bytes()), Ok(campaign.clone()));
    assert_eq!(parse(to_json(&campaign).as_bytes()), Ok(campaign));
}

#[test]
fn marks_line_ends_delimiters_and_spreadsheet_habits_are_fine() {
    let plain = parse(TABLE.as_bytes()).expect("sound");
    let semicolons: String =
        TABLE.lines().map(|l| if l.starts_with('#') { l.into() } else { l.replace(',', ";") } + "\n").collect();
    let quoted: String =
        TABLE.lines().map(|l| if l.starts_with("# g") { format!("\"{l}\",,,\n") } else { format!("{l}\n") }).collect();
    for text in [
        format!("\u{feff}{TABLE}"),
        TABLE.replace('\n', "\r\n"),
        semicolons.clone(),
        semicolons.replace(';', "\t"),
        quoted,
        TABLE.replace(" G1 A, G3 B", r#" [{"slot": "G1", "serial": "A"}, {"slot": "G3", "serial": "B"}]"#),
        TABLE.replace("# gyros: G1 A, G3 B", "# slot_1: G1\n# serial_1: A\n# slot_2: G3\n# serial_2: B"),
        TABLE.replace("# imu: ", "#  imu : ").replace("# started by hand at", "# begun by: hand, at"),
        TABLE.replace("site.latitude_deg", "latitude_deg").replace("phase,", "\n\nphase,"),
        format!("{TABLE}\n\n,,,,\n# the end\n"),
    ] {
        assert_eq!(parse(text.as_bytes()).as_ref(), Ok(&plain), "{text}");
    }
}

#[test]
fn a_wrong_header_is_named_by_line_and_column() {
    assert_eq!(
        fault_after("temperature_c,", "Temperature,"),
        "line 9, column 14: unknown column \"Temperature\"; did you mean \"temperature_c\"?"
    );
    assert!(
        faults(&TABLE.replacen("rate_arcsec_s_y", "rate_deg_s_y", 1)).iter().any(|f| f.contains("line 9, column 12"))
    );
    let doubled = faults(&TABLE.replacen("rate_arcsec_s_y", "rate_arcsec_s_x", 1));
    assert_eq!(
        doubled,
        ["line 9, column 12: a second column \"rate_arcsec_s_x\"", "line 9: no column rate_arcsec_s_y"]
    );
    assert_eq!(fault_after("output_sem_pulse_s_1,", ","), "line 9: no column output_sem_pulse_s_1");
    let one_gyro = faults(&TABLE.replacen("gyros: G1 A, G3 B", "gyros: G1 A", 1));
    assert_eq!(one_gyro[0], "line 9: 2 columns of output_pulse_s, but 1 gyros in the head");
    assert!(faults("# imu: X\n")[0].contains("no table"));
}

#[test]
fn bad_cells_are_named_by_line_and_column() {
    assert_eq!(fault_after("-1,0,-15.041067", "-1,0,x"), "line 11, column 12 (rate_arcsec_s_y): \"x\" is not a number");
    assert!(fault_after("45.1", "NaN").starts_with("line 11, column 14 (temperature_c): must be a finite number"));
    assert!(fault_after("240,180", "240,").starts_with("line 11, column 3 (duration_s): empty"));
    assert!(fault_after("240,180", "100,180").starts_with("line 11, column 2 (start_s): overlaps"));
    assert!(
        fault_after("1.5,2.5,0.1,0.2\nrate", "1.5,2.5,0.1,0\nrate")
            .starts_with("line 11, column 18 (output_sem_pulse_s_2)")
    );
    assert!(fault_after("rate,480", "turn,480").starts_with("line 12, column 1 (phase): must be static or rate"));
    assert!(
        fault_after("0,1,0,0,0,0,-1", "0,0.9,0,0,0,0,-1").starts_with("line 11, column 4 (attitude_w): must be a unit")
    );
}

#[test]
fn a_cell_without_a_value_comes_with_the_way_out() {
    let errors = "leave every column of output_sem_pulse_s in this row empty";
    for (from, to, column, way_out) in [
        ("1.5,2.5,0.1,0.2\nrate", "1.5,2.5,,0.2\nrate", 17, errors),
        ("1.5,2.5,0.1,0.2\nrate", "1.5,2.5,0.1,-\nrate", 18, errors),
        ("45.1", "n/a", 14, "leave every column of temperature_c in this row empty"),
        ("1.5,2.5,0.1,0.2\nrate", "1.5,,0.1,0.2\nrate", 16, "where a gyro has no output, leave the row out"),
        ("1.5,2.5,0.1,0.2\nrate", "NaN,2.5,0.1,0.2\nrate", 15, "where a gyro has no output, leave the row out"),
        ("1.5,2.5,0.1,0.2\nrate", "1.5,--,0.1,0.2\nrate", 16, "where a gyro has no output, leave the row out"),
    ] {
        let fault = fault_after(from, to);
        assert!(fault.starts_with(&format!("line 11, column {column} (")) && fault.ends_with(way_out), "{fault}");
    }
    assert!(fault_after("1.5,2.5,0.1,0.2\nrate", "1.5,2.5x,0.1,0.2\nrate").ends_with("is not a number"));
    assert!(faults(&TABLE.replacen("1.5,2.5,0.1,0.2\nrate", "1.5,2.5,,\nrate", 1)).is_empty());
}

#[test]
fn an_unknown_separator_is_named() {
    for separator in ["|", " ", ":"] {
        let table: String = TABLE
            .lines()
            .map(|line| if line.starts_with('#') { line.to_owned() } else { line.replace(',', separator) } + "\n")
            .collect();
        let expected = format!("line 9: the columns are separated by \"{separator}\"");
        assert!(faults(&table)[0].starts_with(&expected), "{:?}", faults(&table));
    }
}

#[test]
fn lines_are_those_of_the_file_below_remarks_and_empty_lines() {
    let remarked = TABLE.replacen("static,240", "# a pause\n\n# of, two\nstatic,240", 1).replacen("45.1", "warm", 1);
    let remarked = remarked.replacen("rate,480,180", "\n# turning\nrate,480,long", 1);
    for text in [remarked.clone(), remarked.replace('\n', "\r\n")] {
        let found = faults(&text);
        assert!(found[0].starts_with("line 14, column 14 (temperature_c)"), "{found:?}");
        assert!(found[1].starts_with("line 17, column 3 (duration_s)") && found.len() == 2, "{found:?}");
    }
}

#[test]
fn a_table_whose_rows_are_all_wrong_is_not_without_rows() {
    let (head, _) = TABLE.split_once("static,").expect("rows");
    assert_eq!(faults(head), ["the table has a header and no rows"]);
    let found = faults(&format!("{head}{}", TABLE.lines().last().expect("a row").replacen("480", "late", 1)));
    assert_eq!(found, ["line 10, column 2 (start_s): \"late\" is not a number"]);
}

#[test]
fn a_decimal_comma_is_named_by_line_and_column() {
    let unquoted = fault_after("45.1", "45,1");
    assert!(unquoted.starts_with("line 11, column 14 (temperature_c): 19 cells under 18 columns"), "{unquoted}");
    assert!(unquoted.contains("is 45,1 a number with a decimal comma"), "{unquoted}");
    let among_zeros = fault_after("0,15.041067,0,45.0", "0,15,041067,0,45.0");
    assert!(among_zeros.starts_with("line 10, column 12 (rate_arcsec_s_y)"), "{among_zeros}");
    let quoted = fault_after("45.1", "\"45,1\"");
    assert!(quoted.starts_with("line 11, column 14 (temperature_c): \"45,1\" has a decimal comma"), "{quoted}");
    let semicolons: String = TABLE
        .lines()
        .map(|l| if l.starts_with('#') { l.into() } else { l.replace(',', ";").replace('.', ",") } + "\n")
        .collect();
    let first = "line 10, column 12 (rate_arcsec_s_y): \"15,041067\" has a decimal comma; write decimals with a point";
    let all = format!("17 cells in lines 10 to 12 have the same fault; the first: {first}");
    assert_eq!(faults(&semicolons), [all]);
}

#[test]
fn the_head_is_checked_by_line() {
    assert!(fault_after("# imu: IMU-07", "# imu: ").starts_with("line 1 (imu): must not be empty"));
    assert!(fault_after("# imu: IMU-07\n", "").contains("`imu` is missing"));
    assert!(fault_after("# imu", "# operater: x\n# imu").starts_with("line 1: unknown key \"operater\""));
    assert!(fault_after("# imu", "# imu: IMU-07\n# imu").starts_with("line 2: imu is given twice"));
    assert!(fault_after(" G1 A, G3 B", " [{").starts_with("line 8 (gyros): is not JSON"));
    assert!(fault_after("latitude_deg: 0", "latitude_deg: 34,25").contains("decimal comma"));
    assert!(fault_after("G3 B", "G4 B").starts_with("line 8 (gyros): must be G1, G2 or G3"));
    assert!(fault_after("gravity_g0: 1.0", "gravity_g0: 9.8").starts_with("line 7 (site)"));
}

#[test]
fn full_width_colons_and_equals_signs_part_known_keys_from_values() {
    let plain = parse(TABLE.as_bytes());
    let note = |mark: &str| parse(TABLE.replacen("# geo", &format!("# note{mark}a = b: c\n# geo"), 1).as_bytes());
    for mark in ["：", " = ", "=", "＝"] {
        assert_eq!(parse(TABLE.replace("# imu: ", &format!("# imu{mark}")).as_bytes()), plain, "{mark}");
        assert_eq!(parse(TABLE.replace("# started", &format!("# fan{mark}on, by")).as_bytes()), plain, "{mark}");
        assert_eq!(note(mark).expect("a note").note.as_deref(), Some("a = b: c"), "{mark}");
        let found = faults(&TABLE.replacen("rate,480", &format!("# imu{mark}IMU-08\nrate,480"), 1));
        assert!(found.len() == 1 && found[0].starts_with("line 12: imu"), "{mark}: {found:?}");
        assert!(fault_after("# imu: ", &format!("# station{mark}ST-2\n# imu: ")).contains("given twice"), "{mark}");
        let bare = faults(&TABLE.replacen("# imu: ", &format!("imu{mark}"), 1));
        assert!(bare.iter().any(|fault| fault.contains("belongs to the head")), "{mark}: {bare:?}");
    }
}

#[test]
fn a_key_below_the_header_is_refused_where_it_says_something_else() {
    let below = |line: &str| faults(&TABLE.replacen("static,240", &format!("{line}\nstatic,240"), 1));
    for same in ["# imu: IMU-07", "# latitude_deg: 0", "# pause: 2", "# begun at 08:02", "# serial_2: B"] {
        assert_eq!(below(same), [""; 0], "{same}");
    }
    for (other, key) in [
        ("# imu: IMU-08", "imu"),
        ("# operator: Li Wei", "operator"),
        ("\"# gyros: G1 A, G3 C\",,", "gyros"),
        ("# gravity_g0: much", "gravity_g0"),
    ] {
        let found = below(other);
        assert!(found[0].starts_with(&format!("line 11: {key} stands below the header row")), "{other}: {found:?}");
        assert_eq!(found.len(), 1, "{other}: {found:?}");
    }
    let second = TABLE.replacen("IMU-07", "IMU-08", 1).replacen("03-01", "03-02", 1);
    let found = faults(&format!("{TABLE}{second}"));
    assert!(found.len() == 2 && found[0].starts_with("line 13: imu") && found[1].starts_with("line 15:"), "{found:?}");
}

#[test]
fn what_is_not_utf_8_says_so() {
    assert!(parse(b"\xff\xfe#\0").unwrap_err().0[0].message.code == "utf16");
    assert!(
        parse(b"# imu: X\n# note: \xe9\n").unwrap_err().0[0].message.to_string()
            == "at_line (line: 2, fault: not_utf8_text)"
    );
}

/// What docs/formats.md says of a campaign's CSV, and its example.
fn documented() -> (&'static str, &'static str) {
    let (_, after) =
        include_str!("../../../docs/formats.md").split_once("\n### A campaign as CSV\n").expect("a section");
    let section = after.split_once("\n## ").map_or(after, |(section, _)| section);
    let example = section.split("```").nth(1).and_then(|block| block.strip_prefix("text\n")).expect("an example");
    (section, example)
}

#[test]
fn the_example_in_the_docs_is_read_as_it_says() {
    let campaign = parse(documented().1.as_bytes()).unwrap_or_else(|faults| panic!("{faults}"));
    assert_eq!((campaign.imu.to_string().as_str(), campaign.gyros.len(), campaign.dwells.len()), ("IMU-07", 3, 4));
    assert_eq!(campaign.dwells[3].phase, Phase::Rate);
    let complete = |d: &Dwell| d.attitude.is_some() && d.temperature_c.is_some() && d.output_sem_pulse_s.is_some();
    assert!(campaign.site.is_some() && campaign.dwells.iter().all(complete), "the example shows every column");
}

#[test]
fn the_docs_name_every_column_and_every_key() {
    let text = documented().0;
    for (field, parts, _) in cells::FIELDS {
        assert!(parts.iter().all(|part| text.contains(&format!("{field}{part}"))), "{field}");
    }
    let numbered = head::GYRO_KEYS.iter().map(|(key, _)| format!("{key}_1"));
    for key in head::KEYS.iter().map(|(key, ..)| (*key).to_owned()).chain(numbered) {
        assert!(text.contains(&format!("`{key}")) || text.contains(&format!("`site.{key}")), "{key}");
    }
}
