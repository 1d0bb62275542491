//! What is asked, one gyro's history, and what is answered.

use crate::core::judge::{Coefficient, Mark, Measured};
use crate::core::time::UtcMicros;

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
