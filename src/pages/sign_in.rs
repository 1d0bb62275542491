//! Signing in with a token, and out again.

use std::net::SocketAddr;

use axum::extract::{ConnectInfo, State as Held};
use axum::http::header::{LOCATION, RETRY_AFTER, SET_COOKIE, USER_AGENT};
use axum::http::{HeaderMap, HeaderValue};

use super::prelude::*;
use super::viewer::is_local;
use crate::pipeline::{Caller, Denied, SESSION_COOKIE};

#[derive(Debug, Deserialize)]
pub(super) struct SignInQuery {
    back: Option<String>,
    /// The role that the page takes from which somebody was sent here.
    takes: Option<String>,
}

#[derive(Deserialize)]
pub(super) struct SignInForm {
    token: String,
    back: Option<String>,
}

pub(super) async fn page(viewer: Viewer, Query(asked): Query<SignInQuery>) -> Page {
    let t = viewer.text();
    let lacking =
        asked.takes.as_deref().and_then(Role::from_name).map(|role| format!("{}{}", t.takes_role, t.role(role)));
    form(t, asked.back.as_deref(), lacking.as_deref())
}

/// Takes the token for a cookie that no script reads and no other site's page has sent along.
pub(super) async fn enter(
    Held(pages): Held<Pages>,
    viewer: Viewer,
    ConnectInfo(peer): ConnectInfo<SocketAddr>,
    headers: HeaderMap,
    Form(shown): Form<SignInForm>,
) -> Response {
    let back = shown.back.as_deref().filter(|back| is_local(back)).unwrap_or("/");
    let t = viewer.text();
    let agent = headers.get(USER_AGENT).and_then(|sent| Caller::agent(sent.as_bytes()));
    match pages.pipeline.access.sign_in(&shown.token, peer.ip(), agent).await {
        Ok(Ok(signed_in)) => {
            let cookie = session_cookie(&signed_in.cookie.reveal(), signed_in.seconds);
            (StatusCode::SEE_OTHER, [(LOCATION, header(back)), (SET_COOKIE, header(&cookie))]).into_response()
        }
        Ok(Err(Denied::TooManyFailures { wait } | Denied::TooManyRequests { wait })) => {
            let after = [(RETRY_AFTER, HeaderValue::from(wait.as_secs().max(1)))];
            let page = form(t, Some(back), Some(t.too_many_tokens));
            (StatusCode::TOO_MANY_REQUESTS, after, page).into_response()
        }
        Ok(Err(_)) => (StatusCode::UNAUTHORIZED, form(t, Some(back), Some(t.wrong_token))).into_response(),
        Err(refused) => Problem::new(503, "title_try_again", refused.message()).into_response(),
    }
}

pub(super) async fn leave(Held(pages): Held<Pages>) -> Response {
    match pages.pipeline.access.sign_out().await {
        Ok(()) => {
            let gone = session_cookie("", 0);
            (StatusCode::SEE_OTHER, [(LOCATION, header("/sign-in")), (SET_COOKIE, header(&gone))]).into_response()
        }
        Err(refused) => Problem::new(503, "title_try_again", refused.message()).into_response(),
    }
}

fn session_cookie(value: &str, seconds: i64) -> String {
    format!("{SESSION_COOKIE}={value}; Path=/; Max-Age={seconds}; HttpOnly; SameSite=Strict")
}

fn header(text: &str) -> HeaderValue {
    HeaderValue::from_str(text).unwrap_or_else(|_| HeaderValue::from_static("/"))
}

fn form(t: &Text, back: Option<&str>, fault: Option<&str>) -> Page {
    let body = html! {
        h1 { (t.sign_in) }
        p.lead { (t.sign_in_note) }
        @if let Some(fault) = fault { p.fault role="alert" { (fault) } }
        form.sign-in action="/sign-in" method="post" {
            label { (t.token) " " input type="password" name="token" autocomplete="current-password" required autofocus; }
            @if let Some(back) = back { input type="hidden" name="back" value=(back); }
            button.primary { (t.sign_in) }
        }
    };
    Page { title: t.sign_in.into(), section: Section::None, body }
}
