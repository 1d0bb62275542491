//! The outermost of the service: who asks, and by which scheme and name, where a trusted proxy says so; the path
//! under which a proxy serves it; identifiers of requests, their log, and the headers of every answer.
//!
//! Whatever lies further in knows neither proxies nor prefixes: it sees the client's address, its `Host`, and paths
//! that begin with `/`.

mod forwarded;
mod trace;
mod unread;

use std::net::SocketAddr;
use std::time::Instant;

use axum::Router;
use axum::extract::{ConnectInfo, Request};
use axum::http::header::{CACHE_CONTROL, HOST, LINK, SET_COOKIE, STRICT_TRANSPORT_SECURITY, X_CONTENT_TYPE_OPTIONS};
use axum::http::uri::PathAndQuery;
use axum::http::{HeaderName, HeaderValue};
use ipnet::IpNet;
use tower::ServiceExt;
use tracing::Instrument;

use crate::config::Server;
use crate::http::prelude::*;
use forwarded::ForwardedRequest;
use trace::{REQUEST_ID, TRACEPARENT, Trace};
use unread::Unread;

/// Browsers that came over TLS come over nothing else for a year.
const ONLY_TLS: &str = "max-age=31536000";
/// Kept by nobody on the way: it holds a secret.
pub(super) const NO_STORE: &str = "no-store";

/// A request has a header that only proxies add.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forwarded;

pub(super) struct Edge {
    trusted: Vec<IpNet>,
    base_path: String,
    encrypted: bool,
}

impl Edge {
    pub fn of(server: &Server) -> Self {
        let (trusted, base_path) = (server.trusted_proxies.clone(), server.base_path.clone());
        Self { trusted, base_path, encrypted: server.is_encrypted() }
    }

    /// Has the `router` answer a request that came from `peer`.
    pub async fn pass(&self, mut request: Request, peer: SocketAddr, router: Router) -> Response {
        let way = ForwardedRequest::of(request.headers(), peer.ip(), &self.trusted);
        let encrypted = way.https.unwrap_or(self.encrypted);
        let trace = Trace::of(request.headers());
        let span = tracing::info_span!("request", id = trace.id, traceparent = trace.parent);
        if way.is_forwarded {
            request.extensions_mut().insert(Forwarded);
        }
        request.extensions_mut().insert(ConnectInfo(SocketAddr::new(way.client, peer.port())));
        // Of none and of two the gate has its say.
        if let (Some(host), 1) = (way.host, request.headers().get_all(HOST).iter().count()) {
            request.headers_mut().insert(HOST, host);
        }
        if let Some(uri) = self.without_base(request.uri()) {
            *request.uri_mut() = uri;
        }
        let told = tracing::enabled!(tracing::Level::DEBUG);
        let asked = told.then(|| (request.method().clone(), request.uri().path().to_owned()));
        let begun = Instant::now();
        let (request, unread) = Unread::of(request);
        let served = router.oneshot(request).instrument(span.clone()).await;
        let mut response = served.unwrap_or_else(|never| match never {});
        unread.settle(response.headers_mut()).await;
        if let Some((method, path)) = asked {
            let (status, took_ms) = (response.status().as_u16(), begun.elapsed().as_secs_f64() * 1e3);
            span.in_scope(|| tracing::debug!(%method, path, status, took_ms, client = %way.client, "answered"));
        }
        self.finish(response.headers_mut(), encrypted, &trace);
        response
    }

    /// The address without the prefix; none where it does not have it, because the proxy has cut it off or there is
    /// no proxy.
    fn without_base(&self, uri: &Uri) -> Option<Uri> {
        let rest = uri.path_and_query()?.as_str().strip_prefix(&self.base_path)?;
        if self.base_path.is_empty() || !(rest.is_empty() || rest.starts_with(['/', '?'])) {
            return None;
        }
        let slash = if rest.starts_with('/') { "" } else { "/" };
        let mut parts = uri.clone().into_parts();
        parts.path_and_query = Some(PathAndQuery::try_from(format!("{slash}{rest}")).ok()?);
        Uri::from_parts(parts).ok()
    }

