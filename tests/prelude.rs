//! What nearly every test of the program is written with.

pub(crate) use std::collections::{BTreeMap, BTreeSet};
pub(crate) use std::path::{Path, PathBuf};
pub(crate) use std::process::{Command, Stdio};
pub(crate) use std::sync::Arc;
pub(crate) use std::time::{Duration, Instant};

pub(crate) use serde_json::{Value, json};

pub(crate) use crate::lab::{Lab, day, record};
pub(crate) use crate::receiver::Receiver;
pub(crate) use crate::support::{
    self, Running, Server, data, document, gyrowatch, holds, id, once, paper_record, root,
};
pub(crate) use crate::{behind, cluster};
