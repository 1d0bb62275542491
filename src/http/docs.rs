//! The description of the service for programs (OpenAPI 3.1) and its reader.

use axum::Router;
use utoipa::OpenApi as _;
use utoipa::openapi::OpenApi;
use utoipa_swagger_ui::SwaggerUi;

use super::App;

#[derive(utoipa::OpenApi)]
#[openapi(info(
    title = "gyrowatch",
    description = "Separates, judges and diagnoses the acceleration-sensitive drift coefficients D_I and D_S of \
                   liquid-floated gyros from calibrations of their inertial measurement unit.",
    license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0")
))]
struct Head;

/// The document without its paths.
pub fn head() -> OpenApi {
    Head::openapi()
}

/// `/openapi.json` and `/docs`.
pub fn router(openapi: OpenApi) -> Router<App> {
    SwaggerUi::new("/docs").url("/openapi.json", openapi).into()
}
