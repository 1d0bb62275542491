//! Values that are written as text: read with words that say what is wanted.

use std::net::{IpAddr, SocketAddr};

use ipnet::IpNet;
use serde::{Deserialize, Deserializer, de};
use serde_json::Value;

use super::error::MessageError;
use crate::core::message::{Message, sent};
use crate::core::time::UtcMicros;
use crate::message;
use crate::wire::time;

/// Text, or a number as it is written: an environment variable that holds nothing else (a port, a year) is read as a
/// number.
fn as_written<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    Ok(match Value::deserialize(deserializer)? {
        Value::String(text) => text,
        other => other.to_string(),
    })
}

/// An IP address and a port. A name is refused: it may lead to several addresses, or elsewhere tomorrow.
pub(super) fn address<'de, D: Deserializer<'de>>(deserializer: D) -> Result<SocketAddr, D::Error> {
    let text = as_written(deserializer)?;
    found(text.parse().ok(), message!("config_address"), &text)
}

/// A date, which begins at midnight UTC, or an RFC 3339 time.
pub(super) fn instant<'de, D: Deserializer<'de>>(deserializer: D) -> Result<UtcMicros, D::Error> {
    parsed(as_written(deserializer)?)
}

/// A list of them.
pub(super) fn instants<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<UtcMicros>, D::Error> {
    items(deserializer)?.into_iter().map(parsed).collect()
}

/// A list of networks; an address is a network of its own.
pub(super) fn networks<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<IpNet>, D::Error> {
    let network = |item: String| {
        let read = item.parse::<IpNet>().ok().or_else(|| Some(item.parse::<IpAddr>().ok()?.into()));
        found(read, message!("config_networks"), &item)
    };
    items(deserializer)?.into_iter().map(network).collect()
}

/// A list of numbers.
pub(super) fn numbers<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    let number = |item: String| found(item.parse().ok(), message!("config_numbers"), &item);
    items(deserializer)?.into_iter().map(number).collect()
}

fn parsed<E: de::Error>(text: String) -> Result<UtcMicros, E> {
    found(time::parse_start(&text).ok(), message!("config_instant"), &text)
}

fn found<T, E: de::Error>(read: Option<T>, wanted: Message, text: &str) -> Result<T, E> {
    read.ok_or_else(|| E::custom(MessageError(message!("must_be", wanted, value = sent(text)))))
}

/// A list, or its items in one text with commas between: an environment variable holds no list.
fn items<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<String>, D::Error> {
    let text = |item: &Value| item.as_str().map_or_else(|| item.to_string(), str::to_owned);
    Ok(match Value::deserialize(deserializer)? {
        Value::Array(items) => items.iter().map(text).collect(),
        one => text(&one).split(',').map(|item| item.trim().to_owned()).filter(|item| !item.is_empty()).collect(),
    })
}
