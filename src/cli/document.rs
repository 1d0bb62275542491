//! What the subcommands that read one document and print one result have in common.

use std::io::{Read, Write};
use std::path::Path;

use anyhow::{Context, ensure};
use comfy_table::{CellAlignment, Table, presets};
use serde::Serialize;

/// Largest document that is read: far above any campaign, far below memory.
const MAX_BYTES: u64 = 16 << 20;

/// How a result is printed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// A table for people
    #[default]
    Table,
    /// The JSON that the service answers
    Json,
}

/// Reads a file whole, or standard input for `-`.
pub fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = if path == Path::new("-") {
        std::io::stdin().take(MAX_BYTES + 1).read_to_end(&mut bytes)
    } else {
        std::fs::File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
    };
    read.with_context(|| name(path))?;
    ensure!(bytes.len() as u64 <= MAX_BYTES, "{}: is larger than {MAX_BYTES} bytes", name(path));
    Ok(bytes)
}

/// The file as messages name it.
pub fn name(path: &Path) -> String {
    if path == Path::new("-") { "standard input".to_owned() } else { path.display().to_string() }
}

/// Prints a result as JSON, alone on standard output.
pub fn print_json(result: &impl Serialize) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    serde_json::to_writer_pretty(&mut out, result).map_err(std::io::Error::from)?;
    writeln!(out)?;
    Ok(())
}

/// Prints text for people. Unlike `println!` it fails, not panics, where nobody reads any more.
pub fn print(text: &str) -> anyhow::Result<()> {
    writeln!(std::io::stdout(), "{text}")?;
    Ok(())
}

/// A table with a rule under its head; the columns `figures` are set to the right.
pub fn table<const N: usize>(head: [&str; N], figures: std::ops::Range<usize>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED).set_header(head);
    for column in figures {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}
