//! `[hooks]`: how and where to targets are told.

use std::path::PathBuf;
use std::time::Duration;

use ipnet::IpNet;
use serde::Deserialize;

use super::ConfigError;
use super::error::{above_0, between};
use super::values::{networks, numbers};
use crate::alert::deliver::AttemptLimits;
use crate::alert::mail::{MailError, Mailer};
use crate::alert::retry_schedule::{LONGEST_WAIT, RetrySchedule};
use crate::core::message::sent;
use crate::core::time::UtcMicros;
use crate::message;
use crate::system::Proxies;

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HooksConfig {
    #[serde(deserialize_with = "networks")]
    pub allow: Vec<IpNet>,
    pub external_url: String,
    pub proxy: String,
    pub connect_timeout_s: f64,
    pub attempt_timeout_s: f64,
    pub attempts_at_once: usize,
    #[serde(deserialize_with = "numbers")]
    pub retry_waits_s: Vec<f64>,
    pub resend_s: f64,
    pub old_secret_hours: f64,
    pub ca_file: Option<PathBuf>,
    pub smtp_url: String,
    pub mail_from: String,
}

/// No target, and no recipient of an e-mail, may hold an attempt for longer.
const LONGEST_ATTEMPT_S: f64 = 15.0;

impl HooksConfig {
    pub fn limits(&self) -> AttemptLimits {
        AttemptLimits {
            connect: Duration::from_secs_f64(self.connect_timeout_s),
            whole: Duration::from_secs_f64(self.attempt_timeout_s),
            ..AttemptLimits::default()
        }
    }

    pub fn retry_schedule(&self) -> RetrySchedule {
        RetrySchedule::new(self.retry_waits_s.iter().copied().map(Duration::from_secs_f64).collect())
    }

    /// Where people reach the service's pages; none where nobody has said.
    pub fn external_url(&self) -> Option<&str> {
        Some(self.external_url.trim_end_matches('/')).filter(|url| !url.is_empty())
    }

    /// By way of which proxies targets are told.
    pub fn proxies(&self) -> Proxies {
        Proxies::parse(&self.proxy).expect("the configuration was checked when it was read")
    }

    /// Whom e-mail is handed to; none where no mail server is named. `roots` as of [`Mailer::new`].
    pub fn mailer(&self, roots: Option<&[u8]>) -> Result<Option<Mailer>, MailError> {
        if self.smtp_url.is_empty() {
            return Ok(None);
        }
        Mailer::new(&self.smtp_url, &self.mail_from, self.limits().whole, roots).map(Some)
    }

    pub fn resend_every(&self) -> Duration {
        Duration::from_secs_f64(self.resend_s)
    }

    /// Until when a secret that is replaced at `now` signs as well.
    pub fn old_secret_until(&self, now: UtcMicros) -> UtcMicros {
        UtcMicros(now.0.saturating_add((self.old_secret_hours * 3.6e9) as i64))
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        let require = |holds, key: &str, fault| ConfigError::unless(holds, format!("hooks.{key}"), fault);
        let within = |key: &str, value, most| require(value > 0.0 && value <= most, key, above_0(most, value));
        within("attempt_timeout_s", self.attempt_timeout_s, LONGEST_ATTEMPT_S)?;
        within("connect_timeout_s", self.connect_timeout_s, self.attempt_timeout_s)?;
        within("attempts_at_once", self.attempts_at_once as f64, 256.0)?;
        within("resend_s", self.resend_s, 3600.0)?;
        within("retry_waits_s: how many", self.retry_waits_s.len() as f64, 100.0)?;
        for (i, wait) in self.retry_waits_s.iter().enumerate() {
            within(&format!("retry_waits_s[{i}]"), *wait, LONGEST_WAIT.as_secs_f64())?;
        }
        let (hours, most) = (self.old_secret_hours, 24.0 * 365.0);
        require((0.0..=most).contains(&hours), "old_secret_hours", between(0.0, most, hours))?;
        // It may hold a password, so that it is not repeated.
        require(Proxies::parse(&self.proxy).is_some(), "proxy", message!("config_proxy"))?;
        if let Err(error) = self.mailer(None) {
            let key = if matches!(error, MailError::From) { "hooks.mail_from" } else { "hooks.smtp_url" };
            return Err(ConfigError::of(key, error.message()));
        }
        let Some(url) = self.external_url() else { return Ok(()) };
        let is_http = url.starts_with("http://") || url.starts_with("https://");
        require(is_http, "external_url", message!("config_http", value = sent(url)))
    }
}
