//! `gyrowatch simulate`: made-up campaigns, and their truth apart.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;

use crate::simulate::presets::{PRESETS, preset};
use crate::simulate::truth::Key;
use crate::simulate::{Scenario, Simulated, simulate};
use crate::wire;

/// Simulates a station's campaign from physics, with or without a hidden cause.
///
/// Prints the campaign's JSON, or writes it with --out; the truth (gyros, causes, detectability) goes only where
/// --truth says. With --count it writes that many campaigns of successive seeds and one key.json into --dir.
#[derive(Debug, Args)]
pub struct Simulate {
    /// Start from a ready scenario (see --list).
    #[arg(long, value_name = "NAME", default_value = "24-position", conflicts_with = "scenario")]
    preset: String,
    /// Start from a scenario in TOML or JSON (by its extension).
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
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
    #[arg(long, value_name = "N", requires = "dir")]
    count: Option<u64>,
    /// Folder for --count.
    #[arg(long, value_name = "DIR", requires = "count")]
    dir: Option<PathBuf>,
    /// List the presets.
    #[arg(long, conflicts_with_all = ["count", "out", "truth", "print_scenario"])]
    list: bool,
    /// Print the scenario in TOML, every key with its value, and simulate nothing.
    #[arg(long, conflicts_with_all = ["count", "out", "truth"])]
    print_scenario: bool,
}

impl Simulate {
    pub fn run(self) -> anyhow::Result<()> {
        if self.list {
            return list(std::io::stdout().lock());
        }
        let mut scenario = self.read()?;
        scenario.seed = self.seed.unwrap_or(scenario.seed);
        if self.print_scenario {
            let text = toml::to_string(&scenario).context("the scenario cannot be written as TOML")?;
            return Ok(std::io::stdout().lock().write_all(text.as_bytes())?);
        }
        match (&self.dir, self.count) {
            (Some(dir), Some(count)) => many(&scenario, count, dir),
            _ => self.one(&scenario),
        }
    }

    fn read(&self) -> anyhow::Result<Scenario> {
        let Some(path) = &self.scenario else {
            let known = || PRESETS.map(|(name, _)| name).join(", ");
            return preset(&self.preset).with_context(|| format!("no preset {:?}; there are {}", self.preset, known()));
        };
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        let scenario = match path.extension().is_some_and(|extension| extension == "json") {
            true => serde_json::from_str(&text).map_err(anyhow::Error::from),
            false => toml::from_str(&text).map_err(anyhow::Error::from),
        };
        scenario.with_context(|| path.display().to_string())
    }

    fn one(&self, scenario: &Scenario) -> anyhow::Result<()> {
        let simulated = made(scenario)?;
        let text = wire::campaign::to_json(&simulated.campaign);
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

fn made(scenario: &Scenario) -> anyhow::Result<Simulated> {
    simulate(scenario).map_err(|faults| anyhow::anyhow!("scenario: {faults}"))
}

fn list(mut out: impl Write) -> anyhow::Result<()> {
    for (name, about) in PRESETS {
        writeln!(out, "{name:<18} {about}")?;
    }
    Ok(())
}

fn many(scenario: &Scenario, count: u64, dir: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(dir).with_context(|| dir.display().to_string())?;
    let mut key = Key::new();
    for k in 0..count {
        let Some(seed) = scenario.seed.checked_add(k) else { bail!("seeds end at {}", u64::MAX) };
        let simulated = made(&Scenario { seed, ..scenario.clone() })?;
        let name = format!("campaign-{k:05}.json");
        write(&dir.join(&name), &wire::campaign::to_json(&simulated.campaign))?;
        key.insert(name, simulated.truth);
    }
    write_key(&dir.join("key.json"), &key)
}

fn write_key(path: &Path, key: &Key) -> anyhow::Result<()> {
    write(path, &serde_json::to_string_pretty(key)?)
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    std::fs::write(path, format!("{text}\n")).with_context(|| path.display().to_string())
}
