//! The history as a file for those who analyse elsewhere: it says what the service answers, in both forms.

use crate::command::on_database;
use crate::prelude::*;

const CALIBRATIONS: usize = 5;

/// The paper's IMU calibrated every other day, with standard deviations in the newest record; one record is voided.
async fn a_served_fleet() -> Server {
    let server = Server::start().await;
    let paper = document("paper.json");
    let mut ids = Vec::new();
    for k in 0..CALIBRATIONS {
        let mut record = paper.clone();
        record["calibrated_at"] = json!(format!("2026-03-{:02}T08:00:00.25Z", 1 + 2 * k));
        for gyro in record["gyros"].as_array_mut().unwrap() {
            let g = gyro["g_pulse_per_s_g0"][0].as_f64().unwrap();
            gyro["g_pulse_per_s_g0"][0] = json!(g + 1e-5 * k as f64);
            if k + 1 == CALIBRATIONS {
                gyro["e_sd"] = json!([1e-6, 1e-6, 1e-6]);
                gyro["g_sd"] = json!([1e-6, 1e-6, 1e-6]);
            }
        }
        let answer = server.post_json("/v1/records", &record).await.created();
        ids.push(answer["id"].as_str().unwrap().to_owned());
    }
    let said = json!({ "author": "Chen", "reason": "table was not level" });
    server.post_json(&format!("/v1/records/{}/void", ids[1]), &said).await.has(200);
    server
}

type Line = BTreeMap<String, String>;

fn lines(file: &Path) -> Vec<Line> {
    let mut reader = csv::Reader::from_path(file).unwrap();
    reader.deserialize().collect::<Result<_, _>>().unwrap()
}

fn number(line: &Line, column: &str) -> Option<f64> {
    Some(line[column].as_str()).filter(|text| !text.is_empty()).map(|text| text.parse().unwrap())
}

