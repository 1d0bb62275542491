//! What a gyro is judged against. Configuration by fleet, IMU, gyro and coefficient is resolved to one of these before.

use super::history::{BASELINE_RECORDS, Measured};

/// The paper's short-term stability of D_I and D_S, deg/(h g0).
pub const DEFAULT_BUDGET: f64 = 1e-2;

/// Limits of one of D_I and D_S, deg/(h g0). A rule without a limit does not judge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftLimits {
    pub step: Option<f64>,
    pub range: Option<f64>,
    pub baseline: Option<f64>,
    /// A baseline that the acceptance file fixes, instead of the mean of the first records.
    pub fixed_baseline: Option<Measured>,
}

impl DriftLimits {
    /// Every rule against the same budget, deg/(h g0).
    pub fn from_budget(budget: f64) -> Self {
        Self { step: Some(budget), range: Some(budget), baseline: Some(budget), fixed_baseline: None }
    }
}

/// Everything that one gyro is judged against.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    pub d_i: DriftLimits,
    pub d_s: DriftLimits,
    /// Probability from which an exceedance counts as certain, and below whose complement as excluded; between
    /// the two a verdict is indeterminate.
    pub confidence: f64,
    /// `range` looks at the records of so many days up to the judged one,
    pub range_days: f64,
    /// and says nothing of fewer than so many.
    pub range_min_records: usize,
}

impl Limits {
    pub fn from_budget(budget: f64) -> Self {
        Self {
            d_i: DriftLimits::from_budget(budget),
            d_s: DriftLimits::from_budget(budget),
            confidence: 0.95,
            range_days: 30.0,
            range_min_records: 3,
        }
    }

    /// How many records before the judged one the rule with the longest memory takes.
    pub(crate) fn longest_memory(&self) -> usize {
        BASELINE_RECORDS
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::from_budget(DEFAULT_BUDGET)
    }
}
