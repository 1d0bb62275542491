//! What subcommands share: the runtime, the progress bar, and arguments that clap cannot check.

use indicatif::{ProgressBar, ProgressStyle};

use super::prelude::*;
use crate::core::message::{Message, list};
use crate::core::time::UtcMicros;
use crate::words::of_environment;

/// Runs a subcommand that waits for the network. One thread is plenty: the service is where the work is.
pub(super) fn block_on<T>(work: impl Future<Output = anyhow::Result<T>>) -> anyhow::Result<T> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(work)
}

/// Where the service is, unless `--url` or GYROWATCH_URL says so: where it would listen on this machine.
pub(super) fn service_address() -> String {
    std::env::var("GYROWATCH_LISTEN").unwrap_or_else(|_| "127.0.0.1:8080".to_owned())
}

/// A bar that shows how far `length` has come.
pub(super) fn progress(length: u64, template: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length).with_style(style)
}

/// What is wrong with an argument. Arguments are read before the process has a language.
pub(super) fn wrong(message: Message) -> String {
    of_environment().words(&message)
}

/// An argument that is one of the names that are `known`.
pub(super) fn one_of<T>(found: Option<T>, known: impl IntoIterator<Item = &'static str>) -> Result<T, String> {
    found.ok_or_else(|| wrong(message!("argument_one_of", known = list(known))))
}

/// A time in an argument.
pub(super) fn instant(text: &str) -> Result<UtcMicros, String> {
    time::parse(text).map_err(wrong)
}

/// Where a stretch of time begins; a day begins at midnight UTC.
pub(super) fn start(text: &str) -> Result<UtcMicros, String> {
    time::parse_start(text).map_err(wrong)
}

/// Where a stretch of time ends; a day (UTC) belongs to it.
pub(super) fn end(text: &str) -> Result<UtcMicros, String> {
    time::parse_end(text).map_err(wrong)
}

/// Arguments that do not go together in a way that clap cannot be told.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct Usage(pub(super) String);

/// An argument that is a number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| wrong(message!("argument_positive")))
}
