//! How the blind checks show their progress and their proportions.

use indicatif::{ProgressBar, ProgressStyle};

use crate::blindcheck::tally::Tally;

pub(super) fn progress(count: usize, of: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(&format!("{{bar:40}} {{pos}}/{{len}} {of}, {{eta}} left"));
    let bar = ProgressBar::new(count as u64);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

pub(super) fn figures(tally: &Tally) -> [String; 4] {
    let interval = tally.interval().map(|[low, high]| format!("{} to {}", percent(low), percent(high)));
    let rate = tally.rate().map(percent).unwrap_or_default();
    [tally.hits.to_string(), tally.trials.to_string(), rate, interval.unwrap_or_default()]
}

pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
