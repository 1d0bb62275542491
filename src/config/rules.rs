//! `[judging.rules]` and `rules` of an override: what single rules depart in from the budget.

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::core::judge::{DriftLimits, Limit, LimitKey, Limits, Measured, Rule, ShiftLimits, TrendLimits};

/// Limits in deg/(h g0). What is left out stays as the budget, or the layer before, has it.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RuleKeys {
    pub step: Option<f64>,
    pub range: Option<f64>,
    pub baseline: Option<f64>,
    pub fixed_baseline: Option<FixedBaseline>,
    pub rms_successive: Option<f64>,
    pub agreement: Option<f64>,
    pub before_after: Option<f64>,
    pub closure: Option<f64>,
    pub trend: Option<f64>,
    pub trend_confidence: Option<f64>,
    pub trend_horizon_days: Option<f64>,
    pub shift: Option<f64>,
    /// Of versions before 0.2, whose rule `cusum` has given way to `shift`: read, and without effect.
    pub cusum_records_per_false_alarm: Option<IgnoredAny>,
    pub cusum_least_scatter: Option<IgnoredAny>,
    /// Rules that do not judge at all.
    pub off: Vec<OffRule>,
}

/// A baseline from the acceptance file, instead of the mean of the first records.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedBaseline {
    pub value: f64,
    pub sd: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct OffRule(Rule);

impl TryFrom<String> for OffRule {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        match Rule::from_name(&name) {
            Some(Rule::Requirement) => Err("requirement is switched off by judging.requirements = false, or figure by figure in judging.requirement".into()),
            Some(Rule::Overdue) => Err("overdue is switched off by interval_days = 0".into()),
            Some(rule) => Ok(Self(rule)),
            None => Err(format!("there is no rule {name:?}")),
        }
    }
}

impl RuleKeys {
    /// Changes what these keys name: of one coefficient, or of both and the closure. `place` is that of the override
    /// that holds them.
    pub(super) fn apply(&self, coefficient: Option<OverriddenCoefficient>, place: Option<u16>, limits: &mut Limits) {
        if coefficient != Some(OverriddenCoefficient::DS) {
            self.apply_to_drift(place, &mut limits.d_i);
        }
        if coefficient != Some(OverriddenCoefficient::DI) {
            self.apply_to_drift(place, &mut limits.d_s);
        }
        if coefficient.is_none() {
            let own = self.closure.map(|value| Limit { value, from: LimitKey { place, key: "rules.closure" } });
            limits.closure = if self.is_off(Rule::Closure) { None } else { own.or(limits.closure) };
        }
    }

    fn apply_to_drift(&self, place: Option<u16>, drift: &mut DriftLimits) {
        let limit = |value: f64, key: &'static str| Limit { value, from: LimitKey { place, key } };
        for (rule, key, own) in self.single() {
            let own = own.map(|value| limit(value, key));
            drift.set(rule, if self.is_off(rule) { None } else { own.or(drift.of(rule)) });
        }
        if let Some(FixedBaseline { value, sd }) = self.fixed_baseline {
            drift.fixed_baseline = Some(Measured { value, sd });
        }
        drift.trend = drift.trend.filter(|_| !self.is_off(Rule::Trend)).map(|trend| TrendLimits {
            budget: self.trend.map_or(trend.budget, |value| limit(value, "rules.trend")),
            confidence: self.trend_confidence.unwrap_or(trend.confidence),
            horizon_days: self.trend_horizon_days.unwrap_or(trend.horizon_days),
        });
        drift.shift = drift.shift.filter(|_| !self.is_off(Rule::Shift)).map(|shift| ShiftLimits {
            least: self.shift.map_or(shift.least, |value| limit(value, "rules.shift")),
            ..shift
        });
    }

    /// Of the rules that have one limit.
    fn single(&self) -> [(Rule, &'static str, Option<f64>); 6] {
        [
            (Rule::Step, "rules.step", self.step),
            (Rule::Range, "rules.range", self.range),
            (Rule::Baseline, "rules.baseline", self.baseline),
            (Rule::RmsSuccessive, "rules.rms_successive", self.rms_successive),
            (Rule::Agreement, "rules.agreement", self.agreement),
            (Rule::BeforeAfter, "rules.before_after", self.before_after),
        ]
    }

    fn is_off(&self, rule: Rule) -> bool {
        self.off.contains(&OffRule(rule))
    }

    /// The first key whose value cannot be, and why.
    pub(super) fn fault(&self) -> Option<(&'static str, String)> {
        let others = [
            ("shift", self.shift),
            ("closure", self.closure),
            ("trend", self.trend),
            ("trend_horizon_days", self.trend_horizon_days),
        ];
        let positive = self.single().map(|(rule, _, value)| (rule.name(), value));
        for (key, value) in positive.into_iter().chain(others) {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Some((key, format!("must be positive, is {value}")));
            }
        }
        if let Some(confidence) = self.trend_confidence.filter(|c| !(*c > 0.5 && *c < 1.0)) {
            return Some(("trend_confidence", format!("must lie between 0.5 and 1, is {confidence}")));
        }
        let sd_is_wrong = |baseline: &FixedBaseline| baseline.sd.is_some_and(|sd| !(sd.is_finite() && sd >= 0.0));
        match self.fixed_baseline {
            Some(baseline) if !baseline.value.is_finite() => Some(("fixed_baseline.value", "must be finite".into())),
            Some(baseline) if sd_is_wrong(&baseline) => Some(("fixed_baseline.sd", "must not be negative".into())),
            _ => None,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum OverriddenCoefficient {
    #[serde(rename = "D_I")]
    DI,
    #[serde(rename = "D_S")]
    DS,
}
