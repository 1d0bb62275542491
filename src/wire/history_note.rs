//! Notes of a record beside what is known of its IMU and gyros, as answers show them and as the database keeps them.

use serde_json::Map;

use super::time;
use crate::core::history_note::{HistoryNote, NameKind, NamedRecord, Quantity, Seat, TimeDoubt};
use crate::core::message::{Parameter, figure, list, text};
use crate::core::note::Note;
use crate::wire::prelude::*;

/// The form of what is kept.
const VERSION: u64 = 1;

/// A note by its code, with its parameters.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "code", rename_all = "snake_case")]
enum Coded {
    TimeInDoubt { set_aside: bool, epoch: Option<String>, nearest: Option<String> },
    OthersSetAside { records: Vec<NamedBody> },
    Suspect { station: String, author: String, reason: String },
    SameTimeSetAside { records: Vec<String> },
    AheadOfNow { hours: f64 },
    YearInDoubt { year: i64 },
    NewSerial { slot: Slot, serial: String, had: String, nearest: Option<String> },
    LookAlike { of: NameKind, name: String, known: String },
    SerialsExchanged { fits: Vec<FitBody> },
    OtherUnit { serials: Vec<String>, budgets: f64 },
    IdenticalFigures { serials: Vec<String>, record: String, calibrated_at: String },
    OverlapsInTime { serials: Vec<String>, record: String, calibrated_at: String },
    AnotherGyro { serials: Vec<String>, budgets: f64 },
    UnitFactor { serials: Vec<String>, quantity: Quantity, factor: f64, unit: Option<String> },
    Moved { serial: String, from: SeatBody, to: SeatBody },
    UncertaintyFactor { serials: Vec<String>, factor: f64 },
}

#[derive(Debug, Serialize, Deserialize)]
struct NamedBody {
    record: String,
    calibrated_at: String,
}

#[derive(Debug, Serialize, Deserialize)]
struct FitBody {
    serial: String,
    figures_of: String,
}

#[derive(Debug, Serialize, Deserialize)]
struct SeatBody {
    imu: String,
    slot: Slot,
}

/// The unit in which E or G would be so many times what it is in the right one.
fn likely_unit(quantity: Quantity, factor: f64) -> Option<&'static str> {
    let is = |other: f64| (factor / other - 1.0).abs() < 1e-6;
    let units: &[(f64, &str)] = match quantity {
        Quantity::E => &[(60.0, "pulse/arcmin"), (3600.0, "pulse/deg"), (206_264.806, "pulse/rad")],
        Quantity::G => &[
            (60.0, "pulse/(min g0)"),
            (3600.0, "pulse/(h g0)"),
            (1.0 / 9.806_65, "pulse/(s m/s^2)"),
            (1.0 / 206_264.806, "rad/s per g0 (of 1 pulse an arcsec)"),
            (1.0 / 3600.0, "deg/(s g0) (of 1 pulse an arcsec)"),
        ],
    };
    units.iter().find(|(unit, _)| is(*unit)).map(|(_, unit)| *unit)
}

