//! What every rule is given.

use crate::core::judge::cells::{Points, Window};
use crate::core::judge::coefficient::Coefficient;
use crate::core::judge::decide::{Outcome, beyond};
use crate::core::judge::history::History;
use crate::core::judge::limits::{Limit, Limits};
use crate::core::judge::rule::Finding;
use crate::core::judge::rule::Rule;
use crate::core::judge::sample::{Measured, Sample};
use crate::core::judge::verdict::{State, Verdict};

/// One coefficient of the record to be judged, and the history before it.
#[derive(Clone, Copy)]
pub(crate) struct Case<'a> {
    pub history: &'a History<'a>,
    /// Index of the judged record in `history.samples`.
    pub k: usize,
    pub coefficient: Coefficient,
    /// Its place in [`Sample::d`].
    pub column: usize,
    pub limits: &'a Limits,
    pub window: &'a Window,
}

impl<'a> Case<'a> {
    pub fn now(&self) -> &'a Sample {
        &self.history.samples[self.k]
    }

    pub fn value(&self, sample: &Sample) -> Measured {
        sample.d[self.column]
    }

    /// The records that the rule may look at, the judged one last.
    pub fn since_reset(&self, rule: Rule) -> &'a [Sample] {
        self.history.since_reset(self.k, rule)
    }

    /// The weekly means that the control rules look at, of D_I or D_S.
    pub fn points(&self) -> Points<'a> {
        self.window.column(self.column)
    }

    pub fn beyond(&self, difference: Measured, limit: f64) -> Outcome {
        beyond(difference, limit, self.limits.confidence)
    }

    pub fn exceeds(&self, difference: Measured, limit: f64) -> bool {
        self.beyond(difference, limit).state == State::Exceeded
    }

    /// Whether both lie beyond the limit, on the same side.
    pub fn both_exceed(&self, a: Measured, b: Measured, limit: f64) -> bool {
        a.value.is_sign_positive() == b.value.is_sign_positive() && self.exceeds(a, limit) && self.exceeds(b, limit)
    }

    pub fn too_few(&self, rule: Rule, limit: Limit, have: usize, need: usize) -> Verdict {
        self.nothing(rule, limit, Finding::TooFew { have, need })
    }

    pub fn nothing(&self, rule: Rule, limit: Limit, finding: Finding) -> Verdict {
        Verdict::undecided(self.coefficient, rule, limit, finding)
    }

    pub fn verdict(&self, rule: Rule, limit: Limit, value: Measured, outcome: Outcome, finding: Finding) -> Verdict {
        Verdict {
            state: outcome.state,
            value: Some(value.value.abs()),
            sd: value.sd,
            probability: outcome.probability,
            ..self.nothing(rule, limit, finding)
        }
    }
}
