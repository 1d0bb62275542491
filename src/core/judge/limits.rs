//! What a gyro is judged against. Configuration by fleet, IMU, gyro and coefficient is resolved to one of these before.

use std::fmt::{self, Display, Formatter};

use crate::core::judge::{Coefficient, Measured, NoiseParameters, Rule};

/// The paper's short-term stability of D_I and D_S, deg/(h g0): a typical value there, a limit here.
pub const DEFAULT_BUDGET: f64 = 1e-2;

/// What in the configuration sets a limit. Displays as the whole key: `judging.budget`,
/// `judging.overrides[2].rules.step`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LimitKey {
    /// Place in the list of overrides; none where the fleet's own section says so.
    pub place: Option<u16>,
    /// Within the section.
    pub key: &'static str,
}

impl LimitKey {
    pub const BUDGET: Self = Self { place: None, key: "budget" };
}

impl Display for LimitKey {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.place {
            None => write!(f, "judging.{}", self.key),
            Some(place) => write!(f, "judging.overrides[{place}].{}", self.key),
        }
    }
}

/// A limit, and where it comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    pub value: f64,
    pub from: LimitKey,
}

/// Everything that one gyro is judged against. A rule without a limit does not judge.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    pub d_i: DriftLimits,
    pub d_s: DriftLimits,
    /// How far the closure may move from its baseline, deg/(h g0).
    pub closure: Option<Limit>,
    /// Whether the closure is the rigid D_O; if not, it is the published method's residual, which tells no angle.
    pub closure_is_d_o: bool,
    /// Probability from which an exceedance counts as certain, and below whose complement as excluded; between
    /// the two a verdict is indeterminate.
    pub confidence: f64,
    /// `range` looks at the records of so many days up to the judged one,
    pub range_days: f64,
    /// and at so many at least.
    pub range_min_records: usize,
    /// `overdue` fires so many days after the last calibration.
    pub interval_days: Option<Limit>,
    /// How the figures of unmoved gyros scatter.
    pub noise: NoiseParameters,
    /// Standard deviation of D_I and D_S from station to station, deg/(h g0); 0 where the fleet does not tell it.
    pub between_stations: [f64; 2],
}

/// Limits of one of D_I and D_S, deg/(h g0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftLimits {
    /// Of the rules that have one limit, by [`Rule`].
    single: [Option<Limit>; Rule::ALL.len()],
    /// A baseline that the acceptance file fixes, instead of the first records.
    pub fixed_baseline: Option<Measured>,
    pub trend: Option<TrendLimits>,
    pub shift: Option<ShiftLimits>,
}

/// When a slope is established, and how far ahead it is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrendLimits {
    /// deg/(h g0), from the baseline.
    pub budget: Limit,
    /// Confidence that the slope is not zero.
    pub confidence: f64,
    pub horizon_days: f64,
}

/// When a change of level matters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShiftLimits {
    /// Smaller departures raise no alarm, deg/(h g0).
    pub least: Limit,
    /// What the scatter of a gyro is expected to be a tenth of, deg/(h g0).
    pub budget: f64,
}

impl DriftLimits {
    /// The limit of a rule that has one; none where it does not judge.
    pub fn of(&self, rule: Rule) -> Option<Limit> {
        self.single[rule as usize]
    }

    /// What was set for a rule: of `trend` its budget, of `shift` the least that counts, of others their limit.
    pub fn stated(&self, rule: Rule) -> Option<Limit> {
        match rule {
            Rule::Trend => self.trend.map(|trend| trend.budget),
            Rule::Shift => self.shift.map(|shift| shift.least),
            _ => self.of(rule),
        }
    }

    /// Sets the limit of a rule that has a single one; `None` switches it off.
    pub fn set(&mut self, rule: Rule, limit: Option<Limit>) {
        self.single[rule as usize] = limit;
    }

