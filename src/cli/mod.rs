//! The command line: one file a subcommand, and how each of them ends.
//!
//! A subcommand is a `clap::Args` struct with `fn run(self) -> anyhow::Result<()>`: it prints its result on standard
//! output and returns an error that names the file and the field. Exit status: 0 done, 1 an error, 2 wrong usage
//! (clap's own, and [`Usage`]). To add one: a file here, a `mod` line, a variant of [`Command`] and its arm in
//! [`Command::run`].

mod backup;
mod blindcheck;
mod blindcheck_history;
mod blindcheck_service;
mod calibrate;
mod client;
mod codes;
mod common;
mod completions;
mod config;
mod copy;
mod correct;
mod demo;
mod diagnose;
mod diagnose_all;
mod diagnose_gyro;
mod diagnose_record;
mod document;
mod dwells;
mod experiment;
mod export;
mod faults;
mod fleet_noise;
mod gap;
mod healthcheck;
mod hypothesis;
mod import;
mod model;
mod model_fit;
mod notify;
mod predict;
mod restore;
mod separate;
mod serve;
mod simulate;
mod tallies;
mod template;
mod token;
mod verify;

use std::error::Error;
use std::io;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::core::diagnose::NoReference;
use crate::core::effects::Refusal;
use crate::core::fault::Faults;
use crate::core::imu_model::{NoForecast, NotIdentified};
use crate::logs::error::LogError;
use crate::pipeline::AccessError;
use crate::system;
use crate::words;
use common::{Usage, block_on, instant};

/// Separates, judges and diagnoses the drift coefficients of liquid-floated gyros from calibrations of their IMU.
#[derive(Debug, Parser)]
#[command(version = system::version(), propagate_version = true, max_term_width = 110)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
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
    fn run(self) -> anyhow::Result<()> {
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
            Self::Completions(completions) => completions.run(Cli::command()),
            Self::Man(man) => man.run(Cli::command()),
        }
    }
}

impl Cli {
    /// Runs the subcommand; a failure is reported once, here, on standard error.
    pub fn run(self) -> ExitCode {
        if !matches!(self.command, Command::Serve(_) | Command::Demo(_)) {
            words::speak_as_the_environment();
        }
        match self.command.run() {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("gyrowatch: {}", in_words(&error));
                if error.is::<Usage>() { ExitCode::from(WRONG_USAGE) } else { ExitCode::FAILURE }
            }
        }
    }
}

/// The error and its causes; what is a message in the language of the environment.
fn in_words(error: &anyhow::Error) -> String {
    let language = words::asked();
    let said = |cause: &(dyn Error + 'static)| {
        if let Some(found) = cause.downcast_ref::<Faults>() {
            return faults::in_words(&found.0, language);
        }
        let message = None
            .or_else(|| cause.downcast_ref::<AccessError>().map(AccessError::message))
            .or_else(|| cause.downcast_ref::<LogError>().map(LogError::message))
            .or_else(|| cause.downcast_ref::<Refusal>().map(Refusal::message))
            .or_else(|| cause.downcast_ref::<NoReference>().map(NoReference::message))
            .or_else(|| cause.downcast_ref::<NotIdentified>().map(NotIdentified::message))
            .or_else(|| cause.downcast_ref::<NoForecast>().map(NoForecast::message));
        message.map_or_else(|| cause.to_string(), |message| language.words(&message))
    };
    error.chain().map(said).collect::<Vec<_>>().join(": ")
}

/// What clap ends with, too.
const WRONG_USAGE: u8 = 2;

/// Whoever reads our output has seen enough (`gyrowatch … | head`): not an error.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>()).any(|e| e.kind() == io::ErrorKind::BrokenPipe)
}
