//! `/v1/alerts`: what fires, what has fired, and what people say of it.

use axum::http::header::CONTENT_TYPE;

use super::signed::Signed;
use crate::core::alert_filter::AlertFilter;
use crate::http::prelude::*;
use crate::pipeline::{AlertChange, AlertOrder, AlertStep};
use crate::wire::alert::AlertBody;
use crate::wire::alert_csv;
use crate::words::asked;

const DEFAULT_ALERTS: usize = 100;
const MOST_ALERTS: usize = 10_000;

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct AlertsQuery {
    /// `firing`, `acknowledged`, `silenced`, `inhibited` or `resolved`.
    state: Option<String>,
    /// Of one gyro.
    serial: Option<String>,
    /// Of one rule: `step`, `range`, `baseline`, ….
    rule: Option<String>,
    /// `D_I`, `D_S`, `D_O`, `E`, `G` or `all`.
    coefficient: Option<String>,
    /// `warning` or `critical`.
    severity: Option<String>,
    /// Where the gyro was when it was last judged.
    imu: Option<String>,
    /// At most so many; 100 unless it is given, all that there are in CSV.
    limit: Option<usize>,
    /// `next` of the page before.
    cursor: Option<String>,
    /// `json` or `csv`; without it, `Accept` decides.
    format: Option<String>,
}

/// Alerts, newest first.
#[derive(Serialize, ToSchema)]
struct Alerts {
    alerts: Vec<ListedAlert>,
    /// Cursor of the next page; null on the last.
    #[schema(required)]
    next: Option<String>,
}

/// An alert among others.
#[derive(Serialize, ToSchema)]
struct ListedAlert {
    #[serde(flatten)]
    alert: AlertBody,
    /// The same for all alerts that rest on the same record of the same gyro: one change of a gyro violates several
    /// rules.
    group: String,
}

/// Alerts, the newest first. An alert lasts: when it fires again it is the same alert.
#[utoipa::path(get, path = "/v1/alerts", tag = "alerts",
    params(AlertsQuery),
    responses(
        (status = 200, description = "the alerts", content((Alerts = "application/json"), (String = "text/csv")),
        headers(("Link" = String, description = "the next page"))),
        (status = 404, description = "no such gyro")))]
pub async fn get_alerts(
    app: App,
    Parameters(asked): Parameters<AlertsQuery>,
    uri: Uri,
    headers: HeaderMap,
) -> Answer<Response> {
    let csv = query::wants_csv(asked.format.as_deref(), &headers)?;
    let limit = query::limit(asked.limit, if csv { MOST_ALERTS } else { DEFAULT_ALERTS }, MOST_ALERTS)?;
    let before = query::position(List::Alerts, asked.cursor.as_deref())?.map(Id);
    let filter = filter(&app, &asked)?;
    let found = app.pipeline.alerts.find(&filter, before, limit as u32 + 1).await?;
    let (alerts, next) = query::page(List::Alerts, found, limit, |last| last.id.parse().ok());
    let link = query::link(&uri, next.as_deref());
    if csv {
        let text = alert_csv::to_csv(&alerts);
        return Ok((link, [(CONTENT_TYPE, "text/csv; charset=utf-8")], text).into_response());
    }
    let listed = |alert: AlertBody| ListedAlert { group: alert.group(), alert };
    Ok((link, Json(Alerts { alerts: alerts.into_iter().map(listed).collect(), next })).into_response())
}

fn filter(app: &App, asked: &AlertsQuery) -> Answer<AlertFilter> {
    Ok(AlertFilter {
        standing: query::named("state", asked.state.as_deref())?,
        gyro: asked.serial.as_deref().map(|serial| query::gyro(app, serial)).transpose()?,
        coefficient: query::named("coefficient", asked.coefficient.as_deref())?,
        rule: query::named("rule", asked.rule.as_deref())?,
        severity: query::named("severity", asked.severity.as_deref())?,
        imu: asked.imu.clone(),
    })
}

/// One alert and what became of it.
#[derive(Serialize, ToSchema)]
pub struct AlertDetail {
    #[serde(flatten)]
    alert: AlertBody,
    /// Its newest thousand steps, oldest first.
    history: Vec<StepBody>,
    /// Of a station: identifiers of the alerts of gyros that it explains, of which nobody is told meanwhile.
    inhibits: Vec<String>,
}

