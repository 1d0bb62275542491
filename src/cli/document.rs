//! What the subcommands that read one document and print one result have in common.

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use comfy_table::{CellAlignment, Table, presets};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::cli::errors::{said, word};
use crate::core::message::Message;
use crate::logs::error::LogError;
use crate::logs::sheet::readable;
pub use crate::logs::source::name;
use crate::message;
use crate::wire::document::open_table;
use crate::wire::note;
use crate::wire::text::toml_fault;

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

impl Format {
    /// Prints an answer, or the tables that people read in its place.
    pub fn show(self, answer: &impl Serialize, tables: impl FnOnce() -> String) -> anyhow::Result<()> {
        match self {
            Self::Table => print(&tables()),
            Self::Json => print_json(answer),
        }
    }
}

/// Reads a file whole, or standard input for `-`.
pub fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = if path == Path::new("-") {
        std::io::stdin().take(MAX_BYTES + 1).read_to_end(&mut bytes)
    } else {
        File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
    };
    read.with_context(|| name(path))?;
    if bytes.len() as u64 > MAX_BYTES {
        bail!("{}: {}", name(path), said(message!("terminal_too_large", most = MAX_BYTES.to_string())));
    }
    readable(bytes).map_err(|fault| LogError::new(name(path), fault).into())
}

/// The text of a file.
pub fn text(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| name(path))
}

/// What a file in TOML says.
pub fn toml<T: DeserializeOwned>(path: &Path) -> anyhow::Result<T> {
    let text = text(path)?;
    toml::from_str(&text).map_err(|error| LogError::new(name(path), toml_fault(&error, &text)).into())
}

/// Writes a file as [`put`] does, and says on standard error where it took the place of another.
pub fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    if put(path, text)? {
        eprintln!("{}", said(message!("terminal_file_replaced", file = path.display().to_string())));
    }
    Ok(())
}

/// Writes files into a folder, which is made where it is missing, and says on standard error how many took the place
/// of others.
pub fn write_all(dir: &Path, files: impl Iterator<Item = anyhow::Result<(String, String)>>) -> anyhow::Result<()> {
    std::fs::create_dir_all(dir).with_context(|| dir.display().to_string())?;
    let mut replaced = 0_u64;
    for file in files {
        let (name, text) = file?;
        replaced += u64::from(put(&dir.join(name), &text)?);
    }
    if replaced > 0 {
        eprintln!(
            "{}",
            said(message!("terminal_files_replaced", count = replaced, folder = dir.display().to_string()))
        );
    }
    Ok(())
}

/// Writes a file whole or not at all; whether there was one before.
///
/// The text is written beside the file and renamed onto it: whoever reads the file sees the old one or the new one,
/// also where the disk is full. What is no regular file (a pipe, `/dev/stdout`) is written to as it is.
fn put(path: &Path, text: &str) -> anyhow::Result<bool> {
    let replaced = match std::fs::metadata(path) {
        Ok(there) if !there.is_file() => {
            return std::fs::write(path, text).map(|()| false).with_context(|| name(path));
        }
        Ok(_) => true,
        Err(_) => false,
    };
    // A link stays one: what it leads to is replaced.
    let target = if replaced { std::fs::canonicalize(path).with_context(|| name(path))? } else { path.to_owned() };
    let mut part = target.clone().into_os_string();
    part.push(format!(".{}.part", std::process::id()));
    let part = PathBuf::from(part);
    let written = write_and_rename(&part, &target, text, replaced);
    if written.is_err() {
        let _may_not_be_there = std::fs::remove_file(&part);
    }
    written.with_context(|| name(path))?;
    Ok(replaced)
}

fn write_and_rename(part: &Path, target: &Path, text: &str, replaces: bool) -> std::io::Result<()> {
    let mut file = File::create_new(part)?;
    if replaces {
        file.set_permissions(std::fs::metadata(target)?.permissions())?;
    }
    file.write_all(text.as_bytes())?;
    std::fs::rename(part, target)
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

/// Says on standard error where a table may have been cut.
pub fn note_open_end(path: &Path, bytes: &[u8]) {
    if let Some(open) = open_table(bytes) {
        eprintln!("{}: {}", name(path), said(note::message(&open)));
    }
}

/// A note below a result.
pub fn note(words: &str) -> String {
    said(message!("terminal_note", note = words.to_owned()))
}

/// The verdict of a diagnosis as a heading says it.
pub fn verdict(code: &str) -> Message {
    match code {
        "no_gap" => message!("terminal_no_gap"),
        "explained" => message!("terminal_explained"),
        "partly_explained" => message!("terminal_partly_explained"),
        "unexplained" => message!("terminal_unexplained"),
        other => Message::verbatim(other.replace('_', " ")),
    }
}

/// A count beside that of all.
pub fn part_of(part: String, all: u64) -> String {
    said(message!("terminal_of", part, all = all.to_string()))
}

/// A coefficient in its own unit, and its standard deviation where it is known.
pub fn coefficient(value: f64, sd: Option<f64>) -> String {
    let sd = sd.map(|sd| format!(" ± {sd:.1e}")).unwrap_or_default();
    format!("{value:+.3e}{sd}")
}

/// A table with the head that a message names, and a rule under it; the columns `figures` are set to the right.
pub fn table_of(head: &str, figures: std::ops::Range<usize>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED).set_header(word(head).split(" | "));
    for column in figures {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}
