//! Why a gap cannot be split.

use crate::core::diagnose::NoReference;
use crate::core::id::Id;
use crate::pipeline::error::StorageError;
use crate::store::StoreError;

/// Why a diagnosis cannot be held against a reference.
#[derive(Debug, thiserror::Error)]
pub enum NotSplit {
    #[error("there is no campaign or record {0}")]
    NoSuchReference(Id),
    #[error(transparent)]
    NoReference(#[from] NoReference),
    #[error(transparent)]
    Storage(#[from] StorageError),
}

impl From<StoreError> for NotSplit {
    fn from(error: StoreError) -> Self {
        Self::Storage(error.into())
    }
}
