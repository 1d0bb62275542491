//! `[access]`: how often, and for how long.

use serde::Deserialize;

use super::ConfigError;
use super::error::{above_0, at_least_1};

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
        let require = |holds, key: &str, fault| ConfigError::unless(holds, format!("access.{key}"), fault);
        require(self.failures_per_minute > 0, "failures_per_minute", at_least_1(self.failures_per_minute))?;
        let rate = self.requests_per_second;
        require(rate.is_finite() && rate >= 1.0, "requests_per_second", at_least_1(rate))?;
        let (hours, most) = (self.session_hours, 24 * 366);
        require(hours > 0.0 && hours <= f64::from(most), "session_hours", above_0(most, hours))
    }
}
