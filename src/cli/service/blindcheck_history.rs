//! `gyrowatch blindcheck history`: how well are histories diagnosed whose cause is hidden?

use std::time::Instant;

use anyhow::{Error, bail};
use clap::Args;

use super::blindcheck_service::ask;
use super::tallies::{figures, percent, progress};
use crate::blindcheck::history::draw::{DrawnFleet, HiddenCause};
use crate::blindcheck::history::report::{HistoryRate, HistoryReport};
use crate::blindcheck::history::run;
use crate::blindcheck::history::speed::{Speed, measure};
use crate::cli::document::{Format, print, print_json, table};
use crate::cli::errors::{said, with_causes};
use crate::message;

/// Draw fleets with a hidden cause, send each to a service of its own, score what it answers of every gyro
///
/// A fleet is five to eight IMUs of three gyros with 20 to 30 records each. One coefficient of one gyro, or a station,
/// has the cause; everything else has none.
#[derive(Debug, Args)]
pub struct History {
    /// Fleets of each kind.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    count: u32,
    /// Other seeds draw other fleets.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[arg(long, value_delimiter = ',', value_parser = kind, help = kinds_help())]
    kind: Vec<HiddenCause>,
    /// Instead: how long the diagnosis of so many gyros takes on all threads, and that of one with 1,000 records.
    #[arg(long, value_name = "GYROS", conflicts_with_all = ["count", "kind", "strict"])]
    speed: Option<usize>,
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    /// End with exit status 1 where a figure to be reached is not.
    #[arg(long)]
    strict: bool,
}

fn kind(text: &str) -> Result<HiddenCause, String> {
    HiddenCause::from_name(text)
        .ok_or_else(|| format!("kinds are {}", HiddenCause::ALL.map(HiddenCause::name).join(", ")))
}

fn kinds_help() -> String {
    format!("Only these kinds; all where left out: {}", HiddenCause::ALL.map(HiddenCause::name).join(", "))
}

impl History {
    pub fn run(self) -> anyhow::Result<()> {
        if let Some(gyros) = self.speed {
            let speed = measure(self.seed, gyros);
            return match self.format {
                Format::Json => print_json(&speed),
                Format::Table => print(&shown(&speed)),
            };
        }
        let kinds = if self.kind.is_empty() { HiddenCause::ALL.to_vec() } else { self.kind.clone() };
        let bar = progress(kinds.len() * self.count as usize, "fleets");
        let begun = Instant::now();
        let services = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
        let answers = |fleet: &DrawnFleet| services.block_on(ask(fleet)).map_err(|error| with_causes(&error));
        let scores = run(self.seed, self.count as usize, &kinds, &answers, &|| bar.inc(1)).map_err(Error::msg)?;
        bar.finish_and_clear();
        let report = HistoryReport::of(self.seed, &scores);
        match self.format {
            Format::Json => print_json(&report)?,
            Format::Table => print(&tables(&report, begun.elapsed().as_secs_f64()))?,
        }
        if self.strict && !report.reached() {
            bail!(said(message!("terminal_not_reached")));
        }
        Ok(())
    }
}

fn shown(speed: &Speed) -> String {
    let Speed { gyros, records, threads, fleet_s, of_one, one_ms, slowest_ms } = speed;
    format!(
        "{gyros} gyros with {records} records in {fleet_s:.1} s on {threads} threads\n\
         one gyro with {of_one} records and 40 peers: {one_ms:.1} ms (median), {slowest_ms:.1} ms (slowest)"
    )
}

fn tables(report: &HistoryReport, seconds: f64) -> String {
    let mut rows = table(["what", "hits", "trials", "rate", "95 % interval", "to reach", ""], 1..4);
    for HistoryRate { what, tally, at_least, at_most, reached } in &report.rows {
        let goal = at_least.map(|share| format!(">= {}", percent(share)));
        let goal = goal.or(at_most.map(|share| format!("<= {}", percent(share)))).unwrap_or_default();
        let mark = reached.map_or("", |reached| if reached { "reached" } else { "NOT REACHED" });
        let [hits, trials, rate, interval] = figures(tally);
        rows.add_row([what.clone(), hits, trials, rate, interval, goal, mark.to_owned()]);
    }
    let mut confusion = table(["hidden", "named instead (- nothing), how often"], 0..0);
    for (kind, named) in &report.confusion {
        let counts: Vec<String> = named.iter().map(|(name, count)| format!("{name} {count}")).collect();
        confusion.add_row([(*kind).to_owned(), counts.join(", ")]);
    }
    format!("{} fleets of seed {}, {seconds:.1} s\n\n{rows}\n\n{confusion}", report.fleets, report.seed)
}
