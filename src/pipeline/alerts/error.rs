//! Why an order about an alert or a silence is not carried out.

use crate::core::id::Id;
use crate::core::message::{Message, text};
use crate::message;
use crate::pipeline::error::{WriteError, unwritten};

#[derive(Debug, Clone, thiserror::Error)]
#[error("{}", self.message())]
pub enum AlertError {
    UnknownAlert(Id),
    AlertResolved(Id),
    UnknownSilence(Id),
    TooManySilences(usize),
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl AlertError {
    pub fn message(&self) -> Message {
        match self {
            Self::UnknownAlert(id) => message!("unknown_alert", id = text(id)),
            Self::AlertResolved(id) => message!("alert_resolved", id = text(id)),
            Self::UnknownSilence(id) => message!("unknown_silence", id = text(id)),
            Self::TooManySilences(most) => message!("too_many_silences", most = *most),
            Self::Write(error) => error.message(),
        }
    }
}

unwritten!(AlertError);
