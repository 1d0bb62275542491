//! The `[alerts]` section: how alerts behave between verdicts.

use serde::Deserialize;

use super::ConfigError;
use super::error::{at_least_1, between};
use crate::core::alert_decision::Policy;
use crate::core::message::{Message, text};
use crate::message;

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
        let wrong = |key: &str, fault: Message| Err(ConfigError::of(format!("alerts.{key}"), fault));
        if !(0.0..=1.0).contains(&self.resolve_below) {
            return wrong("resolve_below", between(0.0, 1.0, self.resolve_below));
        }
        if self.resolve_after == 0 {
            return wrong("resolve_after", at_least_1(self.resolve_after));
        }
        if !(0.01..=86400.0).contains(&self.tick_s) {
            return wrong("tick_s", between(0.01, 86400.0, self.tick_s));
        }
        if !self.backfill_days.is_finite() {
            return wrong("backfill_days", message!("not_finite", value = text(self.backfill_days)));
        }
        if self.backfill_days < 0.0 {
            return wrong("backfill_days", message!("config_negative", value = text(self.backfill_days)));
        }
        Ok(())
    }
}
