//! The subcommands of a station's agent: what needs neither the service nor its configuration.

use clap::{CommandFactory, Subcommand};

use super::{Cli, codes, completions, correct, dwells, import, template};

#[derive(Debug, Subcommand)]
pub enum Command {
    Dwells(dwells::Dwells),
    Import(import::Import),
    Void(correct::Void),
    Revise(correct::Revise),
    Template(template::Template),
    Codes(codes::Codes),
    Completions(completions::Completions),
    Man(completions::Man),
}

impl Command {
    pub fn run(self) -> anyhow::Result<()> {
        match self {
            Self::Dwells(dwells) => dwells.run(),
            Self::Import(import) => import.run(),
            Self::Void(void) => void.run(),
            Self::Revise(revise) => revise.run(),
            Self::Template(template) => template.run(),
            Self::Codes(codes) => codes.run(),
            Self::Completions(completions) => completions.run(Cli::command()),
            Self::Man(man) => man.run(Cli::command()),
        }
    }

    pub fn is_service(&self) -> bool {
        false
    }
}
