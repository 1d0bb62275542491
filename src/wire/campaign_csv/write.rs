//! Writing a campaign as CSV.

use std::collections::HashMap;
use std::fmt::Write;

use serde_json::Value;

use crate::core::campaign::Campaign;
use crate::wire::campaign::{CampaignBody, DwellBody};
use crate::wire::numbers::Numbers;

/// The campaign as CSV that [`super::parse_csv`] reads back: head matter by lines, then one row a dwell.
pub fn to_csv(campaign: &Campaign) -> String {
    body_to_csv(&CampaignBody::from(campaign))
}

/// As [`to_csv`], of the document with its own figures.
pub fn body_to_csv(body: &CampaignBody) -> String {
    let mut text = String::new();
    let head = serde_json::to_value(body).expect("strings and finite numbers always serialise");
    let mut line = |key: &str, value: &str| writeln!(text, "# {key}: {value}").expect("a string takes everything");
    for (key, value) in head.as_object().into_iter().flatten().filter(|(key, _)| *key != "dwells") {
        match value {
            Value::String(words) if is_plain(words) => line(key, words),
            Value::Object(site) if key == "site" => {
                site.iter().for_each(|(name, value)| line(&format!("site.{name}"), &value.to_string()));
            }
            Value::Array(gyros) if key == "gyros" => {
                line(key, &in_words(gyros).unwrap_or_else(|| value.to_string()));
            }
            _ => line(key, &value.to_string()),
        }
    }
    // Whichever dwell states most has all the columns; the others leave cells empty.
    let mut names: Vec<String> = Vec::new();
    for dwell in &body.dwells {
        let own = columns(dwell).into_iter().map(|(name, _)| name);
        let new: Vec<String> = own.filter(|name| !names.contains(name)).collect();
        names.extend(new);
    }
    text.push_str(&names.join(","));
    text.push('\n');
    for dwell in &body.dwells {
        let mut own: HashMap<String, String> = columns(dwell).into_iter().collect();
        let cells: Vec<String> = names.iter().map(|name| own.remove(name).unwrap_or_default()).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}

/// Gyros as `G1 LFG-0101, G2 LFG-0102`, where each is its slot and a serial number that such a list can hold.
fn in_words(gyros: &[Value]) -> Option<String> {
    let one = |gyro: &Value| {
        let (slot, serial) = (gyro["slot"].as_str()?, gyro["serial"].as_str()?);
        let is_word = serial.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c));
        (is_word && gyro.as_object()?.len() == 2).then(|| format!("{slot} {serial}"))
    };
    Some(gyros.iter().map(one).collect::<Option<Vec<_>>>()?.join(", "))
}

/// Whether a head value can stand without quotes: one line that is not taken for JSON or padding.
fn is_plain(text: &str) -> bool {
    !text.starts_with(['{', '[', '"']) && !text.ends_with([',', ';']) && !text.contains(['\n', '\r', '\t'])
}

fn columns(dwell: &DwellBody) -> Vec<(String, String)> {
    const XYZ: &[&str] = &["_x", "_y", "_z"];
    let mut columns = vec![
        ("phase".to_owned(), dwell.phase.clone()),
        ("start_s".to_owned(), dwell.start_s.to_string()),
        ("duration_s".to_owned(), dwell.duration_s.to_string()),
    ];
    // A negative zero is a zero.
    let mut list = |name: &str, suffixes: &[&str], numbers: Option<&Numbers>| {
        let values = numbers.into_iter().flat_map(Numbers::values);
        columns.extend(suffixes.iter().zip(values).map(|(s, v)| (format!("{name}{s}"), (v + 0.0).to_string())));
    };
    list("attitude", &["_w", "_x", "_y", "_z"], dwell.attitude.as_ref());
    list("specific_force_g0", XYZ, Some(&dwell.specific_force_g0));
    list("rate_arcsec_s", XYZ, Some(&dwell.rate_arcsec_s));
    list("temperature_c", &[""], dwell.temperature_c.map(|t| Numbers::from([t].as_slice())).as_ref());
    list("output_pulse_s", &["_1", "_2", "_3"], Some(&dwell.output_pulse_s));
    list("output_sem_pulse_s", &["_1", "_2", "_3"], dwell.output_sem_pulse_s.as_ref());
    columns
}
