//! `gyrowatch blindcheck`: how well does the diagnosis do on campaigns whose cause is hidden from it?

use std::collections::BTreeMap;
use std::time::Instant;

use anyhow::Error;
use comfy_table::Table;

use super::hypothesis;
use super::tallies::{demand, figures, percent, progress, target};
use crate::blindcheck::answer::Answer;
use crate::blindcheck::draw::{Case, Draw};
use crate::blindcheck::hypothesis::{FOUND, HypothesisReport, NoReport};
use crate::blindcheck::kind::{CampaignKind, KINDS, KindRow, row};
use crate::blindcheck::report::{Goal, Milliseconds, Report};
use crate::blindcheck::run::{Foreign, drawn, file_name, foreign, key, key_text};
use crate::blindcheck::score::Score;
use crate::blindcheck::seal;
use crate::blindcheck::tally::Tally;
use crate::cli::common::{one_of, positive, wrong};
use crate::cli::document::{part_of, write, write_all};
use crate::cli::faults;
use crate::cli::prelude::*;
use crate::core::augmented::{AugmentedModel, Options};
use crate::core::diagnose::diagnose;
use crate::core::effects::Effect;
use crate::simulate::Scenario;
use crate::simulate::cause::{CATALOGUE, listed};
use crate::simulate::truth::Key;
use crate::{blindcheck, wire};

/// Draw campaigns with a hidden cause, diagnose them from their file alone, score the answers
///
/// The truth of all campaigns is sealed before the first diagnosis: its SHA-256 is printed first, and with --keep the
/// key whose SHA-256 that is lies in the folder afterwards. With --campaigns and --key the campaigns are somebody
/// else's.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Blindcheck {
    #[command(subcommand)]
    of: Option<BlindcheckOf>,
    /// Number of campaigns to draw; of --kind and --hypothesis, for each line of the table [default: 1000, with
    /// --hypothesis 100].
    #[arg(long, value_parser = count, conflicts_with = "campaigns")]
    count: Option<usize>,
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
    /// Detectability d of the case "one" [default: 8,12,20,30], or of a hypothesis [default: 3,4,5,6,8,12].
    #[arg(long, value_delimiter = ',', value_parser = positive, conflicts_with = "campaigns")]
    detectability: Vec<f64>,
    /// A hypothesis of one's own, in TOML: hidden in some campaigns of one design and asked for in all. Says what size
    /// this design would find, and how often it is named where it is not.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["campaigns", "case", "effect", "kind", "keep", "strict"])]
    hypothesis: Option<PathBuf>,
    /// The design for the hypothesis, a scenario in TOML (`simulate --print-scenario`); else the preset 24-position.
    #[arg(long, value_name = "FILE", requires = "hypothesis")]
    scenario: Option<PathBuf>,
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
enum BlindcheckOf {
    History(super::blindcheck_history::History),
}

fn count(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|count| *count > 0).ok_or_else(|| wrong(message!("argument_count")))
}

fn case(text: &str) -> Result<Case, String> {
    one_of(Case::from_name(text), Case::ALL.map(Case::name))
}

fn effect(text: &str) -> Result<String, String> {
    let known = CATALOGUE.map(|known| known.id);
    one_of(known.contains(&text).then(|| text.to_owned()), known)
}

fn kinds(name: &str) -> Result<&'static str, String> {
    let known = || [ALL].into_iter().chain(KINDS.iter().map(|kind| kind.name));
    one_of(known().find(|kind| *kind == name), known())
}

/// Campaigns that are drawn where no number is given.
const COUNT: usize = 1000;

