//! The configuration that subcommands read.

use crate::cli::prelude::*;
use crate::config::{Config, unread};
use crate::core::calibrate::outcome::check_scales;
use crate::core::campaign::Campaign;
use crate::core::message::Message;
use crate::core::record::Plausibility;
use crate::wire::document::parse;

/// Which configuration is in force.
#[derive(Debug, clap::Args)]
pub struct ConfigArgs {
    /// Configuration file, which names the database and the limits; repeat for several, later ones win [default:
    /// config/*.toml]
    #[arg(long = "config", value_name = "FILE", global = true)]
    files: Vec<PathBuf>,
}

impl ConfigArgs {
    pub fn load(&self) -> anyhow::Result<Config> {
        Ok(Config::load(&self.files, std::env::vars())?)
    }

    /// What is in force, as one file.
    pub fn in_force(&self) -> anyhow::Result<String> {
        Ok(Config::in_force(&self.files, std::env::vars())?)
    }
}

/// Of the environment: what looks like a key and is none.
pub fn unread_variables() -> Vec<Message> {
    unread(std::env::vars_os().filter_map(|(name, _)| name.into_string().ok()))
}

/// The configuration in force: files in `config` and the environment.
pub fn config() -> anyhow::Result<Config> {
    Ok(Config::load(&[], std::env::vars())?)
}

/// What is refused as impossible, as the configuration in force says.
pub fn plausibility() -> anyhow::Result<Plausibility> {
    Ok(config()?.plausibility.limits())
}

/// A campaign in a file, where its scale factors are possible.
pub fn campaign(path: &Path, bytes: &[u8]) -> anyhow::Result<Campaign> {
    let file = || document::name(path);
    let campaign = parse(bytes).with_context(file)?;
    check_scales(&campaign, &plausibility()?).with_context(file)?;
    document::note_open_end(path, bytes);
    Ok(campaign)
}
