//! Every error leaves as problem details (RFC 9457).

use axum::http::header::{CONTENT_LANGUAGE, CONTENT_LENGTH, CONTENT_TYPE, RETRY_AFTER, VARY};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use http_body_util::{BodyExt, Limited};

use crate::core::message::Message;
use crate::wire::problem::Problem;
use crate::{message, words};

/// What is answered, or the problem that there is.
pub type Answer<T> = Result<T, Problem>;

pub const PROBLEM_JSON: &str = "application/problem+json";

/// When to try again after a 503: the queue of writes empties within a second.
const RETRY_AFTER_S: &str = "1";

/// Longest text of a refusal that is taken over as the detail.
const MAX_DETAIL_BYTES: usize = 4096;

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let language = words::asked();
        let body = serde_json::to_vec(&self.body(language)).unwrap_or_default();
        let headers = [(CONTENT_TYPE, PROBLEM_JSON), (CONTENT_LANGUAGE, language.tag()), (VARY, "accept-language")];
        let mut response = (status, headers, body).into_response();
        if status == StatusCode::SERVICE_UNAVAILABLE {
            response.headers_mut().insert(RETRY_AFTER, HeaderValue::from_static(RETRY_AFTER_S));
        }
        // For the pages, which say it in a frame.
        response.extensions_mut().insert(self);
        response
    }
}

/// Something is longer than the configuration allows.
pub fn too_large(message: Message) -> Problem {
    Problem::new(413, "title_too_large", message)
}

/// Puts refusals that are not ours (of axum's extractors and of the layers) into the common form. Headers such as
/// `Allow` and `Retry-After` stay. `longest_body` is what a body may have at the most, bytes.
pub async fn in_form(response: Response, longest_body: usize) -> Response {
    let status = response.status();
    let is_error = status.is_client_error() || status.is_server_error();
    let content_type = response.headers().get(CONTENT_TYPE).and_then(|t| t.to_str().ok()).unwrap_or_default();
    // The web pages say in words what went wrong.
    let is_said = content_type == PROBLEM_JSON || content_type.starts_with("text/html");
    if !is_error || is_said {
        return response;
    }
    let (mut parts, body) = response.into_parts();
    let text = match Limited::new(body, MAX_DETAIL_BYTES).collect().await {
        Ok(collected) => String::from_utf8_lossy(&collected.to_bytes()).trim().to_owned(),
        Err(_) => String::new(),
    };
    let (problem, headers) = (problem_of(status, text, longest_body).into_response(), &mut parts.headers);
    headers.remove(CONTENT_LENGTH);
    for name in [CONTENT_TYPE, CONTENT_LANGUAGE, VARY] {
        if let Some(value) = problem.headers().get(&name) {
            headers.insert(name, value.clone());
        }
    }
    Response::from_parts(parts, problem.into_body())
}

/// What a refusal that says no more than `text` means.
fn problem_of(status: StatusCode, text: String, longest_body: usize) -> Problem {
    if status == StatusCode::PAYLOAD_TOO_LARGE {
        return too_large(message!("too_long_body", most = longest_body, key = "server.max_body_bytes"));
    }
    let title = status.canonical_reason().unwrap_or("Error");
    // What failed inside is for the log, not for the client.
    let message = match (text.is_empty() || status == StatusCode::INTERNAL_SERVER_ERROR, status) {
        (false, StatusCode::BAD_REQUEST) if text.starts_with("Invalid URL") => message!("path_not_utf8"),
        (false, _) => Message::verbatim(text),
        (true, StatusCode::METHOD_NOT_ALLOWED) => message!("wrong_method"),
        (true, StatusCode::INTERNAL_SERVER_ERROR) => message!("service_failed"),
        (true, StatusCode::SERVICE_UNAVAILABLE) => message!("answer_took_too_long"),
        (true, _) => Message::verbatim(title),
    };
    Problem::new(status.as_u16(), title, message)
}
