//! Is the process alive, and can it do its work?

use std::time::Duration;

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::App;
use crate::wire::problem::Problem;

/// How long the writer may take to answer: a group commit on a slow disk, and one before it.
const PATIENCE: Duration = Duration::from_secs(8);

#[derive(Debug, Serialize, ToSchema)]
pub struct Health {
    /// `ok`.
    pub status: &'static str,
    pub version: &'static str,
}

/// Liveness: answers as long as the process runs.
#[utoipa::path(get, path = "/healthz", tag = "service", responses((status = 200, description = "alive", body = Health)))]
pub async fn healthz() -> Json<Health> {
    Json(Health { status: "ok", version: env!("CARGO_PKG_VERSION") })
}

/// Readiness: the database can be read and written, and the writer and the delivery worker are at work.
#[utoipa::path(get, path = "/readyz", tag = "service", responses(
    (status = 200, description = "ready", body = Health),
    (status = 503, description = "not ready, and why", body = Problem, content_type = "application/problem+json")))]
pub async fn readyz(State(app): State<App>) -> Result<Json<Health>, Problem> {
    let not_ready = |why: String| Problem::new(503, "Not ready", why);
    app.pipeline.store().ping().await.map_err(|error| not_ready(format!("reading: {error}")))?;
    match tokio::time::timeout(PATIENCE, app.pipeline.probe()).await {
        Ok(probed) => probed.map_err(|refused| not_ready(format!("writing: {refused}")))?,
        Err(_) => return Err(not_ready(format!("writing: the writer has not answered for {} s", PATIENCE.as_secs()))),
    }
    if !app.pipeline.delivers() {
        return Err(not_ready("the delivery worker is not at work".to_owned()));
    }
    Ok(Json(Health { status: "ok", version: env!("CARGO_PKG_VERSION") }))
}
