//! Who may do what: every request passes here before it is handled.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use axum::extract::{ConnectInfo, MatchedPath, Request};
use axum::http::header::{
    ACCEPT, AUTHORIZATION, CACHE_CONTROL, HOST, ORIGIN, RETRY_AFTER, USER_AGENT, WWW_AUTHENTICATE,
};
use axum::http::uri::Authority;
use axum::http::{HeaderName, HeaderValue, Method};
use axum::middleware::Next;

use super::edge::{Forwarded, NO_STORE};
use crate::cookies;
use crate::http::prelude::*;
use crate::pipeline::{Caller, Credential, Denied, SESSION_COOKIE};
use crate::routes::{ADMIN, ANYONE, Rules, VIEWER};

/// What decides about a request before it is handled.
#[derive(Clone)]
pub struct Gate {
    pub app: App,
    pub rules: Arc<Rules>,
}

/// Lets a request through to its handler as its caller, or answers it 400, 401, 403, 421 or 429.
pub async fn admit(Gate { app, rules }: &Gate, mut request: Request, next: Next) -> Response {
    let Some(route) = request.extensions().get::<MatchedPath>().cloned() else {
        return next.run(request).await; // Nothing is there: the fallback says so.
    };
    // A method that the route does not take: its handler says so, to whoever may read at all.
    let least = rules.get(request.method(), route.as_str()).unwrap_or(VIEWER);
    let origin = RequestOrigin::of(request.method(), request.headers());
    let source = request.extensions().get::<ConnectInfo<SocketAddr>>().map(|ConnectInfo(peer)| peer.ip());
    // Without an address (a request that came over no connection) it is nobody's, and certainly not this machine's.
    let source = source.unwrap_or(IpAddr::V4(Ipv4Addr::UNSPECIFIED));
    if request.extensions().get::<Forwarded>().is_some() {
        app.pipeline.access.guard().note_proxy();
    }
    let headers = request.headers();
    let credentials = (bearer(headers), cookies::sent(headers, SESSION_COOKIE));
    let caller = match app.pipeline.access.guard().caller(credentials, source, app.clock.now()).await {
        Ok(caller) => {
            Caller { agent: headers.get(USER_AGENT).and_then(|sent| Caller::agent(sent.as_bytes())), ..caller }
        }
        Err(_) if least == ANYONE && origin != RequestOrigin::Foreign => return next.run(request).await,
        Err(_) if least == ANYONE => return foreign().into_response(),
        Err(denied) => return refuse(&denied, &request),
    };
    if matches!(caller.by, Credential::Presence) && !is_probed(route.as_str()) && !names_this_machine(headers) {
        return Problem::new(421, "title_other_name", message!("other_name")).into_response();
    }
    let by_cookie = matches!(caller.by, Credential::Session { .. });
    let by_token = matches!(caller.by, Credential::Token(_) | Credential::Setup);
    // A page of another site can make a browser send its cookie, or reach this machine; it cannot make it send a token.
    if (origin == RequestOrigin::Foreign && !by_token) || (origin == RequestOrigin::Unsaid && by_cookie) {
        return foreign().into_response();
    }
    if let Some(role) = least.filter(|role| caller.role < *role) {
        if by_cookie && wants_page(&request) {
            let place = format!("{}&takes={}", sign_in_for(request.uri()), role.name());
            return (StatusCode::SEE_OTHER, [(LOCATION, place)]).into_response();
        }
        if matches!(caller.by, Credential::Presence) {
            // Nobody has shown who they are, and a proxy on this machine lets everybody in.
            let detail = message!("first_token_needed", role = role.name());
            return challenged(Problem::new(401, "title_token_needed", detail), "Bearer realm=\"gyrowatch\"");
        }
        let detail = message!("role_needed", needed = role.name(), role = caller.role.name());
        return challenged(Problem::new(403, "title_not_allowed", detail), "Bearer error=\"insufficient_scope\"");
    }
    if let Some(takes) = rules.takes(request.method(), route.as_str()).filter(|_| route.as_str().starts_with("/v1/"))
        && let Some(refused) = query::not_taken(takes, &request)
    {
        return refused.into_response();
    }
    request.extensions_mut().insert(caller.clone());
    let mut response = caller.during(next.run(request)).await;
    if least == ADMIN {
        // Secrets are shown there.
        response.headers_mut().insert(CACHE_CONTROL, HeaderValue::from_static(NO_STORE));
    }
    response
}

/// What watches a service asks these, under whatever name it knows it by; they tell nothing of what is measured.
fn is_probed(route: &str) -> bool {
    ["/healthz", "/readyz", "/metrics"].contains(&route)
}

/// Whether a request that changes something was sent by a page of this service.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RequestOrigin {
    Own,
    Foreign,
    /// No browser, or an old one.
    Unsaid,
}

impl RequestOrigin {
    /// By the browser's word, which no page can forge. What changes nothing may come from anywhere.
    fn of(method: &Method, headers: &HeaderMap) -> Self {
        if method.is_safe() {
            return Self::Own;
        }
        let text = |name: HeaderName| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
        match (text(HeaderName::from_static("sec-fetch-site")), text(ORIGIN)) {
            (Some("same-origin" | "none"), _) => Self::Own,
            (None, Some(origin)) if origin.split_once("://").map(|(_, host)| host) == text(HOST) => Self::Own,
            (None, None) => Self::Unsaid,
            _ => Self::Foreign,
        }
    }
}

