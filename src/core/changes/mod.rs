//! Why a coefficient changed over months: the question of the diagnosis, asked of a gyro's history instead of a campaign.
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

mod candidates;
mod peers;
mod search;

use super::judge::{Coefficient, Mark, Measured};
use super::time::UtcMicros;

pub use peers::StationOffset;

/// One record of one gyro, with what else was recorded of the occasion.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    pub at: UtcMicros,
    pub station: String,
    /// IMU and slot, as one word: a change of it is a re-mounting.
    pub seat: String,
    pub temperature_c: Option<f64>,
    /// D_I, D_S, D_O, deg/(h g0).
    pub d: [Measured; 3],
}

/// One gyro's records and events, oldest first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GyroHistory {
    pub entries: Vec<Entry>,
    pub marks: Vec<Mark>,
}

/// A cause that was named, and the evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedCause {
    pub cause: &'static str,
    /// Every id that explains this change equally well, itself included.
    pub class: Vec<&'static str>,
    /// What the cause is tied to: an event, a station, an instant.
    pub detail: String,
    /// Name, value, standard deviation and unit of each parameter.
    pub estimates: Vec<(String, f64, f64, &'static str)>,
    /// Root mean square error of left-out records before and after, deg/(h g0).
    pub before: f64,
    pub after: f64,
    /// 1 - (after^2 - floor^2)/(before^2 - floor^2), at most 1.
    pub closure: f64,
    pub p_value_adjusted: f64,
}

/// A candidate that was not taken, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Rejected {
    pub cause: &'static str,
    pub detail: String,
    pub reason: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HistoryVerdict {
    /// Too few records to tell a change from scatter.
    TooFew,
    /// Nothing above the scatter of calibration.
    NoChange,
    Explained,
    PartlyExplained,
    Unexplained,
}

impl HistoryVerdict {
    pub fn name(self) -> &'static str {
        match self {
            Self::TooFew => "too_few",
            Self::NoChange => "no_change",
            Self::Explained => "explained",
            Self::PartlyExplained => "partly_explained",
            Self::Unexplained => "unexplained",
        }
    }
}

/// The answer for one coefficient.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryDiagnosis {
    pub coefficient: Coefficient,
    pub verdict: HistoryVerdict,
    pub records: usize,
    /// Scatter of calibration from successive differences, deg/(h g0).
    pub scatter: f64,
    /// Root mean square about the mean, deg/(h g0).
    pub spread: f64,
    pub causes: Vec<NamedCause>,
    pub rejected: Vec<Rejected>,
    /// Significance of what is left beyond the scatter.
    pub remaining_p_value: f64,
}

/// Fewest records of which anything is said: a constant, a cause, and four left to judge the scatter by.
pub const FEWEST_RECORDS: usize = 6;

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
