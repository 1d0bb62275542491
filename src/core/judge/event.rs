//! What happened to a gyro, and what begins anew with it.

use crate::core::judge::{Measured, Rule};
use crate::core::named::named;
use crate::core::time::UtcMicros;

named! {
/// What was done to a gyro.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Event("event_") {
    /// An engineer declares a new baseline.
    Baseline = "baseline",
    Repair = "repair",
    /// Taken out of an IMU and mounted again, there or elsewhere.
    Reinstallation = "reinstallation",
    Transport = "transport",
    Firmware = "firmware",
    Note = "note",
    /// An environmental test: the gyro is judged before and after.
    EnvironmentalTest = "environmental_test",
    /// Taken out of use for good.
    Retired = "retired",
    /// Not to be calibrated until it comes back.
    InStorage = "in_storage",
    /// An engineer has decided: it is released for use as it is.
    DecisionRelease = "decision_release",
    /// It is to be measured again before anything else is decided.
    DecisionRetest = "decision_retest",
    /// It is to be taken out.
    DecisionRemove = "decision_remove",
    /// The last decision was an error and does not stand.
    DecisionWithdrawn = "decision_withdrawn",
}
}

impl Event {
    /// Whether the next records form a new baseline.
    pub fn resets_baseline(self) -> bool {
        matches!(self, Event::Baseline | Event::Repair | Event::Reinstallation)
    }

    /// Whether it is somebody's decision, which does nothing to the gyro itself.
    pub fn is_decision(self) -> bool {
        matches!(
            self,
            Event::DecisionRelease | Event::DecisionRetest | Event::DecisionRemove | Event::DecisionWithdrawn
        )
    }

    /// Whether it may change a gyro: what was written down or decided does nothing to it.
    pub fn may_move_a_gyro(self) -> bool {
        !matches!(self, Event::Note | Event::Baseline) && !self.is_decision()
    }

    /// Whether no calibration is expected after it, until the next one comes.
    pub fn ends_calibrations(self) -> bool {
        matches!(self, Event::Retired | Event::InStorage)
    }

    /// Whether records before the event are not to be compared by `rule` with those after it.
    ///
    /// * A repair makes another gyro of it: everything restarts.
    /// * A baseline mark and a re-installation restart what is measured from a level (baseline, closure, trend,
    ///   shift, before_after). `step`, `range` and `rms_successive` go on: D_I and D_S belong to the gyro, not to its
    ///   seat, and a jump over a re-installation is what an engineer wants to see.
    /// * New firmware may change how pulses are counted: the control rules restart, the budgets hold.
    /// * Transport and environmental tests are what the budgets are there to survive; the rest changes nothing.
    pub fn resets(self, rule: Rule) -> bool {
        match self {
            // What a station, a batch or an IMU does is no gyro's.
            Event::Repair => !rule.explains_others() && rule != Rule::Forecast,
            Event::Baseline | Event::Reinstallation => matches!(
                rule,
                Rule::Baseline | Rule::Closure | Rule::Trend | Rule::Shift | Rule::Cusum | Rule::BeforeAfter
            ),
            Event::Firmware => matches!(rule, Rule::Trend | Rule::Shift | Rule::Cusum),
            Event::Transport | Event::Note | Event::EnvironmentalTest | Event::Retired | Event::InStorage => false,
            Event::DecisionRelease | Event::DecisionRetest | Event::DecisionRemove | Event::DecisionWithdrawn => false,
        }
    }

    /// The rules that it [resets](Event::resets), as people are told: `overdue` compares nothing that an event may part,
    /// and no rule judges any more by a cumulative sum.
    pub fn rules_reset(self) -> impl Iterator<Item = Rule> {
        let judges = |rule: &Rule| !matches!(rule, Rule::Overdue | Rule::Cusum);
        Rule::ALL.into_iter().filter(move |rule| judges(rule) && self.resets(*rule))
    }
}

/// An event on a gyro's time line. It parts the records before `at` from those at or after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    pub at: UtcMicros,
    pub event: Event,
    /// When what began at `at` was over; none for what took no time.
    pub until: Option<UtcMicros>,
    /// Levels of what comes after it, where it begins a baseline and states them.
    pub fixed: FixedLevels,
}

/// D_I and D_S that are stated instead of measured, deg/(h g0).
pub type FixedLevels = [Option<Measured>; 2];

impl Mark {
    /// One that states no levels.
    pub fn of(at: UtcMicros, event: Event) -> Self {
        Self { at, event, until: None, fixed: [None; 2] }
    }
}

/// Where the baseline of a record at `at` begins: at the last event that resets it, or at the very first record (none).
pub fn baseline_since(marks: &[Mark], at: UtcMicros) -> Option<UtcMicros> {
    baseline_mark(marks, at).map(|mark| mark.at)
}

/// When `rule` began anew for a record at `at`.
pub fn reset_before(marks: &[Mark], at: UtcMicros, rule: Rule) -> Option<UtcMicros> {
    marks.iter().rev().find(|mark| mark.at <= at && mark.event.resets(rule)).map(|mark| mark.at)
}

/// The level that the mark states which begins the baseline of a record at `at`.
pub fn stated_level(marks: &[Mark], at: UtcMicros, column: usize) -> Option<Measured> {
    baseline_mark(marks, at).and_then(|mark| mark.fixed.get(column).copied().flatten())
}

fn baseline_mark(marks: &[Mark], at: UtcMicros) -> Option<&Mark> {
    marks.iter().rev().find(|mark| mark.at <= at && mark.event.resets_baseline())
}
