//! Cells of a table with the same kind of fault, said together.

use crate::core::message::Parameter;
use crate::wire::prelude::*;

/// Cells of one kind of fault from which on they are said together.
const ALIKE: usize = 4;

/// Faults of cells as one for each kind that is `folded`, by its code, in the place of the first.
pub fn together(faults: &[Fault], folded: impl Fn(&str) -> bool) -> Vec<Fault> {
    let kind = |fault: &Fault| match fault.message.parameter("fault") {
        Some(Parameter::Message(inner)) if fault.message.code == "at_cell" && folded(&inner.code) => {
            Some(inner.code.clone())
        }
        _ => None,
    };
    let mut said = Vec::new();
    let mut done = Vec::new();
    for fault in faults {
        let Some(code) = kind(fault) else {
            said.push(fault.clone());
            continue;
        };
        if done.contains(&code) {
            continue;
        }
        let alike: Vec<&Fault> = faults.iter().filter(|other| kind(other).as_ref() == Some(&code)).collect();
        if alike.len() < ALIKE {
            said.push(fault.clone());
            continue;
        }
        done.push(code);
        let lines = || alike.iter().map(|fault| count(&fault.message, "line"));
        let (from, to) = (lines().min().unwrap_or(0), lines().max().unwrap_or(0));
        let (count, first) = (alike.len(), fault.message.clone());
        let message = match from == to {
            true => message!("cells_alike_of_line", count, line = from, fault = first),
            false => message!("cells_alike", count, from, to, fault = first),
        };
        said.push(Fault { pointer: fault.pointer.clone(), message });
    }
    said
}

fn count(message: &Message, name: &str) -> u64 {
    match message.parameter(name) {
        Some(Parameter::Count(count)) => *count,
        _ => 0,
    }
}
