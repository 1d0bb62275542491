//! `gyrowatch blindcheck`: how well does the diagnosis do on campaigns whose cause is hidden from it?

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, bail};
use clap::Args;
use comfy_table::Table;

use super::document::{Format, print, print_json, table, write, write_all};
use super::tallies::{figures, percent, progress};
use crate::blindcheck::answer::Answer;
use crate::blindcheck::draw::{Case, Draw};
use crate::blindcheck::kind::{KINDS, Kind, KindRow, row};
use crate::blindcheck::report::{Goal, Report};
use crate::blindcheck::run::{Foreign, drawn, file_name, foreign, key, key_text};
use crate::blindcheck::score::Score;
use crate::blindcheck::seal;
use crate::blindcheck::tally::Tally;
use crate::core::augmented::Options;
use crate::core::diagnose::diagnose;
use crate::simulate::cause::{CATALOGUE, listed};
use crate::simulate::truth::Key;
use crate::wire;

/// Draw campaigns with a hidden cause, diagnose them from their file alone, score the answers
///
/// The truth of all campaigns is sealed before the first diagnosis: its SHA-256 is printed first, and with --keep the
/// key whose SHA-256 that is lies in the folder afterwards. With --campaigns and --key the campaigns are somebody
/// else's.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Blindcheck {
    #[command(subcommand)]
    of: Option<Of>,
    /// Number of campaigns to draw.
    #[arg(long, default_value_t = 1000, value_parser = count, conflicts_with = "campaigns")]
    count: usize,
    /// Other seeds draw other campaigns.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[arg(long, value_delimiter = ',', value_parser = case, conflicts_with = "campaigns", help = cases_help())]
    case: Vec<Case>,
    #[arg(long, value_delimiter = ',', value_parser = effect, conflicts_with = "campaigns", help = effects_help())]
    effect: Vec<String>,
    /// Only what stations do beyond white, independent noise: kinds by name, or "all" of them, `count` campaigns each.
    #[arg(long, value_delimiter = ',', value_parser = kinds, conflicts_with_all = ["campaigns", "case", "keep"])]
    kind: Vec<&'static str>,
    /// Detectability d of the case "one".
    #[arg(long, value_delimiter = ',', default_values_t = [8.0, 12.0, 20.0, 30.0], value_parser = positive, conflicts_with = "campaigns")]
    detectability: Vec<f64>,
    /// Folder to write the drawn campaigns and their key.json into.
    #[arg(long, value_name = "DIR", conflicts_with = "campaigns")]
    keep: Option<PathBuf>,
    /// Folder with campaigns of another maker.
    #[arg(long, value_name = "DIR", requires = "key")]
    campaigns: Option<PathBuf>,
    /// Their truth: file name to effects, gyros, detectability and the gyros' coefficients.
    #[arg(long, value_name = "FILE", requires = "campaigns")]
    key: Option<PathBuf>,
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    /// End with exit status 1 where a figure to be reached is not.
    #[arg(long)]
    strict: bool,
}

/// What is checked besides campaigns.
#[derive(Debug, clap::Subcommand)]
enum Of {
    History(super::blindcheck_history::History),
}

fn count(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|count| *count > 0).ok_or_else(|| "must be a whole number from 1 on".to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "must be a positive number".to_owned())
}

fn case(text: &str) -> Result<Case, String> {
    Case::from_name(text).ok_or_else(|| format!("cases are {}", Case::ALL.map(Case::name).join(", ")))
}

fn effect(text: &str) -> Result<String, String> {
    let known = CATALOGUE.iter().any(|known| known.id == text);
    known.then(|| text.to_owned()).ok_or_else(|| format!("effects are {}", listed()))
}

fn kinds(name: &str) -> Result<&'static str, String> {
    let known = || KINDS.iter().map(|kind| kind.name).collect::<Vec<_>>().join(", ");
    let found = KINDS.iter().map(|kind| kind.name).chain([ALL]).find(|kind| *kind == name);
    found.ok_or_else(|| format!("kinds are {ALL}, {}", known()))
}

