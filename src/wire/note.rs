//! Notes as answers show them: a stable code, its parameters beside it, and words for a reader.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::history_note;
use crate::core::message::Message;
use crate::core::note::Note;
use crate::message;
use crate::words::{Language, asked};

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
    pub fn of(note: &Note) -> Self {
        let parameters = match note {
            Note::Campaign(note) => campaign::parameters(note),
            Note::History(note) => history_note::parameters(note),
            _ => Map::new(),
        };
        Self { code: note.code().into(), detail: words(note, asked()), parameters }
    }
}

pub fn words(note: &Note, language: Language) -> String {
    language.words(&message(note))
}

/// What a reader is told.
pub(super) fn message(note: &Note) -> Message {
    match note {
        Note::NoAttitudes => message!("no_attitudes"),
        Note::NoSite => message!("no_site"),
        Note::NoTemperatures => message!("no_temperatures"),
        Note::Campaign(note) => campaign::message(note),
        Note::History(note) => history_note::message(note),
    }
}
