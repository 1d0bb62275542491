//! Why an order about access is not carried out.

use crate::core::id::Id;
use crate::core::message::{Message, text};
use crate::message;
use crate::pipeline::error::{WriteError, unwritten};

#[derive(Debug, Clone, thiserror::Error)]
#[error("{}", self.message())]
pub enum AccessError {
    NoSuchToken(Id),
    SetupOver,
    NoRandomNumbers,
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl AccessError {
    pub fn message(&self) -> Message {
        match self {
            Self::NoSuchToken(id) => message!("no_such_token", id = text(id)),
            Self::SetupOver => message!("setup_over"),
            Self::NoRandomNumbers => message!("no_random_numbers"),
            Self::Write(error) => error.message(),
        }
    }
}

unwritten!(AccessError);
