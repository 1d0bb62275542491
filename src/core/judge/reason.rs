//! Reasons in words that stand up in a review board: the result, then the number, then what it was compared with.

use std::fmt::{self, Display, Formatter, Write as _};

use super::decimal::Decimal;
use super::rules::Source;
use super::{Finding, Rule, State, Status, Verdict};
use crate::core::time::UtcMicros;
use crate::core::units::degrees;

impl Verdict {
    /// Why the verdict is what it is, in a few short sentences.
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
        if self.value.is_none() {
            return Ok(());
        }
        self.write_limit(f)?;
        if self.confirmed {
            f.write_str(match self.rule {
                Rule::Range | Rule::Agreement => " Not due to a single result.",
                _ => " Confirmed by a second campaign.",
            })?;
        }
        self.write_certainty(f)
    }
}

/// Decimals that show a hundredth of the limit.
pub fn digits(limit: f64) -> usize {
    if limit == 0.0 { 6 } else { (2.0 - limit.abs().log10().floor()).clamp(0.0, 12.0) as usize }
}

/// As many decimals as the limit, and more where they would not show the standard deviation.
pub fn sd_digits(sd: f64, limit: f64) -> usize {
    let one = if sd > 0.0 { (-sd.log10().floor()).clamp(0.0, 12.0) as usize } else { 0 };
    digits(limit).max(one)
}

impl Verdict {
    fn write_finding(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (name, p) = (self.coefficient.name(), digits(self.limit));
        match self.finding {
            Finding::TooFew { have, need } => {
                let what = match self.rule {
                    Rule::Agreement => "results",
                    Rule::Shift | Rule::Trend => "weeks with records",
                    _ => "records",
                };
                write!(f, "{name}: not enough data for {}. It needs {need} {what} and has {have}.", self.rule.name())
            }
            Finding::FewWithin { have, need, days } => {
                write!(f, "{name}: not enough data for {}. ", self.rule.name())?;
                write!(f, "It needs {need} results within {days} days and has {have}.")
            }
            Finding::Moved { since, have, need } => {
                write!(f, "{name}: the gyro was moved to another IMU or slot before {}. ", since.date())?;
                write!(f, "Its level there needs {need} records and has {have}.")
            }
            Finding::Step { level, now } => {
                self.write_departure(f, now - level)?;
                write!(f, " the records before (median {:.p$}).", Decimal(level))
            }
            Finding::Range { records, since, lowest, highest } => {
                write!(f, "{name} spans ")?;
                self.write_value(f)?;
                write!(f, " over {records} records since {}: ", since.date())?;
                write!(f, "{:.p$} on {} ", Decimal(lowest.1), lowest.0.date())?;
                write!(f, "and {:.p$} on {}.", Decimal(highest.1), highest.0.date())
            }
            Finding::Baseline { level, since, now } => {
                self.write_departure(f, now - level)?;
                write!(f, " its baseline {:.p$}", Decimal(level))?;
                write_origin(f, since)
            }
            Finding::Closure { level, since, moved, now, d_s } => {
                self.write_departure(f, now - level)?;
                write!(f, " its baseline {:.p$}", Decimal(level))?;
                write_origin(f, since)?;
                if moved {
                    f.write_str(" That level began when the gyro was moved to another IMU or slot.")?;
                }
                if let Some(turn) = turn_arcmin(now - level, d_s) {
                    write!(f, " A turn of {turn:+.1} arcmin about the input axis does the same.")?;
                }
                // What lies within its limit is not said to have a cause.
                f.write_str(match self.state {
                    State::Exceeded => " Likely the mounting or an output-axis term, not D_I or D_S.",
                    State::Within | State::Indeterminate => "",
                })
            }
            Finding::NoTrend { cells, since, step } => {
                write!(f, "{name}: no trend in the {cells} weekly means since {}", since.date())?;
                match step {
                    Some(at) => write!(f, "; a step on {} fits better.", at.date()),
                    None => f.write_str("."),
                }
            }
            Finding::Trend { .. } => self.write_trend(f),
            Finding::Shift { level, before, since, now, .. } => {
                write!(f, "{name}: the newest three weekly means, since {}, are ", since.date())?;
                self.write_value(f)?;
                let side = if now >= level { "above" } else { "below" };
                write!(f, " {side} the level {:.p$} of the {before} before.", Decimal(level))
            }
            Finding::RmsSuccessive { since, explained } => {
                write!(f, "{name}: the rms of successive differences since {} is ", since.date())?;
                self.write_value(f)?;
                f.write_str(", without the most deviating record.")?;
                let Some(explained) = explained else { return Ok(()) };
                write!(f, " Stated standard deviations explain {:.p$}.", Decimal(explained))
            }
            Finding::BeforeAfter { before, from, until, now } => {
                self.write_departure(f, now - before.1)?;
                write!(
                    f,
                    " its last record before the environmental test ({:.p$} on {}). ",
                    Decimal(before.1),
                    before.0.date()
                )?;
                write!(f, "The test took from {} to {}.", from.date(), until.date())
            }
            Finding::Agreement { results, lowest, highest } => {
                let of = |(source, at, result): (Source, UtcMicros, f64)| {
                    format!("{:.p$} ({} on {})", Decimal(result), source.name(), at.date())
                };
                write!(f, "{name} spans ")?;
                self.write_value(f)?;
                write!(f, " over {results} results: {} and {}.", of(lowest), of(highest))
            }
            Finding::Requirement { figure, low, high, others } => {
                let value = self.value.unwrap_or(0.0);
                let place = if (low..=high).contains(&value) { "inside" } else { "outside" };
                write!(f, "{figure} = ")?;
                self.write_value(f)?;
                write!(f, " is {place} {:.p$} to {:.p$}.", Decimal(low), Decimal(high))?;
                for (k, other) in others.iter().flatten().enumerate() {
                    write!(f, "{}{other}", if k == 0 { " Also outside: " } else { ", " })?;
                }
                f.write_str(if others[0].is_some() { "." } else { "" })
            }
            Finding::Overdue { last } => {
                write!(f, "Last calibrated on {}, {:.1} days ago.", last.date(), Decimal(self.value.unwrap_or(0.0)))
            }
        }
    }

