//! `/book`: the documentation, `docs/` as its SUMMARY.md orders it, rendered here and whole without a network.
//!
//! Markdown that is not this repository's own never comes here; raw HTML in it (comments) is left out all the same. An
//! address of another host is shown and not linked, for the machine that shows the book may have no way there.

use std::collections::HashMap;
use std::sync::LazyLock;

use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, X_CONTENT_TYPE_OPTIONS};
use maud::PreEscaped;
use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, html as written};

use super::prelude::*;

const SUMMARY: &str = include_str!("../../docs/SUMMARY.md");
const FIGURE: (&str, &str) = ("figures/paper-experiment.svg", include_str!("../../docs/figures/paper-experiment.svg"));
/// What a page may hold of another file, as mdBook writes it.
const INCLUDED: (&str, &str) = ("{{#include ../config/default.toml}}", include_str!("../../config/default.toml"));

macro_rules! sources {
    ($($name:literal)*) => {
        /// Text of every page by its path below `docs/`, without the ending. A test holds it against SUMMARY.md.
        const SOURCES: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../docs/", $name, ".md")))),*];
    };
}

sources! {
    "introduction"
    "tutorials/first-alert" "tutorials/own-csv" "tutorials/adopt-predict-compare"
    "how-to/install" "how-to/nginx" "how-to/postgresql" "how-to/monitoring" "how-to/hooks" "how-to/backup"
    "how-to/new-station" "how-to/repaired-gyro" "how-to/own-hypothesis" "how-to/extend"
    "commands" "api" "formats" "configuration" "judging" "alerts" "findings" "pages" "operations" "routes"
    "integrations" "stations" "model"
    "method" "limits" "fit" "diagnosis" "histories" "simulation" "architecture" "decisions" "performance" "reliability"
    "glossary" "troubleshooting"
    "zh/first-alert" "zh/own-csv" "zh/adopt-predict-compare" "zh/glossary"
}

/// A part of SUMMARY.md: its title and (title, page) of what it lists.
struct Part {
    title: &'static str,
    pages: Vec<(&'static str, &'static str)>,
}

static PARTS: LazyLock<Vec<Part>> = LazyLock::new(|| parts(SUMMARY));
static RENDERED: LazyLock<HashMap<&'static str, Rendered>> =
    LazyLock::new(|| SOURCES.iter().map(|&(name, source)| (name, Rendered::of(name, source))).collect());

/// The first page, which says who begins where.
pub(super) async fn first(viewer: Viewer) -> Result<Page, Problem> {
    page("introduction", viewer.text())
}

/// Any page, or the figure of one.
pub(super) async fn one(Path(name): Path<String>, viewer: Viewer) -> Response {
    if name == FIGURE.0 {
        let head = [
            (CONTENT_TYPE, "image/svg+xml"),
            (CONTENT_SECURITY_POLICY, "default-src 'none'"),
            (X_CONTENT_TYPE_OPTIONS, "nosniff"),
            (CACHE_CONTROL, "no-cache"),
        ];
        return (head, FIGURE.1).into_response();
    }
    page(&name, viewer.text()).into_response()
}

fn page(name: &str, t: &Text) -> Result<Page, Problem> {
    let no_such = || Problem::new(404, "title_no_such_page", message!("no_such_path", path = format!("/book/{name}")));
    let rendered = RENDERED.get(name).ok_or_else(no_such)?;
    let order: Vec<_> = PARTS.iter().flat_map(|part| &part.pages).collect();
    let at = order.iter().position(|(_, listed)| *listed == name);
    let beside = |step: isize| at.and_then(|at| order.get(at.checked_add_signed(step)?).copied());
    let body = html! {
        div.book {
            nav.contents aria-label=(t.contents) { details open {
                summary { (t.contents) }
                (contents(name))
                ul { li { a href="/docs" { (t.api) } } }
            } }
            article lang=(language(name)) {
                (PreEscaped(&rendered.body))
                p.pager {
                    @if let Some((title, to)) = beside(-1) { a rel="prev" href={ "/book/" (to) } { "← " (title) } }
                    @if let Some((title, to)) = beside(1) { a rel="next" href={ "/book/" (to) } { (title) " →" } }
                }
            }
        }
    };
    Ok(Page { title: rendered.title.clone(), section: Section::Book, body })
}