impl From<HistoryNote> for Coded {
    fn from(note: HistoryNote) -> Self {
        let named = |NamedRecord { record, at }| NamedBody { record, calibrated_at: time::format(at) };
        let seat = |Seat { imu, slot }| SeatBody { imu, slot };
        match note {
            HistoryNote::TimeInDoubt(doubt) => {
                let (epoch, nearest) = match doubt {
                    TimeDoubt::NearEpoch { epoch } => (Some(time::format(epoch)), None),
                    TimeDoubt::FarFromOthers { nearest } => (None, Some(time::format(nearest))),
                };
                Self::TimeInDoubt { set_aside: true, epoch, nearest }
            }
            HistoryNote::OthersSetAside { records } => {
                Self::OthersSetAside { records: records.into_iter().map(named).collect() }
            }
            HistoryNote::Suspect { station, author, reason } => Self::Suspect { station, author, reason },
            HistoryNote::SameTimeSetAside { records } => Self::SameTimeSetAside { records },
            HistoryNote::AheadOfNow { hours } => Self::AheadOfNow { hours },
            HistoryNote::YearInDoubt { year } => Self::YearInDoubt { year },
            HistoryNote::NewSerial { slot, serial, had, nearest } => Self::NewSerial { slot, serial, had, nearest },
            HistoryNote::LookAlike { of, name, known } => Self::LookAlike { of, name, known },
            HistoryNote::SerialsExchanged { fits } => {
                let body = |(serial, figures_of)| FitBody { serial, figures_of };
                Self::SerialsExchanged { fits: fits.into_iter().map(body).collect() }
            }
            HistoryNote::OtherUnit { serials, budgets } => Self::OtherUnit { serials, budgets },
            HistoryNote::IdenticalFigures { serials, record } => {
                let NamedBody { record, calibrated_at } = named(record);
                Self::IdenticalFigures { serials, record, calibrated_at }
            }
            HistoryNote::OverlapsInTime { serials, record } => {
                let NamedBody { record, calibrated_at } = named(record);
                Self::OverlapsInTime { serials, record, calibrated_at }
            }
            HistoryNote::AnotherGyro { serials, budgets } => Self::AnotherGyro { serials, budgets },
            HistoryNote::UnitFactor { serials, quantity, factor, by_scale } => {
                let of_drift = (by_scale && quantity == Quantity::G && factor.abs() < 1.0).then_some("deg/(h g0)");
                let unit = likely_unit(quantity, factor).or(of_drift).map(str::to_owned);
                Self::UnitFactor { serials, quantity, factor, unit }
            }
            HistoryNote::Moved { serial, from, to } => Self::Moved { serial, from: seat(from), to: seat(to) },
            HistoryNote::UncertaintyFactor { serials, factor } => Self::UncertaintyFactor { serials, factor },
        }
    }
}

fn coded(note: &HistoryNote) -> Map<String, Value> {
    match serde_json::to_value(Coded::from(note.clone())) {
        Ok(Value::Object(members)) => members,
        _ => Map::new(),
    }
}

/// What the words name.
pub fn parameters(note: &HistoryNote) -> Map<String, Value> {
    let mut members = coded(note);
    members.remove("code");
    members.retain(|_, value| !value.is_null());
    members
}

/// What a reader is told.
pub fn message(note: &HistoryNote) -> Message {
    Coded::from(note.clone()).message()
}

/// The notes of a record as they are kept; nothing where there are none.
pub fn kept(notes: &[Note]) -> Option<String> {
    let notes: Vec<Value> = notes
        .iter()
        .filter_map(|note| match note {
            Note::History(note) => Some(Value::Object(coded(note))),
            _ => None,
        })
        .collect();
    (!notes.is_empty()).then(|| written(&notes))
}

/// What is kept of a record, with one note more.
pub fn with(kept: Option<&str>, note: &HistoryNote) -> String {
    let mut notes = kept.map(notes_of).unwrap_or_default();
    notes.push(Value::Object(coded(note)));
    written(&notes)
}

/// What is kept of a record less the notes of one code.
pub fn without(kept: &str, code: &str) -> String {
    let mut notes = notes_of(kept);
    notes.retain(|note| note.get("code").and_then(Value::as_str) != Some(code));
    written(&notes)
}

fn written(notes: &[Value]) -> String {
    serde_json::json!({ "version": VERSION, "notes": notes }).to_string()
}

fn notes_of(kept: &str) -> Vec<Value> {
    let document: Value = serde_json::from_str(kept).unwrap_or_default();
    document.get("notes").and_then(Value::as_array).cloned().unwrap_or_default()
}

/// What a reader is told of a kept note; nothing of one that only a later version knows.
pub(super) fn kept_words(note: &Value) -> Option<String> {
    let coded = serde_json::from_value::<Coded>(note.clone()).ok()?;
    Some(asked().words(&coded.message()))
}

/// The day of a time that was written by [`time::format`].
fn day(time: &str) -> &str {
    time.split('T').next().unwrap_or(time)
}

/// A factor with so many digits; below 1 as a fraction.
fn times(factor: f64, digits: usize) -> Parameter {
    let written =
        if factor.abs() > 1.0 { format!("{factor:.digits$}") } else { format!("1/{:.digits$}", factor.recip()) };
    let is_decimal = written.contains('.');
    text(if is_decimal { written.trim_end_matches('0').trim_end_matches('.') } else { &written })
}

