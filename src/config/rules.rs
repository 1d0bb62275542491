//! `[judging.rules]` and `rules` of an override: what single rules depart in from the budget.

use serde::Deserialize;

use crate::core::judge::{CusumLimits, DriftLimits, Limits, Measured, Rule, TrendLimits};

use super::judging::OverriddenCoefficient;

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
    pub closure: Option<f64>,
    pub trend: Option<f64>,
    pub trend_confidence: Option<f64>,
    pub trend_horizon_days: Option<f64>,
    pub cusum_records_per_false_alarm: Option<f64>,
    pub cusum_least_scatter: Option<f64>,
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
    /// Changes what these keys name: of one coefficient, or of both and the closure.
    pub(super) fn apply(&self, coefficient: Option<OverriddenCoefficient>, limits: &mut Limits) {
        if coefficient != Some(OverriddenCoefficient::DS) {
            self.apply_to_drift(&mut limits.d_i);
        }
        if coefficient != Some(OverriddenCoefficient::DI) {
            self.apply_to_drift(&mut limits.d_s);
        }
        if coefficient.is_none() {
            limits.closure = if self.is_off(Rule::Closure) { None } else { self.closure.or(limits.closure) };
        }
    }

    fn apply_to_drift(&self, drift: &mut DriftLimits) {
        for (limit, own, rule) in [
            (&mut drift.step, self.step, Rule::Step),
            (&mut drift.range, self.range, Rule::Range),
            (&mut drift.baseline, self.baseline, Rule::Baseline),
            (&mut drift.rms_successive, self.rms_successive, Rule::RmsSuccessive),
            (&mut drift.agreement, self.agreement, Rule::Agreement),
        ] {
            *limit = if self.is_off(rule) { None } else { own.or(*limit) };
        }
        if let Some(FixedBaseline { value, sd }) = self.fixed_baseline {
            drift.fixed_baseline = Some(Measured { value, sd });
        }
        drift.trend = drift.trend.filter(|_| !self.is_off(Rule::Trend)).map(|trend| TrendLimits {
            budget: self.trend.unwrap_or(trend.budget),
            confidence: self.trend_confidence.unwrap_or(trend.confidence),
            horizon_days: self.trend_horizon_days.unwrap_or(trend.horizon_days),
        });
        drift.cusum = drift.cusum.filter(|_| !self.is_off(Rule::Cusum)).map(|cusum| CusumLimits {
            records_per_false_alarm: self.cusum_records_per_false_alarm.unwrap_or(cusum.records_per_false_alarm),
            least_scatter: self.cusum_least_scatter.unwrap_or(cusum.least_scatter),
        });
    }

    fn is_off(&self, rule: Rule) -> bool {
        self.off.contains(&OffRule(rule))
    }

    /// The first key whose value cannot be, and why.
    pub(super) fn fault(&self) -> Option<(&'static str, String)> {
        let positive = [
            ("step", self.step),
            ("range", self.range),
            ("baseline", self.baseline),
            ("rms_successive", self.rms_successive),
            ("agreement", self.agreement),
            ("closure", self.closure),
            ("trend", self.trend),
            ("trend_horizon_days", self.trend_horizon_days),
            ("cusum_records_per_false_alarm", self.cusum_records_per_false_alarm),
            ("cusum_least_scatter", self.cusum_least_scatter),
        ];
        for (key, value) in positive {
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
