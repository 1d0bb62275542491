//! A trend as an answer: its tag, what the client knows already, the next page's address.

use crate::http::prelude::*;
use std::fmt::Write as _;
use std::hash::{DefaultHasher, Hash, Hasher};

use axum::http::HeaderValue;
use axum::http::header::{CONTENT_TYPE, ETAG, IF_NONE_MATCH, VARY};

use super::request::Request;

/// A tag of what the answer holds (rows by identifier and what is shown of them, or periods with the events), and how it
/// is asked for.
fn etag(request: &Request, holds: &impl Hash, next: &Option<String>) -> HeaderValue {
    let mut hasher = DefaultHasher::new();
    holds.hash(&mut hasher);
    let Request { coefficient, method, voided, every, csv, columns, .. } = request;
    (coefficient, csv, columns, voided, every, next, format!("{method:?}")).hash(&mut hasher);
    let mut tag = String::new();
    write!(tag, "\"{:016x}\"", hasher.finish()).expect("writing to a string cannot fail");
    HeaderValue::from_str(&tag).expect("hexadecimal digits in quotes are a valid header")
}

fn is_known(headers: &HeaderMap, tag: &HeaderValue) -> bool {
    let known = headers.get(IF_NONE_MATCH).and_then(|known| known.to_str().ok());
    let tag = tag.to_str().unwrap_or_default();
    // A proxy that compresses may weaken the tag.
    known.is_some_and(|known| known.split(',').any(|k| k.trim().trim_start_matches("W/") == tag || k.trim() == "*"))
}

/// The answer to a request, `written` with the cursor of its next page. What the client knows already is not written
/// again.
pub(super) fn answer(
    (uri, headers): (&Uri, &HeaderMap),
    request: &Request,
    holds: &impl Hash,
    next: Option<String>,
    written: impl FnOnce(Option<String>) -> Option<Vec<u8>>,
) -> Answer<Response> {
    let tag = etag(request, holds, &next);
    if is_known(headers, &tag) {
        return Ok((StatusCode::NOT_MODIFIED, [(ETAG, tag)]).into_response());
    }
    let media_type = if request.csv { "text/csv; charset=utf-8" } else { "application/json" };
    let link = query::link(uri, next.as_deref());
    let text = written(next);
    let text = text.ok_or_else(|| Problem::new(500, "title_internal_error", message!("not_written")))?;
    Ok((link, [(CONTENT_TYPE, media_type), (VARY, "accept")], [(ETAG, tag)], text).into_response())
}
