//! How the blind checks show their progress and their proportions.

use indicatif::ProgressBar;

use crate::blindcheck::tally::Tally;
use crate::cli::common;
use crate::cli::prelude::*;

pub(super) fn progress(count: usize, of: &str) -> ProgressBar {
    common::progress(count as u64, &format!("{{bar:40}} {{pos}}/{{len}} {of}, {{eta}} left"))
}

pub(super) fn figures(tally: &Tally) -> [String; 4] {
    let interval =
        tally.interval().map(|[from, to]| said(message!("terminal_to", from = percent(from), to = percent(to))));
    let rate = tally.rate().map(percent).unwrap_or_default();
    [tally.hits.to_string(), tally.trials.to_string(), rate, interval.unwrap_or_default()]
}

/// What is to be reached, and whether it is.
pub(super) fn target(at_least: Option<f64>, at_most: Option<f64>, reached: Option<bool>) -> [String; 2] {
    let goal = at_least.map(|share| format!(">= {}", percent(share)));
    let goal = goal.or_else(|| at_most.map(|share| format!("<= {}", percent(share))));
    let mark = reached.map_or("", |reached| word(if reached { "terminal_reached" } else { "terminal_short_of_it" }));
    [goal.unwrap_or_default(), mark.to_owned()]
}

/// With `strict`, what has not been reached is an error.
pub(super) fn demand(strict: bool, reached: bool) -> anyhow::Result<()> {
    if strict && !reached {
        bail!(word("terminal_not_reached"));
    }
    Ok(())
}

pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
