//! The service's answer to one record or campaign in the few lines that an operator reads.

use std::fmt;

use serde_json::Value;

use crate::cli::document::note;
use crate::cli::prelude::*;
use crate::core::judge::Status;
use crate::core::message::list;

/// Displays D_I and D_S of each gyro or why there are none, how many verdicts there are of each status, what was
/// judged beyond its limit, and what could not be checked; nothing for other answers.
pub struct AnswerSummary<'a>(pub &'a Value);

impl fmt::Display for AnswerSummary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The figures of what counts no more would be read as those in force.
        if let Some(standing) = withdrawn(self.0) {
            return writeln!(f, "  {}", note(&standing));
        }
        for separation in members(self.0, "separations") {
            let value = |name: &str| separation[name]["value"].as_f64().unwrap_or(f64::NAN);
            let (slot, serial) = (text(separation, "slot"), text(separation, "serial"));
            writeln!(f, "  {slot} {serial}  D_I {:+.6}  D_S {:+.6} deg/(h g0)", value("d_i"), value("d_s"))?;
        }
        for gyro in members(self.0, "not_separated") {
            let (slot, serial, reason) = (text(gyro, "slot"), text(gyro, "serial"), text(gyro, "reason"));
            let none = message!("terminal_no_coefficients", reason = reason.to_owned());
            writeln!(f, "  {slot} {serial}  {}", said(none))?;
        }
        let verdicts: Vec<(Status, &Value)> = members(self.0, "verdicts")
            .filter_map(|verdict| Some((Status::from_name(text(verdict, "status"))?, verdict)))
            .collect();
        let of_status = |status: Status| word(&status.word().code);
        let counted = |status: Status| {
            let count = verdicts.iter().filter(|(other, _)| *other == status).count();
            let said = || said(message!("terminal_counted", count = count.to_string(), status = of_status(status)));
            (count > 0).then(said)
        };
        let counts: Vec<String> = Status::ALL.into_iter().rev().filter_map(counted).collect();
        if !counts.is_empty() {
            writeln!(f, "  {}", said(message!("terminal_verdicts", counts = list(counts))))?;
        }
        for (status, verdict) in verdicts.iter().filter(|(_, verdict)| text(verdict, "state") == "exceeded") {
            let (serial, coefficient) = (text(verdict, "serial"), text(verdict, "coefficient"));
            let (rule, reason) = (text(verdict, "rule"), text(verdict, "reason"));
            writeln!(f, "  {serial} {coefficient} {rule} {}: {reason}", of_status(*status))?;
        }
        let mut notes = members(self.0, "notes").filter_map(|note| note["detail"].as_str());
        notes.try_for_each(|detail| writeln!(f, "  {}", note(detail)))
    }
}

/// Why what is stored counts no more; none where it counts.
pub fn withdrawn(answer: &Value) -> Option<String> {
    let of = |member: &str, name: &str| text(&answer[member], name).to_owned();
    let why = match text(answer, "state") {
        "revised" => {
            let (record, author) = (of("revised_by", "record"), of("revised_by", "author"));
            message!("terminal_replaced", record, author, reason = of("revised_by", "reason"))
        }
        "voided" => message!("terminal_voided", author = of("voided", "author"), reason = of("voided", "reason")),
        "set_aside" => message!("terminal_set_aside"),
        _ => return None,
    };
    Some(said(why))
}

fn members<'a>(answer: &'a Value, name: &str) -> impl Iterator<Item = &'a Value> {
    answer[name].as_array().into_iter().flatten()
}

fn text<'a>(value: &'a Value, name: &str) -> &'a str {
    value[name].as_str().unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn an_operator_reads_the_coefficients_what_is_exceeded_and_what_there_is_not() {
        let answer = json!({"id": "r1",
            "separations": [{"slot": "G1", "serial": "LFG-1", "d_i": {"value": 2.957643}, "d_s": {"value": -4.618005}}],
            "not_separated": [{"slot": "G2", "serial": "LFG-2", "reason": "the dwells do not determine G_x"}],
            "verdicts": [
                {"serial": "LFG-1", "coefficient": "D_I", "rule": "step", "state": "exceeded", "status": "unconfirmed", "reason": "too far"},
                {"serial": "LFG-1", "coefficient": "D_I", "rule": "trend", "state": "indeterminate", "status": "not_enough_data", "reason": "too few"},
                {"serial": "LFG-1", "coefficient": "D_S", "rule": "trend", "state": "indeterminate", "status": "not_enough_data", "reason": "too few"},
                {"serial": "LFG-1", "coefficient": "D_S", "rule": "step", "state": "within", "status": "in_tolerance", "reason": "close"}],
            "notes": [{"code": "no_temperatures", "detail": "no temperature column"}, {"code": "moved", "detail": "LFG-1 has moved"}]});
        let lines = [
            "  G1 LFG-1  D_I +2.957643  D_S -4.618005 deg/(h g0)",
            "  G2 LFG-2  no D_I and D_S: the dwells do not determine G_x",
            "  verdicts: 1 unconfirmed, 2 not enough data, 1 in tolerance",
            "  LFG-1 D_I step unconfirmed: too far",
            "  note: no temperature column",
            "  note: LFG-1 has moved",
        ];
        assert_eq!(AnswerSummary(&answer).to_string(), lines.map(|line| format!("{line}\n")).concat());
        assert_eq!(AnswerSummary(&json!({"id": "b1"})).to_string(), "");
    }
}