/// One step of an alert.
#[derive(Serialize, ToSchema)]
struct StepBody {
    id: String,
    at: String,
    /// `fire`, `escalate`, `lower`, `repeat`, `resolve`, `digest` (told at the end of an import); or what somebody did:
    /// `acknowledge`, `unacknowledge`, `silence`.
    action: String,
    /// Whether it is told to the hooks that are enabled, if there are any.
    told: bool,
    #[schema(required)]
    by: Option<String>,
    #[schema(required)]
    reason: Option<String>,
    /// The alert as it then was.
    alert: AlertBody,
}

impl From<AlertStep> for StepBody {
    fn from(step: AlertStep) -> Self {
        let AlertStep { id, at, action, told, author, reason, alert } = step;
        let reason = reason.map(|reason| asked().words(&reason));
        Self { id: id.to_string(), at: time::format(at), action, told, by: author, reason, alert }
    }
}

/// One alert with its history.
#[utoipa::path(get, path = "/v1/alerts/{id}", tag = "alerts",
    responses((status = 200, description = "the alert", body = AlertDetail)))]
pub async fn get_alert(app: App, Path(id): Path<String>) -> Answer<Json<AlertDetail>> {
    let number = query::id(&id, Problem::unknown_alert)?;
    let found = app.pipeline.alerts.get(number).await?.ok_or_else(|| Problem::unknown_alert(&id))?;
    let inhibited = app.pipeline.alerts.inhibited_by(number).await?;
    Ok(Json(AlertDetail {
        alert: found.alert,
        history: found.steps.into_iter().map(StepBody::from).collect(),
        inhibits: inhibited.into_iter().map(|alert| alert.id).collect(),
    }))
}

/// Who wants nobody to be told, until when, and why.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct SilenceOrder {
    /// RFC 3339; in the future.
    until: String,
    #[schema(min_length = 1, max_length = 64)]
    by: String,
    #[schema(min_length = 1, max_length = 4096)]
    reason: String,
}

/// Stops the repeats until it resolves or becomes more severe. Both are still told.
#[utoipa::path(post, operation_id = "acknowledge_alert", path = "/v1/alerts/{id}/acknowledge", tag = "alerts", request_body = Signed,
    responses(
        (status = 200, description = "the alert, acknowledged", body = AlertBody),
        (status = 409, description = "it is resolved")))]
pub async fn post_acknowledge(app: App, Path(id): Path<String>, body: Document) -> Answer<Json<AlertBody>> {
    signed(&app, &id, AlertChange::Acknowledge, &body).await
}

/// Nobody knows, after all: repeats go on.
#[utoipa::path(post, operation_id = "unacknowledge_alert", path = "/v1/alerts/{id}/unacknowledge", tag = "alerts", request_body = Signed,
    responses((status = 200, description = "the alert, not acknowledged", body = AlertBody)))]
pub async fn post_unacknowledge(app: App, Path(id): Path<String>, body: Document) -> Answer<Json<AlertBody>> {
    signed(&app, &id, AlertChange::Unacknowledge, &body).await
}

async fn signed(app: &App, id: &str, change: AlertChange, body: &Document) -> Answer<Json<AlertBody>> {
    let Signed { by, reason } = Signed::read(body)?;
    changed(app, id, change, (by, reason)).await
}

async fn changed(app: &App, id: &str, change: AlertChange, (by, reason): (String, String)) -> Answer<Json<AlertBody>> {
    let order = AlertOrder { alert: query::id(id, Problem::unknown_alert)?, change, by, reason };
    Ok(Json(app.pipeline.alerts.change(order).await?))
}

/// Nobody is told before a time. What has changed by then is told at its end; a later silence replaces an earlier one.
#[utoipa::path(post, operation_id = "silence_alert", path = "/v1/alerts/{id}/silence", tag = "alerts", request_body = SilenceOrder,
    responses((status = 200, description = "the alert, silenced", body = AlertBody)))]
pub async fn post_silence(app: App, Path(id): Path<String>, body: Document) -> Answer<Json<AlertBody>> {
    let (change, signed) = body.read(|bytes| {
        let SilenceOrder { until, by, reason } = json::parse(bytes)?;
        let mut faults = Faults::default();
        let until = future("/until", &until, app.clock.now(), &mut faults);
        let signed = text::signed("/by", by, reason, &mut faults);
        faults.or((AlertChange::Silence { until }, signed))
    })?;
    changed(&app, &id, change, signed).await
}

pub(super) fn future(pointer: &str, text: &str, now: UtcMicros, faults: &mut Faults) -> UtcMicros {
    let at = time::parse(text).unwrap_or_else(|detail| {
        faults.push(pointer, detail);
        UtcMicros(i64::MAX)
    });
    if at <= now {
        faults.push(pointer, message!("not_in_future"));
    }
    at
}
