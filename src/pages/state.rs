//! What every page may use.

use std::sync::Arc;

use serde_json::Value;

use crate::config::Config;
use crate::pipeline::Pipeline;
use crate::system::Clock;
use crate::wire::problem::Problem;
use crate::words;

/// Cheap to clone.
#[derive(Clone)]
pub struct Pages {
    pub config: Arc<Config>,
    pub clock: Clock,
    pub pipeline: Arc<Pipeline>,
    /// The OpenAPI document.
    pub api: Arc<Value>,
}

impl Pages {
    pub(super) fn gyro_number(&self, serial: &str) -> Result<u32, Problem> {
        self.pipeline.queries.names().gyro_number(serial).ok_or_else(|| Problem::unknown_gyro(serial))
    }
}

/// For what takes its time: other requests are not to wait for it.
pub(super) async fn off_the_loop<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> T {
    match words::spawn_blocking(work).await {
        Ok(done) => done,
        // It is never cancelled, so it has panicked: as if it had done so here.
        Err(failed) => std::panic::resume_unwind(failed.into_panic()),
    }
}
