//! The fitted numbers of one gyro, and what the dwells leave open.

use std::collections::BTreeMap;

use crate::core::calibrate::bench::BenchCoefficient;
use crate::core::calibrate::design;
use crate::core::calibrate::{EffectParameter, GyroCalibration, NullDirection, Parameter};
use crate::wire::answer::UncertaintyBody;
use crate::wire::prelude::*;
use crate::wire::unit;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ParameterBody {
    pub name: String,
    pub unit: String,
    pub value: f64,
    /// None where the dwells do not determine the parameter, or nothing gives the noise.
    #[schema(required)]
    pub sd: Option<f64>,
    /// Whether the dwells, with the gauge, leave one value.
    pub determined: bool,
    /// What `sd` is made of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintyBody>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EffectParameterBody {
    /// Id of the catalogue.
    pub effect: String,
    pub name: String,
    pub unit: String,
    pub value: f64,
    /// None where nothing gives the noise.
    #[schema(required)]
    pub sd: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct NullDirectionBody {
    /// Shares of the parameters, a unit vector; those of zero are left out.
    pub direction: BTreeMap<String, f64>,
    /// The condition that was imposed to make the estimate unique; none where it is cut off at the shortest one.
    #[schema(required)]
    pub gauge: Option<String>,
}

impl ParameterBody {
    pub(super) fn of(p: &Parameter, gyro: &GyroCalibration, i: usize) -> Self {
        let uncertainty = gyro.uncertainty.as_ref().filter(|_| p.sd.is_some());
        let budget = uncertainty.and_then(|parts| parts.budgets(|covariance| Some([covariance[(i, i)]])));
        Self {
            uncertainty: budget.map(|[budget]| (&budget).into()),
            name: p.name.to_owned(),
            unit: design::unit(p.term).to_owned(),
            value: p.value,
            sd: p.sd,
            determined: p.determined,
        }
    }
}

bodies! {
    ParameterBody of BenchCoefficient: name, unit, value, sd, determined: |_| true,
        uncertainty: |one| one.uncertainty.as_ref().map(UncertaintyBody::from);
    EffectParameterBody of EffectParameter: effect, name = coefficient.name,
        unit: |parameter| unit::of_machines(parameter.coefficient.unit), value, sd;
}

impl NullDirectionBody {
    pub(super) fn of(null: &NullDirection, gyro: &GyroCalibration) -> Self {
        let shares = gyro.parameters.iter().zip(null.direction.iter());
        Self {
            direction: shares.filter(|(_, s)| s.abs() > 1e-9).map(|(p, s)| (p.name.to_owned(), *s)).collect(),
            gauge: null.gauge.map(str::to_owned),
        }
    }
}
