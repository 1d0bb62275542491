//! The frame of every page, and how pages and failures leave.

use axum::Extension;
use axum::extract::Request;
use axum::http::StatusCode;
use axum::http::header::{
    CACHE_CONTROL, CONTENT_LANGUAGE, CONTENT_SECURITY_POLICY, CONTENT_TYPE, REFERRER_POLICY, RETRY_AFTER, VARY,
    X_CONTENT_TYPE_OPTIONS,
};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, Render, html};

use super::assets::{SCRIPT, STYLE};
use super::text::Text;
use super::viewer::{Theme, Viewer};
use crate::core::access::Role;
use crate::core::effects::Effect;
use crate::core::judge::Coefficient;
use crate::core::time::UtcMicros;
use crate::system;
use crate::wire::note::NoteBody;
use crate::wire::problem::Problem;
pub(super) use crate::wire::text::encoded;
use crate::wire::time;

/// Nothing is loaded from elsewhere, nothing inline runs and nothing inline is a style. Pictures that are saved are made
/// from data of their own.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
                      connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'";

/// Attributes that hold an address.
const LEADING: [&str; 4] = ["href", "src", "action", "formaction"];

/// A page, which leaves within its frame.
#[derive(Clone)]
pub(super) struct Page {
    pub title: String,
    /// Which entry of the navigation it belongs to.
    pub section: Section,
    pub body: Markup,
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(super) enum Section {
    Today,
    Fleet,
    Alerts,
    Diagnoses,
    Stations,
    Import,
    Hooks,
    Book,
    Api,
    Setup,
    #[default]
    None,
}

impl IntoResponse for Page {
    fn into_response(self) -> Response {
        Extension(self).into_response()
    }
}

/// Puts the page that a handler answers, or in words why there is none, into its frame.
pub(super) async fn framed(viewer: Viewer, request: Request, next: Next) -> Response {
    let (mut parts, body) = next.run(request).await.into_parts();
    let page = match (parts.extensions.remove::<Page>(), parts.extensions.remove::<Problem>()) {
        (Some(page), _) => page,
        (None, Some(problem)) => {
            // Those are for programs.
            for name in [CONTENT_LANGUAGE, RETRY_AFTER] {
                parts.headers.remove(name);
            }
            viewer.failure(&problem)
        }
        (None, None) => return Response::from_parts(parts, body),
    };
    let (head, body) = viewer.leave(parts.status, &page, None).into_parts();
    parts.headers.extend(head.headers);
    Response::from_parts(parts, body)
}

impl Viewer {
    /// The page with what it is about and a number on every sheet of paper. Of several, parts of the page with the
    /// classes `about0`, `about1` … are about each.
    pub fn show_for_paper(&self, page: &Page, about: &[&str]) -> Response {
        self.leave(StatusCode::OK, page, Some(&sheets(about)))
    }

    /// `style`: rules of this page alone, which the policy names by their hash.
    fn leave(&self, status: StatusCode, page: &Page, style: Option<&str>) -> Response {
        let policy = match style {
            Some(style) => {
                let hash = BASE64_STANDARD.encode(system::sha256(style.as_bytes()));
                POLICY.replace("style-src 'self'", &format!("style-src 'self' 'sha256-{hash}'"))
            }
            None => POLICY.to_owned(),
        };
        let head = [
            (CONTENT_TYPE, "text/html; charset=utf-8"),
            (CONTENT_SECURITY_POLICY, policy.as_str()),
            (X_CONTENT_TYPE_OPTIONS, "nosniff"),
            (REFERRER_POLICY, "same-origin"),
            (CACHE_CONTROL, "no-cache"),
            (VARY, "accept-language, cookie"),
        ];
        (status, head, self.under_base(self.document(page, style).into_string())).into_response()
    }

    /// Has whatever leads to this service lead under its prefix. In text and values quotation marks are escaped, so
    /// only attributes match.
    fn under_base(&self, document: String) -> String {
        if self.base_path.is_empty() {
            return document;
        }
        LEADING.iter().fold(document, |document, attribute| {
            document.replace(&format!(" {attribute}=\"/"), &format!(" {attribute}=\"{}/", self.base_path))
        })
    }

    fn failure(&self, problem: &Problem) -> Page {
        let t = self.text();
        let body = html! {
            h1 { (t.error_title) }
            // What is wrong with a document stands below, place by place.
            @if problem.places.is_empty() { p.lead { (t.words(&problem.message)) } }
            @if !problem.places.is_empty() {
                ul { @for place in &problem.places { li { code { (place.pointer) } " " (t.words(&place.message)) } } }
            }
            p { a href="/fleet" { (t.error_back) } }
        };
        Page { title: t.error_title.into(), section: Section::None, body }
    }

