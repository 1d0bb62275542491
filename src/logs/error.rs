//! Why a log becomes no campaign: a code with its parameters, and the file that it is about.

use crate::core::message::{Message, sent};
use crate::message;
use crate::wire::cause::by_system;

/// What is wrong, and in which file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}: {fault}")]
pub struct LogError {
    pub place: String,
    pub fault: Message,
}

impl LogError {
    /// A fault at a place in a file or map.
    pub fn new(place: impl Into<String>, fault: Message) -> Self {
        Self { place: place.into(), fault }
    }

    /// Place and fault in one message.
    pub fn message(&self) -> Message {
        message!("at_file", file = sent(&self.place), fault = self.fault.clone())
    }
}

/// What the operating system, or a library, says of a file.
pub fn unreadable(place: &str) -> impl Fn(std::io::Error) -> LogError + '_ {
    move |error| LogError::new(place, by_system(&error).unwrap_or_else(|| Message::verbatim(error)))
}
