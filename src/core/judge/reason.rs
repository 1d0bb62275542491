//! Reasons in words that stand up in a review board: what was compared with what, on which dates, how certain.

use std::fmt::{self, Display, Formatter, Write as _};

use super::decimal::Decimal;
use super::rules::Source;
use super::{Coefficient, Rule, State, Verdict};
use crate::core::time::UtcMicros;
use crate::core::units::degrees;

/// What a rule saw. Values in deg/(h g0) unless said otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finding {
    /// Not enough records since the last event that resets the rule.
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
    Step {
        since: UtcMicros,
        before: f64,
        now: f64,
        /// The level before an earlier step that this record confirms.
        confirms: Option<(UtcMicros, f64)>,
    },
    Range {
        records: usize,
        days: f64,
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
        now: f64,
        /// D_S, where the closure is D_O: what a turn of the spin axis would have moved it by, per radian.
        d_s: Option<f64>,
    },
    /// No slope is established.
    NoTrend {
        records: usize,
        since: UtcMicros,
        /// Where a change of level explains the records better.
        step: Option<UtcMicros>,
    },
    Trend {
        records: usize,
        since: UtcMicros,
        /// The judged record, from which the slope is carried on.
        until: UtcMicros,
        /// Slope and its interval: low, median, high, deg/(h g0) a day.
        per_day: [f64; 3],
        /// From the baseline, at `until`.
        deviation: f64,
        horizon_days: f64,
        /// When the budget is reached, by the steepest, the median and the shallowest slope of the interval; `until` where it has
        /// been passed already.
        reach: [UtcMicros; 3],
    },
    /// Sums in standard deviations.
    Cusum {
        records: usize,
        onset: UtcMicros,
        upward: bool,
        records_per_false_alarm: f64,
    },
    RmsSuccessive {
        since: UtcMicros,
        /// The part that the stations' standard deviations explain, where they are known.
        explained: Option<f64>,
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
        others_outside: usize,
    },
    /// Days.
    Overdue {
        last: UtcMicros,
    },
}

impl Verdict {
    /// Why the verdict is what it is, in one or two sentences.
    pub fn reason(&self) -> String {
        // Room for nearly all of them: growing piece by piece costs more than the words.
        let mut words = String::with_capacity(256);
        write!(words, "{self}").expect("writing to a string cannot fail");
        words
    }
}

impl Display for Verdict {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.write_finding(f)?;
        if matches!(self.finding, Finding::TooFew { .. } | Finding::FewWithin { .. }) {
            return f.write_str(".");
        }
        write!(f, "; the limit is {:.*} {}.", digits(self.limit), Decimal(self.limit), self.unit())?;
        self.write_certainty(f)?;
        if self.confirmed {
            f.write_str(match self.rule {
                Rule::Range | Rule::Agreement => {
                    " No single one is to blame: without the highest or the lowest it is exceeded too."
                }
                _ => " A second campaign confirms it.",
            })?;
        }
        Ok(())
    }
}

/// Decimals that show a thousandth of the limit.
fn digits(limit: f64) -> usize {
    if limit == 0.0 { 6 } else { (3.0 - limit.abs().log10().floor()).clamp(0.0, 12.0) as usize }
}

/// As many decimals as the limit, and more where they would show less than two digits of the standard deviation.
fn sd_digits(sd: f64, limit: f64) -> usize {
    let two = if sd > 0.0 { (1.0 - sd.log10().floor()).clamp(0.0, 12.0) as usize } else { 0 };
    digits(limit).max(two)
}

