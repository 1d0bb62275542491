//! The blind check: campaigns with a hidden cause, diagnosed from their file alone, scored against the sealed truth.
//!
//! The truth of a whole run is one text, [`sealed`](seal) by its SHA-256 before the first diagnosis and shown after
//! the last. Nothing of the simulator reaches the diagnosis: it gets the campaign's JSON and nothing else.
//!
//! # In reading order
//!
//! [`draw`] which campaigns, [`answer`] what is read of a diagnosis, [`reach`] what the truth says could be told
//! apart, [`score`] one campaign, [`tally`] proportions, [`report`] the table; [`kind`] what stations do
//! beyond white, independent noise; [`hypothesis`] what somebody's own would take to be found.

pub mod answer;
pub mod draw;
pub mod history;
pub mod hypothesis;
pub mod kind;
pub mod reach;
pub mod report;
pub mod run;
pub mod score;
pub mod tally;

use crate::system::sha256;

/// SHA-256 of a text, in hexadecimal: the seal of a key.
pub fn seal(text: &str) -> String {
    hex::encode(sha256(text.as_bytes()))
}
