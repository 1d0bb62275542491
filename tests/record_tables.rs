//! Records and bench results that a laboratory keeps in tables: mapped, printed, sent.

use std::process::Output;

use crate::prelude::*;

const BENCHES: &str = "# station: BENCH-1\n# method: torque_feedback\n\
    serial;measured_at;d_i_deg_per_h_g0;d_s_deg_per_h_g0;d_i_sd;d_s_sd\n\
    T-1;2016-03-01T08:00:00Z;1.25;-2.5;1e-3;2e-3\n\
    T-2;2016-03-02T08:00:00Z;0.5;0.75;;\n";

fn record_rows(change: impl Fn(&str, &str) -> String) -> String {
    let mut text = String::from("# station: ST-9\n# geometry: skewed\nimu,calibrated_at,slot,serial");
    for name in ["e_pulse_per_arcsec", "g_pulse_per_s_g0"] {
        text.push_str(&["_x", "_y", "_z"].map(|part| format!(",{name}{part}")).concat());
    }
    text.push_str(",temperature_c\n");
    let e = ["0.8473,-0.6011,1.0367", "0.8478,-0.6000,-1.0381", "0.8533,1.2062,-0.0008"];
    for at in ["2016-03-01T08:00:00Z", "2017-03-01T08:00:00Z"] {
        for ((slot, serial), e) in [("G1", "T-1"), ("G2", "T-2"), ("G3", "T-3")].into_iter().zip(e) {
            text.push_str(&change(at, &format!("IMU-T,{at},{slot},{serial},{e},1.2,1.3,1.4,45\n")));
        }
    }
    text
}