#[tokio::test]
async fn an_exported_history_says_what_the_trends_answer() {
    let server = a_served_fleet().await;
    let (status, said) = on_database(&["export", "all.csv"], server.dir());
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("12 rows of 3 gyros"), "{said}");
    let exported = lines(&server.dir().join("all.csv"));
    assert!(exported.is_sorted_by_key(|line| (line["serial"].clone(), line["calibrated_at"].clone())));
    let mut compared = 0;
    for serial in ["LFG-0101", "LFG-0102", "LFG-0103"] {
        let rows: Vec<&Line> = exported.iter().filter(|line| line["serial"] == serial).collect();
        for (coefficient, method) in
            [("D_I", "rigid"), ("D_S", "rigid"), ("D_O", "rigid"), ("D_I", "published"), ("D_S", "published")]
        {
            let path = format!("/v1/gyros/{serial}/trend?coefficient={coefficient}&method={method}");
            let trend = server.get(&path).await.json();
            let points = trend["points"].as_array().unwrap();
            assert_eq!(points.len(), rows.len(), "{path}");
            for (row, point) in rows.iter().zip(points) {
                let column = format!("{method}_{coefficient}");
                assert_eq!(number(row, &column), point["value"].as_f64(), "{path}");
                assert_eq!(number(row, &format!("{column}_sd")), point["sd"].as_f64(), "{path}");
                for name in ["calibrated_at", "record", "imu", "station", "slot"] {
                    assert_eq!(Some(row[name].as_str()), point[name].as_str(), "{path}");
                }
                if method == "rigid" {
                    let state = Some(row[&format!("{coefficient}_state")].as_str()).filter(|it| !it.is_empty());
                    assert_eq!(state, point["state"].as_str(), "{path}");
                    let status = row[&format!("{coefficient}_status")].as_str();
                    assert_eq!(Some(status), point["status"].as_str(), "{path}");
                }
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 3 * 5 * (CALIBRATIONS - 1));
    assert!(exported.iter().all(|line| !line["status"].is_empty()));
    let with_sd = exported.iter().filter(|line| number(line, "rigid_D_I_sd").is_some()).count();
    assert_eq!(with_sd, 3, "an unknown standard deviation is an empty cell");
}

#[tokio::test]
async fn an_export_keeps_to_the_gyros_and_times_that_were_asked_for_and_shows_what_was_voided_on_request() {
    let server = a_served_fleet().await;
    let asked =
        ["some.csv", "--serial", "LFG-0102", "--from", "2026-03-03T08:00:00.25Z", "--to", "2026-03-07T12:00:00Z"];
    assert_eq!(on_database(&[&["export"], &asked[..]].concat(), server.dir()).0, Some(0));
    let times = |file: &str| -> Vec<(String, String)> {
        let lines = lines(&server.dir().join(file));
        assert!(lines.iter().all(|line| line["serial"] == "LFG-0102"));
        lines
            .into_iter()
            .map(|mut line| (line.remove("calibrated_at").unwrap(), line.remove("voided").unwrap()))
            .collect()
    };
    let (fifth, seventh) = ("2026-03-05T08:00:00.25Z".to_owned(), "2026-03-07T08:00:00.25Z".to_owned());
    assert_eq!(times("some.csv"), [(fifth, "false".to_owned()), (seventh, "false".to_owned())]);
    let with_voided = [&["export", "voided.csv", "--voided"], &asked[1..]].concat();
    assert_eq!(on_database(&with_voided, server.dir()).0, Some(0));
    let voided = times("voided.csv");
    assert_eq!(voided.len(), 3);
    assert!(voided.contains(&("2026-03-03T08:00:00.25Z".to_owned(), "true".to_owned())), "{voided:?}");
}

#[tokio::test]
async fn an_export_that_fails_says_why_and_leaves_nothing_behind() {
    let server = a_served_fleet().await;
    for (arguments, named) in [
        (&["all.txt"][..], "--format"),
        (&["all.csv", "--serial", "LFG-9999"], "LFG-9999"),
        (&["all.csv", "--from", "yesterday"], "RFC 3339"),
        (&["no/such/directory/all.csv"], "no/such/directory"),
        (&["gyrowatch.db", "--format", "csv"], "gyrowatch.db"),
    ] {
        let (status, said) = on_database(&[&["export"], arguments].concat(), server.dir());
        assert_ne!(status, Some(0), "{arguments:?}");
        assert!(said.contains(named), "{arguments:?}: {said}");
        assert!(!server.dir().join(arguments[0]).with_extension("csv").exists(), "{arguments:?}");
    }
    assert_eq!(server.get("/v1/gyros/LFG-0101").await.status, 200, "the database was not overwritten");
}

#[cfg(not(feature = "parquet"))]
#[tokio::test]
async fn a_program_without_parquet_says_how_to_build_one_with_it() {
    let server = a_served_fleet().await;
    let (status, said) = on_database(&["export", "all.parquet"], server.dir());
    assert_eq!(status, Some(1));
    assert!(said.contains("--features parquet"), "{said}");
    assert!(!server.dir().join("all.parquet").exists());
}

#[cfg(feature = "parquet")]
#[tokio::test]
async fn a_parquet_file_holds_the_same_as_the_csv_in_columns_with_types() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    let server = a_served_fleet().await;
    assert_eq!(on_database(&["export", "all.csv", "--voided"], server.dir()).0, Some(0));
    let (status, said) = on_database(&["export", "all.parquet", "--voided"], server.dir());
    assert_eq!(status, Some(0), "{said}");
    let file = std::fs::File::open(server.dir().join("all.parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let mut lines = lines(&server.dir().join("all.csv")).into_iter();
    for row in reader.get_row_iter(None).unwrap() {
        let (row, line) = (row.unwrap(), lines.next().unwrap());
        assert_eq!(row.len(), line.len());
        for (name, field) in row.get_column_iter() {
            let text = &line[name];
            match field {
                Field::Null => assert_eq!(text, "", "{name}"),
                Field::Str(word) => assert_eq!(text, word, "{name}"),
                Field::Double(value) => assert_eq!(text.parse::<f64>().unwrap(), *value, "{name}"),
                Field::Int(count) => assert_eq!(text, &count.to_string(), "{name}"),
                Field::Bool(flag) => assert_eq!(text, &flag.to_string(), "{name}"),
                Field::TimestampMicros(micros) => {
                    let instant = gyrowatch::core::time::UtcMicros(*micros);
                    assert_eq!(text, &gyrowatch::wire::time::format(instant), "{name}");
                }
                other => panic!("{name}: {other:?}"),
            }
        }
    }
    assert!(lines.next().is_none(), "a row is missing");
    let metadata = reader.metadata().file_metadata().key_value_metadata().unwrap();
    assert!(metadata.iter().any(|pair| pair.key == "unit" && pair.value.as_deref() == Some("deg/(h*g0)")));
}
