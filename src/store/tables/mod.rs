//! One file a table: its rows, what reads them and what writes them.

pub(super) mod access;
pub(super) mod alerts;
pub(super) mod bench;
pub(super) mod correction;
pub(super) mod delivery;
pub(super) mod delivery_line;
pub(super) mod diagnosis;
pub(super) mod diagnosis_digest;
pub(super) mod diagnosis_job;
pub(super) mod event;
pub(super) mod gyro;
pub(super) mod histories;
pub(super) mod history;
pub(super) mod hook;
pub(super) mod keys;
pub(super) mod model;
pub(super) mod names;
pub(super) mod outbox;
#[cfg(test)]
pub(super) mod outbox_tests;
pub(super) mod record;
pub(super) mod set_aside;
pub(super) mod silence;
