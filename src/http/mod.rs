//! The service over HTTP: the router, and one file an endpoint family.
//!
//! A handler is a short story: read, act (one call of the pipeline), answer. Whatever goes wrong leaves as
//! `application/problem+json`; what axum and its layers refuse by themselves is put into that form in one place
//! ([`problem::as_problem`]).

mod agreement;
mod alerts;
mod answer;
mod baseline;
mod bench_results;
mod campaigns;
mod docs;
mod document;
mod events;
mod gyro_diagnosis;
mod gyros;
mod health;
mod hooks;
mod import;
mod metrics;
mod models;
pub mod problem;
mod query;
mod records;
mod refusal;
pub mod server;
mod trend;

use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::http::StatusCode;
use axum::middleware;
use tower::ServiceBuilder;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::timeout::{RequestBodyTimeoutLayer, TimeoutLayer};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::config::Config;
use crate::pipeline::Pipeline;
use crate::system::Clock;

/// What every handler may use. Cheap to clone.
#[derive(Clone)]
pub struct App {
    pub config: Arc<Config>,
    pub clock: Clock,
    pub pipeline: Pipeline,
}

/// The whole service as one router, the web `pages` included.
pub fn router(app: App, pages: Router) -> Router {
    let server = app.config.server.clone();
    let timed = OpenApiRouter::with_openapi(docs::head())
        .routes(routes!(health::healthz))
        .routes(routes!(health::readyz))
        .merge(metrics::routes())
        .merge(records::routes())
        .merge(campaigns::routes())
        .merge(bench_results::routes())
        .merge(gyros::routes())
        .merge(gyro_diagnosis::routes())
        .merge(trend::routes())
        .merge(agreement::routes())
        .merge(baseline::routes())
        .merge(models::routes())
        .merge(hooks::routes())
        .merge(events::routes())
        .merge(alerts::routes())
        .layer(TimeoutLayer::with_status_code(
            StatusCode::SERVICE_UNAVAILABLE,
            Duration::from_secs_f64(server.request_timeout_s),
        ));
    let (router, openapi) = timed.merge(import::routes()).split_for_parts();
    router.merge(docs::router(openapi)).with_state(app).merge(pages).fallback(problem::no_such_path).layer(
        // The outermost first. Refusals are put into form before they are compressed. As one stack: each layer by itself would be boxed.
        ServiceBuilder::new()
            .layer(middleware::from_fn(metrics::count))
            .layer(CompressionLayer::new())
            .layer(middleware::from_fn(problem::as_problem))
            .layer(CatchPanicLayer::new())
            .layer(RequestBodyTimeoutLayer::new(Duration::from_secs_f64(server.body_timeout_s)))
            .layer(DefaultBodyLimit::max(server.max_body_bytes)),
    )
}
