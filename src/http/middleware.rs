//! What every request passes on its way in and out. One middleware: each by itself would copy the whole stack below
//! it for every request.

use std::panic::AssertUnwindSafe;

use axum::extract::{Request, State};
use axum::http::Version;
use axum::http::header::{ACCEPT_LANGUAGE, CONNECTION, HOST, TRANSFER_ENCODING};
use axum::middleware::Next;
use futures::FutureExt;

use super::access::{self, Gate};
use super::gzip::unpacked;
use super::metrics::Counted;
use super::problem;
use crate::cookies;
use crate::http::prelude::*;
use crate::words::{self, Language};

/// Counts the request, lets it in or refuses it, and puts what went wrong into the common form.
pub async fn pass(State(gate): State<Gate>, request: Request, next: Next) -> Response {
    words::asked_in(language(request.headers()), passed(gate, request, next)).await
}

/// The language that was chosen on the pages, else that of `Accept-Language`.
fn language(headers: &HeaderMap) -> Language {
    let preferred = || headers.get(ACCEPT_LANGUAGE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let chosen = cookies::sent(headers, "language").and_then(Language::from_tag);
    chosen.unwrap_or_else(|| Language::preferred(preferred()))
}

async fn passed(gate: Gate, request: Request, next: Next) -> Response {
    let counted = Counted::begin(&request);
    if let Some(doubt) = doubt(request.version(), request.headers()) {
        counted.end(doubt.status());
        return doubt;
    }
    let longest_body = gate.app.config.server.max_body_bytes;
    answered(counted, longest_body, access::admit(&gate, unpacked(request), next)).await
}

/// A panic, of the admission as of a handler, is answered and counted like any other failure; the connection would
/// break off.
async fn answered(counted: Counted, longest_body: usize, answer: impl Future<Output = Response>) -> Response {
    let answer = AssertUnwindSafe(answer).catch_unwind().await.unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<&str>().copied().or(panic.downcast_ref::<String>().map(String::as_str));
        tracing::error!(panic = said.unwrap_or_default(), "a request could not be handled");
        StatusCode::INTERNAL_SERVER_ERROR.into_response()
    });
    let response = problem::in_form(answer, longest_body).await;
    counted.end(response.status());
    response
}

/// The refusal of a request that a proxy in front may read otherwise: as ending elsewhere, or as meant for somebody
/// else. Nothing more is read from its connection. hyper refuses lengths that contradict one another, but takes any
/// coding that ends in `chunked`.
fn doubt(version: Version, headers: &HeaderMap) -> Option<Response> {
    let mut codings = headers.get_all(TRANSFER_ENCODING).iter();
    let known = codings.next().is_none_or(|coding| coding.as_bytes().eq_ignore_ascii_case(b"chunked"));
    let problem = if !known || codings.next().is_some() {
        Problem::new(501, "title_unknown_transfer_coding", message!("transfer_coding"))
    } else if headers.get_all(HOST).iter().count() > 1 {
        Problem::new(400, "title_two_hosts", message!("one_host"))
    } else if version == Version::HTTP_11 && !headers.contains_key(HOST) {
        Problem::new(400, "title_no_host", message!("host_needed"))
    } else {
        return None;
    };
    Some(([(CONNECTION, "close")], problem).into_response())
}

#[cfg(test)]
mod tests {
    use axum::body::Body;
    use axum::http::header::CONTENT_TYPE;

    use super::*;

    #[tokio::test]
    async fn a_panic_is_answered_wherever_it_happens() {
        let counted = Counted::begin(&Request::new(Body::empty()));
        let response = answered(counted, 0, async { panic!("at the door") }).await;
        assert_eq!(response.status(), StatusCode::INTERNAL_SERVER_ERROR);
        assert_eq!(response.headers()[CONTENT_TYPE], problem::PROBLEM_JSON);
    }
}
