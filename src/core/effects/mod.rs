//! The catalogue: every effect that model (6) leaves out and that a campaign may show.
//!
//! An effect adds `sum_m k_m x_m` to the drift of a gyro (deg/h), where the regressors `x_m` follow from what the
//! station commanded and read: specific force, rate, temperature, time, attitude, order of dwells. Some regressors
//! hold one unknown [`Shape`] parameter (a time constant, an instant, a period) that is profiled over a grid.
//!
//! Two standings. *Contract* entries may be named as a cause. *Competing hypotheses* are what physics or table work
//! also produces and what nobody asked to have named: they compete in the search, so that a contract entry which
//! merely resembles one of them does not get its name, but they are reported as signs, never adopted.
//!
//! One file a family. All that the rest of the program asks of an effect is a field of its [`Entry`].

mod acceleration;
pub mod axes;
mod competitors;
mod dimension;
mod entry;
mod equation;
mod estimate;
mod memory;
mod model_terms;
mod own;
mod own_hypothesis;
mod rate;
mod refusal;
mod setting;
mod station;
mod thermal;
mod time;

pub use dimension::regressor_unit;
pub use entry::{Coefficient, Effect, Entry, Own, Parameter, Prior, Scope, Shape};
pub use estimate::Estimate;
pub use own::own;
pub use own_hypothesis::{HypothesisDefinition, OwnHypothesis, Range};
pub use refusal::{MissingInput, Refusal};
pub use setting::{GyroAxes, Setting};

use super::message::Message;
use super::model::Term;
use crate::message;

/// Families by the order of [`Effect`]: those of the contract, then competing hypotheses.
const CONTRACT: [&[&Entry]; 7] = [
    model_terms::ENTRIES,
    thermal::ENTRIES,
    time::ENTRIES,
    memory::ENTRIES,
    rate::ENTRIES,
    station::ENTRIES,
    acceleration::ENTRIES,
];

/// All entries that may be named, in the order of the contract.
pub const CATALOGUE: [&Entry; count(&CONTRACT)] = joined(&CONTRACT);

/// Competing hypotheses, which are never named.
pub const COMPETITORS: [&Entry; count(&competitors::FAMILIES)] = joined(&competitors::FAMILIES);

const fn count(families: &[&[&Entry]]) -> usize {
    let (mut family, mut sum) = (0, 0);
    while family < families.len() {
        sum += families[family].len();
        family += 1;
    }
    sum
}

const fn joined<const N: usize>(families: &[&[&'static Entry]]) -> [&'static Entry; N] {
    let mut all = [families[0][0]; N];
    let (mut family, mut next) = (0, 0);
    while family < families.len() {
        let mut i = 0;
        while i < families[family].len() {
            all[next] = families[family][i];
            next += 1;
            i += 1;
        }
        family += 1;
    }
    all
}

impl Effect {
    /// Its entry, in the catalogue, among the competitors, or made of one's own equation.
    pub fn entry(self) -> &'static Entry {
        match self.place() {
            Ok(place) if place < CATALOGUE.len() => CATALOGUE[place],
            Ok(place) => COMPETITORS[place - CATALOGUE.len()],
            Err(own) => own.entry(),
        }
    }

    /// What somebody wrote, where it is a hypothesis of one's own.
    pub fn hypothesis(self) -> Option<&'static OwnHypothesis> {
        self.place().err().map(Own::hypothesis)
    }

    /// Its name in answers, files and the database.
    pub fn id(self) -> &'static str {
        self.entry().id
    }

    /// What people read.
    pub fn word(self) -> Message {
        if let Some(own) = self.hypothesis() {
            return message!("effect_of_ones_own", words = own.written.words.clone());
        }
        Message { code: format!("effect_{}", self.id()).into(), parameters: Vec::new() }
    }

    /// What a campaign must hold for the effect to show; said of those that may be named.
    pub fn needs(self) -> Message {
        if self.hypothesis().is_some() {
            return message!("needed_for_ones_own");
        }
        Message { code: format!("needed_for_{}", self.id()).into(), parameters: Vec::new() }
    }

    /// Whether a diagnosis may name it as a cause. Competitors never are.
    pub fn is_nameable(self) -> bool {
        self.entry().nameable
    }

    /// The entry of the contract with this id.
    pub fn from_id(id: &str) -> Option<Self> {
        CATALOGUE.iter().find(|entry| entry.id == id).map(|entry| entry.effect)
    }

    /// The entry that stands for a term of model (6), where there is one.
    pub fn of_term(term: Term) -> Option<Self> {
        Self::from_id(term.name())
    }

    /// The term of model (6) that it stands for, if it does.
    pub fn term(self) -> Option<Term> {
        Term::from_name(self.id())
    }
}

/// The names of all contract entries, for messages.
pub fn known() -> String {
    CATALOGUE.map(|entry| entry.id).join(", ")
}

/// The names of those that have a largest plausible size.
pub fn known_with_size() -> String {
    CATALOGUE.iter().filter(|entry| entry.has_size()).map(|entry| entry.id).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    #[test]
    fn an_effect_finds_its_own_entry_and_its_own_id() {
        for (i, entry) in CATALOGUE.iter().enumerate() {
            assert_eq!(entry.effect.place(), Ok(i), "{}", entry.id);
            assert_eq!(Effect::from_id(entry.id), Some(entry.effect));
            assert!(!entry.cause.is_empty() && !entry.equation.is_empty());
            assert!(entry.typical[0] <= entry.typical[1]);
            assert!(entry.plausible >= 10.0 * entry.typical[1], "{}", entry.id);
            assert!(!entry.confused_with.contains(&entry.effect));
        }
    }

    #[test]
    fn every_competing_hypothesis_says_what_it_is_and_what_it_passes_for() {
        let mut ids: Vec<&str> = COMPETITORS.iter().map(|competitor| competitor.id).collect();
        for (i, competitor) in COMPETITORS.iter().enumerate() {
            assert_eq!(competitor.effect.place(), Ok(CATALOGUE.len() + i), "{}", competitor.id);
            assert_eq!(competitor.effect.entry().id, competitor.id);
            let words = [competitor.cause, competitor.equation, competitor.unit];
            assert!(words.iter().all(|text| !text.is_empty()));
            assert!(competitor.typical[0] < competitor.typical[1] && !competitor.confused_with.is_empty());
            assert!(!competitor.nameable, "{}", competitor.id);
            assert_eq!(Effect::from_id(competitor.id), None, "the contract's entries are no competitors");
        }
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), COMPETITORS.len());
    }

    #[test]
    fn the_documentation_holds_the_catalogue_row_by_row() {
        let row = |entry: &&Entry| {
            let unit = entry.unit;
            let of = if entry.scope == Scope::Common { "all gyros alike" } else { "each gyro" };
            let others: Vec<String> = entry.confused_with.iter().map(|other| format!("`{}`", other.id())).collect();
            let equation = entry.equation.replace('|', "\\|");
            let (id, cause) = (entry.id, entry.cause);
            let needs = Language::English.words(&entry.effect.needs());
            format!("| `{id}` | {cause} | {equation} | {unit} | {of} | {needs} | {} |", others.join(", "))
        };
        let expected: Vec<String> = CATALOGUE.iter().map(row).collect();
        let documented: Vec<&str> =
            include_str!("../../../docs/diagnosis.md").lines().filter(|line| line.starts_with("| `")).collect();
        assert_eq!(documented, expected, "docs/diagnosis.md should hold\n{}", expected.join("\n"));
    }
}
