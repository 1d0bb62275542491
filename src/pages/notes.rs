//! Notes on a record: what was noticed when it came.

use super::prelude::*;
use crate::wire::note::NoteBody;

pub(super) fn noted(t: &Text, notes: &[NoteBody]) -> Markup {
    html! {
        @if !notes.is_empty() {
            section.notes {
                h3 { (t.notes) }
                ul { @for note in notes { li { (note.detail) } } }
            }
        }
    }
}
