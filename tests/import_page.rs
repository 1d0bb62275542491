//! `/import` with a station's own files: workbooks, foreign encodings, raw logs with and without a map, what is no
//! document at all; and the right document in the place of a wrong one.

use std::fs;

use crate::spoken::unescaped;
use crate::support::{FORM, Server, data, gyrowatch, root};
use base64::prelude::{BASE64_STANDARD, Engine};
use serde_json::{Value, json};

async fn previewed(server: &Server, form: String) -> String {
    let answer = server.call("POST", "/import/preview", &[("content-type", "text/plain")], form).await;
    assert_eq!((answer.status, answer.content_type.as_str()), (200, "text/html; charset=utf-8"));
    answer.text()
}

/// As the page's script sends what is no UTF-8.
fn as_base64(name: &str, bytes: &[u8]) -> String {
    let text = BASE64_STANDARD.encode(bytes);
    format!("file={name}\r\nmap=\r\nprogramme=\r\ntext=data:application/octet-stream;base64,{text}\r\n")
}

/// As a browser sends the form with a file, with or without a script.
async fn uploaded(server: &Server, name: &str, file: &[u8]) -> String {
    let head = format!("Content-Disposition: form-data; name=\"document\"; filename=\"{name}\"\r\n\r\n");
    let fields = ["map", "programme", "text"]
        .map(|field| format!("--edge\r\nContent-Disposition: form-data; name=\"{field}\"\r\n\r\n\r\n"));
    let form = [b"--edge\r\n", head.as_bytes(), file, b"\r\n", fields.concat().as_bytes(), b"--edge--\r\n"].concat();
    let kind = [("content-type", "multipart/form-data; boundary=edge")];
    let answer = server.call("POST", "/import/preview", &kind, form).await;
    assert_eq!(answer.status, 200, "{}", answer.text());
    answer.text()
}

fn with_map(map: &str, programme: &str, log: &str) -> String {
    let lines = |text: &str| text.trim_end().replace('\n', "\r\n");
    format!("file=table.csv\r\nmap={}\r\nprogramme={}\r\ntext={}\r\n", lines(map), lines(programme), lines(log))
}

/// What stands in a textarea of the page, as a browser would send it.
fn field(page: &str, name: &str) -> String {
    let from = page.rfind(&format!("<textarea name=\"{name}\"")).unwrap_or_else(|| panic!("no {name} in {page}"));
    let text = &page[from..][page[from..].find('>').unwrap() + 1..];
    let text = &text[..text.find("</textarea>").unwrap()];
    unescaped(text)
}

#[tokio::test]
async fn a_raw_log_gets_a_first_map_and_with_its_map_becomes_a_campaign_that_is_stored() {
    let server = Server::start().await;
    let logs = root().join("examples/logs");
    let [log, map, programme] =
        ["table.csv", "map.toml", "programme.csv"].map(|name| fs::read_to_string(logs.join(name)).unwrap());
    let guessed = previewed(&server, with_map("", "", &log)).await;
    assert!(guessed.contains("<h1>Import</h1>") && guessed.contains("Preview · <span translate=\"no\">table.csv"));
    assert!(guessed.contains("This is a raw log, not averaged dwells."), "{guessed}");
    let first = guessed.find("<textarea name=\"map\"").unwrap();
    assert!(guessed[first..].contains("# Guessed from table.csv: check every line"), "{guessed}");
    assert!(!guessed.contains("can be stored"), "{guessed}");

    let said = previewed(&server, with_map("imu = \"?\"\noutput = { columns = [1] }", "", &log)).await;
    assert!(said.contains("map: line 1: &quot;?&quot; must be answered"), "{said}");
    let said = previewed(&server, with_map(&map, "up,north\n+X,+X\n", &log)).await;
    assert!(said.contains("programme: ") && said.contains("are parallel"), "{said}");

    let made = previewed(&server, with_map(&map, &programme, &log)).await;
    assert!(made.contains("1 can be stored") && made.contains("What was averaged"), "{made}");
    assert_eq!(made.matches("<td>rate</td>").count(), 12, "the dwells are shown");
    assert!(made.contains("<rect class=\"static\""), "over the signals");
    // The campaign is what is stored, not the log.
    let stored = format!("text={}\r\n", field(&made, "text"));
    let stored = server.call("POST", "/import/store", &[("content-type", "text/plain")], stored).await.text();
    assert!(stored.contains("href=\"/records/"), "{stored}");
    let fleet = server.get("/v1/gyros/LFG-0101").await.json();
    assert_eq!(fleet["calibrations"], 1, "{fleet}");
}

