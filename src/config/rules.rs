//! `[judging.rules]` and `rules` of an override: what single rules depart in from the budget.

use std::collections::BTreeMap;
use std::fmt::{self, Formatter};
use std::sync::LazyLock;

use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, Visitor};

use super::ConfigError;
use super::error::{MessageError, between, not_negative};
use crate::core::judge::{DriftLimits, Limit, LimitKey, Limits, Measured, Rule, ShiftLimits, TrendLimits};
use crate::core::message::{sent, text};
use crate::message;

/// Limits in deg/(h g0). What is left out stays as the budget, or the layer before, has it.
#[derive(Debug, Clone, Default)]
pub struct RuleKeys {
    /// Of the rules that have one limit, which is a share of the budget.
    pub limits: BTreeMap<Rule, f64>,
    pub fixed_baseline: Option<FixedBaseline>,
    pub closure: Option<f64>,
    pub trend: Option<f64>,
    pub trend_confidence: Option<f64>,
    pub trend_horizon_days: Option<f64>,
    pub shift: Option<f64>,
    /// Rules that do not judge at all.
    pub off: Vec<OffRule>,
}

impl<'de> Deserialize<'de> for RuleKeys {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(ReadRuleKeys)
    }
}

/// The rules that have one limit, which is a share of the budget.
fn limited_rules() -> impl Iterator<Item = Rule> {
    Rule::ALL.into_iter().filter(|rule| rule.share_of_budget().is_some())
}

/// The keys besides those of [`limited_rules`].
const OTHERS: [&str; 7] =
    ["fixed_baseline", "closure", "trend", "trend_confidence", "trend_horizon_days", "shift", "off"];

struct ReadRuleKeys;

impl<'de> Visitor<'de> for ReadRuleKeys {
    type Value = RuleKeys;

    fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("a table of rules")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RuleKeys, A::Error> {
        let mut keys = RuleKeys::default();
        while let Some(key) = map.next_key::<String>()? {
            let limited = limited_rules().find(|rule| rule.name() == key);
            match (key.as_str(), limited) {
                (_, Some(rule)) => drop(keys.limits.insert(rule, map.next_value()?)),
                ("fixed_baseline", _) => keys.fixed_baseline = map.next_value()?,
                ("closure", _) => keys.closure = map.next_value()?,
                ("trend", _) => keys.trend = map.next_value()?,
                ("trend_confidence", _) => keys.trend_confidence = map.next_value()?,
                ("trend_horizon_days", _) => keys.trend_horizon_days = map.next_value()?,
                ("shift", _) => keys.shift = map.next_value()?,
                ("off", _) => keys.off = map.next_value()?,
                // Of versions before 0.2, whose rule `cusum` has given way to `shift`: read, and without effect.
                ("cusum_records_per_false_alarm" | "cusum_least_scatter", _) => drop(map.next_value::<IgnoredAny>()?),
                _ => {
                    let known: Vec<&str> = limited_rules().map(Rule::name).chain(OTHERS).collect();
                    let known = known.join("`, `");
                    return Err(serde::de::Error::custom(format_args!(
                        "unknown field `{key}`, expected one of `{known}`"
                    )));
                }
            }
        }
        Ok(keys)
    }
}

/// A baseline from the acceptance file, instead of the mean of the first records.
#[derive(Debug, Clone, Copy, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedBaseline {
    pub value: f64,
    pub sd: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(try_from = "String")]
pub struct OffRule(Rule);

impl TryFrom<String> for OffRule {
    type Error = MessageError;

    fn try_from(name: String) -> Result<Self, MessageError> {
        match Rule::from_name(&name) {
            Some(Rule::Requirement) => Err(MessageError(message!("config_off_requirement"))),
            Some(Rule::Overdue) => Err(MessageError(message!("config_off_overdue"))),
            Some(rule) => Ok(Self(rule)),
            None => Err(MessageError(message!("unknown_rule", rule = sent(&name)))),
        }
    }
}

/// The key of a rule's limit within its section.
fn key(rule: Rule) -> &'static str {
    static KEYS: LazyLock<Vec<String>> =
        LazyLock::new(|| Rule::ALL.iter().map(|rule| format!("rules.{}", rule.name())).collect());
    &KEYS[rule as usize]
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
        for rule in limited_rules() {
            let own = self.limits.get(&rule).map(|value| limit(*value, key(rule)));
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

    fn is_off(&self, rule: Rule) -> bool {
        self.off.contains(&OffRule(rule))
    }

    /// `section` is where the keys stand.
    pub(super) fn check(&self, section: &str) -> Result<(), ConfigError> {
        let require = |holds, key: &str, fault| ConfigError::unless(holds, format!("{section}.{key}"), fault);
        let others = [
            ("shift", self.shift),
            ("closure", self.closure),
            ("trend", self.trend),
            ("trend_horizon_days", self.trend_horizon_days),
        ];
        let others = others.into_iter().filter_map(|(key, value)| Some((key, value?)));
        for (key, value) in self.limits.iter().map(|(rule, value)| (rule.name(), *value)).chain(others) {
            require(value.is_finite() && value > 0.0, key, message!("not_positive", value = text(value)))?;
        }
        if let Some(confidence) = self.trend_confidence {
            let fault = between(0.5, 1.0, confidence);
            require(confidence > 0.5 && confidence < 1.0, "trend_confidence", fault)?;
        }
        let Some(FixedBaseline { value, sd }) = self.fixed_baseline else { return Ok(()) };
        require(value.is_finite(), "fixed_baseline.value", message!("not_finite", value = text(value)))?;
        not_negative(format!("{section}.fixed_baseline.sd"), sd.unwrap_or(0.0))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
pub enum OverriddenCoefficient {
    #[serde(rename = "D_I")]
    DI,
    #[serde(rename = "D_S")]
    DS,
}
