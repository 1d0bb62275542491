//! Words for the person who ran the command: messages, and errors with their causes.

use std::borrow::Borrow;
use std::error::Error;

use super::faults;
use crate::core::diagnose::NoReference;
use crate::core::effects::Refusal;
use crate::core::fault::Faults;
use crate::core::imu_model::{NoForecast, NotIdentified};
use crate::core::message::Message;
use crate::logs::error::LogError;
use crate::simulate::augment::NotPossible;
use crate::wire::cause::by_system;
use crate::wire::json::said_of;
use crate::words;

/// A message in the language of the environment.
pub(super) fn said(message: impl Borrow<Message>) -> String {
    words::asked().words(message.borrow())
}

/// A message without parameters, by its code.
pub(super) fn word(code: &str) -> &'static str {
    words::asked().word(code)
}

/// The error and its causes, in the language of the environment.
pub(super) fn with_causes(error: &anyhow::Error) -> String {
    let one = |cause: &(dyn Error + 'static)| match cause.downcast_ref::<Faults>() {
        Some(found) => faults::in_words(found),
        None => message_of(cause).map_or_else(|| cause.to_string(), said),
    };
    error.chain().map(one).collect::<Vec<_>>().join(": ")
}

/// The message of the first of these types that the error is of.
macro_rules! message_of {
    ($cause:expr, $($of:ty),*) => {
        None$(.or_else(|| $cause.downcast_ref::<$of>().map(<$of>::message)))*
    };
}

fn message_of(cause: &(dyn Error + 'static)) -> Option<Message> {
    let found = message_of!(cause, LogError, Refusal, NoReference, NotIdentified, NoForecast, NotPossible);
    #[cfg(feature = "server")]
    let found = found.or_else(|| of_service(cause));
    found.or_else(|| cause.downcast_ref().and_then(by_system)).or_else(|| cause.downcast_ref().map(said_of))
}

#[cfg(feature = "server")]
fn of_service(cause: &(dyn Error + 'static)) -> Option<Message> {
    use crate::config::ConfigError;
    use crate::pipeline::Refused;
    use crate::store::StoreError;

    if let Some(Refused::Storage(error)) = cause.downcast_ref() {
        return Some(error.message());
    }
    message_of!(cause, ConfigError, Refused, StoreError)
}
