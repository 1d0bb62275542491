//! The rules by name, what kind of limit each has, and what each sees.

use crate::core::bench::BenchMethod;
use crate::core::judge::{Coefficient, Measured};
use crate::core::message::Message;
use crate::core::mounting::Slot;
use crate::core::named::named;
use crate::core::time::UtcMicros;
use crate::message;

named! {
/// A criterion. Several may watch the same coefficient. Stored by their place: new ones come last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule("rule_", letter) {
    /// |x_k - median of the three before|.
    Step = "step" 'S',
    /// max - min over the newest records.
    Range = "range" 'R',
    /// |x_k - baseline|.
    Baseline = "baseline" 'B',
    /// A straight course, carried forward to the budget.
    Trend = "trend" 'T',
    /// Two-sided cumulative sum, in verdicts and alerts of earlier versions; [`Rule::Shift`] has taken its place.
    Cusum = "cusum" 'C',
    /// Root mean square of successive differences.
    RmsSuccessive = "rms_successive" 'N',
    /// The closure moved from its baseline.
    Closure = "closure" 'O',
    /// Range over the methods that measured the gyro.
    Agreement = "agreement" 'A',
    /// E or G outside its requirement (Tables 3 and 4).
    Requirement = "requirement" 'Q',
    /// Not calibrated for longer than the interval.
    Overdue = "overdue" 'D',
    /// The newest three weeks with records against the level before.
    Shift = "shift" 'L',
    /// The first records after an environmental test against the last one before.
    BeforeAfter = "before_after" 'E',
    /// What the gyros of a station have moved by together, judged by the clock and not by a record.
    StationShift = "station_shift" 'G',
    /// A campaign of an IMU against what its adopted model has foretold.
    Forecast = "forecast" 'K',
    /// Every gyro of an IMU has moved at once, judged as [`Rule::StationShift`] is.
    ImuShift = "imu_shift" 'I',
    /// What the gyros of a batch of production have moved by together, judged as [`Rule::StationShift`] is.
    BatchShift = "batch_shift" 'H',
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
            Unit::Drift => "deg/(h*g0)",
            Unit::Days => "days",
            Unit::StandardDeviations => "standard deviations",
            Unit::PulsePerArcsec => "pulse/arcsec",
            Unit::PulsePerSecond => "pulse/(s*g0)",
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
    /// Whether its limit is a specification, or what the gyro usually does.
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
            Rule::Forecast | Rule::ImuShift => Some(1.0),
            Rule::RmsSuccessive => Some(0.5),
            Rule::StationShift | Rule::BatchShift => Some(0.25),
            _ => None,
        }
    }

    /// Unit of what it compares with its limit.
    pub fn unit(self, coefficient: Coefficient) -> Unit {
        match (self, coefficient) {
            (Rule::Overdue, _) => Unit::Days,
            (Rule::Cusum | Rule::Forecast, _) => Unit::StandardDeviations,
            (Rule::Requirement, Coefficient::E) => Unit::PulsePerArcsec,
            (Rule::Requirement, _) => Unit::PulsePerSecond,
            _ => Unit::Drift,
        }
    }

    /// Whether what a station, a batch or an IMU does to all its gyros can make a gyro exceed it.
    pub fn can_be_shared(self) -> bool {
        matches!(
            self,
            Rule::Step
                | Rule::Range
                | Rule::Baseline
                | Rule::Trend
                | Rule::Shift
                | Rule::RmsSuccessive
                | Rule::BeforeAfter
        )
    }

    /// Whether it tells what several gyros share, and stands for what is told of each.
    pub fn explains_others(self) -> bool {
        matches!(self, Rule::StationShift | Rule::BatchShift | Rule::ImuShift)
    }

    /// Whether a second campaign can confirm what the rule says.
    pub fn can_be_confirmed(self) -> bool {
        !matches!(
            self,
            Rule::Trend
                | Rule::Cusum
                | Rule::Shift
                | Rule::RmsSuccessive
                | Rule::Overdue
                | Rule::StationShift
                | Rule::BatchShift
        )
    }
}

