//! `gyrowatch simulate`: made-up campaigns, and their truth apart; the paper's experiment, and its table.

use std::io::Write;

use super::{experiment, hypothesis, model};
use crate::cli::common::{Usage, positive, wrong};
use crate::cli::prelude::*;
use crate::core::augmented::AugmentedModel;
use crate::core::campaign::Campaign;
use crate::core::effects::Effect;
use crate::core::message::{self, sent};
use crate::core::mounting::Slot;
use crate::simulate::augment::augment;
use crate::simulate::cause::known;
use crate::simulate::experiment::{Test, tests};
use crate::simulate::of_hypothesis::{Amount, hide};
use crate::simulate::of_model::{drawn_from, state_as_fitted};
use crate::simulate::presets::{PRESETS, preset};
use crate::simulate::truth::Key;
use crate::simulate::{Scenario, Simulated, Stream, random, simulate};
use crate::wire;

/// The one preset that is several campaigns.
const PAPER_EXPERIMENT: &str = "paper-experiment";

/// Simulate a station's campaign from physics, with or without a hidden cause
///
/// Prints the campaign's JSON, or writes it with --out; the truth (gyros, causes, detectability) goes only where
/// --truth says. With --count it writes that many campaigns of successive seeds and one key.json into --dir.
///
/// --preset paper-experiment is the paper's Table 5: six bench tests around one campaign of the IMU. It prints the
/// range of the three results over --count experiments (200), or writes the files of each into --dir.
#[derive(Debug, Args)]
#[command(after_long_help = effects_help())]
pub struct Simulate {
    /// Start from a ready scenario (see --list).
    #[arg(long, value_name = "NAME", default_value = "24-position", value_parser = known_preset, conflicts_with = "scenario")]
    preset: String,
    /// Start from a scenario in TOML or JSON (by its extension).
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Simulate the IMU of this model file: gyros and effects drawn from its covariance by the seed, unless a scenario
    /// says otherwise in conditions that it has seen. Of a file without coefficients of an IMU, put in its effects only,
    /// as large as it says.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Put in a hypothesis of one's own, in TOML (docs/how-to/own-hypothesis.md), by --size or --detectability; its
    /// parameter is drawn from its range by the seed.
    #[arg(long, value_name = "FILE", requires = "amount")]
    hypothesis: Option<PathBuf>,
    /// Every coefficient of the hypothesis, in its unit.
    #[arg(long, value_name = "NUMBER", group = "amount", requires = "hypothesis", allow_negative_numbers = true)]
    size: Option<f64>,
    /// As visible as this over all gyros: d of the diagnosis. Signs and proportions are drawn.
    #[arg(long, value_name = "D", group = "amount", requires = "hypothesis", value_parser = positive)]
    detectability: Option<f64>,
    /// Gyros that have the hypothesis; all where left out.
    #[arg(long, value_name = "SLOT", value_delimiter = ',', requires = "hypothesis", value_parser = slot)]
    gyros: Vec<Slot>,
    /// Overrides the scenario's seed.
    #[arg(long)]
    seed: Option<u64>,
    /// Write the campaign here instead of to standard output.
    #[arg(long, value_name = "FILE", conflicts_with = "count")]
    out: Option<PathBuf>,
    /// Write the truth here.
    #[arg(long, value_name = "FILE", conflicts_with = "count")]
    truth: Option<PathBuf>,
    /// Make so many campaigns, each with the next seed.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    /// Folder for --count.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["out", "truth"])]
    dir: Option<PathBuf>,
    /// Print every result of --preset paper-experiment as CSV instead of the table.
    #[arg(long, conflicts_with_all = ["dir", "scenario"])]
    csv: bool,
    /// How campaigns are written.
    #[arg(long, value_enum, default_value_t)]
    format: CampaignFormat,
    /// List the presets.
    #[arg(long, conflicts_with_all = ["count", "out", "truth", "print_scenario"])]
    list: bool,
    /// Print the scenario in TOML, every key with its value, and simulate nothing.
    #[arg(long, conflicts_with_all = ["count", "out", "truth"])]
    print_scenario: bool,
}

