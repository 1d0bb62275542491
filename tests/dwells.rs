//! `dwells`: raw logs of every layout that the maps in `examples/maps` describe, made here, and what is wrong with
//! logs.

use std::fmt::Write;
use std::fs;
use std::process::Output;

use assert_cmd::Command;
use gyrowatch::core::campaign::{Campaign, Dwell, Phase};
use gyrowatch::simulate::presets::preset;
use gyrowatch::simulate::simulate;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::prelude::*;

const G: f64 = 9.806_65;

fn map(name: &str) -> PathBuf {
    root().join("examples/maps").join(name)
}

fn dwells(dir: &Path, arguments: &[&str]) -> Output {
    Command::cargo_bin("gyrowatch").unwrap().current_dir(dir).arg("dwells").args(arguments).output().unwrap()
}

fn campaign(output: &Output) -> Value {
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {said}"))
}

fn refused(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stdout));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Positions of an IMU held by hand: body directions that point up.
const UPS: [[f64; 3]; 6] =
    [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0], [0.0, 0.6, -0.8], [-1.0, 0.0, 0.0]];
const BIAS: [f64; 3] = [0.3, -0.2, 0.1];

/// 100 Hz: five seconds in each position, three seconds of turning between; time, force in g0, rates in deg/s.
fn by_hand(seed: u64) -> Vec<(f64, [f64; 3], [f64; 3])> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let mut rows = Vec::new();
    for k in 0..(UPS.len() * 800 - 300) {
        let (position, into) = (k / 800, (k % 800) as f64 * 0.01);
        let share = ((into - 5.0) / 3.0).clamp(0.0, 1.0);
        let next = UPS[(position + 1).min(UPS.len() - 1)];
        let mixed: Vec<f64> = (0..3).map(|c| UPS[position][c] * (1.0 - share) + next[c] * share).collect();
        let length = mixed.iter().map(|c| c * c).sum::<f64>().sqrt().max(0.1);
        let turning = if share > 0.0 { 40.0 * (std::f64::consts::PI * share).sin() } else { 0.0 };
        let force = [0, 1, 2].map(|c| mixed[c] / length + noise(1e-3));
        let rate = [0, 1, 2].map(|c| BIAS[c] + turning * (1.0 + c as f64) + noise(0.05));
        rows.push((k as f64 * 0.01, force, rate));
    }
    rows
}

fn check_by_hand(campaign: &Value) {
    let dwells = campaign["dwells"].as_array().unwrap();
    assert_eq!(dwells.len(), UPS.len(), "{dwells:?}");
    for (dwell, up) in dwells.iter().zip(UPS) {
        let list =
            |name: &str| -> Vec<f64> { dwell[name].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
        assert!(list("specific_force_g0").iter().zip(up).all(|(f, u)| (f - u).abs() < 0.01), "{dwell}");
        let sem = list("output_sem_pulse_s");
        for ((mean, bias), sem) in list("output_pulse_s").iter().zip(BIAS).zip(&sem) {
            assert!((mean - 3600.0 * bias).abs() < 6.0 * sem, "{mean} {sem}");
            // 0.05 deg/s a sample, 450 samples.
            assert!((4.0..40.0).contains(sem), "{sem}");
        }
    }
    assert!(campaign["gyros"][1]["known_e_pulse_per_arcsec"] == json!([0.0, 1.0, 0.0]), "{campaign}");
}

#[test]
fn a_csv_of_an_ahrs_with_more_columns_than_are_needed() {
    let dir = tempfile::tempdir().unwrap();
    let mut text = String::from("HI91,sys_time,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,temperature\n");
    for (t, f, w) in by_hand(1) {
        let ms = (t * 1000.0).round();
        writeln!(text, "HI91,{ms},{},{},{},{},{},{},12.5,30,", f[0], f[1], f[2], w[0], w[1], w[2]).unwrap();
    }
    fs::write(dir.path().join("log.csv"), text).unwrap();
    let map = map("hi91-csv.toml");
    let made = campaign(&dwells(dir.path(), &["log.csv", "--map", map.to_str().unwrap()]));
    check_by_hand(&made);
    assert_eq!(made["dwells"][2]["temperature_c"], 30.0);

    let report = ["log.csv", "--map", map.to_str().unwrap(), "--report", "r.html", "-o", "c.csv"];
    assert!(dwells(dir.path(), &report).status.success());
    let page = fs::read_to_string(dir.path().join("r.html")).unwrap();
    assert_eq!(page.matches("class=\"static\"").count(), 1 + 7 * UPS.len(), "a legend, and six dwells in seven plots");
    let mut calibrate = Command::cargo_bin("gyrowatch").unwrap();
    calibrate.current_dir(dir.path()).args(["calibrate", "c.csv", "--model", "bias"]).assert().success();
}

/// As `zcat log.csv.gz | gyrowatch dwells -`, and the same from a named pipe.
#[cfg(unix)]
#[test]
fn a_log_may_come_through_a_pipe() {
    let dir = tempfile::tempdir().unwrap();
    let mut text = String::from("sys_time;acc_x;acc_y;acc_z;gyr_x;gyr_y;gyr_z;temperature\n");
    for (t, f, w) in by_hand(3) {
        let row: Vec<String> = row((t, f, w)).iter().map(|value| format!("{value:.6}").replace('.', ",")).collect();
        writeln!(text, "{}", row.join(";")).unwrap();
    }
    let utf_16: Vec<u8> = std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    for (log, text) in [("-", text.into_bytes()), ("/dev/stdin", utf_16)] {
        let mut command = Command::cargo_bin("gyrowatch").unwrap();
        command.current_dir(dir.path()).args(["dwells", log, "--map"]).arg(map("hi91-csv.toml")).write_stdin(text);
        check_by_hand(&campaign(&command.output().unwrap()));
    }
    for what in [&["--guess"][..], &["--map", map("hi91-csv.toml").to_str().unwrap()]] {
        let mut command = Command::cargo_bin("gyrowatch").unwrap();
        command.args(["dwells", "-"]).args(what).write_stdin("");
        let said = refused(&command.output().unwrap());
        assert!(said.contains("standard input: ") && !said.contains("-:"), "{said}");
    }
}

/// An array as numpy.save writes it.
fn npy(descr: &str, shape: &str, rows: impl Iterator<Item = Vec<f64>>) -> Vec<u8> {
    let mut header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}}}");
    header.push_str(&" ".repeat((64 - (10 + header.len() + 1) % 64) % 64));
    header.push('\n');
    let mut bytes = [b"\x93NUMPY\x01\x00".as_slice(), &(header.len() as u16).to_le_bytes(), header.as_bytes()].concat();
    bytes.extend(rows.flatten().flat_map(f64::to_le_bytes));
    bytes
}

const NAMES: [&str; 8] = ["sys_time", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z", "temperature"];

fn row((t, f, w): (f64, [f64; 3], [f64; 3])) -> Vec<f64> {
    [vec![(t * 1000.0).round()], f.to_vec(), w.to_vec(), vec![30.0]].concat()
}

#[test]
fn arrays_of_numpy_are_read_by_the_names_of_their_members_or_of_their_archive() {
    let dir = tempfile::tempdir().unwrap();
    let rows = by_hand(8);
    let members: Vec<String> = NAMES.iter().map(|name| format!("('{name}', '<f8')")).collect();
    let structured =
        npy(&format!("[{}]", members.join(", ")), &format!("({},)", rows.len()), rows.iter().copied().map(row));
    fs::write(dir.path().join("log.npy"), &structured).unwrap();
    let own = map("hi91-csv.toml");
    check_by_hand(&campaign(&dwells(dir.path(), &["log.npy", "--map", own.to_str().unwrap()])));

    let mut archive = zip::ZipWriter::new(fs::File::create(dir.path().join("log.npz")).unwrap());
    let (line, three) = (format!("({},)", rows.len()), format!("({}, 3)", rows.len()));
    for (name, array) in [
        ("t", npy("'<f8'", &line, rows.iter().map(|(t, ..)| vec![*t]))),
        ("gyro", npy("'<f8'", &three, rows.iter().map(|(.., w)| w.to_vec()))),
        ("acc", npy("'<f8'", &three, rows.iter().map(|(_, f, _)| f.map(|f| f * G).to_vec()))),
        ("temp", npy("'<f8'", &line, rows.iter().map(|_| vec![30.0]))),
        ("fs", npy("'<f8'", "()", std::iter::once(vec![100.0]))),
    ] {
        archive.start_file(format!("{name}.npy"), zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut archive, &array).unwrap();
    }
    archive.finish().unwrap();
    let made = campaign(&dwells(dir.path(), &["log.npz", "--map", map("matlab.toml").to_str().unwrap()]));
    check_by_hand(&made);
    assert_eq!(made["dwells"][2]["temperature_c"], 30.0);

    fs::write(dir.path().join("cut.npy"), &structured[..structured.len() - 1]).unwrap();
    let said = refused(&dwells(dir.path(), &["cut.npy", "--map", own.to_str().unwrap()]));
    assert!(said.contains("cut.npy: is a file of NumPy that breaks off"), "{said}");
    fs::write(dir.path().join("o.npy"), npy("'|O'", "(2,)", std::iter::empty())).unwrap();
    let said = refused(&dwells(dir.path(), &["o.npy", "--map", own.to_str().unwrap()]));
    assert!(said.contains("holds Python objects") && said.contains("astype(float)"), "{said}");
}

/// As pandas writes it, but for the codec that is given.
#[cfg(feature = "parquet")]
fn parquet(rows: &[Vec<f64>], compression: parquet::basic::Compression) -> Vec<u8> {
    use parquet::data_type::DoubleType;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;

    let columns: String = NAMES.iter().map(|name| format!("optional double {name}; ")).collect();
    let schema = parquet::schema::parser::parse_message_type(&format!("message log {{ {columns} }}")).unwrap();
    let properties = WriterProperties::builder().set_compression(compression).build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema.into(), properties.into()).unwrap();
    for rows in rows.chunks(1000) {
        let mut group = writer.next_row_group().unwrap();
        for k in 0..NAMES.len() {
            let values: Vec<f64> = rows.iter().map(|row| row[k]).collect();
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<DoubleType>().write_batch(&values, Some(&vec![1; values.len()]), None).unwrap();
            column.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
    bytes
}

#[cfg(feature = "parquet")]
#[test]
fn a_parquet_log_is_read_by_its_columns() {
    let dir = tempfile::tempdir().unwrap();
    let rows: Vec<Vec<f64>> = by_hand(9).into_iter().map(row).collect();
    let whole = parquet(&rows, parquet::basic::Compression::SNAPPY);
    fs::write(dir.path().join("log.parquet"), &whole).unwrap();
    let map = map("hi91-csv.toml");
    let of = |name: &str| dwells(dir.path(), &[name, "--map", map.to_str().unwrap()]);
    check_by_hand(&campaign(&of("log.parquet")));
    fs::write(dir.path().join("cut.parquet"), &whole[..whole.len() / 2]).unwrap();
    let said = refused(&of("cut.parquet"));
    assert!(said.contains("cut.parquet: cannot be read as Parquet"), "{said}");
}

#[cfg(not(feature = "parquet"))]
#[test]
fn a_parquet_log_is_named_where_the_program_cannot_read_it() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("log.parquet"), b"PAR1\x15\x04").unwrap();
    let said = refused(&dwells(dir.path(), &["log.parquet", "--map", map("hi91-csv.toml").to_str().unwrap()]));
    assert!(said.contains("is a Parquet file") && said.contains("to_csv"), "{said}");
}