    /// Every rule measured by the same budget, deg/(h g0): each by its [share](Rule::share_of_budget); as it stands
    /// for the level that a `trend` must not reach; a quarter of it for a `shift`, which nothing has violated yet.
    pub fn from_budget(budget: Limit) -> Self {
        let part = |share: f64| Limit { value: share * budget.value, ..budget };
        Self {
            single: Rule::ALL.map(|rule| rule.share_of_budget().map(part)),
            fixed_baseline: None,
            trend: Some(TrendLimits { budget, confidence: 0.999, horizon_days: 90.0 }),
            shift: Some(ShiftLimits { least: part(0.25), budget: budget.value }),
        }
    }
}

impl Limits {
    /// How far D_I, D_S and the closure may be from their baselines.
    pub fn budgets(&self) -> [Option<f64>; 3] {
        [self.d_i.of(Rule::Baseline), self.d_s.of(Rule::Baseline), self.closure]
            .map(|limit| limit.map(|limit| limit.value))
    }

    /// The defaults, with one budget for D_I, D_S and D_O, deg/(h g0).
    pub fn from_budget(budget: f64) -> Self {
        let budget = Limit { value: budget, from: LimitKey::BUDGET };
        Self {
            d_i: DriftLimits::from_budget(budget),
            d_s: DriftLimits::from_budget(budget),
            closure: Some(budget),
            closure_is_d_o: true,
            confidence: 0.95,
            range_days: 30.0,
            range_min_records: 3,
            interval_days: None,
            noise: NoiseParameters::default(),
            between_stations: [0.0; 2],
        }
    }

    /// How far the methods may be apart on `coefficient`, deg/(h g0); none where nobody asks.
    pub fn agreement(&self, coefficient: Coefficient) -> Option<Limit> {
        match coefficient {
            Coefficient::DI => self.d_i.of(Rule::Agreement),
            Coefficient::DS => self.d_s.of(Rule::Agreement),
            _ => None,
        }
    }

    /// The steps of D_I and D_S that the forecast of a campaign is to show, deg/(h g0); none where nobody asks.
    pub fn forecast(&self) -> [Option<Limit>; 2] {
        [&self.d_i, &self.d_s].map(|drift| drift.of(Rule::Forecast))
    }

    /// How many records up to the judged one the rule with the longest memory takes one by one.
    pub(crate) fn longest_memory(&self) -> usize {
        RMS_RECORDS.max(self.range_min_records).max(BEFORE_AFTER_RECORDS)
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::from_budget(DEFAULT_BUDGET)
    }
}

/// An interval that a figure must lie in, its ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    pub low: f64,
    pub high: f64,
    pub from: LimitKey,
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
    /// The requirement columns of Tables 3 and 4, for G1, G2, G3 of the skewed geometry. Table 4's "< 13.23" is read
    /// as a magnitude: its own G_z3 = -9.98 is called conforming for its size, not for its sign.
    pub fn tables_3_and_4() -> [Self; 3] {
        let e = [
            [(0.8425, 0.8529), (-0.6052, -0.5935), (1.0336, 1.0427)],
            [(0.8427, 0.8532), (-0.6090, -0.5972), (-1.0428, -1.0337)],
            [(0.8480, 0.8585), (1.2028, 1.2103), (-0.0063, 0.0066)],
        ];
        let from = LimitKey { place: None, key: "requirements" };
        let bounds = |(low, high)| Some(Bounds { low, high, from });
        e.map(|row| Self { e_norm: bounds((1.0, 3.0)), e: row.map(bounds), g: [bounds((-13.23, 13.23)); 3] })
    }
}

/// Records up to the judged one that `before_after` looks at: those, and the last one before the test.
pub const BEFORE_AFTER_RECORDS: usize = AFTER + 2;

/// Records that `rms_successive` looks at.
pub const RMS_RECORDS: usize = 11;

/// Records after a test that may be judged by it: the first always, the others only while none has come back to where
/// the gyro was.
pub(super) const AFTER: usize = 10;