/// How a campaign is written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
enum CampaignFormat {
    #[default]
    Json,
    /// One row a dwell, as a station's table program writes it
    Csv,
}

impl CampaignFormat {
    fn text(self, campaign: &Campaign) -> String {
        match self {
            Self::Json => wire::campaign::to_json(campaign),
            Self::Csv => wire::campaign_csv::to_csv(campaign).trim_end().to_owned(),
        }
    }

    fn ending(self) -> &'static str {
        match self {
            Self::Json => "json",
            Self::Csv => "csv",
        }
    }
}

fn known_preset(name: &str) -> Result<String, String> {
    let mut known = PRESETS.map(|(name, _)| name).to_vec();
    known.push(PAPER_EXPERIMENT);
    if known.contains(&name) {
        Ok(name.to_owned())
    } else {
        Err(wrong(message!("argument_presets", known = message::list(known))))
    }
}

fn effects_help() -> String {
    format!(
        "Causes of a scenario, as [[effects]] with effect = NAME and size or detectability (docs/simulation.md; \
         docs/diagnosis.md says what each is): {}.",
        known()
    )
}

impl Simulate {
    pub fn run(self) -> anyhow::Result<()> {
        if self.list {
            return list(std::io::stdout().lock());
        }
        if self.preset == PAPER_EXPERIMENT && self.scenario.is_none() {
            return self.paper_experiment();
        }
        if self.csv {
            return Err(Usage(said(message!("terminal_csv_of_experiment", preset = PAPER_EXPERIMENT))).into());
        }
        let mut scenario = self.read()?;
        scenario.seed = self.seed.unwrap_or(scenario.seed);
        if self.print_scenario {
            let text = toml::to_string(&scenario)?;
            return Ok(std::io::stdout().lock().write_all(text.as_bytes())?);
        }
        match (&self.dir, self.count) {
            (Some(dir), count) => many(&scenario, &self.put_in()?, count.unwrap_or(1), dir, self.format),
            (None, Some(_)) => Err(Usage(word("terminal_count_needs_dir").to_owned()).into()),
            (None, None) => self.one(&scenario),
        }
    }

    fn put_in(&self) -> anyhow::Result<InjectedEffects> {
        let model = self.model.as_deref().map_or_else(|| Ok(AugmentedModel::default()), model::file)?;
        let files: Vec<PathBuf> = self.hypothesis.iter().cloned().collect();
        let effect = hypothesis::files(&files, &model)?.first().copied();
        let amount = self.size.map(Amount::Size).or(self.detectability.map(Amount::Detectability));
        let hypothesis = effect.zip(amount).map(|(effect, amount)| (effect, amount, self.gyros.clone()));
        let model_file = self.model.as_deref().map(document::name).unwrap_or_default();
        Ok(InjectedEffects { model, model_file, hypothesis })
    }

    fn paper_experiment(&self) -> anyhow::Result<()> {
        let one_campaign = [&self.out, &self.truth, &self.model, &self.hypothesis].into_iter().any(Option::is_some);
        if one_campaign || self.print_scenario {
            return Err(Usage(said(message!("terminal_experiment_takes", preset = PAPER_EXPERIMENT))).into());
        }
        let seed = self.seed.unwrap_or(1);
        match &self.dir {
            Some(dir) => {
                let form = self.format;
                let made = (0..self.count.unwrap_or(1)).flat_map(|k| {
                    let seed = seed.wrapping_add(k);
                    let file = move |test: &Test| format!("{seed:04}-{}.{}", test.name(), form.ending());
                    tests(seed).into_iter().map(move |test| (file(&test), test.scenario))
                });
                write_all(made, &InjectedEffects::default(), dir, form)
            }
            None => experiment::print(seed, self.count.unwrap_or(200), self.csv),
        }
    }