#[test]
fn counts_in_two_files_without_header_beside_one_another() {
    let dir = tempfile::tempdir().unwrap();
    let (mut force, mut rate) = (String::new(), String::new());
    for (t, f, w) in by_hand(2) {
        let a = [0, 1, 2].map(|c| [33_123.0, 33_276.0, 32_360.0][c] + (f[c] * G / 0.00241).round());
        let g = [0, 1, 2].map(|c| [32_768.0, 32_466.0, 32_485.0][c] + (w[c].to_radians() / 0.00021).round());
        writeln!(force, "   {t:.7e}   {:.7e}   {:.7e}   {:.7e}", a[0], a[1], a[2]).unwrap();
        writeln!(rate, "   {t:.7e}   {:.7e}   {:.7e}   {:.7e}", g[0], g[1], g[2]).unwrap();
    }
    fs::write(dir.path().join("acc.mat"), force).unwrap();
    fs::write(dir.path().join("gyro.mat"), rate).unwrap();
    let map = map("counts-beside-one-another.toml");
    check_by_hand(&campaign(&dwells(dir.path(), &["acc.mat", "gyro.mat", "--map", map.to_str().unwrap()])));
    let one = refused(&dwells(dir.path(), &["acc.mat", "--map", map.to_str().unwrap()]));
    assert!(one.contains("the map is of 2 logs beside one another; 1 were named"), "{one}");
}

#[test]
fn decimal_commas_units_in_a_row_of_their_own_and_utf_16() {
    let dir = tempfile::tempdir().unwrap();
    let mut text =
        String::from("Messung;vom;25.11.2026;;;;\r\nZeit;ax;ay;az;gx;gy;gz\r\n[s];[g];[g];[g];[°/s];[°/s];[°/s]\r\n");
    for (t, f, w) in by_hand(3) {
        let row = format!("{t:.2};{:.5};{:.5};{:.5};{:.4};{:.4};{:.4}\r\n", f[0], f[1], f[2], w[0], w[1], w[2]);
        text.push_str(&row.replace('.', ","));
    }
    let wide: Vec<u8> = std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    fs::write(dir.path().join("wide.csv"), wide).unwrap();
    let latin: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    fs::write(dir.path().join("latin.csv"), latin).unwrap();
    let map = "imu = \"A\"\nstation = \"S\"\nmeasured_at = \"2026-03-01T08:00:00Z\"\ngeometry = \"orthogonal\"\n\
        gyros = [\"G1 X\", \"G2 Y\", \"G3 Z\"]\ntime = { column = \"Zeit\" }\n\
        force = { columns = [\"ax\", \"ay\", \"az\"] }\noutput = { columns = [\"gx\", \"gy\", \"gz\"] }\n";
    fs::write(dir.path().join("map.toml"), map).unwrap();
    for file in ["wide.csv", "latin.csv"] {
        check_by_hand(&campaign(&dwells(dir.path(), &[file, "--map", "map.toml"])));
    }
    // What the header says is not contradicted in silence.
    fs::write(dir.path().join("other.toml"), map.replace("\"gz\"]", "\"gz\"], unit = \"rad/s\"")).unwrap();
    let said = refused(&dwells(dir.path(), &["latin.csv", "--map", "other.toml"]));
    assert!(said.contains("the map says rad/s, the header of the log says °/s"), "{said}");
}

/// Times of day in a column of their own, and a table in GBK.
#[test]
fn times_of_day_are_seconds_and_chinese_headers_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let mut text = String::from(
        "日期,时间（时:分:秒）,加速度X（g）,加速度Y（g）,加速度Z（g）,陀螺1（度/秒）,陀螺2（度/秒）,陀螺3（度/秒）,温度（℃）\n",
    );
    for (t, f, w) in by_hand(7) {
        // Half a minute before midnight it begins.
        let ms = (1000.0 * t).round() as u64 + 86_370_000;
        let (day, ms) = (24 + ms / 86_400_000, ms % 86_400_000);
        let stamp = format!("{:02}:{:02}:{:02}.{:03}", ms / 3_600_000, ms / 60_000 % 60, ms / 1000 % 60, ms % 1000);
        writeln!(text, "2026/11/{day},{stamp},{},{},{},{},{},{},21.5", f[0], f[1], f[2], w[0], w[1], w[2]).unwrap();
    }
    fs::write(dir.path().join("log.csv"), encoding_rs::GBK.encode(&text).0).unwrap();
    let guessed = dwells(dir.path(), &["log.csv", "--guess"]);
    let map = String::from_utf8(guessed.stdout).unwrap();
    for line in [
        "time = { column = \"时间\", unit = \"s\" }",
        "force = { columns = [\"加速度X\", \"加速度Y\", \"加速度Z\"], unit = \"g\" }",
        "output = { columns = [\"陀螺1\", \"陀螺2\", \"陀螺3\"], unit = \"度/秒\" }",
        "temperature = { column = \"温度\", unit = \"℃\" }",
    ] {
        assert!(map.contains(line), "{line}: {map}");
    }
    let answered = map
        .replace("measured_at = \"?\"", "measured_at = \"2026-03-01T08:00:00Z\"")
        .replace("latitude_deg = \"?\", gravity_g0 = \"?\"", "latitude_deg = 34.0, gravity_g0 = 1.0")
        .replace("\"?\"\n", "\"A\"\n");
    fs::write(dir.path().join("map.toml"), answered).unwrap();
    let output = dwells(dir.path(), &["log.csv", "--map", "map.toml"]);
    let made = campaign(&output);
    check_by_hand(&made);
    assert_eq!(made["dwells"][5]["temperature_c"], 21.5);
    // It is held from 40 s on, and the beginning is cut.
    let begins = made["dwells"][5]["start_s"].as_f64().unwrap();
    assert!((40.0..42.0).contains(&begins), "across midnight: {made}");
}

#[test]
fn a_guess_of_two_logs_says_which_is_which() {
    let dir = tempfile::tempdir().unwrap();
    let (mut force, mut rate) = (String::from("t,ax,ay,az\n"), String::from("t,gx,gy,gz\n"));
    for (t, f, w) in by_hand(8) {
        writeln!(force, "{t:.2},{},{},{}", f[0], f[1], f[2]).unwrap();
        writeln!(rate, "{t:.2},{},{},{}", w[0], w[1], w[2]).unwrap();
    }
    fs::write(dir.path().join("a.csv"), force).unwrap();
    fs::write(dir.path().join("g.csv"), rate).unwrap();
    let guessed = dwells(dir.path(), &["a.csv", "g.csv", "--guess"]);
    let map = String::from_utf8(guessed.stdout).unwrap();
    assert!(map.contains("output = { columns = [\"gx\", \"gy\", \"gz\"], unit = \"?\", log = 2 }"), "{map}");
    assert!(map.contains("force = { columns = [\"ax\", \"ay\", \"az\"], unit = \"g0\", log = 1 }"), "{map}");
    let alone = String::from_utf8(dwells(dir.path(), &["g.csv", "--guess"]).stdout).unwrap();
    assert!(!alone.contains("log ="), "{alone}");
    let plain = |text: &str| text.lines().skip(1).map(|line| line.to_owned() + "\n").collect::<String>();
    for (of, name) in [("a.csv", "run_acc.txt"), ("g.csv", "run_gyro.txt")] {
        let text = fs::read_to_string(dir.path().join(of)).unwrap();
        fs::write(dir.path().join(name), plain(&text)).unwrap();
    }
    let map = String::from_utf8(dwells(dir.path(), &["run_acc.txt", "run_gyro.txt", "--guess"]).stdout).unwrap();
    assert!(
        map.contains("output = { columns = [2, 3, 4], unit = \"?\", log = 2 }"),
        "without names, by the files': {map}"
    );
    assert!(map.contains("force = { columns = [2, 3, 4], unit = \"g0\", log = 1 }"), "{map}");
    let mut chinese = Command::cargo_bin("gyrowatch").unwrap();
    chinese.current_dir(dir.path()).env("LC_ALL", "zh_CN.UTF-8").args(["dwells", "a.csv", "g.csv", "--guess"]);
    let map = String::from_utf8(chinese.output().unwrap().stdout).unwrap();
    assert!(map.contains("# 多数行的模为") && map.contains("unit = \"g0\", log = 1 }"), "{map}");
    assert!(!map.contains("which is"), "{map}");
}

