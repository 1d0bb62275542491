//! `[access]`: how often, and for how long.

use serde::Deserialize;

use super::ConfigError;
use super::error::{above_0, at_least_1};
use crate::core::message::Message;

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AccessConfig {
    pub open: bool,
    pub failures_per_minute: usize,
    pub requests_per_second: f64,
    pub session_hours: f64,
}

impl AccessConfig {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        let wrong = |key: &str, fault: Message| Err(ConfigError::of(format!("access.{key}"), fault));
        if self.failures_per_minute == 0 {
            return wrong("failures_per_minute", at_least_1(self.failures_per_minute));
        }
        if !(self.requests_per_second.is_finite() && self.requests_per_second >= 1.0) {
            return wrong("requests_per_second", at_least_1(self.requests_per_second));
        }
        if !(self.session_hours > 0.0 && self.session_hours <= 24.0 * 366.0) {
            return wrong("session_hours", above_0(24 * 366, self.session_hours));
        }
        Ok(())
    }
}
