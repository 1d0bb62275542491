//! `/v1/campaigns`: raw dwells in, fitted here; as they are stored; and the diagnosis of their gap.

use std::time::Duration;

use axum::extract::{FromRequest, Request};
use axum::http::header::RETRY_AFTER;
use bytes::Bytes;
use serde_json::value::RawValue;

use super::corrections::{StandingBody, standing};
use super::document::check_media_type;
use super::document_post::{DocumentPost, IdempotencyKey, PostOutcome};
use super::notify_query::NotifyQuery;
use super::prefer_header::{MinimalAnswer, Prefer};
use crate::http::prelude::*;
use crate::pipeline::{DiagnosisAnswer, ReadCampaign, StoredCampaign, Submission};
use crate::wire::calibration::CampaignAnswer;
use crate::wire::campaign::{CampaignBody, Form};
use crate::wire::diagnosis::DiagnosisBody;
use crate::wire::document::DocumentKind;
use crate::wire::note::{self, NoteBody};
use crate::wire::sender::SenderBody;
use crate::wire::split::SplitBody;
use crate::wire::table::open_end;
use crate::words::{self, asked};

/// A campaign as JSON or CSV.
pub struct Dwells(Bytes, Form);

impl<S: Send + Sync> FromRequest<S> for Dwells {
    type Rejection = Response;

    async fn from_request(request: Request, state: &S) -> Result<Self, Response> {
        let types = ["application/json", "text/csv"];
        let sent = check_media_type(request.headers(), &types).map_err(IntoResponse::into_response)?;
        let form = if sent == "text/csv" { Form::Csv } else { Form::Json };
        let bytes = Bytes::from_request(request, state).await.map_err(IntoResponse::into_response)?;
        Ok(Self(bytes, form))
    }
}

/// As much of the answer as was wanted.
#[derive(ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "describes the two forms of the answer in the OpenAPI document")]
enum CampaignAsWanted {
    Whole(Box<CampaignAnswer>),
    Minimal(MinimalAnswer),
}

/// Fits model (6) to the dwells, separates, stores and judges; the same rules as for records.
///
/// A raw single-gyro bench test (`"test": "torque_feedback"` or `"turntable_servo"`) becomes a bench result.
#[utoipa::path(post, path = "/v1/campaigns", tag = "campaigns", request_body(content((CampaignBody = "application/json"), (String = "text/csv"))),
    params(IdempotencyKey, NotifyQuery, Prefer),
    responses(
        (status = 201, description = "stored and judged", body = CampaignAsWanted,
            headers(("Location" = String, description = "where it is"), ("Preference-Applied" = Option<String>, description = "`return=minimal` where it was preferred"))),
        (status = 200, description = "was stored before with the same content", body = CampaignAsWanted),
        (status = 409, description = "the same IMU and time with other content"),
        (status = 422, description = "what cannot be stored; the places are named")))]
pub async fn post_campaign(app: App, mut post: DocumentPost, body: Dwells) -> Answer<Response> {
    let Dwells(bytes, form) = body;
    let key = post.key()?;
    let (pipeline, text) = (app.pipeline.clone(), bytes.clone());
    let read = words::spawn_blocking(move || pipeline.reader.campaign_document(&text, form)).await;
    let read = read.map_err(|_| Problem::new(500, "title_internal_error", message!("not_fitted")))?;
    let ReadCampaign { submission, fit, body } = read.map_err(|faults| match form {
        Form::Csv => Problem::of_faults(422, "title_cannot_be_stored", faults),
        Form::Json => Document::refused_as(DocumentKind::Campaign, &bytes, faults),
    })?;
    post.noted = if form == Form::Csv { open_end(&bytes) } else { None };
    let is_bench = matches!(submission, Submission::Bench(_));
    let collection = if is_bench { "bench-results" } else { "campaigns" };
    let whole = |id: Id, notes: Vec<NoteBody>, verdicts| {
        let stored = app.pipeline.reader.answer_as_stored(&fit, &body);
        let mut answer = CampaignAnswer { id: Some(id.to_string()), verdicts, ..stored };
        answer.notes.extend(notes);
        answer
    };
    match post.store(&app, submission.with_key(key), collection, &whole).await? {
        PostOutcome::New(answer) => Ok(answer),
        // Of a bench test nothing is judged: the answer is the fit, now as then.
        PostOutcome::There(id) if is_bench => {
            Ok(post.again((collection, id), (whole(id, Vec::new(), Vec::new()), std::iter::empty(), Vec::new()), None))
        }
        PostOutcome::There(id) => {
            let StoredCampaign { item, answer, .. } = stored(&app, id).await?;
            let whole = (answer, item.verdicts.states(), note::read(item.notes.as_deref()));
            Ok(post.again((collection, id), whole, standing(&app, id).await?.unless_valid()))
        }
    }
}

