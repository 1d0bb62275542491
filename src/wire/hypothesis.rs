//! A hypothesis of one's own: a file in TOML for `--hypothesis`, and in JSON beside an effect of a model file.

use std::collections::BTreeMap;

use crate::core::effects::{COMPETITORS, Effect, HypothesisDefinition, OwnHypothesis, Range, own};
use crate::core::message::{sent, text};
use crate::wire::json;
use crate::wire::prelude::*;
use crate::wire::text::toml_fault;

/// An equation for the drift that the catalogue does not hold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct HypothesisBody {
    /// Its name in answers: small letters, digits and underscores.
    pub id: String,
    /// What people read.
    pub words: String,
    /// The physics behind it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub cause: String,
    /// Drift in deg/h, `k * T * w_I`: proportional to coefficients, names that begin with k.
    pub equation: String,
    /// Unit of the coefficients, of deg, h, g0, K and what is made of them.
    pub unit: String,
    /// Largest size that is believed.
    pub plausible: f64,
    /// Sizes that are met in practice; a thousandth to a tenth of `plausible` where left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub typical: Option<[f64; 2]>,
    /// Whether all gyros share one set of coefficients.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub common: bool,
    /// The one parameter that is no factor, and where it may lie.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty", deserialize_with = "json::each_once")]
    pub range: BTreeMap<String, HypothesisRangeBody>,
}

/// Where a parameter may lie.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct HypothesisRangeBody {
    pub from: f64,
    pub to: f64,
    pub unit: String,
}

/// Longest id, and longest text beside it.
const LONGEST_ID: usize = 48;
const LONGEST_TEXT: usize = 200;

/// Most bytes of a file.
const MOST_BYTES: usize = 65_536;

/// Reads and checks a hypothesis in TOML.
///
/// # Errors
/// What is no such file, with its line; otherwise every fault by pointer.
pub fn parse_toml(bytes: &[u8]) -> Result<Effect, Faults> {
    if bytes.len() > MOST_BYTES {
        return Err(message!("hypothesis_too_long", most = MOST_BYTES).into());
    }
    let text = std::str::from_utf8(bytes).map_err(|e| message!("not_utf8", why = e.to_string()))?;
    let body: HypothesisBody = toml::from_str(text).map_err(|error| toml_fault(&error, text))?;
    body.to_core()
}

impl HypothesisBody {
    /// Converts and checks.
    pub fn to_core(&self) -> Result<Effect, Faults> {
        let mut faults = Faults::default();
        let small = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        let named = self.id.starts_with(|c: char| c.is_ascii_lowercase()) && self.id.chars().all(small);
        if !named || self.id.len() > LONGEST_ID {
            faults.push("/id", message!("hypothesis_id", value = sent(&self.id), most = LONGEST_ID));
        } else if Effect::from_id(&self.id).is_some() || COMPETITORS.iter().any(|entry| entry.id == self.id) {
            faults.push("/id", message!("hypothesis_id_taken", value = sent(&self.id)));
        }
        for (pointer, words) in [("/words", &self.words), ("/cause", &self.cause)] {
            let long = words.chars().count() > LONGEST_TEXT;
            if long || words.chars().any(char::is_control) || (pointer == "/words" && words.trim().is_empty()) {
                faults.push(pointer, message!("hypothesis_words", most = LONGEST_TEXT));
            }
        }
        if self.range.len() > 1 {
            faults.push("/range", message!("hypothesis_one_range", have = self.range.len()));
        }
        let range = self.range.iter().next().map(|(name, range)| Range {
            name: name.clone(),
            from: range.from,
            to: range.to,
            unit: range.unit.clone(),
        });
        let written = HypothesisDefinition {
            id: self.id.clone(),
            words: self.words.clone(),
            cause: if self.cause.is_empty() { self.words.clone() } else { self.cause.clone() },
            equation: self.equation.clone(),
            unit: self.unit.clone(),
            plausible: self.plausible,
            typical: self.typical.unwrap_or([1e-3 * self.plausible, 0.1 * self.plausible]),
            common: self.common,
            range,
        };
        match OwnHypothesis::of(written).map_err(|part| faults.absorb("", part)) {
            Ok(hypothesis) if faults.is_empty() => own(hypothesis),
            _ => Err(faults),
        }
    }
}

bodies! {
    HypothesisBody of HypothesisDefinition: id, words, cause, equation, unit, plausible, typical: |written| Some(written.typical),
        common, range: |written| written.range.iter().map(|range| (range.name.clone(), range.to_body())).collect();
    HypothesisRangeBody of Range: from, to, unit;
}

/// Refuses two that have one id.
pub fn with_one_id_each(effects: &[Effect]) -> Result<(), Faults> {
    let twice = effects.iter().enumerate().find(|(i, effect)| effects[..*i].iter().any(|e| e.id() == effect.id()));
    let fault = |id: &str| Fault { pointer: "/id".to_owned(), message: message!("named_twice", name = text(id)) };
    twice.map_or(Ok(()), |(_, effect)| Err(fault(effect.id()).into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "id = \"creep\"\nwords = \"creep of the spring\"\nequation = \"k1 * exp(-t/tau) * a_S\"\n\
        unit = \"deg/(h g0)\"\nplausible = 10.0\n[range.tau]\nfrom = 0.1\nto = 5.0\nunit = \"h\"\n";

    #[test]
    fn a_file_is_read_and_written_as_the_same_hypothesis() {
        let effect = parse_toml(FILE.as_bytes()).unwrap();
        assert_eq!((effect.id(), effect.entry().unit, effect.is_nameable()), ("creep", "deg/(h g0)", true));
        let body = HypothesisBody::from(&effect.hypothesis().unwrap().written);
        let json = serde_json::to_string(&body).unwrap();
        let again: HypothesisBody = serde_json::from_str(&json).unwrap();
        assert_eq!(again.to_core().unwrap(), effect);
        assert_eq!(parse_toml(toml::to_string(&body).unwrap().as_bytes()).unwrap(), effect);
    }

    #[test]
    fn what_is_wrong_is_said_where_it_stands() {
        for (from, to, pointer, code) in [
            ("\"creep\"", "\"warmup\"", "/id", "hypothesis_id_taken"),
            ("\"creep\"", "\"torquer_heating\"", "/id", "hypothesis_id_taken"),
            ("\"creep\"", "\"My creep\"", "/id", "hypothesis_id"),
            ("creep of the spring", " ", "/words", "hypothesis_words"),
            ("plausible = 10.0", "plausible = -1.0", "/plausible", "hypothesis_sizes"),
            ("plausible = 10.0", "plausible = 10.0\nsize = 1", "", "at_line"),
            ("equation = \"k1", "equation = \"k1 * foo", "/equation", "equation_name"),
            ("unit = \"h\"", "unit = \"K\"", "/equation", "equation_pure_number"),
            ("from = 0.1", "from = nan", "/range/tau", "range_empty"),
            ("[range.tau]", "[range.a]\nfrom=1\nto=2\nunit=\"1\"\n[range.tau]", "/range", "hypothesis_one_range"),
        ] {
            let faults = parse_toml(FILE.replacen(from, to, 1).as_bytes()).unwrap_err();
            let found = |fault: &Fault| fault.pointer == pointer && fault.message.code == code;
            assert!(faults.0.iter().any(found), "{to}: {faults:?}");
        }
    }
}
