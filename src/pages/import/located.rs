//! Where in a text a fault is: its line, and the part of the line that it is about.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

use serde_json::value::RawValue;

use crate::core::fault::Fault;
use crate::core::message::{Message, Parameter};
use crate::pages::upload_parts::Piece;
use crate::wire::campaign::Form;

/// A line of the whole text, counting from 1, and bytes of it; none where it is about all of the line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Place {
    pub line: usize,
    pub part: Option<Range<usize>>,
}

pub(super) fn place(piece: &Piece<'_>, fault: &Fault) -> Place {
    match piece.form {
        Form::Csv => of_csv(piece, &fault.message),
        Form::Json => of_json(piece, fault),
    }
}

fn of_csv(piece: &Piece<'_>, message: &Message) -> Place {
    let Some(own) = count(message, "line") else { return Place { line: piece.line, part: None } };
    let text = piece.text.lines().nth(own - 1).unwrap_or_default();
    let part = count(message, "column").and_then(|column| cell(text, column));
    Place { line: piece.line + own - 1, part }
}

/// A parameter of a message, or of one within it.
fn count(message: &Message, name: &str) -> Option<usize> {
    if let Some(Parameter::Count(count)) = message.parameter(name) {
        return usize::try_from(*count).ok().filter(|count| *count > 0);
    }
    message.parameters.iter().find_map(|(_, parameter)| match parameter {
        Parameter::Message(nested) => count(nested, name),
        _ => None,
    })
}

/// The bytes of a cell, counting from 1: up to the next mark that parts cells.
fn cell(line: &str, number: usize) -> Option<Range<usize>> {
    let marks = ['\t', ';', ','].into_iter().max_by_key(|mark| line.matches(*mark).count())?;
    let mut start = 0;
    for (k, part) in line.split(marks).enumerate() {
        if k + 1 == number {
            return Some(start..start + part.len());
        }
        start += part.len() + 1;
    }
    None
}

fn of_json(piece: &Piece<'_>, fault: &Fault) -> Place {
    let bytes = match span(piece.text, &fault.pointer) {
        Some(span) if !fault.pointer.is_empty() => span,
        _ => {
            // It cannot be read: serde tells where, in lines of the whole text where there are several.
            let Some(column) = count(&fault.message, "column") else { return Place { line: piece.line, part: None } };
            let line = count(&fault.message, "line").unwrap_or(piece.line);
            let text = piece.text.lines().nth(line - piece.line).unwrap_or_default();
            let start = (0..column.min(text.len() + 1)).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
            return Place { line, part: Some(start..text.len()).filter(|part| !part.is_empty()) };
        }
    };
    let before = &piece.text[..bytes.start];
    let line = piece.line + before.matches('\n').count();
    let begins = before.rfind('\n').map_or(0, |at| at + 1);
    let ends = piece.text[bytes.start..].find('\n').map_or(piece.text.len(), |at| bytes.start + at);
    Place { line, part: Some(bytes.start - begins..bytes.end.min(ends) - begins) }
}

/// The bytes of what a JSON pointer names; of a member that is missing, the object that should hold it.
fn span(text: &str, pointer: &str) -> Option<Range<usize>> {
    let mut found: &str = serde_json::from_str::<&RawValue>(text).ok()?.get();
    for token in pointer.split('/').skip(1) {
        let token = token.replace("~1", "/").replace("~0", "~");
        let next = match serde_json::from_str::<BTreeMap<Cow<'_, str>, &RawValue>>(found) {
            Ok(members) => members.get(token.as_str()).map(|value| value.get()),
            Err(_) => {
                let items = serde_json::from_str::<Vec<&RawValue>>(found).unwrap_or_default();
                token.parse::<usize>().ok().and_then(|at| items.get(at).map(|value| value.get()))
            }
        };
        let Some(next) = next else { break };
        found = next;
    }
    let start = found.as_ptr() as usize - text.as_ptr() as usize;
    Some(start..start + found.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message;

    fn part(piece: &Piece<'_>, pointer: &str, message: Message) -> (usize, Option<String>) {
        let place = place(piece, &Fault { pointer: pointer.into(), message });
        let line = piece.text.lines().nth(place.line - piece.line).unwrap();
        (place.line, place.part.map(|part| line[part].to_owned()))
    }

    #[test]
    fn the_value_that_a_pointer_names_is_found_in_its_line() {
        let text = "{\n \"imu\": \"A\",\n \"gyros\": [{\"serial\": \"G/1\"},\n  {\"serial\": 7, \"a/b\": [1, 2]}]\n}";
        let piece = Piece { line: 5, text, form: Form::Json };
        let fault = || message!("empty_text");
        assert_eq!(part(&piece, "/imu", fault()), (6, Some("\"A\"".into())));
        assert_eq!(part(&piece, "/gyros/1/serial", fault()), (8, Some("7".into())));
        assert_eq!(part(&piece, "/gyros/1/a~1b/1", fault()), (8, Some("2".into())));
        // What is missing is looked for in the object that should hold it.
        assert_eq!(part(&piece, "/gyros/0/slot", fault()), (7, Some("{\"serial\": \"G/1\"}".into())));
        assert_eq!(part(&piece, "", fault()), (5, None));
        let broken = Piece { line: 3, text: "{ \"imu\": nope }", form: Form::Json };
        assert_eq!(part(&broken, "", message!("in_column", column = 11_u64)), (3, Some("ope }".into())));
    }

    #[test]
    fn a_cell_of_a_table_is_found_by_its_line_and_column() {
        let piece = Piece { line: 2, text: "# imu: A\nphase,start_s\nstatic,x 1,2", form: Form::Csv };
        let cell = |line: u64, column: u64| {
            let fault = message!("empty_text");
            message!("at_cell", line, column, name = "start_s", fault)
        };
        assert_eq!(part(&piece, "/dwells/0/start_s", cell(3, 2)), (4, Some("x 1".into())));
        assert_eq!(part(&piece, "/dwells/0/start_s", cell(3, 9)), (4, None));
        let key = message!("at_line_key", line = 1_u64, key = "imu", fault = message!("empty_text"));
        assert_eq!(part(&piece, "/imu", key), (2, None));
        assert_eq!(part(&piece, "/dwells", message!("no_table")), (2, None));
    }
}