/// Hits without a miss whose interval (Wilson's) reaches 95 %: n/(n + 1.96^2) >= 0.95.
const SHOWS: usize = 73;

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
        if let Some(BlindcheckOf::History(history)) = self.of {
            return history.run();
        }
        if !self.kind.is_empty() {
            return self.kinds();
        }
        if let Some(path) = &self.hypothesis {
            return self.hypothesis(path);
        }
        let begun = Instant::now();
        let (seal, scores) = match (&self.campaigns, &self.key) {
            (Some(folder), Some(key)) => self.foreign(folder, key)?,
            _ => self.drawn()?,
        };
        let report = Report::of(&seal, scores);
        self.format.show(&report, || tables(&report, begun.elapsed().as_secs_f64()))?;
        demand(self.strict, report.reached())
    }

    fn kinds(&self) -> anyhow::Result<()> {
        let wanted = |kind: &&CampaignKind| self.kind.iter().any(|name| *name == ALL || *name == kind.name);
        let rows: Vec<KindRow> =
            KINDS.iter().filter(wanted).map(|kind| row(kind, self.seed, self.count.unwrap_or(COUNT), &plain)).collect();
        self.format.show(&rows, || kind_table(&rows))
    }

    fn hypothesis(&self, path: &Path) -> anyhow::Result<()> {
        let own = hypothesis::files(&[path.to_owned()], &AugmentedModel::default())?;
        let scenario = match &self.scenario {
            Some(path) => document::toml(path)?,
            None => Scenario::default(),
        };
        let effect = own[0];
        let sizes =
            if self.detectability.is_empty() { &[3.0, 4.0, 5.0, 6.0, 8.0, 12.0] } else { &self.detectability[..] };
        let count = self.count.unwrap_or(100);
        let bar = progress(count * (1 + sizes.len()), "campaigns");
        let asked = |text: &str| diagnosed(text, &own);
        let design = (&scenario, self.seed, count);
        let report = blindcheck::hypothesis::hypothesis(effect, design, sizes, &asked, &|| bar.inc(1));
        bar.finish_and_clear();
        let report = report.map_err(|why| match why {
            NoReport::Scenario(faults) => Error::from(faults).context(word("terminal_scenario")),
            NoReport::NotPossible(why) => Error::from(why).context(path.display().to_string()),
        })?;
        self.format.show(&report, || hypothesis_tables(&report))
    }

    fn drawn(&self) -> anyhow::Result<(String, Vec<Score>)> {
        let count = self.count.unwrap_or(COUNT);
        let of_one = if self.detectability.is_empty() { &[8.0, 12.0, 20.0, 30.0] } else { &self.detectability[..] };
        let draw = Draw {
            seed: self.seed,
            cases: self.case.clone(),
            effects: self.effect.clone(),
            detectability: of_one.to_vec(),
        };
        let key = key_text(&key(&draw, count));
        let seal = seal(&key);
        eprintln!("{}", said(message!("terminal_key_sealed", count, seal = seal.clone())));
        if let Some(folder) = &self.keep {
            keep_campaigns(&draw, count, folder)?;
        }
        let bar = progress(count, "campaigns");
        let scores = drawn(&draw, count, &plain, &|| bar.inc(1));
        bar.finish_and_clear();
        if let Some(folder) = &self.keep {
            let path = folder.join("key.json");
            write(&path, &key)?;
            eprintln!("{}", said(message!("terminal_key_revealed", file = path.display().to_string())));
        }
        Ok((seal, scores))
    }

    fn foreign(&self, folder: &Path, key: &Path) -> anyhow::Result<(String, Vec<Score>)> {
        let text = document::text(key)?;
        let seal = seal(&text);
        eprintln!("{}", said(message!("terminal_key_read", file = key.display().to_string(), seal = seal.clone())));
        let entries: Key = serde_json::from_str(&text).with_context(|| key.display().to_string())?;
        let mut campaigns = Vec::new();
        for (name, key) in entries {
            let text = document::text(&folder.join(&name))?;
            campaigns.push(Foreign { name, text, key });
        }
        let bar = progress(campaigns.len(), "campaigns");
        let scores = foreign(&campaigns, &plain, &|| bar.inc(1))?;
        bar.finish_and_clear();
        Ok((seal, scores))
    }
}

fn plain(text: &str) -> Result<Answer, String> {
    diagnosed(text, &[])
}

/// The diagnosis as a user gets it, with hypotheses asked: from the file's text to the answer's JSON.
fn diagnosed(text: &str, hypotheses: &[Effect]) -> Result<Answer, String> {
    let campaign = wire::campaign::parse_json(text.as_bytes()).map_err(|found| faults::in_words(&found))?;
    let options = Options { hypotheses: hypotheses.to_vec(), ..Options::default() };
    let diagnosis = diagnose(&campaign, &options).map_err(|refusal| said(refusal.message()))?;
    let json = serde_json::to_value(wire::diagnosis::DiagnosisBody::from(&diagnosis)).map_err(|e| e.to_string())?;
    serde_json::from_value(json).map_err(|e| e.to_string())
}

fn keep_campaigns(draw: &Draw, count: usize, folder: &Path) -> anyhow::Result<()> {
    let drawn = |number| Ok((file_name(number), wire::campaign::to_json(&draw.trial(number).simulated.campaign)));
    write_all(folder, (0..count).map(drawn))
}

fn tables(report: &Report, seconds: f64) -> String {
    let (count, seal) = (report.campaigns, report.seal.clone());
    let mut parts = vec![
        said(message!("terminal_blind_campaigns", count, seal)),
        format!("{}\n{}", goals(report), word("terminal_blind_key")),
    ];
    for (head, groups) in [
        ("terminal_by_effect_head", &report.by_effect),
        ("terminal_by_design_head", &report.by_design),
        ("terminal_by_errors_head", &report.by_standard_errors),
        ("terminal_by_family_head", &report.by_outside_family),
    ] {
        if !groups.is_empty() {
            parts.push(by_group(head, groups).to_string());
        }
    }
    parts.push(confusion(report).to_string());
    parts.extend(report.errors.iter().map(|why| no_answer(why)));
    let Milliseconds { median, p99, most } = report.milliseconds;
    let [median, p99, most, seconds] = [median, p99, most, seconds].map(|time| format!("{time:.1}"));
    parts.push(said(message!("terminal_blind_times", median, p99, most, seconds)));
    parts.join("\n\n")
}

