//! `/v1/silences`: nobody is told of the alerts that match, for a time.

use super::alerts::future;
use super::query::not_one_of;
use super::signed::Signed;
use crate::core::alert_filter::Matchers;
use crate::core::judge::Rule;
use crate::core::message::sent;
use crate::http::prelude::*;
use crate::pipeline::SilenceOrder;
use crate::wire::silence::{MatchersBody, MatchingSilenceBody, NewSilenceBody};

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct SilencesQuery {
    /// `active`, or `all` that there ever were; those that hold, where it is left out.
    state: Option<String>,
}

/// Silences, newest first, a thousand at the most.
#[derive(Serialize, ToSchema)]
pub struct Silences {
    silences: Vec<MatchingSilenceBody>,
}

/// Silences of many alerts, newest first.
#[utoipa::path(get, path = "/v1/silences", tag = "alerts",
    params(SilencesQuery),
    responses((status = 200, description = "the silences", body = Silences)))]
pub async fn get_silences(app: App, Parameters(asked): Parameters<SilencesQuery>) -> Answer<Json<Silences>> {
    let all = match asked.state.as_deref() {
        None | Some("active") => false,
        Some("all") => true,
        Some(other) => return Err(not_one_of("state", ["active", "all"], other)),
    };
    Ok(Json(Silences { silences: app.pipeline.alerts.silences(all).await? }))
}

/// Nobody is told of any alert that matches, before a time: of those that fire, and of those that will. What has
/// changed by then is told at its end.
#[utoipa::path(post, operation_id = "post_silence", path = "/v1/silences", tag = "alerts", request_body = NewSilenceBody,
    responses(
        (status = 201, description = "it holds", body = MatchingSilenceBody, headers(("Location" = String, description = "where it is"))),
        (status = 409, description = "there are too many")))]
pub async fn post_matching_silence(app: App, body: Document) -> Answer<Response> {
    let order = body.read(|bytes| read(bytes, app.clock.now()))?;
    let id = app.pipeline.alerts.order_silence(order).await?;
    let silence = shown(&app, id).await?;
    Ok((StatusCode::CREATED, [(LOCATION, format!("/v1/silences/{id}"))], Json(silence)).into_response())
}

fn read(bytes: &[u8], now: UtcMicros) -> Result<SilenceOrder, Faults> {
    let NewSilenceBody { matchers, until, by, reason } = json::parse(bytes)?;
    let mut faults = Faults::default();
    let matchers = matchers_of(matchers, &mut faults);
    let until = future("/until", &until, now, &mut faults);
    let (by, reason) = text::signed("/by", by, reason, &mut faults);
    faults.or(SilenceOrder::Begin { matchers, until, by, reason })
}

fn matchers_of(body: MatchersBody, faults: &mut Faults) -> Matchers {
    if body == MatchersBody::default() {
        faults.push("/matchers", message!("silence_matches_nothing"));
    }
    let MatchersBody { serial, imu, station, rule } = body;
    let mut matched =
        |member: &str, name: Option<String>| text::matched(&format!("/matchers/{member}"), &name?, faults);
    let [serial, imu, station] =
        [("serial", serial), ("imu", imu), ("station", station)].map(|(of, name)| matched(of, name));
    let known = rule.as_deref().and_then(Rule::from_name);
    if let Some(rule) = rule.filter(|_| known.is_none()) {
        faults.push("/matchers/rule", message!("unknown_rule", rule = sent(&rule)));
    }
    Matchers { serial, imu, station, rule: known }
}

/// One silence.
#[utoipa::path(get, path = "/v1/silences/{id}", tag = "alerts",
    responses((status = 200, description = "the silence", body = MatchingSilenceBody)))]
pub async fn get_silence(app: App, Path(id): Path<String>) -> Answer<Json<MatchingSilenceBody>> {
    Ok(Json(shown(&app, query::id(&id, Problem::unknown_silence)?).await?))
}

async fn shown(app: &App, id: Id) -> Answer<MatchingSilenceBody> {
    app.pipeline.alerts.silence(id).await?.ok_or_else(|| Problem::unknown_silence(id))
}

/// Ends a silence: what it has held back is told. One that is over already stays as it is.
#[utoipa::path(post, operation_id = "end_silence", path = "/v1/silences/{id}/end", tag = "alerts", request_body = Signed,
    responses((status = 200, description = "the silence, ended", body = MatchingSilenceBody)))]
pub async fn post_end_silence(app: App, Path(id): Path<String>, body: Document) -> Answer<Json<MatchingSilenceBody>> {
    let Signed { by, reason } = Signed::read(&body)?;
    let silence = query::id(&id, Problem::unknown_silence)?;
    app.pipeline.alerts.order_silence(SilenceOrder::End { silence, by, reason }).await?;
    Ok(Json(shown(&app, silence).await?))
}
