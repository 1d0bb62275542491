//! What is asked of the database: fleet, histories, records, stations, agreement of methods, verification.

pub(super) mod agreement;
pub(super) mod changes_explained;
pub(super) mod fleet;
pub(super) mod fleet_noise;
pub(super) mod gyro_history;
pub(super) mod record;
pub(super) mod stations;
pub(super) mod status;
pub(super) mod verify;
