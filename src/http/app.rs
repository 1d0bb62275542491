//! What every handler may use.

use std::sync::Arc;

use crate::config::Config;
use crate::pipeline::Pipeline;
use crate::system::Clock;

/// Cheap to clone.
#[derive(Clone)]
pub struct App {
    pub config: Arc<Config>,
    pub clock: Clock,
    pub pipeline: Arc<Pipeline>,
}