    fn finish(&self, headers: &mut HeaderMap, encrypted: bool, trace: &Trace) {
        headers.insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
        headers.insert(REQUEST_ID, trace::header(&trace.id));
        headers.insert(TRACEPARENT, trace::header(&trace.parent));
        if encrypted {
            headers.insert(STRICT_TRANSPORT_SECURITY, HeaderValue::from_static(ONLY_TLS));
        }
        if headers.contains_key(SET_COOKIE) {
            headers.insert(CACHE_CONTROL, HeaderValue::from_static(NO_STORE));
            let attribute = if encrypted { "; Secure" } else { "" };
            rewrite(headers, SET_COOKIE, |cookie| {
                let path = if self.base_path.is_empty() { "/" } else { &self.base_path };
                Some(cookie.replacen("; Path=/;", &format!("; Path={path};"), 1) + attribute)
            });
        }
        if !self.base_path.is_empty() {
            let is_own = |path: &str| path.starts_with('/') && !path.starts_with("//");
            rewrite(headers, LOCATION, |to| is_own(to).then(|| format!("{}{to}", self.base_path)));
            rewrite(headers, LINK, |link| {
                let to = link.strip_prefix('<')?;
                is_own(to).then(|| format!("<{}{to}", self.base_path))
            });
        }
    }
}

/// Replaces every value of a header for which there is another.
fn rewrite(headers: &mut HeaderMap, name: HeaderName, other: impl Fn(&str) -> Option<String>) {
    let axum::http::header::Entry::Occupied(mut entry) = headers.entry(name) else { return };
    for value in entry.iter_mut() {
        if let Some(new) = value.to_str().ok().and_then(&other).and_then(|new| HeaderValue::try_from(new).ok()) {
            *value = new;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(base_path: &str) -> Edge {
        Edge { trusted: Vec::new(), base_path: base_path.to_owned(), encrypted: false }
    }

    #[test]
    fn the_prefix_is_taken_off_where_it_is_there() {
        for (asked, served) in [
            ("/gyrowatch", Some("/")),
            ("/gyrowatch/", Some("/")),
            ("/gyrowatch?status=drifting", Some("/?status=drifting")),
            ("/gyrowatch/v1/gyros?limit=1", Some("/v1/gyros?limit=1")),
            ("/gyrowatch/gyrowatch", Some("/gyrowatch")),
            ("/gyrowatching", None),
            ("/v1/gyros", None),
        ] {
            let rest = edge("/gyrowatch").without_base(&asked.parse().unwrap());
            assert_eq!(rest.map(|uri| uri.to_string()).as_deref(), served, "{asked}");
        }
        assert_eq!(edge("").without_base(&"/v1/gyros".parse().unwrap()), None);
    }

    #[test]
    fn what_leads_to_this_service_leads_under_its_prefix() {
        let mut headers = HeaderMap::new();
        headers.insert(LOCATION, "/v1/records/1".parse().unwrap());
        headers.insert(LINK, "</v1/alerts?cursor=x>; rel=\"next\"".parse().unwrap());
        headers.append(SET_COOKIE, "a=b; Path=/; HttpOnly".parse().unwrap());
        headers.append(SET_COOKIE, "c=d; Path=/; HttpOnly".parse().unwrap());
        edge("/gyrowatch").finish(&mut headers, true, &Trace::of(&HeaderMap::new()));
        assert_eq!(headers[LOCATION], "/gyrowatch/v1/records/1");
        assert_eq!(headers[LINK], "</gyrowatch/v1/alerts?cursor=x>; rel=\"next\"");
        let cookies: Vec<_> = headers.get_all(SET_COOKIE).iter().collect();
        assert_eq!(cookies, ["a=b; Path=/gyrowatch; HttpOnly; Secure", "c=d; Path=/gyrowatch; HttpOnly; Secure"]);
        assert_eq!(headers[CACHE_CONTROL], "no-store");
        let mut elsewhere = HeaderMap::from_iter([(LOCATION, "https://b.example/".parse().unwrap())]);
        edge("/gyrowatch").finish(&mut elsewhere, false, &Trace::of(&HeaderMap::new()));
        assert_eq!(elsewhere[LOCATION], "https://b.example/");
        assert!(!elsewhere.contains_key(STRICT_TRANSPORT_SECURITY));
    }
}