#[test]
fn averages_of_a_chamber_are_dwells_already() {
    let dir = tempfile::tempdir().unwrap();
    let mut text = String::new();
    for k in 0..20 {
        let t = 2.0 + 3.0 * f64::from(k);
        let ripple = |f: f64| 5e-4 * (f * f64::from(k * k)).sin();
        let rates = [-0.002 + ripple(1.3), 0.004 + ripple(2.1), 0.002 + ripple(0.7)];
        let rates = rates.map(|rate| format!("{rate:8.5}")).join(", ");
        writeln!(text, "BIN_DATA: {k:2}, {t:6.2}, {}, 7,  0.12, -0.11,  9.80, {rates}, -49.5", 12_000 + k).unwrap();
    }
    fs::write(dir.path().join("chamber.log"), text).unwrap();
    let output = dwells(dir.path(), &["chamber.log", "--map", map("averaged-chamber.toml").to_str().unwrap()]);
    let made = campaign(&output);
    assert_eq!(made["dwells"].as_array().unwrap().len(), 20);
    assert_eq!((&made["dwells"][3]["temperature_c"], &made["dwells"][3]["duration_s"]), (&11.0.into(), &120.03.into()));
    assert!(made["dwells"][3].get("output_sem_pulse_s").is_none());
}

/// A log of pulses on a two-axis table: what the table did is in its angles.
fn on_a_table() -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut text = String::from("time,outer,inner,pulses_1,pulses_2,pulses_3,temperature\n");
    let stops = [(0.0, 0.0), (90.0, 0.0), (90.0, 90.0), (180.0, 90.0), (270.0, 90.0), (270.0, 0.0), (0.0, 0.0)];
    let mut counted = [0.0_f64; 3];
    let (mut time, mut row) = (0.0, 0);
    let mut add = |outer: f64, inner: f64, level: f64, text: &mut String| {
        let step = 0.1;
        let before = counted;
        for (c, count) in counted.iter_mut().enumerate() {
            *count += step * (100.0 + level * (1.0 + c as f64)) + 0.05 * rng.sample::<f64, _>(StandardNormal);
        }
        let pulses: Vec<f64> = (0..3).map(|c| counted[c].floor() - before[c].floor()).collect();
        row += 1;
        if row % 997 != 0 {
            writeln!(text, "{time:.3},{outer:.4},{inner:.4},{},{},{},45.2", pulses[0], pulses[1], pulses[2]).unwrap();
        }
        time += step;
    };
    for (k, (outer, inner)) in stops.iter().enumerate() {
        for _ in 0..600 {
            add(*outer, *inner, 3.0 * k as f64, &mut text);
        }
        let next = stops.get(k + 1).unwrap_or(&(0.0, 0.0));
        for s in 0..100 {
            let share = f64::from(s) / 100.0;
            let between = |a: f64, b: f64| (a + (b - a) * share + 360.0) % 360.0;
            add(between(*outer, next.0), between(*inner, next.1), 40.0, &mut text);
        }
    }
    // A turn about the vertical and a quarter more, two degrees a second.
    for k in 0..2250 {
        add(0.0, f64::from(k) * 0.2 % 360.0, 60.0, &mut text);
    }
    text
}

#[test]
fn angles_of_a_table_say_what_was_commanded() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("table.csv"), on_a_table()).unwrap();
    let map = fs::read_to_string(map("pulses-on-a-table.toml")).unwrap();
    fs::write(dir.path().join("map.toml"), map).unwrap();
    let output = dwells(dir.path(), &["table.csv", "--map", "map.toml", "--report", "r.html"]);
    // The outputs are made up, so the fit is refused; what was commanded stands in the report.
    let page = fs::read_to_string(dir.path().join("r.html")).unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(page.matches("<td>static</td>").count(), 7, "{said}");
    assert_eq!(page.matches("<td>rate</td>").count(), 1, "{said}");
    assert!(page.contains("<td>-0.99905, 0.00000, 0.00000</td>"), "outer axis at 90: -X up");
    assert!(page.contains("0.000, 0.000, 7208.465"), "two degrees a second and the Earth's {said}");
    assert!(page.contains("<td>100.0") || page.contains("<td>99.9"), "pulses of 0.1 s over 0.1 s");
    assert!(said.contains("samples are lost"), "{said}");
}

/// A whole campaign as a raw log of a hundred rows a second: white noise, flicker, jitter, lost samples.
fn raw(campaign: &Campaign, hz: f64, seed: u64) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut text = String::from("time,pulses_1,pulses_2,pulses_3,ax,ay,az\n");
    let end = campaign.dwells.last().map_or(0.0, |d| d.start_s + d.duration_s);
    let mut k = 0;
    let mut slow = [0.0_f64; 3];
    for row in 0..(end * hz) as usize {
        let time = row as f64 / hz;
        while k + 1 < campaign.dwells.len() && campaign.dwells[k + 1].start_s <= time {
            k += 1;
        }
        let (now, next) = (&campaign.dwells[k], campaign.dwells.get(k + 1).unwrap_or(&campaign.dwells[k]));
        let share = ((time - now.start_s - now.duration_s) / 20.0).clamp(0.0, 1.0);
        let mixed = |a: f64, b: f64| a * (1.0 - share) + b * share;
        for state in &mut slow {
            *state = *state * (1.0 - 1e-3 / hz * 10.0) + 1e-5 * rng.sample::<f64, _>(StandardNormal);
        }
        let mut normal = || rng.sample::<f64, _>(StandardNormal);
        let output: Vec<f64> = (0..3)
            .map(|c| mixed(now.output_pulse_s[c], next.output_pulse_s[c]) + slow[c] + 0.02 * hz.sqrt() * normal())
            .collect();
        let force: Vec<f64> =
            (0..3).map(|c| mixed(now.specific_force_g0[c], next.specific_force_g0[c]) + 2e-4 * normal()).collect();
        let jitter = 0.1 / hz * normal().clamp(-3.0, 3.0);
        if rng.random_range(0.0..1.0) < 1e-3 {
            continue;
        }
        writeln!(
            text,
            "{:.5},{:.5},{:.5},{:.5},{:.5},{:.5},{:.5}",
            time + jitter,
            output[0],
            output[1],
            output[2],
            force[0],
            force[1],
            force[2]
        )
        .unwrap();
    }
    text
}

#[test]
fn a_programme_says_what_was_commanded_and_the_campaign_is_the_one_that_was_measured() {
    let dir = tempfile::tempdir().unwrap();
    let mut truth = simulate(&preset("24-position").unwrap()).unwrap().campaign;
    // A quarter longer: of a turn whose edges are cut no whole one is left.
    let mut later = 0.0;
    for d in &mut truth.dwells {
        d.start_s += later;
        if d.phase == Phase::Rate {
            later += 0.25 * d.duration_s;
            d.duration_s *= 1.25;
        }
    }
    fs::write(dir.path().join("log.csv"), raw(&truth, 5.0, 9)).unwrap();
    let mut programme = String::from("attitude_w,attitude_x,attitude_y,attitude_z,rate_arcsec_s,start_s,duration_s\n");
    let vertical = truth.site.unwrap().earth_rate().0.z;
    for d in &truth.dwells {
        let q = d.attitude.unwrap().to_attitude();
        let turn = match d.phase {
            Phase::Static => 0.0,
            Phase::Rate => d.rate_arcsec_s.dot(&d.specific_force_g0.normalize()) - vertical,
        };
        writeln!(programme, "{},{},{},{},{turn},{},{}", q[0], q[1], q[2], q[3], d.start_s, d.duration_s).unwrap();
    }
    fs::write(dir.path().join("programme.csv"), &programme).unwrap();
    let map = fs::read_to_string(map("pulses-with-a-programme.toml"))
        .unwrap()
        .replace("unit = \"pulse\"", "unit = \"pulse/s\"");
    let site = truth.site.unwrap();
    let (latitude, gravity) = (site.latitude.to_degrees(), site.gravity_g0);
    let map = map.replace("34.25", &latitude.to_string()).replace("0.99905", &gravity.to_string());
    fs::write(dir.path().join("map.toml"), &map).unwrap();
    let output = dwells(dir.path(), &["log.csv", "--map", "map.toml", "--programme", "programme.csv"]);
    let made = campaign(&output);
    let dwells_made = made["dwells"].as_array().unwrap();
    // Less than a turn, at an unknown heading, is left out.
    let turned = |d: &Dwell| d.rate_arcsec_s.norm() * d.duration_s / 3600.0;
    let start = |made: &Value| made["start_s"].as_f64().unwrap();
    let of = |made: &Value| truth.dwells.iter().find(|d| (start(made) - d.start_s).abs() < 10.0).unwrap();
    let kept: Vec<&Dwell> = dwells_made.iter().map(of).collect();
    let of_phase = |phase: Phase, of: &[&Dwell]| of.iter().filter(|d| d.phase == phase).count();
    let all: Vec<&Dwell> = truth.dwells.iter().collect();
    assert_eq!(of_phase(Phase::Static, &kept), of_phase(Phase::Static, &all));
    assert!(kept.iter().all(|d| d.phase == Phase::Static || turned(d) > 350.0) && of_phase(Phase::Rate, &kept) > 3);
    assert!(String::from_utf8_lossy(&output.stderr).contains("shorter than one turn"));
    let mut squares = Vec::new();
    for (made, true_one) in dwells_made.iter().zip(kept) {
        assert!((made["start_s"].as_f64().unwrap() - true_one.start_s).abs() < 10.0);
        for c in 0..3 {
            let value = |name: &str| made[name][c].as_f64().unwrap();
            squares
                .push(((value("output_pulse_s") - true_one.output_pulse_s[c]) / value("output_sem_pulse_s")).powi(2));
            assert!((value("specific_force_g0") - true_one.specific_force_g0[c]).abs() < 1e-9);
            assert!((value("rate_arcsec_s") - true_one.rate_arcsec_s[c]).abs() < 0.02, "{made} {true_one:?}");
        }
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    // How much flicker there is, one log of white noise says poorly: its errors may be stated too large.
    assert!((0.6..1.25).contains(&rms), "{rms}");

    // Without the station's clock the accelerometers say which is which.
    let untimed: String = programme
        .lines()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            cells[..5].join(",") + "\n"
        })
        .collect();
    fs::write(dir.path().join("untimed.csv"), untimed).unwrap();
    let with_force = map + "force = { columns = [\"ax\", \"ay\", \"az\"], unit = \"g0\" }\n";
    fs::write(dir.path().join("force.toml"), &with_force).unwrap();
    let made = campaign(&dwells(dir.path(), &["log.csv", "--map", "force.toml", "--programme", "untimed.csv"]));
    let whole = truth.dwells.iter().filter(|d| d.phase == Phase::Static || turned(d) > 350.0);
    assert_eq!(made["dwells"].as_array().unwrap().len(), whole.count());
    // Two axes exchanged.
    fs::write(dir.path().join("swapped.toml"), with_force.replace("\"ax\", \"ay\"", "\"ay\", \"ax\"")).unwrap();
    let said = refused(&dwells(dir.path(), &["log.csv", "--map", "swapped.toml", "--programme", "untimed.csv"]));
    assert!(said.contains("axes exchanged") || said.contains("contradict the programme"), "{said}");
}

