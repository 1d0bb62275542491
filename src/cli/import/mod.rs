//! `import`: sends files to a running service. Sending again does no harm, so that is how to resume.

mod answer_summary;
#[cfg(unix)]
mod folder;
#[cfg(windows)]
#[path = "folder_windows.rs"]
mod folder;
mod revise;
mod send;
pub(super) mod source;
mod watch;

use std::time::Duration;

use indicatif::ProgressBar;

use super::client::{Connection, Service};
use super::common::{block_on, progress, wrong};
use super::prelude::*;
use crate::logs::error::LogError;
use crate::logs::text::of_any;
use crate::wire::record_table::TableMap;
use crate::wire::text::map_fault;
use answer_summary::AnswerSummary;
pub(super) use answer_summary::withdrawn;
use send::{Event, ImportCounts, Importer, PATIENCE, end};
use source::Content;

/// Send records, campaigns and bench results (JSON, NDJSON, CSV) to a running service
#[derive(Debug, clap::Args)]
pub struct Import {
    /// Files to send; `-` is standard input
    #[arg(required_unless_present = "watch", conflicts_with = "watch")]
    files: Vec<PathBuf>,

    /// Instead of files: send what appears in DIR, move it to DIR/sent, or to DIR/refused with the reason beside it
    #[arg(long, value_name = "DIR")]
    watch: Option<PathBuf>,

    /// Give up at once where the service is down or busy, instead of asking again for half a minute
    #[arg(long, conflicts_with = "watch")]
    no_retry: bool,

    /// With --watch: seconds for which a file must not change before it is sent [default: 1 of *.json, else 30, since
    /// nothing else says when a table or a file of lines is whole but a head line `# dwells: N`]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    settle: Option<f64>,

    /// Who is told of what gyros did longer ago than `alerts.backfill_days`
    #[arg(long, value_enum, default_value_t = Notify::Digest)]
    notify: Notify,

    /// What the columns of a table of records or bench results mean (TOML), where its header is your own
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,

    /// Print the documents that a table comes to, one a line, instead of sending them
    #[arg(long, conflicts_with = "watch")]
    print: bool,

    #[command(flatten)]
    connection: Connection,
}

/// Who is told of what is found late.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Notify {
    /// Hooks hear every change of every alert
    All,
    /// Hooks hear in one message what still fires
    Digest,
    /// Nobody
    None,
}

impl Notify {
    /// More requests of the same import follow: its end is said by [`end`].
    fn query(self) -> &'static str {
        match self {
            Self::All => "?notify=all",
            Self::Digest => "?notify=digest&more=true",
            Self::None => "?notify=none",
        }
    }
}

impl Import {
    pub fn run(self) -> anyhow::Result<()> {
        let map = self.map.as_deref().map(table_map).transpose()?.unwrap_or_default();
        if self.print {
            return self.files.iter().try_for_each(|path| print(path, &map));
        }
        let service = self.connection.service()?.with_notify_query(self.notify.query());
        let digest = self.notify == Notify::Digest;
        match self.watch {
            Some(dir) => {
                let settle = self.settle.map(Duration::from_secs_f64);
                block_on(watch::watch(&dir, map, settle, &service, digest))
            }
            None => {
                let pauses: &[Duration] = if self.no_retry { &[] } else { &PATIENCE };
                block_on(import(&self.files, &map, &service, digest, pauses))
            }
        }
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=3600.0).contains(seconds));
    seconds.ok_or_else(|| wrong(message!("argument_seconds")))
}

fn table_map(path: &Path) -> anyhow::Result<TableMap> {
    let text = of_any(&std::fs::read(path).with_context(|| path.display().to_string())?);
    toml::from_str(&text).map_err(|error| LogError::new(path.display().to_string(), map_fault(&error, &text)).into())
}

fn print(path: &Path, map: &TableMap) -> anyhow::Result<()> {
    match source::open(path, map)? {
        Ok(Content::Members(members) | Content::Table(members, _)) => {
            members.iter().try_for_each(|(_, text)| document::print(&String::from_utf8_lossy(text)))
        }
        Ok(_) => {
            let nothing = word("file_nothing_to_print");
            bail!("{}: {nothing}", path.display())
        }
        Err(unreadable) => bail!("{}: {}", path.display(), unreadable.why),
    }
}

async fn import(
    files: &[PathBuf],
    map: &TableMap,
    service: &Service,
    digest: bool,
    pauses: &[Duration],
) -> anyhow::Result<()> {
    let bar = progress_bar(files);
    let mut total = ImportCounts::default();
    for path in files {
        let name = path.display();
        bar.set_message(name.to_string());
        let mut summary = String::new();
        let tally = match source::open(path, map)? {
            Ok(content) => {
                let mut tell = |event: Event<'_>| match event {
                    Event::Carried { bytes } => bar.inc(bytes),
                    Event::Refused(refusal) => {
                        bar.suspend(|| eprintln!("{name}:{}{refusal}", if refusal.line.is_some() { "" } else { " " }))
                    }
                    Event::Answered(answer) => summary = AnswerSummary(answer).to_string(),
                    Event::Noted { line, note } => {
                        bar.suspend(|| eprintln!("{name}:{line}: {}", document::note(note)));
                    }
                };
                let carried = Importer::new(service, pauses, &mut tell).carry(content).await;
                carried.with_context(|| format!("{name}: {}", word("terminal_interrupted")))?
            }
            Err(unreadable) => {
                bar.suspend(|| eprintln!("{name}: {}", unreadable.why));
                ImportCounts { refused: 1, ..ImportCounts::default() }
            }
        };
        bar.suspend(|| document::print(format!("{name}: {tally}\n{summary}").trim_end()))?;
        total += tally;
    }
    bar.finish_and_clear();
    if digest {
        end(service).await;
    }
    if files.len() > 1 {
        document::print(&said(message!("terminal_together", tally = total.to_string())))?;
    }
    if total.refused > 0 {
        bail!(said(message!("terminal_refused", count = total.refused.to_string())));
    }
    Ok(())
}

/// Counts bytes, because the number of documents in a file is known only at its end.
fn progress_bar(files: &[PathBuf]) -> ProgressBar {
    let sizes = files.iter().filter_map(|path| std::fs::metadata(path).ok()).map(|m| m.len());
    progress(sizes.sum(), "{bar:30} {bytes}/{total_bytes} {bytes_per_sec} {msg}")
}

#[cfg(test)]
mod tests;
