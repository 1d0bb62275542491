//! `[access]`: how often, and for how long.

use serde::Deserialize;

use super::ConfigError;
use crate::core::message::{Message, text};
use crate::message;

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
            return wrong(
                "failures_per_minute",
                message!("config_at_least", least = 1_usize, value = self.failures_per_minute),
            );
        }
        if !(self.requests_per_second.is_finite() && self.requests_per_second >= 1.0) {
            return wrong(
                "requests_per_second",
                message!("config_at_least", least = 1_usize, value = text(self.requests_per_second)),
            );
        }
        if !(self.session_hours > 0.0 && self.session_hours <= 24.0 * 366.0) {
            return wrong(
                "session_hours",
                message!("config_above_0", most = text(24 * 366), value = text(self.session_hours)),
            );
        }
        Ok(())
    }
}
