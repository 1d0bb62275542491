//! What admission is made by.

use super::ahead::Ahead;
use super::memory::Memory;
use crate::config::Judging;
use crate::pipeline::prelude::*;
use crate::store::IdSource;

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
