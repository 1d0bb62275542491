//! What readers and writers hold in memory together.

use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

#[derive(Debug, Default)]
pub struct Shared<T>(Arc<RwLock<T>>);

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<T> Shared<T> {
    pub(super) fn new(all: T) -> Self {
        Self(Arc::new(RwLock::new(all)))
    }

    /// Of what waits to be put into its place, to be asked before the database: what is put there in between is then
    /// seen in both rather than in neither.
    pub fn read(&self) -> RwLockReadGuard<'_, T> {
        // Every change leaves it whole, even one that panics.
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn change<R>(&self, change: impl FnOnce(&mut T) -> R) -> R {
        change(&mut self.0.write().unwrap_or_else(PoisonError::into_inner))
    }
}