impl Coded {
    fn message(self) -> Message {
        match self {
            Self::TimeInDoubt { epoch: Some(epoch), .. } => message!("time_near_epoch", epoch = text(day(&epoch))),
            Self::TimeInDoubt { nearest, .. } => {
                message!("time_far_from_others", nearest = text(nearest.as_deref().map_or("", day)))
            }
            Self::OthersSetAside { records } => {
                let one = |NamedBody { record, calibrated_at }| {
                    message!("record_of_day", record, day = text(day(&calibrated_at)))
                };
                message!("others_set_aside", records = list(records.into_iter().map(one)))
            }
            Self::Suspect { station, author, reason } => message!("suspect", station, author, reason),
            Self::SameTimeSetAside { records } => message!("same_time_set_aside", records = list(records)),
            Self::AheadOfNow { hours } => message!("ahead_of_now", hours = figure(hours, 1)),
            Self::YearInDoubt { year } => message!("year_in_doubt", year = format_args!("{year}")),
            Self::NewSerial { slot, serial, had, nearest } => {
                let slot = slot.name();
                match nearest {
                    None => message!("new_serial", serial, slot, had),
                    Some(nearest) => message!("new_serial_like", serial, slot, had, nearest),
                }
            }
            Self::LookAlike { of, name, known } => message!("look_alike", of = of.name(), name, known),
            Self::SerialsExchanged { fits } => {
                let one = |FitBody { serial, figures_of }| message!("figures_of", serial, other = figures_of);
                message!("serials_exchanged", fits = list(fits.into_iter().map(one)))
            }
            Self::OtherUnit { serials, budgets } => {
                message!("other_unit", serials = list(serials), budgets = figure(budgets, 0))
            }
            Self::IdenticalFigures { serials, record, calibrated_at: at } => {
                message!("identical_figures", serials = list(serials), record, at)
            }
            Self::OverlapsInTime { serials, record, calibrated_at: at } => {
                message!("overlaps_in_time", serials = list(serials), record, at)
            }
            Self::AnotherGyro { serials, budgets } => {
                message!("another_gyro", serials = list(serials), budgets = figure(budgets, 0))
            }
            Self::UnitFactor { serials, quantity, factor, unit } => {
                let (quantity, serials) = (quantity.name(), list(serials));
                if factor == -1.0 {
                    return message!("sign_reversed", quantity, serials);
                }
                let times = times(factor, 6);
                match unit {
                    None => message!("unit_factor", quantity, serials, times),
                    Some(unit) => message!("unit_factor_of", quantity, serials, times, unit),
                }
            }
            Self::Moved { serial, from, to } => {
                let (from_slot, to_slot) = (from.slot.name(), to.slot.name());
                message!("moved", serial, from_imu = from.imu, from_slot, to_imu = to.imu, to_slot)
            }
            Self::UncertaintyFactor { serials, factor } => {
                message!("uncertainty_factor", serials = list(serials), times = times(factor, 0))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::time::UtcMicros;
    use crate::wire::note::{NoteBody, read};

    fn every_kind() -> Vec<Note> {
        let named = |record: &str| NamedRecord { record: record.to_owned(), at: UtcMicros(1_767_254_400_000_000) };
        let seat = |imu: &str, slot| Seat { imu: imu.to_owned(), slot };
        let serials = vec!["A".to_owned(), "B".to_owned()];
        let unit = |quantity, factor| HistoryNote::UnitFactor {
            serials: vec!["A".to_owned()],
            quantity,
            factor,
            by_scale: factor == 0.625,
        };
        let kinds = [
            HistoryNote::TimeInDoubt(TimeDoubt::NearEpoch { epoch: UtcMicros(946_684_800_000_000) }),
            HistoryNote::TimeInDoubt(TimeDoubt::FarFromOthers { nearest: UtcMicros(1_767_254_400_000_000) }),
            HistoryNote::OthersSetAside { records: vec![named("r1"), named("r2")] },
            HistoryNote::Suspect { station: "ST-1".into(), author: "Li Wei".into(), reason: "loose fixture".into() },
            HistoryNote::AheadOfNow { hours: 3.25 },
            HistoryNote::YearInDoubt { year: 2027 },
            HistoryNote::NewSerial { slot: Slot::G2, serial: "B".into(), had: "8".into(), nearest: Some("8".into()) },
            HistoryNote::NewSerial { slot: Slot::G2, serial: "B".into(), had: "8".into(), nearest: None },
            HistoryNote::LookAlike { of: NameKind::Imu, name: "I".into(), known: "1".into() },
            HistoryNote::LookAlike { of: NameKind::Station, name: "I".into(), known: "1".into() },
            HistoryNote::LookAlike { of: NameKind::Serial, name: "I".into(), known: "1".into() },
            HistoryNote::SerialsExchanged { fits: vec![("A".into(), "B".into()), ("B".into(), "A".into())] },
            HistoryNote::OtherUnit { serials: serials.clone(), budgets: 81.4 },
            HistoryNote::IdenticalFigures { serials, record: named("r1") },
            unit(Quantity::E, 3600.0),
            unit(Quantity::G, 1.0 / 9.806_65),
            unit(Quantity::G, 9.806_65),
            unit(Quantity::G, -1.0),
            HistoryNote::Moved { serial: "A".into(), from: seat("I-1", Slot::G1), to: seat("I-2", Slot::G3) },
            unit(Quantity::G, 0.625),
            HistoryNote::UncertaintyFactor { serials: vec!["A".to_owned()], factor: 1000.2 },
            HistoryNote::UncertaintyFactor { serials: vec!["A".to_owned()], factor: 1.0 / 3600.0 },
            HistoryNote::SameTimeSetAside { records: vec!["r1".to_owned(), "r2".to_owned()] },
            HistoryNote::OverlapsInTime { serials: vec!["A".to_owned()], record: named("r1") },
            HistoryNote::AnotherGyro { serials: vec!["A".to_owned()], budgets: 91.0 },
        ];
        kinds.into_iter().map(Note::History).collect()
    }

    #[test]
    fn what_is_kept_says_the_same_as_what_was_answered() {
        let notes = every_kind();
        let answered: Vec<NoteBody> = notes.iter().map(NoteBody::of).collect();
        assert_eq!(read(kept(&notes).as_deref()), answered);
        assert_eq!(kept(&[]), None);
        assert_eq!(read(None), []);
    }

    #[test]
    fn a_note_of_a_later_version_is_shown_by_its_code() {
        let later = r#"{"version":2,"notes":[{"code":"of_tomorrow","weight":2},{"code":"ahead_of_now","hours":1.0}]}"#;
        let [first, second] = &read(Some(later))[..] else { panic!("two notes") };
        assert_eq!(
            (&*first.code, &*first.detail, &first.parameters["weight"]),
            ("of_tomorrow", "of_tomorrow", &2.into())
        );
        assert!(second.detail.contains("1.0 hours ahead"));
    }

    #[test]
    fn words_name_what_they_are_about() {
        let said: Vec<String> = every_kind().iter().map(|note| NoteBody::of(note).detail).collect();
        for (place, words) in [
            (0, "near 2000-01-01"),
            (1, "(nearest: 2026-01-01)"),
            (2, "r1 (2026-01-01), r2"),
            (3, "what ST-1 measured"),
            (5, "long before the newest record of its gyros; in 2027"),
            (6, "B is new in G2, which had 8 before; the nearest known serial is 8"),
            (11, "A has the figures of B, B has the figures of A"),
            (13, "A, B: identical to record r1 of 2026-01-01T08:00:00Z"),
            (14, "E of A is 3600 times what it was before: is it in pulse/deg?"),
            (15, "G of A is 1/9.80665 times what it was before: is it in pulse/(s m/s^2)?"),
            (16, "G of A is 9.80665 times what it was before: is it in another unit?"),
            (17, "G of A is that of before with the opposite sign"),
            (18, "A was in I-1 G1 in its last record and is in I-2 G3 now"),
            (19, "G of A is 1/1.6 times what it was before: is it in deg/(h g0)?"),
            (20, "the stated standard deviations of A are 1000 times those before"),
            (21, "the stated standard deviations of A are 1/3600 times those before"),
            (23, "test r1 of 2026-01-01T08:00:00Z"),
            (24, "D_I and D_S of A are both off their last levels by more than 91 budgets"),
            (22, "only one of them can count: r1, r2"),
        ] {
            assert!(said[place].contains(words), "{}", said[place]);
        }
    }
}
