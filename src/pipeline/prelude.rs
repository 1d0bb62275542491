//! What nearly every file of the pipeline is written with.

pub(super) use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
pub(super) use std::sync::Arc;
pub(super) use std::time::Duration;

pub(super) use super::error::{Refused, computed};
pub(super) use super::{Accepted, Actor};
pub(super) use crate::config::Config;
pub(super) use crate::core::alert_decision::Late;
pub(super) use crate::core::fault::Faults;
pub(super) use crate::core::figures::Figures;
pub(super) use crate::core::id::Id;
pub(super) use crate::core::judge::{Rule, Verdict};
pub(super) use crate::core::kind::Kind;
pub(super) use crate::core::message::{Message, text};
pub(super) use crate::core::note::Note;
pub(super) use crate::core::time::{Span, UtcMicros};
pub(super) use crate::message;
pub(super) use crate::store::{self, Changes, Store, StoreError};
pub(super) use crate::system::Clock;
pub(super) use crate::wire::problem::Problem;