#[tokio::test]
async fn workbooks_and_foreign_files_are_read_or_named_as_what_they_are() {
    let server = Server::start().await;
    let dir = tempfile::tempdir().unwrap();
    let book = dir.path().join("c.xlsx");
    let made = gyrowatch().args(["template", "campaign", "--format", "xlsx", "--out"]).arg(&book).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let shown = previewed(&server, as_base64("c.xlsx", &fs::read(&book).unwrap())).await;
    assert!(shown.contains("1 can be stored") && shown.contains("c.xlsx"), "{shown}");
    let wide: Vec<u8> = "# imu: A\nphase,start_s\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let wide = [b"\xff\xfe".to_vec(), wide].concat();
    for (name, bytes, expected) in [
        ("px4.ulg", b"ULog\x01\x12\x35\x01\x00\x00".to_vec(), "px4.ulg: is a ULog of PX4"),
        ("a.mat", b"MATLAB 7.3 MAT-file, Platform\x00\x01".to_vec(), "-v7"),
        ("b.mat", [b"MATLAB 5.0 MAT-file".to_vec(), vec![0; 200]].concat(), "b.mat: "),
        ("zeros.csv", vec![0; 600], "nothing but zeros"),
        ("tail.csv", b"# imu: A\nphase,start_s\nstatic,0\n\x00\x00\x00\x00".to_vec(), "line 4: only zero bytes"),
        ("wide.csv", wide, "the table has a header and no rows"),
    ] {
        let shown = previewed(&server, as_base64(name, &bytes)).await;
        assert!(shown.contains(expected), "{name}: {shown}");
        assert!(!shown.contains("1 can be stored"), "{name}: {shown}");
    }
}

#[tokio::test]
async fn a_form_that_breaks_off_or_is_too_large_is_refused_in_words() {
    let server = Server::start_with(&[("GYROWATCH_SERVER__MAX_BODY_BYTES", "20000")]).await;
    let kind = [("content-type", "multipart/form-data; boundary=edge")];
    let head = "--edge\r\nContent-Disposition: form-data; name=\"document\"; filename=\"a.csv\"\r\n\r\n";
    let broken = server.call("POST", "/import/preview", &kind, format!("{head}t,g")).await;
    assert!(broken.status == 400 && broken.text().contains("did not arrive whole"), "{}", broken.text());
    let large = format!("{head}{}\r\n--edge--\r\n", "1,2\r\n".repeat(5000));
    let large = server.call("POST", "/import/preview", &kind, large).await;
    assert!(large.status == 413 && large.text().contains("server.max_body_bytes"), "{}", large.text());
}

#[tokio::test]
async fn a_file_is_sent_without_a_script_and_gyros_that_are_not_stored_lead_nowhere() {
    let server = Server::start_with(&[("GYROWATCH_JUDGING__REQUIREMENTS", "true")]).await;
    assert!(server.get("/import").await.text().contains("<input type=\"file\" name=\"document\""));
    let march = fs::read("docs/examples/march.csv").unwrap();
    let shown = uploaded(&server, "march \u{53f0}.csv", &march).await;
    assert!(shown.contains("1 can be stored") && shown.contains("march \u{53f0}.csv"), "{shown}");
    assert!(shown.contains(">LFG-3002<") && !shown.contains("/gyros/LFG-3002"), "{shown}");
    // E of G2 is outside its requirement, which says nothing of its drift.
    assert!(!shown.contains("badge unconfirmed") && shown.matches("badge not_enough_data").count() == 12, "{shown}");
    assert!(shown.contains("requirement</span>"), "{shown}");
    let stored = format!("text={}\r\n", field(&shown, "text"));
    let stored = server.call("POST", "/import/store", &[("content-type", "text/plain")], stored).await.text();
    assert!(stored.contains("href=\"/records/"), "{stored}");
    let again = uploaded(&server, "march.csv", &march).await;
    assert!(again.contains("href=\"/gyros/LFG-3002\""), "{again}");
    let window = json!({"from": "2026-03-01", "to": "2026-03-31", "by": "Li Wei", "reason": "loose fixture"});
    assert_eq!(server.post_json("/v1/stations/ST-2/suspect", &window).await.status, 200);
    let later = String::from_utf8(march).unwrap().replacen("2026-03-02", "2026-03-05", 1);
    let suspect = uploaded(&server, "march.csv", later.as_bytes()).await;
    assert!(suspect.contains("what ST-2 measured at that time is suspect (Li Wei: loose fixture)"), "{suspect}");
    let binary = uploaded(&server, "px4.ulg", b"ULog\x01\x12\x35\x01\x00\x00").await;
    assert!(binary.contains("px4.ulg: is a ULog of PX4"), "{binary}");
}

