//! `/v1/records`: calibration records in, and as they are stored.

use axum::response::Redirect;
use serde_json::value::RawValue;

use super::corrections::{StandingBody, standing};
use super::document_post::{DocumentPost, IdempotencyKey, PostOutcome};
use super::notify_query::NotifyQuery;
use super::prefer_header::{MinimalAnswer, Prefer};
use crate::core::kind::Kind;
use crate::http::prelude::*;
use crate::pipeline::{StoredRecord, Submission};
use crate::wire::answer::RecordAnswer;
use crate::wire::closure::ClosureBody;
use crate::wire::document::DocumentKind;
use crate::wire::note;
use crate::wire::note::NoteBody;
use crate::wire::record::RecordBody;
use crate::wire::sender::SenderBody;

/// As much of the answer as was wanted.
#[derive(ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "describes the two forms of the answer in the OpenAPI document")]
enum RecordAsWanted {
    Whole(RecordAnswer),
    Minimal(MinimalAnswer),
}

/// Separates, stores and judges a calibration record.
///
/// The record is on disk before the answer. The same content again answers 200 with the same id; the same IMU and
/// time with other content 409.
#[utoipa::path(post, path = "/v1/records", tag = "records", request_body = RecordBody,
    params(IdempotencyKey, NotifyQuery, Prefer),
    responses(
        (status = 201, description = "stored and judged", body = RecordAsWanted,
            headers(("Location" = String, description = "where it is"), ("Preference-Applied" = Option<String>, description = "`return=minimal` where it was preferred"))),
        (status = 200, description = "was stored before with the same content", body = RecordAsWanted),
        (status = 409, description = "the same IMU and time with other content")))]
pub async fn post_record(app: App, post: DocumentPost, Document(bytes): Document) -> Answer<Response> {
    let read = app.pipeline.reader.record(&bytes);
    let mut calibration = read.map_err(|faults| Document::refused_as(DocumentKind::Record, &bytes, faults))?;
    calibration.idempotency_key = post.key()?;
    let separations = (post.wanted == Prefer::Whole).then(|| app.pipeline.reader.separations(&calibration.gyros));
    let of_model = app.pipeline.reader.notes_of_model(&calibration);
    let whole = |id: Id, notes: Vec<NoteBody>, verdicts| {
        let separations = separations.clone().unwrap_or_default();
        let notes = of_model.iter().cloned().chain(notes).collect();
        RecordAnswer { id: Some(id.to_string()), separations, notes, verdicts }
    };
    let item = Submission::Calibration(Box::new(calibration));
    match post.store(&app, item, COLLECTION, whole).await? {
        PostOutcome::New(answer) => Ok(answer),
        PostOutcome::There(id) => {
            let StoredRecord { item, answer, .. } = stored(&app, id).await?;
            let whole = (answer, item.verdicts.states(), note::read(item.notes.as_deref()));
            Ok(post.again((COLLECTION, id), whole, standing(&app, id).await?.unless_valid()))
        }
    }
}

const COLLECTION: &str = "records";

/// A stored record.
#[derive(Serialize, ToSchema)]
struct StoredRecordBody {
    #[serde(flatten)]
    answer: RecordAnswer,
    #[serde(flatten)]
    standing: StandingBody,
    received_at: String,
    /// Who sent it; null of what a version without that knowledge stored.
    #[schema(required)]
    sent_by: Option<SenderBody>,
    /// The record word for word as it was sent.
    #[schema(value_type = RecordBody)]
    record: Box<RawValue>,
}

/// A stored record: what was sent, what was separated from it, and how it is judged.
///
/// Points of a trend name a record or a campaign; a campaign's identifier is sent on to where campaigns are.
#[utoipa::path(get, path = "/v1/records/{id}", tag = "records",
    responses(
        (status = 200, description = "the record", body = StoredRecordBody),
        (status = 308, description = "it is a campaign", headers(("Location" = String, description = "where it is")))))]
pub async fn get_record(app: App, Path(id): Path<String>) -> Answer<Response> {
    let id = query::id(&id, Problem::no_such_record)?;
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
    responses((status = 200, description = "the diagnosis of the closure", body = ClosureBody)))]
pub async fn get_record_diagnosis(app: App, Path(id): Path<String>) -> Answer<Json<ClosureBody>> {
    let number = query::id(&id, Problem::no_such_record)?;
    let closures = app.pipeline.queries.records.closures(number).await?;
    let closures = closures.ok_or_else(|| Problem::no_such_record(&id))?;
    Ok(Json(ClosureBody::from(&closures)))
}

async fn stored(app: &App, id: Id) -> Answer<StoredRecord> {
    let stored = app.pipeline.queries.records.record(id).await?;
    stored.ok_or_else(|| Problem::no_such_record(id))
}
