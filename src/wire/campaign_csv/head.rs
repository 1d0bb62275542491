//! Head matter: `# key: value` lines, gathered into the JSON document that they stand for.

use serde_json::Map;

use crate::core::message::{list, sent};
use crate::wire::prelude::*;
use crate::wire::table::{comment, number};

/// What stands above the table.
pub(super) struct Head {
    /// The campaign without its dwells.
    pub document: Value,
    /// Pointer of each key that was given, and its line.
    lines: Vec<(String, usize)>,
    /// How many dwells follow, and the line that says so.
    pub told: Option<(usize, usize)>,
}

/// What a key's bare (not JSON) value is.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum ValueKind {
    Text,
    Number,
    Numbers,
    Names,
    Gyros,
}

/// Keys as they may be written, the JSON pointer that each stands for, and how its value reads.
pub(super) const KEYS: &[(&str, &str, ValueKind)] = &[
    ("imu", "/imu", ValueKind::Text),
    ("station", "/station", ValueKind::Text),
    ("measured_at", "/measured_at", ValueKind::Text),
    ("geometry", "/geometry", ValueKind::Text),
    ("rates", "/rates", ValueKind::Text),
    ("test", "/test", ValueKind::Text),
    ("operator", "/operator", ValueKind::Text),
    ("note", "/note", ValueKind::Text),
    ("temperature_c", "/temperature_c", ValueKind::Number),
    ("model", "/model", ValueKind::Names),
    ("site", "/site", ValueKind::Text),
    ("latitude_deg", "/site/latitude_deg", ValueKind::Number),
    ("gravity_g0", "/site/gravity_g0", ValueKind::Number),
    ("magnetic_field_nav", "/site/magnetic_field_nav", ValueKind::Numbers),
    ("station_uncertainty", "/station_uncertainty", ValueKind::Text),
    ("levelling_arcsec", "/station_uncertainty/levelling_arcsec", ValueKind::Number),
    ("azimuth_arcsec", "/station_uncertainty/azimuth_arcsec", ValueKind::Number),
    ("fixture_arcsec", "/station_uncertainty/fixture_arcsec", ValueKind::Number),
    ("gyros", "/gyros", ValueKind::Gyros),
];
/// A station that writes while it measures says with it when its table is whole.
const DWELLS: &str = "dwells";
pub(super) const GYRO_KEYS: &[(&str, ValueKind)] =
    &[("slot", ValueKind::Text), ("serial", ValueKind::Text), ("known_e_pulse_per_arcsec", ValueKind::Numbers)];

impl Head {
    /// Reads the lines above the table; the second value is the table's first line (counted from 0).
    pub fn read(text: &str, faults: &mut Faults) -> (Self, usize) {
        let mut head = Self { document: json!({"dwells": []}), lines: Vec::new(), told: None };
        let mut table = 0;
        for (i, line) in text.lines().enumerate() {
            table = i;
            match comment(line) {
                Some(comment) => head.line(i + 1, &comment, faults),
                None if line.trim().is_empty() => {}
                None => return (head, table),
            }
        }
        (head, table + 1)
    }

    /// Line at which what `pointer` points to was given.
    pub fn line_of(&self, pointer: &str) -> Option<usize> {
        let holds = |given: &str| pointer == given || pointer.strip_prefix(given).is_some_and(|r| r.starts_with('/'));
        self.lines.iter().filter(|(given, _)| holds(given)).max_by_key(|(given, _)| given.len()).map(|&(_, line)| line)
    }

    /// Refuses keys below the header, of another campaign most often, that say what the head does not say; whether
    /// there were any. `header`: its line, counted from 0.
    pub fn refuse_below(&self, text: &str, header: usize, faults: &mut Faults) -> bool {
        let before = faults.0.len();
        for (i, line) in text.lines().enumerate().skip(header + 1) {
            let Some(comment) = comment(line) else { continue };
            let Some((key, value)) = key_and_value(&comment) else { continue };
            let Some((pointer, kind)) = meaning(key) else { continue };
            if read_value(value, kind).ok().as_ref() != self.document.pointer(&pointer) {
                let fault = message!("key_below_header", key = key.to_owned());
                faults.push(pointer, message!("at_line", line = i + 1, fault));
            }
        }
        faults.0.len() > before
    }