fn printed(output: &Output) -> Vec<Value> {
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// `gyrowatch import` in a folder with these files.
fn import(files: &[(&str, &[u8])], arguments: &[&str]) -> Output {
    let dir = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(dir.path().join(name), bytes).unwrap();
    }
    gyrowatch().args(arguments).current_dir(dir.path()).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_table_is_printed_as_the_documents_that_it_comes_to() {
    let benches = printed(&import(&[("b.csv", BENCHES.as_bytes())], &["import", "--print", "b.csv"]));
    let first = json!({"serial": "T-1", "station": "BENCH-1", "method": "torque_feedback",
        "measured_at": "2016-03-01T08:00:00Z", "d_i_deg_per_h_g0": 1.25, "d_s_deg_per_h_g0": -2.5,
        "d_i_sd": 1e-3, "d_s_sd": 2e-3});
    assert_eq!(benches[0], first);
    assert_eq!(benches[1].get("d_i_sd"), None);

    let rows = record_rows(|_, row| row.to_owned());
    let records = printed(&import(&[("r.csv", rows.as_bytes())], &["import", "--print", "r.csv"]));
    assert_eq!(records.len(), 2);
    assert_eq!(records[1]["calibrated_at"], "2017-03-01T08:00:00Z");
    assert_eq!(records[1]["gyros"][2]["e_pulse_per_arcsec"], json!([0.8533, 1.2062, -0.0008]));
    assert_eq!((&records[0]["station"], &records[0]["temperature_c"]), (&json!("ST-9"), &json!(45.0)));
}

#[test]
fn a_header_of_ones_own_is_mapped() {
    let map = "[columns]\nserial = 'Gyro No.'\nmeasured_at = 'Date'\nd_i_deg_per_h_g0 = 'KI'\nd_s_deg_per_h_g0 = 'KS'\n\
        [values]\nstation = 'B-2'\nmethod = 'turntable_servo'\n[factors]\nd_i_deg_per_h_g0 = 15.0\n\
        [time]\nformat = '%d.%m.%Y'\noffset = '+08:00'\n";
    let table = "Gyro No.,Date,KI,KS,Inspector\nT-7,31.12.2009,0.1,0.3,Li\n";
    let files: [(&str, &[u8]); 2] = [("m.toml", map.as_bytes()), ("h.csv", table.as_bytes())];
    let arguments = ["import", "--print", "--map", "m.toml", "h.csv"];
    let found = printed(&import(&files, &arguments)).remove(0);
    let wanted = json!({"serial": "T-7", "station": "B-2", "method": "turntable_servo",
        "measured_at": "2009-12-31T00:00:00+08:00", "d_i_deg_per_h_g0": 1.5, "d_s_deg_per_h_g0": 0.3});
    assert_eq!(found, wanted);

    for (map, table, wrong) in [
        (map.replace("KS", "KT"), table.to_owned(), "column \"KT\", which the table does not have"),
        (map.replace("d_i_deg_per_h_g0 = 'KI'", "d_i_deg_per_h = 'KI'"), table.to_owned(), "did you mean"),
        (
            map.to_owned(),
            table.replace("31.12.2009", "2009-12-31"),
            "line 2, column 2 (Date): \"2009-12-31\" is not a time",
        ),
    ] {
        let refused = import(&[("m.toml", map.as_bytes()), ("h.csv", table.as_bytes())], &arguments);
        assert!(!refused.status.success() && said(&refused).contains(wrong), "{wrong}: {}", said(&refused));
    }
}

#[test]
fn a_workbook_of_results_keeps_its_dates() {
    let mut book = rust_xlsxwriter::Workbook::new();
    let sheet = book.add_worksheet();
    for (column, name) in (0..).zip(["serial", "measured_at", "d_i_deg_per_h_g0", "d_s_deg_per_h_g0"]) {
        sheet.write_string(0, column, name).unwrap();
    }
    let date = rust_xlsxwriter::ExcelDateTime::from_ymd(2014, 7, 3).unwrap().and_hms(9, 30, 0).unwrap();
    let format = rust_xlsxwriter::Format::new().set_num_format("yyyy-mm-dd hh:mm");
    sheet.write_string(1, 0, "T-1").unwrap();
    sheet.write_datetime_with_format(1, 1, &date, &format).unwrap();
    sheet.write_number(1, 2, 1.5).unwrap();
    sheet.write_number(1, 3, -0.25).unwrap();
    let map = "[values]\nstation = 'B'\nmethod = 'torque_feedback'\n[time]\noffset = '+08:00'\n";
    let files = [("m.toml", map.as_bytes().to_vec()), ("h.xlsx", book.save_to_buffer().unwrap())];
    let files: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
    let found = printed(&import(&files, &["import", "--print", "--map", "m.toml", "h.xlsx"])).remove(0);
    assert_eq!((&found["measured_at"], &found["d_i_deg_per_h_g0"]), (&json!("2014-07-03T09:30:00+08:00"), &json!(1.5)));
}

#[test]
fn faults_of_a_table_name_line_and_column() {
    let rows = |change: fn(&str, &str) -> String| record_rows(change);
    for (table, wrong) in [
        (BENCHES.replace("1.25", "1,25"), "line 4, column 3 (d_i_deg_per_h_g0): \"1,25\" has a decimal comma"),
        (BENCHES.replace("d_s_sd", "d_s_sdd"), "unknown column \"d_s_sdd\"; did you mean \"d_s_sd\"?"),
        (BENCHES.replace("# method: torque_feedback\n", ""), "no column method"),
        (BENCHES.replace("0.75;;", "0.75;;;9"), "line 5, column 7: 7 cells under 6 columns"),
        (BENCHES.replace("# station", "# statoin"), "line 1: "),
        (BENCHES.replace("0.5;0.75", "0.5;"), "line 5, column 4 (d_s_deg_per_h_g0): empty"),
        (BENCHES.split_inclusive('\n').take(3).collect(), "no rows"),
        (
            rows(|at, row| {
                if at.starts_with("2017") {
                    row.replace(",45\n", ",46\n").replacen(",46\n", ",47\n", usize::from(row.contains("G3")))
                } else {
                    row.to_owned()
                }
            }),
            "line 9, column 11 (temperature_c): differs from line 7",
        ),
    ] {
        let refused = import(&[("t.csv", table.as_bytes())], &["import", "--print", "t.csv"]);
        assert!(!refused.status.success() && said(&refused).contains(wrong), "{wrong}: {}", said(&refused));
    }
}

#[tokio::test]
async fn a_table_is_stored_as_its_documents_would_be_and_refused_by_line() {
    let server = Server::start().await;
    let dir = tempfile::tempdir().unwrap();
    let table = dir.path().join("records.csv");
    std::fs::write(
        &table,
        record_rows(|at, row| if at.starts_with("2017") { row.replace(",T-3,", ",T-2,") } else { row.to_owned() }),
    )
    .unwrap();
    let url = server.url("");
    let sent = tokio::task::spawn_blocking(move || {
        gyrowatch().args(["import", "--url", &url, &table.display().to_string()]).output()
    })
    .await
    .unwrap()
    .unwrap();
    let told = String::from_utf8_lossy(&sent.stdout).into_owned();
    assert!(told.contains("1 stored, 0 already known, 1 refused"), "{told}{}", said(&sent));
    assert!(said(&sent).contains("records.csv:7: "), "{}", said(&sent));
    let trend = server.get("/v1/gyros/T-3/trend?coefficient=D_I").await.json();
    assert_eq!(trend["points"].as_array().unwrap().len(), 1);
}
