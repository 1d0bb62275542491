//! `completions` and `man`: what a shell and `man` know of the command line, made from its definition.

use std::{fs, io};

use clap::Command;
use clap_complete::Shell;

use super::prelude::*;

/// Print what completes commands and options in a shell
///
/// bash: gyrowatch completions bash > /etc/bash_completion.d/gyrowatch
#[derive(Debug, Args)]
pub struct Completions {
    /// Shell that reads it
    shell: Shell,
}

impl Completions {
    /// `command`: the whole command line.
    pub fn run(self, mut command: Command) -> anyhow::Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut command, "gyrowatch", &mut script);
        document::print(String::from_utf8(script)?.trim_end())
    }
}

/// Print the manual page, or write a page for each command into a directory
#[derive(Debug, Args)]
pub struct ManPage {
    /// Directory for gyrowatch.1, gyrowatch-serve.1, and so on
    directory: Option<PathBuf>,
}

impl ManPage {
    /// `command`: the whole command line.
    pub fn run(self, command: Command) -> anyhow::Result<()> {
        let Some(directory) = self.directory else {
            return document::print(String::from_utf8(page(command)?)?.trim_end());
        };
        fs::create_dir_all(&directory).with_context(|| directory.display().to_string())?;
        // The version stands on the first page.
        let command = command.disable_help_subcommand(true);
        for (name, command) in pages("gyrowatch".to_owned(), command) {
            let file = directory.join(format!("{name}.1"));
            fs::write(&file, page(command)?).with_context(|| file.display().to_string())?;
        }
        Ok(())
    }
}

/// A command and its subcommands, each with the name of its page.
fn pages(name: String, command: Command) -> Vec<(String, Command)> {
    let below: Vec<_> = command
        .get_subcommands()
        .filter(|below| !below.is_hide_set())
        .flat_map(|below| pages(format!("{name}-{}", below.get_name()), below.clone()))
        .collect();
    let shown = command.name(name.clone()).display_name(name.clone());
    [vec![(name, shown)], below].concat()
}

fn page(command: Command) -> io::Result<Vec<u8>> {
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page)?;
    Ok(page)
}