    fn read(&self) -> anyhow::Result<Scenario> {
        let Some(path) = &self.scenario else {
            return Ok(preset(&self.preset).expect("known_preset lets no other name pass"));
        };
        match path.extension().is_some_and(|extension| extension == "json") {
            true => serde_json::from_str(&document::text(path)?).with_context(|| document::name(path)),
            false => document::toml(path),
        }
    }

    fn one(&self, scenario: &Scenario) -> anyhow::Result<()> {
        let simulated = made(scenario, &self.put_in()?)?;
        let text = self.format.text(&simulated.campaign);
        match &self.out {
            Some(path) => write(path, &text)?,
            None => writeln!(std::io::stdout().lock(), "{text}")?,
        }
        let Some(path) = &self.truth else { return Ok(()) };
        let name =
            self.out.as_deref().and_then(Path::file_name).map_or("-".into(), |n| n.to_string_lossy().into_owned());
        write_key(path, &Key::from([(name, simulated.truth)]))
    }
}

/// What is put into the outputs beside the scenario's causes.
#[derive(Default)]
struct InjectedEffects {
    model: AugmentedModel,
    model_file: String,
    hypothesis: Option<(Effect, Amount, Vec<Slot>)>,
}

fn made(scenario: &Scenario, put_in: &InjectedEffects) -> anyhow::Result<Simulated> {
    let whose = || word("terminal_scenario");
    let (scenario, model) = drawn_from(scenario, &put_in.model).with_context(whose)?;
    let mut simulated = simulate(&scenario).with_context(whose)?;
    state_as_fitted(&mut simulated.campaign, &model);
    augment(&mut simulated, &model).with_context(|| format!("--model {}", put_in.model_file))?;
    if let Some((effect, amount, slots)) = &put_in.hypothesis {
        hypothesis::defined_in(&[*effect], &simulated.campaign)?;
        let mut rng = random(scenario.seed, Stream::Hypothesis);
        hide(&mut simulated, *effect, *amount, slots, &mut rng).context("--hypothesis")?;
    }
    Ok(simulated)
}

fn slot(name: &str) -> Result<Slot, String> {
    Slot::from_name(name).ok_or_else(|| wrong(message!("unknown_slot", value = sent(name))))
}

fn list(mut out: impl Write) -> anyhow::Result<()> {
    for (name, about) in PRESETS {
        writeln!(out, "{name:<18} {}", word(about))?;
    }
    writeln!(out, "{PAPER_EXPERIMENT:<18} {}", word("preset_paper_experiment"))?;
    Ok(())
}

fn many(
    scenario: &Scenario,
    put_in: &InjectedEffects,
    count: u64,
    dir: &Path,
    form: CampaignFormat,
) -> anyhow::Result<()> {
    if scenario.seed.checked_add(count).is_none() {
        bail!(said(message!("terminal_seeds_end", last = u64::MAX.to_string())));
    }
    let named = |k: u64| {
        let scenario = Scenario { seed: scenario.seed + k, ..scenario.clone() };
        (format!("campaign-{k:05}.{}", form.ending()), scenario)
    };
    write_all((0..count).map(named), put_in, dir, form)
}

/// The campaigns, and their truth in key.json beside them.
fn write_all(
    scenarios: impl Iterator<Item = (String, Scenario)>,
    put_in: &InjectedEffects,
    dir: &Path,
    form: CampaignFormat,
) -> anyhow::Result<()> {
    let mut key = Key::new();
    let campaigns = scenarios.map(|(name, scenario)| {
        let simulated = made(&scenario, put_in)?;
        key.insert(name.clone(), simulated.truth);
        Ok((name, form.text(&simulated.campaign) + "\n"))
    });
    document::write_all(dir, campaigns)?;
    write_key(&dir.join("key.json"), &key)
}

fn write_key(path: &Path, key: &Key) -> anyhow::Result<()> {
    write(path, &serde_json::to_string_pretty(key)?)
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    document::write(path, &format!("{text}\n"))
}
