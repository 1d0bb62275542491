//! `gyrowatch verify`: what is stored is what follows from what was sent, and what is not is named.

use crate::command::{all_of, beside, on_database};
use crate::prelude::*;
use sqlx::Row;

/// A stopped service with records, one of which came late, a campaign, bench results and an event.
async fn a_database() -> Server {
    let mut server = Server::start().await;
    let record = document("paper.json");
    for at in ["2026-03-01T08:00:00Z", "2026-03-22T08:00:00Z", "2026-03-08T08:00:00Z"] {
        let mut record = record.clone();
        record["calibrated_at"] = at.into();
        assert_eq!(server.post_json("/v1/records", &record).await.status, 201);
    }
    let event = json!({ "event": "repair", "reason": "new motor", "at": "2026-03-20T00:00:00Z" });
    assert_eq!(server.post_json("/v1/gyros/LFG-0101/events", &event).await.status, 201);
    assert_eq!(server.post("/v1/campaigns", "application/json", data("practice/campaign-00.json")).await.status, 201);
    assert_eq!(server.post("/v1/import", "application/x-ndjson", data("paper-bench.ndjson")).await.status, 200);
    assert!(server.terminate().0.success());
    server
}

async fn run(server: &Server, sql: &'static str) {
    let changed = sqlx::query(sql).execute(&mut behind::open(&server.database()).await).await.unwrap();
    assert!(changed.rows_affected() > 0, "{sql}");
}

#[tokio::test]
async fn what_is_stored_follows_from_what_was_sent() {
    let mut server = a_database().await;
    let (code, said) = on_database(&["verify"], server.dir());
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("4 records, 12 separations") && !said.contains("other limits"), "{said}");
    let other = beside(server.dir()).arg("verify").env("GYROWATCH_JUDGING__BUDGET", "0.02").output().unwrap();
    assert!(other.status.success(), "{other:?}");
    assert!(all_of(other).contains("other limits"));
    server.restart();
    assert_eq!(on_database(&["verify"], server.dir()).0, Some(0), "while it is served too");
}

/// The noise constants come from the histories of all gyros, and are put into words that the configuration takes.
#[tokio::test]
async fn the_fleets_noise_is_fitted_to_what_is_stored() {
    let mut server = Server::start().await;
    let uniform = |k: i64| ((k * 7919 + 104_729) * k % 10_007) as f64 / 10_007.0 - 0.5;
    let mut lines = String::new();
    for gyro in 0..6_i64 {
        for k in 0..40_i64 {
            // About normal with a scatter of 0.0006; every record a week of its own.
            let scatter =
                (0..4).map(|part| uniform(1000 * gyro + 4 * k + part + 1)).sum::<f64>() * 3.0_f64.sqrt() * 6e-4;
            let mut record = document("paper.json");
            record["imu"] = format!("IMU-{gyro}").into();
            record["calibrated_at"] = format!("20{:02}-{:02}-15T08:00:00Z", 20 + k / 12, 1 + k % 12).into();
            record["gyros"] = json!([record["gyros"][0]]);
            record["gyros"][0]["serial"] = format!("N-{gyro}").into();
            let g = &mut record["gyros"][0]["g_pulse_per_s_g0"];
            for axis in 0..3 {
                g[axis] = (g[axis].as_f64().unwrap() + scatter).into();
            }
            lines += &format!("{record}\n");
        }
    }
    assert_eq!(server.post("/v1/import", "application/x-ndjson", lines).await.status, 200);
    assert!(server.terminate().0.success());
    let (code, said) = on_database(&["fleet-noise"], server.dir());
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("weekly means of 12 coefficients"), "{said}");
    let line = said.lines().find(|line| line.starts_with("noise = {")).expect("the line for the configuration");
    let file = server.dir().join("noise.toml");
    std::fs::write(&file, format!("[judging]\n{line}\n")).unwrap();
    let shown = gyrowatch().args(["config", "--config"]).arg(&file).output().unwrap();
    assert!(shown.status.success(), "{}", String::from_utf8_lossy(&shown.stderr));
    let short = a_database().await;
    let (code, said) = on_database(&["fleet-noise"], short.dir());
    assert!(code == Some(0) && said.contains("too short for a fit: the defaults stay"), "{said}");
}

/// Flips one bit of a stored value.
async fn flip(server: &Server, table: &str, column: &str, bit: usize) -> String {
    let mut connection = behind::open(&server.database()).await;
    let found = format!("SELECT rowid, {column} AS value FROM {table} ORDER BY rowid LIMIT 1");
    let row = sqlx::query(sqlx::AssertSqlSafe(found)).fetch_one(&mut connection).await.unwrap();
    let (id, mut value): (i64, Vec<u8>) = (row.get(0), row.get("value"));
    let bit = bit % (value.len() * 8);
    value[bit / 8] ^= 1 << (bit % 8);
    let sql = format!("UPDATE {table} SET {column} = $1 WHERE rowid = $2");
    sqlx::query(sqlx::AssertSqlSafe(sql)).bind(value).bind(id).execute(&mut connection).await.unwrap();
    gyrowatch::core::id::Id(id).to_string()
}

