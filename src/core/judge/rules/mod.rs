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

pub(crate) use before_after::BEFORE_AFTER_RECORDS;
pub(crate) use closure::closure;
pub(crate) use rms_successive::RMS_RECORDS;

use baseline::baseline;
use before_after::before_after;
use range::range;
use rms_successive::rms_successive;
use shift::shift;
use step::step;
use trend::trend;

use super::cells::{Points, Window};
use super::decide::{Outcome, beyond};
use super::history::{History, Measured, Sample};
use super::limits::Limit;
use super::{Coefficient, DriftLimits, Finding, Limits, State, Verdict};
use crate::core::message::Message;
use crate::core::named::named;
use crate::message;

named! {
/// A criterion. Several may watch the same coefficient. Stored by their place: new ones come last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule("rule_") {
    /// |x_k - median of the three before|.
    Step = "step",
    /// max - min over the newest records.
    Range = "range",
    /// |x_k - baseline|.
    Baseline = "baseline",
    /// A straight course, carried forward to the budget.
    Trend = "trend",
    /// Two-sided cumulative sum, in verdicts and alerts of earlier versions; [`Rule::Shift`] has taken its place.
    Cusum = "cusum",
    /// Root mean square of successive differences.
    RmsSuccessive = "rms_successive",
    /// The closure moved from its baseline.
    Closure = "closure",
    /// Range over the methods that measured the gyro.
    Agreement = "agreement",
    /// E or G outside its requirement (Tables 3 and 4).
    Requirement = "requirement",
    /// Not calibrated for longer than the interval.
    Overdue = "overdue",
    /// The newest three weeks with records against the level before.
    Shift = "shift",
    /// The first records after an environmental test against the last one before.
    BeforeAfter = "before_after",
}
}

/// Which kind of limit a rule holds a gyro to; the two are never mixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LimitKind {
    /// What the gyro must do: a budget or a requirement.
    Specification,
    /// What this gyro usually does: a statistical limit, calibrated by its rate of false alarms.
    Control,
}

/// The unit of a value and its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    Drift,
    Days,
    StandardDeviations,
    PulsePerArcsec,
    PulsePerSecond,
}

impl Unit {
    /// As machines read it.
    pub fn name(self) -> &'static str {
        match self {
            Unit::Drift => "deg/(h g0)",
            Unit::Days => "days",
            Unit::StandardDeviations => "standard deviations",
            Unit::PulsePerArcsec => "pulse/arcsec",
            Unit::PulsePerSecond => "pulse/(s g0)",
        }
    }

    /// As people read it.
    pub fn word(self) -> Message {
        match self {
            Unit::Drift => message!("unit_drift"),
            Unit::Days => message!("unit_days"),
            Unit::StandardDeviations => message!("unit_standard_deviations"),
            Unit::PulsePerArcsec => message!("unit_pulse_per_arcsec"),
            Unit::PulsePerSecond => message!("unit_pulse_per_second"),
        }
    }
}

impl Rule {
    pub fn limit_kind(self) -> LimitKind {
        match self {
            Rule::Cusum | Rule::Shift | Rule::Trend => LimitKind::Control,
            _ => LimitKind::Specification,
        }
    }

    /// The part of the budget that is its limit, where it has one limit. A gyro that keeps its budget in 19 of 20 steps stays below half of
    /// it in the root mean square of successive differences.
    pub fn share_of_budget(self) -> Option<f64> {
        match self {
            Rule::Step | Rule::Range | Rule::Baseline | Rule::Agreement | Rule::BeforeAfter => Some(1.0),
            Rule::RmsSuccessive => Some(0.5),
            _ => None,
        }
    }

    /// Unit of what it compares with its limit.
    pub fn unit(self, coefficient: Coefficient) -> Unit {
        match (self, coefficient) {
            (Rule::Overdue, _) => Unit::Days,
            (Rule::Cusum, _) => Unit::StandardDeviations,
            (Rule::Requirement, Coefficient::E) => Unit::PulsePerArcsec,
            (Rule::Requirement, _) => Unit::PulsePerSecond,
            _ => Unit::Drift,
        }
    }

    /// Whether a second campaign can confirm what the rule says.
    pub fn can_be_confirmed(self) -> bool {
        !matches!(self, Rule::Trend | Rule::Cusum | Rule::Shift | Rule::RmsSuccessive | Rule::Overdue)
    }
}

/// By every rule of D_I or D_S that has a limit.
pub(super) fn of_drift(case: &Case<'_>, drift: &DriftLimits, verdicts: &mut Vec<Verdict>) {
    verdicts.extend(drift.of(Rule::Step).map(|limit| step(case, limit)));
    verdicts.extend(drift.of(Rule::Range).map(|limit| range(case, limit)));
    verdicts.extend(drift.of(Rule::Baseline).map(|limit| baseline(case, limit, drift.fixed_baseline)));
    verdicts.extend(drift.trend.map(|limits| trend(case, &limits, drift.fixed_baseline)));
    verdicts.extend(drift.shift.map(|limits| shift(case, &limits)));
    verdicts.extend(drift.of(Rule::RmsSuccessive).map(|limit| rms_successive(case, limit)));
    verdicts.extend(drift.of(Rule::BeforeAfter).and_then(|limit| before_after(case, limit)));
}

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
