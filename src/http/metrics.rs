//! `/metrics`, and the counting of requests.

use std::time::Instant;

use axum::extract::{MatchedPath, Request};
use axum::http::Method;
use axum::http::header::CONTENT_TYPE;
use metrics::{counter, gauge, histogram};

use crate::core::judge::{Severity, Status};
use crate::http::prelude::*;
use crate::routes::AccessRule;
use crate::telemetry;

/// What the service counts about itself, in Prometheus' text format.
#[utoipa::path(get, path = "/metrics", tag = "service",
    responses((status = 200, description = "the metrics", body = String, content_type = "text/plain")))]
pub async fn get_metrics(app: App) -> Answer<Response> {
    let (database, log) = app.pipeline.sizes().await?;
    gauge!(telemetry::DATABASE).set(database as f64);
    gauge!(telemetry::LOG).set(log as f64);
    gauge!(telemetry::WAITING).set(app.pipeline.waiting().0 as f64);
    let outbox = app.pipeline.hooks.outbox_totals().await?;
    let age = outbox.oldest_open.map_or(0.0, |oldest| (app.clock.now().0 - oldest.0).max(0) as f64 / 1e6);
    gauge!(telemetry::OUTBOX_AGE).set(age);
    gauge!(telemetry::OUTBOX, "state" => "open").set(outbox.open as f64);
    gauge!(telemetry::OUTBOX, "state" => "dead").set(outbox.dead as f64);
    gauge!(telemetry::HOOKS_DISABLED).set(app.pipeline.hooks.disabled().await?.len() as f64);
    let (stored, ordered) = app.pipeline.diagnoses.waiting().await?;
    gauge!(telemetry::DIAGNOSES_WAITING, "for" => "stored").set(stored as f64);
    gauge!(telemetry::DIAGNOSES_WAITING, "for" => "ordered").set(ordered as f64);
    let totals = app.pipeline.queries.fleet.totals().await?;
    for (status, gyros) in Status::ALL.into_iter().zip(totals.of_status) {
        gauge!(telemetry::GYROS, "status" => status.name()).set(gyros as f64);
    }
    for (station, calibrated) in totals.of_station {
        let newest = calibrated.last_calibrated.0 as f64 / 1e6;
        gauge!(telemetry::NEWEST_CALIBRATION, "station" => station.clone()).set(newest);
        gauge!(telemetry::STATION_OVERDUE, "station" => station).set(calibrated.overdue as f64);
    }
    for (severity, firing) in Severity::ALL.into_iter().zip(app.pipeline.alerts.firing().await?) {
        gauge!(telemetry::ALERTS, "severity" => severity.name()).set(firing as f64);
    }
    Ok(([(CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], telemetry::render()).into_response())
}

/// A request that is counted when it has been answered, under its route, so that names in paths do not make a series
/// each.
pub struct Counted {
    method: &'static str,
    route: Option<MatchedPath>,
    begun: Instant,
}

impl Counted {
    pub fn begin(request: &Request) -> Self {
        let route = request.extensions().get::<MatchedPath>().cloned();
        Self { method: known(request.method()), route, begun: Instant::now() }
    }

    pub fn end(self, status: StatusCode) {
        let (method, status) = (self.method, status.as_str().to_owned());
        let route = self.route.as_ref().map_or("none", MatchedPath::as_str).to_owned();
        let took = self.begun.elapsed();
        histogram!(telemetry::REQUEST_TIME, "method" => method, "route" => route.clone()).record(took);
        counter!(telemetry::REQUESTS, "method" => method, "route" => route, "status" => status).increment(1);
    }
}

/// The failures of every route begin at 0: `rate` and `increase` see nothing of a series that begins at 1. What else is
/// answered comes as it is asked for.
pub fn begin_at_zero(rules: &[AccessRule]) {
    for (rule, status) in rules.iter().flat_map(|rule| FAILURES.map(|status| (rule, status))) {
        let (method, route) = (known(&rule.method), rule.path.clone());
        counter!(telemetry::REQUESTS, "method" => method, "route" => route, "status" => status).absolute(0);
    }
}

/// The service's own, not its caller's.
const FAILURES: [&str; 2] = ["500", "503"];

/// A client may invent methods without end; they share one series.
fn known(method: &Method) -> &'static str {
    match *method {
        Method::GET => "GET",
        Method::HEAD => "HEAD",
        Method::POST => "POST",
        Method::PUT => "PUT",
        Method::PATCH => "PATCH",
        Method::DELETE => "DELETE",
        _ => "other",
    }
}
