//! Reasons in words that stand up in a review board: what was compared with what, on which dates, how certain.

use std::fmt::{self, Display, Formatter};

use crate::core::time::UtcMicros;

use super::{State, Verdict};

/// What a rule saw. Values in deg/(h g0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finding {
    /// Not enough records since the last event that resets the rule.
    TooFew {
        have: usize,
        need: usize,
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
}

impl Verdict {
    /// Why the verdict is what it is, in one or two sentences.
    pub fn reason(&self) -> String {
        self.to_string()
    }
}

impl Display for Verdict {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let name = self.coefficient.name();
        let digits = digits(self.limit);
        match self.finding {
            Finding::TooFew { have, need } => {
                write!(f, "{name}: {have} of the {need} records that the rule {} needs are there", self.rule.name())?;
                return f.write_str(".");
            }
            Finding::Step { since, before, now, confirms } => {
                let step = now - before;
                write!(
                    f,
                    "{name} changed by {step:+.digits$} from {before:.digits$} on {} to {now:.digits$}",
                    since.date()
                )?;
                if let Some((at, level)) = confirms {
                    let moved = now - level;
                    write!(f, ", which confirms a change of {moved:+.digits$} from {level:.digits$} on {}", at.date())?;
                }
            }
            Finding::Range { records, days, lowest, highest } => {
                let range = highest.1 - lowest.1;
                write!(f, "{name} spans {range:.digits$} over {records} records of {days} days, ")?;
                write!(f, "from {:.digits$} on {} ", lowest.1, lowest.0.date())?;
                write!(f, "to {:.digits$} on {}", highest.1, highest.0.date())?;
            }
            Finding::Baseline { level, since, now } => {
                let moved = now - level;
                write!(f, "{name} lies {moved:+.digits$} from its baseline {level:.digits$}")?;
                match since {
                    Some(at) => write!(f, " (mean of the first records from {})", at.date())?,
                    None => f.write_str(" (fixed)")?,
                }
            }
        }
        write!(f, "; the limit is {:.digits$} deg/(h g0). ", self.limit)?;
        self.write_conclusion(f, digits)
    }
}

impl Verdict {
    fn write_conclusion(&self, f: &mut Formatter<'_>, digits: usize) -> fmt::Result {
        match (self.sd, self.probability) {
            (Some(sd), Some(probability)) => {
                write!(
                    f,
                    "With a standard deviation of {sd:.digits$} the true value exceeds it with a probability of "
                )?;
                write_percent(f, probability)?;
                if self.state == State::Indeterminate {
                    f.write_str(": the uncertainty straddles the limit")?;
                }
            }
            _ => f.write_str("No standard deviation is known: the figures are compared as they stand")?,
        }
        if self.confirmed {
            f.write_str("; a second campaign confirms it")?;
        }
        f.write_str(".")
    }
}

fn write_percent(f: &mut Formatter<'_>, probability: f64) -> fmt::Result {
    match probability {
        p if p > 0.999 => f.write_str("more than 99.9 %"),
        p if p < 0.001 => f.write_str("less than 0.1 %"),
        p => write!(f, "{:.1} %", 100.0 * p),
    }
}

/// Decimals that show a thousandth of the limit.
fn digits(limit: f64) -> usize {
    if limit > 0.0 { (3.0 - limit.log10().floor()).clamp(1.0, 12.0) as usize } else { 6 }
}
