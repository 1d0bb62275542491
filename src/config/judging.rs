//! The `[judging]` section, resolved to the limits of one gyro.

use nalgebra::Vector3;
use serde::Deserialize;

use crate::core::judge::limits::{DriftLimits, Limit, LimitKey, Limits, Requirement};
use crate::core::judge::{NoiseParameters, Verdict, requirement};
use crate::core::message::text;
use crate::core::mounting::{Geometry, Slot};
use crate::core::name::{Name, normal_form};
use crate::core::separate::JudgedMethod;
use crate::message;
use crate::wire::time;

use super::ConfigError;
use super::error::{between, not_negative};
use super::requirement::SlotRequirements;
use super::rules::{OverriddenCoefficient, RuleKeys};

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Judging {
    pub method: JudgedMethod,
    pub budget: f64,
    pub confidence: f64,
    pub range_days: f64,
    pub range_min_records: usize,
    pub agreement_days: f64,
    pub remembered_records: usize,
    pub interval_days: f64,
    pub noise: NoiseKeys,
    pub between_stations: BetweenStations,
    pub requirements: bool,
    pub requirement: SlotRequirements,
    pub rules: RuleKeys,
    pub overrides: Vec<Override>,
}

/// How the figures of unmoved gyros scatter: as `gyrowatch fleet-noise` found it, or as gyros usually do.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseKeys {
    pub phi: f64,
    /// deg/(h g0) a root year.
    pub walk: f64,
    /// The day of the fit; none for constants that are not this fleet's.
    pub fitted: Option<String>,
}

impl NoiseKeys {
    fn noise(&self) -> NoiseParameters {
        NoiseParameters { phi: self.phi, walk: self.walk, of_fleet: self.fitted.is_some() }
    }
}

/// How D_I and D_S differ from station to station: standard deviations, deg/(h g0), as `gyrowatch fleet-noise` finds
/// them.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BetweenStations {
    pub d_i: f64,
    pub d_s: f64,
}

/// Limits for what matches; a filter that is left out matches everything.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Override {
    pub imu: Option<String>,
    pub serial: Option<String>,
    pub coefficient: Option<OverriddenCoefficient>,
    pub budget: Option<f64>,
    pub interval_days: Option<f64>,
    #[serde(default)]
    pub requirement: SlotRequirements,
    #[serde(default)]
    pub rules: RuleKeys,
}

impl Judging {
    /// What the gyro `serial`, mounted in `imu`, is judged against.
    pub fn limits(&self, imu: &str, serial: &str) -> Limits {
        let mut limits = Limits {
            closure_is_d_o: self.method == JudgedMethod::Rigid,
            confidence: self.confidence,
            range_days: self.range_days,
            range_min_records: self.range_min_records,
            interval_days: self.fleet_interval_days(),
            noise: self.noise.noise(),
            between_stations: [self.between_stations.d_i, self.between_stations.d_s],
            ..Limits::from_budget(self.budget)
        };
        self.rules.apply(None, None, &mut limits);
        for (place, change) in self.matching(imu, serial) {
            if let Some(budget) = change.budget {
                let budget = Limit { value: budget, from: LimitKey { place, key: "budget" } };
                if change.coefficient != Some(OverriddenCoefficient::DS) {
                    limits.d_i = DriftLimits::from_budget(budget);
                }
                if change.coefficient != Some(OverriddenCoefficient::DI) {
                    limits.d_s = DriftLimits::from_budget(budget);
                }
                if change.coefficient.is_none() {
                    limits.closure = Some(budget);
                }
            }
            change.rules.apply(change.coefficient, place, &mut limits);
            if let Some(days) = change.interval_days {
                limits.interval_days = interval(days, place);
            }
        }
        limits
    }

    /// The overrides that hold for a gyro, with their places.
    fn matching(&self, imu: &str, serial: &str) -> impl Iterator<Item = (Option<u16>, &Override)> {
        let placed = self.overrides.iter().zip(0..).map(|(change, place)| (Some(place), change));
        placed.filter(move |(_, change)| change.matches(imu, serial))
    }

    /// What E and G of the gyro `serial` in `slot` of `imu` must keep. Without an override that names them nothing is
    /// required of a geometry other than the skewed one.
    pub fn requirement(&self, skewed: bool, slot: Slot, imu: &str, serial: &str) -> Requirement {
        let mut required = Requirement::default();
        if skewed && self.requirements {
            required = Requirement::tables_3_and_4()[slot.index()];
        }
        if skewed {
            self.requirement.apply(slot, None, &mut required);
        }
        for (place, change) in self.matching(imu, serial) {
            change.requirement.apply(slot, place, &mut required);
        }
        required
    }

