//! Values that are written as text: read with words that say what is wanted.

use serde::{Deserialize, Deserializer, de};

use crate::core::time::UtcMicros;
use crate::wire::time;

/// A date, which begins at midnight UTC, or an RFC 3339 time.
pub(super) fn instant<'de, D: Deserializer<'de>>(deserializer: D) -> Result<UtcMicros, D::Error> {
    let text = String::deserialize(deserializer)?;
    time::parse(&text).or_else(|_| time::parse(&format!("{text}T00:00:00Z"))).map_err(|_| {
        de::Error::custom(format!(
            "must be a date or an RFC 3339 time, such as \"1950-01-01\" or \"1950-01-01T00:00:00Z\", is {text:?}"
        ))
    })
}
