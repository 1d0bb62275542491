//! Parses the command line and hands over.

use std::process::ExitCode;

use clap::Parser;
use gyrowatch::cli::Cli;

fn main() -> ExitCode {
    gyrowatch::system::install_crypto();
    Cli::parse().run()
}
