//! `[access]`: how often, and for how long.

use serde::Deserialize;

use super::ConfigError;

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
        let wrong = |key: &str, detail: String| Err(ConfigError::Key { key: format!("access.{key}"), detail });
        if self.failures_per_minute == 0 {
            return wrong("failures_per_minute", "must be at least 1".into());
        }
        if !(self.requests_per_second.is_finite() && self.requests_per_second >= 1.0) {
            return wrong("requests_per_second", format!("must be at least 1, is {}", self.requests_per_second));
        }
        if !(self.session_hours > 0.0 && self.session_hours <= 24.0 * 366.0) {
            return wrong("session_hours", format!("must be above 0 and at most a year, is {}", self.session_hours));
        }
        Ok(())
    }
}
