//! A hypothesis that the search adopted, and the columns that it adds.

use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::hypotheses::Bank;
use crate::core::effects::Effect;

/// One adopted hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Choice {
    pub kind: Effect,
    /// Index into the bank.
    pub hypothesis: usize,
    pub members: Vec<bool>,
    /// Evidence given the other choices, prior odds included.
    pub evidence: f64,
    /// A competitor that explains the same a little better.
    pub rival: Option<Effect>,
}

impl Choice {
    /// Whether it stands for structure outside the catalogue and so is never named.
    pub fn is_competitor(&self) -> bool {
        !self.kind.is_nameable()
    }
}

pub(crate) fn without(choices: &[Choice], i: usize) -> Vec<Choice> {
    let mut others = choices.to_vec();
    others.remove(i);
    others
}

/// More columns than these make a competitor smooth.
const MOST_COLUMNS: usize = 4;

/// Raw columns of the model and of all choices. Smooth competitors stay out: they are not a few columns.
pub(crate) fn designs(frame: &Frame, bank: &Bank, found: &[Choice]) -> Vec<Vec<Vec<f64>>> {
    (0..frame.gyros.len())
        .map(|j| {
            let mut design = frame.designs[j].clone();
            for choice in found {
                let hypothesis = &bank.hypotheses[choice.hypothesis];
                if choice.members[j] && hypothesis.blocks[j].len <= MOST_COLUMNS {
                    for column in bank.columns_of(choice.hypothesis, j) {
                        design.push(column.iter().zip(&frame.gyros[j].sd).map(|(x, sd)| x * sd).collect());
                    }
                }
            }
            design
        })
        .collect()
}