    fn document(&self, page: &Page, style: Option<&str>) -> Markup {
        let t = self.text();
        let entry = |path: &str, name: &str, section: Section| {
            html! { a href=(path) aria-current=[(page.section == section).then_some("page")] { (name) } }
        };
        html! {
            (DOCTYPE)
            html lang=(self.language.tag()) data-theme=[self.theme.map(Theme::name)] {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (page.title) " · gyrowatch" }
                    link rel="icon" href="data:,";
                    link rel="stylesheet" href=(STYLE.path);
                    @if let Some(style) = style { style { (PreEscaped(style)) } }
                    script src=(SCRIPT.path) defer {}
                }
                body {
                    a.skip href="#content" { (t.skip) }
                    header.bar {
                        a.name href="/" { "gyrowatch" }
                        nav aria-label=(t.navigation) {
                            (entry("/", t.today_title, Section::Today))
                            (entry("/fleet", t.fleet, Section::Fleet))
                            (entry("/alerts", t.alerts, Section::Alerts))
                            (entry("/diagnoses", t.diagnoses, Section::Diagnoses))
                            (entry("/stations", t.stations, Section::Stations))
                            @if self.may(Role::Station) { (entry("/import", t.import, Section::Import)) }
                            @if self.may(Role::Engineer) { (entry("/hooks", t.hooks, Section::Hooks)) }
                            (entry("/book", t.book, Section::Book))
                            @if self.may(Role::Engineer) { (entry("/setup", t.setup, Section::Setup)) }
                            (entry("/docs", t.api, Section::Api))
                        }
                        form.find role="search" aria-label=(t.find_hint) action="/find" method="get" {
                            input #find type="search" name="q" placeholder=(t.find_short) aria-label=(t.find_hint) title=(t.find_hint);
                        }
                        (self.switches())
                    }
                    main #content { (page.body) }
                }
            }
        }
    }

    /// Language, and light or dark: links that a cookie remembers.
    fn switches(&self) -> Markup {
        let t = self.text();
        let other = match self.language {
            super::text::Language::English => "zh",
            super::text::Language::Chinese => "en",
        };
        let to = |key: &str, value: &str| format!("/preference?{key}={value}&back={}", encoded(&self.here));
        html! {
            div.switches {
                a href=(to("language", other)) lang=(other) { (t.other_language) }
                a.to-dark href=(to("theme", "dark")) { (t.dark) }
                a.to-light href=(to("theme", "light")) { (t.light) }
                span.quiet #zone title=(t.times_are_in) { "UTC" }
                @if let Some(name) = &self.signed_in {
                    span.who translate="no" { (name) }
                    @if let Some(role) = self.role { span.quiet { (t.role(role)) } }
                    form.sign-out action="/sign-out" method="post" { button { (t.sign_out) } }
                }
            }
        }
    }
}

/// Rules that put a name and the page's number on every sheet. Every character of the name but letters and digits as
/// an escape, so that it can end neither the string nor the element.
fn sheets(about: &[&str]) -> String {
    let escaped = |c: char| if c.is_ascii_alphanumeric() { c.to_string() } else { format!("\\{:x} ", u32::from(c)) };
    let foot = |about: &str| {
        let about: String = about.chars().map(escaped).collect();
        format!(
            "{{ @bottom-left {{ content: \"{about}\"; font-size: 8pt; }} \
             @bottom-right {{ content: counter(page) \" / \" counter(pages); font-size: 8pt; }} }}"
        )
    };
    match about {
        [about] => format!("@page {}", foot(about)),
        several => {
            let part =
                |(k, about): (usize, &&str)| format!("@page about{k} {} .about{k} {{ page: about{k}; }} ", foot(about));
            several.iter().enumerate().map(part).collect()
        }
    }
}

/// An instant: in UTC as it stands, in the viewer's zone once the script has run.
pub(super) fn instant(at: UtcMicros) -> Markup {
    let utc = time::format(at);
    let shown = format!("{} {}", &utc[..utc.find('T').unwrap_or(utc.len())], clock(&utc));
    html! { time datetime=(utc) title=(utc) { (shown) } }
}

/// The day of an instant: in UTC as it stands, in the viewer's zone once the script has run.
pub(super) fn day(at: UtcMicros) -> Markup {
    let utc = time::format(at);
    html! { time datetime=(utc) title=(utc) data-day { (&utc[..utc.find('T').unwrap_or(utc.len())]) } }
}

/// Hours and minutes of an RFC 3339 time, with what they are counted in.
pub(super) fn clock(utc: &str) -> String {
    let start = utc.find('T').map_or(utc.len(), |at| at + 1);
    format!("{} UTC", utc.get(start..start + 5).unwrap_or_default())
}

