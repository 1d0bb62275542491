//! The service over HTTP: the router, and one file an endpoint family.
//!
//! A handler is a short story: read, act (one call of the pipeline), answer. Whatever goes wrong leaves as
//! `application/problem+json`; what axum and its layers refuse by themselves is put into that form in one place
//! ([`problem::in_form`]).

mod access;
mod agreement;
mod alerts;
mod app;
mod audit;
mod baseline;
mod bench_results;
mod campaigns;
mod confirm;
mod constraints;
mod corrections;
mod diagnoses;
mod document;
mod document_post;
mod edge;
mod events;
mod examples;
mod gyro_diagnosis;
mod gyros;
mod gzip;
mod health;
mod hooks;
mod hypotheses;
mod import;
mod imus;
mod json_response;
mod metrics;
mod middleware;
mod models;
mod notify_query;
mod openapi;
mod operation;
mod prefer_header;
mod prelude;
pub mod problem;
mod query;
mod record_list;
mod records;
mod remark;
pub mod server;
mod signed;
mod silences;
mod stations;
pub mod tls;
mod tokens;
mod trend;

use std::sync::Arc;
use std::time::Duration;

use axum::extract::DefaultBodyLimit;
use axum::http::StatusCode;
use axum::middleware::from_fn_with_state;
use axum::{Json, Router};
use tower::ServiceBuilder;
use tower_http::compression::CompressionLayer;
use tower_http::timeout::{RequestBodyTimeoutLayer, TimeoutLayer};
use utoipa::openapi::OpenApi;
use utoipa_axum::routes;

use self::access::Gate;
use crate::config::Server;
use crate::routes::{ADMIN, ANYONE, ENGINEER, Routes, Rules, STATION, VIEWER};

pub use app::App;

/// The whole service as one router, the web `pages` included.
pub fn router(app: App, pages: Routes) -> Router {
    let server = app.config.server.clone();
    let routes = routes(&server).with_state(app.clone()).merge(pages);
    metrics::begin_at_zero(routes.rules());
    let gate = Gate { app, rules: Arc::new(Rules::of(routes.rules())) };
    routes.into_router().layer(
        // The outermost first. Refusals are put into form before they are compressed. As one stack: each layer by
        // itself would be boxed.
        ServiceBuilder::new()
            .layer(CompressionLayer::new())
            .layer(from_fn_with_state(gate, middleware::pass))
            .layer(RequestBodyTimeoutLayer::new(Duration::from_secs_f64(server.body_timeout_s)))
            // The limit is over what was unpacked.
            .layer(DefaultBodyLimit::max(server.max_body_bytes)),
    )
}

/// Every route but those of pages.
pub fn routes(server: &Server) -> Routes<App> {
    let openapi = Json(description(server));
    api(server).get(VIEWER, "/openapi.json", async move || openapi)
}

/// The OpenAPI document.
pub fn description(server: &Server) -> OpenApi {
    openapi::description(&api(server), &server.base_path)
}

