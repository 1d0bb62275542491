//! The body of a request: one JSON document, as bytes.

use axum::extract::{FromRequest, Request};
use axum::http::HeaderName;
use axum::http::header::{CONTENT_ENCODING, CONTENT_TYPE};
use bytes::Bytes;

use crate::core::message::Message;
use crate::http::prelude::*;
use crate::pipeline::Accepted;
use crate::wire::document::DocumentKind;
use crate::wire::json::is_json;

/// A whole JSON body within the size limit. Anything that does not call itself JSON is answered 415.
pub struct Document(pub Bytes);

impl<S: Send + Sync> FromRequest<S> for Document {
    type Rejection = Response;

    async fn from_request(request: Request, state: &S) -> Result<Self, Response> {
        check_media_type(request.headers(), &["application/json"]).map_err(IntoResponse::into_response)?;
        Bytes::from_request(request, state).await.map(Self).map_err(|rejection| match rejection.status() {
            StatusCode::BAD_REQUEST => {
                Problem::new(400, "title_broken_off", message!("body_broke_off")).into_response()
            }
            _ => rejection.into_response(),
        })
    }
}

impl Document {
    /// What it says, as `read` takes it.
    pub fn read<T>(&self, read: impl FnOnce(&[u8]) -> Result<T, Faults>) -> Answer<T> {
        read(&self.0).map_err(|faults| Self::problem(&self.0, faults))
    }

    /// The answer to a document that cannot be read as the kind that is `wanted`: of one that is of another kind,
    /// where it belongs, for its members are then all at fault.
    pub fn refused_as(wanted: DocumentKind, bytes: &[u8], faults: Faults) -> Problem {
        let belongs = match DocumentKind::instead_of(wanted, bytes) {
            None => return Self::problem(bytes, faults),
            Some(DocumentKind::Record) => message!("belongs_to_records"),
            Some(DocumentKind::Campaign) => message!("belongs_to_campaigns"),
            Some(DocumentKind::Bench) => message!("belongs_to_bench_results"),
        };
        Self::problem(bytes, belongs.into())
    }

    /// The answer to a document with faults: 400 where it is no JSON at all, 422 where it says what cannot be.
    pub fn problem(bytes: &[u8], faults: Faults) -> Problem {
        if is_json(bytes) {
            Problem::of_faults(422, "title_cannot_be_stored", faults)
        } else {
            Problem::of_faults(400, "title_not_json", faults)
        }
    }
}

/// Whether something was new, and its identifier.
pub fn outcome(accepted: &Accepted) -> (StatusCode, Id) {
    match accepted {
        Accepted::Stored { id, .. } => (StatusCode::CREATED, *id),
        Accepted::There { id, .. } => (StatusCode::OK, *id),
    }
}

/// Which of `accepted` a body is sent as; one that is none of them, or of another coding than
/// gzip, is refused, and so is JSON in another charset than UTF-8.
pub fn check_media_type(headers: &HeaderMap, accepted: &[&'static str]) -> Answer<&'static str> {
    let text = |name: HeaderName| headers.get(name).map(|value| value.to_str().unwrap_or("?").trim().to_owned());
    let media_type = text(CONTENT_TYPE);
    let essence = media_type.as_deref().map(|t| t.split(';').next().unwrap_or(t).trim().to_ascii_lowercase());
    let Some(sent) = accepted.iter().find(|accepted| essence.as_deref() == Some(**accepted)) else {
        let wanted = accepted.join(" or ");
        return Err(unsupported(match media_type {
            Some(found) => message!("content_type", wanted, found),
            None => message!("content_type_missing", wanted),
        }));
    };
    if let Some(charset) = media_type.as_deref().filter(|_| sent.contains("json")).and_then(other_charset) {
        return Err(unsupported(message!("content_type_charset", charset)));
    }
    match text(CONTENT_ENCODING).filter(|encoding| !encoding.eq_ignore_ascii_case("identity")) {
        None => Ok(sent),
        Some(encoding) => Err(unsupported(message!("content_encoding", encoding))),
    }
}

/// The charset that a media type names, where that is another than JSON's.
fn other_charset(media_type: &str) -> Option<String> {
    let named = media_type.split(';').skip(1).filter_map(|parameter| parameter.split_once('='));
    let charsets = named.filter(|(name, _)| name.trim().eq_ignore_ascii_case("charset"));
    let is_utf8 = |charset: &&str| ["utf-8", "utf8", "us-ascii"].iter().any(|same| charset.eq_ignore_ascii_case(same));
    let mut charsets = charsets.map(|(_, charset)| charset.trim().trim_matches('"'));
    charsets.find(|charset| !is_utf8(charset)).map(str::to_owned)
}

fn unsupported(message: Message) -> Problem {
    Problem::new(415, "title_unsupported_media_type", message)
}