/// What a log holds, the map's change, and what is said.
#[test]
fn what_is_wrong_with_a_log_is_said() {
    let dir = tempfile::tempdir().unwrap();
    let rows = by_hand(4);
    let head = "t,ax,ay,az,gx,gy,gz\n";
    let row = |t: f64, f: [f64; 3], w: [f64; 3]| {
        format!("{t:.2},{:.5},{:.5},{:.5},{:.4},{:.4},{:.4}\n", f[0], f[1], f[2], w[0], w[1], w[2])
    };
    let text = |change: &dyn Fn(usize, &mut (f64, [f64; 3], [f64; 3]))| {
        let mut rows = rows.clone();
        rows.iter_mut().enumerate().for_each(|(k, r)| change(k, r));
        head.to_owned() + &rows.iter().map(|&(t, f, w)| row(t, f, w)).collect::<String>()
    };
    let map = "imu = \"A\"\nstation = \"S\"\nmeasured_at = \"2026-03-01T08:00:00Z\"\ngeometry = \"orthogonal\"\n\
        gyros = [\"G1 X\", \"G2 Y\", \"G3 Z\"]\ntime = { column = \"t\", unit = \"s\" }\n\
        force = { columns = [\"ax\", \"ay\", \"az\"], unit = \"g\" }\n\
        output = { columns = [\"gx\", \"gy\", \"gz\"], unit = \"deg/s\" }\n";
    let clean = text(&|_, _| {});
    let one_position = head.to_owned() + &rows[..480].iter().map(|&(t, f, w)| row(t, f, w)).collect::<String>();
    let moving = {
        let only = rows.iter().enumerate().filter(|(k, _)| k % 800 > 510 && k % 800 < 790);
        let again = only.enumerate().map(|(n, (_, &(_, f, w)))| row(n as f64 * 0.01, f, w));
        head.to_owned() + &again.collect::<String>()
    };
    let same = |text: &str| text.to_owned();
    let cases: Vec<(&str, String, String, &str)> = vec![
        (
            "time jumps back",
            text(&|k, r| {
                if k > 2000 {
                    r.0 -= 10.0
                }
            }),
            same(map),
            "time jumps back by 9.990 s",
        ),
        ("one position", one_position, same(map), "one interval of"),
        ("no still interval", moving, same(map), "is still or steady in"),
        (
            "a column that is not there",
            clean.clone(),
            map.replace("\"gx\"", "\"gyr_x\""),
            "no column is named \"gyr_x\"; there are: t, ax",
        ),
        (
            "a number that is not there",
            clean.clone(),
            map.replace("\"gz\"", "9"),
            "there is no column 9; the log has 7",
        ),
        ("another unit", clean.clone(), map.replace("unit = \"g\"", "unit = \"m/s^2\""), "is 0.1020 g0 long"),
        (
            "raw counts",
            clean.clone(),
            map.replace("unit = \"deg/s\"", "unit = \"counts\""),
            "Raw counts need `scale` and `offset`",
        ),
        ("no unit", clean.clone(), map.replace(", unit = \"deg/s\"", ""), "the unit is missing"),
        (
            "pulses by hand",
            clean.clone(),
            map.replace("unit = \"deg/s\"", "unit = \"pulse/s\""),
            "the heading of each position is not known",
        ),
        ("a gyro's column as force", clean.clone(), map.replace("\"az\"]", "\"gz\"]"), "g0 long while nothing moves"),
        ("an unknown key", clean.clone(), map.replace("time =", "tme ="), "unknown field `tme`"),
        ("half the rows broken", clean.replace(".5", ".x"), same(map), "rows cannot be read"),
        ("unanswered", clean.clone(), map.replace("imu = \"A\"", "imu = \"?\""), "line 1: \"?\" must be answered"),
        (
            "frozen",
            text(&|k, r| {
                if (1000..1200).contains(&k) {
                    (r.1, r.2) = (rows[1000].1, rows[1000].2);
                }
            }),
            same(map),
            "for up to 199 samples in a row, which is left out (10.0–12.0 s)",
        ),
        (
            "one gyro frozen",
            text(&|k, r| r.2[1] = if (900..1100).contains(&k) { 0.3 } else { r.2[1] }),
            same(map),
            "199",
        ),
        ("a dead gyro", text(&|_, r| r.2[1] = 0.0), same(map), "output 2 reads 0 all the while"),
        ("a clipped gyro", text(&|_, r| r.2[1] = r.2[1].max(-0.2)), same(map), "intervals are clipped"),
        ("clipped", text(&|_, r| r.1 = r.1.map(|f| f.clamp(-0.95, 0.95))), same(map), "intervals are clipped"),
    ];
    for (name, log, map, expected) in cases {
        fs::write(dir.path().join("log.csv"), log).unwrap();
        fs::write(dir.path().join("map.toml"), map).unwrap();
        let output = dwells(dir.path(), &["log.csv", "--map", "map.toml"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(expected), "{name}: {said}");
    }
    // Lost, repeated and unfinished rows are left out, and said.
    let mut broken = clean.replace("3.00,", "2.99,");
    broken.truncate(broken.len() - 20);
    fs::write(dir.path().join("log.csv"), broken).unwrap();
    fs::write(dir.path().join("map.toml"), map).unwrap();
    let output = dwells(dir.path(), &["log.csv", "--map", "map.toml"]);
    check_by_hand(&campaign(&output));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("5 samples repeat the time before") && said.contains("1 lines that are no rows"), "{said}");
}

#[test]
fn foreign_files_are_named_as_what_they_are() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("map.toml"), fs::read(map("hi91-csv.toml")).unwrap()).unwrap();
    for (bytes, expected) in [
        (b"ULog\x01\x12\x35\x01more".to_vec(), "is a ULog of PX4"),
        (b"MATLAB 7.3 MAT-file, Platform".to_vec(), "save('FILE7.mat', '-v7')"),
        (b"#ROSBAG V2.0\n".to_vec(), "is a ROS bag"),
        (b"ARROW1\0\0more".to_vec(), "is an Arrow (Feather) file"),
        (vec![0; 4096], "nothing but zeros"),
        (vec![3, 1, 4, 1, 5, 9, 2, 6, 5, 3, 5, 8, 200, 7, 1, 2], "is binary"),
        (Vec::new(), "is empty"),
        (b"dear colleagues,\nthe log follows\n".to_vec(), "text without a table of numbers"),
    ] {
        fs::write(dir.path().join("log.bin"), bytes).unwrap();
        let said = refused(&dwells(dir.path(), &["log.bin", "--map", "map.toml"]));
        assert!(said.contains(expected) && said.contains("log.bin"), "{said}");
    }
}

