//! The `[alerts]` section: how alerts behave between verdicts.

use serde::Deserialize;

use super::ConfigError;
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
        let wrong = |key: &str, detail: String| Err(ConfigError::Key { key: format!("alerts.{key}"), detail });
        if !(self.repeat_days.is_finite() && self.repeat_days > 0.0) {
            return wrong("repeat_days", format!("must be positive, is {}", self.repeat_days));
        }
        if !(0.0..=1.0).contains(&self.resolve_below) {
            return wrong("resolve_below", format!("must lie between 0 and 1, is {}", self.resolve_below));
        }
        if self.resolve_after == 0 {
            return wrong("resolve_after", "must be at least 1".into());
        }
        if !(0.01..=86400.0).contains(&self.tick_s) {
            return wrong("tick_s", format!("must lie between 0.01 and 86400, is {}", self.tick_s));
        }
        if !(self.backfill_days.is_finite() && self.backfill_days >= 0.0) {
            return wrong("backfill_days", format!("must be 0 or more, is {}", self.backfill_days));
        }
        Ok(())
    }
}