/// What a rule saw. Values in deg/(h g0) unless said otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finding {
    /// Not enough records since the last event that resets the rule; weeks with records where the rule counts those.
    TooFew { have: usize, need: usize },
    /// Not enough results that lie close enough in time to be compared.
    FewWithin { have: usize, need: usize, days: f64 },
    /// The gyro is in another IMU or slot than before, and has too few records there.
    Moved { since: UtcMicros, have: usize, need: usize },
    /// Of the newest record from those before it.
    Step {
        /// Median of the three records before.
        level: f64,
        now: f64,
    },
    /// Between the records that lie furthest apart.
    Range { records: usize, since: UtcMicros, lowest: (UtcMicros, f64), highest: (UtcMicros, f64) },
    /// From the baseline.
    Baseline {
        level: f64,
        /// First of the records that make the baseline; none where it is fixed.
        since: Option<UtcMicros>,
        now: f64,
    },
    /// From the level of the closure.
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
    /// A slope, and where it leads.
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
    /// Of the newest cells from the level of those before.
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
    /// Of the differences between records that follow one another.
    RmsSuccessive {
        since: UtcMicros,
        /// The part that the stations' standard deviations explain, where they are known.
        explained: Option<f64>,
    },
    /// From before a test to after it.
    BeforeAfter {
        before: (UtcMicros, f64),
        /// The test.
        from: UtcMicros,
        until: UtcMicros,
        now: f64,
    },
    /// Newest calibrations by one station, or of one batch, from their baselines.
    GroupShift {
        gyros: usize,
        imus: usize,
        /// First and last of them.
        since: UtcMicros,
        until: UtcMicros,
        /// The median.
        shift: f64,
    },
    /// Gyros of an IMU, all of which have moved.
    ImuShift { gyros: usize },
    /// The gyro of the campaign that is furthest from its forecast.
    Forecast {
        slot: Slot,
        /// Its dwell that is, with the error over its standard deviation.
        furthest: Option<(usize, f64)>,
        /// Of errors as large, over all gyros.
        p: f64,
        /// Of D_I or D_S, the smallest that would show in every gyro, deg/(h g0); none where none would.
        step: Option<f64>,
        /// That the model was fitted to.
        campaigns: usize,
        unseen: Option<Unseen>,
    },
    /// Between results of all methods.
    Agreement { results: usize, lowest: (FigureSource, UtcMicros, f64), highest: (FigureSource, UtcMicros, f64) },
    /// pulse/arcsec or pulse/(s g0).
    Requirement {
        figure: &'static str,
        low: f64,
        high: f64,
        /// Other figures that lie outside.
        others: [Option<&'static str>; MOST_FIGURES - 1],
    },
    /// Days.
    Overdue { last: UtcMicros },
}

named! {
/// What of a campaign, or of most of its dwells, the model has not seen: the notes of the forecast.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Unseen("unseen_") {
    Temperature = "temperature_outside_model",
    Rate = "rate_outside_model",
    Attitudes = "attitudes_outside_model",
    Before = "campaign_before_model",
    Effect = "effect_not_foretold",
    Station = "effect_of_other_station",
}
}

impl Unseen {
    /// Whether it is of single dwells, and the others may be judged.
    pub fn is_of_dwells(self) -> bool {
        matches!(self, Unseen::Temperature | Unseen::Rate | Unseen::Attitudes)
    }
}

/// Where a figure comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FigureSource {
    /// Separated from a calibration of the IMU.
    Separation,
    Bench(BenchMethod),
}

impl FigureSource {
    /// What people read.
    pub fn word(self) -> Message {
        match self {
            FigureSource::Separation => message!("method_separation"),
            FigureSource::Bench(method) => method.word(),
        }
    }
}

/// Most figures of one verdict: |E| and its components.
pub const MOST_FIGURES: usize = 4;
