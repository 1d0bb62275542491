//! Every subcommand.

use clap::Subcommand;

use super::{
    backup, blindcheck, calibrate, codes, completions, config, copy, correct, demo, diagnose, dwells, export,
    fleet_noise, gap, healthcheck, import, model_fit, predict, restore, separate, serve, simulate, template, token,
    verify,
};

#[derive(Debug, Subcommand)]
pub enum Command {
    Serve(serve::Serve),
    Demo(demo::Demo),
    Separate(separate::Separate),
    Calibrate(calibrate::Calibrate),
    Dwells(dwells::Dwells),
    Diagnose(diagnose::Diagnose),
    Model(model_fit::Model),
    Predict(predict::Predict),
    Gap(gap::Gap),
    Import(import::Import),
    Void(correct::Void),
    Revise(correct::Revise),
    Export(export::Export),
    FleetNoise(fleet_noise::FleetNoise),
    Simulate(simulate::Simulate),
    Template(template::Template),
    Blindcheck(blindcheck::Blindcheck),
    Backup(backup::Backup),
    Restore(restore::Restore),
    Copy(copy::Copy),
    Token(token::Token),
    Verify(verify::Verify),
    Config(config::Show),
    Codes(codes::Codes),
    Healthcheck(healthcheck::Healthcheck),
    Completions(completions::Completions),
    Man(completions::Man),
}

impl Command {
    /// `whole`: the definition of the command line.
    pub fn run(self, whole: fn() -> clap::Command) -> anyhow::Result<()> {
        match self {
            Self::Serve(serve) => serve.run(),
            Self::Demo(demo) => demo.run(),
            Self::Separate(separate) => separate.run(),
            Self::Calibrate(calibrate) => calibrate.run(),
            Self::Dwells(dwells) => dwells.run(),
            Self::Diagnose(diagnose) => diagnose.run(),
            Self::Model(model) => model.run(),
            Self::Predict(predict) => predict.run(),
            Self::Gap(gap) => gap.run(),
            Self::Import(import) => import.run(),
            Self::Void(void) => void.run(),
            Self::Revise(revise) => revise.run(),
            Self::Export(export) => export.run(),
            Self::FleetNoise(fleet_noise) => fleet_noise.run(),
            Self::Simulate(simulate) => simulate.run(),
            Self::Template(template) => template.run(),
            Self::Blindcheck(blindcheck) => blindcheck.run(),
            Self::Backup(backup) => backup.run(),
            Self::Restore(restore) => restore.run(),
            Self::Copy(copy) => copy.run(),
            Self::Token(token) => token.run(),
            Self::Verify(verify) => verify.run(),
            Self::Config(show) => show.run(),
            Self::Codes(codes) => codes.run(),
            Self::Healthcheck(healthcheck) => healthcheck.run(),
            Self::Completions(completions) => completions.run(whole()),
            Self::Man(man) => man.run(whole()),
        }
    }

    /// Whether it runs on and answers others, each in a language of their own.
    pub fn is_service(&self) -> bool {
        matches!(self, Self::Serve(_) | Self::Demo(_))
    }
}
