//! What several queries have in common: checked parameters, opaque cursors.

use std::borrow::Cow;

use axum::extract::{FromRequestParts, Query, Request};
use axum::http::Method;
use axum::http::header::{ACCEPT, HeaderName, LINK};
use axum::http::request::Parts;
use serde::de::DeserializeOwned;
use url::form_urlencoded;

use crate::core::message::{Message, list};
use crate::core::time::Span;
use crate::http::prelude::*;
use crate::routes::AcceptedInputs;
use crate::wire::cursor;
use crate::wire::unreadable;

pub use crate::wire::problem::{id, named, not_one_of};

pub const IDEMPOTENCY_KEY: &str = "idempotency-key";

/// Query parameters whose faults are answered 400 in the common form.
pub struct Parameters<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for Parameters<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Answer<Self> {
        let Query(parameters) = Query::from_request_parts(parts, state)
            .await
            .map_err(|rejection| bad(unreadable::in_words(&rejection.body_text())))?;
        Ok(Self(parameters))
    }
}

/// The refusal of a parameter that an operation does not take, or of a promise that it does not keep: what is ignored
/// would be taken for granted.
pub fn not_taken(takes: &AcceptedInputs, request: &Request) -> Option<Problem> {
    let sent = form_urlencoded::parse(request.uri().query().unwrap_or_default().as_bytes());
    let mut unknown = sent.filter(|(name, _)| !takes.parameters.iter().any(|known| known == name));
    if let Some((name, _)) = unknown.next() {
        let (parameter, known) = (name.into_owned(), takes.parameters.clone());
        return Some(bad(match known.is_empty() {
            true => message!("no_parameters", parameter),
            false => message!("unknown_parameter", parameter, known = list(known)),
        }));
    }
    let bears_key = request.method() == Method::POST && request.headers().contains_key(IDEMPOTENCY_KEY);
    let unkept = bears_key && !takes.headers.iter().any(|known| known.eq_ignore_ascii_case(IDEMPOTENCY_KEY));
    unkept.then(|| Problem::new(400, "title_bad_idempotency_key", message!("idempotency_key_not_taken")))
}

/// The answer to a parameter that cannot be used.
pub fn bad(message: Message) -> Problem {
    Problem::new(400, "title_bad_query", message)
}

/// `format`, or else `Accept`: whether CSV is asked for and not JSON.
pub fn wants_csv(format: Option<&str>, headers: &HeaderMap) -> Answer<bool> {
    match format {
        Some("csv") => Ok(true),
        Some("json") => Ok(false),
        Some(other) => Err(not_one_of("format", ["json", "csv"], other)),
        None => Ok(headers.get(ACCEPT).and_then(|a| a.to_str().ok()).is_some_and(|a| a.contains("text/csv"))),
    }
}

/// A whole number that a parameter says, which has to be one of a range.
pub fn between(parameter: &'static str, value: u64, (least, most): (u64, u64)) -> Answer<u64> {
    let is_within = (least..=most).contains(&value);
    is_within.then_some(value).ok_or_else(|| bad(message!("parameter_range", parameter, least, most, value)))
}

/// `limit`: how many items at most.
pub fn limit(asked: Option<usize>, default: usize, most: usize) -> Answer<usize> {
    between("limit", asked.unwrap_or(default) as u64, (1, most as u64)).map(|limit| limit as usize)
}

/// The time that a parameter says, as `read` takes it.
pub fn instant(
    name: &'static str,
    text: Option<&str>,
    read: fn(&str) -> Result<UtcMicros, Message>,
) -> Answer<Option<UtcMicros>> {
    let fault = |fault| bad(message!("parameter_fault", parameter = name, fault));
    text.map(|text| read(&with_sign(text)).map_err(fault)).transpose()
}

