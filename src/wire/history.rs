//! The answer to `GET /v1/gyros/{serial}/diagnosis`: why the coefficients of a gyro changed over its history.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::core::changes::{HistoryDiagnosis, NamedCause, Rejected};

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HistoryDiagnosisBody {
    pub serial: String,
    /// Other gyros that met the same stations, from which the stations' offsets were told.
    pub peers: usize,
    pub coefficients: Vec<CoefficientBody>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CoefficientBody {
    pub coefficient: Cow<'static, str>,
    /// `too_few`, `no_change`, `explained`, `partly_explained` or `unexplained`.
    pub verdict: Cow<'static, str>,
    pub records: usize,
    pub unit: Cow<'static, str>,
    /// Scatter of calibration, from successive differences.
    pub scatter: f64,
    /// Root mean square about the mean.
    pub spread: f64,
    pub causes: Vec<CauseBody>,
    /// What was tried and not named, and why.
    pub candidates: Vec<RejectedBody>,
    /// Significance of what follows in time after all that was named.
    pub remaining_p_value: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CauseBody {
    pub cause: Cow<'static, str>,
    /// Every cause that these records cannot tell from it, itself included.
    pub class: Vec<Cow<'static, str>>,
    pub detail: String,
    pub estimates: Vec<EstimateBody>,
    pub held_out: LeftOutBody,
    pub p_value_adjusted: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = HistoryEstimateBody)]
pub struct EstimateBody {
    pub name: String,
    pub value: f64,
    pub sd: f64,
    pub unit: Cow<'static, str>,
}

/// Error of records predicted from the others, root mean square.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LeftOutBody {
    pub before: f64,
    pub after: f64,
    pub closure: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RejectedBody {
    pub cause: Cow<'static, str>,
    pub detail: String,
    pub reason: String,
}

impl HistoryDiagnosisBody {
    pub fn new(serial: &str, peers: usize, answers: &[HistoryDiagnosis]) -> Self {
        Self { serial: serial.to_owned(), peers, coefficients: answers.iter().map(CoefficientBody::from).collect() }
    }
}

impl From<&HistoryDiagnosis> for CoefficientBody {
    fn from(answer: &HistoryDiagnosis) -> Self {
        Self {
            coefficient: answer.coefficient.name().into(),
            verdict: answer.verdict.name().into(),
            records: answer.records,
            unit: "deg/(h*g0)".into(),
            scatter: answer.scatter,
            spread: answer.spread,
            causes: answer.causes.iter().map(CauseBody::from).collect(),
            candidates: answer.rejected.iter().map(RejectedBody::from).collect(),
            remaining_p_value: answer.remaining_p_value,
        }
    }
}

impl From<&NamedCause> for CauseBody {
    fn from(cause: &NamedCause) -> Self {
        let estimate = |(name, value, sd, unit): &(String, f64, f64, &'static str)| EstimateBody {
            name: name.clone(),
            value: *value,
            sd: *sd,
            unit: (*unit).into(),
        };
        Self {
            cause: cause.cause.into(),
            class: cause.class.iter().map(|&id| id.into()).collect(),
            detail: cause.detail.clone(),
            estimates: cause.estimates.iter().map(estimate).collect(),
            held_out: LeftOutBody { before: cause.before, after: cause.after, closure: cause.closure },
            p_value_adjusted: cause.p_value_adjusted,
        }
    }
}

impl From<&Rejected> for RejectedBody {
    fn from(rejected: &Rejected) -> Self {
        Self { cause: rejected.cause.into(), detail: rejected.detail.clone(), reason: rejected.reason.clone() }
    }
}
