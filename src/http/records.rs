//! `/v1/records`: calibration records in, and as they are stored.

use axum::extract::{Path, State};
use axum::http::header::LOCATION;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Redirect, Response};
use axum::{Extension, Json};
use serde::Serialize;
use serde_json::value::RawValue;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::App;
use super::answer::{Answer, JustJudged};
use super::corrections::{Standing, StandingBody, standing};
use super::document::{Document, idempotency_key};
use super::telling::Telling;
use crate::core::alert_decision::Late;
use crate::core::id::Id;
use crate::core::kind::Kind;
use crate::http::prefer_header::{AsWanted, MinimalAnswer, Wanted};
use crate::message;
use crate::pipeline::{Accepted, Caller, Sent, StoredRecord, Submission};
use crate::wire::answer::RecordAnswer;
use crate::wire::closure::ClosureBody;
use crate::wire::document::DocumentKind;
use crate::wire::history_note;
use crate::wire::note::NoteBody;
use crate::wire::problem::Problem;
use crate::wire::record::RecordBody;
use crate::wire::sender::SenderBody;
use crate::wire::time;

pub fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(post_record)).routes(routes!(get_record)).routes(routes!(get_record_diagnosis))
}

/// Separates, stores and judges a calibration record.
///
/// The record is on disk before the answer. The same content again answers 200 with the same id; the same IMU and time with
/// other content 409.
#[utoipa::path(post, path = "/v1/records", tag = "records", request_body = RecordBody,
    params(
        ("Idempotency-Key" = Option<String>, Header, description = "one key a request, repeated when it is sent again"),
        ("notify" = Option<String>, Query, description = "who is told of what is found later than `alerts.backfill_days`: `all`, `digest` or `none`; as of an import"),
        ("more" = Option<bool>, Query, description = "with `notify=digest`: more of the same import follows"),
        ("Prefer" = Option<String>, Header, description = "`return=minimal`: the answer is the identifier and how many verdicts there are of each state")),
    responses(
        (status = 201, description = "stored and judged", body = AsWanted<RecordAnswer>,
            headers(("Location" = String, description = "where it is"), ("Preference-Applied" = Option<String>, description = "`return=minimal` where it was preferred"))),
        (status = 200, description = "was stored before with the same content", body = AsWanted<RecordAnswer>),
        (status = 400, description = "not JSON", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "the same IMU and time with other content", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "too large", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "not application/json", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "JSON that cannot be stored; the places are named", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "too busy or not writable; try again", body = Problem, content_type = "application/problem+json"),
        (status = 507, description = "no room left", body = Problem, content_type = "application/problem+json")))]
async fn post_record(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    headers: HeaderMap,
    wanted: Wanted,
    telling: Telling,
    body: Document,
) -> Result<Response, Problem> {
    let bytes = body.0;
    let read = app.pipeline.reader.record(&bytes);
    let mut calibration = read.map_err(|faults| Document::refused_as(DocumentKind::Record, &bytes, faults))?;
    calibration.idempotency_key = idempotency_key(&headers)?;
    let body = calibration.body.clone();
    let mut whole = (wanted == Wanted::Whole).then(|| {
        let separations = app.pipeline.reader.separations(&calibration.gyros);
        RecordAnswer { id: None, separations, notes: Vec::new(), verdicts: Vec::new() }
    });
    let submission = Submission::Calibration(Box::new(calibration));
    submission.may_be_sent_by(&caller)?;
    let late = telling.late_or(Late::Quiet);
    let worded = app.pipeline.ingest.submit_late(submission, late, |accepted| {
        let Accepted::Stored { id, judged, notes } = accepted else { return None };
        let notes: Vec<NoteBody> = notes.iter().map(NoteBody::of).collect();
        let answer = match &mut whole {
            Some(answer) => {
                answer.id = Some(id.to_string());
                answer.notes = notes;
                JustJudged { answer, judged }.into_response()
            }
            None => Json(MinimalAnswer::just_judged(*id, judged, notes)).into_response(),
        };
        let location = [(LOCATION, format!("/v1/records/{id}"))];
        Some((StatusCode::CREATED, location, wanted.applied(), answer).into_response())
    });
    let (accepted, created) = worded.await?;
    telling.end(&app, late).await;
    if let Some(created) = created {
        return Ok(created);
    }
    let id = app.pipeline.ingest.settle(&accepted, Sent::Calibration(Kind::Record, &body)).await?;
    let stored = stored(&app, id).await?;
    let standing = standing(&app, id).await?.unless_valid();
    let notes = history_note::read(stored.item.notes.as_deref());
    let answer = AsWanted::of(wanted, stored.answer, id, stored.item.states.into_iter(), notes);
    let location = [(LOCATION, format!("/v1/records/{id}"))];
    Ok((location, wanted.applied(), Answer(Standing { answer, standing })).into_response())
}

