//! The answer to `GET /v1/gyros/{serial}/diagnosis`: why the coefficients of a gyro changed over its history.

use std::borrow::Cow;

use crate::core::changes::{
    AsOf, CauseEstimate, Due, ExcessScatter, HistoryDiagnosis, HistoryHeldOut, NamedCause, Outlier, RandomVariation,
    Rejected,
};
use crate::wire::prelude::*;
use crate::wire::time;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HistoryDiagnosisBody {
    pub serial: String,
    /// Other gyros that met the same stations, from which the stations' doing was told.
    pub peers: usize,
    /// Records that count; of more than 1,000 so many are looked at, spread over their time.
    pub records: usize,
    pub coefficients: Vec<CoefficientBody>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CoefficientBody {
    pub coefficient: Cow<'static, str>,
    /// `too_few`, `no_change`, `explained`, `partly_explained` or `unexplained`.
    pub verdict: Cow<'static, str>,
    /// That were looked at.
    pub records: usize,
    pub unit: Cow<'static, str>,
    /// Scatter of calibration, from successive differences.
    pub scatter: f64,
    /// Root mean square about the mean.
    pub spread: f64,
    pub causes: Vec<CauseBody>,
    /// What was tried and not named, and why.
    pub candidates: Vec<RejectedBody>,
    /// Records that stand apart from those before and after them, and were left out.
    pub outliers: Vec<OutlierBody>,
    /// How the coefficient wanders without a cause; null where it does not.
    #[schema(required)]
    pub wander: Option<WanderBody>,
    /// That what is left is more than scatter; left out where it is not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub excess: Option<ExcessBody>,
    /// Significance of what follows in time after all that was named.
    pub remaining_p_value: f64,
    /// When it leaves its budget, where it ages; null where it does not.
    #[schema(required)]
    pub due: Option<DueBody>,
    /// All this in sentences, in the language of the request.
    pub said: Vec<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CauseBody {
    pub cause: Cow<'static, str>,
    /// Every cause that these records cannot tell from it, itself included.
    pub class: Vec<Cow<'static, str>>,
    /// What it is tied to, in the language of the request.
    pub detail: String,
    pub estimates: Vec<HistoryEstimateBody>,
    /// Null where no block of records can be predicted from the others, or where they say nothing of it.
    #[schema(required)]
    pub held_out: Option<LeftOutBody>,
    pub p_value_adjusted: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HistoryEstimateBody {
    pub name: String,
    pub value: f64,
    pub sd: f64,
    pub unit: Cow<'static, str>,
}

/// Error of blocks of time predicted from the others, root mean square.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LeftOutBody {
    pub before: f64,
    pub after: f64,
    pub closure: f64,
    /// 95 %.
    pub interval: [f64; 2],
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RejectedBody {
    pub cause: Cow<'static, str>,
    pub detail: String,
    pub reason: String,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OutlierBody {
    pub calibrated_at: String,
    /// From its neighbours.
    pub deviation: f64,
    pub sd: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WanderBody {
    /// `random_walk`, `walk_by_record` or `flicker`.
    pub process: String,
    /// Standard deviation after a year, from one record to the next, or altogether.
    pub size: f64,
    pub p_value: f64,
}

/// What is left varies far more than calibrations scatter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ExcessBody {
    /// Standard deviation of what is left, and that expected of calibrations.
    pub sd: f64,
    pub expected: f64,
    pub p_value: f64,
}

/// When the coefficient leaves its budget; an end of an interval is null where it may never come.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DueBody {
    pub at: String,
    pub interval_80: [Option<String>; 2],
    pub interval_95: [Option<String>; 2],
    /// Until when it is within its budget with 95 %; null where that was never so.
    #[schema(required)]
    pub calibrate_by: Option<String>,
}

impl HistoryDiagnosisBody {
    /// The diagnoses of a gyro's coefficients as answers write them.
    pub fn new(serial: &str, peers: usize, as_of: AsOf, answers: &[HistoryDiagnosis]) -> Self {
        let coefficients = answers.iter().map(|answer| CoefficientBody::new(answer, as_of)).collect();
        Self { serial: serial.to_owned(), peers, records: as_of.records, coefficients }
    }
}

impl CoefficientBody {
    fn new(answer: &HistoryDiagnosis, as_of: AsOf) -> Self {
        let due = as_of.newest.zip(answer.due.as_ref());
        Self {
            coefficient: answer.coefficient.name().into(),
            verdict: answer.verdict.name().into(),
            records: answer.records,
            unit: "deg/(h*g0)".into(),
            scatter: answer.scatter,
            spread: answer.spread,
            causes: answer.causes.to_body(),
            candidates: answer.rejected.to_body(),
            outliers: answer.outliers.to_body(),
            wander: answer.wander.to_body(),
            excess: answer.excess.to_body(),
            remaining_p_value: answer.remaining_p_value,
            due: due.map(|(newest, due)| DueBody::new(due, newest)),
            said: answer.sentences(as_of).to_body(),
        }
    }
}

bodies! {
    CauseBody of NamedCause: cause: |named| named.cause.name().into(),
        class: |named| named.class.iter().map(|one| one.name().into()).collect(),
        detail: |named| named.tie.message().to_body(), estimates: |named| vec![named.estimate.to_body()], held_out,
        p_value_adjusted;
    RejectedBody of Rejected: cause: |rejected| rejected.cause.name().into(),
        detail: |rejected| rejected.tie.message().to_body(), reason: |rejected| rejected.why.message().to_body();
    HistoryEstimateBody of CauseEstimate: name, value, sd, unit;
    LeftOutBody of HistoryHeldOut: before, after, closure, interval;
    OutlierBody of Outlier: calibrated_at = at, deviation, sd;
    WanderBody of RandomVariation: process, size, p_value;
    ExcessBody of ExcessScatter: sd, expected, p_value;
}

impl DueBody {
    fn new(due: &Due, newest: UtcMicros) -> Self {
        let at = |days: f64| time::format(newest.plus_days(days));
        Self {
            at: at(due.days),
            interval_80: due.p80.map(|end| end.map(at)),
            interval_95: due.p95.map(|end| end.map(at)),
            calibrate_by: due.calibrate_by.map(at),
        }
    }
}
