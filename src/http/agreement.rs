//! `/v1/gyros/{serial}/agreement`: the results of every method side by side, and their range (Table 5 of the paper).

use crate::http::prelude::*;
use crate::pipeline::{Compared, Comparison};
use crate::wire::answer::{FigureBody, VerdictBody};
use crate::wire::body::{ToBody, bodies};

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct AgreementQuery {
    /// Oldest instant, a day (UTC) or an RFC 3339 time, itself included. With `from` or `to`, all results in between are
    /// compared.
    from: Option<String>,
    /// Newest instant, itself included.
    to: Option<String>,
}

/// Results of every method. Without `from` and `to`: the separation nearest in time to the newest bench result, and
/// of each bench method the nearest result before and after it (or the two nearest, where all lie on one side).
#[derive(Serialize, ToSchema)]
pub struct Agreement {
    serial: String,
    /// `deg/(h*g0)`.
    unit: &'static str,
    /// Oldest first.
    results: Vec<ResultBody>,
    /// max - min over the results that count.
    range: RangeBody,
    /// The ranges against their limits, over the same results.
    verdicts: Vec<VerdictBody>,
}

#[derive(Serialize, ToSchema)]
struct ResultBody {
    /// `rigid`, `published`, `torque_feedback` or `turntable_servo`.
    method: &'static str,
    measured_at: String,
    station: String,
    /// The IMU and slot of a separation.
    #[schema(required)]
    imu: Option<String>,
    #[schema(required)]
    slot: Option<&'static str>,
    /// Identifier of the record or of the bench result.
    id: String,
    d_i: FigureBody,
    d_s: FigureBody,
    /// Whether it counts in the ranges and the verdicts: of a separation, only the judged method's figures do; and
    /// without `from` and `to`, only what is no more than `judging.agreement_days` older than the newest of these
    /// results.
    counts: bool,
}

/// Null with fewer than two results.
#[derive(Serialize, ToSchema)]
struct RangeBody {
    #[serde(rename = "D_I")]
    #[schema(required)]
    d_i: Option<f64>,
    #[serde(rename = "D_S")]
    #[schema(required)]
    d_s: Option<f64>,
}

/// Results of every method for the gyro side by side, and their range.
#[utoipa::path(get, path = "/v1/gyros/{serial}/agreement", tag = "gyros",
    params(AgreementQuery),
    responses((status = 200, description = "the results", body = Agreement)))]
pub async fn get_agreement(
    app: App,
    Path(serial): Path<String>,
    Parameters(asked): Parameters<AgreementQuery>,
) -> Answer<Json<Agreement>> {
    let gyro = query::gyro(&app, &serial)?;
    let span = match (&asked.from, &asked.to) {
        (None, None) => None,
        (from, to) => Some(query::span(from.as_deref(), to.as_deref())?),
    };
    let Comparison { results, range, verdicts } = app.pipeline.queries.histories.compare_methods(gyro, span).await?;
    let verdicts = verdicts.iter().map(|verdict| VerdictBody::of(&serial, verdict)).collect();
    let [d_i, d_s] = range;
    Ok(Json(Agreement {
        unit: "deg/(h*g0)",
        results: results.to_body(),
        range: RangeBody { d_i, d_s },
        verdicts,
        serial,
    }))
}

bodies! {
    ResultBody of Compared: method, measured_at = at, station,
        imu: |result| result.seat.as_ref().map(|(imu, _)| imu.clone()),
        slot: |result| result.seat.as_ref().map(|(_, slot)| slot.name()), id,
        d_i: |result| result.d[0].to_body(), d_s: |result| result.d[1].to_body(), counts;
}
