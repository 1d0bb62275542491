//! The rules by name, and what kind of limit each has.

use super::coefficient::Coefficient;
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

    /// The part of the budget that is its limit, where it has one limit. A gyro that keeps its budget in 19 of 20
    /// steps stays below half of it in the root mean square of successive differences.
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
