//! What is wrong with a configuration.

use std::fmt::{self, Display, Formatter};

use crate::core::message::{Message, text};
use crate::message;
use crate::wire::message::{read, to_part};
use crate::wire::text::said_of_keys;

#[derive(Debug, thiserror::Error)]
#[error("{}", self.message())]
pub enum ConfigError {
    Unreadable(String),
    Key { key: String, fault: Message },
}

impl ConfigError {
    pub(super) fn of(key: impl Into<String>, fault: Message) -> Self {
        Self::Key { key: key.into(), fault }
    }

    pub(super) fn unless(holds: bool, key: impl Into<String>, fault: Message) -> Result<(), Self> {
        if holds { Ok(()) } else { Err(Self::of(key, fault)) }
    }

    /// What is wrong, as a code with parameters.
    pub fn message(&self) -> Message {
        match self {
            Self::Unreadable(why) => message!("config_unreadable", why = why.clone()),
            Self::Key { key, fault } => message!("config_key", key = key.clone(), fault = fault.clone()),
        }
    }
}

/// A message on its way through serde, whose errors are texts.
#[derive(Debug)]
pub struct MessageError(pub Message);

impl Display for MessageError {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}", to_part(&self.0))
    }
}

/// What serde says of a value: a message that was carried, or what it finds itself.
pub(super) fn of_serde(error: &serde_json::Error) -> Message {
    let carried = serde_json::from_str(&error.to_string()).ok().and_then(|part| read(&part));
    carried.unwrap_or_else(|| said_of_keys(&error.to_string()))
}

impl From<config::ConfigError> for ConfigError {
    fn from(why: config::ConfigError) -> Self {
        Self::Unreadable(why.to_string())
    }
}

pub(super) fn at_least_1(value: impl Display) -> Message {
    message!("config_at_least", least = 1_usize, value = text(value))
}

pub(super) fn above_0(most: impl Display, value: f64) -> Message {
    message!("config_above_0", most = text(most), value = text(value))
}

pub(super) fn between(least: f64, most: f64, value: f64) -> Message {
    message!("config_between", least = text(least), most = text(most), value = text(value))
}

pub(super) fn not_negative(key: impl Into<String>, value: f64) -> Result<(), ConfigError> {
    let key = key.into();
    ConfigError::unless(value.is_finite(), key.clone(), message!("not_finite", value = text(value)))?;
    ConfigError::unless(value >= 0.0, key, message!("config_negative", value = text(value)))
}
