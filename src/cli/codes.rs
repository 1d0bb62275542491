//! `codes`: every message that the service may answer.

use super::prelude::*;
use crate::words;

/// Print every code of an error, with the names of its parameters and its words
///
/// In the language of the environment: Chinese where LC_ALL or LANG begins with zh.
#[derive(Debug, Args)]
pub struct Codes;

impl Codes {
    pub fn run(&self) -> anyhow::Result<()> {
        document::print(words::sources(words::asked()).join("\n").trim_end())
    }
}
