//! `/v1/diagnoses`: diagnoses of many campaigns, ordered, followed, canceled; and what they say together.

use axum::http::header::CONTENT_TYPE;

use super::query::{bad, with_sign};
use crate::core::fault::Fault;
use crate::core::message::list;
use crate::http::prelude::*;
use crate::pipeline::{Accepted, DiagnosisOrder};
use crate::wire::diagnoses::{JobDetailBody, JobsBody, SummaryBody, WhichBody};
use crate::wire::diagnoses_csv;

const MOST_ORDERS: usize = 100;
const MOST_FAILURES: usize = 1000;

/// Orders the diagnoses of stored campaigns: all that count, or those of an IMU, a station, a stretch of time.
///
/// Those whose diagnosis is of this version of the program and the model in force are done already, unless `again` is
/// true. The same order, sent while it is being worked off, is that order.
#[utoipa::path(post, operation_id = "order_diagnoses", path = "/v1/diagnoses", tag = "diagnoses", request_body = WhichBody,
    responses(
        (status = 202, description = "taken; `Location` says how it goes", body = JobDetailBody, headers(("Location" = String, description = "where its progress is"))),
        (status = 200, description = "the same is being worked off", body = JobDetailBody, headers(("Location" = String, description = "where its progress is"))),
        (status = 422, description = "an unknown IMU or station, no time …; the places are named")))]
pub async fn post_diagnoses(app: App, body: Document) -> Answer<Response> {
    let wanted = body.read(|bytes| app.pipeline.diagnoses.check_wanted(json::parse(bytes)?))?;
    let (status, id) = match app.pipeline.diagnoses.order(DiagnosisOrder::Start(wanted)).await? {
        Accepted::Stored { id, .. } => (StatusCode::ACCEPTED, id),
        Accepted::There { id, .. } => (StatusCode::OK, id),
    };
    let job = one(&app, id, None, MOST_FAILURES).await?;
    Ok((status, [(LOCATION, format!("/v1/diagnoses/{id}"))], Json(job)).into_response())
}

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct PageQuery {
    /// At most so many; 20 orders or 100 failures unless it is given.
    limit: Option<usize>,
    /// `next` of the page before.
    cursor: Option<String>,
}

impl PageQuery {
    fn position(&self, list: List) -> Answer<Option<Id>> {
        Ok(query::position(list, self.cursor.as_deref())?.map(Id))
    }
}

/// Orders with their progress, newest first.
#[utoipa::path(get, operation_id = "get_diagnosis_orders", path = "/v1/diagnoses", tag = "diagnoses",
    params(PageQuery),
    responses(
        (status = 200, description = "the orders", body = JobsBody, headers(("Link" = Option<String>, description = "where it goes on")))))]
pub async fn get_diagnoses(app: App, uri: Uri, Parameters(asked): Parameters<PageQuery>) -> Answer<Response> {
    let limit = query::limit(asked.limit, 20, MOST_ORDERS)?;
    let diagnoses = app.pipeline.diagnoses.jobs(asked.position(List::DiagnosisOrders)?, limit as u32 + 1).await?;
    let (diagnoses, next) = query::page(List::DiagnosisOrders, diagnoses, limit, |last| last.id.parse().ok());
    Ok((query::link(&uri, next.as_deref()), Json(JobsBody { diagnoses, next })).into_response())
}

/// One order: how far it has come, and which campaigns could not be diagnosed, and why.
#[utoipa::path(get, operation_id = "get_diagnosis_order", path = "/v1/diagnoses/{id}", tag = "diagnoses",
    params(PageQuery),
    responses(
        (status = 200, description = "the order", body = JobDetailBody, headers(("Link" = Option<String>, description = "where its failures go on")))))]
pub async fn get_one(
    app: App,
    uri: Uri,
    Path(id): Path<String>,
    Parameters(asked): Parameters<PageQuery>,
) -> Answer<Response> {
    let limit = query::limit(asked.limit, 100, MOST_FAILURES)?;
    let job =
        one(&app, query::id(&id, Problem::no_such_diagnoses)?, asked.position(List::DiagnosisFailures)?, limit).await?;
    Ok((query::link(&uri, job.next.as_deref()), Json(job)).into_response())
}

/// Cancels an order. What is done stays done; what is in work is finished.
#[utoipa::path(delete, operation_id = "cancel_diagnosis_order", path = "/v1/diagnoses/{id}", tag = "diagnoses",
    responses((status = 204, description = "canceled, now or before"), (status = 409, description = "it has ended")))]
pub async fn delete_one(app: App, Path(id): Path<String>) -> Answer<StatusCode> {
    app.pipeline.diagnoses.order(DiagnosisOrder::Cancel(query::id(&id, Problem::no_such_diagnoses)?)).await?;
    Ok(StatusCode::NO_CONTENT)
}

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct SummaryQuery {
    /// Of this IMU alone.
    imu: Option<String>,
    /// Of campaigns at this station alone.
    station: Option<String>,
    /// Of this effect alone, by its catalogue name.
    effect: Option<String>,
    /// Of campaigns measured from this time on: a day (UTC) or an RFC 3339 time.
    since: Option<String>,
    /// Of campaigns measured up to this time: a day (UTC) or an RFC 3339 time.
    until: Option<String>,
    /// `json` or `csv`; without it, `Accept` decides.
    format: Option<String>,
}

/// What the diagnoses of stored campaigns say together: which effects, in which IMUs and gyros, at which stations,
/// since when. How far the gap closes, by how much D_I and D_S move, and whose gap the catalogue does not explain.
///
/// Campaigns that were voided or revised are left out. In CSV a line is an effect in a gyro, or an IMU in doubt.
#[utoipa::path(get, operation_id = "get_diagnosis_summary", path = "/v1/diagnoses/summary", tag = "diagnoses",
    params(SummaryQuery),
    responses(
        (status = 200, description = "the summary", content((SummaryBody = "application/json"), (String = "text/csv")))))]
pub async fn get_summary(
    app: App,
    headers: HeaderMap,
    Parameters(asked): Parameters<SummaryQuery>,
) -> Answer<Response> {
    let csv = query::wants_csv(asked.format.as_deref(), &headers)?;
    let SummaryQuery { imu, station, effect, since, until, .. } = asked;
    let [since, until] = [since, until].map(|time| time.map(|text| with_sign(&text).into_owned()));
    let which = WhichBody { imu, station, since, until, again: false };
    let filter = app.pipeline.diagnoses.summary_filter(&which, effect.as_deref()).map_err(|faults| {
        let parameter = |fault: &Fault| fault.pointer.trim_start_matches('/').to_owned();
        let said = |fault: Fault| message!("parameter_fault", parameter = parameter(&fault), fault = fault.message);
        let mut said = faults.0.into_iter().map(said);
        match (said.next(), said.len()) {
            (Some(one), 0) => bad(one),
            (one, _) => bad(message!("several", faults = list(one.into_iter().chain(said)))),
        }
    })?;
    let summary = app.pipeline.diagnoses.summary(&filter).await?;
    if csv {
        let text = diagnoses_csv::to_csv(&summary);
        return Ok(([(CONTENT_TYPE, "text/csv; charset=utf-8")], text).into_response());
    }
    Ok(Json(summary).into_response())
}

async fn one(app: &App, id: Id, after: Option<Id>, limit: usize) -> Answer<JobDetailBody> {
    app.pipeline.diagnoses.job(id, after, limit as u32).await?.ok_or_else(|| Problem::no_such_diagnoses(id))
}
