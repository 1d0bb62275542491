//! The description of the service for programs (OpenAPI 3.1) and its reader.

use axum::http::HeaderValue;
use axum::http::header::CONTENT_SECURITY_POLICY;
use axum::response::Response;
use axum::{Router, middleware};
use utoipa::OpenApi as _;
use utoipa::openapi::security::{Http, HttpAuthScheme, SecurityScheme};
use utoipa::openapi::{OpenApi, Server};
use utoipa_swagger_ui::{Config, SwaggerUi};

use super::app::App;
use super::{examples, members, operation};
use crate::routes::{Routes, Rules};
use crate::wire::problem::ProblemBody;

#[derive(utoipa::OpenApi)]
#[openapi(
    info(
        title = "gyrowatch",
        description = "Separates, judges and diagnoses the acceleration-sensitive drift coefficients D_I and D_S of \
                   liquid-floated gyros from calibrations of their inertial measurement unit.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0")
    ),
    components(schemas(ProblemBody))
)]
struct Head;

/// Nothing is loaded from elsewhere. The reader puts style into its page, and has its pictures in its style sheet.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
                      connect-src 'self'; form-action 'none'; base-uri 'none'; frame-ancestors 'none'";

/// The whole document, of a service whose paths begin with `base_path`.
pub fn description(api: &Routes<App>, base_path: &str) -> OpenApi {
    let mut openapi = Head::openapi();
    openapi.merge(api.description().clone());
    operation::complete(&mut openapi, &Rules::of(api.rules()));
    members::describe(&mut openapi);
    examples::describe(&mut openapi);
    let token = SecurityScheme::Http(Http::new(HttpAuthScheme::Bearer));
    openapi.components.get_or_insert_default().add_security_scheme(operation::TOKEN, token);
    if !base_path.is_empty() {
        openapi.servers = Some(vec![Server::new(base_path)]);
    }
    openapi
}

/// What [`router`] serves.
pub const PATHS: [&str; 4] = ["/openapi.json", "/docs", "/docs/", "/docs/{*rest}"];

pub fn router(openapi: OpenApi, base_path: &str) -> Router<App> {
    // No other service is asked whether the description is right.
    let reader = Config::new([format!("{base_path}/openapi.json")]).validator_url("none");
    Router::from(SwaggerUi::new("/docs").url("/openapi.json", openapi).config(reader)).layer(middleware::map_response(
        async |mut response: Response| {
            response.headers_mut().insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY));
            response
        },
    ))
}
