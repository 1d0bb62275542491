//! `restore`: a backup checked, and put where a database is missing.

use super::backup::contents_message;
use super::settings::ConfigArgs;
use crate::cli::common::block_on;
use crate::cli::prelude::*;
use crate::store;

/// Check a backup and put it where the database is to be; what is there already is never overwritten
#[derive(Debug, Args)]
pub struct Restore {
    /// The backup
    file: PathBuf,
    /// Check the backup and do nothing else
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    config: ConfigArgs,
}

impl Restore {
    pub fn run(self) -> anyhow::Result<()> {
        let file = self.file.display();
        if self.check {
            let checked = block_on(async { Ok(store::check(&self.file).await?) });
            println!("{file}: {}", contents_message(&checked.with_context(|| file.to_string())?));
            return Ok(());
        }
        let database = self.config.load()?.database;
        let restored = block_on(async { Ok(store::restore(&self.file, &database.options()).await?) });
        let to = database.options().shown();
        let failed = || said(message!("terminal_not_restored", file = file.to_string(), database = to.clone()));
        let holdings = restored.with_context(failed)?;
        println!("{to}: {}", contents_message(&holdings));
        Ok(())
    }
}
