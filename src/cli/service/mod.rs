//! The subcommands that a station's agent goes without: they need the service or its configuration.

mod backup;
mod blindcheck;
mod blindcheck_history;
mod blindcheck_service;
mod calibrate;
mod config;
mod copy;
mod demo;
mod diagnose;
mod diagnose_all;
mod diagnose_gyro;
mod diagnose_record;
mod experiment;
mod export;
mod fleet_noise;
mod gap;
mod healthcheck;
mod hypothesis;
mod model;
mod model_fit;
mod notify;
mod predict;
mod restore;
mod separate;
mod serve;
mod settings;
mod simulate;
mod tallies;
mod token;
mod verify;

use clap::Subcommand;

/// Each subcommand, run by its own `run`.
macro_rules! commands {
    ($($name:ident($of:ty),)*) => {
        #[derive(Debug, Subcommand)]
        pub enum Command {
            $($name($of),)*
        }

        impl Command {
            pub fn run(self) -> anyhow::Result<()> {
                match self {
                    $(Self::$name(one) => one.run(),)*
                }
            }
        }
    };
}

commands! {
    Serve(serve::Serve),
    Demo(demo::Demo),
    Separate(separate::Separate),
    Calibrate(calibrate::Calibrate),
    Diagnose(diagnose::Diagnose),
    Model(model_fit::Model),
    Predict(predict::Predict),
    Gap(gap::Gap),
    Export(export::Export),
    FleetNoise(fleet_noise::FleetNoiseArgs),
    Simulate(simulate::Simulate),
    Blindcheck(blindcheck::Blindcheck),
    Backup(backup::Backup),
    Restore(restore::Restore),
    Copy(copy::Copy),
    Token(token::TokenArgs),
    Verify(verify::Verify),
    Config(config::Show),
    Healthcheck(healthcheck::Healthcheck),
}

impl Command {
    /// Whether it runs on and answers others, each in a language of their own.
    pub fn is_service(&self) -> bool {
        matches!(self, Self::Serve(_) | Self::Demo(_))
    }
}
