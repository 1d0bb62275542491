//! The service over HTTP: the router, and one file an endpoint family.
//!
//! A handler is a short story: read, act (one call of the pipeline), answer. Whatever goes wrong leaves as
//! `application/problem+json`; what axum and its layers refuse by themselves is put into that form in one place
//! ([`problem::in_form`]).

mod access;
mod agreement;
mod alerts;
mod answer;
mod app;
mod audit;
mod baseline;
mod bench_results;
mod campaigns;
mod confirm;
mod corrections;
mod diagnoses;
mod docs;
mod document;
mod edge;
mod events;
mod gyro_diagnosis;
mod gyros;
mod health;
mod hooks;
mod import;
mod metrics;
mod middleware;
mod models;
mod prefer_header;
pub mod problem;
mod query;
mod records;
mod refusal;
mod remark;
pub mod server;
mod silences;
mod telling;
pub mod tls;
mod tokens;
mod trend;

use std::time::Duration;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::http::StatusCode;
use axum::middleware::from_fn_with_state;
use tower::ServiceBuilder;
use tower_http::compression::CompressionLayer;
use tower_http::timeout::{RequestBodyTimeoutLayer, TimeoutLayer};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

pub use app::App;

/// The whole service as one router, the web `pages` included.
pub fn router(app: App, pages: Router) -> Router {
    let (server, guarded) = (app.config.server.clone(), app.clone());
    let timed = answered_soon().layer(TimeoutLayer::with_status_code(
        StatusCode::SERVICE_UNAVAILABLE,
        Duration::from_secs_f64(server.request_timeout_s),
    ));
    let (router, openapi) = timed.merge(import::routes()).split_for_parts();
    router
        .merge(docs::router(openapi, &server.base_path))
        .with_state(app)
        .merge(pages)
        .fallback(problem::no_such_path)
        .layer(
            // The outermost first. Refusals are put into form before they are compressed. As one stack: each layer by itself would be boxed.
            ServiceBuilder::new()
                .layer(CompressionLayer::new())
                .layer(from_fn_with_state(guarded, middleware::pass))
                .layer(RequestBodyTimeoutLayer::new(Duration::from_secs_f64(server.body_timeout_s)))
                .layer(DefaultBodyLimit::max(server.max_body_bytes)),
        )
}

/// Every route but the import, which may take as long as it likes.
fn answered_soon() -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(docs::head())
        .routes(routes!(health::healthz))
        .routes(routes!(health::readyz))
        .merge(metrics::routes())
        .merge(records::routes())
        .merge(campaigns::routes())
        .merge(bench_results::routes())
        .merge(corrections::routes())
        .merge(confirm::routes())
        .merge(diagnoses::routes())
        .merge(gyros::routes())
        .merge(gyro_diagnosis::routes())
        .merge(trend::routes())
        .merge(agreement::routes())
        .merge(baseline::routes())
        .merge(models::routes())
        .merge(hooks::routes())
        .merge(events::routes())
        .merge(alerts::routes())
        .merge(silences::routes())
        .merge(tokens::routes())
        .merge(audit::routes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_route_has_a_rule_that_says_who_may_use_it() {
        let api = answered_soon().merge(import::routes()).into_openapi();
        let described = serde_json::to_value(&api.paths).unwrap();
        let mut routes = 0;
        for (path, operations) in described.as_object().unwrap() {
            for method in operations.as_object().unwrap().keys() {
                let method = method.to_uppercase();
                assert!(access::has_rule(&method, path), "{method} {path} has no rule in http/access/rules.rs");
                routes += 1;
            }
        }
        assert!(routes > 30);
        assert!(!access::has_rule("POST", "/v1/unheard-of"));
    }
}
