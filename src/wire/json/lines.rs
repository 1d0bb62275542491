//! Lines that faults name, where the document is part of a longer text.

use crate::core::message::Parameter;
use crate::wire::prelude::*;

/// The faults of a document on a line of its own name the column alone: whoever reads them is told the line beside
/// them, and counted in itself the document has another one.
pub fn on_a_line(faults: Faults) -> Faults {
    replaced(faults, &|_, column| message!("in_column", column))
}

/// The faults of a document that begins on `line` of the text which it is part of, in lines of that text.
pub fn from_line(line: usize, document: &str, faults: Faults) -> Faults {
    if !document.trim().contains('\n') {
        return on_a_line(faults);
    }
    replaced(faults, &|own, column| message!("line_and_column", line = own + line as u64 - 1, column))
}

fn replaced(mut faults: Faults, place: &impl Fn(u64, u64) -> Message) -> Faults {
    faults.0.iter_mut().for_each(|fault| replace(&mut fault.message, place));
    faults
}

/// Puts another place for every line and column in it.
fn replace(message: &mut Message, place: &impl Fn(u64, u64) -> Message) {
    if message.code == "line_and_column" {
        if let (Some(Parameter::Count(line)), Some(Parameter::Count(column))) =
            (message.parameter("line"), message.parameter("column"))
        {
            *message = place(*line, *column);
        }
        return;
    }
    for (_, parameter) in &mut message.parameters {
        if let Parameter::Message(nested) = parameter {
            replace(nested, place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::fault::Fault;
    use crate::words::Language;

    fn said(line: usize, document: &str, fault: Message) -> String {
        let fault = Fault { pointer: "/imu".into(), message: fault };
        Language::English.words(&from_line(line, document, fault.into()).0.remove(0).message)
    }

    #[test]
    fn a_fault_names_the_line_of_the_whole_text_or_none() {
        let placed = |line: u64| {
            let place = message!("line_and_column", line, column = 9_u64);
            message!("not_json", why = message!("at_place", fault = message!("json_expected_value"), place))
        };
        assert_eq!(said(7, "not json\r\n", placed(1)), "not JSON: expected a value at column 9");
        assert_eq!(said(7, "{\n \"imu\": 7}", placed(2)), "not JSON: expected a value at line 8 column 9");
        assert_eq!(said(7, "{}", message!("empty_text")), "must not be empty");
    }
}
