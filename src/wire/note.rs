//! Notes as answers show them: a stable code, its parameters beside it, and words for a reader.

use std::borrow::Cow;

use serde_json::Map;

use super::history_note;
use crate::core::message::sent;
use crate::core::note::Note;
use crate::wire::prelude::*;

mod campaign;

/// What a reader should know before relying on an accepted item.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct NoteBody {
    /// Which kind of note, for programs.
    pub code: Cow<'static, str>,
    /// The same in words, in the language that the request asks for.
    pub detail: String,
    /// What the words name, by code: serials, figures, places.
    #[serde(flatten)]
    pub parameters: Map<String, Value>,
}

impl NoteBody {
    /// Code, parameters and words of a note.
    pub fn of(note: &Note) -> Self {
        let parameters = match note {
            Note::NoLineEnd { line, value } => Map::from_iter([
                ("line".to_owned(), Value::from(*line)),
                ("value".to_owned(), Value::from(value.as_str())),
            ]),
            Note::NotRestated { slot, effect } => Map::from_iter([
                ("slot".to_owned(), Value::from(slot.name())),
                ("effect".to_owned(), Value::from(effect.id())),
            ]),
            Note::Campaign(note) => campaign::parameters(note),
            Note::History(note) => history_note::parameters(note),
            _ => Map::new(),
        };
        Self { code: note.code().into(), detail: asked().words(&message(note)), parameters }
    }

    /// Whether it says that the figures of a gyro may be another's or in another unit, or that a name of the record may
    /// be misspelt.
    pub fn doubts_figures_of(&self, serial: &str) -> bool {
        let named = |member: &str| self.parameters.get(member).and_then(Value::as_array).into_iter().flatten();
        match self.code.as_ref() {
            "serials_exchanged" => named("fits").any(|fit| fit["serial"] == serial),
            "other_unit" | "another_gyro" | "unit_factor" | "uncertainty_factor" => {
                named("serials").any(|one| one == serial)
            }
            "look_alike" => match self.parameters.get("of").and_then(Value::as_str) {
                Some("serial") => self.parameters.get("name").is_some_and(|name| name == serial),
                of => of == Some("imu"),
            },
            _ => false,
        }
    }
}

/// Kept notes for a reader. One that only a later version knows is shown by its code.
pub fn read(kept: Option<&str>) -> Vec<NoteBody> {
    let document: Value = kept.and_then(|kept| serde_json::from_str(kept).ok()).unwrap_or_default();
    let notes = document.get("notes").and_then(Value::as_array);
    notes.into_iter().flatten().filter_map(of_kept).collect()
}

fn of_kept(note: &Value) -> Option<NoteBody> {
    let mut parameters = note.as_object()?.clone();
    let code = parameters.remove("code")?.as_str()?.to_owned();
    parameters.retain(|_, value| !value.is_null());
    let detail = history_note::kept_words(note).unwrap_or_else(|| code.clone());
    Some(NoteBody { code: code.into(), detail, parameters })
}

/// What a reader is told.
pub fn message(note: &Note) -> Message {
    match note {
        Note::NoAttitudes => message!("no_attitudes"),
        Note::NoSite => message!("no_site"),
        Note::NoTemperatures => message!("no_temperatures"),
        Note::AnyTemperature => message!("any_temperature_of_record"),
        Note::NotRestated { slot, effect } => {
            message!("not_restated", slot = slot.name(), effect = effect.word())
        }
        Note::NoLineEnd { line, value } => message!("no_line_end", line = *line, value = sent(value)),
        Note::Withdrawn => message!("withdrawn"),
        Note::Campaign(note) => campaign::message(note),
        Note::History(note) => history_note::message(note),
    }
}
