//! `config`: what is in force, from the defaults, the files and the environment.

use super::settings::{ConfigArgs, unread_variables};
use crate::cli::prelude::*;

/// Check the configuration and print what is in force, as one file
#[derive(Debug, Args)]
pub struct Show {
    #[command(flatten)]
    config: ConfigArgs,
}

impl Show {
    pub fn run(self) -> anyhow::Result<()> {
        for warning in unread_variables() {
            eprintln!("gyrowatch: {}", said(warning));
        }
        document::print(self.config.in_force()?.trim_end())
    }
}