/// A handler says its method and path; administrators decide where data leave to (hooks) and who comes in (tokens).
fn api(server: &Server) -> Routes<App> {
    let timeout = TimeoutLayer::with_status_code(
        StatusCode::SERVICE_UNAVAILABLE,
        Duration::from_secs_f64(server.request_timeout_s),
    );
    Routes::default()
        .api(ANYONE, routes!(health::healthz))
        .api(ANYONE, routes!(health::readyz))
        .api(VIEWER, routes!(metrics::get_metrics))
        .api(STATION, routes!(records::post_record))
        .api(VIEWER, routes!(record_list::get_records))
        .api(VIEWER, routes!(records::get_record))
        .api(VIEWER, routes!(records::get_record_diagnosis))
        .api(ENGINEER, routes!(corrections::void_record))
        .api(ENGINEER, routes!(corrections::revise_record))
        .api(ENGINEER, routes!(confirm::confirm_record))
        .api(STATION, routes!(campaigns::post_campaign))
        .api(VIEWER, routes!(record_list::get_campaigns))
        .api(VIEWER, routes!(campaigns::get_campaign))
        .api(VIEWER, routes!(campaigns::get_diagnosis))
        .api(ENGINEER, routes!(corrections::void_campaign))
        .api(ENGINEER, routes!(corrections::revise_campaign))
        .api(STATION, routes!(bench_results::post_bench_result))
        .api(VIEWER, routes!(bench_results::get_bench_result))
        .api(ENGINEER, routes!(corrections::void_bench_result))
        .api(VIEWER, routes!(gyros::get_gyros))
        .api(VIEWER, routes!(gyros::get_gyro))
        .api(VIEWER, routes!(trend::get_trend))
        .api(VIEWER, routes!(agreement::get_agreement))
        .api(VIEWER, routes!(gyro_diagnosis::get_gyro_diagnosis))
        .api(ENGINEER, routes!(gyros::patch_gyro))
        .api(ENGINEER, routes!(gyros::patch_gyros))
        .api(VIEWER, routes!(stations::get_stations))
        .api(VIEWER, routes!(stations::get_station))
        .api(ENGINEER, routes!(stations::suspect_window))
        .api(ENGINEER, routes!(stations::trust_window))
        .api(VIEWER, routes!(events::get_events))
        .api(ENGINEER, routes!(events::post_event))
        .api(ENGINEER, routes!(baseline::post_baseline))
        .api(VIEWER, routes!(imus::get_imus))
        .api(VIEWER, routes!(imus::get_imu))
        .api(VIEWER, routes!(models::get_model))
        .api(ENGINEER, routes!(models::post_model))
        .api(VIEWER, routes!(models::get_forecast))
        .api(VIEWER, routes!(hypotheses::get_hypotheses))
        .api(ENGINEER, routes!(hypotheses::post_hypothesis))
        .api(ENGINEER, routes!(hypotheses::delete_hypothesis))
        .api(VIEWER, routes!(diagnoses::get_diagnoses))
        .api(ENGINEER, routes!(diagnoses::post_diagnoses))
        .api(VIEWER, routes!(diagnoses::get_summary))
        .api(VIEWER, routes!(diagnoses::get_one))
        .api(ENGINEER, routes!(diagnoses::delete_one))
        .api(VIEWER, routes!(alerts::get_alerts))
        .api(VIEWER, routes!(alerts::get_alert))
        .api(ENGINEER, routes!(alerts::post_acknowledge))
        .api(ENGINEER, routes!(alerts::post_unacknowledge))
        .api(ENGINEER, routes!(alerts::post_silence))
        .api(VIEWER, routes!(silences::get_silences))
        .api(ENGINEER, routes!(silences::post_matching_silence))
        .api(VIEWER, routes!(silences::get_silence))
        .api(ENGINEER, routes!(silences::post_end_silence))
        .api(ENGINEER, routes!(hooks::get_hooks))
        .api(ADMIN, routes!(hooks::post_hook))
        .api(ENGINEER, routes!(hooks::get_hook))
        .api(ADMIN, routes!(hooks::patch_hook))
        .api(ADMIN, routes!(hooks::delete_hook))
        .api(ENGINEER, routes!(hooks::test_hook))
        .api(ENGINEER, routes!(hooks::get_deliveries))
        .api(ENGINEER, routes!(hooks::get_delivery))
        .api(ENGINEER, routes!(hooks::redeliver))
        .api(ADMIN, routes!(tokens::get_tokens))
        .api(ADMIN, routes!(tokens::post_token))
        .api(ADMIN, routes!(tokens::delete_token))
        .api(ADMIN, routes!(audit::get_audit))
        .map(|answered_soon| answered_soon.layer(timeout))
        .api(STATION, routes!(import::post_import))
}