#[test]
fn a_guessed_map_says_why_and_leaves_open_what_the_log_does_not_say() {
    let dir = tempfile::tempdir().unwrap();
    let mut text = String::from("timestamp,acc_x,acc_y,acc_z,gyro_x,gyro_y,gyro_z,temp\n");
    for (t, f, w) in by_hand(6) {
        let f = f.map(|f| f * G);
        writeln!(text, "{},{},{},{},{},{},{},25", (t * 1e6).round(), f[0], f[1], f[2], w[0], w[1], w[2]).unwrap();
    }
    fs::write(dir.path().join("log.csv"), text).unwrap();
    let output = dwells(dir.path(), &["log.csv", "--guess", "-o", "map.toml"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let map = fs::read_to_string(dir.path().join("map.toml")).unwrap();
    assert!(map.contains("time = { column = \"timestamp\", unit = \"us\" }"), "{map}");
    assert!(map.contains("which is gravity in m/s^2"), "{map}");
    assert!(map.contains("output = { columns = [\"gyro_x\", \"gyro_y\", \"gyro_z\"], unit = \"?\" }"), "{map}");
    assert!(refused(&dwells(dir.path(), &["log.csv", "--map", "map.toml"])).contains("must be answered"));
    let answered = map
        .replace("unit = \"?\"", "unit = \"deg/s\"")
        .replace("measured_at = \"?\"", "measured_at = \"2026-03-01T08:00:00Z\"")
        .replace("latitude_deg = \"?\", gravity_g0 = \"?\"", "latitude_deg = 34.0, gravity_g0 = 1.0")
        .replace("\"?\"\n", "\"A\"\n");
    fs::write(dir.path().join("map.toml"), answered).unwrap();
    check_by_hand(&campaign(&dwells(dir.path(), &["log.csv", "--map", "map.toml"])));
}

/// The example log: turns at 10 deg/s of quiet gyros, in which the Earth's rate goes round.
#[test]
fn the_example_log_becomes_a_campaign_that_has_no_gap() {
    let logs = root().join("examples/logs");
    let output = dwells(&logs, &["table.csv", "--map", "map.toml", "--programme", "programme.csv"]);
    let made = campaign(&output);
    let phases = |name: &str| made["dwells"].as_array().unwrap().iter().filter(|d| d["phase"] == name).count();
    assert_eq!((phases("static"), phases("rate")), (24, 12));
    assert!(!String::from_utf8_lossy(&output.stderr).contains("no dwell"));
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("c.json"), &output.stdout).unwrap();
    let mut diagnose = Command::cargo_bin("gyrowatch").unwrap();
    let said = diagnose.current_dir(dir.path()).args(["diagnose", "c.json"]).output().unwrap();
    assert!(String::from_utf8_lossy(&said.stdout).contains("no gap"), "{}", String::from_utf8_lossy(&said.stdout));
    let guessed = dwells(&logs, &["table.csv", "--guess"]);
    let guessed = String::from_utf8_lossy(&guessed.stdout).into_owned();
    assert!(
        guessed.contains("output = { columns = [\"gyro_1\", \"gyro_2\", \"gyro_3\"], unit = \"pulse\" }"),
        "{guessed}"
    );
    assert!(guessed.contains("rate = { columns = [\"table\"], unit = \"deg/s\" }"), "{guessed}");
    // The program beside it makes the same files.
    fs::copy(logs.join("make.py"), dir.path().join("make.py")).unwrap();
    if Command::new("python3").current_dir(dir.path()).arg("make.py").output().is_ok() {
        for name in ["table.csv", "programme.csv"] {
            assert!(fs::read(dir.path().join(name)).unwrap() == fs::read(logs.join(name)).unwrap(), "{name}");
        }
    }
}

/// The example log, changed as stations' logs are: what the rows then are, or what is said.
#[test]
fn what_was_commanded_agrees_with_the_outputs_or_is_refused() {
    let logs = root().join("examples/logs");
    let text = fs::read_to_string(logs.join("table.csv")).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    // Time, three counts, the table's rate.
    let number = |row: &str| row.split(';').map(|cell| cell.parse().unwrap()).collect();
    let rows: Vec<Vec<f64>> = rows.lines().map(number).collect();
    let dir = tempfile::tempdir().unwrap();
    for name in ["map.toml", "programme.csv"] {
        fs::copy(logs.join(name), dir.path().join(name)).unwrap();
    }
    let made = |head: &str, rows: &[Vec<f64>], digits: usize| {
        let line = |row: &Vec<f64>| row.iter().map(|c| format!("{c:.digits$}")).collect::<Vec<_>>().join(";");
        let lines: Vec<String> = std::iter::once(head.to_owned()).chain(rows.iter().map(line)).collect();
        fs::write(dir.path().join("log.csv"), lines.join("\n") + "\n").unwrap();
        dwells(dir.path(), &["log.csv", "--map", "map.toml", "--programme", "programme.csv"])
    };
    let forces = |made: &Value, turned: &str| -> Vec<String> {
        let of = made["dwells"].as_array().unwrap().iter().filter(|dwell| dwell["phase"] == turned);
        of.map(|dwell| format!("{} {}", dwell["specific_force_g0"], dwell["attitude"])).collect()
    };
    let whole = forces(&campaign(&made(head, &rows, 3)), "static");
    let without: Vec<String> = whole.iter().enumerate().filter(|(k, _)| *k != 5).map(|(_, f)| f.clone()).collect();
    let place = |row: &Vec<f64>| (row[0] / 90.0) as usize;
    let later =
        |row: &Vec<f64>, by: f64| -> Vec<f64> { std::iter::once(row[0] + by).chain(row[1..].to_vec()).collect() };

    let gap: Vec<Vec<f64>> = rows.iter().filter(|row| !(455.0..545.0).contains(&row[0])).cloned().collect();
    let skipped = rows.iter().filter(|row| place(row) != 5);
    let skipped: Vec<Vec<f64>> = skipped.map(|row| later(row, if place(row) > 5 { -90.0 } else { 0.0 })).collect();
    for (log, name) in [(gap, "the logger was down"), (skipped, "the operator left it out")] {
        let output = made(head, &log, 3);
        assert_eq!(forces(&campaign(&output), "static"), without, "{name}");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains("0 of them turns: rows 6\n"), "{name}: {said}");
    }
    let output = made(head, &rows[..18 * 90], 3);
    assert_eq!(forces(&campaign(&output), "static"), whole[..18], "it breaks off");

    let exchanged: Vec<Vec<f64>> = [0..2, 3..4, 2..3, 4..36]
        .into_iter()
        .flat_map(|part| rows[part.start * 90..part.end * 90].to_vec())
        .enumerate()
        .map(|(k, row)| later(&row, k as f64 - row[0]))
        .collect();
    let said = refused(&made(head, &exchanged, 3));
    assert!(said.contains("contradict the outputs in dwells 3 (") && said.contains(" 4 ("), "{said}");
    let reversed: Vec<Vec<f64>> = rows.iter().map(|row| [&row[..4], &[-row[4]]].concat()).collect();
    let said = refused(&made(head, &reversed, 3));
    assert!(said.contains("contradict"), "{said}");

    let most = rows.iter().map(|row| row[1]).fold(0.0, f64::max);
    let clipped: Vec<Vec<f64>> =
        rows.iter().map(|row| [&[row[0], row[1].min((0.5 * most).floor())], &row[2..]].concat()).collect();
    let said = refused(&made(head, &clipped, 3));
    assert!(said.contains("intervals are clipped") && said.contains("Without them"), "{said}");

    let infinite: Vec<Vec<f64>> = rows
        .iter()
        .map(|row| if row[0] == 500.0 { vec![500.0, f64::INFINITY, 0.0, 0.0, 0.0] } else { row.clone() })
        .collect();
    let output = made(head, &infinite, 3);
    assert_eq!(forces(&campaign(&output), "static"), whole);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("1 lines that are no rows") && said.contains("line 502, column 2 (gyro_1)"), "{said}");

    let total = head.replace("[pulse]", "[pulse_total]");
    let mut sums = [0.0_f64; 3];
    let mut counted = |row: &Vec<f64>| {
        (0..3).for_each(|k| sums[k] += row[k + 1]);
        vec![row[0], sums[0].floor(), sums[1].floor(), sums[2].floor(), row[4]]
    };
    let totals: Vec<Vec<f64>> = rows.iter().map(&mut counted).collect();
    campaign(&made(&total, &totals, 0));
    let of_bits = |row: &Vec<f64>| -> Vec<f64> {
        (0..5).map(|k| if (1..4).contains(&k) { row[k].rem_euclid(65_536.0) } else { row[k] }).collect()
    };
    let said = refused(&made(&total, &totals.iter().map(of_bits).collect::<Vec<_>>(), 0));
    assert!(said.contains("a counter of 16 bits"), "{said}");

    let two: Vec<Vec<f64>> = rows
        .iter()
        .flat_map(|row| {
            let other = vec![row[0] + 0.5, row[1] + 30.0, row[2] - 20.0, row[3] + 10.0, row[4], 2.0];
            [[&row[..], &[1.0]].concat(), other]
        })
        .collect();
    let said = refused(&made(&format!("{head};imu"), &two, 3));
    assert!(said.contains("column imu holds 1.000, 2.000"), "{said}");
    let alike: Vec<Vec<f64>> = two.iter().map(|row| row[..5].to_vec()).collect();
    let said = refused(&made(head, &alike, 3));
    assert!(said.contains("alternate between two levels"), "{said}");

    // Dwells of 60 s and of 40 s.
    for seconds in [60, 40] {
        let short = rows.iter().filter(|row| (row[0] as usize) % 90 < 10 + seconds).cloned().enumerate();
        let short: Vec<Vec<f64>> = short.map(|(k, row)| later(&row, k as f64 - row[0])).collect();
        let output = made(head, &short, 3);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!said.contains("clipped"), "{said}");
        match seconds {
            60 => assert_eq!(forces(&campaign(&output), "static"), whole),
            _ => assert!(output.status.success() || said.contains("`min_s`"), "{said}"),
        }
    }
}

/// The example log with its map and its programme, and a directory for logs that are made of it.
struct ExampleLog {
    head: String,
    rows: Vec<String>,
    map: String,
    programme: String,
    dir: tempfile::TempDir,
}

impl ExampleLog {
    fn read() -> Self {
        let text = |name: &str| fs::read_to_string(root().join("examples/logs").join(name)).unwrap();
        let table = text("table.csv");
        let (head, rows) = table.split_once('\n').unwrap();
        let (head, rows) = (head.to_owned(), rows.lines().map(str::to_owned).collect());
        let (map, programme, dir) = (text("map.toml"), text("programme.csv"), tempfile::tempdir().unwrap());
        let example = Self { head, rows, map, programme, dir };
        example.write("map.toml", &example.map);
        example.write("programme.csv", &example.programme);
        example
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.dir.path().join(name), text).unwrap();
    }

    /// Its rows that have a stamp, with that in place of their own, which counts seconds from 0.
    fn write_stamped(&self, name: &str, unit: &str, stamp: impl Fn(usize) -> Option<String>) {
        let row = |(k, row): (usize, &String)| Some(format!("{};{}\n", stamp(k)?, row.split_once(';').unwrap().1));
        let rows: String = self.rows.iter().enumerate().filter_map(row).collect();
        self.write(name, &format!("{}\n{rows}", self.head.replace("[s]", &format!("[{unit}]"))));
    }

    fn dwells(&self, logs: &[&str], map: &str) -> Output {
        dwells(self.dir.path(), &[logs, &["--map", map, "--programme", "programme.csv"]].concat())
    }
}

