//! One rule a file. Each is a function of a [`Case`] and of its limit.

mod agreement;
mod baseline;
mod before_after;
mod closure;
mod overdue;
mod range;
mod requirement;
mod rms_successive;
mod shift;
mod step;
mod trend;

pub use agreement::{Source, SourcedResult, agreement};
pub use overdue::overdue;
pub use requirement::{MOST_FIGURES, requirement};

pub(crate) use baseline::baseline;
pub(crate) use before_after::{BEFORE_AFTER_RECORDS, before_after};
pub(crate) use closure::closure;
pub(crate) use range::range;
pub(crate) use rms_successive::{RMS_RECORDS, rms_successive};
pub(crate) use shift::shift;
pub(crate) use step::step;
pub(crate) use trend::trend;

use super::cells::{Points, Window};
use super::decide::{Outcome, beyond};
use super::history::{History, Measured, Sample};
use super::limits::Limit;
use super::{Coefficient, Finding, Limits, Rule, State, Verdict};

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
    fn now(&self) -> &'a Sample {
        &self.history.samples[self.k]
    }

    fn value(&self, sample: &Sample) -> Measured {
        sample.d[self.column]
    }

    /// The records that the rule may look at, the judged one last.
    fn since_reset(&self, rule: Rule) -> &'a [Sample] {
        self.history.since_reset(self.k, rule)
    }

    /// The weekly means that the control rules look at, of D_I or D_S.
    fn points(&self) -> Points<'a> {
        self.window.column(self.column)
    }

    fn beyond(&self, difference: Measured, limit: f64) -> Outcome {
        beyond(difference, limit, self.limits.confidence)
    }

    fn exceeds(&self, difference: Measured, limit: f64) -> bool {
        self.beyond(difference, limit).state == State::Exceeded
    }

    /// Whether both lie beyond the limit, on the same side.
    fn both_exceed(&self, a: Measured, b: Measured, limit: f64) -> bool {
        a.value.is_sign_positive() == b.value.is_sign_positive() && self.exceeds(a, limit) && self.exceeds(b, limit)
    }

    fn too_few(&self, rule: Rule, limit: Limit, have: usize, need: usize) -> Verdict {
        self.nothing(rule, limit, Finding::TooFew { have, need })
    }

    fn nothing(&self, rule: Rule, limit: Limit, finding: Finding) -> Verdict {
        Verdict::undecided(self.coefficient, rule, limit, finding)
    }

    fn verdict(&self, rule: Rule, limit: Limit, value: Measured, outcome: Outcome, finding: Finding) -> Verdict {
        Verdict {
            state: outcome.state,
            value: Some(value.value.abs()),
            sd: value.sd,
            probability: outcome.probability,
            ..self.nothing(rule, limit, finding)
        }
    }
}

impl Verdict {
    /// With nothing to compare.
    fn undecided(coefficient: Coefficient, rule: Rule, limit: Limit, finding: Finding) -> Self {
        Self {
            coefficient,
            rule,
            state: State::Indeterminate,
            value: None,
            limit: limit.value,
            limit_from: limit.from,
            sd: None,
            probability: None,
            confirmed: false,
            finding,
        }
    }

    /// What does not exceed has nothing to be confirmed.
    fn confirmed_if(self, confirmed: bool) -> Self {
        Self { confirmed: confirmed && self.state == State::Exceeded, ..self }
    }
}