fn goals(report: &Report) -> Table {
    let mut table = table_of("terminal_goals_head", 1..4);
    for row in &report.rows {
        let (at_least, at_most) = match row.to_reach {
            Some(Goal::AtLeast(share)) => (Some(share), None),
            Some(Goal::AtMost(share)) => (None, Some(share)),
            None => (None, None),
        };
        let [goal, mark] = target(at_least, at_most, row.reached);
        let [hits, trials, rate, interval] = figures(&row.tally);
        table.add_row([row.what.to_owned(), hits, trials, rate, interval, goal, mark]);
    }
    table
}

fn kind_table(rows: &[KindRow]) -> String {
    let mut table = table_of("terminal_kinds_head", 1..12);
    for row in rows {
        let hits = |tally: &Tally| tally.hits.to_string();
        let share = |of: &Tally| if of.trials > 0 { part_of(hits(of), of.trials as u64) } else { String::new() };
        table.add_row([
            row.kind.to_owned(),
            row.confident_wrong.trials.to_string(),
            hits(&row.confident_wrong),
            hits(&row.doubted_wrong),
            share(&row.found),
            share(&row.explained_as_whole),
            share(&row.closure_covers),
            hits(&row.gap_without_a_name),
            hits(&row.noise_said),
            hits(&row.described),
            format!("{:.1}", row.milliseconds),
            row.errors.to_string(),
        ]);
    }
    table.to_string()
}

fn hypothesis_tables(report: &HypothesisReport) -> String {
    let mut table = table_of("terminal_hypothesis_head", 0..7);
    for row in &report.hidden {
        let [hits, trials, rate, interval] = figures(&row.named);
        table.add_row([
            row.detectability.to_string(),
            format!("{:.3e} {}", row.size, report.unit),
            trials,
            format!("{hits}, {rate}"),
            interval,
            row.in_class.hits.to_string(),
            row.something_else.hits.to_string(),
        ]);
    }
    let (share, unit, digits) = (percent(FOUND), report.unit.to_owned(), |size: f64| format!("{size:.1e}"));
    let found = match (report.found_from, report.surely_from) {
        (None, _) => message!("terminal_named_never", share),
        (Some(size), Some(surely)) if surely <= size => {
            message!("terminal_named_from", share, size = digits(size), unit)
        }
        (Some(size), Some(surely)) => {
            message!("terminal_named_shown", share, size = digits(size), unit, surely = digits(surely))
        }
        (Some(size), None) => {
            let row = report.hidden.iter().find(|row| row.size >= size);
            let [hits, trials, _, interval] = row.map(|row| figures(&row.named)).unwrap_or_default();
            let (size, least) = (digits(size), SHOWS.to_string());
            message!("terminal_named_unshown", hits, trials, size, unit, interval, share, least)
        }
    };
    let head = message!("terminal_hypothesis", id = report.hypothesis.to_string(), found);
    let mut parts = vec![said(head), table.to_string()];
    let mut class: Vec<&str> = report.hidden.iter().flat_map(|row| &row.class).map(String::as_str).collect();
    let mut seen = std::collections::BTreeSet::new();
    class.retain(|id| seen.insert(*id));
    if !class.is_empty() {
        parts.push(said(message!("terminal_hard_to_tell", effects = class.join(", "))));
    }
    let [hits, trials, rate, interval] = figures(&report.clean);
    let anything = report.clean_anything.hits.to_string();
    parts.push(said(message!("terminal_where_not", hits, trials, rate, interval, anything)));
    parts.extend(report.errors.iter().map(|why| no_answer(why)));
    parts.join("\n\n")
}

fn no_answer(why: &str) -> String {
    said(message!("terminal_undiagnosed", why = why.to_owned()))
}

fn by_group(head: &str, groups: &BTreeMap<String, Tally>) -> Table {
    let mut table = table_of(head, 1..4);
    for (name, tally) in groups {
        let [hits, trials, rate, interval] = figures(tally);
        table.add_row([name.clone(), hits, trials, rate, interval]);
    }
    table
}

fn confusion(report: &Report) -> Table {
    let mut table = table_of("terminal_confusion_head", 0..0);
    for (hidden, named) in &report.confusion {
        let mut counts: Vec<(&String, &usize)> = named.iter().collect();
        counts.sort_by(|a, b| b.1.cmp(a.1));
        let text: Vec<String> = counts.iter().map(|(name, count)| format!("{name} {count}")).collect();
        table.add_row([hidden.clone(), text.join(", ")]);
    }
    table
}
