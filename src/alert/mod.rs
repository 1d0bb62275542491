//! Telling the world: what a hook is sent ([`payload`], pure), how it is signed ([`sign`]), where it may go
//! ([`target`]), one attempt to send it ([`deliver`], [`mail`]) and when to try again ([`retry_schedule`]).
//!
//! Nothing here knows the database. The queue of what is to be told lives there, written in the transaction that
//! decided it; the pipeline takes deliveries from it, has them attempted here and writes down how that went.

pub mod deliver;
pub mod mail;
pub mod message;
pub mod payload;
pub mod resolver;
pub mod retry_schedule;
pub mod sign;
pub mod target;

pub use message::{AlertTransition, DIGEST_EVENT, HookEvent, HookKind, HookMessage, event_name};
