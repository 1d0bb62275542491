//! Is the process alive, and can it do its work?

use std::time::Duration;

use crate::core::message::Message;
use crate::http::prelude::*;
use crate::pipeline::Refused;

/// How long the writer may take to answer: a group commit on a slow disk, and one before it.
const PATIENCE: Duration = Duration::from_secs(8);

#[derive(Debug, Serialize, ToSchema)]
pub struct Health {
    /// `ok`.
    pub status: &'static str,
    pub version: &'static str,
}

/// Liveness: answers as long as the process runs.
#[utoipa::path(get, path = "/healthz", tag = "service",
    responses((status = 200, description = "alive", body = Health)))]
pub async fn healthz() -> Json<Health> {
    Json(Health { status: "ok", version: env!("CARGO_PKG_VERSION") })
}

/// What the operator is told of a write that failed, in the store's own words.
fn unwritten(error: &Refused) -> Message {
    match error {
        Refused::Storage(error) => error.message(),
        other => other.message(),
    }
}

/// Readiness: the database can be read and written, and the writer and the delivery worker are at work.
#[utoipa::path(get, path = "/readyz", tag = "service",
    responses(
        (status = 200, description = "ready", body = Health),
        (status = 503, description = "not ready, and why")))]
pub async fn readyz(app: App) -> Answer<Json<Health>> {
    let not_ready = |why: Message| Problem::new(503, "title_not_ready", why);
    app.pipeline.ping().await.map_err(|error| not_ready(message!("not_reading", why = error.message())))?;
    match tokio::time::timeout(PATIENCE, app.pipeline.probe()).await {
        Ok(probed) => probed.map_err(|error| not_ready(message!("not_writing", why = unwritten(&error))))?,
        Err(_) => {
            return Err(not_ready(message!(
                "not_writing",
                why = message!("writer_silent", seconds = PATIENCE.as_secs())
            )));
        }
    }
    if !app.pipeline.hooks.delivers() {
        return Err(not_ready(message!("no_delivery_worker")));
    }
    Ok(Json(Health { status: "ok", version: env!("CARGO_PKG_VERSION") }))
}
