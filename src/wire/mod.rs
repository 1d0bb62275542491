//! The formats that stations and tools rely on, and their conversion to and from the core's types.
//!
//! The command line and the HTTP service speak the same JSON, so both read and write it through this module.
//! Reading has two stages: serde checks shape and types and stops at the first fault; conversion to the core
//! type then collects every fault of content. Both name places by JSON pointers with the names on the wire.

pub mod alert;
pub mod alert_csv;
pub mod alike;
pub mod answer;
pub mod bench;
pub(crate) mod body;
pub mod calibration;
pub mod campaign;
pub mod campaign_csv;
pub mod cause;
pub mod closure;
pub mod csv_text;
pub mod cursor;
pub mod diagnoses;
pub mod diagnoses_csv;
pub mod diagnosis;
pub mod differences;
pub mod document;
pub mod event;
pub mod file_kind;
pub mod forecast;
pub mod geometry;
pub mod gyro_table;
pub mod history;
pub mod history_note;
pub mod hook;
pub mod hypothesis;
pub mod json;
pub mod located;
pub mod message;
pub mod model;
mod named;
pub mod note;
pub mod numbers;
mod prelude;
pub mod problem;
pub mod reason;
pub mod record;
pub mod record_table;
pub mod sender;

pub mod silence;
pub mod split;
pub mod stations;
pub mod table;
pub mod text;
pub mod time;
pub mod triple;
pub mod unit;
pub mod unreadable;