fn language(name: &str) -> &'static str {
    if name.starts_with("zh/") { "zh" } else { "en" }
}

fn contents(here: &str) -> Markup {
    html! {
        @for part in PARTS.iter() {
            @let english = part.title.is_ascii().then_some("en");
            @if !part.title.is_empty() { p.quiet lang=[english] { (part.title) } }
            ul { @for (title, name) in &part.pages {
                @let current = (*name == here).then_some("page");
                li { a href={ "/book/" (name) } lang=(language(name)) aria-current=[current] { (title) } }
            } }
        }
    }
}

/// Titles and pages of a SUMMARY.md: headings begin a part, links are its pages.
fn parts(summary: &'static str) -> Vec<Part> {
    let mut parts = vec![Part { title: "", pages: Vec::new() }];
    for line in summary.lines().skip(1) {
        if let Some(title) = line.strip_prefix("# ") {
            parts.push(Part { title, pages: Vec::new() });
        } else if let Some((title, rest)) = line.split_once('[').and_then(|(_, link)| link.split_once("](")) {
            let name = rest.trim_end_matches(')').trim_end_matches(".md");
            parts.last_mut().expect("there is a first part").pages.push((title, name));
        }
    }
    parts
}

struct Rendered {
    title: String,
    body: String,
}

impl Rendered {
    fn of(name: &str, source: &str) -> Self {
        let source = source.replace(INCLUDED.0, INCLUDED.1);
        let events: Vec<_> = Parser::new_ext(&source, Options::ENABLE_TABLES).collect();
        let mut anchors = Anchors::default();
        let (mut title, mut out, mut leads_away) = (String::new(), Vec::new(), None);
        for (at, event) in events.iter().enumerate() {
            match event {
                Event::Html(_)
                | Event::InlineHtml(_)
                | Event::Start(Tag::HtmlBlock)
                | Event::End(TagEnd::HtmlBlock) => {}
                Event::Start(Tag::Heading { level, .. }) => {
                    let heading = text_of(&events[at + 1..]);
                    out.push(raw(format!("<{level} id=\"{}\">", anchors.next(&heading))));
                    if *level == HeadingLevel::H1 {
                        title = heading;
                    }
                }
                Event::Start(Tag::Table(_)) => {
                    out.push(raw("<div class=\"scroll\" tabindex=\"0\">".into()));
                    out.push(event.clone());
                }
                Event::End(TagEnd::Table) => {
                    out.push(event.clone());
                    out.push(raw("</div>".into()));
                }
                Event::Start(Tag::CodeBlock(_)) => out.push(raw("<pre tabindex=\"0\"><code>".into())),
                Event::End(TagEnd::CodeBlock) => out.push(raw("</code></pre>\n".into())),
                Event::Start(Tag::Link { dest_url, .. }) if dest_url.contains("://") => {
                    leads_away = Some(dest_url.to_string());
                }
                Event::Start(Tag::Link { .. } | Tag::Image { .. }) => {
                    let mut event = event.clone();
                    if let Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) = &mut event {
                        *dest_url = CowStr::from(address(name, dest_url));
                    }
                    out.push(event);
                }
                Event::End(TagEnd::Link) => match leads_away.take() {
                    // An address that stands for itself is shown already.
                    Some(to) if matches!(&events[at - 1], Event::Text(shown) if **shown == *to) => {}
                    Some(to) => out.push(Event::Text(CowStr::from(format!(" ({to})")))),
                    None => out.push(event.clone()),
                },
                other => out.push(other.clone()),
            }
        }
        let mut body = String::new();
        written::push_html(&mut body, out.into_iter());
        Self { title, body }
    }
}

fn raw(html: String) -> Event<'static> {
    Event::Html(CowStr::from(html))
}

