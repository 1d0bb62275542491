//! What nearly every file of the pipeline is written with.

pub(super) use super::error::{OrderError, StorageError, WriteError};
pub(super) use crate::core::figures::Figures;
pub(super) use crate::core::id::Id;
pub(super) use crate::core::kind::Kind;
pub(super) use crate::core::time::{Span, UtcMicros};
pub(super) use crate::message;
pub(super) use crate::store::{self, Changes, Store, StoreError};
