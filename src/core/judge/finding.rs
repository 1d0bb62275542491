//! What each rule saw, and what is to be said of it.

use super::history::Measured;
use super::reason::{digits, turn_arcmin};
use super::rules::{MOST_FIGURES, Source};
use super::{Rule, State, Verdict};
use crate::core::message::{Message, Parameter, figure, list, signed, text};
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
        /// When the budget is reached: by the early edge of the 95 % band, by the line, by the late edge; `until` where it has been passed
        /// already, none where it never is.
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

/// The side of a level on which a figure is.
fn side(difference: f64) -> &'static str {
    if difference < 0.0 { "below" } else { "above" }
}

/// What makes a baseline.
fn origin(since: Option<UtcMicros>) -> Message {
    match since {
        Some(at) => message!("level_from", since = text(at.date())),
        None => message!("level_fixed"),
    }
}

impl Verdict {
    /// What the rule saw, by code: a first sentence, and what there is to add.
    pub(super) fn finding_messages(&self) -> Vec<Message> {
        let name = self.coefficient.name();
        let shown = |value: f64| figure(value, digits(self.limit));
        let day = |at: UtcMicros| text(at.date());
        let value = || self.measured();
        match self.finding {
            Finding::TooFew { have, need } => {
                let of = match self.rule {
                    Rule::Agreement => "results",
                    Rule::Shift | Rule::Trend => "weeks",
                    _ => "records",
                };
                vec![message!("too_few", name = name, rule = self.rule.word(), need = need, have = have, of = of)]
            }
            Finding::FewWithin { have, need, days } => vec![message!(
                "too_few_within",
                name = name,
                rule = self.rule.word(),
                need = need,
                have = have,
                days = text(days),
            )],
            Finding::Moved { since, have, need } => {
                vec![message!("too_few_since_moved", name = name, since = day(since), need = need, have = have)]
            }
            Finding::Step { level, now } => {
                let side = side(now - level);
                vec![message!("step", name = name, value = value(), side = side, level = shown(level))]
            }
            Finding::Range { records, since, lowest, highest } => vec![message!(
                "range",
                name = name,
                value = value(),
                records = records,
                since = day(since),
                lowest = shown(lowest.1),
                lowest_at = day(lowest.0),
                highest = shown(highest.1),
                highest_at = day(highest.0),
            )],
            Finding::Baseline { level, since, now } => vec![message!(
                "baseline",
                name = name,
                value = value(),
                side = side(now - level),
                level = shown(level),
                origin = origin(since),
            )],
            Finding::Closure { level, since, moved, now, d_s } => {
                let mut said = vec![message!(
                    "closure",
                    name = name,
                    value = value(),
                    side = side(now - level),
                    level = shown(level),
                    origin = origin(since),
                )];
                said.extend(moved.then(|| message!("closure_moved")));
                let turn = turn_arcmin(now - level, d_s);
                said.extend(turn.map(|turn| message!("closure_turn", turn = signed(turn, 1))));
                // What is not beyond its limit is not said to have a cause.
                said.extend((self.state == State::Exceeded).then(|| message!("closure_cause")));
                said
            }
            Finding::NoTrend { step: None, .. } => vec![message!("no_trend")],
            Finding::NoTrend { step: Some(_), .. } => vec![message!("no_trend_but_step")],
            Finding::Trend { .. } => self.trend_messages(),
            Finding::Shift { level, before, since, now, .. } => vec![message!(
                "shift",
                name = name,
                since = day(since),
                value = value(),
                side = side(now - level),
                level = shown(level),
                before = before,
            )],
            Finding::RmsSuccessive { since, explained } => {
                let mut said = vec![message!("rms_successive", name = name, since = day(since), value = value())];
                said.extend(explained.map(|explained| message!("rms_explained", explained = shown(explained))));
                said
            }
            Finding::BeforeAfter { before, from, until, now } => vec![message!(
                "before_after",
                name = name,
                value = value(),
                side = side(now - before.1),
                level = shown(before.1),
                at = day(before.0),
                from = day(from),
                until = day(until),
            )],
            Finding::Agreement { results, lowest, highest } => {
                let of = |(source, at, result): (Source, UtcMicros, f64)| {
                    message!("result_of_method", value = shown(result), method = source.word(), at = day(at))
                };
                vec![message!(
                    "agreement",
                    name = name,
                    value = value(),
                    results = results,
                    lowest = of(lowest),
                    highest = of(highest),
                )]
            }
            Finding::Requirement { figure, low, high, others } => {
                let inside = self.value.is_some_and(|value| (low..=high).contains(&value));
                let place = if inside { "inside" } else { "outside" };
                let (low, high) = (shown(low), shown(high));
                let mut said = vec![message!(
                    "requirement",
                    figure = figure,
                    value = value(),
                    place = place,
                    low = low,
                    high = high
                )];
                let others: Vec<&str> = others.into_iter().flatten().collect();
                said.extend((!others.is_empty()).then(|| message!("requirement_others", figures = list(others))));
                said
            }
            Finding::Overdue { last } => {
                vec![message!("overdue", last = day(last), days = figure(self.value.unwrap_or(0.0), 1))]
            }
        }
    }

    fn trend_messages(&self) -> Vec<Message> {
        let Finding::Trend { cells, since, until, per_year, deviation, horizon_days, reach, provisional, of_fleet } =
            self.finding
        else {
            return Vec::new();
        };
        let (p, day) = (digits(self.limit), |at: UtcMicros| text(at.date()));
        let rate = message!(
            "measured_with_sd",
            value = signed(per_year.value, p),
            sd = figure(per_year.sd.unwrap_or(0.0), p),
            unit = self.unit().word(),
        );
        let name = self.coefficient.name();
        let (from, to) = (day(since), day(until));
        let mut said = vec![message!("trend", name = name, rate = rate, cells = cells, since = from, until = to)];
        // This is read long after too: no date is said to be still to come.
        match reach {
            [_, Some(middle), _] if middle <= until => said.push(message!("trend_passed")),
            [Some(first), Some(middle), last] => {
                let last = last.map_or_else(|| Parameter::from(message!("never")), day);
                said.push(message!("trend_reaches", at = day(middle), first = day(first), last = last));
            }
            _ => {}
        }
        let (deviation, days) = (signed(deviation, p), figure(horizon_days, 0));
        said.push(message!("trend_ahead", deviation = deviation, value = self.measured(), days = days));
        said.extend(provisional.then(|| message!("trend_provisional")));
        said.extend((!of_fleet).then(|| message!("trend_default_noise")));
        said
    }
}
