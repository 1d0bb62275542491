//! After a flush that failed nothing is written any more.
//!
//! The system may have marked the pages that it could not write as clean: another flush would succeed and mean
//! nothing. So none is tried, neither by the connection that commits nor by the one that copies the log, and both are
//! left open to the end, for closing the last one would copy and flush once more. The next start copies the log anew
//! before it adds to it.

use std::sync::{Arc, OnceLock};

use crate::store::error::{Result, StoreError};

/// Whether a flush has failed, for whichever connection; never taken back.
#[derive(Debug, Clone, Default)]
pub(crate) struct FlushFailure(Arc<OnceLock<String>>);

impl FlushFailure {
    /// # Errors
    /// [`StoreError::NotDurable`] from the first failed flush on.
    pub fn check(&self) -> Result<()> {
        self.0.get().map_or(Ok(()), |why| Err(StoreError::NotDurable(why.clone())))
    }

    /// Hands an outcome on, and keeps in mind a flush that failed.
    pub fn record<T>(&self, outcome: Result<T>) -> Result<T> {
        if let Err(StoreError::NotDurable(why)) = &outcome
            && self.0.set(why.clone()).is_ok()
        {
            tracing::error!(%why, "a flush of the disk failed: nothing is stored until a restart");
        }
        outcome
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_flush_is_heard_of_by_everyone_and_other_failures_are_not() {
        let (flush_failure, other) = (FlushFailure::default(), FlushFailure::default());
        let beside = flush_failure.clone();
        assert!(flush_failure.record::<()>(Err(StoreError::Full)).is_err());
        beside.check().unwrap();
        assert!(flush_failure.record::<()>(Err(StoreError::NotDurable("EIO".into()))).is_err());
        assert!(matches!(beside.check(), Err(StoreError::NotDurable(why)) if why == "EIO"));
        other.check().unwrap();
    }
}
