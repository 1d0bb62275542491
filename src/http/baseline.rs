//! `/v1/gyros/{serial}/baseline`: from here on a gyro is compared with itself anew.

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::App;
use super::document::Document;
use crate::core::fault::Faults;
use crate::core::judge::Event;
use crate::core::record::Name;
use crate::pipeline::{Accepted, Actor, GyroEvent, Submission};
use crate::wire::problem::Problem;
use crate::wire::{json, text, time};

pub fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(post_baseline))
}

/// Why and from when on a new baseline counts.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct BaselineBody {
    /// What was done to the gyro, in words.
    #[schema(min_length = 1, max_length = 4096)]
    reason: String,
    /// From when on, RFC 3339; now, where it is left out.
    #[serde(default)]
    at: Option<String>,
    #[serde(default)]
    author: Option<String>,
}

/// A baseline mark as it is stored.
#[derive(Serialize, ToSchema)]
struct BaselineAnswer {
    id: String,
    serial: String,
    at: String,
    reason: String,
    author: Option<String>,
}

/// Starts a new baseline (after a repair or re-installation). What it changes is judged again.
#[utoipa::path(post, path = "/v1/gyros/{serial}/baseline", tag = "gyros", request_body = BaselineBody,
    params(("serial" = String, Path, description = "serial number of the gyro")),
    responses(
        (status = 201, description = "the baseline is set", body = BaselineAnswer),
        (status = 200, description = "was set before, for the same reason", body = BaselineAnswer),
        (status = 400, description = "not JSON", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "no such gyro", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "another baseline begins at that very time", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "not application/json", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "JSON that cannot be stored; the places are named", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "too busy or not writable; try again", body = Problem, content_type = "application/problem+json")))]
async fn post_baseline(
    State(app): State<App>,
    Path(serial): Path<String>,
    body: Document,
) -> Result<(StatusCode, Json<BaselineAnswer>), Problem> {
    let name = Name::parse(&serial)
        .map_err(|_| Problem::new(404, "Unknown gyro", format!("no gyro with the serial {serial} is known")))?;
    let event = read(&app, name, &body.0).map_err(|faults| Document::problem(&body.0, faults))?;
    let (at, reason, author) = (time::format(event.at), event.reason.clone(), event.author.clone());
    match app.pipeline.submit(Submission::Event(event)).await? {
        Accepted::Stored { id, .. } => {
            let answer = BaselineAnswer { id: id.to_string(), serial, at, reason, author };
            Ok((StatusCode::CREATED, Json(answer)))
        }
        Accepted::There { id, same_bytes: true } => {
            let answer = BaselineAnswer { id: id.to_string(), serial, at, reason, author };
            Ok((StatusCode::OK, Json(answer)))
        }
        Accepted::There { id, .. } => {
            let detail = "a baseline begins at that very time for another reason";
            Err(Problem::new(409, "Already stored with other content", detail).with_existing(id))
        }
    }
}

fn read(app: &App, serial: Name, bytes: &[u8]) -> Result<GyroEvent, Faults> {
    let body: BaselineBody = json::parse(bytes)?;
    let mut faults = Faults::default();
    if body.reason.trim().is_empty() {
        faults.push("/reason", "must say what was done to the gyro");
    }
    let reason = text::note("/reason", &Some(body.reason), &mut faults).unwrap_or_default();
    let at = match &body.at {
        Some(at) => text::instant("/at", at, &mut faults),
        None => app.clock.now(),
    };
    let author = text::short("/author", &body.author, &mut faults);
    if faults.is_empty()
        && let Err(future) = app.pipeline.check_time("/at", at)
    {
        faults.absorb("", future);
    }
    faults.or(GyroEvent { serial, at, event: Event::Baseline, reason, author, by: Actor::by_caller() })
}
