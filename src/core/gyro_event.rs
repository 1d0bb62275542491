//! What was done to gyros.

use super::judge::{Event, FixedLevels};
use super::time::UtcMicros;

/// Something that was done to a gyro.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroEvent {
    pub at: UtcMicros,
    pub event: Event,
    /// When it was over, of what took time.
    pub until: Option<UtcMicros>,
    /// Which environmental test it was.
    pub test: Option<String>,
    /// Levels that a baseline mark states.
    pub fixed: FixedLevels,
    pub reason: String,
    pub author: Option<String>,
}

impl GyroEvent {
    /// When it was over.
    pub fn end(&self) -> UtcMicros {
        self.until.map_or(self.at, |until| until.max(self.at))
    }
}
