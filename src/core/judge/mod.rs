//! History and limits in, verdicts with their reasons out.
//!
//! A verdict judges one record of one gyro by one rule. Rules are pure functions of a bounded stretch of history
//! ([`history::Need`] says how much), so a record that arrives late, or is voided, is dealt with by judging the records
//! after it again. No words are made here: [`Verdict::messages`] says what there is to say, by code and parameters.

pub mod history;
pub mod limits;

mod cells;
mod decide;
mod extremes;
mod finding;
mod noise;
mod range_summary;
mod reason;
mod rules;
mod series;

pub use crate::core::judge::range_summary::Older;
pub use finding::Finding;
pub use history::{
    BASELINE_RECORDS, Event, FixedLevels, History, Mark, Measured, Need, Sample, Seat, baseline_since, stated_level,
};
pub use limits::{Bounds, DriftLimits, Limit, LimitKey, Limits, Requirement, ShiftLimits, TrendLimits};
pub use noise::{FleetNoise, Noise, Spacing, fit_fleet};
pub use reason::{digits, sd_digits, turn_arcmin};
pub use rules::{LimitKind, Rule, Source, SourcedResult, Unit, agreement, overdue, requirement};
pub use series::Series;

use super::named::named;
use cells::Window;
use rules::Case;

/// What a verdict is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Coefficient {
    DI,
    DS,
    /// The closure, in which neither D_I nor D_S has a part: mounting, or a true output-axis term.
    DO,
    /// The scale-factor row (Table 3).
    E,
    /// The row of g-sensitive terms (Table 4).
    G,
    /// The gyro as a whole.
    All,
}

impl Coefficient {
    pub const ALL: [Coefficient; 6] =
        [Coefficient::DI, Coefficient::DS, Coefficient::DO, Coefficient::E, Coefficient::G, Coefficient::All];

    pub fn name(self) -> &'static str {
        match self {
            Coefficient::DI => "D_I",
            Coefficient::DS => "D_S",
            Coefficient::DO => "D_O",
            Coefficient::E => "E",
            Coefficient::G => "G",
            Coefficient::All => "all",
        }
    }

    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|coefficient| coefficient.name() == name)
    }

    /// Its place in [`Sample::d`]; none for what has no history there.
    pub fn column(self) -> Option<usize> {
        match self {
            Coefficient::DI => Some(0),
            Coefficient::DS => Some(1),
            Coefficient::DO => Some(2),
            _ => None,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum State {
    Within,
    /// Too few points, or the uncertainty straddles the limit.
    Indeterminate,
    Exceeded,
}

impl State {
    pub const ALL: [State; 3] = [State::Within, State::Indeterminate, State::Exceeded];

    pub fn name(self) -> &'static str {
        match self {
            State::Within => "within",
            State::Indeterminate => "indeterminate",
            State::Exceeded => "exceeded",
        }
    }

    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.name() == name)
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
            // A shift is undecided for no other reason.
            State::Indeterminate if rule == Rule::Shift => Status::TooUncertain,
            State::Indeterminate => Status::Borderline,
            State::Exceeded if rule == Rule::Overdue => Status::Overdue,
            State::Exceeded if rule.limit_kind() == LimitKind::Control => Status::Drifting,
            State::Exceeded if confirmed => Status::Confirmed,
            State::Exceeded if rule.can_be_confirmed() => Status::Unconfirmed,
            State::Exceeded => Status::OutOfTolerance,
        }
    }
}

/// A standard deviation of more than this part of the limit decides nothing: of a figure without any departure, 5 % would still
/// lie beyond it.
const TOO_UNCERTAIN: f64 = 0.5;

named! {
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

    pub fn status(&self) -> Status {
        Status::of(self.rule, self.state, self.value, self.limit, self.sd, self.confirmed)
    }
}

/// Judges record `k` of a history by every rule of that history that has a limit, appending to `verdicts`.
///
/// Used for the latest record as for any earlier one that has to be judged again: records after `k` have no part in it.
/// [`requirement`], [`agreement`] and [`overdue`] are judged apart: they need no history.
///
/// # Panics
/// Where `k` is not an index of `history.samples`.
pub fn judge(history: &History<'_>, k: usize, limits: &Limits, verdicts: &mut Vec<Verdict>) {
    let window = &Window::at(history.samples, k);
    let case = |coefficient, column| Case { history, k, coefficient, column, limits, window };
    rules::of_drift(&case(Coefficient::DI, 0), &limits.d_i, verdicts);
    rules::of_drift(&case(Coefficient::DS, 1), &limits.d_s, verdicts);
    verdicts.extend(limits.closure.map(|limit| rules::closure(&case(Coefficient::DO, 2), limit)));
}

#[cfg(test)]
mod tests;
