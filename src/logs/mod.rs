//! A station's own files: raw logs of any layout, read by a map, become campaigns.
//!
//! [`crate::wire::file_kind`] says what a file is, [`source`] reads it as named columns of numbers, [`map`] says which are what,
//! [`gather`] brings all samples to one series, [`assemble`] makes dwells of it and [`campaign`] the document.
//! The mathematics is in [`crate::core::dwells`].

pub mod assemble;
mod averaged;
pub mod campaign;
mod clock;
mod column;
pub mod error;
mod gather;
pub mod guess;
pub mod map;
mod mat;
mod npy;
#[cfg(feature = "parquet")]
mod parquet;
pub mod programme;
mod repeats;
pub mod report;
mod sampling;
pub mod sheet;
pub mod source;
pub mod text;
mod turning;
mod units;

#[cfg(test)]
mod tests;
