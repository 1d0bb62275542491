//! Lines that faults name, where the document is part of a longer text.

use crate::core::fault::{Fault, Faults};

/// The faults of a document on a line of its own name the column alone: whoever reads them is told the line beside them, and counted in
/// itself the document has another one.
pub fn on_a_line(faults: Faults) -> Faults {
    replaced(faults, |what, _, column| format!("{what} at column {column}"))
}

/// The faults of a document that begins on `line` of the text which it is part of, in lines of that text.
pub fn from_line(line: usize, document: &str, faults: Faults) -> Faults {
    if !document.trim().contains('\n') {
        return on_a_line(faults);
    }
    replaced(faults, |what, own, column| format!("{what} at line {} column {column}", own + line - 1))
}

fn replaced(mut faults: Faults, said: impl Fn(&str, usize, usize) -> String) -> Faults {
    for Fault { detail, .. } in &mut faults.0 {
        if let Some((what, line, column)) = taken_apart(detail) {
            *detail = said(what, line, column);
        }
    }
    faults
}

/// What is wrong, and the line and column that serde has added.
fn taken_apart(detail: &str) -> Option<(&str, usize, usize)> {
    let (what, place) = detail.rsplit_once(" at line ")?;
    let (line, column) = place.split_once(" column ")?;
    Some((what, line.parse().ok()?, column.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(line: usize, document: &str, detail: &str) -> String {
        let fault = Fault { pointer: "/imu".into(), detail: detail.into() };
        from_line(line, document, fault.into()).0.remove(0).detail
    }

    #[test]
    fn a_fault_names_the_line_of_the_whole_text_or_none() {
        let detail = "not JSON: expected ident at line 1 column 2";
        assert_eq!(said(7, "not json\r\n", detail), "not JSON: expected ident at column 2");
        assert_eq!(said(7, "{\n \"imu\": 7}", "invalid type at line 2 column 9"), "invalid type at line 8 column 9");
        for other in ["must not be empty", "at line 3", "unknown field `x at line one column`"] {
            assert_eq!(said(7, "{}", other), other);
        }
    }
}
