//! The two kinds of calibrations.

use super::id::Id;
use super::time::UtcMicros;

/// What a station sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Parameters that the station fitted.
    Record,
    /// Raw dwells, fitted here.
    Campaign,
}

/// A record or a campaign among others, without what it says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordEntry {
    pub id: Id,
    pub kind: Kind,
    pub imu: u32,
    pub station: u32,
    pub calibrated_at: UtcMicros,
    pub received_at: UtcMicros,
    /// It does not count: voided, revised or set aside.
    pub voided: bool,
}
