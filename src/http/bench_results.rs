//! `/v1/bench-results`: what single-gyro benches measured.

use serde_json::value::{RawValue, to_raw_value};

use super::corrections::{StandingBody, standing};
use super::document::outcome;
use super::document_post::{DocumentPost, IdempotencyKey};
use super::notify_query::NotifyQuery;
use crate::http::prelude::*;
use crate::pipeline::{Origin, Submission};
use crate::wire::bench::BenchBody;
use crate::wire::campaign::CampaignBody;
use crate::wire::document::DocumentKind;
use crate::wire::note::NoteBody;
use crate::wire::sender::SenderBody;

/// The answer to a bench result.
#[derive(Serialize, ToSchema)]
struct BenchAnswer {
    id: String,
    serial: String,
    /// New names that look like known ones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<NoteBody>,
}

/// Stores a bench result; the same rules as for records.
#[utoipa::path(post, path = "/v1/bench-results", tag = "bench results", request_body = BenchBody,
    params(IdempotencyKey, NotifyQuery),
    responses(
        (status = 201, description = "stored", body = BenchAnswer, headers(("Location" = String, description = "where it is"))),
        (status = 200, description = "was stored before with the same content", body = BenchAnswer),
        (status = 409, description = "the same gyro, time and method with other content")))]
pub async fn post_bench_result(app: App, post: DocumentPost, Document(bytes): Document) -> Answer<Response> {
    let read = app.pipeline.reader.bench_result(&bytes);
    let mut bench = read.map_err(|faults| Document::refused_as(DocumentKind::Bench, &bytes, faults))?;
    bench.idempotency_key = post.key()?;
    let serial = bench.result.serial.to_string();
    let item = Submission::Bench(Box::new(bench));
    let origin = Origin::of(&item);
    let accepted = post.submit(&app, item).await?;
    let (status, _) = outcome(&accepted);
    let notes = accepted.notes().iter().map(NoteBody::of).collect();
    let id = app.pipeline.ingest.settle(&accepted, origin.as_ref()).await?;
    let location = [(LOCATION, format!("/v1/bench-results/{id}"))];
    Ok((status, location, Json(BenchAnswer { id: id.to_string(), serial, notes })).into_response())
}

/// A stored bench result.
#[derive(Serialize, ToSchema)]
pub struct StoredBench {
    id: String,
    #[serde(flatten)]
    standing: StandingBody,
    received_at: String,
    /// Who sent it; null of what a version without that knowledge stored.
    #[schema(required)]
    sent_by: Option<SenderBody>,
    /// The result word for word as it was sent; of raw dwells, what was fitted to them.
    #[schema(value_type = BenchBody)]
    bench_result: Box<RawValue>,
    /// The raw dwells, where the result was fitted here.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<CampaignBody>)]
    campaign: Option<Box<RawValue>>,
}

/// A stored bench result, as it was sent or as it was fitted.
#[utoipa::path(get, path = "/v1/bench-results/{id}", tag = "bench results",
    responses((status = 200, description = "the bench result", body = StoredBench)))]
pub async fn get_bench_result(app: App, Path(id): Path<String>) -> Answer<Json<StoredBench>> {
    let number = query::id(&id, Problem::no_such_bench_result)?;
    let row = app.pipeline.queries.records.bench(number).await?;
    let row = row.ok_or_else(|| Problem::no_such_bench_result(&id))?;
    let damaged = || Problem::new(500, "title_damaged_database", message!("body_unreadable", id = id.to_string()));
    let body = RawValue::from_string(row.body.to_string()).map_err(|_| damaged())?;
    let (bench_result, campaign) = match DocumentKind::of(row.body.as_bytes()) {
        DocumentKind::Campaign => {
            let fitted = app.pipeline.reader.fitted_bench(&row.body).map_err(|_| damaged())?;
            (to_raw_value(&fitted).map_err(|_| damaged())?, Some(body))
        }
        DocumentKind::Record | DocumentKind::Bench => (body, None),
    };
    let (standing, received_at) = (standing(&app, number).await?, time::format(row.received_at));
    let sent_by = app.pipeline.queries.records.sender(row.sent_by).await?;
    Ok(Json(StoredBench { id: number.to_string(), standing, received_at, sent_by, bench_result, campaign }))
}
