//! Every subcommand. A station's agent has those that need neither the service nor its configuration.

use clap::Subcommand;

#[cfg(feature = "server")]
use super::service;
use super::{codes, completions, correct, dwells, import, template};

#[derive(Debug, Subcommand)]
pub enum Command {
    #[cfg(feature = "server")]
    #[command(flatten)]
    Service(service::Command),
    Dwells(dwells::Dwells),
    Import(import::Import),
    Void(correct::Void),
    Revise(correct::Revise),
    Template(template::Template),
    Codes(codes::Codes),
    Completions(completions::Completions),
    Man(completions::ManPage),
}

impl Command {
    /// `whole`: the definition of the command line.
    pub fn run(self, whole: fn() -> clap::Command) -> anyhow::Result<()> {
        match self {
            #[cfg(feature = "server")]
            Self::Service(command) => command.run(),
            Self::Dwells(dwells) => dwells.run(),
            Self::Import(import) => import.run(),
            Self::Void(void) => void.run(),
            Self::Revise(revise) => revise.run(),
            Self::Template(template) => template.run(),
            Self::Codes(codes) => codes.run(),
            Self::Completions(completions) => completions.run(whole()),
            Self::Man(man) => man.run(whole()),
        }
    }

    /// Whether it runs on and answers others, each in a language of their own.
    pub fn is_service(&self) -> bool {
        match self {
            #[cfg(feature = "server")]
            Self::Service(command) => command.is_service(),
            _ => false,
        }
    }
}
