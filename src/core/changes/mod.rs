//! Why a coefficient changed over months: the question of the diagnosis, asked of a gyro's history instead of a
//! campaign.
//!
//! A history y_k (deg/(h g0)) of one coefficient is a constant, plus causes, plus the scatter of calibration. The
//! causes that a history can name:
//!
//! | id | form | what parts it from the others |
//! |---|---|---|
//! | `ageing` | k t | a slope that goes on across events, stations and temperatures |
//! | `step_at_event` | k after one recorded event | the instant is known beforehand |
//! | `re_mounting` | k after the gyro changed IMU or slot | as above; in D_O it is the clocking of S about I |
//! | `temperature` | k (T - mean T) | follows the recorded temperature |
//! | `station` | one offset a station | **shared by every gyro that the station measured** |
//! | `clocking` | D_O = delta D_S | D_O moves in proportion to D_S; parts from D_O proper only where D_S changes |
//! | `step` | k after an instant that no event explains | none of the above |
//!
//! Each candidate is tried alone against what is already named; the significance is corrected for all that was tried
//! (Bonferroni over candidates and instants), the gain is measured on records that were left out, and candidates that
//! explain the same change equally well are answered as one class. A station's offset is estimated from its *other*
//! gyros first, so that a gyro is not blamed for what its station does to all.

mod answer;
mod candidates;
mod peers;
mod search;

use super::judge::Coefficient;

pub use answer::{Entry, FEWEST_RECORDS, GyroHistory, HistoryDiagnosis, HistoryVerdict, NamedCause, Rejected};
pub use peers::StationOffset;

/// Diagnoses D_I, D_S and D_O of `gyro`. `peers` are the other gyros of the fleet, whatever their IMU: those that met
/// the same stations tell what a station does to all.
pub fn diagnose_history(gyro: &GyroHistory, peers: &[GyroHistory]) -> Vec<HistoryDiagnosis> {
    [Coefficient::DI, Coefficient::DS, Coefficient::DO]
        .into_iter()
        .map(|coefficient| search::diagnose(gyro, peers, coefficient))
        .collect()
}

#[cfg(test)]
mod tests;
