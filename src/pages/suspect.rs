//! `/stations/{name}/suspect` and `/stations/{name}/trust`: what a station measured in a window of time does not count,
//! and counts again.

use axum::Form;
use axum::extract::{Path, Query, State as Held};
use axum::response::Response;
use maud::html;
use serde::Deserialize;

use super::Pages;
use super::form::{Deed, Word, answered, see_other, typed_time};
use super::layout::{Section, encoded};
use super::viewer::Viewer;
use crate::core::fault::Faults;
use crate::pipeline::SuspectWindow;
use crate::wire::problem::Problem;
use crate::wire::text;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Window {
    #[serde(flatten)]
    word: Word,
    from: String,
    to: String,
}

/// What is done about a window.
#[derive(Clone, Copy)]
enum Doing {
    Suspect,
    Trust,
}

pub(super) async fn ask_suspect(
    pages: Held<Pages>,
    viewer: Viewer,
    name: Path<String>,
    window: Query<Window>,
) -> Response {
    ask(&pages, &viewer, &name, &window, Doing::Suspect).await
}

pub(super) async fn ask_trust(
    pages: Held<Pages>,
    viewer: Viewer,
    name: Path<String>,
    window: Query<Window>,
) -> Response {
    ask(&pages, &viewer, &name, &window, Doing::Trust).await
}

pub(super) async fn suspect(
    Held(pages): Held<Pages>,
    viewer: Viewer,
    Path(name): Path<String>,
    Form(window): Form<Window>,
) -> Response {
    answered(&viewer, done(&pages, &viewer, &name, &window, Doing::Suspect).await)
}

pub(super) async fn trust(
    Held(pages): Held<Pages>,
    viewer: Viewer,
    Path(name): Path<String>,
    Form(window): Form<Window>,
) -> Response {
    answered(&viewer, done(&pages, &viewer, &name, &window, Doing::Trust).await)
}

async fn ask(pages: &Pages, viewer: &Viewer, name: &str, window: &Window, doing: Doing) -> Response {
    let known = known(pages, name).await;
    viewer.show(known.map(|()| form(viewer, name, window, doing).fresh(viewer, &window.word)))
}

async fn known(pages: &Pages, name: &str) -> Result<(), Problem> {
    let is_known = pages.pipeline.queries.is_station(name).await?;
    is_known.then_some(()).ok_or_else(|| Problem::no_such_station(name))
}

async fn done(pages: &Pages, viewer: &Viewer, name: &str, said: &Window, doing: Doing) -> Result<Response, Problem> {
    known(pages, name).await?;
    let mut faults = Faults::default();
    said.word.check(viewer, &mut faults);
    let span = text::span(("from", &typed_time(&said.from)), ("to", &typed_time(&said.to)), &mut faults);
    if !faults.is_empty() {
        return Ok(form(viewer, name, said, doing).again(viewer, &said.word, &faults));
    }
    let Word { by: author, reason, .. } = said.word.clone();
    let window = SuspectWindow { station: name.to_owned(), span, author, reason };
    let outcome = match doing {
        Doing::Suspect => pages.pipeline.suspect(&window).await?,
        Doing::Trust => pages.pipeline.trust(&window).await?,
    };
    match outcome.refused.into_iter().next() {
        Some((_, why)) => Err(why.into()),
        None => Ok(see_other(&format!("/stations/{}", encoded(name)))),
    }
}

fn form(viewer: &Viewer, name: &str, said: &Window, doing: Doing) -> Deed {
    let t = viewer.text();
    let (title, what, path) = match doing {
        Doing::Suspect => (t.suspect_window, t.suspect_what, "suspect"),
        Doing::Trust => (t.trust_window, t.trust_what, "trust"),
    };
    let home = format!("/stations/{}", encoded(name));
    Deed {
        section: Section::Stations,
        title: title.into(),
        what: html! { p.lead { (t.station) " " span translate="no" { (name) } } p { (what) } },
        fields: html! {
            label { (t.window_from) input name="from" value=(said.from) required data-time placeholder="2026-06-01 08:00"; }
            label { (t.window_to) input name="to" value=(said.to) required data-time placeholder="2026-06-08 18:00"; }
        },
        action: format!("{home}/{path}"),
        button: title,
        back: home,
        reasoned: true,
    }
}
