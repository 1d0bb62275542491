//! Notes as answers show them: a stable code, its parameters beside it, and words for a reader.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::history_note;
use crate::core::note::Note;

mod campaign;

/// What a reader should know before relying on an accepted item.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct NoteBody {
    /// Which kind of note, for programs.
    pub code: Cow<'static, str>,
    /// The same in words.
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
        Self { code: note.code().into(), detail: detail(note), parameters }
    }
}

fn detail(note: &Note) -> String {
    match note {
        Note::NoAttitudes => "no attitude column: specific force and rate were not checked against the attitude".into(),
        Note::NoSite => "no site: the specific force of static dwells was checked against standard gravity".into(),
        Note::NoTemperatures => "no temperature column: effects of temperature cannot be seen".into(),
        Note::Campaign(note) => campaign::detail(note),
        Note::History(note) => history_note::words(note),
    }
}
