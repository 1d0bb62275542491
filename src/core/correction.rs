//! What was said of records and bench results that count no more.

use super::id::Id;
use super::time::UtcMicros;

/// That an item counts no more, or that another stands in its place: who said so, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CorrectionItem {
    pub item: Id,
    /// The record that stands in its place; none where it was voided.
    pub replaced_by: Option<Id>,
    pub at: UtcMicros,
    pub author: String,
    pub reason: String,
}

/// A result of a gyro that counts no more.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CorrectedResult {
    pub correction: CorrectionItem,
    /// Of the calibration or bench result.
    pub measured_at: UtcMicros,
    pub is_bench: bool,
}
