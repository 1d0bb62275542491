//! What nearly every subcommand is written with.

pub(super) use std::path::{Path, PathBuf};

pub(super) use anyhow::{Context, bail};
pub(super) use clap::Args;

pub(super) use super::document::{self, Format, table_of};
pub(super) use super::errors::{said, word};
pub(super) use crate::message;
pub(super) use crate::wire::time;