/// A stored campaign.
#[derive(Serialize, ToSchema)]
pub struct StoredCampaignBody {
    #[serde(flatten)]
    answer: CampaignAnswer,
    #[serde(flatten)]
    standing: StandingBody,
    received_at: String,
    /// Who sent it; null of what a version without that knowledge stored.
    #[schema(required)]
    sent_by: Option<SenderBody>,
    /// The campaign word for word as it was sent; one sent as CSV, as the JSON that says the same.
    #[schema(value_type = CampaignBody)]
    campaign: Box<RawValue>,
}

/// A stored campaign: what was sent, the fit with its evidence, what was separated, and how it is judged.
#[utoipa::path(get, path = "/v1/campaigns/{id}", tag = "campaigns",
    responses((status = 200, description = "the campaign", body = StoredCampaignBody)))]
pub async fn get_campaign(app: App, Path(id): Path<String>) -> Answer<Json<StoredCampaignBody>> {
    let id = query::id(&id, Problem::no_such_campaign)?;
    let StoredCampaign { item, answer, .. } = stored(&app, id).await?;
    let campaign = RawValue::from_string(item.body.to_string())
        .map_err(|_| Problem::new(500, "title_damaged_database", message!("body_not_json", id = id.to_string())))?;
    let (standing, sent_by) = (standing(&app, id).await?, app.pipeline.queries.records.sender(item.sent_by).await?);
    let received_at = time::format(item.received_at);
    Ok(Json(StoredCampaignBody { answer, standing, received_at, sent_by, campaign }))
}

/// The gap between the campaign and its error model: where, which unmodelled effect, how far it shrinks, what cannot
/// be told.
#[utoipa::path(get, operation_id = "get_campaign_diagnosis", path = "/v1/campaigns/{id}/diagnosis", tag = "campaigns",
    params(DiagnosisQuery),
    responses(
        (status = 200, description = "the diagnosis", body = DiagnosisBody),
        (status = 202, description = "it is being made; ask again", headers(("Retry-After" = u32, description = "seconds"))),
        (status = 400, description = "a bad query"),
        (status = 404, description = "no such campaign, or no such reference"),
        (status = 422, description = "the campaign leaves nothing to hold against the model, or the reference is none for it")))]
pub async fn get_diagnosis(
    app: App,
    Path(id): Path<String>,
    Parameters(DiagnosisQuery { reference, wait }): Parameters<DiagnosisQuery>,
) -> Answer<Response> {
    let number = query::id(&id, Problem::no_such_campaign)?;
    let patience = query::between("wait", wait.unwrap_or(PATIENCE_S), (0, PATIENCE_S))?;
    match app.pipeline.diagnoses.of_campaign(number, Duration::from_secs(patience)).await? {
        DiagnosisAnswer::NoSuchCampaign => Err(Problem::no_such_campaign(&id)),
        DiagnosisAnswer::Waiting => Ok((StatusCode::ACCEPTED, [(RETRY_AFTER, "5")]).into_response()),
        DiagnosisAnswer::Answered(diagnosed) => {
            let mut diagnosis = match &*diagnosed {
                Ok(diagnosis) => diagnosis.clone().said_in(asked()),
                Err(why) => return Err(Problem::new(422, "title_nothing_to_diagnose", why.clone())),
            };
            if let Some(reference) = reference {
                diagnosis.reference = Some(against(&app, number, &diagnosis, &reference).await?);
            }
            Ok(Json(diagnosis).into_response())
        }
    }
}

/// How long a caller waits for a diagnosis that is being made, s.
const PATIENCE_S: u64 = 10;

/// What a diagnosis is asked for with.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct DiagnosisQuery {
    /// Identifier of an earlier campaign or record of the IMU: the gap is then also split into parameters, structure
    /// and noise.
    reference: Option<String>,
    /// Seconds to wait for one that is being made, 0 to 10; 10 where left out.
    wait: Option<u64>,
}

async fn against(app: &App, id: Id, diagnosis: &DiagnosisBody, reference: &str) -> Answer<SplitBody> {
    let number = query::id(reference, Problem::no_such_reference)?;
    let split = app.pipeline.diagnoses.split(id, diagnosis, number).await?;
    let split = split.ok_or_else(|| Problem::no_such_reference(reference))?;
    split.map_err(|why| Problem::new(422, "title_no_reference", why.message()))
}

async fn stored(app: &App, id: Id) -> Answer<StoredCampaign> {
    app.pipeline.queries.records.campaign(id).await?.ok_or_else(|| Problem::no_such_campaign(id))
}
