//! Who looks: in which language, light or dark. By the browser's word, or by what was chosen and is kept in a cookie.

use std::convert::Infallible;

use axum::extract::{FromRequestParts, Query};
use axum::http::header::{LOCATION, SET_COOKIE};
use axum::http::request::Parts;

use super::Pages;
use super::prelude::*;
use super::text::Language;
use crate::core::named::named;
use crate::pipeline::{Caller, Credential};
use crate::{cookies, words};

named! {
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Theme {
    Light = "light",
    Dark = "dark",
}
}

pub(super) struct Viewer {
    pub language: Language,
    /// None: as the system says.
    pub theme: Option<Theme>,
    /// What every path of this service begins with where they look.
    pub base_path: String,
    /// Path and query of the page that is looked at.
    pub here: String,
    /// The name of the token that they have signed in with.
    pub signed_in: Option<String>,
    /// What they may do; none for somebody who has not signed in where that is needed.
    pub role: Option<Role>,
}

impl Viewer {
    pub fn text(&self) -> &'static Text {
        self.language.text()
    }

    /// Whether what takes this role is offered to them: what would be refused is not.
    pub fn may(&self, role: Role) -> bool {
        self.role.is_some_and(|own| own >= role)
    }
}

impl FromRequestParts<Pages> for Viewer {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, pages: &Pages) -> Result<Self, Infallible> {
        let theme = cookies::sent(&parts.headers, "theme").and_then(Theme::from_name);
        let language = words::asked();
        let here = parts.uri.path_and_query().map_or("/", |here| here.as_str()).to_owned();
        let caller = parts.extensions.get::<Caller>();
        let session = caller.filter(|caller| matches!(caller.by, Credential::Session { .. }));
        let signed_in = session.map(|caller| caller.name.clone());
        let base_path = pages.config.server.base_path.clone();
        Ok(Self { language, theme, base_path, here, signed_in, role: caller.map(|caller| caller.role) })
    }
}

/// What every page may use, and who looks.
pub(super) struct PageContext(pub Pages, pub Viewer);

impl FromRequestParts<Pages> for PageContext {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, pages: &Pages) -> Result<Self, Infallible> {
        Ok(Self(pages.clone(), Viewer::from_request_parts(parts, pages).await?))
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct Preference {
    language: Option<String>,
    theme: Option<String>,
    /// Where to go on.
    back: Option<String>,
}

/// Keeps a choice in a cookie and goes back to where it was made.
pub(super) async fn prefer(Query(chosen): Query<Preference>) -> Response {
    let language = chosen.language.as_deref().and_then(Language::from_tag).map(|l| ("language", l.tag()));
    let theme = chosen.theme.as_deref().and_then(Theme::from_name).map(|theme| ("theme", theme.name()));
    let back = chosen.back.as_deref().filter(|back| is_local(back)).unwrap_or("/");
    let mut response = (StatusCode::SEE_OTHER, [(LOCATION, back)]).into_response();
    for (name, value) in language.into_iter().chain(theme) {
        let kept = format!("{name}={value}; Path=/; Max-Age=31536000; SameSite=Lax");
        response.headers_mut().append(SET_COOKIE, kept.parse().expect("names and values are plain ASCII"));
    }
    response
}

/// A path on this service: nobody is sent elsewhere.
pub(super) fn is_local(path: &str) -> bool {
    let plain = path.bytes().all(|byte| byte.is_ascii_graphic() && byte != b'\\');
    plain && path.starts_with('/') && !path.starts_with("//")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_is_sent_to_another_host() {
        assert!(is_local("/gyros/LFG-1?method=bench"));
        for elsewhere in ["//evil.example", "https://evil.example", "/\\evil.example", "", "gyros", "/a\r\nb"] {
            assert!(!is_local(elsewhere), "{elsewhere}");
        }
    }
}
