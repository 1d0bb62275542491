//! What every request passes on its way in and out. One middleware: each by itself would copy the whole stack below it for every request.

use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::Response;

use super::{App, access, metrics, problem};

/// Counts the request, lets it in or refuses it, and puts what went wrong into the common form.
pub async fn pass(State(app): State<App>, request: Request, next: Next) -> Response {
    let counted = metrics::Counted::begin(&request);
    let response = problem::in_form(access::admit(&app, request, next).await).await;
    counted.end(response.status());
    response
}
