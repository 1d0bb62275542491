//! What nearly every subcommand is written with.

pub(super) use std::path::{Path, PathBuf};

pub(super) use anyhow::{Context, bail};
pub(super) use clap::Args;

#[cfg(feature = "server")]
pub(super) use super::document::Format;
pub(super) use super::document::{self, table_of};
pub(super) use super::errors::{said, word};
pub(super) use crate::message;
pub(super) use crate::wire::time;
