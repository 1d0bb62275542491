//! One rule a file. Each is a function of a [`Case`] and of its limit.

mod agreement;
mod baseline;
mod closure;
mod cusum;
mod overdue;
mod range;
mod requirement;
mod rms_successive;
mod step;
mod trend;

pub use agreement::{Source, SourcedResult, agreement};
pub use overdue::overdue;
pub use requirement::requirement;

pub(crate) use baseline::baseline;
pub(crate) use closure::closure;
pub(crate) use cusum::{CUSUM_RECORDS, cusum};
pub(crate) use range::range;
pub(crate) use rms_successive::{RMS_RECORDS, rms_successive};
pub(crate) use step::step;
pub(crate) use trend::{TREND_RECORDS, trend};

use super::decide::{Outcome, beyond};
use super::history::{History, Measured, Sample};
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

    fn too_few(&self, rule: Rule, limit: f64, have: usize, need: usize) -> Verdict {
        Verdict {
            coefficient: self.coefficient,
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

    fn verdict(&self, rule: Rule, limit: f64, value: Measured, outcome: Outcome, finding: Finding) -> Verdict {
        Verdict {
            coefficient: self.coefficient,
            rule,
            state: outcome.state,
            value: Some(value.value.abs()),
            limit,
            sd: value.sd,
            probability: outcome.probability,
            confirmed: false,
            finding,
        }
    }
}

impl Verdict {
    fn confirmed_if(self, confirmed: bool) -> Self {
        Self { confirmed, ..self }
    }
}
