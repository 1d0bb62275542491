//! The subcommands of a station's agent: what needs neither the service nor its configuration.

use clap::Subcommand;

use super::{codes, completions, correct, dwells, import, template};

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
    /// `whole`: the definition of the command line.
    pub fn run(self, whole: fn() -> clap::Command) -> anyhow::Result<()> {
        match self {
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

    pub fn is_service(&self) -> bool {
        false
    }
}