/// Every kind.
const ALL: &str = "all";

fn effects_help() -> String {
    format!("Only these effects of the catalogue (docs/diagnosis.md says what each is): {}", listed())
}

fn cases_help() -> String {
    let cases = Case::ALL.map(Case::name).join(", ");
    format!("Only these cases; all in their usual shares where left out: {cases}")
}

impl Blindcheck {
    pub fn run(self) -> anyhow::Result<()> {
        if let Some(Of::History(history)) = self.of {
            return history.run();
        }
        if !self.kind.is_empty() {
            return self.kinds();
        }
        let begun = Instant::now();
        let (seal, scores) = match (&self.campaigns, &self.key) {
            (Some(folder), Some(key)) => self.foreign(folder, key)?,
            _ => self.drawn()?,
        };
        let report = Report::of(&seal, scores);
        match self.format {
            Format::Json => print_json(&report)?,
            Format::Table => print(&tables(&report, begun.elapsed().as_secs_f64()))?,
        }
        if self.strict && !report.reached() {
            bail!("not every figure to be reached was reached");
        }
        Ok(())
    }

    fn kinds(&self) -> anyhow::Result<()> {
        let wanted = |kind: &&Kind| self.kind.iter().any(|name| *name == ALL || *name == kind.name);
        let rows: Vec<KindRow> =
            KINDS.iter().filter(wanted).map(|kind| row(kind, self.seed, self.count, &diagnosed)).collect();
        match self.format {
            Format::Json => print_json(&rows),
            Format::Table => print(&kind_table(&rows)),
        }
    }

    fn drawn(&self) -> anyhow::Result<(String, Vec<Score>)> {
        let draw = Draw {
            seed: self.seed,
            cases: self.case.clone(),
            effects: self.effect.clone(),
            detectability: self.detectability.clone(),
        };
        let key = key_text(&key(&draw, self.count));
        let seal = seal(&key);
        eprintln!("key of {} campaigns sealed: SHA-256 {seal}", self.count);
        if let Some(folder) = &self.keep {
            keep_campaigns(&draw, self.count, folder)?;
        }
        let bar = progress(self.count, "campaigns");
        let scores = drawn(&draw, self.count, &diagnosed, &|| bar.inc(1));
        bar.finish_and_clear();
        if let Some(folder) = &self.keep {
            let path = folder.join("key.json");
            write(&path, &key)?;
            eprintln!("key revealed: {}", path.display());
        }
        Ok((seal, scores))
    }

    fn foreign(&self, folder: &Path, key: &Path) -> anyhow::Result<(String, Vec<Score>)> {
        let text = std::fs::read_to_string(key).with_context(|| key.display().to_string())?;
        let seal = seal(&text);
        eprintln!("key {}: SHA-256 {seal}", key.display());
        let entries: Key = serde_json::from_str(&text).with_context(|| key.display().to_string())?;
        let mut campaigns = Vec::new();
        for (name, key) in entries {
            let path = folder.join(&name);
            let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            campaigns.push(Foreign { name, text, key });
        }
        let bar = progress(campaigns.len(), "campaigns");
        let scores = foreign(&campaigns, &diagnosed, &|| bar.inc(1))?;
        bar.finish_and_clear();
        Ok((seal, scores))
    }
}

/// The diagnosis as a user gets it: from the file's text to the answer's JSON.
fn diagnosed(text: &str) -> Result<Answer, String> {
    let campaign = wire::campaign::parse_json(text.as_bytes()).map_err(|faults| faults.to_string())?;
    let diagnosis = diagnose(&campaign, &Options::default()).map_err(|refusal| refusal.to_string())?;
    let json = serde_json::to_value(wire::diagnosis::DiagnosisBody::from(&diagnosis)).map_err(|e| e.to_string())?;
    serde_json::from_value(json).map_err(|e| e.to_string())
}

