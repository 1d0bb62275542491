//! What a calibration record shows by itself, as `diagnose RECORD` and `GET /v1/records/{id}/diagnosis` answer it.
//!
//! The members of a campaign's diagnosis, as far as a record has them. Nothing was held out: there are no dwells.

use crate::core::diagnose::{BUDGET_DEG_PER_H_G0, CLOSURE_CLASS, ClosureDiagnosis, GyroClosure};
use crate::core::effects::Effect;
use crate::core::message::{figure, list};
use crate::wire::prelude::*;

const D_O_UNIT: &str = "deg/(h*g0)";

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ClosureBody {
    /// `no_gap`, or `partly_explained`: what it is called is one of a class that a record cannot take apart.
    pub verdict: String,
    pub gap: ClosureGapBody,
    #[serde(rename = "where")]
    pub located: ClosureWhereBody,
    pub effects: Vec<ClosureEffectBody>,
    pub impact: Vec<ClosureImpactBody>,
    pub next_measurements: Vec<MeasurementBody>,
    /// In the language that the request asks for.
    pub notes: Vec<String>,
    /// The notes for programs.
    #[serde(default)]
    pub note_codes: Vec<MessageBody>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ClosureGapBody {
    /// Root mean square of D_O over the gyros: a drift in deg/h where 1 g0 acts along O.
    pub rms_deg_per_h_g0: f64,
    pub budget_deg_per_h_g0: f64,
    /// Smallest probability of a gyro's D_O by noise alone; null where no standard deviations are stated.
    #[schema(required)]
    pub p_value: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ClosureWhereBody {
    pub gyros: Vec<ClosureShareBody>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ClosureShareBody {
    pub slot: String,
    pub share: f64,
    pub d_o: f64,
    #[schema(required)]
    pub sd: Option<f64>,
    pub of_budget: f64,
    #[schema(required)]
    pub p_value: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ClosureEffectBody {
    pub effect: String,
    /// Every entry that no single record can tell from it, itself included.
    pub class: Vec<String>,
    pub gyros: Vec<String>,
    /// D_O, and the clocking that would take its place.
    pub estimates: Vec<ClosureEstimateBody>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ClosureEstimateBody {
    /// The member of the class that the estimate is for.
    pub effect: String,
    pub slot: String,
    pub name: String,
    pub value: f64,
    #[schema(required)]
    pub sd: Option<f64>,
    pub unit: String,
}

/// What D_S would be if the closure is clocking; if it is D_O, D_S stays.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ClosureImpactBody {
    pub slot: String,
    pub coefficient: String,
    /// The member of the class under which the coefficient shifts.
    pub under: String,
    pub plain: f64,
    pub augmented: f64,
    pub shift: f64,
    pub of_budget: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MeasurementBody {
    /// In the language that the request asks for.
    pub measurement: String,
    /// The same for programs.
    #[serde(flatten)]
    pub message: MessageBody,
    pub separates: Vec<String>,
}

impl From<&ClosureDiagnosis> for ClosureBody {
    fn from(d: &ClosureDiagnosis) -> Self {
        let total: f64 = d.gyros.iter().map(|g| g.d_o * g.d_o).sum();
        let out: Vec<&GyroClosure> = d.gyros.iter().filter(|g| g.stands_out).collect();
        let p_values = d.gyros.iter().filter_map(|g| g.p_value);
        let unstated = d.gyros.iter().any(|g| g.sd.is_none()).then(|| message!("closure_without_deviations"));
        let untested = (!out.is_empty()).then(|| message!("closure_is_not_tested"));
        let notes: Vec<Message> = unstated.into_iter().chain(untested).collect();
        Self {
            verdict: d.verdict.name().to_owned(),
            gap: ClosureGapBody {
                rms_deg_per_h_g0: d.rms,
                budget_deg_per_h_g0: BUDGET_DEG_PER_H_G0,
                p_value: p_values.reduce(f64::min),
            },
            located: ClosureWhereBody { gyros: d.gyros.iter().map(|g| ClosureShareBody::of(g, total)).collect() },
            effects: if out.is_empty() { Vec::new() } else { vec![ClosureEffectBody::of(&out)] },
            impact: out.iter().map(|gyro| gyro.to_body()).collect(),
            next_measurements: if out.is_empty() { Vec::new() } else { measurements(&out) },
            notes: notes.to_body(),
            note_codes: notes.to_body(),
        }
    }
}

impl ClosureShareBody {
    fn of(g: &GyroClosure, total: f64) -> Self {
        Self {
            slot: g.slot.name().to_owned(),
            share: if total > 0.0 { g.d_o * g.d_o / total } else { 0.0 },
            d_o: g.d_o,
            sd: g.sd,
            of_budget: g.of_budget,
            p_value: g.p_value,
        }
    }
}

impl ClosureEffectBody {
    fn of(out: &[&GyroClosure]) -> Self {
        let [d_o, clocking] = CLOSURE_CLASS;
        let both = |g: &&GyroClosure| {
            let clocking_sd = g.sd.map(|sd| sd * g.d_s.abs() / (g.d_s * g.d_s + g.d_o * g.d_o));
            [(d_o, g.slot, "D_O", g.d_o, g.sd, D_O_UNIT), (clocking, g.slot, "phi", g.clocking, clocking_sd, "rad")]
        };
        Self {
            effect: d_o.to_body(),
            class: class(),
            gyros: out.iter().map(|g| g.slot.name().to_owned()).collect(),
            estimates: out.iter().flat_map(both).collect::<Vec<_>>().to_body(),
        }
    }
}

bodies! {
    ClosureEstimateBody of (Effect, Slot, &'static str, f64, Option<f64>, &'static str): effect = 0, slot = 1, name = 2,
        value = 3, sd = 4, unit = 5;
    ClosureImpactBody of GyroClosure: slot, coefficient: |_| "D_S".to_owned(), under: |_| CLOSURE_CLASS[1].to_body(),
        plain = d_s, augmented: |gyro| gyro.d_s + gyro.d_s_shift, shift = d_s_shift,
        of_budget: |gyro| gyro.d_s_shift.abs() / BUDGET_DEG_PER_H_G0;
}

fn class() -> Vec<String> {
    CLOSURE_CLASS.iter().map(ToBody::to_body).collect()
}

/// What would take the class apart, the cheapest first.
fn measurements(out: &[&GyroClosure]) -> Vec<MeasurementBody> {
    let change = |g: &&GyroClosure| {
        g.telling_change.map(|change| message!("closure_of_change", slot = g.slot.name(), change = figure(change, 2)))
    };
    let changes: Vec<Message> = out.iter().filter_map(change).collect();
    let by_change = (!changes.is_empty()).then(|| message!("closure_after_change", changes = list(changes)));
    let others = [message!("closure_seated_again"), message!("closure_on_bench")];
    let all = by_change.into_iter().chain(others);
    let body = |measurement: Message| MeasurementBody {
        measurement: measurement.to_body(),
        message: measurement.to_body(),
        separates: class(),
    };
    all.map(body).collect()
}