/// The example log in two parts, by clocks of several kinds: what is laid behind one another, and what is refused.
#[test]
fn logs_of_one_campaign_count_once_and_in_order_of_time() {
    let example = ExampleLog::read();
    example.write("undated.toml", &example.map.replace("measured_at", "# measured_at"));
    let write = |name: &str, unit: &str, part: std::ops::Range<usize>, stamp: &dyn Fn(usize) -> String| {
        example.write_stamped(name, unit, |k| part.contains(&k).then(|| stamp(k)));
    };
    let made = |logs: &[&str], map: &str| example.dwells(logs, map);
    // 2026-03-01T08:00:00Z.
    let unix = |k: usize| format!("{}", 1_772_352_000 + k);
    let iso = |k: usize| format!("2026-03-01 {:02}:{:02}:{:02}+08:00", 16 + k / 3600, k / 60 % 60, k % 60);
    let (whole, half) = (example.rows.len(), 21 * 90);
    write("all.csv", "s", 0..whole, &|k| k.to_string());
    write("from0.csv", "s", half..whole, &|k| (k - half).to_string());
    write("first.csv", "s", 0..half, &|k| k.to_string());
    write("over.csv", "s", half - 90..whole, &|k| k.to_string());
    for (kind, unit, stamp) in [("unix", "unix_s", &unix as &dyn Fn(usize) -> String), ("iso", "s", &iso)] {
        write(&format!("{kind}1.csv"), unit, 0..half, stamp);
        write(&format!("{kind}2.csv"), unit, half..whole, stamp);
        write(&format!("{kind}3.csv"), unit, half - 90..whole, stamp);
    }
    let starts = |made: &Value| -> Vec<f64> {
        made["dwells"].as_array().unwrap().iter().map(|dwell| dwell["start_s"].as_f64().unwrap()).collect()
    };
    let expected = starts(&campaign(&made(&["all.csv"], "map.toml")));
    assert_eq!(expected.len(), 36);
    let as_expected = |output: &Output| {
        let made = campaign(output);
        let starts = starts(&made);
        assert_eq!(starts.len(), 36, "{starts:?}");
        assert!(starts.iter().zip(&expected).all(|(own, whole)| (own - whole).abs() < 3.0), "{starts:?}");
        made["measured_at"].as_str().unwrap().to_owned()
    };
    assert_eq!(as_expected(&made(&["first.csv", "from0.csv"], "map.toml")), "2026-03-01T08:00:00Z");
    for kind in ["unix", "iso"] {
        let [first, second, over] = [1, 2, 3].map(|part| format!("{kind}{part}.csv"));
        for order in [[&*first, &*second], [&*second, &*first]] {
            let output = made(&order, "undated.toml");
            assert_eq!(as_expected(&output), "2026-03-01T08:00:00Z");
            let said = String::from_utf8_lossy(&output.stderr);
            let note = format!("in order of time: {first}, {second}");
            assert_eq!(said.contains(&note), order[0] == second, "{said}");
        }
        for order in [[&*first, &*over], [&*over, &*first]] {
            let said = refused(&made(&order, "undated.toml"));
            let begins = format!("{over}: line 2: begins at 2026-03-01T08:30:00Z, 90.0 s before {first} ends");
            assert!(said.contains(&format!("{begins} (2026-03-01T08:31:29Z)")), "{said}");
        }
        let said = refused(&made(&[&first, &first], "undated.toml"));
        assert!(said.contains(&format!("{first}: line 2: begins")), "{said}");
    }
    let said = refused(&made(&["all.csv", "all.csv"], "map.toml"));
    assert!(said.contains("all.csv: holds the same 3240 rows as all.csv"), "{said}");
    let said = refused(&made(&["first.csv", "over.csv"], "map.toml"));
    assert!(said.contains("over.csv: holds 89.0 s of first.csv again, from 1800.0 s to 1889.0 s"), "{said}");
}

/// The first rows of the example log by clocks with dates, and what the map says of the date.
#[test]
fn a_date_that_the_logs_clock_contradicts_is_refused() {
    let example = ExampleLog::read();
    let made = |stamp: &dyn Fn(usize) -> String, unit: &str, date: &str| {
        example.write_stamped("log.csv", unit, |k| Some(stamp(k)));
        example.write("map.toml", &example.map.replace("2026-03-01T08:00:00Z", date));
        example.dwells(&["log.csv"], "map.toml")
    };
    let time = |k: usize| format!("{:02}:{:02}:{:02}", 8 + k / 3600, k / 60 % 60, k % 60);
    let unix = |k: usize| (1_772_352_000 + k).to_string();
    let zoned = |k: usize| format!("2026-03-01T{}Z", time(k));
    let local = |k: usize| format!("2026-03-01 {}", time(k));
    let unset = |k: usize| format!("2000-01-01 {}", time(k));
    let unmarked = |k: usize| format!("20260301T{}", time(k).replace(':', ""));
    let clocks: [(&dyn Fn(usize) -> String, &str, &str); 4] = [
        (&unix, "unix_s", "08:00:00Z"),
        (&zoned, "s", "08:00:00Z"),
        (&local, "s", "08:00:00"),
        (&unmarked, "s", "08:00:00"),
    ];
    for (stamp, unit, clock) in clocks {
        // A day off, or any hour of the date.
        for date in ["2026-03-01T00:00:00+08:00", "2026-03-02T06:00:00Z"] {
            campaign(&made(stamp, unit, date));
        }
        let said = refused(&made(stamp, unit, "2025-12-24T08:00:00Z"));
        let words =
            format!("`measured_at`: is 2025-12-24T08:00:00Z, and the log's clock runs from 2026-03-01T{clock} to");
        assert!(said.contains(&words), "{said}");
    }
    let output = made(&unset, "s", "2026-03-01T08:00:00Z");
    assert_eq!(campaign(&output)["measured_at"], "2026-03-01T08:00:00Z");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("the log's clock says 2000-01-01T08:00:00, as one that was never set"), "{said}");
    // Dates say their unit themselves.
    let log = example.dir.path().join("log.csv");
    let without = fs::read_to_string(&log).unwrap().replacen("time [s]", "time", 1);
    example.write("log.csv", &without.replace("2000-01-01", "2026-03-01"));
    campaign(&example.dwells(&["log.csv"], "map.toml"));
    let minutes = |k: usize| format!("{}:{:02}", k / 60, k % 60);
    let said = refused(&made(&minutes, "s", "2026-03-01T08:00:00Z"));
    assert!(said.contains("\"24:00\" is no time that can be read; write 08:15:00.5"), "{said}");
}

/// The example log without the table's rate, with the clock set within a position, and without a position.
#[test]
fn where_intervals_and_rows_are_not_as_many_is_said() {
    let example = ExampleLog::read();
    let programme = example.programme.clone();
    example.write("map.toml", &example.map.replace("rate =", "# rate ="));
    let made = |stamp: &dyn Fn(usize) -> Option<usize>, programme: &str| {
        example.write_stamped("log.csv", "s", |k| Some(stamp(k)?.to_string()));
        example.write("programme.csv", programme);
        example.dwells(&["log.csv"], "map.toml")
    };
    let jump = |k: usize| Some(if k < 500 { k } else { k + 3600 });
    let said = refused(&made(&jump, &programme));
    assert!(said.contains("37 intervals were found and the programme has 36 rows"), "{said}");
    assert!(said.contains("splits: intervals 6/7 (49") || said.contains("splits: intervals 6/7 (50"), "{said}");
    // Its row once more, as is said.
    let lines: Vec<&str> = programme.lines().collect();
    let twice = [&lines[..7], &lines[6..]].concat().join("\n") + "\n";
    assert_eq!(campaign(&made(&jump, &twice))["dwells"].as_array().unwrap().len(), 37);
    // One turn's rate is another than the table's.
    let slower = programme.replacen(",10\n", ",8\n", 1);
    for (programme, count) in [(&programme, 0), (&slower, 1)] {
        let output = made(&Some, programme);
        assert_eq!(campaign(&output)["dwells"].as_array().unwrap().len(), 36, "{programme}");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(said.matches("in 1 turns the outputs swing with the Earth's rate").count(), count, "{said}");
        assert_eq!(said.matches("/ 8.00 deg/s").count(), count, "{said}");
    }
    // Totals that begin anew within a position or a turn: what is said of them.
    let totals = |reset: usize| {
        let mut total = [0.0; 3];
        let row = |(k, row): (usize, &String)| {
            let cells: Vec<&str> = row.split(';').collect();
            for (total, cell) in total.iter_mut().zip(&cells[1..4]) {
                *total = if k == reset { 0.0 } else { *total + cell.parse::<f64>().unwrap().round() };
            }
            format!("{k};{};{};{};0\n", total[0], total[1], total[2])
        };
        let rows: String = example.rows.iter().enumerate().map(row).collect();
        format!("{}\n{rows}", example.head.replace("[pulse]", "[pulse_total]"))
    };
    for reset in [0, 12 * 90 + 45, 26 * 90 + 45] {
        example.write("log.csv", &totals(reset));
        example.write("programme.csv", &programme);
        let output = example.dwells(&["log.csv"], "map.toml");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(said.contains("counters fell to zero 1 times"), reset > 0, "{said}");
    }
    // A clock that runs half a per cent fast, and one that is right.
    for (fast, count) in [(1.005, 1), (1.0, 0)] {
        example.write_stamped("log.csv", "s", |k| Some(format!("{:.3}", fast * k as f64)));
        example.write("programme.csv", &programme);
        let output = example.dwells(&["log.csv"], "map.toml");
        assert_eq!(campaign(&output)["dwells"].as_array().unwrap().len(), 36);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(
            said.matches("turns the outputs swing with the Earth's rate about -0.5 % off").count(),
            count,
            "{said}"
        );
    }
    let skipped = |k: usize| Some(k).filter(|k| !(455..545).contains(k));
    let said = refused(&made(&skipped, &programme));
    assert!(said.contains("35 intervals were found and the programme has 36 rows"), "{said}");
    assert!(said.contains("between intervals 5/6 (4"), "{said}");
}

