//! The two kinds of calibrations.

/// What a station sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Parameters that the station fitted.
    Record,
    /// Raw dwells, fitted here.
    Campaign,
}