/// A stored record.
#[derive(Serialize, ToSchema)]
struct StoredRecordBody {
    #[serde(flatten)]
    answer: RecordAnswer,
    #[serde(flatten)]
    standing: StandingBody,
    received_at: String,
    /// Who sent it; null of what a version without that knowledge stored.
    sent_by: Option<SenderBody>,
    /// The record word for word as it was sent.
    #[schema(value_type = RecordBody)]
    record: Box<RawValue>,
}

/// A stored record: what was sent, what was separated from it, and how it is judged.
///
/// Points of a trend name a record or a campaign; a campaign's identifier is sent on to where campaigns are.
#[utoipa::path(get, path = "/v1/records/{id}", tag = "records", params(("id" = String, Path, description = "identifier of the record")),
    responses(
        (status = 200, description = "the record", body = StoredRecordBody),
        (status = 308, description = "it is a campaign", headers(("Location" = String, description = "where it is"))),
        (status = 404, description = "no such record", body = Problem, content_type = "application/problem+json")))]
async fn get_record(State(app): State<App>, Path(id): Path<String>) -> Result<Response, Problem> {
    let no_such = || Problem::no_such_record(&id);
    let id: Id = id.parse().map_err(|_| no_such())?;
    let StoredRecord { item, answer, .. } = stored(&app, id).await?;
    if item.kind == Kind::Campaign {
        return Ok(Redirect::permanent(&format!("/v1/campaigns/{id}")).into_response());
    }
    let record = RawValue::from_string(item.body.to_string())
        .map_err(|_| Problem::new(500, "title_damaged_database", message!("body_not_json", id = id.to_string())))?;
    let (standing, sent_by) = (standing(&app, id).await?, app.pipeline.queries.records.sender(item.sent_by).await?);
    let received_at = time::format(item.received_at);
    Ok(Json(StoredRecordBody { answer, standing, received_at, sent_by, record }).into_response())
}

/// What the closure of the record says: D_O, which D_I and D_S cannot explain, and what would tell its causes apart.
#[utoipa::path(get, path = "/v1/records/{id}/diagnosis", tag = "records",
    params(("id" = String, Path, description = "identifier of the record, or of a campaign")),
    responses(
        (status = 200, description = "the diagnosis of the closure", body = ClosureBody),
        (status = 404, description = "no such record", body = Problem, content_type = "application/problem+json")))]
async fn get_record_diagnosis(State(app): State<App>, Path(id): Path<String>) -> Result<Json<ClosureBody>, Problem> {
    let no_such = || Problem::no_such_record(&id);
    let number: Id = id.parse().map_err(|_| no_such())?;
    let closures = app.pipeline.queries.records.closures(number).await?.ok_or_else(no_such)?;
    Ok(Json(ClosureBody::from(&closures)))
}

async fn stored(app: &App, id: Id) -> Result<StoredRecord, Problem> {
    let stored = app.pipeline.queries.records.record(id).await?;
    stored.ok_or_else(|| Problem::no_such_record(id))
}
