//! `…/void` and `…/revise`: what was stored counts no more, or another stands in its place. Nothing is deleted.

use serde_json::value::RawValue;

use super::document::outcome;
use crate::core::correction::CorrectionItem;
use crate::core::fault::Fault;
use crate::core::kind::Kind;
use crate::http::prelude::*;
use crate::pipeline::{Calibration, Corrected, Correction, Submission};
use crate::wire::answer::RecordAnswer;
use crate::wire::body::bodies;
use crate::wire::calibration::CampaignAnswer;
use crate::wire::campaign::{CampaignBody, Form};
use crate::wire::record::RecordBody;
use crate::words;

/// How a record, campaign or bench result stands.
#[derive(Debug, Serialize, ToSchema)]
pub struct StandingBody {
    /// `valid`, `voided`, `revised`, or `set_aside` until somebody confirms it; only what is valid counts.
    state: &'static str,
    #[schema(required)]
    voided: Option<RemarkBody>,
    /// What stands in its place.
    #[schema(required)]
    revised_by: Option<RevisionBody>,
    /// In whose place it stands.
    #[schema(required)]
    revises: Option<RevisionBody>,
    /// Who confirmed the time of a record that was set aside.
    #[serde(skip_serializing_if = "Option::is_none")]
    confirmed: Option<RemarkBody>,
}

/// Who said so, when and why.
#[derive(Debug, Serialize, ToSchema)]
struct RemarkBody {
    at: String,
    author: String,
    reason: String,
}

#[derive(Debug, Serialize, ToSchema)]
struct RevisionBody {
    /// Identifier of the other record.
    record: String,
    #[serde(flatten)]
    remark: RemarkBody,
}

/// An answer, with how the item stands where that is to be said.
#[derive(Serialize, ToSchema)]
pub struct Standing<T> {
    #[serde(flatten)]
    pub answer: T,
    #[serde(flatten)]
    pub standing: Option<StandingBody>,
}

impl StandingBody {
    /// What whoever sends something again has to know besides the answer that he was given at first.
    pub fn unless_valid(self) -> Option<Self> {
        (self.state != "valid").then_some(self)
    }
}

/// A record or bench result that counts no more.
#[derive(Serialize, ToSchema)]
pub struct CorrectedBody {
    id: String,
    #[serde(flatten)]
    standing: StandingBody,
}

bodies! { RemarkBody of CorrectionItem: at, author, reason; }

/// How a stored item stands.
pub async fn standing(app: &App, id: Id) -> Answer<StandingBody> {
    let status = app.pipeline.queries.records.status(id).await?;
    let said = &status.corrections;
    let voided = said.iter().find(|row| row.item == id && row.replaced_by.is_none()).map(RemarkBody::from);
    let link = |row: &CorrectionItem, record: Id| RevisionBody { record: record.to_string(), remark: row.into() };
    let revised_by = said.iter().filter(|row| row.item == id).find_map(|row| Some(link(row, row.replaced_by?)));
    let revises = said.iter().find(|row| row.replaced_by == Some(id)).map(|row| link(row, row.item));
    let confirmed =
        status.confirmation.map(|row| RemarkBody { at: time::format(row.at), author: row.author, reason: row.reason });
    let state = match (&revised_by, &voided) {
        (Some(_), _) => "revised",
        (None, Some(_)) => "voided",
        (None, None) if status.set_aside => "set_aside",
        (None, None) => "valid",
    };
    Ok(StandingBody { state, voided, revised_by, revises, confirmed })
}

/// Who says so, and why.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct VoidOrder {
    #[schema(min_length = 1, max_length = 64)]
    author: String,
    #[schema(min_length = 1, max_length = 4096)]
    reason: String,
}

/// A record counts no more: it is kept, with who said so and why, and what depends on it is judged again.
#[utoipa::path(post, path = "/v1/records/{id}/void", tag = "records", request_body = VoidOrder,
    responses(
        (status = 200, description = "it counts no more; so too where the same was said before", body = CorrectedBody),
        (status = 409, description = "it was voided or revised before, by another author, for another reason or by other content")))]
pub async fn void_record(app: App, Path(id): Path<String>, body: Document) -> Answer<Json<CorrectedBody>> {
    void(&app, Corrected::Calibration { id: query::id(&id, Problem::no_such_record)?, kind: None }, &body).await
}

/// A campaign counts no more: it is kept, with who said so and why, and what depends on it is judged again.
#[utoipa::path(post, path = "/v1/campaigns/{id}/void", tag = "campaigns", request_body = VoidOrder,
    responses(
        (status = 200, description = "it counts no more; so too where the same was said before", body = CorrectedBody),
        (status = 409, description = "it was voided or revised before, by another author, for another reason or by other content")))]
pub async fn void_campaign(app: App, Path(id): Path<String>, body: Document) -> Answer<Json<CorrectedBody>> {
    void(&app, campaign(&id)?, &body).await
}

/// A bench result counts no more: it is kept, with who said so and why, and the methods are compared without it.
#[utoipa::path(post, path = "/v1/bench-results/{id}/void", tag = "bench results", request_body = VoidOrder,
    responses(
        (status = 200, description = "it counts no more; so too where the same was said before", body = CorrectedBody),
        (status = 409, description = "it was voided before, by another author or for another reason")))]
pub async fn void_bench_result(app: App, Path(id): Path<String>, body: Document) -> Answer<Json<CorrectedBody>> {
    void(&app, Corrected::Bench(query::id(&id, Problem::no_such_bench_result)?), &body).await
}