/// Whether the table is of a campaign or of records, and however it comes.
#[tokio::test]
async fn a_table_that_may_have_been_cut_says_so_before_it_is_stored() {
    let server = Server::start().await;
    let campaign = fs::read_to_string("docs/examples/march.csv").unwrap();
    let results = "serial,measured_at,station,method,d_i_deg_per_h_g0,d_s_deg_per_h_g0\n\
        A-1,2026-03-01T08:00:00Z,ST-1,torque_feedback,1.5,-2.25\nA-2,2026-03-01T09:00:00Z,ST-1,torque_feedback,1.5,-2.2";
    for (table, last) in [(campaign.trim_end(), ""), (results, "its last number is not -2.2")] {
        let sent = |text: &str| format!("text={}\r\n", text.replace('\n', "\r\n"));
        let cut = previewed(&server, sent(table)).await;
        assert!(cut.contains("does not end with a line break") && cut.contains(last), "{cut}");
        assert!(cut.contains("can be stored"), "{cut}");
        let binary = previewed(&server, as_base64("t.csv", table.as_bytes())).await;
        assert!(binary.contains("does not end with a line break"), "{binary}");
        let whole = previewed(&server, sent(&format!("{table}\n"))).await;
        assert!(!whole.contains("does not end with a line break") && whole.contains("can be stored"), "{whole}");
    }
}

#[tokio::test]
async fn empty_files_and_lone_headers_are_told_apart_wherever_they_are_sent() {
    let server = Server::start().await;
    let head = "# imu: A\n# station: S\n# measured_at: 2026-03-01T08:00:00Z\n# geometry: skewed\n# gyros: G1 L-1\n";
    let header = "phase,start_s,duration_s,specific_force_g0_x,specific_force_g0_y,specific_force_g0_z,\
        rate_arcsec_s_x,rate_arcsec_s_y,rate_arcsec_s_z,output_pulse_s_1\n";
    let alone = format!("{head}{header}");
    let sent = async |kind: &str, body: &str| server.post("/v1/campaigns", kind, body.to_owned()).await.text();
    for (kind, body, expected) in [
        ("text/csv", alone.as_str(), "the table has a header and no rows"),
        ("text/csv", "", "no table"),
        ("application/json", "", "is empty"),
        ("application/json", " \n", "is empty"),
        ("text/csv", &format!("{alone}\0\0\0\0"), "line 7: only zero bytes"),
    ] {
        let said = sent(kind, body).await;
        assert!(said.contains(expected), "{kind} {body:?}: {said}");
    }
    for (bytes, expected) in [
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\x01\x02\x03".to_vec(), "is binary, in a format that is not known"),
        (b"PK\x03\x04\xff\xfe....[Content_Types].xml".to_vec(), "is a file of Excel (.xlsx), not text"),
        (b"\x93NUMPY\x01\x00v\x00".to_vec(), "is a file of NumPy (.npy), not text"),
        (b"\x1f\x8b\x08\x00\xff".to_vec(), "is compressed with gzip"),
        (b"# imu: A\n# note: 20 \xb0C\n".to_vec(), "line 2: not UTF-8 text"),
    ] {
        let answer = server.call("POST", "/v1/campaigns", &[("content-type", "text/csv")], bytes).await;
        let said = answer.text();
        assert!(answer.status == 422 && said.contains(expected), "{said}");
    }
    let shown = previewed(&server, format!("text={}\r\n", alone.replace('\n', "\r\n"))).await;
    assert!(shown.contains("the table has a header and no rows"), "{shown}");

    let dir = tempfile::tempdir().unwrap();
    for (name, text, expected) in
        [("empty.csv", "", "empty.csv: is empty"), ("head.csv", &alone, "head.csv: the table has a header and no rows")]
    {
        fs::write(dir.path().join(name), text).unwrap();
        let output = gyrowatch().current_dir(dir.path()).args(["calibrate", name]).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(expected), "{said}");
    }
}

#[tokio::test]
async fn what_is_refused_for_another_that_is_stored_can_be_put_in_its_place() {
    let server = Server::start().await;
    let first = data("practice/campaign-00.json");
    let there = server.post("/v1/campaigns", "application/json", first.clone()).await;
    let id = there.json()["id"].as_str().unwrap().to_owned();
    let mut right: Value = serde_json::from_str(&first).unwrap();
    right["note"] = json!("the right one");
    let shown = previewed(&server, format!("text={right}\r\n")).await;
    assert!(shown.contains("Put this one in its place") && shown.contains(&format!("href=\"/records/{id}\"")));
    let order = |fields: &[(&str, &str)]| {
        let mut form = url::form_urlencoded::Serializer::new(String::new());
        let text = right.to_string();
        form.append_pair("id", &id).append_pair("text", &text).extend_pairs(fields).finish()
    };
    let send = async |body: String| {
        let kind = [("content-type", FORM)];
        server.call("POST", "/import/replace", &kind, body).await
    };
    let unsaid = send(order(&[("by", "Li Wei"), ("reason", ""), ("confirm", "yes")])).await;
    assert!(unsaid.status == 200 && unsaid.text().contains("class=\"fault\" role=\"alert\""), "{}", unsaid.text());
    let done = send(order(&[("by", "Li Wei"), ("reason", "table was not level"), ("confirm", "yes")])).await;
    assert!(done.status == 303 || done.status == 200, "{} {}", done.status, done.text());
    let old = server.get(&format!("/v1/campaigns/{id}")).await.json();
    assert_eq!(old["state"], "revised", "{old}");
}
