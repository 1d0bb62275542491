//! What else physics and table work produce, beyond the contract: competitors and signs, never names.
//!
//! A contract entry that merely resembles one of these must not get its name, so they take part in the search. Where
//! one of them wins, the answer says what kind of structure is there and that the catalogue does not explain it.

mod common;
mod orientation;
mod rate;
mod station;
mod thermal;
mod time;

use super::entry::Entry;

/// By family, in the order of [`super::Effect`].
pub(super) const FAMILIES: [&[&Entry]; 5] =
    [time::ENTRIES, thermal::ENTRIES, orientation::ENTRIES, rate::ENTRIES, station::ENTRIES];