#[tokio::test]
async fn a_flipped_bit_is_found_and_its_record_named() {
    let server = a_database().await;
    let whole = std::fs::read(server.database()).unwrap();
    for bit in [0, 7, 65, 130, 259, 388, 517, 646, 1000] {
        for (table, column) in [("history_log", "rows"), ("record", "verdicts"), ("record", "body_sha256")] {
            let id = flip(&server, table, column, bit).await;
            let (code, said) = on_database(&["verify"], server.dir());
            assert_eq!(code, Some(1), "{table}.{column}, bit {bit}: {said}");
            assert!(said.contains(&id) || said.contains("gyro"), "{table}.{column}, bit {bit}: {said}");
            for beside in ["gyrowatch.db-wal", "gyrowatch.db-shm"] {
                let _may_not_be_there = std::fs::remove_file(server.dir().join(beside));
            }
            std::fs::write(server.database(), &whole).unwrap();
        }
    }
    assert_eq!(on_database(&["verify"], server.dir()).0, Some(0));
}

#[tokio::test]
async fn a_campaign_that_the_model_in_force_does_not_state_is_named() {
    let server = a_database().await;
    let adopt = "INSERT INTO imu_model (id, imu, adopted_at, author, reason, body)
                 SELECT id + 1, imu, received_at, 'M. Adopter', 'fewer terms',
                     '{\"version\": 1, \"terms\": [\"bias\", \"g_linear\", \"scale\"], \"effects\": []}'
                 FROM record WHERE kind = 1";
    run(&server, adopt).await;
    let (code, said) = on_database(&["verify"], server.dir());
    assert!(code == Some(1) && said.contains("not stated by the model in force"), "{said}");
    assert!(
        said.contains("differ from what is computed again") && said.contains("restore the newest backup"),
        "{said}"
    );
}

#[tokio::test]
async fn a_change_that_fits_its_checksums_is_found_by_computing_again() {
    let server = a_database().await;
    let whole = std::fs::read(server.database()).unwrap();
    // Another input under a hash that fits it: the figures no longer follow from it.
    let mut connection = behind::open(&server.database()).await;
    let (id, body): (i64, String) = sqlx::query_as("SELECT id, body FROM record WHERE kind = 0 ORDER BY id LIMIT 1")
        .fetch_one(&mut connection)
        .await
        .unwrap();
    let mut changed: Value = serde_json::from_str(&body).unwrap();
    let g = &mut changed["gyros"][0]["g_pulse_per_s_g0"][1];
    *g = (g.as_f64().unwrap() + 1e-6).into();
    let changed = changed.to_string();
    sqlx::query("UPDATE record SET body = $1, body_sha256 = $2 WHERE id = $3")
        .bind(&changed)
        .bind(gyrowatch::system::sha256(changed.as_bytes()).to_vec())
        .bind(id)
        .execute(&mut connection)
        .await
        .unwrap();
    drop(connection);
    let (code, said) = on_database(&["verify"], server.dir());
    let id = gyrowatch::core::id::Id(id).to_string();
    assert!(code == Some(1) && said.contains(&id) && said.contains("computed again"), "{said}");

    for (sql, named) in [
        ("UPDATE bench_result SET d_i = d_i + 1e-6 WHERE id = (SELECT min(id) FROM bench_result)", "bench result"),
        ("UPDATE record SET imu = (SELECT max(id) FROM imu) WHERE calibrated_at = (SELECT max(calibrated_at) FROM record)", "elsewhere"),
        // With the calendar to match.
        (
            "UPDATE record SET imu = (SELECT max(id) FROM imu) WHERE calibrated_at = (SELECT max(calibrated_at) FROM record);
             DELETE FROM calendar; INSERT INTO calendar SELECT imu, calibrated_at, voided, id FROM record",
            "under the IMU",
        ),
        (
            "UPDATE record SET calibrated_at = calibrated_at + 1 WHERE id = (SELECT min(id) FROM record);
             DELETE FROM calendar; INSERT INTO calendar SELECT imu, calibrated_at, voided, id FROM record",
            "another time",
        ),
        ("UPDATE event SET kind = 'note'", "verdict"),
    ] {
        std::fs::write(server.database(), &whole).unwrap();
        for beside in ["gyrowatch.db-wal", "gyrowatch.db-shm"] {
            let _may_not_be_there = std::fs::remove_file(server.dir().join(beside));
        }
        run(&server, sql).await;
        let (code, said) = on_database(&["verify"], server.dir());
        assert!(code == Some(1) && said.contains(named), "{sql}: {said}");
    }
}
