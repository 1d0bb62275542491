//! Which kind of document a line of an import holds.

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use super::campaign::is_csv;
use super::json::without_mark;

/// What a document is read as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DocumentKind {
    Record,
    Bench,
    Campaign,
}

/// The members that tell the kinds apart.
#[derive(Deserialize)]
struct Marks {
    method: Option<IgnoredAny>,
    measured_at: Option<IgnoredAny>,
    gyros: Option<IgnoredAny>,
    dwells: Option<IgnoredAny>,
}

impl DocumentKind {
    /// Whether a document shows that it is a calibration record, complete or not: by its time, or by the E of a gyro.
    pub fn is_record(bytes: &[u8]) -> bool {
        if Self::is_campaign(bytes) {
            return false;
        }
        let Ok(document) = serde_json::from_slice::<Value>(without_mark(bytes)) else { return false };
        let gyros = document.get("gyros").and_then(Value::as_array);
        let has_e = gyros.is_some_and(|gyros| gyros.iter().any(|gyro| gyro.get("e_pulse_per_arcsec").is_some()));
        document.get("calibrated_at").is_some() || has_e
    }

    /// Whether a document shows that it is a campaign of raw dwells: in JSON by their list, in CSV by a column that only they have.
    pub fn is_campaign(bytes: &[u8]) -> bool {
        if is_csv(bytes) {
            return memchr::memmem::find(bytes, b"specific_force_g0_x").is_some();
        }
        matches!(serde_json::from_slice(without_mark(bytes)), Ok(Marks { dwells: Some(_), .. }))
    }

    /// A document that is none of them is read as a record, and refused as one.
    pub fn of(bytes: &[u8]) -> Self {
        // Nearly all documents are records; the name alone, wherever it stands, is a hint that is cheap to look for.
        if memchr::memmem::find(bytes, b"\"measured_at\"").is_none() {
            return Self::Record;
        }
        match serde_json::from_slice(bytes) {
            Ok(Marks { dwells: Some(_), .. }) => Self::Campaign,
            Ok(Marks { method: Some(_), measured_at: Some(_), gyros: None, .. }) => Self::Bench,
            Ok(_) | Err(_) => Self::Record,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_and_campaigns_are_known_before_they_are_read() {
        for (text, record, campaign) in [
            (r#"{"imu":"A","calibrated_at":"…","gyros":[]}"#, true, false),
            (r#"{"imu":"A","gyros":[{"slot":"G1"},{"e_pulse_per_arcsec":[1,0,0]}]}"#, true, false),
            ("\u{feff}{\"gyros\":[{\"e_pulse_per_arcsec\":[1,0,0]}]}", true, false),
            (r#"{"imu":"A","gyros":[{"slot":"G1"}],"dwells":[]}"#, false, true),
            (r#"{"gyros":[{"e_pulse_per_arcsec":[1,0,0]}],"dwells":[]}"#, false, true),
            ("# imu: A\nphase,specific_force_g0_x\n", false, true),
            (r#"{"imu":"A","gyros":[{"slot":"G1","serial":"A"}]}"#, false, false),
            ("not json", false, false),
            ("[]", false, false),
        ] {
            let found = (DocumentKind::is_record(text.as_bytes()), DocumentKind::is_campaign(text.as_bytes()));
            assert_eq!(found, (record, campaign), "{text}");
        }
    }

    #[test]
    fn kinds_are_told_apart_by_members_not_by_words() {
        for (text, kind) in [
            (r#"{"method":"torque_feedback","measured_at":"…","serial":"A"}"#, DocumentKind::Bench),
            (r#"{"imu":"A","measured_at":"…","gyros":[],"dwells":[]}"#, DocumentKind::Campaign),
            (r#"{"imu":"A","calibrated_at":"…","gyros":[]}"#, DocumentKind::Record),
            (r#"{"imu":"A","note":"see \"measured_at\" and \"method\"","gyros":[]}"#, DocumentKind::Record),
            ("not json \"measured_at\"", DocumentKind::Record),
        ] {
            assert_eq!(DocumentKind::of(text.as_bytes()), kind, "{text}");
        }
    }
}
