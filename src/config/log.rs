//! The `[log]` section.

use serde::Deserialize;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::LevelFilter;

use super::ConfigError;
use crate::core::message::{Message, sent};
use crate::message;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LogFormat {
    Text,
    Json,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Log {
    pub format: LogFormat,
    pub filter: String,
}

impl Log {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        fault_of(&self.filter).map_or(Ok(()), |fault| Err(ConfigError::of("log.filter", fault)))
    }
}

/// A word alone that is no level would be taken for a module: all of that one, and nothing else, would be logged.
fn fault_of(filter: &str) -> Option<Message> {
    if let Err(why) = EnvFilter::try_new(filter) {
        return Some(Message::verbatim(why));
    }
    let is_word = |part: &&str| part.chars().all(|c| c.is_alphanumeric() || c == '-' || c == '_');
    let is_known = |part: &str| part.is_empty() || part == "gyrowatch" || part.parse::<LevelFilter>().is_ok();
    let mut parts = filter.split(',');
    let word = parts.find(|part| is_word(part) && !is_known(part))?;
    Some(message!("config_log_filter", value = sent(word)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_that_is_no_level_is_refused() {
        for filter in ["loud", "info,loud", "gyrowatch=loud", "verbose"] {
            assert!(fault_of(filter).is_some(), "{filter}");
        }
        for filter in
            ["info", "WARN", "off", "", "gyrowatch", "gyrowatch=debug", "warn,gyrowatch::http=trace", "[span{a}]=debug"]
        {
            assert_eq!(fault_of(filter), None, "{filter}");
        }
    }
}
