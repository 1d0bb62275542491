//! What one rule says of one record, and what that comes to.

use crate::core::judge::{Coefficient, Finding, Limit, LimitKey, LimitKind, Measured, Rule, Unit};
use crate::core::named::named;

named! {
/// Where a figure lies from its limit, as the API has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum State {
    Within = "within",
    /// Too few points, or the uncertainty straddles the limit.
    Indeterminate = "indeterminate",
    Exceeded = "exceeded",
}
}

named! {
/// What a verdict comes to, in the words of a quality engineer. The worst last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Status("status_") {
    InTolerance = "in_tolerance",
    /// Too few records to judge.
    NotEnoughData = "not_enough_data",
    /// Not even a figure in the middle of its tolerance would be known to lie within it.
    TooUncertain = "too_uncertain",
    /// The uncertainty straddles the limit.
    Borderline = "borderline",
    /// Not calibrated in its interval.
    Overdue = "overdue",
    /// Within its specification; a control rule speaks.
    Drifting = "drifting",
    /// Beyond a specification limit in one campaign; a second one is to confirm it.
    Unconfirmed = "unconfirmed",
    /// Beyond a specification limit, by a rule that sees several campaigns or none.
    OutOfTolerance = "out_of_tolerance",
    /// Beyond a specification limit, and a second campaign agrees.
    Confirmed = "confirmed",
}
}

impl Status {
    /// Where nothing is known but the worst state of what was judged.
    pub fn of_state(state: Option<State>) -> Self {
        match state {
            None => Status::NotEnoughData,
            Some(State::Within) => Status::InTolerance,
            Some(State::Indeterminate) => Status::Borderline,
            Some(State::Exceeded) => Status::OutOfTolerance,
        }
    }

    /// Of a verdict's parts; `value`, its limit and standard deviation as in [`Verdict`].
    pub fn of(rule: Rule, state: State, value: Option<f64>, limit: f64, sd: Option<f64>, confirmed: bool) -> Self {
        match state {
            State::Within => Status::InTolerance,
            State::Indeterminate if value.is_none() => Status::NotEnoughData,
            State::Indeterminate if sd.is_some_and(|sd| sd > TOO_UNCERTAIN * limit.abs()) => Status::TooUncertain,
            // They are undecided for no other reason.
            State::Indeterminate if matches!(rule, Rule::Shift | Rule::Forecast) => Status::TooUncertain,
            State::Indeterminate => Status::Borderline,
            State::Exceeded if rule == Rule::Overdue => Status::Overdue,
            State::Exceeded if rule.limit_kind() == LimitKind::Control => Status::Drifting,
            State::Exceeded if confirmed => Status::Confirmed,
            State::Exceeded if rule.can_be_confirmed() => Status::Unconfirmed,
            State::Exceeded => Status::OutOfTolerance,
        }
    }
}

/// A standard deviation of more than this part of the limit decides nothing: of a figure without any departure, 5 %
/// would still lie beyond it.
const TOO_UNCERTAIN: f64 = 0.5;

/// A level whose standard deviation is so many of one record's is uncertain by the scatter of the records, however they
/// are correlated.
const SCATTERED: f64 = 2.0;

named! {
/// How grave an alert is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity("severity_") {
    Warning = "warning",
    Critical = "critical",
}
}

/// One record of one gyro judged by one rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    pub coefficient: Coefficient,
    pub rule: Rule,
    pub state: State,
    /// The magnitude that is compared with the limit; none where there are too few points.
    pub value: Option<f64>,
    pub limit: f64,
    /// What in the configuration sets the limit.
    pub limit_from: LimitKey,
    /// Standard deviation of the value, where the station's standard deviations are known.
    pub sd: Option<f64>,
    /// Probability that the true value exceeds the limit, where the standard deviation is known.
    pub probability: Option<f64>,
    /// The part of the standard deviation that different stations bring in, where they do.
    pub between: Option<f64>,
    /// A second campaign says the same: see each rule for what that takes.
    pub confirmed: bool,
    /// What the rule saw, for the reason in words.
    pub finding: Finding,
}

impl Verdict {
    /// Specification limits warn, and are critical once a second campaign confirms; control limits only ever warn.
    pub fn severity(&self) -> Option<Severity> {
        match (self.state, self.rule.limit_kind(), self.confirmed) {
            (State::Exceeded, LimitKind::Specification, true) => Some(Severity::Critical),
            (State::Exceeded, _, _) => Some(Severity::Warning),
            _ => None,
        }
    }

    /// Unit of the value and the limit.
    pub fn unit(&self) -> Unit {
        self.rule.unit(self.coefficient)
    }

    /// What people are told: state, rule and confirmation in one word.
    pub fn status(&self) -> Status {
        Status::of(self.rule, self.state, self.value, self.limit, self.sd, self.confirmed)
    }

    /// Whether it is too uncertain by how the gyro scatters from record to record, of which each states this standard
    /// deviation: a smaller one would not decide either. What its stations differ by is not the gyro's.
    pub fn is_too_scattered(&self, of_record: Option<f64>) -> bool {
        let is_by_scatter = matches!(self.rule, Rule::Shift | Rule::Trend) && self.status() == Status::TooUncertain;
        let between = self.between.unwrap_or(0.0);
        let own = self.sd.map_or(0.0, |sd| (sd * sd - between * between).max(0.0).sqrt());
        is_by_scatter && of_record.is_none_or(|stated| own > SCATTERED * stated)
    }

    /// With nothing to compare.
    pub(crate) fn undecided(coefficient: Coefficient, rule: Rule, limit: Limit, finding: Finding) -> Self {
        Self {
            coefficient,
            rule,
            state: State::Indeterminate,
            value: None,
            limit: limit.value,
            limit_from: limit.from,
            sd: None,
            probability: None,
            between: None,
            confirmed: false,
            finding,
        }
    }

    /// What of the standard deviation comes from different stations.
    pub(super) fn between_stations(self, between: Option<f64>) -> Self {
        Self { between, ..self }
    }

    /// What the gyros of a station or batch share, where that exceeds its limit.
    pub fn group_shift(&self) -> Option<Measured> {
        match self.finding {
            Finding::GroupShift { shift, .. } if self.state == State::Exceeded => {
                Some(Measured { value: shift, sd: self.sd })
            }
            _ => None,
        }
    }

    /// What does not exceed has nothing to be confirmed.
    pub(super) fn confirmed_if(self, confirmed: bool) -> Self {
        Self { confirmed: confirmed && self.state == State::Exceeded, ..self }
    }
}