/// A time as the service writes it on the wire.
pub(super) fn written(text: &str) -> Markup {
    time::parse(text).map_or_else(|_| html! { (text) }, instant)
}

/// The day of a time as the service writes it on the wire.
pub(super) fn written_day(text: &str) -> Markup {
    time::parse(text).map_or_else(|_| html! { (text) }, day)
}

/// `a=1&b=2`: those that have a value.
pub(super) fn query<'a>(all: impl IntoIterator<Item = (&'a str, &'a str)>) -> String {
    let given = all.into_iter().filter(|(_, value)| !value.is_empty());
    given.map(|(key, value)| format!("{key}={}", encoded(value))).collect::<Vec<_>>().join("&")
}

/// Who said something, and why, where they said that.
pub(super) fn remark(said_by: &str, by: &str, reason: &str) -> Markup {
    let reason = if reason.is_empty() { String::new() } else { format!(": {reason}") };
    html! { br; span.quiet { (said_by) " " span translate="no" { (by) (reason) } } }
}

/// A dash for what there is nothing of.
pub(super) fn or_dash(said: Option<impl Render>) -> Markup {
    html! { @if let Some(said) = said { (said) } @else { "–" } }
}

/// One after the other, with something between them.
pub(super) fn joined(between: &str, all: impl IntoIterator<Item = impl Render>) -> Markup {
    html! { @for (k, one) in all.into_iter().enumerate() { @if k > 0 { (between) } (one) } }
}

/// What was noticed of a record when it came.
pub(super) fn noted(t: &Text, notes: &[NoteBody]) -> Markup {
    html! {
        @if !notes.is_empty() {
            section.notes {
                h3 { (t.notes) }
                ul { @for note in notes { li { (note.detail) } } }
            }
        }
    }
}

/// What is separated, in the order of the figures.
pub(super) const DRIFTS: [&str; 3] = ["D_I", "D_S", "D_O"];

/// `D_I` with its index set low; nothing for `all`, the gyro as a whole.
pub(super) fn symbol(name: &str) -> Markup {
    if name == Coefficient::All.name() {
        return html! {};
    }
    match name.split_once('_') {
        Some((letter, index)) => html! { var { (letter) sub { (index) } } },
        None => html! { var { (name) } },
    }
}

/// The name of a coefficient's figure in its cell, where the table is a list (a telephone).
pub(super) fn label(words: &str, name: &str) -> Markup {
    html! { span.label { (words) " " (symbol(name)) } " " }
}

/// A sentence in which the coefficients stand as [`symbol`] has them.
pub(super) fn with_symbols(sentence: &str) -> Markup {
    let first = DRIFTS.into_iter().filter_map(|name| Some((sentence.find(name)?, name))).min();
    match first {
        Some((at, name)) => html! { (sentence[..at]) (symbol(name)) (with_symbols(&sentence[at + name.len()..])) },
        None => html! { (sentence) },
    }
}

/// An effect by its name in words, with the identifier that the interface uses.
pub(super) fn effect_named(t: &Text, id: &str) -> Markup {
    html! { @if let Some(effect) = Effect::from_id(id) { (t.effect(effect)) " " } code.quiet { (id) } }
}

/// An effect by its name in words; one that is not of the catalogue by its identifier.
pub(super) fn effect_word<'a>(t: &'a Text, id: &'a str) -> &'a str {
    Effect::from_id(id).map_or(id, |effect| t.effect(effect))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_gyro_is_called_ends_neither_a_string_nor_a_style() {
        assert!(sheets(&["LFG-1"]).starts_with("@page { @bottom-left { content: \"LFG\\2d 1\";"));
        let several = sheets(&["A", "B"]);
        assert!(several.contains("@page about1 { @bottom-left { content: \"B\";"), "{several}");
        assert!(several.contains(".about1 { page: about1; }"), "{several}");
        let evil = sheets(&["a\"}</style><script>\\"]);
        assert!(!evil.contains('<') && evil.matches('"').count() == 4, "{evil}");
    }

    #[test]
    fn coefficients_in_a_sentence_have_their_index_set_low() {
        let shown = with_symbols("D_S and D_I are < D_X.").into_string();
        let [s, i] = ["S", "I"].map(|index| format!("<var>D<sub>{index}</sub></var>"));
        assert_eq!(shown, format!("{s} and {i} are &lt; D_X."));
    }

    #[test]
    fn instants_are_written_to_the_minute_and_kept_whole() {
        let at = time::parse("2026-03-01T08:05:30.25Z").unwrap();
        let written = instant(at).into_string();
        assert_eq!(
            written,
            r#"<time datetime="2026-03-01T08:05:30.25Z" title="2026-03-01T08:05:30.25Z">2026-03-01 08:05 UTC</time>"#
        );
    }
}
