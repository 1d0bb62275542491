//! `copy`: a database in a file taken over to PostgreSQL.

use indicatif::{ProgressBar, ProgressStyle};

use crate::cli::common::block_on;
use crate::cli::prelude::*;
use crate::config::Config;
use crate::store::{self, Copied, Options};

/// Copy a database from a file to an empty one on PostgreSQL and compare the two; interrupted, it goes on when run
/// again
#[derive(Debug, Args)]
pub struct Copy {
    /// The database to copy, which no service serves meanwhile
    #[arg(long, value_name = "sqlite://PATH")]
    from: String,
    /// Where to
    #[arg(long, value_name = "postgres://…")]
    to: String,
}

impl Copy {
    pub fn run(self) -> anyhow::Result<()> {
        let options = |url: &str| Options { url: url.to_owned(), ..Config::defaults().database.options() };
        let (from, to) = (options(&self.from), options(&self.to));
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{elapsed} {msg}") {
            bar.set_style(style);
        }
        let work = async {
            let each = |table, rows| bar.set_message(format!("{table}: {rows}"));
            Ok(store::copy(&from, &to, each).await?)
        };
        let compared = block_on(work);
        bar.finish_and_clear();
        let (from, to) = (from.shown(), to.shown());
        let failed = || said(message!("terminal_not_copied", from = from.clone(), to = to.clone()));
        let compared = compared.with_context(failed)?;
        document::print(&shown(&compared))?;
        if !compared.iter().all(Copied::is_whole) {
            bail!(word("terminal_copy_differs"));
        }
        document::print(&said(message!("terminal_copied", from, to)))
    }
}

fn shown(compared: &[Copied]) -> String {
    let mut table = document::table_of("terminal_copied_head", 1..3);
    for copied in compared {
        let [rows, found] = copied.rows;
        let verdict = word(if copied.is_whole() { "terminal_same" } else { "terminal_different" });
        let checksum = format!("{:032x}", copied.checksums[0]);
        table.add_row([copied.table, &rows.to_string(), &found.to_string(), &checksum[..16], verdict]);
    }
    table.to_string()
}
