//! One rule a file. Each takes the history, the index of the judged record, and its limit.

mod baseline;
mod range;
mod step;

pub(crate) use baseline::baseline;
pub(crate) use range::range;
pub(crate) use step::step;

use super::{Coefficient, Finding, Rule, State, Verdict};

fn too_few(rule: Rule, coefficient: Coefficient, limit: f64, have: usize, need: usize) -> Verdict {
    Verdict {
        coefficient,
        rule,
        state: State::Indeterminate,
        value: None,
        limit,
        sd: None,
        probability: None,
        confirmed: false,
        finding: Finding::TooFew { have, need },
    }
}
