//! Why an order about a hook or a delivery is not carried out.

use crate::core::id::Id;
use crate::core::message::{Message, text};
use crate::message;
use crate::pipeline::error::{WriteError, unwritten};

#[derive(Debug, Clone, thiserror::Error)]
#[error("{}", self.message())]
pub enum HookError {
    NoSuchHook(Id),
    NoSuchDelivery(Id),
    HookDisabled(Id),
    StillBehind(Id),
    Dropped(Id),
    SecretNeeded,
    /// A `mailto:` address for a hook that is no e-mail, or another for one that is.
    OtherKind,
    TooManyHooks(usize),
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl HookError {
    pub fn message(&self) -> Message {
        match self {
            Self::NoSuchHook(id) => message!("no_such_hook", id = text(id)),
            Self::NoSuchDelivery(id) => message!("no_such_delivery", id = text(id)),
            Self::HookDisabled(id) => message!("hook_disabled", id = text(id)),
            Self::StillBehind(id) => message!("still_behind", id = text(id)),
            Self::Dropped(id) => message!("delivery_dropped", id = text(id)),
            Self::SecretNeeded => message!("secret_needed"),
            Self::OtherKind => message!("target_of_other_kind"),
            Self::TooManyHooks(most) => message!("too_many_hooks", most = *most),
            Self::Write(error) => error.message(),
        }
    }
}

unwritten!(HookError);
