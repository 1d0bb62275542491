//! Parses the command line and hands over.

use std::process::ExitCode;

use clap::Parser;
use gyrowatch::cli::Cli;

fn main() -> ExitCode {
    gyrowatch::system::install_crypto();
    gyrowatch::words::speak_as_the_environment();
    Cli::parse().run()
}