/// The example log in units that it is not in, with a cell too many, and one that moves: what is said.
#[test]
fn units_that_cannot_be_shifted_cells_and_motion_are_refused() {
    let logs = root().join("examples/logs");
    let text = fs::read_to_string(logs.join("table.csv")).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    let dir = tempfile::tempdir().unwrap();
    for name in ["map.toml", "programme.csv"] {
        fs::copy(logs.join(name), dir.path().join(name)).unwrap();
    }
    let made = |log: String| {
        fs::write(dir.path().join("log.csv"), log).unwrap();
        dwells(dir.path(), &["log.csv", "--map", "map.toml", "--programme", "programme.csv"])
    };
    for (unit, other, expected) in [
        ("[s]", "[h]", "`time` (or `rate_hz`) is in another unit"),
        ("[s]", "[min]", "`time` looks like s"),
        ("[deg/s]", "[rad/s]", "`rate` of the log looks like deg/s"),
        ("[deg/s]", "[rpm]", "`rate` of the log looks like deg/s"),
        ("[deg/s]", "[mdeg/s]", "`rate` of the log looks like deg/s"),
    ] {
        let said = refused(&made(text.replace(unit, other)));
        assert!(said.contains(expected), "{other}: {said}");
    }
    let rows: Vec<&str> = rows.lines().collect();
    // A rate that is off by a hundredth of a degree a second, until the map says so.
    let off = |row: &&str| {
        let (before, rate) = row.rsplit_once(';').unwrap();
        format!("{before};{:.2}\n", rate.parse::<f64>().unwrap() + 0.01)
    };
    let off = format!("{head}\n{}", rows.iter().map(off).collect::<String>());
    let said = refused(&made(off.clone()));
    assert!(said.contains("`rate` of the log shows 0.0100 deg/s in every still position"), "{said}");
    let map = fs::read_to_string(logs.join("map.toml")).unwrap();
    fs::write(dir.path().join("map.toml"), map.replace("[\"table\"]", "[\"table\"], offset = 0.01")).unwrap();
    assert_eq!(campaign(&made(off))["dwells"].as_array().unwrap().len(), 36);
    fs::write(dir.path().join("map.toml"), map).unwrap();
    // A decimal comma between commas, in the first rows and later.
    for (damaged, way) in [(7, "line 9"), (1700, "line 1702")] {
        let cells = |k: usize, row: &&str| {
            let row = row.replace(';', ",");
            if k == damaged { row.replacen('.', ",", 1) } else { row }
        };
        let lines = rows.iter().enumerate().map(|(k, row)| cells(k, row) + "\n").collect::<String>();
        let output = made(format!("{}\n{lines}", head.replace(';', ",")));
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains("1 lines that are no rows are left out") && said.contains(way), "{said}");
        assert!(said.contains("more than 5 cells"), "{said}");
        assert_eq!(campaign(&output)["dwells"].as_array().unwrap().len(), 36);
    }
    let wave = |k: usize, c: f64| 5000.0 * (k as f64 * 0.19 + c).sin() + 3000.0 * (k as f64 * 0.06 * (c + 1.0)).sin();
    let row = |k: usize| format!("{k};{:.3};{:.3};{:.3};0\n", wave(k, 0.0), wave(k, 1.0), wave(k, 2.0));
    let said = refused(&made(format!("{head}\n{}", (0..2500).map(row).collect::<String>())));
    assert!(said.contains("nothing is still in"), "{said}");
}

/// A campaign as a station's table of averages in pulses, with headings of its own.
fn averages(campaign: &Campaign) -> String {
    let mut text = String::from("Beginn [s];Dauer [s];q0;q1;q2;q3;wx [arcsec/s];wy [arcsec/s];wz [arcsec/s];");
    text.push_str("K1 [Imp/s];K2 [Imp/s];K3 [Imp/s];s(K1);s(K2);s(K3)\n");
    for d in &campaign.dwells {
        let sem = d.output_sem_pulse_s.as_ref().unwrap();
        let mut cells = vec![d.start_s, d.duration_s];
        cells.extend(d.attitude.unwrap().to_attitude());
        cells.extend(d.rate_arcsec_s.iter());
        cells.extend(d.output_pulse_s.iter().chain(sem.iter()));
        let cells: Vec<String> = cells.iter().map(|cell| cell.to_string().replace('.', ",")).collect();
        writeln!(text, "{}", cells.join(";")).unwrap();
    }
    text
}

const OF_AVERAGES: &str = r#"
imu = "IMU-1"
station = "ST-1"
measured_at = "2026-03-01T08:00:00Z"
geometry = "skewed"
gyros = ["G1 A-1", "G2 A-2", "G3 A-3"]
averaged = true
time = { column = "Beginn" }
duration = { column = "Dauer" }
attitude = { columns = ["q0", "q1", "q2", "q3"] }
output = { columns = ["K1", "K2", "K3"], unit = "pulse/s" }
standard_error = { columns = ["s(K1)", "s(K2)", "s(K3)"] }
"#;

#[test]
fn averages_in_pulses_with_their_errors_and_rates_are_the_campaign() {
    let dir = tempfile::tempdir().unwrap();
    let truth = simulate(&preset("24-position").unwrap()).unwrap().campaign;
    fs::write(dir.path().join("t.csv"), averages(&truth)).unwrap();
    let site = truth.site.unwrap();
    let site =
        format!("site = {{ latitude_deg = {}, gravity_g0 = {} }}\n", site.latitude.to_degrees(), site.gravity_g0);
    let map = site + OF_AVERAGES;
    let rate = "rate = { columns = [\"wx\", \"wy\", \"wz\"] }\n";
    fs::write(dir.path().join("m.toml"), map.clone() + rate).unwrap();
    let output = dwells(dir.path(), &["t.csv", "--map", "m.toml"]);
    let made = campaign(&output);
    assert!(String::from_utf8_lossy(&output.stderr).contains("inertial space"), "the smallest rate is the Earth's");
    assert_eq!(made["dwells"].as_array().unwrap().len(), truth.dwells.len());
    for (made, d) in made["dwells"].as_array().unwrap().iter().zip(&truth.dwells) {
        assert_eq!((&made["phase"], &made["duration_s"]), (&d.phase.name().into(), &d.duration_s.into()));
        for c in 0..3 {
            let near = |name: &str, value: f64| (made[name][c].as_f64().unwrap() - value).abs() < 1e-6;
            assert!(near("output_pulse_s", d.output_pulse_s[c]) && near("rate_arcsec_s", d.rate_arcsec_s[c]), "{made}");
            assert!(near("output_sem_pulse_s", d.output_sem_pulse_s.as_ref().unwrap()[c]), "{made}");
            assert!(near("specific_force_g0", d.specific_force_g0[c]), "{made}");
        }
    }
    // Where nothing says how noisy it is, the others do.
    let unknown = map.replace("standard_error = { columns = [\"s(K1)\", \"s(K2)\", \"s(K3)\"] }\n", rate);
    fs::write(dir.path().join("m.toml"), unknown).unwrap();
    campaign(&dwells(dir.path(), &["t.csv", "--map", "m.toml"]));
    let mut exchanged = truth.clone();
    let third = exchanged.dwells[2].output_pulse_s.clone();
    exchanged.dwells[2].output_pulse_s = std::mem::replace(&mut exchanged.dwells[9].output_pulse_s, third);
    fs::write(dir.path().join("x.csv"), averages(&exchanged)).unwrap();
    let said = refused(&dwells(dir.path(), &["x.csv", "--map", "m.toml"]));
    assert!(said.contains("contradict the outputs in dwells 3 (") && said.contains(" 10 ("), "{said}");
    // Without the rates, turns would be taken for rest.
    fs::write(dir.path().join("m.toml"), &map).unwrap();
    let said = refused(&dwells(dir.path(), &["t.csv", "--map", "m.toml"]));
    assert!(said.contains("are those of turns, and nothing says how fast"), "{said}");
    fs::write(dir.path().join("m.toml"), map.clone() + &rate.replace("wy", "wx")).unwrap();
    let said = refused(&dwells(dir.path(), &["t.csv", "--map", "m.toml"]));
    assert!(said.contains("\"wx\" is named twice"), "{said}");
    fs::write(dir.path().join("m.toml"), map.replace("averaged = true\n", "")).unwrap();
    let said = refused(&dwells(dir.path(), &["t.csv", "--map", "m.toml"]));
    assert!(said.contains("`averaged = true` is missing"), "{said}");
}

/// A log of `rows` rows by a header and what each row holds.
fn rows_of(header: &str, rows: usize, row: impl Fn(usize) -> String) -> String {
    let rows: Vec<String> = (0..rows).map(row).collect();
    format!("{header}\n{}\n", rows.join("\n"))
}

