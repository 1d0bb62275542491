//! Is the process alive, and can it do its work?

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::App;
use crate::wire::problem::Problem;

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

/// Readiness: migrated, reading, and the writer at work.
#[utoipa::path(get, path = "/readyz", tag = "service", responses(
    (status = 200, description = "ready", body = Health),
    (status = 503, description = "not ready, and why", body = Problem, content_type = "application/problem+json")))]
pub async fn readyz(State(app): State<App>) -> Result<Json<Health>, Problem> {
    let not_ready = |why: String| Problem::new(503, "Not ready", why);
    if !app.pipeline.is_alive() {
        return Err(not_ready("the writer has stopped".into()));
    }
    app.pipeline.store().ping().await.map_err(|error| not_ready(format!("the database does not answer: {error}")))?;
    Ok(Json(Health { status: "ok", version: env!("CARGO_PKG_VERSION") }))
}
