//! `config`: what is in force, from the defaults, the files and the environment.

use std::path::PathBuf;

use clap::Args;

use crate::cli::document;
use crate::config::Config;

/// Check the configuration and print what is in force, as one file
#[derive(Debug, Args)]
pub struct Show {
    /// Configuration file; repeat for several, later ones win [default: config/*.toml]
    #[arg(long = "config", value_name = "FILE")]
    config: Vec<PathBuf>,
}

impl Show {
    pub fn run(self) -> anyhow::Result<()> {
        document::print(Config::in_force(&self.config, std::env::vars())?.trim_end())
    }
}