    /// E and G, with their standard deviations, against what is required of them.
    pub fn of_parameters(
        &self,
        geometry: &Geometry,
        (slot, imu, serial): (Slot, &Name, &Name),
        (e, g): (&Vector3<f64>, &Vector3<f64>),
        (e_sd, g_sd): (Option<&Vector3<f64>>, Option<&Vector3<f64>>),
    ) -> [Option<Verdict>; 2] {
        let skewed = matches!(geometry, Geometry::Skewed);
        let required = self.requirement(skewed, slot, imu.as_str(), serial.as_str());
        requirement(&required, e, g, e_sd, g_sd, self.confidence)
    }

    /// The budget of D_I and D_S of the gyro `serial`, mounted in `imu`; the larger one where they have two.
    pub fn budget_of(&self, imu: &str, serial: &str) -> f64 {
        let budgets = self.matching(imu, serial).filter_map(|(_, change)| change.budget);
        budgets.reduce(f64::max).unwrap_or(self.budget)
    }

    /// Whether any gyro may become overdue.
    pub fn has_intervals(&self) -> bool {
        let of_overrides = self.overrides.iter().any(|change| change.interval_days.is_some());
        of_overrides || self.fleet_interval_days().is_some()
    }

    /// Where no override says otherwise.
    pub fn fleet_interval_days(&self) -> Option<Limit> {
        interval(self.interval_days, None)
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        let require = |holds, key: &str, fault| ConfigError::unless(holds, format!("judging.{key}"), fault);
        let between_half_and_1 = self.confidence > 0.5 && self.confidence < 1.0;
        require(between_half_and_1, "confidence", between(0.5, 1.0, self.confidence))?;
        let phi = self.noise.phi;
        require((0.0..1.0).contains(&phi), "noise.phi", message!("config_from_0_below_1", value = text(phi)))?;
        let BetweenStations { d_i, d_s } = self.between_stations;
        let deviations =
            [("noise.walk", self.noise.walk), ("between_stations.d_i", d_i), ("between_stations.d_s", d_s)];
        for (key, sd) in deviations {
            not_negative(format!("judging.{key}"), sd)?;
        }
        not_negative("judging.interval_days", self.interval_days)?;
        if let Some(Err(why)) = self.noise.fitted.as_deref().map(time::parse_start) {
            return Err(ConfigError::of("judging.noise.fitted", why));
        }
        let least = message!("config_at_least", least = 2_usize, value = text(self.range_min_records));
        require(self.range_min_records >= 2, "range_min_records", least)?;
        self.rules.check("judging.rules")?;
        for (i, change) in self.overrides.iter().enumerate() {
            change.check(&format!("judging.overrides[{i}]"))?;
        }
        Ok(())
    }
}

fn interval(days: f64, place: Option<u16>) -> Option<Limit> {
    (days > 0.0).then_some(Limit { value: days, from: LimitKey { place, key: "interval_days" } })
}

impl Override {
    /// `section` is where the override stands.
    fn check(&self, section: &str) -> Result<(), ConfigError> {
        let require = |holds, key: &str, fault| ConfigError::unless(holds, format!("{section}.{key}"), fault);
        for (key, name) in [("imu", &self.imu), ("serial", &self.serial)] {
            let read = name.as_deref().map(|name| Name::parse(name).and_then(|name| name.check_seen()));
            if let Some(Err(why)) = read {
                return Err(ConfigError::of(format!("{section}.{key}"), why));
            }
        }
        self.rules.check(&format!("{section}.rules"))?;
        let of_gyro = self.coefficient.is_none();
        require(of_gyro || self.rules.closure.is_none(), "rules.closure", message!("config_of_whole_gyro"))?;
        let unrequired = self.requirement == SlotRequirements::default();
        require(of_gyro || unrequired, "requirement", message!("config_of_whole_gyro"))?;
        not_negative(format!("{section}.interval_days"), self.interval_days.unwrap_or(0.0))?;
        let Some(budget) = self.budget else { return Ok(()) };
        require(budget.is_finite() && budget > 0.0, "budget", message!("not_positive", value = text(budget)))
    }

    fn matches(&self, imu: &str, serial: &str) -> bool {
        let is = |wanted: &Option<String>, name: &str| {
            wanted.as_deref().is_none_or(|wanted| normal_form(wanted) == normal_form(name))
        };
        is(&self.imu, imu) && is(&self.serial, serial)
    }
}
