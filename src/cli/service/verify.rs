//! `verify`: everything that was stored, computed again from what stations sent, and compared.

use std::sync::Arc;

use super::settings::ConfigArgs;
use crate::cli::common::block_on;
use crate::cli::prelude::*;
use crate::pipeline::{Pipeline, Verified};
use crate::store;
use crate::system::Clock;

/// Compute every stored separation and verdict again from what was sent, and compare; exit status 1 names what differs
#[derive(Debug, Args)]
pub struct Verify {
    #[command(flatten)]
    config: ConfigArgs,
}

/// Differences that are printed; all are counted.
const MOST_SHOWN: usize = 100;

impl Verify {
    pub fn run(self) -> anyhow::Result<()> {
        let config = self.config.load()?;
        let options = config.database.options();
        let url = options.shown();
        let work = async {
            // First what is read from the database at all: structure, hashes, checksums. The records follow one by one.
            store::check_all_but_records(&options).await?;
            let store = store::open_to_read(&options).await?;
            let reading = Pipeline::to_read(store, Arc::new(config), Clock::System).await?;
            let mut verified = reading.queries.records.verify().await?;
            // Last, so that what has a name of its own is named by it.
            verified.faults.extend(store::check_checksums(&options)?);
            Ok(verified)
        };
        report(&block_on(work).with_context(|| said(message!("terminal_database", url)))?)
    }
}

fn report(verified: &Verified) -> anyhow::Result<()> {
    let Verified { records, separations, verdicts, bench_results, heads, not_compared, faults } = verified;
    for fault in faults.iter().take(MOST_SHOWN) {
        document::print(&said(fault))?;
    }
    let mut lines = vec![
        message!(
            "terminal_verified",
            records = records.to_string(),
            separations = separations.to_string(),
            verdicts = verdicts.to_string(),
            bench_results = bench_results.to_string()
        ),
        match heads {
            Some(gyros) => message!("terminal_lists_verified", gyros = gyros.to_string()),
            None => message!("terminal_lists_not_compared"),
        },
    ];
    if *not_compared > 0 {
        lines.push(message!("terminal_not_compared", verdicts = not_compared.to_string()));
    }
    lines.into_iter().try_for_each(|line| document::print(&said(line)))?;
    if !faults.is_empty() {
        bail!(said(message!("terminal_differ", count = faults.len().to_string())));
    }
    Ok(())
}
