//! What admission is made by.

use super::ahead::Ahead;
use super::memory::Memory;
use crate::config::Judging;
use crate::core::time::UtcMicros;
use crate::pipeline::access::Actor;
use crate::store::{IdSource, Store};

/// What admission may ask.
pub(crate) struct Admission<'a> {
    pub store: &'a Store,
    pub ids: &'a mut IdSource,
    pub memory: &'a mut Memory,
    pub ahead: &'a Ahead,
    pub judging: &'a Judging,
    /// Where clocks that were never set begin.
    pub epochs: &'a [UtcMicros],
    pub now: UtcMicros,
    /// Whose item is at hand.
    pub by: &'a Actor,
}
