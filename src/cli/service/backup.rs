//! `backup`: a copy of the database, taken while it is served, and checked.

use super::settings::ConfigArgs;
use crate::cli::common::block_on;
use crate::cli::prelude::*;
use crate::store::{self, BackupContents};

/// Copy the database into one file, served or not, and check the copy
#[derive(Debug, Args)]
pub struct Backup {
    /// The file to write; it must not exist
    file: PathBuf,
    #[command(flatten)]
    config: ConfigArgs,
}

impl Backup {
    pub fn run(self) -> anyhow::Result<()> {
        let database = self.config.load()?.database;
        let copied = block_on(async { Ok(store::backup(&database.options(), &self.file).await?) });
        let contents =
            copied.with_context(|| said(message!("terminal_not_backed_up", database = database.options().shown())))?;
        println!("{}: {}", self.file.display(), contents_message(&contents));
        Ok(())
    }
}

/// What was found whole.
pub(super) fn contents_message(contents: &BackupContents) -> String {
    let BackupContents { gyros, records, figures, bench_results } = contents;
    said(message!(
        "terminal_holdings",
        records = records.to_string(),
        bench_results = bench_results.to_string(),
        figures = figures.to_string(),
        gyros = gyros.to_string()
    ))
}
