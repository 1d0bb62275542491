//! Every fault of form of a short document, where reading stops at the first.
//!
//! What stands at a fault is taken out, or something of the right form is put in its place, and the document is read
//! again: the next fault is another one. What is below a place that has been named is mended in silence.

use serde::de::DeserializeOwned;

use super::place::fault_at;
use super::words;
use crate::core::message::Parameter;
use crate::wire::prelude::*;

/// Longer documents are not read again and again: whoever sends nonsense shall not keep a thread busy.
const LONGEST: usize = 64 * 1024;
/// How often one document is read at most.
const READINGS: u32 = 100;

/// `first` and what else is wrong with the form of `bytes`.
pub(super) fn faults<T: DeserializeOwned>(bytes: &[u8], first: Fault) -> Faults {
    let mut faults = Faults::from(first);
    if bytes.len() > LONGEST || faults.0[0].pointer.is_empty() {
        return faults;
    }
    let Ok(document) = serde_json::from_slice(bytes) else { return faults };
    let mut reader = Reader { document, left: READINGS };
    while let Some(fault) = reader.fault::<T>() {
        let named = |known: &Fault| is_at_or_below(&fault.pointer, &known.pointer);
        let place = fault.pointer.clone();
        let within = words::innermost(&fault.message);
        let unknown = is_unknown(within);
        let stand_ins = stand_ins(within);
        if !faults.0.iter().any(named) {
            faults.0.push(fault);
        }
        let mended = unknown && reader.remove(&place) || reader.mend::<T>(&place, &stand_ins);
        if !mended {
            break;
        }
    }
    faults
}

/// The document without its unknown members, where nothing else is wrong with its form.
pub(super) fn without_unknown<T: DeserializeOwned>(bytes: &[u8], faults: &Faults) -> Option<T> {
    if bytes.len() > LONGEST || !faults.0.iter().all(|fault| is_unknown(words::innermost(&fault.message))) {
        return None;
    }
    let mut reader = Reader { document: serde_json::from_slice(bytes).ok()?, left: 0 };
    faults.0.iter().all(|fault| reader.remove(&fault.pointer)).then(|| serde_json::from_value(reader.document).ok())?
}

fn is_unknown(fault: &Message) -> bool {
    matches!(&*fault.code, "unknown_member" | "no_members_here")
}

struct Reader {
    document: Value,
    left: u32,
}

impl Reader {
    /// The first fault; none where the document can be read or has been read often enough.
    fn fault<T: DeserializeOwned>(&mut self) -> Option<Fault> {
        self.left = self.left.checked_sub(1)?;
        let read: Result<T, _> = serde_path_to_error::deserialize(&self.document);
        read.err().map(|error| fault_at(error.path(), error.inner()))
    }

    fn remove(&mut self, pointer: &str) -> bool {
        let Some((parent, member)) = parent(&mut self.document, pointer) else { return false };
        parent.as_object_mut().is_some_and(|object| object.remove(&member).is_some())
    }

    /// Puts the first stand-in at `pointer` with which the reading comes past it.
    fn mend<T: DeserializeOwned>(&mut self, pointer: &str, stand_ins: &[Value]) -> bool {
        stand_ins.iter().any(|stand_in| {
            set(&mut self.document, pointer, stand_in.clone())
                && self.left > 0
                && self.fault::<T>().is_none_or(|next| next.pointer != pointer)
        })
    }
}

/// What may be of the form that is wanted: one of the values that the message names, or the least of each kind.
fn stand_ins(fault: &Message) -> Vec<Value> {
    let named = match fault.parameter("known") {
        Some(Parameter::List(known)) => known.first().map(ToString::to_string),
        _ => None,
    };
    let least =
        [json!(""), json!(0), json!([]), json!([0, 0, 0]), json!({}), json!(false), json!("G1"), json!("skewed")];
    named.map(|value| json!(value)).into_iter().chain(least).collect()
}

