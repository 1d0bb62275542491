//! What a gyro is judged against. Configuration by fleet, IMU, gyro and coefficient is resolved to one of these before.

use super::Coefficient;
use super::history::Measured;
use super::rules::{CUSUM_RECORDS, RMS_RECORDS, TREND_RECORDS};

/// The paper's short-term stability of D_I and D_S, deg/(h g0).
pub const DEFAULT_BUDGET: f64 = 1e-2;

/// Everything that one gyro is judged against. A rule without a limit does not judge.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    pub d_i: DriftLimits,
    pub d_s: DriftLimits,
    /// How far the closure may move from its baseline, deg/(h g0).
    pub closure: Option<f64>,
    /// Whether the closure is the rigid D_O; if not, it is the published method's residual, which tells no angle.
    pub closure_is_d_o: bool,
    /// Probability from which an exceedance counts as certain, and below whose complement as excluded; between
    /// the two a verdict is indeterminate.
    pub confidence: f64,
    /// `range` looks at the records of so many days up to the judged one,
    pub range_days: f64,
    /// and says nothing of fewer than so many.
    pub range_min_records: usize,
    /// `overdue` fires so many days after the last calibration.
    pub interval_days: Option<f64>,
}

/// Limits of one of D_I and D_S, deg/(h g0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftLimits {
    pub step: Option<f64>,
    pub range: Option<f64>,
    pub baseline: Option<f64>,
    /// A baseline that the acceptance file fixes, instead of the mean of the first records.
    pub fixed_baseline: Option<Measured>,
    pub rms_successive: Option<f64>,
    pub agreement: Option<f64>,
    pub trend: Option<TrendLimits>,
    pub cusum: Option<CusumLimits>,
}

/// When a slope is established, and how far ahead it is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrendLimits {
    /// deg/(h g0), from the baseline.
    pub budget: f64,
    /// Confidence of the slope's interval, which must not hold zero.
    pub confidence: f64,
    pub horizon_days: f64,
}

/// A control limit that is set by its rate of false alarms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CusumLimits {
    /// Records until a stable gyro raises an alarm, on average.
    pub records_per_false_alarm: f64,
    /// Scatter below which differences do not matter, deg/(h g0).
    pub least_scatter: f64,
}

impl DriftLimits {
    /// No rule judges.
    pub fn none() -> Self {
        Self {
            step: None,
            range: None,
            baseline: None,
            fixed_baseline: None,
            rms_successive: None,
            agreement: None,
            trend: None,
            cusum: None,
        }
    }

    /// Every rule measured by the same budget, deg/(h g0): as it stands for `step`, `range`, `baseline`, `agreement` and the
    /// level that a `trend` must not reach; half of it for the root mean square of successive differences, which
    /// a gyro that keeps its budget in 19 of 20 steps stays below; a twentieth is too little to matter to `cusum`.
    pub fn from_budget(budget: f64) -> Self {
        Self {
            step: Some(budget),
            range: Some(budget),
            baseline: Some(budget),
            fixed_baseline: None,
            rms_successive: Some(budget / 2.0),
            agreement: Some(budget),
            trend: Some(TrendLimits { budget, confidence: 0.999, horizon_days: 90.0 }),
            cusum: Some(CusumLimits { records_per_false_alarm: 500.0, least_scatter: budget / 20.0 }),
        }
    }
}

impl Limits {
    pub fn from_budget(budget: f64) -> Self {
        Self {
            d_i: DriftLimits::from_budget(budget),
            d_s: DriftLimits::from_budget(budget),
            closure: Some(budget),
            closure_is_d_o: true,
            confidence: 0.95,
            range_days: 30.0,
            range_min_records: 3,
            interval_days: None,
        }
    }

    /// How far the methods may be apart on `coefficient`, deg/(h g0); none where nobody asks.
    pub fn agreement(&self, coefficient: Coefficient) -> Option<f64> {
        match coefficient {
            Coefficient::DI => self.d_i.agreement,
            Coefficient::DS => self.d_s.agreement,
            _ => None,
        }
    }

    /// How many records up to the judged one the rule with the longest memory takes.
    pub(crate) fn longest_memory(&self) -> usize {
        CUSUM_RECORDS.max(RMS_RECORDS).max(TREND_RECORDS)
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::from_budget(DEFAULT_BUDGET)
    }
}

/// (records per false alarm, threshold) of the two-sided sum as `rules/cusum.rs` makes it, from 4,000 simulated runs:
/// `cargo run --release --example judging thresholds`.
const CUSUM_THRESHOLDS: [(f64, f64); 6] =
    [(100.0, 3.49), (200.0, 4.20), (500.0, 5.14), (1000.0, 5.85), (2000.0, 6.58), (5000.0, 7.55)];

impl CusumLimits {
    /// The threshold of the sum for the wanted run length: log-linear in between, the end values beyond.
    pub fn threshold(&self) -> f64 {
        let wanted = self.records_per_false_alarm;
        let longer = CUSUM_THRESHOLDS.iter().position(|&(length, _)| length >= wanted);
        match longer {
            Some(0) => CUSUM_THRESHOLDS[0].1,
            Some(i) => {
                let ((l0, h0), (l1, h1)) = (CUSUM_THRESHOLDS[i - 1], CUSUM_THRESHOLDS[i]);
                h0 + (h1 - h0) * (wanted / l0).ln() / (l1 / l0).ln()
            }
            None => CUSUM_THRESHOLDS[CUSUM_THRESHOLDS.len() - 1].1,
        }
    }
}

/// An interval that a figure must lie in, its ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    pub low: f64,
    pub high: f64,
}

/// What E (pulse/arcsec) and G (pulse/(s g0)) of the gyro in one slot must keep.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Requirement {
    /// |E|.
    pub e_norm: Option<Bounds>,
    pub e: [Option<Bounds>; 3],
    pub g: [Option<Bounds>; 3],
}

impl Requirement {
    /// The requirement columns of Tables 3 and 4, for G1, G2, G3 of the skewed geometry. Table 4's "< 13.23" is read as a
    /// magnitude: its own G_z3 = -9.98 is called conforming for its size, not for its sign.
    pub fn tables_3_and_4() -> [Self; 3] {
        let e = [
            [(0.8425, 0.8529), (-0.6052, -0.5935), (1.0336, 1.0427)],
            [(0.8427, 0.8532), (-0.6090, -0.5972), (-1.0428, -1.0337)],
            [(0.8480, 0.8585), (1.2028, 1.2103), (-0.0063, 0.0066)],
        ];
        let bounds = |(low, high)| Some(Bounds { low, high });
        e.map(|row| Self { e_norm: bounds((1.0, 3.0)), e: row.map(bounds), g: [bounds((-13.23, 13.23)); 3] })
    }
}
