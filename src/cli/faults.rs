//! Faults of a document for a person at a station: those of a table by line and column, and alike ones together.

use serde_json::json;

use crate::core::fault::{Fault, Faults};
use crate::core::message::Message;
use crate::wire::alike::together;
use crate::wire::message::read;
use crate::wire::problem::{ProblemBody, summary};
use crate::words::asked;

/// What is wrong, for the eye: of a table one fault a line, without pointers into a document that nobody wrote; of JSON
/// with its pointers, in one line.
pub(super) fn in_words(Faults(faults): &Faults) -> String {
    if faults.is_empty() || !faults.iter().all(|fault| is_placed(&fault.message)) {
        return summary(faults, asked());
    }
    let lines: Vec<String> = together(faults, |_| true).iter().map(|fault| asked().words(&fault.message)).collect();
    lines.join("\n  ")
}

/// The same of a refusal that a service answered; none where it is of a version that gives no codes.
pub(super) fn of_problem(problem: &ProblemBody) -> Option<String> {
    let fault = |place: &crate::wire::problem::Place| {
        let message = read(&json!({ "code": place.message.code, "parameters": place.message.parameters }))?;
        is_placed(&message).then(|| Fault { pointer: place.pointer.clone(), message })
    };
    let faults: Option<Vec<Fault>> = problem.errors.iter().map(fault).collect();
    Some(in_words(&Faults(faults.filter(|faults| !faults.is_empty())?)))
}

/// Whether a message says itself where in a table it belongs.
fn is_placed(message: &Message) -> bool {
    matches!(
        &*message.code,
        "at_line"
            | "at_line_key"
            | "at_cell"
            | "at_column"
            | "at_head_line"
            | "cells_alike"
            | "cells_alike_of_line"
            | "no_table"
            | "utf16"
            | "map_names"
            | "map_column_missing"
            | "table_without_rows"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::campaign_csv::{parse_csv, to_csv};

    fn campaign() -> String {
        let scenario = crate::simulate::presets::preset("24-position").unwrap();
        to_csv(&crate::simulate::simulate(&scenario).unwrap().campaign)
    }

    fn said(text: &str) -> String {
        in_words(&parse_csv(text.as_bytes()).unwrap_err())
    }

    #[test]
    fn decimal_commas_of_a_whole_table_are_one_line() {
        let (head, table) = campaign().split_once("phase,").map(|(a, b)| (a.to_owned(), format!("phase,{b}"))).unwrap();
        let german = head + &table.replace(',', ";").replace('.', ",");
        let said = said(&german);
        assert!(said.contains("cells in lines") && said.contains("has a decimal comma"), "{said}");
        assert!(said.lines().count() <= 2 && !said.contains("/dwells"), "{said}");
    }

    #[test]
    fn one_decimal_comma_among_points_is_found_in_its_own_column() {
        let text = campaign();
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let head = lines.iter().position(|line| line.starts_with("phase,")).unwrap();
        let column = lines[head].split(',').position(|name| name == "temperature_c").unwrap();
        let broken = head + 7;
        let mut cells: Vec<String> = lines[broken].split(',').map(str::to_owned).collect();
        cells[column] = "45,67".into();
        lines[broken] = cells.join(",");
        let said = said(&lines.join("\n"));
        let expected = format!("line {}, column {} (temperature_c)", broken + 1, column + 1);
        assert!(said.contains(&expected) && said.contains("45,67"), "{said}");
    }
}
