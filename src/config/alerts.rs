//! The `[alerts]` section: how alerts behave between verdicts.

use serde::Deserialize;

use super::ConfigError;
use super::error::{at_least_1, between, not_negative};
use crate::core::alert_decision::Policy;

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AlertsConfig {
    pub repeat_days: f64,
    pub resolve_below: f64,
    pub resolve_after: u32,
    pub tick_s: f64,
    pub backfill_days: f64,
}

impl AlertsConfig {
    pub fn policy(&self) -> Policy {
        let Self { repeat_days, resolve_below, resolve_after, backfill_days, tick_s: _ } = *self;
        Policy { repeat_days, resolve_below, resolve_after, backfill_days }
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        let require = |holds, key: &str, fault| ConfigError::unless(holds, format!("alerts.{key}"), fault);
        let Self { repeat_days: _, resolve_below, resolve_after, tick_s, backfill_days } = *self;
        require((0.0..=1.0).contains(&resolve_below), "resolve_below", between(0.0, 1.0, resolve_below))?;
        require(resolve_after > 0, "resolve_after", at_least_1(resolve_after))?;
        require((0.01..=86400.0).contains(&tick_s), "tick_s", between(0.01, 86400.0, tick_s))?;
        not_negative("alerts.backfill_days", backfill_days)
    }
}