fn keep_campaigns(draw: &Draw, count: usize, folder: &Path) -> anyhow::Result<()> {
    let drawn = |number| Ok((file_name(number), wire::campaign::to_json(&draw.trial(number).simulated.campaign)));
    write_all(folder, (0..count).map(drawn))
}

const KEY: &str =
    "named: the effect itself, or a class that holds it because the campaign cannot tell its members apart";

fn tables(report: &Report, seconds: f64) -> String {
    let mut parts = vec![
        format!("{} campaigns, key SHA-256 {}", report.campaigns, report.seal),
        format!("{}\n{KEY}", goals(report)),
    ];
    for (title, groups) in [
        ("one effect, named: by effect", &report.by_effect),
        ("by set of positions", &report.by_design),
        ("by standard errors", &report.by_standard_errors),
        ("outside the catalogue, partly or not explained", &report.by_outside_family),
    ] {
        if !groups.is_empty() {
            parts.push(by_group(title, groups).to_string());
        }
    }
    parts.push(confusion(report).to_string());
    parts.extend(report.errors.iter().map(|error| format!("no answer: {error}")));
    let time = report.milliseconds;
    parts.push(format!(
        "one diagnosis: median {:.1} ms, 99 % {:.1} ms, most {:.1} ms; all campaigns: {seconds:.1} s",
        time.median, time.p99, time.most
    ));
    parts.join("\n\n")
}

fn goals(report: &Report) -> Table {
    let mut table = table(["case", "hits", "trials", "rate", "95 % interval", "to reach", ""], 1..4);
    for row in &report.rows {
        let goal = row.to_reach.map_or(String::new(), |goal| match goal {
            Goal::AtLeast(share) => format!(">= {}", percent(share)),
            Goal::AtMost(share) => format!("<= {}", percent(share)),
        });
        let mark = row.reached.map_or("", |reached| if reached { "reached" } else { "NOT REACHED" });
        let [hits, trials, rate, interval] = figures(&row.tally);
        table.add_row([row.what.to_owned(), hits, trials, rate, interval, goal, mark.to_owned()]);
    }
    table
}

fn kind_table(rows: &[KindRow]) -> String {
    let head = [
        "kind",
        "campaigns",
        "confident wrong",
        "doubted wrong",
        "all named",
        "explained as whole",
        "gap, no name",
        "noise said",
        "described",
        "median, ms",
        "no answer",
    ];
    let mut table = table(head, 1..11);
    for row in rows {
        let hits = |tally: &Tally| tally.hits.to_string();
        table.add_row([
            row.kind.to_owned(),
            row.confident_wrong.trials.to_string(),
            hits(&row.confident_wrong),
            hits(&row.doubted_wrong),
            hits(&row.found),
            hits(&row.explained_as_whole),
            hits(&row.gap_without_a_name),
            hits(&row.noise_said),
            hits(&row.described),
            format!("{:.1}", row.milliseconds),
            row.errors.to_string(),
        ]);
    }
    table.to_string()
}

fn by_group(title: &str, groups: &BTreeMap<String, Tally>) -> Table {
    let mut table = table([title, "hits", "trials", "rate", "95 % interval"], 1..4);
    for (name, tally) in groups {
        let [hits, trials, rate, interval] = figures(tally);
        table.add_row([name.clone(), hits, trials, rate, interval]);
    }
    table
}

fn confusion(report: &Report) -> Table {
    let mut table = table(["hidden", "named (- nothing), how often"], 0..0);
    for (hidden, named) in &report.confusion {
        let mut counts: Vec<(&String, &usize)> = named.iter().collect();
        counts.sort_by(|a, b| b.1.cmp(a.1));
        let text: Vec<String> = counts.iter().map(|(name, count)| format!("{name} {count}")).collect();
        table.add_row([hidden.clone(), text.join(", ")]);
    }
    table
}
