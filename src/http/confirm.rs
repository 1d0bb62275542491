//! `/v1/records/{id}/confirm`: the time of a record that was set aside is right.

use super::corrections::{StandingBody, standing};
use super::signed::Signed;
use crate::http::prelude::*;
use crate::pipeline::{Accepted, Confirmation, Submission};

/// A record whose time was confirmed.
#[derive(Serialize, ToSchema)]
pub struct ConfirmedBody {
    id: String,
    #[serde(flatten)]
    standing: StandingBody,
}

/// The time of a record or campaign that was set aside is right: it counts from now on, and what depends on it is
/// judged again.
#[utoipa::path(post, path = "/v1/records/{id}/confirm", tag = "records", request_body = Signed,
    params(("id" = String, Path, description = "identifier of the record or campaign")),
    responses(
        (status = 200, description = "it counts; so too where it was confirmed before", body = ConfirmedBody),
        (status = 409, description = "it is not set aside, or another record stands at its time")))]
pub async fn confirm_record(app: App, Path(id): Path<String>, body: Document) -> Answer<Json<ConfirmedBody>> {
    let id = query::id(&id, Problem::no_such_record)?;
    let Signed { by: author, reason } = Signed::read(&body)?;
    let sent = Confirmation { id, of_window: false, author, reason, restated: None };
    let (Accepted::Stored { id, .. } | Accepted::There { id, .. }) =
        app.pipeline.ingest.submit(Submission::Confirmation(sent)).await?;
    Ok(Json(ConfirmedBody { id: id.to_string(), standing: standing(&app, id).await? }))
}