    /// One comment. Without a colon, or with a blank inside what stands before it, it is a remark and no key.
    fn line(&mut self, number: usize, comment: &str, faults: &mut Faults) {
        let Some((key, value)) = key_and_value(comment) else { return };
        if let (DWELLS, Ok(count)) = (key, value.parse()) {
            self.told = Some((count, number));
            return;
        }
        let Some((pointer, kind)) = meaning(key) else {
            let of_gyros = ["slot_1", "serial_1", "known_e_pulse_per_arcsec_1"];
            let known = list(KEYS.iter().map(|(key, ..)| *key).chain(of_gyros));
            let unknown = message!("unknown_key", key = sent(key), known);
            faults.push(format!("/{key}"), message!("at_line", line = number, fault = unknown));
            return;
        };
        if self.lines.iter().any(|(given, _)| *given == pointer) {
            faults.push(
                &pointer,
                message!("at_line", line = number, fault = message!("key_twice", key = key.to_owned())),
            );
            return;
        }
        match read_value(value, kind) {
            Ok(value) => place(&mut self.document, &pointer, value),
            Err(fault) => {
                faults.push(&pointer, message!("at_line_key", line = number, key = key.to_owned(), fault));
            }
        }
        self.lines.push((pointer, number));
    }
}

/// What stands before the colon of a comment, and what behind it; none of a remark. Behind a known key a full-width
/// colon and an equals sign are colons too.
pub(super) fn key_and_value(comment: &str) -> Option<(&str, &str)> {
    let parted = |marks: &[char]| comment.split_once(marks).map(|(key, value)| (key.trim(), value.trim()));
    let known = parted(&[':', '：', '=', '＝']).filter(|(key, _)| *key == DWELLS || is_key(key));
    let (key, value) = known.or_else(|| parted(&[':']))?;
    (!key.is_empty() && !key.contains(char::is_whitespace)).then_some((key, value))
}

/// Pointer and kind of a key. `site.latitude_deg`, `site_latitude_deg` and `latitude_deg` are the same; a gyro's
/// keys end in `_1 _2 _3`, or stand as `gyros.0.serial`.
fn meaning(key: &str) -> Option<(String, ValueKind)> {
    let plain =
        ["site.", "site_", "station_uncertainty."].into_iter().find_map(|of| key.strip_prefix(of)).unwrap_or(key);
    if let Some((_, pointer, kind)) = KEYS.iter().find(|(name, ..)| *name == plain) {
        return Some(((*pointer).to_owned(), *kind));
    }
    GYRO_KEYS.iter().find_map(|(name, kind)| {
        let numbered = (1..=3).find(|i| key == format!("{name}_{i}"));
        let indexed = (0..3).find(|i| key == format!("gyros.{i}.{name}"));
        let index = numbered.map(|i| i - 1).or(indexed)?;
        Some((format!("/gyros/{index}/{name}"), *kind))
    })
}

pub(super) fn is_key(name: &str) -> bool {
    meaning(name).is_some()
}

fn read_value(text: &str, kind: ValueKind) -> Result<Value, Message> {
    if text.starts_with(['{', '[', '"']) {
        return serde_json::from_str(text)
            .map_err(|error| message!("value_not_json", why = crate::wire::json::said_of(&error)));
    }
    match kind {
        ValueKind::Text => Ok(Value::from(text)),
        ValueKind::Number => number(text).map(Value::from),
        ValueKind::Numbers => text
            .split([' ', ';', '\t', ','])
            .filter(|part| !part.is_empty())
            .map(|part| number(part).map(Value::from))
            .collect(),
        ValueKind::Names => {
            Ok(text.split([',', ' ', ';']).map(str::trim).filter(|name| !name.is_empty()).map(Value::from).collect())
        }
        ValueKind::Gyros => text.split([',', ';']).map(gyro).collect(),
    }
}

/// `G1 LFG-0101`, `G1=LFG-0101` or `G1:LFG-0101`.
fn gyro(text: &str) -> Result<Value, Message> {
    let text = text.trim();
    let (slot, serial) =
        text.split_once([' ', '=', ':']).ok_or_else(|| message!("not_slot_and_serial", text = sent(text)))?;
    Ok(json!({"slot": slot.trim(), "serial": serial.trim_start_matches(['=', ':', ' ']).trim()}))
}

/// Puts a value where its pointer (of object members, and indices below /gyros) says, making what is not yet there.
fn place(document: &mut Value, pointer: &str, value: Value) {
    let mut at = document;
    for token in pointer.split('/').skip(1) {
        at = match token.parse::<usize>() {
            Ok(index) => {
                if !at.is_array() {
                    *at = json!([]);
                }
                let list = at.as_array_mut().expect("made a list above");
                while list.len() <= index {
                    list.push(json!({}));
                }
                &mut list[index]
            }
            Err(_) => {
                if !at.is_object() {
                    *at = Value::Object(Map::new());
                }
                at.as_object_mut().expect("made an object above").entry(token).or_insert(Value::Null)
            }
        };
    }
    *at = value;
}
