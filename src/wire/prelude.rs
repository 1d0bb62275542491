//! What nearly every file of the wire is written with.

pub(super) use serde::{Deserialize, Serialize};
pub(super) use serde_json::{Value, json};
pub(super) use utoipa::ToSchema;

pub(super) use super::body::{ToBody, bodies};
pub(super) use super::message::MessageBody;
pub(super) use super::triple::Triple;
pub(super) use crate::core::fault::{Fault, Faults};
pub(super) use crate::core::message::Message;
pub(super) use crate::core::mounting::Slot;
pub(super) use crate::core::time::UtcMicros;
pub(super) use crate::message;
pub(super) use crate::words::{Language, asked};