#[test]
fn a_first_map_is_right_or_says_why_it_cannot_tell() {
    let pulses = |k: usize| format!("{},{},{}", 780 + k % 5, 100 + k % 3, 5 + k % 4);
    let xsens = |step: u64| {
        let sensors = |k: usize| format!("0.0{},0.01,9.81,0.002,0.00{},0.001,0.4,0.4,0.4", k % 7, k % 5);
        // Both counters begin anew within the log.
        rows_of(
            "// Update Rate: 100.0Hz\nPacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,Mag_X,Mag_Y,Mag_Z",
            900,
            |k| {
                let time = (4_294_967_295 - 50 * step + step * k as u64) % 4_294_967_296;
                format!("{},{time},{}", (65_000 + k) % 65_536, sensors(k))
            },
        )
    };
    let cases = [
        (xsens(100), "time = { column = \"SampleTimeFine\", unit = \"us\", scale = 100 }"),
        (xsens(10_000), "time = { column = \"SampleTimeFine\", unit = \"us\" }"),
        (xsens(100), "force = { columns = [\"Acc_X\", \"Acc_Y\", \"Acc_Z\"], unit = \"m/s^2\" }"),
        (xsens(100), "output = { columns = [\"Gyr_X\", \"Gyr_Y\", \"Gyr_Z\"], unit = \"?\" }"),
        (
            rows_of("PacketCounter,g1,g2,g3", 300, |k| format!("{k},{}", pulses(k))),
            "# column \"PacketCounter\" counts rows and is no time: say how many samples a second\nrate_hz = \"?\"",
        ),
        (
            rows_of("[s],[pulse],[pulse],[pulse],[degC]", 300, |k| format!("{k},{},20.{k}", pulses(k))),
            "time = { column = 1, unit = \"s\" }",
        ),
        (
            rows_of("[s],[pulse],[pulse],[pulse],[degC]", 300, |k| format!("{k},{},20.{k}", pulses(k))),
            "output = { columns = [2, 3, 4], unit = \"pulse\" }",
        ),
        (
            rows_of("temperature,p1,p2,p3", 300, |k| format!("{},{}", 20.0 + 0.001 * k as f64, pulses(k))),
            "# no column rises steadily: say how many samples a second\nrate_hz = \"?\"",
        ),
        (
            rows_of("temperature,p1,p2,p3", 300, |k| format!("{},{}", 20.0 + 0.001 * k as f64, pulses(k))),
            "output = { columns = [\"p1\", \"p2\", \"p3\"], unit = \"?\" }",
        ),
        (
            rows_of("T,p1,p2,p3", 300, |k| format!("{},{}", 20.0 + 0.001 * k as f64, pulses(k))),
            "# column \"T\" rises, but may be a temperature",
        ),
        (
            rows_of("t,T,p1,p2,p3", 300, |k| format!("{},20.5,{}", 0.01 * k as f64, pulses(k))),
            "temperature = { column = \"T\", unit = \"C\" }",
        ),
        (
            rows_of("time,p1,p2,p3", 300, |k| format!("{k},{}", pulses(k))),
            "# rises by 1 from row to row, in a unit that nothing says: s gives 1.0 samples a second, ms 1000.0\n\
             time = { column = \"time\", unit = \"?\" }",
        ),
        (
            rows_of("time_ms,p1,p2,p3", 300, |k| format!("{k},{}", pulses(k))),
            "time = { column = \"time_ms\", unit = \"ms\" }",
        ),
        (
            rows_of("Date,p1,p2,p3", 300, |k| format!("{:.8},{}", 46_350.0 + k as f64 / 86_400.0, pulses(k))),
            "time = { column = \"Date\", unit = \"h\", scale = 24 }",
        ),
        (
            rows_of("time,p1,p2,p3", 300, |k| format!("03/04/2026 08:{:02}:{:02},{}", k / 60, k % 60, pulses(k))),
            "# column \"time\" holds neither numbers nor times with a plain date",
        ),
    ];
    let dir = tempfile::tempdir().unwrap();
    for (log, expected) in cases {
        fs::write(dir.path().join("log.csv"), &log).unwrap();
        let output = dwells(dir.path(), &["log.csv", "--guess"]);
        let map = String::from_utf8_lossy(&output.stdout);
        assert!(map.contains(expected), "{}\n{expected}\n{map}", log.lines().nth(1).unwrap());
    }
}

#[test]
fn names_units_and_dates_that_are_not_plain_are_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    let pulses = |k: usize| format!("{},{},{}", 780 + k % 5, 100 + k % 3, 5 + k % 4);
    let log = |header: &str| rows_of(header, 300, |k| format!("{k},20.5,{}", pulses(k)));
    let map = |time: &str, unit: &str| {
        format!(
            "time = {{ column = \"{time}\", unit = \"s\" }}\n\
             output = {{ columns = [\"p1\", \"p2\", \"p3\"]{unit} }}\ntemperature = {{ column = \"T\", unit = \"C\" }}\n"
        )
    };
    let pulse = ", unit = \"pulse\"";
    let dated = |k: usize| format!("03/04/2026 08:{:02}:{:02},20.5,{}", k / 60, k % 60, pulses(k));
    let cases = [
        // `t` and `T` are two columns; of longer names the case does not matter.
        (log("t,T,p1,p2,p3"), map("t", pulse), "one interval"),
        (log("TIME,T,P1,P2,P3"), map("time", pulse), "one interval"),
        (log("clock,T,p1,p2,p3"), map("t", pulse), "no column is named \"t\"; did you mean \"T\"?"),
        (log("t,T,gyro_1,p2,p3"), map("t", pulse).replace("p1", "gyro1"), "did you mean \"gyro_1\"?"),
        (log("t,T,p1,p2,p3"), map("clock", pulse), "no column is named \"clock\"; there are: t, T, p1, p2, p3"),
        (log("t,T,p1 [furlong],p2,p3"), map("t", ""), "the header says \"furlong\", which is no unit of this"),
        (
            log("t [fortnight],T,p1,p2,p3"),
            map("t", pulse).replace(", unit = \"s\"", ""),
            "the header says \"fortnight\"",
        ),
        (log("t [ms],T,p1,p2,p3"), map("t", pulse), "the map says s, the header of the log says ms"),
        (rows_of("t,T,p1,p2,p3", 300, dated), map("t", pulse), "\"03/04/2026 08:00:00\" is a date whose day and month"),
        // Counts are of what was read.
        (rows_of("t,T,p1,p2,p3", 300, dated), map("t", pulse), "21 of 21 rows cannot be read"),
        (
            rows_of("t,T,p1,p2,p3", 2000, |k| format!("{},20.5,{}", k / 100, pulses(k))),
            map("t", pulse),
            "1980 of 2000 samples repeat the time before",
        ),
        (log("t,T,p1,p2,p3"), "time = 5 =\n".to_owned(), "map.toml: line 1: the map cannot be read"),
    ];
    for (log, map, expected) in cases {
        fs::write(dir.path().join("log.csv"), log).unwrap();
        fs::write(dir.path().join("map.toml"), &map).unwrap();
        let output = dwells(dir.path(), &["log.csv", "--map", "map.toml"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(expected), "{expected}: {said}");
        assert!(said.lines().filter(|line| line.starts_with("gyrowatch:")).count() <= 1, "{said}");
    }
}

#[test]
fn a_programme_may_be_a_workbook_or_of_another_encoding() {
    let logs = root().join("examples/logs");
    let dir = tempfile::tempdir().unwrap();
    let table = fs::read_to_string(logs.join("programme.csv")).unwrap();
    let mut book = rust_xlsxwriter::Workbook::new();
    let sheet = book.add_worksheet();
    for (row, line) in (0_u32..).zip(table.lines()) {
        for (column, cell) in (0_u16..).zip(line.split(',')) {
            match cell.parse::<f64>() {
                Ok(number) if !cell.starts_with('+') => sheet.write_number(row, column, number).unwrap(),
                _ => sheet.write_string(row, column, cell).unwrap(),
            };
        }
    }
    book.save(dir.path().join("programme.xlsx")).unwrap();
    let wide = table.replace("up,north,rate_deg_s", "Up,North,Rate deg s");
    let wide: Vec<u8> = std::iter::once(0xfeff).chain(wide.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    fs::write(dir.path().join("programme.txt"), wide).unwrap();
    let made = |programme: &Path| {
        let programme = programme.to_str().unwrap();
        campaign(&dwells(&logs, &["table.csv", "--map", "map.toml", "--programme", programme]))
    };
    let plain = made(Path::new("programme.csv"));
    // A unit that nobody knows is not passed over.
    let odd = fs::read_to_string(logs.join("table.csv")).unwrap().replace("gyro_1 [pulse]", "gyro_1 [furlong]");
    fs::write(dir.path().join("odd.csv"), odd).unwrap();
    let map =
        fs::read_to_string(logs.join("map.toml")).unwrap().replace("\"gyro_3\"]", "\"gyro_3\"], unit = \"pulse\"");
    fs::write(dir.path().join("map.toml"), map).unwrap();
    let output = dwells(dir.path(), &["odd.csv", "--map", "map.toml", "--programme", "programme.txt"]);
    assert_eq!(campaign(&output)["dwells"], plain["dwells"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("the header says \"furlong\", which is no unit known here"), "{said}");
    assert_eq!(made(&dir.path().join("programme.xlsx")), plain);
    assert_eq!(made(&dir.path().join("programme.txt")), plain);
    fs::write(dir.path().join("broken.xlsx"), b"PK\x03\x04....[Content_Types].xml").unwrap();
    let broken = dir.path().join("broken.xlsx");
    let said = refused(&dwells(&logs, &["table.csv", "--map", "map.toml", "--programme", broken.to_str().unwrap()]));
    assert!(said.contains("broken.xlsx: cannot be read as xlsx"), "{said}");
}
