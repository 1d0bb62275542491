//! The description of the service for programs (OpenAPI 3.1).

use utoipa::OpenApi as _;
use utoipa::openapi::security::{Http, HttpAuthScheme, SecurityScheme};
use utoipa::openapi::{OpenApi, Server};

use super::app::App;
use super::{constraints, examples, operation};
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
struct ApiInfo;

/// The whole document, of a service whose paths begin with `base_path`.
pub fn description(api: &Routes<App>, base_path: &str) -> OpenApi {
    let mut openapi = ApiInfo::openapi();
    openapi.merge(api.description().clone());
    operation::complete(&mut openapi, &Rules::of(api.rules()));
    constraints::describe(&mut openapi);
    examples::describe(&mut openapi);
    let token = SecurityScheme::Http(Http::new(HttpAuthScheme::Bearer));
    openapi.components.get_or_insert_default().add_security_scheme(operation::TOKEN, token);
    if !base_path.is_empty() {
        openapi.servers = Some(vec![Server::new(base_path)]);
    }
    openapi
}