fn foreign() -> Problem {
    Problem::new(403, "title_foreign_page", message!("foreign_page"))
}

/// Whether a request is for this machine by the name it uses. Any site can let its own name lead here, and to a
/// browser its page is then one of this service: only the name tells. What names no host comes from no browser.
fn names_this_machine(headers: &HeaderMap) -> bool {
    let Some(host) = headers.get(HOST) else { return true };
    let Ok(authority) = Authority::try_from(host.as_bytes()) else { return false };
    let name = authority.host().trim_start_matches('[').trim_end_matches(']');
    let is_loopback = |address: IpAddr| address.to_canonical().is_loopback();
    name.eq_ignore_ascii_case("localhost") || name.parse().is_ok_and(is_loopback)
}

/// The token of `Authorization: Bearer`.
fn bearer(headers: &HeaderMap) -> Option<&str> {
    let (scheme, token) = headers.get(AUTHORIZATION)?.to_str().ok()?.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| token.trim())
}

/// Whether a person looks at a page.
fn wants_page(request: &Request) -> bool {
    let accepts = request.headers().get(ACCEPT).and_then(|accept| accept.to_str().ok());
    request.method() == Method::GET && accepts.is_some_and(|accept| accept.contains("text/html"))
}

/// A person who looks at a page is sent to where to sign in; everybody else is told why.
fn refuse(denied: &Denied, request: &Request) -> Response {
    let could_sign_in = matches!(denied, Denied::NoToken | Denied::SignedOut | Denied::Revoked | Denied::Expired);
    if wants_page(request) && could_sign_in && bearer(request.headers()).is_none() {
        return (StatusCode::SEE_OTHER, [(LOCATION, sign_in_for(request.uri()))]).into_response();
    }
    let problem = denied.problem();
    match denied {
        Denied::NoToken | Denied::SignedOut => challenged(problem, "Bearer realm=\"gyrowatch\""),
        Denied::Wrong | Denied::Revoked | Denied::Expired => {
            challenged(problem, "Bearer realm=\"gyrowatch\", error=\"invalid_token\"")
        }
        Denied::TooManyFailures { wait } | Denied::TooManyRequests { wait } => later(problem, *wait),
        Denied::NotHere | Denied::Proxied | Denied::Unreadable => problem.into_response(),
    }
}

fn sign_in_for(uri: &Uri) -> String {
    let here = uri.path_and_query().map_or("/", |here| here.as_str());
    let back = url::form_urlencoded::byte_serialize(here.as_bytes()).collect::<String>();
    format!("/sign-in?back={back}")
}

fn challenged(problem: Problem, challenge: &'static str) -> Response {
    let mut response = problem.into_response();
    response.headers_mut().insert(WWW_AUTHENTICATE, HeaderValue::from_static(challenge));
    response
}

fn later(problem: Problem, wait: Duration) -> Response {
    let mut response = problem.into_response();
    let seconds = wait.as_secs_f64().ceil().max(1.0) as u64;
    response.headers_mut().insert(RETRY_AFTER, HeaderValue::from(seconds));
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(method: Method, headers: &[(&'static str, &str)]) -> RequestOrigin {
        let mut map = HeaderMap::new();
        map.insert(HOST, "gyros.example:8080".parse().unwrap());
        for (name, value) in headers {
            map.insert(*name, value.parse().unwrap());
        }
        RequestOrigin::of(&method, &map)
    }

    #[test]
    fn only_pages_of_this_service_change_anything_with_a_browsers_hands() {
        for (headers, expected) in [
            (&[][..], RequestOrigin::Unsaid),
            (&[("sec-fetch-site", "same-origin")], RequestOrigin::Own),
            (&[("sec-fetch-site", "cross-site")], RequestOrigin::Foreign),
            (&[("sec-fetch-site", "same-site")], RequestOrigin::Foreign),
            (&[("origin", "https://gyros.example:8080")], RequestOrigin::Own),
            (&[("origin", "https://evil.example")], RequestOrigin::Foreign),
            (&[("origin", "null")], RequestOrigin::Foreign),
            (&[("sec-fetch-site", "cross-site"), ("origin", "https://gyros.example:8080")], RequestOrigin::Foreign),
        ] {
            assert_eq!(origin(Method::POST, headers), expected, "{headers:?}");
            assert_eq!(origin(Method::GET, headers), RequestOrigin::Own, "{headers:?}");
        }
    }

    #[test]
    fn this_machine_is_named_by_localhost_and_by_its_loopback_addresses() {
        let named = |host: &str| names_this_machine(&HeaderMap::from_iter([(HOST, host.parse().unwrap())]));
        for host in
            ["localhost", "LocalHost:8080", "127.0.0.1", "127.9.9.9:1", "[::1]", "[::1]:8080", "[::ffff:127.0.0.1]"]
        {
            assert!(named(host), "{host}");
        }
        for host in [
            "evil.example:8080",
            "localhost.evil.example",
            "localhost@evil.example",
            "127.0.0.1.evil.example",
            "192.168.1.5:8080",
            "[fe80::1]",
            "0.0.0.0",
            "[::1",
            "",
        ] {
            assert!(!named(host), "{host}");
        }
        assert!(names_this_machine(&HeaderMap::new()), "no browser leaves it out");
    }
}