/// The words up to the end of what has just begun.
fn text_of(events: &[Event<'_>]) -> String {
    let words = events.iter().take_while(|event| !matches!(event, Event::End(TagEnd::Heading(_))));
    words.filter_map(|event| if let Event::Text(t) | Event::Code(t) = event { Some(&**t) } else { None }).collect()
}

/// Where a link of page `from` leads: `../formats.md#geometry` to `/book/formats#geometry`.
fn address(from: &str, link: &str) -> String {
    let (path, anchor) = link.split_once('#').map_or((link, None), |(path, anchor)| (path, Some(anchor)));
    let anchor = anchor.map(|anchor| format!("#{anchor}")).unwrap_or_default();
    if path.is_empty() {
        return anchor;
    }
    let mut segments: Vec<&str> = from.split('/').collect();
    segments.pop();
    for segment in path.split('/') {
        match segment {
            ".." => drop(segments.pop()),
            segment => segments.push(segment),
        }
    }
    format!("/book/{}{anchor}", segments.join("/").trim_end_matches(".md"))
}

/// Names of headings as GitHub makes them, so that a link holds there and here.
#[derive(Default)]
struct Anchors(HashMap<String, usize>);

impl Anchors {
    fn next(&mut self, heading: &str) -> String {
        let kept =
            heading.to_lowercase().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>();
        let name = kept.replace(' ', "-");
        let seen = self.0.entry(name.clone()).or_default();
        *seen += 1;
        if *seen == 1 { name } else { format!("{name}-{}", *seen - 1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attributes<'a>(html: &'a str, name: &str) -> Vec<&'a str> {
        let opening = format!(" {name}=\"");
        let starts: Vec<_> = html.match_indices(&opening).map(|(at, found)| at + found.len()).collect();
        starts.into_iter().map(|at| html[at..].split('"').next().unwrap()).collect()
    }

    #[test]
    fn every_entry_of_the_summary_is_a_page_and_every_page_an_entry() {
        let mut listed: Vec<_> = PARTS.iter().flat_map(|part| part.pages.iter().map(|(_, name)| *name)).collect();
        let mut held: Vec<_> = SOURCES.iter().map(|(name, _)| *name).collect();
        listed.sort_unstable();
        held.sort_unstable();
        assert_eq!(listed, held);
        for (name, rendered) in RENDERED.iter() {
            assert!(!rendered.title.is_empty() && rendered.body.len() > 200, "{name}: {:?}", rendered.title);
        }
    }

    #[test]
    fn every_link_leads_to_a_page_and_a_heading_of_the_book() {
        let mut followed = 0;
        for (name, rendered) in RENDERED.iter() {
            for link in attributes(&rendered.body, "href").into_iter().chain(attributes(&rendered.body, "src")) {
                let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
                let to = path.strip_prefix("/book/").unwrap_or(if path.is_empty() { name } else { path });
                let there = RENDERED.get(to).map(|page| attributes(&page.body, "id"));
                assert!(there.is_some() || to == FIGURE.0, "{name}: {link}");
                assert!(anchor.is_empty() || there.unwrap().contains(&anchor), "{name}: {link}");
                followed += 1;
            }
        }
        assert!(followed > 80, "{followed}");
    }

    #[test]
    fn nothing_of_a_page_runs_or_is_loaded_from_elsewhere() {
        for (name, rendered) in RENDERED.iter() {
            let body = &rendered.body;
            assert!(!body.contains("<script") && !body.contains("<!--") && !body.contains(" style="), "{name}");
            assert!(
                !body.contains("=\"http:") && !body.contains("=\"https:") && !body.contains("{{#include"),
                "{name}"
            );
        }
        let made = Rendered::of(
            "a",
            "# T\n<script>f()</script>\n\n[x](javascript:f) <b onclick='f()'>b</b> [y](https://e.example/z)",
        );
        assert!(
            !made.body.contains("<script") && !made.body.contains("onclick") && !made.body.contains("=\"javascript")
        );
        assert!(made.body.contains("y (https://e.example/z)"), "{}", made.body);
    }

    #[test]
    fn the_configuration_is_shown_as_the_program_reads_it() {
        let body = &RENDERED["configuration"].body;
        assert!(body.contains("checkpoint_pages = 20000") && body.contains("listen = \"127.0.0.1:8080\""), "{body}");
    }

    #[test]
    fn links_are_read_from_where_they_stand() {
        assert_eq!(address("tutorials/own-csv", "../formats.md#geometry"), "/book/formats#geometry");
        assert_eq!(address("tutorials/own-csv", "first-alert.md"), "/book/tutorials/first-alert");
        assert_eq!(address("method", "#errata"), "#errata");
        let mut anchors = Anchors::default();
        let names = ["To D_I, D_S, D_O", "The fit", "The fit"].map(|heading| anchors.next(heading));
        assert_eq!(names, ["to-d_i-d_s-d_o", "the-fit", "the-fit-1"]);
    }
}
