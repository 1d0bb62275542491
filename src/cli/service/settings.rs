//! What the configuration says to subcommands that read documents.

use crate::config::Config;
use crate::core::record::Plausibility;

/// The configuration in force: files in `config` and the environment.
pub fn config() -> anyhow::Result<Config> {
    Ok(Config::load(&[], std::env::vars())?)
}

/// What is refused as impossible, as the configuration in force says.
pub fn plausibility() -> anyhow::Result<Plausibility> {
    Ok(config()?.plausibility.limits())
}