impl Verdict {
    /// Unit of the value and the limit.
    pub fn unit(&self) -> &'static str {
        match (self.rule, self.coefficient) {
            (Rule::Overdue, _) => "days",
            (Rule::Cusum, _) => "standard deviations",
            (Rule::Requirement, Coefficient::E) => "pulse/arcsec",
            (Rule::Requirement, _) => "pulse/(s g0)",
            _ => "deg/(h g0)",
        }
    }

    fn write_finding(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (name, p) = (self.coefficient.name(), digits(self.limit));
        let value = Decimal(self.value.unwrap_or(0.0));
        match self.finding {
            Finding::TooFew { have, need } => {
                let what = if self.rule == Rule::Agreement { "results" } else { "records" };
                let are = if have == 1 { "is" } else { "are" };
                write!(f, "{name}: the rule {} needs {need} {what}, {have} {are} there", self.rule.name())
            }
            Finding::FewWithin { have, need, days } => {
                let are = if have == 1 { "is" } else { "are" };
                write!(
                    f,
                    "{name}: the rule {} needs {need} results within {days} days, {have} {are} there",
                    self.rule.name()
                )
            }
            Finding::Step { since, before, now, confirms } => {
                let (step, before, date) = (Decimal(now - before), Decimal(before), since.date());
                let shown = Decimal(now);
                write!(f, "{name} changed by {step:+.p$} from {before:.p$} on {date} to {shown:.p$}")?;
                let Some((at, level)) = confirms else { return Ok(()) };
                write!(f, " and lies {:+.p$} from {:.p$} on {}", Decimal(now - level), Decimal(level), at.date())
            }
            Finding::Range { records, days, lowest, highest } => {
                write!(f, "{name} spans {value:.p$} over {records} records of {days} days, ")?;
                write!(f, "from {:.p$} on {} ", Decimal(lowest.1), lowest.0.date())?;
                write!(f, "to {:.p$} on {}", Decimal(highest.1), highest.0.date())
            }
            Finding::Baseline { level, since, now } => {
                write!(f, "{name} lies {:+.p$} from its baseline {:.p$}", Decimal(now - level), Decimal(level))?;
                write_origin(f, since)
            }
            Finding::Closure { level, since, now, d_s } => {
                let moved = Decimal(now - level);
                write!(f, "The closure {name} moved by {moved:+.p$} from its baseline {:.p$}", Decimal(level))?;
                write_origin(f, since)?;
                if let Some(turn) = turn_arcmin(now - level, d_s) {
                    write!(f, ", as a turn of {turn:+.1} arcmin about the input axis would")?;
                }
                // What lies within its limit is not said to have a cause.
                f.write_str(match self.state {
                    State::Exceeded => ": mounting, or an output-axis term, rather than D_I or D_S",
                    State::Within | State::Indeterminate => "",
                })
            }
            Finding::NoTrend { records, since, step } => {
                write!(f, "{name}: the {records} records since {} establish no slope", since.date())?;
                let Some(at) = step else { return Ok(()) };
                write!(f, " (a change of level on {} explains them better)", at.date())
            }
            Finding::Trend { records, since, until, per_day, deviation, horizon_days, reach } => {
                let deviation = Decimal(deviation);
                let [low, slope, high] = per_day.map(|per_day| Decimal(per_day * 365.25));
                write!(
                    f,
                    "{name} drifts by {slope:+.p$} a year ({low:+.p$} to {high:+.p$}) over the {records} records "
                )?;
                write!(
                    f,
                    "from {} to {}, when it lay {deviation:+.p$} from its baseline; ",
                    since.date(),
                    until.date()
                )?;
                // Whoever reads this may do so long after: no date is said to lie ahead.
                if reach[1] <= until {
                    write!(f, "it has passed the budget, and carried on from there it would ")?;
                } else {
                    let [first, middle, last] = reach.map(UtcMicros::date);
                    write!(
                        f,
                        "carried on from there it would reach the budget about {middle} ({first} to {last}), and "
                    )?;
                }
                write!(f, "lie {value:.p$} off after {horizon_days:.0} days")
            }
            Finding::Cusum { records, onset, upward, records_per_false_alarm } => {
                let side = if upward { "above" } else { "below" };
                write!(f, "{name} has lain {side} its level for {records} records, since {}: ", onset.date())?;
                write!(
                    f,
                    "the cumulative sum is {value:.p$} standard deviations, and a stable gyro passes the limit "
                )?;
                write!(f, "once in {records_per_false_alarm} records")
            }
            Finding::RmsSuccessive { since, explained } => {
                write!(
                    f,
                    "{name}: the root mean square of successive differences since {} is {value:.p$}",
                    since.date()
                )?;
                let Some(explained) = explained else { return Ok(()) };
                write!(f, ", of which the campaigns' standard deviations explain {:.p$}", Decimal(explained))
            }
            Finding::Agreement { results, lowest, highest } => {
                let of = |(source, at, result): (Source, UtcMicros, f64)| {
                    format!("{:.p$} ({} on {})", Decimal(result), source.name(), at.date())
                };
                write!(f, "{name} spans {value:.p$} over {results} results, from {} to {}", of(lowest), of(highest))
            }
            Finding::Requirement { figure, low, high, others_outside } => {
                let where_it_lies = if (low..=high).contains(&value.0) { "lies within" } else { "lies outside" };
                write!(f, "{figure} = {value:.p$} {where_it_lies} {:.p$} to {:.p$}", Decimal(low), Decimal(high))?;
                match others_outside {
                    0 => Ok(()),
                    1 => write!(f, ", and so does 1 more figure of {name}"),
                    n => write!(f, ", and so do {n} more figures of {name}"),
                }
            }
            Finding::Overdue { last } => write!(f, "Last calibrated on {}, {value:.1} days ago", last.date()),
        }
    }

    fn write_certainty(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match (self.sd, self.probability) {
            (Some(sd), Some(probability)) => {
                let p = sd_digits(sd, self.limit);
                write!(f, " With a standard deviation of {:.p$} the true value ", Decimal(sd))?;
                // What is required has a lower limit too.
                f.write_str(if self.rule == Rule::Requirement { "lies beyond it" } else { "exceeds it" })?;
                f.write_str(" with a probability of ")?;
                write_percent(f, probability)?;
                f.write_str(if self.state == State::Indeterminate {
                    ": the uncertainty straddles the limit."
                } else {
                    "."
                })
            }
            _ if matches!(self.rule, Rule::Cusum | Rule::Trend | Rule::Overdue) => Ok(()),
            _ => f.write_str(" No standard deviation is known: the figures are compared as they stand."),
        }
    }
}

fn write_origin(f: &mut Formatter<'_>, since: Option<UtcMicros>) -> fmt::Result {
    match since {
        Some(at) => write!(f, " (mean of the first records from {})", at.date()),
        None => f.write_str(" (fixed)"),
    }
}

/// Five degrees: far beyond any seat.
const LARGEST_TURN_ARCMIN: f64 = 300.0;

/// The turn of the spin axis about the input axis that moves D_O by as much, arc minutes: D_O moves by D_S psi when it turns by psi.
/// None where it would not show, and where no mount turns as far: then it is no turn.
pub fn turn_arcmin(moved: f64, d_s: Option<f64>) -> Option<f64> {
    d_s.map(|d_s| degrees((moved / d_s).atan()) * 60.0)
        .filter(|turn| (0.05..=LARGEST_TURN_ARCMIN).contains(&turn.abs()))
}

fn write_percent(f: &mut Formatter<'_>, probability: f64) -> fmt::Result {
    match probability {
        p if p > 0.999 => f.write_str("more than 99.9 %"),
        p if p < 0.001 => f.write_str("less than 0.1 %"),
        p => write!(f, "{:.1} %", 100.0 * p),
    }
}
