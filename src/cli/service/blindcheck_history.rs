//! `gyrowatch blindcheck history`: how well are histories diagnosed whose cause is hidden?

use std::time::Instant;

use anyhow::Error;

use super::blindcheck_service::ask;
use super::tallies::{demand, figures, progress, target};
use crate::blindcheck::history::draw::{DrawnFleet, HiddenCause};
use crate::blindcheck::history::report::{HistoryRate, HistoryReport};
use crate::blindcheck::history::run;
use crate::blindcheck::history::speed::{Speed, measure};
use crate::cli::common::one_of;
use crate::cli::errors::with_causes;
use crate::cli::prelude::*;

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
    one_of(HiddenCause::from_name(text), HiddenCause::ALL.map(HiddenCause::name))
}

fn kinds_help() -> String {
    format!("Only these kinds; all where left out: {}", HiddenCause::ALL.map(HiddenCause::name).join(", "))
}

impl History {
    pub fn run(self) -> anyhow::Result<()> {
        if let Some(gyros) = self.speed {
            let speed = measure(self.seed, gyros);
            return self.format.show(&speed, || shown(&speed));
        }
        let kinds = if self.kind.is_empty() { HiddenCause::ALL.to_vec() } else { self.kind.clone() };
        let bar = progress(kinds.len() * self.count as usize, "fleets");
        let begun = Instant::now();
        let services = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
        let answers = |fleet: &DrawnFleet| services.block_on(ask(fleet)).map_err(|error| with_causes(&error));
        let scores = run(self.seed, self.count as usize, &kinds, &answers, &|| bar.inc(1)).map_err(Error::msg)?;
        bar.finish_and_clear();
        let report = HistoryReport::of(self.seed, &scores);
        self.format.show(&report, || tables(&report, begun.elapsed().as_secs_f64()))?;
        demand(self.strict, report.reached())
    }
}

fn shown(speed: &Speed) -> String {
    let &Speed { gyros, records, threads, fleet_s, of_one, one_ms, slowest_ms } = speed;
    let [fleet_s, one_ms, slowest_ms] = [fleet_s, one_ms, slowest_ms].map(|time| format!("{time:.1}"));
    said(message!("terminal_speed", gyros, records, threads, fleet_s, of_one, one_ms, slowest_ms))
}

fn tables(report: &HistoryReport, seconds: f64) -> String {
    let mut rows = table_of("terminal_fleet_goals_head", 1..4);
    for HistoryRate { what, tally, at_least, at_most, reached } in &report.rows {
        let [goal, mark] = target(*at_least, *at_most, *reached);
        let [hits, trials, rate, interval] = figures(tally);
        rows.add_row([what.clone(), hits, trials, rate, interval, goal, mark]);
    }
    let mut confusion = table_of("terminal_named_instead_head", 0..0);
    for (kind, named) in &report.confusion {
        let counts: Vec<String> = named.iter().map(|(name, count)| format!("{name} {count}")).collect();
        confusion.add_row([(*kind).to_owned(), counts.join(", ")]);
    }
    let (fleets, seed, seconds) = (report.fleets, report.seed.to_string(), format!("{seconds:.1}"));
    format!("{}\n\n{rows}\n\n{confusion}", said(message!("terminal_blind_fleets", fleets, seed, seconds)))
}
