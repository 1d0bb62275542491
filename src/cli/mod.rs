//! The command line: one file a subcommand, and how each of them ends.
//!
//! A subcommand is a `clap::Args` struct with `fn run(self) -> anyhow::Result<()>`: it prints its result on standard
//! output and returns an error that names the file and the field. Exit status: 0 done, 1 an error, 2 wrong usage
//! (clap's own, and [`Usage`]). To add one: a file, a `mod` line, a variant of `Command` and its arm in `Command::run`, in
//! `service`, or here and in `commands` where a station's agent has it too.

mod client;
mod codes;
mod commands;
mod common;
mod completions;
mod correct;
mod document;
mod dwells;
mod errors;
mod faults;
mod import;
mod prelude;
#[cfg(feature = "server")]
mod service;
mod template;

use std::io;
use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use crate::{system, words};
use commands::Command;
use common::{Usage, block_on};
use errors::with_causes;

/// Separates, judges and diagnoses the drift coefficients of liquid-floated gyros from calibrations of their IMU.
#[derive(Debug, Parser)]
#[command(version = system::version(), propagate_version = true, max_term_width = 110)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

impl Cli {
    /// Runs the subcommand; a failure is reported once, here, on standard error.
    pub fn run(self) -> ExitCode {
        if !self.command.is_service() {
            words::speak_as_the_environment();
        }
        match self.command.run(Self::command) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("gyrowatch: {}", with_causes(&error));
                if error.is::<Usage>() { ExitCode::from(WRONG_USAGE) } else { ExitCode::FAILURE }
            }
        }
    }
}

/// What clap ends with, too.
const WRONG_USAGE: u8 = 2;

/// Whoever reads our output has seen enough (`gyrowatch … | head`): not an error.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>()).any(|e| e.kind() == io::ErrorKind::BrokenPipe)
}