/// `from` and `to`: a stretch of time, both ends included.
pub fn span(from: Option<&str>, to: Option<&str>) -> Answer<Span> {
    let from = instant("from", from, time::parse_start)?.unwrap_or(Span::EVER.from);
    let to = instant("to", to, time::parse_end)?.unwrap_or(Span::EVER.to);
    let span = Span { from, to };
    if span.from > span.to {
        return Err(bad(message!("from_after_to")));
    }
    Ok(span)
}

/// A time whose `+` was sent as it is: in a query it means a blank.
pub fn with_sign(text: &str) -> Cow<'_, str> {
    match text.rsplit_once(' ') {
        Some((instant, offset)) if instant.contains(['T', 't']) => format!("{instant}+{offset}").into(),
        _ => text.into(),
    }
}

pub fn position(list: List, cursor: Option<&str>) -> Answer<Option<i64>> {
    cursor.map(|cursor| cursor::decode(list, cursor).map_err(bad)).transpose()
}

/// The number after which a page of a list by numbers begins.
pub fn number_before(list: List, cursor: Option<&str>) -> Answer<u32> {
    let after = position(list, cursor)?.unwrap_or_default();
    u32::try_from(after).map_err(|_| bad(message!("invalid_cursor")))
}

/// The first `limit` of what was asked for with one more, and the cursor of the page after them where there is one.
pub fn page<T>(
    list: List,
    mut found: Vec<T>,
    limit: usize,
    id: impl FnOnce(&T) -> Option<Id>,
) -> (Vec<T>, Option<String>) {
    let more = found.len() > limit;
    found.truncate(limit);
    let next = found.last().filter(|_| more).and_then(id).map(|last| cursor::encode(list, last.0));
    (found, next)
}

/// Where a list goes on, if it does: the same address with another cursor (RFC 8288).
pub fn link(uri: &Uri, next: Option<&str>) -> Option<[(HeaderName, String); 1]> {
    let next = next?;
    let kept = uri.query().unwrap_or_default().split('&').filter(|p| !p.is_empty() && !p.starts_with("cursor="));
    let query: Vec<String> = kept.map(str::to_owned).chain([format!("cursor={next}")]).collect();
    Some([(LINK, format!("<{}?{}>; rel=\"next\"", uri.path(), query.join("&")))])
}

pub fn gyro(app: &App, serial: &str) -> Answer<u32> {
    let number = app.pipeline.queries.names().gyro_number(serial);
    number.ok_or_else(|| Problem::unknown_gyro(serial))
}

/// That no IMU has this name, and which one may be meant.
pub fn unknown_imu(app: &App, name: &str) -> Problem {
    Problem::new(404, "title_unknown_imu", app.pipeline.queries.names().unknown_imu(name))
}

#[cfg(test)]
mod tests {
    use axum::http::Request;
    use serde::Deserialize;

    use super::*;
    use crate::words::Language;

    #[derive(Debug, Deserialize)]
    struct Asked {
        #[serde(rename = "limit")]
        _limit: Option<usize>,
        #[serde(rename = "share")]
        _share: Option<f64>,
        #[serde(rename = "all")]
        _all: Option<bool>,
    }

    #[tokio::test]
    async fn a_query_that_cannot_be_read_is_refused_in_words_of_ours() {
        for (query, expected) in [
            ("limit=1&share=0.5&all=true", None),
            ("limit=x", Some("limit must be a whole number")),
            ("limit=-1", Some("limit must be a whole number")),
            ("limit=99999999999999999999999", Some("limit must be a whole number")),
            ("share=x", Some("share must be a number")),
            ("all=x", Some("all must be true or false")),
            ("limit=1&limit=2", Some("limit is given twice")),
        ] {
            let (mut parts, ()) = Request::get(format!("/?{query}")).body(()).unwrap().into_parts();
            let read = Parameters::<Asked>::from_request_parts(&mut parts, &()).await;
            let said = read.err().map(|problem| problem.body(Language::English).detail);
            assert_eq!(said.as_deref(), expected, "{query}");
        }
    }
}