async fn void(app: &App, item: Corrected, body: &Document) -> Answer<Json<CorrectedBody>> {
    let (author, reason) = body.read(|bytes| {
        let VoidOrder { author, reason } = json::parse(bytes)?;
        let mut faults = Faults::default();
        let signed = text::signed("/author", author, reason, &mut faults);
        faults.or(signed)
    })?;
    submit(app, Correction { item, author, reason, replacement: None }).await?;
    let id = item.id();
    Ok(Json(CorrectedBody { id: id.to_string(), standing: standing(app, id).await? }))
}

/// What stands in the place of a record, who says so, and why.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct RecordRevision {
    #[schema(min_length = 1, max_length = 64)]
    author: String,
    #[schema(min_length = 1, max_length = 4096)]
    reason: String,
    /// Of the same IMU.
    #[schema(value_type = RecordBody)]
    record: Box<RawValue>,
}

/// Another record stands in the place of one, which counts no more. Both are kept; what depends on them is judged
/// again. What was voided can still be revised.
#[utoipa::path(post, path = "/v1/records/{id}/revise", tag = "records", request_body = RecordRevision,
    responses(
        (status = 201, description = "the new record is stored and judged", body = Standing<RecordAnswer>, headers(("Location" = String, description = "where it is"))),
        (status = 200, description = "the same was said before", body = Standing<RecordAnswer>),
        (status = 409, description = "it was revised before, or another stands at the new one's time")))]
pub async fn revise_record(app: App, Path(id): Path<String>, body: Document) -> Answer<Response> {
    let item = Corrected::Calibration { id: query::id(&id, Problem::no_such_record)?, kind: None };
    let problem = |faults| Document::problem(&body.0, faults);
    let RecordRevision { author, reason, record } = json::parse(&body.0).map_err(problem)?;
    let read = app.pipeline.reader.record(record.get().as_bytes());
    let correction = revision(item, (author, reason), "/record", read).map_err(problem)?;
    let (status, id) = submit(&app, correction).await?;
    let stored = app.pipeline.queries.records.record(id).await?.ok_or_else(|| Problem::no_such_record(id))?;
    let answer = Standing { answer: stored.answer, standing: Some(standing(&app, id).await?) };
    Ok((status, [(LOCATION, format!("/v1/records/{id}"))], Json(answer)).into_response())
}

/// What stands in the place of a campaign, who says so, and why.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct CampaignRevision {
    #[schema(min_length = 1, max_length = 64)]
    author: String,
    #[schema(min_length = 1, max_length = 4096)]
    reason: String,
    /// Of the same IMU.
    #[schema(value_type = CampaignBody)]
    campaign: Box<RawValue>,
}

/// Another campaign stands in the place of one, which counts no more. Both are kept; what depends on them is judged
/// again. What was voided can still be revised.
#[utoipa::path(post, path = "/v1/campaigns/{id}/revise", tag = "campaigns", request_body = CampaignRevision,
    responses(
        (status = 201, description = "the new campaign is stored and judged", body = Standing<CampaignAnswer>, headers(("Location" = String, description = "where it is"))),
        (status = 200, description = "the same was said before", body = Standing<CampaignAnswer>),
        (status = 409, description = "it was revised before, or another stands at the new one's time")))]
pub async fn revise_campaign(app: App, Path(id): Path<String>, body: Document) -> Answer<Response> {
    let item = campaign(&id)?;
    let problem = |faults| Document::problem(&body.0, faults);
    let CampaignRevision { author, reason, campaign } = json::parse(&body.0).map_err(problem)?;
    let pipeline = app.pipeline.clone();
    let read =
        words::spawn_blocking(move || pipeline.reader.campaign_document(campaign.get().as_bytes(), Form::Json)).await;
    let read = read.map_err(|_| Problem::new(500, "title_internal_error", message!("not_fitted")))?;
    let read = read.and_then(|read| match read.submission {
        Submission::Calibration(calibration) => Ok(*calibration),
        _ => {
            let message = message!("is_bench_test");
            Err(Fault { pointer: "/test".to_owned(), message }.into())
        }
    });
    let correction = revision(item, (author, reason), "/campaign", read).map_err(problem)?;
    let (status, id) = submit(&app, correction).await?;
    let stored = app.pipeline.queries.records.campaign(id).await?.ok_or_else(|| Problem::no_such_campaign(id))?;
    let answer = Standing { answer: stored.answer, standing: Some(standing(&app, id).await?) };
    Ok((status, [(LOCATION, format!("/v1/campaigns/{id}"))], Json(answer)).into_response())
}

/// Every fault of who, why and what, the latter's under `place`.
fn revision(
    item: Corrected,
    (author, reason): (String, String),
    place: &str,
    read: Result<Calibration, Faults>,
) -> Result<Correction, Faults> {
    let mut faults = Faults::default();
    let (author, reason) = text::signed("/author", author, reason, &mut faults);
    let Ok(new) = read.map_err(|of_new| faults.absorb(place, of_new)) else { return Err(faults) };
    faults.or(Correction { item, author, reason, replacement: Some(new) })
}

async fn submit(app: &App, correction: Correction) -> Answer<(StatusCode, Id)> {
    let place = correction.replacement.as_ref().map(|new| match new.kind {
        Kind::Record => "/record",
        Kind::Campaign => "/campaign",
    });
    let accepted = app.pipeline.ingest.submit(Submission::Correction(Box::new(correction))).await;
    accepted.map(|accepted| outcome(&accepted)).map_err(|refused| {
        // The places are those of what is to stand in the place of the old.
        let mut problem = Problem::from(refused);
        for error in &mut problem.places {
            error.pointer.insert_str(0, place.unwrap_or_default());
        }
        problem
    })
}

fn campaign(id: &str) -> Answer<Corrected> {
    Ok(Corrected::Calibration { id: query::id(id, Problem::no_such_campaign)?, kind: Some(Kind::Campaign) })
}
