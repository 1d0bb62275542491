//! The description of the service for programs (OpenAPI 3.1) and its reader.

use axum::http::HeaderValue;
use axum::http::header::CONTENT_SECURITY_POLICY;
use axum::response::Response;
use axum::{Router, middleware};
use utoipa::OpenApi as _;
use utoipa::openapi::link::Link;
use utoipa::openapi::{OpenApi, RefOr, Server};
use utoipa_swagger_ui::{Config, SwaggerUi};

use super::App;
use crate::routes::{Routes, operations};

#[derive(utoipa::OpenApi)]
#[openapi(info(
    title = "gyrowatch",
    description = "Separates, judges and diagnoses the acceleration-sensitive drift coefficients D_I and D_S of \
                   liquid-floated gyros from calibrations of their inertial measurement unit.",
    license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0")
))]
struct Head;

/// Answers that name what other operations are about.
const NAMED: [Named; 10] = [
    Named { by: "/v1/records", status: "201", at: "/id", parameter: "id", of: "/v1/records/{id}" },
    Named { by: "/v1/campaigns", status: "201", at: "/id", parameter: "id", of: "/v1/campaigns/{id}" },
    Named { by: "/v1/bench-results", status: "201", at: "/id", parameter: "id", of: "/v1/bench-results/{id}" },
    Named { by: "/v1/hooks", status: "201", at: "/id", parameter: "id", of: "/v1/hooks/{id}" },
    Named { by: "/v1/silences", status: "201", at: "/id", parameter: "id", of: "/v1/silences/{id}" },
    Named { by: "/v1/tokens", status: "201", at: "/id", parameter: "id", of: "/v1/tokens/{id}" },
    Named { by: "/v1/hooks/{id}/test", status: "202", at: "/id", parameter: "id", of: "/v1/deliveries/{id}" },
    Named { by: "/v1/diagnoses", status: "202", at: "/id", parameter: "id", of: "/v1/diagnoses/{id}" },
    Named { by: "/v1/gyros", status: "200", at: "/gyros/0/serial", parameter: "serial", of: "/v1/gyros/{serial}" },
    Named { by: "/v1/alerts", status: "200", at: "/alerts/0/id", parameter: "id", of: "/v1/alerts/{id}" },
];

/// The answer with `status` of what makes things at the path `by` (or lists them) holds, `at` a JSON pointer, the `parameter` of
/// the path `of` and of all below it.
struct Named {
    by: &'static str,
    status: &'static str,
    at: &'static str,
    parameter: &'static str,
    of: &'static str,
}

/// Adds to answers the links to operations on what they name.
fn link(openapi: &mut OpenApi) {
    for named in NAMED {
        let below = openapi.paths.paths.iter().filter(|(path, _)| {
            path.strip_prefix(named.of).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        });
        let about: Vec<String> =
            below.flat_map(|(_, item)| operations(item)).filter_map(|(_, of)| of.operation_id.clone()).collect();
        let by = openapi.paths.paths.get_mut(named.by);
        let answer = by
            .and_then(|item| item.post.as_mut().or(item.get.as_mut()))
            .and_then(|operation| operation.responses.responses.get_mut(named.status));
        let Some(RefOr::T(answer)) = answer else { continue };
        for id in about {
            let from = format!("$response.body#{}", named.at);
            let link = Link::builder().operation_id(&id).parameter(named.parameter, from).build();
            answer.links.insert(id, RefOr::T(link));
        }
    }
}

/// Nothing is loaded from elsewhere. The reader puts style into its page, and has its pictures in its style sheet.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
                      connect-src 'self'; form-action 'none'; base-uri 'none'; frame-ancestors 'none'";

/// The whole document, of a service whose paths begin with `base_path`.
pub fn description(api: &Routes<App>, base_path: &str) -> OpenApi {
    let mut openapi = Head::openapi();
    openapi.merge(api.description().clone());
    link(&mut openapi);
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