    fn write_trend(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Finding::Trend { cells, since, until, per_year, deviation, horizon_days, reach, provisional, of_fleet } =
            self.finding
        else {
            return Ok(());
        };
        let (name, p, unit) = (self.coefficient.name(), digits(self.limit), self.unit());
        let sd = per_year.sd.unwrap_or(0.0);
        write!(f, "{name} drifts by {:+.p$} +- {:.p$} {unit} a year ", Decimal(per_year.value), Decimal(sd))?;
        write!(f, "({cells} weekly means from {} to {}). ", since.date(), until.date())?;
        // Whoever reads this may do so long after: no date is said to lie ahead.
        match reach {
            [_, Some(middle), _] if middle <= until => f.write_str("It has passed its budget. ")?,
            [Some(first), Some(middle), last] => {
                write!(f, "It reaches its budget about {} (95 %: {} to ", middle.date(), first.date())?;
                match last {
                    Some(last) => write!(f, "{}). ", last.date())?,
                    None => f.write_str("never). ")?,
                }
            }
            _ => {}
        }
        write!(f, "Its deviation from the baseline is {:+.p$} and will be ", Decimal(deviation))?;
        self.write_value(f)?;
        write!(f, " after {horizon_days:.0} days.")?;
        if provisional {
            f.write_str(" Dates are provisional: the course is younger than 24 weekly means.")?;
        }
        if !of_fleet {
            f.write_str(" The noise constants are defaults, not the fleet's.")?;
        }
        Ok(())
    }

    /// `D_I is 0.0251 +- 0.0007 deg/(h g0) above`.
    fn write_departure(&self, f: &mut Formatter<'_>, difference: f64) -> fmt::Result {
        write!(f, "{} is ", self.coefficient.name())?;
        self.write_value(f)?;
        f.write_str(if difference < 0.0 { " below" } else { " above" })
    }

    fn write_value(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let p = digits(self.limit);
        write!(f, "{:.p$}", Decimal(self.value.unwrap_or(0.0)))?;
        if let Some(sd) = self.sd {
            let p = sd_digits(sd, self.limit);
            write!(f, " +- {:.p$}", Decimal(sd))?;
        }
        write!(f, " {}", self.unit())
    }

    fn write_limit(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let p = digits(self.limit);
        let limit = Decimal(self.limit);
        match self.finding {
            // Its bounds were named.
            Finding::Requirement { .. } => write!(f, " Limits from {}.", self.limit_from),
            Finding::Shift { least, .. } if self.limit > least => {
                write!(f, " Limit {limit:.p$} {} (three standard deviations; least {})", self.unit(), self.limit_from)?;
                f.write_str(".")
            }
            _ => {
                write!(f, " Limit {limit:.p$} {} ({})", self.unit(), self.limit_from)?;
                let percent = 100.0 * self.value.unwrap_or(0.0) / self.limit;
                if self.state == State::Exceeded && percent < 1e5 {
                    write!(f, ": {percent:.0} %")?;
                }
                f.write_str(".")
            }
        }
    }

    fn write_certainty(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let by_clock_or_chart = matches!(self.rule, Rule::Shift | Rule::Trend | Rule::Overdue | Rule::Cusum);
        match (self.status(), self.sd, self.probability) {
            (Status::TooUncertain, ..) if self.rule == Rule::Shift => {
                f.write_str(" Too uncertain to judge: three standard deviations are more than the budget.")
            }
            (Status::TooUncertain, Some(sd), _) => {
                let p = sd_digits(sd, self.limit);
                let limit = Decimal(self.limit);
                write!(
                    f,
                    " Too uncertain to judge: standard deviation {:.p$} against a limit of {limit:.p$}.",
                    Decimal(sd)
                )
            }
            (_, _, Some(probability)) => {
                f.write_str(" P(out of tolerance) ")?;
                write_percent(f, probability)?;
                f.write_str(".")
            }
            (_, None, None) if !by_clock_or_chart => {
                f.write_str(" No standard deviation is known: compared as it stands.")
            }
            _ => Ok(()),
        }
    }
}

fn write_origin(f: &mut Formatter<'_>, since: Option<UtcMicros>) -> fmt::Result {
    match since {
        Some(at) => write!(f, " (median of three records from {}).", at.date()),
        None => f.write_str(" (fixed)."),
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
        p if p > 0.999 => f.write_str("> 99.9 %"),
        p if p < 0.001 => f.write_str("< 0.1 %"),
        p => write!(f, "= {:.1} %", 100.0 * p),
    }
}
