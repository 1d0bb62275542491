//! Which kind of document it is that was sent.

use serde::de::IgnoredAny;

use super::campaign::parse_json_as_sent;
use super::campaign_csv::parse_csv;
use super::json::without_mark;
use super::table::open_end;
use crate::core::campaign::Campaign;
use crate::core::kind::Kind;
use crate::core::note::Note;
use crate::wire::prelude::*;

/// What a document is read as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DocumentKind {
    Record,
    Bench,
    Campaign,
}

impl From<Kind> for DocumentKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Record => Self::Record,
            Kind::Campaign => Self::Campaign,
        }
    }
}

/// In longer documents nobody looks for the E of a gyro: no record comes near it, and whoever sends nonsense shall
/// not fill the memory.
const LONGEST_RECORD: usize = 64 * 1024;

/// The members that tell the kinds apart.
#[derive(Deserialize)]
struct KindMembers {
    method: Option<IgnoredAny>,
    imu: Option<IgnoredAny>,
    measured_at: Option<IgnoredAny>,
    calibrated_at: Option<IgnoredAny>,
    gyros: Option<IgnoredAny>,
    dwells: Option<IgnoredAny>,
    d_i_deg_per_h_g0: Option<IgnoredAny>,
    d_s_deg_per_h_g0: Option<IgnoredAny>,
}

impl KindMembers {
    /// None of what is no object, which serde would take for the members in their order.
    fn of(bytes: &[u8]) -> Option<Self> {
        let text = without_mark(bytes);
        let is_object = text.trim_ascii_start().starts_with(b"{");
        is_object.then(|| serde_json::from_slice(text).ok()).flatten()
    }
}

impl DocumentKind {
    /// The kind that a document shows itself to be, complete or not, where that is another than `wanted`.
    pub fn instead_of(wanted: Self, bytes: &[u8]) -> Option<Self> {
        let shown = if Self::is_campaign(bytes) {
            Self::Campaign
        } else if Self::is_bench(bytes) {
            Self::Bench
        } else if Self::is_record(bytes) {
            Self::Record
        } else {
            return None;
        };
        (shown != wanted).then_some(shown)
    }

    /// Whether a document shows that it is a bench result, complete or not: it has a method or a drift, and nothing
    /// that the others have.
    fn is_bench(bytes: &[u8]) -> bool {
        let of_others =
            |m: &KindMembers| m.imu.is_some() || m.calibrated_at.is_some() || m.gyros.is_some() || m.dwells.is_some();
        let marks = KindMembers::of(bytes).filter(|marks| !of_others(marks));
        marks.is_some_and(|m| m.method.is_some() || m.d_i_deg_per_h_g0.is_some() || m.d_s_deg_per_h_g0.is_some())
    }

    /// Whether a document shows that it is a calibration record, complete or not: by its time, or by the E of a gyro.
    pub fn is_record(bytes: &[u8]) -> bool {
        let Some(marks) = KindMembers::of(bytes).filter(|marks| marks.dwells.is_none()) else { return false };
        marks.calibrated_at.is_some() || bytes.len() <= LONGEST_RECORD && has_e(bytes)
    }

    /// Whether a document shows that it is a campaign of raw dwells: in JSON by their list, in CSV by a column that
    /// only they have.
    pub fn is_campaign(bytes: &[u8]) -> bool {
        if is_csv(bytes) {
            return memchr::memmem::find(bytes, b"specific_force_g0_x").is_some();
        }
        KindMembers::of(bytes).is_some_and(|marks| marks.dwells.is_some())
    }

    /// A document that is none of them is read as a record, and refused as one.
    pub fn of(bytes: &[u8]) -> Self {
        // Nearly all documents are records; the name alone, wherever it stands, is a hint that is cheap to look for.
        if memchr::memmem::find(bytes, b"\"measured_at\"").is_none() {
            return Self::Record;
        }
        match KindMembers::of(bytes) {
            Some(KindMembers { dwells: Some(_), .. }) => Self::Campaign,
            Some(KindMembers { method: Some(_), measured_at: Some(_), gyros: None, .. }) => Self::Bench,
            Some(_) | None => Self::Record,
        }
    }
}

/// Whether one of its gyros has an E.
fn has_e(bytes: &[u8]) -> bool {
    let Ok(document) = serde_json::from_slice::<Value>(without_mark(bytes)) else { return false };
    let gyros = document.get("gyros").and_then(Value::as_array);
    gyros.is_some_and(|gyros| gyros.iter().any(|gyro| gyro.get("e_pulse_per_arcsec").is_some()))
}

/// Reads and checks a campaign that comes in, in JSON or CSV, told apart by the first character: JSON begins with a
/// brace.
pub fn parse(bytes: &[u8]) -> Result<Campaign, Faults> {
    if is_csv(bytes) { parse_csv(bytes) } else { parse_json_as_sent(bytes) }
}

pub fn is_csv(bytes: &[u8]) -> bool {
    let text = without_mark(bytes);
    !matches!(text.iter().find(|b| !b.is_ascii_whitespace()), Some(b'{' | b'[') | None)
}

/// As [`open_end`], of a document that may be no table.
pub fn open_table(bytes: &[u8]) -> Option<Note> {
    open_end(bytes).filter(|_| is_csv(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_tables_are_noted_where_the_last_line_has_no_end() {
        let open = |line, value: &str| Some(Note::NoLineEnd { line, value: value.to_owned() });
        assert_eq!(open_table(b"# imu: A\nstart_s,temperature_c\n0,45.1"), open(3, "45.1"));
        assert_eq!(open_table(b"start_s;temperature_c\r\n0;45.1\r\n"), None);
        assert_eq!(open_table(b"{\"dwells\":\n[1,2]}"), None);
    }

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
    fn what_is_of_another_kind_than_wanted_is_known_complete_or_not() {
        use DocumentKind::{Bench, Campaign, Record};
        for (text, shown) in [
            (r#"{"serial":"A","method":"torque_feedback"}"#, Some(Bench)),
            (r#"{"d_s_deg_per_h_g0":1.5}"#, Some(Bench)),
            (r#"{"d_s_deg_per_h_g0":1.5,"calibrated_at":"…"}"#, Some(Record)),
            (r#"{"imu":"A","gyrs":[],"method":"x"}"#, None),
            (r#"{"imu":"A","calibrated_at":"…","method":"x","gyros":[]}"#, Some(Record)),
            (r#"{"method":"x","dwells":[]}"#, Some(Campaign)),
            (r#"{"serial":"A"}"#, None),
            ("[1,2,3,4,5,6]", None),
            ("{\"method\":1}\n{\"method\":1}", None),
        ] {
            for wanted in [Bench, Campaign, Record] {
                let other = shown.filter(|kind| *kind != wanted);
                assert_eq!(DocumentKind::instead_of(wanted, text.as_bytes()), other, "{text}");
            }
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
