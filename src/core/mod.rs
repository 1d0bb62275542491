//! The mathematics: calibration, separation, judging and diagnosis as plain functions.
//!
//! Everything below is pure. No clock, no randomness, no I/O, no serialisation and no logging: what a function
//! needs is passed in, what it found is returned, evidence included. `tests/architecture` keeps it so.

pub mod access;
pub mod adopted;
pub mod alert_decision;
pub mod alert_filter;
pub mod at_reference;
pub mod augmented;
pub mod bench;
pub mod calibrate;
pub mod campaign;
pub mod changes;
pub mod correction;
pub mod delivery;
pub mod diagnose;
pub mod dwells;
pub mod effects;
pub mod fault;
pub mod figures;
pub mod first_of;
pub mod fleet_order;
pub mod frames;
pub mod gyro_attributes;
pub mod gyro_event;
pub mod history_note;
pub mod id;
pub mod imu_model;
pub mod judge;
pub mod kind;
pub mod message;
pub mod model;
pub mod mounting;
pub mod name;
pub(crate) mod named;
pub mod note;
pub mod numerics;
pub mod own_history;
pub mod period;
pub mod record;
pub mod separate;
pub mod suspect_window;
pub mod time;
pub mod units;
