//! From the time series of a log to dwells: still and turning intervals, their means, and the errors of these means.
//!
//! ```text
//! samples -> blocks -> series -> intervals -> (programme) -> means and standard errors
//! ```
//!
//! [`blocks`] gathers samples in memory that does not grow with the log, [`intervals`] finds where nothing changes,
//! [`turns`] takes out what the Earth's rate does while the table turns,
//! [`noise`] says from the log's own Allan variance how far a mean is known, [`programme`] what the table was told, and
//! [`explained`] whether that explains the outputs.

pub mod averages;
pub mod blocks;
pub mod explained;
pub mod intervals;
pub mod noise;
pub mod programme;
pub mod turns;

#[cfg(test)]
mod tests;
