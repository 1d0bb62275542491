//! The service's answer to one record or campaign in the two or three lines that an operator reads.

use std::fmt;

use serde_json::Value;

/// Displays D_I and D_S of each gyro and what was judged out of bounds or undecided; nothing for other answers.
pub struct Gist<'a>(pub &'a Value);

impl fmt::Display for Gist<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for separation in members(self.0, "separations") {
            let value = |name: &str| separation[name]["value"].as_f64().unwrap_or(f64::NAN);
            let (slot, serial) = (text(separation, "slot"), text(separation, "serial"));
            writeln!(f, "  {slot} {serial}  D_I {:+.6}  D_S {:+.6} deg/(h g0)", value("d_i"), value("d_s"))?;
        }
        let verdicts = members(self.0, "verdicts");
        for verdict in verdicts.filter(|v| text(v, "state") != "within") {
            let (serial, coefficient) = (text(verdict, "serial"), text(verdict, "coefficient"));
            let (state, rule, reason) = (text(verdict, "state"), text(verdict, "rule"), text(verdict, "reason"));
            writeln!(f, "  {serial} {coefficient} {rule} {state}: {reason}")?;
        }
        Ok(())
    }
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
    fn an_operator_reads_the_coefficients_and_what_is_not_within() {
        let answer = json!({"id": "r1",
            "separations": [{"slot": "G1", "serial": "LFG-1", "d_i": {"value": 2.957643}, "d_s": {"value": -4.618005}}],
            "verdicts": [
                {"serial": "LFG-1", "coefficient": "D_I", "rule": "step", "state": "exceeded", "reason": "too far"},
                {"serial": "LFG-1", "coefficient": "D_S", "rule": "step", "state": "within", "reason": "close"}]});
        assert_eq!(
            Gist(&answer).to_string(),
            "  G1 LFG-1  D_I +2.957643  D_S -4.618005 deg/(h g0)\n  LFG-1 D_I step exceeded: too far\n"
        );
        assert_eq!(Gist(&json!({"id": "b1"})).to_string(), "");
    }
}
