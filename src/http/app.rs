//! What handlers work with.

use std::sync::Arc;

use crate::config::Config;
use crate::pipeline::Pipeline;
use crate::system::Clock;

/// What every handler may use. Cheap to clone.
#[derive(Clone)]
pub struct App {
    pub config: Arc<Config>,
    pub clock: Clock,
    pub pipeline: Arc<Pipeline>,
}