fn is_at_or_below(pointer: &str, place: &str) -> bool {
    pointer.strip_prefix(place).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// What holds the member at `pointer`, and the member's name or number.
fn parent<'d>(document: &'d mut Value, pointer: &str) -> Option<(&'d mut Value, String)> {
    let (parent, member) = pointer.rsplit_once('/')?;
    Some((document.pointer_mut(parent)?, member.replace("~1", "/").replace("~0", "~")))
}

fn set(document: &mut Value, pointer: &str, value: Value) -> bool {
    if pointer.is_empty() {
        *document = value;
        return true;
    }
    match parent(document, pointer) {
        Some((Value::Object(object), member)) => {
            object.insert(member, value);
            true
        }
        Some((Value::Array(list), index)) => {
            let item = index.parse::<usize>().ok().and_then(|index| list.get_mut(index));
            item.map(|item| *item = value).is_some()
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::campaign::CampaignBody;
    use crate::wire::json::parse;
    use crate::wire::record::RecordBody;

    fn places<T: DeserializeOwned>(document: &Value) -> Vec<String> {
        let faults = parse::<T>(document.to_string().as_bytes()).err().map(|faults| faults.0).unwrap_or_default();
        faults.into_iter().map(|fault| fault.pointer).collect()
    }

    #[test]
    fn a_record_of_a_wrong_form_is_told_everything_at_once() {
        let document = json!({
            "imu": 7, "calibrated_at": "2026-03-01T08:00:00Z", "geometry": "slanted", "colour": "red",
            "gyros": [
                {"slot": "G4", "serial": "A", "e_pulse_per_arcsec": [1, 2], "g_pulse_per_s_g0": [1, 2, "3"]},
                "none",
                {"serial": "C", "e_pulse_per_arcsec": {"x": 1}},
            ],
        });
        let mut found = places::<RecordBody>(&document);
        found.sort();
        let expected = [
            "/colour",
            "/geometry",
            "/gyros/0/e_pulse_per_arcsec",
            "/gyros/0/g_pulse_per_s_g0/2",
            "/gyros/0/slot",
            "/gyros/1",
            "/gyros/2/e_pulse_per_arcsec",
            "/gyros/2/slot",
            "/imu",
            "/station",
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn an_unknown_member_hides_no_fault_of_content() {
        let document = json!({
            "imu": "I\u{200b}1", "station": "", "calibrated_at": "2026/11/28 10:00", "geometry": "skewed",
            "colour": "red", "gyros": [],
        });
        let read = |document: &Value| {
            let limits = crate::core::record::Plausibility::default();
            let faults = crate::wire::record::parse_new_record(document.to_string().as_bytes(), &limits).unwrap_err();
            faults.0.into_iter().map(|fault| fault.pointer).collect::<Vec<_>>()
        };
        let found = read(&document);
        for place in ["/colour", "/imu", "/station", "/calibrated_at", "/gyros"] {
            assert!(found.iter().any(|pointer| pointer == place), "{place}: {found:?}");
        }
        let mut known = document;
        known.as_object_mut().unwrap().remove("colour");
        assert_eq!(read(&known), found[1..], "the same without it");
    }

    #[test]
    fn a_document_of_another_kind_altogether_has_one_fault() {
        assert_eq!(places::<RecordBody>(&json!([1, 2, 3])), [""]);
        assert_eq!(places::<CampaignBody>(&json!("campaign")), [""]);
    }

    #[test]
    fn a_long_document_is_read_twice_and_no_more() {
        let gyros = vec![json!({"slot": 1}); 20_000];
        assert_eq!(places::<RecordBody>(&json!({"gyros": gyros})).len(), 1);
    }

    #[test]
    fn nonsense_ends() {
        let many: Vec<Value> = (0..5_000).map(|k| json!(k)).collect();
        let found = places::<RecordBody>(&json!({"gyros": many})).len();
        assert!((1..=READINGS as usize).contains(&found), "{found}");
    }
}
