//! Which kind of document a line of an import holds.

use serde::Deserialize;
use serde::de::IgnoredAny;

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
    calibrated_at: Option<IgnoredAny>,
    method: Option<IgnoredAny>,
    measured_at: Option<IgnoredAny>,
    gyros: Option<IgnoredAny>,
    dwells: Option<IgnoredAny>,
}

impl DocumentKind {
    /// Whether a document says of itself that it is a calibration record.
    pub fn is_record(bytes: &[u8]) -> bool {
        matches!(serde_json::from_slice(bytes), Ok(Marks { calibrated_at: Some(_), dwells: None, .. }))
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
