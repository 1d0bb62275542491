//! Whether the delivery worker is at work.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A worker that has not looked around for so long is not at work.
const STUCK: Duration = Duration::from_secs(30);

/// When the worker last looked around. Cheap to clone.
#[derive(Debug, Clone, Default)]
pub(in crate::pipeline) struct Heartbeat(Arc<Mutex<Option<Instant>>>);

impl Heartbeat {
    pub fn beat(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
    }

    pub fn is_alive(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some_and(|last| last.elapsed() < STUCK)
    }
}
