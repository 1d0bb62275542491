//! What the lists of a day begin with.

use super::id::Id;
use super::time::UtcMicros;

/// The first of a list, and how long it is.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstOf<T> {
    pub first: Vec<T>,
    pub of: usize,
}

/// An IMU with gyros to be calibrated.
#[derive(Debug, Clone, PartialEq)]
pub struct DueImu {
    pub imu: u32,
    /// When the first of them was or is due.
    pub at: UtcMicros,
    pub gyros: usize,
}

/// An IMU of which every gyro lies far from its baseline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovedImu {
    pub record: Id,
    pub imu: u32,
    pub at: UtcMicros,
    pub gyros: usize,
    /// That of the gyro that lies nearest, in budgets.
    pub least: f64,
}
