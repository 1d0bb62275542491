//! What every request passes on its way in and out. One middleware: each by itself would copy the whole stack below it for every request.

use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::http::header::{CONNECTION, HOST, TRANSFER_ENCODING};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::{App, access, metrics, problem};
use crate::wire::problem::Problem;

/// Counts the request, lets it in or refuses it, and puts what went wrong into the common form.
pub async fn pass(State(app): State<App>, request: Request, next: Next) -> Response {
    let counted = metrics::Counted::begin(&request);
    if let Some(doubt) = doubt(request.headers()) {
        counted.end(doubt.status());
        return doubt;
    }
    let response = problem::in_form(access::admit(&app, request, next).await).await;
    counted.end(response.status());
    response
}

/// The refusal of a request that a proxy in front may read otherwise: as ending elsewhere, or as meant for somebody else. Nothing
/// more is read from its connection. hyper refuses lengths that contradict one another, but takes any coding that ends in `chunked`.
fn doubt(headers: &HeaderMap) -> Option<Response> {
    let mut codings = headers.get_all(TRANSFER_ENCODING).iter();
    let known = codings.next().is_none_or(|coding| coding.as_bytes().eq_ignore_ascii_case(b"chunked"));
    let problem = if !known || codings.next().is_some() {
        Problem::new(501, "Unknown transfer coding", "Transfer-Encoding must be chunked, once, where there is one")
    } else if headers.get_all(HOST).iter().count() > 1 {
        Problem::new(400, "Two hosts", "there must be one Host")
    } else {
        return None;
    };
    Some(([(CONNECTION, "close")], problem).into_response())
}
