//! What each rule saw.

use super::sample::Measured;
use crate::core::bench::BenchMethod;
use crate::core::message::Message;
use crate::core::time::UtcMicros;
use crate::message;

/// What a rule saw. Values in deg/(h g0) unless said otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finding {
    /// Not enough records since the last event that resets the rule; weeks with records where the rule counts those.
    TooFew {
        have: usize,
        need: usize,
    },
    /// Not enough results that lie close enough in time to be compared.
    FewWithin {
        have: usize,
        need: usize,
        days: f64,
    },
    /// The gyro is in another IMU or slot than before, and has too few records there.
    Moved {
        since: UtcMicros,
        have: usize,
        need: usize,
    },
    Step {
        /// Median of the three records before.
        level: f64,
        now: f64,
    },
    Range {
        records: usize,
        since: UtcMicros,
        lowest: (UtcMicros, f64),
        highest: (UtcMicros, f64),
    },
    Baseline {
        level: f64,
        /// First of the records that make the baseline; none where it is fixed.
        since: Option<UtcMicros>,
        now: f64,
    },
    Closure {
        level: f64,
        since: Option<UtcMicros>,
        /// Whether the level began when the gyro was moved to another IMU or slot.
        moved: bool,
        now: f64,
        /// D_S, where the closure is D_O: what a turn of the spin axis would have moved it by, per radian.
        d_s: Option<f64>,
    },
    /// No slope is established.
    NoTrend {
        cells: usize,
        since: UtcMicros,
        /// Where a change of level explains the records better.
        step: Option<UtcMicros>,
    },
    Trend {
        cells: usize,
        since: UtcMicros,
        /// The judged record, from which the slope is carried on.
        until: UtcMicros,
        per_year: Measured,
        /// From the baseline, at `until`.
        deviation: f64,
        horizon_days: f64,
        /// When the budget is reached: by the early edge of the 95 % band, by the line, by the late edge; `until`
        /// where it has been passed already, none where it never is.
        reach: [Option<UtcMicros>; 3],
        /// The course is younger than the longest window: the dates may be off by more than they say.
        provisional: bool,
        /// Whether the noise constants are the fleet's.
        of_fleet: bool,
    },
    Shift {
        level: f64,
        /// Cells that make the level.
        before: usize,
        /// First record of the newest three cells.
        since: UtcMicros,
        /// Median of the newest three.
        now: f64,
        /// Of one cell about its level.
        scatter: f64,
        /// The departure that matters; the limit is three standard deviations where they are more.
        least: f64,
    },
    RmsSuccessive {
        since: UtcMicros,
        /// The part that the stations' standard deviations explain, where they are known.
        explained: Option<f64>,
    },
    BeforeAfter {
        before: (UtcMicros, f64),
        /// The test.
        from: UtcMicros,
        until: UtcMicros,
        now: f64,
    },
    Agreement {
        results: usize,
        lowest: (Source, UtcMicros, f64),
        highest: (Source, UtcMicros, f64),
    },
    /// pulse/arcsec or pulse/(s g0).
    Requirement {
        figure: &'static str,
        low: f64,
        high: f64,
        /// Other figures that lie outside.
        others: [Option<&'static str>; MOST_FIGURES - 1],
    },
    /// Days.
    Overdue {
        last: UtcMicros,
    },
}

/// Where a figure comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Source {
    /// Separated from a calibration of the IMU.
    Separation,
    Bench(BenchMethod),
}

impl Source {
    pub fn name(self) -> &'static str {
        match self {
            Source::Separation => "separation",
            Source::Bench(method) => method.name(),
        }
    }

    pub fn word(self) -> Message {
        match self {
            Source::Separation => message!("method_separation"),
            Source::Bench(method) => method.word(),
        }
    }
}

/// Most figures of one verdict: |E| and its components.
pub const MOST_FIGURES: usize = 4;
