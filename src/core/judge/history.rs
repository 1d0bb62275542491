//! What a rule is given: the stretch of one gyro's history that it needs, oldest first, and what happened to the gyro.

use crate::core::time::UtcMicros;

use super::limits::Limits;
use super::{Coefficient, Older, Rule, Series};

/// A baseline is the mean of this many records after the last mark that resets it.
pub const BASELINE_RECORDS: usize = 3;

/// A figure and its standard deviation, where the station gave what it takes to know it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    pub value: f64,
    pub sd: Option<f64>,
}

impl Measured {
    pub fn exact(value: f64) -> Self {
        Self { value, sd: None }
    }

    /// `self - earlier`, the two taken as independent campaigns.
    pub(crate) fn minus(self, earlier: Self) -> Self {
        let sd = self.sd.zip(earlier.sd).map(|(a, b)| (a * a + b * b).sqrt());
        Self { value: self.value - earlier.value, sd }
    }

    /// Mean of independent figures; its standard deviation is known when all of theirs are.
    pub(crate) fn mean(all: impl ExactSizeIterator<Item = Self>) -> Self {
        let n = all.len() as f64;
        let (sum, variance) = all.fold((0.0, Some(0.0)), |(sum, variance): (f64, Option<f64>), x| {
            (sum + x.value, variance.zip(x.sd).map(|(v, sd)| v + sd * sd))
        });
        Self { value: sum / n, sd: variance.map(|v| v.sqrt() / n) }
    }
}

/// D_I, D_S, and the closure.
pub(super) const COLUMNS: usize = 3;

/// One gyro in one calibration record: the row that the store keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    pub at: UtcMicros,
    /// D_I, D_S, and the closure (D_O, or the published closure where that method is judged), deg/(h g0).
    pub d: [Measured; COLUMNS],
}

impl Sample {
    pub fn get(&self, coefficient: Coefficient) -> Option<Measured> {
        coefficient.column().map(|column| self.d[column])
    }
}

/// What was done to a gyro.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Event {
    /// An engineer declares a new baseline.
    Baseline,
    Repair,
    /// Taken out of an IMU and mounted again, there or elsewhere.
    Reinstallation,
    Transport,
    Firmware,
    Note,
}

impl Event {
    pub const ALL: [Event; 6] =
        [Event::Baseline, Event::Repair, Event::Reinstallation, Event::Transport, Event::Firmware, Event::Note];

    pub fn name(self) -> &'static str {
        match self {
            Event::Baseline => "baseline",
            Event::Repair => "repair",
            Event::Reinstallation => "reinstallation",
            Event::Transport => "transport",
            Event::Firmware => "firmware",
            Event::Note => "note",
        }
    }

    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|event| event.name() == name)
    }

    /// Whether the next records form a new baseline.
    pub fn resets_baseline(self) -> bool {
        matches!(self, Event::Baseline | Event::Repair | Event::Reinstallation)
    }

    /// Whether records before the event are not to be compared by `rule` with those after it.
    ///
    /// * A repair makes another gyro of it: everything restarts.
    /// * A baseline mark and a re-installation restart what is measured from a level (baseline, closure, trend,
    ///   cusum). `step`, `range` and `rms_successive` go on: D_I and D_S belong to the gyro, not to its seat, and
    ///   a jump over a re-installation is what an engineer wants to see.
    /// * New firmware may change how pulses are counted: the statistical rules restart, the budgets hold.
    /// * Transport is what the budgets are there to survive, and a note changes nothing.
    pub fn resets(self, rule: Rule) -> bool {
        match self {
            Event::Repair => true,
            Event::Baseline | Event::Reinstallation => {
                matches!(rule, Rule::Baseline | Rule::Closure | Rule::Trend | Rule::Cusum)
            }
            Event::Firmware => matches!(rule, Rule::Trend | Rule::Cusum),
            Event::Transport | Event::Note => false,
        }
    }
}

/// An event on a gyro's time line. It parts the records before `at` from those at or after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    pub at: UtcMicros,
    pub event: Event,
    /// Levels of what comes after it, where it begins a baseline and states them.
    pub fixed: FixedLevels,
}

/// D_I and D_S that are stated instead of measured, deg/(h g0).
pub type FixedLevels = [Option<Measured>; 2];

impl Mark {
    /// One that states no levels.
    pub fn of(at: UtcMicros, event: Event) -> Self {
        Self { at, event, fixed: [None; 2] }
    }
}

/// The stretch of one gyro's history that the judging of one record needs.
#[derive(Debug, Clone, Copy)]
pub struct History<'a> {
    /// Consecutive records without the voided ones, oldest first: as far back as [`Need`] says. What comes after the
    /// judged record does no harm.
    pub samples: &'a Series,
    /// The first [`BASELINE_RECORDS`] records at or after [`baseline_since`], or fewer where there are not so many.
    pub baseline: &'a [Sample],
    /// Every event of the gyro, oldest first.
    pub marks: &'a [Mark],
    /// Records before `samples` that are not there one by one: those that `range` compares with the judged one.
    pub older: Older,
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

/// How far back the rules look from the record that they judge (besides the baseline's records and the marks).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Need {
    /// At least so many records before it, where there are so many.
    pub records: usize,
    /// And every record of so many days before it.
    pub days: f64,
}

impl Need {
    pub fn of(limits: &Limits) -> Self {
        Self { records: limits.longest_memory() - 1, days: limits.range_days }
    }

    /// How many of the records after `changed` (oldest first) must be judged again when a record at
    /// `changed` is inserted, voided or revised. Where that alters the baseline's records, all of them must.
    pub fn reach(&self, changed: UtcMicros, later: &[Sample]) -> usize {
        let within_days = later.partition_point(|sample| sample.at.days_since(changed) <= self.days);
        within_days.max(self.records.min(later.len()))
    }
}

impl<'a> History<'a> {
    /// Of records that are all there one by one.
    pub fn of(samples: &'a Series, baseline: &'a [Sample], marks: &'a [Mark]) -> Self {
        Self { samples, baseline, marks, older: Older::NONE }
    }

    /// The records that `rule` may compare with record `k`: from the last event that resets the rule, `k` included.
    pub(crate) fn since_reset(&self, k: usize, rule: Rule) -> &'a [Sample] {
        &self.samples[self.first_since_reset(k, rule)..=k]
    }

    /// Place of the first of [`History::since_reset`].
    pub(crate) fn first_since_reset(&self, k: usize, rule: Rule) -> usize {
        let upto = &self.samples[..=k];
        let reset = reset_before(self.marks, self.samples[k].at, rule);
        reset.map_or(0, |reset| upto.partition_point(|sample| sample.at < reset))
    }

    /// The baseline's records that precede record `k`; complete with [`BASELINE_RECORDS`] of them.
    pub(crate) fn baseline_before(&self, k: usize) -> &'a [Sample] {
        let before = self.baseline.partition_point(|sample| sample.at < self.samples[k].at);
        &self.baseline[..before]
    }
}
